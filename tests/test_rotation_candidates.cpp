// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/rotation_math.h"
#include "pose_matchers.h"
#include "search/rotation_candidates.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace pcl_ssfr::test_rotation_candidates {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

double
angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.transpose() * b)).angle();
}

std::vector<MainNormal>
makeNormals(const std::vector<Eigen::Vector3d>& directions)
{
  std::vector<MainNormal> normals;
  normals.reserve(directions.size());
  for (const Eigen::Vector3d& direction : directions)
    normals.push_back({direction.normalized(), 100.0 - 5 * static_cast<double>(normals.size())});
  return normals;
}

std::vector<MainNormal>
rotated(const std::vector<MainNormal>& normals, const Eigen::Matrix3d& R)
{
  std::vector<MainNormal> result = normals;
  for (MainNormal& normal : result)
    normal.direction = R * normal.direction;
  return result;
}

std::vector<MainNormal>
makeManhattan()
{
  return makeNormals({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
}

TEST(RotationFromPairs, RecoversAnyRotation)
{
  testing::Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Matrix3d R = testing::randomRotation(random);
    const Eigen::Vector3d a = testing::randomRotation(random).col(0);
    const Eigen::Vector3d b = testing::randomRotation(random).col(0);
    if (a.cross(b).norm() < 0.1)
      continue;
    EXPECT_LT(angleBetween(rotationFromPairs(a, b, R * a, R * b), R), 1e-7);
  }
}

TEST(RotationFromPairs, SplitsTheErrorEvenly)
{
  // Target pair 4 degrees wider than the source pair, in one plane: each vector is missed by 2 degrees.
  const Eigen::Vector3d b(0, 1, 0);
  const Eigen::Vector3d wide_a(std::cos(-2 * kDegree), std::sin(-2 * kDegree), 0);
  const Eigen::Vector3d wide_b(std::cos(92 * kDegree), std::sin(92 * kDegree), 0);
  const Eigen::Matrix3d R = rotationFromPairs(Eigen::Vector3d::UnitX(), b, wide_a, wide_b);
  EXPECT_LT(angleBetween(R, Eigen::Matrix3d::Identity()), 1e-7);
}

TEST(RotationFromPairs, AlwaysProper)
{
  testing::Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Matrix3d a = testing::randomRotation(random), b = testing::randomRotation(random);
    // Also parallel and opposite vectors, where the rotation is not determined.
    const Eigen::Vector3d second = trial % 3 == 0 ? Eigen::Vector3d(a.col(0)) : Eigen::Vector3d(a.col(1));
    const Eigen::Vector3d image = trial % 4 == 0 ? Eigen::Vector3d(-b.col(0)) : Eigen::Vector3d(b.col(2));
    const Eigen::Matrix3d R = rotationFromPairs(a.col(0), second, b.col(0), image);
    EXPECT_NEAR(R.determinant(), 1, 1e-9);
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  }
}

TEST(RotationCandidates, EnumeratesUnorderedAgainstOrderedPairs)
{
  // Three orthogonal normals: 3 unordered source pairs times 6 ordered target pairs, all of 90 degrees.
  const std::vector<MainNormal> normals = makeNormals({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const std::vector<RotationCandidate> candidates = proposeRotations(normals, normals, RotationOptions());
  ASSERT_EQ(candidates.size(), 18U);
  const std::array<std::array<std::size_t, 2>, 3> source_pairs{{{{0, 1}}, {{0, 2}}, {{1, 2}}}};
  int identities = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const RotationCandidate& candidate = candidates[i];
    identities += angleBetween(candidate.R_target_source, Eigen::Matrix3d::Identity()) < 1e-6 ? 1 : 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const Eigen::Vector3d source = normals[source_pairs[i / 6][k]].direction;
      const Eigen::Vector3d target = normals[static_cast<std::size_t>(candidate.target_pair[k])].direction;
      EXPECT_LT((candidate.R_target_source * source - target).norm(), 1e-9);
    }
  }
  EXPECT_EQ(identities, 3);
}

