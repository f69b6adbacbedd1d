// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// StructuredSceneRegistration as a drop-in for pcl::IterativeClosestPoint. What PCL's class promises is tested on both
// through pcl::Registration::Ptr, ICP being the control; the rest is where ours promises more.

#include "pcl_clouds.h"
#include "pose_matchers.h"

#include <pcl_ssfr/detail/finite_query_kdtree.h>
#include <pcl_ssfr/structured_scene_registration.h>

#include <pcl/common/transforms.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/incremental_registration.h>
#include <pcl/registration/meta_registration.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <ostream>
#include <set>
#include <string>
#include <vector>

namespace pcl_ssfr::test_pcl_contract {
namespace {

using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::makeRoomPair;
using pcl_ssfr::testing::ScanPair;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

template <typename PointT, typename ScalarT>
struct Icp {
  using Point = PointT;
  using Scalar = ScalarT;
  using Method = pcl::IterativeClosestPoint<PointT, PointT, ScalarT>;
  static constexpr bool kIsGlobal = false;
  static constexpr const char* kName = "IterativeClosestPoint";
};

template <typename PointT, typename ScalarT>
struct Ssfr {
  using Point = PointT;
  using Scalar = ScalarT;
  using Method = StructuredSceneRegistration<PointT, PointT, ScalarT>;
  static constexpr bool kIsGlobal = true;
  static constexpr const char* kName = "StructuredSceneRegistration";
};

/// Every \p step th point of a cloud.
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
thinned(const pcl::PointCloud<PointT>& cloud, std::size_t step)
{
  auto thin = pcl::make_shared<pcl::PointCloud<PointT>>();
  for (std::size_t i = 0; i < cloud.size(); i += step)
    thin->push_back(cloud[i]);
  return thin;
}

/// The scans are cast once for all tests.
template <typename PointT>
const ScanPair<PointT>&
roomPair(bool small_motion)
{
  if (small_motion) {
    static const ScanPair<PointT> small = [] {
      ScanPair<PointT> pair = makeRoomPair<PointT>(true, 0.0436);
      pair.source = thinned(*pair.source, 3); // sparse, or ICP takes a minute of the tests
      return pair;
    }();
    return small;
  }
  static const ScanPair<PointT> large = makeRoomPair<PointT>(false);
  return large;
}

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
copyOf(const pcl::PointCloud<PointT>& cloud)
{
  return pcl::make_shared<pcl::PointCloud<PointT>>(cloud);
}

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
movedBy(const Eigen::Isometry3d& T, const pcl::PointCloud<PointT>& cloud)
{
  auto moved = pcl::make_shared<pcl::PointCloud<PointT>>();
  if constexpr (pcl::traits::has_normal_v<PointT>) {
    pcl::transformPointCloudWithNormals(cloud, *moved, Eigen::Matrix4d(T.matrix()));
  }
  else {
    pcl::transformPointCloud(cloud, *moved, Eigen::Matrix4d(T.matrix()));
  }
  return moved;
}

/// Largest distance between points of equal number; infinity when the sizes differ.
template <typename PointT>
float
maxDistance(const pcl::PointCloud<PointT>& a, const pcl::PointCloud<PointT>& b)
{
  if (a.size() != b.size()) {
    return std::numeric_limits<float>::infinity();
  }
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].getVector3fMap() - b[i].getVector3fMap()).norm());
  }
  return largest;
}

template <typename Matrix>
bool
sameBits(const Matrix& a, const Matrix& b)
{
  return std::memcmp(a.data(), b.data(), sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(a.size())) == 0;
}

template <typename PointT>
bool
sameBits(const pcl::PointCloud<PointT>& a, const pcl::PointCloud<PointT>& b)
{
  if (a.size() != b.size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!sameBits(Eigen::Vector4f(a[i].getVector4fMap()), Eigen::Vector4f(b[i].getVector4fMap()))) {
      return false;
    }
  }
  return true;
}

Eigen::Isometry3d
motion(double yaw, const Eigen::Vector3d& translation)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d(0.1, -0.2, 1).normalized()).toRotationMatrix();
  T.translation() = translation;
  return T;
}

/// What was printed to stderr (PCL_ERROR, PCL_WARN) while \p action ran.
template <typename Action>
std::string
messagesOf(Action action)
{
  ::testing::internal::CaptureStderr();
  action();
  return ::testing::internal::GetCapturedStderr();
}

// ---------------------------------------------------------------------------------------------------------------
// Shared with pcl::IterativeClosestPoint

template <typename T>
class RegistrationContract : public ::testing::Test {
protected:
  using Point = typename T::Point;
  using Scalar = typename T::Scalar;
  using Cloud = pcl::PointCloud<Point>;
  using Registration = pcl::Registration<Point, Point, Scalar>;
  using Matrix4 = typename Registration::Matrix4;

  void
  SetUp() override
  {
    registration_ = pcl::make_shared<typename T::Method>();
    registration_->setMaximumIterations(30);
    if (!T::kIsGlobal) {
      registration_->setMaxCorrespondenceDistance(0.3);
    }
  }

  /// Clouds as the tests need them: a motion small enough for ICP.
  const ScanPair<Point>&
  pair() const
  {
    return roomPair<Point>(true);
  }
  void
  expectTruth(const Matrix4& T_target_source) const
  {
    const double max_rotation = (T::kIsGlobal ? 0.2 : 1.0) * kDegree;
    const double max_translation = T::kIsGlobal ? 0.01 : 0.05;
    EXPECT_THAT(T_target_source, IsPoseNear(pair().T_target_source, max_rotation, max_translation));
  }
  /// A source that no method can align.
  static typename Cloud::Ptr
  hopelessCloud()
  {
    auto cloud = pcl::make_shared<Cloud>();
    for (int i = 0; i < 2; ++i) {
      Point point;
      point.getVector3fMap() = Eigen::Vector3f(1.0F + static_cast<float>(i), 2, 3);
      cloud->push_back(point);
    }
    return cloud;
  }

  typename Registration::Ptr registration_;
};

using Methods = ::testing::Types<Icp<pcl::PointXYZ, float>,
                                 Icp<pcl::PointNormal, float>,
                                 Ssfr<pcl::PointXYZ, float>,
                                 Ssfr<pcl::PointXYZ, double>,
                                 Ssfr<pcl::PointNormal, float>>;
TYPED_TEST_SUITE(RegistrationContract, Methods);

TYPED_TEST(RegistrationContract, AlignsThroughTheBasePointer)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  EXPECT_FALSE(this->registration_->hasConverged());
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  this->expectTruth(this->registration_->getFinalTransformation());
  EXPECT_EQ(this->registration_->getClassName(), TypeParam::kName);
}

TYPED_TEST(RegistrationContract, OrderOfTheSettersDoesNotMatter)
{
  typename TestFixture::Cloud output;
  this->registration_->setInputTarget(this->pair().target);
  this->registration_->setInputSource(this->pair().source);
  this->registration_->align(output);
  const auto first = this->registration_->getFinalTransformation();
  this->SetUp();
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  this->registration_->align(output);
  EXPECT_TRUE(this->registration_->hasConverged());
  EXPECT_TRUE(sameBits(first, this->registration_->getFinalTransformation()));
}

