// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/translation.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace pcl_ssfr::test_translation {
namespace {

/// Planes given by unit normal and distance; \p count points on each, 5 mm noise, spread over a few metres.
OrientedSamples
makePlanes(const std::vector<std::pair<Eigen::Vector3d, double>>& planes, int count, std::uint64_t seed)
{
  testing::Random random(seed);
  OrientedSamples samples;
  const auto total = static_cast<Eigen::Index>(planes.size()) * count;
  samples.points.resize(3, total);
  samples.normals.resize(3, total);
  samples.weights = Eigen::VectorXd::Ones(total);
  samples.extents = Eigen::VectorXd::Zero(total);
  Eigen::Index column = 0;
  for (const auto& [normal, distance] : planes) {
    const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    for (int i = 0; i < count; ++i, ++column) {
      samples.points.col(column) =
          (distance + 0.005 * random.gaussian()) * normal + random.uniform(-3, 3) * u + random.uniform(-3, 3) * v;
      samples.normals.col(column) = -normal;
    }
  }
  return samples;
}

OrientedSamples
makeRoom(std::uint64_t seed)
{
  return makePlanes({{Eigen::Vector3d::UnitX(), 2.0},
                     {Eigen::Vector3d::UnitX(), -3.1},
                     {Eigen::Vector3d::UnitX(), 0.7},
                     {Eigen::Vector3d::UnitY(), 1.5},
                     {Eigen::Vector3d::UnitY(), -4.2},
                     {Eigen::Vector3d::UnitZ(), 1.1},
                     {Eigen::Vector3d::UnitZ(), -1.4}},
                    800,
                    seed);
}

std::vector<MainNormal>
makeNormals(const std::vector<Eigen::Vector3d>& directions)
{
  std::vector<MainNormal> normals;
  normals.reserve(directions.size());
  for (const Eigen::Vector3d& direction : directions)
    normals.push_back({direction.normalized(), 10});
  return normals;
}

RotationCandidate
identityOn(int a, int b)
{
  RotationCandidate candidate;
  candidate.target_pair = {{a, b}};
  return candidate;
}

TEST(ComposeShifts, SolvesAnyIndependentAxes)
{
  testing::Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::Matrix3d axes;
    for (Eigen::Index k = 0; k < 3; ++k)
      axes.col(k) = testing::randomRotation(random).col(0);
    if (std::abs(axes.determinant()) < 0.05)
      continue;
    const Eigen::Vector3d t(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9));
    EXPECT_LT((composeShifts(axes, axes.transpose() * t) - t).norm(), 1e-11);
  }
}

TEST(ComposeShifts, RefusesDependentAxes)
{
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.col(2) = Eigen::Vector3d(1, 1, 0).normalized();
  EXPECT_THROW(composeShifts(axes, Eigen::Vector3d::Ones()), std::invalid_argument);
  EXPECT_THROW(composeShifts(Eigen::Matrix3d::Zero(), Eigen::Vector3d::Ones()), std::invalid_argument);
}

TEST(ChooseAxes, FirstModeTakesTheFirstIndependentNormal)
{
  const std::vector<MainNormal> normals =
      makeNormals({{1, 0, 0}, {0, 1, 0}, {-1, 0.1, 0}, {1, 1, 0}, {0.2, 0, 1}, {0, 0, 1}});
  const std::optional<Eigen::Matrix3d> axes = chooseAxes(identityOn(0, 1), normals, normals, TranslationOptions());
  ASSERT_TRUE(axes.has_value());
  EXPECT_EQ(axes->col(0), normals[0].direction);
  EXPECT_EQ(axes->col(1), normals[1].direction);
  EXPECT_EQ(axes->col(2), normals[4].direction); // 2 is parallel to a, 3 lies in the plane of a and b
}

TEST(ChooseAxes, FirstModeDropsTheCandidateWithoutAThirdDirection)
{
  const std::vector<MainNormal> normals = makeNormals({{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 1, 0}});
  EXPECT_FALSE(chooseAxes(identityOn(0, 1), normals, normals, TranslationOptions()).has_value());
}

