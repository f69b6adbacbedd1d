// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "preparation/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace pcl_ssfr::test_thinning {
namespace {

using testing::kInf;
using testing::kMaxFloat;
using testing::kNan;
using testing::viewOfPoints;

Eigen::Matrix3Xf
randomCloud(Eigen::Index count, float size, std::uint64_t seed)
{
  testing::Random random(seed);
  Eigen::Matrix3Xf points(3, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      points(axis, i) = static_cast<float>(random.uniform(-1, 1)) * size;
  return points;
}

/// Morton code of the voxel of \p p (relative to the origin), bit by bit; x is the lowest of each three bits.
std::uint64_t
naiveCode(const Eigen::Vector3d& p, double leaf)
{
  std::uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto voxel = static_cast<std::uint64_t>(std::floor(p[axis] / leaf) + 1048576);
    for (int bit = 0; bit < 21; ++bit)
      code |= ((voxel >> bit) & 1) << (3 * bit + axis);
  }
  return code;
}

void
expectEqual(const ThinnedCloud& a, const ThinnedCloud& b)
{
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.points == b.points);
  EXPECT_TRUE(a.normals == b.normals);
  EXPECT_EQ(a.codes, b.codes);
  EXPECT_EQ(a.counts, b.counts);
}

/// What holds for every thinned cloud.
void
expectConsistent(const ThinnedCloud& thinned, std::size_t points_in)
{
  const auto n = static_cast<std::size_t>(thinned.size());
  ASSERT_EQ(thinned.codes.size(), n);
  ASSERT_EQ(thinned.counts.size(), n);
  EXPECT_TRUE(thinned.points.allFinite());
  EXPECT_LE(std::accumulate(thinned.counts.begin(), thinned.counts.end(), std::size_t{0}), points_in);
  EXPECT_TRUE(std::adjacent_find(thinned.codes.begin(), thinned.codes.end(), std::greater_equal<>()) ==
              thinned.codes.end());
}

TEST(ThinScan, ByHand)
{
  Eigen::Matrix3Xf points(3, 5);
  points.col(0) << 0.2f, 0.2f, 0.2f;
  points.col(1) << 1.5f, 0.f, 0.f;
  points.col(2) << kNan, 0.f, 0.f;
  points.col(3) << 0.4f, 0.6f, 0.8f;
  points.col(4) << -0.1f, 0.f, 0.f;
  const ThinnedCloud thinned = thinScan(viewOfPoints(points), 1.0, Eigen::Vector3d::Zero());
  ASSERT_EQ(thinned.size(), 3);
  EXPECT_EQ(thinned.counts, (std::vector<std::uint32_t>{1, 2, 1}));
  EXPECT_TRUE(thinned.points.col(0).isApprox(Eigen::Vector3f(-0.1f, 0, 0)));
  EXPECT_TRUE(thinned.points.col(1).isApprox(Eigen::Vector3f(0.3f, 0.4f, 0.5f)));
  EXPECT_TRUE(thinned.points.col(2).isApprox(Eigen::Vector3f(1.5f, 0, 0)));
  EXPECT_EQ(thinned.codes[2], thinned.codes[1] + 1);
  EXPECT_EQ(thinned.normals.cols(), 0);
  EXPECT_EQ(thinned.leaf, 1.0);
}

