// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr_ros2/scan_matcher.h>

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <Eigen/Cholesky>

#include <fstream>
#include <stdexcept>

namespace pcl_ssfr_ros2 {

namespace {

pcl_ssfr::ScanView
viewOf(const pcl::PointCloud<pcl::PointXYZ>& cloud)
{
  pcl_ssfr::ScanView view;
  if (!cloud.empty())
    view.xyz = cloud.points.front().data;
  view.stride = sizeof(pcl::PointXYZ) / sizeof(float);
  view.size = cloud.size();
  return view;
}

bool
endsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// Enough of a file for the header of a cloud; empty when it cannot be read.
std::string
beginningOf(const std::string& path)
{
  std::string text(4096, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

} // namespace

Matrix6
covarianceInRosOrder(const Matrix6& information, const Eigen::Isometry3d& T_target_source)
{
  Matrix6 with_prior = 0.5 * (information + information.transpose());
  with_prior.diagonal().head<3>().array() += 1 / (kUnknownRotation * kUnknownRotation);
  with_prior.diagonal().tail<3>().array() += 1 / (kUnknownTranslation * kUnknownTranslation);
  const Matrix6 of_motion = with_prior.ldlt().solve(Matrix6::Identity()); // order (w, v)
  const Eigen::Vector3d t = T_target_source.translation();
  Matrix6 jacobian = Matrix6::Zero(); // of (position, rotation) by (w, v)
  jacobian.topRightCorner<3, 3>().setIdentity();
  jacobian.bottomLeftCorner<3, 3>().setIdentity();
  jacobian.topLeftCorner<3, 3>() << 0, t.z(), -t.y(), -t.z(), 0, t.x(), t.y(), -t.x(), 0; // w x t
  const Matrix6 covariance = jacobian * of_motion * jacobian.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

std::array<double, 36>
toRowMajor(const Matrix6& covariance)
{
  std::array<double, 36> values{};
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data()) = covariance;
  return values;
}

Eigen::Isometry3d
anchored(const Eigen::Isometry3d& T_target_source, const Eigen::Isometry3d& T_anchor_source)
{
  return T_target_source * T_anchor_source.inverse();
}

pcl::PointCloud<pcl::PointXYZ>::Ptr
readMap(const std::string& path)
{
  const bool is_pcd = endsWith(path, ".pcd");
  if (!is_pcd && !endsWith(path, ".ply"))
    throw std::invalid_argument(path + ": is neither .pcd nor .ply");
  // PCL's reader of PCD files does not survive files of another kind.
  const std::string header = beginningOf(path);
  if (is_pcd ? header.find("\nFIELDS") == std::string::npos || header.find("\nDATA") == std::string::npos
             : header.compare(0, 3, "ply") != 0)
    throw std::invalid_argument(path + ": cannot be read, or has not the header of a " + (is_pcd ? "PCD" : "PLY") +
                                " file");
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  const int code = is_pcd ? pcl::io::loadPCDFile(path, *cloud) : pcl::io::loadPLYFile(path, *cloud);
  if (code < 0 || cloud->empty())
    throw std::invalid_argument(path + ": cannot be read, or holds no points");
  return cloud;
}

ScanMatcher::ScanMatcher(const MatcherConfig& config) : options_(pcl_ssfr::makeOptions(pcl_ssfr::Profile::Default))
{
  options_.threads = config.threads;
  options_.time_limit = config.time_limit;
  options_.min_confidence = config.min_confidence;
  if (config.gravity_tolerance < 0)
    throw std::invalid_argument("gravity_tolerance = " + std::to_string(config.gravity_tolerance) +
                                ", must be at least 0");
  if (config.gravity_tolerance > 0) {
    options_.gravity.emplace();
    options_.gravity->tolerance = config.gravity_tolerance;
  }
  pcl_ssfr::validate(options_);
}

void
ScanMatcher::setTarget(const pcl::PointCloud<pcl::PointXYZ>& cloud)
{
  target_ = pcl_ssfr::prepareScan(viewOf(cloud), options_);
}

Match
ScanMatcher::match(const pcl::PointCloud<pcl::PointXYZ>& source) const
{
  Match match;
  if (!hasTarget()) {
    match.message = "no target yet";
    return match;
  }
  const pcl_ssfr::Deadline deadline =
      options_.time_limit > 0 ? pcl_ssfr::Deadline::after(options_.time_limit) : pcl_ssfr::Deadline();
  const pcl_ssfr::PreparedScan prepared = pcl_ssfr::prepareScan(viewOf(source), options_, deadline);
  const pcl_ssfr::Result result = pcl_ssfr::registerScans(prepared, target_, options_, nullptr, deadline);
  match.accepted = result.accepted();
  match.message = result.message;
  match.confidence = result.confidence;
  match.T_target_source = result.T_target_source;
  match.covariance = covarianceInRosOrder(result.information, result.T_target_source);
  return match;
}

} // namespace pcl_ssfr_ros2
