// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "baselines/congruent_sets.h"
#include "baselines/lcp_verifier.h"
#include "judgement/overlap.h"
#include "pose_matchers.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/baselines/super4pcs.h>
#include <pcl_ssfr/detail/neighbor_index.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::baselines::test_super4pcs {
namespace {

using pcl_ssfr::testing::castScan;
using pcl_ssfr::testing::IsPoseNear;
using pcl_ssfr::testing::makeFurnishedRoom;
using pcl_ssfr::testing::makeSymmetricRoom;
using pcl_ssfr::testing::makeUnrelatedRooms;
using pcl_ssfr::testing::Random;
using pcl_ssfr::testing::randomMotion;
using pcl_ssfr::testing::relativePose;
using pcl_ssfr::testing::roomScanner;
using pcl_ssfr::testing::Scene;
using pcl_ssfr::testing::sensorPose;
using pcl_ssfr::testing::transformed;
using pcl_ssfr::testing::viewOfPoints;

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180;

Points3
randomPoints(Random& random, Eigen::Index count, double half_size)
{
  Points3 points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      points(k, i) = random.uniform(-half_size, half_size);
  }
  return points;
}

std::vector<PointPair>
allPairs(const Points3& points, double length, double tolerance)
{
  std::vector<PointPair> pairs;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      if (i != j && std::abs((points.col(j) - points.col(i)).norm() - length) <= tolerance)
        pairs.push_back({i, j});
    }
  }
  return pairs;
}

TEST(PairExtractor, AgreesWithAllPairs)
{
  Random random(1);
  const Points3 points = randomPoints(random, 400, 5);
  const PairExtractor extractor(points);
  std::size_t found = 0;
  for (const double length : {0.0, 0.5, 3.0, 8.0, 17.0, 40.0}) {
    for (const double tolerance : {0.001, 0.1, 1.0}) {
      const std::vector<PointPair> expected = allPairs(points, length, tolerance);
      EXPECT_EQ(extractor.extract(length, tolerance), expected) << length << " +- " << tolerance;
      EXPECT_EQ(extractor.extract(length, tolerance, 3), expected) << length << " +- " << tolerance;
      found += expected.size();
    }
  }
  EXPECT_GT(found, 10000U);
}

// A grid puts many points exactly on the sphere and on the faces of the cells; some points are there twice.
TEST(PairExtractor, AgreesWithAllPairsOnAGrid)
{
  Points3 points(3, 250);
  for (Eigen::Index i = 0; i < 250; ++i) {
    const Eigen::Index k = i % 216, layer = k / 36;
    points.col(i) << static_cast<double>(k % 6), static_cast<double>(k / 6 % 6), static_cast<double>(layer);
  }
  const PairExtractor extractor(points);
  for (const double length : {0.0, 1.0, 2.0, 3.0, std::sqrt(2.0), 5.0}) {
    for (const double tolerance : {0.0, 1e-12, 0.5})
      EXPECT_EQ(extractor.extract(length, tolerance), allPairs(points, length, tolerance)) << length;
  }
}

TEST(PairExtractor, FewPoints)
{
  EXPECT_TRUE(PairExtractor(Points3(3, 0)).extract(1, 0.1).empty());
  EXPECT_TRUE(PairExtractor(Points3::Zero(3, 1)).extract(0, 1).empty());
  EXPECT_EQ(PairExtractor(Points3::Constant(3, 20, 1.5)).extract(0, 0.1).size(), 20U * 19U);
  EXPECT_TRUE(PairExtractor(Points3::Constant(3, 20, 1.5)).extract(1, 0.1).empty());
  // Neighbouring numbers: the middle of the box is one of its corners.
  Points3 close = Points3::Ones(3, 20);
  close.rightCols(10).setConstant(std::nextafter(1.0, 2.0));
  EXPECT_EQ(PairExtractor(close).extract(0, 0.1).size(), 20U * 19U);
}

