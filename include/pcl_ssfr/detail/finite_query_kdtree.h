// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl/memory.h>
#include <pcl/point_representation.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <limits>
#include <mutex>
#include <numeric>
#include <vector>

namespace pcl_ssfr {

/// x, y and z of a point, wherever its type keeps them; PCL's default takes the first three floats of the point.
template <typename PointT>
class XyzRepresentation : public pcl::PointRepresentation<PointT> {
public:
  XyzRepresentation()
  {
    this->nr_dimensions_ = 3;
    this->trivial_ = false;
  }
  void
  copyToFloatArray(const PointT& point, float* out) const override
  {
    out[0] = point.x;
    out[1] = point.y;
    out[2] = point.z;
  }
};

/** \brief A pcl::search::KdTree over x, y and z that may be asked about any point.
 *
 * PCL's tree asserts on a NaN or infinite query, and its precompiled library keeps its asserts; on a cloud without one
 * finite point it has no index at all and leaves the caller's vectors as they were. Both would make
 * pcl::Registration::getFitnessScore() abort, or report a perfect score. This tree answers such queries with "no
 * neighbour": it returns 0, every distance is +infinity and every index is pcl::UNAVAILABLE.
 *
 * The cloud is indexed at the first query: pcl::Registration gives each target a tree, which takes more memory than the
 * target itself, and many users never ask it. The first query may come from several threads at once. Points that were
 * appended to the cloud since setInputCloud() are not indexed, as if it had been done there; a cloud that has lost
 * points since is no longer what was to be searched, and nothing has a neighbour in it.
 */
template <typename PointT>
class FiniteQueryKdTree : public pcl::search::KdTree<PointT> {
public:
  using Base = pcl::search::KdTree<PointT>;
  using PointCloudConstPtr = typename pcl::search::Search<PointT>::PointCloudConstPtr;

  using Base::nearestKSearch;
  using Base::radiusSearch;

  FiniteQueryKdTree() { this->setPointRepresentation(pcl::make_shared<XyzRepresentation<PointT>>()); }

  /// Take the finite points of \p cloud (those of \p indices only, when given); they are indexed at the first query.
  void
  setInputCloud(const PointCloudConstPtr& cloud, const pcl::IndicesConstPtr& indices = pcl::IndicesConstPtr()) override
  {
    this->input_ = cloud;
    this->indices_ = indices;
    size_ = cloud->size();
    index_ = Index::Unmade;
    forgetIndex();
  }

  /// Whether a query has made the index of the cloud given last.
  bool
  isBuilt() const
  {
    return index_ == Index::Made;
  }

  /// As in PCL; a query that is not finite has no neighbour.
  int
  nearestKSearch(const PointT& point,
                 int k,
                 pcl::Indices& k_indices,
                 std::vector<float>& k_sqr_distances) const override
  {
    if (this->getPointRepresentation()->isValid(point) && isSearchable()) {
      return Base::nearestKSearch(point, k, k_indices, k_sqr_distances);
    }
    const auto count = static_cast<std::size_t>(std::max(k, 0));
    k_indices.assign(count, pcl::UNAVAILABLE);
    k_sqr_distances.assign(count, std::numeric_limits<float>::infinity());
    return 0;
  }

  /// As in PCL; a query that is not finite has no neighbour.
  int
  radiusSearch(const PointT& point,
               double radius,
               pcl::Indices& k_indices,
               std::vector<float>& k_sqr_distances,
               unsigned int max_nn = 0) const override
  {
    if (this->getPointRepresentation()->isValid(point) && isSearchable()) {
      return Base::radiusSearch(point, radius, k_indices, k_sqr_distances, max_nn);
    }
    k_indices.clear();
    k_sqr_distances.clear();
    return 0;
  }

private:
  /// Of the cloud given last: not asked for yet; there; no point of it can be indexed, or it has lost points.
  enum class Index { Unmade, Made, Impossible };

  /// Whether there is an index, which the first query makes.
  bool
  isSearchable() const
  {
    Index index = index_.load(std::memory_order_acquire);
    if (index == Index::Unmade) {
      const std::lock_guard<std::mutex> lock(building_);
      index = index_.load(std::memory_order_relaxed);
      if (index == Index::Unmade) {
        index = makeIndex();
        index_.store(index, std::memory_order_release);
      }
    }
    return index == Index::Made;
  }

  /// Index the points that the cloud had when it was given.
  Index
  makeIndex() const
  {
    if (!this->input_ || this->input_->size() < size_) {
      return Index::Impossible;
    }
    pcl::IndicesConstPtr indices = this->indices_;
    if (!indices && this->input_->size() > size_) {
      const auto first = pcl::make_shared<pcl::Indices>(size_);
      std::iota(first->begin(), first->end(), pcl::index_t(0));
      indices = first;
    }
    const auto is_valid = [this](const PointT& point) { return this->getPointRepresentation()->isValid(point); };
    const auto is_valid_index = [&](pcl::index_t i) { return is_valid((*this->input_)[static_cast<std::size_t>(i)]); };
    if (indices ? std::none_of(indices->begin(), indices->end(), is_valid_index)
                : std::none_of(this->input_->begin(), this->input_->end(), is_valid)) {
      return Index::Impossible;
    }
    const float epsilon = this->tree_->getEpsilon();
    this->tree_->setInputCloud(this->input_, indices); // forgets the epsilon
    this->tree_->setEpsilon(epsilon);
    return Index::Made;
  }

  /// Give up the index of an earlier cloud, and that cloud; the settings stay.
  void
  forgetIndex()
  {
    if (!this->tree_->getInputCloud()) {
      return;
    }
    auto tree = pcl::make_shared<typename Base::KdTreePtr::element_type>(this->sorted_results_);
    tree->setEpsilon(this->tree_->getEpsilon());
    tree->setPointRepresentation(this->tree_->getPointRepresentation());
    this->tree_ = tree;
  }

  std::size_t size_ = 0; ///< of the cloud, when it was given
  mutable std::atomic<Index> index_{Index::Unmade};
  mutable std::mutex building_;
};

} // namespace pcl_ssfr
