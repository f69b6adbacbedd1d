// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/range_image.h"

#include "common/parallel.h"
#include "common/vector_clones.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace pcl_ssfr {

namespace {

constexpr double kRightAngle = 1.5707963267948966;
constexpr double kViewpointCell = 0.01745; // [rad]
constexpr double kDepthRatio = 1.5;
constexpr double kDepthMargin = 0.3; // [m] at scale 1
constexpr double kDisplacement = 3;  // [m] at scale 1
constexpr double kMinSpread = 0.35;  // occupied directions, relative to those seen from the centroid
// Measured on 80 single scans (gain 1.46 and more, 1.9 in the median of the worst set) and on merged ones (up to 1.5).
constexpr double kCleanShare = 0.01;
constexpr double kMinMixedShare = 0.03;
constexpr double kMaxMixing = 0.95;
constexpr double kClearGain = 1.8;
constexpr double kWeakGain = 1.4;
constexpr double kMaxFineShareAtWeakGain = 0.08;

// Search for the sensor: places are judged by few points in wide cells, the best of them by more points in finer ones.
constexpr Eigen::Index kFirstPoints = 1500;
constexpr double kFirstCell = 0.08;  // [rad]
constexpr double kFirstShare = 0.25; // of all places, which is judged again
constexpr Eigen::Index kCoarsePoints = 6000;
constexpr double kCoarseCell = 0.04; // [rad]
constexpr Eigen::Index kMiddlePoints = 12000;
constexpr double kMiddleCell = 0.032; // [rad]
constexpr Eigen::Index kFinePoints = 40000;
constexpr double kFineCell = 0.0175;     // [rad]
constexpr double kPlaceStep = 1;         // [m] at scale 1, of the grid of places
constexpr double kMaxPlaces = 1500;      // else the grid is wider
constexpr std::size_t kMinPlaces = 100;  // are judged again
constexpr std::size_t kClimbs = 6;       // from the best places
constexpr std::size_t kMiddleClimbs = 3; // go on with more points, ...
constexpr std::size_t kFineClimbs = 2;   // go on with many points
constexpr double kFirstMiddleStep = 0.3; // [m] at scale 1
constexpr double kFirstFineStep = 0.1;   // [m] at scale 1
constexpr double kLastFineStep = 0.05;   // [m] at scale 1
constexpr double kPlaceRatio = 1.25;     // of two depths, to judge places
constexpr double kTwoDepthPenalty = 10;  // of a direction with two depths, in directions that see something
// Returns crowd around a sensor: their mean log range from it is near the least of all places (80 scans: within 0.25).
constexpr double kMaxRemoteness = 0.25;
// At the best place of 80 single scans, those of a sparse street aside, the score was 0.09 of the points and more, and
// 6 % of the directions or fewer had two depths; of merged scans of a car park less than 0, and 7 % or more.
constexpr double kMinPlaceScore = 0.05; // of the points
constexpr double kMaxTwoDepths = 0.06;
// Of the best score: a doubted place that reaches it is as good as any found. Corridors: 0.79 and more, frames of
// buildings: 0.3 and less.
constexpr double kDoubtedShare = 0.75;

/// Ranges of the nearest and the farthest return of a cell [m]; zeros when there was none.
struct DepthSpan {
  float nearest = 0;
  float farthest = 0;
};

/// Some points as seen from a place: arrays, so that the compiler can handle several points at once.
struct SightBlock {
  static constexpr std::size_t kSize = 256;
  using Floats = std::array<float, kSize>;

  Floats x, y, z; ///< from the place [m]
  Floats range;   ///< [m]
  std::array<int, kSize> cells;

  /// \p count of \p points from column \p first on.
  PCL_SSFR_VECTOR_CLONES void
  look(const Eigen::Matrix3Xf& points,
       std::size_t first,
       std::size_t count,
       const Eigen::Vector3f& place,
       const DirectionGrid& grid)
  {
    const float* const coordinates = points.data() + 3 * first;
    look({coordinates, coordinates + 1, coordinates + 2}, 3, count, place, grid);
  }