TYPED_TEST(RegistrationContract, OutputIsTheSourceMovedAndNothingElse)
{
  const auto source = copyOf(*this->pair().source);
  source->header.frame_id = "laser";
  source->header.stamp = 42;
  source->header.seq = 7;
  source->sensor_origin_ = Eigen::Vector4f(0.25F, 0, 0, 0);
  this->registration_->setInputSource(source);
  this->registration_->setInputTarget(this->pair().target);
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());

  EXPECT_EQ(output.size(), source->size());
  EXPECT_EQ(output.width, source->width);
  EXPECT_EQ(output.height, source->height);
  EXPECT_EQ(output.is_dense, source->is_dense);
  EXPECT_EQ(output.header.frame_id, "laser");
  EXPECT_EQ(output.header.stamp, 42U);
  EXPECT_EQ(output.header.seq, 7U);
  EXPECT_EQ(output.sensor_origin_, source->sensor_origin_);
  typename TestFixture::Cloud expected;
  pcl::transformPointCloud(*source, expected, this->registration_->getFinalTransformation());
  EXPECT_LT(maxDistance(output, expected), 1e-5F);
}

TYPED_TEST(RegistrationContract, OrganisedSourceStaysOrganised)
{
  const auto source = copyOf(*this->pair().source);
  source->resize(source->size() / 10 * 10);
  source->height = 10;
  source->width = static_cast<std::uint32_t>(source->size() / 10);
  this->registration_->setInputSource(source);
  this->registration_->setInputTarget(this->pair().target);
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  EXPECT_TRUE(this->registration_->hasConverged());
  EXPECT_EQ(output.height, 10U);
  EXPECT_EQ(output.width, source->width);
}

/// The point types with normals.
template <typename T>
class NormalContract : public RegistrationContract<T> {};

using MethodsWithNormals =
    ::testing::Types<Icp<pcl::PointNormal, float>, Ssfr<pcl::PointNormal, float>, Ssfr<pcl::PointXYZINormal, double>>;
TYPED_TEST_SUITE(NormalContract, MethodsWithNormals);

TYPED_TEST(NormalContract, NormalsAreRotated)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  const Eigen::Matrix3f R =
      this->registration_->getFinalTransformation().template topLeftCorner<3, 3>().template cast<float>();
  for (std::size_t i = 0; i < output.size(); i += 100) {
    const Eigen::Vector3f expected = R * (*this->pair().source)[i].getNormalVector3fMap();
    EXPECT_LT((output[i].getNormalVector3fMap() - expected).norm(), 1e-5F);
  }
}

TYPED_TEST(RegistrationContract, AlignTwiceGivesTheSameBits)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  typename TestFixture::Cloud first;
  typename TestFixture::Cloud second;
  this->registration_->align(first);
  const auto T_first = this->registration_->getFinalTransformation();
  this->registration_->align(second);
  EXPECT_TRUE(this->registration_->hasConverged());
  EXPECT_TRUE(sameBits(T_first, this->registration_->getFinalTransformation()));
  EXPECT_TRUE(sameBits(first, second));
}

TYPED_TEST(RegistrationContract, NewTargetIsUsed)
{
  typename TestFixture::Cloud output;
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  this->registration_->align(output);
  const Eigen::Isometry3d shift = motion(0.03, Eigen::Vector3d(0.05, 0.04, -0.02));
  this->registration_->setInputTarget(movedBy(shift, *this->pair().target));
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  const Eigen::Matrix4d T = this->registration_->getFinalTransformation().template cast<double>();
  this->expectTruth((shift.inverse().matrix() * T).template cast<typename TypeParam::Scalar>());
}

TYPED_TEST(RegistrationContract, NewSourceIsUsed)
{
  typename TestFixture::Cloud output;
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  this->registration_->align(output);
  const Eigen::Isometry3d shift = motion(0.03, Eigen::Vector3d(0.05, 0.04, -0.02));
  this->registration_->setInputSource(movedBy(shift, *this->pair().source));
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  const Eigen::Matrix4d T = this->registration_->getFinalTransformation().template cast<double>();
  this->expectTruth((T * shift.matrix()).template cast<typename TypeParam::Scalar>());
}

TYPED_TEST(RegistrationContract, EditsInPlaceAreSeenWhenTheCloudIsSetAgain)
{
  const auto source = copyOf(*this->pair().source);
  const auto target = copyOf(*this->pair().target);
  typename TestFixture::Cloud output;
  this->registration_->setInputSource(source);
  this->registration_->setInputTarget(target);
  this->registration_->align(output);
  const Eigen::Isometry3d shift = motion(0.02, Eigen::Vector3d(-0.03, 0.04, 0.02));
  *source = *movedBy(shift, *source);
  *target = *movedBy(shift, *target);
  this->registration_->setInputSource(source);
  this->registration_->setInputTarget(target);
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  const Eigen::Matrix4d T = this->registration_->getFinalTransformation().template cast<double>();
  this->expectTruth((shift.inverse().matrix() * T * shift.matrix()).template cast<typename TypeParam::Scalar>());
}

TYPED_TEST(RegistrationContract, EmptyCloudIsRefusedAndTheOldOneKept)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  const auto empty = pcl::make_shared<typename TestFixture::Cloud>();
  const std::string messages = messagesOf([&] {
    this->registration_->setInputSource(empty);
    this->registration_->setInputTarget(empty);
  });
  EXPECT_THAT(messages, HasSubstr("Invalid or empty"));
  EXPECT_EQ(this->registration_->getInputSource(), this->pair().source);
  EXPECT_EQ(this->registration_->getInputTarget(), this->pair().target);
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  EXPECT_TRUE(this->registration_->hasConverged());
  this->expectTruth(this->registration_->getFinalTransformation());
}

TYPED_TEST(RegistrationContract, MissingCloudIsReportedAndTheOutputIsLeftAlone)
{
  typename TestFixture::Cloud output;
  output.push_back(typename TypeParam::Point());
  EXPECT_THAT(messagesOf([&] { this->registration_->align(output); }), HasSubstr("No input target"));
  this->registration_->setInputTarget(this->pair().target);
  EXPECT_THAT(messagesOf([&] { this->registration_->align(output); }), HasSubstr("No input set"));
  EXPECT_EQ(output.size(), 1U);
  EXPECT_FALSE(this->registration_->hasConverged());
}

TYPED_TEST(RegistrationContract, OutputMayBeTheSource)
{
  const auto source = copyOf(*this->pair().source);
  this->registration_->setInputSource(source);
  this->registration_->setInputTarget(this->pair().target);
  this->registration_->align(*source);
  ASSERT_TRUE(this->registration_->hasConverged());
  this->expectTruth(this->registration_->getFinalTransformation());
  typename TestFixture::Cloud expected;
  pcl::transformPointCloud(*this->pair().source, expected, this->registration_->getFinalTransformation());
  EXPECT_LT(maxDistance(*source, expected), 1e-5F);
  // The source is the moved cloud from now on.
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  EXPECT_THAT(this->registration_->getFinalTransformation(),
              IsPoseNear(Eigen::Isometry3d::Identity(), 0.5 * kDegree, 0.03));
}

