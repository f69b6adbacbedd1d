// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"
#include "distance_transform.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <vector>

// The error that Go-ICP minimises and its bounds; section numbers are those of Yang et al., PAMI 2016. Lengths have
// the unit of the points, which the search normalises.
namespace pcl_ssfr::baselines {

/// A cube of rotations in angle-axis coordinates [rad], or of translations.
struct SearchCube {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double half = 0; ///< half of its edge
};

/// The rotation by |v| about v.
Eigen::Matrix3d
angleAxisRotation(const Eigen::Vector3d& v);

/// The eighth number \p child (0 to 7) of a cube.
SearchCube
childOf(const SearchCube& cube, int child);

/// Registration as a minimisation: sum of the squared distances from the moved source to the target, the worst left
/// out.
class GoIcpProblem {
public:
  /// The source at the centre of a cube of rotations, in voxels of the distance transform, padded to
  /// whole blocks.
  struct RotatedSource {
    std::vector<float> x, y, z;
    std::vector<float> radius; ///< how far a point may be from there under another rotation of the cube (5.1)
    float largest_radius = 0;  ///< of them
    float reach = 0;           ///< largest coordinate, positive or negative
    Points3 points;            ///< in the unit of the source
    std::vector<double> radii; ///< in the unit of the source
  };

  /// Sums over the points kept, for a cube of translations.
  struct Bounds {
    double lower = 0;  ///< no pose of the two cubes has a lower error (5.2)
    double centre = 0; ///< error at the centre of the translations, less what the rotations may gain at each point
  };

  /// Intermediate values of one thread.
  struct Scratch {
    std::vector<float> lower;
    std::vector<float> centre;
    std::vector<double> exact_lower;
    std::vector<double> exact_centre;
  };

  /** \brief Prepare the error of \p source, N > 0 points, against \p target, M > 0 points, all finite.
   * \param[in] trim_fraction share of the source left out, [0, 1)
   * \param[in] voxels of the distance transform along the target's longest side
   * \param[in] threads for the distance transform
   */
  GoIcpProblem(const Points3& source, const Points3& target, double trim_fraction, int voxels, unsigned threads);

  const Points3&
  source() const
  {
    return source_;
  }
  /// Number of points that count.
  Eigen::Index
  kept() const
  {
    return kept_;
  }
  const DistanceTransform&
  transform() const
  {
    return transform_;
  }

  /// The error of a pose, from exact distances.
  double
  error(const Eigen::Isometry3d& T) const;

  /// Number of source points no farther than \p distance from the target under \p T.
  std::size_t
  countWithin(const Eigen::Isometry3d& T, double distance) const;

  /** \brief Trimmed point-to-point ICP from \p T, which it changes: never to a greater error. It ends with the step
   * that lowers the error by less than the share \p progress. \return the error reached
   */
  double
  icp(Eigen::Isometry3d& T, int iterations, double progress) const;

  /// \p uncertain: with the radii of the cube; else they are 0.
  RotatedSource
  rotate(const SearchCube& rotations, bool uncertain) const;

  /// What Bounds::centre is, as far as the distance transform determines it.
  enum class Centre { Likely, AtMost };

  /** \brief Bounds for the rotations of \p source and the translations of a cube, from the distance transform.
   *
   * Above \p enough the lower bound is not computed to the end, and the other number means nothing.
   */
  Bounds
  bounds(const RotatedSource& source, const SearchCube& translations, Centre centre, double enough, Scratch& scratch)
      const;

  /// The same from exact distances: slower, and without the slack of the distance transform.
  Bounds
  exactBounds(const RotatedSource& source, const SearchCube& translations, double enough, Scratch& scratch) const;

  /// True when the slack of the distance transform is no longer small against the cubes.
  bool
  isFine(const RotatedSource& source, const SearchCube& translations) const;

  /// How far the bounds of a point may be off with the translation known: by the rotations, and by the distance
  /// transform as long as no cube isFine().
  double
  uncertainty(const RotatedSource& source) const;

private:
  /// Distance from \p x to the target.
  NeighborIndex::Neighbor
  nearest(const Eigen::Vector3d& x) const;

  Points3 source_;
  Points3 target_;
  Eigen::Index kept_ = 0;
  DistanceTransform transform_;
  NeighborIndex tree_;
};

} // namespace pcl_ssfr::baselines
