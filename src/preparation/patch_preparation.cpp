// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/even_draw.h"
#include "common/stage_clock.h"
#include "common/stage_names.h"
#include "preparation/thinning.h"
#include "preparation/viewpoint_search.h"
#include "profiles/patch_profile.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace {

std::uint64_t
count(Eigen::Index n)
{
  return static_cast<std::uint64_t>(n);
}

double
sceneScale(const ScanExtent& extent, const PreparationConfig& config)
{
  if (!(extent.radius > 0))
    return 1;
  return extent.radius / std::clamp(extent.radius, config.smallest_radius, config.largest_radius);
}

/// At most \p most of the \p returns of a scan, evenly drawn in their order, that are within \p reach [m] of \p origin
/// along every axis, and relative to it [m]. Drivers write huge numbers where nothing came back.
Eigen::Matrix3Xf
drawReturns(const ScanView& scan, std::size_t returns, const Eigen::Vector3d& origin, double reach, std::size_t most)
{
  const std::size_t count = std::min(most, returns);
  const bool is_each_one = returns == scan.count();
  Eigen::Matrix3Xf drawn(3, static_cast<Eigen::Index>(count));
  Eigen::Index kept = 0;
  std::size_t at = 0, before = 0; // a point, and the returns before it
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t wanted = evenlyDrawn(i, count, returns);
    if (is_each_one)
      at = wanted;
    else
      for (; before < wanted || !scan.isReturn(at); ++at)
        before += scan.isReturn(at) ? 1 : 0;
    const Eigen::Vector3d p = scan.point(at).cast<double>() - origin;
    if ((p.array().abs() < reach).all())
      drawn.col(kept++) = p.cast<float>();
  }
  return drawn.leftCols(kept);
}

/// Thinned points that share a coarsest patch cell with a typical point: the median over the points.
std::size_t
pointsPerCell(const ThinnedCloud& cloud, int level)
{
  std::vector<std::size_t> counts;
  for (std::size_t i = 0; i < cloud.codes.size(); ++i) {
    if (i == 0 || (cloud.codes[i] >> (3 * level)) != (cloud.codes[i - 1] >> (3 * level)))
      counts.push_back(0);
    ++counts.back();
  }
  std::sort(counts.begin(), counts.end());
  std::size_t below = 0;
  for (const std::size_t c : counts)
    if (2 * (below += c) >= cloud.codes.size())
      return c;
  return 0;
}

/// Thickness that patches may have: the usual one, more where the scan is noisier than that.
double
choosePatchThickness(const ThinnedCloud& cloud, const std::vector<FineCell>& cells, const PreparationConfig& lengths)
{
  const double usual = lengths.thickness;
  const double most = lengths.max_noise * usual;
  const PlanarPatches rough = extractPatches(cloud, cells, nullptr, most, lengths.patches);
  if (rough.size() == 0)
    return usual;
  std::vector<std::pair<double, double>> thickness; // and the surface that has it
  for (Eigen::Index i = 0; i < rough.size(); ++i)
    thickness.emplace_back(rough.thickness[i], rough.samples.weights[i]);
  std::sort(thickness.begin(), thickness.end());
  const double wanted = lengths.thin_share * rough.samples.weights.sum();
  double sum = 0;
  for (const auto& [t, surface] : thickness)
    if ((sum += surface) >= wanted)
      return std::clamp(lengths.noise_factor * t, usual, most);
  return usual;
}

std::vector<MainNormal>
findPatchMainNormals(const OrientedSamples& samples, const Options& options)
{
  const DensityOptions density = patchDensityOptions(options);
  MeanShiftOptions mean_shift;
  mean_shift.bandwidth = 2 * density.radius;
  mean_shift.merge_chord = mean_shift.bandwidth;
  mean_shift.tolerance = 1e-5;
  const DirectionSet sphere = makeGaussianSphere(samples);
  const Eigen::VectorXd densities = computeDensity(sphere, density, threadCount(options));
  return findMainNormals(sphere, findDensestRegions(sphere, densities, density), mean_shift);
}

