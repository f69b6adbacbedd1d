// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The core of examples/ros2: bytes of messages, covariances in the order of ROS, frames, and a registration.

#include "pose_matchers.h"

#include <pcl_ssfr_ros2/cloud_message.h>
#include <pcl_ssfr_ros2/scan_matcher.h>

#include <Eigen/Eigenvalues>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ssfr_ros2 {
namespace {

using pcl_ssfr::testing::poseError;
using ::testing::HasSubstr;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A message and the bytes that it borrows.
struct OwnedMessage {
  CloudMessage message;
  std::vector<std::uint8_t> bytes;
};

/// How a driver may lay out its points.
struct Layout {
  std::uint8_t datatype = kFloat32;
  bool is_bigendian = false;
  std::uint32_t x = 0, y = 4, z = 8;
  std::uint32_t point_step = 12;
  std::uint32_t padding = 0; ///< bytes after each row
  std::uint32_t height = 1;
};

template <typename Number>
void
put(std::vector<std::uint8_t>& bytes, std::size_t at, double value, bool is_bigendian)
{
  const auto number = static_cast<Number>(value);
  std::vector<std::uint8_t> raw(sizeof(Number));
  std::memcpy(raw.data(), &number, sizeof(Number));
  if (is_bigendian) // the tests run on little-endian machines
    std::reverse(raw.begin(), raw.end());
  std::copy(raw.begin(), raw.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

OwnedMessage
makeMessage(const Cloud& cloud, const Layout& layout)
{
  OwnedMessage owned;
  CloudMessage& message = owned.message;
  message.height = layout.height;
  message.width = static_cast<std::uint32_t>(cloud.size()) / layout.height;
  message.fields = {{"intensity", 0, kFloat32, 1},
                    {"z", layout.z, layout.datatype, 1},
                    {"x", layout.x, layout.datatype, 1},
                    {"y", layout.y, layout.datatype, 1}};
  message.is_bigendian = layout.is_bigendian;
  message.point_step = layout.point_step;
  message.row_step = message.width * layout.point_step + layout.padding;
  owned.bytes.assign(std::size_t(message.row_step) * message.height, 0xAB);
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const std::size_t at = std::size_t(i / message.width) * message.row_step + i % message.width * layout.point_step;
    const std::uint32_t offsets[] = {layout.x, layout.y, layout.z};
    for (int k = 0; k < 3; ++k) {
      if (layout.datatype == kFloat64)
        put<double>(owned.bytes, at + offsets[k], cloud[i].data[k], layout.is_bigendian);
      else
        put<float>(owned.bytes, at + offsets[k], cloud[i].data[k], layout.is_bigendian);
    }
  }
  message.data = owned.bytes.data();
  message.size = owned.bytes.size();
  return owned;
}

Cloud
somePoints()
{
  Cloud cloud;
  for (int i = 0; i < 12; ++i)
    cloud.push_back(pcl::PointXYZ(1 + static_cast<float>(i), -2.5F * static_cast<float>(i), 1e-3F));
  return cloud;
}

void
expectSamePoints(const Cloud& actual, const Cloud& expected)
{
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i)
    EXPECT_EQ(actual[i].getVector3fMap(), expected[i].getVector3fMap()) << "point " << i;
}

TEST(CloudMessage, AnyLayoutGivesTheSamePoints)
{
  Layout floats;
  Layout scattered;
  scattered.x = 20;
  scattered.y = 5; // not aligned
  scattered.z = 11;
  scattered.point_step = 31;
  Layout big = scattered;
  big.is_bigendian = true;
  Layout doubles;
  doubles.datatype = kFloat64;
  doubles.x = 16;
  doubles.y = 0;
  doubles.z = 8;
  doubles.point_step = 26;
  Layout big_doubles = doubles;
  big_doubles.is_bigendian = true;
  for (const Layout& layout : {floats, scattered, big, doubles, big_doubles})
    for (const std::uint32_t height : {1U, 3U}) {
      Layout rows = layout;
      rows.height = height;
      rows.padding = height > 1 ? 7 : 0;
      expectSamePoints(*readCloud(makeMessage(somePoints(), rows).message, 0), somePoints());
    }
}

TEST(CloudMessage, LostReturnsAreLeftOut)
{
  Cloud cloud;
  cloud.push_back(pcl::PointXYZ(kNan, 1, 1));
  cloud.push_back(pcl::PointXYZ(1, 1, std::numeric_limits<float>::infinity()));
  cloud.push_back(pcl::PointXYZ(0, 0, 0));
  cloud.push_back(pcl::PointXYZ(0.05F, 0, 0.02F));
  cloud.push_back(pcl::PointXYZ(3, 4, 5));
  const OwnedMessage owned = makeMessage(cloud, Layout());
  EXPECT_EQ(readCloud(owned.message, 0)->size(), 2U); // never the origin itself
  const Cloud::Ptr kept = readCloud(owned.message, 0.1);
  ASSERT_EQ(kept->size(), 1U);
  EXPECT_EQ(kept->front().z, 5);
  EXPECT_TRUE(kept->is_dense);
}

TEST(CloudMessage, EmptyIsEmpty)
{
  for (const std::uint32_t height : {0U, 1U, 5U}) {
    OwnedMessage owned = makeMessage(somePoints(), Layout());
    owned.message.height = height;
    owned.message.width = height == 0 ? 12 : 0;
    owned.message.data = nullptr;
    owned.message.size = 0;
    EXPECT_TRUE(readCloud(owned.message, 0.1)->empty());
  }
}

TEST(CloudMessage, WhatIsWrongIsNamed)
{
  const auto errorOf = [](const std::function<void(CloudMessage&)>& change, double least_range = 0) {
    OwnedMessage owned = makeMessage(somePoints(), Layout());
    change(owned.message);
    try {
      readCloud(owned.message, least_range);
    }
    catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(errorOf([](CloudMessage& m) { m.fields.pop_back(); }), HasSubstr("no field y"));
  EXPECT_THAT(errorOf([](CloudMessage& m) { m.fields[2].datatype = 5; }), HasSubstr("field x has datatype 5"));
  EXPECT_THAT(errorOf([](CloudMessage& m) { m.fields[1].offset = 9; }), HasSubstr("field z at offset 9"));
  EXPECT_THAT(errorOf([](CloudMessage& m) { m.fields[1].offset = 0xFFFFFFFFU; }), HasSubstr("field z at offset"));
  EXPECT_THAT(errorOf([](CloudMessage& m) { --m.size; }), HasSubstr("data has 143 bytes, 144 are needed"));
  EXPECT_THAT(errorOf([](CloudMessage& m) { m.height = m.width = 0xFFFFFFFFU; }), HasSubstr("row_step 144 is less"));
  EXPECT_THAT(errorOf([](CloudMessage& m) { m.height = 2; }), HasSubstr("data has 144 bytes, 288 are needed"));
  EXPECT_THAT(errorOf([](CloudMessage&) {}, -1), HasSubstr("least_range"));
  EXPECT_EQ(errorOf([](CloudMessage&) {}), "no error");
}

Matrix6
someInformation(std::uint64_t seed)
{
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> gaussian;
  Matrix6 root;
  for (double& value : root.reshaped())
    value = gaussian(engine);
  Matrix6 information = root * root.transpose() + Matrix6::Identity();
  Eigen::Matrix<double, 6, 1> scale;
  scale << 2000, 3000, 1500, 400, 250, 300; // 1 / rad, 1 / m
  return scale.asDiagonal() * information * scale.asDiagonal();
}

/// The covariance of the message is that of the errors of poses that are drawn as Result::information says.
TEST(Covariance, SampledPosesScatterAsItSays)
{
  std::mt19937_64 engine(11);
  std::normal_distribution<double> gaussian;
  Eigen::Isometry3d T = Eigen::Translation3d(4, -7, 2) * Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -1).normalized());
  const Matrix6 information = someInformation(5);
  const Matrix6 root = information.inverse().llt().matrixL();
  Matrix6 scatter = Matrix6::Zero();
  constexpr int kSamples = 40000;
  for (int i = 0; i < kSamples; ++i) {
    Eigen::Matrix<double, 6, 1> normal;
    for (double& value : normal)
      value = gaussian(engine);
    const Eigen::Matrix<double, 6, 1> motion = root * normal;
    const Eigen::Vector3d w = motion.head<3>();
    const Eigen::Isometry3d truth =
        Eigen::Translation3d(motion.tail<3>()) * Eigen::AngleAxisd(w.norm(), w.normalized()) * T;
    const Eigen::AngleAxisd rotation(Eigen::Matrix3d(truth.linear() * T.linear().transpose()));
    Eigen::Matrix<double, 6, 1> error;
    error << truth.translation() - T.translation(), rotation.angle() * rotation.axis();
    scatter += error * error.transpose() / kSamples;
  }
  const Matrix6 expected = covarianceInRosOrder(information, T);
  const Eigen::Matrix<double, 6, 1> deviations = expected.diagonal().cwiseSqrt();
  const Matrix6 difference =
      deviations.cwiseInverse().asDiagonal() * (scatter - expected) * deviations.cwiseInverse().asDiagonal();
  // Of a correlation, 40,000 samples leave 0.005 to 0.007.
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.03) << scatter << "\n\n" << expected;
  // The lever is large: without it the test would fail.
  const Matrix6 without = covarianceInRosOrder(information, Eigen::Isometry3d::Identity());
  EXPECT_GT((without - expected).topRows(3).norm(), 0.5 * expected.topRows(3).norm());
}

