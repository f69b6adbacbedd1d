// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Time of a whole registration against two yardsticks of PCL on the same raw clouds, in the same run; and how the time
// of each stage grows with the number of points. See `speed_ratio --help`.

#include "cloud_views.h"
#include "common/angles.h"
#include "scan_loader.h"
#include "scan_views.h"
#include "synthetic_scene.h"
#include "timing.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/io/dataset_folder.h>

#include <pcl/features/normal_3d_omp.h>
#include <pcl/registration/icp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ssfr;
using benchmarks::median;
using benchmarks::medianSeconds;
using testing::viewOfCloud;
using testing::viewOfPoints;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using NormalCloud = pcl::PointCloud<pcl::PointNormal>;

constexpr int kNeighbours = 20; // of PCL's normal estimation

const char* const kUsage =
    "usage: speed_ratio [options] DATASET...     ratios to PCL's normal estimation and point-to-plane ICP\n"
    "       speed_ratio --scaling [options]      time per stage against the number of points\n"
    "  --threads N      for the registration and the normal estimation (default 2; PCL's ICP has one)\n"
    "  --runs N         each time is the median of so many runs (default 3)\n"
    "  --pairs N        pairs of each dataset, evenly spread over pairs.csv (default 3)\n"
    "  --paper          Profile::Paper2017 instead of the default profile\n"
    "  --no-long-icp    leave out the ICP of up to 50 iterations\n"
    "  --with-paper     time of Profile::Paper2017 over that of the default profile too (one run)\n"
    "  --max-points N   largest cloud of --scaling (default 10000000)\n";

struct Settings {
  unsigned threads = 2;
  int runs = 3;
  int pairs = 3;
  bool paper = false;
  bool long_icp = true;
  bool with_paper = false;
  bool scaling = false;
  double max_points = 1e7;
  std::vector<std::string> datasets;
};

Settings
parse(int argc, char** argv)
{
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto number = [&] {
      if (++i >= argc)
        throw std::invalid_argument(argument + " needs a value");
      const double value = std::stod(argv[i]);
      if (!(value >= 1))
        throw std::invalid_argument(argument + " must be at least 1");
      return value;
    };
    if (argument == "--threads")
      settings.threads = static_cast<unsigned>(number());
    else if (argument == "--runs")
      settings.runs = static_cast<int>(number());
    else if (argument == "--pairs")
      settings.pairs = static_cast<int>(number());
    else if (argument == "--paper")
      settings.paper = true;
    else if (argument == "--no-long-icp")
      settings.long_icp = false;
    else if (argument == "--with-paper")
      settings.with_paper = true;
    else if (argument == "--scaling")
      settings.scaling = true;
    else if (argument == "--max-points")
      settings.max_points = number();
    else if (argument.rfind("--", 0) == 0)
      throw std::invalid_argument("unknown option " + argument);
    else
      settings.datasets.push_back(argument);
  }
  if (settings.scaling != settings.datasets.empty())
    throw std::invalid_argument("give dataset folders, or --scaling");
  return settings;
}

Result
registerPair(const ScanView& source, const ScanView& target, const Options& options)
{
  const auto [prepared_source, prepared_target] = prepareScans(source, target, options);
  return registerScans(prepared_source, prepared_target, options);
}

/// PCL's normals from 20 neighbours.
pcl::PointCloud<pcl::Normal>
estimateNormalsWithPcl(const Cloud::Ptr& cloud, unsigned threads)
{
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> estimation(threads);
  estimation.setInputCloud(cloud);
  estimation.setKSearch(kNeighbours);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  return normals;
}

/// Points with a normal.
NormalCloud::Ptr
joined(const Cloud& cloud, const pcl::PointCloud<pcl::Normal>& normals)
{
  auto out = pcl::make_shared<NormalCloud>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!std::isfinite(normals[i].normal_x))
      continue;
    pcl::PointNormal point;
    point.getVector3fMap() = cloud[i].getVector3fMap();
    point.getNormalVector3fMap() = normals[i].getNormalVector3fMap();
    out->push_back(point);
  }
  return out;
}

