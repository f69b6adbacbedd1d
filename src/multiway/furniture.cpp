// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/furniture.h"

#include "judgement/visibility_score.h"
#include "preparation/planar_patches.h"
#include "profiles/patch_pair.h"
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

FurnitureEvidence&
FurnitureEvidence::operator+=(const FurnitureEvidence& other)
{
  seen += other.seen;
  seen_through += other.seen_through;
  return *this;
}

FurnitureEvidence
furnitureAt(const PreparedScan& source,
            const OrientedSamples& source_furniture,
            const PreparedScan& target,
            const OrientedSamples& target_furniture,
            const Eigen::Isometry3d& T_target_source,
            const MultiwayOptions& options)
{
  Options pair_options = options.registration;
  pair_options.threads = 1;
  const PatchScan& s = std::get<PatchScan>(source.data().scan);
  const PatchScan& t = std::get<PatchScan>(target.data().scan);
  const PatchPair pair(s, t, pair_options, nullptr, Deadline());
  VisibilityOptions tolerances = pair.fineTolerances();
  const auto margin = static_cast<float>(options.furniture.margin);
  tolerances.free_margin *= margin;
  tolerances.free_ratio = 1 - margin * (1 - tolerances.free_ratio);
  const Eigen::Isometry3d T = pair.toInner(T_target_source);
  SurfaceEvidence both = collectEvidence(source_furniture, t.index, t.freeSpace(), T, tolerances);
  both += collectEvidence(target_furniture, s.index, s.freeSpace(), T.inverse(), tolerances);
  const WeightedEvidence& e = both.patches;
  return {e.matched + e.unmatched + e.contradicted, e.contradicted};
}

} // namespace pcl_ssfr
