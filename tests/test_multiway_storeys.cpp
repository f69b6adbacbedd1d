// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Whether a storey may be several: the vertical of made-up parts, levels, and stairs that lead to nowhere.

#include "common/angles.h"
#include "multiway/storeys.h"

#include <patch_scenes.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace pcl_ssfr::test_multiway_storeys {
namespace {

using Eigen::Vector3d;
using testing::addPatch;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::Rectangle;

/// Scans at some heights above the floor of their storey, 1.2 m above what is under them, in one long room each.
class Storeys : public ::testing::Test {
protected:
  std::vector<StoreyScan>
  scansAt(const std::vector<double>& heights)
  {
    surfaces_.clear();
    surfaces_.reserve(heights.size());
    std::vector<StoreyScan> scans;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      PlanarPatches patches;
      const Vector3d place(2.0 * static_cast<double>(i), 0.1 * static_cast<double>(i % 3), heights[i]);
      addPatch(patches, {{place.x(), 0, heights[i] - 1.2}, {0, 2, 0}, {-1, 0, 0}}); // the floor faces up
      addPatch(patches, {{place.x(), 0, heights[i] + 1.5}, {0, 2, 0}, {1, 0, 0}});
      addPatch(patches, {{-3 - 0.5 * static_cast<double>(i), 0, heights[i]}, {0, 2, 0}, {0, 0, 1}});
      addPatch(patches, {{place.x(), -2 - 0.7 * static_cast<double>(i), heights[i]}, {0, 0, 1}, {1, 0, 0}});
      surfaces_.push_back(patches.samples);
      StoreyScan scan;
      scan.surface = &surfaces_.back();
      scan.place = place;
      scans.push_back(scan);
    }
    return scans;
  }
  std::optional<StoreyDoubt>
  doubtOf(const std::vector<double>& heights, bool others = false)
  {
    return findStoreyDoubt(scansAt(heights), Eigen::Vector3d::UnitZ(), others, 0.4, AliasConfig());
  }

  std::vector<OrientedSamples> surfaces_;
};

TEST_F(Storeys, upIsWhereFloorsLieEquallyFarBelow)
{
  const auto up = findUp(scansAt({1.2, 1.2, 1.2, 2.0, 2.9, 4.7, 4.7}), AliasConfig());
  ASSERT_TRUE(up.has_value());
  EXPECT_GT(up->z(), 0.99);
}

TEST_F(Storeys, noFloorNoVertical)
{
  std::vector<StoreyScan> scans = scansAt({1.2, 1.2, 1.2});
  for (std::size_t i = 0; i < scans.size(); ++i)
    scans[i].place.z() += 5 + static_cast<double>(i);
  AliasConfig sees_all_around; // whose view is no axis of rings
  sees_all_around.flat_view = 0.01;
  EXPECT_FALSE(findUp(scans, sees_all_around).has_value());
}

/// A room of 6 x 5 x 3 m.
struct Room {
  int parts = 1;     ///< patches of one wall for each direction: their number says nothing
  bool level = true; ///< it has a floor and a ceiling
};

/// What a sensor in a room sees in the directions that the test allows, in a frame rotated by R: a patch
/// for each of many directions, of the area that fills the same solid angle.
template <typename Test>
OrientedSamples
seenInRoom(const Room& room, const Vector3d& place, const Eigen::Matrix3d& R, const Test& sees)
{
  const Vector3d low(0, 0, 0), high(6, 5, 3);
  constexpr int kDirections = 2000;
  std::vector<Vector3d> points, normals;
  std::vector<double> areas;
  for (int k = 0; k < kDirections; ++k) { // a spiral: evenly spread
    const double z = 1 - (2 * k + 1.0) / kDirections, angle = 2.399963 * k;
    const double r = std::sqrt(1 - z * z);
    const Vector3d d(r * std::cos(angle), r * std::sin(angle), z);
    if (!sees(d))
      continue;
    double range = 1e9;
    Vector3d normal = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const double to_wall = ((d[axis] > 0 ? high[axis] : low[axis]) - place[axis]) / d[axis];
      if (to_wall < range) {
        range = to_wall;
        normal = Vector3d::Unit(axis) * (d[axis] > 0 ? -1 : 1);
      }
    }
    if (!room.level && normal.z() != 0)
      continue;
    const int parts = normal.x() < 0 ? room.parts : 1;
    for (int part = 0; part < parts; ++part) {
      points.emplace_back(R * (place + range * d));
      normals.emplace_back(R * normal);
      areas.push_back(4 * kPi / kDirections * range * range / std::abs(normal.dot(d)) / parts);
    }
  }
  OrientedSamples samples;
  const auto count = static_cast<Eigen::Index>(points.size());
  samples.points.resize(3, count);
  samples.normals.resize(3, count);
  samples.weights.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    samples.points.col(i) = points[static_cast<std::size_t>(i)];
    samples.normals.col(i) = normals[static_cast<std::size_t>(i)];
    samples.weights[i] = areas[static_cast<std::size_t>(i)];
  }
  return samples;
}

