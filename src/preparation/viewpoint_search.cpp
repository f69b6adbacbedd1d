// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "preparation/viewpoint_search.h"

#include "common/angles.h"
#include "common/even_draw.h"
#include "common/parallel.h"
#include "common/vector_clones.h"
#include "preparation/range_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace {

using Level = ViewpointSearchConfig::Level;

/// At most \p most of the points, evenly drawn in their order.
Eigen::Matrix3Xf
drawPoints(const Eigen::Matrix3Xf& points, Eigen::Index most)
{
  const auto all = static_cast<std::size_t>(points.cols()), n = std::min(static_cast<std::size_t>(most), all);
  Eigen::Matrix3Xf drawn(3, static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i)
    drawn.col(static_cast<Eigen::Index>(i)) = points.col(static_cast<Eigen::Index>(evenlyDrawn(i, n, all)));
  return drawn;
}

/// Directions for each point that rates a place, where places are compared with those around them.
constexpr Eigen::Index kDirections = 4;

/// A grid with so many directions for each of the \p points that rate. A scan with few points, which are all among
/// them, has four for each: in narrower ones its returns hardly meet.
DirectionGrid
gridFor(Eigen::Index points, Eigen::Index directions, Eigen::Index all)
{
  const Eigen::Index n = std::min(directions * points, kDirections * all);
  return DirectionGrid(std::min(1.0, std::sqrt(4 * kPi / static_cast<double>(n))));
}

/// In how many directions something is seen.
struct DirectionCounts {
  int occupied = 0;   ///< something is seen
  int several = 0;    ///< several returns
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

/// The objective of the search: how well some points may have been seen from a place.
class Rating {
public:
  Rating(const Eigen::Matrix3Xf& points,
         int most,
         Eigen::Index directions,
         const PreparationConfig& config,
         const Deadline& deadline)
      : points_(drawPoints(points, most)), grid_(gridFor(points_.cols(), directions, points.cols())),
        config_(config.viewpoint), margin_(config.margin), deadline_(deadline)
  {}

  /// Of \p place, as a share of the points.
  double
  operator()(const Eigen::Vector3f& place) const
  {
    const DirectionCounts counts = count(place);
    return (counts.occupied - config_.two_depth_weight * counts.two_depths) / static_cast<double>(points_.cols());
  }
  /// Whether few of the directions that hold several returns, seen from \p place, hold two depths.
  bool
  isClear(const Eigen::Vector3f& place) const
  {
    const DirectionCounts counts = count(place);
    // Where hardly any direction holds several returns, edges alone make most of these.
    const double several = std::max(static_cast<double>(counts.several), counts.occupied / config_.two_depth_weight);
    return counts.two_depths <= config_.max_two_depths * several;
  }
  /// Whether \p place is rated markedly higher than the places around it.
  bool
  accepts(const Eigen::Vector3f& place) const
  {
    double around = 0;
    for (int k = 0; k < 6; ++k) {
      Eigen::Vector3f other = place;
      other[k / 2] += static_cast<float>(k % 2 ? config_.contrast_distance : -config_.contrast_distance);
      around += (*this)(other) / 6;
    }
    return (*this)(place)-around >= config_.min_contrast;
  }

private:
  DirectionCounts
  count(const Eigen::Vector3f& place) const
  {
    return countDirections(depthSpans(points_, place, grid_, deadline_), config_.depth_ratio, margin_);
  }

  Eigen::Matrix3Xf points_;
  DirectionGrid grid_;
  const ViewpointSearchConfig& config_;
  double margin_;
  const Deadline& deadline_;
};

/// Mean logarithm of the ranges from \p place; ranges below \p margin [m] do not count much.
PCL_SSFR_VECTOR_CLONES double
meanLogRange(const Eigen::Matrix3Xf& points, const Eigen::Vector3f& place, double margin)
{
  // Of a product: that of eight floats is within the range of a double.
  constexpr auto kFactors = static_cast<Eigen::Index>(kSumGroup);
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
  double score = 0;
};

void
sortByScore(std::vector<Place>& places)
{
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.score > b.score; });
}

