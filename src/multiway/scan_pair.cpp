// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/scan_pair.h"

#include "judgement/pose_uncertainty.h"
#include "judgement/visibility_score.h"
#include "preparation/range_image.h"
#include "profiles/patch_pair.h"
#include "profiles/pose_refinement.h"
#include "profiles/prepared_data.h"
#include "refinement/plane_equations.h"

#include <pcl_ssfr/pipeline.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ssfr {

namespace {

using Matrix6 = SurfaceEquations::Matrix6;

constexpr double kSurvey = 0.006;     // [m] Autodesk ReCap counts the points below
constexpr double kWithinReach = 0.99; // two scans farther apart share a hundredth of either: less than an overlap
constexpr float kFreeRatio = 0.02f;   // of the range: what a loose test adds to the margin of free space

template <typename Matrix>
std::size_t
bytesOfMatrix(const Matrix& m)
{
  return static_cast<std::size_t>(m.size()) * sizeof(typename Matrix::Scalar);
}

std::size_t
bytesOfPatches(const PlanarPatches& patches)
{
  const OrientedSamples& s = patches.samples;
  return bytesOfMatrix(s.points) + bytesOfMatrix(s.normals) + bytesOfMatrix(s.weights) + bytesOfMatrix(s.extents) +
         bytesOfMatrix(s.facing) + bytesOfMatrix(patches.majors) + bytesOfMatrix(patches.half_minors) +
         bytesOfMatrix(patches.thickness) +
         (patches.counts.size() + patches.first_point.size() + patches.clutter.size()) * sizeof(std::uint32_t);
}

/// Two scans and their options, which the pair refers to.
struct OptionedPair {
  OptionedPair(const PreparedScan& source, const PreparedScan& target, const MultiwayOptions& multiway)
      : options(pairOptions(multiway)), pair(patchesOf(source), patchesOf(target), options, nullptr, Deadline())
  {}
  OptionedPair(const OptionedPair&) = delete;
  OptionedPair&
  operator=(const OptionedPair&) = delete;

  Options options;
  PatchPair pair;
};

/// A pose that was found but not polished, refined to the end and rated again.
PairHypothesis
polished(const PatchPair& pair, const Candidate& candidate)
{
  ScoredPose pose;
  pose.T_target_source = pair.toInner(candidate.T_target_source);
  pair.scoreFine(pose);
  pair.polish(pose);
  const PoseUncertainty uncertainty = uncertaintyOf(pair, pose);
  PairHypothesis hypothesis;
  hypothesis.T_target_source = pair.toOuter(pose.T_target_source);
  hypothesis.rmse = pose.polish->rms;
  hypothesis.information = uncertainty.informationAbout(-pair.target().origin);
  return hypothesis;
}

/// Of a patch that fills a finest cell.
double
weightOfPoint(const PreparedScan& scan)
{
  const int finest_level = scan.data().options.patch_profile.preparation.patches.finest_level;
  const double edge = std::ldexp(patchesOf(scan).leaf, finest_level);
  return voteOf(edge * edge);
}

/// Add what the sensor of \p image, where there is one, sees of points that T lays into its frame.
void
addPoints(const Eigen::Matrix3Xf& points,
          double weight,
          const RangeImage* image,
          const Eigen::Isometry3d& T,
          const VisibilityOptions& tolerances,
          FurnitureEvidence& evidence)
{
  if (!image)
    return;
  const Eigen::Isometry3f T_image = T.cast<float>();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f ray = T_image * points.col(i) - image->viewpoint();
    if (!(ray.norm() > 0))
      continue;
    const Visibility visibility = visibilityAt(ray, *image, tolerances);
    const bool is_free = visibility == Visibility::Free;
    evidence.in_view += is_free || visibility == Visibility::AtDepth ? weight : 0;
    evidence.seen_through += is_free ? weight : 0;
  }
}

} // namespace

