// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>
#include <pcl_ssfr/result.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// A pose of a pair with what speaks for it.
struct PairHypothesis {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< maps source points into the target's frame
  double probability = 0;                                            ///< as Candidate::probability
  double score = 0;                                                  ///< as Candidate::score
  double overlap = 0;       ///< share of the surface that met its counterpart, [0, 1]
  double contradiction = 0; ///< share of the surface that lies in the other's free space, [0, 1]
  double rmse = 0;          ///< of plane distances [m]
  /// As Result::information, of this pose.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
};

/// What linking found of one pair of scans.
struct PairLink {
  int source = 0;                         ///< number of a scan, less than target
  int target = 0;                         ///< number of the other scan
  Status status = Status::NotRun;         ///< of the pair alone
  std::string message;                    ///< of the pair alone, for people
  double confidence = 0;                  ///< of the pair alone, [0, 1]
  double probability_of_none = 1;         ///< as Result::probability_of_none, with what was not kept
  std::vector<PairHypothesis> hypotheses; ///< ranked, most probable first; may be empty
  double seconds = 0;                     ///< that it took
};

/// A scan in the map.
struct MapScan {
  std::string name;       ///< as it was given
  std::uint64_t hash = 0; ///< of points and viewpoint, 0 when it could not be read
  std::size_t points = 0; ///< that it has
  std::size_t bytes = 0;  ///< that are kept of it in memory
  bool usable = false;    ///< it can be registered
  int component = -1;     ///< by size from 0
  Eigen::Isometry3d T_map_scan = Eigen::Isometry3d::Identity(); ///< maps points of the scan into its component's frame
  /// Covariance of the pose: small motions (w, v) applied on the left about the scan's sensor, order (rotation [rad],
  /// translation [m]), relative to the scan that holds the frame of the component. Zero for that scan.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double sigma_rotation = 0;    ///< root of the trace of the covariance's rotation [rad]
  double sigma_translation = 0; ///< root of the trace of the covariance's translation [m]
  int links = 0;                ///< used
  std::string reason;           ///< why it is not placed, or what is to be known of it; may be empty
};

/// What became of a link.
enum class LinkStatus {
  Used,      ///< it agrees with the map and determines it
  Rejected,  ///< it contradicts the map, or a person rejected it
  Ambiguous, ///< it may be right, but not surely enough to join what it would join
  None       ///< the scans share nothing that was found
};

/// "used", "rejected", "ambiguous", "none".
PCL_SSFR_EXPORT const char*
toString(LinkStatus status);

/// A pair of scans in the map.
struct MapLink {
  int source = 0;                       ///< number of a scan, less than target
  int target = 0;                       ///< number of the other scan
  LinkStatus status = LinkStatus::None; ///< what became of it
  double confidence = 0; ///< that its pose is right, all pairs considered; of an accepted one by itself; [0, 1]
  double overlap = 0;    ///< share of the surface that meets, at the pose of the map where it is used, [0, 1]
  double rmse = 0;       ///< of plane distances of both scans [m], likewise
  Eigen::Vector3d strength = Eigen::Vector3d::Zero(); ///< share of the matched surface that faces x, y, z of the target
  double below_6mm = 0;                               ///< share of the matches with a plane distance below 6 mm, [0, 1]
  double residual_rotation = 0;                       ///< between the link's own pose and the map [rad]
  double residual_translation = 0;                    ///< the same, at the source's sensor [m]
  bool bridge = false;                                ///< it alone joins two parts of the map
  std::string reason;                                 ///< why it is not used; may be empty
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< its own pose
};

/// A loop of links that closes badly, or well.
struct LoopClosure {
  std::vector<int> scans; ///< three, in order
  double rotation = 0;    ///< that is left after going round [rad]
  double translation = 0; ///< the same [m]
};

/// Scans in one frame per component.
struct MultiwayMap {
  std::vector<MapScan> scans;      ///< in the order in which they were added
  std::vector<MapLink> links;      ///< of all pairs that were linked, by source, then target
  int components = 0;              ///< number of them, scans that were not placed included
  std::size_t placed = 0;          ///< scans in components of two and more, of which copies do not count
  double bundle_error = 0;         ///< root mean square plane distance over all pairs after the joint adjustment [m]
  double graph_error = 0;          ///< the same after the pose graph alone [m]
  double median_misclosure = 0;    ///< over triangles of used links [m]; 0 without any
  double largest_misclosure = 0;   ///< likewise [m]
  std::vector<LoopClosure> loops;  ///< the worst of them, at most 20, worst first
  std::vector<std::string> notes;  ///< what is to be known of the map as a whole
  std::vector<StageReport> stages; ///< prepare, link, choose, adjust
  /// Poses before the joint adjustment, and along a maximum spanning tree of the links: for comparison.
  std::vector<Eigen::Isometry3d> graph_poses;
  std::vector<Eigen::Isometry3d> chain_poses; ///< the second of these
};

/// Decisions of a person that cannot hold: an accepted link that has no pose or does not agree with others, say.
class PCL_SSFR_EXPORT DecisionError : public std::invalid_argument {
public:
  using std::invalid_argument::invalid_argument;
};

} // namespace pcl_ssfr
