// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/mesh_file.h>

#include <apps/simulation/simulation_error.h>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <optional>
#include <sstream>

namespace pcl_ssfr::simulation {

namespace {

constexpr double kNoColour = 0.5;  // reflectance of what has no colour
constexpr double kColourStep = 20; // reflectances are rounded to 1/20: few materials
constexpr double kLeast = 0.05;    // of a black colour
constexpr double kMaxExtent = 1e5; // [m]; single precision places a point within 1 cm there

[[noreturn]] void
fail(const std::string& path, const std::string& message)
{
  throw SimulationError(path + ": " + message);
}

void
requireFinite(const std::string& path, const aiScene& scene)
{
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))
        continue;
      std::ostringstream text;
      text << "vertex " << v << " of mesh " << m << " is (" << p.x << ", " << p.y << ", " << p.z
           << "), needs finite coordinates";
      fail(path, text.str());
    }
  }
}

/// Mean of the three channels as a reflectance in (0, 1].
double
reflectanceOf(const aiColor4D& colour)
{
  const double mean =
      (static_cast<double>(colour.r) + static_cast<double>(colour.g) + static_cast<double>(colour.b)) / 3;
  return std::isfinite(mean) ? std::clamp(std::round(mean * kColourStep) / kColourStep, kLeast, 1.0) : kNoColour;
}

/// Reflectance of a mesh's material; nothing when the file has none (Assimp then makes one up).
std::optional<double>
materialReflectance(const aiScene& scene, const aiMesh& mesh)
{
  if (mesh.mMaterialIndex >= scene.mNumMaterials)
    return std::nullopt;
  const aiMaterial& material = *scene.mMaterials[mesh.mMaterialIndex];
  aiString name;
  aiColor4D colour;
  // Readers of formats without materials make up a white one without a name, or this one.
  if (material.Get(AI_MATKEY_NAME, name) != aiReturn_SUCCESS || name.length == 0 ||
      name.C_Str() == std::string(AI_DEFAULT_MATERIAL_NAME))
    return std::nullopt;
  if (material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) != aiReturn_SUCCESS)
    return std::nullopt;
  return reflectanceOf(colour);
}

/// The material of a reflectance, made when it is new.
std::uint16_t
addReflectance(SurfaceModel& model, std::optional<double> reflectance)
{
  if (!reflectance)
    return model.addMaterial("no colour", kNoColour);
  std::ostringstream name;
  name << "colour " << std::fixed << std::setprecision(2) << *reflectance;
  return model.addMaterial(name.str(), *reflectance);
}

void
addMesh(SurfaceModel& model, const aiScene& scene, const aiMesh& mesh)
{
  const auto first = static_cast<std::uint32_t>(model.mesh.vertices.size());
  for (unsigned v = 0; v < mesh.mNumVertices; ++v)
    model.mesh.vertices.emplace_back(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
  const std::optional<double> whole = materialReflectance(scene, mesh);
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3)
      continue; // points and lines
    const auto corner = [&](unsigned i) {
      return Eigen::Vector3d(model.mesh.vertices[first + face.mIndices[i]].cast<double>());
    };
    if ((corner(1) - corner(0)).cross(corner(2) - corner(0)).isZero(0))
      continue; // no area
    std::optional<double> reflectance = whole;
    if (mesh.HasVertexColors(0)) {
      const aiColor4D* colours = mesh.mColors[0];
      const aiColor4D sum = colours[face.mIndices[0]] + colours[face.mIndices[1]] + colours[face.mIndices[2]];
      reflectance = reflectanceOf(sum / 3.0F);
    }
    model.mesh.triangles.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    model.mesh.material.push_back(addReflectance(model, reflectance));
  }
}

} // namespace

SurfaceModel
loadMesh(const std::string& path)
{
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found)
    fail(path, "no such file");
  if (std::filesystem::is_directory(status))
    fail(path, "is a directory");

  Assimp::Importer importer;
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(path, 0);
    if (scene != nullptr) {
      requireFinite(path, *scene); // before triangulation can trip over it
      scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_PreTransformVertices);
    }
  }
  catch (const SimulationError&) {
    throw;
  }
  catch (const std::exception& exception) {
    fail(path, std::string("cannot be read as a mesh: ") + exception.what());
  }
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    std::replace_if(
        reason.begin(), reason.end(), [](char c) { return c < ' ' || c > '~'; }, ' ');
    fail(path, "cannot be read as a mesh: " + reason);
  }
  requireFinite(path, *scene);

  SurfaceModel model;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m)
    addMesh(model, *scene, *scene->mMeshes[m]);
  if (model.mesh.triangles.empty())
    fail(path, "has no triangle");
  const Eigen::AlignedBox3d bounds = boundsOf(model);
  const double extent = bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).maxCoeff();
  if (extent > kMaxExtent) {
    std::ostringstream text;
    text << "has coordinates up to " << extent << " m, needs at most " << kMaxExtent << ": move it near the origin";
    fail(path, text.str());
  }
  return model;
}

} // namespace pcl_ssfr::simulation
