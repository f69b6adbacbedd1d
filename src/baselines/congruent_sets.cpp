// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "congruent_sets.h"

#include "common/angles.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace pcl_ssfr::baselines {

namespace {

constexpr double kMinBaseAngle = 20 * kDegree; ///< between the segments of a base
constexpr double kMinRatio = 0.1;              ///< the crossing keeps this share of the segment from its ends
constexpr int kTriangleTrials = 200;           ///< random triangles of which the widest is taken
constexpr double kMinSidePerDiameter = 0.2;    ///< points of a base are at least this far apart
constexpr std::size_t kPointsPerLeaf = 8;      ///< of the octree
constexpr int kMaxCellsPerAxis = 128;          ///< of the grid of crossings
constexpr int kBinsPerEdge = 4;                ///< direction bins along an edge of the cube around the unit sphere
constexpr int kBins = 6 * kBinsPerEdge * kBinsPerEdge;

Eigen::Index
randomColumn(const Points3& points, std::mt19937_64& engine)
{
  return static_cast<Eigen::Index>(engine() % static_cast<std::uint64_t>(points.cols()));
}

double
angleBetween(const Eigen::Vector3d& unit_a, const Eigen::Vector3d& unit_b)
{
  return std::acos(std::clamp(unit_a.dot(unit_b), -1.0, 1.0));
}

/// Where the segments a-b and c-d come nearest, as lines; nothing when that is outside either or they are parallel.
std::optional<CoplanarBase>
crossing(const Points3& points, const Quad& quad, double gap)
{
  const Eigen::Vector3d a = points.col(quad[0]);
  const Eigen::Vector3d c = points.col(quad[2]);
  const Eigen::Vector3d u = points.col(quad[1]) - a;
  const Eigen::Vector3d v = points.col(quad[3]) - c;
  CoplanarBase base;
  base.points = quad;
  base.first_length = u.norm();
  base.second_length = v.norm();
  if (!(base.first_length > 0) || !(base.second_length > 0))
    return std::nullopt;
  base.angle = angleBetween(u / base.first_length, v / base.second_length);
  if (base.angle < kMinBaseAngle || base.angle > kPi - kMinBaseAngle)
    return std::nullopt;
  const double uv = u.dot(v);
  const double determinant = u.squaredNorm() * v.squaredNorm() - uv * uv;
  const Eigen::Vector3d w = c - a;
  base.first_ratio = (v.squaredNorm() * u.dot(w) - uv * v.dot(w)) / determinant;
  base.second_ratio = (uv * u.dot(w) - u.squaredNorm() * v.dot(w)) / determinant;
  const auto is_inside = [](double ratio) { return ratio >= kMinRatio && ratio <= 1 - kMinRatio; };
  if (!is_inside(base.first_ratio) || !is_inside(base.second_ratio))
    return std::nullopt;
  if ((a + base.first_ratio * u - c - base.second_ratio * v).norm() > gap)
    return std::nullopt;
  return base;
}

/// Squared distances of the nearest and the farthest point of a box.
std::pair<double, double>
squaredDistances(const Eigen::Vector3d& point, const Eigen::Vector3d& min, const Eigen::Vector3d& max)
{
  const Eigen::Vector3d below = min - point;
  const Eigen::Vector3d above = point - max;
  const Eigen::Vector3d nearest = below.cwiseMax(above).cwiseMax(0);
  const Eigen::Vector3d farthest = below.cwiseAbs().cwiseMax(above.cwiseAbs());
  return {nearest.squaredNorm(), farthest.squaredNorm()};
}

/// The cube around the unit sphere, its faces cut into squares.
class DirectionBins {
public:
  DirectionBins()
  {
    for (int bin = 0; bin < kBins; ++bin) {
      const int face = bin / (kBinsPerEdge * kBinsPerEdge);
      const int row = bin / kBinsPerEdge % kBinsPerEdge;
      const int column = bin % kBinsPerEdge;
      const auto on_face = [&](double i, double j) {
        Eigen::Vector3d direction = Eigen::Vector3d::Zero();
        direction[face / 2] = face % 2 == 0 ? 1 : -1;
        direction[(face / 2 + 1) % 3] = 2 * i / kBinsPerEdge - 1;
        direction[(face / 2 + 2) % 3] = 2 * j / kBinsPerEdge - 1;
        return Eigen::Vector3d(direction.normalized());
      };
      const auto slot = static_cast<std::size_t>(bin);
      centres_[slot] = on_face(row + 0.5, column + 0.5);
      radii_[slot] = 0;
      for (int corner = 0; corner < 4; ++corner) {
        const int upper = corner / 2;
        const Eigen::Vector3d direction = on_face(row + upper, column + corner % 2);
        radii_[slot] = std::max(radii_[slot], angleBetween(centres_[slot], direction));
      }
    }
  }

