// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/baselines/baseline_registration.h>
#include <pcl_ssfr/detail/finite_query_kdtree.h>
#include <pcl_ssfr/impl/registration_support.h>
#include <pcl_ssfr/impl/structured_scene_registration.hpp>

#include <pcl/common/io.h>
#include <pcl/common/point_tests.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::baselines {

template <typename PointSource, typename PointTarget, typename Scalar>
BaselineRegistration<PointSource, PointTarget, Scalar>::BaselineRegistration(const char* name)
{
  reg_name_ = name;
  max_iterations_ = 0;
  tree_ = pcl::make_shared<FiniteQueryKdTree<PointTarget>>();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::setInputSource(const PointCloudSourceConstPtr& cloud)
{
  if (!cloud) {
    pcl_ssfr::detail::reportError(getClassName(), "setInputSource", "null cloud given; the old source is kept");
    return;
  }
  Base::setInputSource(cloud);
  if (input_ == cloud) { // else it was empty, which the base has reported
    cleanIndices("setInputSource");
    resetResult();
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::setInputTarget(const PointCloudTargetConstPtr& cloud)
{
  if (!cloud) {
    pcl_ssfr::detail::reportError(getClassName(), "setInputTarget", "null cloud given; the old target is kept");
    return;
  }
  Base::setInputTarget(cloud);
  if (target_ == cloud) { // else it was empty, which the base has reported
    resetResult();
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::setIndices(const pcl::IndicesPtr& indices)
{
  Base::setIndices(indices);
  cleanIndices("setIndices");
  resetResult();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::setIndices(const pcl::IndicesConstPtr& indices)
{
  setIndices(indices ? pcl::make_shared<pcl::Indices>(*indices) : pcl::IndicesPtr());
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::setIndices(const PointIndicesConstPtr& indices)
{
  setIndices(indices ? pcl::make_shared<pcl::Indices>(indices->indices) : pcl::IndicesPtr());
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::setIndices(std::size_t row_start,
                                                                   std::size_t col_start,
                                                                   std::size_t nb_rows,
                                                                   std::size_t nb_cols)
{
  if (!input_) {
    pcl_ssfr::detail::reportError(getClassName(), "setIndices", "a rectangle needs a source, set that first");
    return;
  }
  Base::setIndices(row_start, col_start, nb_rows, nb_cols);
  cleanIndices("setIndices");
  resetResult();
}

template <typename PointSource, typename PointTarget, typename Scalar>
double
BaselineRegistration<PointSource, PointTarget, Scalar>::distanceThreshold() const
{
  const bool is_set = corr_dist_threshold_ > 0 && corr_dist_threshold_ < pcl_ssfr::detail::kUnsetCorrespondenceDistance;
  return is_set ? corr_dist_threshold_ : 0;
}

template <typename PointSource, typename PointTarget, typename Scalar>
unsigned
BaselineRegistration<PointSource, PointTarget, Scalar>::threads() const
{
  return pcl_ssfr::threadCount(threads_);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::computeTransformation(PointCloudSource& output,
                                                                              const Matrix4& guess)
{
  warnOfIgnoredSettings();
  resetResult();

  // A guess that cannot be a pose is not judged; as with ICP it still is the answer of a failed run, if it is finite.
  std::optional<Eigen::Isometry3d> usable_guess;
  Matrix4 fallback = guess;
  if (guess != Matrix4::Identity()) {
    usable_guess = pcl_ssfr::detail::rigidGuess(guess.template cast<double>());
    if (!usable_guess) {
      pcl_ssfr::detail::reportWarning(getClassName(), "align", "the guess is not a rigid motion and is ignored");
      fallback = guess.allFinite() ? guess : Matrix4(Matrix4::Identity());
    }
  }
  previous_transformation_ = fallback;
  final_transformation_ = fallback;
  transformation_ = fallback;

  const std::string problem = aliasingProblem(output);
  if (!problem.empty()) {
    result_.message = problem;
    pcl_ssfr::detail::reportError(getClassName(), "align", problem);
    target_cloud_updated_ = true; // one of the clouds is no longer what it was
    const PointCloudSource before = output;
    pcl::Indices all(before.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = static_cast<pcl::index_t>(i);
    }
    pcl_ssfr::detail::moveCloud(before, all, final_transformation_, output);
    return;
  }

  try {
    const pcl::Indices* indices = fake_indices_ ? nullptr : indices_.get();
    result_ = runMethod(pcl_ssfr::detail::viewOf(*input_, indices, std::nullopt),
                        pcl_ssfr::detail::viewOf(*target_, nullptr, std::nullopt),
                        usable_guess);
  }
  catch (const std::exception& error) {
    result_ = BaselineResult();
    result_.message = error.what();
    pcl_ssfr::detail::reportError(getClassName(), "align", error.what());
  }
  nr_iterations_ = result_.iterations;
  converged_ = result_.converged;
  if (converged_) {
    final_transformation_ = pcl_ssfr::detail::rigidMatrix(result_.T_target_source).template cast<Scalar>();
    transformation_ = final_transformation_;
    findCorrespondences();
  }
  if (update_visualizer_) {
    notifyVisualizer();
  }

  // Last of all, because the output may be the source.
  PointCloudSource moved;
  pcl_ssfr::detail::moveCloud(*input_, *indices_, final_transformation_, moved);
  output.swap(moved);
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::resetResult()
{
  converged_ = false;
  nr_iterations_ = 0;
  correspondences_->clear();
  result_ = BaselineResult();
  result_.message = "align() was not called";
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::cleanIndices(const char* setter)
{
  if (!input_ || !indices_ || fake_indices_) {
    return;
  }
  pcl::Indices kept = *indices_;
  const std::size_t dropped = pcl_ssfr::detail::dropOutOfRange(kept, input_->size());
  if (dropped > 0) {
    pcl_ssfr::detail::reportWarning(getClassName(),
                                    setter,
                                    std::to_string(dropped) + " indices lie outside the source of " +
                                        std::to_string(input_->size()) + " points and are dropped");
    indices_ = pcl::make_shared<pcl::Indices>(std::move(kept));
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::warnOfIgnoredSettings()
{
  if (warned_) {
    return;
  }
  // Against the defaults of pcl::Registration. Exact comparison: they were either touched or not.
  const auto differs = [](double value, double standard) { return !(value <= standard && value >= standard); };
  constexpr double kDefaultInlierThreshold = 0.05;
  std::string names;
  const auto note = [&names](bool changed, const char* name) {
    if (changed) {
      names += (names.empty() ? "" : ", ") + std::string(name);
    }
  };
  note(differs(transformation_epsilon_, 0), "setTransformationEpsilon");
  note(differs(transformation_rotation_epsilon_, 0), "setTransformationRotationEpsilon");
  note(differs(euclidean_fitness_epsilon_, -std::numeric_limits<double>::max()), "setEuclideanFitnessEpsilon");
  note(ransac_iterations_ != 0, "setRANSACIterations");
  note(differs(inlier_threshold_, kDefaultInlierThreshold), "setRANSACOutlierRejectionThreshold");
  note(transformation_estimation_ != nullptr, "setTransformationEstimation");
  note(correspondence_estimation_ != nullptr, "setCorrespondenceEstimation");
  note(!correspondence_rejectors_.empty(), "addCorrespondenceRejector");
  if (!names.empty()) {
    warned_ = true;
    pcl_ssfr::detail::reportWarning(getClassName(), "align", "no effect of " + names);
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
std::string
BaselineRegistration<PointSource, PointTarget, Scalar>::aliasingProblem(const PointCloudSource& output) const
{
  // align() of the base has already written the indexed source points into the output.
  if (static_cast<const void*>(&output) == static_cast<const void*>(target_.get())) {
    return "the output is the target, which it has overwritten; set the target again and give another output";
  }
  if (&output == input_.get() && !fake_indices_ && !pcl_ssfr::detail::isEveryPointInOrder(*indices_, input_->size())) {
    return "the output is the source, and indices are set: the source was overwritten; set it again and give another "
           "output";
  }
  return {};
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::findCorrespondences()
{
  // The base's tree, unless the user made it for another cloud.
  typename Base::KdTreePtr tree = tree_;
  if (tree->getInputCloud() != target_) {
    tree = pcl::make_shared<FiniteQueryKdTree<PointTarget>>();
    tree->setInputCloud(target_);
  }
  const auto representation = tree->getPointRepresentation();
  // One slot a point, gathered in order: the same for any number of threads.
  const auto count = static_cast<std::ptrdiff_t>(indices_->size());
  std::vector<pcl::index_t> matches(indices_->size(), pcl::UNAVAILABLE);
  std::vector<float> squared_distances(indices_->size(), 0.0F);
  const double squared_radius = result_.inlier_distance * result_.inlier_distance;
#ifdef _OPENMP
#pragma omp parallel num_threads(static_cast <int>(threads()))
#endif
  {
    pcl::Indices neighbor(1);
    std::vector<float> tree_distance(1);
#ifdef _OPENMP
#pragma omp for schedule(dynamic, 1024)
#endif
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const auto slot = static_cast<std::size_t>(i);
      const PointSource& point = (*input_)[static_cast<std::size_t>((*indices_)[slot])];
      if (!pcl::isXYZFinite(point)) {
        continue;
      }
      PointTarget query;
      pcl::copyPoint(point, query);
      query.getVector3fMap() =
          (result_.T_target_source * point.getVector3fMap().template cast<double>()).template cast<float>();
      if (!representation->isValid(query) || tree->nearestKSearch(query, 1, neighbor, tree_distance) != 1) {
        continue;
      }
      const PointTarget& match = (*target_)[static_cast<std::size_t>(neighbor[0])];
      const float squared = (match.getVector3fMap() - query.getVector3fMap()).squaredNorm();
      if (static_cast<double>(squared) <= squared_radius) {
        matches[slot] = neighbor[0];
        squared_distances[slot] = squared;
      }
    }
  }
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] != pcl::UNAVAILABLE) {
      correspondences_->emplace_back((*indices_)[i], matches[i], squared_distances[i]);
    }
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
BaselineRegistration<PointSource, PointTarget, Scalar>::notifyVisualizer()
{
  pcl::Indices all(input_->size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<pcl::index_t>(i);
  }
  PointCloudSource moved;
  pcl_ssfr::detail::moveCloud(*input_, all, final_transformation_, moved);
  pcl::Indices source_indices;
  pcl::Indices target_indices;
  for (const pcl::Correspondence& pair : *correspondences_) {
    source_indices.push_back(pair.index_query);
    target_indices.push_back(pair.index_match);
  }
  update_visualizer_(moved, source_indices, *target_, target_indices);
}

} // namespace pcl_ssfr::baselines
