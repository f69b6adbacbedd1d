// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Where a search lost the true pose: each stage by hand, and searches of real scans against a truth that is made up.

#include <apps/benchmark/lost_stage.h>
#include <apps/io/dataset_folder.h>

#include <gtest/gtest.h>

namespace pcl_ssfr::apps::test_lost_stage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

Candidate
candidate(const Isometry3d& T)
{
  Candidate result;
  result.T_target_source = T;
  return result;
}

TracedHypothesis
hypothesis(const Isometry3d& T, bool refined)
{
  TracedHypothesis result;
  result.T_target_source = T;
  result.refined = refined;
  return result;
}

/// A search that answers a pose 20 m off.
class LostSearchTest : public ::testing::Test {
protected:
  LostSearchTest()
  {
    search_.truth = Translation3d(1, 2, 3) * AngleAxisd(0.4, Vector3d::UnitZ());
    wrong_ = Translation3d(20, 0, 0) * search_.truth;
    search_.result.T_target_source = wrong_;
    search_.result.candidates = {candidate(wrong_)};
    search_.trace.passes.resize(1);
  }
  /// A pose that is off the truth by so much.
  Isometry3d
  off(double degrees, double metres) const
  {
    return Translation3d(0, metres, 0) * search_.truth * AngleAxisd(degrees * kDegree, Vector3d::UnitX());
  }
  /// A search that was given the truth as a guess answers right.
  void
  truthIsMostProbable()
  {
    search_.from_truth.candidates = {candidate(off(0.1, 0.02)), candidate(wrong_)};
    search_.from_truth.T_target_source = off(0.1, 0.02);
  }
  TracedPass&
  pass()
  {
    return search_.trace.passes.back();
  }

  LostSearch search_;
  Isometry3d wrong_;
};

TEST_F(LostSearchTest, aRightAnswerIsNotLost)
{
  search_.result.candidates = {candidate(off(1, 0.1))};
  search_.result.T_target_source = off(1, 0.1);
  EXPECT_EQ(lostStage(search_), "");
}

TEST_F(LostSearchTest, nothingSearchedIsThePreparation)
{
  search_.result.candidates.clear();
  search_.trace.passes.clear();
  EXPECT_EQ(lostStage(search_), "preparation");
  // The identity that a result holds then is no answer, even where it is right.
  search_.result.T_target_source = search_.truth;
  EXPECT_EQ(lostStage(search_), "preparation");
}

TEST_F(LostSearchTest, aTruthThatIsLessProbableIsTheEvidence)
{
  EXPECT_EQ(lostStage(search_), "evidence"); // from the truth, nothing is found
  // An identity that stands for no pose is no answer, even where it is right.
  search_.from_truth.T_target_source = search_.truth;
  EXPECT_EQ(lostStage(search_), "evidence");
  search_.from_truth.candidates = {candidate(wrong_), candidate(off(0.1, 0.02))};
  search_.from_truth.T_target_source = wrong_;
  EXPECT_EQ(lostStage(search_), "evidence");
  pass().rotations.emplace_back(search_.truth.linear());
  pass().hypotheses.push_back(hypothesis(search_.truth, true));
  EXPECT_EQ(lostStage(search_), "evidence"); // proposed or not
}

TEST_F(LostSearchTest, aRightPoseThatWasFoundAndIsLessProbableIsTheEvidence)
{
  truthIsMostProbable(); // with the prior of a guess
  search_.result.candidates.push_back(candidate(off(0.1, 0.02)));
  EXPECT_EQ(lostStage(search_), "evidence");
}

TEST_F(LostSearchTest, stagesOfTheSearch)
{
  truthIsMostProbable();
  EXPECT_EQ(lostStage(search_), "rotation");
  pass().rotations.emplace_back(off(5.1, 0).linear());
  EXPECT_EQ(lostStage(search_), "rotation");
  pass().rotations.emplace_back(off(4.9, 0).linear());
  EXPECT_EQ(lostStage(search_), "translation");
  pass().hypotheses = {hypothesis(off(4.9, 1.1), true), hypothesis(off(5.1, 0.1), true)};
  EXPECT_EQ(lostStage(search_), "translation");
  pass().hypotheses.push_back(hypothesis(off(4.9, 0.9), false));
  EXPECT_EQ(lostStage(search_), "not refined");
  pass().hypotheses.push_back(hypothesis(off(2, 0.5), true));
  EXPECT_EQ(lostStage(search_), "refinement");
}

TEST_F(LostSearchTest, planViewsProposeAsWell)
{
  truthIsMostProbable();
  search_.trace.plan_hypotheses = {hypothesis(off(3, 4), true)};
  EXPECT_EQ(lostStage(search_), "translation");
  search_.trace.plan_hypotheses = {hypothesis(off(3, 0.4), true)};
  EXPECT_EQ(lostStage(search_), "refinement");
}

TEST_F(LostSearchTest, errorsAreTakenAtTheReference)
{
  truthIsMostProbable();
  search_.reference = Vector3d(100, 0, 0);
  // A degree at 100 m is 1.7 m.
  pass().rotations.emplace_back(search_.truth.linear());
  pass().hypotheses = {hypothesis(search_.truth * AngleAxisd(kDegree, Vector3d::UnitZ()), true)};
  EXPECT_EQ(lostStage(search_), "translation");
}

/// A pair of data/ as the benchmark loads it.
PairRequest
listedPair()
{
  const io::DatasetFolder dataset = io::readDatasetFolder(PCL_SSFR_DATA_DIR);
  PairRequest request;
  request.source = io::scanPath(dataset.path, dataset.pairs.front().source);
  request.target = io::scanPath(dataset.path, dataset.pairs.front().target);
  request.T_target_source = dataset.pairs.front().T_target_source;
  request.variation.perturbation = Perturbation::Rotation;
  return request;
}

TEST(FindLostStage, ofRealSearches)
{
  const SuccessBound bound{2, 0.3};
  PairInput pair = loadPair(listedPair());
  EXPECT_EQ(findLostStage(pair, Options(), bound), "");
  // Where the truth is another place, the evidence is against it.
  const Isometry3d truth = *pair.T_target_source;
  pair.T_target_source = Translation3d(40, 30, 20) * truth;
  EXPECT_EQ(findLostStage(pair, Options(), bound), "evidence");
  pair.T_target_source.reset();
  EXPECT_EQ(findLostStage(pair, Options(), bound), "");
  pair.T_target_source = truth;
  pair.source.points->clear();
  EXPECT_EQ(findLostStage(pair, Options(), bound), "preparation");
}

TEST(FindLostStage, doesNotDependOnLargeCoordinates)
{
  PairInput pair = loadPair(listedPair());
  pair.source.offset += Vector3d(1e6, -2e6, 500);
  pair.reference += Vector3d(1e6, -2e6, 500);
  *pair.T_target_source = *pair.T_target_source * Translation3d(-1e6, 2e6, -500);
  EXPECT_EQ(findLostStage(pair, Options(), {2, 0.3}), "");
}

} // namespace
} // namespace pcl_ssfr::apps::test_lost_stage
