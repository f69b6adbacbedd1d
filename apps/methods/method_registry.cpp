// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/pcl_methods.h>

#include <algorithm>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

/// How a Refiner or Global method is made.
struct Maker {
  const char* name;
  bool normals;
  bool stops; ///< after ParameterRule::max_seconds
  MethodRegistration::Ptr (*make)(const MethodInput&);
};

constexpr Maker kMakers[] = {{"icp_point_to_point", false, false, makeIcpPointToPoint},
                             {"icp_point_to_plane", true, false, makeIcpPointToPlane},
                             {"gicp", false, false, makeGicp},
                             {"ndt", false, false, makeNdt},
                             {"fpfh_ransac", true, false, makeFpfhRansac},
                             {"fpfh_sac_ia", true, false, makeFpfhSacIa},
                             {"fpcs", false, true, makeFpcs},
                             {"fgr", false, false, makeFgr},
                             {"super4pcs", false, true, makeSuper4pcs},
                             {"go_icp", false, true, makeGoIcp},
                             {"kfpcs", false, true, makeKfpcs}};

const Maker&
makerOf(const std::string& name)
{
  const auto maker =
      std::find_if(std::begin(kMakers), std::end(kMakers), [&name](const Maker& m) { return name == m.name; });
  if (maker == std::end(kMakers))
    throw std::invalid_argument("'" + name + "' is no method of PCL");
  return *maker;
}

} // namespace

const std::vector<Method>&
methods()
{
  using K = MethodKind;
  static const std::vector<Method> kMethods{
      {"ssfr", "planes, 1-D correlations, visibility scoring, polish; no guess needed", K::Ssfr, ""},
      {"ssfr_paper2017", "the method as published in 2017", K::Ssfr, ""},
      {"ssfr_icp", "ssfr, then PCL's point-to-plane ICP from its answer", K::SsfrRefined, "icp_point_to_plane"},
      {"ssfr_gicp", "ssfr, then PCL's generalised ICP from its answer", K::SsfrRefined, "gicp"},
      {"ssfr_ndt", "ssfr, then PCL's NDT from its answer", K::SsfrRefined, "ndt"},
      {"icp_point_to_point", "PCL's ICP from the guess or the identity", K::Refiner, ""},
      {"icp_point_to_plane", "PCL's point-to-plane ICP from the guess or the identity", K::Refiner, ""},
      {"gicp", "PCL's generalised ICP from the guess or the identity", K::Refiner, ""},
      {"ndt", "PCL's normal distributions transform from the guess or the identity", K::Refiner, ""},
      {"fpfh_ransac", "FPFH features, PCL's SampleConsensusPrerejective", K::Global, ""},
      {"fpfh_sac_ia", "FPFH features, PCL's SampleConsensusInitialAlignment", K::Global, ""},
      {"fpcs", "four congruent points, PCL's FPCSInitialAlignment", K::Global, ""},
      {"kfpcs", "the same on sparse points, PCL's KFPCSInitialAlignment", K::Global, ""},
      {"fgr", "Fast Global Registration (ECCV 2016)", K::Global, ""},
      {"super4pcs", "Super4PCS (SGP 2014)", K::Global, ""},
      {"go_icp", "Go-ICP (PAMI 2016): branch and bound", K::Global, ""},
  };
  return kMethods;
}

const Method*
findMethod(const std::string& name)
{
  for (const Method& method : methods())
    if (method.name == name)
      return &method;
  return nullptr;
}

std::string
methodNames()
{
  std::string names;
  for (const Method& method : methods())
    names += (names.empty() ? "" : ", ") + method.name;
  return names;
}

std::string
describeUnknown()
{
  return "is not one of " + methodNames();
}

bool
needsNormals(const std::string& name)
{
  return makerOf(name).normals;
}

bool
stopsByItself(const std::string& name)
{
  return makerOf(name).stops;
}

MethodRegistration::Ptr
makeRegistration(const std::string& name, const MethodInput& input)
{
  return makerOf(name).make(input);
}

} // namespace apps
} // namespace pcl_ssfr
