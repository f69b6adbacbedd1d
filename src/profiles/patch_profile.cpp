// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/patch_profile.h"

#include "common/stage_clock.h"
#include "judgement/correspondence_distance.h"
#include "judgement/decision.h"
#include "judgement/posterior.h"
#include "profiles/hypothesis_source.h"
#include "profiles/patch_pair.h"
#include "profiles/pose_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

namespace pcl_ssfr {

namespace {

/// What is known of a pair before it is searched.
Result
describeScans(const PatchScan& source, const PatchScan& target)
{
  Result result;
  result.source_viewpoint_used = source.viewpoint_used;
  result.target_viewpoint_used = target.viewpoint_used;
  result.source_viewpoint_found = source.viewpoint_found;
  result.target_viewpoint_found = target.viewpoint_found;
  if (source.viewpoint_used)
    result.source_viewpoint = source.origin + source.viewpoint;
  if (target.viewpoint_used)
    result.target_viewpoint = target.origin + target.viewpoint;
  for (const PatchScan* scan : {&source, &target})
    for (StageReport stage : scan->stages) {
      stage.name = (scan == &source ? "source " : "target ") + stage.name;
      result.stages.push_back(stage);
    }
  return result;
}

Result
withStatus(Result result, Status status, const std::string& message)
{
  result.status = status;
  result.message = message;
  return result;
}

/// Step of float coordinates where most points of a scan are [m].
double
coordinateStep(const ScanExtent& extent)
{
  const auto farthest = static_cast<float>(extent.median.cwiseAbs().maxCoeff() + extent.radius);
  return std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest;
}

/// Why the scans cannot be searched; nothing: they can.
std::optional<std::pair<Status, std::string>>
findProblem(const PatchPair& pair, const HypothesisSource& source)
{
  for (const PatchScan* scan : {&pair.source(), &pair.target()}) {
    const std::string name = scan == &pair.source() ? "the source scan" : "the target scan";
    const int least = pair.config().preparation.min_points;
    if (scan->extent.returns < static_cast<std::size_t>(least))
      return std::make_pair(Status::TooFewPoints,
                            name + " has " + std::to_string(scan->extent.returns) +
                                " finite points away from the sensor, at least " + std::to_string(least) +
                                " are needed");
    // What is left of the shape is the lattice of the steps, and lattices match.
    if (const double step = coordinateStep(scan->extent); step > pair.config().preparation.match) {
      std::ostringstream text;
      text << name << " lies " << std::llround(scan->extent.median.cwiseAbs().maxCoeff())
           << " m from the origin of its frame, where float coordinates have steps of " << step
           << " m: take an offset off before they become floats";
      return std::make_pair(Status::InvalidInput, text.str());
    }
    const auto& normals = scan == &pair.source() ? source.sourceNormals() : source.targetNormals();
    if (normals.empty() && !pair.priors().guess())
      return std::make_pair(Status::TooFewDirections, name + " has no planes: its rotation cannot be observed");
  }
  return std::nullopt;
}

std::string
nothingFound(const PatchPair& pair, const HypothesisSource& source)
{
  if (source.rotations().empty())
    return "no rotation lays the main normals of the scans on each other";
  return std::string("no ") +
         (pair.priors().guess()    ? "pose within the tolerance of the guess"
          : pair.options().gravity ? "pose that keeps the given vertical"
                                   : "translation") +
         " lays surfaces of the scans on each other";
}

/// Whether the truth is so probably among the poses that no other is looked for.
bool
isDecided(const PatchPair& pair, const std::vector<ScoredPose>& poses)
{
  return !poses.empty() && computePosterior(poses, pair.posteriorModel()).none <= 1 - pair.config().judgement.decided;
}

/// Whether the matches of the most probable pose, polished, determine all of it: else it may be next to a better one
/// that was not proposed yet.
bool
isDetermined(const PatchPair& pair, const ScoredPose& best)
{
  return unobservableDirections(uncertaintyOf(pair, best), pair.config().judgement.uncertainty).empty();
}

/// The result of a search that ended with some poses, most probable first.
Result
conclude(Result result, const PatchPair& pair, const HypothesisSource& source, const std::vector<ScoredPose>& poses)
{
  const ScoredPose& best = poses.front();
  DecisionContext context;
  context.posterior = computePosterior(poses, pair.posteriorModel());
  context.uncertainty = uncertaintyOf(pair, best);
  context.config = pair.config().judgement;
  context.min_confidence = pair.options().min_confidence;
  context.source_viewpoint = pair.source().viewpoint;
  context.distinct_distance = pair.config().refinement.distinct_distance;
  context.distinct_angle = pair.config().refinement.distinct_angle;
  context.few_directions = source.fewDirections();
  context.is_cut_short = pair.outOfTime();
  Decision decision = decide(poses, context);

  result.probability_of_none = 1;
  const auto listed = std::min(poses.size(), static_cast<std::size_t>(pair.options().max_candidates));
  for (std::size_t i = 0; i < listed; ++i) {
    Candidate candidate = describe(poses[i]);
    candidate.T_target_source = pair.toOuter(poses[i].T_target_source);
    candidate.probability = context.posterior.poses[i];
    result.probability_of_none -= candidate.probability;
    result.candidates.push_back(candidate);
  }
  result.probability_of_none = std::max(0.0, result.probability_of_none);
  result.T_target_source = result.candidates.front().T_target_source;
  result.overlap = result.candidates.front().overlap;
  result.contradiction = result.candidates.front().contradiction;
  result.rmse = best.polish ? best.polish->rms : 0;
  result.information = context.uncertainty.informationAbout(-pair.target().origin);
  if (best.polish)
    result.correspondence_distance =
        correspondenceDistance(*best.polish,
                               context.uncertainty,
                               std::max(spacingOf(pair.source().patches), spacingOf(pair.target().patches)),
                               pair.polishReach(),
                               pair.config().judgement.uncertainty);
  result.confidence = decision.confidence;
  result.unobservable = std::move(decision.unobservable);
  return withStatus(std::move(result), decision.status, decision.message);
}

/// The whole search, from the first rotations to the decision. \param[in] guess T_target_source of the inner frames
Result
searchPose(const PatchPair& pair, const std::optional<Eigen::Isometry3d>& guess, SearchTrace* trace)
{
  Result result = describeScans(pair.source(), pair.target());
  StageLog stages(result.stages);
  HypothesisSource hypotheses(pair, guess, stages, trace);
  if (const auto problem = findProblem(pair, hypotheses))
    return withStatus(std::move(result), problem->first, problem->second);

  std::vector<ScoredPose> poses; // distinct, most probable first
  while (const std::optional<HypothesisBatch> batch = hypotheses.next()) {
    poses = refineAndMerge(pair, *batch, poses, stages);
    if (!isDecided(pair, poses) && !pair.outOfTime())
      continue;
    // Polished, a pose may turn out not to be as good as it seemed, or to be open: a reason to look further.
    if (!poses.empty())
      poses = polishLeaders(pair, std::move(poses), stages);
    if ((isDecided(pair, poses) && isDetermined(pair, poses.front())) || pair.outOfTime())
      break;
  }
  if (poses.empty())
    return pair.outOfTime() ? withStatus(std::move(result),
                                         Status::TimeLimit,
                                         "the time limit ran out before a pose could be judged")
                            : withStatus(std::move(result), Status::NoCandidate, nothingFound(pair, hypotheses));
  if (!poses.front().polish)
    poses = polishLeaders(pair, std::move(poses), stages);
  return conclude(std::move(result), pair, hypotheses, poses);
}

/// What says that coordinates may not be in metres, for people, after a message; empty: nothing.
std::string
unitText(const PatchScan& source, const PatchScan& target, bool is_accepted)
{
  const bool is_source = source.extent.radius > target.extent.radius;
  const PatchScan& larger = is_source ? source : target;
  const double radius = larger.extent.radius, other = (is_source ? target : source).extent.radius;
  const std::string reaches = std::string("; the ") + (is_source ? "source" : "target") + " scan reaches ";
  if (larger.scale > kUnlikelyScale)
    return reaches + std::to_string(std::lround(radius)) + " m: are its coordinates in metres?";
  if (!is_accepted && other > 0 && radius > kUnlikelyScale * other)
    return reaches + std::to_string(std::lround(radius / other)) +
           " times as far as the other one: are both in metres?";
  return "";
}

} // namespace

Candidate
scorePatchPose(const PatchScan& source,
               const PatchScan& target,
               const Options& options,
               const Eigen::Isometry3d& T_target_source)
{
  Candidate candidate;
  if (source.patches.size() > 0 && target.patches.size() > 0) {
    const PatchPair pair(source, target, options, nullptr, Deadline());
    ScoredPose pose;
    pose.T_target_source = pair.toInner(T_target_source);
    pair.scoreFine(pose);
    pose.polish = pair.fitAt(pose.T_target_source);
    candidate = describe(pose);
  }
  candidate.T_target_source = T_target_source;
  return candidate;
}

Result
registerPatchScans(const PatchScan& source,
                   const PatchScan& target,
                   const Options& options,
                   const Eigen::Isometry3d* guess,
                   const Deadline& deadline,
                   SearchTrace* trace)
{
  const PatchPair pair(source, target, options, guess, deadline);
  Result result =
      searchPose(pair, guess ? std::optional<Eigen::Isometry3d>(pair.toInner(*guess)) : std::nullopt, trace);
  result.message += unitText(source, target, result.accepted());
  return result;
}

} // namespace pcl_ssfr