/// Corners of a square of side 2 and others.
Points3
squarePoints()
{
  Points3 points(3, 6);
  points.col(0) << 0, 0, 0;
  points.col(1) << 2, 0, 0;
  points.col(2) << 2, 2, 0;
  points.col(3) << 0, 2, 0;
  points.col(4) << 1.2, 0.6, 0;
  points.col(5) << 0, 2, 1;
  return points;
}

TEST(MakeBase, FindsTheDiagonals)
{
  const std::optional<CoplanarBase> base = makeBase(squarePoints(), {0, 1, 2, 3}, 1e-6);
  ASSERT_TRUE(base);
  EXPECT_EQ(base->points, (Quad{0, 2, 1, 3}));
  EXPECT_NEAR(base->first_length, std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(base->second_length, std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(base->first_ratio, 0.5, 1e-12);
  EXPECT_NEAR(base->second_ratio, 0.5, 1e-12);
  EXPECT_NEAR(base->angle, kPi / 2, 1e-12);
}

TEST(MakeBase, RatiosOfAnUnevenCross)
{
  // Segments from (0,0) to (4,0) and from (1,-1) to (1,3): they cross at (1,0).
  Points3 points(3, 4);
  points << 0, 4, 1, 1, 0, 0, -1, 3, 0, 0, 0, 0;
  const std::optional<CoplanarBase> base = makeBase(points, {0, 1, 2, 3}, 1e-6);
  ASSERT_TRUE(base);
  EXPECT_NEAR(base->first_ratio, 0.25, 1e-12);
  EXPECT_NEAR(base->second_ratio, 0.25, 1e-12);
}

TEST(MakeBase, RefusesWhatDoesNotCross)
{
  const Points3 points = squarePoints();
  EXPECT_FALSE(makeBase(points, {0, 1, 2, 4}, 1e-6)) << "a point inside the triangle of the others";
  EXPECT_FALSE(makeBase(points, {0, 1, 2, 5}, 0.1)) << "not coplanar";
  EXPECT_TRUE(makeBase(points, {0, 1, 2, 5}, 1.0)) << "coplanar enough";
  EXPECT_FALSE(makeBase(points, {0, 0, 0, 0}, 1));
  Points3 line(3, 4);
  line << 0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0;
  EXPECT_FALSE(makeBase(line, {0, 1, 2, 3}, 1));
}

TEST(SelectBase, IsWideCoplanarAndCrosses)
{
  Random random(2);
  const Points3 points = randomPoints(random, 2000, 5);
  std::mt19937_64 engine(7);
  constexpr double kDiameter = 6;
  constexpr double kThickness = 0.1;
  int found = 0;
  for (int run = 0; run < 30; ++run) {
    const std::optional<CoplanarBase> base = selectBase(points, kDiameter, kThickness, engine);
    if (!base)
      continue;
    ++found;
    const auto at = [&](std::size_t k) { return Eigen::Vector3d(points.col(base->points[k])); };
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_LE((at(i) - at(j)).norm(), kDiameter);
        EXPECT_GE((at(i) - at(j)).norm(), 0.2 * kDiameter * 0.999);
      }
    }
    const Eigen::Vector3d first = at(0) + base->first_ratio * (at(1) - at(0));
    const Eigen::Vector3d second = at(2) + base->second_ratio * (at(3) - at(2));
    EXPECT_LE((first - second).norm(), kThickness);
    EXPECT_NEAR(base->first_length, (at(1) - at(0)).norm(), 1e-12);
    EXPECT_NEAR(std::cos(base->angle), (at(1) - at(0)).normalized().dot((at(3) - at(2)).normalized()), 1e-9);
  }
  EXPECT_GE(found, 20);
}

TEST(SelectBase, NothingToSelect)
{
  std::mt19937_64 engine(1);
  EXPECT_FALSE(selectBase(Points3(3, 0), 1, 0.1, engine));
  EXPECT_FALSE(selectBase(Points3::Zero(3, 3), 1, 0.1, engine));
  EXPECT_FALSE(selectBase(Points3::Ones(3, 50), 1, 0.1, engine));
  Points3 line = Points3::Zero(3, 50);
  line.row(0) = Eigen::RowVectorXd::LinSpaced(50, 0, 10);
  EXPECT_FALSE(selectBase(line, 10, 0.1, engine));
}

