// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "patch_scenes.h"
#include "preparation/patch_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

namespace pcl_ssfr::test_patch_index {
namespace {

using testing::addPatch;
using testing::kInf;
using testing::kMaxFloat;
using testing::kNan;

PatchIndex::Tolerance
tolerance(float distance, float lateral)
{
  PatchIndex::Tolerance t;
  t.distance = distance;
  t.lateral = lateral;
  return t;
}

/// What \p index finds at the centroid of patch \p i, for its normal.
int
findAtPatch(const PatchIndex& index, const PlanarPatches& patches, Eigen::Index i)
{
  const OrientedSamples& samples = patches.samples;
  return index.find(samples.points.col(i).cast<float>(), samples.normals.col(i).cast<float>(), tolerance(0.3f, 0.3f));
}

/// A wall of 4 x 2 m at x = 1 that faces +x.
PlanarPatches
oneWall()
{
  PlanarPatches patches;
  addPatch(patches, {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, 1)});
  return patches;
}

Eigen::Vector3f
randomPlace(testing::Random& random, double size)
{
  return Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size))
      .cast<float>();
}

TEST(DirectionClass, EveryClassHoldsItsOwnCentre)
{
  std::set<int> classes;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {1.f, -1.f})
      for (int u = -1; u <= 1; ++u)
        for (int v = -1; v <= 1; ++v) {
          Eigen::Vector3f d;
          d[axis] = side;
          d[(axis + 1) % 3] = static_cast<float>(u) * 0.6f;
          d[(axis + 2) % 3] = static_cast<float>(v) * 0.6f;
          const int c = directionClass(d);
          EXPECT_TRUE(c >= 0 && c < kDirectionClasses);
          EXPECT_EQ(directionClass(100 * d), c);
          EXPECT_EQ(directionClassesNear(d.normalized(), 0), std::uint64_t{1} << c);
          classes.insert(c);
        }
  EXPECT_EQ(classes.size(), static_cast<std::size_t>(kDirectionClasses));
}

TEST(DirectionClass, NearClassesGrowWithTheAngle)
{
  testing::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3f d = randomPlace(random, 1).normalized(), other = randomPlace(random, 1).normalized();
    const std::uint64_t bits = directionClassesNear(d, 0.5), own = std::uint64_t{1} << directionClass(d);
    EXPECT_NE(bits & own, 0U);
    EXPECT_EQ(bits & ~directionClassesNear(d, 0.8), 0U);
    // No member of a class is farther than 0.35 rad from its centre.
    const double angle = std::acos(std::clamp(d.dot(other), -1.f, 1.f));
    const bool near = (bits >> directionClass(other) & 1) != 0;
    EXPECT_TRUE(near || angle > 0.15);
    EXPECT_FALSE(near && angle > 0.85);
  }
  EXPECT_EQ(directionClassesNear(Eigen::Vector3f::UnitX(), 3.14159265358979),
            (std::uint64_t{1} << kDirectionClasses) - 1);
}

TEST(DirectionClass, AnyNumbersGiveSomeClass)
{
  for (const float x : {0.f, 1e-45f, -1.f, kMaxFloat, -kInf, kNan})
    for (const float y : {0.f, -1e-45f, -kMaxFloat, kInf, kNan})
      for (const float z : {0.f, 1.f, kMaxFloat, kInf, kNan}) {
        const int c = directionClass(Eigen::Vector3f(x, y, z));
        EXPECT_TRUE(c >= 0 && c < kDirectionClasses) << x << " " << y << " " << z;
      }
}

