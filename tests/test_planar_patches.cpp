// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "preparation/planar_patches.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace pcl_ssfr::test_planar_patches {
namespace {

using testing::kMaxFloat;
using testing::kNan;
using testing::viewOfPoints;

constexpr double kLeaf = 0.05;
constexpr double kThickness = 0.01;

ThinnedCloud
thin(const Eigen::Matrix3Xf& points, double leaf = kLeaf)
{
  return thinScan(viewOfPoints(points), leaf, Eigen::Vector3d::Zero());
}

/// A square of \p n x n points, one in the middle of each voxel, from (0, 0, z) on.
Eigen::Matrix3Xf
gridOnPlane(int n, float z)
{
  Eigen::Matrix3Xf points(3, n * n);
  for (int i = 0; i < n * n; ++i) {
    const int row = i / n;
    points.col(i) << (static_cast<float>(i % n) + 0.5f) * 0.05f, (static_cast<float>(row) + 0.5f) * 0.05f, z;
  }
  return points;
}

/// The room with 5 mm noise and with scattered points in it.
Eigen::Matrix3Xf
noisyRoom(std::uint64_t seed)
{
  Eigen::Matrix3Xf points = testing::samplePoints(testing::roomRectangles(), 150, seed);
  testing::Random random(seed);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      points(axis, i) += static_cast<float>(0.005 * random.gaussian());
      if (i % 20 == 0)
        points(axis, i) = static_cast<float>(random.uniform(-1, 1));
    }
  return points;
}

