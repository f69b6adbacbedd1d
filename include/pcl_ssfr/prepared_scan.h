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
  /// An empty one.
  PreparedScan() = default;
  /// Made by prepareScan(); not for users.
  explicit PreparedScan(std::shared_ptr<const PreparedData> data) : data_(std::move(data)) {}

  /// Whether it holds no scan: it was default-constructed, not returned by prepareScan().
  bool
  empty() const
  {
    return !data_;
  }
  /// False when it is empty, or when the deadline passed before it was ready: registerScans() then just reports so.
  bool
  isComplete() const;
  /// Whether prepareScan() with \p options would give the same for the same points; false when it is empty.
  bool
  isPreparedWith(const Options& options) const;
  /// What the stages need; not for users. Must not be empty().
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
 * No scan makes it fail: the Result::status of a registration says that one is empty or degenerate.
 * \param[in] scan borrowed until this returns
 * \param[in] options the same as for registerScans(); time_limit is not read here
 * \param[in] deadline when it passes before the end, the scan is not complete
 * \return the prepared scan, independent of the memory of \p scan
 * \throw std::invalid_argument when \p options are out of range
 */
PCL_SSFR_EXPORT PreparedScan
prepareScan(const ScanView& scan, const Options& options, const Deadline& deadline = Deadline());

/** \brief prepareScan() for both scans of a pair; at the same time where Options::threads allows it.
 * \param[in] source,target borrowed until this returns
 * \param[in] options the same as for registerScans(); time_limit is not read here
 * \param[in] deadline when it passes before the end, one or both scans are not complete
 * \return source and target, the same bits as prepareScan() gives
 * \throw std::invalid_argument when \p options are out of range
 */
PCL_SSFR_EXPORT std::pair<PreparedScan, PreparedScan>
prepareScans(const ScanView& source,
             const ScanView& target,
             const Options& options,
             const Deadline& deadline = Deadline());

} // namespace pcl_ssfr