/// A scan thinned at the scale of its scene.
struct ScaledCloud {
  double scale = 1;
  ThinnedCloud cloud; ///< relative to the median of the scan
};

ScaledCloud
thinAtScale(const ScanView& scan, const ScanExtent& extent, const Options& options, const Deadline& deadline)
{
  const PreparationConfig& config = options.patch_profile.preparation;
  ScaledCloud result;
  result.scale = sceneScale(extent, config);
  // A patch of the finest level has an edge of 2^finest_level leaves; a normal radius r asks for an edge of 2 r.
  const bool given = options.leaf > 0 || options.normal_radius > 0;
  const auto leaf = [&] {
    return options.leaf > 0 ? options.leaf
           : options.normal_radius > 0
               ? 2 * options.normal_radius / static_cast<double>(1 << config.patches.finest_level)
               : config.leaf * result.scale;
  };
  result.cloud = thinScan(scan, leaf(), extent.median, 0, threadCount(options), deadline);
  // Where points are sparse, patches must be larger to hold enough of them; at most as large as the scan.
  const double size = (extent.max - extent.min).norm();
  while (!given && result.cloud.size() >= config.min_points && leaf() < size &&
         pointsPerCell(result.cloud, config.patches.coarsest_level) <
             static_cast<std::size_t>(config.min_points_per_cell)) {
    result.scale *= 2;
    result.cloud = ThinnedCloud(); // its memory first
    result.cloud = thinScan(scan, leaf(), extent.median, 0, threadCount(options), deadline);
  }
  return result;
}

/// Where a scan's sensor is, relative to the median of the scan [m].
struct SensorPlace {
  std::optional<Eigen::Vector3d> place; ///< nothing: not known
  bool is_found = false;                ///< in the points, not given
};

SensorPlace
placeSensor(const ScanView& scan,
            const ScanExtent& extent,
            const ThinnedCloud& cloud,
            const PreparationConfig& lengths,
            const Options& options,
            const Deadline& deadline)
{
  const Eigen::Vector3d given = scan.viewpoint - extent.median;
  const ViewpointMode mode = options.viewpoint_mode;
  if (mode == ViewpointMode::Unused)
    return {};
  if (mode == ViewpointMode::SensorOrigin || (mode == ViewpointMode::Auto && scan.viewpoint_is_known))
    return {given, false};
  const Eigen::Matrix3Xf points = drawReturns(scan,
                                              extent.returns,
                                              extent.median,
                                              thinningReach(cloud.leaf),
                                              static_cast<std::size_t>(lengths.viewpoint.levels.back().points));
  if (mode == ViewpointMode::Auto && isPlausibleViewpoint(points, given.cast<float>(), lengths, deadline))
    return {given, false};
  if (const std::optional<Eigen::Vector3f> place = findViewpoint(points, lengths, threadCount(options), deadline))
    return {place->cast<double>(), true};
  return {};
}

/// At most \p most of the points that are in no patch, evenly drawn in their order, one of each finest cell of patches.
Eigen::Matrix3Xf
drawClutter(const ThinnedCloud& cloud, const PlanarPatches& patches, const PatchConfig& config, int most)
{
  const auto cell = [&](std::uint32_t i) { return cloud.codes[i] >> (3 * config.finest_level); };
  std::vector<std::uint32_t> of_cells;
  for (const std::uint32_t i : patches.clutter)
    if (of_cells.empty() || cell(i) != cell(of_cells.back()))
      of_cells.push_back(i);
  of_cells = drawEvenly(std::move(of_cells), static_cast<std::size_t>(most));
  Eigen::Matrix3Xf drawn(3, static_cast<Eigen::Index>(of_cells.size()));
  for (std::size_t k = 0; k < of_cells.size(); ++k)
    drawn.col(static_cast<Eigen::Index>(k)) = cloud.points.col(of_cells[k]);
  return drawn;
}

} // namespace