TYPED_TEST(RegistrationContract, ResultIsAbsoluteWithAGuess)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  const Eigen::Isometry3d guess = this->pair().T_target_source * motion(0.02, Eigen::Vector3d(0.03, 0.02, 0.01));
  typename TestFixture::Cloud output;
  this->registration_->align(output, guess.matrix().template cast<typename TypeParam::Scalar>());
  ASSERT_TRUE(this->registration_->hasConverged());
  this->expectTruth(this->registration_->getFinalTransformation());
  typename TestFixture::Cloud expected;
  pcl::transformPointCloud(*this->pair().source, expected, this->registration_->getFinalTransformation());
  EXPECT_LT(maxDistance(output, expected), 1e-5F);
}

TYPED_TEST(RegistrationContract, FailureLeavesTheGuessAndTheSourceMovedByIt)
{
  typename TestFixture::Cloud output;
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());

  const auto hopeless = this->hopelessCloud();
  this->registration_->setInputSource(hopeless);
  const typename TestFixture::Matrix4 guess =
      motion(0.3, Eigen::Vector3d(20, 30, 40)).matrix().template cast<typename TypeParam::Scalar>();
  this->registration_->align(output, guess);
  EXPECT_FALSE(this->registration_->hasConverged());
  EXPECT_TRUE(sameBits(guess, this->registration_->getFinalTransformation()));
  typename TestFixture::Cloud expected;
  pcl::transformPointCloud(*hopeless, expected, guess);
  EXPECT_LT(maxDistance(output, expected), 1e-5F);
}

TYPED_TEST(RegistrationContract, FitnessIsSmallAfterAlignment)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  const double close = this->registration_->getFitnessScore(0.1 * 0.1);
  EXPECT_GT(close, 0);
  EXPECT_LT(close, 0.05 * 0.05);
  EXPECT_GE(this->registration_->getFitnessScore(), close);
}

TYPED_TEST(RegistrationContract, CallbackIsCalledAtRegistrationAndDuringAlign)
{
  this->registration_->setInputSource(this->pair().source);
  this->registration_->setInputTarget(this->pair().target);
  int calls = 0;
  typename TestFixture::Cloud last_moved;
  std::size_t last_pairs = 0;
  std::function<typename TestFixture::Registration::UpdateVisualizerCallbackSignature> callback =
      [&](const typename TestFixture::Cloud& moved,
          const pcl::Indices& source_indices,
          const typename TestFixture::Cloud& target,
          const pcl::Indices& target_indices) {
        ++calls;
        EXPECT_EQ(source_indices.size(), target_indices.size());
        EXPECT_EQ(target.size(), this->pair().target->size());
        last_moved = moved;
        last_pairs = source_indices.size();
      };
  EXPECT_TRUE(this->registration_->registerVisualizationCallback(callback));
  EXPECT_EQ(calls, 1);
  typename TestFixture::Cloud output;
  this->registration_->align(output);
  ASSERT_TRUE(this->registration_->hasConverged());
  EXPECT_GE(calls, 2);
  EXPECT_GT(last_pairs, this->pair().source->size() / 2);
  EXPECT_LT(maxDistance(last_moved, output), 1e-3F);
}

TYPED_TEST(RegistrationContract, IncrementalRegistrationAcceptsIt)
{
  pcl::registration::IncrementalRegistration<typename TypeParam::Point, typename TypeParam::Scalar> incremental;
  incremental.setRegistration(this->registration_);
  EXPECT_TRUE(incremental.registerCloud(this->pair().target));
  EXPECT_TRUE(incremental.registerCloud(this->pair().source));
  this->expectTruth(incremental.getAbsoluteTransform());
  EXPECT_FALSE(incremental.registerCloud(this->hopelessCloud()));
  this->expectTruth(incremental.getAbsoluteTransform());
}

TYPED_TEST(RegistrationContract, MetaRegistrationAcceptsIt)
{
  pcl::registration::MetaRegistration<typename TypeParam::Point, typename TypeParam::Scalar> meta;
  meta.setRegistration(this->registration_);
  EXPECT_TRUE(meta.registerCloud(this->pair().target));
  EXPECT_TRUE(meta.registerCloud(this->pair().source));
  this->expectTruth(meta.getAbsoluteTransform());
  EXPECT_EQ(meta.getMetaCloud()->size(), this->pair().target->size() + this->pair().source->size());
}

// ---------------------------------------------------------------------------------------------------------------
// Ours alone

class StructuredScene : public ::testing::Test {
protected:
  using Point = pcl::PointXYZ;
  using Cloud = pcl::PointCloud<Point>;
  using Registration = StructuredSceneRegistration<Point, Point>;

  void
  setPair(bool small_motion = false)
  {
    registration_.setInputSource(roomPair<Point>(small_motion).source);
    registration_.setInputTarget(roomPair<Point>(small_motion).target);
  }
  /// The same pair in clouds that a test may change: source and target.
  std::pair<Cloud::Ptr, Cloud::Ptr>
  setCopies()
  {
    const auto source = copyOf(*roomPair<Point>(false).source);
    const auto target = copyOf(*roomPair<Point>(false).target);
    registration_.setInputSource(source);
    registration_.setInputTarget(target);
    return {source, target};
  }
  static void
  expectTruth(const Eigen::Matrix4f& T, double max_degrees = 0.2, double max_translation = 0.01)
  {
    EXPECT_THAT(T, IsPoseNear(roomPair<Point>(false).T_target_source, max_degrees * kDegree, max_translation));
  }

  Registration registration_;
  Cloud output_;
};

static_assert(!std::is_same_v<StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ>::Ptr,
                              pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>::Ptr>,
              "the class must have its own Ptr");
static_assert(!std::is_copy_constructible_v<StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ>>);
static_assert(!std::is_move_constructible_v<StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ>>);

TEST_F(StructuredScene, SolvesALargeMotionWithoutGuessOrParameter)
{
  setPair();
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged()) << registration_.getResult().message;
  expectTruth(registration_.getFinalTransformation());
  EXPECT_TRUE(pcl_ssfr::testing::isRigid(registration_.getFinalTransformation(), 1e-6));
  EXPECT_TRUE(sameBits(registration_.getFinalTransformation(), registration_.getLastIncrementalTransformation()));

  const Result& result = registration_.getResult();
  EXPECT_EQ(result.status, Status::Converged);
  EXPECT_GT(result.overlap, 0.3);
  EXPECT_GT(result.confidence, 0.5);
  ASSERT_FALSE(result.stages.empty());
  EXPECT_FALSE(registration_.getCorrespondences()->empty());
  EXPECT_GE(registration_.getFinalNumIteration(), 1);
  EXPECT_EQ(registration_.getFinalNumIteration(), static_cast<int>(result.candidates.size()));

  // The control: ICP alone is lost here.
  pcl::IterativeClosestPoint<Point, Point> icp;
  icp.setMaximumIterations(50);
  icp.setInputSource(thinned(*roomPair<Point>(false).source, 4));
  icp.setInputTarget(roomPair<Point>(false).target);
  icp.align(output_);
  EXPECT_THAT(icp.getFinalTransformation(), Not(IsPoseNear(roomPair<Point>(false).T_target_source, 2 * kDegree, 0.3)));
}

