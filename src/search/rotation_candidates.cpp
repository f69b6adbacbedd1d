// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/rotation_candidates.h"

#include "common/parallel.h"
#include "common/rotation_math.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pcl_ssfr {

namespace {

/// How often a merged rotation is matched and fitted again.
constexpr int kRefitSteps = 2;

/// A source main normal and the target main normal that it meets.
struct Match {
  std::size_t source;
  std::size_t target;
  double weight; ///< the smaller of their normalised supports
  double angle;  ///< [rad]
};

/// Cosine of the angle of the rotation from \p a to \p b.
double
cosineBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
  return (a.cwiseProduct(b).sum() - 1) / 2; // trace(a^T b) = 1 + 2 cos
}

/// Supports of a scan, normalised to sum 1.
std::vector<double>
normalisedSupports(const std::vector<MainNormal>& normals)
{
  double sum = 0;
  for (const MainNormal& normal : normals)
    sum += normal.support;
  std::vector<double> supports;
  supports.reserve(normals.size());
  for (const MainNormal& normal : normals)
    supports.push_back(sum > 0 ? normal.support / sum : 1.0 / static_cast<double>(normals.size()));
  return supports;
}

/// One scan's main normals against the other's under a rotation, for merging.
class Matcher {
public:
  Matcher(const std::vector<MainNormal>& source, const std::vector<MainNormal>& target, double max_angle)
      : source_(source), target_(target), source_supports_(normalisedSupports(source)),
        target_supports_(normalisedSupports(target)), max_angle_(max_angle)
  {}

  /// One-to-one matches within the angle, the closest first.
  std::vector<Match>
  match(const Eigen::Matrix3d& R) const
  {
    const double least_cos = std::cos(max_angle_) - 1e-9; // spares most pairs the exact angle
    std::vector<Match> pairs;
    for (std::size_t i = 0; i < source_.size(); ++i) {
      const Eigen::Vector3d rotated = R * source_[i].direction;
      for (std::size_t j = 0; j < target_.size(); ++j) {
        if (rotated.dot(target_[j].direction) < least_cos)
          continue;
        const double angle = angleBetweenDirections(rotated, target_[j].direction);
        if (angle <= max_angle_)
          pairs.push_back({i, j, std::min(source_supports_[i], target_supports_[j]), angle});
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Match& a, const Match& b) { return a.angle < b.angle; });
    std::vector<Match> matches;
    for (const Match& pair : pairs) {
      const bool taken = std::any_of(matches.begin(), matches.end(), [&](const Match& match) {
        return match.source == pair.source || match.target == pair.target;
      });
      if (!taken)
        matches.push_back(pair);
    }
    return matches;
  }

  static double
  support(const std::vector<Match>& matches)
  {
    double sum = 0;
    for (const Match& match : matches)
      sum += match.weight;
    return sum;
  }

  /// The support of those matches that face across the best supported one rather than along it.
  double
  supportAcross(const std::vector<Match>& matches) const
  {
    const auto best = std::max_element(
        matches.begin(), matches.end(), [](const Match& a, const Match& b) { return a.weight < b.weight; });
    double sum = 0;
    for (const Match& match : matches) {
      const double along = source_[match.source].direction.dot(source_[best->source].direction);
      if (2 * along * along < 1)
        sum += match.weight;
    }
    return sum;
  }

  /// Fit the rotation to all that it matches; stays as it is when that is not two independent directions.
  void
  refit(RotationCandidate& candidate) const
  {
    for (int step = 0; step < kRefitSteps; ++step) {
      const std::vector<Match> matches = match(candidate.R_target_source);
      bool independent = false;
      Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
      for (const Match& match : matches) {
        correlation += match.weight * target_[match.target].direction * source_[match.source].direction.transpose();
        const Eigen::Vector3d& first = source_[matches.front().source].direction;
        independent = independent || first.cross(source_[match.source].direction).norm() > 2 * max_angle_;
      }
      if (!independent)
        break;
      candidate.R_target_source = nearestRotation(correlation);
    }
    candidate.support = std::max(candidate.support, support(match(candidate.R_target_source)));
  }

private:
  const std::vector<MainNormal>& source_;
  const std::vector<MainNormal>& target_;
  std::vector<double> source_supports_, target_supports_;
  double max_angle_;
};

void
sortBySupport(std::vector<RotationCandidate>& candidates)
{
  std::stable_sort(candidates.begin(), candidates.end(), [](const RotationCandidate& a, const RotationCandidate& b) {
    return a.support > b.support;
  });
}

/// Keep the first of all candidates that are closer than \p angle [rad].
std::vector<RotationCandidate>
keepDistinct(const std::vector<RotationCandidate>& candidates, double angle)
{
  const double most_cos = std::cos(angle);
  std::vector<RotationCandidate> distinct;
  for (const RotationCandidate& candidate : candidates) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const RotationCandidate& kept) {
      return cosineBetween(kept.R_target_source, candidate.R_target_source) > most_cos;
    });
    if (!known)
      distinct.push_back(candidate);
  }
  return distinct;
}

/// Two main normals of a scan and the angle between them [rad].
struct NormalPair {
  std::size_t a, b;
  double angle;
};

