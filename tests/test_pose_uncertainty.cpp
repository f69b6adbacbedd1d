// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/pose_uncertainty.h"
#include "made_up_matches.h"
#include "patch_scenes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace pcl_ssfr::test_pose_uncertainty {
namespace {

using testing::hessianAbout;
using testing::Matches;
using testing::matchesOn;
using testing::Matrix6;
using testing::Random;
using testing::refinementOf;
using testing::Vector6;

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(), kZ = Eigen::Vector3d::UnitZ();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kFloor = 1e-6; // [m] no floor to speak of

/// Small patches of a scene with the errors of their distances: what a polish sees of it.
struct PatchedScene {
  int points = 20;            ///< of a patch
  double patch_offset = 0.01; ///< standard deviations: of a patch along its normal [m] ...
  double patch_tilt = 0.01;   ///< ... of its edges against its middle [m] ...
  double point_noise = 0.005; ///< ... and of each point [m]
  bool one_to_one = false;    ///< each patch meets one patch of the other scan; else each point meets another one
  std::vector<Eigen::Vector3d> centres, normals;
};

PatchedScene
sceneOfPatches(const std::vector<Eigen::Vector3d>& normals, int count, std::uint64_t seed)
{
  Random random(seed);
  PatchedScene scene;
  for (int i = 0; i < count; ++i) {
    scene.centres.emplace_back(random.uniform(-8, 8), random.uniform(-5, 5), random.uniform(-2, 2));
    scene.normals.push_back(normals[static_cast<std::size_t>(i) % normals.size()].normalized());
  }
  return scene;
}

/// What the least squares of a scene's distances with random errors give: how far they move the pose, and the polish.
struct Draw {
  Vector6 error;
  Refinement polish;
};

Draw
drawPolish(const PatchedScene& scene, Random& random)
{
  constexpr double kScale = 1e3; // [m] of the robust function: all weights are 1
  constexpr double kHalfWidth = 0.5;
  std::vector<Vector6> rows;
  std::vector<double> errors;
  Draw draw;
  Matches m;
  const auto total = static_cast<Eigen::Index>(scene.centres.size()) * scene.points;
  m.points.resize(3, total);
  m.normals.resize(3, total);
  for (std::size_t k = 0; k < scene.centres.size(); ++k) {
    const Eigen::Vector3d u = scene.normals[k].unitOrthogonal(), v = scene.normals[k].cross(u);
    const double offset = scene.patch_offset * random.gaussian();
    const double tilt_u = scene.patch_tilt * random.gaussian(), tilt_v = scene.patch_tilt * random.gaussian();
    for (int i = 0; i < scene.points; ++i) {
      const double a = random.uniform(-1, 1), b = random.uniform(-1, 1);
      const auto column = static_cast<Eigen::Index>(errors.size());
      m.points.col(column) = scene.centres[k] + kHalfWidth * (a * u + b * v);
      m.normals.col(column) = scene.normals[k];
      errors.push_back(offset + a * tilt_u + b * tilt_v + scene.point_noise * random.gaussian());
    }
  }
  const Eigen::Vector3d centre = m.points.rowwise().mean();
  Vector6 gradient = Vector6::Zero();
  for (Eigen::Index i = 0; i < total; ++i) {
    Vector6 row;
    row << (m.points.col(i) - centre).cross(m.normals.col(i)), m.normals.col(i);
    rows.push_back(row);
    gradient += errors[static_cast<std::size_t>(i)] * row;
  }
  draw.polish = refinementOf(m, centre);
  draw.error = -draw.polish.hessian.ldlt().solve(gradient);
  const std::size_t partners = scene.one_to_one ? scene.centres.size() : rows.size();
  EquationStatisticsSum sum(scene.centres.size(), partners, kScale);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t patch = i / static_cast<std::size_t>(scene.points);
    const auto column = static_cast<Eigen::Index>(i);
    sum.add(patch,
            scene.one_to_one ? patch : i,
            m.points.col(column) - centre,
            m.normals.col(column),
            errors[i] + rows[i].dot(draw.error),
            1,
            1);
  }
  draw.polish.statistics = sum.statistics();
  return draw;
}

