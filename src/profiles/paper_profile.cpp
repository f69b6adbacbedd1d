// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/paper_profile.h"

#include "common/parallel.h"
#include "common/rotation_math.h"
#include "common/stage_clock.h"
#include "common/stage_names.h"
#include "directions/density_filter.h"
#include "directions/gaussian_sphere.h"
#include "judgement/overlap.h"
#include "preparation/voxel_sampling.h"
#include "search/rotation_candidates.h"
#include "search/translation.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Fewest samples with a normal that a scan must have.
constexpr Eigen::Index kMinSamples = 10;
/// The LCP leaf against the normal radius (METHOD: settings the authors ran in 2017).
constexpr double kRoomRadius = 0.1, kVehicleRadius = 0.6, kRoomLcpLeaf = 0.2, kVehicleLcpLeaf = 0.5; ///< [m]
/// Poses closer than this in both are one in the list of candidates.
constexpr double kDistinctAngle = 5 * kDegree, kDistinctShift = 0.5; ///< [rad], [m]

template <typename Count>
std::uint64_t
toCount(Count count)
{
  return static_cast<std::uint64_t>(count);
}

double
deriveLcpLeaf(double normal_radius)
{
  const double share = (normal_radius - kRoomRadius) / (kVehicleRadius - kRoomRadius);
  return kRoomLcpLeaf + std::clamp(share, 0.0, 1.0) * (kVehicleLcpLeaf - kRoomLcpLeaf);
}

/// A pose between the centred scans with all that stages 9 to 12 found.
struct PaperPose {
  bool judged = false; ///< axes were found, the time sufficed and the score was computed
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< target from source, both centred
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();     ///< along which it was shifted, one a column
  Translation translation;
  Overlap overlap;
  double score = 0;
  bool from_guess = false;
  double translation_seconds = 0, score_seconds = 0;
};

/// METHOD stage 12: the LCP of a pose between the centred scans. 2017 counts neighbours nearer than the leaf; 2019 sums
/// a kernel over sqrt(3) bin widths.
Overlap
overlapAt(const PaperScan& source,
          const PaperScan& target,
          const PaperOptions& stages,
          const Eigen::Isometry3d& pose,
          unsigned threads)
{
  const double radius = stages.lcp.kernel_sum ? std::sqrt(3.0) * stages.translation.histogram.bin_width
                                              : std::max(source.lcp_leaf, target.lcp_leaf);
  return computeOverlap(source.lcp_points, target.lcp_index, pose, radius, threads);
}

double
scoreOf(const Overlap& overlap, const PaperOptions& stages)
{
  return stages.lcp.kernel_sum ? overlap.kernel_sum : overlap.ratio;
}

/// Algorithm 2 on two prepared scans.
class PaperRegistration {
public:
  PaperRegistration(const PaperScan& source, const PaperScan& target, const Options& options, const Deadline& deadline)
      : source_(source), target_(target), options_(options), stages_(paperStages(options)), deadline_(deadline),
        threads_(threadCount(options))
  {}

  Result
  run(const Eigen::Isometry3d* guess);

private:
  bool
  isOutOfTime() const
  {
    return deadline_.hasPassed();
  }
  /// Why the scans give no candidate at all, if they do not.
  std::optional<std::pair<Status, std::string>>
  findProblem() const;
  std::vector<RotationCandidate>
  findRotations();
  /// METHOD stages 9 to 12 for every rotation; one slot each, so that the threads leave no trace.
  std::vector<PaperPose>
  judgeRotations(const std::vector<RotationCandidate>& rotations);
  /// METHOD stage 12.
  void
  score(PaperPose& candidate, unsigned threads) const;
  /// METHOD stage 13: the translation anew in fine bins.
  PaperPose
  refineTranslation(const PaperPose& coarse) const;
  /// METHOD stage 13 for the best candidates; what scores at least as high takes the place of the coarse one.
  void
  runFinePass(std::vector<PaperPose>& ranked);
  void
  report(const std::vector<PaperPose>& ranked);
  void
  addStage(const char* name, double seconds, std::uint64_t in, std::uint64_t out);

