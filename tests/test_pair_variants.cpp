// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>
#include <apps/io/file_bytes.h>
#include <apps/pairs/pair_list.h>
#include <apps/pairs/pair_truth.h>
#include <apps/pairs/result_row.h>

#include <pcl/point_types.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

namespace pcl_ssfr::apps::test_pair_variants {
namespace {

/// Points on a circle of 360, one a degree, at ranges 1, 2, 3, ... [m].
pcl::PointCloud<pcl::PointXYZ>
spiral()
{
  pcl::PointCloud<pcl::PointXYZ> scan;
  for (int i = 0; i < 360; ++i) {
    const double angle = (i + 0.5) / 180 * std::acos(-1.0);
    const double range = i + 1;
    scan.push_back({static_cast<float>(range * std::cos(angle)), static_cast<float>(range * std::sin(angle)), 0.f});
  }
  return scan;
}

std::vector<int>
rangesOf(const pcl::PointCloud<pcl::PointXYZ>& scan)
{
  std::vector<int> ranges;
  for (const pcl::PointXYZ& p : scan)
    ranges.push_back(static_cast<int>(std::lround(p.getVector3fMap().norm())));
  return ranges;
}

TEST(Degraded, NothingByDefault)
{
  EXPECT_EQ(degraded(spiral(), Degradation(), 1)->size(), 360u);
  EXPECT_TRUE(degraded(pcl::PointCloud<pcl::PointXYZ>(), Degradation{3, 90, 0.5}, 1)->empty());
}

TEST(Degraded, EveryNth)
{
  const auto ranges = rangesOf(*degraded(spiral(), Degradation{100, 360, 1}, 1));
  EXPECT_THAT(ranges, ::testing::ElementsAre(1, 101, 201, 301));
}

TEST(Degraded, NearestShareInItsOrder)
{
  pcl::PointCloud<pcl::PointXYZ> scan;
  for (const float range : {5.f, 1.f, 4.f, 2.f, 3.f})
    scan.push_back({0, range, 0});
  EXPECT_THAT(rangesOf(*degraded(scan, Degradation{1, 360, 0.6}, 1)), ::testing::ElementsAre(1, 2, 3));
  EXPECT_TRUE(degraded(scan, Degradation{1, 360, 0}, 1)->empty());
}

TEST(Degraded, ASectorInOnePiece)
{
  std::set<std::vector<int>> sectors;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto kept = rangesOf(*degraded(spiral(), Degradation{1, 90, 1}, seed));
    EXPECT_NEAR(static_cast<double>(kept.size()), 90, 1);
    int gaps = 0; // around the circle
    for (std::size_t i = 0; i < kept.size(); ++i)
      gaps += (kept[(i + 1) % kept.size()] - kept[i] + 360) % 360 != 1;
    EXPECT_EQ(gaps, 1);
    EXPECT_EQ(kept, rangesOf(*degraded(spiral(), Degradation{1, 90, 1}, seed)));
    sectors.insert(kept);
  }
  EXPECT_GT(sectors.size(), 3u);
  EXPECT_TRUE(degraded(spiral(), Degradation{1, 0, 1}, 1)->empty());
}

TEST(Degraded, NamesWhatIsOutOfRange)
{
  for (const auto& [degradation, name] : std::vector<std::pair<Degradation, std::string>>{
           {{0, 360, 1}, "every"}, {{1, 361, 1}, "sector"}, {{1, -1, 1}, "sector"}, {{1, 360, 1.5}, "nearest"}})
    try {
      degraded(spiral(), degradation, 1);
      FAIL() << name;
    }
    catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr(name));
    }
}

TEST(Degraded, AboutTheSensorWithoutWhatIsNotFinite)
{
  pcl::PointCloud<pcl::PointXYZ> scan;
  for (const float x : {10.f, 11.f, std::nanf(""), 14.f, 0.f})
    scan.push_back({x, 0, 0});
  const auto kept = degraded(scan, {1, 360, 0.5}, 1, Eigen::Vector3f(11, 0, 0));
  ASSERT_EQ(kept->size(), 2u);
  EXPECT_EQ((*kept)[0].x, 10);
  EXPECT_EQ((*kept)[1].x, 11);
}