  /// \p count points whose coordinates are \p stride apart in arrays.
  [[gnu::always_inline]] inline void
  look(const std::array<const float*, 3>& points,
       std::size_t stride,
       std::size_t count,
       const Eigen::Vector3f& place,
       const DirectionGrid& grid)
  {
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = points[0][stride * i] - place.x();
      y[i] = points[1][stride * i] - place.y();
      z[i] = points[2][stride * i] - place.z();
    }
    for (std::size_t i = 0; i < count; ++i)
      range[i] = std::sqrt(x[i] * x[i] + (y[i] * y[i] + z[i] * z[i]));
    for (std::size_t i = 0; i < count; ++i)
      cells[i] = grid.cell(x[i], y[i], z[i]);
  }
};

/// What is seen from \p viewpoint in each cell; of no use when \p deadline passes meanwhile.
std::vector<DepthSpan>
depthSpans(const Eigen::Matrix3Xf& points,
           const Eigen::Vector3f& viewpoint,
           const DirectionGrid& grid,
           const Deadline& deadline = Deadline())
{
  constexpr std::size_t kPointsPerLook = 64 * SightBlock::kSize;
  const auto n = static_cast<std::size_t>(points.cols());
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  std::vector<DepthSpan> spans(grid.size(), DepthSpan{kNothing, 0});
  SightBlock block;
  for (std::size_t first = 0; first < n; first += SightBlock::kSize) {
    if (first % kPointsPerLook == 0 && deadline.hasPassed())
      break;
    const std::size_t count = std::min(SightBlock::kSize, n - first);
    block.look(points, first, count, viewpoint, grid);
    for (std::size_t i = 0; i < count; ++i) {
      const float range = block.range[i];
      if (!(range > 0 && range < kNothing))
        continue;
      DepthSpan& span = spans[static_cast<std::size_t>(block.cells[i])];
      span.nearest = std::min(span.nearest, range);
      span.farthest = std::max(span.farthest, range);
    }
  }
  for (DepthSpan& span : spans)
    span.nearest = span.farthest > 0 ? span.nearest : 0;
  return spans;
}

/// In how many directions something is seen.
struct DirectionCounts {
  int occupied = 0;   ///< something is seen
  int several = 0;    ///< at several ranges
  int two_depths = 0; ///< the farthest is beyond a ratio of the nearest and a margin
};

PCL_SSFR_VECTOR_CLONES DirectionCounts
countDirections(const std::vector<DepthSpan>& spans, double ratio, double margin)
{
  const DepthSpan* const first = spans.data();
  const std::size_t n = spans.size();
  int occupied = 0;
  int several = 0;
  int two_depths = 0;
  for (std::size_t i = 0; i < n; ++i) {
    occupied += static_cast<int>(first[i].nearest > 0);
    several += static_cast<int>(first[i].farthest > first[i].nearest);
    two_depths += static_cast<int>(static_cast<double>(first[i].farthest) >
                                   ratio * static_cast<double>(first[i].nearest) + margin);
  }
  return {occupied, several, two_depths};
}

double
twoDepthShare(const std::vector<DepthSpan>& spans, double margin)
{
  const DirectionCounts counts = countDirections(spans, kDepthRatio, margin);
  return counts.several ? static_cast<double>(counts.two_depths) / counts.several : 0;
}

/// At most \p most of the points, evenly drawn in their order.
Eigen::Matrix3Xf
drawPoints(const Eigen::Matrix3Xf& points, Eigen::Index most)
{
  const Eigen::Index n = std::min(most, points.cols());
  Eigen::Matrix3Xf drawn(3, n);
  for (Eigen::Index i = 0; i < n; ++i)
    drawn.col(i) = points.col((2 * i + 1) * points.cols() / (2 * n));
  return drawn;
}

/// How well \p points may have been seen from \p place: the directions that see something, less those that see two
/// depths.
double
placeScore(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& place, const DirectionGrid& grid, double margin)
{
  const DirectionCounts counts = countDirections(depthSpans(points, place, grid), kPlaceRatio, margin);
  return counts.occupied - kTwoDepthPenalty * counts.two_depths;
}

