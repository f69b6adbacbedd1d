// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "distance_transform.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace pcl_ssfr::baselines {

namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity(); ///< no occupied voxel in the line so far
constexpr std::size_t kLinesTogether = 16;                         ///< neighbouring lines read as one cache line

/// Working space of one line of the transform.
struct LineBuffer {
  explicit LineBuffer(std::size_t length) : values(length), apexes(length), starts(length + 1) {}

  std::vector<float> values;
  std::vector<std::ptrdiff_t> apexes; ///< where the parabolas of the lower envelope have their lowest point
  std::vector<double> starts;         ///< from where on each of them is the lowest
};

/** \brief Squared distances along one line: out[q] = min over p of (q - p)^2 + in[p].
 *
 * The values are whole numbers below 2^20, so that floats hold them exactly.
 */
void
transformLine(float* line, std::size_t stride, std::size_t length, LineBuffer& buffer)
{
  const auto n = static_cast<std::ptrdiff_t>(length);
  std::ptrdiff_t last = -1; // parabola in the envelope
  for (std::ptrdiff_t q = 0; q < n; ++q) {
    const float value = line[static_cast<std::size_t>(q) * stride];
    buffer.values[static_cast<std::size_t>(q)] = value;
    if (value == kNothing)
      continue;
    const double height = static_cast<double>(value) + static_cast<double>(q * q);
    double start = -std::numeric_limits<double>::infinity();
    while (last >= 0) {
      const std::ptrdiff_t p = buffer.apexes[static_cast<std::size_t>(last)];
      const double other = static_cast<double>(buffer.values[static_cast<std::size_t>(p)]) + static_cast<double>(p * p);
      start = (height - other) / static_cast<double>(2 * (q - p));
      if (start > buffer.starts[static_cast<std::size_t>(last)])
        break;
      --last;
      start = -std::numeric_limits<double>::infinity();
    }
    ++last;
    buffer.apexes[static_cast<std::size_t>(last)] = q;
    buffer.starts[static_cast<std::size_t>(last)] = start;
  }
  if (last < 0)
    return;
  std::ptrdiff_t current = 0;
  for (std::ptrdiff_t q = 0; q < n; ++q) {
    while (current < last && buffer.starts[static_cast<std::size_t>(current + 1)] < static_cast<double>(q))
      ++current;
    const std::ptrdiff_t p = buffer.apexes[static_cast<std::size_t>(current)];
    line[static_cast<std::size_t>(q) * stride] =
        static_cast<float>((q - p) * (q - p)) + buffer.values[static_cast<std::size_t>(p)];
  }
}

/// Transform \p count lines whose first elements are neighbours in memory, by way of a copy that fits the cache.
void
transformLines(float* first, std::size_t count, std::size_t stride, std::size_t length, std::vector<float>& copy)
{
  LineBuffer buffer(length);
  copy.resize(kLinesTogether * length);
  for (std::size_t begin = 0; begin < count; begin += kLinesTogether) {
    const std::size_t together = std::min(kLinesTogether, count - begin);
    for (std::size_t q = 0; q < length; ++q)
      for (std::size_t l = 0; l < together; ++l)
        copy[l * length + q] = first[begin + l + q * stride];
    for (std::size_t l = 0; l < together; ++l)
      transformLine(copy.data() + l * length, 1, length, buffer);
    for (std::size_t q = 0; q < length; ++q)
      for (std::size_t l = 0; l < together; ++l)
        first[begin + l + q * stride] = copy[l * length + q];
  }
}

} // namespace

