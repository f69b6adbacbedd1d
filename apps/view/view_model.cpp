// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/view/view_model.h>

#include "common/angles.h"
#include "common/stage_names.h"
#include "directions/scene_directions.h"
#include "profiles/hypothesis_source.h"
#include "profiles/patch_pair.h"

#include <apps/common/format_text.h>
#include <apps/methods/cloud_view.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kMostTilted = 40;   ///< of a scanner [deg]
constexpr double kRotationFound = 5; ///< a candidate rotation this near to the truth is taken as the right one [deg]
constexpr double kShiftFound = 0.5;  ///< a shift this near to the truth is refined to it [m], at scale 1
constexpr double kScoreReach = 0.8;  ///< shifts are tried this far to both sides, of the larger radius of the scans
constexpr int kScoreSteps = 80;      ///< to each side
constexpr double kPaperParallel = 2; ///< a rotation of the paper's profile is found again within this [deg]

double
angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
  return Eigen::AngleAxisd(a.transpose() * b).angle() / kDegree;
}

/// The rotation of a list that is nearest to \p R, or its end.
std::vector<RotationCandidate>::const_iterator
nearestRotation(const std::vector<RotationCandidate>& rotations, const Eigen::Matrix3d& R)
{
  return std::min_element(
      rotations.begin(), rotations.end(), [&R](const RotationCandidate& a, const RotationCandidate& b) {
        return angleBetween(a.R_target_source, R) < angleBetween(b.R_target_source, R);
      });
}

/// Whether a pose is near enough to the truth to be refined to it; a rotation that is a little off shifts the middle of
/// the source: what counts is where the sensor, at \p place, comes to lie.
bool
isNear(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth, const Eigen::Vector3d& place, double scale)
{
  return angleBetween(T.linear(), truth.linear()) < kRotationFound &&
         (T * place - truth * place).norm() < 2 * kShiftFound * scale;
}

/// One sample of some.
OrientedSamples
oneSample(const OrientedSamples& samples, Eigen::Index i)
{
  OrientedSamples one;
  one.points = samples.points.col(i);
  one.normals = samples.normals.col(i);
  one.weights = samples.weights.segment(i, 1);
  one.extents = samples.extents.segment(i, 1);
  one.oriented = samples.oriented;
  return one;
}

} // namespace

Candidate
scoredPose(const PatchScan& source,
           const PatchScan& target,
           const Eigen::Isometry3d& T_target_source,
           const Options& options,
           bool refine)
{
  const PatchPair pair(source, target, options, nullptr, Deadline());
  ScoredPose pose;
  pose.T_target_source = pair.toInner(T_target_source);
  if (refine)
    pose.T_target_source = pair.refinedFine(pose.T_target_source);
  pair.scoreFine(pose);
  Candidate candidate = describe(pose);
  candidate.T_target_source = pair.toOuter(pose.T_target_source);
  return candidate;
}

ViewModel::ViewModel(ViewRun run, std::size_t candidate) : run_(std::move(run))
{
  const Options& used = run_.report.options;
  options_ = used;
  if (used.profile != Profile::Default) {
    options_ = makeOptions(Profile::Default);
    options_.viewpoint_mode = used.viewpoint_mode;
    options_.threads = used.threads;
    options_.gravity = used.gravity;
    paper_source_ = preparePaperScan(viewOf(run_.source), used);
    paper_target_ = preparePaperScan(viewOf(run_.target), used);
  }
  source_ = preparePatchScan(viewOf(run_.source), options_);
  target_ = preparePatchScan(viewOf(run_.target), options_);
  traceSearch();
  addPoses();
  chosen_ = std::min(candidate > 0 ? candidate - 1 : 0, poses_.size() - 1);
}

