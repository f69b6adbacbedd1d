// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Time of each stage of both profiles on simulated scans of a hall, of several sizes, by Google Benchmark:
// `stage_benchmarks --benchmark_filter=thinning`; its other options: --help. Where PCL has a counterpart, the counter
// over_pcl is our processor time over PCL's for the same work, in the same run. One thread, unless the name says
// otherwise.

#include "common/angles.h"
#include "profiles/paper_profile.h"
#include "profiles/patch_profile.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/baselines/fast_global_registration.h>
#include <pcl_ssfr/pipeline.h>

#include <pcl/features/normal_3d_omp.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/search/kdtree.h>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace pcl_ssfr;
using testing::viewOfPoints;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr int kNeighbours = 20; // of PCL's normals
constexpr std::int64_t kSizes[] = {30000, 300000, 3000000};
constexpr std::int64_t kLargestForPaper = 300000; // its normals and FGR's descriptors take long
constexpr std::int64_t kLargestForFgr = 30000;

// As in the default profile.
const PreparationConfig kPreparation = PatchProfileConfig{}.preparation;
const double kLeaf = kPreparation.leaf;                                     // [m]
const double kThickness = kPreparation.thickness;                           // [m]
const double kCell = kPreparation.range_cell;                               // [rad]
const double kDirectionError = PatchProfileConfig{}.search.direction_error; // [rad]

// A start for the refinements, near the truth.
constexpr double kStartTurn = 0.03; // [rad]
constexpr double kStartShift = 0.2; // [m]

