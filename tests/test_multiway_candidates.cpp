// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Which pairs of a large job are linked: how alike scans are, and the rounds of candidates in made-up jobs.

#include "multiway/candidate_pairs.h"
#include "multiway/scan_signature.h"

#include <synthetic_scene.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace pcl_ssfr::test_multiway_candidates {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Places on the walls, floor and ceiling of an empty room, normals inwards, in a frame of their own.
VotingSamples
votesOfRoom(const Eigen::Vector3d& size, const Eigen::Isometry3d& T)
{
  std::vector<Eigen::Vector3d> points, normals;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {0.0, 1.0})
      for (const double a : {0.1, 0.4, 0.9})
        for (const double b : {0.2, 0.5, 0.7}) {
          Eigen::Vector3d p;
          p[axis] = side * size[axis];
          p[(axis + 1) % 3] = a * size[(axis + 1) % 3];
          p[(axis + 2) % 3] = b * size[(axis + 2) % 3];
          points.emplace_back(T * p);
          normals.emplace_back(T.linear() * (1 - 2 * side) * Eigen::Vector3d::Unit(axis));
        }
  VotingSamples votes;
  votes.points.resize(3, static_cast<Eigen::Index>(points.size()));
  votes.normals.resize(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    votes.points.col(static_cast<Eigen::Index>(i)) = points[i].cast<float>();
    votes.normals.col(static_cast<Eigen::Index>(i)) = normals[i].cast<float>();
  }
  return votes;
}

Eigen::Isometry3d
frame(std::uint64_t seed)
{
  testing::Random random(seed);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = testing::randomRotation(random);
  T.translation() << random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5);
  return T;
}

TEST(ScanSignature, isOfTheDistancesBetweenParallelPlanes)
{
  const MultiwayOptions options;
  const Eigen::VectorXf signature = signatureOf(votesOfRoom({4, 5.45, 2.5}, frame(1)), 1, options);
  ASSERT_EQ(signature.size(), 121);
  EXPECT_NEAR(signature.squaredNorm(), 1, 1e-5);
  // Within each of six planes 36 pairs at no distance, across each of three distances 81.
  const double all = 6 * 36 + 3 * 81;
  EXPECT_NEAR(signature[0] * signature[0] + signature[1] * signature[1], 6 * 36 / all, 1e-4);
  const auto share = [&](int bin) { return signature[bin] * signature[bin] + signature[bin + 1] * signature[bin + 1]; };
  EXPECT_NEAR(share(39) + share(41) - signature[41] * signature[41], 81 / all, 1e-3); // 4 m, rounded either way
  EXPECT_NEAR(signature[54] * signature[54], 81 / all / 2, 1e-3);                     // 5.45 m: half a bin each
  EXPECT_NEAR(signature[55] * signature[55], 81 / all / 2, 1e-3);
}

TEST(ScanSignature, isTheSameInAnyFrameAndAtAnyScale)
{
  const MultiwayOptions options;
  const Eigen::Vector3d size(4.02, 5.43, 2.57);
  const Eigen::VectorXf signature = signatureOf(votesOfRoom(size, Eigen::Isometry3d::Identity()), 1, options);
  for (const std::uint64_t seed : {1U, 2U, 3U})
    EXPECT_LT((signatureOf(votesOfRoom(size, frame(seed)), 1, options) - signature).norm(), 0.01F) << seed;
  EXPECT_LT((signatureOf(votesOfRoom(7 * size, frame(4)), 7, options) - signature).norm(), 0.01F);
}

TEST(ScanSignature, ofNothingIsZeroAndLikeNothing)
{
  const MultiwayOptions options;
  const Eigen::VectorXf nothing = signatureOf({}, 1, options);
  EXPECT_EQ(nothing.size(), 121);
  EXPECT_TRUE(nothing.isZero(0));
  const Eigen::VectorXf room = signatureOf(votesOfRoom({4, 5, 3}, frame(1)), 1, options);
  const Eigen::VectorXf far = signatureOf(votesOfRoom({40, 50, 30}, frame(1)), 1, options); // planes out of reach
  EXPECT_TRUE(far.allFinite());
  EXPECT_TRUE(ScanLikeness({nothing, nothing}).of(0).isZero(0));
  EXPECT_TRUE(ScanLikeness({nothing, room}).of(1).isZero(0)); // the mean of one is itself
  EXPECT_TRUE(ScanLikeness({nothing, room, far}).of(1).allFinite());
  EXPECT_EQ(ScanLikeness({nothing, room, far}).of(1)[0], 0);
}