TEST(ExtractPatches, OnePlaneByHand)
{
  const Eigen::Matrix3Xf points = gridOnPlane(64, 0.52f); // one cell of level 6: 3.2 m
  const ThinnedCloud cloud = thin(points);
  ASSERT_EQ(cloud.size(), 64 * 64);
  const Eigen::Vector3d viewpoint(1, 1, -2);
  const PlanarPatches patches = extractPatches(cloud, &viewpoint, kThickness, PatchConfig());
  ASSERT_EQ(patches.size(), 1);
  EXPECT_TRUE(patches.samples.oriented);
  EXPECT_TRUE(patches.samples.points.col(0).isApprox(Eigen::Vector3d(1.6, 1.6, 0.52), 1e-6));
  EXPECT_TRUE(patches.samples.normals.col(0).isApprox(-Eigen::Vector3d::UnitZ(), 1e-6));
  EXPECT_NEAR(patches.samples.weights[0], 3.2 * 3.2, 0.01);
  EXPECT_NEAR(patches.samples.extents[0], 1.6, 0.01);
  EXPECT_NEAR(patches.half_minors[0], 1.6, 0.01);
  EXPECT_NEAR(patches.thickness[0], 0, 1e-6);
  EXPECT_NEAR(patches.majors.col(0).dot(patches.samples.normals.col(0)), 0, 1e-6);
  EXPECT_EQ(patches.counts, std::vector<std::uint32_t>{64 * 64});
  EXPECT_EQ(patches.first_point, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(patches.clutter.empty());
  const Eigen::Vector3d above(1, 1, 5);
  EXPECT_GT(extractPatches(cloud, &above, kThickness, PatchConfig()).samples.normals(2, 0), 0.999);
}

TEST(ExtractPatches, TellsHowFarAPatchFacesItsSensor)
{
  const ThinnedCloud cloud = thin(gridOnPlane(64, 0.52f));
  const auto facing = [&](const Eigen::Vector3d& viewpoint) {
    return extractPatches(cloud, &viewpoint, kThickness, PatchConfig()).samples.facing[0];
  };
  EXPECT_NEAR(facing({1.6, 1.6, -2}), 1, 1e-6);
  EXPECT_NEAR(facing({1.6, 1.6, 7}), 1, 1e-6);
  EXPECT_NEAR(facing({1.6 - 3, 1.6, 0.52 + 4}), 0.8, 1e-6);
  EXPECT_NEAR(facing({-9, 4, 0.52}), 0, 1e-6); // in the plane
  EXPECT_EQ(extractPatches(cloud, nullptr, kThickness, PatchConfig()).samples.facing[0], 1);
}

TEST(ExtractPatches, SideFromTheCloudsNormalsWhereTheViewpointIsUnknown)
{
  const Eigen::Matrix3Xf points = gridOnPlane(64, 0.52f);
  EXPECT_FALSE(extractPatches(thin(points), nullptr, kThickness, PatchConfig()).samples.oriented);
  Eigen::Matrix3Xf normals = Eigen::Vector3f(0, 0, -1).replicate(1, points.cols());
  ScanView view = viewOfPoints(points);
  view.normals = normals.data();
  PlanarPatches patches =
      extractPatches(thinScan(view, kLeaf, Eigen::Vector3d::Zero()), nullptr, kThickness, PatchConfig());
  EXPECT_TRUE(patches.samples.oriented);
  EXPECT_LT(patches.samples.normals(2, 0), -0.999);
  for (Eigen::Index i = 0; i < normals.cols(); i += 3) // normals that do not agree say nothing
    normals(2, i) = 1;
  patches = extractPatches(thinScan(view, kLeaf, Eigen::Vector3d::Zero()), nullptr, kThickness, PatchConfig());
  EXPECT_FALSE(patches.samples.oriented);
  // Nor where several points make one of the thinned cloud.
  patches = extractPatches(thinScan(view, 4 * kLeaf, Eigen::Vector3d::Zero()), nullptr, kThickness, PatchConfig());
  ASSERT_GT(patches.size(), 0);
  EXPECT_FALSE(patches.samples.oriented);
}

/// The subdivision written down naively: cell by cell from the codes, two-pass covariances.
struct NaiveSubdivision {
  const ThinnedCloud& cloud;
  const PatchConfig& options;
  Eigen::Vector3d viewpoint;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> patches; // first point, count
  std::vector<std::uint32_t> clutter;

  bool
  isPlane(std::size_t first, std::size_t count) const
  {
    const Eigen::MatrixXd p =
        cloud.points.middleCols(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count)).cast<double>();
    const Eigen::Vector3d mean = p.rowwise().mean();
    const Eigen::MatrixXd d = p.colwise() - mean;
    const Eigen::Vector3d deviations =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(d * d.transpose() / static_cast<double>(count))
            .eigenvalues()
            .cwiseMax(0)
            .cwiseSqrt();
    return deviations[0] <= kThickness + options.range_noise * (mean - viewpoint).norm() &&
           deviations[0] < options.max_flatness * deviations[1];
  }

  void
  divide(std::size_t begin, std::size_t end, int level)
  {
    while (begin < end) {
      std::size_t next = begin;
      while (next < end && cloud.codes[next] >> (3 * level) == cloud.codes[begin] >> (3 * level))
        ++next;
      const std::size_t count = next - begin;
      const bool enough = count >= static_cast<std::size_t>(options.min_points);
      if (enough && isPlane(begin, count))
        patches.emplace_back(begin, count);
      else if (enough && level > options.finest_level)
        divide(begin, next, level - 1);
      else
        for (std::size_t i = begin; i < next; ++i)
          clutter.push_back(static_cast<std::uint32_t>(i));
      begin = next;
    }
  }
};

TEST(ExtractPatches, AgreesWithNaiveSubdivision)
{
  for (const std::uint64_t seed : {1U, 2U}) {
    const ThinnedCloud cloud = thin(noisyRoom(seed));
    PatchConfig options;
    options.finest_level = seed == 1 ? 3 : 2;
    const Eigen::Vector3d viewpoint(0.2, -0.1, 0.3);
    NaiveSubdivision naive{cloud, options, viewpoint, {}, {}};
    naive.divide(0, cloud.codes.size(), options.coarsest_level);
    const PlanarPatches patches = extractPatches(cloud, &viewpoint, kThickness, options);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
    for (std::size_t i = 0; i < patches.counts.size(); ++i)
      found.emplace_back(patches.first_point[i], patches.counts[i]);
    EXPECT_EQ(found, naive.patches);
    EXPECT_EQ(patches.clutter, naive.clutter);
    EXPECT_GT(patches.size(), 50);
    EXPECT_GT(patches.clutter.size(), 50U);
  }
}

