// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/angles.h"
#include "pose_matchers.h"
#include "scan_views.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/common/random_stream.h>
#include <apps/simulation/dataset_simulation.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scan_simulation.h>

#include <cstddef>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

// Scans made on the fly by the simulator, with exact truth, for tests of whole registrations.
namespace pcl_ssfr::testing {

constexpr double kSolvedRotation = 2 * kDegree; ///< a pose is right within this [rad] ...
constexpr double kSolvedTranslation = 0.3;      ///< ... and this [m]

/// The frames that scans are given in.
enum class Frames {
  Sensors, ///< those of the sensors
  Rotated, ///< each rotated at random about its sensor: neither the motion nor the vertical can be guessed
  Level    ///< each rotated at random about the vertical only
};

/// A scan and where it was taken.
struct PosedScan {
  Eigen::Matrix3Xf points; ///< 3 x N [m]
  Eigen::Isometry3d T_world_scan = Eigen::Isometry3d::Identity();
};

/// A plan of some scans of one scene; the sensor as it is or with about \p beams beams (0: as it is).
inline simulation::DatasetPlan
planScans(const std::string& scene, const std::string& sensor, int scans, std::size_t beams, std::uint64_t seed)
{
  simulation::DatasetPlan plan;
  plan.scene = scene;
  plan.sensor = sensor;
  plan.trajectory.scans = scans;
  plan.beams = beams;
  plan.seed = seed;
  return plan;
}

/// Take the scans of a plan; what moves does so between any two of them. \p numbers: which of them; empty: all
inline std::vector<PosedScan>
takeScans(const simulation::DatasetPlan& plan, Frames frames = Frames::Rotated, std::vector<std::size_t> numbers = {})
{
  constexpr unsigned kThreads = 2;
  constexpr std::uint64_t kFrameSeed = 77;
  const simulation::PreparedPlan prepared = simulation::prepare(plan, kThreads);
  std::vector<Eigen::Vector3d> sensors;
  for (const Eigen::Isometry3d& T : prepared.T_world_sensor)
    sensors.emplace_back(T.translation());
  const bool moves = plan.movables.people > 0 || plan.movables.doors_move || plan.movables.moved_furniture > 0;
  std::unique_ptr<simulation::RayCaster> caster;
  if (numbers.empty()) {
    numbers.resize(sensors.size());
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  }
  std::vector<PosedScan> scans;
  for (const std::size_t i : numbers) {
    const Eigen::Isometry3d& T_world_sensor = prepared.T_world_sensor.at(i);
    if (moves || !caster)
      caster = std::make_unique<simulation::RayCaster>(
          simulation::surfacesAt(prepared.scene, plan.movables, plan.seed, i, sensors));
    simulation::ScanOptions options;
    options.seed = plan.seed;
    options.scan = i;
    options.noise = plan.noise;
    options.threads = kThreads;
    const std::vector<Eigen::Vector3f> points =
        simulateScan(*caster, prepared.sensorOf(i), T_world_sensor, options).points;
    RandomStream random(kFrameSeed, i, plan.seed);
    Eigen::Isometry3d T_scan_sensor = Eigen::Isometry3d::Identity();
    if (frames == Frames::Rotated)
      T_scan_sensor.linear() = random.rotation();
    else if (frames == Frames::Level)
      T_scan_sensor.linear() =
          Eigen::AngleAxisd(random.uniform(-3.14, 3.14), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    PosedScan scan;
    if (!points.empty())
      scan.points =
          T_scan_sensor.linear().cast<float>() *
          Eigen::Map<const Eigen::Matrix3Xf>(points.front().data(), 3, static_cast<Eigen::Index>(points.size()));
    scan.T_world_scan = T_world_sensor * T_scan_sensor.inverse();
    scans.push_back(std::move(scan));
  }
  return scans;
}

/// Every k-th point, as a sensor of k times lower resolution sees.
inline PosedScan
thinnedScan(const PosedScan& scan, Eigen::Index k)
{
  PosedScan thin;
  thin.T_world_scan = scan.T_world_scan;
  thin.points.resize(3, (scan.points.cols() + k - 1) / k);
  for (Eigen::Index i = 0; i < thin.points.cols(); ++i)
    thin.points.col(i) = scan.points.col(i * k);
  return thin;
}

/// The pose that maps points of \p source into \p target.
inline Eigen::Isometry3d
truePose(const PosedScan& source, const PosedScan& target)
{
  return target.T_world_scan.inverse() * source.T_world_scan;
}

/// Whether a pose is right for the scans.
inline bool
isSolved(const Eigen::Isometry3d& T_target_source, const PosedScan& source, const PosedScan& target)
{
  const PoseError error = poseError(T_target_source, truePose(source, target));
  return error.rotation < kSolvedRotation && error.translation < kSolvedTranslation;
}

/// What became of a pair of scans.
struct PairOutcome {
  Result result;
  bool right = false; ///< the best pose is within \ref kSolvedRotation and \ref kSolvedTranslation, accepted or not

  /// The pose is right, or it was not accepted.
  bool
  honest() const
  {
    return right || !result.accepted();
  }
};

/// Options that all tests of whole registrations use.
inline Options
defaultOptions()
{
  Options options = makeOptions(Profile::Default);
  options.threads = 2;
  return options;
}

/// Register a pair of scans.
inline PairOutcome
registerPosedScans(const PosedScan& source,
                   const PosedScan& target,
                   const Options& options = defaultOptions(),
                   const Eigen::Isometry3d* guess = nullptr)
{
  const auto [s, t] = prepareScans(viewOfPoints(source.points), viewOfPoints(target.points), options);
  PairOutcome outcome;
  outcome.result = registerScans(s, t, options, guess);
  outcome.right = isSolved(outcome.result.T_target_source, source, target);
  return outcome;
}

/// No two candidates are one pose. \p what: for messages
inline void
expectDistinctCandidates(const Result& result, const std::string& what)
{
  for (std::size_t i = 0; i < result.candidates.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Eigen::Isometry3d& one = result.candidates[i].T_target_source;
      const Eigen::Isometry3d& other = result.candidates[k].T_target_source;
      const double apart = (one * result.source_viewpoint - other * result.source_viewpoint).norm();
      EXPECT_TRUE(apart > 0.29 || poseError(one, other).rotation > 0.049) << what << ": " << i << " is " << k;
    }
}

/// Status, message, and score, overlap and contradiction of the candidates, for the messages of tests.
inline std::string
describe(const Result& result)
{
  std::string text = std::string(toString(result.status)) + ", confidence " + std::to_string(result.confidence) + ": " +
                     result.message;
  for (const Candidate& c : result.candidates)
    text +=
        " [" + std::to_string(c.score) + " " + std::to_string(c.overlap) + " " + std::to_string(c.contradiction) + "]";
  return text;
}

} // namespace pcl_ssfr::testing
