// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/detail/finite_query_kdtree.h>
#include <pcl_ssfr/detail/registration_adaptor.h>
#include <pcl_ssfr/impl/cloud_access.hpp>
#include <pcl_ssfr/impl/correspondences.hpp>
#include <pcl_ssfr/impl/registration_support.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace pcl_ssfr::detail {

template <typename PointSource, typename PointTarget, typename Scalar>
RegistrationAdaptor<PointSource, PointTarget, Scalar>::RegistrationAdaptor(const char* name, int max_iterations)
    : default_tree_(tree_reciprocal_)
{
  reg_name_ = name;
  max_iterations_ = max_iterations;
  tree_ = pcl::make_shared<FiniteQueryKdTree<PointTarget>>();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::setInputSource(const PointCloudSourceConstPtr& cloud)
{
  if (!cloud) {
    reportError(getClassName(), "setInputSource", "null cloud given; the old source is kept");
    return;
  }
  Base::setInputSource(cloud);
  if (input_ == cloud) { // else it was empty, which the base has reported
    takeIndices("setInputSource");
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::setInputTarget(const PointCloudTargetConstPtr& cloud)
{
  if (!cloud) {
    reportError(getClassName(), "setInputTarget", "null cloud given; the old target is kept");
    return;
  }
  Base::setInputTarget(cloud);
  if (target_ == cloud) { // else it was empty, which the base has reported
    forgetTarget();
    resetResult();
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::setIndices(const pcl::IndicesPtr& indices)
{
  Base::setIndices(indices);
  takeIndices("setIndices");
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::setIndices(const pcl::IndicesConstPtr& indices)
{
  setIndices(indices ? pcl::make_shared<pcl::Indices>(*indices) : pcl::IndicesPtr());
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::setIndices(const PointIndicesConstPtr& indices)
{
  setIndices(indices ? pcl::make_shared<pcl::Indices>(indices->indices) : pcl::IndicesPtr());
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::setIndices(std::size_t row_start,
                                                                  std::size_t col_start,
                                                                  std::size_t nb_rows,
                                                                  std::size_t nb_cols)
{
  if (!input_) {
    reportError(getClassName(), "setIndices", "a rectangle needs a source, set that first");
    return;
  }
  Base::setIndices(row_start, col_start, nb_rows, nb_cols);
  takeIndices("setIndices");
}

template <typename PointSource, typename PointTarget, typename Scalar>
pcl::CorrespondencesConstPtr
RegistrationAdaptor<PointSource, PointTarget, Scalar>::getCorrespondences() const
{
  if (!correspondences_wanted_) {
    return correspondences_;
  }
  correspondences_wanted_ = false;
  if (input_->size() < aligned_source_size_ || target_->size() < aligned_target_size_) {
    reportWarning(getClassName(), "getCorrespondences", "a cloud has lost points since align(), so there are none");
    return correspondences_;
  }
  // The base's tree, unless the user made it for another cloud.
  typename Base::KdTreePtr tree = tree_;
  if (tree->getInputCloud() != target_) {
    tree = pcl::make_shared<FiniteQueryKdTree<PointTarget>>();
    tree->setInputCloud(target_);
  }
  const auto representation = tree->getPointRepresentation();
  if (std::none_of(
          target_->begin(), target_->end(), [&](const PointTarget& point) { return representation->isValid(point); })) {
    return correspondences_; // PCL's own tree has no index then, and must not be asked
  }
  const double distance =
      answer_.inlier_distance > 0 ? answer_.inlier_distance : inlierDistanceFromData(*target_, *tree, answer_.rmse);
  *correspondences_ = findCorrespondences(
      *input_, *indices_, *target_, *tree, answer_.T_target_source, distance, static_cast<int>(threads()));
  return correspondences_;
}

template <typename PointSource, typename PointTarget, typename Scalar>
double
RegistrationAdaptor<PointSource, PointTarget, Scalar>::maxCorrespondenceDistance() const
{
  return corr_dist_threshold_ > 0 && corr_dist_threshold_ < kUnsetCorrespondenceDistance ? corr_dist_threshold_ : 0;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::computeTransformation(PointCloudSource& output,
                                                                             const Matrix4& guess)
{
  warnOfIgnoredSettings();
  resetResult();

  // A guess that cannot be a pose is not judged; as with ICP it still is the answer of a failed run, if it is finite.
  std::optional<Eigen::Isometry3d> usable_guess;
  Matrix4 fallback = guess;
  if (guess != Matrix4::Identity() || isIdentityAGuess()) {
    usable_guess = rigidGuess(guess.template cast<double>());
    if (!usable_guess) {
      fallback = guess.allFinite() ? guess : Matrix4(Matrix4::Identity());
      if (!isIdentityAGuess())
        reportWarning(getClassName(), "align", "the guess is not a rigid motion and is ignored");
    }
  }
  previous_transformation_ = fallback;
  final_transformation_ = fallback;
  transformation_ = fallback;

  const std::string problem = aliasingProblem(output);
  if (!problem.empty()) {
    reject(problem);
    reportError(getClassName(), "align", problem);
    forgetSource(); // at least one of the clouds is no longer what it was, nor what the tree indexes
    forgetTarget();
    target_cloud_updated_ = true;
    const PointCloudSource before = output;
    moveCloud(before, everyIndex(before.size()), final_transformation_, output);
    return;
  }

  if (isIdentityAGuess() && !usable_guess) {
    const std::string refusal = "the guess is not a rigid motion, and only poses near it are asked for";
    reject(refusal);
    reportError(getClassName(), "align", refusal);
  }
  else {
    answer_ = findPose(usable_guess);
  }
  nr_iterations_ = answer_.iterations;
  converged_ = answer_.is_accepted;
  if (converged_) {
    final_transformation_ = rigidMatrix(answer_.T_target_source).template cast<Scalar>();
    transformation_ = final_transformation_;
    correspondences_wanted_ = true;
    aligned_source_size_ = input_->size();
    aligned_target_size_ = target_->size();
  }
  if (update_visualizer_) {
    notifyVisualizer();
  }

  if (&output != input_.get()) {
    if (final_transformation_ == Matrix4::Identity()) { // the base has copied the points
      output.sensor_origin_ = input_->sensor_origin_;
      output.sensor_orientation_ = input_->sensor_orientation_;
      return;
    }
    moveCloud(*input_, *indices_, final_transformation_, output);
    return;
  }
  getCorrespondences(); // while the source is there
  PointCloudSource moved;
  moveCloud(*input_, *indices_, final_transformation_, moved);
  forgetSource();
  output.swap(moved);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::resetResult()
{
  converged_ = false;
  nr_iterations_ = 0;
  correspondences_ = pcl::make_shared<pcl::Correspondences>(); // who has asked for the old ones keeps them
  correspondences_wanted_ = false;
  answer_ = Answer();
  clearResult();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::takeIndices(const char* setter)
{
  if (input_ && indices_ && !fake_indices_) {
    pcl::Indices kept = *indices_;
    const std::size_t dropped = dropOutOfRange(kept, input_->size());
    if (dropped > 0) {
      reportWarning(getClassName(),
                    setter,
                    std::to_string(dropped) + " indices lie outside the source of " + std::to_string(input_->size()) +
                        " points and are dropped");
      indices_ = pcl::make_shared<pcl::Indices>(std::move(kept));
    }
  }
  forgetSource();
  resetResult();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::warnOnce(Ignored setting, bool changed, const char* text)
{
  const auto bit = static_cast<unsigned>(setting);
  if (changed && (warned_ & bit) == 0) {
    warned_ |= bit;
    reportWarning(getClassName(), "align", text);
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::warnOfIgnoredSettings()
{
  // Against the defaults of pcl::Registration. Exact comparison: they were either touched or not.
  const auto differs = [](double value, double standard) { return !(value <= standard && value >= standard); };
  constexpr double kDefaultInlierThreshold = 0.05;
  warnOnce(
      Ignored::TransformationEpsilon, differs(transformation_epsilon_, 0), "setTransformationEpsilon has no effect");
  warnOnce(Ignored::RotationEpsilon,
           differs(transformation_rotation_epsilon_, 0),
           "setTransformationRotationEpsilon has no effect");
  warnOnce(Ignored::FitnessEpsilon,
           differs(euclidean_fitness_epsilon_, -std::numeric_limits<double>::max()),
           "setEuclideanFitnessEpsilon has no effect");
  warnOnce(Ignored::RansacIterations, ransac_iterations_ != 0, "setRANSACIterations has no effect");
  warnOnce(Ignored::RansacThreshold,
           differs(inlier_threshold_, kDefaultInlierThreshold),
           "setRANSACOutlierRejectionThreshold has no effect");
  warnOnce(Ignored::TransformationEstimation,
           transformation_estimation_ != nullptr,
           "setTransformationEstimation has no effect");
  warnOnce(Ignored::CorrespondenceEstimation,
           correspondence_estimation_ != nullptr,
           "setCorrespondenceEstimation has no effect");
  warnOnce(Ignored::Rejectors, !correspondence_rejectors_.empty(), "addCorrespondenceRejector has no effect");
  warnOnce(Ignored::SearchMethodSource, tree_reciprocal_ != default_tree_, "setSearchMethodSource has no effect");
  warnOnce(Ignored::CorrespondenceDistance,
           !(corr_dist_threshold_ > 0),
           "the maximum correspondence distance must be > 0; one from the data is used");
}

template <typename PointSource, typename PointTarget, typename Scalar>
std::string
RegistrationAdaptor<PointSource, PointTarget, Scalar>::aliasingProblem(const PointCloudSource& output) const
{
  // align() of the base has already written the indexed source points into the output.
  if (static_cast<const void*>(&output) == static_cast<const void*>(target_.get())) {
    return "the output is the target, which it has overwritten; set the target again and give another output";
  }
  if (&output == input_.get() && !fake_indices_ && !isEveryPointInOrder(*indices_, input_->size())) {
    return "the output is the source, and indices are set: the source was overwritten; set it again and give another "
           "output";
  }
  return {};
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
RegistrationAdaptor<PointSource, PointTarget, Scalar>::notifyVisualizer()
{
  PointCloudSource moved;
  moveCloud(*input_, everyIndex(input_->size()), final_transformation_, moved);
  pcl::Indices source_indices;
  pcl::Indices target_indices;
  for (const pcl::Correspondence& pair : *getCorrespondences()) {
    source_indices.push_back(pair.index_query);
    target_indices.push_back(pair.index_match);
  }
  update_visualizer_(moved, source_indices, *target_, target_indices);
}

} // namespace pcl_ssfr::detail