TEST(ScanSignature, scansOfOneRoomAreMoreAlikeThanThoseOfTwo)
{
  const MultiwayOptions options;
  std::vector<Eigen::VectorXf> signatures;
  for (const std::uint64_t seed : {1U, 2U, 3U})
    for (const double width : {3.3, 5.2, 6.6}) // all as high
      signatures.push_back(signatureOf(votesOfRoom({width, width + 1, 2.7}, frame(seed)), 1, options));
  const ScanLikeness likeness(signatures);
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t k = 0; k < 9; ++k) {
      if (k % 3 == i % 3)
        EXPECT_GT(likeness.of(i)[static_cast<Eigen::Index>(k)], 0.9F) << i << k;
      else
        EXPECT_LT(likeness.of(i)[static_cast<Eigen::Index>(k)], 0.1F) << i << k;
    }
}

/// A job whose scans meet where their setups are near; signatures are made up so that the test says who is like whom.
struct Job {
  std::vector<Eigen::Isometry3d> truth;
  CandidateScans scans;
  MultiwayOptions options;
  double reach = 4;         ///< [m] within which two scans share enough
  std::set<ScanPair> blind; ///< pairs that are not found though they share enough

  explicit Job(const std::vector<Eigen::Vector3d>& setups)
  {
    options.threads = 1;
    const auto n = static_cast<Eigen::Index>(setups.size());
    testing::Random random(5);
    for (Eigen::Index i = 0; i < n; ++i) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = testing::randomRotation(random);
      T.translation() = setups[static_cast<std::size_t>(i)];
      truth.push_back(T);
      scans.signatures.emplace_back(Eigen::VectorXf::Unit(n, i));
    }
    scans.usable.assign(setups.size(), 1);
    scans.places.assign(setups.size(), Eigen::Vector3d::Zero());
    scans.T_map_scan.resize(setups.size());
  }
  /// A row of setups so far apart.
  static Job
  row(int count, double step)
  {
    std::vector<Eigen::Vector3d> setups;
    for (int i = 0; i < count; ++i)
      setups.emplace_back(step * i, 0, 0);
    return Job(setups);
  }

  double
  distance(int a, int b) const
  {
    return (truth[static_cast<std::size_t>(a)].translation() - truth[static_cast<std::size_t>(b)].translation()).norm();
  }
  double
  overlap(double apart) const
  {
    return std::max(0.0, 0.5 * (1 - apart / reach));
  }
  bool
  share(int a, int b) const
  {
    return overlap(distance(a, b)) >= 2 * options.adjustment.least_matched;
  }
  PairLink
  link(const ScanPair& pair) const
  {
    PairLink link;
    link.source = pair.first;
    link.target = pair.second;
    if (!share(pair.first, pair.second) || blind.count(pair) > 0)
      return link;
    link.status = Status::Converged;
    link.confidence = 0.99;
    link.probability_of_none = 0.01;
    PairHypothesis h;
    h.T_target_source =
        truth[static_cast<std::size_t>(pair.second)].inverse() * truth[static_cast<std::size_t>(pair.first)];
    h.probability = 0.99;
    h.overlap = overlap(distance(pair.first, pair.second));
    link.hypotheses.push_back(h);
    return link;
  }
  /// All rounds, each in order, no pair twice.
  std::vector<std::vector<ScanPair>>
  run(bool reversed = false) const
  {
    const OverlapFunction overlaps = [this](int a, int b, const Eigen::Isometry3d& T) {
      const Eigen::Vector3d at = T.translation(); // the source's sensor, in the target
      EXPECT_LT(a, b);
      return overlap(at.norm());
    };
    CandidatePairs candidates(scans, overlaps, options);
    std::vector<std::vector<ScanPair>> rounds;
    std::set<ScanPair> all;
    std::vector<PairLink> links;
    for (auto pairs = candidates.next(links); !pairs.empty(); pairs = candidates.next(links)) {
      EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
      for (const ScanPair& pair : pairs) {
        EXPECT_LT(pair.first, pair.second);
        EXPECT_TRUE(scans.usable[static_cast<std::size_t>(pair.first)]);
        EXPECT_TRUE(scans.usable[static_cast<std::size_t>(pair.second)]);
        EXPECT_TRUE(all.insert(pair).second) << pair.first << " " << pair.second;
        links.push_back(link(pair));
      }
      if (reversed)
        std::reverse(links.begin(), links.end());
      rounds.push_back(pairs);
      if (rounds.size() > 100) {
        ADD_FAILURE() << "it does not end";
        break;
      }
    }
    return rounds;
  }
  static std::set<ScanPair>
  together(const std::vector<std::vector<ScanPair>>& rounds)
  {
    std::set<ScanPair> all;
    for (const auto& round : rounds)
      all.insert(round.begin(), round.end());
    return all;
  }
  /// Scans are like those next to them, the more the nearer: but for the step after scan \p gap.
  void
  makeNextOnesAlike(int gap = -1)
  {
    const auto n = static_cast<Eigen::Index>(truth.size());
    const auto place = [&](Eigen::Index i) { return i + (gap >= 0 && i > gap ? 20 : 0); };
    for (Eigen::Index i = 0; i < n; ++i) {
      Eigen::VectorXf& signature = scans.signatures[static_cast<std::size_t>(i)];
      signature.resize(n + 20);
      for (Eigen::Index k = 0; k < n + 20; ++k)
        signature[k] = std::exp(-0.5F * static_cast<float>((place(i) - k) * (place(i) - k)));
    }
  }
};