/// Walk along the axes while that raises \p score(place), and until \p deadline, in steps that are halved from \p step
/// down to \p last.
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
  std::vector<Eigen::Array3i> rated = {here};
  place.score = score(start);
  while (stride > 0) {
    bool risen = false;
    for (int k = 0; k < 6; ++k) {
      if (deadline.hasPassed())
        return;
      Eigen::Array3i cell = here;
      cell[k / 2] += k % 2 ? stride : -stride;
      if (std::any_of(rated.begin(), rated.end(), [&](const Eigen::Array3i& j) { return (j == cell).all(); }))
        continue; // the scores only rise: it was lower
      rated.push_back(cell);
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

/// A grid of places about the middle of \p points, in the box in which they are about as near to them as any.
struct PlaceGrid {
  std::vector<Place> places;
  double step = 0; ///< [m]
};

PlaceGrid
layGrid(const Eigen::Matrix3Xf& points, const PreparationConfig& config, const Deadline& deadline)
{
  const Level& level = config.viewpoint.levels.front();
  const auto nearness = [&](const Eigen::Vector3f& place) { return -meanLogRange(points, place, config.margin); };
  Place middle;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXf along = points.row(axis);
    std::nth_element(along.data(), along.data() + along.size() / 2, along.data() + along.size());
    middle.position[axis] = along[along.size() / 2];
  }
  climb(middle, 4 * level.step, level.step, deadline, nearness);
  PlaceGrid grid;
  grid.step = level.step;
  Eigen::Array3i low, high;
  for (int k = 0; k < 6; ++k) {
    int steps = 0;
    for (Eigen::Vector3f place = middle.position; steps < level.places && !deadline.hasPassed(); ++steps) {
      place[k / 2] += static_cast<float>(k % 2 ? grid.step : -grid.step);
      if (nearness(place) < middle.score - config.viewpoint.reach)
        break;
    }
    (k % 2 ? high : low)[k / 2] = k % 2 ? steps : -steps;
  }
  const double shrink = std::max(1.0, std::cbrt((high - low + 1).cast<double>().prod() / level.places));
  grid.step *= shrink;
  low = (low.cast<double>() / shrink).cast<int>();
  high = (high.cast<double>() / shrink).cast<int>();
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        grid.places.push_back(
            {middle.position + static_cast<float>(grid.step) * Eigen::Array3i(x, y, z).cast<float>().matrix()});
  return grid;
}

/// The first \p most of the places, best first, that are no neighbours on the grid.
std::vector<Place>
keepApart(const std::vector<Place>& places, int most, double step)
{
  std::vector<Place> kept;
  for (const Place& place : places) {
    if (kept.size() >= static_cast<std::size_t>(most))
      break;
    if (std::none_of(kept.begin(), kept.end(), [&](const Place& other) {
          return (other.position - place.position).lpNorm<Eigen::Infinity>() < 1.5 * step;
        }))
      kept.push_back(place);
  }
  return kept;
}

} // namespace

bool
isPlausibleViewpoint(const Eigen::Matrix3Xf& points,
                     const Eigen::Vector3f& place,
                     const PreparationConfig& config,
                     const Deadline& deadline)
{
  // The many points of the last level lie on few rings: directions between the rings stay empty, and things show more
  // rings apart the nearer a place is to them. Fewer points leave as wide gaps along the rings as between them; with as
  // few as those of the first level chance makes as much contrast as the bound asks for.
  const auto& levels = config.viewpoint.levels;
  return points.cols() > 0 && std::any_of(levels.rbegin(), levels.rend() - 1, [&](const Level& level) {
           return Rating(points, level.points, kDirections, config, deadline).accepts(place);
         });
}

std::optional<Eigen::Vector3f>
findViewpoint(const Eigen::Matrix3Xf& points,
              const PreparationConfig& config,
              unsigned threads,
              const Deadline& deadline)
{
  if (points.cols() == 0)
    return std::nullopt;
  const ViewpointSearchConfig& search = config.viewpoint;
  PlaceGrid grid = layGrid(drawPoints(points, search.levels.front().points), config, deadline);
  std::vector<Place> best = std::move(grid.places);
  double step = grid.step; // to which the best places are known
  const auto visitAndSort = [&](const auto& visit) {
    forEachInParallel(static_cast<std::int64_t>(best.size()), 1, static_cast<int>(threads), [&](std::int64_t i) {
      visit(best[static_cast<std::size_t>(i)]);
    });
    sortByScore(best);
  };
  for (const Level& level : search.levels) {
    const bool moves = level.step < search.levels.front().step;
    const Rating rating(points, level.points, moves ? kDirections : search.grid_directions, config, deadline);
    const auto rate = [&](Place& place) { place.score = deadline.hasPassed() ? 0 : rating(place.position); };
    if (moves) {
      const bool have_moved = step < grid.step;
      if (have_moved) // The few that are left are compared by this level's points; to move them all would take longer.
        visitAndSort(rate);
      best = keepApart(best, level.places, step);
      visitAndSort([&](Place& place) { climb(place, step / 2, level.step, deadline, rating); });
      step = level.step;
    }
    else {
      if (&level != &search.levels.front())
        best.resize(std::min(best.size(), static_cast<std::size_t>(level.places)));
      visitAndSort(rate);
    }
  }
  const Eigen::Vector3f place = best.front().position;
  const Rating rating(points, search.levels.back().points, kDirections, config, deadline);
  // Where much is seen at two depths even from the best place, scans were merged.
  const bool is_found = rating.isClear(place) && rating.accepts(place);
  return is_found && !deadline.hasPassed() ? std::optional<Eigen::Vector3f>(place) : std::nullopt;
}

} // namespace pcl_ssfr
