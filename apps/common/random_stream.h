// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace pcl_ssfr {

/** \brief Seeded random numbers that depend on nothing but their key: the standard's distributions differ by library.
 *
 * A stream is named by a seed and up to two numbers (scan, ray), so that any ray's numbers can be had in any order by
 * any thread. SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
 */
class RandomStream {
public:
  explicit RandomStream(std::uint64_t seed, std::uint64_t stream = 0, std::uint64_t substream = 0);
  /// 64 random bits.
  std::uint64_t
  next();
  /// Uniform in [low, high).
  double
  uniform(double low = 0, double high = 1);
  /// Standard normal (Box-Muller, two uniform numbers a call).
  double
  gaussian();
  /// Uniform in [0, count), count > 0.
  int
  index(int count);
  /// Uniformly random rotation.
  Eigen::Matrix3d
  rotation();

private:
  std::uint64_t state_;
};

} // namespace pcl_ssfr