TEST(RotationCandidates, ManhattanRoomGives24DistinctRotationsWhenMerged)
{
  testing::Random random(3);
  const Eigen::Matrix3d R = testing::randomRotation(random);
  const std::vector<MainNormal> source = makeManhattan(), target = rotated(source, R);
  EXPECT_EQ(proposeRotations(source, target, RotationOptions()).size(), 12U * 24U);
  RotationOptions options;
  options.merge_angle = 3 * kDegree;
  const std::vector<RotationCandidate> merged = proposeRotations(source, target, options);
  ASSERT_EQ(merged.size(), 24U);
  EXPECT_LT(angleBetween(merged[0].R_target_source, R), 1e-6); // supports match best at the truth
  EXPECT_NEAR(merged[0].support, 1, 1e-12);
  for (std::size_t i = 1; i < merged.size(); ++i) {
    EXPECT_LE(merged[i].support, merged[i - 1].support);
    EXPECT_GT(angleBetween(merged[i].R_target_source, merged[0].R_target_source), 80 * kDegree);
  }
}

TEST(RotationCandidates, SupportAcrossIsWhatFacesAcrossTheBestSupported)
{
  // Floor 5 and ceiling 2 of 10, walls 2 and 1: by the identity 0.3 faces across the floor, by a quarter turn 0.1.
  const std::vector<MainNormal> source = {{Eigen::Vector3d::UnitX(), 2},
                                          {Eigen::Vector3d::UnitY(), 1},
                                          {Eigen::Vector3d::UnitZ(), 5},
                                          {-Eigen::Vector3d::UnitZ(), 2}};
  RotationCandidate identity, quarter;
  quarter.R_target_source = Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const double tolerance = 3 * kDegree;
  EXPECT_NEAR(supportAcross({identity}, source, source, tolerance), 0.3, 1e-12);
  EXPECT_NEAR(supportAcross({quarter}, source, source, tolerance), 0.1, 1e-12);
  EXPECT_NEAR(supportAcross({quarter, identity}, source, source, tolerance), 0.3, 1e-12);
  EXPECT_EQ(supportAcross({}, source, source, tolerance), 0);
  EXPECT_EQ(supportAcross({identity}, {}, source, tolerance), 0);
  const std::vector<MainNormal> floor = {{Eigen::Vector3d::UnitZ(), 1}, {Eigen::Vector3d(1, 1, 0).normalized(), 1}};
  EXPECT_EQ(supportAcross({identity}, source, floor, tolerance), 0); // ground on ground alone
  // It does not depend on the frame.
  testing::Random random(8);
  const Eigen::Matrix3d R = testing::randomRotation(random);
  identity.R_target_source = R;
  EXPECT_NEAR(supportAcross({identity}, source, rotated(source, R), tolerance), 0.3, 1e-12);
}

TEST(RotationCandidates, MergingFitsAllMatchedNormals)
{
  // Noisy target normals: the merged fit over five normals must beat the best single pair on average.
  double merged_error = 0, single_error = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    testing::Random random(100 + seed);
    const Eigen::Matrix3d R = testing::randomRotation(random);
    const std::vector<MainNormal> source =
        makeNormals({{1, 0, 0}, {0, 1, 0.1}, {0.1, 0, 1}, {-1, 0.3, 0}, {0.2, -1, 0.5}});
    std::vector<MainNormal> target = rotated(source, R);
    for (MainNormal& normal : target)
      normal.direction =
          (normal.direction + 0.01 * Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian()))
              .normalized();
    RotationOptions options;
    single_error += angleBetween(proposeRotations(source, target, options).at(0).R_target_source, R);
    options.merge_angle = 3 * kDegree;
    const RotationCandidate best = proposeRotations(source, target, options).at(0);
    merged_error += angleBetween(best.R_target_source, R);
    EXPECT_LT(angleBetween(best.R_target_source, R), 2 * kDegree) << seed;
    EXPECT_GT(best.support, 0.95) << seed;
  }
  EXPECT_LT(merged_error, single_error);
}

TEST(RotationCandidates, OnlyPairsWhoseAnglesAgree)
{
  const std::vector<MainNormal> source = makeNormals({{1, 0, 0}, {0, 1, 0}});
  const double angle = 80 * kDegree;
  const std::vector<MainNormal> target = makeNormals({{1, 0, 0}, {std::cos(angle), std::sin(angle), 0}});
  RotationOptions options;
  options.angle_tolerance = 10 * kDegree - 1e-9;
  EXPECT_TRUE(proposeRotations(source, target, options).empty());
  options.angle_tolerance = 10 * kDegree + 1e-9;
  const std::vector<RotationCandidate> candidates = proposeRotations(source, target, options);
  ASSERT_EQ(candidates.size(), 2U); // both orders
}

