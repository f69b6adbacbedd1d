// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Writes reports of made-up results below a folder: what report_browser_test.py opens.

#include <apps/benchmark/report_html.h>

#include <made_up_results.h>

#include <filesystem>
#include <iostream>

namespace {

using namespace pcl_ssfr;

void
write(const std::filesystem::path& folder,
      const apps::BenchmarkResults& results,
      const apps::ReportPictures& pictures = {})
{
  std::filesystem::create_directories(folder);
  apps::writeReport(folder.string(), results, pictures);
}

} // namespace

int
main(int argc, char** argv)
{
  if (argc != 2) {
    std::cerr << "made_up_reports: give a folder\n";
    return 2;
  }
  const std::filesystem::path folder(argv[1]);
  write(folder / "usual", testing::makeUpResults({}), testing::makeUpPictures({}, 4));

  testing::MadeUpRun sweep;
  sweep.resolutions = {0.05, 0.1, 0.2, 0.4};
  sweep.also_mirrored = true; // points of no line of the others
  sweep.datasets = {"apartment"};
  sweep.methods = {"ssfr",
                   "ssfr_paper2017",
                   "ssfr_icp",
                   "ssfr_gicp",
                   "ssfr_ndt",
                   "icp_point_to_point",
                   "gicp",
                   "ndt",
                   "fpcs",
                   "kfpcs",
                   "fgr",
                   "fpfh_ransac",
                   "fpfh_sac_ia",
                   "super4pcs",
                   "go_icp"};
  write(folder / "sweep", testing::makeUpResults(sweep), testing::makeUpPictures(sweep, 1));

  write(folder / "hostile", testing::makeUpHostileResults());

  apps::BenchmarkResults empty = apps::summarize({}, {}, {});
  empty.complete = false;
  empty.planned = 12;
  write(folder / "empty", empty);

  testing::MadeUpRun large;
  large.pairs = 10000 / (large.datasets.size() * large.methods.size()) + 1;
  write(folder / "large", testing::makeUpResults(large));
  return 0;
}
