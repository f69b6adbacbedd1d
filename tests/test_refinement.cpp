// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "pose_matchers.h"
#include "refinement/refinement.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>

namespace pcl_ssfr::test_refinement {
namespace {

using testing::addPatch;
using testing::IsPoseNear;
using testing::kMaxFloat;
using testing::kNan;
using testing::viewOfPoints;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kLeaf = 0.04;
constexpr double kThickness = 1e-4; // exact planes only: no patch that rounds a corner

/// A scan of exact planes, as the refinement takes it.
struct Scan {
  ThinnedCloud cloud;
  PlanarPatches patches;
  PatchIndex index;
  SurfacePoints surface;
};

/// The room seen from a pose, in the frame of the sensor there; \p seed draws the points.
Scan
makeScan(const std::vector<testing::Rectangle>& rectangles, const Eigen::Isometry3d& T_world_sensor, std::uint64_t seed)
{
  const Eigen::Matrix3Xf points =
      testing::transformed(T_world_sensor.inverse(), testing::samplePoints(rectangles, 600, seed));
  Scan scan;
  scan.cloud = thinScan(viewOfPoints(points), kLeaf, Eigen::Vector3d::Zero());
  const Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  PatchConfig options;
  options.range_noise = 0;
  options.coarsest_level = 5;
  scan.patches = extractPatches(scan.cloud, &viewpoint, kThickness, options);
  scan.index = PatchIndex(scan.patches, 0.4);
  scan.surface = drawSurfacePoints(scan.cloud, scan.patches, 6, 1000000);
  return scan;
}

Eigen::Isometry3d
smallMotion(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& shift)
{
  Vector6 motion;
  motion << angle * axis.normalized(), shift;
  return expSe3(motion);
}

RefinementOptions
options()
{
  RefinementOptions o;
  o.match.distance = 0.4f;
  o.final_distance = 0.03;
  o.steps = 20;
  return o;
}

class RefinementOfTheRoom : public ::testing::Test {
protected:
  const Eigen::Isometry3d T_world_target_ =
      smallMotion(0.4, Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(0.2, 0.1, 0.1));
  const Eigen::Isometry3d T_world_source_ =
      smallMotion(-1.1, Eigen::Vector3d(0.1, -0.1, 1), Eigen::Vector3d(-0.5, -0.3, 0.2));
  const Scan target_ = makeScan(testing::roomRectangles(), T_world_target_, 1);
  const Scan source_ = makeScan(testing::roomRectangles(), T_world_source_, 2);
  const Eigen::Isometry3d truth_ = testing::relativePose(T_world_target_, T_world_source_);
};

TEST(ExpSe3, ByHand)
{
  Vector6 motion = Vector6::Zero();
  EXPECT_TRUE(expSe3(motion).isApprox(Eigen::Isometry3d::Identity()));
  motion << 0, 0, std::acos(-1.0) / 2, 1, 2, 3;
  EXPECT_TRUE((expSe3(motion) * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3), 1e-12));
  motion.head<3>() *= 1e-200;
  EXPECT_TRUE(testing::isRigid(expSe3(motion), 1e-12));
}

TEST_F(RefinementOfTheRoom, PatchesRecoverASmallMotion)
{
  testing::Random random(3);
  for (int trial = 0; trial < 8; ++trial) {
    const Eigen::Isometry3d start =
        smallMotion(0.04, testing::randomRotation(random).col(0), 0.12 * testing::randomRotation(random).col(0)) *
        truth_;
    const Refinement refined = refinePatches(source_.patches, target_.index, start, options());
    EXPECT_THAT(refined.T_target_source, IsPoseNear(truth_, 1e-3, 1e-3)) << trial;
    EXPECT_LT(refined.rms, 1e-3);
    EXPECT_GT(refined.matches, source_.patches.size() / 2);
    EXPECT_GE(refined.steps, 2);
    EXPECT_LE(refined.steps, 20);
  }
}

TEST_F(RefinementOfTheRoom, EndsAfterTheStepInWhichTimeRanOut)
{
  const Eigen::Isometry3d start = smallMotion(0.02, Eigen::Vector3d::UnitZ(), Eigen::Vector3d(0.05, 0, 0)) * truth_;
  RefinementOptions late = options();
  late.deadline = Deadline::after(1e-9);
  const Refinement ended = refinePatches(source_.patches, target_.index, start, late);
  EXPECT_EQ(ended.steps, 1);
  EXPECT_GT(ended.matches, 0);
  EXPECT_TRUE(testing::isRigid(ended.T_target_source, 1e-9));
}

TEST_F(RefinementOfTheRoom, MutualPolishRecoversASmallMotion)
{
  testing::Random random(4);
  for (int trial = 0; trial < 8; ++trial) {
    const Eigen::Isometry3d start =
        smallMotion(0.03, testing::randomRotation(random).col(0), 0.1 * testing::randomRotation(random).col(0)) *
        truth_;
    const Refinement refined =
        refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, start, options());
    EXPECT_THAT(refined.T_target_source, IsPoseNear(truth_, 1e-3, 1e-3)) << trial;
    // The roles change, the answer does not.
    const Refinement back =
        refineMutual({target_.surface, target_.index}, {source_.surface, source_.index}, start.inverse(), options());
    EXPECT_THAT(back.T_target_source.inverse(), IsPoseNear(refined.T_target_source, 1e-4, 1e-4)) << trial;
  }
}