/// Mean squared error over what is claimed, each of 1 where the claim is true.
struct Consistency {
  double all = 0, rotation = 0, translation = 0;
};

Consistency
consistencyOf(const PatchedScene& scene, std::uint64_t seed)
{
  constexpr int kDraws = 400;
  Random random(seed);
  Consistency mean;
  for (int i = 0; i < kDraws; ++i) {
    const Draw draw = drawPolish(scene, random);
    const Matrix6 covariance = poseUncertainty(draw.polish, kFloor).information.inverse();
    const auto normalised = [&](Eigen::Index first, Eigen::Index n) {
      const Eigen::VectorXd e = draw.error.segment(first, n);
      return e.dot(covariance.block(first, first, n, n).ldlt().solve(e)) / static_cast<double>(n) / kDraws;
    };
    mean.all += normalised(0, 6);
    mean.rotation += normalised(0, 3);
    mean.translation += normalised(3, 3);
  }
  return mean;
}

TEST(NoiseFloor, IsThatOfAllScansAndAShareOfTheNoiseOfTheMatches)
{
  UncertaintyConfig config;
  config.noise_floor = 0.003;
  config.patch_noise = 0.1;
  EXPECT_EQ(noiseFloor(config, 0), 0.003);
  EXPECT_NEAR(noiseFloor(config, 0.04), 0.005, 1e-15);
}

TEST(PoseCovariance, IsThatOfManyDraws)
{
  // Patches that err as a whole, among partners that do not: what is claimed is what is seen.
  const std::vector<std::vector<Eigen::Vector3d>> scenes = {{kX, kY, kZ}, {kX + 0.2 * kY, kY, kZ, kY + kZ}};
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    const Consistency mean = consistencyOf(sceneOfPatches(scenes[k], 120, 20 + k), 30 + k);
    EXPECT_NEAR(mean.all, 1, 0.25);
    EXPECT_NEAR(mean.rotation, 1, 0.25);
    EXPECT_NEAR(mean.translation, 1, 0.25);
  }
}

TEST(PoseCovariance, SaturatesWithTheNumberOfPoints)
{
  // Twenty times the points on patches that err as a whole tell no more of the pose.
  PatchedScene scene = sceneOfPatches({kX, kY, kZ}, 120, 22);
  scene.points = 10;
  Random random(32);
  const double few = poseUncertainty(drawPolish(scene, random).polish, kFloor).information.trace();
  scene.points = 200;
  const double many = poseUncertainty(drawPolish(scene, random).polish, kFloor).information.trace();
  EXPECT_LT(many, 1.6 * few);
  // Points that err independently do.
  scene.patch_offset = scene.patch_tilt = 0;
  const double independent = poseUncertainty(drawPolish(scene, random).polish, kFloor).information.trace();
  EXPECT_GT(independent, 20 * many);
}

TEST(PoseCovariance, IsAtMostTwiceTooLargeWhereEachPatchMeetsOneOnly)
{
  PatchedScene scene = sceneOfPatches({kX, kY, kZ}, 120, 23);
  scene.one_to_one = true;
  const Consistency mean = consistencyOf(scene, 33);
  EXPECT_GT(mean.all, 0.45);
  EXPECT_LT(mean.all, 0.7);
}

TEST(PoseCovariance, WhatPullsLessScattersAsMuch)
{
  // With half of the curvature the same scatter moves the pose twice as far.
  const Matches m = matchesOn({kX, kY, kZ}, 100, kX, 24);
  Refinement all = refinementOf(m);
  all.statistics.curvature *= 0.5;
  const Matrix6 half = poseUncertainty(all, kFloor).information.inverse();
  const Matrix6 whole = poseUncertainty(refinementOf(m), kFloor).information.inverse();
  EXPECT_TRUE(half.isApprox(4 * whole, 1e-6));
}

TEST(PoseInformation, AboutItsOwnCentreIsTheSame)
{
  const PoseUncertainty u =
      poseUncertainty(refinementOf(matchesOn({kX, kY, kZ}, 20, Eigen::Vector3d(30, -20, 5), 12)), 0.001);
  EXPECT_EQ(u.informationAbout(u.centre), u.information);
}

