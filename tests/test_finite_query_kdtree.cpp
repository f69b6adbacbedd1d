// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The search tree that is built when it is first asked, against brute force and against PCL's own.

#include "synthetic_scene.h"

#include <pcl_ssfr/detail/finite_query_kdtree.h>

#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

namespace pcl_ssfr::test_finite_query_kdtree {
namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Tree = FiniteQueryKdTree<Point>;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Points in a cube of 10 m, some of them not finite.
Cloud::Ptr
randomCloud(std::size_t size, std::uint64_t seed)
{
  testing::Random random(seed);
  auto cloud = pcl::make_shared<Cloud>();
  for (std::size_t i = 0; i < size; ++i) {
    Point point;
    for (int axis = 0; axis < 3; ++axis)
      point.data[axis] = static_cast<float>(random.uniform(-5, 5));
    if (i % 50 == 7)
      point.y = kNaN;
    cloud->push_back(point);
  }
  return cloud;
}

/// Squared distances from \p query to the finite points of \p cloud, ascending.
std::vector<float>
sortedDistances(const Cloud& cloud, const Point& query)
{
  std::vector<float> distances;
  for (const Point& point : cloud)
    if (point.getVector3fMap().allFinite())
      distances.push_back((point.getVector3fMap() - query.getVector3fMap()).squaredNorm());
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(FiniteQueryKdTree, IsBuiltByTheFirstQuery)
{
  const Cloud::Ptr cloud = randomCloud(100, 1);
  pcl::Indices indices;
  std::vector<float> distances;
  const auto near = [&](Tree& tree) { return tree.nearestKSearch(Point(0, 0, 0), 1, indices, distances); };
  const auto around = [&](Tree& tree) { return tree.radiusSearch(Point(0, 0, 0), 20, indices, distances); };
  const auto numbered = [&](Tree& tree) { return tree.nearestKSearch(3, 1, indices, distances); };
  for (const std::function<int(Tree&)>& query : {std::function<int(Tree&)>(near), {around}, {numbered}}) {
    Tree tree;
    EXPECT_FALSE(tree.isBuilt());
    tree.setInputCloud(cloud);
    EXPECT_FALSE(tree.isBuilt());
    EXPECT_EQ(tree.getInputCloud(), cloud);
    EXPECT_GT(query(tree), 0);
    EXPECT_TRUE(tree.isBuilt());
    tree.setInputCloud(cloud); // announced again: edited perhaps
    EXPECT_FALSE(tree.isBuilt());
  }
  // What needs no index does not build it.
  Tree tree;
  tree.setInputCloud(cloud);
  EXPECT_EQ(tree.nearestKSearch(Point(kNaN, 0, 0), 1, indices, distances), 0);
  tree.setInputCloud(pcl::make_shared<Cloud>());
  EXPECT_EQ(near(tree), 0);
  EXPECT_FALSE(tree.isBuilt());
}

TEST(FiniteQueryKdTree, ACloudThatChangedBeforeTheFirstQuery)
{
  pcl::Indices indices;
  std::vector<float> distances;
  const Point far(50, 0, 0);
  const auto distanceOfFar = [&](Tree& tree) {
    const int found = tree.nearestKSearch(far, 1, indices, distances);
    return std::pair(found, distances.at(0));
  };
  const Cloud::Ptr cloud = randomCloud(100, 1);
  Tree first;
  first.setInputCloud(cloud);
  const auto before = distanceOfFar(first);

  Tree tree;
  tree.setInputCloud(cloud);
  cloud->push_back(far); // as a map grows by what was just registered to it
  EXPECT_EQ(distanceOfFar(tree), before) << "what was appended is not searched";
  tree.setInputCloud(cloud);
  EXPECT_EQ(distanceOfFar(tree), std::pair(1, 0.0F));

  tree.setInputCloud(cloud);
  cloud->resize(50);
  EXPECT_EQ(distanceOfFar(tree).first, 0) << "the cloud has lost points";
  tree.setInputCloud(cloud);
  EXPECT_EQ(distanceOfFar(tree).first, 1);
  tree.setInputCloud(cloud);
  for (Point& point : *cloud)
    point.x = kNaN;
  EXPECT_EQ(distanceOfFar(tree).first, 0) << "no point is finite any more";
  tree.setInputCloud(cloud);
  cloud->clear();
  EXPECT_EQ(distanceOfFar(tree), std::pair(0, std::numeric_limits<float>::infinity()));
  EXPECT_EQ(tree.radiusSearch(far, 100, indices, distances), 0);
  EXPECT_FALSE(tree.isBuilt());
}

TEST(FiniteQueryKdTree, AgreesWithBruteForceAndPcl)
{
  Tree tree;
  pcl::search::KdTree<Point> pcls;
  testing::Random random(3);
  for (const std::size_t size : {1U, 9U, 2000U}) {
    const Cloud::Ptr cloud = randomCloud(size, size); // another cloud each time: nothing of the last one is left
    tree.setInputCloud(cloud);
    pcls.setInputCloud(cloud);
    for (int q = 0; q < 100; ++q) {
      const Point query(static_cast<float>(random.uniform(-6, 6)),
                        static_cast<float>(random.uniform(-6, 6)),
                        static_cast<float>(random.uniform(-6, 6)));
      const std::vector<float> all = sortedDistances(*cloud, query);
      pcl::Indices indices, pcls_indices;
      std::vector<float> distances, pcls_distances;
      const int found = tree.nearestKSearch(query, 5, indices, distances);
      ASSERT_EQ(found, static_cast<int>(std::min<std::size_t>(5, all.size())));
      ASSERT_EQ(found, pcls.nearestKSearch(query, 5, pcls_indices, pcls_distances));
      EXPECT_EQ(distances, pcls_distances);
      for (std::size_t k = 0; k < static_cast<std::size_t>(found); ++k) {
        EXPECT_FLOAT_EQ(distances[k], all[k]);
        EXPECT_FLOAT_EQ(
            (cloud->at(static_cast<std::size_t>(indices[k])).getVector3fMap() - query.getVector3fMap()).squaredNorm(),
            distances[k]);
      }
      EXPECT_EQ(tree.nearestKSearch(query, 1, indices, distances), all.empty() ? 0 : 1);
      pcls.nearestKSearch(query, 1, pcls_indices, pcls_distances);
      EXPECT_EQ(indices, pcls_indices);
      EXPECT_EQ(distances, pcls_distances);
      constexpr float kRadius = 1.5F;
      const auto within = std::upper_bound(all.begin(), all.end(), kRadius * kRadius) - all.begin();
      EXPECT_EQ(tree.radiusSearch(query, kRadius, indices, distances), within);
    }
  }
}

TEST(FiniteQueryKdTree, OfEquallyNearPointsTheFirst)
{
  const auto cloud = pcl::make_shared<Cloud>();
  for (int i = 0; i < 100; ++i)
    cloud->push_back(i % 3 == 0 ? Point(kNaN, 0, 0) : Point(1, 2, 3));
  Tree tree;
  tree.setInputCloud(cloud);
  pcl::Indices indices;
  std::vector<float> distances;
  EXPECT_EQ(tree.nearestKSearch(Point(1, 2, 4), 1, indices, distances), 1);
  EXPECT_EQ(indices, pcl::Indices{1});
  EXPECT_EQ(distances, std::vector<float>{1});
}

TEST(FiniteQueryKdTree, PointsOnceIndexedStayAsTheyWere)
{
  const Cloud::Ptr cloud = randomCloud(100, 8);
  const Point last = cloud->back();
  Tree tree;
  tree.setInputCloud(cloud);
  pcl::Indices indices;
  std::vector<float> distances;
  for (const int k : {1, 2})
    tree.nearestKSearch(last, k, indices, distances);
  cloud->clear();
  cloud->points.shrink_to_fit();
  for (const int k : {1, 2}) {
    EXPECT_EQ(tree.nearestKSearch(last, k, indices, distances), k);
    EXPECT_EQ(indices[0], 99);
    EXPECT_EQ(distances[0], 0.0F);
  }
}

/// Points are compared as on a plan.
class PlanRepresentation : public pcl::PointRepresentation<Point> {
public:
  PlanRepresentation() { nr_dimensions_ = 2; }
  void
  copyToFloatArray(const Point& point, float* out) const override
  {
    out[0] = point.x;
    out[1] = point.y;
  }
};

TEST(FiniteQueryKdTree, AnotherRepresentationHolds)
{
  const auto cloud = pcl::make_shared<Cloud>();
  cloud->push_back(Point(0, 0, 9));
  cloud->push_back(Point(2, 0, 0));
  Tree tree;
  tree.setInputCloud(cloud);
  pcl::Indices indices;
  std::vector<float> distances;
  tree.nearestKSearch(Point(0, 0, 0), 1, indices, distances);
  EXPECT_EQ(indices, pcl::Indices{1});
  tree.setPointRepresentation(pcl::make_shared<PlanRepresentation>());
  tree.nearestKSearch(Point(0, 0, 0), 1, indices, distances);
  EXPECT_EQ(indices, pcl::Indices{0});
  EXPECT_EQ(distances, std::vector<float>{0});
}

TEST(FiniteQueryKdTree, IndicesChooseThePoints)
{
  const Cloud::Ptr cloud = randomCloud(200, 4);
  const auto chosen = pcl::make_shared<pcl::Indices>();
  for (int i = 0; i < 200; i += 3)
    chosen->push_back(i);
  Tree tree;
  tree.setInputCloud(cloud, chosen);
  pcl::Indices indices;
  std::vector<float> distances;
  EXPECT_FALSE(tree.isBuilt());
  tree.radiusSearch(Point(0, 0, 0), 100, indices, distances);
  for (const pcl::index_t i : indices)
    EXPECT_EQ(i % 3, 0);
  EXPECT_GT(indices.size(), 60U);
  for (const Point& query : *cloud) {
    tree.nearestKSearch(query, 1, indices, distances);
    EXPECT_EQ(indices[0] % 3, query.getVector3fMap().allFinite() ? 0 : pcl::UNAVAILABLE);
  }
}

TEST(FiniteQueryKdTree, SettingsOutliveTheCloud)
{
  Tree tree;
  tree.setEpsilon(0.25F);
  tree.setSortedResults(false);
  const auto representation = tree.getPointRepresentation();
  pcl::Indices indices;
  std::vector<float> distances;
  for (std::uint64_t seed : {1, 2, 3}) {
    tree.setInputCloud(randomCloud(50, seed));
    EXPECT_EQ(tree.nearestKSearch(Point(0, 0, 0), 1, indices, distances), 1);
    EXPECT_EQ(tree.getEpsilon(), 0.25F);
    EXPECT_EQ(tree.getPointRepresentation(), representation);
  }
  // Sorted again: of an index that is there and of the next.
  tree.setSortedResults(true);
  for (int k = 0; k < 2; ++k) {
    tree.radiusSearch(Point(0, 0, 0), 100, indices, distances);
    EXPECT_GT(distances.size(), 40U);
    EXPECT_TRUE(std::is_sorted(distances.begin(), distances.end()));
    tree.setInputCloud(randomCloud(50, 9));
  }
}

TEST(FiniteQueryKdTree, AnEarlierCloudIsLetGo)
{
  Tree tree;
  Cloud::Ptr first = randomCloud(50, 5);
  const std::weak_ptr<Cloud> watched = first;
  tree.setInputCloud(first);
  pcl::Indices indices;
  std::vector<float> distances;
  tree.nearestKSearch(Point(0, 0, 0), 1, indices, distances);
  first.reset();
  EXPECT_FALSE(watched.expired());
  tree.setInputCloud(randomCloud(50, 6));
  EXPECT_TRUE(watched.expired());
}

TEST(FiniteQueryKdTree, FirstQueryFromManyThreads)
{
  constexpr std::size_t kThreads = 8;
  const Cloud::Ptr cloud = randomCloud(20000, 7);
  for (int round = 0; round < 5; ++round) {
    Tree tree;
    tree.setInputCloud(cloud);
    std::vector<pcl::Indices> found(kThreads), nearest(kThreads);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < kThreads; ++t)
      threads.emplace_back([&tree, &found, &nearest, t] {
        std::vector<float> distances;
        tree.nearestKSearch(Point(0.5F, -1, 2), 1, nearest[t], distances);
        tree.nearestKSearch(Point(0.5F, -1, 2), 10, found[t], distances);
      });
    for (std::thread& thread : threads)
      thread.join();
    for (std::size_t t = 0; t < kThreads; ++t) {
      EXPECT_EQ(found[t].size(), 10U);
      EXPECT_EQ(found[t], found[0]);
      EXPECT_EQ(nearest[t], pcl::Indices{found[0][0]});
    }
  }
}

} // namespace
} // namespace pcl_ssfr::test_finite_query_kdtree
