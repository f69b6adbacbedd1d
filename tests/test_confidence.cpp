// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/confidence.h>
#include <pcl_ssfr/options.h>

#include "synthetic_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pcl_ssfr {
namespace {

/// A pose as it looks when it is right: most surface meets, nothing hangs in free space.
Candidate
goodCandidate()
{
  Candidate c;
  c.overlap = 0.6;
  c.contradiction = 0.002;
  c.evidence.unmatched = 0.08;
  c.evidence.tightness = 0.8;
  c.evidence.weakest_direction = 0.7;
  c.evidence.third_direction = 0.15;
  return c;
}

/// A pose as it looks when the scans have nothing to do with each other.
Candidate
badCandidate()
{
  Candidate c;
  c.overlap = 0.12;
  c.contradiction = 0.05;
  c.evidence.unmatched = 0.25;
  c.evidence.tightness = 0.3;
  c.evidence.weakest_direction = 0.15;
  c.evidence.third_direction = 0.01;
  return c;
}

TEST(Confidence, SeparatesClearCases)
{
  for (const bool free_space : {false, true}) {
    EXPECT_GT(estimateConfidence(goodCandidate(), 0.5, free_space), 0.9) << free_space;
    EXPECT_LT(estimateConfidence(badCandidate(), 0.95, free_space), Options().min_confidence) << free_space;
  }
}

TEST(Confidence, NoEvidenceNoConfidence)
{
  EXPECT_EQ(estimateConfidence(Candidate(), 0, true), 0);
  EXPECT_EQ(estimateConfidence(Candidate(), 1, false), 0);
  Candidate nothing = goodCandidate();
  nothing.overlap = nothing.contradiction = nothing.evidence.unmatched = 0;
  EXPECT_EQ(estimateConfidence(nothing, 0.5, true), 0);
  nothing.overlap = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(estimateConfidence(nothing, 0.5, true), 0);
}

TEST(Confidence, IsAProbabilityForAnyEvidence)
{
  testing::Random random(1);
  for (int trial = 0; trial < 20000; ++trial) {
    Candidate c;
    const auto share = [&] { return random.index(4) == 0 ? random.index(2) : random.uniform(0, 1); };
    c.overlap = share();
    c.contradiction = share() * (1 - c.overlap);
    c.evidence.unmatched = share() * (1 - c.overlap - c.contradiction);
    c.evidence.tightness = share();
    c.evidence.weakest_direction = share();
    c.evidence.third_direction = share() / 3;
    const double confidence = estimateConfidence(c, random.uniform(-3, 1), trial % 2 == 0);
    ASSERT_TRUE(confidence >= 0 && confidence <= 1);
  }
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double ratio : {-infinity, infinity}) // no rival at all
    EXPECT_TRUE(std::isfinite(estimateConfidence(goodCandidate(), ratio, true)));
}

TEST(Confidence, GrowsWithTheOverlapAndWithTheThirdDirection)
{
  for (const bool free_space : {false, true}) {
    double before = 0;
    for (double overlap = 0.02; overlap < 0.9; overlap += 0.02) {
      Candidate c = goodCandidate();
      c.overlap = overlap;
      const double confidence = estimateConfidence(c, 0.5, free_space);
      EXPECT_GT(confidence, before) << overlap;
      before = confidence;
    }
    before = 0;
    for (double third = 0; third < 0.33; third += 0.02) {
      Candidate c = goodCandidate();
      c.overlap = 0.3;
      c.evidence.third_direction = third;
      const double confidence = estimateConfidence(c, 0.5, free_space);
      EXPECT_GT(confidence, before) << third;
      before = confidence;
    }
  }
}

TEST(Confidence, ContradictionsCountWhereTheyCouldBeSeen)
{
  Candidate clean = goodCandidate(), contradicted = goodCandidate();
  clean.overlap = contradicted.overlap = 0.35;
  clean.contradiction = 0;
  contradicted.contradiction = 0.05;
  EXPECT_LT(estimateConfidence(contradicted, 0.5, true), estimateConfidence(clean, 0.5, true));
  EXPECT_EQ(estimateConfidence(contradicted, 0.5, false), estimateConfidence(clean, 0.5, false));
}

TEST(Confidence, ACloseRivalDoesNotHelp)
{
  Candidate c = goodCandidate();
  c.overlap = 0.3;
  EXPECT_LE(estimateConfidence(c, 0.99, true), estimateConfidence(c, 0.2, true));
  EXPECT_EQ(estimateConfidence(c, 7, true), estimateConfidence(c, 1, true)); // a ratio above 1 is no ratio
}

} // namespace
} // namespace pcl_ssfr
