// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "go_icp_branch_and_bound.h"

#include "common/angles.h"
#include "common/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <queue>

namespace pcl_ssfr::baselines {

namespace {

constexpr int kChildren = 8;
constexpr std::uint64_t kUpperNodes = 2000; ///< of a search for a better pose; its answer needs no proof
constexpr int kStartLevel = 2;              ///< ICP starts from every cube of rotations split so often
constexpr double kNoBetter = 1e-3;          ///< of the tolerance: an error that nothing is left to gain from
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

/// What the search over translations is to find.
struct InnerTask {
  double range = 0;       ///< half the edge of the domain
  double prune_above = 0; ///< cubes with this lower bound or more are of no interest
  double stop_below = 0;  ///< an error below this answers the question
  double tolerance = 0;   ///< the bounds need not come closer than this
  double finest = 0;      ///< a cube with half a diagonal below this is not split
  GoIcpProblem::Centre centre = GoIcpProblem::Centre::Likely; ///< what errors at the centres of cubes have to be
  std::uint64_t nodes = 0;                                    ///< at most, about
  Deadline deadline;
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
        (result.nodes / kChildren % kClockEvery == kClockEvery - 1 && task.deadline.hasPassed()))
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
  return nearest.matrix().norm() <= kPi;
}

/// One cube of rotations on its way through the outer search.
struct Trial {
  SearchCube cube;
  InnerResult upper; ///< at the centre of the cube
  InnerResult lower; ///< for all of the cube
};

/// The outer search, over rotations.
class RotationSearch {
public:
  RotationSearch(const GoIcpProblem& problem, const GoIcpLimits& limits, unsigned threads)
      : problem_(problem), limits_(limits),
        workers_(static_cast<int>(std::clamp(threads, 1U, static_cast<unsigned>(kChildren))))
  {
    optimum_.error = std::numeric_limits<double>::infinity();
  }

  GoIcpOptimum
  run(const std::vector<Eigen::Isometry3d>& starts)
  {
    accept(Eigen::Isometry3d::Identity());
    for (const Eigen::Isometry3d& start : starts)
      accept(start);
    startFromEverywhere();
    branch();
    return optimum_;
  }

private:
  /// Take the pose that ICP reaches from \p T when it is better than what is known.
  void
  accept(Eigen::Isometry3d T)
  {
    double error = problem_.icp(T, limits_.icp_iterations, kRoughProgress);
    ++optimum_.icp_runs;
    acceptRough(T, error);
  }

  /// The same for a pose that ICP has roughly reached, with its error.
  void
  acceptRough(Eigen::Isometry3d T, double error)
  {
    if (error < kWorthPolish * optimum_.error)
      error = problem_.icp(T, limits_.icp_iterations, kFineProgress);
    if (error < optimum_.error) {
      optimum_.error = error;
      optimum_.T = T;
    }
  }

  void
  acceptIfBetter(const Eigen::Matrix3d& R, const Eigen::Vector3d& t)
  {
    const Eigen::Isometry3d T = poseOf(R, t);
    if (problem_.error(T) < optimum_.error)
      accept(T);
  }

  static Eigen::Isometry3d
  poseOf(const Eigen::Matrix3d& R, const Eigen::Vector3d& t)
  {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = R;
    T.translation() = t;
    return T;
  }

  /// True when a limit is reached, which is noted.
  bool
  isOver()
  {
    if (limits_.nodes > 0 && optimum_.nodes >= limits_.nodes)
      optimum_.stop = GoIcpOptimum::Stop::NodeLimit;
    else if (limits_.deadline.hasPassed())
      optimum_.stop = GoIcpOptimum::Stop::TimeLimit;
    else
      return false;
    return true;
  }

  /// What both inner searches have in common; together they stay near the limit of nodes.
  InnerTask
  innerTask() const
  {
    InnerTask task;
    task.range = limits_.translation_range;
    task.deadline = limits_.deadline;
    task.nodes = std::numeric_limits<std::uint64_t>::max();
    if (limits_.nodes > 0)
      task.nodes = (limits_.nodes - std::min(limits_.nodes, optimum_.nodes)) / (2 * kChildren) + 1;
    task.tolerance = limits_.tolerance;
    return task;
  }

  /// The search for the best translation at the centre of a cube: its answer needs no proof.
  InnerTask
  upperTask(double prune_above) const
  {
    InnerTask task = innerTask();
    task.nodes = std::min(task.nodes, kUpperNodes);
    task.prune_above = prune_above;
    return task;
  }

  InnerResult
  search(const SearchCube& rotations, bool uncertain, InnerTask task) const
  {
    const GoIcpProblem::RotatedSource rotated = problem_.rotate(rotations, uncertain);
    task.finest = kFinestShare * problem_.uncertainty(rotated);
    return searchTranslations(problem_, rotated, task);
  }