TEST(PatchIndex, ByHand)
{
  const PatchIndex index(oneWall(), 0.5);
  ASSERT_FALSE(index.empty());
  EXPECT_EQ(index.voxel(), 0.5);
  const PatchIndex::Meeting centroid = index.meet(0, Eigen::Vector3d(1, 0, 0));
  EXPECT_TRUE(centroid.normal.isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_EQ(centroid.distance, 0);
  EXPECT_EQ(centroid.variance, 2); // the least: it grows away from there
  const Eigen::Vector3f facing = Eigen::Vector3f::UnitX();
  const PatchIndex::Tolerance t = tolerance(0.12f, 0.1f);
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 0), facing, t), 0);
  EXPECT_EQ(index.find(Eigen::Vector3f(1.1f, 1.9f, -0.9f), facing, t), 0);
  EXPECT_EQ(index.find(Eigen::Vector3f(0.9f, 2.05f, 1.05f), facing, t), 0);
  EXPECT_EQ(index.find(Eigen::Vector3f(1.13f, 0, 0), facing, t), -1); // off the plane
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 2.15f, 0), facing, t), -1); // beyond the long edge
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 1.15f), facing, t), -1); // beyond the short edge
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 0), -facing, t), -1);    // the other side
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 0), Eigen::Vector3f::UnitY(), t), -1);
  EXPECT_EQ(index.find(Eigen::Vector3f(50, 0, 0), facing, t), -1); // outside of the grid
  PatchIndex::Tolerance either = t;
  either.either_side = true;
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 0), -facing, either), 0);
  // The angle between the normals, on both sides of its bound.
  const auto rotated = [](float angle) { return Eigen::Vector3f(std::cos(angle), std::sin(angle), 0); };
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 0), rotated(std::acos(t.min_cos) - 0.01f), t), 0);
  EXPECT_EQ(index.find(Eigen::Vector3f(1, 0, 0), rotated(std::acos(t.min_cos) + 0.01f), t), -1);
  // Masks.
  const auto sees = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
    return (index.mask(p) >> directionClass(n) & 1) != 0;
  };
  EXPECT_TRUE(sees(Eigen::Vector3f(1, 1.9f, 0.9f), facing));
  EXPECT_FALSE(sees(Eigen::Vector3f(1, 1.9f, 0.9f), -facing));
  EXPECT_FALSE(sees(Eigen::Vector3f(1, 1.9f, 0.9f), Eigen::Vector3f::UnitZ()));
  EXPECT_EQ(index.mask(Eigen::Vector3f(2.1f, 0, 0)), 0U); // in the grid, away from the wall
  EXPECT_EQ(index.mask(Eigen::Vector3f(-70, 0, 0)), 0U);
}

TEST(PatchIndex, MasksOfUnorientedPatchesHoldBothSides)
{
  PlanarPatches patches = oneWall();
  patches.samples.oriented = false;
  const PatchIndex index(patches, 0.5);
  const std::uint64_t mask = index.mask(Eigen::Vector3f(1, 0, 0));
  EXPECT_NE(mask >> directionClass(Eigen::Vector3f::UnitX()) & 1, 0U);
  EXPECT_NE(mask >> directionClass(-Eigen::Vector3f::UnitX()) & 1, 0U);
}

/// Probes inside, outside and nowhere, among patches.
class PatchIndexCount : public ::testing::Test {
protected:
  PatchIndexCount()
  {
    testing::Random random(6);
    for (int i = 0; i < 300; ++i) {
      Eigen::Vector3f place = randomPlace(random, 5);
      if (i == 7)
        place.x() = kNan;
      else if (i == 8)
        place.y() = kInf;
      else if (i == 9)
        place.z() = -kMaxFloat;
      probes_.add(place, testing::randomRotation(random).col(0).cast<float>());
    }
  }

  /// Whether a probe, moved by \p t, has patches near it that face its way, by mask() alone.
  bool
  faces(std::size_t i, const Eigen::Vector3f& t) const
  {
    return (index_.mask(Eigen::Vector3f(probes_.x[i], probes_.y[i], probes_.z[i]) + t) & probes_.direction[i]) != 0;
  }

  const PatchIndex index_{testing::randomPatches(500, 4, 1, 5), 0.4};
  PatchIndex::Probes probes_;
};

TEST_F(PatchIndexCount, IsTheMaskOfEachProbe)
{
  // Any number of probes, moved anywhere: one by one it is the same.
  testing::Random random(8);
  int total = 0;
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector3f t = randomPlace(random, 3);
    const auto begin = static_cast<std::size_t>(3 * k);
    const std::size_t end = std::min(probes_.x.size(), begin + 7 * static_cast<std::size_t>(k));
    std::vector<std::int32_t> expected, found(end - begin, -1);
    for (std::size_t i = begin; i < end; ++i)
      expected.push_back(faces(i, t) ? 1 : 0);
    const int count = std::accumulate(expected.begin(), expected.end(), 0);
    EXPECT_EQ(index_.countFacing(probes_, begin, end, t), count) << k;
    index_.findFacing(probes_, begin, end, t, found.data());
    EXPECT_EQ(found, expected) << k;
    total += count;
  }
  EXPECT_GT(total, 100); // there was something to count
}

