// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/benchmark_results.h>
#include <apps/benchmark/report_pictures.h>
#include <apps/common/random_stream.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace testing {

/// Names that break a page that does not escape them; the last is no UTF-8.
inline const std::vector<std::string>&
hostileNames()
{
  static const std::vector<std::string> names{"</script><script>window.broken=1</script>",
                                              "<img src=x onerror=\"window.broken=1\">",
                                              "\"quotes\" & 'quotes' &lt; \\ \\u003c",
                                              "<!-- @@data@@ -->",
                                              "__proto__",
                                              "tab\there \xe2\x80\xa8 \xc3\xa4\xc3\xb6",
                                              "no \xff\xfe text"};
  return names;
}

struct MadeUpRun {
  std::vector<std::string> datasets{"apartment", "office_floor"};
  std::vector<std::string> methods{"ssfr", "ssfr_icp", "icp_point_to_plane", "gicp", "ndt", "fpfh_ransac", "fgr"};
  std::vector<double> resolutions{0};
  std::size_t pairs = 20;
  bool also_mirrored = false; ///< all once more with mirrored sources
  apps::Perturbation perturbation = apps::Perturbation::Rotation;
};

inline Eigen::Isometry3d
randomPose(RandomStream& random, double metres)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  for (int axis = 0; axis < 3; ++axis)
    T.translation()[axis] = random.uniform(-metres, metres);
  return T;
}

inline Eigen::Isometry3d
truthOfPair(std::size_t pair)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(0.3 + 0.1 * static_cast<double>(pair), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << 1.5, -0.7, 0.1;
  return T;
}

/// Rows as a run might write them: every kind of end, unknown values, methods of different quality.
inline std::vector<apps::ResultRow>
makeUpRows(const MadeUpRun& run)
{
  std::vector<apps::ResultRow> rows;
  for (std::size_t d = 0; d < run.datasets.size(); ++d)
    for (const double resolution : run.resolutions)
      for (std::size_t pair = 0; pair < run.pairs; ++pair)
        for (std::size_t m = 0; m < run.methods.size(); ++m) {
          RandomStream random(17 * m + 5, 1000 * d + static_cast<std::uint64_t>(100 * resolution), pair);
          apps::ResultRow row;
          row.dataset = run.datasets[d];
          row.pair = pair;
          row.source = "scan_" + std::to_string(pair + 1) + ".pcd";
          row.target = "scan_" + std::to_string(pair) + ".pcd";
          row.method = run.methods[m];
          row.variation.resolution_m = resolution;
          row.variation.perturbation = run.perturbation;
          row.time_s = (0.2 + 0.6 * static_cast<double>(m)) * std::exp(0.4 * random.gaussian());
          row.cpu_s = 1.4 * row.time_s;
          row.peak_rss_mib = 80 + 15 * static_cast<double>(m);
          row.overlap = random.uniform(0.3, 0.9);
          row.gt_rmse_m = 0.012;
          Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
          if (run.perturbation != apps::Perturbation::None) {
            RandomStream motion(3, d, pair); // the same for each method
            start.linear() = motion.rotation();
          }
          const Eigen::Isometry3d truth = truthOfPair(pair) * start.inverse();
          row.truth = truth;
          const double luck = random.uniform();
          const double skill = 0.97 - 0.11 * static_cast<double>(m) - 0.3 * resolution;
          if (luck > 0.97) {
            row.status = luck > 0.985 ? "crashed" : "timeout";
            row.message = luck > 0.985 ? "signal 11: about to fall" : "killed after 300 s";
          }
          else if (luck < skill) {
            row.status = "converged";
            row.converged = row.success = true;
            row.rotation_error_deg = 0.1 * std::exp(0.5 * random.gaussian());
            row.translation_error_m = 0.02 * std::exp(0.5 * random.gaussian());
            row.rmse_m = 0.02;
            row.T_target_source = truth;
          }
          else {
            row.converged = luck > 0.6;
            row.status = row.converged ? "converged" : "ambiguous";
            row.message = row.converged ? "" : "two poses explain the scans as well as each other";
            row.T_target_source = randomPose(random, 2);
            row.rotation_error_deg = random.uniform(20, 180);
            row.translation_error_m = random.uniform(0.5, 6);
            row.rmse_m = random.uniform(0.5, 3);
          }
          if (m < 3 && row.T_target_source)
            row.confidence = std::clamp((row.success ? 0.8 : 0.4) + 0.15 * random.gaussian(), 0.0, 1.0);
          rows.push_back(row);
        }
  for (std::size_t i = 0, count = run.also_mirrored ? rows.size() : 0; i < count; ++i) {
    apps::ResultRow row = rows[i];
    row.variation.mirror_source = true;
    row.truth.reset();
    row.success = false;
    rows.push_back(row);
  }
  return rows;
}