std::vector<Quad>
allQuads(const Points3& points,
         const std::vector<PointPair>& first_pairs,
         const std::vector<PointPair>& second_pairs,
         const CoplanarBase& base,
         const QuadTolerance& tolerance)
{
  std::vector<Quad> quads;
  for (const PointPair& second : second_pairs) {
    for (const PointPair& first : first_pairs) {
      const Eigen::Vector3d u = points.col(first.second) - points.col(first.first);
      const Eigen::Vector3d v = points.col(second.second) - points.col(second.first);
      const Eigen::Vector3d gap =
          points.col(first.first) + base.first_ratio * u - points.col(second.first) - base.second_ratio * v;
      const double angle = std::acos(std::clamp(u.normalized().dot(v.normalized()), -1.0, 1.0));
      const bool distinct = first.first != second.first && first.first != second.second &&
                            first.second != second.first && first.second != second.second;
      if (distinct && gap.norm() <= tolerance.distance && std::abs(angle - base.angle) <= tolerance.angle)
        quads.push_back({first.first, first.second, second.first, second.second});
    }
  }
  return quads;
}

TEST(FilterByNormals, KeepsPairsThatLieLikeTheBase)
{
  // Two points on the floor, one on a wall, one whose normal is unknown.
  Points3 points(3, 4);
  points << 0, 3, 5, 4, 0, 0, 0, 1, 0, 0, 2, 0;
  Points3 normals(3, 4);
  normals << 0, 0, -1, 0, 0, 0, 0, 0, 1, -1, 0, 0;
  const SegmentNormals on_floor = measureNormals(points, normals, {0, 1});
  EXPECT_NEAR(on_floor.first, kPi / 2, 1e-12);
  EXPECT_NEAR(on_floor.second, kPi / 2, 1e-12);
  EXPECT_NEAR(on_floor.between, 0, 1e-7) << "the signs do not matter";
  const SegmentNormals to_wall = measureNormals(points, normals, {0, 2});
  EXPECT_NEAR(to_wall.first, std::acos(2 / std::sqrt(29.0)), 1e-12);
  EXPECT_NEAR(to_wall.second, std::acos(5 / std::sqrt(29.0)), 1e-12);
  EXPECT_NEAR(to_wall.between, kPi / 2, 1e-12);

  const std::vector<PointPair> pairs = {{0, 1}, {1, 0}, {0, 2}, {2, 0}, {1, 2}, {0, 3}};
  EXPECT_EQ(filterByNormals(points, normals, pairs, on_floor, 0.1), (std::vector<PointPair>{{0, 1}, {1, 0}, {0, 3}}));
  EXPECT_EQ(filterByNormals(points, normals, pairs, to_wall, 0.1), (std::vector<PointPair>{{0, 2}}));
  EXPECT_EQ(filterByNormals(points, normals, pairs, to_wall, kPi / 2), pairs);
  // A base that knows nothing of its normals takes every pair.
  EXPECT_EQ(filterByNormals(points, Points3::Zero(3, 4), pairs, to_wall, 0.1), pairs);
}