  const PaperScan& source_;
  const PaperScan& target_;
  const Options& options_;
  PaperOptions stages_;
  Deadline deadline_;
  unsigned threads_;
  Result result_;
  std::size_t proposed_ = 0, skipped_ = 0; ///< rotations proposed, and left unjudged when the time ran out
};

void
PaperRegistration::addStage(const char* name, double seconds, std::uint64_t in, std::uint64_t out)
{
  result_.stages.push_back({name, seconds, in, out});
}

std::optional<std::pair<Status, std::string>>
PaperRegistration::findProblem() const
{
  const auto nameOf = [this](const PaperScan* scan) { return std::string(scan == &source_ ? "source" : "target"); };
  for (const PaperScan* scan : {&source_, &target_}) {
    if (scan->normals.samples.size() < kMinSamples)
      return std::pair(Status::TooFewPoints,
                       "the " + nameOf(scan) + " has " + std::to_string(scan->normals.samples.size()) +
                           " points with a normal (of " + std::to_string(scan->normals.returns) +
                           " finite points away from the sensor); at least " + std::to_string(kMinSamples) +
                           " are needed");
  }
  for (const PaperScan* scan : {&source_, &target_}) {
    if (!hasPair(scan->main_normals, stages_.rotation))
      return std::pair(Status::TooFewDirections,
                       "the planes of the " + nameOf(scan) +
                           " face in fewer than two directions that are not parallel: the rotation is unobservable");
  }
  return std::nullopt;
}

std::vector<RotationCandidate>
PaperRegistration::findRotations()
{
  const StageClock clock;
  std::vector<RotationCandidate> rotations =
      proposeRotations(source_.main_normals, target_.main_normals, stages_.rotation);
  if (options_.gravity)
    rotations.erase(std::remove_if(rotations.begin(),
                                   rotations.end(),
                                   [&](const RotationCandidate& candidate) {
                                     return !keepsVertical(
                                         candidate.R_target_source, *options_.gravity, options_.gravity->tolerance);
                                   }),
                    rotations.end());
  addStage("rotation_candidates",
           clock.elapsed(),
           toCount(source_.main_normals.size() + target_.main_normals.size()),
           toCount(rotations.size()));
  proposed_ = rotations.size();
  return rotations;
}

void
PaperRegistration::score(PaperPose& candidate, unsigned threads) const
{
  candidate.overlap = overlapAt(source_, target_, stages_, candidate.pose, threads);
  candidate.score = scoreOf(candidate.overlap, stages_);
  candidate.judged = true;
}

std::vector<PaperPose>
PaperRegistration::judgeRotations(const std::vector<RotationCandidate>& rotations)
{
  const StageClock clock;
  TranslationOptions translation_options = stages_.translation;
  translation_options.histogram.bin_width = boundBinWidth(stages_.translation.histogram.bin_width,
                                                          source_.normals.samples,
                                                          target_.normals.samples,
                                                          stages_.translation.histogram.max_bins);
  std::vector<PaperPose> poses(rotations.size());
  std::vector<char> skipped(rotations.size(), 0);
  forEachInParallel(static_cast<std::int64_t>(rotations.size()), 1, static_cast<int>(threads_), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    if (isOutOfTime()) {
      skipped[i] = 1;
      return;
    }
    PaperPose& candidate = poses[i];
    const StageClock translation_clock;
    const std::optional<Eigen::Matrix3d> axes =
        chooseAxes(rotations[i], source_.main_normals, target_.main_normals, translation_options);
    if (!axes)
      return;
    candidate.axes = *axes;
    candidate.pose.linear() = rotations[i].R_target_source;
    candidate.translation = estimateTranslation(transformSamples(source_.normals.samples, candidate.pose),
                                                target_.normals.samples,
                                                candidate.axes,
                                                translation_options);
    candidate.pose.translation() = candidate.translation.t_target_source;
    candidate.translation_seconds = translation_clock.elapsed();
    const StageClock score_clock;
    score(candidate, 1);
    candidate.score_seconds = score_clock.elapsed();
  });

  double translation_seconds = 0, score_seconds = 0;
  std::uint64_t judged = 0;
  for (const PaperPose& pose : poses) {
    translation_seconds += pose.translation_seconds;
    score_seconds += pose.score_seconds;
    judged += pose.judged ? 1 : 0;
  }
  skipped_ = static_cast<std::size_t>(std::count(skipped.begin(), skipped.end(), 1));
  // Both run in one loop: the wall clock is split in proportion to the time that the threads spent.
  const double spent = translation_seconds + score_seconds;
  const double share = spent > 0 ? translation_seconds / spent : 1;
  const double seconds = clock.elapsed();
  addStage("translation", seconds * share, toCount(rotations.size()), judged);
  addStage("lcp", seconds * (1 - share), judged, judged);
  return poses;
}

