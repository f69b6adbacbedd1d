// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Uses the installed package as a stranger would: registers a small hand-made room with a rotated copy of itself.

#include <pcl_ssfr/structured_scene_registration.h>
#include <pcl_ssfr/version.h>

#include <pcl/common/transforms.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <iostream>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// Points every 4 cm on the rectangle corner + s u + t v, s and t in [0, 1].
void
addRectangle(Cloud& cloud, const Eigen::Vector3f& corner, const Eigen::Vector3f& u, const Eigen::Vector3f& v)
{
  constexpr float kSpacing = 0.04F;
  for (float s = 0; s < u.norm(); s += kSpacing) {
    for (float t = 0; t < v.norm(); t += kSpacing) {
      const Eigen::Vector3f p = corner + s * u.normalized() + t * v.normalized();
      cloud.emplace_back(p.x(), p.y(), p.z());
    }
  }
}

/// The faces of a box; \p low is its lowest corner.
void
addBox(Cloud& cloud, const Eigen::Vector3f& low, const Eigen::Vector3f& size)
{
  const Eigen::Vector3f high = low + size;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3f u = size[(k + 1) % 3] * Eigen::Vector3f::Unit((k + 1) % 3);
    const Eigen::Vector3f v = size[(k + 2) % 3] * Eigen::Vector3f::Unit((k + 2) % 3);
    addRectangle(cloud, low, u, v);
    addRectangle(cloud, high, -u, -v);
  }
}

} // namespace

int
main()
{
  Cloud::Ptr target(new Cloud);
  addBox(*target, Eigen::Vector3f(-3, -2, -1.2F), Eigen::Vector3f(6.5F, 4.5F, 2.6F)); // the room, sensor inside
  addBox(*target, Eigen::Vector3f(2.4F, -1.9F, -1.2F), Eigen::Vector3f(0.6F, 1.4F, 1.9F));
  addBox(*target, Eigen::Vector3f(-2.9F, 0.4F, -1.2F), Eigen::Vector3f(0.5F, 1.2F, 0.8F));
  addBox(*target, Eigen::Vector3f(0.2F, 1.6F, -1.2F), Eigen::Vector3f(1.1F, 0.7F, 1.3F));

  const Eigen::Affine3f T_source_target(Eigen::AngleAxisf(2, Eigen::Vector3f(0.2F, -0.1F, 1).normalized()));
  Cloud::Ptr source(new Cloud);
  pcl::transformPointCloud(*target, *source, T_source_target);

  pcl_ssfr::StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ> registration;
  registration.setInputSource(source);
  registration.setInputTarget(target);
  Cloud moved;
  registration.align(moved);

  const Eigen::Matrix4f rest = registration.getFinalTransformation() * T_source_target.matrix();
  const float error = (rest - Eigen::Matrix4f::Identity()).cwiseAbs().maxCoeff();
  std::cout << "pcl_ssfr " << PCL_SSFR_VERSION << ": " << registration.getResult().message << "\nerror " << error
            << '\n';
  return registration.hasConverged() && error < 0.02F ? 0 : 1;
}
