// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/scene_builder.h>

#include <functional>

/// What scenes out of doors have in common: ground, buildings, trees.
namespace pcl_ssfr::simulation::outdoors {

/// Height of the ground at x, y [m].
using Ground = std::function<double(double, double)>;

/// A strip of ground between two rows of points, in steps of about a metre along x.
void
addStrip(SurfaceModel& model, const parts::Rect& area, int rows, parts::Stuff stuff, const Ground& height);
/// A town house whose facade is on y = 0 and faces -y; it stands from x = 0 to \p width, behind the facade.
SurfaceModel
makeHouse(SceneBuilder& b, double width);
/// A building with rows of windows and a door on all four sides and a flat roof, from x = 0, y = 0 to its size [m].
SurfaceModel
makeBlock(SceneBuilder& b, double width, double depth, int storeys);
/// A tree of a wood: a bare trunk under a small crown, few triangles.
SurfaceModel
makeForestTree(SceneBuilder& b);
/// The foot of something on the ground takes floor there: \p reach on all sides of it. \return whether it stands
bool
stand(SceneBuilder& b,
      const SurfaceModel& part,
      const Eigen::Vector2d& at,
      double yaw,
      const Ground& height,
      double reach);

} // namespace pcl_ssfr::simulation::outdoors