  static int
  binOf(const Eigen::Vector3d& direction)
  {
    Eigen::Index axis = 0;
    const double length = direction.cwiseAbs().maxCoeff(&axis);
    const auto part = [&](Eigen::Index k) {
      const double place = (direction[k] / length + 1) / 2 * kBinsPerEdge;
      return std::clamp(static_cast<int>(place), 0, kBinsPerEdge - 1);
    };
    const int face = 2 * static_cast<int>(axis) + (direction[axis] > 0 ? 0 : 1);
    return (face * kBinsPerEdge + part((axis + 1) % 3)) * kBinsPerEdge + part((axis + 2) % 3);
  }

  /// Entry kBins a + b: bins a and b may hold directions that are \p angle apart within \p tolerance [rad].
  std::vector<char>
  compatible(double angle, double tolerance) const
  {
    constexpr double kRounding = 1e-7;
    std::vector<char> table(static_cast<std::size_t>(kBins) * kBins, 0);
    for (std::size_t a = 0; a < kBins; ++a) {
      for (std::size_t b = 0; b < kBins; ++b) {
        const double difference = std::abs(angleBetween(centres_[a], centres_[b]) - angle);
        table[a * kBins + b] = difference <= radii_[a] + radii_[b] + tolerance + kRounding ? 1 : 0;
      }
    }
    return table;
  }

private:
  std::array<Eigen::Vector3d, kBins> centres_;
  std::array<double, kBins> radii_ = {};
};

/// The crossing on a pair and the pair's direction.
struct Crossing {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(); ///< unit; 0 for two equal points
  int bin = 0;
  int cell = 0;
  std::size_t pair = 0;
};

Crossing
crossingOn(const Points3& points, const PointPair& pair, double ratio)
{
  Crossing result;
  const Eigen::Vector3d segment = points.col(pair.second) - points.col(pair.first);
  const double length = segment.norm();
  result.position = points.col(pair.first) + ratio * segment;
  if (length > 0)
    result.direction = segment / length;
  result.bin = DirectionBins::binOf(length > 0 ? segment : Eigen::Vector3d::UnitX());
  return result;
}

/// A dense grid over a box.
struct Grid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double edge = 1; ///< of a cell [m]
  Eigen::Vector3i size = Eigen::Vector3i::Ones();

  Grid(const Eigen::Vector3d& min, const Eigen::Vector3d& max, double least_edge) : origin(min)
  {
    edge = std::max(least_edge, (max - min).maxCoeff() / (kMaxCellsPerAxis - 1));
    size = ((max - min) / edge).array().floor().cast<int>() + 1;
  }
  Eigen::Vector3i
  cell(const Eigen::Vector3d& position) const
  {
    // Far outside is as good as just outside; int could not hold it.
    const Eigen::Array3d place = ((position - origin) / edge).array().floor();
    return place.max(-2.0).min(kMaxCellsPerAxis + 2.0).cast<int>();
  }
  bool
  contains(const Eigen::Vector3i& cell) const
  {
    return (cell.array() >= 0).all() && (cell.array() < size.array()).all();
  }
  int
  number(const Eigen::Vector3i& cell) const
  {
    return (cell.z() * size.y() + cell.y()) * size.x() + cell.x();
  }
};

} // namespace