/// Time of align() of PCL's point-to-plane ICP from identity; its normals are given.
double
timeIcp(const NormalCloud::Ptr& source, const NormalCloud::Ptr& target, int iterations, int runs)
{
  return medianSeconds(runs, [&] {
    pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
    icp.setMaximumIterations(iterations);
    icp.setInputSource(source);
    icp.setInputTarget(target);
    NormalCloud moved;
    icp.align(moved);
  });
}

/// The times of one pair [s].
struct PairTimes {
  double points = 0; ///< of both clouds
  double registration = 0;
  double one_thread = 0;  ///< of the registration
  double unavoidable = 0; ///< of that, thinning and patches (paper's profile: normals) of both scans
  double paper = 0;       ///< registration by the paper's profile
  double normals = 0;
  double icp_10 = 0;
  double icp_50 = 0;
  bool solved = false; ///< within 2 degrees and 0.3 m of the truth, so that speed is not bought by failing
};

/// Seconds of the stages of a registration that no method on thinned planar patches can leave out, both scans.
double
unavoidableSeconds(const Result& result)
{
  double seconds = 0;
  for (const StageReport& stage : result.stages)
    for (const char* name : {"source thinning", "source patches", "source_normals"})
      if (stage.name == name || stage.name == "target" + std::string(name).substr(std::string("source").size()))
        seconds += stage.seconds;
  return seconds;
}

PairTimes
timePair(const std::string& folder, const io::ScanPair& pair, const Options& options, const Settings& settings)
{
  const Cloud::Ptr source = benchmarks::loadScan(folder, pair.source);
  const Cloud::Ptr target = benchmarks::loadScan(folder, pair.target);
  PairTimes times;
  times.points = static_cast<double>(source->size() + target->size());
  Result result;
  times.registration =
      medianSeconds(settings.runs, [&] { result = registerPair(viewOfCloud(*source), viewOfCloud(*target), options); });
  Options other = options;
  other.threads = 1;
  std::vector<double> unavoidable;
  times.one_thread = medianSeconds(settings.runs, [&] {
    unavoidable.push_back(unavoidableSeconds(registerPair(viewOfCloud(*source), viewOfCloud(*target), other)));
  });
  times.unavoidable = median(unavoidable);
  if (settings.with_paper) {
    other = makeOptions(Profile::Paper2017);
    other.threads = options.threads;
    times.paper = medianSeconds(1, [&] { registerPair(viewOfCloud(*source), viewOfCloud(*target), other); });
  }
  const Eigen::Isometry3d error = result.T_target_source.inverse() * pair.T_target_source;
  times.solved = Eigen::AngleAxisd(error.linear()).angle() < 2 * kDegree && error.translation().norm() < 0.3;

  pcl::PointCloud<pcl::Normal> source_normals;
  pcl::PointCloud<pcl::Normal> target_normals;
  times.normals = medianSeconds(settings.runs, [&] {
    source_normals = estimateNormalsWithPcl(source, settings.threads);
    target_normals = estimateNormalsWithPcl(target, settings.threads);
  });
  const NormalCloud::Ptr icp_source = joined(*source, source_normals);
  const NormalCloud::Ptr icp_target = joined(*target, target_normals);
  times.icp_10 = timeIcp(icp_source, icp_target, 10, settings.runs);
  if (settings.long_icp)
    times.icp_50 = timeIcp(icp_source, icp_target, 50, 1);
  return times;
}

/// Name of a folder, also when it ends in a slash.
std::string
folderName(const std::string& folder)
{
  const std::filesystem::path path = std::filesystem::path(folder).lexically_normal();
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
}

