// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The default profile on simulated scans with exact truth: the reduced sets of the paper, every source in a randomly
// rotated frame, and the scenes that are made to mislead.

#include "pose_matchers.h"
#include "scan_views.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/common/random_stream.h>
#include <apps/simulation/paper_sets.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scan_simulation.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace pcl_ssfr::test_simulated_sets {
namespace {

using simulation::DatasetPlan;

constexpr double kDegree = 3.14159265358979323846 / 180;

/// The scans of a plan and where they were taken.
struct Scans {
  std::vector<Eigen::Matrix3Xf> points;
  std::vector<Eigen::Isometry3d> T_world_scan;
};

Scans
simulate(const DatasetPlan& plan)
{
  const simulation::PreparedPlan prepared = simulation::prepare(plan, 2);
  const simulation::RayCaster caster(simulation::surfacesAt(prepared.scene, {}, plan.seed, 0));
  Scans scans;
  for (std::size_t i = 0; i < prepared.T_world_sensor.size(); ++i) {
    simulation::ScanOptions options;
    options.seed = plan.seed;
    options.scan = i;
    options.noise = plan.noise;
    options.threads = 2;
    const std::vector<Eigen::Vector3f> points =
        simulateScan(caster, prepared.sensorOf(i), prepared.T_world_sensor[i], options).points;
    // Every scan in a frame of its own: neither the motion nor the vertical can be guessed.
    Eigen::Isometry3d T_scan_sensor = Eigen::Isometry3d::Identity();
    T_scan_sensor.linear() = RandomStream(77, i).rotation();
    scans.points.emplace_back(
        T_scan_sensor.linear().cast<float>() *
        Eigen::Map<const Eigen::Matrix3Xf>(points.front().data(), 3, static_cast<Eigen::Index>(points.size())));
    scans.T_world_scan.push_back(prepared.T_world_sensor[i] * T_scan_sensor.inverse());
  }
  return scans;
}

/// What became of a pair of scans.
struct Outcome {
  Result result;
  bool right = false; ///< within 2 degrees and 0.3 m
};

Outcome
registerPair(const Scans& scans, std::size_t source, std::size_t target)
{
  Options options = makeOptions(Profile::Default);
  options.threads = 2;
  const auto [s, t] = prepareScans(pcl_ssfr::testing::viewOfPoints(scans.points[source]),
                                   pcl_ssfr::testing::viewOfPoints(scans.points[target]),
                                   options);
  Outcome outcome;
  outcome.result = registerScans(s, t, options);
  const pcl_ssfr::testing::PoseError error = pcl_ssfr::testing::poseError(
      outcome.result.T_target_source, scans.T_world_scan[target].inverse() * scans.T_world_scan[source]);
  outcome.right = error.rotation < 2 * kDegree && error.translation < 0.3;
  return outcome;
}

/// Score, overlap and contradiction of the candidates, for messages.
std::string
summary(const Result& result)
{
  std::string text;
  for (const Candidate& c : result.candidates)
    text +=
        " [" + std::to_string(c.score) + " " + std::to_string(c.overlap) + " " + std::to_string(c.contradiction) + "]";
  return text;
}

DatasetPlan
planOf(const std::string& scene, const std::string& sensor, int scans, std::size_t beams)
{
  DatasetPlan plan;
  plan.scene = scene;
  plan.sensor = sensor;
  plan.beams = beams;
  plan.trajectory.scans = scans;
  plan.seed = 3;
  return plan;
}

class PaperSets : public ::testing::TestWithParam<const char*> {};

TEST_P(PaperSets, EveryPairIsSolvedAndBelieved)
{
  const Scans scans = simulate(simulation::makePaperSet(GetParam(), true).plan);
  ASSERT_GE(scans.points.size(), 3u);
  for (std::size_t i = 1; i < scans.points.size(); ++i) {
    const Outcome outcome = registerPair(scans, i, i - 1);
    EXPECT_TRUE(outcome.right) << "scan " << i << " onto " << i - 1 << ": " << outcome.result.message;
    // The corridor of ds4s repeats itself: a right pose may be called ambiguous.
    EXPECT_TRUE(outcome.result.accepted() ||
                (std::string(GetParam()) == "ds4s" && outcome.result.status == Status::Ambiguous))
        << "scan " << i << " onto " << i - 1 << ": " << outcome.result.message << summary(outcome.result);
  }
}

INSTANTIATE_TEST_SUITE_P(Reduced, PaperSets, ::testing::Values("basic_model", "ds1h", "ds2l", "ds3v", "ds4s"));

class TrapScenes : public ::testing::TestWithParam<const char*> {};

TEST_P(TrapScenes, NoConfidentWrongPose)
{
  const Scans scans = simulate(planOf(GetParam(), "leica_p20", 4, 40000));
  for (std::size_t target = 0; target < scans.points.size(); ++target)
    for (std::size_t source = target + 1; source < scans.points.size(); ++source) {
      const Outcome outcome = registerPair(scans, source, target);
      EXPECT_TRUE(outcome.right || !outcome.result.accepted())
          << source << " onto " << target << ": confidence " << outcome.result.confidence << summary(outcome.result);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    TrapScenes,
    ::testing::Values("endless_corridor", "symmetric_room", "cylinder_hall", "slanted", "cave", "two_floors_alike"));

TEST(CorridorSet, SaysThatTheWayAlongItIsUnobservable)
{
  const Scans scans = simulate(planOf("endless_corridor", "leica_p20", 2, 40000));
  const Result result = registerPair(scans, 1, 0).result;
  EXPECT_EQ(result.status, Status::Unobservable) << result.message;
  ASSERT_FALSE(result.unobservable.empty());
  EXPECT_FALSE(result.unobservable.front().rotation);
  const Eigen::Vector3d along = scans.T_world_scan[0].linear().transpose() * Eigen::Vector3d::UnitX();
  EXPECT_GT(std::abs(result.unobservable.front().direction.dot(along)), std::cos(2 * kDegree));
}

TEST(Storeys, OneLaidOnTheOtherIsNeverBelievedFarApart)
{
  // The first and the last scan of a walk through both storeys see the same rooms one storey apart.
  const Scans scans = simulate(planOf("two_floors_alike", "velodyne_vlp16", 12, 30000));
  for (std::size_t source = 6; source < scans.points.size(); source += 2) {
    const Outcome outcome = registerPair(scans, source, 0);
    EXPECT_TRUE(outcome.right || !outcome.result.accepted())
        << source << " onto 0: confidence " << outcome.result.confidence << ", " << outcome.result.message;
  }
}

} // namespace
} // namespace pcl_ssfr::test_simulated_sets
