// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/impl/cloud_access.hpp>
#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/multiway/pair_linking.h>
#include <pcl_ssfr/prepared_scan.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// A scan as the caller has read it.
struct ScanSource {
  ScanView view;                     ///< borrowed from \ref owner
  std::shared_ptr<const void> owner; ///< let go as soon as the scan is prepared; may be null
};

/// What is known of a pose beforehand.
struct PosePrior {
  Eigen::Isometry3d T_map_scan = Eigen::Isometry3d::Identity(); ///< in one frame for all scans that have one
  double rotation = 0.1745;                                     ///< it is right within this [rad], (0, pi]
  double translation = 1;                                       ///< and this [m], > 0
};

/** \brief Many scans, one map: unordered scans in, a consistent set of poses with covariances out.
 *
 * Stages: every scan is prepared once and its points are let go; all pairs (of many scans those that are likely to
 * share a place: MultiwayOptions::pairs) are linked, several poses each; the most probable consistent ones are chosen
 * and verified against all scans; pose graph and joint adjustment over the surfaces make them exact. What no sure
 * evidence connects stays apart. Same scans, same bits, for any number of threads.
 *
 * \code
 *   pcl_ssfr::MultiwayRegistration registration;
 *   for (const auto& cloud : clouds)
 *     registration.addPointCloud("scan " + std::to_string(registration.size()), *cloud);
 *   const pcl_ssfr::MultiwayMap map = registration.run();
 *   pcl::transformPointCloud(*clouds[0], moved, map.scans[0].T_map_scan.matrix().cast<float>());
 * \endcode
 */
class PCL_SSFR_EXPORT MultiwayRegistration {
public:
  /// How far a stage is: its name, what is done and what there is. Called from one thread at a time.
  using Progress = std::function<void(const char* stage, std::size_t done, std::size_t total)>;
  /// Gives scan i, or throws std::exception with the reason why there is none.
  using Loader = std::function<ScanSource(std::size_t i)>;

  /// \throw std::invalid_argument when \p options are out of range
  explicit MultiwayRegistration(const MultiwayOptions& options = {});
  ~MultiwayRegistration();
  /// What was prepared and linked moves along.
  MultiwayRegistration(MultiwayRegistration&&) noexcept;
  /// The same.
  MultiwayRegistration&
  operator=(MultiwayRegistration&&) noexcept;

  /** \brief Prepare scans, as many at a time as there are threads; no more of them are in memory.
   *
   * A scan that cannot be loaded, is empty or says nothing is kept as a row with a reason. Of scans with the same
   * points the first one is registered, and the others get its pose.
   * \param[in] names of the scans, each another one
   * \param[in] load called once for each, from several threads
   * \param[in] progress called after each scan; empty: not
   * \throw std::invalid_argument when a name is empty or not new, and what \p progress throws; then no scan is added
   */
  void
  addScans(const std::vector<std::string>& names, const Loader& load, const Progress& progress = {});

  /// One scan that the caller has in memory; borrowed until this returns. \return its number \throw as addScans()
  int
  addScan(const std::string& name, const ScanView& scan);

  /// One cloud of PCL, with its sensor_origin_. \return its number \throw as addScans()
  template <typename PointT>
  int
  addPointCloud(const std::string& name, const pcl::PointCloud<PointT>& cloud)
  {
    return addScan(name, detail::viewOf(cloud, nullptr, std::nullopt));
  }

  /// Number of scans so far.
  std::size_t
  size() const;
  /// Number of a scan, -1: there is none of this name.
  int
  find(const std::string& name) const;
  /// A prepared scan; empty when it could not be prepared.
  const PreparedScan&
  preparedScan(int scan) const;

  /** \brief Keep everything in a database: links are written as they are found and taken from it where the scans and
   * the options are the same, so that a run that was killed goes on and a change of mind costs seconds.
   * \param[in] file of SQLite, made when there is none
   * \param[in] resume false: what the file holds is dropped
   * \throw std::runtime_error naming the file when it cannot be opened or is no project
   */
  void
  openProject(const std::string& file, bool resume);

  /** \brief Write a map to the project again, such as run() has written it, in the frame that the caller has brought it
   * to since. Without a project: nothing. \throw std::runtime_error as run()
   */
  void
  writeToProject(const MultiwayMap& map);

  /// A person says that the best pose of this pair is right: the two are not put apart for what speaks against it,
  /// which becomes a note of the map. \throw std::invalid_argument for a number that is no scan
  void
  accept(int a, int b);
  /// A person says that these scans are not to be joined by a link of theirs. \throw as accept()
  void
  reject(int a, int b);
  /// The scan holds the frame of its component: its pose is the identity, or its prior. \throw as accept()
  void
  pin(int scan);
  /// The scan's pose is known to a tolerance: only poses within it are considered. \throw std::invalid_argument for a
  /// number that is no scan, a pose that is no rigid motion, a tolerance out of range
  void
  setPosePrior(int scan, const PosePrior& prior);

  /** \brief Who links the pairs that are not in the project: other processes, say. Empty, the default: this one.
   *
   * Everything else stays here: scans are prepared, links are written to the project as they come, the map is made.
   */
  void
  setLinker(const PairLinker& linker);

  /** \brief Link, choose, adjust.
   * Decisions, pins and priors of a scan that was given twice are of the first one with its points.
   * \throw std::invalid_argument when fewer than two scans can be used
   * \throw DecisionError when decisions cannot hold, as accepted links that do not agree: the text names the loop that
   * does not close
   * \throw std::runtime_error when the project cannot be written, or when a linker gives a link that was not asked for
   * or leaves one out
   */
  MultiwayMap
  run(const Progress& progress = {});

private:
  struct State;
  std::unique_ptr<State> state_;
};

} // namespace pcl_ssfr