TEST_F(StructuredScene, NothingWasRunBeforeAlign)
{
  EXPECT_EQ(registration_.getResult().status, Status::NotRun);
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getFinalNumIteration(), 0);
  EXPECT_TRUE(registration_.getCorrespondences()->empty());
}

TEST_F(StructuredScene, SettingACloudForgetsTheLastResult)
{
  setPair();
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  registration_.setInputTarget(roomPair<Point>(false).target);
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::NotRun);
  EXPECT_TRUE(registration_.getCorrespondences()->empty());
}

TEST_F(StructuredScene, NullCloudIsRefusedAndTheOldOneKept)
{
  setPair();
  EXPECT_THAT(messagesOf([&] { registration_.setInputSource(Cloud::ConstPtr()); }), HasSubstr("null cloud"));
  EXPECT_THAT(messagesOf([&] { registration_.setInputTarget(Cloud::ConstPtr()); }), HasSubstr("null cloud"));
  registration_.align(output_);
  EXPECT_TRUE(registration_.hasConverged());
}

TEST_F(StructuredScene, PreparedScansAreKeptUntilTheCloudIsSetAgain)
{
  const auto [source, target] = setCopies();
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  const Eigen::Matrix4f first = registration_.getFinalTransformation();

  // Not announced: the answer comes from what was prepared, bit by bit.
  const Eigen::Isometry3d shift = motion(0.5, Eigen::Vector3d(1, 2, 0.5));
  const Cloud moved_source = *movedBy(shift, *source);
  *source = moved_source;
  registration_.align(output_);
  EXPECT_TRUE(sameBits(first, registration_.getFinalTransformation()));
  // Announced: it is seen.
  registration_.setInputSource(source);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  expectTruth((registration_.getFinalTransformation().cast<double>() * shift.matrix()).cast<float>());

  const Eigen::Matrix4f second = registration_.getFinalTransformation();
  *target = *movedBy(shift, *target);
  registration_.align(output_);
  EXPECT_TRUE(sameBits(second, registration_.getFinalTransformation()));
  registration_.setInputTarget(target);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  expectTruth((shift.inverse().matrix() * registration_.getFinalTransformation().cast<double>() * shift.matrix())
                  .cast<float>());
}

TEST_F(StructuredScene, OptionsThatMatterDropThePreparedScans)
{
  const auto source = copyOf(*roomPair<Point>(false).source);
  registration_.setInputSource(source);
  registration_.setInputTarget(roomPair<Point>(false).target);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  source->resize(2); // not announced
  registration_.setNumberOfThreads(2);
  registration_.align(output_);
  EXPECT_TRUE(registration_.hasConverged()) << "the number of threads must not matter";
  registration_.setViewpointMode(ViewpointMode::SensorOrigin);
  registration_.align(output_);
  EXPECT_EQ(registration_.getResult().status, Status::TooFewPoints) << "the source must be read again";
}

TEST_F(StructuredScene, NonFinitePointsAreSkippedAndStayInPlace)
{
  const float infinity = std::numeric_limits<float>::infinity();
  for (const bool is_dense : {false, true}) { // is_dense may lie
    const auto source = copyOf(*roomPair<Point>(false).source);
    const auto target = copyOf(*roomPair<Point>(false).target);
    for (std::size_t i = 0; i < source->size(); i += 50) {
      (*source)[i].x = kNaN;
      (*source)[i].y = 5;
    }
    (*source)[1].getVector3fMap() = Eigen::Vector3f(infinity, 0, 0);
    for (std::size_t i = 0; i < target->size(); i += 70) {
      (*target)[i].getVector3fMap().setConstant(kNaN);
    }
    source->is_dense = is_dense;
    target->is_dense = is_dense;
    registration_.setInputSource(source);
    registration_.setInputTarget(target);
    registration_.align(output_);
    ASSERT_TRUE(registration_.hasConverged()) << registration_.getResult().message;
    expectTruth(registration_.getFinalTransformation());
    ASSERT_EQ(output_.size(), source->size());
    EXPECT_EQ(output_.is_dense, is_dense);
    EXPECT_TRUE(std::isnan(output_[50].x));
    EXPECT_EQ(output_[50].y, 5);
    EXPECT_EQ(output_[1].x, infinity);
    EXPECT_TRUE(pcl::isFinite(output_[2]));
    // PCL's own tree would abort on these queries.
    const double fitness = registration_.getFitnessScore();
    EXPECT_GT(fitness, 0);
    EXPECT_LT(fitness, 1);
    for (const pcl::Correspondence& pair : *registration_.getCorrespondences()) {
      ASSERT_TRUE(pcl::isFinite((*source)[static_cast<std::size_t>(pair.index_query)]));
      ASSERT_TRUE(pcl::isFinite((*target)[static_cast<std::size_t>(pair.index_match)]));
    }
  }
}

TEST_F(StructuredScene, NoFinitePointAtAll)
{
  const auto nothing = pcl::make_shared<Cloud>();
  nothing->resize(1000, Point(kNaN, kNaN, kNaN));
  nothing->is_dense = false;
  const auto& pair = roomPair<Point>(false);
  registration_.setInputSource(nothing);
  registration_.setInputTarget(pair.target);
  registration_.align(output_);
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::TooFewPoints);
  EXPECT_EQ(output_.size(), 1000U);
  EXPECT_EQ(registration_.getFitnessScore(), std::numeric_limits<double>::max());

  registration_.setInputSource(pair.source);
  registration_.setInputTarget(nothing);
  registration_.align(output_);
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::TooFewPoints);
  EXPECT_EQ(registration_.getFitnessScore(), std::numeric_limits<double>::max()) << "no target is no perfect fit";
}

TEST_F(StructuredScene, FitnessBeforeAlignIsNotPerfect)
{
  setPair();
  EXPECT_EQ(registration_.getFitnessScore(), std::numeric_limits<double>::max());
}

TEST_F(StructuredScene, TooFewPointsSaySo)
{
  const auto few = pcl::make_shared<Cloud>(*roomPair<Point>(false).source, pcl::Indices{1, 2, 3});
  registration_.setInputSource(few);
  registration_.setInputTarget(roomPair<Point>(false).target);
  registration_.align(output_);
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::TooFewPoints);
  EXPECT_FALSE(registration_.getResult().message.empty());
  EXPECT_EQ(output_.size(), 3U);
  EXPECT_TRUE(registration_.getFinalTransformation().isIdentity(0));
}