TEST_F(PatchIndexCount, OfALineIsThatOfEachShift)
{
  // Lines in any direction, also along one axis or two, that start within the grid and without, and lines of one place.
  testing::Random random(9);
  int total = 0;
  for (int k = 0; k < 120; ++k) {
    ShiftLine line{randomPlace(random, k % 3 == 0 ? 40 : 8), randomPlace(random, 0.3), static_cast<std::size_t>(k)};
    for (int axis = 0; axis < 3; ++axis)
      if (k >> axis & 1)
        line.step[axis] = axis == 1 ? -0.f : 0.f;
    if (k % 3 == 0)
      line.start = -0.5f * static_cast<float>(k) * line.step; // through the middle
    const auto begin = static_cast<std::size_t>(k);
    const std::vector<int> found = index_.countFacingAlong(line, probes_, begin, probes_.x.size());
    ASSERT_EQ(found.size(), line.count);
    for (std::size_t s = 0; s < line.count; ++s) {
      EXPECT_EQ(found[s], index_.countFacing(probes_, begin, probes_.x.size(), line[s])) << k << " " << s;
      total += found[s];
    }
  }
  EXPECT_GT(total, 1000);
}

TEST_F(PatchIndexCount, OfALineFarFromTheOrigin)
{
  // There floats are 0.06 m apart: what is next to the edge of the grid must not get lost.
  PlanarPatches patches = testing::randomPatches(200, 4, 1, 5);
  patches.samples.points.colwise() += Eigen::Vector3d(1e6, -1e6, 1e6);
  const PatchIndex far(patches, 0.4);
  const ShiftLine line{{1e6f - 8, -1e6f - 8, 1e6f - 8}, {0.13f, 0.13f, 0.13f}, 130};
  const std::vector<int> found = far.countFacingAlong(line, probes_, 0, probes_.x.size());
  for (std::size_t s = 0; s < line.count; ++s)
    EXPECT_EQ(found[s], far.countFacing(probes_, 0, probes_.x.size(), line[s])) << s;
  EXPECT_GT(std::accumulate(found.begin(), found.end(), 0), 100);
}

TEST_F(PatchIndexCount, OfPlacesThatOnlyTheShiftBringsNear)
{
  // Place and shift cancel, and what is left of them is rounded: the edge of the grid must be no nearer for a line.
  // Patches that stand on a corner reach the edge of the grid.
  PlanarPatches patches;
  for (const double x : {-5., 5.})
    addPatch(patches, {Eigen::Vector3d(x, 0, 0), Eigen::Vector3d(3, -3, 0), Eigen::Vector3d(3, 3, 0)});
  const PatchIndex index(patches, 0.4713);
  float inside = 0;
  float edge = 50;
  for (int i = 0; i < 60; ++i) {
    const float middle = (inside + edge) / 2;
    (index.mask({middle, 0, 0}) != 0 ? inside : edge) = middle;
  }
  ASSERT_GT(inside, 1);
  testing::Random random(11);
  constexpr std::size_t kAtEdge = 10; // the shift of a line that brings the place to the edge
  int total = 0;
  for (int k = 0; k < 20000; ++k) {
    const float from = (k % 2 == 0 ? 1e5f : -1e5f) * (1 + 0.5f * static_cast<float>(k) / 20000);
    PatchIndex::Probes probe;
    probe.add({from, 0, 0}, {0, 0, 1});
    ShiftLine line;
    line.step = {randomPlace(random, 0.25).x(), 0, 0};
    line.start = {edge - from - static_cast<float>(kAtEdge) * line.step.x(), 0, 0};
    line.count = 2 * kAtEdge;
    const std::vector<int> found = index.countFacingAlong(line, probe, 0, 1);
    for (std::size_t s = 0; s < line.count; ++s) {
      ASSERT_EQ(found[s], index.countFacing(probe, 0, 1, line[s])) << k << ' ' << s;
      total += found[s];
    }
  }
  EXPECT_GT(total, 1000);
}