TEST_F(RefinementOfTheRoom, EitherHalfOfThePolishIsEnough)
{
  // One point in one scan: all comes from the points of the other, onto moving planes or onto fixed ones.
  ASSERT_GT(source_.surface.points.cols(), 1);
  ASSERT_GT(target_.surface.points.cols(), 1);
  const Eigen::Isometry3d start =
      smallMotion(0.02, Eigen::Vector3d(1, -2, 1), Eigen::Vector3d(0.05, 0.04, -0.06)) * truth_;
  const auto firstOf = [](const SurfacePoints& all) {
    return SurfacePoints{all.points.leftCols(1), all.normals.leftCols(1), {all.patches.front()}, all.facing};
  };
  const SurfacePoints one_source = firstOf(source_.surface), one_target = firstOf(target_.surface);
  const Refinement by_target =
      refineMutual({one_source, source_.index}, {target_.surface, target_.index}, start, options());
  const Refinement by_source =
      refineMutual({source_.surface, source_.index}, {one_target, target_.index}, start, options());
  const Refinement by_both =
      refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, start, options());
  for (const Refinement* refined : {&by_target, &by_source, &by_both}) {
    EXPECT_THAT(refined->T_target_source, IsPoseNear(truth_, 1e-3, 1e-3));
  }
  EXPECT_NEAR(static_cast<double>(by_both.matches), static_cast<double>(by_target.matches + by_source.matches), 3);
}

