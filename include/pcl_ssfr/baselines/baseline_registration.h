// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_result.h>
#include <pcl_ssfr/detail/registration_adaptor.h>
#include <pcl_ssfr/export.h>
#include <pcl_ssfr/scan_view.h>

#include <pcl/memory.h>
#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

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
 * setRANSACOutlierRejectionThreshold, setTransformationEstimation, setCorrespondenceEstimation,
 * addCorrespondenceRejector and setSearchMethodSource. getFinalNumIteration() is the number of steps or samples.
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT BaselineRegistration
    : public pcl_ssfr::detail::RegistrationAdaptor<PointSource, PointTarget, Scalar> {
public:
  /// What it has in common with the other registration classes of this library.
  using Adaptor = pcl_ssfr::detail::RegistrationAdaptor<PointSource, PointTarget, Scalar>;
  /// The base class.
  using Base = pcl::Registration<PointSource, PointTarget, Scalar>;
  /// This class.
  using Self = BaselineRegistration<PointSource, PointTarget, Scalar>;
  /// Shared pointer to it.
  using Ptr = pcl::shared_ptr<Self>;
  /// Shared pointer to a constant one.
  using ConstPtr = pcl::shared_ptr<const Self>;

  using typename Adaptor::Matrix4;
  using typename Adaptor::PointCloudSource;
  using typename Adaptor::PointCloudSourceConstPtr;
  using typename Adaptor::PointCloudTarget;
  using typename Adaptor::PointCloudTargetConstPtr;
  using typename Adaptor::PointIndicesConstPtr;

  ~BaselineRegistration() override = default;

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

protected:
  using Adaptor::fake_indices_;
  using Adaptor::getClassName;
  using Adaptor::indices_;
  using Adaptor::input_;
  using Adaptor::max_iterations_;
  using Adaptor::target_;

  using typename Adaptor::Answer;

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

  unsigned
  /// Threads to use, at least 1.
  threads() const override;

private:
  Answer
  findPose(const std::optional<Eigen::Isometry3d>& guess) final;
  void
  reject(const std::string& problem) final;
  void
  clearResult() final;

  BaselineResult result_;
  unsigned threads_ = 0;

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
