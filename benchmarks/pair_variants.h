// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/dataset_folder.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstdint>
#include <vector>

namespace pcl_ssfr::benchmarks {

/// What is taken away from a scan, to make it harder than it was recorded. The sensor lies at the origin.
struct Spoil {
  std::size_t every = 1;       ///< keep every k-th point, at least 1
  double sector_degrees = 360; ///< keep a sector of this width about z, at a random place [deg], 0 to 360
  double nearest = 1;          ///< keep this share of the points, those nearest to the sensor, 0 to 1
};

/// A scan without what is taken away, in its order. Same scan, spoil and seed: same points.
/// \throw std::invalid_argument naming the value that is out of range
pcl::PointCloud<pcl::PointXYZ>::Ptr
spoiled(const pcl::PointCloud<pcl::PointXYZ>& scan, const Spoil& spoil, std::uint64_t seed);

/// All ordered pairs of scans that chains of the given pairs connect, but for the given ones themselves: those the
/// other way round, and those of scans that are farther apart. The truth is that of the shortest chain.
std::vector<io::ScanPair>
otherPairs(const std::vector<io::ScanPair>& pairs);

} // namespace pcl_ssfr::benchmarks