/// Mean logarithm of the ranges from \p place; ranges below \p margin [m] do not count much.
PCL_SSFR_VECTOR_CLONES double
remoteness(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& place, double margin)
{
  constexpr Eigen::Index kFactors = 8; // of a product: that of eight floats is within the range of a double
  const float* const coordinates = points.data();
  const auto least = static_cast<float>(margin);
  std::array<double, kFactors> ranges;
  double sum = 0;
  for (Eigen::Index first = 0; first < points.cols(); first += kFactors) {
    const Eigen::Index count = std::min(kFactors, points.cols() - first);
    ranges.fill(1);
    for (Eigen::Index i = 0; i < count; ++i) {
      const float* const point = coordinates + 3 * (first + i);
      const float x = point[0] - place.x();
      const float y = point[1] - place.y();
      const float z = point[2] - place.z();
      ranges[static_cast<std::size_t>(i)] = static_cast<double>(std::sqrt(x * x + (y * y + z * z)) + least);
    }
    double product = 1;
    for (const double range : ranges)
      product *= range;
    sum += std::log(product);
  }
  return sum / static_cast<double>(points.cols());
}

struct Place {
  Eigen::Vector3f position;
  double score;
};

/// Walk along the axes while that raises \p score(place), and until \p deadline, in steps that are halved down to \p
/// last.
template <typename Score>
void
climb(Place& place, double step, double last, const Deadline& deadline, const Score& score)
{
  int stride = 1; // in units of the last step: the places lie on a grid of these
  for (; step >= 2 * last; step *= 0.5)
    stride *= 2;
  const Eigen::Vector3f start = place.position;
  const auto unit = static_cast<float>(step);
  Eigen::Array3i here = Eigen::Array3i::Zero();
  std::vector<Eigen::Array3i> judged = {here};
  place.score = score(start);
  while (stride > 0) {
    bool risen = false;
    for (int k = 0; k < 6; ++k) {
      if (deadline.hasPassed())
        return;
      Eigen::Array3i cell = here;
      cell[k / 2] += k % 2 ? stride : -stride;
      if (std::any_of(judged.begin(), judged.end(), [&](const Eigen::Array3i& j) { return (j == cell).all(); }))
        continue; // the scores only rise: it was lower
      judged.push_back(cell);
      const Eigen::Vector3f position = start + unit * cell.cast<float>().matrix();
      const double next = score(position);
      if (next > place.score) {
        place = {position, next};
        here = cell;
        risen = true;
      }
    }
    if (!risen)
      stride /= 2;
  }
}

} // namespace

DirectionGrid::DirectionGrid(double cell)
    : resolution_(std::max(1, static_cast<int>(std::ceil(kRightAngle / cell)))),
      half_(0.5f * static_cast<float>(resolution_))
{}

RangeImage::RangeImage(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell)
    : grid_(cell), viewpoint_(viewpoint)
{
  nearest_.reserve(grid_.size());
  farthest_.reserve(grid_.size());
  for (const DepthSpan& span : depthSpans(points, viewpoint, grid_)) {
    nearest_.push_back(span.nearest);
    farthest_.push_back(span.farthest);
  }
  findFreeRanges();
}

void
RangeImage::findFreeRanges()
{
  free_.assign(nearest_.size(), 0.f);
  const int resolution = grid_.resolution();
  for (int face = 0; face < 6; ++face)
    for (int row = 0; row < resolution; ++row)
      for (int column = 0; column < resolution; ++column) {
        const auto at = [&](int r, int c) {
          return static_cast<std::size_t>((face * resolution + r) * resolution + c);
        };
        const float own = nearest_[at(row, column)];
        if (own == 0)
          continue;
        float least = own;
        for (int r = std::max(0, row - 1); r <= std::min(resolution - 1, row + 1); ++r)
          for (int c = std::max(0, column - 1); c <= std::min(resolution - 1, column + 1); ++c)
            if (nearest_[at(r, c)] > 0)
              least = std::min(least, nearest_[at(r, c)]);
        free_[at(row, column)] = least;
      }
}

