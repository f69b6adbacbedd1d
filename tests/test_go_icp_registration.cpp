// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Go-ICP as a pcl::Registration; what it computes is tested in test_go_icp.cpp.

#include "synthetic_scene.h"

#include <pcl_ssfr/baselines/go_icp.h>

#include <pcl/console/print.h>
#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

namespace pcl_ssfr::baselines::test_go_icp_registration {
namespace {

using ::testing::HasSubstr;
using testing::Random;

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
randomCloud(int count, std::uint64_t seed)
{
  Random random(seed);
  auto cloud = pcl::make_shared<pcl::PointCloud<PointT>>();
  for (int i = 0; i < count; ++i) {
    PointT point;
    point.x = static_cast<float>(random.uniform(-4, 4));
    point.y = static_cast<float>(random.uniform(-3, 3));
    point.z = static_cast<float>(random.uniform(-1, 1));
    cloud->push_back(point);
  }
  return cloud;
}

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
movedCloud(const pcl::PointCloud<PointT>& cloud, const Eigen::Isometry3d& T)
{
  auto result = pcl::make_shared<pcl::PointCloud<PointT>>(cloud);
  for (PointT& point : *result)
    point.getVector3fMap() = (T * point.getVector3fMap().template cast<double>()).template cast<float>();
  return result;
}

template <typename PointT, typename ScalarT>
struct Types {
  using Point = PointT;
  using Scalar = ScalarT;
};

template <typename T>
class GoIcpRegistration : public ::testing::Test {};

using AllTypes = ::testing::Types<Types<pcl::PointXYZ, float>,
                                  Types<pcl::PointXYZ, double>,
                                  Types<pcl::PointXYZI, float>,
                                  Types<pcl::PointNormal, float>,
                                  Types<pcl::PointXYZINormal, double>>;
TYPED_TEST_SUITE(GoIcpRegistration, AllTypes);

TYPED_TEST(GoIcpRegistration, AlignsThroughTheBaseOfPcl)
{
  using Point = typename TypeParam::Point;
  using Method = GoIcp<Point, Point, typename TypeParam::Scalar>;
  Random random(3);
  const Eigen::Isometry3d truth = testing::randomMotion(random, 20);
  const auto target = randomCloud<Point>(200, 1);
  const auto source = movedCloud(*target, truth.inverse());

  auto method = pcl::make_shared<Method>();
  method->setDistanceTransformSize(80);
  method->setNumberOfThreads(1);
  typename Method::Base::Base::Ptr registration = method;
  registration->setInputSource(source);
  registration->setInputTarget(target);
  pcl::PointCloud<Point> output;
  registration->align(output);
  ASSERT_TRUE(registration->hasConverged()) << method->getMessage();
  EXPECT_TRUE(registration->getFinalTransformation().template cast<double>().isApprox(truth.matrix(), 1e-3));
  ASSERT_EQ(output.size(), target->size());
  for (std::size_t i = 0; i < output.size(); ++i)
    EXPECT_LT((output[i].getVector3fMap() - (*target)[i].getVector3fMap()).norm(), 1e-2F);
  EXPECT_LT(registration->getFitnessScore(), 1e-4);
  EXPECT_TRUE(method->getReport().certified);
  EXPECT_LE(method->getReport().gap, method->getReport().tolerance);
  EXPECT_GT(method->getReport().seconds, 0);
  EXPECT_EQ(method->getCorrespondences()->size(), output.size());
}

TEST(GoIcpRegistrationSettings, ReachTheSearch)
{
  GoIcp<pcl::PointXYZ, pcl::PointXYZ> method;
  EXPECT_EQ(method.getOptions().icp_iterations, 0);
  EXPECT_EQ(method.getOptions().inlier_distance, 0);
  EXPECT_EQ(method.getOptions().time_limit_clock, TimeLimitClock::Wall);
  method.setSourcePoints(77);
  method.setTrimFraction(0.25);
  method.setMseThreshold(0.02);
  method.setTranslationRange(0.75);
  method.setDistanceTransformSize(90);
  method.setNodeLimit(1234);
  method.setTimeLimit(2.5, TimeLimitClock::Processor);
  method.setMaximumIterations(7);
  method.setMaxCorrespondenceDistance(0.3);
  method.setNumberOfThreads(3);
  const GoIcpOptions options = method.getOptions();
  EXPECT_EQ(options.source_points, 77);
  EXPECT_EQ(options.trim_fraction, 0.25);
  EXPECT_EQ(options.mse_threshold, 0.02);
  EXPECT_EQ(options.translation_range, 0.75);
  EXPECT_EQ(options.transform_size, 90);
  EXPECT_EQ(options.node_limit, 1234U);
  EXPECT_EQ(options.time_limit, 2.5);
  EXPECT_EQ(options.time_limit_clock, TimeLimitClock::Processor);
  EXPECT_EQ(options.icp_iterations, 7);
  EXPECT_EQ(options.inlier_distance, 0.3);
  EXPECT_EQ(options.threads, 3U);
}

TEST(GoIcpRegistrationFailure, CutOffMeansNotConvergedAndTheGuess)
{
  const auto source = randomCloud<pcl::PointXYZ>(300, 1);
  const auto target = randomCloud<pcl::PointXYZ>(100, 2);
  GoIcp<pcl::PointXYZ, pcl::PointXYZ> method;
  method.setDistanceTransformSize(50);
  method.setMseThreshold(1e-6);
  method.setNodeLimit(5000);
  method.setInputSource(source);
  method.setInputTarget(target);
  Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  guess(0, 3) = 0.5F;
  pcl::PointCloud<pcl::PointXYZ> output;
  method.align(output, guess);
  EXPECT_FALSE(method.hasConverged());
  EXPECT_EQ(method.getFinalTransformation(), guess);
  EXPECT_EQ(output.size(), source->size());
  EXPECT_THAT(method.getMessage(), HasSubstr("cut off by the limit of 5000 nodes"));
  EXPECT_FALSE(method.getReport().certified);
  EXPECT_GT(method.getReport().gap, method.getReport().tolerance);
  EXPECT_GT(method.getResult().iterations, 0);
}

TEST(GoIcpRegistrationFailure, BadCloudsAndOptionsDoNotCrash)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto good = randomCloud<pcl::PointXYZ>(50, 1);
  auto nan = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>(*good);
  for (pcl::PointXYZ& point : *nan)
    point.y = kNan;
  auto tiny = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  tiny->push_back((*good)[0]);
  pcl::PointCloud<pcl::PointXYZ> output;
  for (const auto& bad : {nan, tiny}) {
    for (const bool is_source : {true, false}) {
      GoIcp<pcl::PointXYZ, pcl::PointXYZ> method;
      method.setInputSource(is_source ? bad : good);
      method.setInputTarget(is_source ? good : bad);
      method.align(output);
      EXPECT_FALSE(method.hasConverged());
      EXPECT_THAT(method.getMessage(), HasSubstr(is_source ? "source" : "target"));
    }
  }
  GoIcp<pcl::PointXYZ, pcl::PointXYZ> method;
  method.setInputSource(good);
  method.setInputTarget(good);
  method.setTrimFraction(1.5);
  method.align(output);
  EXPECT_FALSE(method.hasConverged());
  EXPECT_THAT(method.getMessage(), HasSubstr("trim_fraction = 1.5"));
  method.setTrimFraction(0);
  method.align(output);
  EXPECT_TRUE(method.hasConverged());

  // An index list is all that counts.
  auto indices = pcl::make_shared<pcl::Indices>(20);
  std::iota(indices->begin(), indices->end(), 5);
  method.setIndices(indices);
  method.align(output);
  EXPECT_TRUE(method.hasConverged());
  EXPECT_EQ(output.size(), 20U);
  EXPECT_EQ(method.getResult().source_points, 20U);
  method.setIndices(pcl::make_shared<pcl::Indices>());
  method.align(output);
  EXPECT_FALSE(method.hasConverged());
  EXPECT_TRUE(output.empty());
}

} // namespace
} // namespace pcl_ssfr::baselines::test_go_icp_registration