void
ViewModel::traceSearch()
{
  // The search of the default profile, from the guess of the run and without its time limit.
  std::optional<Eigen::Isometry3d> guess;
  if (run_.report.options.profile == Profile::Default && run_.report.guess)
    guess = toClouds(*run_.report.guess);
  SearchTrace trace;
  registerPatchScans(source_, target_, options_, guess ? &*guess : nullptr, Deadline(), &trace);
  const PatchPair pair(source_, target_, options_, nullptr, Deadline());
  std::vector<StageReport> reports;
  StageLog log(reports);
  const HypothesisSource hypotheses(pair, std::nullopt, log, nullptr);
  normals_ = {hypotheses.sourceNormals(), hypotheses.targetNormals()};
  if (trace.passes.empty())
    trace.passes.emplace_back(); // nothing could be searched
  for (const TracedPass& traced : trace.passes) {
    const SearchConfig& config = pair.config().search;
    ViewedPass pass;
    pass.options = hypotheses.searchOptions(traced.little_overlap ? config.little_overlap : config.much_overlap);
    pass.target_normals = normals_[1];
    for (const Eigen::Matrix3d& R : traced.rotations) {
      pass.rotations.emplace_back();
      pass.rotations.back().R_target_source = R;
    }
    for (const TracedHypothesis& hypothesis : traced.hypotheses) {
      pass.poses.emplace_back();
      pass.poses.back().T_target_source = pair.toInner(hypothesis.T_target_source);
      pass.poses.back().score = hypothesis.votes;
      pass.refined += hypothesis.refined;
    }
    passes_.push_back(std::move(pass));
  }
  for (const TracedHypothesis& hypothesis : trace.plan_hypotheses)
    plan_poses_.emplace_back(pair.toInner(hypothesis.T_target_source), hypothesis.refined);
}

bool
ViewModel::isOwnMethod() const
{
  const Method* method = findMethod(run_.report.method);
  return method && isSsfr(*method);
}

const ViewedPose*
ViewModel::truth() const
{
  return poses_.back().is_truth ? &poses_.back() : nullptr;
}

Eigen::Isometry3d
ViewModel::toClouds(const Eigen::Isometry3d& T_files) const
{
  return Eigen::Translation3d(-run_.target.offset) * T_files * Eigen::Translation3d(run_.source.offset);
}

Eigen::Isometry3d
ViewModel::toPatches(const Eigen::Isometry3d& T_files) const
{
  return Eigen::Translation3d(-targetOffset()) * T_files * Eigen::Translation3d(sourceOffset());
}

ViewedPose
ViewModel::judged(const Eigen::Isometry3d& T_files, const Candidate* known) const
{
  ViewedPose pose;
  // The evidence is that of the default profile; what the method itself reported of the pose goes before it.
  pose.candidate = scoredPose(source_, target_, toClouds(T_files), options_, false);
  if (known) {
    pose.candidate.score = known->score;
    pose.candidate.overlap = known->overlap;
    if (isOwnMethod() && !isPaperProfile())
      pose.candidate.contradiction = known->contradiction;
    pose.candidate.from_guess = known->from_guess;
  }
  pose.candidate.T_target_source = T_files;
  pose.moved = (T_files * run_.reference - run_.reference).norm();
  if (run_.truth) {
    pose.error = poseError(T_files, *run_.truth, run_.reference);
    pose.right = isWithin(*pose.error, run_.bound);
  }
  return pose;
}

void
ViewModel::addPoses()
{
  const std::vector<Candidate>& candidates = result().candidates;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    ViewedPose pose = judged(candidates[i].T_target_source, &candidates[i]);
    pose.short_name = std::to_string(i + 1);
    pose.name = "candidate " + pose.short_name + (candidates[i].from_guess ? " (the guess)" : "");
    poses_.push_back(pose);
  }
  if (poses_.empty()) {
    ViewedPose pose = judged(result().T_target_source, nullptr);
    pose.name = "no pose was found: the scans as they are";
    pose.short_name = "none";
    pose.error.reset(); // it is nobody's answer
    pose.right = false;
    poses_.push_back(pose);
  }
  if (run_.truth) {
    ViewedPose pose = judged(*run_.truth, nullptr);
    pose.name = "the truth";
    pose.short_name = "truth";
    pose.is_truth = true;
    poses_.push_back(pose);
  }
}

Eigen::Vector3d
ViewModel::up() const
{
  if (run_.report.options.gravity)
    return run_.report.options.gravity->up_target;
  // Scanners are held more or less upright: the heaviest direction near the z axis is that of floors and ceilings.
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double heaviest = 0;
  for (const MainNormal& normal : target_.main_normals) {
    if (std::abs(normal.direction.z()) < std::cos(kMostTilted * kDegree) || normal.support <= heaviest)
      continue;
    heaviest = normal.support;
    best = normal.direction.z() > 0 ? normal.direction : Eigen::Vector3d(-normal.direction);
  }
  return best;
}

