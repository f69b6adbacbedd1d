// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// What distinguishes places that look alike.

#include "multiway/furniture.h"
#include "multiway/scan_pair.h"
#include "profiles/prepared_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pcl_ssfr::test_multiway_furniture {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// A grid on the rectangle from \p corner along \p u and \p v.
void
addRectangle(Points& points, const Eigen::Vector3f& corner, const Eigen::Vector3f& u, const Eigen::Vector3f& v)
{
  constexpr float kSpacing = 0.03F;
  for (float a = 0; a <= u.norm(); a += kSpacing)
    for (float b = 0; b <= v.norm(); b += kSpacing)
      points.push_back(corner + a * u.normalized() + b * v.normalized());
}

/// A room of 6 x 5 x 2.6 m about its sensor, with a box of 0.5 m at each place [m] on the floor.
Points
roomPoints(const std::vector<Eigen::Vector2f>& boxes)
{
  Points points;
  const Eigen::Vector3f x(6, 0, 0), y(0, 5, 0), z(0, 0, 2.6F), corner(-3.1F, -2.3F, -1.5F);
  addRectangle(points, corner, x, y);
  addRectangle(points, corner + z, x, y);
  addRectangle(points, corner, x, z);
  addRectangle(points, corner + y, x, z);
  addRectangle(points, corner, y, z);
  addRectangle(points, corner + x, y, z);
  for (const Eigen::Vector2f& place : boxes) {
    const Eigen::Vector3f at(place.x(), place.y(), corner.z());
    const Eigen::Vector3f a(0.5F, 0, 0), b(0, 0.5F, 0), c(0, 0, 0.5F);
    addRectangle(points, at + c, a, b);
    addRectangle(points, at, a, c);
    addRectangle(points, at + b, a, c);
    addRectangle(points, at, b, c);
    addRectangle(points, at + a, b, c);
  }
  return points;
}

PreparedScan
prepared(const Points& points)
{
  ScanView view;
  view.xyz = points.front().data();
  view.size = points.size();
  return prepareScan(view, Options());
}

PreparedScan
room(const std::vector<Eigen::Vector2f>& boxes)
{
  return prepared(roomPoints(boxes));
}

const std::vector<Eigen::Vector2f> kHere = {{1.5F, -1}, {-1.9F, -1.2F}, {0.9F, 1.2F}};
const std::vector<Eigen::Vector2f> kElsewhere = {{-1.7F, 0.9F}, {1.6F, 0.6F}, {-0.6F, -1.7F}};

FurnitureEvidence
evidenceOf(const PreparedScan& source, const PreparedScan& target, const Eigen::Isometry3d& T)
{
  const MultiwayOptions options;
  return furnitureAt(source, furnitureOf(source, options), target, furnitureOf(target, options), T, options);
}

TEST(Furniture, isWhatIsOfNoLargePlane)
{
  MultiwayOptions options;
  EXPECT_LT(furnitureOf(room({}), options).patches.weights.sum(),
            0.02 * 2 * (6 * 5 + 6 * 2.6 + 5 * 2.6)); // but for corners
  const OrientedSamples boxes = furnitureOf(room(kHere), options).patches;
  ASSERT_GT(boxes.size(), 3);
  // Boxes of 0.5 m: all of it is near the floor, and no more than their faces.
  EXPECT_LT(boxes.weights.sum(), 3 * 5 * 0.25 * 1.3);
  options.furniture.most_area = 1000;
  EXPECT_GT(furnitureOf(room(kHere), options).patches.size(), boxes.size());
  options.furniture.most_area = 1e-6;
  EXPECT_EQ(furnitureOf(room(kHere), options).patches.size(), 0);
}

const Eigen::Vector3f kPlant(0.5F, 0.4F, -0.3F);

/// Points on a ball of 0.15 m, no plane anywhere, in place of what the sensor would see behind it.
void
addPlant(Points& points)
{
  constexpr float kRadius = 0.15F;
  constexpr int kLeaves = 60;
  const auto isBehind = [&](const Eigen::Vector3f& p) {
    return p.dot(kPlant) > 0 && kPlant.cross(p.normalized()).norm() < 1.3F * kRadius;
  };
  points.erase(std::remove_if(points.begin(), points.end(), isBehind), points.end());
  for (int k = 0; k < kLeaves; ++k) { // a spiral from pole to pole
    const float z = -1 + (2 * static_cast<float>(k) + 1) / kLeaves, angle = 2.4F * static_cast<float>(k);
    const float r = std::sqrt(1 - z * z);
    points.push_back(kPlant + kRadius * Eigen::Vector3f(r * std::cos(angle), r * std::sin(angle), z));
  }
}

