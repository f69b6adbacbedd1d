// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "refinement/plane_equations.h"
#include "search/pose_search.h"

#include <pcl_ssfr/multiway/multiway_map.h>
#include <pcl_ssfr/multiway/multiway_options.h>
#include <pcl_ssfr/multiway/pair_linking.h>
#include <pcl_ssfr/options.h>
#include <pcl_ssfr/prepared_scan.h>

#include <Eigen/Geometry>

#include <optional>
#include <string>

namespace pcl_ssfr {

/// Why a prepared scan cannot be registered; empty: it can.
std::string
problemOf(const PreparedScan& scan);

/// Memory that a prepared scan takes [bytes].
std::size_t
bytesOf(const PreparedScan& scan);

/// The place of its sensor, or the middle of its points where that is not known, in its own frame [m].
Eigen::Vector3d
placeOf(const PreparedScan& scan);

/// Places that stand for all of a scan, in one frame; and the scale of its scene, which multiplies every length.
const VotingSamples&
votesOf(const PreparedScan& scan);
double
scaleOf(const PreparedScan& scan);

/// What a pair is registered with: of MultiwayOptions::registration, and one vertical for both where that is given.
Options
pairOptions(const MultiwayOptions& options);

/** \brief Register two scans and keep several poses, each with its information. Same scans, same bits.
 * \param[in] options threads are not read: it runs in this thread
 */
PairLink
linkScans(const PreparedScan& source,
          const PreparedScan& target,
          const MultiwayOptions& options,
          const std::optional<PairGuess>& guess);

/// What the surfaces of two scans say of a pose, each patch weighted as in the score of a pair.
struct PlacementEvidence {
  double total = 0;
  double matched = 0;
  double contradicted = 0;
  double overlap = 0; ///< share of the surface that meets, [0, 1]

  PlacementEvidence&
  operator+=(const PlacementEvidence& other)
  {
    total += other.total;
    matched += other.matched;
    contradicted += other.contradicted;
    return *this;
  }
  PlacementEvidence&
  operator-=(const PlacementEvidence& other)
  {
    total -= other.total;
    matched -= other.matched;
    contradicted -= other.contradicted;
    return *this;
  }
};

/// What may be said of two scans without a look at them.
struct SightOfScan {
  double reach = 0; ///< from its sensor, within which all but a hundredth of its patches lie [m]
  double total = 0; ///< its part of PlacementEvidence::total of any pair
};

SightOfScan
sightOf(const PreparedScan& scan);

/// Of surface in free space over surface that meets, as in the score of a pair.
double
contradictionWeight(const MultiwayOptions& options);
/// What meets less what contradicts, as a share of all; 0 of nothing.
double
scoreOf(const PlacementEvidence& evidence, double contradiction_weight);

/** \brief What the surfaces of two scans say of a pose.
 * \param[in] looseness factor on matching distances and margins, >= 1: 1 where poses are exact
 */
PlacementEvidence
evidenceAt(const PreparedScan& source,
           const PreparedScan& target,
           const Eigen::Isometry3d& T_target_source,
           const MultiwayOptions& options,
           double looseness);

/// What distinguishes places that look alike, in the inner frame of a scan.
struct Furniture {
  OrientedSamples patches; ///< of no large plane
  Eigen::Matrix3Xf points; ///< that fit no plane, each of a finest cell of patches, 3 x N [m]
};

/** \brief The points of a scan that fit no plane (PatchScan::clutter: one of each finest cell, at most
 * PreparationConfig::clutter_points) and behind which its own sensor sees nothing in the same cell of its range image,
 * by more than the margins of what is hidden: what it sees through itself, as leaves, another one may see through too.
 * \return 3 x N [m]; none where the place of the sensor is not known
 */
Eigen::Matrix3Xf
solidClutter(const PreparedScan& scan, const MultiwayOptions& options);

/// What becomes of furniture in another scan, whichever way it faces, each patch weighted as in PlacementEvidence, each
/// point as a patch that fills a finest cell.
struct FurnitureEvidence {
  double in_view = 0;      ///< what meets, or is where the other sensor saw
  double seen_through = 0; ///< of that: what hangs in front of what it saw through
};

/** \brief What becomes of the furniture of two scans in each other, with narrower margins of free space.
 * \param[in] source_furniture,target_furniture furnitureOf() the scans
 */
FurnitureEvidence
furnitureAt(const PreparedScan& source,
            const Furniture& source_furniture,
            const PreparedScan& target,
            const Furniture& target_furniture,
            const Eigen::Isometry3d& T_target_source,
            const MultiwayOptions& options);

/// The plane distances of two scans at a pose, linearised: a small motion (w, v) of the source on the left, about the
/// target's origin, order (rotation [rad], translation [m]).
struct SurfaceEquations {
  using Matrix6 = PlaneEquations::Matrix6;
  using Vector6 = PlaneEquations::Vector6;

  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();       ///< the step -hessian^-1 gradient lays the surfaces onto each other
  Matrix6 curvature = Matrix6::Zero();      ///< as EquationStatistics
  Matrix6 full_curvature = Matrix6::Zero(); ///< as there
  double weight = 0;                        ///< robust weight of all matches
  double squares = 0;                       ///< weighted sum of squared distances [m^2]
};

SurfaceEquations
equationsAt(const PreparedScan& source,
            const PreparedScan& target,
            const Eigen::Isometry3d& T_target_source,
            const MultiwayOptions& options);

/// What the matches of each patch of one scan of a pair add to the gradient of the pair, a column per patch; zero where
/// it met nothing. Motions as of SurfaceEquations.
struct PatchGradients {
  using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  Columns gradients;
  Columns offsets; ///< what it would add if the patch were off by the noise floor along its normal
};

/// \param[in] of_source the patches of the source, else those of the target
PatchGradients
patchGradientsAt(const PreparedScan& source,
                 const PreparedScan& target,
                 const Eigen::Isometry3d& T_target_source,
                 const MultiwayOptions& options,
                 bool of_source);

/// The figures of a link that a surveyor signs.
struct LinkFigures {
  double overlap = 0;                                 ///< share of the surface that meets, [0, 1]
  double rmse = 0;                                    ///< of the plane distances of the matches [m]
  double below_6mm = 0;                               ///< share of the matches below 6 mm, [0, 1]
  Eigen::Vector3d strength = Eigen::Vector3d::Zero(); ///< share of the matched surface that faces x, y, z; sums to 1
};

LinkFigures
figuresAt(const PreparedScan& source,
          const PreparedScan& target,
          const Eigen::Isometry3d& T_target_source,
          const MultiwayOptions& options);

} // namespace pcl_ssfr
