// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "search/translation.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace pcl_ssfr {

namespace {

/// Axes whose system has a larger condition number are called dependent.
constexpr double kMaxCondition = 1e7;

bool
areIndependent(const Eigen::Matrix3d& axes)
{
  const Eigen::Vector3d singular = Eigen::JacobiSVD<Eigen::Matrix3d>(axes).singularValues();
  return singular[2] > 0 && singular[0] / singular[2] <= kMaxCondition;
}

/// Smallest angle between \p direction and a rotated main normal of the source [rad].
double
nearestRotatedNormal(const Eigen::Vector3d& direction, const Eigen::Matrix3d& R, const std::vector<MainNormal>& source)
{
  double highest = -1;
  for (const MainNormal& normal : source)
    highest = std::max(highest, direction.dot(R * normal.direction));
  return std::acos(std::clamp(highest, -1.0, 1.0));
}

} // namespace

std::optional<Eigen::Matrix3d>
chooseAxes(const RotationCandidate& candidate,
           const std::vector<MainNormal>& source,
           const std::vector<MainNormal>& target,
           const TranslationOptions& options)
{
  const Eigen::Vector3d a = target.at(static_cast<std::size_t>(candidate.target_pair[0])).direction;
  const Eigen::Vector3d b = target.at(static_cast<std::size_t>(candidate.target_pair[1])).direction;
  const Eigen::Vector3d cross = a.cross(b);
  Eigen::Matrix3d axes;
  axes.col(0) = a;
  axes.col(1) = b;

  if (options.third_axis == TranslationOptions::ThirdAxis::FirstMode) {
    for (const MainNormal& mode : target) {
      const Eigen::Vector3d& c = mode.direction;
      if (std::abs(c.dot(a)) >= options.max_abs_cos || std::abs(c.dot(b)) >= options.max_abs_cos ||
          std::abs(c.dot(cross)) <= options.min_triple_product)
        continue;
      axes.col(2) = c;
      if (areIndependent(axes))
        return axes;
    }
    return std::nullopt;
  }

  const Eigen::Vector3d perpendicular = cross.normalized();
  axes.col(2) = perpendicular;
  if (!areIndependent(axes))
    return std::nullopt;
  double best = std::numeric_limits<double>::infinity();
  for (const MainNormal& mode : target) {
    Eigen::Matrix3d with_mode = axes;
    with_mode.col(2) = mode.direction;
    if (std::abs(mode.direction.dot(perpendicular)) < std::cos(options.cross_angle) || !areIndependent(with_mode))
      continue;
    const double angle = nearestRotatedNormal(mode.direction, candidate.R_target_source, source);
    if (angle >= best)
      continue;
    best = angle;
    axes = with_mode;
  }
  return axes;
}

Eigen::Vector3d
composeShifts(const Eigen::Matrix3d& axes, const Eigen::Vector3d& shifts)
{
  if (!areIndependent(axes))
    throw std::invalid_argument("composeShifts: the axes are linearly dependent");
  return axes.transpose().partialPivLu().solve(shifts);
}

Translation
estimateTranslation(const OrientedSamples& rotated_source,
                    const OrientedSamples& target,
                    const Eigen::Matrix3d& axes,
                    const TranslationOptions& options,
                    const Translation* coarse,
                    double half_range,
                    int smooth_half_window)
{
  CorrelationOptions correlation_options = options.correlation;
  correlation_options.max_peaks = 1;
  Translation translation;
  for (std::size_t k = 0; k < 3; ++k) {
    if (coarse && !coarse->observed[k])
      continue; // METHOD stage 11: no plane along an axis, no movement along it
    const auto column = static_cast<Eigen::Index>(k);
    const auto prepare = [&](const OrientedSamples& samples) {
      AxisHistogram histogram = projectOnAxis(samples, axes.col(column), options.histogram);
      return smoothHistogram(clipHistogram(std::move(histogram), options.histogram), smooth_half_window);
    };
    const Correlation correlation = correlate(
        prepare(rotated_source), prepare(target), coarse ? coarse->shifts[column] : 0, coarse ? half_range : -1);
    const std::vector<ShiftPeak> peaks = findPeaks(correlation, correlation_options);
    if (peaks.empty()) {
      if (coarse) // nothing better within the range: what was known before stays
        translation.shifts[column] = coarse->shifts[column], translation.observed[k] = true;
      continue;
    }
    translation.shifts[column] = peaks.front().shift;
    translation.observed[k] = true;
  }
  translation.t_target_source = composeShifts(axes, translation.shifts);
  return translation;
}

OrientedSamples
transformSamples(const OrientedSamples& samples, const Eigen::Isometry3d& T)
{
  OrientedSamples moved = samples;
  moved.points = (T.linear() * samples.points).colwise() + T.translation();
  moved.normals = T.linear() * samples.normals;
  return moved;
}

} // namespace pcl_ssfr
