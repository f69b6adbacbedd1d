// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/baselines/fast_global_registration.h>
#include <pcl_ssfr/baselines/go_icp.h>
#include <pcl_ssfr/baselines/super4pcs.h>

#include <apps/methods/pcl_methods.h>

namespace pcl_ssfr {
namespace apps {

namespace {

using Baseline = baselines::BaselineRegistration<MethodPoint, MethodPoint>;

/// These classes thin for themselves; the scans are thinned already, so their voxels are too small to matter [leafs].
constexpr double kNoThinning = 0.1;

template <typename Method>
pcl::shared_ptr<Method>
makeBaseline(const MethodInput& input)
{
  auto method = pcl::make_shared<Method>();
  method->setInputSource(input.source);
  method->setInputTarget(input.target);
  method->setNumberOfThreads(input.threads);
  method->setMaxCorrespondenceDistance(input.scales.threshold);
  return method;
}

} // namespace

MethodRegistration::Ptr
makeFgr(const MethodInput& input)
{
  auto method = makeBaseline<baselines::FastGlobalRegistration<MethodPoint, MethodPoint>>(input);
  method->setLeafSize(kNoThinning * input.scales.leaf);
  method->setNormalRadius(input.scales.normal_radius);
  method->setFeatureRadius(input.scales.feature_radius);
  method->setSeed(input.seed);
  return method;
}

MethodRegistration::Ptr
makeSuper4pcs(const MethodInput& input)
{
  auto method = makeBaseline<baselines::Super4PCS<MethodPoint, MethodPoint>>(input);
  method->setLeafSize(kNoThinning * input.scales.leaf);
  method->setOverlap(input.rule.expected_overlap);
  method->setTimeLimit(input.rule.max_seconds, TimeLimitClock::Processor);
  method->setSeed(input.seed);
  return method;
}

MethodRegistration::Ptr
makeGoIcp(const MethodInput& input)
{
  auto method = makeBaseline<baselines::GoIcp<MethodPoint, MethodPoint>>(input);
  method->setSourcePoints(static_cast<int>(input.rule.go_icp_points));
  method->setTrimFraction(input.rule.go_icp_trim);
  method->setMseThreshold(input.rule.go_icp_tolerance);
  method->setTimeLimit(input.rule.max_seconds, TimeLimitClock::Processor);
  return method;
}

std::optional<OwnAnswer>
ownAnswerOf(const MethodRegistration& registration)
{
  const auto* baseline = dynamic_cast<const Baseline*>(&registration);
  if (!baseline)
    return std::nullopt;
  return OwnAnswer{baseline->getResult().T_target_source, baseline->getMessage()};
}

} // namespace apps
} // namespace pcl_ssfr