TEST_F(RefinementOfTheRoom, ThePolishSumsOverThePointsOfBothScans)
{
  // More points than a block holds, a different number in each scan; the oracle takes them one by one.
  const SurfacePoints source = drawSurfacePoints(source_.cloud, source_.patches, 150, 1000000);
  const SurfacePoints target = drawSurfacePoints(target_.cloud, target_.patches, 220, 1000000);
  ASSERT_GT(source.points.cols(), 600);
  ASSERT_GT(target.points.cols(), source.points.cols() + 300);
  RefinementOptions one_step = options();
  one_step.steps = 1;
  one_step.match.distance = 0.2f;
  const Eigen::Isometry3d T = smallMotion(0.02, Eigen::Vector3d(1, -2, 1), Eigen::Vector3d(0.05, 0.04, -0.06)) * truth_;
  const Refinement refined = refineMutual({source, source_.index}, {target, target_.index}, T, one_step);

  Matrix6 hessian = Matrix6::Zero();
  double weight = 0;
  int matches = 0;
  const double square = std::pow(0.5 * static_cast<double>(one_step.match.distance), 2); // of the robust weight's scale
  const auto add = [&](const SurfacePoints& points, const Eigen::Isometry3d& T_moved, const PatchIndex& planes) {
    const bool is_source = &points == &source;
    for (Eigen::Index i = 0; i < points.points.cols(); ++i) {
      const Eigen::Vector3d p = T_moved * points.points.col(i).cast<double>();
      const Eigen::Vector3d n = T_moved.linear() * points.normals.col(i).cast<double>();
      const int match = planes.find(p.cast<float>(), n.cast<float>(), one_step.match);
      if (match < 0)
        continue;
      const PatchIndex::Meeting at = planes.meet(match, p);
      const Eigen::Vector3d place = is_source ? p : Eigen::Vector3d(points.points.col(i).cast<double>());
      const Eigen::Vector3d normal = is_source ? at.normal : Eigen::Vector3d(T.linear() * at.normal);
      Vector6 row;
      row << (place - refined.centre).cross(normal), normal;
      const double w = std::pow(square / (square + at.distance * at.distance), 2) / at.variance;
      hessian += w * row * row.transpose();
      weight += w;
      ++matches;
    }
  };
  add(source, T, target_.index);
  add(target, T.inverse(), source_.index);
  EXPECT_GT(matches, 1000);
  EXPECT_NEAR(
      static_cast<double>(refined.matches), static_cast<double>(matches), 2); // rounding at the bounds of a match
  EXPECT_NEAR(refined.hessian.bottomRightCorner(3, 3).trace(), weight, 1e-3 * weight);
  EXPECT_LT((refined.hessian - hessian).norm(), 1e-3 * hessian.norm()) << refined.hessian << "\n\n" << hessian;
}

NoiseRule
ruleWithin(double least, double most)
{
  NoiseRule rule;
  rule.least = least;
  rule.most = most;
  return rule;
}

TEST_F(RefinementOfTheRoom, AFitSumsOverThePointsOfBothScans)
{
  // As wide a scale as the distances allow: that of a single step of the polish.
  RefinementOptions wide = options();
  wide.match.distance = 0.2f;
  wide.final_distance = 0.2;
  wide.steps = 1;
  const Eigen::Isometry3d T = smallMotion(0.02, Eigen::Vector3d(1, -2, 1), Eigen::Vector3d(0.05, 0.04, -0.06)) * truth_;
  const Refinement step = refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, T, wide);
  const MutualFit fit =
      fitMutual({source_.surface, source_.index}, {target_.surface, target_.index}, T, wide, ruleWithin(0.2, 0.2));
  EXPECT_GT(fit.refinement.matches, 100);
  EXPECT_EQ(fit.refinement.matches, step.matches);
  EXPECT_NEAR(fit.match_distance, 0.2, 1e-6);
  EXPECT_NEAR(fit.refinement.rms, step.rms, 1e-6 * step.rms); // the distance is a float
  EXPECT_TRUE(fit.refinement.hessian.isApprox(step.hessian, 1e-6));
  // The step that was made solves the equations.
  const Eigen::Isometry3d moved = step.T_target_source * T.inverse();
  const Eigen::AngleAxisd rotation(moved.linear());
  Vector6 motion;
  motion << rotation.angle() * rotation.axis(), moved * fit.refinement.centre - fit.refinement.centre;
  EXPECT_LT((fit.refinement.hessian * motion + fit.gradient).norm(), 1e-5 * fit.gradient.norm());
}

