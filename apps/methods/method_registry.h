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
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What a method needs and what its answer means.
enum class MethodKind {
  Ssfr,        ///< ours: takes the raw scans, judges its answer
  SsfrRefined, ///< ours first, then a refiner from its answer
  Refiner,     ///< starts at the guess or at the identity
  Global       ///< finds its own start
};

/// A registration method that the programs can run, by the name that the command line and result files use.
struct Method {
  std::string name;
  std::string description; ///< half a line for the help
  MethodKind kind;
  std::string refiner; ///< of SsfrRefined: the method that follows
};

/// Whether a method judges its answer as ssfr does: ssfr alone, or with a refiner after it.
inline bool
isSsfr(const Method& method)
{
  return method.kind == MethodKind::Ssfr || method.kind == MethodKind::SsfrRefined;
}

/// All methods, in the order of the help and of reports.
const std::vector<Method>&
methods();

/// The method of this name, null when there is none.
const Method*
findMethod(const std::string& name);

/// The names of all methods, separated by commas.
std::string
methodNames();

/// Why findMethod() knows no method of a name, as the end of a sentence that begins with the name.
std::string
describeUnknown();

using MethodPoint = pcl::PointXYZINormal;
using MethodCloud = pcl::PointCloud<MethodPoint>;
using MethodRegistration = pcl::Registration<MethodPoint, MethodPoint, float>;

/// What a registration of PCL is made from: thinned scans, each about its own origin.
struct MethodInput {
  MethodCloud::Ptr source; ///< unit normals when needsNormals()
  MethodCloud::Ptr target;
  Scales scales;
  ParameterRule rule;
  double correspondence_distance = 0; ///< of the refiners [m]
  bool is_planar = false;             ///< refiners: all points lie on planes and have unit normals, the pose is near
  unsigned threads = 1;               ///< > 0
  std::uint64_t seed = 1;             ///< of the methods that draw lots
};

/// Whether a Refiner or Global method works on normals (its own need or that of its features).
bool
needsNormals(const std::string& name);

/// Whether a Refiner or Global method ends after ParameterRule::max_seconds.
bool
stopsByItself(const std::string& name);

/** \brief A Refiner or Global method with its scans and parameters set, ready to align(). Features are computed here.
 * \throw std::invalid_argument for a name that is none
 */
MethodRegistration::Ptr
makeRegistration(const std::string& name, const MethodInput& input);

/// What a class that says more than PCL's interface can carry thinks of its answer.
struct OwnAnswer {
  Eigen::Isometry3d T_target_source; ///< best pose, accepted or not
  std::string message;
};

/// What it thinks of the answer of the last align(); nothing for PCL's own classes.
std::optional<OwnAnswer>
ownAnswerOf(const MethodRegistration& registration);

} // namespace apps
} // namespace pcl_ssfr
