// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/impl/registration_support.h>

#include <pcl/common/io.h>
#include <pcl/common/point_tests.h>
#include <pcl/correspondence.h>
#include <pcl/point_cloud.h>
#include <pcl/types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace pcl_ssfr::detail {

inline constexpr std::size_t kSpacingProbes = 1000; ///< target points that the spacing is measured at
inline constexpr float kRadiusPerSpacing = 3;       ///< overlap radius per point spacing, when it follows from the data

/// Distance of inliers that follows from the spacing of \p target, which \p tree indexes, and \p rmse [m].
template <typename PointTarget, typename Tree>
double
inlierDistanceFromData(const pcl::PointCloud<PointTarget>& target, const Tree& tree, double rmse)
{
  const auto representation = tree.getPointRepresentation();
  std::vector<float> squared_spacings;
  const std::size_t step = std::max<std::size_t>(target.size() / kSpacingProbes, 1);
  for (std::size_t i = 0; i < target.size(); i += step) {
    pcl::Indices neighbors;
    std::vector<float> squared_distances;
    if (representation->isValid(target[i]) && tree.nearestKSearch(target[i], 2, neighbors, squared_distances) == 2) {
      squared_spacings.push_back(squared_distances[1]);
    }
  }
  const float spacing = std::sqrt(median(std::move(squared_spacings)));
  return kRadiusPerSpacing * std::max(spacing, static_cast<float>(rmse));
}

/** \brief The points \p indices of \p source whose nearest point of \p target, which \p tree indexes, is within
 * \p distance [m] once they are moved by \p T; in their order, whatever the number of threads.
 */
template <typename PointSource, typename PointTarget, typename Tree>
pcl::Correspondences
findCorrespondences(const pcl::PointCloud<PointSource>& source,
                    const pcl::Indices& indices,
                    const pcl::PointCloud<PointTarget>& target,
                    const Tree& tree,
                    const Eigen::Isometry3d& T,
                    double distance,
                    [[maybe_unused]] int threads) // not every user compiles for OpenMP
{
  const auto representation = tree.getPointRepresentation();
  const double squared_limit = distance * distance;
  const auto count = static_cast<std::ptrdiff_t>(indices.size());
  std::vector<pcl::index_t> matches(indices.size(), pcl::UNAVAILABLE); // one slot per point
  std::vector<float> squared_distances(indices.size(), 0.0F);
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
      const PointSource& point = source[static_cast<std::size_t>(indices[slot])];
      if (!pcl::isXYZFinite(point)) {
        continue;
      }
      PointTarget query;
      pcl::copyPoint(point, query);
      query.getVector3fMap() = (T * point.getVector3fMap().template cast<double>()).template cast<float>();
      if (!representation->isValid(query) || tree.nearestKSearch(query, 1, neighbor, tree_distance) != 1) {
        continue;
      }
      const PointTarget& match = target[static_cast<std::size_t>(neighbor[0])];
      const float squared = (match.getVector3fMap() - query.getVector3fMap()).squaredNorm();
      if (static_cast<double>(squared) <= squared_limit) {
        matches[slot] = neighbor[0];
        squared_distances[slot] = squared;
      }
    }
  }
  pcl::Correspondences correspondences;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] != pcl::UNAVAILABLE) {
      correspondences.emplace_back(indices[i], matches[i], squared_distances[i]);
    }
  }
  return correspondences;
}

} // namespace pcl_ssfr::detail