TEST(CongruentQuads, AgreeWithExhaustiveSearch)
{
  Random random(4);
  std::size_t found = 0;
  for (int run = 0; run < 6; ++run) {
    const Points3 points = randomPoints(random, 60, 2);
    CoplanarBase base;
    base.first_length = random.uniform(1, 3);
    base.second_length = random.uniform(1, 3);
    base.first_ratio = random.uniform(0.1, 0.9);
    base.second_ratio = random.uniform(0.1, 0.9);
    base.angle = random.uniform(0.4, 2.7);
    const std::vector<PointPair> first_pairs = allPairs(points, base.first_length, 0.3);
    const std::vector<PointPair> second_pairs = allPairs(points, base.second_length, 0.3);
    for (const QuadTolerance tolerance : {QuadTolerance{0.3, 0.15}, {0.05, 3.0}, {1.5, 0.02}}) {
      const std::vector<Quad> expected = allQuads(points, first_pairs, second_pairs, base, tolerance);
      EXPECT_EQ(findCongruentQuads(points, first_pairs, second_pairs, base, tolerance), expected) << "run " << run;
      EXPECT_EQ(findCongruentQuads(points, first_pairs, second_pairs, base, tolerance, 3), expected);
      found += expected.size();
    }
  }
  EXPECT_GT(found, 5000U);
}

TEST(CongruentQuads, ContainTheBaseUnderARigidMotion)
{
  Random random(5);
  const Points3 target = randomPoints(random, 300, 5);
  std::mt19937_64 engine(3);
  int bases = 0;
  for (int run = 0; run < 10; ++run) {
    const std::optional<CoplanarBase> base = selectBase(target, 8, 0.2, engine);
    if (!base)
      continue;
    ++bases;
    const Points3 source = randomMotion(random, 10) * target;
    const PairExtractor extractor(source);
    QuadTolerance tolerance;
    tolerance.distance = 0.2 + 1e-9; // as thick as the base is
    tolerance.angle = 1e-6;
    const std::vector<Quad> quads = findCongruentQuads(source,
                                                       extractor.extract(base->first_length, 1e-9),
                                                       extractor.extract(base->second_length, 1e-9),
                                                       *base,
                                                       tolerance);
    EXPECT_NE(std::find(quads.begin(), quads.end(), base->points), quads.end()) << "run " << run;
    EXPECT_LT(quads.size(), 20U); // of 300^4
  }
  EXPECT_GE(bases, 5);
}

TEST(CongruentQuads, NothingToFind)
{
  CoplanarBase base;
  base.angle = 1;
  const Points3 points = Points3::Random(3, 5);
  EXPECT_TRUE(findCongruentQuads(points, {}, {{0, 1}}, base, {1, 1}).empty());
  EXPECT_TRUE(findCongruentQuads(points, {{0, 1}}, {}, base, {1, 1}).empty());
  EXPECT_TRUE(findCongruentQuads(points, {{0, 1}}, {{1, 2}}, base, {100, 4}).empty()) << "a point is used twice";
  EXPECT_EQ(findCongruentQuads(points, {{0, 1}}, {{2, 3}}, base, {100, 4}).size(), 1U);
}

TEST(LcpVerifier, AgreesWithBruteForce)
{
  Random random(6);
  const Points3 target = randomPoints(random, 500, 3);
  const Points3 source = randomPoints(random, 300, 3.5);
  for (const double radius : {0.05, 0.3, 1.0}) {
    const LcpVerifier verifier(source, target, radius);
    for (int run = 0; run < 10; ++run) {
      const Eigen::Isometry3d T = randomMotion(random, run < 5 ? 1 : 20);
      Eigen::Index expected = 0;
      for (Eigen::Index i = 0; i < source.cols(); ++i) {
        const double nearest = (target.colwise() - T * source.col(i)).colwise().norm().minCoeff();
        expected += nearest < radius ? 1 : 0;
      }
      EXPECT_EQ(verifier.count(T, 0), expected);
      EXPECT_EQ(verifier.count(T, expected), 0) << "not better than the floor";
      EXPECT_EQ(verifier.count(T, expected - 1), expected);
      EXPECT_EQ(verifier.count(T, 300), 0);
    }
  }
  EXPECT_EQ(LcpVerifier(source, Points3(3, 0), 1).count(Eigen::Isometry3d::Identity(), 0), 0);
  EXPECT_EQ(LcpVerifier(Points3(3, 0), target, 1).count(Eigen::Isometry3d::Identity(), 0), 0);
}

/// Two scans of one apartment and the pose between them.
struct Scans {
  Eigen::Matrix3Xf source;
  Eigen::Matrix3Xf target;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
};