io::ScanPair
pairOf(const char* source, const char* target, double x)
{
  io::ScanPair pair{source, target, Eigen::Isometry3d::Identity()};
  pair.T_target_source.translation().x() = x;
  return pair;
}

/// "source target x", or "source target ?" where no pose is known.
std::vector<std::string>
inWords(const std::vector<io::ScanPair>& pairs, PairsFrom from, const std::vector<io::ScanPair>& others = {})
{
  io::DatasetFolder dataset;
  dataset.pairs = pairs;
  io::DatasetFolder targets = dataset;
  if (from == PairsFrom::Unrelated)
    targets.pairs = others;
  const PairList list(dataset, targets, from);
  std::vector<std::string> words;
  for (std::size_t i = 0; i < list.size(); ++i)
    words.push_back(
        list[i].source + list[i].target + " " +
        (list[i].T_target_source ? std::to_string(std::lround(list[i].T_target_source->translation().x())) : "?"));
  return words;
}

TEST(PairList, TheOtherWayRoundAndAlongChains)
{
  // c -> b -> a in steps of 1 and 2 m; y -> x apart from them.
  const std::vector<io::ScanPair> pairs = {pairOf("b", "a", 2), pairOf("c", "b", 1), pairOf("y", "x", 7)};
  EXPECT_THAT(inWords(pairs, PairsFrom::Listed), ::testing::ElementsAre("ba 2", "cb 1", "yx 7"));
  EXPECT_THAT(inWords(pairs, PairsFrom::Unlisted),
              ::testing::UnorderedElementsAre("ab -2", "bc -1", "ca 3", "ac -3", "xy -7"));
  EXPECT_THAT(
      inWords(pairs, PairsFrom::All),
      ::testing::UnorderedElementsAre("ba 2", "cb 1", "ac -3", "yx 7", "ax ?", "ay ?", "bx ?", "by ?", "cx ?", "cy ?"));
  EXPECT_THAT(inWords(pairs, PairsFrom::Unrelated, {pairOf("p", "q", 1), pairOf("r", "s", 1)}),
              ::testing::ElementsAre("bq ?", "cs ?", "yq ?"));
}

TEST(PairList, TheShortestChainIsTheTruth)
{
  // Directly 5 m, around 1 + 1 m.
  const std::vector<io::ScanPair> pairs = {pairOf("a", "b", 1), pairOf("b", "c", 1), pairOf("a", "c", 5)};
  EXPECT_THAT(inWords(pairs, PairsFrom::All), ::testing::UnorderedElementsAre("ab 1", "ac 5", "bc 1"));
}

TEST(PairList, NoneOfNothing)
{
  EXPECT_TRUE(inWords({}, PairsFrom::Unlisted).empty());
  EXPECT_TRUE(inWords({}, PairsFrom::All).empty());
  EXPECT_TRUE(inWords({pairOf("a", "b", 1), pairOf("b", "a", -1)}, PairsFrom::Unlisted).empty());
}

