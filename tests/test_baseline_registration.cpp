// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// What the comparison methods promise as pcl::Registration, whatever they compute.

#include "pcl_clouds.h"
#include "pose_matchers.h"

#include <pcl_ssfr/baselines/fast_global_registration.h>
#include <pcl_ssfr/baselines/go_icp.h>
#include <pcl_ssfr/baselines/super4pcs.h>

#include <pcl/console/print.h>

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace pcl_ssfr::baselines::test_baseline_registration {
namespace {

using pcl_ssfr::testing::castScanWithNormals;
using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::makeFurnishedRoom;
using pcl_ssfr::testing::relativePose;
using pcl_ssfr::testing::roomScanner;
using pcl_ssfr::testing::ScanPair;
using pcl_ssfr::testing::ScanWithNormals;
using pcl_ssfr::testing::Scene;
using pcl_ssfr::testing::sensorPose;
using pcl_ssfr::testing::toCloud;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Two coarse scans from nearly the same place, rotated by a radian.
struct CoarseScans {
  ScanWithNormals source, target;
  Eigen::Isometry3d T_target_source;
};

/// Cast once for all tests.
const CoarseScans&
coarseScans()
{
  static const CoarseScans scans = [] {
    constexpr double kStep = 0.045; // 2.6 degrees
    const Scene scene = makeFurnishedRoom(1);
    const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
    const Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(0) + Eigen::Vector3d(0.2, 0.1, 0), 1.1);
    return CoarseScans{castScanWithNormals(scene, T_world_source, roomScanner(kStep), 12),
                       castScanWithNormals(scene, T_world_target, roomScanner(kStep), 11),
                       relativePose(T_world_target, T_world_source)};
  }();
  return scans;
}

/// Clouds of these scans that a test may change.
template <typename PointT>
ScanPair<PointT>
makePair()
{
  ScanPair<PointT> pair;
  pair.target = toCloud<PointT>(coarseScans().target);
  pair.source = toCloud<PointT>(coarseScans().source);
  pair.T_target_source = coarseScans().T_target_source;
  return pair;
}

template <typename Method>
constexpr bool kIsSuper4Pcs = std::is_base_of_v<Super4PCS<typename Method::PointCloudSource::PointType,
                                                          typename Method::PointCloudTarget::PointType,
                                                          typename Method::Matrix4::Scalar>,
                                                Method>;
template <typename Method>
constexpr bool kIsGoIcp = std::is_base_of_v<GoIcp<typename Method::PointCloudSource::PointType,
                                                  typename Method::PointCloudTarget::PointType,
                                                  typename Method::Matrix4::Scalar>,
                                            Method>;

/// A method set up so that it solves makePair() quickly.
template <typename Method>
typename Method::Ptr
makeMethod()
{
  auto method = pcl::make_shared<Method>();
  method->setNumberOfThreads(1);
  if constexpr (kIsSuper4Pcs<Method>) {
    method->setLeafSize(0.1); // from these thin scans it would be 0.2, and the answer half as exact
    method->setOverlap(0.8);
    method->setMaximumIterations(20);
  }
  if constexpr (kIsGoIcp<Method>) {
    method->setSourcePoints(150);
    method->setTrimFraction(0.1);
    method->setMseThreshold(0.002);
    method->setDistanceTransformSize(60);
  }
  return method;
}

template <typename Method>
class BaselineContract : public ::testing::Test {
public:
  using Point = typename Method::PointCloudSource::PointType;
  using Cloud = pcl::PointCloud<Point>;

  static void
  SetUpTestSuite()
  {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }

  ScanPair<Point> pair = makePair<Point>();
  typename Method::Ptr method = makeMethod<Method>();

  void
  align(Cloud& output)
  {
    method->setInputSource(pair.source);
    method->setInputTarget(pair.target);
    method->align(output);
  }
};

template <typename PointT, typename Scalar>
using Fgr = FastGlobalRegistration<PointT, PointT, Scalar>;
template <typename PointT, typename Scalar>
using Goi = GoIcp<PointT, PointT, Scalar>;
template <typename PointT, typename Scalar>
using S4 = Super4PCS<PointT, PointT, Scalar>;

using Methods = ::testing::Types<Fgr<pcl::PointXYZ, float>,
                                 Fgr<pcl::PointXYZINormal, double>,
                                 Goi<pcl::PointXYZ, float>,
                                 S4<pcl::PointXYZ, double>,
                                 S4<pcl::PointXYZINormal, float>>;
TYPED_TEST_SUITE(BaselineContract, Methods);

constexpr double kMaxRotation = 0.07;   // 4 degrees
constexpr double kMaxTranslation = 0.3; // [m]

TYPED_TEST(BaselineContract, AlignsThroughTheBasePointer)
{
  using Registration = typename TypeParam::Base::Base;
  const typename Registration::Ptr registration = this->method;
  typename TestFixture::Cloud output;
  registration->setInputSource(this->pair.source);
  registration->setInputTarget(this->pair.target);
  registration->align(output);
  ASSERT_TRUE(registration->hasConverged()) << this->method->getMessage();
  EXPECT_THAT(registration->getFinalTransformation(),
              IsPoseNear(this->pair.T_target_source, kMaxRotation, kMaxTranslation));
  ASSERT_EQ(output.size(), this->pair.source->size());
  for (std::size_t i = 0; i < output.size(); i += 100) {
    const Eigen::Vector4d expected = registration->getFinalTransformation().template cast<double>() *
                                     (*this->pair.source)[i].getVector4fMap().template cast<double>();
    EXPECT_NEAR((output[i].getVector4fMap().template cast<double>() - expected).norm(), 0, 1e-4);
  }
  EXPECT_LT(registration->getFitnessScore(0.04), 0.04);
  EXPECT_GT(this->method->getCorrespondences()->size(), output.size() / 2);
}

TYPED_TEST(BaselineContract, AlignTwiceGivesTheSameBits)
{
  typename TestFixture::Cloud output;
  this->align(output);
  const auto first = this->method->getFinalTransformation();
  this->method->setNumberOfThreads(3);
  this->method->align(output);
  EXPECT_EQ(first, this->method->getFinalTransformation());
}

TYPED_TEST(BaselineContract, NonFinitePointsStayAndIndicesAreHonoured)
{
  auto& source = *this->pair.source;
  (*this->pair.target)[3].x = kNaN;
  const auto indices = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (i % 10 != 0)
      indices->push_back(static_cast<pcl::index_t>(i));
  }
  source[1].x = kNaN;
  source[1].y = 5;
  indices->push_back(static_cast<pcl::index_t>(source.size())); // outside
  this->method->setInputSource(this->pair.source);
  this->method->setIndices(indices);
  typename TestFixture::Cloud output;
  this->align(output);
  EXPECT_TRUE(this->method->hasConverged()) << this->method->getMessage();
  ASSERT_EQ(output.size(), indices->size() - 1);
  EXPECT_TRUE(std::isnan(output[0].x));
  EXPECT_EQ(output[0].y, 5);
}

