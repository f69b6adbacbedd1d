// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// SSFR as the initial guess of PCL's ICP, GICP and NDT: on pairs where each of them alone fails from identity.

#include "pose_matchers.h"
#include "real_scans.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/structured_scene_registration.h>

#include <pcl/common/transforms.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_initial_guess {
namespace {

using pcl_ssfr::testing::findPair;
using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::Random;
using pcl_ssfr::testing::randomRotation;
using pcl_ssfr::testing::realScansFolder;
using ::testing::Not;

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Registration = pcl::Registration<Point, Point>;

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr double kMaxRotation = 2 * kDegree; ///< success, as everywhere in this project
constexpr double kMaxTranslation = 0.3;      ///< [m]
constexpr float kLeaf = 0.3F;                ///< the local methods get clouds thinned to this [m]

constexpr double kWideReach = 1.0; ///< correspondences of ICP and GICP alone, for the best chance [m]

struct Case {
  std::string real_set; ///< folder of real scans; empty: the simulated ones in data/
  std::string source;
  std::string target;
  std::uint64_t seed; ///< of the rotation that the source is rotated by about its sensor
};

std::ostream&
operator<<(std::ostream& stream, const Case& pair)
{
  return stream << pair.real_set << ": " << pair.source << " -> " << pair.target;
}

Cloud::Ptr
thinned(const Cloud::ConstPtr& cloud)
{
  auto result = pcl::make_shared<Cloud>();
  pcl::VoxelGrid<Point> grid;
  grid.setInputCloud(cloud);
  grid.setLeafSize(kLeaf, kLeaf, kLeaf);
  grid.filter(*result);
  return result;
}

std::vector<std::pair<std::string, Registration::Ptr>>
localMethods()
{
  const auto icp = pcl::make_shared<pcl::IterativeClosestPoint<Point, Point>>();
  icp->setMaximumIterations(50);
  const auto gicp = pcl::make_shared<pcl::GeneralizedIterativeClosestPoint<Point, Point>>();
  gicp->setMaximumIterations(30);
  const auto ndt = pcl::make_shared<pcl::NormalDistributionsTransform<Point, Point>>();
  ndt->setResolution(1.0F);
  ndt->setStepSize(0.1);
  ndt->setTransformationEpsilon(0.01);
  ndt->setMaximumIterations(35);
  return {{"ICP", icp}, {"GICP", gicp}, {"NDT", ndt}};
}

class InitialGuess : public ::testing::TestWithParam<Case> {};

TEST_P(InitialGuess, TurnsFailureIntoSuccess)
{
  const bool simulated = GetParam().real_set.empty();
  if (!simulated && realScansFolder().empty())
    GTEST_SKIP() << pcl_ssfr::testing::kNoRealScans;
  const io::DatasetFolder dataset =
      io::readDatasetFolder(simulated ? PCL_SSFR_DATA_DIR : (realScansFolder() / GetParam().real_set).string());
  const io::ScanPair pair = findPair(dataset, GetParam().source, GetParam().target);
  const Cloud::Ptr whole_source = pcl_ssfr::testing::loadPoints(io::scanPath(dataset.path, pair.source));
  const Cloud::Ptr whole_target = pcl_ssfr::testing::loadPoints(io::scanPath(dataset.path, pair.target));
  Random random(GetParam().seed);
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() = randomRotation(random);
  pcl::transformPointCloud(*whole_source, *whole_source, Eigen::Matrix4d(turn.matrix()));
  const Eigen::Isometry3d truth = pair.T_target_source * turn.inverse();

  StructuredSceneRegistration<Point, Point> ssfr;
  ssfr.setInputSource(whole_source);
  ssfr.setInputTarget(whole_target);
  Cloud moved;
  ssfr.align(moved);
  ASSERT_TRUE(ssfr.hasConverged()) << ssfr.getResult().message;
  ASSERT_THAT(ssfr.getFinalTransformation(), IsPoseNear(truth, kMaxRotation, kMaxTranslation));

  EXPECT_GT(ssfr.getCorrespondenceDistance(), 0);
  EXPECT_EQ(ssfr.getCorrespondenceDistance(), ssfr.getResult().correspondence_distance);
  const double reach = std::hypot(ssfr.getCorrespondenceDistance(), static_cast<double>(kLeaf));
  EXPECT_LT(reach, 0.4);
  const std::optional<Candidate> ours = ssfr.scorePose(ssfr.getFinalTransformation());
  ASSERT_TRUE(ours);
  EXPECT_NEAR(ours->score, ssfr.getResult().candidates.front().score, 1e-3);

  const Cloud::Ptr source = thinned(whole_source);
  const Cloud::Ptr target = thinned(whole_target);
  for (const auto& [name, method] : localMethods()) {
    method->setInputSource(source);
    method->setInputTarget(target);
    method->setMaxCorrespondenceDistance(kWideReach);
    method->align(moved);
    EXPECT_THAT(method->getFinalTransformation(), Not(IsPoseNear(truth, kMaxRotation, kMaxTranslation)))
        << name << " alone: the pair shows nothing";
    const std::optional<Candidate> alone = ssfr.scorePose(method->getFinalTransformation());
    ASSERT_TRUE(alone);
    EXPECT_FALSE(isNoWorse(*alone, *ours)) << name << " alone";
    method->setMaxCorrespondenceDistance(reach);
    method->align(moved, ssfr.getFinalTransformation());
    EXPECT_TRUE(method->hasConverged()) << name << " with SSFR's guess";
    EXPECT_THAT(method->getFinalTransformation(), IsPoseNear(truth, kMaxRotation, kMaxTranslation))
        << name << " with SSFR's guess";
  }
}

TEST(InitialGuessApi, ScoresNothingWithoutCloudsOrARigidMotion)
{
  StructuredSceneRegistration<Point, Point> ssfr;
  EXPECT_EQ(ssfr.getCorrespondenceDistance(), 0);
  const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
  EXPECT_FALSE(ssfr.scorePose(identity));
  const auto cloud = pcl::make_shared<Cloud>();
  for (int i = 0; i < 100; ++i)
    cloud->push_back(Point(static_cast<float>(i % 10), static_cast<float>(i / 10), 0));
  ssfr.setInputSource(cloud);
  EXPECT_FALSE(ssfr.scorePose(identity));
  ssfr.setInputTarget(cloud);
  EXPECT_TRUE(ssfr.scorePose(identity)); // no align() before
  Eigen::Matrix4f wrong = identity;
  wrong(0, 3) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(ssfr.scorePose(wrong));
  EXPECT_FALSE(ssfr.scorePose(2 * identity));
}

std::string
nameOf(const ::testing::TestParamInfo<Case>& info)
{
  std::string name = (info.param.real_set.empty() ? "data" : info.param.real_set) + "_" + info.param.source;
  for (char& letter : name) {
    letter = std::isalnum(static_cast<unsigned char>(letter)) != 0 ? letter : '_';
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(SimulatedScans,
                         InitialGuess,
                         ::testing::Values(Case{"", "apartment_1.pcd", "apartment_0.pcd", 1}),
                         nameOf);

INSTANTIATE_TEST_SUITE_P(RealScans,
                         InitialGuess,
                         ::testing::Values(Case{"room_pair_pcl", "room_scan2.pcd", "room_scan1.pcd", 1},
                                           Case{"apartment_pair", "cloud_1.pcd", "cloud_0.pcd", 1},
                                           Case{"parking_tls", "scan01.pcd", "scan00.pcd", 1}),
                         nameOf);

} // namespace
} // namespace pcl_ssfr::test_initial_guess