TEST_F(RefinementOfTheRoom, WhatLiesOffAPlaneIsNoMatchWhereMatchesAreExact)
{
  // A sixth of the points of the source lie 3 cm in front of their surfaces, as a cupboard before a wall does.
  SurfacePoints moved = source_.surface;
  for (Eigen::Index i = 0; i < moved.points.cols(); i += 6)
    moved.points.col(i) += 0.03f * moved.normals.col(i);
  RefinementOptions o = options();
  o.final_distance = 0.1;
  constexpr double kLeast = 0.006;
  const auto fitAt = [&](const Eigen::Isometry3d& T, double least) {
    return fitMutual({moved, source_.index}, {target_.surface, target_.index}, T, o, ruleWithin(least, 0.1));
  };
  const MutualFit narrow = fitAt(truth_, kLeast), wide = fitAt(truth_, 0.1);
  EXPECT_GE(narrow.match_distance, kLeast);
  EXPECT_LT(narrow.match_distance, 0.03);
  EXPECT_NEAR(wide.match_distance, 0.1, 1e-6);
  EXPECT_LT(narrow.refinement.matches, wide.refinement.matches);
  EXPECT_EQ(narrow.wide_rms, wide.wide_rms); // of all within the final distance
  EXPECT_EQ(narrow.wide_weight, wide.wide_weight);
  NoiseRule rule = ruleWithin(kLeast, 0.1);
  const auto distanceAtTruth = [&] {
    return mutualMatchDistance({moved, source_.index}, {target_.surface, target_.index}, truth_, o, rule);
  };
  EXPECT_EQ(distanceAtTruth(), narrow.match_distance);
  rule.pose_deviation = 0.02; // of a pose that is not exact no match is left out
  EXPECT_EQ(distanceAtTruth(), 0.1);
  // How far each says that the pose is off.
  const auto step = [](const MutualFit& fit) { return Vector6(fit.refinement.hessian.ldlt().solve(fit.gradient)); };
  EXPECT_LT(step(narrow).tail<3>().norm(), 2e-4);
  EXPECT_GT(step(wide).tail<3>().norm(), 5 * step(narrow).tail<3>().norm());
  // Where the pose is not exact no small scale is confirmed, and the fit sees how far it is off.
  const Eigen::Vector3d shift(0.03, 0.03, 0.03);
  const MutualFit away = fitAt(smallMotion(0, Eigen::Vector3d::UnitX(), shift) * truth_, kLeast);
  EXPECT_GT(away.match_distance, 0.06);
  EXPECT_LT((step(away).tail<3>() - shift).norm(), 0.01);
}

TEST_F(RefinementOfTheRoom, AFitOfNoisyMatchesKeepsTheWideScale)
{
  SurfacePoints noisy = source_.surface, others = target_.surface;
  testing::Random random(8);
  for (SurfacePoints* surface : {&noisy, &others})
    for (Eigen::Index i = 0; i < surface->points.cols(); ++i)
      surface->points.col(i) += static_cast<float>(0.03 * random.gaussian()) * surface->normals.col(i);
  RefinementOptions o = options();
  o.final_distance = 0.1;
  const NoiseRule rule = ruleWithin(0.006, 0.1);
  const MutualFit fit = fitMutual({noisy, source_.index}, {others, target_.index}, truth_, o, rule);
  EXPECT_GT(fit.match_distance, 0.09);
  // Nothing to fit.
  const MutualFit none = fitMutual({SurfacePoints(), PatchIndex()}, {others, target_.index}, truth_, o, rule);
  EXPECT_EQ(none.refinement.matches, 0);
  EXPECT_TRUE(none.refinement.hessian.isZero());
  const Eigen::Isometry3d away = Eigen::Translation3d(100, 0, 0) * truth_;
  EXPECT_EQ(fitMutual({noisy, source_.index}, {others, target_.index}, away, o, rule).refinement.matches, 0);
}

