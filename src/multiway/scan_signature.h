// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "search/pose_search.h"

#include <pcl_ssfr/multiway/multiway_options.h>

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace pcl_ssfr {

/** \brief How often each distance between parallel planes occurs in a scan: the same wherever the sensor stood and
 * however the frame lies, as far as the same was seen.
 *
 * A histogram of the distances across each two places of the scan with parallel normals, of either sign; the square
 * roots of the shares, so that a few large planes do not outweigh all others. Zero for a scan without parallel places.
 * \param[in] votes places that stand for all of the scan
 * \param[in] scale of the scene: multiplies every length
 */
Eigen::VectorXf
signatureOf(const VotingSamples& votes, double scale, const MultiwayOptions& options);

/** \brief How much scans are like each other: the cosine between their signatures less the mean of all.
 *
 * What all scans of a building have (its ceiling height) says nothing. Every two signatures are compared: that takes
 * a tenth of a microsecond, a link takes 50 milliseconds.
 */
class ScanLikeness {
public:
  /// \param[in] signatures of one length each
  explicit ScanLikeness(const std::vector<Eigen::VectorXf>& signatures);

  /// How much each scan is like scan \p scan, [-1, 1].
  Eigen::VectorXf
  of(std::size_t scan) const;

private:
  Eigen::MatrixXf columns_; ///< of each scan, of length 1, or 0
};

} // namespace pcl_ssfr
