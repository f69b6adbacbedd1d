// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Time of a whole registration against Open3D's two global registrations (FPFH with RANSAC, and Fast Global
// Registration) on the same raw clouds, in the same run. See `open3d_ratio --help`.

#include "common/angles.h"
#include "timing.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/io/dataset_folder.h>
#include <apps/io/loaded_cloud.h>
#include <apps/methods/cloud_view.h>
#include <apps/methods/method_parameters.h>

#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/CorrespondenceChecker.h>
#include <open3d/pipelines/registration/FastGlobalRegistration.h>
#include <open3d/pipelines/registration/Feature.h>
#include <open3d/pipelines/registration/Registration.h>
#include <open3d/utility/Logging.h>
#include <open3d/utility/Random.h>

#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ssfr;
using benchmarks::median;
using benchmarks::medianCpuSeconds;
using benchmarks::medianSeconds;
namespace o3d = open3d::pipelines::registration;
using O3dCloud = open3d::geometry::PointCloud;

// What Open3D's own example of global registration takes and what has no length.
constexpr int kNormalNeighbours = 30;
constexpr int kFeatureNeighbours = 100;
constexpr double kEdgeSimilarity = 0.9;
constexpr int kRansacPoints = 3;
constexpr int kRansacIterations = 100000;
constexpr double kRansacConfidence = 0.999;

const char* const kUsage =
    "usage: open3d_ratio [options] DATASET...     ratios to Open3D's FPFH + RANSAC and Fast Global Registration\n"
    "  --threads N      for all of them (default 2)\n"
    "  --runs N         each time is the median of so many runs (default 3)\n"
    "  --pairs N        pairs of each dataset, evenly spread over pairs.csv (default 3)\n"
    "  --cpu            processor time instead of wall clock: for a machine that does other work as well\n";

struct Settings {
  int threads = 2;
  int runs = 3;
  int pairs = 3;
  bool cpu = false;
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
      const int value = std::stoi(argv[i]);
      if (value < 1)
        throw std::invalid_argument(argument + " must be at least 1");
      return value;
    };
    if (argument == "--threads")
      settings.threads = number();
    else if (argument == "--runs")
      settings.runs = number();
    else if (argument == "--pairs")
      settings.pairs = number();
    else if (argument == "--cpu")
      settings.cpu = true;
    else if (argument.rfind("--", 0) == 0)
      throw std::invalid_argument("unknown option " + argument);
    else
      settings.datasets.push_back(argument);
  }
  if (settings.datasets.empty())
    throw std::invalid_argument("give dataset folders");
  return settings;
}

/// A scan thinned, with normals and descriptors, all by Open3D.
struct Described {
  std::shared_ptr<O3dCloud> cloud;
  std::shared_ptr<o3d::Feature> features;
};

O3dCloud
toOpen3d(const ScanView& scan)
{
  O3dCloud cloud;
  for (std::size_t i = 0; i < scan.count(); ++i) {
    if (scan.point(i).allFinite())
      cloud.points_.emplace_back(scan.point(i).cast<double>());
  }
  return cloud;
}

Described
describe(const O3dCloud& cloud, const apps::Scales& scales)
{
  Described described;
  described.cloud = cloud.VoxelDownSample(scales.leaf);
  described.cloud->EstimateNormals(open3d::geometry::KDTreeSearchParamHybrid(scales.normal_radius, kNormalNeighbours));
  described.cloud->OrientNormalsTowardsCameraLocation();
  described.features = o3d::ComputeFPFHFeature(
      *described.cloud, open3d::geometry::KDTreeSearchParamHybrid(scales.feature_radius, kFeatureNeighbours));
  return described;
}

Eigen::Isometry3d
runRansac(const O3dCloud& source, const O3dCloud& target, const apps::Scales& scales)
{
  const Described from = describe(source, scales);
  const Described onto = describe(target, scales);
  const o3d::CorrespondenceCheckerBasedOnEdgeLength edges(kEdgeSimilarity);
  const o3d::CorrespondenceCheckerBasedOnDistance distances(scales.threshold);
  const o3d::RegistrationResult result =
      o3d::RegistrationRANSACBasedOnFeatureMatching(*from.cloud,
                                                    *onto.cloud,
                                                    *from.features,
                                                    *onto.features,
                                                    true,
                                                    scales.threshold,
                                                    o3d::TransformationEstimationPointToPoint(false),
                                                    kRansacPoints,
                                                    {edges, distances},
                                                    {kRansacIterations, kRansacConfidence});
  return Eigen::Isometry3d(Eigen::Matrix4d(result.transformation_));
}

Eigen::Isometry3d
runFgr(const O3dCloud& source, const O3dCloud& target, const apps::Scales& scales)
{
  const Described from = describe(source, scales);
  const Described onto = describe(target, scales);
  o3d::FastGlobalRegistrationOption option;
  option.use_absolute_scale_ = true;
  option.maximum_correspondence_distance_ = scales.threshold;
  const o3d::RegistrationResult result = o3d::FastGlobalRegistrationBasedOnFeatureMatching(
      *from.cloud, *onto.cloud, *from.features, *onto.features, option);
  return Eigen::Isometry3d(Eigen::Matrix4d(result.transformation_));
}

/// One method on one pair.
struct Outcome {
  double seconds = 0;
  bool solved = false;
};

