// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/detail/finite_query_kdtree.h>
#include <pcl_ssfr/impl/registration_support.h>
#include <pcl_ssfr/structured_scene_registration.h>

#include <pcl/common/io.h>
#include <pcl/common/point_tests.h>
#include <pcl/common/transforms.h>
#include <pcl/console/print.h>
#include <pcl/type_traits.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace detail {

/// Default of pcl::Registration::setMaxCorrespondenceDistance(): "not set" (it is not even finite as a float).
inline const double kUnsetCorrespondenceDistance = std::sqrt(std::numeric_limits<double>::max());
inline constexpr std::int32_t kNoIndex = 0;         ///< what an empty index list points to: null would mean all points
inline constexpr std::size_t kSpacingProbes = 1000; ///< target points that the spacing is measured at
inline constexpr float kRadiusPerSpacing = 3;       ///< overlap radius per point spacing, when it follows from the data

/// Floats before field \p Tag in a point; only for fields that are floats.
template <typename PointT, typename Tag>
constexpr std::size_t
floatOffset()
{
  static_assert(pcl::traits::offset<PointT, Tag>::value % sizeof(float) == 0, "fields must be aligned");
  return pcl::traits::offset<PointT, Tag>::value / sizeof(float);
}

/// True when the point type carries its normal as three floats in a row.
template <typename PointT>
constexpr bool
hasNormal()
{
  if constexpr (pcl::traits::has_normal_v<PointT>) {
    return std::is_same_v<typename pcl::traits::datatype<PointT, pcl::fields::normal_x>::type, float> &&
           floatOffset<PointT, pcl::fields::normal_y>() == floatOffset<PointT, pcl::fields::normal_x>() + 1 &&
           floatOffset<PointT, pcl::fields::normal_z>() == floatOffset<PointT, pcl::fields::normal_x>() + 2;
  }
  else {
    return false;
  }
}

/// The points of \p cloud (of \p indices only, when given) as the core reads them; nothing is copied.
template <typename PointT>
ScanView
viewOf(const pcl::PointCloud<PointT>& cloud,
       const pcl::Indices* indices,
       const std::optional<Eigen::Vector3d>& viewpoint)
{
  static_assert(sizeof(PointT) % sizeof(float) == 0, "points must be made of whole floats");
  static_assert(std::is_same_v<pcl::index_t, std::int32_t>, "PCL must be built with 32 bit indices");

  ScanView view;
  view.stride = sizeof(PointT) / sizeof(float);
  view.size = cloud.size();
  if (!cloud.empty()) {
    view.xyz = cloud.points.front().data;
    if constexpr (hasNormal<PointT>()) {
      view.normals =
          reinterpret_cast<const float*>(&cloud.points.front()) + floatOffset<PointT, pcl::fields::normal_x>();
    }
  }
  if (indices) {
    view.indices = indices->empty() ? &kNoIndex : indices->data();
    view.index_count = indices->size();
  }
  const Eigen::Vector3d origin = cloud.sensor_origin_.template head<3>().template cast<double>();
  view.viewpoint = viewpoint ? *viewpoint : (origin.allFinite() ? origin : Eigen::Vector3d::Zero());
  view.viewpoint_is_known = viewpoint.has_value();
  return view;
}

/** \brief Move the points \p indices of \p input by \p transform into \p output, which is another cloud.
 *
 * Normals are rotated and the other fields kept. Non-finite points stay as they are, whatever `is_dense` says. All
 * points of an organised cloud stay organised.
 */
template <typename PointT, typename Scalar>
void
moveCloud(const pcl::PointCloud<PointT>& input,
          const pcl::Indices& indices,
          const Eigen::Matrix<Scalar, 4, 4>& transform,
          pcl::PointCloud<PointT>& output)
{
  if constexpr (pcl::traits::has_normal_v<PointT>) {
    pcl::transformPointCloudWithNormals(input, indices, output, transform);
  }
  else {
    pcl::transformPointCloud(input, indices, output, transform);
  }
  if (indices.size() == input.size()) {
    output.width = input.width;
    output.height = input.height;
  }
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const PointT& original = input[static_cast<std::size_t>(indices[i])];
    if (!pcl::isXYZFinite(original)) {
      output[i] = original;
      output[i].data[3] = 1.0F;
    }
  }
}

} // namespace detail