Scans
makeScans(std::uint64_t seed, const Eigen::Vector3d& shift)
{
  constexpr double kStep = 0.035; // 2 degrees
  const Scene scene = makeFurnishedRoom(seed);
  const Eigen::Isometry3d T_world_target = sensorPose(scene.stations.at(0), 0.1);
  const Eigen::Isometry3d T_world_source = sensorPose(scene.stations.at(0) + shift, 1.9, 0.1);
  Scans scans;
  scans.target = castScan(scene, T_world_target, roomScanner(kStep), 11);
  scans.source = castScan(scene, T_world_source, roomScanner(kStep), 12);
  scans.T_target_source = relativePose(T_world_target, T_world_source);
  return scans;
}

/// The scans of these tests are too thin for a leaf from the data: delta would be 30 cm.
Super4PcsOptions
optionsFor(double overlap)
{
  Super4PcsOptions options;
  options.leaf = 0.1;
  options.overlap = overlap;
  return options;
}

bool
sameBits(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
  return a.matrix() == b.matrix();
}

TEST(Super4PCS, FindsTheMotionOfAMovedCopy)
{
  const Eigen::Matrix3Xf target = makeScans(1, Eigen::Vector3d::Zero()).target;
  Random random(5);
  const Eigen::Isometry3d T = randomMotion(random, 1);
  const Eigen::Matrix3Xf source = transformed(T.inverse(), target);
  const Super4PcsOptions options = optionsFor(0.9);
  const BaselineResult result = registerSuper4Pcs(viewOfPoints(source), viewOfPoints(target), options);
  EXPECT_TRUE(result.converged) << result.message;
  EXPECT_THAT(result.T_target_source, IsPoseNear(T, 3 * kDegree, 1.5 * result.inlier_distance)) << result.message;
  EXPECT_GT(result.overlap, 0.9);
}

/// Points on a closed bumpy surface of about 3 m radius, without any symmetry.
Eigen::Matrix3Xf
bumpySurface(Random& random, Eigen::Index count, double noise)
{
  constexpr int kBumps = 12;
  Random bump_random(17);
  std::vector<Eigen::Vector3d> bumps;
  bumps.reserve(kBumps);
  for (int k = 0; k < kBumps; ++k)
    bumps.emplace_back(pcl_ssfr::testing::randomRotation(bump_random).col(0));
  Eigen::Matrix3Xf points(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian()).normalized();
    double radius = 3;
    for (std::size_t k = 0; k < bumps.size(); ++k) {
      const double height = k % 2 == 0 ? 2 : -1.5;
      radius += height * std::exp(-(direction - bumps[k]).squaredNorm() / 0.15);
    }
    for (int k = 0; k < 3; ++k)
      points(k, i) = static_cast<float>(radius * direction[k] + noise * random.gaussian());
  }
  return points;
}

/// The share of the points that lies farthest back along a direction.
Eigen::Matrix3Xf
rearPart(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& direction, double share)
{
  const Eigen::VectorXf along = points.transpose() * direction;
  std::vector<float> sorted(along.data(), along.data() + along.size());
  std::sort(sorted.begin(), sorted.end());
  const float limit = sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size()))];
  Eigen::Matrix3Xf kept(3, points.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (along[i] < limit)
      kept.col(count++) = points.col(i);
  }
  return kept.leftCols(count);
}

