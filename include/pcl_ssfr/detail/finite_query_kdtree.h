// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/detail/neighbor_index.h>

#include <pcl/memory.h>
#include <pcl/point_representation.h>
#include <pcl/search/kdtree.h>

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>
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
 * Queries for one neighbour, of which getFitnessScore() makes one per point, are answered by a NeighborIndex, exactly
 * and several times as fast; of equally near points it gives the first. All others go to PCL's tree, and so does every
 * query once another point representation is set.
 *
 * The cloud is indexed at the first query of either kind: pcl::Registration gives each target a tree, which takes more
 * memory than the target itself, and many users never ask it. The first query may come from several threads at once.
 * Points that were appended to the cloud since setInputCloud() are not indexed, as if it had been done there; a cloud
 * that has lost points since is no longer what was to be searched, and nothing has a neighbour in it.
 */
template <typename PointT>
class FiniteQueryKdTree : public pcl::search::KdTree<PointT> {
public:
  using Base = pcl::search::KdTree<PointT>;
  using PointCloudConstPtr = typename pcl::search::Search<PointT>::PointCloudConstPtr;

  using Base::nearestKSearch;
  using Base::radiusSearch;

  FiniteQueryKdTree() { this->setPointRepresentation(xyz_); }

  /// Take the finite points of \p cloud (those of \p indices only, when given); they are indexed at the first query.
  void
  setInputCloud(const PointCloudConstPtr& cloud, const pcl::IndicesConstPtr& indices = pcl::IndicesConstPtr()) override
  {
    this->input_ = cloud;
    this->indices_ = indices;
    size_ = cloud->size();
    made_ = std::make_unique<Made>();
    forgetTree();
  }

  /// Whether a query has made an index of the cloud given last; not to be asked while other threads query.
  bool
  isBuilt() const
  {
    return made_->nearest.size() > 0 || made_->has_tree;
  }

  /// As in PCL; a query that is not finite has no neighbour.
  int
  nearestKSearch(const PointT& point,
                 int k,
                 pcl::Indices& k_indices,
                 std::vector<float>& k_sqr_distances) const override
  {
    if (k == 1 && this->getPointRepresentation() == xyz_) {
      k_indices.resize(1);
      k_sqr_distances.resize(1);
      return nearest(point, k_indices[0], k_sqr_distances[0]);
    }
    if (this->getPointRepresentation()->isValid(point) && hasTree()) {
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
    if (this->getPointRepresentation()->isValid(point) && hasTree()) {
      return Base::radiusSearch(point, radius, k_indices, k_sqr_distances, max_nn);
    }
    k_indices.clear();
    k_sqr_distances.clear();
    return 0;
  }

private:
  /// What queries have made of the cloud given last, each index once.
  struct Made {
    std::once_flag nearest_once;
    NeighborIndex nearest; ///< empty: not asked for yet, or no point can be indexed
    pcl::Indices indices;  ///< of its points in the cloud
    std::once_flag tree_once;
    bool has_tree = false; ///< likewise, of PCL's tree
  };

  /// The number of neighbours of \p point, 0 or 1, as PCL gives them.
  int
  nearest(const PointT& point, pcl::index_t& index, float& squared_distance) const
  {
    index = pcl::UNAVAILABLE;
    squared_distance = std::numeric_limits<float>::infinity();
    std::call_once(made_->nearest_once, [this] { indexForNearest(); });
    const Eigen::Vector3f query(point.x, point.y, point.z);
    const NeighborIndex::Neighbor found = made_->nearest.nearest(query.template cast<double>());
    if (found.index < 0) {
      return 0;
    }
    index = made_->indices[static_cast<std::size_t>(found.index)];
    const Eigen::Vector3f difference = query - found.point.template cast<float>();
    squared_distance = difference.x() * difference.x(); // summed in PCL's order: the same bits
    squared_distance += difference.y() * difference.y();
    squared_distance += difference.z() * difference.z();
    return 1;
  }

  /// Whether PCL's tree is there, which the first query makes.
  bool
  hasTree() const
  {
    std::call_once(made_->tree_once, [this] { makeTree(); });
    return made_->has_tree;
  }

  void
  indexForNearest() const
  {
    made_->indices = validIndices();
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(made_->indices.size()));
    for (Eigen::Index column = 0; column < points.cols(); ++column) {
      const auto i = static_cast<std::size_t>(made_->indices[static_cast<std::size_t>(column)]);
      const PointT& point = (*this->input_)[i];
      points.col(column) << point.x, point.y, point.z;
    }
    made_->nearest = NeighborIndex(std::move(points));
  }

  void
  makeTree() const
  {
    const auto indices = pcl::make_shared<const pcl::Indices>(validIndices());
    if (indices->empty()) {
      return;
    }
    const float epsilon = this->tree_->getEpsilon();
    this->tree_->setInputCloud(this->input_, indices); // forgets the epsilon
    this->tree_->setEpsilon(epsilon);
    made_->has_tree = true;
  }

  /// The points to index, of those that the cloud had when it was given; none if it has lost some.
  pcl::Indices
  validIndices() const
  {
    pcl::Indices valid;
    if (!this->input_ || this->input_->size() < size_) {
      return valid;
    }
    const auto take = [&, representation = this->getPointRepresentation()](pcl::index_t i) {
      if (representation->isValid((*this->input_)[static_cast<std::size_t>(i)])) {
        valid.push_back(i);
      }
    };
    valid.reserve(this->indices_ ? this->indices_->size() : size_);
    if (this->indices_) {
      std::for_each(this->indices_->begin(), this->indices_->end(), take);
    }
    else {
      for (std::size_t i = 0; i < size_; ++i) {
        take(static_cast<pcl::index_t>(i));
      }
    }
    return valid;
  }

  /// Give up PCL's tree of an earlier cloud, and that cloud; the settings stay.
  void
  forgetTree()
  {
    if (!this->tree_->getInputCloud()) {
      return;
    }
    auto tree = pcl::make_shared<typename Base::KdTreePtr::element_type>(this->sorted_results_);
    tree->setEpsilon(this->tree_->getEpsilon());
    tree->setPointRepresentation(this->tree_->getPointRepresentation());
    this->tree_ = tree;
  }

  const pcl::shared_ptr<const XyzRepresentation<PointT>> xyz_ = pcl::make_shared<XyzRepresentation<PointT>>();
  std::size_t size_ = 0; ///< of the cloud, when it was given
  std::unique_ptr<Made> made_ = std::make_unique<Made>();
};

} // namespace pcl_ssfr