SphereView
ViewModel::sphere(bool of_source) const
{
  SphereView view;
  if (isPaperProfile()) {
    const PaperScan& scan = of_source ? *paper_source_ : *paper_target_;
    const DensityOptions density = paperStages(run_.report.options).density;
    view.directions = makeGaussianSphere(scan.normals.samples);
    view.regions = findDensestRegions(view.directions, computeDensity(view.directions, density), density);
    view.main_normals = scan.main_normals;
    view.radius = density.radius;
    return view;
  }
  const PatchScan& scan = of_source ? source_ : target_;
  const DensityOptions density = patchDensityOptions(options_);
  view.directions = makeGaussianSphere(scan.patches.samples);
  view.regions = findDensestRegions(view.directions, computeDensity(view.directions, density), density);
  view.main_normals = normals_[of_source ? 0 : 1];
  view.radius = density.radius;
  return view;
}

std::array<AxisView, 3>
ViewModel::patchAxes(const Eigen::Matrix3d& R) const
{
  // Of the passes, which try different numbers of peaks, the last one is shown.
  const ViewedPass& search = passes_.back();
  const OrientedSamples& source = source_.patches.samples;
  const OrientedSamples& target = target_.patches.samples;
  const Eigen::Matrix3d axes =
      chooseSearchAxes(source, target, search.target_normals, R, parallelCos(search.options.config));
  const std::array<int, 3> counts{{search.options.pass.peaks_first, search.options.pass.peaks_second, 0}};
  std::array<AxisView, 3> views;
  for (std::size_t k = 0; k < 3; ++k) {
    AxisView& view = views[k];
    view.axis = axes.col(static_cast<Eigen::Index>(k));
    view.correlation = correlateAlongAxis(source, target, R.transpose() * view.axis, view.axis, search.options);
    view.every_shift = counts[k] == 0;
    if (!view.every_shift)
      view.peaks = findPeaks(view.correlation.sum, searchPeakOptions(search.options, counts[k]));
  }
  return views;
}

std::array<AxisView, 3>
ViewModel::paperAxes(const Eigen::Matrix3d& R) const
{
  const PaperOptions options = paperStages(run_.report.options);
  const OrientedSamples& target = paper_target_->normals.samples;
  TranslationOptions stage = options.translation;
  stage.histogram.bin_width = boundBinWidth(
      stage.histogram.bin_width, paper_source_->normals.samples, target, options.translation.histogram.max_bins);
  const std::vector<RotationCandidate> rotations =
      proposeRotations(paper_source_->main_normals, paper_target_->main_normals, options.rotation);
  const auto nearest = nearestRotation(rotations, R);
  std::array<AxisView, 3> views;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (nearest != rotations.end() && angleBetween(nearest->R_target_source, R) < kPaperParallel) {
    const auto chosen = chooseAxes(*nearest, paper_source_->main_normals, paper_target_->main_normals, stage);
    if (chosen)
      axes = *chosen;
  }
  Eigen::Isometry3d rotation = Eigen::Isometry3d::Identity();
  rotation.linear() = R;
  const OrientedSamples source = transformSamples(paper_source_->normals.samples, rotation);
  CorrelationOptions peaks = stage.correlation;
  peaks.max_peaks = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    AxisView& view = views[k];
    view.axis = axes.col(static_cast<Eigen::Index>(k));
    const auto histogram = [&](const OrientedSamples& samples) {
      return clipHistogram(projectOnAxis(samples, view.axis, stage.histogram), stage.histogram);
    };
    view.correlation.facings = {stage.histogram.facing};
    view.correlation.source = {histogram(source)};
    view.correlation.target = {histogram(target)};
    const Correlation plain = correlate(view.correlation.source.front(), view.correlation.target.front());
    view.correlation.sum = plain.values.size() > 0 && peaks.envelope_half_window > 0
                               ? subtractMedianEnvelope(plain, peaks.envelope_half_window)
                               : plain;
    view.peaks = findPeaks(plain, peaks);
  }
  return views;
}

