// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/pairs/pair_input.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace apps {

/// One method on one pair: a line of results.csv. NaN: not known, an empty field.
struct ResultRow {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  std::string dataset;
  std::string source; ///< file name
  std::string target; ///< file name
  std::string method;
  std::string status;
  bool converged = false;
  bool success = false; ///< the pose is right by the dataset's bound, whatever the method says of it
  double rotation_error_deg = kUnknown;
  double translation_error_m = kUnknown;
  double rmse_m = kUnknown;     ///< over the correspondences fixed at the ground truth
  double gt_rmse_m = kUnknown;  ///< the same under the ground truth
  double overlap = kUnknown;    ///< share of the source with a counterpart under the ground truth, [0, 1]
  double confidence = kUnknown; ///< of methods that judge their answer, [0, 1]
  double time_s = kUnknown;
  double cpu_s = kUnknown;
  double peak_rss_mib = kUnknown;
  std::string message;
  std::optional<Eigen::Isometry3d> T_target_source; ///< what the method found

  std::size_t pair = 0;            ///< row of pairs.csv, from 0; of the list of pairs that were chosen from
  double found_overlap = kUnknown; ///< as the method measured it
  Variation variation;
  std::uint64_t seed = 0; ///< of the pair, see pairSeed()
  double source_points = kUnknown;
  double target_points = kUnknown;
  std::optional<Eigen::Isometry3d> truth; ///< after the variation; none: no pose is right, or it is not known
  std::string target_dataset;             ///< that the target is from, where it is another
  double right_rank = kUnknown;           ///< place of the first candidate that is right, from 1; unknown: none is
  std::string lost_at;                    ///< stage at which ssfr lost the truth; empty: it did not, or nobody knows
};

/// The first line of results.csv, without its end.
std::string
csvHeader();

/// The row as a line without its end.
std::string
toCsvLine(const ResultRow& row);

/// The row of a line that toCsvLine wrote. \throw std::invalid_argument naming column and value
ResultRow
rowFromCsv(std::string_view line);

/// What makes a row one of its kind: dataset, that of the target, pair, variation and method.
std::string
rowKey(const std::string& dataset,
       const std::string& target_dataset,
       std::size_t pair,
       const Variation& variation,
       const std::string& method);

inline std::string
rowKey(const ResultRow& row)
{
  return rowKey(row.dataset, row.target_dataset, row.pair, row.variation, row.method);
}

} // namespace apps
} // namespace pcl_ssfr
