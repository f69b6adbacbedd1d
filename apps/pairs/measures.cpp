// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/measures.h>

#include <apps/common/degrees.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kSmallestProbability = 1e-4; ///< in the log loss
constexpr std::size_t kCalibrationBins = 10;
constexpr double kNormal95 = 1.959963984540054; ///< half width of the 95 % interval of a normal distribution [sigma]

} // namespace

PoseError
poseError(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth, const Eigen::Vector3d& reference)
{
  // The quaternion keeps the accuracy of small angles, which the trace does not.
  const Eigen::Quaterniond rotation(estimate.linear().transpose() * truth.linear());
  PoseError error;
  error.rotation_deg = 2 * std::atan2(rotation.vec().norm(), std::abs(rotation.w())) * kDegreesPerRadian;
  error.translation_m = (estimate * reference - truth * reference).norm();
  return error;
}

bool
isWithin(const PoseError& error, const SuccessBound& bound)
{
  return error.rotation_deg <= bound.rotation_deg && error.translation_m <= bound.translation_m;
}

CorrespondenceSums
sumCorrespondences(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target)
{
  CorrespondenceSums sums;
  if (source.cols() == 0)
    return sums;
  sums.count = static_cast<double>(source.cols());
  sums.mean_source = source.rowwise().mean();
  sums.mean_target = target.rowwise().mean();
  const Eigen::Matrix3Xd p = source.colwise() - sums.mean_source;
  const Eigen::Matrix3Xd q = target.colwise() - sums.mean_target;
  sums.source_spread = p.squaredNorm();
  sums.target_spread = q.squaredNorm();
  sums.cross = q * p.transpose();
  return sums;
}

double
rmseOf(const CorrespondenceSums& sums, const Eigen::Isometry3d& T_target_source)
{
  if (!(sums.count > 0))
    return std::numeric_limits<double>::quiet_NaN();
  // sum |R p + t - q|^2 with p, q about their means: the mixed terms with the means vanish.
  const double mixed = T_target_source.linear().cwiseProduct(sums.cross).sum();
  const double about_means = (sums.source_spread + sums.target_spread - 2 * mixed) / sums.count;
  const double of_means = (T_target_source * sums.mean_source - sums.mean_target).squaredNorm();
  return std::sqrt(std::max(0.0, about_means) + of_means);
}

Interval
wilsonInterval(std::size_t successes, std::size_t trials)
{
  if (trials == 0)
    return {};
  const auto n = static_cast<double>(trials);
  const double rate = static_cast<double>(successes) / n;
  const double z2 = kNormal95 * kNormal95;
  const double middle = (rate + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kNormal95 / (1 + z2 / n) * std::sqrt(rate * (1 - rate) / n + z2 / (4 * n * n));
  return {successes == 0 ? 0 : std::max(0.0, middle - half), successes == trials ? 1 : std::min(1.0, middle + half)};
}

double
quantile(std::vector<double> values, double share)
{
  values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }), values.end());
  if (values.empty())
    return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

std::vector<PrecisionRecall>
precisionRecall(std::vector<JudgedAnswer> answers, std::size_t pairs)
{
  std::sort(answers.begin(), answers.end(), [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
  std::vector<PrecisionRecall> curve;
  double right = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    right += answers[i].right ? 1 : 0;
    if (i + 1 < answers.size() && answers[i + 1].confidence == answers[i].confidence)
      continue; // equally sure answers are accepted together
    curve.push_back({answers[i].confidence,
                     right / static_cast<double>(i + 1),
                     right / static_cast<double>(std::max<std::size_t>(pairs, 1))});
  }
  return curve;
}

double
logLoss(const std::vector<JudgedAnswer>& answers)
{
  double sum = 0;
  for (const JudgedAnswer& answer : answers) {
    const double p = std::clamp(answer.confidence, kSmallestProbability, 1 - kSmallestProbability);
    sum -= std::log(answer.right ? p : 1 - p);
  }
  return answers.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(answers.size());
}

double
calibrationError(const std::vector<JudgedAnswer>& answers)
{
  std::array<double, kCalibrationBins> surplus{}; ///< confidences less right answers, sums
  for (const JudgedAnswer& answer : answers) {
    const double place = std::clamp(kCalibrationBins * answer.confidence, 0.0, kCalibrationBins - 1.0);
    surplus[static_cast<std::size_t>(place)] += answer.confidence - (answer.right ? 1 : 0);
  }
  double sum = 0;
  for (const double bin : surplus)
    sum += std::abs(bin);
  return answers.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(answers.size());
}

} // namespace apps
} // namespace pcl_ssfr
