// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "pose_matchers.h"
#include "profiles/paper_profile.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ssfr::test_paper_profile {
namespace {

using testing::IsPoseNear;

constexpr double kDegree = 3.14159265358979323846 / 180;

ScanView
viewOf(const Eigen::Matrix3Xf& points, const Eigen::Vector3d& viewpoint = Eigen::Vector3d::Zero())
{
  ScanView view = testing::viewOfPoints(points);
  view.viewpoint = viewpoint;
  return view;
}

struct ScanPair {
  Eigen::Matrix3Xf source, target;
  Eigen::Isometry3d T_target_source;
};

/// \p step between two rays [rad]
ScanPair
makeRoomPair(double step)
{
  const testing::Scene room = testing::makeFurnishedRoom(1);
  testing::Random random(2);
  Eigen::Isometry3d source_pose = testing::sensorPose(room.stations[1], 0);
  source_pose.linear() = testing::randomRotation(random);
  const Eigen::Isometry3d target_pose = testing::sensorPose(room.stations[0], 0.4);
  // A full sphere of directions: what a rotated sensor sees does not depend on how it is rotated.
  testing::SensorPattern pattern = testing::roomScanner(step);
  pattern.elevation_min = -90 * kDegree;
  pattern.elevation_max = 90 * kDegree;
  ScanPair pair;
  pair.source = testing::castScan(room, source_pose, pattern, 3);
  pair.target = testing::castScan(room, target_pose, pattern, 4);
  pair.T_target_source = testing::relativePose(target_pose, source_pose);
  return pair;
}

/// Two scans of one furnished room, the source rotated freely.
const ScanPair&
roomPair()
{
  static const ScanPair pair = makeRoomPair(0.01745);
  return pair;
}

Options
paperOptions()
{
  Options options = makeOptions(Profile::Paper2017);
  options.threads = 2;
  return options;
}

Result
run(const ScanPair& pair, const Options& options, const Eigen::Isometry3d* guess = nullptr)
{
  return registerPaperScans(preparePaperScan(viewOf(pair.source), options),
                            preparePaperScan(viewOf(pair.target), options),
                            options,
                            guess,
                            Deadline::after(options.time_limit));
}

/// The scans of roomPair(), prepared with paperOptions().
const PaperScan&
roomSource()
{
  static const PaperScan scan = preparePaperScan(viewOf(roomPair().source), paperOptions());
  return scan;
}

const PaperScan&
roomTarget()
{
  static const PaperScan scan = preparePaperScan(viewOf(roomPair().target), paperOptions());
  return scan;
}

/// Registers them; \p options differ from paperOptions() in nothing that the preparation reads.
Result
runRoom(const Options& options, const Eigen::Isometry3d* guess = nullptr)
{
  return registerPaperScans(roomSource(), roomTarget(), options, guess, Deadline::after(options.time_limit));
}

const Result&
roomResult()
{
  static const Result result = runRoom(paperOptions());
  return result;
}

TEST(PaperProfile, AlignsTwoScansOfARoom)
{
  const Result& result = roomResult();
  ASSERT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(roomPair().T_target_source, 2 * kDegree, 0.1));
  EXPECT_GT(result.overlap, 0.5);
  EXPECT_EQ(result.confidence, 0); // the paper estimates none
  EXPECT_TRUE(result.unobservable.empty());
  EXPECT_TRUE(result.source_viewpoint_used && result.target_viewpoint_used);
  EXPECT_FALSE(result.message.empty());
}

TEST(PaperProfile, ListsDistinctCandidatesBestFirst)
{
  Options options = paperOptions();
  options.max_candidates = 5;
  const std::vector<Candidate> candidates = runRoom(options).candidates;
  ASSERT_EQ(candidates.size(), 5U);
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (std::size_t j = i + 1; j < candidates.size(); ++j) {
      EXPECT_GE(candidates[i].score, candidates[j].score);
      // The origin of the source lies near its centre here, so that the translations can be compared.
      const testing::PoseError apart = testing::poseError(candidates[i].T_target_source, candidates[j].T_target_source);
      EXPECT_TRUE(apart.rotation > 4.9 * kDegree || apart.translation > 0.3);
    }
  options.max_candidates = 1;
  const Result best = runRoom(options);
  ASSERT_EQ(best.candidates.size(), 1U);
  EXPECT_EQ(best.candidates[0].T_target_source.matrix(), candidates[0].T_target_source.matrix());
}