PaperPose
PaperRegistration::refineTranslation(const PaperPose& coarse) const
{
  const OrientedSamples& source = source_.normals.samples;
  const OrientedSamples& target = target_.normals.samples;
  const double coarse_width = stages_.translation.histogram.bin_width;
  TranslationOptions fine = stages_.translation;
  fine.histogram.bin_width =
      boundBinWidth(coarse_width / stages_.lcp.fine_factor, source, target, fine.histogram.max_bins);
  // The envelope would span less than one smoothed peak here and take its top off.
  fine.correlation.envelope_half_window = 0;
  const int half_window = static_cast<int>(std::lround(stages_.lcp.fine_smoothing / fine.histogram.bin_width / 2));

  PaperPose refined = coarse;
  Eigen::Isometry3d rotation = Eigen::Isometry3d::Identity();
  rotation.linear() = coarse.pose.linear();
  refined.translation = estimateTranslation(transformSamples(source, rotation),
                                            target,
                                            coarse.axes,
                                            fine,
                                            &coarse.translation,
                                            stages_.lcp.fine_range_bins * coarse_width,
                                            half_window);
  refined.pose.translation() = refined.translation.t_target_source;
  score(refined, threads_);
  return refined;
}

void
PaperRegistration::runFinePass(std::vector<PaperPose>& ranked)
{
  if (stages_.lcp.fine_factor <= 0)
    return;
  const StageClock clock;
  const std::size_t limit = stages_.lcp.kernel_sum ? 2 : 1; // 2019 refines the best two
  std::uint64_t tried = 0, taken = 0;
  for (std::size_t i = 0; i < std::min(limit, ranked.size()) && !isOutOfTime(); ++i) {
    ++tried;
    PaperPose refined = refineTranslation(ranked[i]);
    if (refined.score < ranked[i].score)
      continue;
    ranked[i] = refined;
    ++taken;
  }
  addStage("fine_pass", clock.elapsed(), tried, taken);
}