TEST(Covariance, ByHandAtTheOrigin)
{
  Matrix6 information = Matrix6::Zero();
  information.diagonal() << 1e4, 4e4, 1e6, 100, 400, 2500;
  const Matrix6 covariance = covarianceInRosOrder(information, Eigen::Isometry3d::Identity());
  Eigen::Matrix<double, 6, 1> expected;
  expected << 0.01, 0.0025, 0.0004, 1e-4, 2.5e-5, 1e-6; // translations first
  EXPECT_LT((covariance.diagonal() - expected).cwiseQuotient(expected).cwiseAbs().maxCoeff(), 1e-4);
  const std::array<double, 36> row_major = toRowMajor(someInformation(3));
  EXPECT_EQ(row_major[6 * 1 + 4], someInformation(3)(1, 4));
}

TEST(Covariance, OpenDirectionsAreWideNotInfinite)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 3, 0, 0;
  Matrix6 information = 1e4 * Matrix6::Identity();
  information(3, 3) = 0; // a corridor along x
  const Matrix6 corridor = covarianceInRosOrder(information, T);
  EXPECT_NEAR(std::sqrt(corridor(0, 0)), kUnknownTranslation, 1);
  EXPECT_LT(std::sqrt(corridor(1, 1)), 0.05);
  const Matrix6 nothing = covarianceInRosOrder(Matrix6::Zero(), T);
  EXPECT_TRUE(nothing.allFinite());
  EXPECT_NEAR(std::sqrt(nothing(5, 5)), kUnknownRotation, 1e-6);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(nothing).eigenvalues().minCoeff(), 0);
}