std::array<AxisView, 3>
ViewModel::axes(const ViewedPose& pose, bool with_scores) const
{
  const Eigen::Isometry3d& T = pose.candidate.T_target_source;
  std::array<AxisView, 3> views = isPaperProfile() ? paperAxes(T.linear()) : patchAxes(T.linear());
  // Histograms are about the origins of the prepared scans.
  const auto prepared = [this](const Eigen::Isometry3d& T_files) {
    if (!isPaperProfile())
      return toPatches(T_files);
    return Eigen::Isometry3d(Eigen::Translation3d(-run_.target.offset - paper_target_->normals.origin) * T_files *
                             Eigen::Translation3d(run_.source.offset + paper_source_->normals.origin));
  };
  for (AxisView& view : views) {
    view.shift = view.axis.dot(prepared(T).translation());
    if (run_.truth)
      view.true_shift = view.axis.dot(prepared(*run_.truth).translation());
    if (with_scores)
      view.scores = scoresAlong(toPatches(T), view.axis);
  }
  return views;
}

std::vector<ShiftScore>
ViewModel::scoresAlong(const Eigen::Isometry3d& T_patches, const Eigen::Vector3d& axis) const
{
  const PatchPair pair(source_, target_, options_, nullptr, Deadline());
  const VisibilityOptions tolerances = pair.fineTolerances();
  const double step = kScoreReach / kScoreSteps * std::max({source_.extent.radius, target_.extent.radius, 1e-3});
  std::vector<ShiftScore> scores(2 * kScoreSteps + 1);
  [[maybe_unused]] const auto threads = static_cast<int>(threadCount(options_));
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
  for (int i = -kScoreSteps; i <= kScoreSteps; ++i) {
    const Eigen::Isometry3d T = Eigen::Translation3d(i * step * axis) * T_patches;
    const SurfaceEvidence both = pair.evidenceAt(T, tolerances);
    const double total = std::max(both.total, 1e-12);
    scores[static_cast<std::size_t>(i + kScoreSteps)] = {i * step, both.matched / total, both.contradicted / total};
  }
  return scores;
}

SurfaceFates
ViewModel::fates(const ViewedPose& pose, bool of_source) const
{
  const VisibilityOptions visibility = PatchPair(source_, target_, options_, nullptr, Deadline()).fineTolerances();
  const PatchScan& own = of_source ? source_ : target_;
  const PatchScan& other = of_source ? target_ : source_;
  Eigen::Isometry3d T = toPatches(pose.candidate.T_target_source);
  if (!of_source)
    T = T.inverse();
  SurfaceFates fates;
  for (Eigen::Index i = 0; i < own.patches.size(); ++i) {
    const SurfaceEvidence evidence =
        collectEvidence(oneSample(own.patches.samples, i), other.index, other.freeSpace(), T, visibility);
    const SurfaceFate fate = evidence.matched > 0        ? SurfaceFate::Matched
                             : evidence.contradicted > 0 ? SurfaceFate::Contradicted
                             : evidence.unmatched > 0    ? SurfaceFate::Unmatched
                                                         : SurfaceFate::Unseen;
    fates.each.push_back(fate);
    fates.surface[static_cast<std::size_t>(fate)] += evidence.total;
  }
  return fates;
}

// ---------------------------------------------------------------------------------------------------------------------
// Where the truth was lost

std::vector<LossStep>
ViewModel::findLoss() const
{
  if (!run_.truth || !isOwnMethod())
    return {};
  return isPaperProfile() ? findPaperLoss() : findPatchLoss();
}

LossStep
ViewModel::selectionStep() const
{
  LossStep step;
  step.stage = "selection";
  const ViewedPose& best = poses_.front();
  const ViewedPose& truth = poses_.back();
  std::size_t rank = 0;
  while (rank < poses_.size() && (poses_[rank].is_truth || !poses_[rank].right))
    ++rank;
  step.passed = best.right;
  if (!best.error || best.is_truth)
    step.finding = "there is no candidate";
  else if (best.right)
    step.finding = format("candidate 1 is right: %.2f deg and %.3f m from the truth",
                          best.error->rotation_deg,
                          best.error->translation_m);
  else if (rank < poses_.size())
    step.finding =
        format("the truth is candidate %zu: score %.3f, contradicted %.2f %%; candidate 1 has %.3f and %.2f %%",
               rank + 1,
               poses_[rank].candidate.score,
               100 * poses_[rank].candidate.contradiction,
               best.candidate.score,
               100 * best.candidate.contradiction);
  else
    step.finding =
        format("no candidate is right; the true pose itself would score %.3f (contradicted %.2f %%), candidate 1 "
               "has %.3f (%.2f %%)",
               truth.candidate.score,
               100 * truth.candidate.contradiction,
               best.candidate.score,
               100 * best.candidate.contradiction);
  return step;
}

