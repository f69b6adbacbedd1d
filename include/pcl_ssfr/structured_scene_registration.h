// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/options.h>
#include <pcl_ssfr/pipeline.h>
#include <pcl_ssfr/prepared_scan.h>
#include <pcl_ssfr/result.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/memory.h>
#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <optional>
#include <string>

namespace pcl_ssfr {

/** \brief Global registration of two LiDAR scans of a structured (man-made) scene, without an initial guess.
 *
 * A drop-in for pcl::IterativeClosestPoint: the rotation is found from the directions of the planes, the translation
 * from 1-D histograms along them, and the pose under which the scans agree best is polished (Sanchez et al., "Global
 * Registration of 3D LiDAR Point Clouds Based on Scene Features", Remote Sensing 2017, 9(10), 1014).
 *
 * \code
 * pcl_ssfr::StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ> registration;
 * registration.setInputSource(source);
 * registration.setInputTarget(target);
 * pcl::PointCloud<pcl::PointXYZ> moved;
 * registration.align(moved);
 * if (registration.hasConverged())
 *   std::cout << registration.getFinalTransformation() << '\n';
 * else
 *   std::cout << registration.getResult().message << '\n';
 * \endcode
 *
 * No parameter is required; every scale is derived from the clouds. Lengths are in metres, angles in radians.
 *
 * **Result.** hasConverged() is true only when a pose was accepted; getResult() tells the status and the reason, the
 * ranked candidates, the overlap, a confidence and what the scene leaves unobservable. getFinalTransformation() maps
 * the original source onto the target, a guess included. Without an accepted pose it is the guess, as after a failed
 * pcl::IterativeClosestPoint, and the output is the source moved by it.
 *
 * **Output.** The indexed points of the source in their order, moved; normals are rotated when the point type carries
 * them, every other field and the header are kept. Non-finite points stay where they are. `sensor_origin_` is copied
 * without being moved, as by ICP. align(*source) is allowed without indices; with indices that are not simply all
 * points PCL itself has overwritten the source before this class is asked, so such a call is reported as
 * Status::InvalidInput, and so is an output that is the target.
 *
 * **Viewpoint.** Normals are oriented towards the sensor, and space between it and the points is taken to be free. The
 * sensor is at each cloud's `sensor_origin_`, which PCL does not move along with the points: on merged or moved clouds
 * it is wrong. By default (ViewpointMode::Auto) it is believed only when the points agree with it. setSourceViewpoint()
 * and setTargetViewpoint() give it explicitly; ViewpointMode::Unknown never believes it.
 *
 * **Guess.** Never needed and never harmful: a guess other than the identity is judged as one more candidate. With
 * setGuessTolerance() it is a prior instead.
 *
 * **Cached work.** The target and the source are prepared once and kept until their setter (or setIndices(), or the
 * setter of a viewpoint) is called again, or align() finds another value of an option that the preparation reads
 * (PreparationOptions, and the stages of the profile). A cloud edited in place must therefore be set again.
 *
 * **Work on demand.** The search tree of the target takes 1.7 times the memory of a cloud of pcl::PointXYZ, and the
 * registration has no use for it: it is built when getFitnessScore() or getCorrespondences() first asks it, from the
 * clouds as they are then, unlike with ICP. So is the list of correspondences. A search method that was set by
 * setSearchMethodTarget() is filled at once, as PCL does it.
 *
 * **Time limit.** setTimeLimit() bounds the whole of align(), preparation included, but for the copying of the source
 * into the output. When it ends the preparation, the status is Status::TimeLimit, the message names the stage, and the
 * scans that were not ready are prepared anew by the next align(). When it ends the search, the status is the same, and
 * getResult() holds the best poses so far; none of them is accepted.
 *
 * **Inherited settings**
 *
 * | setting | effect |
 * |---|---|
 * | setMaxCorrespondenceDistance | honoured: radius within which points count as overlapping; unset: from the data |
 * | setMaximumIterations | honoured: bound on the steps of the polish (default 30); 0 or less: no polish |
 * | setSearchMethodTarget | honoured: used by getFitnessScore() and for correspondences, if it indexes the target |
 * | setPointRepresentation | for that tree only; the registration itself always works on x, y and z |
 * | setIndices | honoured: only these points are registered and returned |
 * | registerVisualizationCallback | honoured: called once, at the end of align(); set both clouds first |
 * | setTransformationEpsilon, setTransformationRotationEpsilon, setEuclideanFitnessEpsilon | ignored |
 * | setRANSACIterations, setRANSACOutlierRejectionThreshold | ignored |
 * | setTransformationEstimation, setCorrespondenceEstimation, addCorrespondenceRejector | ignored |
 * | setSearchMethodSource | ignored |
 *
 * An ignored setting that was changed is reported once by PCL_WARN. What only pcl::IterativeClosestPoint has
 * (setUseReciprocalCorrespondences(), getConvergeCriteria()) is not part of this class.
 *
 * **Fitness.** getFitnessScore() is the inherited one: it uses all points of the source (not the indices) and compares
 * *squared* distances with its argument. Unlike with ICP, points that are not finite are skipped, and it is
 * DBL_MAX before the first align(), as long as no other search method was set.
 *
 * One object must not be used by two threads at once; clouds may be shared. For point types that are not precompiled,
 * define PCL_NO_PRECOMPILE before the first PCL header, and link with the library all the same (and with lz4, which
 * FLANN's headers need then).
 *
 * \tparam PointSource, PointTarget point types with x, y, z in `data[4]`; PCL's base class compiles for two different
 * types only from PCL 1.15 on
 * \tparam Scalar float or double, of the matrices; the computation is in double for both
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT StructuredSceneRegistration : public pcl::Registration<PointSource, PointTarget, Scalar> {
public:
  using Base = pcl::Registration<PointSource, PointTarget, Scalar>;
  using Self = StructuredSceneRegistration<PointSource, PointTarget, Scalar>;
  using Ptr = pcl::shared_ptr<Self>;
  using ConstPtr = pcl::shared_ptr<const Self>;

  using typename Base::Matrix4;
  using typename Base::PointCloudSource;
  using typename Base::PointCloudSourceConstPtr;
  using typename Base::PointCloudSourcePtr;
  using typename Base::PointCloudTarget;
  using typename Base::PointCloudTargetConstPtr;
  using typename Base::PointCloudTargetPtr;

  using typename Base::PointIndicesConstPtr;
  using typename Base::PointIndicesPtr;

  StructuredSceneRegistration();
  ~StructuredSceneRegistration() override = default;

  // As for pcl::IterativeClosestPoint: a copy would share the search tree of the base.
  StructuredSceneRegistration(const StructuredSceneRegistration&) = delete;
  StructuredSceneRegistration(StructuredSceneRegistration&&) = delete;
  StructuredSceneRegistration&
  operator=(const StructuredSceneRegistration&) = delete;
  StructuredSceneRegistration&
  operator=(StructuredSceneRegistration&&) = delete;

  /** \brief Set the scan to move. Call it again after the cloud was edited in place.
   *
   * A null or empty cloud is refused with PCL_ERROR, and the previous one is kept. Indices set before that lie outside
   * the new cloud are dropped with PCL_WARN.
   */
  void
  setInputSource(const PointCloudSourceConstPtr& cloud) override;