/// Three scans of the same 60 points, each in a frame of its own: a -> b and c -> b are listed.
class VariedPair : public ::testing::Test {
protected:
  VariedPair()
  {
    RandomStream random(5);
    std::map<std::string, Eigen::Isometry3d> T_scan_world;
    Eigen::Matrix3Xd world(3, 60);
    for (Eigen::Index i = 0; i < world.cols(); ++i)
      world.col(i) = Eigen::Vector3d(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0, 3));
    for (const char* scan : {"a.xyz", "b.xyz", "c.xyz"}) {
      Eigen::Isometry3d& T = T_scan_world[scan];
      T = Eigen::Translation3d(random.uniform(-2, 2), random.uniform(-2, 2), 0) * Eigen::Quaterniond(random.rotation());
      std::string text;
      for (Eigen::Index i = 0; i < world.cols(); ++i) {
        const Eigen::Vector3d p = T * world.col(i);
        text += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
      }
      io::writeFile(folder_.file(scan), text);
    }
    dataset_.name = "room";
    dataset_.path = folder_.file("");
    for (const char* scan : {"a.xyz", "c.xyz"})
      dataset_.pairs.push_back({scan, "b.xyz", T_scan_world["b.xyz"] * T_scan_world[scan].inverse()});
  }
  PairRequest
  request(const Variation& variation, std::uint64_t seed = 1) const
  {
    return PairList(dataset_, dataset_, variation.pairs_from).request(0, variation, seed).value();
  }
  /// Largest distance between points of the source under the truth and the same points of the target [m].
  static double
  misfit(const PairInput& pair)
  {
    double worst = 0;
    for (std::size_t i = 0; i < pair.source.points->size(); ++i) {
      const Eigen::Vector3d p = (*pair.source.points)[i].getVector3fMap().cast<double>();
      const Eigen::Vector3d q = (*pair.target.points)[i].getVector3fMap().cast<double>();
      worst = std::max(worst, (pair.T_target_source.value() * p - q).norm());
    }
    return worst;
  }
  /// Volume that three points span with the first of the cloud, with its sign [m^3].
  static double
  signedVolume(const io::LoadedCloud& cloud)
  {
    Eigen::Matrix3d m;
    for (Eigen::Index k = 0; k < 3; ++k)
      m.col(k) =
          ((*cloud.points)[static_cast<std::size_t>(k) + 1].getVector3fMap() - cloud.points->front().getVector3fMap())
              .cast<double>();
    return m.determinant();
  }

  pcl_ssfr::testing::TemporaryFolder folder_;
  io::DatasetFolder dataset_;
};

TEST_F(VariedPair, TruthAndSensorFollowEachMotion)
{
  const PairInput plain = loadPair(request({}));
  EXPECT_LT(misfit(plain), 1e-4);
  EXPECT_EQ(plain.reference.norm(), 0);
  Variation variation;
  variation.perturbation = Perturbation::Rotation;
  const PairInput rotated = loadPair(request(variation));
  EXPECT_LT(misfit(rotated), 1e-4);
  EXPECT_EQ(rotated.reference.norm(), 0); // about the sensor
  EXPECT_GT((rotated.T_target_source->linear() - plain.T_target_source->linear()).norm(), 0.1);
  EXPECT_TRUE(rotated.T_target_source->isApprox(*loadPair(request(variation)).T_target_source));
  EXPECT_FALSE(rotated.T_target_source->isApprox(*loadPair(request(variation, 2)).T_target_source));
  variation.origin_offset_m = 50;
  const PairInput away = loadPair(request(variation));
  EXPECT_LT(misfit(away), 1e-4);
  EXPECT_NEAR(away.reference.norm(), 50, 1e-6);
  EXPECT_FALSE(away.source.viewpoint); // nobody knows
  EXPECT_FALSE(away.target.viewpoint);
  for (const io::LoadedCloud* cloud : {&away.source, &away.target})
    EXPECT_GT(cloud->points->front().getVector3fMap().norm(), 40);
  // The sensor of the source is where it was, seen from the target.
  const Eigen::Vector3d shift =
      ((*away.target.points)[0].getVector3fMap() - (*plain.target.points)[0].getVector3fMap()).cast<double>();
  EXPECT_LT((*away.T_target_source * away.reference - shift - *plain.T_target_source * plain.reference).norm(), 1e-4);
}

TEST_F(VariedPair, FarOriginsLeaveThePointsTheirDigits)
{
  Variation variation;
  const PairInput plain = loadPair(request(variation));
  variation.origin_offset_m = 1e6;
  const PairInput away = loadPair(request(variation));
  for (const auto& [far, near] : {std::pair{&away.source, &plain.source}, std::pair{&away.target, &plain.target}}) {
    EXPECT_NEAR(far->offset.norm(), 1e6, 1e-6);
    EXPECT_FALSE(far->viewpoint);
    for (std::size_t i = 0; i < near->points->size(); ++i)
      EXPECT_EQ((*far->points)[i].getVector3fMap(), (*near->points)[i].getVector3fMap());
  }
  EXPECT_NEAR(away.reference.norm(), 1e6, 1e-6);
  for (std::size_t i = 0; i < away.source.points->size(); ++i) {
    const Eigen::Vector3d p = away.source.offset + (*away.source.points)[i].getVector3fMap().cast<double>();
    const Eigen::Vector3d q = away.target.offset + (*away.target.points)[i].getVector3fMap().cast<double>();
    EXPECT_LT((*away.T_target_source * p - q).norm(), 1e-4);
  }
}