TEST(PoseCovariance, OfTheSameSceneTenTimesAsLarge)
{
  // All lengths grow, also those of the errors: rotations are known as well, translations ten times worse.
  Matches m = matchesOn({kX, {0.3, 1, 0}, {0, 0.2, 1}}, 50, Eigen::Vector3d::Zero(), 11);
  const PoseUncertainty small = poseUncertainty(refinementOf(m, 0.01), 0.001);
  m.points *= 10;
  const PoseUncertainty large = poseUncertainty(refinementOf(m, 0.1), 0.01);
  EXPECT_NEAR(large.largestRotationDeviation(), small.largestRotationDeviation(), 1e-9);
  const Matrix6 of_small = small.information.inverse(), of_large = large.information.inverse();
  EXPECT_TRUE(of_large.bottomRightCorner(3, 3).isApprox(100 * of_small.bottomRightCorner(3, 3), 1e-6));
  ASSERT_EQ(small.motions.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(large.motions[i].deviation, 10 * small.motions[i].deviation, 1e-9);
}

TEST(PoseCovariance, OfASceneInAnotherFrame)
{
  Random random(5);
  const Matches m = matchesOn({kX, kY, kZ - 0.3 * kX}, 80, kX, 6);
  const Matrix6 before = poseUncertainty(refinementOf(m), 0.001).information.inverse();
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 100);
    const Matrix6 after =
        poseUncertainty(refinementOf({T * m.points, T.linear() * m.normals}), 0.001).information.inverse();
    Matrix6 turn = Matrix6::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T.linear();
    EXPECT_TRUE(after.isApprox(turn * before * turn.transpose(), 1e-6));
  }
}

TEST(PoseInformation, AboutAnotherOriginIsThatOfTheAdjoint)
{
  Random random(7);
  const Matches m = matchesOn({kX, kY + kZ, kZ - 0.3 * kX}, 40, Eigen::Vector3d(3, -2, 1), 8);
  const PoseUncertainty a = poseUncertainty(refinementOf(m, Eigen::Vector3d(3, -2, 1)), 0.001);
  const PoseUncertainty b = poseUncertainty(refinementOf(m, Eigen::Vector3d(-7, 20, 4)), 0.001);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Vector3d origin(random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-50, 50));
    const Matrix6 information = a.informationAbout(origin);
    EXPECT_TRUE(information.isApprox(b.informationAbout(origin), 1e-6)); // whatever the centre
    // Matches that err independently: the sum about that origin, over their variance and that of the floor.
    const Matrix6 expected = hessianAbout(m, origin) / (0.01 * 0.01 + 0.001 * 0.001);
    EXPECT_LT((information - expected).norm(), 1e-9 * expected.norm());
    EXPECT_TRUE(information == information.transpose());
    // A motion about the centre is one about the origin with the translation that moves the centre alike.
    Matrix6 adjoint = Matrix6::Identity();
    for (int k = 0; k < 3; ++k)
      adjoint.bottomLeftCorner<3, 3>().col(k) = Eigen::Vector3d::Unit(k).cross(a.centre - origin);
    EXPECT_TRUE((adjoint.transpose() * a.information * adjoint).isApprox(information, 1e-9));
  }
  for (const double x : {1e6, 1e30})
    EXPECT_TRUE(a.informationAbout(Eigen::Vector3d::Constant(x)).allFinite());
}

TEST(PoseInformation, NoiseFloorBoundsIt)
{
  const Matches m = matchesOn({kX, kY, kZ}, 4, kX, 10);
  const PoseUncertainty exact = poseUncertainty(refinementOf(m, 0), 0.01); // an exact fit
  EXPECT_TRUE(exact.information.bottomRightCorner(3, 3).isApprox(4e4 * Eigen::Matrix3d::Identity(), 1e-9));
  EXPECT_TRUE(poseUncertainty(refinementOf(m, 0.02), 0.01).information.isApprox(exact.information / 5, 1e-9));
}