TYPED_TEST(BaselineContract, FailureLeavesTheGuess)
{
  using Matrix4 = typename TypeParam::Matrix4;
  this->pair.source->resize(2);
  Matrix4 guess = Matrix4::Identity();
  guess(0, 3) = 2;
  typename TestFixture::Cloud output;
  this->method->setInputSource(this->pair.source);
  this->method->setInputTarget(this->pair.target);
  this->method->align(output, guess);
  EXPECT_FALSE(this->method->hasConverged());
  EXPECT_FALSE(this->method->getMessage().empty());
  EXPECT_EQ(this->method->getFinalTransformation(), guess);
  ASSERT_EQ(output.size(), 2U);
  EXPECT_NEAR(output[0].x, (*this->pair.source)[0].x + 2, 1e-5);
  EXPECT_TRUE(this->method->getCorrespondences()->empty());
}

TYPED_TEST(BaselineContract, CloudsWithoutAFinitePoint)
{
  for (auto& point : *this->pair.source)
    point.x = kNaN;
  typename TestFixture::Cloud output;
  this->align(output);
  EXPECT_FALSE(this->method->hasConverged());
  EXPECT_EQ(output.size(), this->pair.source->size());
}

TYPED_TEST(BaselineContract, EmptyAndNullCloudsAreRefused)
{
  typename TestFixture::Cloud output;
  this->method->align(output); // nothing set
  EXPECT_FALSE(this->method->hasConverged());
  this->method->setInputSource(nullptr);
  this->method->setInputTarget(nullptr);
  this->method->setInputSource(pcl::make_shared<typename TestFixture::Cloud>());
  this->method->setInputTarget(pcl::make_shared<typename TestFixture::Cloud>());
  this->method->align(output);
  EXPECT_FALSE(this->method->hasConverged());
  this->align(output);
  EXPECT_TRUE(this->method->hasConverged()) << this->method->getMessage();
  this->method->setInputSource(this->pair.source); // a cloud set again: nothing is known of it
  EXPECT_FALSE(this->method->hasConverged());
}