TEST_F(StructuredScene, OnlyTheIndexedPointsAreUsedAndReturned)
{
  // The room and, in the same cloud but not indexed, other places that would mislead.
  const auto& pair = roomPair<Point>(false);
  const auto source = copyOf(*pair.source);
  *source += *movedBy(motion(1.0, Eigen::Vector3d(3, 1, 0)), *pair.source);
  pcl::Indices chosen;
  for (std::size_t i = 0; i < pair.source->size(); i += 1 + i % 2) {
    chosen.push_back(static_cast<pcl::index_t>(i));
  }
  std::swap(chosen.front(), chosen.back()); // the order of the list counts
  registration_.setInputTarget(pair.target);

  const auto check = [&] {
    registration_.align(output_);
    ASSERT_TRUE(registration_.hasConverged()) << registration_.getResult().message;
    expectTruth(registration_.getFinalTransformation());
    Cloud expected;
    pcl::transformPointCloud(*source, chosen, expected, registration_.getFinalTransformation());
    EXPECT_LT(maxDistance(output_, expected), 1e-5F);
    EXPECT_EQ(output_.width, chosen.size());
    EXPECT_EQ(output_.height, 1U);
    const std::set<pcl::index_t> allowed(chosen.begin(), chosen.end());
    EXPECT_FALSE(registration_.getCorrespondences()->empty());
    for (const pcl::Correspondence& match : *registration_.getCorrespondences()) {
      ASSERT_EQ(allowed.count(match.index_query), 1U);
    }
  };
  registration_.setInputSource(source);
  registration_.setIndices(pcl::make_shared<pcl::Indices>(chosen));
  check();
  registration_.setIndices(pcl::IndicesConstPtr(pcl::make_shared<pcl::Indices>(chosen)));
  check();
  const auto point_indices = pcl::make_shared<pcl::PointIndices>();
  point_indices->indices = chosen;
  registration_.setIndices(pcl::PointIndices::ConstPtr(point_indices));
  check();

  registration_.setInputSource(pair.source);
  registration_.setIndices(pcl::IndicesPtr()); // all points again
  registration_.align(output_);
  EXPECT_EQ(output_.size(), pair.source->size());
  EXPECT_TRUE(registration_.hasConverged());
}

TEST_F(StructuredScene, RectangleOfAnOrganisedSource)
{
  const auto source = copyOf(*roomPair<Point>(false).source);
  source->resize(source->size() / 4 * 4);
  source->height = 4;
  source->width = static_cast<std::uint32_t>(source->size() / 4);
  EXPECT_THAT(messagesOf([&] { registration_.setIndices(0, 0, 1, 1); }), HasSubstr("needs a source"));
  registration_.setInputSource(source);
  registration_.setInputTarget(roomPair<Point>(false).target);
  registration_.setIndices(0, 0, 3, source->width);
  registration_.align(output_);
  EXPECT_EQ(output_.size(), 3U * source->width);
}

TEST_F(StructuredScene, IndicesOutsideTheSourceAreDropped)
{
  const auto& pair = roomPair<Point>(false);
  const auto size = static_cast<pcl::index_t>(pair.source->size());
  const auto given = pcl::make_shared<pcl::Indices>(pair.source->size());
  std::iota(given->begin(), given->end(), 0);
  given->push_back(size);
  given->push_back(-1);
  registration_.setInputTarget(pair.target);
  registration_.setInputSource(pair.source);
  EXPECT_THAT(messagesOf([&] { registration_.setIndices(given); }), HasSubstr("2 indices lie outside"));
  EXPECT_EQ(given->size(), pair.source->size() + 2) << "the caller's list must not change";
  registration_.align(output_);
  EXPECT_TRUE(registration_.hasConverged());
  EXPECT_EQ(output_.size(), pair.source->size());

  // A smaller source after the indices.
  const auto smaller = copyOf(*pair.source);
  smaller->resize(smaller->size() - 10);
  EXPECT_THAT(messagesOf([&] { registration_.setInputSource(smaller); }), HasSubstr("10 indices lie outside"));
  registration_.align(output_);
  EXPECT_TRUE(registration_.hasConverged());
  EXPECT_EQ(output_.size(), smaller->size());
}

TEST_F(StructuredScene, EmptyIndexListGivesAnEmptyOutput)
{
  setPair();
  registration_.setIndices(pcl::make_shared<pcl::Indices>());
  registration_.align(output_);
  EXPECT_TRUE(output_.empty());
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::TooFewPoints);
}

TEST_F(StructuredScene, OutputIsTheSourceWithIndices)
{
  const auto source = copyOf(*roomPair<Point>(false).source);
  const auto every_second = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < source->size(); i += 2) {
    every_second->push_back(static_cast<pcl::index_t>(i));
  }
  registration_.setInputSource(source);
  registration_.setInputTarget(roomPair<Point>(false).target);
  registration_.setIndices(every_second);
  EXPECT_THAT(messagesOf([&] { registration_.align(*source); }), HasSubstr("the output is the source"));
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::InvalidInput);
  EXPECT_EQ(source->size(), every_second->size());
}

TEST_F(StructuredScene, OutputIsTheTarget)
{
  const auto target = copyOf(*roomPair<Point>(false).target);
  registration_.setInputSource(roomPair<Point>(false).source);
  registration_.setInputTarget(target);
  EXPECT_THAT(messagesOf([&] { registration_.align(*target); }), HasSubstr("the output is the target"));
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::InvalidInput);
}

TEST_F(StructuredScene, WrongGuessDoesNoHarm)
{
  setPair();
  registration_.align(output_, motion(2, Eigen::Vector3d(4, -3, 1)).matrix().cast<float>());
  ASSERT_TRUE(registration_.hasConverged()) << registration_.getResult().message;
  expectTruth(registration_.getFinalTransformation());
}

TEST_F(StructuredScene, GuessThatIsNoMotionIsIgnored)
{
  setPair();
  const Eigen::Matrix4f no_number = Eigen::Matrix4f::Constant(kNaN);
  Eigen::Matrix4f mirrored = Eigen::Matrix4f::Identity();
  mirrored(0, 0) = -1;
  const Eigen::Matrix4f scaled = 2 * Eigen::Matrix4f::Identity();
  for (const Eigen::Matrix4f& guess : {no_number, mirrored, scaled}) {
    EXPECT_THAT(messagesOf([&] { registration_.align(output_, guess); }), HasSubstr("not a rigid motion"));
    EXPECT_TRUE(registration_.hasConverged());
    expectTruth(registration_.getFinalTransformation());
  }
  registration_.setIndices(pcl::make_shared<pcl::Indices>(2, 0));
  registration_.align(output_, no_number);
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_TRUE(registration_.getFinalTransformation().isIdentity(0));
  EXPECT_EQ(output_[0].x, (*roomPair<Point>(false).source)[0].x);
}

TEST_F(StructuredScene, AToleranceTakesAGuessThatIsAMotion)
{
  setPair();
  registration_.setGuessTolerance(0.1, 1);
  const Eigen::Matrix4f scaled = 1.1F * Eigen::Matrix4f::Identity();
  EXPECT_THAT(messagesOf([&] { registration_.align(output_, scaled); }),
              HasSubstr("the guess is not a rigid motion, and only poses near it are asked for"));
  EXPECT_FALSE(registration_.hasConverged());
  EXPECT_EQ(registration_.getResult().status, Status::InvalidInput);
  EXPECT_EQ(registration_.getFinalTransformation(), scaled) << "a failed run leaves the guess";
}

