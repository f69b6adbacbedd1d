// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_registration.h>
#include <pcl_ssfr/baselines/baseline_result.h>
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

/// Settings of Fast Global Registration; every length is in metres, and 0 where it is to follow from the data.
struct FastGlobalOptions {
  double leaf = 0; ///< edge of the thinning voxels [m], >= 0; 0: from the scans (FastGlobalRegistration::setLeafSize)
  double normal_radius = 0;       ///< neighbourhood of the normals [m], >= 0; 0: 2 leafs
  double feature_radius = 0;      ///< neighbourhood of the descriptors [m], >= 0; 0: 5 leafs
  double distance_threshold = 0;  ///< delta of the paper [m], >= 0; 0: 1.5 leafs
  double tuple_similarity = 0.9;  ///< tau of the paper, (0, 1]
  std::size_t max_tuples = 1000;  ///< triples of matches that are kept, >= 1
  int iterations = 0;             ///< Gauss-Newton steps; 0: as the annealing needs, at least 64
  std::size_t min_inliers = 20;   ///< matches within delta that an accepted pose has at least
  double min_inlier_ratio = 0.05; ///< their share of the matches that passed the tuple test, at least, [0, 1]
  double min_overlap = 0.3;       ///< share of the source that lies on the target under an accepted pose, [0, 1]
  std::uint64_t seed = 1;         ///< of the tuple test
  unsigned threads = 1;           ///< >= 1
};

/** \brief Fast Global Registration of two scans. Points that are not finite are skipped; never throws for the sake of
 * the points: a result that did not converge says why.
 * \throw std::invalid_argument for an option out of its range, "name = value, must ..."
 */
PCL_SSFR_EXPORT BaselineResult
registerFastGlobal(const ScanView& source,
                   const ScanView& target,
                   const FastGlobalOptions& options,
                   const std::optional<Eigen::Isometry3d>& guess = std::nullopt);

/** \brief Fast Global Registration (Zhou, Park, Koltun, ECCV 2016), without an initial guess.
 *
 * FPFH descriptors of the thinned scans are matched, mutual nearest ones are kept (reciprocity test), triples of them
 * whose triangles agree are drawn (tuple test), and the pose is optimised over these matches by graduated
 * non-convexity: a line process on the scaled Geman-McClure estimator, mu divided by 1.4 every fourth Gauss-Newton step
 * from the squared diameter of the scans down to delta^2.
 *
 * No parameter is required. Everything follows from the voxel edge, the *leaf*: normals within 2 leafs, descriptors
 * within 5 leafs, delta 1.5 leafs. Without setLeafSize() the leaf is 1/50 of the smaller scan's radius (90th percentile
 * of the distance to the median point), grown by halves until a voxel holds 3 points on average in both scans, to no
 * more than 1/5 of that radius. Normals are estimated from the thinned points (those of the point type are not used)
 * and oriented towards each cloud's `sensor_origin_`.
 *
 * The paper has no test for failure. hasConverged() is true here when, under the pose, at least 20 distinct matches and
 * 5 % of all lie within delta, are not all on one line, and 30 % of the thinned source lies within delta of the target
 * (setMinInliers(), setMinOverlap()).
 *
 * setMaxCorrespondenceDistance() sets delta; setMaximumIterations() the number of Gauss-Newton steps (0, the default
 * here: as the annealing needs, at least 64). A guess other than the identity is optimised as well, and kept when its
 * robust cost is the lower one. All else as BaselineRegistration says.
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT FastGlobalRegistration : public BaselineRegistration<PointSource, PointTarget, Scalar> {
public:
  /// The base class.
  using Base = BaselineRegistration<PointSource, PointTarget, Scalar>;
  /// This class.
  using Self = FastGlobalRegistration<PointSource, PointTarget, Scalar>;
  /// Shared pointer to it.
  using Ptr = pcl::shared_ptr<Self>;
  /// Shared pointer to a constant one.
  using ConstPtr = pcl::shared_ptr<const Self>;

  FastGlobalRegistration();
  ~FastGlobalRegistration() override = default;

  /// Edge of the voxels that both scans are thinned to [m]; 0 (default): from the scans.
  void
  setLeafSize(double leaf)
  {
    options_.leaf = leaf;
  }
  /// Neighbourhood of the normals [m]; 0 (default): 2 leafs.
  void
  setNormalRadius(double radius)
  {
    options_.normal_radius = radius;
  }
  /// Neighbourhood of the descriptors [m]; 0 (default): 5 leafs.
  void
  setFeatureRadius(double radius)
  {
    options_.feature_radius = radius;
  }
  /// Largest ratio by which corresponding sides of a triple of matches may differ, (0, 1]; default 0.9.
  void
  setTupleSimilarity(double similarity)
  {
    options_.tuple_similarity = similarity;
  }
  /// Triples of matches that are kept; default 1000.
  void
  setMaxTuples(std::size_t tuples)
  {
    options_.max_tuples = tuples;
  }
  /// Least number of matches within delta, and least share of all matches [0, 1], of an accepted pose.
  void
  setMinInliers(std::size_t inliers, double ratio)
  {
    options_.min_inliers = inliers;
    options_.min_inlier_ratio = ratio;
  }
  /// Least share of the source that lies on the target under an accepted pose, [0, 1].
  void
  setMinOverlap(double overlap)
  {
    options_.min_overlap = overlap;
  }
  /// Seed of the tuple test; default 1.
  void
  setSeed(std::uint64_t seed)
  {
    options_.seed = seed;
  }

  /// The options in force, those set through inherited setters included. One out of its range fails align().
  FastGlobalOptions
  getOptions() const;

protected:
  BaselineResult
  runMethod(const ScanView& source,
            const ScanView& target,
            const std::optional<Eigen::Isometry3d>& guess) const override;

private:
  FastGlobalOptions options_;
};

} // namespace pcl_ssfr::baselines

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/baselines/impl/fast_global_registration.hpp>
#else
namespace pcl_ssfr::baselines {
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointNormal, pcl::PointNormal, float>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointNormal, pcl::PointNormal, double>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class PCL_SSFR_EXPORT FastGlobalRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
#endif