std::optional<CoplanarBase>
makeBase(const Points3& points, const Quad& quad, double gap)
{
  constexpr std::array<std::array<std::size_t, 4>, 3> kPairings = {{{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}}};
  for (const auto& pairing : kPairings) {
    const Quad ordered = {quad[pairing[0]], quad[pairing[1]], quad[pairing[2]], quad[pairing[3]]};
    if (std::optional<CoplanarBase> base = crossing(points, ordered, gap))
      return base;
  }
  return std::nullopt;
}

std::optional<CoplanarBase>
selectBase(const Points3& points, double max_diameter, double thickness, std::mt19937_64& engine)
{
  if (points.cols() < kBasePoints)
    return std::nullopt;
  const double squared_max = max_diameter * max_diameter;
  const double squared_min = kMinSidePerDiameter * kMinSidePerDiameter * squared_max;
  const auto is_apart = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const double squared = (a - b).squaredNorm();
    return squared >= squared_min && squared <= squared_max;
  };

  const Eigen::Index first = randomColumn(points, engine);
  const Eigen::Vector3d p0 = points.col(first);
  Eigen::Index second = -1;
  Eigen::Index third = -1;
  double widest = 0;
  for (int trial = 0; trial < kTriangleTrials; ++trial) {
    const Eigen::Index i = randomColumn(points, engine);
    const Eigen::Index j = randomColumn(points, engine);
    if (!is_apart(p0, points.col(i)) || !is_apart(p0, points.col(j)) || !is_apart(points.col(i), points.col(j)))
      continue;
    const double area = (points.col(i) - p0).cross(points.col(j) - p0).squaredNorm();
    if (area > widest) {
      widest = area;
      second = i;
      third = j;
    }
  }
  if (second < 0)
    return std::nullopt;

  const Eigen::Vector3d p1 = points.col(second);
  const Eigen::Vector3d p2 = points.col(third);
  const Eigen::Vector3d normal = (p1 - p0).cross(p2 - p0).normalized();
  std::optional<CoplanarBase> best;
  double farthest = 0;
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const Eigen::Vector3d p = points.col(k);
    if (std::abs(normal.dot(p - p0)) > thickness || !is_apart(p, p0) || !is_apart(p, p1) || !is_apart(p, p2))
      continue;
    const double nearest = std::min({(p - p0).squaredNorm(), (p - p1).squaredNorm(), (p - p2).squaredNorm()});
    if (nearest <= farthest)
      continue;
    if (std::optional<CoplanarBase> base = makeBase(points, {first, second, third, k}, thickness)) {
      best = base;
      farthest = nearest;
    }
  }
  return best;
}

PairExtractor::PairExtractor(const Points3& points) : points_(points), order_(static_cast<std::size_t>(points.cols()))
{
  std::iota(order_.begin(), order_.end(), Eigen::Index{0});
  if (points.cols() == 0)
    return;
  Node root;
  root.end = order_.size();
  root.min = points.rowwise().minCoeff();
  root.max = points.rowwise().maxCoeff();
  nodes_.push_back(root);
  for (std::size_t node = 0; node < nodes_.size(); ++node)
    split(node);
}

