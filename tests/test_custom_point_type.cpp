// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// A point type of the user's, for which neither PCL nor this library is precompiled.

#define PCL_NO_PRECOMPILE

#include "pcl_clouds.h"
#include "pose_matchers.h"

#include <pcl_ssfr/structured_scene_registration.h>

#include <pcl/register_point_struct.h>

#include <gtest/gtest.h>

#include <cstdint>

/// As spinning LiDARs give it, fields in an order of their own.
struct EIGEN_ALIGN16 RingPoint {
  double time;
  PCL_ADD_POINT4D;
  std::uint16_t ring;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

// clang-format off
POINT_CLOUD_REGISTER_POINT_STRUCT(RingPoint,
                                  (double, time, time)
                                  (float, x, x)(float, y, y)(float, z, z)
                                  (std::uint16_t, ring, ring))
// clang-format on

template class pcl_ssfr::StructuredSceneRegistration<RingPoint, RingPoint, float>; // all of it must compile

namespace pcl_ssfr {
namespace {

using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::makeRoomPair;
using pcl_ssfr::testing::ScanPair;

pcl::PointCloud<RingPoint>::Ptr
withRings(const pcl::PointCloud<pcl::PointXYZ>& cloud)
{
  auto result = pcl::make_shared<pcl::PointCloud<RingPoint>>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    RingPoint point{};
    point.getVector3fMap() = cloud[i].getVector3fMap();
    point.ring = static_cast<std::uint16_t>(i % 64);
    point.time = 0.5 * static_cast<double>(i);
    result->push_back(point);
  }
  return result;
}

TEST(CustomPointType, IsRegisteredAndKeepsItsFields)
{
  const ScanPair<pcl::PointXYZ> pair = makeRoomPair<pcl::PointXYZ>(false);
  const auto source = withRings(*pair.source);
  StructuredSceneRegistration<RingPoint, RingPoint> registration;
  registration.setInputSource(source);
  registration.setInputTarget(withRings(*pair.target));
  pcl::PointCloud<RingPoint> output;
  registration.align(output);
  ASSERT_TRUE(registration.hasConverged()) << registration.getResult().message;
  EXPECT_THAT(registration.getFinalTransformation(), IsPoseNear(pair.T_target_source, 0.0035, 0.01));
  ASSERT_EQ(output.size(), source->size());
  for (std::size_t i = 0; i < output.size(); ++i) {
    ASSERT_EQ(output[i].ring, i % 64);
    ASSERT_EQ(output[i].time, 0.5 * static_cast<double>(i));
  }
  EXPECT_LT(registration.getFitnessScore(0.01), 0.01);

  // The same answer as for the precompiled type: only the layout differs.
  StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ> plain;
  plain.setInputSource(pair.source);
  plain.setInputTarget(pair.target);
  pcl::PointCloud<pcl::PointXYZ> plain_output;
  plain.align(plain_output);
  EXPECT_EQ(registration.getFinalTransformation(), plain.getFinalTransformation());
  EXPECT_EQ(registration.getCorrespondences()->size(), plain.getCorrespondences()->size());
}

} // namespace
} // namespace pcl_ssfr
