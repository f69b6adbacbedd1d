// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_registration.h>
#include <pcl_ssfr/baselines/baseline_result.h>
#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/memory.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ssfr::baselines {

/// Settings of Super 4PCS; every length is in metres, and 0 where it is to follow from the data.
struct Super4PcsOptions {
  double leaf = 0;               ///< edge of the thinning voxels [m], >= 0; 0: from the scans
  double distance_threshold = 0; ///< delta of the paper [m], >= 0; 0: 1.5 leafs
  double overlap = 0.5;          ///< estimate of the share of the source that the target saw, (0, 1]
  double target_lcp = 1; ///< a pose that brings this share of the source onto the target ends the search, (0, 1]
  double min_lcp = 0;    ///< share that an accepted pose has at least, [0, 1]; 0: 3/4 of overlap
  /// Angles between normals and segments of a pair differ from the base's by no more than this, (0, pi/2] [rad]
  double normal_tolerance = 0.5;
  std::size_t sample_size = 1000; ///< points of the source in which quads are sought, >= 4
  std::size_t max_quads = 50000;  ///< quads verified of one base: where there are more, evenly spaced ones, >= 1
  int max_bases = 0;              ///< bases tried; 0: enough for \ref overlap with a probability of 99 %
  double time_limit = 0;          ///< no new base after this [s], >= 0; 0: none
  TimeLimitClock time_limit_clock = TimeLimitClock::Wall; ///< what time_limit counts
  std::uint64_t seed = 1;                                 ///< of the sample and the bases
  unsigned threads = 1;                                   ///< >= 1
};

/** \brief Super 4PCS of two scans. Points that are not finite are skipped; never throws for the sake of the points: a
 * result that did not converge says why.
 * \throw std::invalid_argument for an option out of its range, "name = value, must ..."
 */
PCL_SSFR_EXPORT BaselineResult
registerSuper4Pcs(const ScanView& source,
                  const ScanView& target,
                  const Super4PcsOptions& options,
                  const std::optional<Eigen::Isometry3d>& guess = std::nullopt);

/** \brief Super 4PCS (Mellado, Aiger, Mitra, SGP 2014), without an initial guess.
 *
 * Wide bases of four coplanar points are drawn from the thinned target; in a sample of the thinned source all pairs as
 * long as a base's two segments are extracted by spheres rasterised in an octree, and of them all quads that an affine
 * invariant and the angle of the segments make congruent to the base are found in a grid with an index of directions.
 * Pairs whose normals (unsigned, from the points within 2 leafs) lie otherwise than the base's are left out before: an
 * addition to the paper, see setNormalTolerance().
 * The pose of each quad is verified by the share of the sample that it brings within delta of the thinned target (LCP),
 * and given up as soon as it cannot win. The best of all bases is the answer; there is no refinement in the paper, nor
 * here, so expect errors of the order of delta.
 *
 * No parameter is required; the estimate of the overlap (setOverlap()) decides how wide the bases are and how many are
 * tried. Lengths follow from the voxel edge, the *leaf*: delta is 1.5 leafs. Without setLeafSize() the leaf follows
 * from the scans by the same rule as for FastGlobalRegistration. The diameter of the target is twice the 90th
 * percentile of the distance to its median point, so that a few far points do not widen the bases.
 *
 * hasConverged() is true when the LCP of the best pose reaches 3/4 of the estimated overlap (setMinLcp()).
 *
 * setMaxCorrespondenceDistance() sets delta; setMaximumIterations() the number of bases (0, the default here: enough
 * for the estimated overlap). A guess other than the identity is verified first, and is the answer when nothing beats
 * it. With setTimeLimit() the answer depends on the speed of the machine. All else as BaselineRegistration says.
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT Super4PCS : public BaselineRegistration<PointSource, PointTarget, Scalar> {
public:
  /// The base class.
  using Base = BaselineRegistration<PointSource, PointTarget, Scalar>;
  /// This class.
  using Self = Super4PCS<PointSource, PointTarget, Scalar>;
  /// Shared pointer to it.
  using Ptr = pcl::shared_ptr<Self>;
  /// Shared pointer to a constant one.
  using ConstPtr = pcl::shared_ptr<const Self>;

  Super4PCS();
  ~Super4PCS() override = default;

  /// Edge of the voxels that both scans are thinned to [m]; 0 (default): from the scans.
  void
  setLeafSize(double leaf)
  {
    options_.leaf = leaf;
  }
  /// Estimate of the share of the source that the target saw, (0, 1]; default 0.5.
  void
  setOverlap(double overlap)
  {
    options_.overlap = overlap;
  }
  /// The search ends with a pose that brings this share of the source onto the target, (0, 1]; default 1.
  void
  setTargetLcp(double lcp)
  {
    options_.target_lcp = lcp;
  }
  /// Share of the source that an accepted pose brings onto the target, [0, 1]; 0 (default): 3/4 of the overlap.
  void
  setMinLcp(double lcp)
  {
    options_.min_lcp = lcp;
  }
  /** \brief Pairs of points whose normals lie otherwise than the base's, by more than this angle, are left out;
   * (0, pi/2] [rad], default 0.5. With pi/2 normals are not looked at, as in the paper, and a run takes far longer.
   */
  void
  setNormalTolerance(double angle)
  {
    options_.normal_tolerance = angle;
  }
  /// Points of the source in which quads are sought; default 1000.
  void
  setSampleSize(std::size_t points)
  {
    options_.sample_size = points;
  }
  /// Quads verified of one base; default 50000.
  void
  setMaxQuads(std::size_t quads)
  {
    options_.max_quads = quads;
  }
  /// No new base after this [s]; 0 (default): no limit.
  void
  setTimeLimit(double seconds, TimeLimitClock clock = TimeLimitClock::Wall)
  {
    options_.time_limit = seconds;
    options_.time_limit_clock = clock;
  }
  /// Seed of the sample and of the bases; default 1.
  void
  setSeed(std::uint64_t seed)
  {
    options_.seed = seed;
  }

  /// The options in force, those set through inherited setters included. One out of its range fails align().
  Super4PcsOptions
  getOptions() const;

protected:
  BaselineResult
  runMethod(const ScanView& source,
            const ScanView& target,
            const std::optional<Eigen::Isometry3d>& guess) const override;

private:
  Super4PcsOptions options_;
};

} // namespace pcl_ssfr::baselines

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/baselines/impl/super4pcs.hpp>
#else
namespace pcl_ssfr::baselines {
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointNormal, pcl::PointNormal, float>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointNormal, pcl::PointNormal, double>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class PCL_SSFR_EXPORT Super4PCS<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
#endif
