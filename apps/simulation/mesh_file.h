// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/surface_model.h>

#include <string>

namespace pcl_ssfr::simulation {

/** \brief Read a triangle mesh (OBJ, PLY, STL and what else Assimp knows), coordinates in metres, z up.
 *
 * Faces of more corners are triangulated, node transforms applied, and triangles without area dropped. Every triangle
 * gets the reflectance of its diffuse colour when the file has one, else 0.5. \throw SimulationError naming the file:
 * missing, not readable, no triangle, or a coordinate that is not finite
 */
SurfaceModel
loadMesh(const std::string& path);

} // namespace pcl_ssfr::simulation