TEST(CandidatePairs, theMostAlikeComeFirst)
{
  Job job = Job::row(6, 100); // nothing meets
  job.options.candidates.alike = 1;
  job.options.candidates.apart_rounds = 0;
  for (std::size_t i = 0; i < 3; ++i)
    job.scans.signatures[i + 3] = job.scans.signatures[i];
  EXPECT_THAT(job.run(), ElementsAre(ElementsAre(ScanPair(0, 3), ScanPair(1, 4), ScanPair(2, 5))));
}

TEST(CandidatePairs, neighboursOfNeighboursFollowWhereTheyWouldMeet)
{
  Job job = Job::row(5, 1.5); // up to two steps meet
  job.options.candidates.alike = 1;
  job.scans.wanted = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
  job.makeNextOnesAlike();
  EXPECT_THAT(job.run(),
              ElementsAre(ElementsAre(ScanPair(0, 1), ScanPair(1, 2), ScanPair(2, 3), ScanPair(3, 4)),
                          ElementsAre(ScanPair(0, 2), ScanPair(1, 3), ScanPair(2, 4))));
}

TEST(CandidatePairs, everyPairThatMeetsIsFoundInALongRow)
{
  Job job = Job::row(60, 1);
  job.options.candidates.alike = 2;
  job.makeNextOnesAlike();
  const std::set<ScanPair> all = Job::together(job.run());
  std::size_t meet = 0;
  for (int i = 0; i < 60; ++i)
    for (int k = i + 1; k < 60; ++k)
      if (job.share(i, k)) {
        ++meet;
        EXPECT_EQ(all.count({i, k}), 1U) << i << " " << k;
      }
  EXPECT_LE(all.size(), meet + 60U * job.options.candidates.alike);
  // The same for any number of threads and any order of the links.
  job.options.threads = 3;
  EXPECT_EQ(Job::together(job.run(true)), all);
}

TEST(CandidatePairs, partnersOfAScanAreBounded)
{
  Job job = Job::row(40, 0.01); // all meet
  job.makeNextOnesAlike();
  job.options.candidates.alike = 2;
  job.options.candidates.most = 5;
  const auto rounds = job.run();
  std::vector<std::size_t> partners(40, 0);
  for (std::size_t r = 1; r < rounds.size(); ++r)
    for (const auto& [a, b] : rounds[r]) {
      ++partners[static_cast<std::size_t>(a)];
      ++partners[static_cast<std::size_t>(b)];
    }
  EXPECT_LE(*std::max_element(partners.begin(), partners.end()), 5U);
  EXPECT_GE(std::count(partners.begin(), partners.end(), 5U), 30);
}

TEST(CandidatePairs, aWayAroundIsClosedWhereItsEndsAreNear)
{
  // A walk around a block: its ends meet, but no scan at the one end is like any at the other.
  std::vector<Eigen::Vector3d> setups;
  for (int i = 0; i < 25; ++i)
    setups.emplace_back(10 * std::cos(0.25 * i), 10 * std::sin(0.25 * i), 0);
  Job job(setups);
  job.options.candidates.alike = 1;
  job.reach = 4;
  job.makeNextOnesAlike();
  job.options.candidates.apart_rounds = 0;
  for (int i = 0; i < 24; ++i)
    job.scans.wanted.insert({i, i + 1});
  ASSERT_TRUE(job.share(0, 24));
  EXPECT_EQ(Job::together(job.run()).count({0, 24}), 1U);
  job.options.candidates.near = 0;
  EXPECT_EQ(Job::together(job.run()).count({0, 24}), 0U);
}

