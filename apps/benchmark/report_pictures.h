// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/dataset_folder.h>
#include <apps/io/loaded_cloud.h>
#include <apps/pairs/pair_input.h>
#include <apps/pairs/result_row.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A scan as a report draws it: few points, evenly over its surfaces.
struct ReportCloud {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< middle of the scan in file coordinates [m]
  double step = 0;                                  ///< a unit of the coordinates [m]
  std::vector<std::int16_t> coordinates;            ///< x, y, z of each point relative to the origin
};

/// Two scans of a report and the truth about them.
struct ReportPair {
  std::string dataset;
  std::size_t pair = 0;                                              ///< row of pairs.csv
  std::size_t source = 0;                                            ///< index into ReportPictures::clouds
  std::size_t target = 0;                                            ///< index into ReportPictures::clouds
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< ground truth, of the files
};

/// What a report needs to draw pairs: each scan once, however many pairs name it.
struct ReportPictures {
  std::vector<ReportCloud> clouds;
  std::vector<ReportPair> pairs;
};

/// Whether the scans of a variation are drawn: those of pairs.csv, that lie in the frames of the files but for a motion
/// of the source.
bool
isDrawn(const Variation& variation);

/// Thin a scan for a report; points far outside are left out. Empty for a scan without returns.
ReportCloud
makeReportCloud(const io::LoadedCloud& cloud);

/** \brief Load the scans of those pairs that most methods failed on, and of others while there is room.
 * \param[in] max_pairs bound on the size of the report. A scan that cannot be read leaves its pairs without pictures.
 */
ReportPictures
loadReportPictures(const std::vector<ResultRow>& rows,
                   const std::vector<io::DatasetFolder>& datasets,
                   std::size_t max_pairs);

} // namespace apps
} // namespace pcl_ssfr