TEST_F(PatchIndexCount, OfMoreShiftsThanAFloatTells)
{
  ShiftLine line;
  line.start.setZero();
  line.step = Eigen::Vector3f::Constant(1e-9f);
  line.count = (std::size_t{1} << 24U) + 3; // as a float one more
  const std::vector<int> found = index_.countFacingAlong(line, probes_, 0, 1);
  ASSERT_EQ(found.size(), line.count);
  EXPECT_EQ(found.back(), index_.countFacing(probes_, 0, 1, line[line.count - 1]));
}

TEST_F(PatchIndexCount, OfNothing)
{
  EXPECT_EQ(PatchIndex().countFacing(probes_, 0, probes_.x.size(), Eigen::Vector3f::Zero()), 0);
  std::vector<std::int32_t> found(probes_.x.size(), -1);
  PatchIndex().findFacing(probes_, 0, probes_.x.size(), Eigen::Vector3f::Zero(), found.data());
  EXPECT_EQ(found, std::vector<std::int32_t>(probes_.x.size(), 0));
  const ShiftLine line{Eigen::Vector3f::Zero(), Eigen::Vector3f::UnitX(), 3};
  EXPECT_EQ(PatchIndex().countFacingAlong(line, probes_, 0, probes_.x.size()), std::vector<int>(3, 0));
  EXPECT_EQ(index_.countFacingAlong(line, probes_, 5, 5), std::vector<int>(3, 0));
  EXPECT_TRUE(index_.countFacingAlong(ShiftLine(), probes_, 0, probes_.x.size()).empty());
}

TEST(PatchIndex, CountsWhatFacesWithinTheAngle)
{
  // A wall that faces along x, and a direction whose class has its centre 0.588 rad from it: atan(2 / 3).
  PatchIndex::Probes probes;
  probes.add({1, 0, 0}, Eigen::Vector3f(3, 2, 0).normalized());
  for (const auto& [facing, found] : {std::pair(0.57, 0), std::pair(0.6, 1)}) {
    const PatchIndex index(oneWall(), 0.5, 0.1, facing);
    EXPECT_EQ(index.countFacing(probes, 0, 1, Eigen::Vector3f::Zero()), found) << facing;
  }
}

TEST(ShiftLine, EverySecondOfIt)
{
  const ShiftLine line{{1, 2, 3}, {0.1f, 0.7f, -0.3f}, 7};
  const ShiftLine second = line.everySecond();
  ASSERT_EQ(second.count, 4U);
  for (std::size_t i = 0; i < second.count; ++i)
    EXPECT_EQ(second[i], line[2 * i]);
  EXPECT_EQ((ShiftLine{{1, 2, 3}, {1, 0, 0}, 0}).everySecond().count, 0U);
}