void
printRatios(const Settings& settings, const Options& options)
{
  std::printf(
      "Whole registration (thinning, patches or normals included), %s profile, %u threads, against PCL's\n"
      "NormalEstimationOMP (%d neighbours, %u threads, both clouds) and the align() of its\n"
      "IterativeClosestPointWithNormals from identity (one thread, normals given; at most 10 iterations, PCL's\n"
      "default, and at most 50). Unavoidable: thinning and patches of both scans with one thread; the whole with one\n"
      "thread is divided by it. Medians of %d runs (ICP of 50, paper: one run), then over the pairs of the set.\n\n",
      settings.paper ? "paper" : "default",
      settings.threads,
      kNeighbours,
      settings.threads,
      settings.runs);
  std::printf("| set | pairs (solved) | points | registration [s] | normals [s] | ICP 10 [s] | ICP 50 [s] | "
              "registration / normals | registration / ICP 10 | registration / ICP 50 | one thread / unavoidable | "
              "one thread / %u threads | paper2017 / registration |\n"
              "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
              settings.threads);
  for (const std::string& folder : settings.datasets) {
    const std::vector<io::ScanPair> pairs = io::readDatasetFolder(folder).pairs;
    const std::size_t count = std::min(pairs.size(), static_cast<std::size_t>(settings.pairs));
    std::vector<PairTimes> times;
    for (std::size_t i = 0; i < count; ++i)
      times.push_back(timePair(folder, pairs[i * pairs.size() / count], options, settings));
    if (times.empty())
      continue;
    const auto over_pairs = [&times](const std::function<double(const PairTimes&)>& value) {
      std::vector<double> values;
      values.reserve(times.size());
      for (const PairTimes& pair : times)
        values.push_back(value(pair));
      return median(values);
    };
    const auto solved = std::count_if(times.begin(), times.end(), [](const PairTimes& t) { return t.solved; });
    std::printf("| %s | %zu (%d) | %.0f | %.3f | %.3f | %.2f | %.2f | %.2f | %.4f | %.4f | %.2f | %.2f | ",
                folderName(folder).c_str(),
                times.size(),
                static_cast<int>(solved),
                over_pairs([](const PairTimes& t) { return t.points; }),
                over_pairs([](const PairTimes& t) { return t.registration; }),
                over_pairs([](const PairTimes& t) { return t.normals; }),
                over_pairs([](const PairTimes& t) { return t.icp_10; }),
                over_pairs([](const PairTimes& t) { return t.icp_50; }),
                over_pairs([](const PairTimes& t) { return t.registration / t.normals; }),
                over_pairs([](const PairTimes& t) { return t.registration / t.icp_10; }),
                over_pairs([](const PairTimes& t) { return t.icp_50 > 0 ? t.registration / t.icp_50 : 0.0; }),
                over_pairs([](const PairTimes& t) { return t.unavoidable > 0 ? t.one_thread / t.unavoidable : 0.0; }),
                over_pairs([](const PairTimes& t) { return t.one_thread / t.registration; }));
    if (settings.with_paper)
      std::printf("%.1f |\n", over_pairs([](const PairTimes& t) { return t.paper / t.registration; }));
    else
      std::printf("- |\n");
    std::fflush(stdout);
  }
}

/// Seconds of each stage at one size.
struct SizeTimes {
  double points = 0; ///< of both clouds
  std::vector<StageReport> stages;
};

/// The same stages, with names that differ: those of a second search pass, or of poses that had few votes, are
/// numbered.
std::vector<StageReport>
namedApart(std::vector<StageReport> stages)
{
  for (std::size_t i = stages.size(); i-- > 0;) {
    const std::string& name = stages[i].name;
    const auto before = std::count_if(stages.begin(),
                                      stages.begin() + static_cast<std::ptrdiff_t>(i),
                                      [&name](const StageReport& other) { return other.name == name; });
    if (before > 0)
      stages[i].name += " " + std::to_string(before + 1);
  }
  return stages;
}

/// Slope of log(seconds) over log(points), least squares.
double
growthExponent(const std::vector<double>& points, const std::vector<double>& seconds)
{
  const auto n = static_cast<Eigen::Index>(points.size());
  const Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(points.data(), n).log();
  const Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(seconds.data(), n).log();
  return ((x - x.mean()) * (y - y.mean())).sum() / (x - x.mean()).square().sum();
}