PCL_SSFR_VECTOR_CLONES void
RangeImage::findFree(
    const std::array<const float*, 3>& places, std::size_t count, float ratio, float margin, std::int32_t* free) const
{
  if (empty()) {
    std::fill(free, free + count, 0);
    return;
  }
  SightBlock block;
  for (std::size_t first = 0; first < count; first += SightBlock::kSize) {
    const std::size_t n = std::min(SightBlock::kSize, count - first);
    block.look({places[0] + first, places[1] + first, places[2] + first}, 1, n, viewpoint_, grid_);
    for (std::size_t i = 0; i < n; ++i) {
      const float reach = free_[static_cast<std::size_t>(block.cells[i])];
      free[first + i] = static_cast<int>(reach > 0) & static_cast<int>(block.range[i] < ratio * reach - margin);
    }
  }
}

double
twoDepthShare(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& viewpoint, double cell, double margin)
{
  return twoDepthShare(depthSpans(points, viewpoint, DirectionGrid(cell)), margin);
}

bool
isPlausibleViewpoint(const Eigen::Matrix3Xf& points,
                     const Eigen::Vector3f& viewpoint,
                     double scale,
                     const Deadline& deadline)
{
  if (points.cols() == 0)
    return false;
  const double margin = kDepthMargin * scale;
  // A sensor spreads its returns over the directions; from elsewhere, and more so from afar, they bunch.
  const Eigen::Vector3f centroid = points.cast<double>().rowwise().mean().cast<float>();
  const DirectionGrid grid(kViewpointCell);
  const std::vector<DepthSpan> spans = depthSpans(points, viewpoint, grid, deadline);
  const auto occupied = [&](const std::vector<DepthSpan>& seen) {
    return countDirections(seen, kDepthRatio, margin).occupied;
  };
  if (occupied(spans) < kMinSpread * occupied(depthSpans(points, centroid, grid, deadline)))
    return false;

  const double here = twoDepthShare(spans, margin);
  if (here <= kCleanShare)
    return true;
  // In one scan two depths meet at the edges of things only, and fewer in finer cells; where scans were merged they
  // meet all over.
  const double finer =
      twoDepthShare(depthSpans(points, viewpoint, DirectionGrid(0.5 * kViewpointCell), deadline), margin);
  if (here > kMinMixedShare && finer > kMaxMixing * here)
    return false;
  // Every place adds to the gain: once it is clear, the other places cannot change the answer.
  double elsewhere = 0;
  for (int k = 0; k < 6 && elsewhere / here < kClearGain; ++k) {
    Eigen::Vector3f place = viewpoint;
    place[k / 2] += static_cast<float>((k % 2 ? 1 : -1) * kDisplacement * scale);
    elsewhere += twoDepthShare(depthSpans(points, place, grid, deadline), margin) / 6;
  }
  const double gain = elsewhere / here;
  return gain >= kClearGain || (gain >= kWeakGain && finer < kMaxFineShareAtWeakGain);
}

