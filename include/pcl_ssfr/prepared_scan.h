// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/options.h>
#include <pcl_ssfr/result.h>
#include <pcl_ssfr/scan_view.h>

#include <memory>
#include <utility>

namespace pcl_ssfr {

struct PreparedData; // what the stages need of one scan; internal to the core

/** \brief One scan made ready for registration: samples, main normals, and what the search looks up.
 *
 * A value: cheap to copy (shared, immutable), safe to use from many threads, reusable for any number of partners.
 */
class PCL_SSFR_EXPORT PreparedScan {
public:
  PreparedScan() = default;
  explicit PreparedScan(std::shared_ptr<const PreparedData> data) : data_(std::move(data)) {}

  bool
  empty() const
  {
    return !data_;
  }
  /// False when it is empty, or when time ran out before it was ready: registerScans() then only reports that.
  bool
  isComplete() const;
  /// Whether it is what prepareScan() would give with \p options, as long as the points have not changed; false when it
  /// is empty.
  bool
  isPreparedWith(const Options& options) const;
  /// Only when it is not empty.
  const PreparedData&
  data() const
  {
    return *data_;
  }

private:
  std::shared_ptr<const PreparedData> data_;
};

/** \brief Stages 1 to 5 for one scan: centre, sample, normals or patches, Gaussian sphere, densities, main normals.
 *
 * Never fails on data: a scan that is empty or degenerate gives a prepared scan that registers as such.
 * \param[in] deadline when it passes meanwhile the scan is not complete; Options::time_limit is not read here
 * \throw std::invalid_argument when \p options are out of range.
 */
PCL_SSFR_EXPORT PreparedScan
prepareScan(const ScanView& scan, const Options& options, const Deadline& deadline = Deadline());

/** \brief prepareScan() for both scans of a pair; at the same time where options.threads allows it.
 * \return source and target, the same bits as prepareScan() gives \throw std::invalid_argument as prepareScan()
 */
PCL_SSFR_EXPORT std::pair<PreparedScan, PreparedScan>
prepareScans(const ScanView& source,
             const ScanView& target,
             const Options& options,
             const Deadline& deadline = Deadline());

} // namespace pcl_ssfr
