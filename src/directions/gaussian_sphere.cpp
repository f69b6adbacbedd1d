// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "directions/gaussian_sphere.h"

#include <cmath>

namespace pcl_ssfr {

DirectionSet
makeGaussianSphere(const OrientedSamples& samples)
{
  const Eigen::Index copies = samples.oriented ? 1 : 2;
  DirectionSet image;
  image.directions.resize(3, copies * samples.size());
  image.weights.resize(copies * samples.size());
  Eigen::Index used = 0;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d normal = samples.normals.col(i);
    const double length = normal.norm();
    if (!(std::abs(length - 1) <= kUnitTolerance)) // false for NaN, too
      continue;
    for (Eigen::Index copy = 0; copy < copies; ++copy, ++used) {
      image.directions.col(used) = (copy == 0 ? 1 : -1) * normal / length;
      image.weights[used] = samples.weights[i];
    }
  }
  image.directions.conservativeResize(3, used);
  image.weights.conservativeResize(used);
  return image;
}

} // namespace pcl_ssfr
