// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/pcl_methods.h>

#include <algorithm>
#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

struct Maker {
  const char* name;
  MethodRegistration::Ptr (*make)(const MethodInput&);
};

constexpr Maker kMakers[] = {{"icp_point_to_point", makeIcpPointToPoint},
                             {"icp_point_to_plane", makeIcpPointToPlane},
                             {"gicp", makeGicp},
                             {"ndt", makeNdt},
                             {"fpfh_ransac", makeFpfhRansac},
                             {"fpfh_sac_ia", makeFpfhSacIa},
                             {"fpcs", makeFpcs},
                             {"kfpcs", makeKfpcs},
                             {"fgr", makeFgr},
                             {"super4pcs", makeSuper4pcs},
                             {"go_icp", makeGoIcp}};

MethodRegistration::Ptr
makeMethod(const std::string& name, const MethodInput& input)
{
  const auto maker =
      std::find_if(std::begin(kMakers), std::end(kMakers), [&name](const Maker& m) { return name == m.name; });
  if (maker == std::end(kMakers))
    throw std::invalid_argument("'" + name + "' is no method of PCL");
  return maker->make(input);
}

constexpr ComparisonMethods kMethods = {makeMethod, ownAnswerOf, addNormals};

} // namespace
} // namespace apps
} // namespace pcl_ssfr

extern "C" __attribute__((visibility("default"))) const pcl_ssfr::apps::ComparisonMethods*
pclSsfrComparisonMethods()
{
  return &pcl_ssfr::apps::kMethods;
}
