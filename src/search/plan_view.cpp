// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/plan_view.h"

#include "common/angles.h"
#include "common/even_draw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace pcl_ssfr {

namespace {

constexpr int kSectors = 24;   // of headings; elements of neighbouring ones meet: within 15 to 30 degrees
constexpr int kMaxCells = 250; // to each side of no shift

using Sectors = std::array<std::vector<PlanElement>, kSectors>;

int
sectorOf(double heading)
{
  const auto sector = static_cast<int>(std::floor((heading / (2 * kPi) + 2) * kSectors));
  return sector % kSectors;
}

/// The elements by the sectors of the headings that they meet.
Sectors
sortBySector(const PlanView& view, bool oriented)
{
  Sectors sectors;
  for (const PlanElement& e : view.elements)
    for (int side = 0; side < (oriented ? 1 : 2); ++side) {
      const int sector = sectorOf(static_cast<double>(e.heading)) + side * kSectors / 2 + kSectors;
      for (int k = -1; k <= 1; ++k)
        sectors[static_cast<std::size_t>((sector + k) % kSectors)].push_back(e);
    }
  return sectors;
}

/// Scores over a square of shifts.
class ShiftGrid {
public:
  ShiftGrid(double reach, double cell)
      : half_(static_cast<int>(std::ceil(std::min(reach / cell, static_cast<double>(kMaxCells))))),
        width_(2 * half_ + 1), cell_(cell), scores_(static_cast<std::size_t>(width_ * width_), 0.0F)
  {}

  /// Let \p source, moved already, meet whatever it does. \param[in] height within which elements meet [m]
  void
  add(const PlanElement& source, const std::vector<PlanElement>& target, float height)
  {
    forEachMet(source, target, height, [&](const PlanElement& e, std::size_t shift) {
      scores_[shift] += source.weight * e.weight;
    });
  }

  /// The same of points, each of which counts one.
  void
  add(const PlanPoint& source, const std::vector<PlanPoint>& target, float height)
  {
    if (points_.empty())
      points_.assign(scores_.size(), 0.0F);
    forEachMet(source, target, height, [&](const PlanPoint&, std::size_t shift) { points_[shift] += 1; });
  }

  /// The local maxima of the scores over two by two cells, which do not depend on where a cell ends.
  std::vector<PlanMatch>
  findMaxima(double angle) const
  {
    const int last = width_ - 1;
    std::vector<float> sums(scores_.size(), 0.0F);
    for (int y = 0; y < last; ++y)
      for (int x = 0; x < last; ++x)
        sums[index(x, y)] = sumOfFour(scores_, x, y) * (points_.empty() ? 1 : 1 + sumOfFour(points_, x, y));
    std::vector<PlanMatch> maxima;
    for (int y = 0; y < last; ++y)
      for (int x = 0; x < last; ++x) {
        const float sum = sums[index(x, y)];
        if (sum > 0 && isMaximum(sums, x, y))
          maxima.push_back(
              {angle, Eigen::Vector2d(x + 0.5 - half_, y + 0.5 - half_) * cell_, static_cast<double>(sum)});
      }
    return maxima;
  }

private:
  /// Call \p visit for whatever \p source meets, with the shift that lays it there.
  template <typename Seen, typename Visit>
  void
  forEachMet(const Seen& source, const std::vector<Seen>& target, float height, const Visit& visit) const
  {
    const float scale = 1 / static_cast<float>(cell_);
    const float middle = static_cast<float>(half_) + 0.5F;
    for (const Seen& e : target) {
      const float x = (e.x - source.x) * scale + middle;
      const float y = (e.y - source.y) * scale + middle;
      if (x >= 0 && y >= 0 && x < static_cast<float>(width_) && y < static_cast<float>(width_) &&
          std::abs(e.height - source.height) <= height)
        visit(e, index(static_cast<int>(x), static_cast<int>(y)));
    }
  }

  float
  sumOfFour(const std::vector<float>& cells, int x, int y) const
  {
    return cells[index(x, y)] + cells[index(x + 1, y)] + cells[index(x, y + 1)] + cells[index(x + 1, y + 1)];
  }

  std::size_t
  index(int x, int y) const
  {
    return static_cast<std::size_t>(y * width_ + x);
  }

