// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// SSFR as the initial guess of PCL's local methods: ICP, GICP and NDT, each alone from identity and from SSFR's pose.
// SSFR suggests how far their correspondences may reach from there, and says whether what they made of its pose is
// better. Usage: initial_guess SOURCE.pcd TARGET.pcd [LEAF] LEAF: the local methods work on clouds thinned to this [m],
// 0.1 when not given. SSFR takes the clouds as they are.

#include <pcl_ssfr/structured_scene_registration.h>

#include <pcl/common/transforms.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Registration = pcl::Registration<Point, Point>;

constexpr double kDefaultLeaf = 0.1; ///< [m]
constexpr double kReach = 1.0;       ///< points farther than this from the target do not count in the distance [m]
constexpr double kWideReach = 1.0;   ///< correspondences of ICP and GICP alone, for the best chance [m]
constexpr double kCellPerReach = 6;  ///< width of NDT's cells: noise is thin in them, and each holds some points

Cloud::Ptr
thinned(const Cloud::ConstPtr& cloud, double leaf)
{
  auto result = pcl::make_shared<Cloud>();
  pcl::VoxelGrid<Point> grid;
  grid.setInputCloud(cloud);
  grid.setLeafSize(static_cast<float>(leaf), static_cast<float>(leaf), static_cast<float>(leaf));
  grid.filter(*result);
  return result;
}

/// The local methods, with settings as their tutorials have them.
std::vector<std::pair<std::string, Registration::Ptr>>
localMethods(double ndt_cell)
{
  const auto icp = pcl::make_shared<pcl::IterativeClosestPoint<Point, Point>>();
  icp->setMaximumIterations(50);
  const auto gicp = pcl::make_shared<pcl::GeneralizedIterativeClosestPoint<Point, Point>>();
  gicp->setMaximumIterations(50);
  const auto ndt = pcl::make_shared<pcl::NormalDistributionsTransform<Point, Point>>();
  ndt->setResolution(static_cast<float>(ndt_cell));
  ndt->setStepSize(0.1 * ndt_cell);
  ndt->setTransformationEpsilon(1e-6);
  ndt->setMaximumIterations(50);
  return {{"ICP", icp}, {"GICP", gicp}, {"NDT", ndt}};
}

/// Root mean square distance from the moved source's points to the target, those beyond kReach left out [m].
double
meanDistance(const Cloud& source, const pcl::search::KdTree<Point>& target, const Eigen::Matrix4f& T)
{
  Cloud moved;
  pcl::transformPointCloud(source, moved, T);
  pcl::Indices nearest;
  std::vector<float> squared;
  double sum = 0;
  std::size_t count = 0;
  for (const Point& point : moved) {
    if (pcl::isFinite(point) && target.nearestKSearch(point, 1, nearest, squared) == 1 &&
        squared[0] <= kReach * kReach) {
      sum += squared[0];
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : kReach;
}

/// One line: did it converge, how near do the clouds lie, how far is the pose from SSFR's, and is it as good.
void
report(const std::string& name,
       Registration& method,
       double distance,
       const Eigen::Matrix4f& T_ssfr,
       const pcl_ssfr::Candidate& evidence,
       const pcl_ssfr::Candidate& of_ssfr)
{
  const Eigen::Matrix4f T = method.getFinalTransformation();
  const Eigen::Matrix3f R_between = T_ssfr.topLeftCorner<3, 3>().transpose() * T.topLeftCorner<3, 3>();
  const double degrees = Eigen::AngleAxisf(R_between).angle() * 180 / M_PI;
  const double metres = (T.topRightCorner<3, 1>() - T_ssfr.topRightCorner<3, 1>()).norm();
  std::cout << std::left << std::setw(18) << name << std::right << std::fixed << std::setprecision(3) << std::setw(10)
            << (method.hasConverged() ? "yes" : "no") << std::setw(14) << distance << std::setw(16) << degrees
            << std::setw(10) << metres << std::setw(8) << evidence.score << std::setw(10) << 1000 * evidence.rmse
            << (isNoWorse(evidence, of_ssfr) ? "  keep it" : "  keep SSFR's") << '\n';
}

} // namespace

int
main(int argc, char** argv)
{
  const auto source = pcl::make_shared<Cloud>();
  const auto target = pcl::make_shared<Cloud>();
  const double leaf = argc == 4 ? std::atof(argv[3]) : kDefaultLeaf;
  if (argc < 3 || argc > 4 || !(leaf > 0) || pcl::io::loadPCDFile(argv[1], *source) < 0 ||
      pcl::io::loadPCDFile(argv[2], *target) < 0) {
    std::cerr << "usage: initial_guess SOURCE.pcd TARGET.pcd [LEAF > 0]\n";
    return 2;
  }

  pcl_ssfr::StructuredSceneRegistration<Point, Point> ssfr;
  ssfr.setNumberOfThreads(0);
  ssfr.setInputSource(source);
  ssfr.setInputTarget(target);
  Cloud moved;
  ssfr.align(moved);
  if (!ssfr.hasConverged()) {
    std::cout << "SSFR: " << pcl_ssfr::toString(ssfr.getResult().status) << ": " << ssfr.getResult().message << '\n';
    return 1;
  }
  const Eigen::Matrix4f guess = ssfr.getFinalTransformation();

  const Cloud::Ptr thin_source = thinned(source, leaf);
  const Cloud::Ptr thin_target = thinned(target, leaf);
  pcl::search::KdTree<Point> tree;
  tree.setInputCloud(thin_target);
  const std::optional<pcl_ssfr::Candidate> of_ssfr = ssfr.scorePose(guess);
  const auto print = [&](const std::string& name, Registration& method) {
    const std::optional<pcl_ssfr::Candidate> evidence = ssfr.scorePose(method.getFinalTransformation());
    const double distance = meanDistance(*thin_source, tree, method.getFinalTransformation());
    report(name, method, distance, guess, evidence.value_or(pcl_ssfr::Candidate()), *of_ssfr);
  };
  // What SSFR suggests is for its own points; these are as far apart as the leaf.
  const double reach = std::hypot(ssfr.getCorrespondenceDistance(), leaf);
  std::cout << "method             converged  distance [m]  from SSFR [deg]       [m]   score  rms [mm]\n";
  print("SSFR", ssfr);
  for (const auto& [name, method] : localMethods(kCellPerReach * reach)) {
    method->setInputSource(thin_source);
    method->setInputTarget(thin_target);
    method->setMaxCorrespondenceDistance(kWideReach);
    method->align(moved);
    print(name + " alone", *method);
    method->setMaxCorrespondenceDistance(reach);
    method->align(moved, guess);
    print(name + " with guess", *method);
  }
  return 0;
}
