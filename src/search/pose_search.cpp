// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/pose_search.h"

#include "common/vector_clones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace pcl_ssfr {

namespace {

constexpr double kDirectionRadius = 0.35; // [rad] surface within this of a main normal belongs to it
constexpr double kMaxAxisCos = 0.5;       // the second axis is at least 60 degrees from the first
constexpr double kMinSharedLength = 0.25; // of the shorter scan's length that must overlap along the third axis
// Every so many votes are counted first of all, and more as long as they are this share of the best count so far.
constexpr Eigen::Index kGlanceStride = 8;
constexpr double kGlanceShare = 0.1;
constexpr Eigen::Index kScreeningStride = 4;
constexpr double kScreeningShare = 0.5;
static_assert(kGlanceStride % kScreeningStride == 0);
// And for little overlap:
constexpr double kLeastShare = 0.05;   // of the votes that must be for a pose
constexpr int kGlancedAgainst = 2;     // votes against it at the first glance that no pose survives
constexpr int kPeakNeighbours = 4;     // shifts tried on each side of the highest peak of a correlation ...
constexpr double kNeighbourStep = 1.6; // ... and how far apart, in units of the step along the third axis

/// Main normal that a direction belongs to, or main_normals.size().
std::size_t
nearestMainNormal(const Eigen::Vector3d& n, const std::vector<MainNormal>& main_normals)
{
  std::size_t best = main_normals.size();
  double best_cos = std::cos(kDirectionRadius);
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
  histogram.parallel_cos = options.parallel_cos;
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
  if (options.little_overlap)
    for (int k = 1; k <= kPeakNeighbours; ++k)
      for (const int sign : {-1, 1}) {
        ShiftPeak beside = peaks.front();
        beside.shift += sign * k * kNeighbourStep * options.step;
        peaks.push_back(beside);
      }
  return peaks;
}

/// Votes for poses that differ only by their translation.
class Ballot {
public:
  Ballot(const VotingSamples& votes,
         const PatchIndex& index,
         const RangeImage* image,
         const Eigen::Matrix3d& R,
         const VisibilityOptions& options)
      : index_(index), image_(image), options_(options)
  {
    const Eigen::Matrix3f rotation = R.cast<float>();
    // Every stride-th of the samples, those of the stride before left out; 0: none came before.
    const auto add = [&](Eigen::Index stride, Eigen::Index before) {
      for (Eigen::Index i = 0; i < votes.points.cols(); i += stride)
        if (before == 0 || i % before != 0)
          probes_.add(rotation * votes.points.col(i), rotation * votes.normals.col(i));
      return probes_.x.size();
    };
    glanced_ = add(kGlanceStride, 0);
    screened_ = add(kScreeningStride, kGlanceStride);
    add(1, kScreeningStride);
  }

  Eigen::Index
  size() const
  {
    return static_cast<Eigen::Index>(probes_.x.size());
  }

  /// Votes for each of some translations at a first glance, among every kGlanceStride-th of the samples.
  std::vector<int>
  glance(const ShiftLine& line) const
  {
    return index_.countFacingAlong(line, probes_, 0, glanced_);
  }

  /// Votes for the translation among every kScreeningStride-th of the samples; 0 when those of the first glance,
  /// \p glanced, are far fewer than \p best.
  int
  screenedVotesFor(const Eigen::Vector3f& t, int glanced, int best) const
  {
    if (glanced * static_cast<double>(screened_) < kGlanceShare * best * static_cast<double>(glanced_))
      return 0;
    return glanced + index_.countFacing(probes_, glanced_, screened_, t);
  }
  /// And among the others.
  int
  otherVotesFor(const Eigen::Vector3f& t) const
  {
    return index_.countFacing(probes_, screened_, probes_.x.size(), t);
  }

  /// Votes for the translation among all.
  int
  votesFor(const Eigen::Vector3f& t) const
  {
    return index_.countFacing(probes_, 0, probes_.x.size(), t);
  }

  /// Whether the translation has the least share of the votes among those that are screened, and next to none against
  /// it among those of the first glance, of which \p glanced are for it.
  bool
  isWorthCounting(const Eigen::Vector3f& t, int glanced) const
  {
    return glanced > 0 &&
           glanced + index_.countFacing(probes_, glanced_, screened_, t) >=
               kLeastShare * static_cast<double>(screened_) &&
           votesAgainst(t, glanced_, kGlancedAgainst) < kGlancedAgainst;
  }