void
PaperRegistration::report(const std::vector<PaperPose>& ranked)
{
  const StageClock clock;
  const auto toFullPose = [&](const Eigen::Isometry3d& centred) {
    Eigen::Isometry3d T = centred;
    T.translation() += target_.normals.origin - centred.linear() * source_.normals.origin;
    return T;
  };
  const std::uint64_t in = ranked.size();
  std::vector<PaperPose> distinct;
  for (const PaperPose& pose : ranked) {
    if (static_cast<int>(distinct.size()) >= options_.max_candidates)
      break;
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const PaperPose& kept) {
      return angleBetween(kept.pose.linear(), pose.pose.linear()) < kDistinctAngle &&
             (kept.pose.translation() - pose.pose.translation()).norm() < kDistinctShift;
    });
    if (known)
      continue;
    distinct.push_back(pose);
    Candidate candidate;
    candidate.T_target_source = toFullPose(pose.pose);
    candidate.score = pose.score;
    candidate.overlap = pose.overlap.ratio;
    candidate.rmse = pose.overlap.rmse;
    candidate.from_guess = pose.from_guess;
    result_.candidates.push_back(candidate);
  }
  const PaperPose& best = distinct.front();
  result_.status = Status::Converged;
  result_.T_target_source = result_.candidates.front().T_target_source;
  result_.overlap = best.overlap.ratio;
  result_.rmse = best.overlap.rmse;
  for (std::size_t k = 0; k < 3 && !best.from_guess; ++k) {
    if (best.translation.observed[k])
      continue;
    // Moves along neither of the other two axes: what their shifts leave open.
    const auto column = static_cast<Eigen::Index>(k);
    UnobservableDirection open;
    open.direction = best.axes.col((column + 1) % 3).cross(best.axes.col((column + 2) % 3)).normalized();
    result_.unobservable.push_back(open);
  }

  std::ostringstream message;
  message << "best of " << in << " poses lays " << std::lround(100 * result_.overlap)
          << " % of the source on the target";
  if (skipped_ > 0)
    message << "; the time limit left " << skipped_ << " of " << proposed_ << " rotations unjudged";
  if (!result_.unobservable.empty())
    message << "; no plane fixes the translation along " << result_.unobservable.size()
            << " direction(s), which stays 0";
  result_.message = message.str();
  addStage("selection", clock.elapsed(), in, toCount(result_.candidates.size()));
}

Result
PaperRegistration::run(const Eigen::Isometry3d* guess)
{
  result_.source_viewpoint_used = source_.normals.samples.oriented;
  result_.target_viewpoint_used = target_.normals.samples.oriented;
  result_.source_viewpoint = source_.viewpoint;
  result_.target_viewpoint = target_.viewpoint;
  for (const PaperScan* scan : {&source_, &target_})
    for (StageReport stage : scan->stages) {
      stage.name = (scan == &source_ ? "source_" : "target_") + stage.name;
      result_.stages.push_back(stage);
    }
  if (const auto problem = findProblem()) {
    std::tie(result_.status, result_.message) = *problem;
    return result_;
  }

  const std::vector<RotationCandidate> rotations = findRotations(); // stages 6 to 8
  std::vector<PaperPose> ranked;
  for (PaperPose& pose : judgeRotations(rotations)) // stages 9 to 12
    if (pose.judged)
      ranked.push_back(pose);
  const auto byScore = [](const PaperPose& a, const PaperPose& b) { return a.score > b.score; };
  std::stable_sort(ranked.begin(), ranked.end(), byScore);
  runFinePass(ranked); // stage 13
  const bool judges_guess =
      guess && !(options_.gravity && !keepsVertical(guess->linear(), *options_.gravity, options_.gravity->tolerance));
  if (judges_guess) {
    PaperPose candidate;
    candidate.pose = *guess;
    candidate.pose.translation() =
        *guess * source_.normals.origin - target_.normals.origin; // from centred source to centred target
    candidate.from_guess = true;
    score(candidate, threads_);
    ranked.push_back(candidate);
  }
  std::stable_sort(ranked.begin(), ranked.end(), byScore);

  if (ranked.empty()) {
    result_.status = skipped_ > 0 ? Status::TimeLimit : Status::NoCandidate;
    result_.message = skipped_ > 0 ? "the time limit ran out before a candidate was judged"
                      : rotations.empty()
                          ? "no rotation maps two main normals of the source onto two of the target"
                          : "no third main normal of the target is independent of a matched pair: no translation";
    return result_;
  }
  report(ranked);
  return result_;
}

} // namespace

PaperOptions
paperStages(const Options& options)
{
  PaperOptions stages = options.paper;
  if (options.normal_radius > 0)
    stages.normals.radius = options.normal_radius;
  if (options.leaf > 0)
    stages.normals.leaf = options.leaf;
  if (options.density_radius > 0)
    stages.density.radius = options.density_radius;
  if (options.bin_width > 0)
    stages.translation.histogram.bin_width = options.bin_width;
  return stages;
}

