// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "go_icp_problem.h"

#include "common/angles.h"
#include "common/rotation_math.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

namespace pcl_ssfr::baselines {

namespace {

constexpr float kRounding = 1e-3F;      ///< slack for float arithmetic near the grid [voxels]
constexpr float kRoundingFar = 1e-6F;   ///< the same, for each voxel of a place's coordinates
constexpr double kFineCube = 2;         ///< cubes are fine below so many slacks of the distance transform
constexpr std::size_t kBlock = 32;      ///< points between two looks at whether the sum is large enough
constexpr double kRoundingShare = 1e-9; ///< of a lower bound, given up for rounding in double

using Block = Eigen::Array<float, static_cast<int>(kBlock), 1>;
using IndexBlock = Eigen::Array<int, static_cast<int>(kBlock), 1>;

/// Sum of the \p kept smallest values; reorders them.
template <typename T>
double
trimmedSum(std::vector<T>& values, std::size_t kept)
{
  if (kept < values.size())
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(kept), values.end());
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i)
    sum += static_cast<double>(values[i]);
  return sum;
}

/// Rotation and translation that bring the chosen columns of \p from onto those of \p to with the least squares.
Eigen::Isometry3d
fitRigid(const Points3& from, const Points3& to, const std::vector<Eigen::Index>& columns)
{
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mean = Eigen::Vector3d::Zero();
  for (const Eigen::Index c : columns) {
    from_mean += from.col(c);
    to_mean += to.col(c);
  }
  from_mean /= static_cast<double>(columns.size());
  to_mean /= static_cast<double>(columns.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Index c : columns)
    covariance += (to.col(c) - to_mean) * (from.col(c) - from_mean).transpose();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearestRotation(covariance);
  T.translation() = to_mean - T.linear() * from_mean;
  return T;
}

} // namespace

Eigen::Matrix3d
angleAxisRotation(const Eigen::Vector3d& v)
{
  const double angle = v.norm();
  if (!(angle > 0))
    return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

SearchCube
childOf(const SearchCube& cube, int child)
{
  SearchCube result;
  result.half = cube.half / 2;
  result.centre =
      cube.centre +
      result.half * Eigen::Vector3d((child & 1) != 0 ? 1 : -1, (child & 2) != 0 ? 1 : -1, (child & 4) != 0 ? 1 : -1);
  return result;
}

GoIcpProblem::GoIcpProblem(
    const Points3& source, const Points3& target, double trim_fraction, int voxels, unsigned threads)
    : source_(source), target_(target), transform_(target, voxels, threads), tree_(target)
{
  const auto trimmed = static_cast<Eigen::Index>(std::floor(trim_fraction * static_cast<double>(source.cols())));
  kept_ = std::clamp<Eigen::Index>(source.cols() - trimmed, 1, source.cols());
}

NeighborIndex::Neighbor
GoIcpProblem::nearest(const Eigen::Vector3d& x) const
{
  // The transform bounds how far the search must look; outside the grid it is only a guess.
  const double reach = transform_.estimate(x) + transform_.slack();
  NeighborIndex::Neighbor neighbor = tree_.nearest(x, reach);
  if (neighbor.index < 0)
    neighbor = tree_.nearest(x);
  return neighbor;
}

double
GoIcpProblem::error(const Eigen::Isometry3d& T) const
{
  std::vector<double> squares(static_cast<std::size_t>(source_.cols()));
  for (Eigen::Index i = 0; i < source_.cols(); ++i)
    squares[static_cast<std::size_t>(i)] = nearest(T * source_.col(i)).squared_distance;
  return trimmedSum(squares, static_cast<std::size_t>(kept_));
}

std::size_t
GoIcpProblem::countWithin(const Eigen::Isometry3d& T, double distance) const
{
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < source_.cols(); ++i)
    if (nearest(T * source_.col(i)).squared_distance <= distance * distance)
      ++count;
  return count;
}

