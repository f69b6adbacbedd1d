// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/thinning.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr int kCodeBitsPerAxis = 21;
constexpr double kHalfRange = 1 << (kCodeBitsPerAxis - 1); // voxels on each side of the origin
constexpr std::uint64_t kDropped = std::numeric_limits<std::uint64_t>::max();
constexpr std::size_t kExtentSamples = 20000; // points looked at for the percentile

/// Spread the low 21 bits of \p v so that two zero bits follow each of them.
std::uint64_t
spreadBits(std::uint64_t v)
{
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

struct CodedPoint {
  std::uint64_t code;
  std::uint32_t index;
};

/// Stable least-significant-digit radix sort by code; digits in which all codes agree are skipped.
void
sortByCode(std::vector<CodedPoint>& points)
{
  constexpr int kDigitBits = 11;
  constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;
  std::uint64_t all_and = ~std::uint64_t{0};
  std::uint64_t all_or = 0;
  for (const CodedPoint& p : points) {
    all_and &= p.code;
    all_or |= p.code;
  }
  const std::uint64_t varying = all_and ^ all_or;
  std::vector<CodedPoint> buffer(points.size());
  for (int shift = 0; shift < 64; shift += kDigitBits) {
    if (((varying >> shift) & (kBuckets - 1)) == 0)
      continue;
    std::array<std::size_t, kBuckets> start{};
    for (const CodedPoint& p : points)
      ++start[(p.code >> shift) & (kBuckets - 1)];
    std::size_t sum = 0;
    for (std::size_t& s : start)
      sum += std::exchange(s, sum);
    for (const CodedPoint& p : points)
      buffer[start[(p.code >> shift) & (kBuckets - 1)]++] = p;
    points.swap(buffer);
  }
}

} // namespace

ScanExtent
measureExtent(const ScanView& scan)
{
  ScanExtent extent;
  const std::size_t n = scan.count();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector3f high = Eigen::Vector3f::Constant(std::numeric_limits<float>::lowest());
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p = scan.point(i);
    if (!p.allFinite())
      continue;
    ++extent.finite_points;
    sum += p.cast<double>();
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  if (extent.finite_points == 0)
    return extent;
  extent.centroid = sum / static_cast<double>(extent.finite_points);
  extent.min = low.cast<double>();
  extent.max = high.cast<double>();

  // A few far returns (drivers write the largest float for "none") move the mean anywhere, but not the median.
  const std::size_t step = std::max<std::size_t>(1, extent.finite_points / kExtentSamples);
  std::vector<Eigen::Vector3d> sample;
  sample.reserve(extent.finite_points / step + 1);
  for (std::size_t i = 0, finite = 0; i < n; ++i)
    if (scan.point(i).allFinite() && finite++ % step == 0)
      sample.emplace_back(scan.point(i).cast<double>());
  std::vector<double> values(sample.size());
  const auto quantile = [&values](double q) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(sample.begin(), sample.end(), values.begin(), [axis](const Eigen::Vector3d& p) { return p[axis]; });
    extent.median[axis] = quantile(0.5);
  }
  std::transform(sample.begin(), sample.end(), values.begin(), [&extent](const Eigen::Vector3d& p) {
    return (p - extent.median).norm();
  });
  extent.radius = quantile(0.9);
  return extent;
}

ThinnedCloud
thinScan(const ScanView& scan, double leaf, const Eigen::Vector3d& origin, double max_distance, unsigned threads)
{
  ThinnedCloud thinned;
  thinned.leaf = leaf;
  thinned.origin = origin;
  const double limit = std::min(max_distance > 0 ? max_distance : std::numeric_limits<double>::max(),
                                std::min<double>((kHalfRange - 1) * leaf, std::numeric_limits<float>::max()));
  const double inverse_leaf = 1.0 / std::max(leaf, std::numeric_limits<double>::min()); // finite
  const auto n = static_cast<std::int64_t>(scan.count());

  std::vector<CodedPoint> coded(static_cast<std::size_t>(n));
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(threads))
  for (std::int64_t i = 0; i < n; ++i) {
    const auto u = static_cast<std::size_t>(i);
    CodedPoint& c = coded[u];
    c.index = static_cast<std::uint32_t>(u);
    const Eigen::Vector3d p = scan.point(u).cast<double>() - origin;
    if (!(p.array().abs() < limit).all()) { // also true for NaN, which maxCoeff() may skip
      c.code = kDropped;
      continue;
    }
    const Eigen::Array3d v = (p.array() * inverse_leaf).floor() + kHalfRange;
    c.code = spreadBits(static_cast<std::uint64_t>(v.x())) | spreadBits(static_cast<std::uint64_t>(v.y())) << 1 |
             spreadBits(static_cast<std::uint64_t>(v.z())) << 2;
  }
  coded.erase(std::remove_if(coded.begin(), coded.end(), [](const CodedPoint& c) { return c.code == kDropped; }),
              coded.end());
  sortByCode(coded);

  std::size_t voxels = 0;
  for (std::size_t i = 0; i < coded.size(); ++i)
    voxels += i == 0 || coded[i].code != coded[i - 1].code;
  thinned.points.resize(3, static_cast<Eigen::Index>(voxels));
  if (scan.normals)
    thinned.normals.resize(3, static_cast<Eigen::Index>(voxels));
  thinned.codes.reserve(voxels);
  thinned.counts.reserve(voxels);

  for (std::size_t i = 0; i < coded.size();) {
    const std::uint64_t code = coded[i].code;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Vector3f normal_sum = Eigen::Vector3f::Zero();
    std::uint32_t count = 0;
    for (; i < coded.size() && coded[i].code == code; ++i, ++count) {
      sum += scan.point(coded[i].index).cast<double>();
      if (scan.normals) {
        const Eigen::Vector3f normal = scan.normal(coded[i].index);
        if (std::abs(normal.squaredNorm() - 1.f) < 1e-2f) // false for NaN
          normal_sum += normal;
      }
    }
    const auto column = static_cast<Eigen::Index>(thinned.codes.size());
    const Eigen::Vector3d mean = sum / static_cast<double>(count);
    thinned.points.col(column) = (mean - origin).cast<float>();
    if (scan.normals)
      thinned.normals.col(column) = normal_sum;
    thinned.codes.push_back(code);
    thinned.counts.push_back(count);
  }
  return thinned;
}

} // namespace pcl_ssfr
