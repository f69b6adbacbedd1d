// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "preparation/range_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace pcl_ssfr::test_range_image {
namespace {

using testing::kInf;
using testing::kMaxFloat;
using testing::kNan;

constexpr double kCell = 0.01745;

Eigen::Vector3f
randomDirection(testing::Random& random)
{
  const Eigen::Vector3d d(random.gaussian(), random.gaussian(), random.gaussian());
  return d.normalized().cast<float>();
}

TEST(RangeImage, ByHand)
{
  Eigen::Matrix3Xf points(3, 4);
  points.col(0) << 3, 2, 3;
  points.col(1) << 6, 2, 3;
  points.col(2) << 4, 2, 3;
  points.col(3) << 1, 2, 8;
  const RangeImage image(points, Eigen::Vector3f(1, 2, 3), 0.1);
  EXPECT_FALSE(image.empty());
  EXPECT_EQ(image.size(), 6U * 16 * 16); // pi/2 in cells of 0.1
  EXPECT_EQ(image.nearest(image.cell(Eigen::Vector3f(1, 0, 0))), 2);
  EXPECT_EQ(image.farthest(image.cell(Eigen::Vector3f(7, 0, 0))), 5);
  EXPECT_EQ(image.nearest(image.cell(Eigen::Vector3f(0, 0, 1))), 5);
  EXPECT_EQ(image.nearest(image.cell(Eigen::Vector3f(-1, 0, 0))), 0);
  EXPECT_EQ(image.farthest(image.cell(Eigen::Vector3f(0, 0, -1))), 0);
  EXPECT_TRUE(RangeImage().empty());
  EXPECT_EQ(image.viewpoint(), Eigen::Vector3f(1, 2, 3));
}

TEST(RangeImage, AgreesWithLoopOverThePoints)
{
  const Eigen::Matrix3Xf points = testing::samplePoints(testing::roomRectangles(), 40, 1);
  const Eigen::Vector3f viewpoint(0.4f, -0.3f, 0.2f);
  const RangeImage image(points, viewpoint, 0.05);
  std::map<std::size_t, std::pair<float, float>> ranges;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f d = points.col(i) - viewpoint;
    auto& [nearest, farthest] = ranges.try_emplace(image.cell(d), kInf, 0.f).first->second;
    nearest = std::min(nearest, d.norm());
    farthest = std::max(farthest, d.norm());
  }
  for (std::size_t c = 0; c < image.size(); ++c) {
    const auto found = ranges.find(c);
    EXPECT_EQ(image.nearest(c), found == ranges.end() ? 0 : found->second.first);
    EXPECT_EQ(image.farthest(c), found == ranges.end() ? 0 : found->second.second);
  }
}

TEST(RangeImage, FreeRangeHeedsTheNeighbours)
{
  Eigen::Matrix3Xf points(3, 4);
  points.col(0) << 5, 0.05f, 0.05f; // with its neighbour at 2 m
  points.col(1) << 2, 0.3f, 0.02f;
  points.col(2) << -5, 0.05f, 0.05f; // alone
  points.col(3) << 0.05f, -5, 0.05f; // with one beyond it
  const RangeImage image(points, Eigen::Vector3f::Zero(), 0.1);
  const auto cell = [&](Eigen::Index i) { return image.cell(points.col(i)); };
  EXPECT_EQ(image.freeRange(cell(0)), image.nearest(cell(1)));
  EXPECT_EQ(image.freeRange(cell(1)), image.nearest(cell(1)));
  EXPECT_EQ(image.freeRange(cell(2)), image.nearest(cell(2)));
  EXPECT_EQ(image.freeRange(cell(3)), image.nearest(cell(3)));
  const RangeImage room(testing::samplePoints(testing::roomRectangles(), 40, 4), Eigen::Vector3f::Zero(), 0.05);
  for (std::size_t c = 0; c < room.size(); ++c) {
    EXPECT_LE(room.freeRange(c), room.nearest(c));
    EXPECT_EQ(room.freeRange(c) == 0, room.nearest(c) == 0);
  }
}

