// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "multiway/scan_signature.h"

#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace pcl_ssfr {

/// Two scans by their numbers, the lower one first.
using ScanPair = std::pair<int, int>;

/// What is known of the scans of a job before any pair is linked; one element for each scan.
struct CandidateScans {
  std::vector<char> usable;                                 ///< 0: no pair of it is linked
  std::vector<Eigen::VectorXf> signatures;                  ///< of one length; zero where a scan is not usable
  std::vector<Eigen::Vector3d> places;                      ///< of the sensors in the scans' frames [m]
  std::vector<std::optional<Eigen::Isometry3d>> T_map_scan; ///< where poses are known roughly
  std::set<ScanPair> wanted;                                ///< pairs that are linked in any case
};

/// Share of the surface of two scans that would meet at a pose, [0, 1]. Called from several threads.
using OverlapFunction = std::function<double(int source, int target, const Eigen::Isometry3d& T_target_source)>;

/** \brief Chooses the pairs of a large job that are worth linking, in rounds: what was linked says what to link next.
 *
 * First each scan with those most like it (ScanLikeness), and with the nearest ones where poses are known. Then
 * neighbours of neighbours: two links in a row put two scans to each other, and where enough of their surfaces would
 * meet, the pair is linked, the most first, up to a bound for each scan. When that gives nothing more, poses along the
 * surest links say which scans are near each other. When parts stay apart, each scan is tried with those of other parts
 * that are most like it, as many for each of a part, and what comes of it leads on as before. No pair is given twice.
 * What is given depends on the scans and the links alone, neither on the order of the links nor on the number of
 * threads.
 */
class CandidatePairs {
public:
  CandidatePairs(CandidateScans scans, OverlapFunction overlap, const MultiwayOptions& options);

  /** \brief The next round.
   * \param[in] links of all pairs that were given so far
   * \return in order; empty: no pair is left that is worth it
   */
  std::vector<ScanPair>
  next(const std::vector<PairLink>& links);

private:
  using Links = std::vector<PairLink>;
  /// A pose between two scans that were not linked, by a way of links.
  struct Proposal {
    Eigen::Isometry3d T_target_source;
    double weight = -1; ///< of the way: of several the surest is looked at
  };
  using Proposals = std::map<ScanPair, Proposal>;
  /// Scans in one frame.
  struct Part {
    std::vector<int> scans;
    std::vector<Eigen::Isometry3d> poses; ///< T_part_scan of each
  };

  std::set<ScanPair>
  alikeOnes() const;
  std::set<ScanPair>
  neighboursOfNeighbours(const Links& links);
  std::set<ScanPair>
  nearOnes(const Links& links);
  std::set<ScanPair>
  betweenParts(const Links& links);

  bool
  isOpen(int a, int b) const;
  /// The scans that are most like a scan, of those that are wanted and were not linked with it.
  std::vector<int>
  mostAlike(int scan, std::size_t count, const std::function<bool(int)>& isWanted) const;
  void
  propose(int a, int b, const Eigen::Isometry3d& T_b_a, double weight, Proposals& proposals) const;
  /// Those of which enough surface would meet, the most first, as far as their scans may have partners.
  std::set<ScanPair>
  worthIt(const Proposals& proposals);
  /// Call \p visit for each scan of a part and the nearest ones of it that it was not linked with.
  void
  forEachNear(const Part& part, const std::function<void(std::size_t, std::size_t)>& visit) const;
  /// Scans that sure links join, with poses along the surest of them.
  std::vector<Part>
  partsOf(const Links& links) const;

  CandidateScans scans_;
  OverlapFunction overlap_;
  MultiwayOptions options_;
  ScanLikeness likeness_;
  std::set<ScanPair> given_;
  std::set<ScanPair> seen_;           ///< those of them whose links have led on
  std::vector<std::size_t> partners_; ///< of each scan, that links led to
  std::size_t parts_ = 0;             ///< when the pairs between them were last tried; 0: not yet
  std::size_t apart_rounds_ = 0;
};

} // namespace pcl_ssfr