/// A room with a table, seen from inside; one wall is missing so that its turn can be seen.
inline apps::ReportCloud
makeUpCloud(std::uint64_t seed)
{
  apps::ReportCloud cloud;
  cloud.origin << 0.4, -0.2, 1.1;
  cloud.step = 1e-3;
  RandomStream random(seed);
  for (int i = 0; i < 1500; ++i) {
    Eigen::Vector3d p(random.uniform(-3, 3), random.uniform(-2, 2), random.uniform(-1.2, 1.3));
    switch (i % 5) {
    case 0:
      p.x() = -3;
      break;
    case 1:
      p.y() = 2;
      break;
    case 2:
      p.z() = -1.2;
      break;
    case 3:
      p.x() = 3;
      break;
    default:
      p = {1 + p.x() / 6, -1 + p.y() / 5, -0.5};
    }
    for (int axis = 0; axis < 3; ++axis)
      cloud.coordinates.push_back(static_cast<std::int16_t>(std::lround(p[axis] / cloud.step)));
  }
  return cloud;
}

inline apps::ReportPictures
makeUpPictures(const MadeUpRun& run, std::size_t pairs)
{
  apps::ReportPictures pictures;
  for (std::size_t i = 0; i <= pairs; ++i)
    pictures.clouds.push_back(makeUpCloud(i));
  for (const std::string& dataset : run.datasets)
    for (std::size_t i = 0; i < pairs; ++i)
      pictures.pairs.push_back({dataset, i, i + 1, i, truthOfPair(i)});
  return pictures;
}

inline apps::BenchmarkResults
makeUpResults(const MadeUpRun& run)
{
  apps::BenchmarkResults results = apps::summarize(makeUpRows(run), run.datasets, run.methods);
  results.run = {{"date", "2026-01-31 12:00 UTC"},
                 {"machine", "a made up machine, 8 processors, 16 GiB"},
                 {"command", "ssfr_benchmark --dataset apartment office_floor --methods all --out out"}};
  results.settings["version"] = "0.0.0";
  results.settings["perturb"] = apps::toString(run.perturbation);
  results.settings["seed"] = 1;
  results.settings["timeout_s"] = 300;
  results.settings["threads"] = 1;
  results.settings["parameters"] = {{"leaf_share", 0.02}, {"normal_radius", 2.5}};
  for (const std::string& dataset : run.datasets)
    results.settings["datasets"][dataset] = {
        {"viewpoint", "sensor"}, {"success_rotation_deg", 2}, {"success_translation_m", 0.3}};
  return results;
}

/// Hostile names wherever a user's text gets in.
inline apps::BenchmarkResults
makeUpHostileResults()
{
  MadeUpRun run;
  run.datasets = hostileNames();
  run.methods = hostileNames();
  run.pairs = 1;
  std::vector<apps::ResultRow> rows = makeUpRows(run);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string& name = hostileNames()[i % hostileNames().size()];
    rows[i].source = rows[i].target = rows[i].message = name;
    if (!rows[i].converged)
      rows[i].status = name;
  }
  apps::BenchmarkResults results = apps::summarize(rows, run.datasets, run.methods);
  for (const std::string& name : hostileNames()) {
    results.settings["datasets"][name] = {{"viewpoint", name}};
    results.settings["external"][name] = name;
  }
  results.run = {{"date", hostileNames()[0]}, {"machine", hostileNames()[1]}, {"command", hostileNames()[0]}};
  return results;
}

} // namespace testing
} // namespace pcl_ssfr