TEST_F(RefinementOfTheRoom, TheStatisticsOfThePolishAreThoseAtItsEnd)
{
  RefinementOptions settled = options();
  settled.steps = 30;
  const Refinement refined =
      refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, truth_, settled);
  const Matrix6& curvature = refined.statistics.curvature;
  // Small residuals: the derivative of the robust function is nearly its weight.
  EXPECT_LT((curvature - refined.hessian).norm(), 0.3 * refined.hessian.norm());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(refined.statistics.scatter).eigenvalues()[0], 0);
  // What does not face its sensor determines the pose less than it seems to, but scatters as much.
  SurfacePoints blind = source_.surface;
  std::fill(blind.facing.begin(), blind.facing.end(), std::uint8_t{0});
  const Refinement of_blind = refineMutual({blind, source_.index}, {target_.surface, target_.index}, truth_, settled);
  EXPECT_TRUE(of_blind.T_target_source.isApprox(refined.T_target_source, 0)); // the pose is the same
  EXPECT_TRUE(of_blind.statistics.curvature.isApprox(0.2 * curvature, 1e-12));
  EXPECT_TRUE(of_blind.statistics.scatter == refined.statistics.scatter);
}

TEST_F(RefinementOfTheRoom, TruthStays)
{
  const Refinement refined = refinePatches(source_.patches, target_.index, truth_, options());
  EXPECT_THAT(refined.T_target_source, IsPoseNear(truth_, 1e-5, 1e-5));
  EXPECT_LT(refined.steps, 20); // it stops when nothing moves
}

/// Half the weighted mean square distance of the patches' points to the planes they are matched to at the truth.
double
surfaceCost(const Scan& source,
            const Scan& target,
            const Eigen::Isometry3d& T_match,
            const Eigen::Isometry3d& T,
            const PatchIndex::Tolerance& tolerance)
{
  const OrientedSamples& planes = target.patches.samples;
  double cost = 0;
  for (Eigen::Index i = 0; i < source.patches.size(); ++i) {
    const auto u = static_cast<std::size_t>(i);
    const Eigen::Vector3f p = (T_match * source.patches.samples.points.col(i)).cast<float>();
    const Eigen::Vector3f n = (T_match.linear() * source.patches.samples.normals.col(i)).cast<float>();
    const int match = target.index.find(p, n, tolerance);
    if (match < 0)
      continue;
    const double weight =
        std::sqrt(source.patches.samples.weights[i]) / target.index.meet(match, p.cast<double>()).variance;
    for (std::uint32_t k = 0; k < source.patches.counts[u]; ++k) {
      const Eigen::Vector3d q = T * source.cloud.points.col(source.patches.first_point[u] + k).cast<double>();
      const double r = (q - planes.points.col(match)).dot(planes.normals.col(match));
      cost += 0.5 * weight / source.patches.counts[u] * r * r;
    }
  }
  return cost;
}

TEST_F(RefinementOfTheRoom, HessianIsTheCurvatureOfTheSquaredDistances)
{
  RefinementOptions one_step = options();
  one_step.steps = 1;
  one_step.match.distance = 0.1f;
  const Refinement refined = refinePatches(source_.patches, target_.index, truth_, one_step);
  constexpr double kStep = 1e-3;
  const auto cost = [&](const Vector6& motion) {
    const Eigen::Isometry3d moved =
        Eigen::Translation3d(refined.centre) * expSe3(motion) * Eigen::Translation3d(-refined.centre) * truth_;
    return surfaceCost(source_, target_, truth_, moved, one_step.match);
  };
  Matrix6 numerical;
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < 6; ++b) {
      const Vector6 da = kStep * Vector6::Unit(a), db = kStep * Vector6::Unit(b);
      numerical(a, b) = (cost(da + db) - cost(da - db) - cost(db - da) + cost(-da - db)) / (4 * kStep * kStep);
    }
  EXPECT_LT((refined.hessian - numerical).norm(), 1e-3 * numerical.norm()) << refined.hessian << "\n\n" << numerical;
  EXPECT_TRUE(refined.hessian.isApprox(refined.hessian.transpose(), 1e-9));
}

