// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/pose_search.h"

#include "common/vector_clones.h"
#include "directions/scene_directions.h"
#include "search/vote_count.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Main normal that a direction belongs to, within \p radius [rad] of it, or main_normals.size().
std::size_t
nearestMainNormal(const Eigen::Vector3d& n, const std::vector<MainNormal>& main_normals, double radius)
{
  std::size_t best = main_normals.size();
  double best_cos = std::cos(radius);
  for (std::size_t k = 0; k < main_normals.size(); ++k) {
    const double c = main_normals[k].direction.dot(n);
    if (c > best_cos) {
      best_cos = c;
      best = k;
    }
  }
  return best;
}

/// Surface of some samples that faces along an axis and against it; the same where their signs carry no information.
struct FacingSurface {
  double along = 0, against = 0;
};

PCL_SSFR_VECTOR_CLONES FacingSurface
facingSurface(const OrientedSamples& samples, const Eigen::Vector3d& axis, double min_cos)
{
  GroupSums along{}, against{};
  const double ax = axis.x(), ay = axis.y(), az = axis.z();
  const double* const normals = samples.normals.data();
  const double* const weights = samples.weights.data();
  const auto n = static_cast<std::size_t>(samples.size());
  const double sign = samples.oriented ? -1 : 1; // of the other side's cosine
  std::array<double, kSumGroup> cosines;
  for (std::size_t first = 0; first < n; first += kSumGroup) {
    const std::size_t count = std::min(kSumGroup, n - first);
    for (std::size_t k = 0; k < count; ++k) {
      const double* const m = normals + 3 * (first + k);
      cosines[k] = m[0] * ax + m[1] * ay + m[2] * az;
    }
    for (std::size_t k = 0; k < count; ++k) {
      const double c = samples.oriented ? cosines[k] : std::abs(cosines[k]);
      along[k] += c > min_cos ? weights[first + k] : 0;
      against[k] += sign * c > min_cos ? weights[first + k] : 0;
    }
  }
  return {total(along), total(against)};
}

/// Surface of the two scans that can meet along an axis: facing +axis in both plus facing -axis in both.
double
sharedSurface(const FacingSurface& source, const FacingSurface& target)
{
  return std::min(source.along, target.along) + std::min(source.against, target.against);
}

/// Histogram for correlation: smoothed, and clipped so that one huge wall does not decide alone.
AxisHistogram
axisHistogram(const OrientedSamples& samples,
              const Eigen::Vector3d& axis,
              HistogramOptions::Facing facing,
              const PoseSearchOptions& options)
{
  HistogramOptions histogram;
  histogram.bin_width = options.bin_width;
  histogram.parallel_cos = parallelCos(options.config);
  histogram.facing = facing;
  histogram.normalise = false;
  AxisHistogram h = projectOnAxis(samples, axis, histogram);
  if (h.counts.size() == 0)
    return h;
  h.counts = h.counts.cwiseSqrt();
  return smoothHistogram(h, 1);
}

/// The part of a correlation whose shifts are within \p radius of \p centre [m].
Correlation
within(const Correlation& all, double centre, double radius)
{
  if (all.values.size() == 0)
    return all; // no surface of both scans faces the axis: it has no bins
  const auto bin = [&](double shift) {
    return static_cast<Eigen::Index>(
        std::clamp(std::round((shift - all.first_shift) / all.bin_width), 0.0, static_cast<double>(all.values.size())));
  };
  const Eigen::Index first = bin(centre - radius);
  const Eigen::Index end = bin(centre + radius + all.bin_width);
  Correlation part = all;
  part.first_shift += static_cast<double>(first) * all.bin_width;
  part.values = all.values.segment(first, end - first).eval();
  return part;
}

/// Peaks of the correlation along an axis, at most \p count; where there is none the middle of the window, or 0.
std::vector<ShiftPeak>
axisPeaks(const AxisCorrelation& along, const Eigen::Vector3d& axis, int count, const PoseSearchOptions& options)
{
  const std::optional<ShiftWindow>& window = options.window;
  std::vector<ShiftPeak> peaks =
      findPeaks(window ? within(along.sum, window->centre.dot(axis), window->radius) : along.sum,
                searchPeakOptions(options, count));
  if (peaks.empty()) {
    peaks.push_back({});
    if (window)
      peaks.back().shift = window->centre.dot(axis);
  }
  return peaks;
}

/// Interval of the samples' positions along an axis that holds all but the outermost twentieth at each end.
std::pair<double, double>
centralInterval(const OrientedSamples& samples, const Eigen::Vector3d& axis)
{
  Eigen::VectorXd along = samples.points.transpose() * axis;
  const Eigen::Index cut = along.size() / 20;
  std::nth_element(along.data(), along.data() + cut, along.data() + along.size());
  const double low = along[cut];
  std::nth_element(along.data(), along.data() + (along.size() - 1 - cut), along.data() + along.size());
  return {low, along[along.size() - 1 - cut]};
}

} // namespace