LossStep
ViewModel::shiftStep(const ViewedPass& search, const Eigen::Matrix3d& R, const Eigen::Vector3d& axis, int tried) const
{
  const AxisCorrelation along =
      correlateAlongAxis(source_.patches.samples, target_.patches.samples, R.transpose() * axis, axis, search.options);
  const std::vector<ShiftPeak> all =
      findPeaks(along.sum, searchPeakOptions(search.options, std::numeric_limits<int>::max()));
  const Eigen::Vector3d place = source_.viewpoint;
  const double wanted = axis.dot(toPatches(*run_.truth) * place - R * place);
  const double near = kShiftFound * std::max(source_.scale, target_.scale);
  std::size_t rank = 0;
  while (rank < all.size() && std::abs(all[rank].shift - wanted) > near)
    ++rank;
  LossStep shift;
  shift.passed = static_cast<int>(rank) < tried && rank < all.size();
  shift.finding = rank < all.size()
                      ? format("the true shift %.2f m is near peak %zu of %zu (at %.2f m); the first %d are tried",
                               wanted,
                               rank + 1,
                               all.size(),
                               all[rank].shift,
                               tried)
                      : format("none of the %zu peaks is near the true shift %.2f m", all.size(), wanted);
  return shift;
}

LossStep
ViewModel::voteStep(const ViewedPass& search, const Eigen::Matrix3d& R) const
{
  const Eigen::Isometry3d truth = toPatches(*run_.truth);
  const double scale = std::max(source_.scale, target_.scale);
  const auto isTrue = [&](const PoseHypothesis& pose) {
    return isNear(pose.T_target_source, truth, source_.viewpoint, scale);
  };
  LossStep vote;
  const auto found = std::find_if(search.poses.begin(), search.poses.end(), isTrue);
  if (found != search.poses.end()) {
    const auto rank = static_cast<std::size_t>(found - search.poses.begin());
    vote.passed = rank < search.refined;
    vote.finding = format("a pose near the truth is number %zu of %zu by votes (%.3f, the first has %.3f); the first "
                          "%zu are refined",
                          rank + 1,
                          search.poses.size(),
                          found->score,
                          search.poses.front().score,
                          search.refined);
    return vote;
  }
  // Where would it have come under its own rotation, had more poses been kept?
  PoseSearchOptions all = search.options;
  all.pass.refined = std::numeric_limits<int>::max();
  const std::vector<PoseHypothesis> under = searchTranslations(source_.patches.samples,
                                                               source_.votes,
                                                               target_.patches.samples,
                                                               search.target_normals,
                                                               target_.index,
                                                               target_.freeSpace(),
                                                               R,
                                                               all);
  const auto own = std::find_if(under.begin(), under.end(), isTrue);
  vote.finding = format("none of the %zu poses found is near the truth; ", search.poses.size());
  vote.finding += own == under.end()
                      ? format("nor is any of all %zu under its rotation", under.size())
                      : format("under its rotation it is number %zu of %zu by votes (%.3f, the first has %.3f), and "
                               "%d are kept",
                               static_cast<std::size_t>(own - under.begin()) + 1,
                               under.size(),
                               own->score,
                               under.front().score,
                               search.options.pass.refined);
  return vote;
}

std::vector<LossStep>
ViewModel::passSteps(const ViewedPass& search, const std::string& suffix) const
{
  const Eigen::Isometry3d truth = toPatches(*run_.truth);
  LossStep rotation{"rotation" + suffix, false, "no rotation was proposed"};
  const auto nearest = nearestRotation(search.rotations, truth.linear());
  if (nearest != search.rotations.end()) {
    const double degrees = angleBetween(nearest->R_target_source, truth.linear());
    rotation.passed = degrees < kRotationFound;
    rotation.finding = format("the nearest of %zu rotations is number %zu, %.2f deg from the truth",
                              search.rotations.size(),
                              static_cast<std::size_t>(nearest - search.rotations.begin()) + 1,
                              degrees);
  }
  std::vector<LossStep> steps = {rotation};
  if (!rotation.passed)
    return steps;
  const Eigen::Matrix3d& R = nearest->R_target_source;
  const Eigen::Matrix3d axes = chooseSearchAxes(
      source_.patches.samples, target_.patches.samples, search.target_normals, R, parallelCos(search.options.config));
  for (int k = 0; k < 2; ++k) {
    const int tried = k == 0 ? search.options.pass.peaks_first : search.options.pass.peaks_second;
    steps.push_back(shiftStep(search, R, axes.col(k), tried));
    steps.back().stage = "shift along axis " + std::to_string(k + 1) + suffix;
  }
  steps.push_back(voteStep(search, R));
  steps.back().stage = "votes" + suffix;
  return steps;
}

