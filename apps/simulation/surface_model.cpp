// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/surface_model.h>

#include "common/angles.h"

#include <apps/simulation/simulation_error.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace pcl_ssfr::simulation {

namespace {

constexpr int kColumnSides = 32;
constexpr double kUnitTolerance = 1e-6; // of a direction's length

/// "sphere 3 has radius -1, needs a positive number"
template <typename Value>
[[noreturn]] void
fail(const std::string& element, const std::string& field, const Value& value, const std::string& need)
{
  std::ostringstream text;
  text << element << " has " << field << ' ' << value << ", needs " << need;
  throw SimulationError(text.str());
}

template <typename Vector>
std::string
toText(const Vector& v)
{
  std::ostringstream text;
  text << '(' << v.x() << ", " << v.y() << ", " << v.z() << ')';
  return text.str();
}

template <typename Vector>
void
requireFinite(const std::string& element, const std::string& field, const Vector& v)
{
  if (!v.allFinite())
    fail(element, field, toText(v), "finite coordinates");
}

void
requirePositive(const std::string& element, const std::string& field, double value)
{
  if (!(value > 0) || !std::isfinite(value))
    fail(element, field, value, "a positive number");
}

void
requireMaterial(const SurfaceModel& model, const std::string& element, std::uint16_t material)
{
  if (material >= model.materials.size())
    fail(element, "material", material, "an index below " + std::to_string(model.materials.size()));
}

std::uint32_t
addVertex(TriangleMesh& mesh, const Eigen::Vector3d& vertex)
{
  mesh.vertices.emplace_back(vertex.cast<float>());
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void
addTriangle(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint16_t material)
{
  mesh.triangles.push_back({a, b, c});
  mesh.material.push_back(material);
}

} // namespace

std::uint16_t
SurfaceModel::addMaterial(const std::string& name, double reflectance)
{
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (materials[i].name == name)
      return static_cast<std::uint16_t>(i);
  if (materials.size() > std::numeric_limits<std::uint16_t>::max())
    fail("material '" + name + "'", "index", materials.size(), "at most 65535");
  materials.push_back({name, reflectance});
  return static_cast<std::uint16_t>(materials.size() - 1);
}

void
SurfaceModel::addPolygon(const std::vector<Eigen::Vector3d>& corners, std::uint16_t material)
{
  if (corners.size() != 3 && corners.size() != 4)
    fail("polygon", "corners", corners.size(), "3 or 4");
  const std::uint32_t first = addVertex(mesh, corners[0]);
  for (std::size_t i = 1; i < corners.size(); ++i)
    addVertex(mesh, corners[i]);
  addTriangle(mesh, first, first + 1, first + 2, material);
  if (corners.size() == 4)
    addTriangle(mesh, first, first + 2, first + 3, material);
}

void
SurfaceModel::addBox(const Eigen::Isometry3d& T_world_box, const Eigen::Vector3d& size, std::uint16_t material)
{
  if (!(size.array() > 0).all() || !size.allFinite())
    fail("box", "size", toText(size), "positive numbers");
  std::array<std::uint32_t, 8> corner{}; // bit 0: +x, bit 1: +y, bit 2: +z
  for (unsigned i = 0; i < corner.size(); ++i) {
    const Eigen::Vector3d sign((i & 1U) != 0 ? 0.5 : -0.5, (i & 2U) != 0 ? 0.5 : -0.5, (i & 4U) != 0 ? 0.5 : -0.5);
    corner[i] = addVertex(mesh, T_world_box * sign.cwiseProduct(size));
  }
  // Corners of each face, counterclockwise from outside.
  constexpr std::array<std::array<unsigned, 4>, 6> kFaces = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& face : kFaces) {
    addTriangle(mesh, corner[face[0]], corner[face[1]], corner[face[2]], material);
    addTriangle(mesh, corner[face[0]], corner[face[2]], corner[face[3]], material);
  }
}

void
SurfaceModel::addBlock(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw, std::uint16_t material)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = base + Eigen::Vector3d(0, 0, size.z() / 2);
  addBox(T, size, material);
}

void
SurfaceModel::addColumn(const Eigen::Vector3d& base, double radius, double height, std::uint16_t material)
{
  requirePositive("column", "radius", radius);
  requirePositive("column", "height", height);
  tubes.push_back({base, Eigen::Vector3d::UnitZ(), height, radius, material});
  // The fan is drawn about the circle, not into it, so that no ray gets in between the two.
  const double outer = radius / std::cos(kPi / kColumnSides);
  const Eigen::Vector3d top = base + Eigen::Vector3d(0, 0, height);
  const std::uint32_t centre = addVertex(mesh, top);
  for (int i = 0; i < kColumnSides; ++i) {
    const double angle = 2 * kPi * i / kColumnSides;
    addVertex(mesh, top + Eigen::Vector3d(outer * std::cos(angle), outer * std::sin(angle), 0));
  }
  for (std::uint32_t i = 0; i < kColumnSides; ++i)
    addTriangle(mesh, centre, centre + 1 + i, centre + 1 + (i + 1) % kColumnSides, material);
}