TEST(PaperProfile, ReportsEveryStage)
{
  const Result& result = roomResult();
  std::vector<std::string> names;
  for (const StageReport& stage : result.stages) {
    names.push_back(stage.name);
    EXPECT_GE(stage.seconds, 0) << stage.name;
  }
  std::vector<std::string> expected;
  for (const char* scan : {"source_", "target_"})
    for (const char* stage : {"normals", "gaussian_sphere", "density", "densest_regions", "mean_shift", "lcp_thinning"})
      expected.push_back(std::string(scan) + stage);
  for (const char* stage : {"rotation_candidates", "translation", "lcp", "fine_pass", "selection"})
    expected.emplace_back(stage);
  EXPECT_EQ(names, expected);
  EXPECT_EQ(result.stages.front().count_in, static_cast<std::uint64_t>(roomPair().source.cols()));
  EXPECT_LE(result.stages[4].count_out, 6U); // main normals
}

TEST(PaperProfile, SameBitsForAnyNumberOfThreads)
{
  const Result& two = roomResult();
  ASSERT_EQ(paperOptions().threads, 2U);
  for (const unsigned threads : {1U, 1U, 8U, 0U}) {
    Options options = paperOptions();
    options.threads = threads;
    const Result other = run(roomPair(), options);
    EXPECT_EQ(two.T_target_source.matrix(), other.T_target_source.matrix()) << threads;
    EXPECT_EQ(two.overlap, other.overlap);
    EXPECT_EQ(two.rmse, other.rmse);
    ASSERT_EQ(two.candidates.size(), other.candidates.size());
    for (std::size_t i = 0; i < two.candidates.size(); ++i)
      EXPECT_EQ(two.candidates[i].T_target_source.matrix(), other.candidates[i].T_target_source.matrix());
  }
}

TEST(PaperProfile, WorksFarFromTheOrigin)
{
  // UTM coordinates: the target lies 100 km away, where a float keeps 8 mm.
  const Eigen::Vector3d far(98304, -40960, 512);
  ScanPair moved = roomPair();
  moved.target.colwise() += far.cast<float>();
  moved.T_target_source.translation() += far;
  const Options options = paperOptions();
  const Result result = registerPaperScans(roomSource(), preparePaperScan(viewOf(moved.target, far), options), options);
  ASSERT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(moved.T_target_source, 2 * kDegree, 0.15));
}

TEST(PaperProfile, FinePassSharpensTheTranslation)
{
  // Three exact walls and a fine sampling: the coarse shift is off by up to half a bin (7 mm), the fine one is not.
  Eigen::Matrix3Xf points(3, 3 * 6400);
  Eigen::Index column = 0;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 6400; ++i, ++column) {
      const int row = i / 80;
      Eigen::Vector3f point(0.05F * static_cast<float>(i % 80) - 1.9F, 0.05F * static_cast<float>(row) - 1.7F, 0);
      point[2] = 2.2F + 0.11F * static_cast<float>(axis);
      points(axis, column) = point[2];
      points((axis + 1) % 3, column) = point[0];
      points((axis + 2) % 3, column) = point[1];
    }
  ScanPair pair;
  pair.target = points;
  pair.T_target_source = Eigen::Isometry3d::Identity();
  pair.T_target_source.translation() << 0.0637, -0.0512, 0.0391;
  // The source lacks a strip of each wall: centred, the two are no longer the same numbers.
  Eigen::Matrix3Xf part(3, 3 * 5610);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    part.middleCols(axis * 5610, 5610) = points.middleCols(axis * 6400 + 790, 5610);
  pair.source = testing::transformed(pair.T_target_source.inverse(), part);
  Options options = paperOptions();
  options.normal_radius = 0.15;
  options.paper.lcp.leaf = 0.2;
  options.paper.translation.histogram.bin_width = 0.05;
  options.gravity.emplace(); // rules out the turns of the corner about its diagonal
  const Result fine = run(pair, options);
  options.paper.lcp.fine_factor = 0;
  const Result coarse = run(pair, options);
  ASSERT_EQ(fine.status, Status::Converged) << fine.message;
  const double fine_error = testing::poseError(fine.T_target_source, pair.T_target_source).translation;
  const double coarse_error = testing::poseError(coarse.T_target_source, pair.T_target_source).translation;
  EXPECT_LT(fine_error, 0.003);
  EXPECT_GT(coarse_error, 0.005);
}