template <typename PointSource, typename PointTarget, typename Scalar>
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::StructuredSceneRegistration()
    : options_(makeOptions(Profile::Default)), default_tree_(tree_reciprocal_)
{
  reg_name_ = "StructuredSceneRegistration";
  max_iterations_ = options_.max_refinement_steps;
  tree_ = pcl::make_shared<FiniteQueryKdTree<PointTarget>>();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setInputSource(const PointCloudSourceConstPtr& cloud)
{
  if (!cloud) {
    detail::reportError(getClassName(), "setInputSource", "null cloud given; the old source is kept");
    return;
  }
  Base::setInputSource(cloud);
  if (input_ == cloud) { // else it was empty, which the base has reported
    cleanIndices("setInputSource");
    prepared_source_ = PreparedScan();
    resetResult();
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setInputTarget(const PointCloudTargetConstPtr& cloud)
{
  if (!cloud) {
    detail::reportError(getClassName(), "setInputTarget", "null cloud given; the old target is kept");
    return;
  }
  Base::setInputTarget(cloud);
  if (target_ == cloud) { // else it was empty, which the base has reported
    prepared_target_ = PreparedScan();
    resetResult();
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setIndices(const pcl::IndicesPtr& indices)
{
  Base::setIndices(indices);
  cleanIndices("setIndices");
  prepared_source_ = PreparedScan();
  resetResult();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setIndices(const pcl::IndicesConstPtr& indices)
{
  setIndices(indices ? pcl::make_shared<pcl::Indices>(*indices) : pcl::IndicesPtr());
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setIndices(const PointIndicesConstPtr& indices)
{
  setIndices(indices ? pcl::make_shared<pcl::Indices>(indices->indices) : pcl::IndicesPtr());
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setIndices(std::size_t row_start,
                                                                          std::size_t col_start,
                                                                          std::size_t nb_rows,
                                                                          std::size_t nb_cols)
{
  if (!input_) {
    detail::reportError(getClassName(), "setIndices", "a rectangle needs a source, set that first");
    return;
  }
  Base::setIndices(row_start, col_start, nb_rows, nb_cols);
  cleanIndices("setIndices");
  prepared_source_ = PreparedScan();
  resetResult();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setNormalRadius(double radius)
{
  changeOptions("setNormalRadius", [&](Options& options) { options.normal_radius = radius; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setDensityRadius(double chord)
{
  changeOptions("setDensityRadius", [&](Options& options) { options.density_radius = chord; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setBinWidth(double width)
{
  changeOptions("setBinWidth", [&](Options& options) { options.bin_width = width; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setProfile(Profile profile)
{
  changeOptions("setProfile", [&](Options& options) { options.profile = profile; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setNumberOfThreads(unsigned threads)
{
  changeOptions("setNumberOfThreads", [&](Options& options) { options.threads = threads; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setViewpointMode(ViewpointMode mode)
{
  changeOptions("setViewpointMode", [&](Options& options) { options.viewpoint_mode = mode; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setSourceViewpoint(const Eigen::Vector3d& position)
{
  if (!position.allFinite()) {
    detail::reportError(getClassName(), "setSourceViewpoint", "position is not finite; the old value is kept");
    return;
  }
  source_viewpoint_ = position;
  prepared_source_ = PreparedScan();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setTargetViewpoint(const Eigen::Vector3d& position)
{
  if (!position.allFinite()) {
    detail::reportError(getClassName(), "setTargetViewpoint", "position is not finite; the old value is kept");
    return;
  }
  target_viewpoint_ = position;
  prepared_target_ = PreparedScan();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::clearViewpoints()
{
  if (source_viewpoint_) {
    prepared_source_ = PreparedScan();
  }
  if (target_viewpoint_) {
    prepared_target_ = PreparedScan();
  }
  source_viewpoint_.reset();
  target_viewpoint_.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setGravity(const Eigen::Vector3d& up_source,
                                                                          const Eigen::Vector3d& up_target,
                                                                          double tolerance)
{
  const auto is_direction = [](const Eigen::Vector3d& v) { return v.allFinite() && v.norm() > 0; };
  if (!is_direction(up_source) || !is_direction(up_target) || !(tolerance > 0 && tolerance <= M_PI)) {
    detail::reportError(getClassName(),
                        "setGravity",
                        "directions must be finite and not 0, the tolerance in (0, pi]; the old value is kept");
    return;
  }
  changeOptions("setGravity", [&](Options& options) {
    options.gravity = GravityPrior{up_source.stableNormalized(), up_target.stableNormalized(), tolerance};
  });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::clearGravity()
{
  options_.gravity.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setGuessTolerance(double rotation, double translation)
{
  changeOptions("setGuessTolerance", [&](Options& options) {
    options.guess_tolerance = GuessTolerance{rotation, translation};
  });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::clearGuessTolerance()
{
  options_.guess_tolerance.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setRefinement(bool refine)
{
  options_.refine = refine;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setTimeLimit(double seconds)
{
  changeOptions("setTimeLimit", [&](Options& options) { options.time_limit = seconds; });
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::setOptions(const Options& options)
{
  if (!detail::acceptOptions(getClassName(), "setOptions", options)) {
    return;
  }
  options_ = options;
  max_iterations_ = options.max_refinement_steps;
  corr_dist_threshold_ = options.overlap_radius > 0 ? options.overlap_radius : detail::kUnsetCorrespondenceDistance;
}

template <typename PointSource, typename PointTarget, typename Scalar>
Options
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::getOptions() const
{
  Options options = options_;
  options.refine = options_.refine && max_iterations_ > 0;
  options.max_refinement_steps = std::max(max_iterations_, 1);
  const bool is_radius = corr_dist_threshold_ > 0 && corr_dist_threshold_ < detail::kUnsetCorrespondenceDistance;
  options.overlap_radius = is_radius ? corr_dist_threshold_ : 0;
  return options;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::computeTransformation(PointCloudSource& output,
                                                                                     const Matrix4& guess)
{
  const Deadline deadline = Deadline::after(options_.time_limit);
  warnOfIgnoredSettings();
  resetResult();

  // A guess that cannot be a pose is not judged; as with ICP it still is the answer of a failed run, if it is finite.
  std::optional<Eigen::Isometry3d> usable_guess;
  Matrix4 fallback = guess;
  if (guess != Matrix4::Identity() || options_.guess_tolerance) {
    usable_guess = detail::rigidGuess(guess.template cast<double>());
    if (!usable_guess) {
      detail::reportWarning(getClassName(), "align", "the guess is not a rigid motion and is ignored");
      fallback = guess.allFinite() ? guess : Matrix4(Matrix4::Identity());
    }
  }
  previous_transformation_ = fallback;
  final_transformation_ = fallback;
  transformation_ = fallback;

  const std::string problem = aliasingProblem(output);
  if (!problem.empty()) {
    result_.status = Status::InvalidInput;
    result_.message = problem;
    detail::reportError(getClassName(), "align", problem);
    dropPrepared(); // at least one of the clouds is no longer what it was, nor what the tree indexes
    target_cloud_updated_ = true;
    const PointCloudSource before = output;
    pcl::Indices all(before.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = static_cast<pcl::index_t>(i);
    }
    detail::moveCloud(before, all, final_transformation_, output);
    return;
  }

  const Options options = getOptions();
  runPipeline(usable_guess, options, deadline);
  nr_iterations_ = static_cast<int>(result_.candidates.size());
  converged_ = result_.accepted();
  if (converged_) {
    final_transformation_ = detail::rigidMatrix(result_.T_target_source).template cast<Scalar>();
    transformation_ = final_transformation_;
    correspondences_wanted_ = true;
    correspondence_radius_ = options.overlap_radius;
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
    detail::moveCloud(*input_, *indices_, final_transformation_, output);
    return;
  }
  getCorrespondences(); // while the source is there
  PointCloudSource moved;
  detail::moveCloud(*input_, *indices_, final_transformation_, moved);
  prepared_source_ = PreparedScan();
  output.swap(moved);
}

template <typename PointSource, typename PointTarget, typename Scalar>
pcl::CorrespondencesConstPtr
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::getCorrespondences() const
{
  if (correspondences_wanted_) {
    correspondences_wanted_ = false;
    findCorrespondences();
  }
  return correspondences_;
}

template <typename PointSource, typename PointTarget, typename Scalar>
template <typename Change>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::changeOptions(const char* setter, const Change& change)
{
  Options candidate = options_;
  change(candidate);
  if (detail::acceptOptions(getClassName(), setter, candidate)) {
    options_ = candidate;
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::dropPrepared()
{
  prepared_source_ = PreparedScan();
  prepared_target_ = PreparedScan();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::resetResult()
{
  converged_ = false;
  nr_iterations_ = 0;
  correspondences_->clear();
  correspondences_wanted_ = false;
  result_ = Result();
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::cleanIndices(const char* setter)
{
  if (!input_ || !indices_ || fake_indices_) {
    return;
  }
  pcl::Indices kept = *indices_;
  const std::size_t dropped = detail::dropOutOfRange(kept, input_->size());
  if (dropped > 0) {
    detail::reportWarning(getClassName(),
                          setter,
                          std::to_string(dropped) + " indices lie outside the source of " +
                              std::to_string(input_->size()) + " points and are dropped");
    indices_ = pcl::make_shared<pcl::Indices>(std::move(kept));
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::warnOnce(Ignored setting, bool changed, const char* text)
{
  const auto bit = static_cast<unsigned>(setting);
  if (changed && (warned_ & bit) == 0) {
    warned_ |= bit;
    detail::reportWarning(getClassName(), "align", text);
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::warnOfIgnoredSettings()
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
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::aliasingProblem(const PointCloudSource& output) const
{
  // align() of the base has already written the indexed source points into the output.
  if (static_cast<const void*>(&output) == static_cast<const void*>(target_.get())) {
    return "the output is the target, which it has overwritten; set the target again and give another output";
  }
  if (&output == input_.get() && !fake_indices_ && !detail::isEveryPointInOrder(*indices_, input_->size())) {
    return "the output is the source, and indices are set: the source was overwritten; set it again and give another "
           "output";
  }
  return {};
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::runPipeline(
    const std::optional<Eigen::Isometry3d>& guess, const Options& options, const Deadline& deadline)
{
  try {
    const auto source = [&] {
      return detail::viewOf(*input_, fake_indices_ ? nullptr : indices_.get(), source_viewpoint_);
    };
    const auto target = [&] { return detail::viewOf(*target_, nullptr, target_viewpoint_); };
    for (PreparedScan* scan : {&prepared_source_, &prepared_target_}) {
      if (!scan->isPreparedWith(options)) {
        *scan = PreparedScan();
      }
    }
    if (prepared_source_.empty() && prepared_target_.empty()) {
      std::tie(prepared_source_, prepared_target_) = prepareScans(source(), target(), options, deadline);
    }
    if (prepared_target_.empty()) {
      prepared_target_ = prepareScan(target(), options, deadline);
    }
    if (prepared_source_.empty()) {
      prepared_source_ = prepareScan(source(), options, deadline);
    }
    result_ = registerScans(prepared_source_, prepared_target_, options, guess ? &*guess : nullptr, deadline);
    for (PreparedScan* scan : {&prepared_source_, &prepared_target_}) {
      if (!scan->isComplete()) {
        *scan = PreparedScan();
      }
    }
  }
  catch (const std::exception& error) {
    dropPrepared();
    result_ = Result();
    result_.status = Status::InvalidInput;
    result_.message = error.what();
    detail::reportError(getClassName(), "align", error.what());
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
void
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::findCorrespondences() const
{
  const Eigen::Isometry3d& T = result_.T_target_source;
  // The base's tree, unless the user made it for another cloud.
  typename Base::KdTreePtr tree = tree_;
  if (tree->getInputCloud() != target_) {
    tree = pcl::make_shared<FiniteQueryKdTree<PointTarget>>();
    tree->setInputCloud(target_);
  }
  const auto representation = tree->getPointRepresentation();
  const auto first_finite = std::find_if(
      target_->begin(), target_->end(), [&](const PointTarget& point) { return representation->isValid(point); });
  if (first_finite == target_->end()) {
    return; // PCL's own tree has no index then, and must not be asked
  }

  auto radius = static_cast<float>(correspondence_radius_);
  if (!(radius > 0)) {
    std::vector<float> squared_spacings;
    const std::size_t step = std::max<std::size_t>(target_->size() / detail::kSpacingProbes, 1);
    for (std::size_t i = 0; i < target_->size(); i += step) {
      pcl::Indices neighbors;
      std::vector<float> squared_distances;
      if (representation->isValid((*target_)[i]) &&
          tree->nearestKSearch((*target_)[i], 2, neighbors, squared_distances) == 2) {
        squared_spacings.push_back(squared_distances[1]);
      }
    }
    const float spacing = std::sqrt(detail::median(std::move(squared_spacings)));
    radius = detail::kRadiusPerSpacing * std::max(spacing, static_cast<float>(result_.rmse));
  }

  // One slot a point, gathered in order: the same for any number of threads.
  const auto count = static_cast<std::ptrdiff_t>(indices_->size());
  std::vector<pcl::index_t> matches(indices_->size(), pcl::UNAVAILABLE);
  std::vector<float> squared_distances(indices_->size(), 0.0F);
  const float squared_radius = radius * radius;
  [[maybe_unused]] const auto threads = static_cast<int>(threadCount(options_)); // not every user compiles for OpenMP
#ifdef _OPENMP
#pragma omp parallel num_threads(threads)
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
      query.getVector3fMap() = (T * point.getVector3fMap().template cast<double>()).template cast<float>();
      if (!representation->isValid(query) || tree->nearestKSearch(query, 1, neighbor, tree_distance) != 1) {
        continue;
      }
      const PointTarget& match = (*target_)[static_cast<std::size_t>(neighbor[0])];
      const float squared = (match.getVector3fMap() - query.getVector3fMap()).squaredNorm();
      if (squared <= squared_radius) {
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
StructuredSceneRegistration<PointSource, PointTarget, Scalar>::notifyVisualizer()
{
  pcl::Indices all(input_->size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<pcl::index_t>(i);
  }
  PointCloudSource moved;
  detail::moveCloud(*input_, all, final_transformation_, moved);
  pcl::Indices source_indices;
  pcl::Indices target_indices;
  for (const pcl::Correspondence& pair : *getCorrespondences()) {
    source_indices.push_back(pair.index_query);
    target_indices.push_back(pair.index_match);
  }
  update_visualizer_(moved, source_indices, *target_, target_indices);
}

} // namespace pcl_ssfr