  /// Set the scan to register to; as setInputSource().
  void
  setInputTarget(const PointCloudTargetConstPtr& cloud) override;

  /** \brief Register and return only these points of the source. Null: all points again.
   *
   * Indices outside the source are dropped with PCL_WARN (on a copy, the caller's list is not changed).
   */
  void
  setIndices(const pcl::IndicesPtr& indices) override;
  /// \overload
  void
  setIndices(const pcl::IndicesConstPtr& indices) override;
  /// \overload
  void
  setIndices(const PointIndicesConstPtr& indices) override;
  /// A rectangle of an organised source, which must have been set before.
  void
  setIndices(std::size_t row_start, std::size_t col_start, std::size_t nb_rows, std::size_t nb_cols) override;

  /// Radius of the neighbourhood that normals are estimated in [m]; 0 (default): from the data.
  void
  setNormalRadius(double radius);
  /// Radius of the density filter, a chord on the unit sphere in (0, 1]; 0 (default): the profile's.
  void
  setDensityRadius(double chord);
  /// Width of the bins of the translation histograms [m]; 0 (default): from the data.
  void
  setBinWidth(double width);
  /// Choose the method: Profile::Default, or the paper's as published. Every other option is kept.
  void
  setProfile(Profile profile);
  /// Number of threads; 0: all processors. The result does not depend on it.
  void
  setNumberOfThreads(unsigned threads);
  /// Whether the sensors are believed to be at the viewpoints; see the class description.
  void
  setViewpointMode(ViewpointMode mode);
  /// Position of the source's sensor in the coordinates of the source [m]. Holds for every source set from now on.
  void
  setSourceViewpoint(const Eigen::Vector3d& position);
  /// Position of the target's sensor in the coordinates of the target [m]. Holds for every target set from now on.
  void
  setTargetViewpoint(const Eigen::Vector3d& position);
  /// Use the clouds' `sensor_origin_` again.
  void
  clearViewpoints();
  /** \brief Tell the vertical in both scans: poses that do not map one onto the other are not considered, and where
   * the scans tell the tilt worse than it does, it is kept.
   * \param[in] up_source,up_target directions (any length but 0), in the coordinates of the source and the target
   * \param[in] tolerance largest angle between the mapped and the given vertical [rad], (0, pi]: three standard
   * deviations of what is given
   */
  void
  setGravity(const Eigen::Vector3d& up_source, const Eigen::Vector3d& up_target, double tolerance);
  /// Forget the vertical.
  void
  clearGravity();
  /** \brief Tell how good the guess of align() is, which may then be the identity too: only poses within the tolerance
   * are considered, which is surer and faster.
   * \param[in] rotation largest angle between the rotations [rad], (0, pi]
   * \param[in] translation largest distance between the places of the source's sensor [m], > 0
   */
  void
  setGuessTolerance(double rotation, double translation);
  /// A guess is one candidate among all again.
  void
  clearGuessTolerance();
  /// Polish the answer by robust point-to-plane steps (on by default in Profile::Default).
  void
  setRefinement(bool refine);
  /// End so long after the call of align() [s], with the best answer by then; 0 (default): no limit. Preparation counts
  /// when it is not cached. With a limit, runs may differ.
  void
  setTimeLimit(double seconds);