TEST_F(StructuredScene, CloudsThatChangeAfterAlign)
{
  const auto [source, target] = setCopies();
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  const double fitness = registration_.getFitnessScore();
  ASSERT_GT(fitness, 0);

  registration_.setInputTarget(target);
  registration_.align(output_);
  *target += output_; // the scan joins the map, then the user asks how well it fits
  EXPECT_NEAR(registration_.getFitnessScore(), fitness, 1e-3 * fitness);
  const auto pairs = registration_.getCorrespondences();
  const std::size_t count = pairs->size();
  EXPECT_GT(count, 0U);
  registration_.setInputSource(source); // nothing is known of it yet
  EXPECT_TRUE(registration_.getCorrespondences()->empty());
  EXPECT_EQ(pairs->size(), count) << "what was handed out stays";

  registration_.setInputTarget(target);
  registration_.align(output_);
  source->clear(); // a buffer that is used again
  EXPECT_THAT(messagesOf([&] { EXPECT_TRUE(registration_.getCorrespondences()->empty()); }),
              HasSubstr("a cloud has lost points"));

  registration_.setInputSource(roomPair<Point>(false).source);
  registration_.align(output_);
  target->clear();
  EXPECT_EQ(registration_.getFitnessScore(), std::numeric_limits<double>::max());
}

TEST_F(StructuredScene, CorrespondencesAreTheInliersOfTheFitness)
{
  setPair();
  constexpr double kRadius = 0.15;
  registration_.setMaxCorrespondenceDistance(kRadius);
  EXPECT_EQ(registration_.getOptions().overlap_radius, kRadius);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  const pcl::Correspondences& pairs = *registration_.getCorrespondences();
  ASSERT_FALSE(pairs.empty());
  double sum = 0;
  for (const pcl::Correspondence& pair : pairs) {
    const auto& query = output_[static_cast<std::size_t>(pair.index_query)];
    const auto& match = (*roomPair<Point>(false).target)[static_cast<std::size_t>(pair.index_match)];
    ASSERT_NEAR(pair.distance, (query.getVector3fMap() - match.getVector3fMap()).squaredNorm(), 1e-4);
    ASSERT_LE(pair.distance, static_cast<float>(kRadius * kRadius) * 1.0001F);
    sum += pair.distance;
  }
  const double mean = sum / static_cast<double>(pairs.size());
  EXPECT_NEAR(registration_.getFitnessScore(kRadius * kRadius), mean, 0.02 * mean);
  const double share = static_cast<double>(pairs.size()) / static_cast<double>(output_.size());
  EXPECT_NEAR(share, registration_.getResult().overlap, 0.35) << "two measures of one overlap";
}

TEST_F(StructuredScene, SearchTreeAndCorrespondencesAreMadeOnDemand)
{
  setPair();
  const auto tree = std::dynamic_pointer_cast<FiniteQueryKdTree<Point>>(registration_.getSearchMethodTarget());
  ASSERT_TRUE(tree);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  EXPECT_FALSE(tree->isBuilt());
  const double fitness = registration_.getFitnessScore(0.01);
  EXPECT_TRUE(tree->isBuilt());
  registration_.align(output_);
  EXPECT_TRUE(tree->isBuilt()) << "the target is the same";

  // What is found then does not depend on it.
  const pcl::Correspondences expected = *registration_.getCorrespondences();
  StructuredSceneRegistration<Point, Point> other;
  other.setInputSource(roomPair<Point>(false).source);
  other.setInputTarget(roomPair<Point>(false).target);
  other.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<Point>>()); // filled by align()
  other.align(output_);
  EXPECT_EQ(other.getFitnessScore(0.01), fitness);
  // Settings that are changed after align() are of the next one.
  other.setMaxCorrespondenceDistance(1e-6);
  const pcl::Correspondences& pairs = *other.getCorrespondences();
  ASSERT_EQ(pairs.size(), expected.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    ASSERT_EQ(pairs[i].index_query, expected[i].index_query);
    ASSERT_EQ(pairs[i].index_match, expected[i].index_match);
    ASSERT_EQ(pairs[i].distance, expected[i].distance);
  }
  EXPECT_EQ(other.getCorrespondences()->size(), expected.size()) << "they are looked for once";

  // Where the output takes the place of the source they are looked for while it is there.
  const auto source = copyOf(*roomPair<Point>(false).source);
  registration_.setInputSource(source);
  registration_.align(*source);
  ASSERT_EQ(registration_.getCorrespondences()->size(), expected.size());
  EXPECT_EQ(registration_.getCorrespondences()->back().distance, expected.back().distance);
}

TEST_F(StructuredScene, OverlapRadiusFollowsFromTheDataWhenUnset)
{
  EXPECT_GT(registration_.getMaxCorrespondenceDistance(), 1e100);
  EXPECT_EQ(registration_.getOptions().overlap_radius, 0);
  setPair();
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  float largest = 0;
  for (const pcl::Correspondence& pair : *registration_.getCorrespondences()) {
    largest = std::max(largest, pair.distance);
  }
  EXPECT_GT(std::sqrt(largest), 0.01F);
  EXPECT_LT(std::sqrt(largest), 0.5F);
}

TEST_F(StructuredScene, SearchTreeOfAnotherCloudIsNotTrusted)
{
  setPair();
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  const pcl::Correspondences expected = *registration_.getCorrespondences();
  const auto tree = pcl::make_shared<pcl::search::KdTree<Point>>();
  const auto other = pcl::make_shared<Cloud>();
  other->push_back(Point(100, 100, 100));
  tree->setInputCloud(other);
  registration_.setSearchMethodTarget(tree, true);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  const pcl::Correspondences& pairs = *registration_.getCorrespondences();
  ASSERT_EQ(pairs.size(), expected.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    ASSERT_EQ(pairs[i].index_match, expected[i].index_match);
  }
}

TEST_F(StructuredScene, PclsOwnTreeWorksToo)
{
  setPair();
  registration_.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<Point>>());
  registration_.align(output_);
  EXPECT_TRUE(registration_.hasConverged());
  EXPECT_FALSE(registration_.getCorrespondences()->empty());
  EXPECT_LT(registration_.getFitnessScore(0.01), 0.01);

  const auto nothing = pcl::make_shared<Cloud>();
  nothing->resize(10, Point(kNaN, kNaN, kNaN));
  registration_.setInputTarget(nothing);
  messagesOf([&] { registration_.align(output_); });
  EXPECT_FALSE(registration_.hasConverged());
}