TEST(ThinScan, AgreesWithMapOfVoxels)
{
  Eigen::Matrix4Xf storage(4, 5000); // PCL's stride
  storage.topRows<3>() = randomCloud(5000, 4, 1);
  storage.row(3).setConstant(1e9f);
  for (Eigen::Index i = 0; i < 5000; i += 97)
    storage(i % 3, i) = i % 2 ? kNan : -kInf;
  std::vector<std::int32_t> indices;
  for (std::int32_t i = 4999; i >= 0; i -= 2)
    indices.push_back(i);
  ScanView view;
  view.xyz = storage.data();
  view.stride = 4;
  view.size = 5000;
  view.indices = indices.data();
  view.index_count = indices.size();
  const Eigen::Vector3d origin(0.3, -1.7, 0.01);
  for (const double leaf : {0.05, 0.31, 2.0, 100.0}) {
    std::map<std::uint64_t, std::pair<Eigen::Vector3d, std::uint32_t>> voxels;
    for (const std::int32_t i : indices) {
      const Eigen::Vector3d p = storage.col(i).head<3>().cast<double>() - origin;
      if (!p.allFinite())
        continue;
      auto& [sum, count] = voxels.try_emplace(naiveCode(p, leaf), Eigen::Vector3d::Zero(), 0).first->second;
      sum += p;
      ++count;
    }
    const ThinnedCloud thinned = thinScan(view, leaf, origin);
    ASSERT_EQ(static_cast<std::size_t>(thinned.size()), voxels.size());
    Eigen::Index k = 0;
    for (const auto& [code, voxel] : voxels) {
      const auto u = static_cast<std::size_t>(k);
      EXPECT_EQ(thinned.codes[u], code);
      EXPECT_EQ(thinned.counts[u], voxel.second);
      EXPECT_LT((thinned.points.col(k).cast<double>() - voxel.first / voxel.second).norm(), 1e-6);
      ++k;
    }
  }
}

TEST(ThinScan, OctreeCellsAreContiguousRanges)
{
  const Eigen::Matrix3Xf points = randomCloud(20000, 3, 2);
  const double leaf = 0.1;
  const ThinnedCloud thinned = thinScan(viewOfPoints(points), leaf, Eigen::Vector3d::Zero());
  for (int level = 1; level < 7; ++level) {
    const double edge = leaf * (1 << level);
    std::set<std::uint64_t> seen;
    std::set<std::array<long, 3>> cells;
    for (Eigen::Index i = 0; i < thinned.size(); ++i) {
      const auto u = static_cast<std::size_t>(i);
      const std::uint64_t code = thinned.codes[u] >> (3 * level);
      if (i == 0 || code != thinned.codes[u - 1] >> (3 * level)) {
        EXPECT_TRUE(seen.insert(code).second) << "a cell of level " << level << " in two pieces";
      }
      const Eigen::Vector3d cell = (thinned.points.col(i).cast<double>() / edge).array().floor();
      cells.insert({std::lround(cell.x()), std::lround(cell.y()), std::lround(cell.z())});
    }
    EXPECT_EQ(seen.size(), cells.size());
  }
}

TEST(ThinScan, SameBitsForAnyNumberOfThreads)
{
  // So many that several threads are used; nearly every point of the finer one has a voxel of its own.
  Eigen::Matrix3Xf points = randomCloud(400001, 5, 3);
  for (Eigen::Index i = 0; i < points.cols(); i += 1013)
    points(i % 3, i) = kNan;
  for (const double leaf : {0.02, 0.2, 3.0}) {
    const ThinnedCloud one = thinScan(viewOfPoints(points), leaf, Eigen::Vector3d(1, 2, 3), 4.5, 1);
    expectConsistent(one, 400001);
    for (const unsigned threads : {2U, 3U, 8U, 1000U})
      expectEqual(thinScan(viewOfPoints(points), leaf, Eigen::Vector3d(1, 2, 3), 4.5, threads), one);
  }
}