TEST(RotationDeviation, IsThatOfTheCovariance)
{
  for (const std::uint64_t seed : {12, 13, 14}) {
    const PoseUncertainty u =
        poseUncertainty(refinementOf(matchesOn({kX, kY, kZ}, 20, Eigen::Vector3d(30, -20, 5), seed)), 0.001);
    ASSERT_EQ(u.rotations.size(), 3U);
    for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(50, 40, -30)}) {
      const Eigen::Matrix3d rotation = u.informationAbout(origin).inverse().topLeftCorner<3, 3>();
      for (const PrincipalRotation& r : u.rotations)
        EXPECT_NEAR(r.axis.dot(rotation * r.axis), r.deviation * r.deviation, 1e-6 * r.deviation * r.deviation);
    }
    EXPECT_EQ(u.largestRotationDeviation(), u.rotations[0].deviation);
    EXPECT_GE(u.rotations[0].deviation, u.rotations[1].deviation);
    EXPECT_LE(u.rotations[0].strength, u.rotations[1].strength);
    EXPECT_DOUBLE_EQ(u.rotations[2].strength, 1);
  }
}

TEST(RotationDeviation, APriorTellsTheAxesThatItBinds)
{
  const Refinement level = refinementOf(matchesOn({kX, kY}, 100, kX, 12), 1); // heights are open, rotations are known
  const double before = poseUncertainty(level, kFloor).largestRotationDeviation();
  const double rough = 10 * before, exact = 0.1 * before;
  const auto with = [&](double deviation) {
    return poseUncertainty(level, kFloor, Eigen::Matrix3d::Identity() / (deviation * deviation))
        .largestRotationDeviation();
  };
  EXPECT_NEAR(with(rough), before, 0.01 * before);
  EXPECT_NEAR(with(exact), exact, 0.01 * exact);
  // One plane leaves the rotation about its normal open; a prior of the others does not tell it.
  const Refinement plane = refinementOf(matchesOn({kZ}, 100, kX, 13), 1);
  const Eigen::Matrix3d vertical = 1e6 * (Eigen::Matrix3d::Identity() - kZ * kZ.transpose());
  EXPECT_EQ(poseUncertainty(plane, kFloor, vertical).largestRotationDeviation(), kInfinite);
  const PoseUncertainty known = poseUncertainty(plane, kFloor, 1e6 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(known.largestRotationDeviation(), 1e-3, 1e-5);
  ASSERT_EQ(known.motions.size(), 6U);
  EXPECT_EQ(known.motions[0].deviation, kInfinite); // not where along the plane
  EXPECT_NEAR(known.motions[0].motion.segment<2>(3).norm(), known.motions[0].motion.norm(), 1e-6);
}

TEST(PrincipalMotions, AreOrderedAndIndependent)
{
  Random random(8);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Eigen::Vector3d> normals(4);
    for (Eigen::Vector3d& n : normals)
      n = Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const Matches m = matchesOn(normals, 30, Eigen::Vector3d::Zero(), 100 + static_cast<std::uint64_t>(trial));
    const PoseUncertainty u = poseUncertainty(refinementOf(m, {0.1, 0.2, 0.3}), 0.001);
    ASSERT_EQ(u.motions.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i) {
      const Vector6& motion = u.motions[i].motion;
      EXPECT_NEAR(1 / std::sqrt(motion.dot(u.information * motion)), u.motions[i].deviation, 1e-9);
      EXPECT_TRUE(i == 0 || u.motions[i].deviation <= u.motions[i - 1].deviation);
      for (std::size_t k = 0; k < i; ++k)
        EXPECT_NEAR(motion.dot(u.information * u.motions[k].motion), 0, 1e-6 * u.information.norm());
    }
  }
}

