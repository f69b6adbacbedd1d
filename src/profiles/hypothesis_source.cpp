// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/hypothesis_source.h"

#include "common/parallel.h"
#include "common/stage_names.h"
#include "directions/scene_directions.h"
#include "search/plan_search.h"

#include <algorithm>
#include <cstdint>
#include <functional>

namespace pcl_ssfr {

namespace {

std::string
fewDirectionsText(const std::vector<MainNormal>& source, const std::vector<MainNormal>& target)
{
  const char* few = !hasPair(source, RotationOptions{})   ? "the source scan"
                    : !hasPair(target, RotationOptions{}) ? "the target scan"
                                                          : nullptr;
  return few ? std::string(few) + " has planes in fewer than two directions" : "";
}

/// What a pose must score to be one of the best \p count of those found; 0: any is.
double
scoreOfLast(std::size_t count, const std::vector<std::vector<PoseHypothesis>>& found)
{
  std::vector<double> scores;
  for (const std::vector<PoseHypothesis>& some : found)
    for (const PoseHypothesis& pose : some)
      scores.push_back(pose.score);
  if (scores.size() < count)
    return 0;
  const auto last = scores.begin() + static_cast<std::ptrdiff_t>(count) - 1;
  std::nth_element(scores.begin(), last, scores.end(), std::greater<>());
  return *last;
}

} // namespace

HypothesisSource::HypothesisSource(const PatchPair& pair,
                                   const std::optional<Eigen::Isometry3d>& guess,
                                   StageLog& stages,
                                   SearchTrace* trace)
    : pair_(pair), guess_(guess), stages_(stages), trace_(trace), source_normals_(pair.source().main_normals),
      target_normals_(pair.target().main_normals)
{
  if (const auto& gravity = pair.options().gravity) {
    source_normals_ = withVertical(source_normals_, gravity->up_source, pair.config().search);
    target_normals_ = withVertical(target_normals_, gravity->up_target, pair.config().search);
  }
  few_directions_ = fewDirectionsText(source_normals_, target_normals_);
}

std::optional<HypothesisBatch>
HypothesisSource::next()
{
  const SearchConfig& config = pair_.config().search;
  switch (stage_) {
  case Stage::MostVotes:
    stage_ = Stage::OtherVotes;
    return searchMostVotes();
  case Stage::OtherVotes:
    stage_ = Stage::LittleOverlap;
    if (taken_ < hypotheses_.size())
      return takeBatch(hypotheses_.size(), config.much_overlap);
    [[fallthrough]];
  case Stage::LittleOverlap:
    stage_ = Stage::Plans;
    if (!rotations_.empty()) {
      hypotheses_ = searchTranslations(config.little_overlap);
      return takeBatch(hypotheses_.size(), config.little_overlap);
    }
    [[fallthrough]];
  case Stage::Plans:
    stage_ = Stage::Done;
    if (!source_normals_.empty() && !target_normals_.empty() &&
        supportAcross(rotations_, source_normals_, target_normals_, config.direction_error) < config.plans_below)
      return searchPlans();
    [[fallthrough]];
  case Stage::Done:
    break;
  }
  return std::nullopt;
}

/// The rotations, and the poses under them that have about as many votes as the first, with the guess.
HypothesisBatch
HypothesisSource::searchMostVotes()
{
  const SearchPass& pass = pair_.config().search.much_overlap;
  rotations_ = proposeRotations();
  hypotheses_ = searchTranslations(pass);
  const double least = hypotheses_.empty() ? 0 : pair_.config().search.promising * hypotheses_.front().score;
  const auto promising = std::find_if(
      hypotheses_.begin(), hypotheses_.end(), [&](const PoseHypothesis& h) { return least > 0 && h.score < least; });
  HypothesisBatch batch = takeBatch(static_cast<std::size_t>(promising - hypotheses_.begin()), pass);
  if (guess_)
    batch.poses.push_back(*guess_);
  batch.has_guess = guess_.has_value();
  return batch;
}

/// The hypotheses of the current pass up to \p end that were not taken yet.
HypothesisBatch
HypothesisSource::takeBatch(std::size_t end, const SearchPass& pass)
{
  HypothesisBatch batch;
  batch.distinct = static_cast<std::size_t>(pass.distinct);
  for (; taken_ < end; ++taken_) {
    batch.poses.push_back(hypotheses_[taken_].T_target_source);
    if (trace_)
      trace_->passes.back().hypotheses[taken_].refined = true;
  }
  return batch;
}

/// Poses under which the scans agree in the vertical where it is given, else in one of the main normals of each.
HypothesisBatch
HypothesisSource::searchPlans() const
{
  const SearchConfig& config = pair_.config().search;
  const PosePriors& priors = pair_.priors();
  PlanSearchOptions options;
  options.elements = pair_.config().preparation.coarse_patches;
  options.cell = 2 * pair_.config().refinement.coarse_reach;
  options.matches = config.much_overlap.refined;
  options.rotations = config.sweep_steps;
  options.reach = std::max(pair_.source().extent.radius, pair_.target().extent.radius);
  options.voting = searchOptions(config.little_overlap);
  options.threads = pair_.threads();
  const auto& gravity = pair_.options().gravity;
  if (gravity || priors.guess())
    options.is_allowed = [&](const Eigen::Isometry3d& T) { return priors.allow(T, Exactness::Proposed); };
  const std::vector<AxisPair> axes = gravity ? std::vector<AxisPair>{{gravity->up_source, gravity->up_target}}
                                             : pairAxes(source_normals_, target_normals_, config);
  std::vector<PoseHypothesis> found;
  for (const AxisPair& pair : axes) {
    const std::vector<PoseHypothesis> some =
        pcl_ssfr::searchPlans({pair_.source().patches.samples, pair_.source().clutter},
                              pair_.source().votes,
                              {pair_.target().patches.samples, pair_.target().clutter},
                              pair_.target().index,
                              pair_.target().freeSpace(),
                              pair,
                              options);
    found.insert(found.end(), some.begin(), some.end());
  }
  std::stable_sort(
      found.begin(), found.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  stages_.report("plan views", axes.size(), found.size());
  HypothesisBatch batch;
  batch.distinct = static_cast<std::size_t>(config.little_overlap.distinct);
  for (const PoseHypothesis& h : found) {
    const bool is_refined = batch.poses.size() < static_cast<std::size_t>(config.much_overlap.refined);
    if (is_refined)
      batch.poses.push_back(h.T_target_source);
    if (trace_)
      trace_->plan_hypotheses.push_back({pair_.toOuter(h.T_target_source), h.score, is_refined});
  }
  return batch;
}

/// METHOD stages 6 to 8, merged and ranked (METHOD, "Rotations"); where main normals do not determine the rotation
/// about an axis, also rotations all around it.
std::vector<RotationCandidate>
HypothesisSource::proposeRotations() const
{
  const SearchConfig& config = pair_.config().search;
  const PosePriors& priors = pair_.priors();
  RotationOptions options;
  options.angle_tolerance = config.direction_error;
  options.merge_angle = config.direction_error;
  options.refit_angle = config.direction_error;
  std::vector<RotationCandidate> rotations =
      pcl_ssfr::proposeRotations(source_normals_, target_normals_, options, static_cast<unsigned>(pair_.threads()));
  const auto is_excluded = [&](const RotationCandidate& r) {
    return !priors.allow(r.R_target_source, Exactness::Proposed);
  };
  rotations.erase(std::remove_if(rotations.begin(), rotations.end(), is_excluded), rotations.end());
  const std::size_t all = rotations.size();
  rotations.resize(std::min(all, static_cast<std::size_t>(config.rotations)));
  const bool few = !few_directions_.empty();
  for (const RotationCandidate& r :
       sweepRotations(sweepAxes(source_normals_, pair_.source().patches.samples, few, config),
                      sweepAxes(target_normals_, pair_.target().patches.samples, few, config),
                      config.sweep_steps))
    if (!is_excluded(r))
      rotations.push_back(r);
  if (priors.guess()) {
    rotations.emplace_back();
    rotations.back().R_target_source = priors.guess()->linear();
  }
  stages_.report("rotations", all, rotations.size());
  return rotations;
}

PoseSearchOptions
HypothesisSource::searchOptions(const SearchPass& pass) const
{
  const PatchProfileConfig& config = pair_.config();
  PoseSearchOptions options;
  options.config = config.search;
  options.pass = pass;
  options.bin_width = boundBinWidth(pair_.options().bin_width > 0 ? pair_.options().bin_width : pair_.binWidth(),
                                    pair_.source().patches.samples,
                                    pair_.target().patches.samples,
                                    HistogramOptions{}.max_bins);
  options.step = config.refinement.coarse_reach / 2;
  options.peak_separation = config.refinement.distinct_distance;
  options.visibility = pair_.searchTolerances();
  options.deadline = pair_.deadline();
  return options;
}

/// METHOD stages 9 to 12 for every rotation; the best poses by their votes.
std::vector<PoseHypothesis>
HypothesisSource::searchTranslations(const SearchPass& pass)
{
  taken_ = 0;
  std::vector<PoseHypothesis> found = searchTranslationsOfAll(searchOptions(pass));
  std::stable_sort(
      found.begin(), found.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
  stages_.report(kTranslationsStage, rotations_.size(), found.size());
  if (trace_) {
    TracedPass traced;
    traced.little_overlap = pass.little_overlap;
    for (const RotationCandidate& r : rotations_)
      traced.rotations.push_back(r.R_target_source);
    for (const PoseHypothesis& h : found)
      traced.hypotheses.push_back({pair_.toOuter(h.T_target_source), h.score, false});
    trace_->passes.push_back(std::move(traced));
  }
  found.resize(std::min(found.size(), static_cast<std::size_t>(pass.refined)));
  return found;
}

/// The same, each rotation by a thread of its own; in their order. They are searched in groups, the best supported ones
/// first: what these find shows for which translations of the others it is worth to count all votes.
std::vector<PoseHypothesis>
HypothesisSource::searchTranslationsOfAll(PoseSearchOptions options) const
{
  constexpr std::size_t kFirst = 2, kGrowth = 3; // rotations of the first group; 2 in 6, 6 in 18, and so on
  std::vector<std::vector<PoseHypothesis>> found(rotations_.size());
  for (std::size_t first = 0, end = kFirst; first < rotations_.size(); first = end, end *= kGrowth) {
    end = std::min(end, rotations_.size());
    forEachInParallel(static_cast<std::int64_t>(end - first), 1, pair_.threads(), [&](std::int64_t k) {
      if (pair_.outOfTime())
        return;
      const std::size_t i = first + static_cast<std::size_t>(k);
      const Eigen::Matrix3d& R = rotations_[i].R_target_source;
      PoseSearchOptions own = options;
      own.window = pair_.priors().translationWindow(R, options.peak_separation);
      found[i] = pcl_ssfr::searchTranslations(pair_.source().patches.samples,
                                              pair_.source().votes,
                                              pair_.target().patches.samples,
                                              target_normals_,
                                              pair_.target().index,
                                              pair_.target().freeSpace(),
                                              R,
                                              own);
    });
    for (std::size_t i = first; i < end; ++i)
      for (const PoseHypothesis& pose : found[i])
        options.rival_votes = std::max(options.rival_votes, pose.votes);
    if (options.pass.little_overlap)
      options.least_score = scoreOfLast(static_cast<std::size_t>(options.pass.refined), found);
  }
  std::vector<PoseHypothesis> poses;
  for (const std::vector<PoseHypothesis>& some : found)
    poses.insert(poses.end(), some.begin(), some.end());
  return poses;
}

} // namespace pcl_ssfr
