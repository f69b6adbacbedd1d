// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/methods/method_parameters.h>

#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ssfr {
namespace apps {

using MethodPoint = pcl::PointXYZINormal;
using MethodCloud = pcl::PointCloud<MethodPoint>;
using MethodRegistration = pcl::Registration<MethodPoint, MethodPoint, float>;

/// What a registration of PCL is made from: thinned scans, each about its own origin.
struct MethodInput {
  MethodCloud::Ptr source; ///< unit normals when Method::needs_normals
  MethodCloud::Ptr target;
  Scales scales;
  ParameterRule rule;
  double correspondence_distance = 0; ///< of the refiners [m]
  bool is_planar = false;             ///< refiners: all points lie on planes and have unit normals, the pose is near
  unsigned threads = 1;               ///< > 0
  std::uint64_t seed = 1;             ///< of the methods that draw lots
};

/// What a class that says more than PCL's interface can carry thinks of its answer.
struct OwnAnswer {
  Eigen::Isometry3d T_target_source; ///< best pose, accepted or not
  std::string message;
};

/// What the module of the methods of PCL and of the comparison methods offers.
struct ComparisonMethods {
  /// A Refiner or Global method with its scans and parameters set, ready to align(). Features are computed here.
  /// \throw std::invalid_argument for a name that is none
  MethodRegistration::Ptr (*make)(const std::string& name, const MethodInput& input);
  /// What it thinks of the answer of the last align(); nothing for PCL's own classes.
  std::optional<OwnAnswer> (*ownAnswerOf)(const MethodRegistration& registration);
  /// Give every point the normal of its neighbours within \p radius [m] that faces \p sensor [m]; NaN where there is
  /// none.
  void (*addNormals)(const MethodCloud::Ptr& cloud, const Eigen::Vector3d& sensor, double radius, unsigned threads);
};

/** \brief The module, loaded when first asked for: PCL's libraries of features, filters and registration hold every
 * combination of its types, and to look up their 170,000 symbols takes 50 ms, as long as it takes to register two
 * scans, which needs none of them.
 * \throw std::runtime_error when it is not where the program was built or installed
 */
const ComparisonMethods&
comparisonMethods();

} // namespace apps
} // namespace pcl_ssfr

/// What the module shows to the program that loads it.
extern "C" const pcl_ssfr::apps::ComparisonMethods*
pclSsfrComparisonMethods();