  /** \brief ICP from a coarse grid of all rotations.
   *
   * Not in the paper. The lower the error known is, the more is pruned; and where the tolerance is large against the
   * error of the true pose, the search would stop at the first pose that is good enough.
   */
  void
  startFromEverywhere()
  {
    const int cells = 1 << kStartLevel;
    const double half = kPi / cells;
    std::vector<SearchCube> cubes;
    for (int i = 0; i < cells * cells * cells; ++i) {
      SearchCube cube;
      cube.half = half;
      const Eigen::Array3i cell(i % cells, i / cells % cells, i / cells / cells);
      cube.centre = half * (2 * cell + 1 - cells).cast<double>();
      if (touchesBall(cube))
        cubes.push_back(cube);
    }
    for (std::size_t begin = 0; begin < cubes.size(); begin += kChildren) {
      if (isOver() || optimum_.error <= kNoBetter * limits_.tolerance)
        return;
      const std::size_t count = std::min<std::size_t>(kChildren, cubes.size() - begin);
      const InnerTask task = upperTask(std::numeric_limits<double>::infinity());
      std::array<InnerResult, kChildren> found;
      std::array<Eigen::Isometry3d, kChildren> poses;
      std::array<double, kChildren> errors{};
      forEachInParallel(static_cast<std::int64_t>(count), 1, workers_, [&](std::int64_t k) {
        const auto i = static_cast<std::size_t>(k);
        found[i] = search(cubes[begin + i], false, task);
        poses[i] = poseOf(angleAxisRotation(cubes[begin + i].centre), found[i].translation);
        errors[i] = problem_.icp(poses[i], limits_.icp_iterations, kRoughProgress);
      });
      for (std::size_t i = 0; i < count; ++i) {
        optimum_.nodes += 1 + found[i].nodes;
        ++optimum_.rotations;
        ++optimum_.icp_runs;
        acceptRough(poses[i], errors[i]);
      }
    }
  }

  /// Split the cube with the lowest bound, until no cube promises more than the tolerance.
  void
  branch()
  {
    Queue queue;
    Node root;
    root.cube.half = kPi;
    queue.push(root);
    // Cubes are dropped when their bound is within the tolerance of the best error; the least of these bounds.
    double dropped = std::numeric_limits<double>::infinity();
    std::uint64_t number = 0;
    while (true) {
      const double waiting = queue.empty() ? std::numeric_limits<double>::infinity() : queue.top().lower;
      optimum_.lower = std::min({dropped, waiting, optimum_.error});
      if (queue.empty() || optimum_.error - waiting <= limits_.tolerance) {
        optimum_.stop = GoIcpOptimum::Stop::Certified;
        return;
      }
      if (isOver())
        return;
      const Node node = queue.top();
      queue.pop();
      for (const Trial& trial : judgeChildren(node.cube)) {
        Node child;
        child.cube = trial.cube;
        child.lower = std::max(node.lower, trial.lower.lower);
        child.number = ++number;
        if (child.lower >= optimum_.error - limits_.tolerance)
          dropped = std::min(dropped, child.lower);
        else
          queue.push(child);
      }
    }
  }

  /// Bounds of the eight parts of a cube, and better poses in them, which are accepted.
  std::vector<Trial>
  judgeChildren(const SearchCube& parent)
  {
    std::vector<Trial> trials;
    for (int c = 0; c < kChildren; ++c) {
      Trial trial;
      trial.cube = childOf(parent, c);
      if (touchesBall(trial.cube))
        trials.push_back(trial);
    }
    // All children are judged by the error known before, whichever thread is first.
    const InnerTask upper_task = upperTask(optimum_.error);
    InnerTask lower_task = innerTask();
    lower_task.prune_above = optimum_.error - limits_.tolerance;
    lower_task.stop_below = lower_task.prune_above; // then the cube has to be split, however low its bound is
    lower_task.tolerance = kInnerTolerance * limits_.tolerance;
    lower_task.centre = GoIcpProblem::Centre::AtMost;
    forEachInParallel(static_cast<std::int64_t>(2 * trials.size()), 1, workers_, [&](std::int64_t k) {
      const auto i = static_cast<std::size_t>(k);
      Trial& trial = trials[i / 2];
      if (i % 2 == 0)
        trial.upper = search(trial.cube, false, upper_task);
      else
        trial.lower = search(trial.cube, true, lower_task);
    });
    for (const Trial& trial : trials) {
      ++optimum_.rotations;
      optimum_.nodes += 1 + trial.upper.nodes + trial.lower.nodes;
      const Eigen::Matrix3d R = angleAxisRotation(trial.cube.centre);
      if (trial.upper.best < optimum_.error)
        acceptIfBetter(R, trial.upper.translation);
      // The nearer the cube is to a point, the nearer is this pose to what its bound promises.
      if (trial.lower.best < lower_task.stop_below)
        acceptIfBetter(R, trial.lower.translation);
    }
    return trials;
  }

  const GoIcpProblem& problem_;
  const GoIcpLimits& limits_;
  int workers_ = 1;
  GoIcpOptimum optimum_;
};

} // namespace

GoIcpOptimum
branchAndBound(const GoIcpProblem& problem,
               const std::vector<Eigen::Isometry3d>& starts,
               const GoIcpLimits& limits,
               unsigned threads)
{
  return RotationSearch(problem, limits, threads).run(starts);
}

} // namespace pcl_ssfr::baselines
