// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_registration.h>
#include <pcl_ssfr/baselines/baseline_result.h>
#include <pcl_ssfr/baselines/go_icp_core.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/memory.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <optional>

namespace pcl_ssfr::baselines {

/** \brief Go-ICP (Yang, Li, Campbell, Jia, PAMI 2016): globally optimal ICP by branch and bound over SE(3), without an
 * initial guess.
 *
 * Cubes of rotations (angle-axis, in the ball of radius pi) are split, the one with the lowest bound first; for each a
 * nested search over cubes of translations bounds the error from both sides, by distances from a distance transform of
 * the target and by how far a pose of the cube can move each point. Wherever a better pose turns up, a local ICP starts
 * from it. The search ends when no pose can be better by more than the tolerance. Unlike the paper's, it begins with
 * ICP from 64 rotations all over the ball, each from its best translation: on scans of rooms the tolerance is large
 * compared with the error of the true pose, and the search alone would end with the first pose that is good enough.
 *
 * **What is optimal.** The mean squared distance from the source, thinned to setSourcePoints() points, to its nearest
 * points of the whole target; with setTrimFraction() without the worst share of the source, as scans need that overlap
 * in part only. All rotations are searched, and all translations that bring the centroids of the two (thinned) scans to
 * within setTranslationRange() of each other along each axis. The pose of least error need not be the true one where
 * the scans overlap little.
 *
 * **Units.** Both scans are scaled into [-1, 1]^3 together, as the paper has it. The two normalised parameters
 * (setMseThreshold(), setTranslationRange()) count in half scenes; GoIcpReport::scale says how many metres that is.
 *
 * hasConverged() is true only when the answer is certified to be within the tolerance of the optimum. When
 * setTimeLimit() or setNodeLimit() cut the search off it is false, getMessage() says so, and getReport() gives the gap
 * that was certified until then; the best pose so far is in getResult(). Expect seconds to minutes, and hours without
 * a limit on scans whose errors are large or whose overlap is small.
 *
 * setMaximumIterations() bounds the steps of each local ICP (0, the default here: 100). setMaxCorrespondenceDistance()
 * is what getCorrespondences() and BaselineResult::overlap count by (unset: the thinning edge, or twice the root mean
 * square error when that is more); it is no part of the error. A guess other than the identity is one more start of
 * the local ICP. Results do not depend on the number of threads, unless a time limit cut them off. All else as
 * BaselineRegistration says.
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT GoIcp : public BaselineRegistration<PointSource, PointTarget, Scalar> {
public:
  /// The base class.
  using Base = BaselineRegistration<PointSource, PointTarget, Scalar>;
  /// This class.
  using Self = GoIcp<PointSource, PointTarget, Scalar>;
  /// Shared pointer to it.
  using Ptr = pcl::shared_ptr<Self>;
  /// Shared pointer to a constant one.
  using ConstPtr = pcl::shared_ptr<const Self>;

  GoIcp() : Base("GoIcp") {}
  ~GoIcp() override = default;

  /// The source is thinned to at most so many points, 3 or more; default 1000. The time grows with it.
  void
  setSourcePoints(int points)
  {
    options_.source_points = points;
  }
  /// Share of the source points left out of the error, those with the largest, [0, 1); default 0.
  void
  setTrimFraction(double fraction)
  {
    options_.trim_fraction = fraction;
  }
  /// Tolerance of the mean squared error, normalised, > 0; default 0.001.
  void
  setMseThreshold(double threshold)
  {
    options_.mse_threshold = threshold;
  }
  /// Half the edge of the cube of translations searched, normalised, > 0; default 0.5.
  void
  setTranslationRange(double range)
  {
    options_.translation_range = range;
  }
  /// Voxels of the distance transform along the target's longest side, 2 to 512; default 300, up to 108 MB.
  void
  setDistanceTransformSize(int voxels)
  {
    options_.transform_size = voxels;
  }
  /// Stop after about so many cubes of rotations and translations; 0: no limit. Default 10^8, some minutes.
  void
  setNodeLimit(std::uint64_t nodes)
  {
    options_.node_limit = nodes;
  }
  /// Stop so long after the call of align() [s]; 0 (default): no limit. With one that cuts off, runs may differ.
  void
  setTimeLimit(double seconds, TimeLimitClock clock = TimeLimitClock::Wall)
  {
    options_.time_limit = seconds;
    options_.time_limit_clock = clock;
  }

  /// The options in force, those set through inherited setters included. One out of its range fails align().
  GoIcpOptions
  getOptions() const;
  /// What the last align() did: certified gap, error, nodes, seconds.
  const GoIcpReport&
  getReport() const
  {
    return report_;
  }

protected:
  BaselineResult
  runMethod(const ScanView& source,
            const ScanView& target,
            const std::optional<Eigen::Isometry3d>& guess) const override;

private:
  GoIcpOptions options_;
  mutable GoIcpReport report_; ///< written by runMethod(), which the base calls from its non-const align()
};

} // namespace pcl_ssfr::baselines

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/baselines/impl/go_icp.hpp>
#else
namespace pcl_ssfr::baselines {
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointNormal, pcl::PointNormal, float>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointNormal, pcl::PointNormal, double>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class PCL_SSFR_EXPORT GoIcp<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
#endif