AxisCorrelation
correlateAlongAxis(const OrientedSamples& source,
                   const OrientedSamples& target,
                   const Eigen::Vector3d& source_axis,
                   const Eigen::Vector3d& target_axis,
                   const PoseSearchOptions& options)
{
  using Facing = HistogramOptions::Facing;
  const bool oriented = source.oriented && target.oriented;
  AxisCorrelation along;
  along.facings =
      oriented ? std::vector<Facing>{Facing::Forward, Facing::Backward} : std::vector<Facing>{Facing::Either};
  Correlation& sum = along.sum;
  for (const Facing facing : along.facings) {
    along.source.push_back(axisHistogram(source, source_axis, facing, options));
    along.target.push_back(axisHistogram(target, target_axis, facing, options));
    Correlation c = correlate(along.source.back(), along.target.back());
    if (c.values.size() == 0)
      continue;
    if (sum.values.size() == 0) {
      sum = c;
      continue;
    }
    const auto offset = [&](const Correlation& a) {
      return static_cast<Eigen::Index>(
          std::lround((a.first_shift - std::min(sum.first_shift, c.first_shift)) / options.bin_width));
    };
    const Eigen::Index os = offset(sum);
    const Eigen::Index oc = offset(c);
    Correlation both;
    both.bin_width = sum.bin_width;
    both.first_shift = std::min(sum.first_shift, c.first_shift);
    both.values = Eigen::VectorXd::Zero(std::max(os + sum.values.size(), oc + c.values.size()));
    both.values.segment(os, sum.values.size()) += sum.values;
    both.values.segment(oc, c.values.size()) += c.values;
    sum = both;
  }
  return along;
}

CorrelationOptions
searchPeakOptions(const PoseSearchOptions& options, int count)
{
  CorrelationOptions correlation;
  correlation.envelope_half_window = 0;
  correlation.max_peaks = count;
  correlation.min_separation = options.peak_separation;
  correlation.sub_bin = true;
  return correlation;
}

Eigen::Matrix3d
chooseSearchAxes(const OrientedSamples& source,
                 const OrientedSamples& target,
                 const std::vector<MainNormal>& main_normals,
                 const Eigen::Matrix3d& R,
                 double min_cos)
{
  std::vector<double> shared;
  shared.reserve(main_normals.size());
  for (const MainNormal& m : main_normals)
    shared.push_back(sharedSurface(facingSurface(source, R.transpose() * m.direction, min_cos),
                                   facingSurface(target, m.direction, min_cos)));
  Eigen::Matrix3d axes;
  const auto first = std::max_element(shared.begin(), shared.end());
  axes.col(0) = first != shared.end() ? main_normals[static_cast<std::size_t>(first - shared.begin())].direction
                                      : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d a = axes.col(0);
  // Then the one that shares most across the first: a second axis at a small angle to it observes little more.
  axes.col(1) = a.unitOrthogonal();
  double most = 0;
  for (std::size_t k = 0; k < main_normals.size(); ++k) {
    const Eigen::Vector3d& d = main_normals[k].direction;
    const double across = shared[k] * d.cross(a).squaredNorm();
    if (across > most) {
      most = across;
      axes.col(1) = d;
    }
  }
  axes.col(2) = a.cross(axes.col(1)).normalized();
  return axes;
}

std::vector<Eigen::Index>
drawRepresentatives(const OrientedSamples& samples,
                    const std::vector<MainNormal>& main_normals,
                    int count,
                    double same_facing)
{
  const auto side = [&](Eigen::Index i) { return std::sqrt(samples.weights[i]); }; // of a square of that area
  std::vector<std::vector<Eigen::Index>> members(main_normals.size() + 1);
  std::vector<double> sides(main_normals.size() + 1, 0);
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const std::size_t k = nearestMainNormal(samples.normals.col(i), main_normals, same_facing);
    members[k].push_back(i);
    sides[k] += side(i);
  }
  double total = 0;
  for (const double s : sides)
    total += std::sqrt(s);

  std::vector<Eigen::Index> drawn;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const auto wanted = std::lround(count * std::sqrt(sides[k]) / total);
    if (wanted == 0 || members[k].empty())
      continue;
    const double interval = sides[k] / static_cast<double>(wanted);
    double sum = 0;
    double next = 0.5 * interval;
    for (const Eigen::Index i : members[k]) {
      sum += side(i);
      if (sum < next)
        continue;
      // A large patch is drawn once however many intervals it spans.
      drawn.push_back(i);
      next += interval * std::ceil((sum - next) / interval);
      if (next <= sum)
        next += interval;
    }
  }
  return drawn;
}