TEST_F(RefinementOfTheRoom, AStrayWallDoesNotPullThePose)
{
  // A board 12 cm in front of a wall, in the source only: a robust kernel lets it go.
  std::vector<testing::Rectangle> changed = testing::roomRectangles();
  changed.push_back({Eigen::Vector3d(-2.88, 0.2, 0.2), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 0.8)});
  const Scan source = makeScan(changed, T_world_source_, 5);
  const Refinement refined = refinePatches(source.patches, target_.index, truth_, options());
  EXPECT_THAT(refined.T_target_source, IsPoseNear(truth_, 1e-3, 1e-3));
}

TEST_F(RefinementOfTheRoom, WithoutMatchesThePoseStays)
{
  const Eigen::Isometry3d away = truth_ * Eigen::Translation3d(100, 0, 0);
  const Refinement refined = refinePatches(source_.patches, target_.index, away, options());
  EXPECT_EQ(refined.matches, 0);
  EXPECT_EQ(refined.steps, 1);
  EXPECT_THAT(refined.T_target_source, IsPoseNear(away, 1e-9, 1e-9));
  EXPECT_TRUE(refined.hessian.isZero());
  const Refinement mutual =
      refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, away, options());
  EXPECT_EQ(mutual.matches, 0);
  EXPECT_THAT(mutual.T_target_source, IsPoseNear(away, 1e-9, 1e-9));
}

TEST_F(RefinementOfTheRoom, EmptyScans)
{
  const PlanarPatches none;
  EXPECT_EQ(refinePatches(none, target_.index, truth_, options()).matches, 0);
  EXPECT_EQ(refinePatches(source_.patches, PatchIndex(), truth_, options()).matches, 0);
  const SurfacePoints no_points = drawSurfacePoints(ThinnedCloud(), none, 5, 100);
  EXPECT_EQ(no_points.points.cols(), 0);
  const Refinement mutual =
      refineMutual({no_points, PatchIndex()}, {target_.surface, target_.index}, truth_, options());
  EXPECT_EQ(mutual.matches, 0);
  EXPECT_THAT(mutual.T_target_source, IsPoseNear(truth_, 1e-12, 1e-12));
}

TEST_F(RefinementOfTheRoom, PosesThatAreNoneAreSurvived)
{
  for (const double x : {static_cast<double>(kNan), 1e30, 1e300, static_cast<double>(kMaxFloat)}) {
    Eigen::Isometry3d T = truth_;
    T.translation().x() = x;
    EXPECT_EQ(refinePatches(source_.patches, target_.index, T, options()).matches, 0) << x;
    EXPECT_EQ(refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, T, options()).matches,
              0);
  }
}

TEST(RefinePatches, MotionsThatNothingBindsAreNotMoved)
{
  // Floor only: height and tilt are bound, the shift along it and the turn about the vertical are not.
  PlanarPatches source, target;
  for (const double x : {-2.0, 0.0, 2.0}) {
    addPatch(source, {Eigen::Vector3d(x, 0.3 * x * x, 0.1), Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0, 0.4, 0)});
    addPatch(source, {Eigen::Vector3d(x, 1.5, 0.1), Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0, 0.4, 0)});
  }
  addPatch(target, {Eigen::Vector3d::Zero(), Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(0, 4, 0)});
  const Eigen::Isometry3d start = smallMotion(0.02, Eigen::Vector3d(1, 0.5, 0), Eigen::Vector3d(0.3, -0.2, 0.03));
  const Refinement refined = refinePatches(source, PatchIndex(target, 0.5), start, options());
  EXPECT_EQ(refined.matches, 6);
  EXPECT_LT(refined.rms, 1e-4);
  const Eigen::Isometry3d moved = refined.T_target_source * start.inverse();
  EXPECT_NEAR(moved.linear()(1, 0), 0, 1e-3); // no turn about z
  const Eigen::Vector3d middle = start * Eigen::Vector3d(0, 0.8, 0.1);
  EXPECT_LT((moved * middle - middle).head<2>().norm(), 5e-3);
  EXPECT_NEAR((refined.T_target_source * Eigen::Vector3d(0, 0, 0.1)).z(), 0, 1e-4);
}

