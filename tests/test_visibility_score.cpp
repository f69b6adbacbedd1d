// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/types.h"
#include "judgement/matched_planes.h"
#include "judgement/visibility_score.h"
#include "patch_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace pcl_ssfr::test_visibility_score {
namespace {

using testing::addPatch;
using testing::kMaxFloat;
using testing::kNan;

constexpr double kCell = 0.05;

/// The room's rectangles as patches that face the origin.
PlanarPatches
roomPatches()
{
  PlanarPatches patches;
  for (testing::Rectangle r : testing::roomRectangles()) {
    if (r.half_u.norm() < r.half_v.norm())
      std::swap(r.half_u, r.half_v);
    if (r.half_u.cross(r.half_v).dot(r.centre) > 0)
      r.half_v = -r.half_v;
    addPatch(patches, r);
  }
  return patches;
}

/// A target that saw a wall at x = 4 through a window of +-2 m, from the origin.
struct SeenWall {
  PatchIndex index;
  RangeImage image;

  SeenWall()
  {
    const testing::Rectangle wall{Eigen::Vector3d(4, 0, 0), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, -2)};
    PlanarPatches target;
    addPatch(target, wall);
    index = PatchIndex(target, 0.5);
    image = RangeImage(testing::samplePoints({wall}, 4000, 1), Eigen::Vector3f::Zero(), kCell);
  }
};

TEST(CollectEvidence, ByHand)
{
  const SeenWall wall;
  OrientedSamples samples;
  samples.points.resize(3, 7);
  samples.normals.resize(3, 7);
  samples.weights.resize(7);
  samples.weights << 1, 2, 4, 8, 16, 32, 64;
  const Eigen::Vector3d towards(-1, 0, 0);
  samples.points.col(0) << 4.02, 0.5, 0.5; // on the wall
  samples.normals.col(0) = towards;
  samples.points.col(1) << 2, 0, 0; // in front of it
  samples.normals.col(1) = towards;
  samples.points.col(2) << 4, 0, 0; // at its depth, facing elsewhere
  samples.normals.col(2) = Eigen::Vector3d::UnitZ();
  samples.points.col(3) << 9, 0, 0; // hidden behind it
  samples.normals.col(3) = towards;
  samples.points.col(4) << -4, 0, 0; // out of view
  samples.normals.col(4) = towards;
  samples.points.col(5) << 0, 0, 0; // in the sensor: no direction
  samples.normals.col(5) = towards;
  samples.points.col(6) << 4, 0, 0; // seen from behind
  samples.normals.col(6) = -towards;
  // The same evidence, seen from a source that stands elsewhere.
  testing::Random random(1);
  const Eigen::Isometry3d T = testing::randomMotion(random, 3);
  samples.points = T.inverse() * samples.points;
  samples.normals = T.inverse().linear() * samples.normals;

  const SurfaceEvidence evidence = collectEvidence(samples, wall.index, &wall.image, T, VisibilityOptions());
  EXPECT_EQ(evidence.total, 127);
  EXPECT_EQ(evidence.matched, 1);
  EXPECT_EQ(evidence.contradicted, 2);
  EXPECT_EQ(evidence.unmatched, 4 + 64);
  const auto vote = [](double area) { return std::pow(area, 0.25); };
  EXPECT_NEAR(evidence.patches.total, 1 + vote(2) + vote(4) + vote(8) + vote(16) + vote(32) + vote(64), 1e-12);
  EXPECT_NEAR(evidence.patches.matched, 1, 1e-12);
  EXPECT_NEAR(evidence.patches.contradicted, vote(2), 1e-12);
  EXPECT_TRUE(evidence.matched_normals.isApprox(Eigen::Vector3d(1, 0, 0).asDiagonal().toDenseMatrix(), 1e-9));

  const SurfaceEvidence matches_only = collectEvidence(samples, wall.index, nullptr, T, VisibilityOptions());
  EXPECT_EQ(matches_only.matched, 1);
  EXPECT_EQ(matches_only.contradicted + matches_only.unmatched, 0);
}