  /// Samples that hang in the free space of the target; counting ends at \p most.
  int
  votesAgainst(const Eigen::Vector3f& t, int most = std::numeric_limits<int>::max()) const
  {
    return votesAgainst(t, probes_.x.size(), most);
  }

private:
  /// The same among the first \p end.
  int
  votesAgainst(const Eigen::Vector3f& t, std::size_t end, int most) const
  {
    if (!image_)
      return 0;
    int votes = 0;
    std::array<float, kCounted> x, y, z;
    std::array<std::int32_t, kCounted> facing, free;
    for (std::size_t first = 0; first < end && votes < most; first += kCounted) {
      const std::size_t n = std::min(kCounted, end - first);
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = probes_.x[first + i] + t.x();
        y[i] = probes_.y[first + i] + t.y();
        z[i] = probes_.z[first + i] + t.z();
      }
      index_.findFacing(probes_, first, first + n, t, facing.data());
      image_->findFree({x.data(), y.data(), z.data()}, n, options_.free_ratio, options_.free_margin, free.data());
      for (std::size_t i = 0; i < n; ++i)
        votes += free[i] & ~facing[i];
    }
    return std::min(votes, most);
  }

  static constexpr std::size_t kCounted = 32; // votes against at once

  const PatchIndex& index_;
  const RangeImage* image_;
  const VisibilityOptions& options_;
  PatchIndex::Probes probes_; ///< first those of the first glance, then the others that are screened
  std::size_t glanced_ = 0;
  std::size_t screened_ = 0;
};

/// A translation and how the samples voted on it.
struct Verdict {
  Eigen::Vector3f translation; ///< [m]
  int votes = 0;               ///< for it
  double score = 0;            ///< votes for it, less the weighted votes against it
};

/// The shifts of a line that have the most votes, of those around them and not far below the best of all.
/// \param[in,out] best_screened votes of the best of all among those that are screened
void
findMostVoted(const Ballot& ballot,
              const ShiftLine& line,
              double contradiction_weight,
              int& best_screened,
              std::vector<Verdict>& found)
{
  // Patches are found from about two steps away: every second shift tells whether those around it are worth counting.
  const std::vector<int> glanced = ballot.glance(line.everySecond());
  std::vector<int> counts(line.count, 0);
  for (std::size_t s = 0; s < line.count; s += 2) {
    const Eigen::Vector3f t = line[s];
    const int screened = ballot.screenedVotesFor(t, glanced[s / 2], best_screened);
    best_screened = std::max(best_screened, screened);
    if (screened < kScreeningShare * best_screened)
      continue;
    counts[s] = screened + ballot.otherVotesFor(t);
    if (s > 0 && counts[s - 1] == 0)
      counts[s - 1] = ballot.votesFor(line[s - 1]);
    if (s + 1 < line.count)
      counts[s + 1] = ballot.votesFor(line[s + 1]);
  }
  for (std::size_t s = 0; s < line.count; ++s) {
    const int count = counts[s];
    if (count == 0 || (s > 0 && counts[s - 1] > count) || (s + 1 < line.count && counts[s + 1] >= count))
      continue;
    found.push_back({line[s], count, count - contradiction_weight * ballot.votesAgainst(line[s])});
  }
}

/// The shifts of a line that have enough votes, and more than the weighted ones against them.
void
findUncontradicted(const Ballot& ballot,
                   const ShiftLine& line,
                   double contradiction_weight,
                   std::vector<Verdict>& found)
{
  const std::vector<int> glanced = ballot.glance(line.everySecond());
  std::vector<bool> wanted(line.count, false);
  for (std::size_t s = 0; s < line.count; s += 2)
    if (ballot.isWorthCounting(line[s], glanced[s / 2]))
      for (std::size_t k = s - std::min<std::size_t>(s, 1); k <= std::min(s + 1, line.count - 1); ++k)
        wanted[k] = true;
  for (std::size_t s = 0; s < line.count; ++s) {
    const int count = wanted[s] ? ballot.votesFor(line[s]) : 0;
    if (count < kLeastShare * static_cast<double>(ballot.size()))
      continue;
    const int most =
        static_cast<int>(std::min(std::ceil(count / contradiction_weight), static_cast<double>(ballot.size()) + 1));
    const int against = ballot.votesAgainst(line[s], most);
    if (against < most)
      found.push_back({line[s], count, count - contradiction_weight * against});
  }
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
  const auto best = [&](const Eigen::Vector3d* other) {
    std::size_t chosen = main_normals.size();
    for (std::size_t k = 0; k < main_normals.size(); ++k)
      if ((!other || std::abs(main_normals[k].direction.dot(*other)) < kMaxAxisCos) &&
          (chosen == main_normals.size() || shared[k] > shared[chosen]))
        chosen = k;
    return chosen;
  };
  Eigen::Matrix3d axes;
  const std::size_t first = best(nullptr);
  axes.col(0) = first < main_normals.size() ? main_normals[first].direction : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d a = axes.col(0);
  const std::size_t second = best(&a);
  axes.col(1) = second < main_normals.size() ? main_normals[second].direction : a.unitOrthogonal();
  axes.col(2) = a.cross(axes.col(1)).normalized();
  return axes;
}

