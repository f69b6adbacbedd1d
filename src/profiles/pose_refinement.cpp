// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/pose_refinement.h"

#include "common/logit.h"
#include "common/parallel.h"
#include "judgement/posterior.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Apply \p refine to every pose, in parallel, one slot each.
template <typename Refine>
void
forEachPose(const PatchPair& pair, std::vector<ScoredPose>& poses, const Refine& refine)
{
  forEachInParallel(static_cast<std::int64_t>(poses.size()), 1, pair.threads(), [&](std::int64_t i) {
    refine(poses[static_cast<std::size_t>(i)]);
  });
}

/// Log odds that a rival has against the best pose, at least: one that is less probable than what a decision leaves
/// open changes none.
double
leastLogOdds(const PatchPair& pair)
{
  return std::log(1 - pair.config().judgement.decided);
}

/// Whether a pose is too improbable against the best to be worth more work. What is not yet refined may still gain as
/// much as a rival lacks, so its odds may be the square of a rival's.
bool
isHopeless(const PatchPair& pair, const ScoredPose& pose, const ScoredPose& best)
{
  return logOdds(pose, best, pair.posteriorModel()) < 2 * leastLogOdds(pair);
}

std::vector<ScoredPose>
refineCoarse(const PatchPair& pair, const HypothesisBatch& batch)
{
  std::vector<ScoredPose> poses(batch.poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i].T_target_source = batch.poses[i];
  if (batch.has_guess)
    poses.back().from_guess = true;
  forEachPose(pair, poses, [&](ScoredPose& pose) {
    if (pair.outOfTime())
      return; // without evidence it is dropped below
    pose.T_target_source = pair.refinedCoarse(pose.T_target_source);
    pair.scoreCoarse(pose);
  });
  poses.erase(
      std::remove_if(poses.begin(), poses.end(), [](const ScoredPose& pose) { return !(pose.evidence.matched > 0); }),
      poses.end());
  pair.priors().dropExcluded(poses, Exactness::Proposed); // what comes in is not yet exact
  std::vector<ScoredPose> distinct = keepDistinct(pair, poses, batch.distinct);
  // Whether the guess is right is for the finer stages to say.
  const auto is_guess = [](const ScoredPose& pose) { return pose.from_guess; };
  const auto guess = std::find_if(poses.begin(), poses.end(), is_guess);
  if (guess != poses.end() && std::none_of(distinct.begin(), distinct.end(), is_guess))
    distinct.push_back(*guess);
  return distinct;
}

std::vector<ScoredPose>
refineFine(const PatchPair& pair, std::vector<ScoredPose> poses)
{
  const std::size_t count = poses.size();
  if (count == 0)
    return poses;
  const ScoredPose best = poses.front();
  forEachPose(pair, poses, [&](ScoredPose& pose) {
    const bool is_hopeless = !pose.from_guess && isHopeless(pair, pose, best);
    pair.scoreFine(pose);
    if (pair.options().refine && !pair.outOfTime() && !is_hopeless)
      pair.moveUnlessWorse(pose, pair.refinedFine(pose.T_target_source));
  });
  pair.priors().dropExcluded(poses, Exactness::Refined);
  return keepDistinct(pair, std::move(poses), count);
}

/// The polished best pose, moved to and fro along the motions that are known least.
std::vector<ScoredPose>
neighboursOf(const PatchPair& pair, const ScoredPose& best)
{
  const RefinementConfig& config = pair.config().refinement;
  const PoseUncertainty uncertainty = uncertaintyOf(pair, best);
  const std::vector<PrincipalMotion> motions = motionsToExplore(uncertainty, config.explored_deviation);
  std::vector<ScoredPose> neighbours;
  for (const PrincipalMotion& motion : motions)
    for (const double distance : {config.distinct_distance / 2, config.distinct_distance})
      for (const int sign : {-1, 1}) {
        ScoredPose neighbour = best;
        neighbour.polish.reset();
        neighbour.T_target_source = Eigen::Translation3d(uncertainty.centre) * expSe3(sign * distance * motion.motion) *
                                    Eigen::Translation3d(-uncertainty.centre) * best.T_target_source;
        neighbours.push_back(neighbour);
      }
  return neighbours;
}

/** \brief Other local optima near the best pose: where a motion is poorly constrained, as level rings hardly
 * constrain a tilt, a refinement ends in the nearest of several places that explain the scans almost equally well. So
 * it is started from the neighbourhood of the best pose along such motions. \return refined and scored, most probable
 * first
 */
std::vector<ScoredPose>
nearbyOptima(const PatchPair& pair, const ScoredPose& best)
{
  if (!(best.score > 0))
    return {};
  std::vector<ScoredPose> neighbours = neighboursOf(pair, best);
  forEachPose(pair, neighbours, [&](ScoredPose& pose) {
    if (pair.outOfTime())
      return;
    pair.scoreFine(pose);
    if (isHopeless(pair, pose, best))
      return;
    pose.T_target_source = pair.refinedFine(pose.T_target_source);
    pair.scoreFine(pose);
  });
  if (pair.outOfTime())
    return {};
  pair.priors().dropExcluded(neighbours, Exactness::Refined);
  const std::size_t count = neighbours.size();
  return keepDistinct(pair, std::move(neighbours), count);
}

