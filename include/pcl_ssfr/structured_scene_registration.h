// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/deadline.h>
#include <pcl_ssfr/detail/registration_adaptor.h>
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
 * **Result.** hasConverged() is true only when a pose was accepted; getResult() gives the status and the reason, the
 * ranked candidates, the overlap, a confidence and what the scene does not determine. getFinalTransformation() maps
 * the original source onto the target, a guess included. Without an accepted pose it is the guess, as after a failed
 * pcl::IterativeClosestPoint, and the output is the source moved by it. getFinalNumIteration() is the number of
 * distinct poses that the search ended with, getResult().candidates.
 *
 * **Output.** The indexed points of the source in their order, moved; normals are rotated when the point type carries
 * them, every other field and the header are kept. Non-finite points stay where they are. `sensor_origin_` is copied
 * without being moved, as by ICP. align(*source) is allowed without indices; with indices that are not simply all
 * points PCL itself has overwritten the source before this class is asked, so such a call is reported as
 * Status::InvalidInput, and so is an output that is the target.
 *
 * **Viewpoint.** Normals are oriented towards the sensor, and space between it and the points is taken to be free. The
 * sensor is at each cloud's `sensor_origin_`, which PCL does not move along with the points: on merged or moved clouds
 * it is wrong. By default (ViewpointMode::Auto) it is used only when the points agree with it. setSourceViewpoint() and
 * setTargetViewpoint() give it explicitly; ViewpointMode::Unknown never uses it. Points exactly there are what did not
 * return, as many drivers write it: like those that are not finite, they take no part.
 *
 * **Guess.** Never needed and never harmful: a guess other than the identity is judged as one more candidate. With
 * setGuessTolerance() it is a prior instead, and align() with a guess that is no rigid motion does not converge.
 *
 * **Cached work.** The target and the source are prepared once and kept until their setter (or setIndices(), or the
 * setter of a viewpoint) is called again, or align() finds another value of an option that the preparation reads
 * (PreparationOptions, and the stages of the profile). A cloud edited in place must therefore be set again.
 *
 * **Work on demand.** The search tree of the target takes 2.6 times the memory of a cloud of pcl::PointXYZ, and the
 * registration does not use it: it is built by the first call of getFitnessScore() or getCorrespondences(), from the
 * points that the target had when it was set, as they are then, unlike with ICP: what was appended since is left out,
 * and a target that has lost points has no neighbours. So is the list of correspondences. A search method that was set
 * by setSearchMethodTarget() is filled at once, as PCL does. Where no correspondence distance was set,
 * getCorrespondences() measures the spacing of the target by PCL's tree, which takes three times that cloud besides.
 *
 * **Time limit.** setTimeLimit() bounds the whole of align(), preparation included, but for the copying of the source
 * into the output. When it ends the preparation, the status is Status::TimeLimit, the message names the stage, and the
 * scans that were not ready are prepared again by the next align(). When it ends the search, the status is the same,
 * and getResult() holds the best poses so far; none of them is accepted.
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
class PCL_SSFR_EXPORT StructuredSceneRegistration
    : public detail::RegistrationAdaptor<PointSource, PointTarget, Scalar> {
public:
  /// What it has in common with the other registration classes of this library.
  using Adaptor = detail::RegistrationAdaptor<PointSource, PointTarget, Scalar>;
  /// The base class.
  using Base = pcl::Registration<PointSource, PointTarget, Scalar>;
  /// This class.
  using Self = StructuredSceneRegistration<PointSource, PointTarget, Scalar>;
  /// Shared pointer to it.
  using Ptr = pcl::shared_ptr<Self>;
  /// Shared pointer to a constant one.
  using ConstPtr = pcl::shared_ptr<const Self>;

  using typename Adaptor::Matrix4;
  using typename Adaptor::PointCloudSource;
  using typename Adaptor::PointCloudSourceConstPtr;
  using typename Adaptor::PointCloudSourcePtr;
  using typename Adaptor::PointCloudTarget;
  using typename Adaptor::PointCloudTargetConstPtr;
  using typename Adaptor::PointCloudTargetPtr;
  using typename Adaptor::PointIndicesConstPtr;
  using typename Adaptor::PointIndicesPtr;

  StructuredSceneRegistration();
  ~StructuredSceneRegistration() override = default;

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
  /// Whether the sensors are taken to be at the viewpoints; see the class description.
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
  /** \brief Give the vertical in both scans: poses that do not map one onto the other are not considered, and where the
   * scans determine the tilt worse than it does, it is kept.
   * \param[in] up_source,up_target directions (any length but 0), in the coordinates of the source and the target
   * \param[in] tolerance largest angle between the mapped and the given vertical [rad], (0, pi]: three standard
   * deviations of the given directions
   */
  void
  setGravity(const Eigen::Vector3d& up_source, const Eigen::Vector3d& up_target, double tolerance);
  /// Remove the prior on the vertical.
  void
  clearGravity();
  /** \brief Say how accurate the guess of align() is, which may then be the identity too: only poses within these
   * bounds are considered, which is more reliable and faster.
   * \param[in] rotation largest angle between the rotations [rad], (0, pi]
   * \param[in] translation largest distance between the positions of the source's sensor [m], > 0
   */
  void
  setGuessTolerance(double rotation, double translation);
  /// A guess is one candidate among all again.
  void
  clearGuessTolerance();
  /// Polish the answer by robust point-to-plane steps (on by default in Profile::Default).
  void
  setRefinement(bool refine);
  /// Limit the time of align() [s]: it ends with the best poses so far, none accepted; 0 (default): no limit.
  /// Preparation counts when it is not cached. With a limit, runs may differ.
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
  /// Maximum correspondence distance for a local refiner that starts from the pose that the last align() found [m]:
  /// Result::correspondence_distance; 0 when no pose was judged.
  double
  getCorrespondenceDistance() const
  {
    return result_.correspondence_distance;
  }
  /** \brief The evidence for a pose from elsewhere, such as one that a local refiner made of ours: see
   * pcl_ssfr::scorePose(). The clouds need no align() before; what is prepared is used.
   * \param[in] T_target_source maps points of the source into the target; rigid to the precision of float
   * \return nothing, with PCL_ERROR, when a cloud is not set or the matrix is no rigid motion
   */
  std::optional<Candidate>
  scorePose(const Matrix4& T_target_source);

protected:
  using Adaptor::corr_dist_threshold_;
  using Adaptor::fake_indices_;
  using Adaptor::getClassName;
  using Adaptor::indices_;
  using Adaptor::input_;
  using Adaptor::max_iterations_;
  using Adaptor::target_;

  using typename Adaptor::Answer;

private:
  /// Prepare what is not cached, and register.
  Answer
  findPose(const std::optional<Eigen::Isometry3d>& guess) override;
  void
  reject(const std::string& problem) override;
  void
  clearResult() override
  {
    result_ = Result();
  }
  void
  forgetSource() override
  {
    prepared_source_ = PreparedScan();
  }
  void
  forgetTarget() override
  {
    prepared_target_ = PreparedScan();
  }
  bool
  isIdentityAGuess() const override
  {
    return options_.guess_tolerance.has_value();
  }
  unsigned
  threads() const override
  {
    return threadCount(options_);
  }

  /// Set the options as \p change leaves a copy of them when that is valid; else report it for \p setter.
  template <typename Change>
  void
  changeOptions(const char* setter, const Change& change);
  /// Set a viewpoint unless it is not finite; the scan is prepared anew then.
  void
  setViewpoint(const char* setter,
               const Eigen::Vector3d& position,
               std::optional<Eigen::Vector3d>& viewpoint,
               PreparedScan& prepared);
  /// Fill what is not prepared, or with other options.
  void
  prepare(const Options& options, const Deadline& deadline);

  Options options_;
  std::optional<Eigen::Vector3d> source_viewpoint_;
  std::optional<Eigen::Vector3d> target_viewpoint_;
  PreparedScan prepared_source_; ///< of (input_, indices_) as last announced; empty: to be made
  PreparedScan prepared_target_; ///< of target_ as last announced; empty: to be made
  Result result_;

public:
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

} // namespace pcl_ssfr

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/impl/structured_scene_registration.hpp>
#else
namespace pcl_ssfr {
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, float>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZRGB, pcl::PointXYZRGB, double>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal, float>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointNormal, pcl::PointNormal, double>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class PCL_SSFR_EXPORT StructuredSceneRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr
#endif