TEST(CollectEvidence, SurfaceSeenEdgeOnDoesNotContradictInTheFacingEvidence)
{
  const SeenWall wall; // the samples hang in front of it, or lie on it
  OrientedSamples samples;
  samples.points.resize(3, 5);
  samples.normals.resize(3, 5);
  samples.weights = Eigen::VectorXd::Ones(5);
  samples.facing.resize(5);
  const Eigen::Vector3d towards(-1, 0, 0);
  samples.points.col(0) << 4, 0.5, 0.5; // on the wall
  samples.normals.col(0) = towards;
  samples.facing[0] = 0.5;
  samples.points.col(1) << 4, -0.5, 0.5; // on the wall, a line of points
  samples.normals.col(1) = towards;
  samples.facing[1] = 0.01;
  samples.points.col(2) << 2, 0, 0; // in front of it
  samples.normals.col(2) = towards;
  samples.facing[2] = 0.5;
  samples.points.col(3) << 2, 0, 0; // a line of points there
  samples.normals.col(3) = towards;
  samples.facing[3] = 0.01;
  samples.points.col(4) << 2, 0, 0; // a board there, edge-on for the target's sensor
  samples.normals.col(4) = Eigen::Vector3d::UnitZ();
  samples.facing[4] = 0.5;

  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const SurfaceEvidence evidence = collectEvidence(samples, wall.index, &wall.image, T, VisibilityOptions());
  EXPECT_EQ(evidence.patches.total, 5);
  EXPECT_EQ(evidence.patches.matched, 2);
  EXPECT_EQ(evidence.patches.contradicted, 3);
  EXPECT_EQ(evidence.facing.total, 3);
  EXPECT_EQ(evidence.facing.matched, 1);
  EXPECT_EQ(evidence.facing.contradicted, 1);
  EXPECT_EQ(evidence.patches.beyond, 0); // the wall is one plane

  samples.facing.resize(0); // from an unknown place: each may face it
  const SurfaceEvidence unknown = collectEvidence(samples, wall.index, &wall.image, T, VisibilityOptions());
  EXPECT_EQ(unknown.facing.total, 5);
  EXPECT_EQ(unknown.facing.matched, 2);
  EXPECT_EQ(unknown.facing.contradicted, 2);
}

TEST(CollectEvidence, AgreesWithPlainSums)
{
  const Eigen::Matrix3Xf points = testing::samplePoints(testing::roomRectangles(), 300, 2);
  const Eigen::Vector3f viewpoint(0.1f, -0.2f, 0.1f);
  const RangeImage image(points, viewpoint, kCell);
  const PatchIndex index(roomPatches(), 0.4);
  PlanarPatches source = testing::randomPatches(600, 3, 0.4, 3);
  VisibilityOptions options;
  options.match.min_cos = 0.8f;
  testing::Random random(4);
  source.samples.facing.resize(source.size());
  for (double& facing : source.samples.facing)
    facing = random.uniform(0, 2 * kMinFacing);
  SurfaceEvidence all;
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::Isometry3d T = testing::randomMotion(random, 1);
    const SurfaceEvidence evidence = collectEvidence(source.samples, index, &image, T, options);
    // All samples, sorted into what they are: hidden or out of view, matched, contradicted, unmatched.
    Eigen::Vector4d sums = Eigen::Vector4d::Zero();
    Eigen::Vector4d votes = Eigen::Vector4d::Zero();
    double facing_matched = 0, facing_contradicted = 0;
    std::vector<Eigen::Index> matched;
    Eigen::Matrix3d matched_normals = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < source.size(); ++i) {
      const Eigen::Vector3f p = (T * source.samples.points.col(i)).cast<float>();
      const Eigen::Vector3d n = T.linear() * source.samples.normals.col(i);
      const std::size_t cell = image.cell(p - viewpoint);
      const float range = (p - viewpoint).norm(), free = image.freeRange(cell), far = image.farthest(cell);
      int kind = 0;
      if (index.find(p, n.cast<float>(), options.match) >= 0)
        kind = 1;
      else if (free > 0 && range < options.free_ratio * free - options.free_margin)
        kind = 2;
      else if (free > 0 && range < options.hidden_ratio * far + options.hidden_margin)
        kind = 3;
      sums[kind] += source.samples.weights[i];
      votes[kind] += std::pow(source.samples.weights[i], 0.25);
      if (source.samples.facing[i] >= kMinFacing) {
        const double towards = std::abs((p - viewpoint).cast<double>().dot(n)) / range;
        facing_matched += kind == 1 ? std::pow(source.samples.weights[i], 0.25) : 0;
        facing_contradicted += kind == 2 && towards >= kMinFacing ? std::pow(source.samples.weights[i], 0.25) : 0;
      }
      if (kind == 1) {
        matched.push_back(i);
        matched_normals += source.samples.weights[i] * n * n.transpose();
      }
    }
    EXPECT_NEAR(evidence.total, sums.sum(), 1e-9);
    EXPECT_NEAR(evidence.matched, sums[1], 1e-9);
    EXPECT_NEAR(evidence.contradicted, sums[2], 1e-9);
    EXPECT_NEAR(evidence.unmatched, sums[3], 1e-9);
    EXPECT_NEAR(evidence.patches.total, votes.sum(), 1e-9);
    EXPECT_NEAR(evidence.patches.matched, votes[1], 1e-9);
    EXPECT_NEAR(evidence.patches.contradicted, votes[2], 1e-9);
    EXPECT_NEAR(evidence.facing.matched, facing_matched, 1e-9);
    EXPECT_NEAR(evidence.facing.contradicted, facing_contradicted, 1e-9);
    EXPECT_TRUE(evidence.matched_normals.isApprox(matched_normals, 1e-9));
    EXPECT_NEAR(evidence.matched_normals.trace(), evidence.matched, 1e-9);
    double beyond = 0, facing_beyond = 0;
    for (const Eigen::Index i : beyondThreePlanes(source.samples, matched, options.match)) {
      const double vote = std::pow(source.samples.weights[i], 0.25);
      beyond += vote;
      facing_beyond += source.samples.facing[i] >= kMinFacing ? vote : 0;
    }
    EXPECT_NEAR(evidence.patches.beyond, beyond, 1e-9);
    EXPECT_NEAR(evidence.facing.beyond, facing_beyond, 1e-9);
    all += evidence;
  }
  EXPECT_GT(all.facing.beyond, 0);
  EXPECT_LT(all.patches.beyond, all.patches.matched);
  EXPECT_GT(all.facing.contradicted, 0);
  EXPECT_LT(all.facing.contradicted, all.patches.contradicted);
  EXPECT_NEAR(all.patches.total, 5 * source.samples.weights.array().pow(0.25).sum(), 1e-9);
  const double visible = all.matched + all.contradicted + all.unmatched;
  for (const double sum : {all.matched, all.contradicted, all.unmatched, all.total - visible})
    EXPECT_GT(sum, 0.01 * all.total); // each kind of evidence occurred
}

