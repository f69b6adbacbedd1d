// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "fpfh_features.h"

#include "surface_normals.h"

#include <pcl/features/fpfh_omp.h>
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
  // FPFH must not meet a point without a normal.
  const Points3 all_normals = estimateSurfaceNormals(points, viewpoint, normal_radius, threads);
  auto cloud = pcl::make_shared<Cloud>();
  auto normals = pcl::make_shared<pcl::PointCloud<pcl::Normal>>();
  std::vector<Eigen::Index> columns;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (all_normals.col(i).isZero(0))
      continue;
    columns.push_back(i);
    pcl::PointXYZ point;
    point.getVector3fMap() = points.col(i).cast<float>();
    cloud->push_back(point);
    pcl::Normal normal;
    normal.getNormalVector3fMap() = all_normals.col(i).cast<float>();
    normals->push_back(normal);
  }
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