Options
pairOptions(const MultiwayOptions& options)
{
  Options result = options.registration;
  result.threads = 1;
  result.time_limit = 0; // links must not depend on how busy the machine is
  double& plans_below = result.patch_profile.search.plans_below;
  plans_below = std::min(plans_below, options.link.plans_below);
  if (options.gravity)
    result.gravity =
        GravityPrior{options.gravity->normalized(), options.gravity->normalized(), options.gravity_tolerance};
  return result;
}

std::string
problemOf(const PreparedScan& scan)
{
  if (scan.empty())
    return "it was not prepared";
  const PatchScan& patches = patchesOf(scan);
  const auto least = static_cast<std::size_t>(scan.data().options.patch_profile.preparation.min_points);
  if (patches.extent.returns < least)
    return "it has " + std::to_string(patches.extent.returns) + " finite points away from the sensor, fewer than " +
           std::to_string(least);
  if (patches.patches.size() == 0)
    return "no surface was found in it";
  return "";
}

std::size_t
bytesOf(const PreparedScan& scan)
{
  if (scan.empty())
    return 0;
  const PatchScan& s = patchesOf(scan);
  return sizeof(PreparedData) + bytesOfPatches(s.patches) + bytesOfPatches(s.coarse) + bytesOfMatrix(s.votes.points) +
         bytesOfMatrix(s.votes.normals) + s.index.bytes() + s.range_image.bytes() + bytesOfMatrix(s.surface.points) +
         bytesOfMatrix(s.clutter) + bytesOfMatrix(s.surface.normals) + s.surface.patches.size() * sizeof(std::int32_t) +
         s.surface.facing.size();
}

Eigen::Vector3d
placeOf(const PreparedScan& scan)
{
  const PatchScan& s = patchesOf(scan);
  return s.origin + s.viewpoint;
}

const VotingSamples&
votesOf(const PreparedScan& scan)
{
  return patchesOf(scan).votes;
}

double
scaleOf(const PreparedScan& scan)
{
  return patchesOf(scan).scale;
}

PairLink
linkScans(const PreparedScan& source,
          const PreparedScan& target,
          const MultiwayOptions& options,
          const std::optional<PairGuess>& guess)
{
  const auto start = std::chrono::steady_clock::now();
  Options pair_options = pairOptions(options);
  if (guess)
    pair_options.guess_tolerance = guess->tolerance;
  const Eigen::Isometry3d* T_guess = guess ? &guess->T_target_source : nullptr;
  const Result result = registerScans(source, target, pair_options, T_guess);
  PairLink link;
  link.status = result.status;
  link.message = result.message;
  link.confidence = result.confidence;
  link.probability_of_none = 1;
  const PatchPair pair(patchesOf(source), patchesOf(target), pair_options, T_guess, Deadline());
  for (const Candidate& candidate : result.candidates) {
    const bool is_best = link.hypotheses.empty();
    if (static_cast<int>(link.hypotheses.size()) >= options.link.hypotheses ||
        candidate.probability < options.link.least_probability)
      break; // they are in the order of their probability
    PairHypothesis hypothesis;
    if (is_best) {
      hypothesis.T_target_source = result.T_target_source;
      hypothesis.rmse = result.rmse;
      hypothesis.information = result.information;
    }
    else
      hypothesis = polished(pair, candidate);
    hypothesis.probability = candidate.probability;
    hypothesis.score = candidate.score;
    hypothesis.overlap = candidate.overlap;
    hypothesis.contradiction = candidate.contradiction;
    link.probability_of_none -= candidate.probability;
    link.hypotheses.push_back(hypothesis);
  }
  link.probability_of_none = std::max(0.0, link.probability_of_none);
  link.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return link;
}

SightOfScan
sightOf(const PreparedScan& scan)
{
  const PatchScan& s = patchesOf(scan);
  const OrientedSamples& samples = s.patches.samples;
  SightOfScan sight;
  std::vector<double> ranges;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    sight.total += std::sqrt(std::sqrt(samples.weights[i]));
    ranges.push_back((samples.points.col(i) - s.viewpoint).norm());
  }
  if (ranges.empty())
    return sight;
  const auto last = ranges.begin() + static_cast<std::ptrdiff_t>(kWithinReach * static_cast<double>(ranges.size()));
  std::nth_element(ranges.begin(), last, ranges.end());
  sight.reach = *last;
  return sight;
}