TEST(PaperProfile, GuessIsOneMoreCandidate)
{
  const Options options = paperOptions();
  const Result& plain = roomResult();
  // A wild guess changes nothing but the number of poses considered.
  testing::Random random(9);
  const Eigen::Isometry3d wild = testing::randomMotion(random, 3);
  EXPECT_EQ(runRoom(options, &wild).T_target_source.matrix(), plain.T_target_source.matrix());
  // The truth as a guess must not make it worse.
  const Result guided = runRoom(options, &roomPair().T_target_source);
  EXPECT_GE(guided.overlap, plain.overlap);
  EXPECT_THAT(guided.T_target_source, IsPoseNear(roomPair().T_target_source, 2 * kDegree, 0.1));
}

TEST(PaperProfile, GravityFiltersTheRotations)
{
  Options options = paperOptions();
  options.gravity.emplace();
  options.gravity->up_target = Eigen::Vector3d::UnitZ(); // the target's sensor stands upright
  options.gravity->up_source = roomPair().T_target_source.linear().transpose() * Eigen::Vector3d::UnitZ();
  const Result upright = runRoom(options);
  EXPECT_THAT(upright.T_target_source, IsPoseNear(roomPair().T_target_source, 2 * kDegree, 0.1));
  for (const Candidate& candidate : upright.candidates) {
    const Eigen::Vector3d up = candidate.T_target_source.linear() * options.gravity->up_source;
    EXPECT_GT(up.z(), std::cos(options.gravity->tolerance) - 1e-9);
  }
  options.gravity->up_target = Eigen::Vector3d(1, 1, 0.3).normalized(); // no rotation of the room does this
  EXPECT_EQ(runRoom(options).status, Status::NoCandidate);
}

TEST(PaperProfile, SaysWhyThereIsNoAnswer)
{
  const Options options = paperOptions();
  const PaperScan& good = roomTarget();

  const PaperScan empty = preparePaperScan(ScanView(), options);
  Result result = registerPaperScans(empty, good, options);
  EXPECT_EQ(result.status, Status::TooFewPoints);
  EXPECT_NE(result.message.find("source"), std::string::npos) << result.message;
  result = registerPaperScans(good, empty, options);
  EXPECT_EQ(result.status, Status::TooFewPoints);
  EXPECT_NE(result.message.find("target"), std::string::npos) << result.message;
  EXPECT_TRUE(result.T_target_source.isApprox(Eigen::Isometry3d::Identity()));

  const Eigen::Matrix3Xf plane = testing::castScan(testing::makeSinglePlane(),
                                                   testing::sensorPose(testing::makeSinglePlane().stations.at(0), 0),
                                                   testing::roomScanner(),
                                                   5);
  const PaperScan floor = preparePaperScan(viewOf(plane), options);
  EXPECT_EQ(registerPaperScans(floor, good, options).status, Status::TooFewDirections);
  EXPECT_EQ(registerPaperScans(good, floor, options).status, Status::TooFewDirections);

  const Eigen::Matrix3Xf nan = Eigen::Matrix3Xf::Constant(3, 50, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(registerPaperScans(preparePaperScan(viewOf(nan), options), good, options).status, Status::TooFewPoints);
}

TEST(PaperProfile, TimeLimitIsHonouredBetweenCandidates)
{
  Options options = paperOptions();
  options.time_limit = 1e-9;
  const Result result = runRoom(options);
  EXPECT_EQ(result.status, Status::TimeLimit);
  EXPECT_TRUE(result.candidates.empty());
}

TEST(PaperProfile, UnknownViewpointGivesUnsignedNormals)
{
  const ScanPair& pair = roomPair();
  Options options = paperOptions();
  for (const ViewpointMode mode : {ViewpointMode::Auto, ViewpointMode::SensorOrigin, ViewpointMode::Unused}) {
    options.viewpoint_mode = mode;
    EXPECT_EQ(preparePaperScan(viewOf(pair.source), options).normals.samples.oriented, mode != ViewpointMode::Unused);
  }
  options.viewpoint_mode = ViewpointMode::Auto;
  ScanView moved = viewOf(pair.source);
  moved.viewpoint = {0.1, 0.2, 0.3};
  const Result seen =
      registerPaperScans(preparePaperScan(moved, options), preparePaperScan(viewOf(pair.target), options), options);
  EXPECT_TRUE(seen.source_viewpoint_used);
  EXPECT_EQ(seen.source_viewpoint, moved.viewpoint);
  EXPECT_EQ(seen.target_viewpoint, Eigen::Vector3d::Zero());
  options.viewpoint_mode = ViewpointMode::Unknown;
  const PaperScan scan = preparePaperScan(viewOf(pair.source), options);
  EXPECT_FALSE(scan.normals.samples.oriented);
  const Result result = registerPaperScans(scan, preparePaperScan(viewOf(pair.target), options), options);
  EXPECT_FALSE(result.source_viewpoint_used || result.target_viewpoint_used);
  EXPECT_EQ(result.source_viewpoint, Eigen::Vector3d::Zero());
  EXPECT_EQ(result.status, Status::Converged);
}

TEST(PaperProfile, ConstantsOf2019WorkToo)
{
  const ScanPair pair = makeRoomPair(0.0349); // of finer scans these constants keep many times more samples
  Options options = makePaper2019Options();
  options.threads = 2;
  options.normal_radius = 0.15;
  const Result result = run(pair, options);
  ASSERT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 2 * kDegree, 0.1));
}