/// A wall of patches in the plane x = 0.1: it does not tell the turn about x.
PlanarPatches
wallPatches()
{
  PlanarPatches wall;
  for (const double y : {-2.0, 0.0, 2.0})
    for (const double z : {-1.0, 1.0})
      addPatch(wall, {Eigen::Vector3d(0.1, y, z), Eigen::Vector3d(0, 0.5, 0), Eigen::Vector3d(0, 0, 0.4)});
  return wall;
}

TEST(KnownVertical, TellsTheTiltThatTheMatchesLeaveOpen)
{
  PlanarPatches target;
  addPatch(target, {Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 5, 0), Eigen::Vector3d(0, 0, 4)});
  const PatchIndex index(target, 0.5);
  const Eigen::Isometry3d start = smallMotion(0.04, Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(-0.05, 0, 0));
  const auto tiltOf = [](const Refinement& refined) { return refined.T_target_source.linear()(2, 1); };
  RefinementOptions given = options();
  EXPECT_NEAR(tiltOf(refinePatches(wallPatches(), index, start, given)), std::sin(0.04), 1e-6);
  given.vertical.emplace();
  for (const double deviation : {1e-4, 0.01, 1.0}) {
    given.vertical->deviation = deviation;
    const Refinement refined = refinePatches(wallPatches(), index, start, given);
    EXPECT_NEAR(tiltOf(refined), 0, 1e-4) << deviation;
    EXPECT_NEAR((refined.T_target_source * Eigen::Vector3d(0.1, 0, 0)).x(), 0, 1e-4) << deviation;
    // What is said of the matches does not come from the vertical.
    EXPECT_LT(refined.hessian(0, 0), 1e-3 * refined.hessian(1, 1)) << deviation;
  }
  // With an upside-down vertical it does not know where to turn to.
  given.vertical->up_target = -Eigen::Vector3d::UnitZ();
  const Refinement upside_down = refinePatches(wallPatches(), index, Eigen::Isometry3d::Identity(), given);
  EXPECT_TRUE(upside_down.T_target_source.matrix().allFinite());
}

TEST_F(RefinementOfTheRoom, AKnownVerticalCountsAsMuchAsItIsGoodTo)
{
  // One that is 0.02 rad wrong, with matches that tell the tilt to some 1e-4 rad.
  RefinementOptions given = options();
  given.vertical.emplace();
  given.vertical->up_source = T_world_source_.linear().row(2);
  given.vertical->up_target =
      (Eigen::AngleAxisd(0.02, T_world_target_.linear().row(0)) * T_world_target_.linear().row(2).transpose()).eval();
  double last = 0;
  for (const double deviation : {1.0, 0.02, 0.001, 1e-5, 1e-7}) {
    given.vertical->deviation = deviation;
    const Refinement patches = refinePatches(source_.patches, target_.index, truth_, given);
    const Refinement points =
        refineMutual({source_.surface, source_.index}, {target_.surface, target_.index}, truth_, given);
    for (const Refinement& refined : {patches, points}) {
      const double error = Eigen::AngleAxisd(truth_.linear().transpose() * refined.T_target_source.linear()).angle();
      EXPECT_LT(error, deviation >= 0.02 ? 0.001 : 0.022) << deviation;
      EXPECT_GT(error, deviation <= 1e-7 ? 0.018 : 0) << deviation;
    }
    const double error = Eigen::AngleAxisd(truth_.linear().transpose() * points.T_target_source.linear()).angle();
    EXPECT_GE(error, last - 1e-6) << deviation;
    last = error;
  }
}

TEST_F(RefinementOfTheRoom, AVerticalWithoutMatchesMovesNothing)
{
  const Eigen::Isometry3d away = truth_ * Eigen::Translation3d(100, 0, 0);
  RefinementOptions given = options();
  given.vertical.emplace();
  EXPECT_THAT(refinePatches(source_.patches, target_.index, away, given).T_target_source, IsPoseNear(away, 1e-9, 1e-9));
}