double
contradictionWeight(const MultiwayOptions& options)
{
  return options.registration.patch_profile.judgement.evidence.contradiction_weight;
}

double
scoreOf(const PlacementEvidence& evidence, double contradiction_weight)
{
  return (evidence.matched - contradiction_weight * evidence.contradicted) / std::max(evidence.total, 1e-9);
}

PlacementEvidence
evidenceAt(const PreparedScan& source,
           const PreparedScan& target,
           const Eigen::Isometry3d& T_target_source,
           const MultiwayOptions& options,
           double looseness)
{
  const OptionedPair optioned(source, target, options);
  const PatchPair& pair = optioned.pair;
  VisibilityOptions tolerances = pair.fineTolerances();
  const auto loose = static_cast<float>(looseness);
  tolerances.match.distance *= loose;
  tolerances.free_margin *= loose;
  tolerances.hidden_margin *= loose;
  tolerances.free_ratio -= kFreeRatio * (loose - 1);
  const SurfaceEvidence both = pair.evidenceAt(pair.toInner(T_target_source), tolerances);
  PlacementEvidence evidence;
  evidence.total = both.patches.total;
  evidence.matched = both.patches.matched;
  evidence.contradicted = both.patches.contradicted;
  evidence.overlap = both.total > 0 ? both.matched / both.total : 0;
  return evidence;
}

Eigen::Matrix3Xf
solidClutter(const PreparedScan& scan, const MultiwayOptions& options)
{
  const OptionedPair itself(scan, scan, options);
  const VisibilityOptions tolerances = itself.pair.fineTolerances();
  const PatchScan& patches = itself.pair.source();
  const RangeImage* image = patches.freeSpace();
  Eigen::Matrix3Xf solid(3, patches.clutter.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; image && i < patches.clutter.cols(); ++i) {
    const Eigen::Vector3f ray = patches.clutter.col(i) - image->viewpoint();
    const float beyond = tolerances.hidden_ratio * ray.norm() + tolerances.hidden_margin;
    if (image->farthest(image->cell(ray)) <= beyond)
      solid.col(count++) = patches.clutter.col(i);
  }
  return solid.leftCols(count);
}

FurnitureEvidence
furnitureAt(const PreparedScan& source,
            const Furniture& source_furniture,
            const PreparedScan& target,
            const Furniture& target_furniture,
            const Eigen::Isometry3d& T_target_source,
            const MultiwayOptions& options)
{
  const OptionedPair optioned(source, target, options);
  const PatchPair& pair = optioned.pair;
  VisibilityOptions tolerances = pair.fineTolerances();
  const auto margin = static_cast<float>(options.furniture.margin);
  tolerances.free_margin *= margin;
  tolerances.free_ratio = 1 - margin * (1 - tolerances.free_ratio);
  const PatchScan& s = pair.source();
  const PatchScan& t = pair.target();
  const Eigen::Isometry3d T = pair.toInner(T_target_source);
  const Eigen::Isometry3d T_back = T.inverse();
  SurfaceEvidence both = collectEvidence(source_furniture.patches, t.index, t.freeSpace(), T, tolerances);
  both += collectEvidence(target_furniture.patches, s.index, s.freeSpace(), T_back, tolerances);
  FurnitureEvidence evidence{both.patches.visible(), both.patches.contradicted};
  addPoints(source_furniture.points, weightOfPoint(source), t.freeSpace(), T, tolerances, evidence);
  addPoints(target_furniture.points, weightOfPoint(target), s.freeSpace(), T_back, tolerances, evidence);
  return evidence;
}

