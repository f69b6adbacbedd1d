// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "go_icp_branch_and_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <queue>

namespace pcl_ssfr::baselines {

namespace {

constexpr int kChildren = 8;
constexpr std::uint64_t kUpperNodes = 2000; ///< of a search for a better pose; its answer needs no proof
constexpr int kAlwaysPolish = 3;            ///< ICP starts from every cube split so often or less
constexpr double kRoughProgress = 1e-2;     ///< ICP ends with a step that lowers the error by less than this share
constexpr double kFineProgress = 1e-9;      ///< the same, where it ended
constexpr double kWorthPolish = 1.2;        ///< below so many times the best error
constexpr double kInnerTolerance = 0.25;    ///< of the tolerance: to what the inner search knows a lower bound
constexpr double kFinestShare = 0.5;      ///< translations need not be finer than this share of what else is uncertain
constexpr std::uint64_t kClockEvery = 16; ///< cubes of translations between two looks at the clock

/// A cube that waits to be split.
struct Node {
  SearchCube cube;
  double lower = 0; ///< of the error in it
  std::uint64_t number = 0;
};

/// The lowest bound first; then the largest cube, then the oldest.
struct ComesLater {
  bool
  operator()(const Node& a, const Node& b) const
  {
    if (a.lower < b.lower || b.lower < a.lower)
      return a.lower > b.lower;
    if (a.cube.half < b.cube.half || b.cube.half < a.cube.half)
      return a.cube.half < b.cube.half;
    return a.number > b.number;
  }
};

using Queue = std::priority_queue<Node, std::vector<Node>, ComesLater>;

bool
isPast(const std::optional<std::chrono::steady_clock::time_point>& deadline)
{
  return deadline && std::chrono::steady_clock::now() >= *deadline;
}

/// What the search over translations is to find.
struct InnerTask {
  double range = 0;       ///< half the edge of the domain
  double prune_above = 0; ///< cubes with this lower bound or more are of no interest
  double stop_below = 0;  ///< an error below this answers the question
  double tolerance = 0;   ///< the bounds need not come closer than this
  double finest = 0;      ///< a cube with half a diagonal below this is not split
  GoIcpProblem::Centre centre = GoIcpProblem::Centre::Likely; ///< what errors at the centres of cubes have to be
  std::uint64_t nodes = 0;                                    ///< at most, about
  std::optional<std::chrono::steady_clock::time_point> deadline;
};

struct InnerResult {
  double lower = 0; ///< of the error over all translations, at most InnerTask::prune_above
  double best = std::numeric_limits<double>::infinity(); ///< least error at the centre of a cube, estimated
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(); ///< where that is
  std::uint64_t nodes = 0;
};

/// Algorithm 2 of the paper: bounds of the error over all translations, for the rotations of \p source.
InnerResult
searchTranslations(const GoIcpProblem& problem, const GoIcpProblem::RotatedSource& source, const InnerTask& task)
{
  GoIcpProblem::Scratch scratch;
  InnerResult result;
  Queue queue;
  Node root;
  root.cube.half = task.range;
  queue.push(root);
  while (true) {
    if (queue.empty()) {
      result.lower = task.prune_above;
      return result;
    }
    const Node node = queue.top();
    result.lower = std::min(node.lower, task.prune_above);
    if (node.lower >= task.prune_above || result.best < task.stop_below || result.best - node.lower <= task.tolerance ||
        std::sqrt(3.0) * node.cube.half < task.finest || result.nodes >= task.nodes ||
        (result.nodes / kChildren % kClockEvery == kClockEvery - 1 && isPast(task.deadline)))
      return result;
    queue.pop();
    for (int c = 0; c < kChildren; ++c) {
      Node child;
      child.cube = childOf(node.cube, c);
      child.number = ++result.nodes;
      GoIcpProblem::Bounds bounds = problem.bounds(source, child.cube, task.centre, task.prune_above, scratch);
      child.lower = std::max(bounds.lower, node.lower);
      if (child.lower >= task.prune_above)
        continue;
      if (task.centre == GoIcpProblem::Centre::AtMost && problem.isFine(source, child.cube)) {
        bounds = problem.exactBounds(source, child.cube, task.prune_above, scratch);
        child.lower = std::max(bounds.lower, child.lower);
        if (child.lower >= task.prune_above)
          continue;
      }
      if (bounds.centre < result.best) {
        result.best = bounds.centre;
        result.translation = child.cube.centre;
      }
      queue.push(child);
    }
  }
}

/// True when the cube of angle-axis vectors has a part in the ball of radius pi.
bool
touchesBall(const SearchCube& cube)
{
  const Eigen::Array3d nearest = (cube.centre.array().abs() - cube.half).max(0.0);
  return nearest.matrix().norm() <= M_PI;
}

/// One cube of rotations on its way through the outer search.
struct Trial {
  SearchCube cube;
  InnerResult upper; ///< at the centre of the cube
  InnerResult lower; ///< for all of the cube
};

} // namespace

GoIcpOptimum
branchAndBound(const GoIcpProblem& problem,
               const std::vector<Eigen::Isometry3d>& starts,
               const GoIcpLimits& limits,
               unsigned threads)
{
  GoIcpOptimum optimum;
  optimum.error = std::numeric_limits<double>::infinity();
  const auto polish = [&](Eigen::Isometry3d T) {
    double error = problem.icp(T, limits.icp_iterations, kRoughProgress);
    ++optimum.icp_runs;
    if (error < kWorthPolish * optimum.error)
      error = problem.icp(T, limits.icp_iterations, kFineProgress);
    if (error < optimum.error) {
      optimum.error = error;
      optimum.T = T;
    }
  };
  const auto tryPose = [&](const Eigen::Matrix3d& R, const Eigen::Vector3d& t, bool is_worth_it) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = R;
    T.translation() = t;
    if (is_worth_it || problem.error(T) < optimum.error)
      polish(T);
  };
  polish(Eigen::Isometry3d::Identity());
  for (const Eigen::Isometry3d& start : starts)
    polish(start);