double
GoIcpProblem::icp(Eigen::Isometry3d& T, int iterations, double progress) const
{
  const auto count = static_cast<std::size_t>(source_.cols());
  Points3 matches(3, source_.cols());
  std::vector<double> squares(count);
  std::vector<Eigen::Index> order(count);
  Eigen::Isometry3d current = T;
  double best = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= iterations; ++step) {
    for (Eigen::Index i = 0; i < source_.cols(); ++i) {
      const NeighborIndex::Neighbor neighbor = nearest(current * source_.col(i));
      squares[static_cast<std::size_t>(i)] = neighbor.squared_distance;
      matches.col(i) = target_.col(neighbor.index);
    }
    order.resize(count);
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    if (kept_ < source_.cols()) {
      std::nth_element(order.begin(), order.begin() + kept_, order.end(), [&](Eigen::Index a, Eigen::Index b) {
        const double of_a = squares[static_cast<std::size_t>(a)];
        const double of_b = squares[static_cast<std::size_t>(b)];
        return of_a < of_b || (of_a <= of_b && a < b);
      });
      order.resize(static_cast<std::size_t>(kept_));
      std::sort(order.begin(), order.end());
    }
    double sum = 0;
    for (const Eigen::Index i : order)
      sum += squares[static_cast<std::size_t>(i)];
    if (!(sum < best))
      break;
    const bool is_slow = step > 0 && best - sum <= progress * best;
    best = sum;
    T = current;
    if (is_slow)
      break;
    current = fitRigid(source_, matches, order);
  }
  return best;
}

GoIcpProblem::RotatedSource
GoIcpProblem::rotate(const SearchCube& rotations, bool uncertain) const
{
  RotatedSource result;
  const auto count = static_cast<std::size_t>(source_.cols());
  result.points = angleAxisRotation(rotations.centre) * source_;
  // Whole blocks; what is beyond the points is so uncertain that it adds nothing.
  const std::size_t padded = (count + kBlock - 1) / kBlock * kBlock;
  result.x.assign(padded, 0.0F);
  result.y.assign(padded, 0.0F);
  result.z.assign(padded, 0.0F);
  result.radius.assign(padded, std::numeric_limits<float>::max());
  result.radii.resize(count);
  // 5.1: a rotation of the cube moves a point by no more than half its diagonal against the centre's.
  const double angle = std::sqrt(3.0) * rotations.half;
  const double chord = uncertain ? chordFromAngle(std::min(angle, kPi)) : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Eigen::Vector3f place = transform_.toGrid(result.points.col(column)).cast<float>();
    result.x[i] = place.x();
    result.y[i] = place.y();
    result.z[i] = place.z();
    result.radii[i] = chord * source_.col(column).norm();
    result.radius[i] = static_cast<float>(result.radii[i] / transform_.voxelSize());
    result.largest_radius = std::max(result.largest_radius, result.radius[i]);
    result.reach = std::max(result.reach, place.cwiseAbs().maxCoeff());
  }
  return result;
}