  /// Of equal neighbours the first is the maximum.
  bool
  isMaximum(const std::vector<float>& sums, int x, int y) const
  {
    const std::size_t here = index(x, y);
    for (int v = std::max(0, y - 1); v <= std::min(width_ - 2, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width_ - 2, x + 1); ++u) {
        const std::size_t there = index(u, v);
        if (sums[there] > sums[here] || (sums[there] == sums[here] && there < here))
          return false;
      }
    return true;
  }

  int half_;
  int width_;
  double cell_;
  std::vector<float> scores_; ///< of elements that meet, by the shift
  std::vector<float> points_; ///< that meet, by the shift; empty: the source has none
};

/// An element or a point of the source under a rotation about the axis and an offset along it.
template <typename Seen>
Seen
moved(Seen e, float cosine, float sine, float offset)
{
  const float x = e.x;
  e.x = cosine * x - sine * e.y;
  e.y = sine * x + cosine * e.y;
  e.height += offset;
  return e;
}

} // namespace

PlanView
drawPlanView(const PlanScan& scan, const Eigen::Vector3d& axis, int most)
{
  const OrientedSamples& samples = scan.samples;
  PlanView view;
  view.oriented = samples.oriented;
  view.frame.col(2) = axis;
  view.frame.col(0) = axis.unitOrthogonal();
  view.frame.col(1) = axis.cross(view.frame.col(0));
  std::vector<PlanElement> all;
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d n = view.frame.transpose() * samples.normals.col(i);
    if (2 * n.z() * n.z() > 1)
      continue; // it faces along the axis rather than across it
    const Eigen::Vector3f p = (view.frame.transpose() * samples.points.col(i)).cast<float>();
    all.push_back({p.x(),
                   p.y(),
                   p.z(),
                   static_cast<float>(std::atan2(n.y(), n.x())),
                   static_cast<float>(std::sqrt(std::sqrt(samples.weights[i])))});
  }
  view.elements = drawEvenly(std::move(all), static_cast<std::size_t>(most));
  const Eigen::Matrix3f to_view = view.frame.transpose().cast<float>();
  std::vector<PlanPoint> clutter;
  for (Eigen::Index i = 0; i < scan.clutter.cols(); ++i) {
    const Eigen::Vector3f p = to_view * scan.clutter.col(i);
    clutter.push_back({p.x(), p.y(), p.z()});
  }
  view.clutter = drawEvenly(std::move(clutter), static_cast<std::size_t>(most) / 2);
  return view;
}

std::vector<PlanMatch>
correlatePlanViews(const PlanView& source,
                   const PlanView& target,
                   double angle,
                   double offset,
                   const PlanCorrelationOptions& options,
                   int most)
{
  if (source.elements.empty() || target.elements.empty())
    return {};
  const Sectors sectors = sortBySector(target, source.oriented && target.oriented);
  ShiftGrid grid(options.reach, options.cell);
  const auto c = static_cast<float>(std::cos(angle));
  const auto s = static_cast<float>(std::sin(angle));
  const auto up = static_cast<float>(offset);
  const auto height = static_cast<float>(options.height);
  for (const PlanElement& e : source.elements) {
    const double heading = std::remainder(static_cast<double>(e.heading) + angle, 2 * kPi);
    grid.add(moved(e, c, s, up), sectors[static_cast<std::size_t>(sectorOf(heading))], height);
  }
  for (const PlanPoint& p : source.clutter)
    grid.add(moved(p, c, s, up), target.clutter, height);
  std::vector<PlanMatch> matches = grid.findMaxima(angle);
  std::stable_sort(
      matches.begin(), matches.end(), [](const PlanMatch& a, const PlanMatch& b) { return a.score > b.score; });
  matches.resize(std::min(matches.size(), static_cast<std::size_t>(most)));
  return matches;
}

Eigen::Isometry3d
poseOf(const PlanView& source, const PlanView& target, const PlanMatch& match, double offset)
{
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = target.frame * Eigen::AngleAxisd(match.angle, Eigen::Vector3d::UnitZ()) * source.frame.transpose();
  T.translation() = target.frame * Eigen::Vector3d(match.shift.x(), match.shift.y(), offset);
  return T;
}

} // namespace pcl_ssfr