void
printScaling(const Settings& settings, const Options& options)
{
  constexpr double kMinPoints = 1e4;
  constexpr double kMinSeconds = 1e-3; // shorter times say nothing about growth
  const testing::Scene scene = testing::makeHall(2);
  std::vector<SizeTimes> sizes;
  for (double wanted = kMinPoints; wanted <= 1.01 * settings.max_points; wanted *= std::sqrt(10.0)) {
    testing::SensorPattern pattern = testing::terrestrialScanner();
    pattern.azimuth_step = std::sqrt(2 * kPi * (pattern.elevation_max - pattern.elevation_min) / wanted);
    pattern.elevation_step = pattern.azimuth_step;
    const Eigen::Matrix3Xf target =
        testing::castScan(scene, testing::sensorPose(scene.stations[0], 0.1, 0), pattern, 1);
    const Eigen::Matrix3Xf source =
        testing::castScan(scene, testing::sensorPose(scene.stations[1], 1.9, 0.05), pattern, 2);
    SizeTimes size;
    size.points = static_cast<double>(source.cols() + target.cols());
    std::vector<std::vector<double>> seconds;
    std::vector<double> total;
    std::vector<double> preparation;
    for (int run = 0; run < settings.runs; ++run) {
      Result result;
      PreparedScan prepared_source;
      PreparedScan prepared_target;
      preparation.push_back(medianSeconds(1, [&] {
        std::tie(prepared_source, prepared_target) = prepareScans(viewOfPoints(source), viewOfPoints(target), options);
      }));
      const double registration =
          medianSeconds(1, [&] { result = registerScans(prepared_source, prepared_target, options); });
      total.push_back(preparation.back() + registration);
      size.stages = namedApart(result.stages);
      seconds.resize(result.stages.size());
      for (std::size_t i = 0; i < result.stages.size(); ++i)
        seconds[i].push_back(result.stages[i].seconds);
    }
    for (std::size_t i = 0; i < size.stages.size(); ++i)
      size.stages[i].seconds = median(seconds[i]);
    StageReport report;
    report.name = "(preparation of both scans)";
    report.seconds = median(preparation);
    size.stages.push_back(report);
    report.name = "(whole registration)";
    report.seconds = median(total);
    size.stages.push_back(report);
    sizes.push_back(size);
    std::fprintf(stderr, "%.0f points: %.3f s\n", size.points, report.seconds);
  }

  std::printf(
      "One pair of scans of a hall, simulated ever more densely; %s profile, %u threads, medians of %d runs.\n"
      "Growth: exponent of time over points, from the sizes at which the stage takes a millisecond or more.\n\n",
      settings.paper ? "paper" : "default",
      settings.threads,
      settings.runs);
  std::printf("| stage \\ points of both scans |");
  for (const SizeTimes& size : sizes)
    std::printf(" %.3g |", size.points);
  std::printf(" growth | growth, last ten-fold |\n|---|");
  for (std::size_t i = 0; i <= sizes.size() + 1; ++i)
    std::printf("---|");
  std::printf("\n");
  for (std::size_t i = 0; i < sizes.back().stages.size(); ++i) {
    std::printf("| %s |", sizes.back().stages[i].name.c_str());
    std::vector<double> points;
    std::vector<double> seconds;
    for (const SizeTimes& size : sizes) {
      // Small clouds may end early, with fewer stages.
      const auto stage = std::find_if(size.stages.begin(), size.stages.end(), [&](const StageReport& report) {
        return report.name == sizes.back().stages[i].name;
      });
      if (stage == size.stages.end()) {
        std::printf(" - |");
        continue;
      }
      std::printf(" %.4f |", stage->seconds);
      if (stage->seconds >= kMinSeconds) {
        points.push_back(size.points);
        seconds.push_back(stage->seconds);
      }
    }
    constexpr std::ptrdiff_t kTenFold = 3; // sizes, a factor of sqrt(10) apart
    for (const bool last : {false, true}) {
      if (points.size() < 3)
        std::printf(" - |");
      else if (last)
        std::printf(" %.2f |",
                    growthExponent({points.end() - kTenFold, points.end()}, {seconds.end() - kTenFold, seconds.end()}));
      else
        std::printf(" %.2f |", growthExponent(points, seconds));
    }
    std::printf("\n");
  }
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    if (argc == 2 && std::string(argv[1]) == "--help") {
      std::cout << kUsage;
      return 0;
    }
    const Settings settings = parse(argc, argv);
    Options options = makeOptions(settings.paper ? Profile::Paper2017 : Profile::Default);
    options.threads = settings.threads;
    if (settings.scaling)
      printScaling(settings, options);
    else
      printRatios(settings, options);
  }
  catch (const std::invalid_argument& error) {
    std::cerr << "speed_ratio: " << error.what() << '\n' << kUsage;
    return 2;
  }
  catch (const std::exception& error) {
    std::cerr << "speed_ratio: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