TEST(RangeImage, FreePlacesAreThoseNearerThanTheFreeRange)
{
  const Eigen::Vector3f viewpoint(0.4f, -0.3f, 0.2f);
  const RangeImage image(testing::samplePoints(testing::roomRectangles(), 40, 4), viewpoint, 0.05);
  testing::Random random(3);
  const std::size_t count = 1000;
  std::vector<float> x, y, z;
  for (std::size_t i = 0; i < count; ++i) {
    x.push_back(static_cast<float>(random.uniform(-2, 2)));
    y.push_back(static_cast<float>(random.uniform(-2, 2)));
    z.push_back(static_cast<float>(random.uniform(-2, 2)));
  }
  x[3] = y[4] = z[5] = kNan;
  x[6] = kInf;
  z[7] = -kMaxFloat;
  const float ratio = 0.95f, margin = 0.3f;
  std::vector<std::int32_t> found(count, -1), none(count, -1);
  image.findFree({x.data(), y.data(), z.data()}, count, ratio, margin, found.data());
  std::size_t free = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f ray = Eigen::Vector3f(x[i], y[i], z[i]) - viewpoint;
    const float reach = image.freeRange(image.cell(ray));
    const bool expected = reach > 0 && ray.norm() < ratio * reach - margin;
    EXPECT_EQ(found[i], expected ? 1 : 0) << i;
    free += expected;
  }
  EXPECT_GT(free, count / 10);
  EXPECT_LT(free, count);
  image.findFree({x.data(), y.data(), z.data()}, 0, ratio, margin, none.data());
  EXPECT_EQ(none, std::vector<std::int32_t>(count, -1));
  RangeImage().findFree({x.data(), y.data(), z.data()}, count, ratio, margin, none.data());
  EXPECT_EQ(none, std::vector<std::int32_t>(count, 0));
}

TEST(RangeImage, CellsPartitionTheDirections)
{
  const double width = 0.2; // 8 x 8 cells on a face
  const RangeImage image(Eigen::Matrix3Xf(3, 0), Eigen::Vector3f::Zero(), width);
  testing::Random random(2);
  std::map<std::size_t, Eigen::Vector3f> first;
  for (int i = 0; i < 100000; ++i) {
    const Eigen::Vector3f d = randomDirection(random);
    const std::size_t cell = image.cell(d);
    ASSERT_LT(cell, image.size());
    EXPECT_EQ(image.cell(d * 0.125f), cell); // the length does not matter
    const Eigen::Vector3f other = first.try_emplace(cell, d).first->second;
    // Of one cell: no farther than the diagonal of a cell of 0.25 of half a face in its middle.
    ASSERT_LT(std::acos(std::min(1.f, d.dot(other))), 0.25 * std::sqrt(2.0));
  }
  EXPECT_EQ(first.size(), image.size());
}

TEST(RangeImage, AnyNumbersGiveSomeCell)
{
  const Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  for (const double width : {kCell, 0.5, 1.5707963267948966}) {
    const RangeImage image(Eigen::Matrix3Xf(3, 0), origin, width);
    for (const float x : {0.f, -0.f, kTiny, -kTiny, 1.f, -1.f, 1e30f, kMaxFloat, -kMaxFloat, kInf, -kInf, kNan})
      for (const float y : {0.f, kTiny, -1.f, -kMaxFloat, kInf, kNan})
        for (const float z : {0.f, -kTiny, 1.f, kMaxFloat, -kInf, kNan})
          EXPECT_LT(image.cell(Eigen::Vector3f(x, y, z)), image.size()) << x << " " << y << " " << z;
  }
}

TEST(RangeImage, SkipsWhatIsNoReturn)
{
  Eigen::Matrix3Xf points(3, 5);
  points.col(0).setConstant(1.f); // at the viewpoint
  points.col(1) << kNan, 1, 1;
  points.col(2) << kInf, 1, 1;
  points.col(3) << 1, -kInf, kNan;
  points.col(4) << kMaxFloat, kMaxFloat, 1; // its range is no float
  const RangeImage image(points, Eigen::Vector3f::Ones(), 0.3);
  for (std::size_t c = 0; c < image.size(); ++c) {
    EXPECT_EQ(image.nearest(c), 0);
    EXPECT_EQ(image.farthest(c), 0);
  }
  const RangeImage nowhere(Eigen::Matrix3Xf::Random(3, 50), Eigen::Vector3f::Constant(kNan), 0.3);
  for (std::size_t c = 0; c < nowhere.size(); ++c)
    EXPECT_EQ(nowhere.nearest(c), 0);
}

TEST(DepthSpans, AreTheNearestAndTheFarthestReturn)
{
  Eigen::Matrix3Xf points(3, 4);
  points.col(0) << 2, 0, 0;
  points.col(1) << 4, 0, 0;
  points.col(2) << 3, 0, 0;
  points.col(3) << 0, 2, 0;
  const DirectionGrid grid(kCell);
  const std::vector<DepthSpan> spans = depthSpans(points, Eigen::Vector3f::Zero(), grid);
  ASSERT_EQ(spans.size(), grid.size());
  EXPECT_EQ(spans[grid.cell(Eigen::Vector3f::UnitX())].nearest, 2);
  EXPECT_EQ(spans[grid.cell(Eigen::Vector3f::UnitX())].farthest, 4);
  EXPECT_EQ(spans[grid.cell(Eigen::Vector3f::UnitY())].nearest, 2);
  EXPECT_EQ(spans[grid.cell(Eigen::Vector3f::UnitY())].farthest, 2);
  EXPECT_EQ(spans[grid.cell(Eigen::Vector3f::UnitZ())].farthest, 0);
}

} // namespace
} // namespace pcl_ssfr::test_range_image