/// The vertical that is found for four sensors in a room, in its frame.
template <typename Test>
std::optional<Vector3d>
verticalOf(const Room& room, const Test& sees)
{
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<OrientedSamples> surfaces;
  std::vector<StoreyScan> scans;
  // At heights of which no two agree, as on stairs: what lies equally far below says nothing.
  const std::vector<Vector3d> places = {{1, 1, 0.4}, {5.5, 4, 0.9}, {3, 0.5, 1.4}, {2, 3, 1.9}};
  for (const Vector3d& place : places)
    surfaces.push_back(seenInRoom(room, place, R, sees));
  for (std::size_t i = 0; i < places.size(); ++i) {
    StoreyScan scan;
    scan.surface = &surfaces[i];
    scan.place = R * places[i];
    scans.push_back(scan);
  }
  const auto up = findUp(scans, AliasConfig());
  return up ? std::optional<Vector3d>(R.transpose() * *up) : std::nullopt;
}

/// Between two axes [rad].
double
angleBetween(const Vector3d& a, const Vector3d& b)
{
  return std::acos(std::min(1.0, std::abs(a.dot(b))));
}

/// The angle between the vertical that is found and the right one [rad]; none found: NaN.
template <typename Test>
double
verticalError(const Test& sees)
{
  const auto up = verticalOf(Room(), sees);
  return up ? angleBetween(*up, Vector3d::UnitZ()) : std::numeric_limits<double>::quiet_NaN();
}

TEST(Vertical, isTheAxisOfWhatLooksAroundButNotAllTheWayUpAndDown)
{
  EXPECT_LT(verticalError([](const Vector3d& d) { return std::abs(d.z()) < 0.26; }), 0.01);        // rings
  EXPECT_LT(verticalError([](const Vector3d& d) { return d.z() > -0.12 && d.z() < 0.79; }), 0.01); // a dome
  EXPECT_TRUE(std::isnan(verticalError([](const Vector3d& d) { return d.z() > -0.88; })));         // no tripod in view
  EXPECT_TRUE(std::isnan(verticalError([](const Vector3d& d) { return d.x() > 0.8; })));           // to the front
}

TEST(Vertical, isOfWhatIsSeenWhateverTheNumberOfItsPatches)
{
  const auto dome = [](const Vector3d& d) { return d.z() > -0.12 && d.z() < 0.79; };
  Room room;
  room.level = false; // level surfaces would make it exact
  const auto up = verticalOf(room, dome);
  ASSERT_TRUE(up.has_value());
  EXPECT_LT(angleBetween(*up, Vector3d::UnitZ()), 0.1);
  room.parts = 20;
  const auto of_many = verticalOf(room, dome);
  ASSERT_TRUE(of_many.has_value());
  EXPECT_LT(angleBetween(*up, *of_many), 0.003);
}

TEST_F(Storeys, oneLevelIsNoDoubt)
{
  EXPECT_FALSE(doubtOf({1.2, 1.21, 1.3, 1.2}).has_value());
  EXPECT_FALSE(doubtOf({1.2, 1.21, 1.3, 1.2}, true).has_value());
}

