// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Hard cases on real scans with ground truth (CMake: PCL_SSFR_TEST_DATA_DIR). Every source is rotated by a seeded
// random rotation about its sensor first. A row names pairs and how many of them may be missed; nothing wrong may be
// accepted. And sensors that have to be looked for.

#include "preparation/viewpoint_search.h"
#include "real_scans.h"
#include "simulated_scans.h"
#include "synthetic_scene.h"

#include <apps/io/dataset_folder.h>
#include <apps/pairs/pair_list.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_hard_real_pairs {
namespace {

using namespace pcl_ssfr::testing;
namespace fs = std::filesystem;

PosedScan
loadScan(const std::string& file, const apps::Degradation& degradation)
{
  constexpr std::uint64_t kSeed = 1;
  PosedScan scan;
  scan.points = toColumns(*apps::degraded(*loadPoints(file), degradation, kSeed));
  return scan;
}

/// A set and the rows of its pairs.csv to take.
struct Row {
  const char* what;
  const char* folder;
  std::vector<std::size_t> pairs; ///< rows of pairs.csv, the first is 0
  std::size_t may_fail;           ///< so many may be unsolved or refused
  apps::Degradation source;       ///< what is taken away from each source
  apps::Degradation target;       ///< and from each target
  std::uint64_t turns = 1000;     ///< seeds of the random turns: this and the number of the row
};

std::ostream&
operator<<(std::ostream& out, const Row& row)
{
  return out << row.what << ", " << row.folder;
}

/// Registers some rows of pairs with rotated sources: nothing wrong may be accepted, and all but \p may_fail must be
/// solved and accepted.
void
expectSolved(const std::string& folder,
             const std::vector<io::ScanPair>& pairs,
             const std::vector<std::size_t>& rows,
             std::size_t may_fail,
             const apps::Degradation& source_degradation = {},
             const apps::Degradation& target_degradation = {},
             std::uint64_t turns = 1000)
{
  std::size_t accepted = 0;
  std::string failures;
  for (const std::size_t number : rows) {
    const io::ScanPair& pair = pairs.at(number);
    PosedScan source = loadScan(io::scanPath(folder, pair.source), source_degradation);
    const PosedScan target = loadScan(io::scanPath(folder, pair.target), target_degradation);
    Random random(turns + number);
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() = randomRotation(random);
    source.points = transformed(turn, source.points);
    source.T_world_scan = pair.T_target_source * turn.inverse();
    const PairOutcome outcome = registerPosedScans(source, target);
    accepted += outcome.right && outcome.result.accepted();
    const std::string name = "pair " + std::to_string(number) + ", " + pair.source + " onto " + pair.target + ": ";
    EXPECT_TRUE(outcome.honest()) << name << describe(outcome.result);
    if (!outcome.right || !outcome.result.accepted())
      failures += name + (outcome.right ? "right: " : "not right: ") + describe(outcome.result) + '\n';
  }
  EXPECT_GE(accepted + may_fail, rows.size()) << failures;
}

apps::Degradation
every(std::size_t k)
{
  apps::Degradation degradation;
  degradation.every = k;
  return degradation;
}

apps::Degradation
nearest(double share)
{
  apps::Degradation degradation;
  degradation.nearest = share;
  return degradation;
}

class HardRealPairs : public ::testing::TestWithParam<Row> {};

TEST_P(HardRealPairs, AreSolved)
{
  const Row& row = GetParam();
  if (realScansFolder().empty())
    GTEST_SKIP() << kNoRealScans;
  const fs::path folder = realScansFolder() / row.folder;
  const io::DatasetFolder dataset = io::readDatasetFolder(folder.string());
  expectSolved(dataset.path, dataset.pairs, row.pairs, row.may_fail, row.source, row.target, row.turns);
}

TEST(OpenRoad, SensorsAreFoundInAnotherFrame)
{
  // Most returns are ground at a grazing angle. Few points make wide directions, in which even the sensor sees it at
  // two depths.
  if (realScansFolder().empty())
    GTEST_SKIP() << kNoRealScans;
  const fs::path folder = realScansFolder() / "ouster_kaist03";
  const io::DatasetFolder dataset = io::readDatasetFolder(folder.string());
  std::set<std::string> scans;
  for (const io::ScanPair& pair : dataset.pairs)
    scans.insert({pair.source, pair.target});
  Random random(5);
  std::size_t found = 0;
  for (const std::string& name : scans) {
    const Eigen::Matrix3f R = randomRotation(random).cast<float>();
    const Eigen::Vector3f sensor = 50 * randomRotation(random).col(0).cast<float>();
    const Eigen::Matrix3Xf points = toColumns(*loadPoints(io::scanPath(dataset.path, name)));
    const auto place = findViewpoint((R * points).colwise() + sensor, PreparationConfig(), 2);
    found += place && (*place - sensor).norm() < 1;
  }
  EXPECT_EQ(scans.size(), 21u);
  EXPECT_GE(found, 17u);
}

TEST(LittleOverlap, FifteenToThirtyPercentOfACarPark)
{
  // Pairs that the set does not list, 25 to 45 m apart. Poses that lay one scan over the other have three times the
  // votes.
  if (realScansFolder().empty())
    GTEST_SKIP() << kNoRealScans;
  const fs::path folder = realScansFolder() / "parking_tls";
  const io::DatasetFolder dataset = io::readDatasetFolder(folder.string());
  const std::set<std::pair<std::string, std::string>> wanted = {{"scan01.pcd", "scan05.pcd"},
                                                                {"scan01.pcd", "scan06.pcd"},
                                                                {"scan02.pcd", "scan05.pcd"},
                                                                {"scan02.pcd", "scan06.pcd"},
                                                                {"scan03.pcd", "scan07.pcd"},
                                                                {"scan08.pcd", "scan04.pcd"},
                                                                {"scan09.pcd", "scan05.pcd"},
                                                                {"scan09.pcd", "scan11.pcd"}};
  const apps::PairList unlisted(dataset, dataset, apps::PairsFrom::Unlisted);
  std::vector<io::ScanPair> pairs;
  for (std::size_t i = 0; i < unlisted.size(); ++i)
    pairs.push_back({unlisted[i].source, unlisted[i].target, unlisted[i].T_target_source.value()});
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (wanted.count({pairs[i].source, pairs[i].target}) > 0)
      rows.push_back(i);
  ASSERT_EQ(rows.size(), wanted.size());
  expectSolved(dataset.path, pairs, rows, 1);
}

TEST(SecondPass, PosesOfBothAreDistinctForAnyNumberOfThreads)
{
  // Two scans of a street, 45 m apart: the first pass does not decide.
  if (realScansFolder().empty())
    GTEST_SKIP() << kNoRealScans;
  const fs::path folder = realScansFolder() / "imm_A";
  const PosedScan source = loadScan((folder / "scan000.pcd").string(), {});
  const PosedScan target = loadScan((folder / "scan008.pcd").string(), {});
  std::vector<Result> results;
  for (const unsigned threads : {1u, 2u, 3u}) {
    Options options = defaultOptions();
    options.threads = threads;
    const auto [s, t] = prepareScans(viewOfPoints(source.points), viewOfPoints(target.points), options);
    results.push_back(registerScans(s, t, options));
  }
  const Result& result = results.front();
  const auto passes = std::count_if(result.stages.begin(), result.stages.end(), [](const StageReport& stage) {
    return stage.name == "translations";
  });
  ASSERT_EQ(passes, 2) << describe(result);
  ASSERT_GE(result.candidates.size(), 2U);
  expectDistinctCandidates(result, "imm_A");
  for (const Result& other : results) {
    EXPECT_EQ(other.confidence, result.confidence);
    ASSERT_EQ(other.candidates.size(), result.candidates.size());
    for (std::size_t i = 0; i < result.candidates.size(); ++i)
      EXPECT_EQ(other.candidates[i].T_target_source.matrix(), result.candidates[i].T_target_source.matrix()) << i;
  }
}

TEST(DifferentPlaces, AreNotBelieved)
{
  // A street laid on a car park so that 3 % of the surface met, with nothing against it, was accepted once.
  if (realScansFolder().empty())
    GTEST_SKIP() << kNoRealScans;
  const fs::path shared = realScansFolder();
  const std::vector<std::pair<std::string, std::string>> pairs = {
      {"outdoor_smoke_pair/@0", "parking_tls/scan00.pcd"},
      {"parking_tls/scan00.pcd", "outdoor_smoke_pair/@0"},
      {"imm_A/scan000.pcd", "parking_tls/scan00.pcd"},
      {"eth_facade/s0.pcd", "imm_A/scan005.pcd"},
      {"apartment_pair/@0", "room_pair_pcl/@0"},
      {"hall_livox_balm/@0", "corridor_sick_3dtk/@0"},
  };
  // @0: the source of the first pair of the set.
  const auto scanOf = [&](const std::string& name) {
    const std::size_t at = name.find("/@0");
    if (at == std::string::npos)
      return loadScan((shared / name).string(), {});
    const io::DatasetFolder dataset = io::readDatasetFolder((shared / name.substr(0, at)).string());
    return loadScan(io::scanPath(dataset.path, dataset.pairs.front().source), {});
  };
  for (const auto& [source_name, target_name] : pairs) {
    PosedScan source = scanOf(source_name);
    const PosedScan target = scanOf(target_name);
    for (const std::uint64_t seed : {0u, 1u}) {
      Random random(seed);
      Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
      if (seed > 0)
        turn.linear() = randomRotation(random);
      PosedScan rotated = source;
      rotated.points = transformed(turn, source.points);
      const PairOutcome outcome = registerPosedScans(rotated, target);
      EXPECT_FALSE(outcome.result.accepted())
          << source_name << " onto " << target_name << ", turn " << seed << ": " << describe(outcome.result);
      EXPECT_LT(outcome.result.confidence, 0.6) << source_name << " onto " << target_name << ", turn " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Rows,
    HardRealPairs,
    ::testing::Values(Row{"overlap of 31 to 42 %", "parking_tls", {6, 10, 12, 17, 18, 20, 22, 25}, 0, {}, {}},
                      Row{"overlap of 34 and 35 %", "eth_facade", {0, 16}, 0, {}, {}},
                      Row{"overlap of 40 to 42 %, street", "imm_A", {19, 27, 31, 43}, 1, {}, {}},
                      // The first search of one finds another place, which it would believe with little confidence. The
                      // right pose of another one has 0.66 to 0.79, by how the source is turned; a half turn rivals it.
                      Row{"overlap of 20 to 30 %: the nearest 65 % of the source",
                          "parking_tls",
                          {6, 10, 12, 17, 18, 20, 22, 25},
                          1,
                          nearest(0.65),
                          {},
                          3700},
                      // Of 40 turns the second is accepted in 25 and right in 38.
                      Row{"corridor", "corridor_sick_3dtk", {0, 1, 2}, 1, {}, {}},
                      Row{"ten times coarser source", "parking_tls", {0, 6, 10, 26}, 0, every(10), {}},
                      Row{"ten times coarser target", "parking_tls", {0, 6, 10, 26}, 0, {}, every(10)},
                      // One was solved only as long as its sensor was not recognised: given the sensor it never was.
                      Row{"ten times coarser source", "eth_facade", {0, 10, 20}, 1, every(10), {}},
                      // Two of these were accepted before confidence fell with contradictions and rivals: 29 % overlap
                      // with 3 % of it contradicted, and 15 % with a rival at 94 %.
                      Row{"ten times coarser target", "eth_facade", {0, 10, 20}, 2, {}, every(10)},
                      Row{"ten times coarser source", "room_pair_pcl", {0}, 0, every(10), {}},
                      Row{"ten times coarser target", "room_pair_pcl", {0}, 0, {}, every(10)},
                      Row{"ten times coarser source", "hall_livox_balm", {0, 40, 80, 120}, 1, every(10), {}}));

} // namespace
} // namespace pcl_ssfr::test_hard_real_pairs