LossStep
ViewModel::planStep() const
{
  const Eigen::Isometry3d truth = toPatches(*run_.truth);
  const double scale = std::max(source_.scale, target_.scale);
  LossStep plan{"plan views", false, format("none of the %zu poses found is near the truth", plan_poses_.size())};
  const auto found = std::find_if(plan_poses_.begin(), plan_poses_.end(), [&](const auto& pose) {
    return isNear(pose.first, truth, source_.viewpoint, scale);
  });
  if (found != plan_poses_.end()) {
    plan.passed = found->second;
    plan.finding = format("a pose near the truth is number %zu of %zu by votes, which is%s refined",
                          static_cast<std::size_t>(found - plan_poses_.begin()) + 1,
                          plan_poses_.size(),
                          found->second ? "" : " not");
  }
  return plan;
}

LossStep
ViewModel::refinementStep() const
{
  const Candidate refined = scoredPose(source_, target_, toClouds(*run_.truth), options_, true);
  const PoseError moved = poseError(Eigen::Translation3d(run_.target.offset) * refined.T_target_source *
                                        Eigen::Translation3d(-run_.source.offset),
                                    *run_.truth,
                                    run_.reference);
  return {"refinement",
          isWithin(moved, run_.bound),
          format("started at the truth it ends %.2f deg and %.3f m away, with score %.3f",
                 moved.rotation_deg,
                 moved.translation_m,
                 refined.score)};
}

std::vector<LossStep>
ViewModel::findPatchLoss() const
{
  std::vector<LossStep> steps;
  for (std::size_t e = 0; e < passes_.size(); ++e)
    for (LossStep& step : passSteps(passes_[e], passes_.size() > 1 ? ", pass " + std::to_string(e + 1) : ""))
      steps.push_back(std::move(step));
  if (!plan_poses_.empty())
    steps.push_back(planStep());
  steps.push_back(refinementStep());
  steps.push_back(selectionStep());
  return steps;
}

std::vector<LossStep>
ViewModel::findPaperLoss() const
{
  const PaperOptions options = paperStages(run_.report.options);
  std::vector<LossStep> steps;
  const std::vector<RotationCandidate> rotations =
      proposeRotations(paper_source_->main_normals, paper_target_->main_normals, options.rotation);
  LossStep rotation{"rotation", false, "no rotation was proposed"};
  const auto nearest = nearestRotation(rotations, run_.truth->linear());
  if (nearest != rotations.end()) {
    const double degrees = angleBetween(nearest->R_target_source, run_.truth->linear());
    rotation.passed = degrees < kRotationFound;
    rotation.finding = format("the nearest of %zu rotations is %.2f deg from the truth", rotations.size(), degrees);
  }
  steps.push_back(rotation);
  if (rotation.passed) {
    ViewedPose pose = poses_.back();
    pose.candidate.T_target_source.linear() = nearest->R_target_source;
    const std::array<AxisView, 3> views = axes(pose, false);
    for (std::size_t k = 0; k < 3; ++k) {
      LossStep shift{"shift along axis " + std::to_string(k + 1), false, "no plane faces this axis in both scans"};
      if (!views[k].peaks.empty()) {
        const double apart = std::abs(views[k].peaks.front().shift - *views[k].true_shift);
        shift.passed = apart < kShiftFound;
        shift.finding = format("the highest peak is at %.2f m, the true shift is %.2f m",
                               views[k].peaks.front().shift,
                               *views[k].true_shift);
      }
      steps.push_back(shift);
    }
  }
  steps.push_back(selectionStep());
  return steps;
}

} // namespace apps
} // namespace pcl_ssfr