TEST_F(StructuredScene, BadValuesAreReportedAndTheOldOneKept)
{
  registration_.setNormalRadius(0.3);
  registration_.setDensityRadius(0.05);
  registration_.setBinWidth(0.02);
  registration_.setTimeLimit(9);
  registration_.setGravity(Eigen::Vector3d(0, 0, 2), Eigen::Vector3d(0, 3, 0), 0.2);
  registration_.setNumberOfThreads(2);
  const auto refused = [&](auto setter) {
    const std::string messages = messagesOf(setter);
    EXPECT_THAT(messages, HasSubstr("the old value is kept"));
  };
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    refused([&] { registration_.setNormalRadius(bad); });
    refused([&] { registration_.setDensityRadius(bad); });
    refused([&] { registration_.setBinWidth(bad); });
    refused([&] { registration_.setTimeLimit(bad); });
    refused([&] { registration_.setGravity(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ(), bad); });
    refused([&] { registration_.setGravity(Eigen::Vector3d(bad, bad, bad) * 0, Eigen::Vector3d::UnitZ(), 0.1); });
  }
  refused([&] { registration_.setDensityRadius(1.5); });
  refused([&] { registration_.setSourceViewpoint(Eigen::Vector3d(0, std::nan(""), 0)); });
  refused([&] { registration_.setTargetViewpoint(Eigen::Vector3d(0, std::nan(""), 0)); });
  Options bad_options = registration_.getOptions();
  bad_options.min_confidence = 2;
  bad_options.bin_width = 0.5;
  refused([&] { registration_.setOptions(bad_options); });

  const Options options = registration_.getOptions();
  EXPECT_EQ(options.normal_radius, 0.3);
  EXPECT_EQ(options.density_radius, 0.05);
  EXPECT_EQ(options.bin_width, 0.02);
  EXPECT_EQ(options.time_limit, 9);
  EXPECT_EQ(options.threads, 2U);
  ASSERT_TRUE(options.gravity);
  EXPECT_TRUE(options.gravity->up_source.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(options.gravity->up_target.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(options.gravity->tolerance, 0.2);
  registration_.clearGravity();
  EXPECT_FALSE(registration_.getOptions().gravity);
  // 0 means: from the data, again.
  registration_.setNormalRadius(0);
  registration_.setDensityRadius(0);
  registration_.setBinWidth(0);
  EXPECT_EQ(registration_.getOptions().bin_width, 0);
}

TEST_F(StructuredScene, ProfileKeepsWhatWasSetByName)
{
  registration_.setBinWidth(0.02);
  registration_.setNumberOfThreads(2);
  registration_.setViewpointMode(ViewpointMode::Unknown);
  registration_.setRefinement(false);
  registration_.setProfile(Profile::Paper2017);
  const Options options = registration_.getOptions();
  EXPECT_EQ(options.profile, Profile::Paper2017);
  EXPECT_EQ(options.bin_width, 0.02);
  EXPECT_EQ(options.threads, 2U);
  EXPECT_EQ(options.viewpoint_mode, ViewpointMode::Unknown);
  EXPECT_FALSE(options.refine);
  registration_.setRefinement(true);
  registration_.setProfile(Profile::Default);
  EXPECT_TRUE(registration_.getOptions().refine);
}

TEST_F(StructuredScene, ProfileKeepsWhatWasSetOfTheSearch)
{
  registration_.setGuessTolerance(0.2, 3);
  Options options = registration_.getOptions();
  options.min_confidence = 0.9;
  options.max_candidates = 4;
  options.leaf = 0.04;
  registration_.setOptions(options);
  registration_.setMaximumIterations(12);
  registration_.setMaxCorrespondenceDistance(0.3);
  for (const Profile profile : {Profile::Paper2017, Profile::Default}) {
    registration_.setProfile(profile);
    const Options kept = registration_.getOptions();
    ASSERT_TRUE(kept.guess_tolerance);
    EXPECT_EQ(kept.guess_tolerance->rotation, 0.2);
    EXPECT_EQ(kept.guess_tolerance->translation, 3);
    EXPECT_EQ(kept.min_confidence, 0.9);
    EXPECT_EQ(kept.max_candidates, 4);
    EXPECT_EQ(kept.leaf, 0.04);
    EXPECT_EQ(kept.max_refinement_steps, 12);
    EXPECT_EQ(kept.overlap_radius, 0.3);
  }
}

TEST_F(StructuredScene, OptionsAndInheritedSettersAreOne)
{
  Options options = registration_.getOptions();
  EXPECT_EQ(registration_.getMaximumIterations(), options.max_refinement_steps);
  options.max_refinement_steps = 17;
  options.overlap_radius = 0.25;
  registration_.setOptions(options);
  EXPECT_EQ(registration_.getMaximumIterations(), 17);
  EXPECT_EQ(registration_.getMaxCorrespondenceDistance(), 0.25);
  registration_.setMaximumIterations(5);
  EXPECT_EQ(registration_.getOptions().max_refinement_steps, 5);
  registration_.setMaximumIterations(0);
  EXPECT_FALSE(registration_.getOptions().refine);
  options.overlap_radius = 0;
  registration_.setOptions(options);
  EXPECT_EQ(registration_.getOptions().overlap_radius, 0);
}

TEST_F(StructuredScene, SettingsWithoutEffectAreReportedOnce)
{
  setPair(true);
  EXPECT_EQ(messagesOf([&] { registration_.align(output_); }), "") << "defaults must not be reported";
  registration_.setTransformationEpsilon(1e-6);
  registration_.setTransformationRotationEpsilon(0.99);
  registration_.setEuclideanFitnessEpsilon(1e-3);
  registration_.setRANSACIterations(10);
  registration_.setRANSACOutlierRejectionThreshold(0.1);
  registration_.setTransformationEstimation(
      pcl::make_shared<pcl::registration::TransformationEstimationSVD<Point, Point>>());
  registration_.setCorrespondenceEstimation(
      pcl::make_shared<pcl::registration::CorrespondenceEstimation<Point, Point>>());
  registration_.setSearchMethodSource(pcl::make_shared<pcl::search::KdTree<Point>>());
  registration_.setMaxCorrespondenceDistance(-1);
  const std::string messages = messagesOf([&] { registration_.align(output_); });
  for (const char* name : {"setTransformationEpsilon",
                           "setTransformationRotationEpsilon",
                           "setEuclideanFitnessEpsilon",
                           "setRANSACIterations",
                           "setRANSACOutlierRejectionThreshold",
                           "setTransformationEstimation",
                           "setCorrespondenceEstimation",
                           "setSearchMethodSource",
                           "maximum correspondence distance"}) {
    EXPECT_THAT(messages, HasSubstr(name));
  }
  EXPECT_TRUE(registration_.hasConverged());
  EXPECT_EQ(messagesOf([&] { registration_.align(output_); }), "") << "once is enough";
}

TEST_F(StructuredScene, ViewpointIsTheSensorOriginOfTheCloud)
{
  // The clouds in frames that are not the sensor's, and PCL knowing where the sensor is.
  const auto& pair = roomPair<Point>(false);
  const Eigen::Isometry3d S = motion(0.7, Eigen::Vector3d(12, -7, 3));
  const Eigen::Isometry3d D = motion(-1.1, Eigen::Vector3d(-5, 4, 8));
  const auto source = movedBy(S, *pair.source);
  const auto target = movedBy(D, *pair.target);
  const Eigen::Isometry3d truth = D * pair.T_target_source * S.inverse();
  source->sensor_origin_.head<3>() = S.translation().cast<float>();
  target->sensor_origin_.head<3>() = D.translation().cast<float>();
  registration_.setInputSource(source);
  registration_.setInputTarget(target);
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged()) << registration_.getResult().message;
  EXPECT_THAT(registration_.getFinalTransformation(), IsPoseNear(truth, 0.2 * kDegree, 0.01));
  EXPECT_TRUE(registration_.getResult().source_viewpoint_used);
  EXPECT_TRUE(registration_.getResult().target_viewpoint_used);
  EXPECT_EQ(output_.sensor_origin_, source->sensor_origin_) << "PCL does not move it";

  // Given explicitly instead; PCL's field is wrong.
  source->sensor_origin_.setZero();
  target->sensor_origin_.setZero();
  registration_.setInputSource(source);
  registration_.setInputTarget(target);
  registration_.setSourceViewpoint(S.translation());
  registration_.setTargetViewpoint(D.translation());
  registration_.align(output_);
  ASSERT_TRUE(registration_.hasConverged()) << registration_.getResult().message;
  EXPECT_THAT(registration_.getFinalTransformation(), IsPoseNear(truth, 0.2 * kDegree, 0.01));
  EXPECT_TRUE(registration_.getResult().source_viewpoint_used);

  // Wrong and not given: it must be noticed.
  registration_.clearViewpoints();
  registration_.align(output_);
  EXPECT_TRUE(registration_.getResult().source_viewpoint_found);
  EXPECT_TRUE(registration_.getResult().target_viewpoint_found);
  if (registration_.hasConverged()) { // fewer certainties: it may be refused, but not be wrong
    EXPECT_THAT(registration_.getFinalTransformation(), IsPoseNear(truth, 0.2 * kDegree, 0.01));
  }
  registration_.setViewpointMode(ViewpointMode::Unused);
  registration_.setSourceViewpoint(S.translation());
  registration_.align(output_);
  EXPECT_FALSE(registration_.getResult().source_viewpoint_used);
}