/// Against a loop over all patches: none within reach is missed, and none beyond the tolerance is found.
TEST(PatchIndex, FindsWhatIsWithinReach)
{
  const PlanarPatches patches = testing::randomPatches(400, 5, 1.2, 2);
  testing::Random random(3);
  for (const auto& [voxel, reach] : {std::pair(0.2, 0.05), {0.5, 0.2}, {0.5, 0.8}, {1.1, 0.01}}) {
    const PatchIndex index(patches, voxel, reach);
    ASSERT_EQ(index.reach(), reach);
    for (const bool either_side : {false, true}) {
      for (const double wanted : {0.9 * index.reach(), 0.3 * voxel, 2 * voxel}) {
        PatchIndex::Tolerance t = tolerance(static_cast<float>(wanted), static_cast<float>(wanted));
        t.either_side = either_side;
        const double certain = std::min(wanted, index.reach());
        int certainly_found = 0;
        for (int trial = 0; trial < 4000; ++trial) {
          // Places on or near some patch, and normals near its normal; the loop judges them against all.
          const Eigen::Index near = random.index(400);
          const Eigen::Vector3f p = (patches.samples.points.col(near) +
                                     random.uniform(-1, 1) * patches.samples.extents[near] * patches.majors.col(near))
                                        .cast<float>() +
                                    randomPlace(random, std::min(wanted, std::max(index.reach(), 0.2 * voxel)));
          const Eigen::Vector3f n = (patches.samples.normals.col(near).cast<float>() * (random.index(2) ? 1.f : -1.f) +
                                     randomPlace(random, 0.2))
                                        .normalized();
          double nearest_allowed = kInf, nearest_certain = kInf;
          const auto distanceTo = [&](Eigen::Index i) {
            return std::abs(patches.samples.normals.col(i).dot(p.cast<double>() - patches.samples.points.col(i)));
          };
          for (Eigen::Index i = 0; i < patches.size(); ++i) {
            const Eigen::Vector3d normal = patches.samples.normals.col(i), major = patches.majors.col(i);
            const Eigen::Vector3d d = p.cast<double>() - patches.samples.points.col(i);
            const double cosine = normal.dot(n.cast<double>());
            const double beyond_edge = std::max(std::abs(d.dot(major)) - patches.samples.extents[i],
                                                std::abs(d.dot(normal.cross(major))) - patches.half_minors[i]);
            const auto within = [&](double bound, double slack) {
              return (either_side ? std::abs(cosine) : cosine) >= static_cast<double>(t.min_cos) - slack &&
                     std::max(distanceTo(i), beyond_edge) <= bound + slack;
            };
            if (within(wanted, 1e-5))
              nearest_allowed = std::min(nearest_allowed, distanceTo(i));
            if (within(certain, -1e-5))
              nearest_certain = std::min(nearest_certain, distanceTo(i));
          }
          const int found = index.find(p, n, t);
          const double distance = found < 0 ? kInf : distanceTo(found);
          ASSERT_GE(distance, nearest_allowed - 1e-5);
          ASSERT_LE(distance, nearest_certain + 1e-5) << "voxel " << voxel << ", tolerance " << wanted;
          if (std::isfinite(nearest_certain)) {
            ++certainly_found;
            // The search over poses must not overlook it.
            ASSERT_NE(index.mask(p) & directionClassesNear(patches.samples.normals.col(found).cast<float>(), 0), 0U);
          }
        }
        EXPECT_GT(certainly_found, 20);
      }
    }
  }
}

/// In a corner of its voxel a place is farthest from where the patches of the voxel are looked for.
TEST(PatchIndex, FindsAPatchThatCutsACornerOfTheVoxel)
{
  testing::Random random(17);
  PlanarPatches patches;
  const Eigen::Vector3d normal = Eigen::Vector3d::Ones().normalized();
  const Eigen::Vector3d major = normal.unitOrthogonal();
  addPatch(patches, {Eigen::Vector3d::Zero(), 3 * major, 2 * normal.cross(major)});
  const PatchIndex index(patches, 0.5);
  const Eigen::Vector3f facing = patches.samples.normals.col(0).cast<float>();
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Vector3d p = random.uniform(-2.9, 2.9) * major + random.uniform(-1.9, 1.9) * normal.cross(major);
    ASSERT_EQ(index.find(p.cast<float>(), facing, tolerance(0.02f, 0.02f)), 0) << p.transpose();
  }
}

TEST(PatchIndexFindAll, IsFindOfEach)
{
  testing::Random random(8);
  constexpr std::size_t kCount = 1000; // no multiple of how many are looked up together
  std::array<std::vector<float>, 6> columns;
  for (std::size_t i = 0; i < kCount; ++i) {
    Eigen::Vector3f p = randomPlace(random, 5);
    if (i % 97 == 0)
      p.y() = std::numeric_limits<float>::quiet_NaN();
    if (i % 89 == 0)
      p.z() = 1e30f;
    const Eigen::Vector3f n = randomPlace(random, 1).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      columns[k].push_back(p[static_cast<Eigen::Index>(k)]);
      columns[3 + k].push_back(n[static_cast<Eigen::Index>(k)]);
    }
  }
  PatchIndex::Tolerance t = tolerance(0.3f, 0.3f);
  t.min_cos = 0.5f;
  for (const PatchIndex& index : {PatchIndex(testing::randomPatches(300, 4, 1, 9), 0.5), PatchIndex()}) {
    std::vector<int> found(kCount, -2);
    index.findAll({columns[0].data(), columns[1].data(), columns[2].data()},
                  {columns[3].data(), columns[4].data(), columns[5].data()},
                  kCount,
                  t,
                  found.data());
    int some = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      EXPECT_EQ(
          found[i],
          index.find({columns[0][i], columns[1][i], columns[2][i]}, {columns[3][i], columns[4][i], columns[5][i]}, t))
          << i;
      some += found[i] >= 0;
    }
    EXPECT_EQ(some > 50, !index.empty());
  }
}

