// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/visibility_score.h>

namespace pcl_ssfr {

SurfaceEvidence
collectEvidence(const OrientedSamples& samples,
                const PatchIndex& index,
                const RangeImage* image,
                const Eigen::Isometry3d& T,
                const VisibilityOptions& options)
{
  SurfaceEvidence evidence;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const double weight = samples.weights[i];
    evidence.total += weight;
    const Eigen::Vector3f p = (T * samples.points.col(i)).cast<float>();
    const Eigen::Vector3f n = (T.linear() * samples.normals.col(i)).cast<float>();
    if (index.find(p, n, options.match) >= 0) {
      evidence.matched += weight;
      continue;
    }
    if (!image)
      continue;
    const Eigen::Vector3f ray = p - image->viewpoint();
    const float range = ray.norm();
    if (!(range > 0))
      continue;
    const std::size_t cell = image->cell(ray);
    const float nearest = image->nearest(cell);
    if (nearest == 0)
      continue; // nothing was seen there
    if (range < options.free_ratio * nearest - options.free_margin)
      evidence.contradicted += weight;
    else if (range < options.hidden_ratio * image->farthest(cell) + options.hidden_margin)
      evidence.unmatched += weight;
  }
  return evidence;
}

} // namespace pcl_ssfr
