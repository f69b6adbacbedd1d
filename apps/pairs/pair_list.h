// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/dataset_folder.h>
#include <apps/pairs/pair_input.h>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// Two scans that a run registers, by their file names.
struct ListedPair {
  std::string source;
  std::string target;
  std::optional<Eigen::Isometry3d> T_target_source; ///< ground truth; none: not known, or no pose is right
};

/** \brief The pairs of a dataset that a run may choose from. The truth of pairs that are not listed is that of the
 * shortest chain of listed pairs, none where no chain connects them.
 * \param[in] targets the dataset that the targets are from: another for PairsFrom::Unrelated, else the same
 */
class PairList {
public:
  PairList(const io::DatasetFolder& dataset, const io::DatasetFolder& targets, PairsFrom from);

  std::size_t
  size() const
  {
    return pairs_.size();
  }
  const ListedPair&
  operator[](std::size_t i) const
  {
    return pairs_[i];
  }

  /** \brief All that decides the input of a pair under a variation, whose pairs_from is that of the list.
   * \param[in] seed of the run; that of the request depends on it and on the names of dataset and scans alone
   * \return nothing where Variation::merge_target finds no other scan with a known pose in the target
   */
  std::optional<PairRequest>
  request(std::size_t i, const Variation& variation, std::uint64_t seed) const;

private:
  std::optional<PosedScan>
  otherInTarget(std::size_t i) const;

  std::string name_; ///< of the dataset
  std::string source_folder_;
  std::string target_folder_;
  bool sensor_at_origin_;
  std::vector<ListedPair> pairs_;
  std::vector<ListedPair> merge_from_; ///< pairs of the targets' dataset, empty: those of the list
};

} // namespace apps
} // namespace pcl_ssfr