// 46 % of either scan is seen by the other too, by other samples of the surface, with noise. Three scenes that are
// solved within 100 bases when the search knows which LCP to stop at; how many bases others need is not tested.
TEST(Super4PCS, CopesWith46PercentOverlapAndNoise)
{
  const Eigen::Vector3f axis = Eigen::Vector3f(1, 0.4F, 0.3F).normalized();
  for (const std::uint64_t seed : {2U, 3U, 6U}) {
    Random random(seed);
    const Eigen::Isometry3d T = randomMotion(random, 1);
    const Eigen::Matrix3Xf target = rearPart(bumpySurface(random, 40000, 0.01), axis, 0.65);
    const Eigen::Matrix3Xf source = transformed(T.inverse(), rearPart(bumpySurface(random, 40000, 0.01), -axis, 0.65));
    const NeighborIndex index(target.cast<double>());
    constexpr double kSpacing = 0.1; // twice that of the samples [m]
    EXPECT_NEAR(computeOverlap(source.cast<double>(), index, T, kSpacing, 1).ratio, 0.46, 0.04);
    Super4PcsOptions options = optionsFor(0.45);
    options.seed = seed;
    options.max_bases = 100;
    options.target_lcp = 0.41; // the truth's or nearly; wrong poses reach 0.37
    const BaselineResult result = registerSuper4Pcs(viewOfPoints(source), viewOfPoints(target), options);
    EXPECT_TRUE(result.converged) << result.message;
    EXPECT_THAT(result.T_target_source, IsPoseNear(T, 4 * kDegree, 2 * result.inlier_distance))
        << result.message << ", seed " << seed;
  }
}

TEST(Super4PCS, HalfTurnOfASymmetricRoomIsAsGood)
{
  const Scene scene = makeSymmetricRoom();
  const Eigen::Isometry3d pose = sensorPose(Eigen::Vector3d(0, 0, scene.stations.at(0).z()), 0);
  const Eigen::Matrix3Xf target = castScan(scene, pose, roomScanner(0.035), 1);
  const Eigen::Isometry3d T(Eigen::AngleAxisd(1, Eigen::Vector3d(0.2, 0.3, 1).normalized()));
  const Eigen::Matrix3Xf source = transformed(T.inverse(), target);
  const Super4PcsOptions options = optionsFor(0.9);
  const BaselineResult result = registerSuper4Pcs(viewOfPoints(source), viewOfPoints(target), options);
  EXPECT_TRUE(result.converged) << result.message;
  const Eigen::Isometry3d half_turn(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitZ()));
  EXPECT_THAT(result.T_target_source,
              ::testing::AnyOf(IsPoseNear(T, 4 * kDegree, 1.5 * result.inlier_distance),
                               IsPoseNear(half_turn * T, 4 * kDegree, 1.5 * result.inlier_distance)));
}

TEST(Super4PCS, SaysWhenScansAreUnrelated)
{
  const auto [first, second] = makeUnrelatedRooms(3);
  const Eigen::Matrix3Xf source = castScan(first, sensorPose(first.stations.at(0), 0.3), roomScanner(0.035), 1);
  const Eigen::Matrix3Xf target = castScan(second, sensorPose(second.stations.at(0), 2), roomScanner(0.035), 2);
  const Super4PcsOptions options = optionsFor(0.9);
  const BaselineResult result = registerSuper4Pcs(viewOfPoints(source), viewOfPoints(target), options);
  EXPECT_FALSE(result.converged) << result.message;
  EXPECT_NE(result.message.find("needed"), std::string::npos) << result.message;
}

TEST(Super4PCS, SameBitsForAnyNumberOfThreads)
{
  const Scans scans = makeScans(1, Eigen::Vector3d(0.4, -0.3, 0));
  const auto run = [&](unsigned threads, std::uint64_t seed) {
    Super4PcsOptions options;
    options.max_bases = 3;
    options.threads = threads;
    options.seed = seed;
    return registerSuper4Pcs(viewOfPoints(scans.source), viewOfPoints(scans.target), options);
  };
  const BaselineResult one = run(1, 1);
  EXPECT_GT(one.overlap, 0);
  for (const unsigned threads : {1U, 3U}) {
    const BaselineResult other = run(threads, 1);
    EXPECT_TRUE(sameBits(one.T_target_source, other.T_target_source)) << threads << " threads";
    EXPECT_EQ(one.message, other.message);
  }
  EXPECT_FALSE(sameBits(one.T_target_source, run(1, 2).T_target_source)) << "the seed has no effect";
}