TEST(CollectEvidence, TruthMatchesAllAndIsContradictedByNothing)
{
  const PlanarPatches room = roomPatches();
  const PatchIndex index(room, 0.4);
  const RangeImage image(testing::samplePoints(testing::roomRectangles(), 2000, 5), Eigen::Vector3f::Zero(), kCell);
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  const SurfaceEvidence truth = collectEvidence(room.samples, index, &image, identity, VisibilityOptions());
  EXPECT_NEAR(truth.matched, truth.total, 1e-9);
  const SurfaceEvidence shifted =
      collectEvidence(room.samples, index, &image, identity * Eigen::Translation3d(1.3, 0, 0), VisibilityOptions());
  EXPECT_LT(shifted.matched, truth.matched);
  EXPECT_GT(shifted.contradicted + shifted.unmatched, 0);
  // Floor and ceiling still lie on each other, what faces x does not.
  EXPECT_LT(shifted.matched_normals(0, 0), 0.3 * truth.matched_normals(0, 0));
  EXPECT_GT(shifted.matched_normals(2, 2), 0.6 * truth.matched_normals(2, 2));
  EXPECT_GT(shifted.matched, 0.3 * (shifted.matched + shifted.contradicted + shifted.unmatched));
}

TEST(CollectEvidence, EmptyAndNumbersThatAreNone)
{
  const PatchIndex index(roomPatches(), 0.4);
  const RangeImage image(Eigen::Matrix3Xf::Random(3, 100), Eigen::Vector3f::Zero(), kCell);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  EXPECT_EQ(collectEvidence(OrientedSamples(), index, &image, T, VisibilityOptions()).total, 0);
  const PlanarPatches source = roomPatches();
  const SurfaceEvidence nothing = collectEvidence(source.samples, PatchIndex(), nullptr, T, VisibilityOptions());
  EXPECT_GT(nothing.total, 0);
  EXPECT_EQ(nothing.matched + nothing.contradicted + nothing.unmatched, 0);
  EXPECT_TRUE(nothing.matched_normals.isZero(0));
  for (const double x : {static_cast<double>(kNan), 1e300, 1e30, static_cast<double>(kMaxFloat), 1e6}) {
    T.translation().setConstant(x);
    EXPECT_EQ(collectEvidence(source.samples, index, &image, T, VisibilityOptions()).matched, 0) << x;
  }
}