SurfaceEquations
equationsAt(const PreparedScan& source,
            const PreparedScan& target,
            const Eigen::Isometry3d& T_target_source,
            const MultiwayOptions& options)
{
  const OptionedPair optioned(source, target, options);
  const PatchPair& pair = optioned.pair;
  const Eigen::Isometry3d T = pair.toInner(T_target_source);
  const MutualFit fit = pair.fitInMap(T);
  SurfaceEquations equations;
  const Refinement& here = fit.refinement;
  if (here.matches < 3)
    return equations;
  const Matrix6 a = aboutOrigin(here.centre + pair.target().origin);
  const auto about = [&](const Matrix6& m) { return Matrix6(a * m * a.transpose()); };
  equations.hessian = about(here.hessian);
  equations.gradient = a * fit.gradient;
  equations.curvature = about(here.statistics.curvature);
  equations.full_curvature = about(here.statistics.full_curvature);
  equations.weight = fit.wide_weight;
  equations.squares = fit.wide_rms * fit.wide_rms * fit.wide_weight;
  return equations;
}

PatchGradients
patchGradientsAt(const PreparedScan& source,
                 const PreparedScan& target,
                 const Eigen::Isometry3d& T_target_source,
                 const MultiwayOptions& options,
                 bool of_source)
{
  const OptionedPair optioned(source, target, options);
  const PatchPair& pair = optioned.pair;
  const Eigen::Isometry3d T = pair.toInner(T_target_source);
  const MutualFit fit = pair.fitInMap(T);
  const auto count = [](const PatchScan& scan) { return static_cast<std::size_t>(scan.patches.size()); };
  const std::size_t sources = count(pair.source()), targets = count(pair.target());
  const Matrix6 a = aboutOrigin(fit.refinement.centre + pair.target().origin);
  const double noise_floor = noiseFloor(pair.config().judgement.uncertainty, fit.refinement.rms);
  const std::size_t first = of_source ? 0 : sources;
  const auto columns = static_cast<Eigen::Index>(of_source ? sources : targets);
  PatchGradients result{PatchGradients::Columns(6, columns), PatchGradients::Columns(6, columns)};
  for (Eigen::Index k = 0; k < columns; ++k) {
    const PatchSum& patch = fit.patches[first + static_cast<std::size_t>(k)];
    result.gradients.col(k) = a * patch.gradient;
    result.offsets.col(k) = noise_floor * (a * patch.offset);
  }
  return result;
}

LinkFigures
figuresAt(const PreparedScan& source,
          const PreparedScan& target,
          const Eigen::Isometry3d& T_target_source,
          const MultiwayOptions& options)
{
  const OptionedPair optioned(source, target, options);
  const PatchPair& pair = optioned.pair;
  const PatchIndex::Tolerance tolerance = pair.lastStep().match;
  const Eigen::Isometry3d T = pair.toInner(T_target_source);
  const Eigen::Isometry3d back = T.inverse();
  double squares = 0;
  Eigen::Index matches = 0;
  Eigen::Index close = 0;
  LinkFigures figures;
  const auto add = [&](const PatchScan& from, const PatchScan& to, const Eigen::Isometry3d& motion, bool is_target) {
    for (Eigen::Index i = 0; i < from.surface.points.cols(); ++i) {
      const Eigen::Vector3d p = motion * from.surface.points.col(i).cast<double>();
      const Eigen::Vector3d n = motion.linear() * from.surface.normals.col(i).cast<double>();
      const int found = to.index.find(p.cast<float>(), n.cast<float>(), tolerance);
      if (found < 0)
        continue;
      const PatchIndex::Meeting meeting = to.index.meet(found, p);
      squares += meeting.distance * meeting.distance;
      ++matches;
      close += std::abs(meeting.distance) < kSurvey ? 1 : 0;
      const Eigen::Vector3d normal = is_target ? meeting.normal : Eigen::Vector3d(T.linear() * meeting.normal);
      figures.strength += normal.cwiseAbs2();
    }
  };
  add(pair.source(), pair.target(), T, true);
  add(pair.target(), pair.source(), back, false);
  if (matches > 0) {
    const auto count = static_cast<double>(matches);
    figures.rmse = std::sqrt(squares / count);
    figures.below_6mm = static_cast<double>(close) / count;
    figures.strength /= count;
  }
  figures.overlap = evidenceAt(source, target, T_target_source, options, 1).overlap;
  return figures;
}

} // namespace pcl_ssfr