DistanceTransform::DistanceTransform(const Points3& points, int voxels, unsigned threads)
{
  if (voxels < 2 || voxels > kMaxVoxels)
    throw std::invalid_argument("distance transform: the number of voxels must be 2 to " + std::to_string(kMaxVoxels) +
                                ", not " + std::to_string(voxels));
  if (!points.allFinite())
    throw std::invalid_argument("distance transform: a point is not finite");
  if (points.cols() == 0)
    return;

  first_centre_ = points.rowwise().minCoeff();
  const Eigen::Vector3d extent = points.rowwise().maxCoeff() - first_centre_;
  if (extent.maxCoeff() > 0)
    voxel_size_ = extent.maxCoeff() / (voxels - 1);
  for (std::size_t axis = 0; axis < 3; ++axis)
    size_[axis] =
        std::clamp(static_cast<int>(std::lround(extent[static_cast<int>(axis)] / voxel_size_)) + 1, 1, voxels);
  const auto nx = static_cast<std::size_t>(size_[0]);
  const auto ny = static_cast<std::size_t>(size_[1]);
  const auto nz = static_cast<std::size_t>(size_[2]);

  distances_.assign(nx * ny * nz, kNothing);
  double farthest = 0; // of a point from the centre of its voxel, squared
  for (Eigen::Index column = 0; column < points.cols(); ++column) {
    const Eigen::Vector3d place = (points.col(column) - first_centre_) / voxel_size_;
    std::array<int, 3> voxel{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      voxel[axis] = std::clamp(static_cast<int>(std::lround(place[static_cast<int>(axis)])), 0, size_[axis] - 1);
    distances_[index(voxel[0], voxel[1], voxel[2])] = 0.0F;
    farthest = std::max(farthest, (place - Eigen::Vector3d(voxel[0], voxel[1], voxel[2])).squaredNorm());
  }
  // A place is at most half a diagonal from its voxel's centre, as is a point from the centre of its own.
  slack_ = voxel_size_ * (std::sqrt(0.75) + std::sqrt(farthest));

  // The lines of one pass do not touch each other.
  const auto workers = static_cast<int>(std::max(threads, 1U));
  const auto slices = static_cast<std::ptrdiff_t>(nz);
  const auto rows = static_cast<std::ptrdiff_t>(ny);
#pragma omp parallel num_threads(workers) if (workers > 1)
  {
    LineBuffer buffer(nx);
    std::vector<float> copy;
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < slices; ++k) {
      float* slice = distances_.data() + static_cast<std::size_t>(k) * nx * ny;
      for (std::size_t j = 0; j < ny; ++j)
        transformLine(slice + j * nx, 1, nx, buffer);
      transformLines(slice, nx, nx, ny, copy);
    }
#pragma omp for schedule(static)
    for (std::ptrdiff_t j = 0; j < rows; ++j) {
      float* row = distances_.data() + static_cast<std::size_t>(j) * nx;
      transformLines(row, nx, nx * ny, nz, copy);
      for (std::size_t k = 0; k < nz; ++k)
        for (std::size_t i = 0; i < nx; ++i)
          row[k * nx * ny + i] = std::sqrt(row[k * nx * ny + i]);
    }
  }
}

void
DistanceTransform::lookUp(const Eigen::Vector3d& x, double& value, double& squared_outside) const
{
  const Eigen::Vector3d place = toGrid(x);
  std::array<int, 3> voxel{};
  squared_outside = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double coordinate = place[static_cast<int>(axis)];
    const double inside = std::clamp(coordinate, 0.0, static_cast<double>(size_[axis]));
    voxel[axis] = std::min(static_cast<int>(inside), size_[axis] - 1);
    squared_outside += (coordinate - inside) * (coordinate - inside);
  }
  squared_outside *= voxel_size_ * voxel_size_;
  value = voxel_size_ * static_cast<double>(inVoxels(voxel[0], voxel[1], voxel[2]));
}

double
DistanceTransform::estimate(const Eigen::Vector3d& x) const
{
  double value = 0;
  double squared_outside = 0;
  lookUp(x, value, squared_outside);
  return std::sqrt(value * value + squared_outside);
}

double
DistanceTransform::lowerBound(const Eigen::Vector3d& x) const
{
  // The grid is a box with all points in it: seen from outside, they lie beyond a right angle at its nearest place c,
  // so that d(x)^2 >= |x - c|^2 + d(c)^2.
  double value = 0;
  double squared_outside = 0;
  lookUp(x, value, squared_outside);
  const double inside = std::max(value - slack_, 0.0);
  return std::sqrt(inside * inside + squared_outside);
}

} // namespace pcl_ssfr::baselines
