// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "simulated_scans.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

// Rates of success over the pairs of a case.
namespace pcl_ssfr::testing {

/// A scene, what it is scanned with, and how far apart.
struct Place {
  const char* scene;
  const char* sensor;
  std::size_t beams;
  double step; ///< [m]
};

inline std::ostream&
operator<<(std::ostream& out, const Place& place)
{
  return out << place.scene << "_" << place.sensor;
}

inline std::string
nameOfPlace(const ::testing::TestParamInfo<Place>& info)
{
  return std::string(info.param.scene) + "_" + info.param.sensor;
}

/// What became of the pairs of a case.
struct Tally {
  std::size_t pairs = 0;
  std::size_t solved = 0;   ///< the best pose is right
  std::size_t accepted = 0; ///< and it was accepted
  std::size_t wrong = 0;    ///< accepted, and not right
  std::string failures;     ///< a line for each pair that was not solved and accepted

  void
  add(const PosedScan& source, const PosedScan& target, const std::string& name)
  {
    const PairOutcome outcome = registerPosedScans(source, target);
    ++pairs;
    solved += outcome.right;
    accepted += outcome.right && outcome.result.accepted();
    wrong += !outcome.honest();
    if (!outcome.right || !outcome.result.accepted())
      failures += name + (outcome.right ? ", right" : ", not right") + ": " + describe(outcome.result) + '\n';
  }
};

/// Add the pair (i, j) of some scans.
inline void
addPair(Tally& tally, const std::vector<PosedScan>& scans, std::size_t i, std::size_t j, std::uint64_t seed)
{
  tally.add(scans[i],
            scans[j],
            "seed " + std::to_string(seed) + ", scan " + std::to_string(i) + " onto " + std::to_string(j));
}

/// Each scan onto the one before it.
inline void
addConsecutive(Tally& tally, const std::vector<PosedScan>& scans, std::uint64_t seed)
{
  for (std::size_t i = 1; i < scans.size(); ++i)
    addPair(tally, scans, i, i - 1, seed);
}

/// Each scan onto all before it.
inline void
addAllPairs(Tally& tally, const std::vector<PosedScan>& scans, std::uint64_t seed)
{
  for (std::size_t i = 1; i < scans.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      addPair(tally, scans, i, j, seed);
}

/// All pairs are right and accepted.
inline void
expectAllBelieved(const Tally& tally)
{
  EXPECT_EQ(tally.accepted, tally.pairs) << tally.failures;
  EXPECT_EQ(tally.wrong, 0u) << tally.failures;
}

} // namespace pcl_ssfr::testing
