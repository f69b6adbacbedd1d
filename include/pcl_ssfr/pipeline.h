// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/prepared_scan.h>

namespace pcl_ssfr {

/** \brief Global registration of two prepared scans: the pose that maps source points into the target frame.
 *
 * Both must have been prepared with these \p options. Same input, same bits, for any number of threads.
 * \param[in] guess optional: refined and judged as one more candidate; never needed, never degrades the answer
 * \throw std::invalid_argument when \p options are out of range. Data never throw: Result::status says what happened.
 */
Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess = nullptr);

} // namespace pcl_ssfr
