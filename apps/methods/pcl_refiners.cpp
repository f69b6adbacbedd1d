// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/pcl_methods.h>

#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr double kTransformationEpsilon = 1e-8; ///< squared translation [m^2]
constexpr double kNdtStepShare = 0.1;           ///< of the cell, as in PCL's tutorial

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
MethodRegistration::Ptr
makeIcp(const MethodInput& input)
{
  auto icp = makeRefiner<Icp>(input);
  icp->setMaxCorrespondenceDistance(input.correspondence_distance);
  icp->setInputTarget(input.target);
  return icp;
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
  return makeIcp<pcl::IterativeClosestPointWithNormals<MethodPoint, MethodPoint>>(input);
}

MethodRegistration::Ptr
makeGicp(const MethodInput& input)
{
  return makeIcp<pcl::GeneralizedIterativeClosestPoint<MethodPoint, MethodPoint>>(input);
}

MethodRegistration::Ptr
makeNdt(const MethodInput& input)
{
  auto ndt = makeRefiner<pcl::NormalDistributionsTransform<MethodPoint, MethodPoint>>(input);
  ndt->setResolution(static_cast<float>(input.scales.ndt_cell)); // before the target, whose cells are made at once
  ndt->setStepSize(kNdtStepShare * input.scales.ndt_cell);
  ndt->setInputTarget(input.target);
  return ndt;
}

} // namespace apps
} // namespace pcl_ssfr
