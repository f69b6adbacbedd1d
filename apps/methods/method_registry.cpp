// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/method_registry.h>

namespace pcl_ssfr {
namespace apps {

const std::vector<Method>&
methods()
{
  using K = MethodKind;
  constexpr bool kNormals = true, kStops = true; // needs_normals, stops_by_itself
  static const std::vector<Method> kMethods{
      {"ssfr", "planes, 1-D correlations, visibility scoring, polish; no guess needed", K::Ssfr, ""},
      {"ssfr_paper2017", "the method as published in 2017", K::Ssfr, ""},
      {"ssfr_icp", "ssfr, then PCL's point-to-plane ICP from its answer", K::SsfrRefined, "icp_point_to_plane"},
      {"ssfr_gicp", "ssfr, then PCL's generalised ICP from its answer", K::SsfrRefined, "gicp"},
      {"ssfr_ndt", "ssfr, then PCL's NDT from its answer", K::SsfrRefined, "ndt"},
      {"icp_point_to_point", "PCL's ICP from the guess or the identity", K::Refiner, ""},
      {"icp_point_to_plane", "PCL's point-to-plane ICP from the guess or the identity", K::Refiner, "", kNormals},
      {"gicp", "PCL's generalised ICP from the guess or the identity", K::Refiner, ""},
      {"ndt", "PCL's normal distributions transform from the guess or the identity", K::Refiner, ""},
      {"fpfh_ransac", "FPFH features, PCL's SampleConsensusPrerejective", K::Global, "", kNormals},
      {"fpfh_sac_ia", "FPFH features, PCL's SampleConsensusInitialAlignment", K::Global, "", kNormals},
      {"fpcs", "four congruent points, PCL's FPCSInitialAlignment", K::Global, "", !kNormals, kStops},
      {"kfpcs", "the same on sparse points, PCL's KFPCSInitialAlignment", K::Global, "", !kNormals, kStops},
      {"fgr", "Fast Global Registration (ECCV 2016)", K::Global, ""},
      {"super4pcs", "Super4PCS (SGP 2014)", K::Global, "", !kNormals, kStops},
      {"go_icp", "Go-ICP (PAMI 2016): branch and bound", K::Global, "", !kNormals, kStops},
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

} // namespace apps
} // namespace pcl_ssfr
