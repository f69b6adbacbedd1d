// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/types.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

// Coplanar bases, pairs of a given length and congruent quads (Aiger, Mitra, Cohen-Or, "4-Points Congruent Sets",
// SIGGRAPH 2008; Mellado, Aiger, Mitra, "Super 4PCS", SGP 2014).
namespace pcl_ssfr::baselines {

/// Points of a base, of which a point set has as many at least.
constexpr Eigen::Index kBasePoints = 4;

/// Four columns of a point set: the ends of a first and of a second segment.
using Quad = std::array<Eigen::Index, kBasePoints>;

/// Two columns of a point set, in order.
struct PointPair {
  Eigen::Index first = 0;
  Eigen::Index second = 0;

  friend bool
  operator==(const PointPair& a, const PointPair& b)
  {
    return a.first == b.first && a.second == b.second;
  }
};

/// What a rigid motion leaves as it is of four nearly coplanar points whose segments 0-1 and 2-3 cross.
struct CoplanarBase {
  Quad points = {0, 0, 0, 0};
  double first_length = 0;  ///< of segment 0-1 [m]
  double second_length = 0; ///< of segment 2-3 [m]
  double first_ratio = 0;   ///< the crossing is at p0 + ratio (p1 - p0), (0, 1)
  double second_ratio = 0;  ///< the crossing is at p2 + ratio (p3 - p2), (0, 1)
  double angle = 0;         ///< between p1 - p0 and p3 - p2 [rad], (0, pi)
};

/** \brief The base that four points make, in the order in which their segments cross.
 *
 * Nothing when no two segments cross within \p gap [m] of each other, away from their ends and at an angle of 20
 * degrees at least: then the invariants say too little.
 */
std::optional<CoplanarBase>
makeBase(const Points3& points, const Quad& quad, double gap);

/** \brief A wide random base: of many random triangles about one point the one of largest area, and a fourth point
 * in its plane that is far from the three.
 * \param[in] max_diameter no two points are farther apart [m] (overlap times the diameter of the cloud)
 * \param[in] thickness the fourth point lies within this of the plane [m]
 */
std::optional<CoplanarBase>
selectBase(const Points3& points, double max_diameter, double thickness, std::mt19937_64& engine);

/** \brief Finds all pairs of points that are a given length apart: section 4.1 of Super 4PCS.
 *
 * Around each point a sphere is rasterised in the cells of an octree: only cells that the shell meets are opened.
 */
class PairExtractor {
public:
  /// \p points are finite, 3 x N [m].
  explicit PairExtractor(const Points3& points);

  /** \brief Ordered pairs (both orders of each) whose distance is within \p tolerance of \p length [m], in ascending
   * order of the first, then the second point. Independent of \p threads.
   */
  std::vector<PointPair>
  extract(double length, double tolerance, unsigned threads = 1) const;

private:
  struct Node {
    Eigen::Vector3d min = Eigen::Vector3d::Zero(); ///< corner of the box around the node's points [m]
    Eigen::Vector3d max = Eigen::Vector3d::Zero();
    std::size_t begin = 0; ///< in order_
    std::size_t end = 0;
    std::size_t first_child = 0; ///< children are consecutive nodes
    std::size_t children = 0;    ///< 0: a leaf
  };

  void
  split(std::size_t node);

  Points3 points_;
  std::vector<Eigen::Index> order_; ///< columns, each node a contiguous range
  std::vector<Node> nodes_;
};

/// How the normals at the ends of a segment lie, their signs left aside: angles in [0, pi/2]; NaN without a normal.
struct SegmentNormals {
  double first = 0;   ///< between the first normal and the segment [rad]
  double second = 0;  ///< between the second normal and the segment [rad]
  double between = 0; ///< between the normals [rad]
};

/// The angles at the pair's ends. \p normals are unit or zero (unknown), one per point.
SegmentNormals
measureNormals(const Points3& points, const Points3& normals, const PointPair& pair);

/** \brief The pairs whose normals lie as in \p model, within \p tolerance [rad] each, in their order; an unknown angle
 * agrees with any. Not in the paper; the authors' implementation can compare the angle between the normals alone.
 */
std::vector<PointPair>
filterByNormals(const Points3& points,
                const Points3& normals,
                const std::vector<PointPair>& pairs,
                const SegmentNormals& model,
                double tolerance);

/// How exactly a quad must agree with the base.
struct QuadTolerance {
  double distance = 0; ///< between the crossings on the two segments, > 0 [m]
  double angle = 0;    ///< between the segments, against the base's [rad], >= 0
};

/** \brief All quads whose crossings coincide and whose segments meet at the base's angle: section 4.2 of Super 4PCS.
 *
 * The crossings on the first pairs are indexed in a 3-D grid whose cells are sorted by the direction of the segment, so
 * that a second pair opens only the cells around its crossing and the directions on the cone about its own.
 * \return in ascending order of the second, then of the first pair; a quad names four different points
 */
std::vector<Quad>
findCongruentQuads(const Points3& points,
                   const std::vector<PointPair>& first_pairs,
                   const std::vector<PointPair>& second_pairs,
                   const CoplanarBase& base,
                   const QuadTolerance& tolerance,
                   unsigned threads = 1);

} // namespace pcl_ssfr::baselines
