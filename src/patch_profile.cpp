// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/patch_profile.h>
#include <pcl_ssfr/refinement.h>
#include <pcl_ssfr/thinning.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "stage_clock.h"

namespace pcl_ssfr {

namespace {

double P(const char* name, double def) { const char* v = getenv(name); return v ? atof(v) : def; }

constexpr double kLeaf = 0.025;
constexpr double kThickness = 0.03;
constexpr double kRangeCell = 0.01745;

unsigned
workers(const Options& options)
{
  return std::max(1u, options.threads);
}

double
sceneScale(const ScanExtent& extent)
{
  constexpr double kSmall = 1.5, kLarge = 120;
  if (!(extent.radius > 0))
    return 1;
  return extent.radius < kSmall ? extent.radius / kSmall : extent.radius > kLarge ? extent.radius / kLarge : 1;
}

struct Judged {
  Eigen::Isometry3d T;
  double score = 0;
  SurfaceEvidence evidence;
  double search_score = 0;
};

class Registration {
public:
  Registration(const PatchScan& source, const PatchScan& target, const Options& options)
  : source_(source), target_(target), options_(options), scale_(std::max(source.scale, target.scale))
  {
    either_ = !(source.patches.samples.oriented && target.patches.samples.oriented);
  }

  VisibilityOptions
  visibility(double distance, double lateral, double angle) const
  {
    VisibilityOptions v;
    v.match.either_side = either_;
    v.match.min_cos = static_cast<float>(std::cos(angle));
    v.match.distance = static_cast<float>(distance * scale_);
    v.match.lateral = static_cast<float>(lateral * scale_);
    v.free_margin = v.hidden_margin = static_cast<float>(0.3 * scale_);
    return v;
  }

  SurfaceEvidence
  evidence(const Eigen::Isometry3d& T, const VisibilityOptions& v) const
  {
    SurfaceEvidence e = collectEvidence(source_.patches.samples, target_.index,
                                        target_.range_image.empty() ? nullptr : &target_.range_image, T, v);
    SurfaceEvidence back = collectEvidence(target_.patches.samples, source_.index,
                         source_.range_image.empty() ? nullptr : &source_.range_image, T.inverse(), v);
    back.matched_normals = (T.linear() * back.matched_normals * T.linear().transpose()).eval();
    back.visible_normals = (T.linear() * back.visible_normals * T.linear().transpose()).eval();
    return e += back;
  }

  const PatchScan& source_;
  const PatchScan& target_;
  const Options& options_;
  double scale_;
  bool either_;
};

bool
nearPose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double angle, double distance, const Eigen::Vector3d& c)
{
  const Eigen::Isometry3d d = a.inverse() * b;
  return ((a * c) - (b * c)).norm() < distance && Eigen::AngleAxisd(d.linear()).angle() < angle;
}

} // namespace