TEST(ThinScan, SumsInTheOrderOfTheScan)
{
  // Sums of these depend on the order: double cannot hold the small ones next to the large ones.
  Eigen::Matrix3Xf points(3, 7);
  points.row(0) << 1e8f, 0.3f, -1e8f, 0.7f, 3e7f, -3e7f, 0.1f;
  points.row(1) = points.row(0).reverse() * 1e8f;
  points.row(2) = 3 * points.row(0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    sum += points.col(i).cast<double>();
  const ThinnedCloud thinned =
      thinScan(viewOfPoints(points), 1e17, Eigen::Vector3d::Constant(-5e16)); // all in one voxel, about its middle
  ASSERT_EQ(thinned.size(), 1);
  const Eigen::Vector3f mean = (sum / 7 + Eigen::Vector3d::Constant(5e16)).cast<float>();
  EXPECT_TRUE(thinned.points.col(0) == mean);
}

TEST(ThinScan, CellsFarApart)
{
  // Two voxels of each of many cells, far from each other: more cells than any table begins with.
  constexpr Eigen::Index kCells = 20000;
  Eigen::Matrix3Xf points(3, 4 * kCells);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Index cell = i % kCells, layer = cell / 729;
    points.col(i) = Eigen::Vector3f(static_cast<float>(cell % 27), static_cast<float>(cell / 27 % 27), 0) * 1000.f;
    points(2, i) = static_cast<float>(layer) * -1000.f + static_cast<float>(i / kCells % 2) + 0.25f;
  }
  const ThinnedCloud thinned = thinScan(viewOfPoints(points), 0.5, Eigen::Vector3d::Zero());
  expectConsistent(thinned, static_cast<std::size_t>(points.cols()));
  ASSERT_EQ(thinned.size(), 2 * kCells);
  for (Eigen::Index i = 0; i < thinned.size(); ++i) {
    ASSERT_EQ(thinned.counts[static_cast<std::size_t>(i)], 2U);
    ASSERT_EQ(thinned.codes[static_cast<std::size_t>(i)], naiveCode(thinned.points.col(i).cast<double>(), 0.5));
  }
}

TEST(ThinScan, EndsWhenTheTimeHasRunOut)
{
  const Eigen::Matrix3Xf points = randomCloud(1000, 5, 8);
  const Deadline past = Deadline::after(1e-9);
  while (!past.hasPassed()) {
  }
  EXPECT_EQ(thinScan(viewOfPoints(points), 0.2, Eigen::Vector3d::Zero(), 0, 1, past).size(), 0);
  expectEqual(thinScan(viewOfPoints(points), 0.2, Eigen::Vector3d::Zero(), 0, 1, Deadline::after(3600)),
              thinScan(viewOfPoints(points), 0.2, Eigen::Vector3d::Zero()));
}

TEST(ThinScan, OrderOfThePointsDoesNotMatter)
{
  const Eigen::Matrix3Xf points = randomCloud(6000, 3, 4);
  const Eigen::Matrix3Xf reversed = points.rowwise().reverse();
  const ThinnedCloud a = thinScan(viewOfPoints(points), 0.4, Eigen::Vector3d::Zero());
  const ThinnedCloud b = thinScan(viewOfPoints(reversed), 0.4, Eigen::Vector3d::Zero());
  EXPECT_EQ(a.codes, b.codes);
  EXPECT_EQ(a.counts, b.counts);
  EXPECT_TRUE(a.points.isApprox(b.points, 1e-6f));
}

TEST(ThinScan, AveragesUnitNormalsOnly)
{
  Eigen::Matrix3Xf points = Eigen::Matrix3Xf::Constant(3, 5, 0.5f);
  Eigen::Matrix3Xf normals(3, 5);
  normals.col(0) << 1, 0, 0;
  normals.col(1) << 0, 1, 0;
  normals.col(2) << kNan, 0, 0;
  normals.col(3) << 0, 0, 0;
  normals.col(4) << 7, 0, 0;
  ScanView view = viewOfPoints(points);
  view.normals = normals.data();
  const ThinnedCloud thinned = thinScan(view, 1, Eigen::Vector3d::Zero());
  ASSERT_EQ(thinned.normals.cols(), 1);
  EXPECT_TRUE(thinned.normals.col(0).isApprox(Eigen::Vector3f(1, 1, 0)));
  EXPECT_EQ(thinned.counts[0], 5U);
}

TEST(ThinScan, DropsWhatIsTooFarToCode)
{
  Eigen::Matrix3Xf points(3, 4);
  points << 0.5f, 9, 11, 2e6f, 0, 0, 0, 0, 0, 0, 0, 0;
  EXPECT_EQ(thinScan(viewOfPoints(points), 1, Eigen::Vector3d::Zero()).size(), 3); // 2^20 voxels on each side
  EXPECT_EQ(thinScan(viewOfPoints(points), 2, Eigen::Vector3d::Zero()).size(), 4);
  EXPECT_EQ(thinScan(viewOfPoints(points), 2, Eigen::Vector3d::Zero(), 10).size(), 2);
}