TEST_F(StructuredScene, FieldsOfThePointTypeAreKept)
{
  const auto& intensity = roomPair<pcl::PointXYZI>(true);
  StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI> with_intensity;
  with_intensity.setInputSource(intensity.source);
  with_intensity.setInputTarget(intensity.target);
  pcl::PointCloud<pcl::PointXYZI> moved;
  with_intensity.align(moved);
  EXPECT_TRUE(with_intensity.hasConverged());
  ASSERT_EQ(moved.size(), intensity.source->size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    ASSERT_EQ(moved[i].intensity, static_cast<float>(3 * i)); // each third point is taken
  }

  const auto& colour = roomPair<pcl::PointXYZRGB>(true);
  StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB> with_colour;
  with_colour.setInputSource(colour.source);
  with_colour.setInputTarget(colour.target);
  pcl::PointCloud<pcl::PointXYZRGB> painted;
  with_colour.align(painted);
  EXPECT_TRUE(with_colour.hasConverged());
  ASSERT_EQ(painted.size(), colour.source->size());
  for (std::size_t i = 0; i < painted.size(); ++i) {
    ASSERT_EQ(painted[i].rgba, (*colour.source)[i].rgba);
  }
}

TEST_F(StructuredScene, NormalsOfThePointTypeMayBeMissingOrWrong)
{
  const auto& pair = roomPair<pcl::PointNormal>(false);
  for (const float value : {0.0F, kNaN}) {
    const auto source = copyOf(*pair.source);
    for (auto& point : *source) {
      point.getNormalVector3fMap().setConstant(value);
    }
    StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal> registration;
    registration.setInputSource(source);
    registration.setInputTarget(pair.target);
    pcl::PointCloud<pcl::PointNormal> output;
    registration.align(output);
    ASSERT_TRUE(registration.hasConverged()) << registration.getResult().message;
    EXPECT_THAT(registration.getFinalTransformation(), IsPoseNear(pair.T_target_source, 0.2 * kDegree, 0.01));
  }
}

TEST_F(StructuredScene, FloatAndDoubleAgree)
{
  setPair();
  registration_.align(output_);
  StructuredSceneRegistration<Point, Point, double> in_double;
  in_double.setInputSource(roomPair<Point>(false).source);
  in_double.setInputTarget(roomPair<Point>(false).target);
  in_double.align(output_);
  ASSERT_TRUE(registration_.hasConverged());
  ASSERT_TRUE(in_double.hasConverged());
  EXPECT_TRUE(sameBits(registration_.getFinalTransformation(),
                       Eigen::Matrix4f(in_double.getFinalTransformation().cast<float>())));
  const Eigen::Matrix3d R = in_double.getFinalTransformation().topLeftCorner<3, 3>();
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST_F(StructuredScene, SurveyCoordinates)
{
  // 1e6 m from the origin a float holds steps of 6 cm: the rounding is the error that remains.
  const auto& pair = roomPair<Point>(false);
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation() = Eigen::Vector3d(4e5, 1e6, 100);
  const auto source = movedBy(far, *pair.source);
  const auto target = movedBy(far, *pair.target);
  StructuredSceneRegistration<Point, Point, double> registration;
  registration.setInputSource(source);
  registration.setInputTarget(target);
  registration.setSourceViewpoint(far.translation());
  registration.setTargetViewpoint(far.translation());
  registration.align(output_);
  ASSERT_TRUE(registration.hasConverged()) << registration.getResult().message;
  const Eigen::Matrix4d near = far.inverse().matrix() * registration.getFinalTransformation() * far.matrix();
  EXPECT_THAT(near, IsPoseNear(pair.T_target_source, 0.5 * kDegree, 0.05));
}

TEST(FiniteQueryKdTreeThroughPcl, AnswersEveryQuery)
{
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->push_back(pcl::PointXYZ(1, 0, 0));
  cloud->push_back(pcl::PointXYZ(kNaN, 0, 0));
  cloud->push_back(pcl::PointXYZ(3, 0, 0));
  const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree = pcl::make_shared<FiniteQueryKdTree<pcl::PointXYZ>>();
  pcl::Indices indices;
  std::vector<float> distances;
  // Nothing indexed yet.
  EXPECT_EQ(tree->nearestKSearch(pcl::PointXYZ(0, 0, 0), 1, indices, distances), 0);
  EXPECT_EQ(distances, std::vector<float>{std::numeric_limits<float>::infinity()});
  tree->setInputCloud(cloud);
  EXPECT_EQ(tree->nearestKSearch(pcl::PointXYZ(2.5F, 0, 0), 1, indices, distances), 1);
  EXPECT_EQ(indices, pcl::Indices{2});
  EXPECT_FLOAT_EQ(distances[0], 0.25F);
  EXPECT_EQ(tree->radiusSearch(pcl::PointXYZ(2, 0, 0), 1.5, indices, distances), 2);
  for (const float bad : {kNaN, std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(tree->nearestKSearch(pcl::PointXYZ(bad, 0, 0), 2, indices, distances), 0);
    EXPECT_EQ(indices, (pcl::Indices{pcl::UNAVAILABLE, pcl::UNAVAILABLE}));
    EXPECT_EQ(distances[1], std::numeric_limits<float>::infinity());
    EXPECT_EQ(tree->radiusSearch(pcl::PointXYZ(0, bad, 0), 10, indices, distances), 0);
    EXPECT_TRUE(indices.empty());
  }
  // Only the point that is not finite is indexed.
  tree->setInputCloud(cloud, pcl::make_shared<pcl::Indices>(1, 1));
  EXPECT_EQ(tree->nearestKSearch(pcl::PointXYZ(0, 0, 0), 1, indices, distances), 0);
  EXPECT_EQ(tree->getInputCloud(), cloud);
}

} // namespace
} // namespace pcl_ssfr::test_pcl_contract
