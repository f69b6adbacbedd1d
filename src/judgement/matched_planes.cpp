// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/matched_planes.h"

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

std::vector<Eigen::Index>
beyondThreePlanes(const OrientedSamples& samples,
                  std::vector<Eigen::Index> chosen,
                  const PatchIndex::Tolerance& tolerance)
{
  // What a direction has across the planes so far: its part that is in none of their normals.
  Eigen::Matrix3d across = Eigen::Matrix3d::Identity();
  for (int plane = 0; plane < 3 && !chosen.empty(); ++plane) {
    const auto surfaceAcross = [&](Eigen::Index i) {
      return samples.weights[i] * (across * samples.normals.col(i)).squaredNorm();
    };
    Eigen::Index largest = chosen.front();
    double most = surfaceAcross(largest);
    for (const Eigen::Index i : chosen)
      if (const double surface = surfaceAcross(i); surface > most) {
        largest = i;
        most = surface;
      }
    const Eigen::Vector3d point = samples.points.col(largest), normal = samples.normals.col(largest);
    const auto liesInPlane = [&](Eigen::Index i) {
      return std::abs(normal.dot(samples.normals.col(i))) >= static_cast<double>(tolerance.min_cos) &&
             std::abs(normal.dot(samples.points.col(i) - point)) <= static_cast<double>(tolerance.distance);
    };
    chosen.erase(std::remove_if(chosen.begin(), chosen.end(), liesInPlane), chosen.end());
    const Eigen::Vector3d added = (across * normal).normalized();
    across -= added * added.transpose();
  }
  return chosen;
}

} // namespace pcl_ssfr