TEST(ChooseAxes, CrossProductFallsBackAndPrefersTheBestMatch)
{
  TranslationOptions options;
  options.third_axis = TranslationOptions::ThirdAxis::CrossProduct;
  const std::vector<MainNormal> flat = makeNormals({{1, 0, 0}, {0, 1, 0}});
  std::optional<Eigen::Matrix3d> axes = chooseAxes(identityOn(0, 1), flat, flat, options);
  ASSERT_TRUE(axes.has_value());
  EXPECT_LT((axes->col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);

  // Two target normals near z; the source has the second one only.
  const std::vector<MainNormal> target = makeNormals({{1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0.4, 0, 1}});
  const std::vector<MainNormal> source = makeNormals({{1, 0, 0}, {0, 1, 0}, {0.41, 0, 1}});
  axes = chooseAxes(identityOn(0, 1), source, target, options);
  ASSERT_TRUE(axes.has_value());
  EXPECT_EQ(axes->col(2), target[3].direction);
}

TEST(ChooseAxes, CrossProductTakesNoNormalInThePlaneOfTheOthers)
{
  TranslationOptions options;
  options.third_axis = TranslationOptions::ThirdAxis::CrossProduct;
  options.cross_angle = 3.14; // [rad] forbids nothing
  const std::vector<MainNormal> flat = makeNormals({{1, 0, 0}, {0, 1, 0}, {1, 1, 1e-9}});
  std::optional<Eigen::Matrix3d> axes = chooseAxes(identityOn(0, 1), flat, flat, options);
  ASSERT_TRUE(axes.has_value());
  EXPECT_LT((axes->col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);

  const std::vector<MainNormal> oblique = makeNormals({{1, 0, 0}, {0, 1, 0}, {1, 1, 0.1}});
  axes = chooseAxes(identityOn(0, 1), oblique, oblique, options);
  ASSERT_TRUE(axes.has_value());
  EXPECT_EQ(axes->col(2), oblique[2].direction);
}

TEST(Translation, FoundToABinInARoom)
{
  const OrientedSamples source = makeRoom(1), other = makeRoom(2);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 1.234, -0.777, 0.456;
  const OrientedSamples target = transformSamples(other, T);
  const TranslationOptions options;
  const Translation coarse = estimateTranslation(source, target, Eigen::Matrix3d::Identity(), options);
  EXPECT_LT((coarse.t_target_source - T.translation()).cwiseAbs().maxCoeff(), 0.016);
  EXPECT_TRUE(coarse.observed[0] && coarse.observed[1] && coarse.observed[2]);

  // METHOD stage 13: bins of 0.15 mm under a mean filter of 1 cm.
  TranslationOptions fine = options;
  fine.histogram.bin_width = options.histogram.bin_width / 100;
  fine.correlation.envelope_half_window = 0;
  const Translation refined = estimateTranslation(
      source, target, Eigen::Matrix3d::Identity(), fine, &coarse, 1.5 * options.histogram.bin_width, 33);
  EXPECT_LT((refined.t_target_source - T.translation()).cwiseAbs().maxCoeff(), 0.001);
}

TEST(Translation, ObliqueAxesGiveTheSame)
{
  const Eigen::Vector3d oblique = Eigen::Vector3d(1, 1, 0.4).normalized();
  const auto scan = [&](std::uint64_t seed) {
    return makePlanes({{Eigen::Vector3d::UnitX(), 2.0},
                       {Eigen::Vector3d::UnitX(), -1.3},
                       {oblique, 1.5},
                       {oblique, -2.4},
                       {Eigen::Vector3d::UnitZ(), 1.1},
                       {Eigen::Vector3d::UnitZ(), -1.7}},
                      800,
                      seed);
  };
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << -0.4, 0.9, 1.3;
  Eigen::Matrix3d axes;
  axes << Eigen::Vector3d::UnitX(), oblique, Eigen::Vector3d::UnitZ();
  const Translation translation =
      estimateTranslation(scan(3), transformSamples(scan(4), T), axes, TranslationOptions());
  EXPECT_LT((translation.t_target_source - T.translation()).norm(), 0.05);
}

TEST(Translation, NoPlaneAlongAnAxisMeansNoMovementAlongIt)
{
  const auto corridor = [](std::uint64_t seed) {
    return makePlanes({{Eigen::Vector3d::UnitY(), 1.0},
                       {Eigen::Vector3d::UnitY(), -1.2},
                       {Eigen::Vector3d::UnitZ(), 1.3},
                       {Eigen::Vector3d::UnitZ(), -1.1}},
                      500,
                      seed);
  };
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 2, 0.3, -0.2;
  const TranslationOptions options;
  const Translation translation =
      estimateTranslation(corridor(5), transformSamples(corridor(6), T), Eigen::Matrix3d::Identity(), options);
  EXPECT_FALSE(translation.observed[0]);
  EXPECT_TRUE(translation.observed[1] && translation.observed[2]);
  EXPECT_EQ(translation.t_target_source.x(), 0);
  EXPECT_NEAR(translation.t_target_source.y(), 0.3, 0.016);
  const Translation again = estimateTranslation(
      corridor(5), transformSamples(corridor(6), T), Eigen::Matrix3d::Identity(), options, &translation, 0.02);
  EXPECT_FALSE(again.observed[0]);
}

TEST(Translation, EmptyIn)
{
  const OrientedSamples room = makeRoom(7);
  for (const Translation& translation :
       {estimateTranslation(OrientedSamples(), room, Eigen::Matrix3d::Identity(), TranslationOptions()),
        estimateTranslation(room, OrientedSamples(), Eigen::Matrix3d::Identity(), TranslationOptions())}) {
    EXPECT_TRUE(translation.t_target_source.isZero(0));
    EXPECT_FALSE(translation.observed[0] || translation.observed[1] || translation.observed[2]);
  }
}

TEST(TransformSamples, MovesPointsTurnsNormalsKeepsTheRest)
{
  testing::Random random(8);
  const OrientedSamples room = makeRoom(9);
  const Eigen::Isometry3d T = testing::randomMotion(random, 5);
  const OrientedSamples moved = transformSamples(room, T);
  EXPECT_LT((moved.points.col(17) - T * room.points.col(17)).norm(), 1e-12);
  EXPECT_LT((moved.normals.col(17) - T.linear() * room.normals.col(17)).norm(), 1e-12);
  EXPECT_EQ(moved.weights, room.weights);
  EXPECT_EQ(moved.extents, room.extents);
  const OrientedSamples back = transformSamples(moved, T.inverse());
  EXPECT_LT((back.points - room.points).norm(), 1e-9);
  EXPECT_LT((back.normals - room.normals).norm(), 1e-9);
  EXPECT_EQ(transformSamples(OrientedSamples(), T).size(), 0);
}

} // namespace
} // namespace pcl_ssfr::test_translation