DensityOptions
patchDensityOptions(const Options& options)
{
  DensityOptions density;
  density.kernel = DensityOptions::Kernel::Gaussian;
  const PreparationConfig& config = options.patch_profile.preparation;
  density.radius = options.density_radius > 0 ? options.density_radius : config.density_radius;
  density.max_regions = config.max_main_normals;
  density.silence_chord = 2 * density.radius; // closer modes are one
  density.min_relative_density = config.min_relative_density;
  density.max_queries = config.max_density_queries;
  return density;
}

PatchScan
preparePatchScan(const ScanView& scan, const Options& options, const Deadline& deadline)
{
  PatchScan prepared;
  StageClock clock;
  // A stage in which the time ran out may not be complete.
  const auto finish = [&](const char* stage, std::uint64_t in, std::uint64_t out) {
    prepared.stages.push_back(clock.lap(stage, in, out));
    if (deadline.hasPassed())
      prepared.unfinished = stage;
  };

  const PreparationConfig& config = options.patch_profile.preparation;
  prepared.extent = measureExtent(scan, deadline);
  prepared.origin = prepared.extent.median;
  ScaledCloud scaled_cloud = thinAtScale(scan, prepared.extent, options, deadline);
  prepared.scale = scaled_cloud.scale;
  ThinnedCloud& cloud = scaled_cloud.cloud;
  prepared.leaf = cloud.leaf;
  finish(kThinningStage, scan.count(), count(cloud.size()));
  if (!prepared.unfinished.empty())
    return prepared;

  const PreparationConfig lengths = scaled(config, prepared.scale);
  const SensorPlace sensor = placeSensor(scan, prepared.extent, cloud, lengths, options, deadline);
  prepared.viewpoint_used = sensor.place.has_value();
  prepared.viewpoint_found = sensor.is_found;
  if (sensor.place) {
    prepared.viewpoint = *sensor.place;
    prepared.range_image = RangeImage(cloud.points, prepared.viewpoint.cast<float>(), config.range_cell);
  }
  finish("range image", count(cloud.size()), prepared.range_image.size());
  if (!prepared.unfinished.empty())
    return prepared;

  const Eigen::Vector3d* seen_from = sensor.place ? &*sensor.place : nullptr;
  {
    const std::vector<FineCell> cells = accumulateFineCells(cloud, config.patches.finest_level);
    prepared.thickness = choosePatchThickness(cloud, cells, lengths);
    prepared.patches = extractPatches(cloud, cells, seen_from, prepared.thickness, config.patches);
  }
  finish("patches", count(cloud.size()), count(prepared.patches.size()));
  if (!prepared.unfinished.empty())
    return prepared;

  prepared.main_normals = findPatchMainNormals(prepared.patches.samples, options);
  finish("main normals", count(prepared.patches.size()), prepared.main_normals.size());
  if (!prepared.unfinished.empty())
    return prepared;

  prepared.votes = drawVotingSamples(prepared.patches.samples, prepared.main_normals, config.votes, config.same_facing);
  prepared.coarse = selectPatches(
      prepared.patches,
      drawRepresentatives(prepared.patches.samples, prepared.main_normals, config.coarse_patches, config.same_facing));
  prepared.coarse.samples.weights.setOnes(); // each stands for others, small and large ones
  prepared.clutter = drawClutter(cloud, prepared.patches, config.patches, config.clutter_points);
  prepared.patches.clutter = std::vector<std::uint32_t>(); // of points that are gone soon
  prepared.surface =
      drawSurfacePoints(cloud, prepared.patches, config.polish_points, config.polish_group, config.max_polish_points);
  cloud = ThinnedCloud(); // its memory goes before the index needs some
  // A voxel is as wide as the geometric mean of the usual edges of patches: each lists few, and each is listed in few.
  const double levels = 0.5 * (config.patches.finest_level + config.patches.coarsest_level);
  const double noise = prepared.thickness / lengths.thickness; // see choosePatchThickness(): 1 and more
  prepared.index =
      PatchIndex(prepared.patches, lengths.leaf * std::exp2(levels), lengths.match * noise, config.loose_facing);
  prepared.stages.push_back(clock.lap("index", count(prepared.patches.size()), count(prepared.surface.points.cols())));
  return prepared; // complete, even if the time has run out meanwhile
}

} // namespace pcl_ssfr