PatchScan
preparePatchScan(const ScanView& scan, const Options& options)
{
  PatchScan prepared;
  StageClock clock;
  prepared.extent = measureExtent(scan);
  prepared.scale = sceneScale(prepared.extent);
  prepared.origin = prepared.extent.centroid;
  const double leaf = options.leaf > 0 ? options.leaf : P("leaf", kLeaf) * prepared.scale;
  const ThinnedCloud cloud = thinScan(scan, leaf, prepared.origin, 0, workers(options));
  prepared.stages.push_back(clock.lap("thinning", scan.count(), static_cast<std::uint64_t>(cloud.size())));

  const Eigen::Vector3d viewpoint = scan.viewpoint - prepared.origin;
  prepared.viewpoint_used =
      options.viewpoint_mode == ViewpointMode::SensorOrigin || scan.viewpoint_is_known ||
      (options.viewpoint_mode == ViewpointMode::Auto &&
       isPlausibleViewpoint(cloud.points, viewpoint.cast<float>(), prepared.scale));
  if (options.viewpoint_mode == ViewpointMode::Unknown)
    prepared.viewpoint_used = false;
  if (prepared.viewpoint_used)
    prepared.range_image = RangeImage(cloud.points, viewpoint.cast<float>(), kRangeCell);
  prepared.stages.push_back(clock.lap("viewpoint", static_cast<std::uint64_t>(cloud.size()), prepared.range_image.size()));

  PatchOptions po = options.patches;
  po.coarsest_level = int(P("coarse", po.coarsest_level));
  prepared.patches = extractPatches(cloud, prepared.viewpoint_used ? &viewpoint : nullptr,
                                    po.thickness > 0 ? po.thickness : P("thick", kThickness) * prepared.scale, po);
  prepared.stages.push_back(clock.lap("patches", static_cast<std::uint64_t>(cloud.size()), static_cast<std::uint64_t>(prepared.patches.size())));

  DensityOptions density;
  density.kernel = DensityOptions::Kernel::Gaussian;
  density.radius = options.density_radius > 0 ? options.density_radius : P("rd", 0.1);
  density.max_regions = int(P("modes", 14));
  density.silence_chord = 0.26;
  density.min_relative_density = P("minden", 0.02);
  MeanShiftOptions mean_shift;
  mean_shift.bandwidth = 2 * density.radius;
  mean_shift.merge_chord = 0.2;
  mean_shift.tolerance = 1e-5;
  const DirectionSet sphere = makeGaussianSphere(prepared.patches.samples);
  const Eigen::VectorXd d = computeDensity(sphere, density, workers(options));
  const std::vector<DenseRegion> regions = findDensestRegions(sphere, d, density);
  prepared.main_normals = findMainNormals(sphere, regions, mean_shift);
  prepared.stages.push_back(clock.lap("main normals", static_cast<std::uint64_t>(sphere.size()), prepared.main_normals.size()));

  prepared.votes = drawVotingSamples(prepared.patches.samples, prepared.main_normals, int(P("votes", 160)));
  prepared.index = PatchIndex(prepared.patches, P("voxel", 0.5) * prepared.scale);
  PatchOptions fine = po;
  fine.split_above = int(P("split", 100));
  fine.min_points = int(P("fmin", 8));
  const PlanarPatches small = extractPatches(cloud, prepared.viewpoint_used ? &viewpoint : nullptr,
                                    po.thickness > 0 ? po.thickness : P("thick", kThickness) * prepared.scale, fine);
  prepared.surface = drawSurfacePoints(cloud, small, int(P("ppp", 4)));
  prepared.fine_index = PatchIndex(small, P("fvoxel", 0.25) * prepared.scale);
  prepared.stages.push_back(clock.lap("index", static_cast<std::uint64_t>(prepared.patches.size()), 0));
  return prepared;
}

