// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/prepared_scan.h>

namespace pcl_ssfr {

/** \brief Global registration of two prepared scans: the pose that maps source points into the target frame.
 *
 * Both must have been prepared with these \p options, of which the preparation reads a part (see
 * PreparedScan::isPreparedWith()); scans of another profile are Status::InvalidInput. Same input, same bits, for any
 * number of threads. When Options::time_limit seconds are over, the status is Status::TimeLimit, and Result holds the
 * best poses so far: what contradicts them may not have been found, nor are they exact. (Profile::Paper2017 ranks what
 * it has.) \param[in] guess optional: refined and judged as one more candidate; never needed, never degrades the answer
 * \throw std::invalid_argument when \p options are out of range. Data never throw: Result::status says what happened.
 */
PCL_SSFR_EXPORT Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess = nullptr);

/** \brief The same with a \p deadline that may have been set earlier, in place of Options::time_limit: give one to
 * prepareScans() and to this, and it covers both.
 */
PCL_SSFR_EXPORT Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess,
              const Deadline& deadline);

} // namespace pcl_ssfr
