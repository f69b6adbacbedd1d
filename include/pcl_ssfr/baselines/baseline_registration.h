// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_result.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/memory.h>
#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <optional>
#include <string>

namespace pcl_ssfr::baselines {

/** \brief What the comparison methods have in common: all of pcl::Registration's contract, but not the method.
 *
 * A method derives from it and implements runMethod() on two ScanView.
 *
 * **Result.** hasConverged() is true only when the method accepted its pose; getMessage() gives the reason.
 * getFinalTransformation() maps the original source onto the target, a guess included. Without an accepted pose it is
 * the guess, and the output is the source moved by it, as after a failed pcl::IterativeClosestPoint. What was found but
 * not accepted is in getResult().
 *
 * **Output.** The indexed points of the source in their order, moved; normals are rotated when the point type carries
 * them, all other fields and the header are kept. Non-finite points stay where they are. The output must not be the
 * target, nor the source while indices are set that are not simply all points: PCL has then overwritten the cloud
 * before this class is asked, and the call is reported and does not converge.
 *
 * **Input.** A null or empty cloud is refused with PCL_ERROR and the previous one is kept. Non-finite points are
 * skipped; indices outside the source are dropped with PCL_WARN. Nothing is cached from one align() to the next.
 *
 * **Inherited settings.** setMaxCorrespondenceDistance() (the distance threshold [m]), setMaximumIterations(),
 * setIndices(), setSearchMethodTarget() (for getFitnessScore() and getCorrespondences()) and
 * registerVisualizationCallback() are honoured. Ignored, and reported once by PCL_WARN when changed:
 * setTransformationEpsilon, setTransformationRotationEpsilon, setEuclideanFitnessEpsilon, setRANSACIterations,
 * setRANSACOutlierRejectionThreshold, setTransformationEstimation, setCorrespondenceEstimation and
 * addCorrespondenceRejector. setSearchMethodSource is ignored.
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT BaselineRegistration : public pcl::Registration<PointSource, PointTarget, Scalar> {
public:
  /// The base class.
  using Base = pcl::Registration<PointSource, PointTarget, Scalar>;
  /// This class.
  using Self = BaselineRegistration<PointSource, PointTarget, Scalar>;
  /// Shared pointer to it.
  using Ptr = pcl::shared_ptr<Self>;
  /// Shared pointer to a constant one.
  using ConstPtr = pcl::shared_ptr<const Self>;

  using typename Base::Matrix4;
  using typename Base::PointCloudSource;
  using typename Base::PointCloudSourceConstPtr;
  using typename Base::PointCloudTarget;
  using typename Base::PointCloudTargetConstPtr;
  using typename Base::PointIndicesConstPtr;

  ~BaselineRegistration() override = default;

  // As for pcl::IterativeClosestPoint: a copy would share the search tree of the base.
  BaselineRegistration(const BaselineRegistration&) = delete;
  BaselineRegistration(BaselineRegistration&&) = delete;
  BaselineRegistration&
  operator=(const BaselineRegistration&) = delete;
  BaselineRegistration&
  operator=(BaselineRegistration&&) = delete;

  /// Set the scan to move; a null or empty one is refused with PCL_ERROR.
  void
  setInputSource(const PointCloudSourceConstPtr& cloud) override;
  /// Set the scan to register to; a null or empty one is refused with PCL_ERROR.
  void
  setInputTarget(const PointCloudTargetConstPtr& cloud) override;

  /// Register and return only these points of the source. Null: all points again.
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

  /// Number of threads; 0 (default): all processors. The result does not depend on it.
  void
  setNumberOfThreads(unsigned threads)
  {
    threads_ = threads;
  }

  /// What the last align() found; empty since a cloud was set.
  const BaselineResult&
  getResult() const
  {
    return result_;
  }
  /// Why the last align() did or did not converge.
  const std::string&
  getMessage() const
  {
    return result_.message;
  }
  /// Steps or samples that the last align() took.
  int
  getFinalNumIteration() const
  {
    return nr_iterations_;
  }
  /** \brief Indexed points of the source and their nearest points of the target within the distance threshold, under
   * the last accepted pose. `distance` is *squared* [m^2]. Empty when nothing was accepted.
   */
  pcl::CorrespondencesConstPtr
  getCorrespondences() const
  {
    return correspondences_;
  }

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
  using Base::update_visualizer_;

  /// \p name is what PCL prints as the class; setMaximumIterations() starts at 0, "as the method sees fit".
  explicit BaselineRegistration(const char* name);

  /** \brief The method itself: the pose of \p source in the frame of \p target.
   * \param[in] source,target borrowed points, non-finite ones among them
   * \param[in] guess a rigid motion given by the caller, if any; the answer is absolute, not relative to it
   *
   * An exception makes the run fail with its text as the message.
   */
  virtual BaselineResult
  runMethod(const ScanView& source, const ScanView& target, const std::optional<Eigen::Isometry3d>& guess) const = 0;

  /// setMaxCorrespondenceDistance() [m]; 0 when it is unset or no distance.
  double
  distanceThreshold() const;
  /// Threads to use, at least 1.
  unsigned
  threads() const;

  /// Called by align() of the base once the clouds are known to be set: runs the method and fills the output.
  void
  computeTransformation(PointCloudSource& output, const Matrix4& guess) final;

private:
  void
  resetResult();
  /// Copy the indices without those outside the source.
  void
  cleanIndices(const char* setter);
  void
  warnOfIgnoredSettings();
  /// Why \p output cannot be written without harm; empty when it can.
  std::string
  aliasingProblem(const PointCloudSource& output) const;
  void
  findCorrespondences();
  void
  notifyVisualizer();

  BaselineResult result_;
  unsigned threads_ = 0;
  bool warned_ = false;

public:
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

} // namespace pcl_ssfr::baselines

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/baselines/impl/baseline_registration.hpp>
#else
namespace pcl_ssfr::baselines {
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointNormal, pcl::PointNormal, float>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointNormal, pcl::PointNormal, double>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class PCL_SSFR_EXPORT BaselineRegistration<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::baselines
#endif