  /// All options, refused as a whole with PCL_ERROR when one is out of range.
  void
  setOptions(const Options& options);
  /// The options in force, those set through inherited setters included.
  Options
  getOptions() const;

  /// What the last align() found. Status::NotRun since a cloud was set.
  const Result&
  getResult() const
  {
    return result_;
  }
  /// Number of distinct poses that the last align() ended with, getResult().candidates.
  int
  getFinalNumIteration() const
  {
    return nr_iterations_;
  }
  /** \brief The inliers of the last accepted pose, in the order of the indexed points.
   *
   * `index_query` points into the source, `index_match` into the target, `distance` is *squared* [m^2]. Empty when
   * nothing was accepted. They are looked for at the first call after align(), in the clouds as they are then.
   */
  pcl::CorrespondencesConstPtr
  getCorrespondences() const;

protected:
  using Base::converged_;
  using Base::corr_dist_threshold_;
  using Base::correspondence_estimation_;
  using Base::correspondence_rejectors_;
  using Base::correspondences_;
  using Base::euclidean_fitness_epsilon_;
  using Base::fake_indices_;
  using Base::final_transformation_;
  using Base::getClassName;
  using Base::indices_;
  using Base::inlier_threshold_;
  using Base::input_;
  using Base::max_iterations_;
  using Base::nr_iterations_;
  using Base::previous_transformation_;
  using Base::ransac_iterations_;
  using Base::reg_name_;
  using Base::target_;
  using Base::target_cloud_updated_;
  using Base::transformation_;
  using Base::transformation_epsilon_;
  using Base::transformation_estimation_;
  using Base::transformation_rotation_epsilon_;
  using Base::tree_;
  using Base::tree_reciprocal_;
  using Base::update_visualizer_;

  /// Called by align() of the base once the clouds are known to be set; see the class description for what it leaves.
  void
  computeTransformation(PointCloudSource& output, const Matrix4& guess) override;

private:
  /// A setting of the base that has no effect here, one bit each in \ref warned_.
  enum class Ignored : unsigned {
    TransformationEpsilon = 1U << 0U,
    RotationEpsilon = 1U << 1U,
    FitnessEpsilon = 1U << 2U,
    RansacIterations = 1U << 3U,
    RansacThreshold = 1U << 4U,
    TransformationEstimation = 1U << 5U,
    CorrespondenceEstimation = 1U << 6U,
    Rejectors = 1U << 7U,
    SearchMethodSource = 1U << 8U,
    CorrespondenceDistance = 1U << 9U, // not ignored as such, but not a distance
  };

  /// Set the options as \p change leaves a copy of them when that is valid; else report it for \p setter.
  template <typename Change>
  void
  changeOptions(const char* setter, const Change& change);
  void
  dropPrepared();
  /// Nothing was computed for the clouds as they are now.
  void
  resetResult();
  /// Copy the indices without those outside the source.
  void
  cleanIndices(const char* setter);
  /// Warn once of each inherited setting that was changed and has no effect.
  void
  warnOfIgnoredSettings();
  void
  warnOnce(Ignored setting, bool changed, const char* text);
  /// Why \p output cannot be written without harm; empty when it can.
  std::string
  aliasingProblem(const PointCloudSource& output) const;
  /// Prepare what is not cached, register, and store the answer in result_. Never throws.
  void
  runPipeline(const std::optional<Eigen::Isometry3d>& guess, const Options& options, const Deadline& deadline);
  /// Fill correspondences_ with the indexed points that lie nearer to the target than the overlap radius under the pose
  /// of result_.
  void
  findCorrespondences() const;
  /// Call the visualiser with all points of the source moved, and the correspondences.
  void
  notifyVisualizer();

  Options options_;
  std::optional<Eigen::Vector3d> source_viewpoint_;
  std::optional<Eigen::Vector3d> target_viewpoint_;
  PreparedScan prepared_source_; ///< of (input_, indices_) as last announced; empty: to be made
  PreparedScan prepared_target_; ///< of target_ as last announced; empty: to be made
  Result result_;
  mutable bool correspondences_wanted_ = false;     ///< a pose was accepted, and nobody has asked for them yet
  double correspondence_radius_ = 0;                ///< of them [m]; 0: from the data
  unsigned warned_ = 0;                             ///< of Ignored: already reported
  typename Base::KdTreeReciprocalPtr default_tree_; ///< the source's tree that the base made

public:
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

} // namespace pcl_ssfr

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/impl/structured_scene_registration.hpp>
#else
namespace pcl_ssfr {
extern template class StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, float>;
extern template class StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, double>;
extern template class StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal, float>;
extern template class StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal, double>;
extern template class StructuredSceneRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class StructuredSceneRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr
#endif