TEST(CountAtDepth, ByHand)
{
  const SeenWall wall; // 4 m away, along x
  Eigen::Matrix3Xf points(3, 6);
  points << 4.05f, 3.95f, 3.5f, 4.5f, -4, 0, // on it to both sides, in front, behind, out of view, in the sensor
      0.2f, -0.2f, 0, 0, 0, 0,               //
      0, 0.1f, 0, 0, 0, 0;
  testing::Random random(5);
  const Eigen::Isometry3d T = testing::randomMotion(random, 3);
  points = T.inverse().cast<float>() * points;
  EXPECT_EQ(countAtDepth(points, wall.image, T, 0.1f), 2U);
  EXPECT_EQ(countAtDepth(points, wall.image, T, 0.6f), 4U);
  EXPECT_EQ(countAtDepth(points, RangeImage(), T, 0.6f), 0U);
  EXPECT_EQ(countAtDepth(Eigen::Matrix3Xf(3, 0), wall.image, T, 0.6f), 0U);
}

TEST(CountAtDepth, AgreesWithPlainChecksAndSurvivesNumbersThatAreNone)
{
  testing::Random random(6);
  const auto cloud = [&](int n) {
    Eigen::Matrix3Xf points(3, n);
    for (Eigen::Index i = 0; i < n; ++i)
      points.col(i) =
          Eigen::Vector3d(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-2, 2)).cast<float>();
    return points;
  };
  const Eigen::Matrix3Xf seen = cloud(4000), points = cloud(500);
  const Eigen::Vector3f viewpoint(0.3f, -0.2f, 0.1f);
  const RangeImage image(seen, viewpoint, kCell);
  std::size_t all = 0;
  for (int trial = 0; trial < 5; ++trial) {
    Eigen::Isometry3d T = testing::randomMotion(random, 2);
    const float tolerance = 0.2f;
    const auto expected = [&](float bound) { // of the returns of the cell, one in front of it and one behind
      std::size_t count = 0;
      for (Eigen::Index i = 0; i < points.cols(); ++i) {
        const Eigen::Vector3f ray = (T * points.col(i).cast<double>()).cast<float>() - viewpoint;
        bool nearer = false, farther = false;
        for (Eigen::Index k = 0; k < seen.cols(); ++k)
          if (image.cell(seen.col(k) - viewpoint) == image.cell(ray)) {
            nearer |= (seen.col(k) - viewpoint).norm() <= ray.norm() + bound;
            farther |= (seen.col(k) - viewpoint).norm() >= ray.norm() - bound;
          }
        count += nearer && farther;
      }
      return count;
    };
    const std::size_t count = countAtDepth(points, image, T, tolerance);
    EXPECT_GE(count, expected(tolerance - 1e-4f));
    EXPECT_LE(count, expected(tolerance + 1e-4f));
    all += count;
    for (const double x : {static_cast<double>(kNan), 1e300, 1e30}) {
      T.translation().setConstant(x);
      EXPECT_EQ(countAtDepth(points, image, T, tolerance), 0U) << x;
    }
  }
  EXPECT_GT(all, 20U);
}

TEST(SurfaceEvidence, AddsUp)
{
  SurfaceEvidence a, b;
  a.total = 1;
  a.matched = 2;
  a.contradicted = 3;
  a.unmatched = 4;
  a.matched_normals.setConstant(5);
  a.clutter = 6;
  a.patches = {7, 8, 9, 13, 14};
  a.facing = {10, 11, 12, 15, 16};
  b = a;
  b += a;
  EXPECT_EQ(b.total, 2);
  EXPECT_EQ(b.matched, 4);
  EXPECT_EQ(b.contradicted, 6);
  EXPECT_EQ(b.unmatched, 8);
  EXPECT_EQ(b.matched_normals(0, 2), 10);
  EXPECT_EQ(b.clutter, 12);
  EXPECT_EQ(b.patches.total, 14);
  EXPECT_EQ(b.patches.matched, 16);
  EXPECT_EQ(b.patches.contradicted, 18);
  EXPECT_EQ(b.facing.total, 20);
  EXPECT_EQ(b.facing.matched, 22);
  EXPECT_EQ(b.facing.contradicted, 24);
  EXPECT_EQ(b.patches.unmatched, 26);
  EXPECT_EQ(b.patches.beyond, 28);
  EXPECT_EQ(b.facing.beyond, 32);
  b.facing *= 0.25;
  EXPECT_EQ(b.facing.matched, 5.5);
  EXPECT_EQ(b.facing.beyond, 8);
}

} // namespace
} // namespace pcl_ssfr::test_visibility_score
