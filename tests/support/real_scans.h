// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/dataset_folder.h>
#include <apps/io/loaded_cloud.h>

#include <pcl/common/io.h>
#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>

#include <filesystem>
#include <stdexcept>
#include <string>

// Datasets: the scans in data/, which are always there, and real ones, which are where CMake's variable
// PCL_SSFR_TEST_DATA_DIR says. A test of real scans skips when that is empty, and fails when a set is not in the
// folder.
namespace pcl_ssfr::testing {

#ifdef PCL_SSFR_TEST_DATA_DIR
/// Folder of real scans, a dataset folder each; empty: none was given.
inline std::filesystem::path
realScansFolder()
{
  return PCL_SSFR_TEST_DATA_DIR;
}

/// For GTEST_SKIP().
constexpr const char* kNoRealScans = "no real scans: CMake's PCL_SSFR_TEST_DATA_DIR is empty";
#endif

/// The points of a file in its order.
inline pcl::PointCloud<pcl::PointXYZ>::Ptr
loadPoints(const std::string& file)
{
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  pcl::copyPointCloud(*io::loadCloud(file).points, *cloud);
  return cloud;
}

/// Points as columns, 3 x N [m].
inline Eigen::Matrix3Xf
toColumns(const pcl::PointCloud<pcl::PointXYZ>& cloud)
{
  Eigen::Matrix3Xf points(3, static_cast<Eigen::Index>(cloud.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = cloud[static_cast<std::size_t>(i)].getVector3fMap();
  return points;
}

/// The row of a dataset with this source and target. \throw std::invalid_argument when there is none
inline io::ScanPair
findPair(const io::DatasetFolder& dataset, const std::string& source, const std::string& target)
{
  for (const io::ScanPair& pair : dataset.pairs)
    if (pair.source == source && pair.target == target)
      return pair;
  throw std::invalid_argument(dataset.path + ": no pair of " + source + " and " + target);
}

} // namespace pcl_ssfr::testing
