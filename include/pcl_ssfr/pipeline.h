// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/prepared_scan.h>
#include <pcl_ssfr/search_trace.h>

namespace pcl_ssfr {

/** \brief Global registration of two prepared scans: the pose that maps source points into the target frame.
 *
 * Same input, same bits, for any number of threads. No scan makes it throw: Result::status says what happened. When
 * Options::time_limit seconds are over, the status is Status::TimeLimit, and Result holds the best poses so far: not
 * all evidence against them was gathered, nor are they fully refined. (Profile::Paper2017 ranks what it has.)
 * \param[in] source,target prepared with the same profile, or the status is Status::InvalidInput
 * \param[in] options those that the scans were prepared with (PreparedScan::isPreparedWith()); SearchOptions may differ
 * \param[in] guess optional: refined and judged as one more candidate; never needed, never degrades the answer
 * \return all that was found; the pose may be used only when Result::accepted()
 * \throw std::invalid_argument when \p options are out of range, or \p guess is not finite or no rigid motion
 */
PCL_SSFR_EXPORT Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess = nullptr);

/** \brief The same with a deadline that may have been set earlier, in place of Options::time_limit.
 * \param[in] source,target,options,guess as above; \p guess may be null
 * \param[in] deadline given to prepareScans() and to this, it covers both
 * \param[out] trace what the search of Profile::Default proposed, may be null; the result is the same with and without
 * \return as above
 * \throw std::invalid_argument as above
 */
PCL_SSFR_EXPORT Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess,
              const Deadline& deadline,
              SearchTrace* trace = nullptr);

/** \brief The evidence for a given pose of two prepared scans, without a search: score, overlap, contradiction, rmse.
 *
 * A pose of Result::candidates gets the scores that it has there; its rmse is that of its matches at this pose, which
 * there is of the step before. A pose that a local refiner made of Result::T_target_source is worth keeping when it is
 * no worse, both by this function: isNoWorse(). Same input, same bits, for any number of threads; takes about as long
 * as one step of the final refinement.
 * \param[in] source,target,options as for registerScans()
 * \param[in] T_target_source rigid motion between the scans' own frames [m]
 * \return Candidate::probability is 0: it would need all other poses. Everything is 0 where a scan has no surface.
 * \throw std::invalid_argument when \p options are out of range, a scan was not prepared, not completely (deadline), or
 * for another profile than that of \p options, and when \p T_target_source is not finite or no rigid motion
 */
PCL_SSFR_EXPORT Candidate
scorePose(const PreparedScan& source,
          const PreparedScan& target,
          const Options& options,
          const Eigen::Isometry3d& T_target_source);

} // namespace pcl_ssfr