std::optional<Eigen::Vector3f>
findViewpoint(const Eigen::Matrix3Xf& points,
              const Eigen::Matrix3Xf& thinned,
              double scale,
              unsigned threads,
              const Eigen::Vector3f* doubted,
              const Deadline& deadline)
{
  if (points.cols() == 0 || thinned.cols() == 0)
    return std::nullopt;
  const auto workers = static_cast<int>(threads);
  const double margin = kDepthMargin * scale;
  const Eigen::Matrix3Xf coarse = drawPoints(points, kCoarsePoints);
  Place middle;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXf along = coarse.row(axis);
    std::nth_element(along.data(), along.data() + along.size() / 2, along.data() + along.size());
    middle.position[axis] = along[along.size() / 2];
  }
  const auto nearness = [&](const Eigen::Vector3f& place) { return -remoteness(coarse, place, margin); };
  climb(middle, 4 * kPlaceStep * scale, kPlaceStep * scale, deadline, nearness);
  // The box around the middle in which places are near enough to the returns.
  double step = kPlaceStep * scale;
  constexpr int kMaxSteps = 100;
  Eigen::Array3i low, high;
  for (int k = 0; k < 6; ++k) {
    int steps = 0;
    for (Eigen::Vector3f place = middle.position; steps < kMaxSteps && !deadline.hasPassed(); ++steps) {
      place[k / 2] += static_cast<float>(k % 2 ? step : -step);
      if (nearness(place) < middle.score - kMaxRemoteness)
        break;
    }
    (k % 2 ? high : low)[k / 2] = k % 2 ? steps : -steps;
  }
  const double shrink = std::max(1.0, std::cbrt((high - low + 1).cast<double>().prod() / kMaxPlaces));
  step *= shrink;
  low = (low.cast<double>() / shrink).cast<int>();
  high = (high.cast<double>() / shrink).cast<int>();
  const Eigen::Array3i dims = high - low + 1;
  std::vector<Place> places(static_cast<std::size_t>(dims.prod()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto k = static_cast<int>(i);
    const Eigen::Array3i cell(k % dims.x(), k / dims.x() % dims.y(), k / dims.x() / dims.y());
    places[i].position = middle.position + static_cast<float>(step) * (low + cell).cast<float>().matrix();
  }
  // Rank the places by what they see of some points.
  const auto rankPlaces = [&](const Eigen::Matrix3Xf& seen, double cell) {
    const DirectionGrid grid(cell);
    forEachInParallel(static_cast<std::int64_t>(places.size()), 16, workers, [&](std::int64_t i) {
      Place& place = places[static_cast<std::size_t>(i)];
      place.score = deadline.hasPassed() ? 0 : placeScore(seen, place.position, grid, margin);
    });
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.score > b.score; });
  };
  rankPlaces(drawPoints(points, kFirstPoints), kFirstCell);
  places.resize(std::max(std::min(places.size(), kMinPlaces),
                         static_cast<std::size_t>(kFirstShare * static_cast<double>(places.size()))));
  rankPlaces(coarse, kCoarseCell);
  if (deadline.hasPassed())
    return std::nullopt;
  std::vector<Place> best;
  for (const Place& place : places) {
    if (best.size() >= kClimbs)
      break;
    if (nearness(place.position) >= middle.score - kMaxRemoteness &&
        std::none_of(best.begin(), best.end(), [&](const Place& other) {
          return (other.position - place.position).norm() < 1.5 * step;
        }))
      best.push_back(place);
  }
  if (best.empty())
    return std::nullopt;
  const auto climbAll = [&](const Eigen::Matrix3Xf& seen, double cell, double first, double last) {
    const DirectionGrid grid(cell);
    forEachInParallel(static_cast<std::int64_t>(best.size()), 1, workers, [&](std::int64_t i) {
      climb(best[static_cast<std::size_t>(i)], first, last, deadline, [&](const Eigen::Vector3f& place) {
        return placeScore(seen, place, grid, margin);
      });
    });
    std::stable_sort(best.begin(), best.end(), [](const Place& a, const Place& b) { return a.score > b.score; });
  };
  climbAll(coarse, kCoarseCell, 0.5 * step, 0.25 * step);
  best.resize(std::min(best.size(), kMiddleClimbs));
  climbAll(drawPoints(points, kMiddlePoints), kMiddleCell, kFirstMiddleStep * scale, kFirstFineStep * scale);
  best.resize(std::min(best.size(), kFineClimbs));
  const Eigen::Matrix3Xf fine = drawPoints(points, kFinePoints);
  climbAll(fine, kFineCell, kFirstFineStep * scale, kLastFineStep * scale);
  if (deadline.hasPassed())
    return std::nullopt;
  const Place& chosen = best.front();
  if (doubted && placeScore(fine, *doubted, DirectionGrid(kFineCell), margin) >= kDoubtedShare * chosen.score)
    return std::nullopt;
  if (chosen.score < kMinPlaceScore * static_cast<double>(fine.cols()) ||
      twoDepthShare(thinned, chosen.position, kViewpointCell, margin) > kMaxTwoDepths)
    return std::nullopt;
  return chosen.position;
}

} // namespace pcl_ssfr