TEST(Frames, TheChainThroughTheAnchorGivesThePose)
{
  const Eigen::Isometry3d T_map_lidar =
      Eigen::Translation3d(10, 2, 0.5) * Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ());
  const Eigen::Isometry3d T_odom_lidar =
      Eigen::Translation3d(-3, 4, 0.4) * Eigen::AngleAxisd(-2, Eigen::Vector3d(0, 0.1, 1).normalized());
  const Eigen::Isometry3d T_map_odom = anchored(T_map_lidar, T_odom_lidar);
  EXPECT_TRUE((T_map_odom * T_odom_lidar).isApprox(T_map_lidar, 1e-12));
}

/// A pair of data/, as messages: the pose of the README, and a covariance that its error agrees with.
TEST(ScanMatcher, RegistersMessagesOntoAMap)
{
  const std::string folder = PCL_SSFR_DATA_DIR;
  const Cloud::Ptr map = readMap(folder + "/apartment_0.pcd");
  const Cloud::Ptr scan = readMap(folder + "/apartment_1.pcd");
  Layout layout;
  layout.datatype = kFloat64;
  layout.x = 8;
  layout.y = 16;
  layout.z = 24;
  layout.point_step = 32;
  layout.is_bigendian = true;

  ScanMatcher matcher((MatcherConfig()));
  EXPECT_FALSE(matcher.hasTarget());
  EXPECT_EQ(matcher.match(*scan).message, "no target yet");
  matcher.setTarget(*map);
  EXPECT_TRUE(matcher.hasTarget());
  const Match match = matcher.match(*readCloud(makeMessage(*scan, layout).message, 0.1));
  ASSERT_TRUE(match.accepted) << match.message;
  EXPECT_GT(match.confidence, 0.9);

  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity(); // data/pairs.csv
  truth.linear() << -0.5, -0.836516304, 0.224143868, 0.866025404, -0.482962913, 0.129409523, 0, 0.258819045,
      0.965925826;
  truth.translation() << 1.818358989, -0.929881718, -0.1;
  EXPECT_LT(poseError(match.T_target_source, truth).rotation, 0.2 * kDegree);
  EXPECT_LT(poseError(match.T_target_source, truth).translation, 0.02);

  Eigen::Matrix<double, 6, 1> error;
  const Eigen::AngleAxisd rotation(Eigen::Matrix3d(truth.linear() * match.T_target_source.linear().transpose()));
  error << truth.translation() - match.T_target_source.translation(), rotation.angle() * rotation.axis();
  const double distance = error.dot(match.covariance.ldlt().solve(error)); // chi-square, 6 degrees of freedom
  EXPECT_LT(distance, 33) << "beyond 1 in 100,000";
  EXPECT_LT(match.covariance.diagonal().head<3>().cwiseSqrt().maxCoeff(), 0.05);
  EXPECT_LT(match.covariance.diagonal().tail<3>().cwiseSqrt().maxCoeff(), 1 * kDegree);
}

