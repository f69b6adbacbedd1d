// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/furniture.h"

#include "preparation/planar_patches.h"
#include "profiles/prepared_data.h"

#include <cmath>
#include <variant>
#include <vector>

namespace pcl_ssfr {

OrientedSamples
furnitureOf(const PreparedScan& scan, const FurnitureConfig& config)
{
  const PatchScan& patches = std::get<PatchScan>(scan.data().scan);
  const OrientedSamples& all = patches.patches.samples;
  const double scale = patches.scale;
  const double most_area = config.most_area * scale * scale;
  std::vector<Eigen::Index> furniture;
  for (Eigen::Index i = 0; i < all.size(); ++i) {
    const Eigen::Vector3d normal = all.normals.col(i).cast<double>();
    double plane = 0;
    for (Eigen::Index j = 0; j < all.size() && plane < most_area; ++j) {
      const Eigen::Vector3d offset = (all.points.col(j) - all.points.col(i)).cast<double>();
      if (offset.norm() < config.reach * scale && std::abs(normal.dot(offset)) < config.thickness * scale &&
          std::abs(normal.dot(all.normals.col(j).cast<double>())) > config.parallel)
        plane += all.weights[j];
    }
    if (plane < most_area)
      furniture.push_back(i);
  }
  return selectPatches(patches.patches, furniture).samples;
}

} // namespace pcl_ssfr