TEST(PrincipalMotions, AlongTheCorridorFirst)
{
  // Floor and walls, a few places on its end: the way along the corridor is known least, and nothing else moves with
  // it.
  Matches m = matchesOn({kZ, kY}, 400, Eigen::Vector3d::Zero(), 3);
  const Matches end = matchesOn({kX}, 4, Eigen::Vector3d::Zero(), 4);
  m.points.conservativeResize(3, 804);
  m.normals.conservativeResize(3, 804);
  m.points.rightCols(4) = end.points;
  m.normals.rightCols(4) = end.normals;
  const PoseUncertainty u = poseUncertainty(refinementOf(m, Eigen::Vector3d::Zero()), 0.001);
  ASSERT_EQ(u.motions.size(), 6U);
  EXPECT_GT(u.motions[0].deviation, 4 * u.motions[1].deviation);
  EXPECT_NEAR(u.motions[0].deviation, 0.005, 0.001); // four matches, 1 cm each
  EXPECT_GT(std::abs(u.motions[0].motion[3]), 0.95);
  EXPECT_LT(u.motions[0].motion.head<3>().norm() * 5, 0.3); // at the ends of the corridor [m]
  // And it is the one that is explored.
  const double deviation = 0.5 * u.motions[0].deviation;
  ASSERT_EQ(motionsToExplore(u, deviation).size(), 1U);
  EXPECT_EQ(motionsToExplore(u, deviation)[0].motion, u.motions[0].motion);
  EXPECT_TRUE(motionsToExplore(u, 3 * deviation).empty()); // not enough in a larger scene
}

TEST(UnobservableDirections, NoneInARoom)
{
  EXPECT_TRUE(unobservableDirections(poseUncertainty(refinementOf(matchesOn({kX, kY, kZ}, 50, kX, 1)), 0.001)).empty());
}

TEST(UnobservableDirections, AlongTheCorridor)
{
  Random random(5);
  const Matches m = matchesOn({kY, kZ}, 80, kX, 6);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 100);
    const PoseUncertainty u = poseUncertainty(refinementOf({T * m.points, T.linear() * m.normals}), 0.001);
    const std::vector<UnobservableDirection> open = unobservableDirections(u);
    ASSERT_EQ(open.size(), 1U);
    EXPECT_FALSE(open[0].rotation);
    EXPECT_NEAR(std::abs(open[0].direction.dot(T.linear() * kX)), 1, 1e-6);
    EXPECT_NEAR(open[0].strength, 0, 1e-9);
    EXPECT_EQ(u.motions[0].deviation, kInfinite);
    EXPECT_LT(u.motions[1].deviation, 0.1);
  }
}

TEST(UnobservableDirections, AlongTheCorridorThoughThePatternsOfItsRaysMatch)
{
  // Walls, floor and ceiling, and a few small patches across that do not face their sensors.
  const Matches walls = matchesOn({kY, kZ}, 80, kX, 6), across = matchesOn({kX}, 2, kX, 7);
  Matches all;
  all.points.resize(3, walls.points.cols() + across.points.cols());
  all.points << walls.points, across.points;
  all.normals.resize(3, all.points.cols());
  all.normals << walls.normals, across.normals;
  Refinement polish = refinementOf(all);
  constexpr double kShare = 0.1;
  EquationStatisticsSum sum(
      static_cast<std::size_t>(all.points.cols()), static_cast<std::size_t>(all.points.cols()), 1);
  for (Eigen::Index i = 0; i < all.points.cols(); ++i)
    sum.add(static_cast<std::size_t>(i),
            static_cast<std::size_t>(i),
            all.points.col(i),
            all.normals.col(i),
            0,
            1,
            i < walls.points.cols() ? 1 : kShare);
  polish.statistics = sum.statistics();
  EXPECT_TRUE(unobservableDirections(poseUncertainty(polish, 0.001)).empty());
  const PoseUncertainty u = poseUncertainty(polish, 0.001, Eigen::Matrix3d::Zero(), true);
  const std::vector<UnobservableDirection> open = unobservableDirections(u);
  ASSERT_EQ(open.size(), 1U);
  EXPECT_FALSE(open[0].rotation);
  EXPECT_GT(std::abs(open[0].direction.dot(kX)), 0.999);
  EXPECT_NEAR(open[0].strength, kShare * poseUncertainty(polish, 0.001).translations[0].strength, 1e-3);
}