std::vector<Eigen::Index>
drawRepresentatives(const OrientedSamples& samples, const std::vector<MainNormal>& main_normals, int count)
{
  const auto side = [&](Eigen::Index i) { return std::sqrt(samples.weights[i]); }; // of a square of that area
  std::vector<std::vector<Eigen::Index>> members(main_normals.size() + 1);
  std::vector<double> sides(main_normals.size() + 1, 0);
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const std::size_t k = nearestMainNormal(samples.normals.col(i), main_normals);
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
drawVotingSamples(const OrientedSamples& samples, const std::vector<MainNormal>& main_normals, int count)
{
  const std::vector<Eigen::Index> drawn = drawRepresentatives(samples, main_normals, count);
  VotingSamples votes;
  votes.points.resize(3, static_cast<Eigen::Index>(drawn.size()));
  votes.normals.resize(3, static_cast<Eigen::Index>(drawn.size()));
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    votes.points.col(static_cast<Eigen::Index>(i)) = samples.points.col(drawn[i]).cast<float>();
    votes.normals.col(static_cast<Eigen::Index>(i)) = samples.normals.col(drawn[i]).cast<float>();
  }
  return votes;
}

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
  const Eigen::Matrix3d axes = chooseSearchAxes(source, target, target_main_normals, R, options.parallel_cos);
  const auto peaks = [&](int axis, int count) {
    return axisPeaks(correlateAlongAxis(source, target, R.transpose() * axes.col(axis), axes.col(axis), options),
                     axes.col(axis),
                     count,
                     options);
  };
  const std::vector<ShiftPeak> first = peaks(0, options.peaks_first);
  const std::vector<ShiftPeak> second = peaks(1, options.peaks_second);

  const auto [source_low, source_high] = centralInterval(source, R.transpose() * axes.col(2));
  const auto [target_low, target_high] = centralInterval(target, axes.col(2));
  const double shared =
      options.little_overlap ? 0 : kMinSharedLength * std::min(source_high - source_low, target_high - target_low);
  double shift_low = target_low - source_high + shared;
  double shift_high = target_high - source_low - shared;
  if (options.window) {
    const double centre = options.window->centre.dot(axes.col(2));
    shift_low = std::max(shift_low, centre - options.window->radius);
    shift_high = std::min(shift_high, centre + options.window->radius);
  }
  const auto shifts = static_cast<std::size_t>(std::max(1.0, std::ceil((shift_high - shift_low) / options.step)));

  const Ballot ballot(votes, target_index, target_image, R, options.visibility);
  std::vector<Verdict> found;
  int best_screened = options.rival_votes / static_cast<int>(kScreeningStride);
  for (const ShiftPeak& a : first)
    for (const ShiftPeak& b : second) {
      if (options.deadline.hasPassed())
        break;
      const ShiftLine line{composeShifts(axes, {a.shift, b.shift, shift_low}).cast<float>(),
                           (axes.col(2) * options.step).cast<float>(),
                           shifts};
      if (options.little_overlap)
        findUncontradicted(ballot, line, options.contradiction_weight, found);
      else
        findMostVoted(ballot, line, options.contradiction_weight, best_screened, found);
    }

  std::stable_sort(found.begin(), found.end(), [](const auto& x, const auto& y) { return x.score > y.score; });
  std::vector<PoseHypothesis> kept;
  for (const Verdict& verdict : found) {
    if (static_cast<int>(kept.size()) >= options.keep)
      break;
    PoseHypothesis pose;
    pose.T_target_source.linear() = R;
    pose.T_target_source.translation() = verdict.translation.cast<double>();
    pose.votes = verdict.votes;
    pose.score = verdict.score / static_cast<double>(std::max<Eigen::Index>(1, ballot.size()));
    const bool distinct = std::none_of(kept.begin(), kept.end(), [&](const PoseHypothesis& other) {
      return (pose.T_target_source.translation() - other.T_target_source.translation()).norm() <
             options.peak_separation;
    });
    if (distinct)
      kept.push_back(pose);
  }
  return kept;
}

} // namespace pcl_ssfr