  Queue queue;
  Node root;
  root.cube.half = M_PI;
  queue.push(root);
  // Cubes are dropped when their bound is within the tolerance of the best error; the least of these bounds.
  double dropped = std::numeric_limits<double>::infinity();
  const auto workers = static_cast<int>(std::clamp(threads, 1U, static_cast<unsigned>(kChildren)));
  std::uint64_t number = 0;
  while (true) {
    const double waiting = queue.empty() ? std::numeric_limits<double>::infinity() : queue.top().lower;
    optimum.lower = std::min({dropped, waiting, optimum.error});
    if (queue.empty() || optimum.error - waiting <= limits.tolerance) {
      optimum.stop = GoIcpOptimum::Stop::Certified;
      return optimum;
    }
    if (limits.nodes > 0 && optimum.nodes >= limits.nodes) {
      optimum.stop = GoIcpOptimum::Stop::NodeLimit;
      return optimum;
    }
    if (isPast(limits.deadline)) {
      optimum.stop = GoIcpOptimum::Stop::TimeLimit;
      return optimum;
    }

    const Node node = queue.top();
    queue.pop();
    std::vector<Trial> trials;
    for (int c = 0; c < kChildren; ++c) {
      Trial trial;
      trial.cube = childOf(node.cube, c);
      if (touchesBall(trial.cube))
        trials.push_back(trial);
    }

    // Poses from everywhere first, whatever their error is: a low error prunes most of what follows.
    const bool is_coarse = node.cube.half > M_PI * std::pow(0.5, kAlwaysPolish - 0.5);

    // All children are judged by the error known before, whichever thread is first.
    InnerTask task;
    task.range = limits.translation_range;
    task.deadline = limits.deadline;
    task.nodes = limits.nodes > 0 ? (limits.nodes - optimum.nodes) / (2 * kChildren) + 1
                                  : std::numeric_limits<std::uint64_t>::max();
    InnerTask upper_task = task;
    upper_task.nodes = std::min(task.nodes, kUpperNodes);
    upper_task.prune_above = is_coarse ? std::numeric_limits<double>::infinity() : optimum.error;
    upper_task.stop_below = 0;
    upper_task.tolerance = limits.tolerance;
    InnerTask lower_task = task;
    lower_task.prune_above = optimum.error - limits.tolerance;
    lower_task.stop_below = lower_task.prune_above; // then the cube has to be split, however low its bound is
    lower_task.tolerance = kInnerTolerance * limits.tolerance;
    lower_task.centre = GoIcpProblem::Centre::AtMost;
    const auto count = static_cast<std::ptrdiff_t>(trials.size());
    std::exception_ptr failure; // out of memory
#pragma omp parallel for num_threads(workers) schedule(dynamic, 1) if (workers > 1)
    for (std::ptrdiff_t i = 0; i < 2 * count; ++i) {
      Trial& trial = trials[static_cast<std::size_t>(i / 2)];
      try {
        const bool is_lower = i % 2 == 1;
        const GoIcpProblem::RotatedSource rotated = problem.rotate(trial.cube, is_lower);
        InnerTask own_task = is_lower ? lower_task : upper_task;
        own_task.finest = kFinestShare * problem.uncertainty(rotated);
        (is_lower ? trial.lower : trial.upper) = searchTranslations(problem, rotated, own_task);
      }
      catch (...) {
#pragma omp critical(pcl_ssfr_go_icp_failure)
        failure = std::current_exception();
      }
    }
    if (failure)
      std::rethrow_exception(failure);

    for (const Trial& trial : trials) {
      ++optimum.rotations;
      optimum.nodes += 1 + trial.upper.nodes + trial.lower.nodes;
      const Eigen::Matrix3d R = angleAxisRotation(trial.cube.centre);
      if (is_coarse || trial.upper.best < optimum.error)
        tryPose(R, trial.upper.translation, is_coarse);
      // The nearer the cube is to a point, the nearer is this pose to what its bound promises.
      if (trial.lower.best < lower_task.stop_below)
        tryPose(R, trial.lower.translation, false);
    }
    for (const Trial& trial : trials) {
      Node child;
      child.cube = trial.cube;
      child.lower = std::max(node.lower, trial.lower.lower);
      child.number = ++number;
      if (child.lower >= optimum.error - limits.tolerance)
        dropped = std::min(dropped, child.lower);
      else
        queue.push(child);
    }
  }
}

} // namespace pcl_ssfr::baselines
