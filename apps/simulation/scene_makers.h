// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/simulation/scenes.h>

#include <cstdint>

/// The scenes, one function each; their names are in scenes.cpp.
namespace pcl_ssfr::simulation {

Scene
makeBasicModel(std::uint64_t seed);
Scene
makeApartment(std::uint64_t seed);
Scene
makeOfficeFloor(std::uint64_t seed);
Scene
makeHall(std::uint64_t seed);
Scene
makeStreet(std::uint64_t seed);
Scene
makeEndlessCorridor(std::uint64_t seed);
Scene
makeSymmetricRoom(std::uint64_t seed);
Scene
makeCylinderHall(std::uint64_t seed);
Scene
makeSlanted(std::uint64_t seed);
Scene
makeCave(std::uint64_t seed);
Scene
makeTwoFloorsAlike(std::uint64_t seed);
Scene
makeTower(std::uint64_t seed, const SceneOptions& options);
Scene
makeHotelCorridor(std::uint64_t seed, const SceneOptions& options);
Scene
makeTwinWings(std::uint64_t seed, const SceneOptions& options);
Scene
makePlantHall(std::uint64_t seed, const SceneOptions& options);
Scene
makeRoomsWithDoors(std::uint64_t seed);
Scene
makeCampus(std::uint64_t seed);
Scene
makeTreeRoad(std::uint64_t seed);
Scene
makeIndustrialSite(std::uint64_t seed);
Scene
makeCarParkLevels(std::uint64_t seed, const SceneOptions& options);
Scene
makeForestEdge(std::uint64_t seed);

} // namespace pcl_ssfr::simulation
