// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/scene_builder.h>

#include <vector>

/// Rooms in rows on a corridor, and what furnishes them: offices, hotels, wings.
namespace pcl_ssfr::simulation::rooms {

constexpr double kOuter = 0.3;     // thickness of outer walls [m]
constexpr double kInner = 0.12;    // and of inner ones [m]
constexpr double kDoorWidth = 1.0; // [m]

void
addDeskWithChair(SceneBuilder& b, const parts::Rect& room);
void
furnishOffice(SceneBuilder& b, const parts::Rect& room, double height);
void
furnishMeetingRoom(SceneBuilder& b, const parts::Rect& room, double height);
void
furnishStore(SceneBuilder& b, const parts::Rect& room);

/// Windows of a room in an outer wall that runs from \p from along x or against it.
void
addWindows(SceneBuilder& b, std::vector<parts::Opening>& openings, double from, double to);

/// A row of rooms on one side of a corridor.
struct RoomRow {
  std::vector<double> ends;  ///< of the rooms along x [m]
  std::vector<double> doors; ///< middle of each room's door [m]
};

/// Rooms of random widths over a length [m].
RoomRow
planRow(SceneBuilder& b, double length, int rooms);
/// The walls of a row: \p corridor and \p outer are y of its corridor wall and of its outer face; doors open into the
/// rooms.
void
addRow(SceneBuilder& b, const RoomRow& row, double corridor, double outer, double height);
/// The floor of room \p i between its walls.
parts::Rect
roomOf(const RoomRow& row, std::size_t i, double corridor, double outer);

} // namespace pcl_ssfr::simulation::rooms
