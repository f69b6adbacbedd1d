// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Every precompiled instantiation links and works; no template code of the class is compiled here.

#include "pcl_clouds.h"
#include "pose_matchers.h"

#include <pcl_ssfr/structured_scene_registration.h>

#include <gtest/gtest.h>

namespace pcl_ssfr {
namespace {

using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::makeRoomPair;
using pcl_ssfr::testing::ScanPair;

template <typename Method>
class Instantiations : public ::testing::Test {};

template <typename PointT, typename Scalar>
using Ssfr = StructuredSceneRegistration<PointT, PointT, Scalar>;

using Methods = ::testing::Types<Ssfr<pcl::PointXYZ, float>,
                                 Ssfr<pcl::PointXYZ, double>,
                                 Ssfr<pcl::PointXYZI, float>,
                                 Ssfr<pcl::PointXYZI, double>,
                                 Ssfr<pcl::PointXYZRGB, float>,
                                 Ssfr<pcl::PointXYZRGB, double>,
                                 Ssfr<pcl::PointNormal, float>,
                                 Ssfr<pcl::PointNormal, double>,
                                 Ssfr<pcl::PointXYZINormal, float>,
                                 Ssfr<pcl::PointXYZINormal, double>>;
TYPED_TEST_SUITE(Instantiations, Methods);

TYPED_TEST(Instantiations, LinksAndAligns)
{
  using Point = typename TypeParam::PointCloudSource::PointType;
  static const ScanPair<Point> pair = makeRoomPair<Point>(false);
  const typename TypeParam::Ptr registration = pcl::make_shared<TypeParam>();
  registration->setInputSource(pair.source);
  registration->setInputTarget(pair.target);
  typename TypeParam::PointCloudSource output;
  registration->align(output);
  ASSERT_TRUE(registration->hasConverged()) << registration->getResult().message;
  EXPECT_THAT(registration->getFinalTransformation(), IsPoseNear(pair.T_target_source, 0.0035, 0.01));
}

} // namespace
} // namespace pcl_ssfr