TEST(RotationCandidates, NothingWithoutPairs)
{
  const std::vector<MainNormal> room = makeManhattan();
  const std::vector<MainNormal> floor = makeNormals({{0, 0, 1}, {0, 0, -1}, {0.1, 0, 1}});
  for (const double merge : {0.0, 0.05}) {
    RotationOptions options;
    options.merge_angle = merge;
    EXPECT_TRUE(proposeRotations({}, {}, options).empty());
    EXPECT_TRUE(proposeRotations({}, room, options).empty());
    EXPECT_TRUE(proposeRotations(floor, room, options).empty());
    EXPECT_TRUE(proposeRotations(room, floor, options).empty());
  }
}

TEST(RotationCandidates, RepeatsItselfWithAnyNumberOfThreads)
{
  testing::Random random(5);
  const std::vector<MainNormal> source = makeManhattan();
  const std::vector<MainNormal> target = rotated(source, testing::randomRotation(random));
  RotationOptions options;
  options.merge_angle = 0.05;
  for (const double merge_angle : {0.0, 0.05}) {
    options.merge_angle = merge_angle;
    const auto first = proposeRotations(source, target, options);
    for (const unsigned threads : {1U, 2U, 7U}) {
      const auto again = proposeRotations(source, target, options, threads);
      ASSERT_EQ(first.size(), again.size());
      for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(first[i].R_target_source, again[i].R_target_source);
        EXPECT_EQ(first[i].target_pair, again[i].target_pair);
        EXPECT_EQ(first[i].support, again[i].support);
      }
    }
  }
}

TEST(HasPair, LooksAtEveryTwo)
{
  const auto at = [](double degrees) {
    const double angle = degrees * 3.14159265358979 / 180;
    return MainNormal{Eigen::Vector3d(std::cos(angle), std::sin(angle), 0), 1};
  };
  const RotationOptions options; // |cos| below 0.9: 26 degrees and more apart
  EXPECT_FALSE(hasPair({}, options));
  EXPECT_FALSE(hasPair({at(0)}, options));
  EXPECT_FALSE(hasPair({at(0), at(20)}, options));
  EXPECT_FALSE(hasPair({at(0), at(180), at(170)}, options)); // opposite ones are parallel
  EXPECT_TRUE(hasPair({at(0), at(90)}, options));
  EXPECT_TRUE(hasPair({at(0), at(25), at(-25)}, options)); // neither with the first
}

TEST(SweepRotations, GoesAllAroundTheSharedAxis)
{
  testing::Random random(7);
  const int steps = 40;
  const Eigen::Vector3d source = testing::randomRotation(random).col(0);
  const Eigen::Vector3d target = testing::randomRotation(random).col(0);
  const std::vector<RotationCandidate> sweep = sweepRotations({source}, {target}, steps);
  ASSERT_EQ(sweep.size(), static_cast<std::size_t>(steps));
  for (const RotationCandidate& candidate : sweep) {
    EXPECT_NEAR(candidate.R_target_source.determinant(), 1, 1e-9);
    EXPECT_LT((candidate.R_target_source * source - target).norm(), 1e-9);
  }
  // Whatever the turn about the axis, one of the sweep is within half a step.
  const Eigen::Matrix3d onto = rotationOnto(source, target);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(random.uniform(-3.2, 3.2), target).toRotationMatrix() * onto;
    double nearest = 10;
    for (const RotationCandidate& candidate : sweep)
      nearest = std::min(nearest, angleBetween(candidate.R_target_source, R));
    EXPECT_LT(nearest, 180 * kDegree / steps + 1e-9);
  }
}

TEST(SweepRotations, OppositeAxesAreTriedBothWaysUpOnce)
{
  // Floor and ceiling in both scans: floor onto floor is ceiling onto ceiling.
  const std::vector<Eigen::Vector3d> axes = {Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ()};
  const std::vector<RotationCandidate> sweep = sweepRotations(axes, axes, 36);
  std::size_t upright = 0, upside_down = 0;
  for (const RotationCandidate& candidate : sweep)
    (candidate.R_target_source(2, 2) > 0 ? upright : upside_down) += 1;
  EXPECT_EQ(upright, 36U);
  EXPECT_GE(upside_down, 36U);
  EXPECT_LE(upside_down, 72U);
}

TEST(SweepRotations, Empty)
{
  EXPECT_TRUE(sweepRotations({}, {Eigen::Vector3d::UnitZ()}, 10).empty());
  EXPECT_TRUE(sweepRotations({Eigen::Vector3d::UnitZ()}, {}, 10).empty());
  EXPECT_EQ(sweepRotations({Eigen::Vector3d::UnitZ()}, {Eigen::Vector3d::UnitX()}, 1).size(), 1U);
}

} // namespace
} // namespace pcl_ssfr::test_rotation_candidates