Cloud::Ptr
cloudOf(const Eigen::Matrix3Xf& points)
{
  auto cloud = pcl::make_shared<Cloud>();
  cloud->resize(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    (*cloud)[static_cast<std::size_t>(i)].getVector3fMap() = points.col(i);
  return cloud;
}

/// A pair of scans of one size with all that the stages take.
struct Pair {
  Eigen::Matrix3Xf source, target; ///< [m], sensor frames
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  Options options = makeOptions(Profile::Default);
  PatchScan source_scan, target_scan;
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity(); ///< near the truth, in the frames of the prepared scans
};

Pair
makePair(std::int64_t size)
{
  const testing::Scene scene = testing::makeHall(2);
  testing::SensorPattern pattern = testing::terrestrialScanner();
  pattern.azimuth_step =
      std::sqrt(2 * kPi * (pattern.elevation_max - pattern.elevation_min) / static_cast<double>(size));
  pattern.elevation_step = pattern.azimuth_step;
  const Eigen::Isometry3d T_world_target = testing::sensorPose(scene.stations[0], 0.1, 0);
  const Eigen::Isometry3d T_world_source = testing::sensorPose(scene.stations[1], 1.9, 0.05);
  Pair pair;
  pair.target = testing::castScan(scene, T_world_target, pattern, 1);
  pair.source = testing::castScan(scene, T_world_source, pattern, 2);
  pair.T_target_source = testing::relativePose(T_world_target, T_world_source);
  pair.source_scan = preparePatchScan(viewOfPoints(pair.source), pair.options);
  pair.target_scan = preparePatchScan(viewOfPoints(pair.target), pair.options);
  pair.start = Eigen::Translation3d(Eigen::Vector3d::Constant(kStartShift / std::sqrt(3)) - pair.target_scan.origin) *
               pair.T_target_source * Eigen::AngleAxisd(kStartTurn, Eigen::Vector3d::UnitX()) *
               Eigen::Translation3d(pair.source_scan.origin);
  return pair;
}

/// Pairs by size, made when they are first asked for.
class Pairs {
public:
  const Pair&
  of(std::int64_t size)
  {
    std::unique_ptr<Pair>& pair = pairs_[size];
    if (!pair)
      pair = std::make_unique<Pair>(makePair(size));
    return *pair;
  }

private:
  std::map<std::int64_t, std::unique_ptr<Pair>> pairs_;
};

/// Processor time of a call [s]: on a busy machine a fairer yardstick than the clock on the wall.
double
processorSeconds(const std::function<void()>& work)
{
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/** \brief Time \p work; report how many items it took and, with a counterpart, our processor time over PCL's.
 * \param[in] counterpart the same work by PCL; empty: there is none
 */
void
measure(benchmark::State& state,
        const std::function<void()>& work,
        std::size_t items,
        const std::function<void()>& counterpart = {})
{
  const double seconds = processorSeconds([&] {
    for (auto _ : state)
      work();
  });
  state.counters["items"] = static_cast<double>(items);
  if (!counterpart)
    return;
  constexpr std::size_t kRuns = 3;
  constexpr double kLong = 1; // [s] once is enough then
  std::vector<double> theirs = {processorSeconds(counterpart)};
  while (theirs.size() < kRuns && theirs.front() < kLong)
    theirs.push_back(processorSeconds(counterpart));
  std::sort(theirs.begin(), theirs.end());
  state.counters["over_pcl"] = seconds / static_cast<double>(state.iterations()) / theirs[theirs.size() / 2];
}

std::size_t
countOf(Eigen::Index n)
{
  return static_cast<std::size_t>(n);
}

ThinnedCloud
thinned(const Pair& pair)
{
  return thinScan(viewOfPoints(pair.source), kLeaf, measureExtent(viewOfPoints(pair.source)).median);
}

/// PCL's normals of all points from their neighbours.
void
estimateNormalsWithPcl(const Cloud::Ptr& cloud, double radius)
{
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> estimation(1);
  estimation.setInputCloud(cloud);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  if (radius > 0)
    estimation.setRadiusSearch(radius);
  else
    estimation.setKSearch(kNeighbours);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  benchmark::DoNotOptimize(normals.points.data());
}

// ---------------------------------------------------------------------------------------------------------------------
// Stages of the default profile: preparation

void
thinning(benchmark::State& state, const Pair& pair)
{
  const Cloud::Ptr cloud = cloudOf(pair.source);
  measure(
      state,
      [&] { benchmark::DoNotOptimize(thinned(pair)); },
      cloud->size(),
      [&] {
        pcl::VoxelGrid<pcl::PointXYZ> grid;
        grid.setInputCloud(cloud);
        grid.setLeafSize(static_cast<float>(kLeaf), static_cast<float>(kLeaf), static_cast<float>(kLeaf));
        Cloud out;
        grid.filter(out);
        benchmark::DoNotOptimize(out.points.data());
      });
}

void
rangeImage(benchmark::State& state, const Pair& pair)
{
  const ThinnedCloud cloud = thinned(pair);
  const Eigen::Vector3f viewpoint = -cloud.origin.cast<float>();
  measure(
      state, [&] { benchmark::DoNotOptimize(RangeImage(cloud.points, viewpoint, kCell)); }, countOf(cloud.size()));
}

/// Against PCL's normals of the thinned points: both give oriented surface.
void
patches(benchmark::State& state, const Pair& pair)
{
  const ThinnedCloud cloud = thinned(pair);
  const Eigen::Vector3d viewpoint = -cloud.origin;
  const Cloud::Ptr points = cloudOf(cloud.points);
  measure(
      state,
      [&] { benchmark::DoNotOptimize(extractPatches(cloud, &viewpoint, kThickness, PatchConfig())); },
      countOf(cloud.size()),
      [&] { estimateNormalsWithPcl(points, 0); });
}

/// Gaussian sphere, densities, densest regions, mean shift on patches.
void
mainNormals(benchmark::State& state, const Pair& pair)
{
  DensityOptions density;
  density.kernel = DensityOptions::Kernel::Gaussian;
  density.radius = 0.1;
  density.max_regions = 14;
  density.silence_chord = 2 * density.radius;
  density.min_relative_density = 0.02;
  MeanShiftOptions mean_shift;
  mean_shift.bandwidth = 2 * density.radius;
  mean_shift.merge_chord = 0.2;
  mean_shift.tolerance = 1e-5;
  measure(
      state,
      [&] {
        const DirectionSet sphere = makeGaussianSphere(pair.source_scan.patches.samples);
        benchmark::DoNotOptimize(
            findMainNormals(sphere, findDensestRegions(sphere, computeDensity(sphere, density), density), mean_shift));
      },
      countOf(pair.source_scan.patches.size()));
}

/// Against the KD-tree that PCL would need over the thinned points.
void
index(benchmark::State& state, const Pair& pair)
{
  const Cloud::Ptr points = cloudOf(thinned(pair).points);
  measure(
      state,
      [&] { benchmark::DoNotOptimize(PatchIndex(pair.source_scan.patches, pair.source_scan.index.voxel())); },
      countOf(pair.source_scan.patches.size()),
      [&] {
        pcl::KdTreeFLANN<pcl::PointXYZ> tree;
        tree.setInputCloud(points);
        benchmark::DoNotOptimize(&tree);
      });
}

/// Places of the source laid into the target: which patch do they meet? Against PCL's nearest point.
void
lookup(benchmark::State& state, const Pair& pair)
{
  const OrientedSamples moved = transformSamples(pair.source_scan.patches.samples, pair.start);
  const Eigen::Matrix3Xf places = moved.points.cast<float>();
  const Eigen::Matrix3Xf normals = moved.normals.cast<float>();
  const PatchIndex::Tolerance tolerance;
  const ThinnedCloud target = thinScan(viewOfPoints(pair.target), kLeaf, pair.target_scan.origin);
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(cloudOf(target.points));
  const Cloud::Ptr queries = cloudOf(places);
  measure(
      state,
      [&] {
        for (Eigen::Index i = 0; i < places.cols(); ++i)
          benchmark::DoNotOptimize(pair.target_scan.index.find(places.col(i), normals.col(i), tolerance));
      },
      countOf(places.cols()),
      [&] {
        pcl::Indices neighbour(1);
        std::vector<float> squared_distance(1);
        for (const pcl::PointXYZ& query : *queries)
          benchmark::DoNotOptimize(tree.nearestKSearch(query, 1, neighbour, squared_distance));
      });
}

// ---------------------------------------------------------------------------------------------------------------------
// Stages of the default profile: search and refinement

std::vector<RotationCandidate>
proposeMergedRotations(const Pair& pair)
{
  RotationOptions rotation;
  rotation.angle_tolerance = kDirectionError;
  rotation.merge_angle = kDirectionError;
  rotation.refit_angle = kDirectionError;
  return proposeRotations(pair.source_scan.main_normals, pair.target_scan.main_normals, rotation);
}

void
rotations(benchmark::State& state, const Pair& pair)
{
  measure(
      state,
      [&] { benchmark::DoNotOptimize(proposeMergedRotations(pair)); },
      pair.source_scan.main_normals.size() * pair.target_scan.main_normals.size());
}

/// All translations under one rotation.
void
translations(benchmark::State& state, const Pair& pair)
{
  const PatchScan& s = pair.source_scan;
  const PatchScan& t = pair.target_scan;
  const Eigen::Matrix3d R = proposeMergedRotations(pair).at(0).R_target_source;
  measure(
      state,
      [&] {
        benchmark::DoNotOptimize(searchTranslations(s.patches.samples,
                                                    s.votes,
                                                    t.patches.samples,
                                                    t.main_normals,
                                                    t.index,
                                                    t.range_image.empty() ? nullptr : &t.range_image,
                                                    R,
                                                    PoseSearchOptions()));
      },
      1);
}

/// One pose, the patches that stand for all.
void
coarseRefinement(benchmark::State& state, const Pair& pair)
{
  RefinementOptions options;
  options.match.distance = 0.5F;
  options.final_distance = 0.15;
  options.steps = 6;
  measure(
      state,
      [&] {
        benchmark::DoNotOptimize(refinePatches(pair.source_scan.coarse, pair.target_scan.index, pair.start, options));
      },
      countOf(pair.source_scan.coarse.size()));
}

/// One pose, all patches.
void
fineRefinement(benchmark::State& state, const Pair& pair)
{
  RefinementOptions options;
  options.match.distance = 0.2F;
  options.final_distance = 0.05;
  options.steps = 15;
  options.min_step = 5e-4;
  measure(
      state,
      [&] {
        benchmark::DoNotOptimize(refinePatches(pair.source_scan.patches, pair.target_scan.index, pair.start, options));
      },
      countOf(pair.source_scan.patches.size()));
}

/// Evidence for and against one pose, one way.
void
visibilityScore(benchmark::State& state, const Pair& pair)
{
  measure(
      state,
      [&] {
        benchmark::DoNotOptimize(
            collectEvidence(pair.source_scan.patches.samples,
                            pair.target_scan.index,
                            pair.target_scan.range_image.empty() ? nullptr : &pair.target_scan.range_image,
                            pair.start,
                            VisibilityOptions()));
      },
      countOf(pair.source_scan.patches.size()));
}

void
polish(benchmark::State& state, const Pair& pair)
{
  RefinementOptions options;
  options.match.distance = 0.3F;
  options.final_distance = 0.1;
  options.steps = 30;
  const PatchScan& s = pair.source_scan;
  const PatchScan& t = pair.target_scan;
  measure(
      state,
      [&] {
        benchmark::DoNotOptimize(refineMutual({s.surface, s.index}, {t.surface, t.index}, pair.start, options));
      },
      countOf(s.surface.points.cols() + t.surface.points.cols()));
}

// ---------------------------------------------------------------------------------------------------------------------
// Stages of the paper's profile

/// Radius r of the paper's normals in the hall, and their spacing [m].
NormalOptions
paperNormals()
{
  NormalOptions options;
  options.radius = 0.3;
  options.leaf = 0.1;
  return options;
}

/// Against PCL's normals of all raw points with the same radius.
void
paperNormalEstimation(benchmark::State& state, const Pair& pair)
{
  const Cloud::Ptr cloud = cloudOf(pair.source);
  measure(
      state,
      [&] { benchmark::DoNotOptimize(estimateNormals(viewOfPoints(pair.source), paperNormals(), true)); },
      cloud->size(),
      [&] { estimateNormalsWithPcl(cloud, paperNormals().radius); });
}

void
paperDensityFilter(benchmark::State& state, const Pair& pair)
{
  const DirectionSet sphere =
      makeGaussianSphere(estimateNormals(viewOfPoints(pair.source), paperNormals(), true).samples);
  const DensityOptions options;
  measure(
      state,
      [&] { benchmark::DoNotOptimize(findDensestRegions(sphere, computeDensity(sphere, options), options)); },
      countOf(sphere.size()));
}

void
paperMeanShift(benchmark::State& state, const Pair& pair)
{
  const DirectionSet sphere =
      makeGaussianSphere(estimateNormals(viewOfPoints(pair.source), paperNormals(), true).samples);
  const DensityOptions options;
  const std::vector<DenseRegion> regions = findDensestRegions(sphere, computeDensity(sphere, options), options);
  measure(
      state,
      [&] { benchmark::DoNotOptimize(findMainNormals(sphere, regions, MeanShiftOptions())); },
      countOf(sphere.size()));
}

/// Two histograms along one axis, their correlation and its peak.
void
paperCorrelation(benchmark::State& state, const Pair& pair)
{
  const OrientedSamples source = estimateNormals(viewOfPoints(pair.source), paperNormals(), true).samples;
  const OrientedSamples target = estimateNormals(viewOfPoints(pair.target), paperNormals(), true).samples;
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  measure(
      state,
      [&] {
        const AxisHistogram s = clipHistogram(projectOnAxis(source, axis, HistogramOptions()), HistogramOptions());
        const AxisHistogram t = clipHistogram(projectOnAxis(target, axis, HistogramOptions()), HistogramOptions());
        benchmark::DoNotOptimize(findPeaks(subtractMedianEnvelope(correlate(s, t), 10), CorrelationOptions()));
      },
      countOf(source.size() + target.size()));
}

// ---------------------------------------------------------------------------------------------------------------------
// Whole registrations

/// Against PCL's normals of both raw clouds, one thread each.
void
wholeRegistration(benchmark::State& state, const Pair& pair, Profile profile, unsigned threads)
{
  Options options = makeOptions(profile);
  options.threads = threads;
  const Cloud::Ptr source = cloudOf(pair.source);
  const Cloud::Ptr target = cloudOf(pair.target);
  const auto run = [&] {
    const auto [s, t] = prepareScans(viewOfPoints(pair.source), viewOfPoints(pair.target), options);
    benchmark::DoNotOptimize(registerScans(s, t, options));
  };
  if (threads > 1)
    return measure(state, run, source->size() + target->size());
  measure(state, run, source->size() + target->size(), [&] {
    estimateNormalsWithPcl(source, 0);
    estimateNormalsWithPcl(target, 0);
  });
}

void
fastGlobalRegistration(benchmark::State& state, const Pair& pair)
{
  measure(
      state,
      [&] {
        benchmark::DoNotOptimize(baselines::registerFastGlobal(
            viewOfPoints(pair.source), viewOfPoints(pair.target), baselines::FastGlobalOptions()));
      },
      countOf(pair.source.cols() + pair.target.cols()));
}

// ---------------------------------------------------------------------------------------------------------------------

using Stage = void (*)(benchmark::State&, const Pair&);

void
add(const std::string& name,
    Pairs& pairs,
    const std::function<void(benchmark::State&, const Pair&)>& stage,
    std::int64_t largest)
{
  auto* registered = benchmark::RegisterBenchmark(
      name.c_str(), [&pairs, stage](benchmark::State& state) { stage(state, pairs.of(state.range(0))); });
  for (const std::int64_t size : kSizes)
    if (size <= largest)
      registered->Arg(size);
  registered->Unit(benchmark::kMillisecond)->UseRealTime();
}

void
addAll(Pairs& pairs)
{
  constexpr std::int64_t kAll = kSizes[2];
  const std::pair<const char*, Stage> stages[] = {
      {"thinning", thinning},
      {"range_image", rangeImage},
      {"patches", patches},
      {"main_normals", mainNormals},
      {"index", index},
      {"lookup", lookup},
      {"rotations", rotations},
      {"translations", translations},
      {"coarse_refinement", coarseRefinement},
      {"fine_refinement", fineRefinement},
      {"visibility_score", visibilityScore},
      {"polish", polish},
  };
  for (const auto& [name, stage] : stages)
    add(name, pairs, stage, kAll);
  const std::pair<const char*, Stage> paper_stages[] = {
      {"paper_normals", paperNormalEstimation},
      {"paper_density_filter", paperDensityFilter},
      {"paper_mean_shift", paperMeanShift},
      {"paper_correlation", paperCorrelation},
  };
  for (const auto& [name, stage] : paper_stages)
    add(name, pairs, stage, kLargestForPaper);
  const auto whole = [](Profile profile, unsigned threads) {
    return [profile, threads](benchmark::State& state, const Pair& pair) {
      wholeRegistration(state, pair, profile, threads);
    };
  };
  add("registration", pairs, whole(Profile::Default, 1), kLargestForPaper);
  add("registration_2_threads", pairs, whole(Profile::Default, 2), kAll);
  add("paper_registration", pairs, whole(Profile::Paper2017, 1), kLargestForFgr);
  add("fast_global_registration", pairs, fastGlobalRegistration, kLargestForFgr);
}

} // namespace

int
main(int argc, char** argv)
{
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 2;
  Pairs pairs;
  addAll(pairs);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
