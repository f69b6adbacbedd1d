// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/confidence.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/options.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace pcl_ssfr {
namespace {

/// The score that poses are ranked by: contradictions are rare and weigh more.
void
rate(Candidate& c)
{
  c.evidence.patches_matched = c.overlap;
  c.evidence.patches_contradicted = c.contradiction;
  c.score = c.overlap - 12 * c.contradiction;
  c.evidence.facing_matched = c.evidence.patches_matched;
  c.evidence.facing_score = c.score;
}

/// The confidence in \p c when the best rival has \p ratio of its score.
double
withRival(const Candidate& c, double ratio, bool free_space)
{
  return estimateConfidence(c, c.score * (1 - ratio), free_space);
}

/// A pose as it looks when it is right: most surface meets, nothing hangs in free space.
Candidate
goodCandidate()
{
  Candidate c;
  c.overlap = 0.6;
  c.contradiction = 0.002;
  c.evidence.unmatched = 0.08;
  c.evidence.weakest_direction = 0.7;
  c.evidence.third_direction = 0.15;
  rate(c);
  return c;
}

/// A pose as it looks when the scans have nothing to do with each other.
Candidate
badCandidate()
{
  Candidate c;
  c.overlap = 0.12;
  c.contradiction = 0.005;
  c.evidence.unmatched = 0.25;
  c.evidence.weakest_direction = 0.15;
  c.evidence.third_direction = 0.01;
  rate(c);
  return c;
}

TEST(Confidence, SeparatesClearCases)
{
  for (const bool free_space : {false, true}) {
    EXPECT_GT(withRival(goodCandidate(), 0.5, free_space), 0.9) << free_space;
    EXPECT_LT(withRival(badCandidate(), 0.95, free_space), Options().min_confidence) << free_space;
  }
}

TEST(Confidence, NoEvidenceNoConfidence)
{
  EXPECT_EQ(estimateConfidence(Candidate(), 0, true), 0);
  EXPECT_EQ(estimateConfidence(Candidate(), 1, false), 0);
  Candidate nothing = goodCandidate();
  nothing.overlap = nothing.contradiction = nothing.evidence.unmatched = nothing.score = 0;
  EXPECT_EQ(estimateConfidence(nothing, 0.5, true), 0);
  nothing.overlap = nothing.evidence.patches_matched = nothing.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(estimateConfidence(nothing, 0.5, true), 0);
}

TEST(Confidence, FallsWithContradictionsAndWithARival)
{
  // Two offices alike: most surface meets, but the desks stand elsewhere.
  Candidate twin = goodCandidate();
  twin.overlap = 0.7;
  twin.contradiction = 0.028;
  rate(twin);
  Candidate same_score = goodCandidate();
  same_score.overlap = twin.score;
  same_score.contradiction = 0;
  rate(same_score);
  EXPECT_LT(withRival(twin, 0.2, true), withRival(same_score, 0.2, true));
  double before = 1;
  for (double ratio = 0.05; ratio < 1; ratio += 0.1) {
    const double now = withRival(goodCandidate(), ratio, true);
    EXPECT_LT(now, before);
    before = now;
  }
  // A rival that contradicts itself away is no more than none.
  EXPECT_EQ(withRival(goodCandidate(), -0.5, true), withRival(goodCandidate(), 0, true));
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
    c.evidence.weakest_direction = share();
    c.evidence.third_direction = share() / 3;
    c.evidence.patches_matched = share();
    c.score = c.evidence.patches_matched - random.uniform(0, 20) * share();
    c.evidence.facing_matched = share();
    c.evidence.facing_score = c.evidence.facing_matched - random.uniform(0, 20) * share();
    const double confidence = estimateConfidence(c, random.uniform(-3, 1), trial % 2 == 0);
    ASSERT_TRUE(confidence >= 0 && confidence <= 1);
  }
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double lead : {-infinity, infinity})
    EXPECT_TRUE(std::isfinite(estimateConfidence(goodCandidate(), lead, true)));
}

TEST(Confidence, GrowsWithTheOverlapAndWithTheThirdDirection)
{
  for (const bool free_space : {false, true}) {
    double before = 0;
    for (double overlap = 0.02; overlap < 0.9; overlap += 0.02) {
      Candidate c = goodCandidate();
      c.overlap = overlap;
      c.contradiction = 0;
      rate(c);
      const double confidence = withRival(c, 0.5, free_space);
      EXPECT_GT(confidence, before) << overlap;
      before = confidence;
    }
    before = 0;
    for (double third = 0; third < 0.33; third += 0.02) {
      Candidate c = goodCandidate();
      c.overlap = 0.3;
      rate(c);
      c.evidence.third_direction = third;
      const double confidence = withRival(c, 0.5, free_space);
      EXPECT_GT(confidence, before) << third;
      before = confidence;
    }
  }
}

TEST(Confidence, ContradictionsSpeakAgainstAPose)
{
  Candidate clean = goodCandidate(), contradicted = goodCandidate();
  clean.overlap = contradicted.overlap = 0.35;
  clean.contradiction = 0;
  contradicted.contradiction = 0.02;
  rate(clean);
  rate(contradicted);
  EXPECT_LT(withRival(contradicted, 0.5, true), withRival(clean, 0.5, true));
  contradicted.contradiction = 0.05; // more than the matches are worth
  rate(contradicted);
  EXPECT_LT(withRival(contradicted, 0.5, true), Options().min_confidence);
}

TEST(Confidence, ACloseRivalDoesNotHelp)
{
  Candidate c = goodCandidate();
  c.overlap = 0.3;
  rate(c);
  for (const bool free_space : {false, true})
    EXPECT_LE(withRival(c, 0.99, free_space), withRival(c, 0.2, free_space));
  EXPECT_LE(withRival(c, 0.99, true), withRival(c, 0.2, true));
  EXPECT_EQ(estimateConfidence(c, -0.3, true), estimateConfidence(c, 0, true)); // behind its rival is no lead
}

} // namespace
} // namespace pcl_ssfr