TEST(PatchIndex, MeetingIsThePlanesOwn)
{
  const PlanarPatches patches = testing::randomPatches(40, 4, 1, 10);
  const PatchIndex index(patches, 0.5);
  testing::Random random(11);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d p = randomPlace(random, 4).cast<double>();
    const PatchIndex::Meeting at = index.meet(i, p);
    EXPECT_TRUE(at.normal.isApprox(patches.samples.normals.col(i), 1e-6));
    EXPECT_NEAR(at.distance, (p - patches.samples.points.col(i)).dot(patches.samples.normals.col(i)), 1e-5);
    EXPECT_GT(at.variance, index.meet(i, patches.samples.points.col(i)).variance);
  }
}

TEST(PatchIndex, OrderOfThePatchesDoesNotMatter)
{
  const PlanarPatches patches = testing::randomPatches(200, 4, 1, 4);
  PlanarPatches reversed;
  for (Eigen::Index i = patches.size() - 1; i >= 0; --i) {
    const Eigen::Vector3d minor = patches.samples.normals.col(i).cross(patches.majors.col(i));
    addPatch(reversed,
             {patches.samples.points.col(i),
              patches.samples.extents[i] * patches.majors.col(i),
              patches.half_minors[i] * minor});
  }
  const PatchIndex a(patches, 0.5), b(reversed, 0.5);
  testing::Random random(5);
  int found = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Eigen::Vector3f p = randomPlace(random, 4), n = randomPlace(random, 1).normalized();
    PatchIndex::Tolerance t = tolerance(0.3f, 0.3f);
    t.min_cos = 0.5f;
    const int i = a.find(p, n, t), j = b.find(p, n, t);
    EXPECT_EQ(a.mask(p), b.mask(p));
    EXPECT_EQ(i, j < 0 ? -1 : 199 - j);
    found += i >= 0;
  }
  EXPECT_GT(found, 100);
}

TEST(PatchIndex, VoxelGrowsUntilTheGridFits)
{
  const PlanarPatches patches = testing::randomPatches(50, 100, 1, 6);
  const PatchIndex index(patches, 0.1, 0.1, 0.5, 10000);
  EXPECT_GT(index.voxel(), 200 / std::cbrt(10000) * 0.9);
  EXPECT_LT(index.voxel(), 230 / std::cbrt(10000) * 1.3);
  for (int i = 0; i < 50; ++i) // each is still found at its own centroid
    EXPECT_GE(findAtPatch(index, patches, i), 0);
}

TEST(PatchIndex, DistanceToAPlaneIsLessCertainAwayFromItsPoints)
{
  // Against planes fitted to noisy points again and again.
  constexpr int kPoints = 12;
  constexpr int kTrials = 4000;
  constexpr double kNoise = 0.01;
  testing::Random random(5);
  Eigen::Matrix3Xd places(3, kPoints); // on z = 0, about 4 by 2
  for (int i = 0; i < kPoints; ++i) {
    const int row = i / 4;
    places.col(i) << 4 * (i % 4) / 3.0 - 2, row - 1, 0;
  }
  const Eigen::Matrix3d covariance = places * places.transpose() / kPoints;
  PlanarPatches patches;
  addPatch(patches,
           {Eigen::Vector3d::Zero(),
            Eigen::Vector3d(std::sqrt(3 * covariance(0, 0)), 0, 0),
            Eigen::Vector3d(0, std::sqrt(3 * covariance(1, 1)), 0)});
  patches.counts = {kPoints};
  const PatchIndex index(patches, 0.5);
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(0, 0), Eigen::Vector2d(2, 1), Eigen::Vector2d(-3, 0.5)}) {
    double squares = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      Eigen::Matrix<double, kPoints, 3> design;
      Eigen::Matrix<double, kPoints, 1> heights;
      for (int i = 0; i < kPoints; ++i) {
        design.row(i) << 1, places(0, i), places(1, i);
        heights[i] = kNoise * random.gaussian();
      }
      const Eigen::Vector3d plane = design.colPivHouseholderQr().solve(heights);
      const double distance = kNoise * random.gaussian() - plane.dot(Eigen::Vector3d(1, place.x(), place.y()));
      squares += distance * distance;
    }
    const double expected = squares / kTrials / (kNoise * kNoise);
    const PatchIndex::Meeting at = index.meet(0, Eigen::Vector3d(place.x(), place.y(), 0));
    EXPECT_NEAR(at.variance, expected, 0.1 * expected) << place.transpose();
  }
}