struct PairOutcomes {
  double points = 0; ///< of both clouds
  Outcome ours, ransac, fgr;
};

Outcome
judge(const io::DatasetFolder& folder,
      const io::ScanPair& pair,
      const Settings& settings,
      const std::function<Eigen::Isometry3d()>& method)
{
  Outcome outcome;
  Eigen::Isometry3d found = Eigen::Isometry3d::Identity();
  const auto run = [&] { found = method(); };
  outcome.seconds = settings.cpu ? medianCpuSeconds(settings.runs, run) : medianSeconds(settings.runs, run);
  const Eigen::Isometry3d error = found.inverse() * pair.T_target_source;
  outcome.solved = Eigen::AngleAxisd(error.linear()).angle() <= folder.success_rotation_deg * kDegree &&
                   error.translation().norm() <= folder.success_translation_m;
  return outcome;
}

PairOutcomes
runPair(const io::DatasetFolder& folder, const io::ScanPair& pair, const Settings& settings)
{
  const io::LoadedCloud source_cloud = io::loadCloud(io::scanPath(folder.path, pair.source));
  const io::LoadedCloud target_cloud = io::loadCloud(io::scanPath(folder.path, pair.target));
  const ScanView source = apps::viewOf(source_cloud);
  const ScanView target = apps::viewOf(target_cloud);
  PairOutcomes outcomes;
  outcomes.points = static_cast<double>(source.count() + target.count());

  Options options = makeOptions(Profile::Default);
  options.threads = static_cast<unsigned>(settings.threads);
  outcomes.ours = judge(folder, pair, settings, [&] {
    const auto [prepared_source, prepared_target] = prepareScans(source, target, options);
    return registerScans(prepared_source, prepared_target, options).T_target_source;
  });

  // Open3D is given its leaf and its own type of cloud: neither is on its clock.
  const apps::ParameterRule rule;
  const apps::Scales scales = apps::scalesOf(apps::thinPair(source, target, rule, 1).source.leaf, rule);
  const O3dCloud from = toOpen3d(source);
  const O3dCloud onto = toOpen3d(target);
  omp_set_num_threads(settings.threads);
  open3d::utility::random::Seed(1);
  outcomes.ransac = judge(folder, pair, settings, [&] { return runRansac(from, onto, scales); });
  outcomes.fgr = judge(folder, pair, settings, [&] { return runFgr(from, onto, scales); });
  return outcomes;
}

void
printRatios(const Settings& settings)
{
  std::printf(
      "Whole registration, default profile, against Open3D's FPFH + RANSAC (mutual matches, %d iterations at\n"
      "most) and Fast Global Registration; thinning, normals and descriptors included for all, %d threads.\n"
      "Lengths of Open3D's by the rule of ssfr_benchmark. Medians of %d runs, then over the pairs of the set.\n\n",
      kRansacIterations,
      settings.threads,
      settings.runs);
  std::printf("| set | pairs | points | ssfr [s] (solved) | RANSAC [s] (solved) | FGR [s] (solved) | ssfr / RANSAC | "
              "ssfr / FGR |\n"
              "|---|---|---|---|---|---|---|---|\n");
  for (const std::string& path : settings.datasets) {
    const io::DatasetFolder folder = io::readDatasetFolder(path);
    const std::size_t count = std::min(folder.pairs.size(), static_cast<std::size_t>(settings.pairs));
    std::vector<PairOutcomes> outcomes;
    for (std::size_t i = 0; i < count; ++i)
      outcomes.push_back(runPair(folder, folder.pairs[i * folder.pairs.size() / count], settings));
    if (outcomes.empty())
      continue;
    const auto over_pairs = [&outcomes](const std::function<double(const PairOutcomes&)>& value) {
      std::vector<double> values;
      values.reserve(outcomes.size());
      for (const PairOutcomes& outcome : outcomes)
        values.push_back(value(outcome));
      return median(values);
    };
    const auto solved = [&outcomes](Outcome PairOutcomes::*method) {
      return static_cast<int>(std::count_if(outcomes.begin(), outcomes.end(), [method](const PairOutcomes& outcome) {
        return (outcome.*method).solved;
      }));
    };
    std::printf("| %s | %zu | %.0f | %.3f (%d) | %.3f (%d) | %.3f (%d) | %.3f | %.3f |\n",
                folder.name.c_str(),
                outcomes.size(),
                over_pairs([](const PairOutcomes& o) { return o.points; }),
                over_pairs([](const PairOutcomes& o) { return o.ours.seconds; }),
                solved(&PairOutcomes::ours),
                over_pairs([](const PairOutcomes& o) { return o.ransac.seconds; }),
                solved(&PairOutcomes::ransac),
                over_pairs([](const PairOutcomes& o) { return o.fgr.seconds; }),
                solved(&PairOutcomes::fgr),
                over_pairs([](const PairOutcomes& o) { return o.ours.seconds / o.ransac.seconds; }),
                over_pairs([](const PairOutcomes& o) { return o.ours.seconds / o.fgr.seconds; }));
    std::fflush(stdout);
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
    open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
    printRatios(settings);
  }
  catch (const std::invalid_argument& error) {
    std::cerr << "open3d_ratio: " << error.what() << '\n' << kUsage;
    return 2;
  }
  catch (const std::exception& error) {
    std::cerr << "open3d_ratio: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