GoIcpProblem::Bounds
GoIcpProblem::bounds(const RotatedSource& source,
                     const SearchCube& translations,
                     Centre centre_is,
                     double enough,
                     Scratch& scratch) const
{
  const auto count = static_cast<std::size_t>(source_.cols());
  const bool is_trimmed = kept_ < source_.cols();
  const double voxel = transform_.voxelSize();
  const double square = voxel * voxel; // of the unit of the points, one squared voxel
  const Eigen::Vector3f shift = (translations.centre / voxel).cast<float>();
  const float rounding = kRounding + kRoundingFar * (source.reach + shift.cwiseAbs().maxCoeff());
  const auto slack = static_cast<float>(transform_.slack() / voxel) + rounding;
  // 5.2: a translation of the cube is no farther than half its diagonal from the centre.
  const auto radius = static_cast<float>(std::sqrt(3.0) * translations.half / voxel) + slack;
  const float centre_offset = centre_is == Centre::Likely ? 0.0F : slack;
  const std::array<int, 3>& size = transform_.size();
  const auto row = size[0];
  const auto slice = row * size[1]; // fewer than 2^27 voxels
  const float* distances = transform_.distances().data();
  if (is_trimmed) {
    scratch.lower.resize(source.x.size());
    scratch.centre.resize(source.x.size());
  }

  double lower_sum = 0;
  double centre_sum = 0;
  for (std::size_t begin = 0; begin < source.x.size(); begin += kBlock) {
    Block outside = Block::Zero();
    const auto voxelsAlong = [&](const std::vector<float>& coordinates, int axis) {
      const auto edge = static_cast<float>(size[static_cast<std::size_t>(axis)]);
      const Block place = Eigen::Map<const Block>(coordinates.data() + begin) + shift[axis];
      const Block inside = place.max(0.0F).min(edge);
      outside += (place - inside).square();
      return IndexBlock(inside.min(std::nextafter(edge, 0.0F)).cast<int>());
    };
    const IndexBlock x = voxelsAlong(source.x, 0);
    const IndexBlock y = voxelsAlong(source.y, 1);
    const IndexBlock z = voxelsAlong(source.z, 2);
    Block distance; // at the centre of the translations
    for (int i = 0; i < static_cast<int>(kBlock); ++i)
      distance[i] = distances[x[i] + row * y[i] + slice * z[i]];
    Block certain = distance - radius; // what is left of it for any translation of the cube
    if ((outside > 0.0F).any()) {
      certain = ((distance - slack).max(0.0F).square() + outside).sqrt() + (slack - rounding - radius);
      if (centre_is == Centre::Likely)
        distance = (distance.square() + outside).sqrt();
      else
        distance += outside.sqrt();
    }
    distance += centre_offset;
    const Eigen::Map<const Block> point_radius(source.radius.data() + begin);
    const Block lower = (certain - point_radius).max(0.0F).square();
    const Block centre = (distance - point_radius).max(0.0F).square();
    if (is_trimmed) {
      Eigen::Map<Block>(scratch.lower.data() + begin) = lower;
      Eigen::Map<Block>(scratch.centre.data() + begin) = centre;
      continue;
    }
    lower_sum += static_cast<double>(lower.sum());
    centre_sum += static_cast<double>(centre.sum());
    if (lower_sum * square > enough)
      break;
  }

  Bounds result;
  if (is_trimmed) {
    scratch.lower.resize(count);
    scratch.centre.resize(count);
    lower_sum = trimmedSum(scratch.lower, static_cast<std::size_t>(kept_));
    if (lower_sum * square <= enough)
      centre_sum = trimmedSum(scratch.centre, static_cast<std::size_t>(kept_));
    else
      centre_sum = lower_sum;
  }
  // Sums of up to kBlock floats are exact to less than a part in 10^5.
  constexpr double kSumRounding = 1e-5;
  result.lower = (1 - kSumRounding) * lower_sum * square;
  result.centre = centre_sum * square;
  return result;
}

GoIcpProblem::Bounds
GoIcpProblem::exactBounds(const RotatedSource& source,
                          const SearchCube& translations,
                          double enough,
                          Scratch& scratch) const
{
  const auto count = static_cast<std::size_t>(source_.cols());
  const bool is_trimmed = kept_ < source_.cols();
  const double radius = std::sqrt(3.0) * translations.half;
  const auto squared = [](double length) { return length > 0 ? length * length : 0; };
  scratch.exact_lower.assign(count, 0);
  scratch.exact_centre.assign(count, 0);
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d place = source.points.col(static_cast<Eigen::Index>(i)) + translations.centre;
    const double distance = std::sqrt(nearest(place).squared_distance) - source.radii[i];
    scratch.exact_centre[i] = squared(distance);
    scratch.exact_lower[i] = squared(distance - radius);
    sum += scratch.exact_lower[i];
    if (!is_trimmed && (1 - kRoundingShare) * sum > enough)
      break;
  }
  Bounds result;
  result.lower = (1 - kRoundingShare) * trimmedSum(scratch.exact_lower, static_cast<std::size_t>(kept_));
  result.centre = (1 + kRoundingShare) * trimmedSum(scratch.exact_centre, static_cast<std::size_t>(kept_));
  return result;
}

bool
GoIcpProblem::isFine(const RotatedSource& source, const SearchCube& translations) const
{
  const double radius =
      static_cast<double>(source.largest_radius) * transform_.voxelSize() + std::sqrt(3.0) * translations.half;
  return radius < kFineCube * transform_.slack();
}

double
GoIcpProblem::uncertainty(const RotatedSource& source) const
{
  const double by_rotation = static_cast<double>(source.largest_radius) * transform_.voxelSize();
  const bool is_sharp = by_rotation > 0 && by_rotation < transform_.slack();
  return is_sharp ? by_rotation : by_rotation + transform_.slack();
}

} // namespace pcl_ssfr::baselines