void
SurfaceModel::append(const SurfaceModel& other, const Eigen::Isometry3d& T)
{
  std::vector<std::uint16_t> merged;
  merged.reserve(other.materials.size());
  for (const Material& material : other.materials)
    merged.push_back(addMaterial(material.name, material.reflectance));

  // By counts taken before, and copies of elements: a model may be appended to itself.
  const std::size_t vertex_count = other.mesh.vertices.size();
  const std::size_t triangle_count = other.mesh.triangles.size();
  const std::size_t sphere_count = other.spheres.size();
  const std::size_t tube_count = other.tubes.size();
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::size_t i = 0; i < vertex_count; ++i)
    addVertex(mesh, T * other.mesh.vertices[i].cast<double>());
  for (std::size_t i = 0; i < triangle_count; ++i) {
    const std::array<std::uint32_t, 3> t = other.mesh.triangles[i];
    addTriangle(mesh, offset + t[0], offset + t[1], offset + t[2], merged.at(other.mesh.material.at(i)));
  }
  for (std::size_t i = 0; i < sphere_count; ++i) {
    Sphere sphere = other.spheres[i];
    sphere.centre = T * sphere.centre;
    sphere.material = merged.at(sphere.material);
    spheres.push_back(sphere);
  }
  for (std::size_t i = 0; i < tube_count; ++i) {
    Tube tube = other.tubes[i];
    tube.base = T * tube.base;
    tube.axis = (T.linear() * tube.axis).normalized();
    tube.material = merged.at(tube.material);
    tubes.push_back(tube);
  }
}

void
validate(const SurfaceModel& model)
{
  const TriangleMesh& mesh = model.mesh;
  if (mesh.triangles.empty() && model.spheres.empty() && model.tubes.empty())
    throw SimulationError("the scene is empty: it has no triangle, sphere or tube");
  for (const Material& material : model.materials)
    if (!(material.reflectance > 0 && material.reflectance <= 1))
      fail("material '" + material.name + "'", "reflectance", material.reflectance, "a number in (0, 1]");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      requireFinite("vertex " + std::to_string(i), "position", mesh.vertices[i]);
  if (mesh.material.size() != mesh.triangles.size())
    fail("mesh", "material entries", mesh.material.size(), std::to_string(mesh.triangles.size()) + ", one a triangle");
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t vertex : mesh.triangles[i])
      if (vertex >= mesh.vertices.size())
        fail("triangle " + std::to_string(i),
             "vertex",
             vertex,
             "an index below " + std::to_string(mesh.vertices.size()));
    if (mesh.material[i] >= model.materials.size())
      requireMaterial(model, "triangle " + std::to_string(i), mesh.material[i]);
  }
  for (std::size_t i = 0; i < model.spheres.size(); ++i) {
    const std::string element = "sphere " + std::to_string(i);
    requireFinite(element, "centre", model.spheres[i].centre);
    requirePositive(element, "radius", model.spheres[i].radius);
    requireMaterial(model, element, model.spheres[i].material);
  }
  for (std::size_t i = 0; i < model.tubes.size(); ++i) {
    const std::string element = "tube " + std::to_string(i);
    requireFinite(element, "base", model.tubes[i].base);
    requireFinite(element, "axis", model.tubes[i].axis);
    if (std::abs(model.tubes[i].axis.norm() - 1) > kUnitTolerance)
      fail(element, "axis", toText(model.tubes[i].axis), "length 1");
    requirePositive(element, "length", model.tubes[i].length);
    requirePositive(element, "radius", model.tubes[i].radius);
    requireMaterial(model, element, model.tubes[i].material);
  }
}

Eigen::AlignedBox3d
boundsOf(const SurfaceModel& model)
{
  Eigen::AlignedBox3d box;
  for (const auto& triangle : model.mesh.triangles)
    for (const std::uint32_t vertex : triangle)
      box.extend(model.mesh.vertices[vertex].cast<double>());
  for (const Sphere& sphere : model.spheres) {
    const Eigen::Vector3d extent = Eigen::Vector3d::Constant(sphere.radius);
    box.extend(sphere.centre - extent);
    box.extend(sphere.centre + extent);
  }
  for (const Tube& tube : model.tubes) {
    // A circle of normal a reaches r sqrt(1 - a_i^2) along axis i.
    const Eigen::Vector3d extent = tube.radius * (1 - tube.axis.array().square()).max(0).sqrt().matrix();
    for (const Eigen::Vector3d& end : {tube.base, Eigen::Vector3d(tube.base + tube.length * tube.axis)}) {
      box.extend(end - extent);
      box.extend(end + extent);
    }
  }
  return box;
}

} // namespace pcl_ssfr::simulation
