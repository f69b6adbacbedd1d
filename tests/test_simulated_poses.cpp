// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The truth of a written dataset against its own points: an ICP that knows nothing of the simulator, on dense scans
// without noise, must find the poses of pairs.csv.

#include "common/types.h"

#include <pcl_ssfr/detail/neighbor_index.h>

#include <apps/io/dataset_folder.h>
#include <apps/io/loaded_cloud.h>
#include <apps/simulation/dataset_simulation.h>

#include <io_testing.h>
#include <pose_matchers.h>

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Dense>

#include <cstddef>
#include <optional>
#include <sstream>
#include <unordered_map>
#include <vector>

namespace pcl_ssfr::simulation::test_simulated_poses {
namespace {

using testing::poseError;

constexpr double kAllowed = 1e-6; // [m] and [rad]

Points3
loadPoints(const std::string& path)
{
  const auto cloud = io::loadCloud(path);
  Points3 points(3, static_cast<Eigen::Index>(cloud.points->size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = (*cloud.points)[static_cast<std::size_t>(i)].getVector3fMap().cast<double>();
  return points;
}

/// A plane of the target.
struct LocalPlane {
  Eigen::Vector3d centre;
  Eigen::Vector3d normal;
};

/// The planes around those points of the target whose neighbours lie on one, to float precision.
class PlaneMap {
public:
  explicit PlaneMap(const Points3& points) : points_(points), index_(points)
  {
    auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      cloud->emplace_back(
          static_cast<float>(points(0, i)), static_cast<float>(points(1, i)), static_cast<float>(points(2, i)));
    tree_.setInputCloud(cloud);
  }

  /// The plane at the target point nearest to \p point; null where there is none.
  const LocalPlane*
  at(const Eigen::Vector3d& point)
  {
    constexpr double kReach = 0.1; // [m]
    const auto nearest = index_.nearest(point, kReach);
    if (nearest.index < 0)
      return nullptr;
    const auto [plane, is_new] = planes_.try_emplace(nearest.index);
    if (is_new)
      plane->second = fit(nearest.index);
    return plane->second ? &*plane->second : nullptr;
  }

private:
  std::optional<LocalPlane>
  fit(Eigen::Index column) const
  {
    constexpr int kNeighbours = 12;
    constexpr double kThin = 3e-6; // rms distance from the plane [m]: floats at 10 m are good for 5e-7
    constexpr double kWide = 2e-3; // rms extent across [m]: three points on a line have no plane
    pcl::Indices neighbours;
    std::vector<float> squares;
    tree_.nearestKSearch(static_cast<int>(column), kNeighbours, neighbours, squares);
    Points3 around(3, static_cast<Eigen::Index>(neighbours.size()));
    for (Eigen::Index k = 0; k < around.cols(); ++k)
      around.col(k) = points_.col(neighbours[static_cast<std::size_t>(k)]);
    const Eigen::Vector3d centre = around.rowwise().mean();
    around.colwise() -= centre;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(around * around.transpose() /
                                                                static_cast<double>(around.cols()));
    const Eigen::Vector3d extent = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
    if (extent[0] < kThin && extent[1] > kWide)
      return LocalPlane{centre, solver.eigenvectors().col(0)};
    return std::nullopt;
  }

  Points3 points_;
  NeighborIndex index_;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree_;
  std::unordered_map<Eigen::Index, std::optional<LocalPlane>> planes_; ///< of the points that were asked for
};

struct IcpResult {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double used = 0;    ///< share of the source points in the last round
  double weakest = 0; ///< least eigenvalue of the normal equations a used point: 0 when a direction is not seen
};

/// Point to plane. Pairs beyond a distance that shrinks from 1 cm to 10 um are left out: edges pair other surfaces.
IcpResult
icp(const Points3& source, PlaneMap& target, const Eigen::Isometry3d& start)
{
  constexpr int kRounds = 14;
  constexpr double kFirstGate = 1e-2;
  constexpr double kLastGate = 1e-5;
  IcpResult result;
  result.T_target_source = start;
  double gate = kFirstGate;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    double used = 0;
    for (Eigen::Index i = 0; i < source.cols(); ++i) {
      const Eigen::Vector3d p = result.T_target_source * source.col(i);
      const LocalPlane* plane = target.at(p);
      if (!plane)
        continue;
      const double residual = plane->normal.dot(p - plane->centre);
      if (std::abs(residual) > gate)
        continue;
      Eigen::Matrix<double, 6, 1> j;
      j << p.cross(plane->normal), plane->normal;
      A += j * j.transpose();
      b -= j * residual;
      used += 1;
    }
    if (used < 6)
      return result;
    const Eigen::Matrix<double, 6, 1> x = A.ldlt().solve(b);
    const double angle = x.head<3>().norm();
    const Eigen::Vector3d axis = angle > 0 ? Eigen::Vector3d(x.head<3>() / angle) : Eigen::Vector3d::UnitX();
    result.T_target_source =
        Eigen::Translation3d(x.tail<3>()) * Eigen::AngleAxisd(angle, axis) * result.T_target_source;
    result.used = used / static_cast<double>(source.cols());
    result.weakest =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(A / used, Eigen::EigenvaluesOnly).eigenvalues()[0];
    gate = std::max(gate / 2, kLastGate);
  }
  return result;
}

class SimulatedPoses : public ::testing::TestWithParam<const char*> {};

TEST_P(SimulatedPoses, areFoundInThePoints)
{
  const testing::TemporaryFolder folder;
  DatasetPlan plan;
  plan.scene = GetParam();
  plan.sensor = "leica_p20";
  plan.beams = 100000;
  plan.noise = false;
  plan.random_rotation = true;
  plan.trajectory.scans = 2;
  {
    DatasetWriter writer(folder.file("set"), false);
    std::ostringstream unused;
    Progress progress(unused, Progress::Style::Silent);
    simulateDataset(prepare(plan, 0), writer, progress, 0);
    writer.commit();
  }
  const io::DatasetFolder set = io::readDatasetFolder(folder.file("set"));
  ASSERT_EQ(set.pairs.size(), 1U);
  const Eigen::Isometry3d truth = set.pairs[0].T_target_source;
  const Points3 source = loadPoints(io::scanPath(set.path, set.pairs[0].source));
  PlaneMap target(loadPoints(io::scanPath(set.path, set.pairs[0].target)));

  const IcpResult from_truth = icp(source, target, truth);
  EXPECT_GT(from_truth.used, 0.2);
  EXPECT_GT(from_truth.weakest, 1e-3);
  EXPECT_LT(poseError(from_truth.T_target_source, truth).rotation, kAllowed);
  EXPECT_LT(poseError(from_truth.T_target_source, truth).translation, kAllowed);

  // From a few millimetres away the same: the points hold the ICP there, not the start.
  const Eigen::Isometry3d nearby = truth * Eigen::Translation3d(1e-3, -1.5e-3, 1e-3) *
                                   Eigen::AngleAxisd(5e-4, Eigen::Vector3d(1, -2, 3).normalized());
  const IcpResult from_nearby = icp(source, target, nearby);
  EXPECT_LT(poseError(from_nearby.T_target_source, truth).rotation, kAllowed);
  EXPECT_LT(poseError(from_nearby.T_target_source, truth).translation, kAllowed);
  RecordProperty("translation_nm", static_cast<int>(1e9 * poseError(from_nearby.T_target_source, truth).translation));
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         SimulatedPoses,
                         ::testing::Values("basic_model", "apartment", "slanted"),
                         [](const auto& scene) { return std::string(scene.param); });

} // namespace
} // namespace pcl_ssfr::simulation::test_simulated_poses
