// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The same input gives the same bits: for any number of threads, and run after run in one process.

#include "pcl_clouds.h"
#include "real_scans.h"

#include <pcl_ssfr/structured_scene_registration.h>

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <vector>

namespace pcl_ssfr::test_determinism {
namespace {

using pcl_ssfr::testing::kNoRealScans;
using pcl_ssfr::testing::loadPoints;
using pcl_ssfr::testing::makeRoomPair;
using pcl_ssfr::testing::realScansFolder;
using pcl_ssfr::testing::ScanPair;

using Point = pcl::PointXYZ;
using Registration = StructuredSceneRegistration<Point, Point, double>;

/// Everything that a run returns, as bytes, the times of the stages apart.
std::vector<double>
fingerprint(const Registration& registration)
{
  const Result& result = registration.getResult();
  std::vector<double> numbers;
  const auto add = [&](const auto& matrix) {
    numbers.insert(numbers.end(), matrix.data(), matrix.data() + matrix.size());
  };
  numbers.push_back(static_cast<double>(result.status));
  add(result.T_target_source.matrix());
  add(result.information);
  numbers.insert(numbers.end(), {result.overlap, result.contradiction, result.confidence, result.rmse});
  for (const Candidate& candidate : result.candidates) {
    add(candidate.T_target_source.matrix());
    numbers.insert(numbers.end(), {candidate.score, candidate.overlap, candidate.contradiction});
  }
  for (const UnobservableDirection& direction : result.unobservable) {
    add(direction.direction);
    numbers.push_back(direction.strength);
  }
  for (const StageReport& stage : result.stages) {
    numbers.push_back(static_cast<double>(stage.count_in));
    numbers.push_back(static_cast<double>(stage.count_out));
  }
  for (const pcl::Correspondence& pair : *registration.getCorrespondences()) {
    numbers.insert(numbers.end(),
                   {static_cast<double>(pair.index_query), static_cast<double>(pair.index_match), pair.distance});
  }
  return numbers;
}

std::vector<double>
run(const ScanPair<Point>& pair, Profile profile, unsigned threads)
{
  Registration registration;
  registration.setProfile(profile);
  registration.setNumberOfThreads(threads);
  registration.setInputSource(pair.source);
  registration.setInputTarget(pair.target);
  pcl::PointCloud<Point> output;
  registration.align(output);
  EXPECT_FALSE(registration.getResult().candidates.empty()) << registration.getResult().message;
  return fingerprint(registration);
}

bool
sameBits(const std::vector<double>& a, const std::vector<double>& b)
{
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

void
expectOneAnswer(const ScanPair<Point>& pair, Profile profile)
{
  const std::vector<double> first = run(pair, profile, 1);
  EXPECT_TRUE(sameBits(first, run(pair, profile, 1))) << "second run";
  for (const unsigned threads : {2U, 8U, 0U}) {
    EXPECT_TRUE(sameBits(first, run(pair, profile, threads))) << threads << " threads";
  }
}

TEST(Determinism, FingerprintTellsPairsApart)
{
  EXPECT_FALSE(sameBits(run(makeRoomPair<Point>(false), Profile::Default, 1),
                        run(makeRoomPair<Point>(true), Profile::Default, 1)));
}

TEST(Determinism, DefaultProfileOnASimulatedPair)
{
  expectOneAnswer(makeRoomPair<Point>(false), Profile::Default);
}

TEST(Determinism, PaperProfileOnASimulatedPair)
{
  expectOneAnswer(makeRoomPair<Point>(false), Profile::Paper2017);
}

class DeterminismOnRealScans : public ::testing::TestWithParam<Profile> {};

TEST_P(DeterminismOnRealScans, RoomPair)
{
  if (realScansFolder().empty())
    GTEST_SKIP() << kNoRealScans;
  const std::filesystem::path folder = realScansFolder() / "room_pair_pcl";
  ScanPair<Point> pair;
  pair.source = loadPoints(folder / "room_scan2.pcd");
  pair.target = loadPoints(folder / "room_scan1.pcd");
  expectOneAnswer(pair, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Profiles,
                         DeterminismOnRealScans,
                         ::testing::Values(Profile::Default, Profile::Paper2017),
                         [](const auto& profile) {
                           return profile.param == Profile::Default ? "Default" : "Paper2017";
                         });

} // namespace
} // namespace pcl_ssfr::test_determinism
