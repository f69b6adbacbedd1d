// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Geometry>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace pcl_ssfr::simulation {

/// One line of pairs.csv.
struct DatasetPair {
  std::size_t source = 0; ///< index into the scans of the dataset
  std::size_t target = 0;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double overlap = 0; ///< share of what the source sees that the target sees too
};

/// The folder that a name means: absolute, links followed, "a/b/" as "a/b"; empty, with an error, where that fails.
std::filesystem::path
resolvedFolder(const std::string& name, std::error_code& error);

/** \brief Writes a dataset folder completely or not at all.
 *
 * Everything goes into "FOLDER.partial-..." next to it; commit() flushes it to the disk and renames it. A writer that
 * is destroyed before, or a process that is asked to stop (SIGINT, SIGTERM, SIGHUP), leaves nothing behind. While a
 * writer lives these signals are waited for by a thread of its own: make it before other threads are started.
 * Every function throws io::IoError naming the file (as it would be called in the end) and what is wrong.
 */
class DatasetWriter {
public:
  /** \brief Make the partial folder, and the folders above it.
   * \param[in] overwrite replace an existing dataset, at commit(); a folder with anything else in it is never touched
   */
  DatasetWriter(const std::string& folder, bool overwrite);
  ~DatasetWriter();
  DatasetWriter(const DatasetWriter&) = delete;
  DatasetWriter&
  operator=(const DatasetWriter&) = delete;

  /// A scan as binary PCD (x, y, z [m], intensity; sensor at the origin) into scans/; streamed, needs no copy of it.
  void
  writeScan(const std::string& name, const std::vector<Eigen::Vector3f>& points, const std::vector<float>& intensity);
  /// pairs.csv and poses.txt: names and poses (world from scan), one a scan; all numbers read back to the same bits.
  void
  writeTruth(const std::vector<std::string>& names,
             const std::vector<Eigen::Isometry3d>& T_world_scan,
             const std::vector<DatasetPair>& pairs);
  /// dataset.json.
  void
  writeDescription(std::string_view json);
  /// Bytes written so far.
  std::size_t
  bytesWritten() const;
  /// Put the folder in its place.
  void
  commit();

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace pcl_ssfr::simulation