TEST(ExtractPatches, EveryPatchDescribesItsPoints)
{
  const ThinnedCloud cloud = thin(noisyRoom(3));
  const Eigen::Vector3d viewpoint(0.2, -0.1, 0.3);
  const PlanarPatches patches = extractPatches(cloud, &viewpoint, kThickness, PatchConfig());
  for (Eigen::Index i = 0; i < patches.size(); ++i) {
    const auto u = static_cast<std::size_t>(i);
    const Eigen::MatrixXd p = cloud.points.middleCols(patches.first_point[u], patches.counts[u]).cast<double>();
    const Eigen::Vector3d mean = p.rowwise().mean();
    const Eigen::MatrixXd d = p.colwise() - mean;
    const Eigen::Matrix3d covariance = d * d.transpose() / static_cast<double>(p.cols());
    const Eigen::Vector3d normal = patches.samples.normals.col(i), major = patches.majors.col(i);
    const double half_major = patches.samples.extents[i], half_minor = patches.half_minors[i];
    ASSERT_LT((patches.samples.points.col(i) - mean).norm(), 1e-9);
    const Eigen::Vector3d minor = normal.cross(major);
    ASSERT_LT((half_major * half_major / 3 * major * major.transpose() +
               half_minor * half_minor / 3 * minor * minor.transpose() +
               patches.thickness[i] * patches.thickness[i] * normal * normal.transpose() - covariance)
                  .norm(),
              1e-8);
    EXPECT_NEAR(normal.norm(), 1, 1e-12);
    EXPECT_NEAR(normal.dot(covariance * normal), patches.thickness[i] * patches.thickness[i], 1e-9);
    EXPECT_NEAR(3 * major.dot(covariance * major), half_major * half_major, 1e-8);
    EXPECT_NEAR(patches.samples.weights[i], 4 * half_major * half_minor, 1e-9);
    EXPECT_GE(half_major, half_minor);
    EXPECT_GT(half_minor, 0);
    EXPECT_GE((viewpoint - mean).dot(normal), 0);
  }
}

TEST(ExtractPatches, ThickOrRoundIsClutter)
{
  testing::Random random(4);
  Eigen::Matrix3Xf ball(3, 3000);
  for (Eigen::Index i = 0; i < ball.cols(); ++i)
    ball.col(i) << static_cast<float>(random.uniform(0, 1)), static_cast<float>(random.uniform(0, 1)),
        static_cast<float>(random.uniform(0, 1));
  const ThinnedCloud cloud = thin(ball);
  const PlanarPatches patches = extractPatches(cloud, nullptr, kThickness, PatchConfig());
  EXPECT_EQ(patches.size(), 0);
  EXPECT_EQ(patches.clutter.size(), static_cast<std::size_t>(cloud.size()));
}

TEST(ExtractPatches, LineIsNoPlane)
{
  // As from a planar laser: no extent across the line but rounding.
  Eigen::Matrix3Xf line(3, 2000);
  for (Eigen::Index i = 0; i < line.cols(); ++i)
    line.col(i) = Eigen::Vector3f(0.31f, 0.17f, 0) + static_cast<float>(i) * 0.005f * Eigen::Vector3f(0.6f, 0.8f, 0);
  const PlanarPatches flat = extractPatches(thin(line), nullptr, kThickness, PatchConfig());
  EXPECT_EQ(flat.size(), 0);
  line = Eigen::Matrix3Xf(Eigen::Quaternionf(0.3f, 0.5f, -0.2f, 0.7f).normalized().toRotationMatrix() * line);
  EXPECT_EQ(extractPatches(thin(line), nullptr, kThickness, PatchConfig()).size(), 0);
}

TEST(ExtractPatches, Degenerate)
{
  const Eigen::Vector3d viewpoint(0, 0, 0);
  const PlanarPatches none = extractPatches(ThinnedCloud(), &viewpoint, kThickness, PatchConfig());
  EXPECT_EQ(none.size(), 0);
  EXPECT_EQ(none.samples.normals.cols(), 0);
  EXPECT_TRUE(none.clutter.empty());
  const Eigen::Matrix3Xf same = Eigen::Matrix3Xf::Constant(3, 100, 1.f);
  EXPECT_EQ(extractPatches(thin(same), &viewpoint, kThickness, PatchConfig()).clutter.size(), 1U);
  const Eigen::Matrix3Xf nans = Eigen::Matrix3Xf::Constant(3, 100, kNan);
  EXPECT_EQ(extractPatches(thin(nans), &viewpoint, kThickness, PatchConfig()).size(), 0);
  // Identical points that were not thinned: no extent at all.
  ThinnedCloud identical;
  identical.leaf = kLeaf;
  identical.points = Eigen::Matrix3Xf::Constant(3, 50, 0.7f);
  identical.codes.assign(50, 5);
  identical.counts.assign(50, 1);
  EXPECT_EQ(extractPatches(identical, &viewpoint, kThickness, PatchConfig()).size(), 0);
}