PaperScan
preparePaperScan(const ScanView& scan, const Options& options, const Deadline& deadline)
{
  validate(options);
  const PaperOptions stages = paperStages(options);
  // The paper takes the sensor to be at the origin: Auto accepts it.
  const bool oriented =
      options.viewpoint_mode == ViewpointMode::Auto || options.viewpoint_mode == ViewpointMode::SensorOrigin;
  const unsigned threads = threadCount(options);
  PaperScan result;
  StageClock clock;
  // A stage in which the time ran out may not be complete.
  const auto finish = [&](const char* name, auto in, auto out) {
    result.stages.push_back(clock.lap(name, toCount(in), toCount(out)));
    if (deadline.hasPassed())
      result.unfinished = name;
  };

  // Stage 1. The paper thins and estimates within fixed scales; r = 0 and leaf = 0 follow from the data.
  result.normals = estimateNormals(scan, stages.normals, oriented, threads, deadline);
  const OrientedSamples& samples = result.normals.samples;
  if (samples.oriented)
    result.viewpoint = scan.viewpoint;
  finish(kPaperNormalsStage, scan.count(), samples.size());
  if (!result.unfinished.empty())
    return result;

  const DirectionSet image = makeGaussianSphere(samples); // stage 2
  finish("gaussian_sphere", samples.size(), image.size());
  if (!result.unfinished.empty())
    return result;

  const Eigen::VectorXd density = computeDensity(image, stages.density, threads, deadline); // stage 3
  finish("density", image.size(), image.size());
  if (!result.unfinished.empty())
    return result;

  const std::vector<DenseRegion> regions = findDensestRegions(image, density, stages.density); // stage 4
  finish("densest_regions", image.size(), regions.size());
  if (!result.unfinished.empty())
    return result;

  result.main_normals = findMainNormals(image, regions, stages.mean_shift); // stage 5
  finish("mean_shift", regions.size(), result.main_normals.size());
  if (!result.unfinished.empty())
    return result;

  // The thinning of stage 12.
  result.lcp_leaf = stages.lcp.leaf > 0 ? stages.lcp.leaf : deriveLcpLeaf(result.normals.radius);
  const std::vector<Eigen::Index> columns = samplePerVoxel(samples.points, result.lcp_leaf);
  result.lcp_points.resize(3, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i)
    result.lcp_points.col(static_cast<Eigen::Index>(i)) = samples.points.col(columns[i]);
  result.lcp_index = NeighborIndex(result.lcp_points);
  result.stages.push_back(clock.lap("lcp_thinning", toCount(samples.size()), toCount(columns.size())));
  return result;
}

Result
registerPaperScans(const PaperScan& source,
                   const PaperScan& target,
                   const Options& options,
                   const Eigen::Isometry3d* guess,
                   const Deadline& deadline)
{
  validate(options);
  return PaperRegistration(source, target, options, deadline).run(guess);
}

Candidate
scorePaperPose(const PaperScan& source,
               const PaperScan& target,
               const Options& options,
               const Eigen::Isometry3d& T_target_source)
{
  Candidate candidate;
  candidate.T_target_source = T_target_source;
  if (source.lcp_points.cols() == 0 || target.lcp_points.cols() == 0)
    return candidate;
  const PaperOptions stages = paperStages(options);
  const Eigen::Isometry3d centred =
      Eigen::Translation3d(-target.normals.origin) * T_target_source * Eigen::Translation3d(source.normals.origin);
  const Overlap overlap = overlapAt(source, target, stages, centred, threadCount(options));
  candidate.score = scoreOf(overlap, stages);
  candidate.overlap = overlap.ratio;
  candidate.rmse = overlap.rmse;
  return candidate;
}

} // namespace pcl_ssfr