/// How many of some points, in the inner frame of a scan, lie within 0.3 m of a place in its own.
Eigen::Index
countNear(const Eigen::Matrix3Xf& points, const PreparedScan& scan, const Eigen::Vector3f& place)
{
  const Eigen::Vector3f inner = place - patchesOf(scan).origin.cast<float>();
  return ((points.colwise() - inner).colwise().norm().array() < 0.3F).count();
}

TEST(SolidClutter, isWhatFitsNoPlaneAndIsNotSeenThroughByItsOwnSensor)
{
  // Twigs a metre before a wall, which the beams next to them reach.
  const Eigen::Vector3f twigs(1.9F, -1, 0.2F);
  Points points = roomPoints({});
  addPlant(points);
  for (int k = 0; k < 4; ++k)
    points.push_back(twigs + 0.04F * static_cast<float>(k) * Eigen::Vector3f(0.3F, 1, k % 2 == 0 ? 1.F : -1.F));
  const PreparedScan scan = prepared(points);
  ASSERT_GT(countNear(patchesOf(scan).clutter, scan, twigs), 0);
  const Eigen::Matrix3Xf solid = solidClutter(scan, MultiwayOptions());
  EXPECT_GT(countNear(solid, scan, kPlant), 3);
  EXPECT_EQ(countNear(solid, scan, twigs), 0);
}

TEST(Furniture, ofNoPlaneCountsAsAPatchOfItsCell)
{
  Points points = roomPoints({});
  addPlant(points);
  const PreparedScan bare = room({}), planted = prepared(points);
  const MultiwayOptions options;
  const Furniture nothing, plant = {OrientedSamples(), solidClutter(planted, options)};
  const auto near = static_cast<double>(countNear(plant.points, planted, kPlant));
  ASSERT_GT(near, 3);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  const double weight = std::sqrt(0.2); // of a square of 0.2 m: the fourth root of its area
  const FurnitureEvidence missed = furnitureAt(planted, plant, bare, nothing, here, options);
  EXPECT_NEAR(missed.seen_through, weight * near, 1e-9); // the bare room has nothing there
  EXPECT_GE(missed.in_view, missed.seen_through);
  const FurnitureEvidence back = furnitureAt(bare, nothing, planted, plant, here, options);
  EXPECT_NEAR(back.seen_through, missed.seen_through, 1e-9);
  const FurnitureEvidence met = furnitureAt(planted, plant, planted, nothing, here, options);
  EXPECT_EQ(met.seen_through, 0);
  EXPECT_GE(met.in_view, weight * near - 1e-9);
}

TEST(Furniture, ofOneRoomIsNotSeenThrough)
{
  const FurnitureEvidence e = evidenceOf(room(kHere), room(kHere), Eigen::Isometry3d::Identity());
  EXPECT_GT(e.in_view, 1);
  EXPECT_LE(e.seen_through, MultiwayOptions().furniture.seen_through * e.in_view);
}

TEST(Furniture, ofRoomsAlikeIsSeenThrough)
{
  const FurnitureEvidence e = evidenceOf(room(kHere), room(kElsewhere), Eigen::Isometry3d::Identity());
  EXPECT_GT(e.seen_through, 10 * MultiwayOptions().furniture.seen_through * e.in_view);
}

double
logOddsOf(const FurnitureEvidence& e)
{
  return furnitureLogOdds(e, FurnitureConfig());
}

FurnitureEvidence
furniture(double in_view, double seen_through)
{
  FurnitureEvidence e;
  e.in_view = in_view;
  e.seen_through = seen_through;
  return e;
}

TEST(Furniture, tellsOneRoomFromRoomsAlike)
{
  EXPECT_GT(logOddsOf(evidenceOf(room(kHere), room(kHere), Eigen::Isometry3d::Identity())), 0.2);
  EXPECT_LT(logOddsOf(evidenceOf(room(kHere), room(kElsewhere), Eigen::Isometry3d::Identity())), -3);
}

TEST(FurnitureLogOdds, areThoseOfTwoDrawsOfAShare)
{
  // The sum over all shares, by hand: of 12 patches in view 0, 1 and 5 are seen through.
  const FurnitureConfig config;
  const auto probability = [](int n, int v, double mean) {
    const double b = (1 - mean) / mean;
    const int steps = 200000;
    double sum = 0;
    for (int k = 0; k < steps; ++k) {
      const double share = (k + 0.5) / steps;
      sum += b * std::pow(1 - share, b - 1) * std::pow(share, n) * std::pow(1 - share, v - n) / steps;
    }
    return sum; // what all orders of n of v have in common is left out
  };
  for (const int n : {0, 1, 5})
    EXPECT_NEAR(furnitureLogOdds(furniture(12, n), config),
                std::log(probability(n, 12, config.seen_through) / probability(n, 12, config.seen_through_alike)),
                1e-4)
        << n;
}