TEST(UnobservableDirections, OnOnePlane)
{
  const PoseUncertainty u = poseUncertainty(refinementOf(matchesOn({kZ}, 50, kX, 3)), 0.001);
  const std::vector<UnobservableDirection> open = unobservableDirections(u);
  ASSERT_EQ(open.size(), 3U); // two translations within it and the rotation about its normal
  for (const UnobservableDirection& d : open) {
    EXPECT_NEAR(d.direction.norm(), 1, 1e-9);
    EXPECT_NEAR(std::abs(d.direction.z()), d.rotation ? 1 : 0, 1e-6);
    EXPECT_EQ(d.strength, 0);
  }
  EXPECT_TRUE(open[2].rotation);
  // The motions say so as well, and keep what is known.
  ASSERT_EQ(u.motions.size(), 6U);
  Vector6 moved_freely = Vector6::Zero(), variances = Vector6::Zero();
  for (const PrincipalMotion& m : u.motions)
    if (std::isinf(m.deviation))
      moved_freely += m.motion.cwiseAbs2();
    else
      variances += m.deviation * m.deviation * m.motion.cwiseAbs2();
  for (const int i : {2, 3, 4})
    EXPECT_GT(moved_freely[i], 1e-3);
  for (const int i : {0, 1, 5}) {
    EXPECT_LT(moved_freely[i], 1e-11);
    EXPECT_GT(variances[i], 0);
    EXPECT_LT(variances[i], 1e-3);
  }
  EXPECT_TRUE(u.information.allFinite());
}

TEST(UnobservableDirections, AWeakTranslationIsARelativeMatter)
{
  Matches m = matchesOn({kY, kZ}, 500, kX, 4);
  m.normals.col(0) = kX;                       // one of 1000 matches faces x
  for (const double deviation : {1e-4, 0.1}) { // however exact the matches are
    const PoseUncertainty u = poseUncertainty(refinementOf(m, deviation), kFloor);
    UncertaintyConfig bounds;
    bounds.min_translation = 0.0019;
    EXPECT_TRUE(unobservableDirections(u, bounds).empty());
    bounds.min_translation = 0.0021;
    const std::vector<UnobservableDirection> open = unobservableDirections(u, bounds);
    ASSERT_EQ(open.size(), 1U);
    EXPECT_NEAR(open[0].strength, 1.0 / 500, 1e-4);
  }
}

TEST(UnobservableDirections, ARotationIsAMatterOfDegrees)
{
  const Matches m = matchesOn({kX, kY, kZ}, 50, kX, 14);
  const double deviation = poseUncertainty(refinementOf(m, 1), kFloor).largestRotationDeviation();
  UncertaintyConfig bounds;
  bounds.max_rotation = 1.01 * deviation;
  EXPECT_TRUE(unobservableDirections(poseUncertainty(refinementOf(m, 1), kFloor), bounds).empty());
  bounds.max_rotation = 0.99 * deviation;
  const std::vector<UnobservableDirection> open =
      unobservableDirections(poseUncertainty(refinementOf(m, 1), kFloor), bounds);
  ASSERT_EQ(open.size(), 1U);
  EXPECT_TRUE(open[0].rotation);
  EXPECT_GT(open[0].strength, 0);
}

TEST(PoseUncertainty, OfNothing)
{
  Refinement no_information;
  no_information.matches = 5;
  Refinement broken = refinementOf(matchesOn({kX, kY, kZ}, 50, kX, 14));
  broken.hessian(0, 0) = broken.statistics.curvature(0, 0) = std::numeric_limits<double>::quiet_NaN();
  for (const Refinement& polish : {Refinement(), no_information, broken}) {
    const PoseUncertainty u = poseUncertainty(polish, 0.001);
    EXPECT_TRUE(u.information.isZero(0));
    EXPECT_TRUE(u.motions.empty() && u.rotations.empty() && u.translations.empty());
    EXPECT_EQ(u.largestRotationDeviation(), kInfinite);
    EXPECT_TRUE(unobservableDirections(u).empty());
  }
}

} // namespace
} // namespace pcl_ssfr::test_pose_uncertainty