Result
registerPatchScans(const PatchScan& source, const PatchScan& target, const Options& options, const Eigen::Isometry3d* guess)
{
  (void)guess;
  Result result;
  StageClock clock;
  const Registration reg(source, target, options);
  if (source.main_normals.size() < 2 || target.main_normals.size() < 2) {
    result.status = Status::TooFewDirections;
    return result;
  }
  RotationOptions ro;
  ro.angle_tolerance = 0.07;
  ro.merge_angle = 0.07;
  ro.refit_angle = 0.12;
  std::vector<RotationCandidate> rotations = proposeRotations(source.main_normals, target.main_normals, ro);
  const std::size_t all_rotations = rotations.size();
  if (rotations.size() > static_cast<std::size_t>(P("maxrot", 24)))
    rotations.resize(static_cast<std::size_t>(P("maxrot", 24)));
  result.stages.push_back(clock.lap("rotations", all_rotations, rotations.size()));
  if (rotations.empty()) {
    result.status = Status::NoCandidate;
    return result;
  }

  PoseSearchOptions so;
  so.samples = int(P("votes", 160));
  so.peaks_first = int(P("pk1", 5));
  so.peaks_second = int(P("pk2", 8));
  so.bin_width = P("bin", 0.1) * reg.scale_;
  so.peak_separation = 0.3 * reg.scale_;
  so.step = P("step", 0.25) * reg.scale_;
  so.contradiction_weight = P("cw1", 1);
  so.visibility = reg.visibility(0.3, 0.3, 0.5);
  std::vector<std::vector<PoseHypothesis>> slots(rotations.size());
  const auto n_rot = static_cast<std::int64_t>(rotations.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast<int>(workers(options)))
  for (std::int64_t i = 0; i < n_rot; ++i) {
    const auto u = static_cast<std::size_t>(i);
    slots[u] = searchTranslations(source.patches.samples, source.votes, target.patches.samples, target.main_normals,
                                  target.index, target.range_image.empty() ? nullptr : &target.range_image,
                                  rotations[u].R_target_source, so);
  }
  std::vector<PoseHypothesis> all;
  for (const auto& s : slots)
    all.insert(all.end(), s.begin(), s.end());
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  const std::size_t found = all.size();
  if (all.size() > static_cast<std::size_t>(P("topk", 80)))
    all.resize(static_cast<std::size_t>(P("topk", 80)));
  result.stages.push_back(clock.lap("translations", rotations.size(), found));

  // coarse refinement
  std::vector<Judged> judged(all.size());
  const auto n_all = static_cast<std::int64_t>(all.size());
  const VisibilityOptions loose = reg.visibility(P("ld", 0.2), P("ll", 0.3), 0.44);
  const double cw = P("cw", 4);
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast<int>(workers(options)))
  for (std::int64_t i = 0; i < n_all; ++i) {
    const auto u = static_cast<std::size_t>(i);
    RefinementOptions r;
    r.match = reg.visibility(0.5, 0.5, 0.44).match;
    r.final_distance = 0.15 * reg.scale_;
    r.steps = int(P("steps", 6));
    Judged& j = judged[u];
    j.search_score = all[u].score;
    j.T = refinePatches(source.patches, target.index, all[u].T_target_source, r).T_target_source;
    j.evidence = reg.evidence(j.T, loose);
    j.score = (j.evidence.matched - cw * j.evidence.contradicted) / j.evidence.total;
  }
  std::stable_sort(judged.begin(), judged.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<Judged> distinct;
  for (const Judged& j : judged) {
    if (std::none_of(distinct.begin(), distinct.end(), [&](const Judged& k) { return nearPose(j.T, k.T, 0.05, 0.3 * reg.scale_, Eigen::Vector3d::Zero()); }))
      distinct.push_back(j);
    if (distinct.size() >= 12)
      break;
  }
  result.stages.push_back(clock.lap("coarse refinement", all.size(), distinct.size()));

  const VisibilityOptions tight = reg.visibility(P("td", 0.1), P("tl", 0.3), 0.35);
  const auto n_d = static_cast<std::int64_t>(distinct.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast<int>(workers(options)))
  for (std::int64_t i = 0; i < n_d; ++i) {
    Judged& j = distinct[static_cast<std::size_t>(i)];
    RefinementOptions r;
    r.match = reg.visibility(0.2, 0.3, 0.35).match;
    r.final_distance = 0.05 * reg.scale_;
    r.steps = 15;
    j.T = refinePatches(source.patches, target.index, j.T, r).T_target_source;
    j.evidence = reg.evidence(j.T, tight);
    j.score = (j.evidence.matched - cw * j.evidence.contradicted) / j.evidence.total;
  }
  std::stable_sort(distinct.begin(), distinct.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  result.stages.push_back(clock.lap("fine refinement", distinct.size(), distinct.size()));

  if (!distinct.empty() && options.refine) {
    RefinementOptions r;
    r.match = reg.visibility(P("pd", 0.3), P("pl", 0.1), 0.35).match;
    r.final_distance = P("pf", 0.1) * reg.scale_;
    r.steps = int(P("ps", 12));
    const Refinement polished = refineMutual(source.surface, source.fine_index, target.surface, target.fine_index, distinct.front().T, r);
    distinct.front().T = polished.T_target_source;
    result.rmse = polished.rms;
    result.stages.push_back(clock.lap("polish", 1, static_cast<std::uint64_t>(polished.matches)));
  }

  for (const Judged& j : distinct) {
    Candidate c;
    c.T_target_source = Eigen::Translation3d(target.origin) * j.T * Eigen::Translation3d(-source.origin);
    c.score = j.score;
    c.overlap = j.evidence.matched / std::max(1e-9, j.evidence.total);
    c.contradiction = j.evidence.contradicted / std::max(1e-9, j.evidence.total);
    c.unmatched = j.evidence.unmatched / std::max(1e-9, j.evidence.total);
    c.weakest = weakestMatchedShare(j.evidence);
    result.candidates.push_back(c);
  }
  if (!result.candidates.empty()) {
    result.T_target_source = result.candidates.front().T_target_source;
    result.overlap = result.candidates.front().overlap;
    result.contradiction = result.candidates.front().contradiction;
    result.status = Status::Converged;
    result.confidence = 1;
  }
  return result;
}

} // namespace pcl_ssfr