TEST(FurnitureLogOdds, growSlowlyWithWhatIsInViewAndFallFastWithWhatIsSeenThrough)
{
  const FurnitureConfig config;
  EXPECT_NEAR(furnitureLogOdds(furniture(0, 0), config), 0, 1e-12); // nothing in view, nothing known
  EXPECT_NEAR(furnitureLogOdds(furniture(0, 3), config), 0, 1e-12);
  double before = 0;
  for (const double in_view : {1, 10, 100, 1000, 100000}) {
    const double odds = furnitureLogOdds(furniture(in_view, 0), config);
    EXPECT_GT(odds, before);
    EXPECT_LT(odds,
              std::log(config.seen_through_alike / config.seen_through) + 0.1); // that copies are rare is no proof
    before = odds;
  }
  before = furnitureLogOdds(furniture(40, 0), config);
  for (double n = 0.5; n <= 40; n += 0.5) {
    EXPECT_LT(furnitureLogOdds(furniture(40, n), config), before);
    before = furnitureLogOdds(furniture(40, n), config);
  }
  EXPECT_LT(before, -30);
  EXPECT_EQ(furnitureLogOdds(furniture(40, 50), config), before); // no more than is in view
}

TEST(LogOddsAmongMany, countThoseForOnePlaceLessThanThoseAgainst)
{
  FurnitureConfig config;
  config.agreement = 0.25;
  const FurnitureEvidence met = furniture(100, 0), missed = furniture(100, 20);
  ASSERT_GT(logOddsOf(met), 1);
  ASSERT_LT(logOddsOf(missed), -1);
  EXPECT_DOUBLE_EQ(logOddsAmongMany(met, config), 0.25 * logOddsOf(met));
  EXPECT_DOUBLE_EQ(logOddsAmongMany(missed, config), logOddsOf(missed));
}

TEST(ShareOfPlacesAlike, isThatOfThePosesThatFurnitureSpeaksAgainst)
{
  const FurnitureConfig config;
  EXPECT_EQ(shareOfPlacesAlike({}, config), 0);
  EXPECT_LT(shareOfPlacesAlike(std::vector<FurnitureEvidence>(3, furniture(0, 0)), config), 0.01); // nothing is known
  EXPECT_LT(shareOfPlacesAlike({furniture(200, 30)}, config), config.least_false); // one pair is no building
  std::vector<FurnitureEvidence> pairs(60, furniture(200, 0));
  EXPECT_LT(shareOfPlacesAlike(pairs, config), 0.05);
  pairs.insert(pairs.end(), 40, furniture(200, 30));
  EXPECT_NEAR(shareOfPlacesAlike(pairs, config), 0.4, 0.07); // some that see nothing through might be alike
  pairs.erase(pairs.begin(), pairs.begin() + 60);
  EXPECT_GT(shareOfPlacesAlike(pairs, config), 0.85);
}

TEST(Furniture, isTheSameSeenFromEitherScan)
{
  const PreparedScan a = room(kHere), b = room(kElsewhere);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Eigen::Vector3d(0.3, -0.2, 0.1)).rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  const FurnitureEvidence there = evidenceOf(a, b, T), back = evidenceOf(b, a, T.inverse());
  EXPECT_NEAR(there.in_view, back.in_view, 0.02 * there.in_view);
  EXPECT_NEAR(there.seen_through, back.seen_through, 0.05 * there.in_view);
}

TEST(Furniture, thatIsFarAwayIsNotSeen)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Eigen::Vector3d(100, 0, 0));
  EXPECT_EQ(evidenceOf(room(kHere), room(kHere), T).seen_through, 0);
}

TEST(Furniture, ofAScanWithoutPointsIsNone)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector3f point(nan, nan, nan);
  ScanView view;
  view.xyz = point.data();
  view.size = 1;
  const Furniture furniture = furnitureOf(prepareScan(view, Options()), MultiwayOptions());
  EXPECT_EQ(furniture.patches.size(), 0);
  EXPECT_EQ(furniture.points.cols(), 0);
}

} // namespace
} // namespace pcl_ssfr::test_multiway_furniture