TEST(CandidatePairs, partsThatStayApartAreTriedOnceMore)
{
  // Two rows of their own, whose only scans that meet are like others first.
  Job job = Job::row(16, 2);
  job.options.candidates.alike = 1;
  job.makeNextOnesAlike(7);
  job.scans.signatures[7] += 0.1F * job.scans.signatures[8];
  const std::set<ScanPair> all = Job::together(job.run());
  ASSERT_TRUE(job.share(7, 8));
  EXPECT_EQ(all.count({7, 8}), 1U);
  job.options.candidates.apart_rounds = 0;
  EXPECT_EQ(Job::together(job.run()).count({7, 8}), 0U);
}

TEST(CandidatePairs, eachScanOfAPartIsTriedWithOthers)
{
  // Of two rows only the scans at the ends meet; all others are more like many of the other row.
  Job job = Job::row(80, 2);
  job.options.candidates.alike = 1;
  job.makeNextOnesAlike(39);
  const std::vector<Eigen::VectorXf> own = job.scans.signatures;
  job.scans.signatures[39] += 0.1F * own[40];
  for (std::size_t i = 0; i < 36; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      job.scans.signatures[i] += own[44 + (i + 12 * k) % 36];
  for (int i = 0; i < 79; ++i)
    if (i != 39)
      job.scans.wanted.insert({i, i + 1});
  ASSERT_TRUE(job.share(39, 40));
  EXPECT_EQ(Job::together(job.run()).count({39, 40}), 1U);
}

TEST(CandidatePairs, whatSharesNothingCostsABoundedNumber)
{
  for (const int n : {20, 80, 200}) {
    const Job job = Job::row(n, 100);
    const auto count = Job::together(job.run()).size();
    EXPECT_LE(count, static_cast<std::size_t>(n) * (job.options.candidates.alike + job.options.candidates.apart)) << n;
    EXPECT_GE(count, static_cast<std::size_t>(n) * job.options.candidates.alike / 2) << n;
  }
}

TEST(CandidatePairs, aMissingLinkIsWalkedAround)
{
  Job job = Job::row(10, 1);
  job.options.candidates.alike = 2;
  job.makeNextOnesAlike();
  job.blind = {{4, 5}};
  const std::set<ScanPair> all = Job::together(job.run());
  EXPECT_EQ(all.count({3, 5}), 1U);
  EXPECT_EQ(all.count({4, 6}), 1U);
}

TEST(CandidatePairs, withoutABoundAllPairsBetweenPartsAreTried)
{
  Job job = Job::row(10, 1);
  job.options.candidates.alike = 2;
  job.options.candidates.apart = std::numeric_limits<std::size_t>::max();
  job.makeNextOnesAlike();
  for (int i = 0; i < 5; ++i)
    for (int k = 5; k < 10; ++k)
      job.blind.insert({i, k});
  const std::set<ScanPair> all = Job::together(job.run());
  for (int i = 0; i < 5; ++i)
    for (int k = 5; k < 10; ++k)
      EXPECT_EQ(all.count({i, k}), 1U) << i << " " << k;
}

TEST(CandidatePairs, knownPosesAndAPersonsWishCount)
{
  Job job = Job::row(30, 100);
  job.options.candidates.alike = 1;
  job.options.candidates.near = 1;
  job.options.candidates.apart_rounds = 0;
  job.scans.wanted = {{2, 29}};
  for (const int i : {3, 17})
    job.scans.T_map_scan[static_cast<std::size_t>(i)] = Eigen::Isometry3d::Identity();
  const std::set<ScanPair> all = Job::together(job.run());
  EXPECT_EQ(all.count({2, 29}), 1U);
  EXPECT_EQ(all.count({3, 17}), 1U);
}

TEST(CandidatePairs, littleAndNothing)
{
  EXPECT_THAT(Job({}).run(), IsEmpty());
  EXPECT_THAT(Job::row(1, 1).run(), IsEmpty());
  EXPECT_THAT(Job::row(2, 1).run(), ElementsAre(ElementsAre(ScanPair(0, 1))));
  Job job = Job::row(12, 1);
  std::fill(job.scans.usable.begin() + 1, job.scans.usable.end(), 0);
  job.scans.wanted = {{0, 5}};
  EXPECT_THAT(job.run(), IsEmpty());
  job.scans.usable[5] = job.scans.usable[7] = 1;
  for (Eigen::VectorXf& signature : job.scans.signatures)
    signature.setZero();
  EXPECT_THAT(Job::together(job.run()), ElementsAre(ScanPair(0, 5), ScanPair(0, 7), ScanPair(5, 7)));
}

} // namespace
} // namespace pcl_ssfr::test_multiway_candidates
