// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>

#include <Eigen/Geometry>

#include <cmath>

namespace pcl_ssfr {

namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;

std::uint64_t
mix(std::uint64_t value)
{
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

} // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t stream, std::uint64_t substream)
    : state_(mix(mix(mix(seed + kGolden) ^ (stream + 2 * kGolden)) ^ (substream + 3 * kGolden)))
{}

std::uint64_t
RandomStream::next()
{
  state_ += kGolden;
  return mix(state_);
}

double
RandomStream::uniform(double low, double high)
{
  constexpr double kUnit = 1.0 / 9007199254740992.0; // 2^-53
  return low + (high - low) * (static_cast<double>(next() >> 11) * kUnit);
}

double
RandomStream::gaussian()
{
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  return radius * std::cos(kTwoPi * uniform());
}

int
RandomStream::index(int count)
{
  return static_cast<int>(next() % static_cast<std::uint64_t>(count));
}

Eigen::Matrix3d
RandomStream::rotation()
{
  // Shoemake, Graphics Gems III, 1992.
  const double u = uniform();
  const double a = kTwoPi * uniform();
  const double b = kTwoPi * uniform();
  const Eigen::Quaterniond q(std::sqrt(u) * std::cos(b),
                             std::sqrt(1 - u) * std::sin(a),
                             std::sqrt(1 - u) * std::cos(a),
                             std::sqrt(u) * std::sin(b));
  return q.normalized().toRotationMatrix();
}

} // namespace pcl_ssfr