/// The pairs (a, b) of which a comes before b; with \p both_ways also those the other way round.
std::vector<NormalPair>
pairsOf(const std::vector<MainNormal>& normals, bool both_ways, const RotationOptions& options)
{
  std::vector<NormalPair> pairs;
  for (std::size_t a = 0; a < normals.size(); ++a)
    for (std::size_t b = both_ways ? 0 : a + 1; b < normals.size(); ++b)
      if (a != b && std::abs(normals[a].direction.dot(normals[b].direction)) < options.max_abs_cos)
        pairs.push_back({a, b, angleBetweenDirections(normals[a].direction, normals[b].direction)});
  return pairs;
}

} // namespace

bool
hasPair(const std::vector<MainNormal>& normals, const RotationOptions& options)
{
  return !pairsOf(normals, false, options).empty();
}

Eigen::Matrix3d
rotationFromPairs(const Eigen::Vector3d& source_a,
                  const Eigen::Vector3d& source_b,
                  const Eigen::Vector3d& target_a,
                  const Eigen::Vector3d& target_b)
{
  // By symmetry the nearest rotation maps the bisectors of one pair onto those of the other.
  const auto frame = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    Eigen::Matrix3d axes;
    axes.col(0) = (a + b).normalized();
    axes.col(1) = (a - b).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
  };
  const auto isParallel = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::min((a + b).squaredNorm(), (a - b).squaredNorm()) < 1e-6;
  };
  if (isParallel(source_a, source_b) || isParallel(target_a, target_b))
    return nearestRotation(target_a * source_a.transpose() + target_b * source_b.transpose());
  return frame(target_a, target_b) * frame(source_a, source_b).transpose();
}

double
supportAcross(const std::vector<RotationCandidate>& rotations,
              const std::vector<MainNormal>& source,
              const std::vector<MainNormal>& target,
              double max_angle)
{
  const Matcher matcher(source, target, max_angle);
  double most = 0;
  for (const RotationCandidate& rotation : rotations)
    most = std::max(most, matcher.supportAcross(matcher.match(rotation.R_target_source)));
  return most;
}

std::vector<RotationCandidate>
proposeRotations(const std::vector<MainNormal>& source,
                 const std::vector<MainNormal>& target,
                 const RotationOptions& options,
                 unsigned threads)
{
  const auto workers = static_cast<int>(threads);
  const bool merge = options.merge_angle > 0;
  const Matcher matcher(source, target, merge ? options.refit_angle : options.angle_tolerance);
  const std::vector<NormalPair> source_pairs = pairsOf(source, false, options);
  const std::vector<NormalPair> target_pairs = pairsOf(target, true, options);
  const auto matchPair = [&](const NormalPair& of_source) {
    std::vector<RotationCandidate> candidates;
    for (const NormalPair& of_target : target_pairs) {
      if (std::abs(of_source.angle - of_target.angle) > options.angle_tolerance)
        continue;
      RotationCandidate candidate;
      candidate.R_target_source = rotationFromPairs(source[of_source.a].direction,
                                                    source[of_source.b].direction,
                                                    target[of_target.a].direction,
                                                    target[of_target.b].direction);
      candidate.target_pair = {{static_cast<int>(of_target.a), static_cast<int>(of_target.b)}};
      candidate.support = Matcher::support(matcher.match(candidate.R_target_source));
      candidates.push_back(candidate);
    }
    return candidates;
  };
  std::vector<std::vector<RotationCandidate>> found(source_pairs.size());
  forEachInParallel(static_cast<std::int64_t>(found.size()), 1, workers, [&](std::int64_t i) {
    found[static_cast<std::size_t>(i)] = matchPair(source_pairs[static_cast<std::size_t>(i)]);
  });
  std::vector<RotationCandidate> candidates;
  for (const std::vector<RotationCandidate>& some : found)
    candidates.insert(candidates.end(), some.begin(), some.end());
  if (!merge)
    return candidates;

  sortBySupport(candidates);
  candidates = keepDistinct(candidates, options.merge_angle);
  forEachInParallel(static_cast<std::int64_t>(candidates.size()), 1, workers, [&](std::int64_t i) {
    matcher.refit(candidates[static_cast<std::size_t>(i)]);
  });
  sortBySupport(candidates);
  return keepDistinct(candidates, options.merge_angle); // fits of neighbours may have met
}

std::vector<RotationCandidate>
sweepRotations(const std::vector<Eigen::Vector3d>& source_axes,
               const std::vector<Eigen::Vector3d>& target_axes,
               int steps)
{
  const double step = 2 * kPi / steps;
  std::vector<RotationCandidate> sweep;
  for (const Eigen::Vector3d& source : source_axes)
    for (const Eigen::Vector3d& target : target_axes) {
      const Eigen::Matrix3d onto = rotationOnto(source, target);
      for (int k = 0; k < steps; ++k) {
        RotationCandidate candidate;
        candidate.R_target_source = Eigen::AngleAxisd(k * step, target).toRotationMatrix() * onto;
        sweep.push_back(candidate);
      }
    }
  return keepDistinct(sweep, 0.5 * step);
}

} // namespace pcl_ssfr