TEST(ThinScan, LargeOffsetLosesNothing)
{
  Eigen::Matrix3Xf far = randomCloud(3000, 5, 5);
  const Eigen::Vector3d offset(1e6, -1e6, 1e6);
  far.colwise() += offset.cast<float>();
  const Eigen::Matrix3Xf near = (far.cast<double>().colwise() - offset).cast<float>(); // exact: the grid of far
  expectEqual(thinScan(viewOfPoints(far), 0.3, offset), thinScan(viewOfPoints(near), 0.3, Eigen::Vector3d::Zero()));
}

TEST(ThinScan, Degenerate)
{
  const Eigen::Matrix3Xf none(3, 0);
  EXPECT_EQ(thinScan(viewOfPoints(none), 0.1, Eigen::Vector3d::Zero()).size(), 0);
  EXPECT_EQ(thinScan(ScanView(), 0.1, Eigen::Vector3d::Zero(), 0, 8).size(), 0);
  const Eigen::Matrix3Xf nans = Eigen::Matrix3Xf::Constant(3, 7, kNan);
  EXPECT_EQ(thinScan(viewOfPoints(nans), 0.1, Eigen::Vector3d::Zero()).size(), 0);
  const Eigen::Matrix3Xf one = Eigen::Matrix3Xf::Constant(3, 1, 1.25f);
  const ThinnedCloud single = thinScan(viewOfPoints(one), 0.1, Eigen::Vector3d::Zero());
  ASSERT_EQ(single.size(), 1);
  EXPECT_TRUE(single.points.col(0) == one.col(0));
  const Eigen::Matrix3Xf same = Eigen::Matrix3Xf::Constant(3, 1000, -1.25f);
  const ThinnedCloud identical = thinScan(viewOfPoints(same), 0.1, Eigen::Vector3d::Zero());
  ASSERT_EQ(identical.size(), 1);
  EXPECT_EQ(identical.counts[0], 1000U);
  EXPECT_TRUE(identical.points.col(0) == same.col(0));
}

TEST(ThinScan, SurvivesExtremeNumbers)
{
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  Eigen::Matrix3Xf points(3, 9);
  points.row(0) << 0, kTiny, -kTiny, 1e30f, -1e30f, kMaxFloat, -kMaxFloat, kInf, 1;
  points.row(1) << 0, 0, kTiny, 1e30f, 1, -kMaxFloat, kMaxFloat, 0, kNan;
  points.row(2) << 0, 0, 0, 0, 1e-30f, kMaxFloat, kMaxFloat, 0, 0;
  for (const double leaf : {5e-324, 1e-310, 1e-40, 0.05, 1e30, 1e300, std::numeric_limits<double>::max()})
    for (const double origin : {0.0, 1.0, -3e38, 1e300}) {
      SCOPED_TRACE(::testing::Message() << leaf << " " << origin);
      const ThinnedCloud thinned = thinScan(viewOfPoints(points), leaf, Eigen::Vector3d::Constant(origin), 0, 2);
      expectConsistent(thinned, 7);
    }
  // The far points do not take the near ones with them: 0 and +-1.4e-45, on both sides of a voxel's border.
  EXPECT_EQ(thinScan(viewOfPoints(points), 0.05, Eigen::Vector3d::Zero()).size(), 2);
  EXPECT_EQ(thinScan(viewOfPoints(points), 1e-40, Eigen::Vector3d::Zero()).size(), 2);
}

TEST(MeasureExtent, ByHand)
{
  Eigen::Matrix3Xf points(3, 5);
  points << 0, 2, kNan, 1, 1, 0, 0, 0, 3, kInf, 0, 0, 0, -3, 0;
  ScanView view = viewOfPoints(points);
  view.viewpoint = Eigen::Vector3d(5, 5, 5); // else the first point would be at the sensor
  const ScanExtent extent = measureExtent(view);
  EXPECT_EQ(extent.returns, 3U);
  EXPECT_EQ(extent.min, Eigen::Vector3d(0, 0, -3));
  EXPECT_EQ(extent.max, Eigen::Vector3d(2, 3, 0));
  EXPECT_EQ(extent.median, Eigen::Vector3d(1, 0, 0));
  EXPECT_NEAR(extent.radius, 1, 1e-12); // of 1, 1 and sqrt(18): 90 % of three, rounded down
}

