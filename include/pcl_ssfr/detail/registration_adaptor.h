// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/export.h>

#include <pcl/memory.h>
#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <optional>
#include <string>

namespace pcl_ssfr::detail {

/** \brief Everything that pcl::Registration promises, but not the method: what StructuredSceneRegistration and the
 * comparison methods have in common.
 *
 * A method derives from it and implements findPose(); the class description of StructuredSceneRegistration says what
 * holds for input, output, guess, indices, correspondences and inherited settings.
 */
template <typename PointSource, typename PointTarget, typename Scalar = float>
class PCL_SSFR_EXPORT RegistrationAdaptor : public pcl::Registration<PointSource, PointTarget, Scalar> {
public:
  /// The base class of PCL.
  using Base = pcl::Registration<PointSource, PointTarget, Scalar>;

  using typename Base::Matrix4;
  using typename Base::PointCloudSource;
  using typename Base::PointCloudSourceConstPtr;
  using typename Base::PointCloudSourcePtr;
  using typename Base::PointCloudTarget;
  using typename Base::PointCloudTargetConstPtr;
  using typename Base::PointCloudTargetPtr;
  using typename Base::PointIndicesConstPtr;
  using typename Base::PointIndicesPtr;

  ~RegistrationAdaptor() override = default;

  // As for pcl::IterativeClosestPoint: a copy would share the search tree of the base.
  RegistrationAdaptor(const RegistrationAdaptor&) = delete;
  RegistrationAdaptor(RegistrationAdaptor&&) = delete;
  RegistrationAdaptor&
  operator=(const RegistrationAdaptor&) = delete;
  RegistrationAdaptor&
  operator=(RegistrationAdaptor&&) = delete;

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

  /// Number of iterations that the last align() reports; see the method.
  int
  getFinalNumIteration() const
  {
    return nr_iterations_;
  }
  /** \brief The inliers of the last accepted pose, in the order of the indexed points.
   *
   * `index_query` points into the source, `index_match` into the target, `distance` is *squared* [m^2]. Empty when
   * nothing was accepted. They are looked for at the first call after align(), in the clouds as they are then; when
   * one of them has lost points since, there are none, with PCL_WARN. A list that was handed out does not change.
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

  /// What a method hands back.
  struct Answer {
    bool is_accepted = false;                                          ///< the pose may be used
    Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity(); ///< absolute; read when accepted
    int iterations = 0;                                                ///< for getFinalNumIteration()
    double inlier_distance = 0; ///< of the correspondences [m]; 0: from the spacing of the target and rmse
    double rmse = 0;            ///< [m]
  };

  /// \p name is what PCL prints as the class, \p max_iterations the default of setMaximumIterations().
  RegistrationAdaptor(const char* name, int max_iterations);

  /** \brief The method: register the source, of which the indexed points only, to the target. Must not throw.
   * \param[in] guess the caller's, as a rigid motion; none when there is none that is one
   */
  virtual Answer
  findPose(const std::optional<Eigen::Isometry3d>& guess) = 0;
  /// align() ends without the method, for the reason \p problem, which was reported.
  virtual void
  reject(const std::string& problem) = 0;
  /// Nothing is known of the clouds as they are now: the last result goes.
  virtual void
  clearResult() = 0;
  /// What was derived from the source goes, but not the last result.
  virtual void
  forgetSource()
  {}
  /// The same of the target.
  virtual void
  forgetTarget()
  {}
  /// Whether the identity is a guess as well; otherwise it means that there is none.
  virtual bool
  isIdentityAGuess() const
  {
    return false;
  }
  /// Threads to use, >= 1.
  virtual unsigned
  threads() const = 0;

  /// setMaxCorrespondenceDistance() [m]; 0 when it is unset or no distance.
  double
  maxCorrespondenceDistance() const;

  /// Called by align() of the base once the clouds are known to be set.
  void
  computeTransformation(PointCloudSource& output, const Matrix4& guess) final;

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

  void
  resetResult();
  /// The source or its indices are others: those outside the source are dropped (on a copy), and what was derived goes.
  void
  takeIndices(const char* setter);
  /// Warn once of each inherited setting that was changed and has no effect.
  void
  warnOfIgnoredSettings();
  void
  warnOnce(Ignored setting, bool changed, const char* text);
  /// Why \p output cannot be written without harm; empty when it can.
  std::string
  aliasingProblem(const PointCloudSource& output) const;
  /// Call the visualiser with all points of the source moved, and the correspondences.
  void
  notifyVisualizer();

  Answer answer_;                               ///< of the last align()
  mutable bool correspondences_wanted_ = false; ///< a pose was accepted, and nobody has asked for them yet
  std::size_t aligned_source_size_ = 0;         ///< of the clouds of that answer
  std::size_t aligned_target_size_ = 0;
  unsigned warned_ = 0;                             ///< of Ignored: already reported
  typename Base::KdTreeReciprocalPtr default_tree_; ///< the source's tree that the base made

public:
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

} // namespace pcl_ssfr::detail

#ifdef PCL_NO_PRECOMPILE
#include <pcl_ssfr/impl/registration_adaptor.hpp>
#else
namespace pcl_ssfr::detail {
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZ, pcl::PointXYZ, float>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZ, pcl::PointXYZ, double>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZI, pcl::PointXYZI, float>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZI, pcl::PointXYZI, double>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZRGB, pcl::PointXYZRGB, float>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZRGB, pcl::PointXYZRGB, double>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointNormal, pcl::PointNormal, float>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointNormal, pcl::PointNormal, double>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZINormal, pcl::PointXYZINormal, float>;
extern template class PCL_SSFR_EXPORT RegistrationAdaptor<pcl::PointXYZINormal, pcl::PointXYZINormal, double>;
} // namespace pcl_ssfr::detail
#endif