VotingSamples
drawVotingSamples(const OrientedSamples& samples,
                  const std::vector<MainNormal>& main_normals,
                  int count,
                  double same_facing)
{
  const std::vector<Eigen::Index> drawn = drawRepresentatives(samples, main_normals, count, same_facing);
  VotingSamples votes;
  votes.points.resize(3, static_cast<Eigen::Index>(drawn.size()));
  votes.normals.resize(3, static_cast<Eigen::Index>(drawn.size()));
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    votes.points.col(static_cast<Eigen::Index>(i)) = samples.points.col(drawn[i]).cast<float>();
    votes.normals.col(static_cast<Eigen::Index>(i)) = samples.normals.col(drawn[i]).cast<float>();
  }
  return votes;
}

namespace {

/// Shifts along an axis at which the scans can meet, [first, second] [m]: their middle parts touch, in the window.
std::pair<double, double>
meetingShifts(const OrientedSamples& source,
              const OrientedSamples& target,
              const Eigen::Matrix3d& R,
              const Eigen::Vector3d& axis,
              const std::optional<ShiftWindow>& window)
{
  const auto [source_low, source_high] = centralInterval(source, R.transpose() * axis);
  const auto [target_low, target_high] = centralInterval(target, axis);
  std::pair<double, double> shifts = {target_low - source_high, target_high - source_low};
  if (window) {
    const double centre = window->centre.dot(axis);
    shifts = {std::max(shifts.first, centre - window->radius), std::min(shifts.second, centre + window->radius)};
  }
  return shifts;
}

/// The best of the translations, each farther than the separation from those before it.
std::vector<PoseHypothesis>
keepDistinct(std::vector<VotedTranslation> found,
             const Eigen::Matrix3d& R,
             Eigen::Index samples,
             const PoseSearchOptions& options)
{
  std::stable_sort(found.begin(), found.end(), [](const auto& x, const auto& y) { return x.score > y.score; });
  std::vector<PoseHypothesis> kept;
  for (const VotedTranslation& candidate : found) {
    if (static_cast<int>(kept.size()) >= options.pass.refined)
      break;
    PoseHypothesis pose;
    pose.T_target_source.linear() = R;
    pose.T_target_source.translation() = candidate.translation.cast<double>();
    pose.votes = candidate.votes;
    pose.score = candidate.score / static_cast<double>(std::max<Eigen::Index>(1, samples));
    const bool distinct = std::none_of(kept.begin(), kept.end(), [&](const PoseHypothesis& other) {
      return (pose.T_target_source.translation() - other.T_target_source.translation()).norm() <
             options.peak_separation;
    });
    if (distinct)
      kept.push_back(pose);
  }
  return kept;
}

} // namespace

std::vector<PoseHypothesis>
searchTranslations(const OrientedSamples& source,
                   const VotingSamples& votes,
                   const OrientedSamples& target,
                   const std::vector<MainNormal>& target_main_normals,
                   const PatchIndex& target_index,
                   const RangeImage* target_image,
                   const Eigen::Matrix3d& R,
                   const PoseSearchOptions& options)
{
  if (source.size() == 0 || target.size() == 0)
    return {};
  const Eigen::Matrix3d axes = chooseSearchAxes(source, target, target_main_normals, R, parallelCos(options.config));
  const auto peaks = [&](int axis, int count) {
    return axisPeaks(correlateAlongAxis(source, target, R.transpose() * axes.col(axis), axes.col(axis), options),
                     axes.col(axis),
                     count,
                     options);
  };
  const std::vector<ShiftPeak> first = peaks(0, options.pass.peaks_first);
  const std::vector<ShiftPeak> second = peaks(1, options.pass.peaks_second);

  const auto [shift_low, shift_high] = meetingShifts(source, target, R, axes.col(2), options.window);
  const auto shifts = static_cast<std::size_t>(std::max(1.0, std::ceil((shift_high - shift_low) / options.step)));

  const VoteCounter counter(votes, target_index, target_image, R, options.visibility);
  std::vector<VotedTranslation> found;
  // As many as are screened of the votes for a rival.
  auto best_screened = static_cast<int>(static_cast<std::int64_t>(options.rival_votes) * counter.screened() /
                                        std::max<Eigen::Index>(1, counter.size()));
  for (const ShiftPeak& a : first)
    for (const ShiftPeak& b : second) {
      if (options.deadline.hasPassed())
        break;
      const ShiftLine line{composeShifts(axes, {a.shift, b.shift, shift_low}).cast<float>(),
                           (axes.col(2) * options.step).cast<float>(),
                           shifts};
      if (options.pass.little_overlap)
        findLeastContradicted(counter, line, options.config, options.least_score, found);
      else
        findMostVoted(counter, line, options.config, best_screened, found);
    }
  return keepDistinct(std::move(found), R, counter.size(), options);
}

} // namespace pcl_ssfr
