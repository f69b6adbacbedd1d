// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/methods/comparison_methods.h>

// What the module is made of (see ComparisonMethods): one maker a method, each in the file of its family, because PCL's
// templates take long to compile.

namespace pcl_ssfr {
namespace apps {

MethodRegistration::Ptr
makeIcpPointToPoint(const MethodInput& input);
MethodRegistration::Ptr
makeIcpPointToPlane(const MethodInput& input);
MethodRegistration::Ptr
makeGicp(const MethodInput& input);
MethodRegistration::Ptr
makeNdt(const MethodInput& input);

MethodRegistration::Ptr
makeFpfhRansac(const MethodInput& input);
MethodRegistration::Ptr
makeFpfhSacIa(const MethodInput& input);

MethodRegistration::Ptr
makeFpcs(const MethodInput& input);
MethodRegistration::Ptr
makeKfpcs(const MethodInput& input);

MethodRegistration::Ptr
makeFgr(const MethodInput& input);
MethodRegistration::Ptr
makeSuper4pcs(const MethodInput& input);
MethodRegistration::Ptr
makeGoIcp(const MethodInput& input);

std::optional<OwnAnswer>
ownAnswerOf(const MethodRegistration& registration);
void
addNormals(const MethodCloud::Ptr& cloud, const Eigen::Vector3d& sensor, double radius, unsigned threads);

} // namespace apps
} // namespace pcl_ssfr
