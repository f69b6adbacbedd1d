// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Whether a storey may be several: the vertical of made-up parts, levels, and stairs that lead to nowhere.

#include "multiway/storeys.h"

#include <patch_scenes.h>

#include <gmock/gmock.h>

namespace pcl_ssfr::test_multiway_storeys {
namespace {

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
    using Eigen::Vector3d;
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
    return findStoreyDoubt(scansAt(heights), Eigen::Vector3d::UnitZ(), others, AliasConfig());
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

TEST_F(Storeys, stairsBetweenTwoLevelsAreNone)
{
  EXPECT_FALSE(doubtOf({1.2, 1.2, 1.2, 2.1, 2.95, 4.1, 4.7, 4.7, 4.7}).has_value());
}

TEST_F(Storeys, noScansNoDoubt)
{
  EXPECT_FALSE(findStoreyDoubt({}, Eigen::Vector3d::UnitZ(), true, AliasConfig()).has_value());
  EXPECT_FALSE(findUp({}, AliasConfig()).has_value());
}

} // namespace
} // namespace pcl_ssfr::test_multiway_storeys
