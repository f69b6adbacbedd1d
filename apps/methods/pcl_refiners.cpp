// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/pcl_methods.h>

#include <pcl/registration/correspondence_rejection_surface_normal.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kTransformationEpsilon = 1e-8; ///< squared translation [m^2]
constexpr double kNdtStepShare = 0.1;           ///< of the cell, as in PCL's tutorial
constexpr double kMinCosNormals = 0.94;         ///< of correspondences on planes: 20 degrees, as our own matches
constexpr double kAcrossPlane = 1e-3;           ///< variance across a plane over that within it, PCL's own for GICP

/// What all refiners of PCL share.
template <typename Refiner>
typename pcl::shared_ptr<Refiner>
makeRefiner(const MethodInput& input)
{
  auto refiner = pcl::make_shared<Refiner>();
  refiner->setInputSource(input.source);
  refiner->setMaximumIterations(static_cast<int>(input.rule.refine_iterations));
  refiner->setTransformationEpsilon(kTransformationEpsilon);
  return refiner;
}

template <typename Icp>
typename pcl::shared_ptr<Icp>
makeIcp(const MethodInput& input)
{
  auto icp = makeRefiner<Icp>(input);
  icp->setMaxCorrespondenceDistance(input.correspondence_distance);
  icp->setInputTarget(input.target);
  return icp;
}

using Gicp = pcl::GeneralizedIterativeClosestPoint<MethodPoint, MethodPoint>;

/// The covariances that GICP gives to points on planes, of our normals: its own are of the 20 nearest points, which lie
/// on a line where rings are far apart.
Gicp::MatricesVectorPtr
planarCovariances(const MethodCloud& cloud)
{
  auto covariances = pcl::make_shared<Gicp::MatricesVector>();
  covariances->reserve(cloud.size());
  for (const MethodPoint& point : cloud) {
    const Eigen::Vector3d n = point.getNormalVector3fMap().cast<double>();
    covariances->push_back(Eigen::Matrix3d::Identity() - (1 - kAcrossPlane) * n * n.transpose());
  }
  return covariances;
}

} // namespace

MethodRegistration::Ptr
makeIcpPointToPoint(const MethodInput& input)
{
  return makeIcp<pcl::IterativeClosestPoint<MethodPoint, MethodPoint>>(input);
}

MethodRegistration::Ptr
makeIcpPointToPlane(const MethodInput& input)
{
  const auto icp = makeIcp<pcl::IterativeClosestPointWithNormals<MethodPoint, MethodPoint>>(input);
  if (input.is_planar) {
    const auto same_side = pcl::make_shared<pcl::registration::CorrespondenceRejectorSurfaceNormal>();
    same_side->setThreshold(kMinCosNormals);
    icp->addCorrespondenceRejector(same_side);
  }
  return icp;
}

MethodRegistration::Ptr
makeGicp(const MethodInput& input)
{
  const auto gicp = makeIcp<Gicp>(input);
  if (input.is_planar) {
    gicp->setSourceCovariances(planarCovariances(*input.source));
    gicp->setTargetCovariances(planarCovariances(*input.target));
  }
  return gicp;
}

MethodRegistration::Ptr
makeNdt(const MethodInput& input)
{
  auto ndt = makeRefiner<pcl::NormalDistributionsTransform<MethodPoint, MethodPoint>>(input);
  const double cell = input.is_planar ? input.rule.polish_cell * input.correspondence_distance : input.scales.ndt_cell;
  ndt->setResolution(static_cast<float>(cell)); // before the target, whose cells are made at once
  ndt->setStepSize(kNdtStepShare * cell);
  ndt->setInputTarget(input.target);
  return ndt;
}

} // namespace apps
} // namespace pcl_ssfr
