// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/impl/registration_support.h>

#include "common/rotation_math.h"

#include <pcl/console/print.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace pcl_ssfr::detail {

namespace {

constexpr double kMaxDeviationFromRigid = 1e-2; ///< largest entry of R^T R - I that still counts as rounding

} // namespace

bool
acceptOptions(const std::string& class_name, const char* setter, const Options& candidate)
{
  try {
    validate(candidate);
  }
  catch (const std::invalid_argument& error) {
    reportError(class_name, setter, std::string(error.what()) + "; the old value is kept");
    return false;
  }
  return true;
}

void
reportError(const std::string& class_name, const char* setter, const std::string& text)
{
  PCL_ERROR("[pcl_ssfr::%s::%s] %s.\n", class_name.c_str(), setter, text.c_str());
}

void
reportWarning(const std::string& class_name, const char* where, const std::string& text)
{
  PCL_WARN("[pcl_ssfr::%s::%s] %s.\n", class_name.c_str(), where, text.c_str());
}

std::optional<GravityPrior>
gravityPrior(const Eigen::Vector3d& up_source, const Eigen::Vector3d& up_target, double tolerance)
{
  const auto is_direction = [](const Eigen::Vector3d& v) { return v.allFinite() && v.norm() > 0; };
  if (!is_direction(up_source) || !is_direction(up_target) || !(tolerance > 0 && tolerance <= kPi)) {
    return std::nullopt;
  }
  return GravityPrior{up_source.stableNormalized(), up_target.stableNormalized(), tolerance};
}

std::optional<Eigen::Isometry3d>
rigidGuess(const Eigen::Matrix4d& guess)
{
  if (!guess.allFinite() || !guess.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kMaxDeviationFromRigid)) {
    return std::nullopt;
  }
  const Eigen::Matrix3d linear = guess.topLeftCorner<3, 3>();
  const double deviation = (linear.transpose() * linear - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (deviation > kMaxDeviationFromRigid || linear.determinant() < 0) {
    return std::nullopt;
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearestRotation(linear);
  T.translation() = guess.topRightCorner<3, 1>();
  return T;
}

Eigen::Matrix4d
rigidMatrix(const Eigen::Isometry3d& T)
{
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = nearestRotation(T.linear());
  matrix.topRightCorner<3, 1>() = T.translation();
  return matrix;
}

std::size_t
dropOutOfRange(pcl::Indices& indices, std::size_t size)
{
  const std::size_t before = indices.size();
  const auto is_outside = [size](pcl::index_t i) { return i < 0 || static_cast<std::size_t>(i) >= size; };
  indices.erase(std::remove_if(indices.begin(), indices.end(), is_outside), indices.end());
  return before - indices.size();
}

pcl::Indices
everyIndex(std::size_t size)
{
  pcl::Indices indices(size);
  std::iota(indices.begin(), indices.end(), pcl::index_t{0});
  return indices;
}

bool
isEveryPointInOrder(const pcl::Indices& indices, std::size_t size)
{
  return indices == everyIndex(size);
}

float
median(std::vector<float> values)
{
  if (values.empty()) {
    return 0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

} // namespace pcl_ssfr::detail
