// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/gaussian_sphere.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pcl_ssfr::test_gaussian_sphere {
namespace {

OrientedSamples
makeSamples(const Points3& normals, bool oriented)
{
  OrientedSamples samples;
  samples.points = Points3::Zero(3, normals.cols());
  samples.normals = normals;
  samples.weights = Eigen::VectorXd::LinSpaced(normals.cols(), 1, static_cast<double>(normals.cols()));
  samples.extents = Eigen::VectorXd::Zero(normals.cols());
  samples.oriented = oriented;
  return samples;
}

TEST(GaussianSphere, KeepsDirectionsAndWeights)
{
  Points3 normals(3, 2);
  normals << 0, 1, 0, 0, -1, 0;
  const DirectionSet image = makeGaussianSphere(makeSamples(normals, true));
  ASSERT_EQ(image.size(), 2);
  EXPECT_EQ(image.directions, normals);
  EXPECT_EQ(image.weights[0], 1);
  EXPECT_EQ(image.weights[1], 2);
}

TEST(GaussianSphere, UnorientedSamplesGiveBothSigns)
{
  testing::Random random(1);
  Points3 normals(3, 20);
  for (Eigen::Index i = 0; i < normals.cols(); ++i)
    normals.col(i) = testing::randomRotation(random).col(0);
  const OrientedSamples samples = makeSamples(normals, false);
  const DirectionSet image = makeGaussianSphere(samples);
  ASSERT_EQ(image.size(), 40);
  // Flipping the sign of a normal leaves the same set of weighted directions.
  EXPECT_NEAR((image.directions * image.weights).norm(), 0, 1e-12);
  for (Eigen::Index i = 0; i < 20; ++i) {
    EXPECT_EQ(image.directions.col(2 * i), -image.directions.col(2 * i + 1));
    EXPECT_EQ(image.weights[2 * i], samples.weights[i]);
    EXPECT_EQ(image.weights[2 * i + 1], samples.weights[i]);
  }
}

TEST(GaussianSphere, DropsWhatIsNoUnitVectorAndNormalisesTheRest)
{
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Points3 normals(3, 5);
  normals.col(0) << 0, 0, 0;
  normals.col(1) << kNan, 0, 1;
  normals.col(2) << 0, 0, 1.0005;
  normals.col(3) << 0, 0.9, 0;
  normals.col(4) << std::numeric_limits<double>::infinity(), 0, 0;
  const DirectionSet image = makeGaussianSphere(makeSamples(normals, true));
  ASSERT_EQ(image.size(), 1);
  EXPECT_EQ(image.weights.size(), 1);
  EXPECT_EQ(image.weights[0], 3);
  EXPECT_DOUBLE_EQ(image.directions.col(0).norm(), 1);
}

TEST(GaussianSphere, EmptyInEmptyOut)
{
  EXPECT_EQ(makeGaussianSphere(OrientedSamples()).size(), 0);
}

TEST(GaussianSphere, ChordsOfAngles)
{
  const double pi = std::acos(-1.0);
  EXPECT_NEAR(chordFromAngle(pi / 3), 1, 1e-15);
  EXPECT_NEAR(chordFromAngle(pi), 2, 1e-15);
  EXPECT_EQ(chordFromAngle(0), 0);
  for (const double angle : {1e-9, 0.01, 0.5, 2.0, 3.0}) {
    const Eigen::Vector3d a = Eigen::Vector3d::UnitX(), b(std::cos(angle), std::sin(angle), 0);
    EXPECT_NEAR(chordFromAngle(angle), (a - b).norm(), 1e-12);
  }
}

} // namespace
} // namespace pcl_ssfr::test_gaussian_sphere