/// Whether even the first of the poses, the most probable one, is so improbable that none will be accepted, however
/// exact. Then it is enough to say how well it is known.
bool
areHopeless(const PatchPair& pair, const std::vector<ScoredPose>& poses)
{
  return logit(computePosterior(poses, pair.posteriorModel()).best()) < 2 * leastLogOdds(pair);
}

/// Polish the most probable pose and its rivals. Polished, a pose may lose its lead, and with it others become rivals:
/// until none is left. \return how many were polished; the poses are ordered, most probable first
std::size_t
polishRivals(const PatchPair& pair, std::vector<ScoredPose>& poses)
{
  const PosteriorModel model = pair.posteriorModel();
  std::size_t polished = 0;
  for (;; ++polished) {
    sortByProbability(poses, model);
    const ScoredPose& best = poses.front();
    const bool are_hopeless = areHopeless(pair, poses);
    const auto next = std::find_if(poses.begin(), poses.end(), [&](const ScoredPose& pose) {
      return !pose.polish && (&pose == &best || (!are_hopeless && logOdds(pose, best, model) >= leastLogOdds(pair)));
    });
    if (next == poses.end() || (pair.outOfTime() && best.polish))
      return polished;
    if (are_hopeless)
      next->polish = pair.fitAt(next->T_target_source);
    else
      pair.polish(*next);
  }
}

/// The poses that are none of those before them.
std::vector<ScoredPose>
firstDistinct(const PatchPair& pair, std::vector<ScoredPose> poses)
{
  std::vector<ScoredPose> distinct;
  for (ScoredPose& pose : poses) {
    const bool is_known = std::any_of(distinct.begin(), distinct.end(), [&](const ScoredPose& other) {
      return pair.isSamePlace(pose.T_target_source, other.T_target_source);
    });
    if (!is_known)
      distinct.push_back(std::move(pose));
  }
  return distinct;
}

} // namespace

std::vector<ScoredPose>
keepDistinct(const PatchPair& pair, std::vector<ScoredPose> poses, std::size_t most)
{
  sortByScore(poses);
  poses = firstDistinct(pair, std::move(poses));
  sortByProbability(poses, pair.posteriorModel());
  if (poses.size() > most)
    poses.erase(poses.begin() + static_cast<std::ptrdiff_t>(most), poses.end());
  return poses;
}

std::vector<ScoredPose>
refineAndMerge(const PatchPair& pair,
               const HypothesisBatch& batch,
               const std::vector<ScoredPose>& known,
               StageLog& stages)
{
  std::vector<ScoredPose> coarse = refineCoarse(pair, batch);
  const std::size_t coarse_count = coarse.size();
  stages.report("coarse refinement", batch.poses.size(), coarse_count);
  std::vector<ScoredPose> poses = refineFine(pair, std::move(coarse));
  stages.report("fine refinement", coarse_count, poses.size());
  // A polished pose stands for what leads to it again, even where that scores a little more.
  const auto is_polished = [&](const ScoredPose& pose) {
    return std::any_of(known.begin(), known.end(), [&](const ScoredPose& other) {
      return other.polish && pair.isSamePlace(pose.T_target_source, other.T_target_source);
    });
  };
  poses.erase(std::remove_if(poses.begin(), poses.end(), is_polished), poses.end());
  poses.insert(poses.end(), known.begin(), known.end());
  return keepDistinct(pair, std::move(poses), std::max(batch.distinct, known.size()));
}

std::vector<ScoredPose>
polishLeaders(const PatchPair& pair, std::vector<ScoredPose> poses, StageLog& stages)
{
  std::size_t polished = polishRivals(pair, poses);
  if (polished > 0 && !pair.outOfTime() && pair.options().refine && !areHopeless(pair, poses))
    for (ScoredPose& pose : nearbyOptima(pair, poses.front()))
      poses.push_back(std::move(pose));
  // Polished, two may be the same pose; and without one of them another pose may be the more probable one.
  for (std::size_t count = 0; count != poses.size();) {
    polished += polishRivals(pair, poses);
    count = poses.size();
    poses = firstDistinct(pair, std::move(poses));
  }
  const Eigen::Index points = pair.source().surface.points.cols() + pair.target().surface.points.cols();
  stages.report(
      "polish", polished * static_cast<std::size_t>(points), static_cast<std::uint64_t>(poses.front().polish->matches));
  return poses;
}

PoseUncertainty
uncertaintyOf(const PatchPair& pair, const ScoredPose& pose)
{
  return pose.polish ? poseUncertainty(*pose.polish,
                                       noiseFloor(pair.config().judgement.uncertainty, pose.polish->rms),
                                       pair.priors().rotationInformation(),
                                       pair.laysSensorOnSensor(pose.T_target_source))
                     : PoseUncertainty();
}

} // namespace pcl_ssfr