void
PairExtractor::split(std::size_t node)
{
  const Node parent = nodes_[node];
  if (parent.end - parent.begin <= kPointsPerLeaf || !((parent.max - parent.min).maxCoeff() > 0))
    return;
  const Eigen::Vector3d middle = (parent.min + parent.max) / 2;
  const auto octant = [&](Eigen::Index column) {
    // The largest coordinate is above even where the middle rounds to it.
    const Eigen::Array3i above =
        (points_.col(column).array() > middle.array() || points_.col(column).array() >= parent.max.array()).cast<int>();
    return above.x() + 2 * above.y() + 4 * above.z();
  };
  const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(parent.begin);
  const auto end = order_.begin() + static_cast<std::ptrdiff_t>(parent.end);
  std::stable_sort(begin, end, [&](Eigen::Index a, Eigen::Index b) { return octant(a) < octant(b); });
  nodes_[node].first_child = nodes_.size();
  for (std::size_t first = parent.begin; first < parent.end;) {
    Node child;
    child.begin = first;
    child.min = points_.col(order_[first]);
    child.max = child.min;
    const int cell = octant(order_[first]);
    for (; first < parent.end && octant(order_[first]) == cell; ++first) {
      child.min = child.min.cwiseMin(points_.col(order_[first]));
      child.max = child.max.cwiseMax(points_.col(order_[first]));
    }
    child.end = first;
    nodes_.push_back(child);
    ++nodes_[node].children;
  }
}

std::vector<PointPair>
PairExtractor::extract(double length, double tolerance, unsigned threads) const
{
  if (nodes_.empty() || !(length + tolerance >= 0))
    return {};
  const double inner = std::max(length - tolerance, 0.0);
  const double outer = length + tolerance;
  // The boxes are compared as squares, which round differently from the distances.
  constexpr double kSlack = 1e-9;
  const double squared_inner = inner * inner * (1 - kSlack);
  const double squared_outer = outer * outer * (1 + kSlack);

  const auto count = static_cast<std::ptrdiff_t>(points_.cols());
  std::vector<std::vector<Eigen::Index>> partners(static_cast<std::size_t>(count));
  [[maybe_unused]] const int workers = static_cast<int>(std::max(threads, 1U));
#pragma omp parallel for num_threads(workers) schedule(dynamic, 32) if (workers > 1)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Eigen::Vector3d centre = points_.col(i);
    std::vector<Eigen::Index>& found = partners[static_cast<std::size_t>(i)];
    std::vector<std::size_t> open = {0};
    while (!open.empty()) {
      const Node& node = nodes_[open.back()];
      open.pop_back();
      const auto [nearest, farthest] = squaredDistances(centre, node.min, node.max);
      if (nearest > squared_outer || farthest < squared_inner)
        continue;
      for (std::size_t child = 0; child < node.children; ++child)
        open.push_back(node.first_child + child);
      for (std::size_t k = node.begin; node.children == 0 && k < node.end; ++k) {
        const Eigen::Index j = order_[k];
        if (j != i && std::abs((points_.col(j) - centre).norm() - length) <= tolerance)
          found.push_back(j);
      }
    }
    std::sort(found.begin(), found.end());
  }
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < partners.size(); ++i) {
    for (const Eigen::Index j : partners[i])
      pairs.push_back({static_cast<Eigen::Index>(i), j});
  }
  return pairs;
}

SegmentNormals
measureNormals(const Points3& points, const Points3& normals, const PointPair& pair)
{
  const auto angle = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const double scale = a.norm() * b.norm();
    return scale > 0 ? std::acos(std::min(std::abs(a.dot(b)) / scale, 1.0)) : std::numeric_limits<double>::quiet_NaN();
  };
  const Eigen::Vector3d segment = points.col(pair.second) - points.col(pair.first);
  SegmentNormals result;
  result.first = angle(normals.col(pair.first), segment);
  result.second = angle(normals.col(pair.second), segment);
  result.between = angle(normals.col(pair.first), normals.col(pair.second));
  return result;
}

std::vector<PointPair>
filterByNormals(const Points3& points,
                const Points3& normals,
                const std::vector<PointPair>& pairs,
                const SegmentNormals& model,
                double tolerance)
{
  // Written so that a NaN agrees.
  const auto differ = [tolerance](double a, double b) { return std::abs(a - b) > tolerance; };
  std::vector<PointPair> kept;
  for (const PointPair& pair : pairs) {
    const SegmentNormals angles = measureNormals(points, normals, pair);
    if (!differ(angles.first, model.first) && !differ(angles.second, model.second) &&
        !differ(angles.between, model.between))
      kept.push_back(pair);
  }
  return kept;
}