TEST(Super4PCS, StopsWhenTold)
{
  const Scans scans = makeScans(1, Eigen::Vector3d(0.4, -0.3, 0));
  Super4PcsOptions options = optionsFor(0.5);
  options.max_bases = 3;
  const BaselineResult three = registerSuper4Pcs(viewOfPoints(scans.source), viewOfPoints(scans.target), options);
  EXPECT_EQ(three.iterations, 3);
  options.max_bases = 100;
  options.target_lcp = 0.01;
  const BaselineResult easy = registerSuper4Pcs(viewOfPoints(scans.source), viewOfPoints(scans.target), options);
  EXPECT_LT(easy.iterations, 20);
  EXPECT_GE(easy.overlap, 0.01);
  options = {};
  options.time_limit = 1e-9;
  for (const TimeLimitClock clock : {TimeLimitClock::Wall, TimeLimitClock::Processor}) {
    options.time_limit_clock = clock;
    const BaselineResult late = registerSuper4Pcs(viewOfPoints(scans.source), viewOfPoints(scans.target), options);
    EXPECT_EQ(late.iterations, 0);
    EXPECT_FALSE(late.converged);
    EXPECT_NE(late.message.find("time limit"), std::string::npos) << late.message;
  }
}

TEST(Super4PCS, GuessIsACandidate)
{
  const Scans scans = makeScans(1, Eigen::Vector3d(0.1, -0.1, 0));
  Super4PcsOptions options;
  options.target_lcp = 0.5;
  const BaselineResult result =
      registerSuper4Pcs(viewOfPoints(scans.source), viewOfPoints(scans.target), options, scans.T_target_source);
  EXPECT_EQ(result.iterations, 0) << "good enough, no base needed";
  EXPECT_THAT(result.T_target_source, IsPoseNear(scans.T_target_source, 1e-6, 1e-6));
  EXPECT_TRUE(result.converged);
}

TEST(Super4PCS, NothingToWorkWith)
{
  const Eigen::Matrix3Xf scan = makeScans(1, Eigen::Vector3d::Zero()).target.leftCols(500);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  Eigen::Matrix3Xf line(3, 200);
  for (Eigen::Index i = 0; i < 200; ++i)
    line.col(i) = Eigen::Vector3f(static_cast<float>(i), 1, 2);
  const std::vector<std::pair<std::string, Eigen::Matrix3Xf>> clouds = {
      {"empty", Eigen::Matrix3Xf(3, 0)},
      {"one point", Eigen::Matrix3Xf::Constant(3, 1, 1.0F)},
      {"one place", Eigen::Matrix3Xf::Constant(3, 50, 1.0F)},
      {"three points", Eigen::Matrix3Xf(Eigen::Matrix3Xf::Random(3, 3))},
      {"all NaN", Eigen::Matrix3Xf::Constant(3, 50, kNaN)},
      {"line", line},
  };
  Super4PcsOptions options;
  options.max_bases = 5;
  for (const auto& [name, cloud] : clouds) {
    for (const bool is_source : {true, false}) {
      const BaselineResult result =
          registerSuper4Pcs(viewOfPoints(is_source ? cloud : scan), viewOfPoints(is_source ? scan : cloud), options);
      EXPECT_FALSE(result.message.empty()) << name;
      EXPECT_TRUE(pcl_ssfr::testing::isRigid(result.T_target_source)) << name;
      EXPECT_FALSE(result.converged) << name << (is_source ? " as source: " : " as target: ") << result.message;
    }
  }
}

TEST(Super4PCS, RefusesOptionsByName)
{
  const Eigen::Matrix3Xf scan = Eigen::Matrix3Xf::Random(3, 100);
  Super4PcsOptions options;
  options.overlap = 0;
  try {
    registerSuper4Pcs(viewOfPoints(scan), viewOfPoints(scan), options);
    FAIL() << "accepted";
  }
  catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "overlap = 0, must be in (0, 1]");
  }
}

} // namespace
} // namespace pcl_ssfr::baselines::test_super4pcs