TEST(RefinePatches, OnePlaneOfOnePatchIsTooFew)
{
  PlanarPatches one;
  addPatch(one, {Eigen::Vector3d(0, 0, 0.1), Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0, 0.4, 0)});
  const Eigen::Isometry3d start = smallMotion(0.01, Eigen::Vector3d(1, 0.5, 0), Eigen::Vector3d(0.05, 0, 0.03));
  const Refinement refined = refinePatches(one, PatchIndex(one, 0.5), start, options());
  EXPECT_EQ(refined.matches, 1);
  EXPECT_THAT(refined.T_target_source, IsPoseNear(start, 1e-12, 1e-12));
}

TEST(DrawSurfacePoints, EvenlyFromEveryPatch)
{
  const Scan scan = makeScan(testing::roomRectangles(), Eigen::Isometry3d::Identity(), 6);
  const std::pair<int, int> shares[] = {{0, 100}, {1, 1000000}, {4, 1000000}, {4, 100}, {3, 7}, {1, 1}, {1000000, 100}};
  for (const auto& [of_group, group] : shares) {
    const SurfacePoints surface = drawSurfacePoints(scan.cloud, scan.patches, of_group, group);
    ASSERT_EQ(surface.points.cols(), surface.normals.cols());
    Eigen::Index next = 0;
    for (std::size_t i = 0; i < scan.patches.counts.size(); ++i) {
      const std::uint32_t count = scan.patches.counts[i], first = scan.patches.first_point[i];
      std::uint64_t drawn = 0; // of each group that the points begin
      for (std::uint32_t begun = 0; begun < count; begun += static_cast<std::uint32_t>(group))
        drawn = std::min<std::uint64_t>(count, drawn + static_cast<std::uint64_t>(of_group));
      for (std::uint32_t k = 0; k < drawn; ++k, ++next) {
        ASSERT_LT(next, surface.points.cols());
        // The k-th of equal pieces of the patch's range of points.
        const std::uint64_t from = first + k * count / drawn, to = first + ((k + 1) * count + drawn - 1) / drawn;
        bool found = false;
        for (auto p = static_cast<Eigen::Index>(from); p < static_cast<Eigen::Index>(to); ++p)
          found = found || scan.cloud.points.col(p) == surface.points.col(next);
        EXPECT_TRUE(found) << "patch " << i << ", point " << k;
        EXPECT_TRUE(surface.normals.col(next).isApprox(
            scan.patches.samples.normals.col(static_cast<Eigen::Index>(i)).cast<float>()));
      }
    }
    EXPECT_EQ(next, surface.points.cols());
  }
}

TEST(DrawSurfacePoints, OfLargerGroupsWhereTheyAreTooMany)
{
  const Scan scan = makeScan(testing::roomRectangles(), Eigen::Isometry3d::Identity(), 6);
  const auto draw = [&](int group, int most) { return drawSurfacePoints(scan.cloud, scan.patches, 2, group, most); };
  const auto all = static_cast<int>(draw(5, 0).points.cols());
  const auto half = static_cast<int>(draw(10, 0).points.cols());
  const auto quarter = static_cast<int>(draw(20, 0).points.cols());
  ASSERT_GT(all, half);
  ASSERT_GT(half, quarter);
  EXPECT_EQ(draw(5, all).points, draw(5, 0).points);
  EXPECT_EQ(draw(5, all - 1).points, draw(10, 0).points);
  EXPECT_EQ(draw(5, half - 1).points, draw(20, 0).points);
  EXPECT_EQ(draw(5, half - 1).normals, draw(20, 0).normals);
  // However few are wanted, every patch keeps those of one group.
  EXPECT_EQ(draw(5, 1).points, draw(1000000, 0).points);
  EXPECT_EQ(drawSurfacePoints(ThinnedCloud(), PlanarPatches(), 2, 5, 1).points.cols(), 0);
}

} // namespace
} // namespace pcl_ssfr::test_refinement