TEST(PatchIndex, Empty)
{
  for (const PatchIndex& index : {PatchIndex(), PatchIndex(PlanarPatches(), 0.5)}) {
    EXPECT_TRUE(index.empty());
    EXPECT_EQ(index.mask(Eigen::Vector3f::Zero()), 0U);
    EXPECT_EQ(index.find(Eigen::Vector3f::Zero(), Eigen::Vector3f::UnitX(), PatchIndex::Tolerance()), -1);
  }
}

TEST(PatchIndex, PlacesThatAreNoPlaces)
{
  const PatchIndex index(oneWall(), 0.5);
  for (const float x : {kNan, kInf, -kInf, kMaxFloat, -kMaxFloat})
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3f p(1, 0, 0);
      p[axis] = x;
      EXPECT_EQ(index.mask(p), 0U);
      EXPECT_EQ(index.find(p, Eigen::Vector3f::UnitX(), PatchIndex::Tolerance()), -1);
    }
}

TEST(PatchIndex, SurvivesExtremeScales)
{
  const PreparationConfig usual;
  constexpr std::size_t kMaxVoxels = 1 << 16; // patches reach all of them here
  for (const double scale : {1e-300, 1e-40, 1e-20, 1e6, 1e18, 1e30, 1e38}) {
    PlanarPatches patches = testing::randomPatches(20, 1, 0.3, 7);
    patches.samples.points *= scale;
    patches.samples.extents *= scale;
    patches.half_minors *= scale;
    for (const double voxel : {0.2 * scale, 1e-3, 1e6}) {
      const PatchIndex index(patches, voxel, usual.match, usual.loose_facing, kMaxVoxels);
      EXPECT_GE(index.voxel(), voxel);
      for (int i = 0; i < 20; ++i)
        findAtPatch(index, patches, i);
      if (scale >= 1e6 && scale <= 1e18) {
        EXPECT_GE(findAtPatch(index, patches, 0), 0) << scale;
      }
    }
  }
  // Two patches as far apart as numbers get.
  PlanarPatches apart;
  addPatch(apart, {Eigen::Vector3d::Constant(-3e38), Eigen::Vector3d(0, 2, 0), Eigen::Vector3d(0, 0, 1)});
  addPatch(apart, {Eigen::Vector3d::Constant(3e38), Eigen::Vector3d(0, 1e38, 0), Eigen::Vector3d(0, 0, 1)});
  const PatchIndex index(apart, 0.5);
  findAtPatch(index, apart, 1);
}

TEST(PatchIndex, KeepsPlacesFarFromTheOrigin)
{
  PlanarPatches patches = oneWall();
  patches.samples.points.colwise() += Eigen::Vector3d(1e6, -1e6, 1e6);
  const PatchIndex index(patches, 0.5);
  EXPECT_EQ(index.find(Eigen::Vector3f(1000001, -1000001, 1000000), Eigen::Vector3f::UnitX(), tolerance(0.2f, 0.2f)),
            0);
  EXPECT_EQ(index.find(Eigen::Vector3f(1000002, -1000001, 1000000), Eigen::Vector3f::UnitX(), tolerance(0.2f, 0.2f)),
            -1);
}

} // namespace
} // namespace pcl_ssfr::test_patch_index
