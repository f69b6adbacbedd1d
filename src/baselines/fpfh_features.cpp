// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "fpfh_features.h"

#include <pcl/features/fpfh_omp.h>
#include <pcl/features/normal_3d_omp.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/memory.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <cstddef>

namespace pcl_ssfr::baselines {

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Histogram = Eigen::Matrix<float, 33, 1>;

pcl::PointXYZ
toPcl(const Eigen::Vector3d& point)
{
  return {static_cast<float>(point.x()), static_cast<float>(point.y()), static_cast<float>(point.z())};
}

/// Keep the points whose normal could be estimated: FPFH must not meet any other.
void
keepOriented(const pcl::PointCloud<pcl::Normal>& all,
             Cloud& cloud,
             pcl::PointCloud<pcl::Normal>& normals,
             std::vector<Eigen::Index>& columns)
{
  Cloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (all[i].getNormalVector3fMap().allFinite()) {
      kept.push_back(cloud[i]);
      normals.push_back(all[i]);
      columns.push_back(static_cast<Eigen::Index>(i));
    }
  }
  cloud.swap(kept);
}

/// For each descriptor of \p queries the number of its nearest in \p cloud.
std::vector<pcl::index_t>
nearestDescriptors(const FpfhFeatures& queries, const FpfhFeatures& features, unsigned threads)
{
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::FPFHSignature33>>();
  cloud->resize(static_cast<std::size_t>(features.bins.cols()));
  for (Eigen::Index i = 0; i < features.bins.cols(); ++i)
    Eigen::Map<Histogram>((*cloud)[static_cast<std::size_t>(i)].histogram) = features.bins.col(i);
  pcl::KdTreeFLANN<pcl::FPFHSignature33> tree;
  tree.setInputCloud(cloud);

  std::vector<pcl::index_t> nearest(static_cast<std::size_t>(queries.bins.cols()), pcl::UNAVAILABLE);
  [[maybe_unused]] const int workers = static_cast<int>(threads);
#pragma omp parallel for num_threads(workers) schedule(dynamic, 64)
  for (Eigen::Index i = 0; i < queries.bins.cols(); ++i) {
    pcl::FPFHSignature33 query;
    Eigen::Map<Histogram>(query.histogram) = queries.bins.col(i);
    pcl::Indices index(1);
    std::vector<float> squared_distance(1);
    if (tree.nearestKSearch(query, 1, index, squared_distance) == 1)
      nearest[static_cast<std::size_t>(i)] = index[0];
  }
  return nearest;
}

} // namespace

FpfhFeatures
computeFpfh(const Points3& points,
            const Eigen::Vector3d& viewpoint,
            double normal_radius,
            double feature_radius,
            unsigned threads)
{
  FpfhFeatures features;
  features.bins.resize(33, 0);
  if (points.cols() == 0)
    return features;
  auto cloud = pcl::make_shared<Cloud>();
  cloud->reserve(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    cloud->push_back(toPcl(points.col(i)));

  pcl::PointCloud<pcl::Normal> all_normals;
  pcl::NormalEstimationOMP<pcl::PointXYZ, pcl::Normal> normal_estimation(threads);
  normal_estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  normal_estimation.setRadiusSearch(normal_radius);
  normal_estimation.setInputCloud(cloud);
  const Eigen::Vector3f eye = viewpoint.cast<float>();
  normal_estimation.setViewPoint(eye.x(), eye.y(), eye.z());
  normal_estimation.compute(all_normals);

  auto normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  std::vector<Eigen::Index> columns;
  keepOriented(all_normals, *cloud, *normals, columns);
  if (cloud->empty())
    return features;

  pcl::PointCloud<pcl::FPFHSignature33> signatures;
  pcl::FPFHEstimationOMP<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation(threads);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(feature_radius);
  estimation.setInputCloud(cloud);
  estimation.setInputNormals(normals);
  estimation.compute(signatures);

  features.bins.resize(33, static_cast<Eigen::Index>(signatures.size()));
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < signatures.size(); ++i) {
    const Eigen::Map<const Histogram> bins(signatures[i].histogram);
    if (bins.allFinite() && bins.maxCoeff() > 0) { // an isolated point has an empty histogram
      features.bins.col(count++) = bins;
      features.columns.push_back(columns[i]);
    }
  }
  features.bins.conservativeResize(33, count);
  return features;
}

std::vector<PointMatch>
matchReciprocally(const FpfhFeatures& source, const FpfhFeatures& target, unsigned threads)
{
  std::vector<PointMatch> matches;
  if (source.columns.empty() || target.columns.empty())
    return matches;
  const std::vector<pcl::index_t> to_target = nearestDescriptors(source, target, threads);
  const std::vector<pcl::index_t> to_source = nearestDescriptors(target, source, threads);
  for (std::size_t i = 0; i < to_target.size(); ++i) {
    const pcl::index_t j = to_target[i];
    if (j != pcl::UNAVAILABLE && to_source[static_cast<std::size_t>(j)] == static_cast<pcl::index_t>(i))
      matches.push_back({source.columns[i], target.columns[static_cast<std::size_t>(j)]});
  }
  return matches;
}

} // namespace pcl_ssfr::baselines