TEST_F(Storeys, stairsThatLeadToNowhereBothWaysAreADoubt)
{
  const auto doubt = doubtOf({1.2, 1.2, 1.2, 1.2, 2.65, 2.95, 0.58});
  ASSERT_TRUE(doubt.has_value());
  EXPECT_THAT(doubt->level, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(doubt->above, ElementsAre(4, 5));
  EXPECT_THAT(doubt->below, ElementsAre(6));
}

TEST_F(Storeys, stairsOneWayAreADoubtWhenScansStandApart)
{
  const std::vector<double> heights = {1.2, 1.2, 1.2, 1.2, 2.1};
  EXPECT_FALSE(doubtOf(heights).has_value());
  const auto doubt = doubtOf(heights, true);
  ASSERT_TRUE(doubt.has_value());
  EXPECT_THAT(doubt->above, ElementsAre(4));
  EXPECT_THAT(doubt->below, IsEmpty());
}

TEST_F(Storeys, aSensorAtAnotherHeightAboveTheSameFloorIsOnNoStairs)
{
  // One stands 0.9 m higher than the others, and one 0.6 m lower, as tripods may, or places that were estimated.
  std::vector<StoreyScan> scans = scansAt({1.2, 1.2, 1.2, 1.2, 1.2, 1.2});
  scans[4].place.z() = 2.1;
  scans[5].place.z() = 0.6;
  for (const bool others : {false, true})
    EXPECT_FALSE(findStoreyDoubt(scans, Vector3d::UnitZ(), others, 0.4, AliasConfig()).has_value());
}

TEST_F(Storeys, landingsOfStoreysLaidOntoOneAnotherAreNoLevels)
{
  // Four storeys in one: three flights of stairs on one another, so three scans at the height of each landing.
  std::vector<StoreyScan> scans = scansAt({1.2, 1.2, 1.2, 1.2, 2.1, 2.1, 2.1, 0.3, 0.3, 0.3});
  EXPECT_FALSE(findStoreyDoubt(scans, Vector3d::UnitZ(), false, 0.4, AliasConfig()).has_value()); // two more levels
  for (const std::size_t first : {4U, 7U}) {
    scans[first + 1].place = scans[first].place + Vector3d(0.1, 0, 0.02);
    scans[first + 2].place = scans[first].place + Vector3d(-0.1, 0.1, 0);
  }
  const auto doubt = findStoreyDoubt(scans, Vector3d::UnitZ(), false, 0.4, AliasConfig());
  ASSERT_TRUE(doubt.has_value());
  EXPECT_THAT(doubt->level, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(doubt->above, ElementsAre(4, 5, 6));
  EXPECT_THAT(doubt->below, ElementsAre(7, 8, 9));
}

TEST_F(Storeys, stairsBetweenTwoLevelsAreNone)
{
  EXPECT_FALSE(doubtOf({1.2, 1.2, 1.2, 2.1, 2.95, 4.1, 4.7, 4.7, 4.7}).has_value());
}

/// Scans of which only the places matter.
std::vector<StoreyScan>
scansAtPlaces(const std::vector<Vector3d>& places)
{
  std::vector<StoreyScan> scans(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    scans[i].place = places[i];
  return scans;
}

TEST(ScansInDoubt, areTheStoreyTheFewerOfTheWaysAndThoseAtOnePlace)
{
  const std::vector<StoreyScan> scans =
      scansAtPlaces({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {9, 0, 1}, {9, 0, -1}, {8, 0, -2}, {8.2, 0, -2.2}, {7, 0, -3}});
  StoreyDoubt doubt;
  doubt.level = {0, 1, 2};
  doubt.above = {3};
  doubt.below = {4, 5, 7};
  EXPECT_THAT(scansInDoubt(scans, doubt, 0.4), ElementsAre(0, 1, 2, 3));
  doubt.below = {4, 5, 6, 7};
  EXPECT_THAT(scansInDoubt(scans, doubt, 0.4), ElementsAre(0, 1, 2, 3, 5, 6));
  doubt.below = {4}; // as many: up and down are not known from each other
  EXPECT_THAT(scansInDoubt(scans, doubt, 0.4), ElementsAre(0, 1, 2, 3, 4));
  doubt.below = {4, 5, 6, 7};
  doubt.above.clear();
  EXPECT_THAT(scansInDoubt(scans, doubt, 0.1), ElementsAre(0, 1, 2)); // the only way may be one
}

TEST_F(Storeys, noScansNoDoubt)
{
  EXPECT_FALSE(findStoreyDoubt({}, Eigen::Vector3d::UnitZ(), true, 0.4, AliasConfig()).has_value());
  EXPECT_FALSE(findUp({}, AliasConfig()).has_value());
}

} // namespace
} // namespace pcl_ssfr::test_multiway_storeys