TEST(ExtractPatches, FarFromTheOrigin)
{
  // Moved by whole cells (32 m), 20 km away: the same patches to the resolution of float there.
  const Eigen::Matrix3Xf points = gridOnPlane(64, 0.52f);
  Eigen::Matrix3Xf far = points;
  far.colwise() += Eigen::Vector3f(19200, -19200, 9600);
  const ThinnedCloud near_cloud = thin(points), far_cloud = thin(far);
  const PlanarPatches patches = extractPatches(far_cloud, nullptr, kThickness, PatchConfig());
  EXPECT_EQ(patches.size(), extractPatches(near_cloud, nullptr, kThickness, PatchConfig()).size());
  ASSERT_EQ(patches.size(), 1);
  EXPECT_NEAR(std::abs(patches.samples.normals(2, 0)), 1, 1e-5);
}

TEST(ExtractPatches, SurvivesExtremeNumbers)
{
  for (const float scale : {1e-40f, 1e-30f, 1e6f, 1e18f, 1e30f, kMaxFloat / 4}) {
    const Eigen::Matrix3Xf points = gridOnPlane(64, 0.52f) * scale;
    const ThinnedCloud cloud = thin(points, kLeaf * static_cast<double>(scale));
    const Eigen::Vector3d viewpoint = Eigen::Vector3d::Constant(static_cast<double>(scale));
    const PlanarPatches patches =
        extractPatches(cloud, &viewpoint, kThickness * static_cast<double>(scale), PatchConfig());
    std::size_t points_out = patches.clutter.size();
    for (const std::uint32_t count : patches.counts)
      points_out += count;
    EXPECT_EQ(points_out, static_cast<std::size_t>(cloud.size())) << scale;
    EXPECT_TRUE(patches.samples.normals.allFinite()) << scale;
    EXPECT_TRUE(patches.samples.weights.allFinite()) << scale;
    EXPECT_GT(patches.size(), 0) << scale;
  }
}

TEST(SelectPatches, KeepsWhatIsAskedFor)
{
  const Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  const PlanarPatches all = extractPatches(thin(noisyRoom(3)), &viewpoint, kThickness, {});
  ASSERT_GT(all.size(), 8);
  const std::vector<Eigen::Index> indices = {7, 0, 7};
  const PlanarPatches some = selectPatches(all, indices);
  ASSERT_EQ(some.size(), 3);
  EXPECT_EQ(some.samples.oriented, all.samples.oriented);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Eigen::Index i = indices[static_cast<std::size_t>(k)];
    EXPECT_EQ(some.samples.points.col(k), all.samples.points.col(i));
    EXPECT_EQ(some.samples.normals.col(k), all.samples.normals.col(i));
    EXPECT_EQ(some.samples.extents[k], all.samples.extents[i]);
    EXPECT_EQ(some.samples.weights[k], all.samples.weights[i]);
    EXPECT_EQ(some.samples.facing[k], all.samples.facing[i]);
    EXPECT_EQ(some.majors.col(k), all.majors.col(i));
    EXPECT_EQ(some.half_minors[k], all.half_minors[i]);
    EXPECT_EQ(some.thickness[k], all.thickness[i]);
    EXPECT_EQ(some.counts[static_cast<std::size_t>(k)], all.counts[static_cast<std::size_t>(i)]);
    EXPECT_EQ(some.first_point[static_cast<std::size_t>(k)], all.first_point[static_cast<std::size_t>(i)]);
  }
  EXPECT_EQ(selectPatches(all, {}).size(), 0);
  PlanarPatches seen_from_nowhere = all;
  seen_from_nowhere.samples.facing.resize(0);
  EXPECT_EQ(selectPatches(seen_from_nowhere, {3}).samples.facing.size(), 0);
  EXPECT_THROW(selectPatches(all, {all.size()}), std::out_of_range);
  EXPECT_THROW(selectPatches(all, {-1}), std::out_of_range);
}

} // namespace
} // namespace pcl_ssfr::test_planar_patches