std::vector<Quad>
findCongruentQuads(const Points3& points,
                   const std::vector<PointPair>& first_pairs,
                   const std::vector<PointPair>& second_pairs,
                   const CoplanarBase& base,
                   const QuadTolerance& tolerance,
                   unsigned threads)
{
  if (first_pairs.empty() || second_pairs.empty() || !(tolerance.distance > 0))
    return {};

  // The crossings on the first pairs, by cell and direction.
  Eigen::Vector3d min = Eigen::Vector3d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector3d max = -min;
  std::vector<Crossing> crossings;
  crossings.reserve(first_pairs.size());
  for (const PointPair& pair : first_pairs) {
    crossings.push_back(crossingOn(points, pair, base.first_ratio));
    crossings.back().pair = crossings.size() - 1;
    min = min.cwiseMin(crossings.back().position);
    max = max.cwiseMax(crossings.back().position);
  }
  const Grid grid(min, max, tolerance.distance);
  for (Crossing& entry : crossings)
    entry.cell = grid.number(grid.cell(entry.position));
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::make_pair(std::make_pair(a.cell, a.bin), a.pair) <
           std::make_pair(std::make_pair(b.cell, b.bin), b.pair);
  });
  std::vector<std::size_t> cell_begin(static_cast<std::size_t>(grid.size.prod()) + 1, 0);
  for (const Crossing& entry : crossings)
    ++cell_begin[static_cast<std::size_t>(entry.cell) + 1];
  std::partial_sum(cell_begin.begin(), cell_begin.end(), cell_begin.begin());

  const DirectionBins bins;
  const std::vector<char> compatible = bins.compatible(base.angle, tolerance.angle);
  const double squared_distance = tolerance.distance * tolerance.distance;

  const auto count = static_cast<std::ptrdiff_t>(second_pairs.size());
  std::vector<std::vector<std::size_t>> matches(second_pairs.size());
  [[maybe_unused]] const int workers = static_cast<int>(std::max(threads, 1U));
#pragma omp parallel for num_threads(workers) schedule(dynamic, 256) if (workers > 1)
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const PointPair& pair = second_pairs[static_cast<std::size_t>(i)];
    const Crossing query = crossingOn(points, pair, base.second_ratio);
    const Eigen::Vector3i centre = grid.cell(query.position);
    std::vector<std::size_t>& found = matches[static_cast<std::size_t>(i)];
    for (int neighbor = 0; neighbor < 27; ++neighbor) {
      const Eigen::Vector3i cell = centre + Eigen::Vector3i(neighbor % 3 - 1, neighbor / 3 % 3 - 1, neighbor / 9 - 1);
      if (!grid.contains(cell))
        continue;
      const auto number = static_cast<std::size_t>(grid.number(cell));
      const std::size_t end = cell_begin[number + 1];
      for (std::size_t k = cell_begin[number]; k < end;) {
        const int bin = crossings[k].bin;
        const bool is_on_cone = compatible[static_cast<std::size_t>(bin * kBins + query.bin)] != 0;
        for (; k < end && crossings[k].bin == bin; ++k) {
          const Crossing& entry = crossings[k];
          if (!is_on_cone || (entry.position - query.position).squaredNorm() > squared_distance ||
              std::abs(angleBetween(entry.direction, query.direction) - base.angle) > tolerance.angle)
            continue;
          const PointPair& other = first_pairs[entry.pair];
          if (other.first != pair.first && other.first != pair.second && other.second != pair.first &&
              other.second != pair.second)
            found.push_back(entry.pair);
        }
      }
    }
    std::sort(found.begin(), found.end());
  }
  std::vector<Quad> quads;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (const std::size_t k : matches[i])
      quads.push_back({first_pairs[k].first, first_pairs[k].second, second_pairs[i].first, second_pairs[i].second});
  }
  return quads;
}

} // namespace pcl_ssfr::baselines