TYPED_TEST(BaselineContract, OutputMayBeTheSourceButNotTheTarget)
{
  const auto untouched = *this->pair.source;
  this->align(*this->pair.source);
  ASSERT_TRUE(this->method->hasConverged()) << this->method->getMessage();
  const Eigen::Vector4d expected = this->method->getFinalTransformation().template cast<double>() *
                                   untouched[7].getVector4fMap().template cast<double>();
  EXPECT_NEAR(((*this->pair.source)[7].getVector4fMap().template cast<double>() - expected).norm(), 0, 1e-4);

  this->method->align(*this->pair.target);
  EXPECT_FALSE(this->method->hasConverged());
  EXPECT_NE(this->method->getMessage().find("target"), std::string::npos) << this->method->getMessage();
}

TYPED_TEST(BaselineContract, GuessThatIsRightIsNotLost)
{
  typename TestFixture::Cloud output;
  this->method->setInputSource(this->pair.source);
  this->method->setInputTarget(this->pair.target);
  const auto guess = this->pair.T_target_source.matrix().template cast<typename TypeParam::Matrix4::Scalar>().eval();
  this->method->align(output, guess);
  ASSERT_TRUE(this->method->hasConverged()) << this->method->getMessage();
  EXPECT_THAT(this->method->getFinalTransformation(),
              IsPoseNear(this->pair.T_target_source, kMaxRotation, kMaxTranslation));
}

TYPED_TEST(BaselineContract, BadSettingIsNamed)
{
  const char* expected = "leaf = -1, must be finite and >= 0 [m]";
  if constexpr (kIsGoIcp<TypeParam>) {
    this->method->setSourcePoints(2);
    expected = "source_points = 2, must be 3 or more";
  }
  else {
    this->method->setLeafSize(-1);
  }
  typename TestFixture::Cloud output;
  this->align(output);
  EXPECT_FALSE(this->method->hasConverged());
  EXPECT_EQ(this->method->getMessage(), expected);
}

TYPED_TEST(BaselineContract, DistanceThresholdIsTheMaximumCorrespondenceDistance)
{
  typename TestFixture::Cloud output;
  this->method->setMaxCorrespondenceDistance(0.25);
  this->align(output);
  EXPECT_EQ(this->method->getResult().inlier_distance, 0.25);
  for (const pcl::Correspondence& match : *this->method->getCorrespondences())
    ASSERT_LE(match.distance, 0.25F * 0.25F);
}

/// The other precompiled types: they link and work.
template <typename Method>
class BaselineInstantiation : public BaselineContract<Method> {};

using OtherMethods = ::testing::Types<Fgr<pcl::PointXYZ, double>,
                                      Fgr<pcl::PointXYZI, float>,
                                      Fgr<pcl::PointXYZI, double>,
                                      Fgr<pcl::PointNormal, float>,
                                      Fgr<pcl::PointNormal, double>,
                                      Fgr<pcl::PointXYZINormal, float>,
                                      Goi<pcl::PointXYZ, double>,
                                      Goi<pcl::PointXYZI, double>,
                                      Goi<pcl::PointNormal, double>,
                                      Goi<pcl::PointXYZINormal, float>,
                                      S4<pcl::PointXYZ, float>,
                                      S4<pcl::PointXYZI, float>,
                                      S4<pcl::PointXYZI, double>,
                                      S4<pcl::PointNormal, float>,
                                      S4<pcl::PointNormal, double>,
                                      S4<pcl::PointXYZINormal, double>>;
TYPED_TEST_SUITE(BaselineInstantiation, OtherMethods);

TYPED_TEST(BaselineInstantiation, LinksAndAligns)
{
  typename TestFixture::Cloud output;
  this->align(output);
  ASSERT_TRUE(this->method->hasConverged()) << this->method->getMessage();
  EXPECT_THAT(this->method->getFinalTransformation(),
              IsPoseNear(this->pair.T_target_source, kMaxRotation, kMaxTranslation));
}

TEST(FastGlobalRegistrationNormals, NormalsOfTheOutputAreRotated)
{
  const ScanPair<pcl::PointNormal> pair = makePair<pcl::PointNormal>();
  FastGlobalRegistration<pcl::PointNormal, pcl::PointNormal> method;
  method.setInputSource(pair.source);
  method.setInputTarget(pair.target);
  pcl::PointCloud<pcl::PointNormal> output;
  method.align(output);
  const Eigen::Vector3f expected =
      method.getFinalTransformation().topLeftCorner<3, 3>() * (*pair.source)[5].getNormalVector3fMap();
  EXPECT_NEAR((output[5].getNormalVector3fMap() - expected).norm(), 0, 1e-5);
}

} // namespace
} // namespace pcl_ssfr::baselines::test_baseline_registration
