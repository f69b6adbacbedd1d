// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/benchmark_options.h>
#include <apps/benchmark/worker.h>
#include <apps/io/dataset_folder.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A pair under one variation, on which every method is run.
struct PlannedPair {
  std::size_t dataset = 0;    ///< index into BenchmarkPlan::datasets
  std::size_t pair = 0;       ///< row of its pairs.csv, or of the PairList that was asked for
  std::string source;         ///< file name
  std::string target;         ///< file name
  std::string target_dataset; ///< name, where it is another
  PairRequest request;
};

/// All that a run will do; made and checked before any work starts.
struct BenchmarkPlan {
  std::vector<io::DatasetFolder> datasets;
  std::vector<BenchmarkMethod> methods;
  std::vector<PlannedPair> pairs; ///< in the order of datasets, variations and rows
  RunSettings run;
  bool candidates = false;         ///< write candidates.csv
  nlohmann::ordered_json settings; ///< what results depend on; results of other settings are not mixed with them

  std::string
  key(std::size_t pair, std::size_t method) const
  {
    const PlannedPair& planned = pairs[pair];
    return rowKeyOf(planned, methods[method].name);
  }

private:
  std::string
  rowKeyOf(const PlannedPair& planned, const std::string& method) const;
};

/** \brief Read dataset folders and name them as their results are named: where several give themselves the same name,
 * those go by the names of their folders; in UTF-8.
 * \throw UsageError when two have the same name all the same, io::IoError
 */
std::vector<io::DatasetFolder>
readDatasets(const std::vector<std::string>& paths);

/** \brief Read and check everything that the arguments name.
 * \throw UsageError, io::IoError
 */
BenchmarkPlan
makePlan(const BenchmarkArguments& arguments);

} // namespace apps
} // namespace pcl_ssfr