/// Two scans of a street from a vehicle, one after the other.
ScanPair
makeStreetPair()
{
  const testing::Scene street = testing::makeStreet(1);
  const Eigen::Isometry3d target_pose = testing::sensorPose(street.stations[0], 0);
  const Eigen::Isometry3d source_pose = testing::sensorPose(street.stations[0] + Eigen::Vector3d(2, 0.3, 0), 0.4);
  testing::SensorPattern pattern = testing::vehicleScanner();
  pattern.azimuth_step = 0.2 * kDegree; // the rings are 1.3 degrees apart
  ScanPair pair;
  pair.source = testing::castScan(street, source_pose, pattern, 3);
  pair.target = testing::castScan(street, target_pose, pattern, 4);
  pair.T_target_source = testing::relativePose(target_pose, source_pose);
  return pair;
}

TEST(PaperProfile, RadiusReachesTheNextRingOfASpinningSensor)
{
  // Points lie densely along a ring, and the next ring is far: ten spacings of nearest neighbours see one line only.
  const ScanPair pair = makeStreetPair();
  const Options options = paperOptions();
  const PaperScan scan = preparePaperScan(viewOf(pair.target), options);
  const double by_spacing = std::max(10 * scan.normals.resolution, 0.1);
  EXPECT_GT(scan.normals.radius, 1.2 * by_spacing);
  EXPECT_LE(scan.normals.radius, 0.9);
  EXPECT_GE(scan.main_normals.size(), 3U);
  const Result result = registerPaperScans(preparePaperScan(viewOf(pair.source), options), scan, options);
  ASSERT_EQ(result.status, Status::Converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(pair.T_target_source, 2 * kDegree, 0.3));

  // What it was before leaves more surface without a normal, or with one of the ring instead.
  Options narrow = options;
  narrow.normal_radius = by_spacing;
  EXPECT_GT(result.overlap, run(pair, narrow).overlap);

  // Where points lie alike in all directions of a surface, their spacing alone decides.
  const PaperScan& room = roomTarget();
  EXPECT_NEAR(room.normals.radius, std::clamp(10 * room.normals.resolution, 0.1, 0.9), 1e-12);

  // It is a length: a scan half as large has half the radius, to a step of the search, as far as the bounds let it.
  const Eigen::Matrix3Xf half = 0.5F * pair.target;
  const Eigen::Matrix3Xf quarter = 0.25F * pair.target;
  EXPECT_NEAR(preparePaperScan(viewOf(quarter), options).normals.radius,
              0.5 * preparePaperScan(viewOf(half), options).normals.radius,
              0.08);
}

TEST(PaperProfile, RefusesBadOptions)
{
  Options options = paperOptions();
  options.normal_radius = -1;
  EXPECT_THROW(preparePaperScan(ScanView(), options), std::invalid_argument);
  EXPECT_THROW(registerPaperScans(PaperScan(), PaperScan(), options), std::invalid_argument);
}

} // namespace
} // namespace pcl_ssfr::test_paper_profile