TEST(ScanMatcher, CloudsThatSayNothingAreNotAccepted)
{
  ScanMatcher matcher((MatcherConfig()));
  matcher.setTarget(Cloud());
  const Match match = matcher.match(Cloud());
  EXPECT_FALSE(match.accepted);
  EXPECT_FALSE(match.message.empty());
  EXPECT_TRUE(match.covariance.allFinite());
}

TEST(ScanMatcher, SettingsOutOfRangeAreNamed)
{
  const auto errorOf = [](const MatcherConfig& config) {
    try {
      ScanMatcher matcher(config);
    }
    catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  MatcherConfig config;
  EXPECT_EQ(errorOf(config), "no error");
  config.min_confidence = 1.5;
  EXPECT_THAT(errorOf(config), HasSubstr("min_confidence"));
  config = MatcherConfig();
  config.gravity_tolerance = -0.1;
  EXPECT_THAT(errorOf(config), HasSubstr("gravity_tolerance"));
  config.gravity_tolerance = 0.05;
  EXPECT_EQ(errorOf(config), "no error");
  config.time_limit = -1;
  EXPECT_THAT(errorOf(config), HasSubstr("time_limit"));
}

TEST(Map, FilesThatAreNoMapAreNamed)
{
  const std::string no_cloud = ::testing::TempDir() + "no_map.pcd";
  std::ofstream(no_cloud) << "nothing\n";
  const std::string no_mesh = ::testing::TempDir() + "no_map.ply";
  std::ofstream(no_mesh) << "nothing\n";
  const std::string empty = ::testing::TempDir() + "empty_map.pcd";
  std::ofstream(empty)
      << "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n";
  for (const std::string& path : {std::string("/no/such/map.ply"), std::string("map.xyz"), no_cloud, no_mesh, empty}) {
    try {
      readMap(path);
      FAIL() << path;
    }
    catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(path));
    }
  }
}

} // namespace
} // namespace pcl_ssfr_ros2
