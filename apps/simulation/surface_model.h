// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ssfr::simulation {

/// What a surface is made of, as a LiDAR sees it.
struct Material {
  std::string name;
  double reflectance = 0.5; ///< diffuse (Lambertian), at the wavelength of the sensors (about 905 nm), in (0, 1]
};

/// Triangles with shared vertices. Both sides of a triangle can be hit.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;               ///< world frame [m]
  std::vector<std::array<std::uint32_t, 3>> triangles; ///< indices of vertices
  std::vector<std::uint16_t> material;                 ///< one a triangle, index into SurfaceModel::materials
};

/// A whole sphere; hit exactly, from outside and inside.
struct Sphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(); ///< [m]
  double radius = 1;                                ///< > 0 [m]
  std::uint16_t material = 0;
};

/// The side of a finite cylinder, without caps; hit exactly, from outside and inside.
struct Tube {
  Eigen::Vector3d base = Eigen::Vector3d::Zero();  ///< one end of the axis [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ(); ///< unit, from the base to the other end
  double length = 1;                               ///< > 0 [m]
  double radius = 1;                               ///< > 0 [m]
  std::uint16_t material = 0;
};

/// All that a ray can hit. A scene is a triangle mesh; round things of our own scenes are kept exact.
struct SurfaceModel {
  TriangleMesh mesh;
  std::vector<Sphere> spheres;
  std::vector<Tube> tubes;
  std::vector<Material> materials; ///< at least one when there is anything to hit

  /// The index of a material of this name, added when it is new (its reflectance is then set).
  std::uint16_t
  addMaterial(const std::string& name, double reflectance);
  /// A flat polygon with 3 or 4 corners in order [m].
  void
  addPolygon(const std::vector<Eigen::Vector3d>& corners, std::uint16_t material);
  /// A box: \p T_world_box puts its centre and axes; \p size is its full extent, > 0 [m].
  void
  addBox(const Eigen::Isometry3d& T_world_box, const Eigen::Vector3d& size, std::uint16_t material);
  /// A box that stands on \p base (centre of its lower face), rotated by \p yaw [rad] about the vertical.
  void
  addBlock(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw, std::uint16_t material);
  /// An upright cylinder with a flat top (a fan of 32 triangles) that stands on \p base.
  void
  addColumn(const Eigen::Vector3d& base, double radius, double height, std::uint16_t material);
  /// Everything of \p other moved by \p T, its materials merged by name.
  void
  append(const SurfaceModel& other, const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity());
};

/** \brief Check a model: finite vertices, indices in range, positive sizes, materials that exist, and not empty.
 * \throw SimulationError naming the element and the value
 */
void
validate(const SurfaceModel& model);

/// Lower and upper corner of everything [m]; an empty box for an empty model.
Eigen::AlignedBox3d
boundsOf(const SurfaceModel& model);

} // namespace pcl_ssfr::simulation
