// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/scored_pose.h"
#include "multiway/growing_parts.h"

#include <made_up_maps.h>

#include <gmock/gmock.h>

#include <utility>
#include <vector>

namespace pcl_ssfr::test_multiway_growing_parts {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A chain of six scans with exact links.
class GrowingPartsTest : public ::testing::Test {
protected:
  GrowingPartsTest()
  {
    for (int i = 0; i + 1 < 6; ++i)
      job_.addTrue(i, i + 1, 0.95, 0);
    graph_ = weighHypotheses(job_.links, job_.places, {}, MultiwayOptions());
  }
  /// Of the link from \p i to the next scan.
  Eigen::Isometry3d
  partPose(const GrowingParts& parts, int i) const
  {
    const PairLink& link = job_.links[static_cast<std::size_t>(i)];
    return parts.partPose(link, link.hypotheses.front().T_target_source);
  }
  void
  join(GrowingParts& parts, int i) const
  {
    parts.merge(parts.partOf(i), parts.partOf(i + 1), partPose(parts, i));
  }

  testing::MadeUpJob job_{6};
  HypothesisGraph graph_;
  const ChoiceConfig config_;
};

TEST_F(GrowingPartsTest, beginAsSingleScans)
{
  const GrowingParts parts(job_.links, graph_, job_.places, config_);
  for (int i = 0; i < 6; ++i) {
    EXPECT_THAT(parts.members(parts.partOf(i)), ElementsAre(i));
    EXPECT_TRUE(parts.pose(i).isApprox(Eigen::Isometry3d::Identity()));
  }
  EXPECT_EQ(parts.pairsAt(0, 1, Eigen::Isometry3d::Identity()).size(), 1U);
}

TEST_F(GrowingPartsTest, mergeKeepsWhatIsKnownWhateverComesFirst)
{
  for (const std::vector<int>& order : {std::vector{0, 1, 2, 3, 4}, {4, 3, 2, 1, 0}, {0, 4, 2, 1, 3}}) {
    GrowingParts parts(job_.links, graph_, job_.places, config_);
    for (const int i : order)
      join(parts, i);
    parts.adjustAll();
    const int part = parts.partOf(0);
    EXPECT_THAT(parts.members(part), ElementsAre(0, 1, 2, 3, 4, 5));
    EXPECT_LT((parts.placeOf(part) - parts.pose(0) * job_.places[0]).norm(), 1e-12);
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(parts.partOf(i), part);
      EXPECT_LT(rotationBetween(parts.pose(0).inverse() * parts.pose(i), job_.relative(i, 0)), 1e-6);
      EXPECT_LT(((parts.pose(0).inverse() * parts.pose(i)).translation() - job_.relative(i, 0).translation()).norm(),
                1e-6);
      if (i != part) {
        EXPECT_THAT(parts.members(i), IsEmpty());
      }
    }
    for (const int used : parts.assembly().used)
      EXPECT_EQ(used, 0); // its links agree
  }
}

TEST_F(GrowingPartsTest, thePairsOfAJoinAreEachWithEach)
{
  GrowingParts parts(job_.links, graph_, job_.places, config_);
  join(parts, 0);
  join(parts, 3);
  join(parts, 1);
  const int a = parts.partOf(0), b = parts.partOf(3);
  const auto pairs = parts.pairsAt(a, b, partPose(parts, 2));
  ASSERT_EQ(pairs.size(), 6U);
  for (const PlacedPair& pair : pairs) {
    EXPECT_EQ(parts.partOf(pair.source), a);
    EXPECT_EQ(parts.partOf(pair.target), b);
    const Eigen::Isometry3d expected = job_.relative(pair.source, pair.target);
    EXPECT_LT((pair.T_target_source.matrix() - expected.matrix()).norm(), 1e-6);
  }

  // Without those that have nothing to say of each other, in the same order.
  const auto areUnrelated = [&](int source, int target, double distance) {
    const double expected = (job_.relative(source, target) * job_.places.at(static_cast<std::size_t>(source)) -
                             job_.places.at(static_cast<std::size_t>(target)))
                                .norm();
    EXPECT_NEAR(distance, expected, 1e-6);
    return (source + target) % 2 == 0;
  };
  std::vector<std::pair<int, int>> wanted, found;
  for (const PlacedPair& pair : pairs)
    if ((pair.source + pair.target) % 2 != 0)
      wanted.emplace_back(pair.source, pair.target);
  for (const PlacedPair& pair : parts.pairsAt(a, b, partPose(parts, 2), areUnrelated))
    found.emplace_back(pair.source, pair.target);
  EXPECT_EQ(found, wanted);
  EXPECT_THAT(found, ::testing::SizeIs(::testing::AllOf(::testing::Gt(0U), ::testing::Lt(6U))));
}

} // namespace
} // namespace pcl_ssfr::test_multiway_growing_parts
