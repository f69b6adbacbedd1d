// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/paper_normals.h"
#include "preparation/voxel_sampling.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <pcl/features/normal_3d_omp.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace pcl_ssfr::test_paper_normals {
namespace {

using testing::viewOfPoints;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A grid of \p side x \p side points on the plane z = -1, 2 cm apart.
Eigen::Matrix3Xf
makeFloor(int side)
{
  Eigen::Matrix3Xf points(3, side * side);
  for (int i = 0; i < points.cols(); ++i) {
    const int row = i / side;
    points.col(i) << 0.02F * static_cast<float>(i % side), 0.02F * static_cast<float>(row), -1;
  }
  return points;
}

NormalOptions
keepAll(double radius)
{
  NormalOptions options;
  options.pre_leaf = 0;
  options.radius = radius;
  options.leaf = 1e-6;
  return options;
}

testing::ScanWithNormals
scanRoom()
{
  const testing::Scene room = testing::makeFurnishedRoom(1);
  return testing::castScanWithNormals(room, testing::sensorPose(room.stations[0], 0.3), testing::roomScanner(), 2);
}

TEST(NormalEstimation, PlaneByHand)
{
  const Eigen::Matrix3Xf points = makeFloor(20);
  const NormalEstimationResult result = estimateNormals(viewOfPoints(points), keepAll(0.1), true);
  ASSERT_EQ(result.samples.size(), 400);
  EXPECT_EQ(result.returns, 400U);
  EXPECT_NEAR(result.resolution, 0.02, 1e-4);
  EXPECT_TRUE(result.samples.oriented);
  EXPECT_LT((result.samples.normals.colwise() - Eigen::Vector3d::UnitZ()).norm(), 1e-3); // up, towards the sensor
  EXPECT_LT(((result.samples.points.colwise() + result.origin) - points.cast<double>()).norm(), 1e-4);
  EXPECT_EQ(result.samples.weights, Eigen::VectorXd::Ones(400));
  EXPECT_TRUE(result.samples.extents.isZero(0));
}

TEST(NormalEstimation, ViewpointDecidesTheSign)
{
  const Eigen::Matrix3Xf points = makeFloor(10);
  NormalOptions options = keepAll(0.1);
  options.away_from_viewpoint = true;
  EXPECT_LT(estimateNormals(viewOfPoints(points), options, true).samples.normals.row(2).maxCoeff(), -0.99);
  options.away_from_viewpoint = false;
  ScanView below = viewOfPoints(points);
  below.viewpoint << 0, 0, -5;
  EXPECT_LT(estimateNormals(below, options, true).samples.normals.row(2).maxCoeff(), -0.99);
  EXPECT_FALSE(estimateNormals(below, options, false).samples.oriented);
}

TEST(NormalEstimation, SameNormalsAsPcl)
{
  const testing::ScanWithNormals scan = scanRoom();
  const NormalEstimationResult result = estimateNormals(viewOfPoints(scan.points), keepAll(0.15), true, 2);

  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (Eigen::Index i = 0; i < scan.points.cols(); ++i)
    cloud->push_back({scan.points(0, i), scan.points(1, i), scan.points(2, i)});
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> pcl_estimation(2);
  pcl_estimation.setInputCloud(cloud);
  pcl_estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  pcl_estimation.setRadiusSearch(0.15);
  pcl::PointCloud<pcl::Normal> expected;
  pcl_estimation.compute(expected);

  // Ours drops what spans no plane; match the rest by position.
  std::map<std::array<float, 3>, std::size_t> columns;
  for (std::size_t i = 0; i < cloud->size(); ++i)
    columns[{{(*cloud)[i].x, (*cloud)[i].y, (*cloud)[i].z}}] = i;
  ASSERT_GT(result.samples.size(), static_cast<Eigen::Index>(0.95 * static_cast<double>(cloud->size())));
  Eigen::Index different = 0;
  for (Eigen::Index i = 0; i < result.samples.size(); ++i) {
    const Eigen::Vector3f point = (result.samples.points.col(i) + result.origin).cast<float>();
    const auto found = columns.find({{point.x(), point.y(), point.z()}});
    ASSERT_NE(found, columns.end());
    const Eigen::Vector3d normal = expected[found->second].getNormalVector3fMap().cast<double>();
    // Corners, where two eigenvalues are nearly equal, may turn with the last bit of the covariance.
    different += std::abs(normal.dot(result.samples.normals.col(i))) < 0.999 ? 1 : 0;
  }
  EXPECT_LT(different, result.samples.size() / 200);
}

TEST(NormalEstimation, FindsTheTrueNormalsOfARoom)
{
  const testing::ScanWithNormals scan = scanRoom();
  const NormalEstimationResult derived = estimateNormals(viewOfPoints(scan.points), NormalOptions(), true);
  EXPECT_GE(derived.radius, 0.1);
  EXPECT_LE(derived.radius, 0.9);
  NormalOptions options;
  options.radius = derived.radius;
  options.leaf = std::clamp(0.5 * derived.radius, 0.04, 0.1);
  const NormalEstimationResult again = estimateNormals(viewOfPoints(scan.points), options, true);
  ASSERT_EQ(derived.samples.size(), again.samples.size());
  EXPECT_TRUE(derived.samples.points == again.samples.points);
  options = NormalOptions();
  options.radius = 0.2;
  const NormalEstimationResult result = estimateNormals(viewOfPoints(scan.points), options, true);
  ASSERT_GT(result.samples.size(), 1000);
  Eigen::Index right = 0;
  for (Eigen::Index i = 0; i < result.samples.size(); ++i) {
    Eigen::Index nearest = 0;
    ((scan.points.cast<double>().colwise() - result.origin).colwise() - result.samples.points.col(i))
        .colwise()
        .squaredNorm()
        .minCoeff(&nearest);
    right += scan.normals.col(nearest).cast<double>().dot(result.samples.normals.col(i)) > 0.98 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(right) / static_cast<double>(result.samples.size()), 0.8);
}

TEST(NormalEstimation, DropsLinesPairsAndLonePoints)
{
  Eigen::Matrix3Xf points(3, 53);
  for (int i = 0; i < 50; ++i)
    points.col(i) << 0.01F * static_cast<float>(i), 1, 2;
  points.col(50) << 100, 0, 0;
  points.col(51) << 200, 0, 0;
  points.col(52) << 200, 0.01F, 0;
  EXPECT_EQ(estimateNormals(viewOfPoints(points), keepAll(0.1), true).samples.size(), 0);
}

TEST(NormalEstimation, SkipsWhatIsNotFiniteAndHonoursIndicesAndRange)
{
  const Eigen::Matrix3Xf clean = makeFloor(20);
  Eigen::Matrix3Xf dirty(3, 403);
  dirty.col(0).setConstant(kNan);
  dirty.middleCols(1, 400) = clean;
  dirty.col(401) << 0, std::numeric_limits<float>::infinity(), 0;
  dirty.col(402) << 0, 0, kNan;
  const NormalEstimationResult expected = estimateNormals(viewOfPoints(clean), keepAll(0.1), true);
  const NormalEstimationResult result = estimateNormals(viewOfPoints(dirty), keepAll(0.1), true);
  EXPECT_EQ(result.returns, 400U);
  EXPECT_EQ(result.samples.points, expected.samples.points);
  EXPECT_EQ(result.samples.normals, expected.samples.normals);

  const std::array<std::int32_t, 3> indices{{1, 2, 0}};
  ScanView few = viewOfPoints(dirty);
  few.indices = indices.data();
  few.index_count = indices.size();
  EXPECT_EQ(estimateNormals(few, keepAll(0.1), true).returns, 2U);

  NormalOptions near = keepAll(0.1);
  near.max_range = 1.05; // the floor's corner at 0.38, 0.38, -1 is farther
  const NormalEstimationResult cut = estimateNormals(viewOfPoints(clean), near, true);
  EXPECT_GT(cut.samples.size(), 50);
  EXPECT_LE((cut.samples.points.colwise() + cut.origin).colwise().norm().maxCoeff(), 1.05 + 1e-6);
  EXPECT_EQ(cut.returns, 400U);
}

TEST(NormalEstimation, BelievesGivenNormals)
{
  // Points and normals interleaved, as PCL stores them. The given normals are no plane normals: they must come back.
  const Eigen::Matrix3Xf floor = makeFloor(10);
  Eigen::Matrix<float, 6, Eigen::Dynamic> rows(6, floor.cols());
  rows.topRows<3>() = floor;
  const Eigen::Vector3f given = Eigen::Vector3f(1, 0, 3).normalized();
  rows.bottomRows<3>().colwise() = given;
  rows.bottomRows<3>().col(5).setConstant(kNan);
  rows.bottomRows<3>().col(7).setZero();
  ScanView view;
  view.xyz = rows.data();
  view.normals = rows.data() + 3;
  view.stride = 6;
  view.size = static_cast<std::size_t>(rows.cols());
  NormalOptions options = keepAll(0.1);
  NormalEstimationResult result = estimateNormals(view, options, true);
  ASSERT_EQ(result.samples.size(), 100);
  EXPECT_LT((result.samples.normals.col(0) - given.cast<double>()).norm(), 1e-6);
  EXPECT_LT((result.samples.normals.col(5) - Eigen::Vector3d::UnitZ()).norm(), 1e-3); // estimated
  EXPECT_LT((result.samples.normals.col(7) - Eigen::Vector3d::UnitZ()).norm(), 1e-3);
  options.use_given_normals = false;
  result = estimateNormals(view, options, true);
  EXPECT_LT((result.samples.normals.col(0) - Eigen::Vector3d::UnitZ()).norm(), 1e-3);
}

TEST(NormalEstimation, FarFromTheOriginAndForAnyNumberOfThreads)
{
  const testing::ScanWithNormals scan = scanRoom();
  const NormalEstimationResult here = estimateNormals(viewOfPoints(scan.points), NormalOptions(), true, 1);
  const NormalEstimationResult threaded = estimateNormals(viewOfPoints(scan.points), NormalOptions(), true, 8);
  EXPECT_EQ(here.samples.points, threaded.samples.points);
  EXPECT_EQ(here.samples.normals, threaded.samples.normals);
  EXPECT_EQ(here.resolution, threaded.resolution);

  const Eigen::Vector3f far(131072, -65536, 1024); // a float keeps 8 mm there
  Eigen::Matrix3Xf moved = scan.points.colwise() + far;
  ScanView view = viewOfPoints(moved);
  view.viewpoint = far.cast<double>();
  NormalOptions options;
  options.radius = 0.2;
  const NormalEstimationResult there = estimateNormals(view, options, true);
  EXPECT_LT((there.origin - far.cast<double>() - here.origin).norm(), 0.1);
  // Most samples still face the six directions of the room as before: up is up.
  const auto facingUp = [](const NormalEstimationResult& result) {
    return static_cast<double>((result.samples.normals.row(2).array() > 0.99).count()) /
           static_cast<double>(result.samples.size());
  };
  EXPECT_NEAR(facingUp(there), facingUp(here), 0.1);
}

TEST(NormalEstimation, EmptyIn)
{
  const NormalEstimationResult none = estimateNormals(ScanView(), NormalOptions(), true);
  EXPECT_EQ(none.samples.size(), 0);
  EXPECT_EQ(none.returns, 0U);
  const Eigen::Matrix3Xf nan = Eigen::Matrix3Xf::Constant(3, 10, kNan);
  EXPECT_EQ(estimateNormals(viewOfPoints(nan), NormalOptions(), true).samples.size(), 0);
  const Eigen::Matrix3Xf one = Eigen::Matrix3Xf::Ones(3, 1);
  EXPECT_EQ(estimateNormals(viewOfPoints(one), NormalOptions(), true).samples.size(), 0);
  const Eigen::Matrix3Xf same = Eigen::Matrix3Xf::Ones(3, 100);
  EXPECT_EQ(estimateNormals(viewOfPoints(same), NormalOptions(), true).samples.size(), 0);
}

// --- thinning to real points
// ------------------------------------------------------------------------------------------

TEST(VoxelSampling, KeepsThePointNearestToEachCentre)
{
  Points3 points(3, 5);
  points << 0.1, 0.45, 0.9, -0.1, 1.5, 0.1, 0.5, 0.9, 0.5, 0.5, 0.1, 0.5, 0.9, 0.5, 0.5;
  EXPECT_EQ(samplePerVoxel(points, 1), (std::vector<Eigen::Index>{1, 3, 4}));
  EXPECT_EQ(samplePerVoxel(points, 0).size(), 5U);
  EXPECT_TRUE(samplePerVoxel(Points3(3, 0), 1).empty());
}

TEST(VoxelSampling, AgreesWithAMapOfVoxels)
{
  testing::Random random(3);
  Points3 points(3, 2000);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) << random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2);
  std::map<std::array<int, 3>, std::pair<double, Eigen::Index>> best;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Array3d voxel = (points.col(i).array() / 0.4).floor();
    const double distance = (points.col(i).array() / 0.4 - voxel - 0.5).matrix().norm();
    const std::array<int, 3> key{
        {static_cast<int>(voxel.x()), static_cast<int>(voxel.y()), static_cast<int>(voxel.z())}};
    const auto [entry, fresh] = best.try_emplace(key, distance, i);
    if (!fresh && distance < entry->second.first)
      entry->second = {distance, i};
  }
  std::vector<Eigen::Index> expected;
  expected.reserve(best.size());
  for (const auto& [key, entry] : best)
    expected.push_back(entry.second);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(samplePerVoxel(points, 0.4), expected);
}

} // namespace
} // namespace pcl_ssfr::test_paper_normals