TEST_F(VariedPair, AnotherScanIsLaidIntoTheTarget)
{
  Variation variation;
  variation.merge_target = true;
  const PairInput pair = loadPair(request(variation));
  ASSERT_EQ(pair.target.points->size(), 120u);
  EXPECT_LT(misfit(pair), 1e-4);
  for (std::size_t i = 0; i < 60; ++i) // the same points of the world
    EXPECT_LT(((*pair.target.points)[i].getVector3fMap() - (*pair.target.points)[60 + i].getVector3fMap()).norm(),
              1e-4);
  dataset_.pairs.pop_back();
  EXPECT_FALSE(PairList(dataset_, dataset_, PairsFrom::Listed).request(0, variation, 1)); // there is none
}

TEST_F(VariedPair, NoPoseIsRightForAMirroredSource)
{
  Variation variation;
  const double plain = signedVolume(loadPair(request(variation)).source);
  variation.mirror_source = true;
  variation.perturbation = Perturbation::Rotation;
  const PairInput pair = loadPair(request(variation));
  EXPECT_FALSE(pair.T_target_source);
  EXPECT_NEAR(signedVolume(pair.source), -plain, 1e-3 * std::abs(plain));
  const PairTruth truth = measureTruth(pair);
  EXPECT_FALSE(truth.T_target_source);
  EXPECT_TRUE(std::isnan(truth.overlap));
  EXPECT_EQ(truth.source_points, 60u);
  const PairTruth back = pairTruthFromJson(toJson(truth));
  EXPECT_FALSE(back.T_target_source);
  EXPECT_TRUE(std::isnan(back.gt_rmse));
}

TEST_F(VariedPair, TheSourceAloneIsDegraded)
{
  Variation variation;
  variation.degradation = {2, 360, 0.5};
  const PairInput pair = loadPair(request(variation));
  EXPECT_EQ(pair.source.points->size(), 15u);
  EXPECT_EQ(pair.target.points->size(), 60u);
  float farthest = 0;
  for (const auto& point : *pair.source.points)
    farthest = std::max(farthest, point.getVector3fMap().norm());
  std::size_t nearer = 0;
  for (const auto& point : *loadPair(request({})).source.points)
    nearer += point.getVector3fMap().norm() <= farthest;
  EXPECT_LE(nearer, 30u);
}

TEST_F(VariedPair, EveryFieldIsKeptAndTellsRowsApart)
{
  std::vector<Variation> variations(1);
  std::size_t fields = 0;
  forEachField(variations[0], [&fields](const char*, const auto&) { ++fields; });
  for (std::size_t field = 0; field < fields; ++field) {
    Variation changed;
    std::size_t place = 0;
    forEachField(changed, [&](const char*, auto& value) {
      using Value = std::decay_t<decltype(value)>;
      if (place++ != field)
        return;
      if constexpr (std::is_same_v<Value, bool>)
        value = true;
      else if constexpr (std::is_enum_v<Value>)
        value = static_cast<Value>(1);
      else if constexpr (std::is_integral_v<Value>)
        value = 1234567;
      else
        value = value > 1 ? value / 2 : value > 0 ? 0.5 : 0.25;
    });
    variations.push_back(changed);
  }
  std::set<std::string> keys, words;
  for (const Variation& variation : variations) {
    keys.insert(rowKey("d", "", 0, variation, "m"));
    words.insert(describeVariation(variation));
    EXPECT_EQ(toJson(variationFromJson(toJson(variation))), toJson(variation));
    ResultRow row;
    row.variation = variation;
    EXPECT_EQ(toJson(rowFromCsv(toCsvLine(row)).variation), toJson(variation));
    PairRequest sent = request({});
    sent.variation = variation;
    EXPECT_EQ(toJson(pairRequestFromJson(toJson(sent))), toJson(sent));
  }
  EXPECT_EQ(keys.size(), fields + 1);
  EXPECT_EQ(words.size(), fields + 1);
  EXPECT_NE(rowKey("d", "", 0, {}, "m"), rowKey("d", "e", 0, {}, "m"));
}

} // namespace
} // namespace pcl_ssfr::apps::test_pair_variants