TEST(MeasureExtent, RadiusIsTheNinetiethPercentile)
{
  const Eigen::Matrix3Xf points = randomCloud(60000, 5, 6);
  const ScanExtent extent = measureExtent(viewOfPoints(points));
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    distances.push_back((points.col(i).cast<double>() - extent.median).norm());
  std::sort(distances.begin(), distances.end());
  EXPECT_NEAR(extent.radius, distances[54000], 0.05);
  // The same far away, to the resolution of float there.
  Eigen::Matrix3Xf far = points;
  far.colwise() += Eigen::Vector3f(1e6f, 1e6f, 1e6f);
  EXPECT_NEAR(measureExtent(viewOfPoints(far)).radius, extent.radius, 0.1);
}

/// As many drivers write them: two points at the sensor before each return.
Eigen::Matrix3Xf
amongPointsAt(const Eigen::Vector3f& sensor, const Eigen::Matrix3Xf& returns)
{
  Eigen::Matrix3Xf points = sensor.replicate(1, 3 * returns.cols());
  for (Eigen::Index i = 0; i < returns.cols(); ++i)
    points.col(3 * i + 2) = returns.col(i);
  return points;
}

TEST(Returns, PointsAtTheSensorAreNone)
{
  const Eigen::Matrix3Xf returns = randomCloud(3000, 5, 8);
  for (const Eigen::Vector3d& sensor : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1.7, -2.3, 0.1)}) {
    const Eigen::Matrix3Xf points = amongPointsAt(sensor.cast<float>(), returns);
    ScanView all = viewOfPoints(points), only = viewOfPoints(returns);
    all.viewpoint = only.viewpoint = sensor;
    const ScanExtent extent = measureExtent(all), expected = measureExtent(only);
    EXPECT_EQ(extent.returns, 3000U);
    EXPECT_EQ(extent.median, expected.median);
    EXPECT_EQ(extent.radius, expected.radius);
    EXPECT_EQ(extent.min, expected.min);
    EXPECT_EQ(thinScan(all, 0.3, extent.median).points, thinScan(only, 0.3, extent.median).points);
    all.viewpoint.x() += 0.5; // a point like any other
    EXPECT_EQ(measureExtent(all).returns, 9000U);
  }
  EXPECT_EQ(measureExtent(viewOfPoints(Eigen::Matrix3Xf::Zero(3, 100))).returns, 0U);
}

TEST(MeasureExtent, Degenerate)
{
  const Eigen::Matrix3Xf none(3, 0);
  EXPECT_EQ(measureExtent(viewOfPoints(none)).returns, 0U);
  EXPECT_EQ(measureExtent(viewOfPoints(none)).radius, 0);
  const Eigen::Matrix3Xf nans = Eigen::Matrix3Xf::Constant(3, 7, kNan);
  EXPECT_EQ(measureExtent(viewOfPoints(nans)).returns, 0U);
  EXPECT_EQ(measureExtent(viewOfPoints(nans)).max, Eigen::Vector3d::Zero());
  const Eigen::Matrix3Xf same = Eigen::Matrix3Xf::Constant(3, 100, 3.f);
  EXPECT_EQ(measureExtent(viewOfPoints(same)).radius, 0);
  EXPECT_EQ(measureExtent(viewOfPoints(same)).median, Eigen::Vector3d(3, 3, 3));
  Eigen::Matrix3Xf huge(3, 2);
  huge.col(0).setConstant(kMaxFloat);
  huge.col(1).setConstant(-kMaxFloat);
  const ScanExtent extent = measureExtent(viewOfPoints(huge));
  EXPECT_TRUE(std::isfinite(extent.radius));
}

} // namespace
} // namespace pcl_ssfr::test_thinning
