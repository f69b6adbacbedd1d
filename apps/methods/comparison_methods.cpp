// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/comparison_methods.h>
#include <apps/methods/method_registry.h>

#include <dlfcn.h>

#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

namespace {

/// For the life of the process: what it makes outlives every call.
const ComparisonMethods*
loadModule()
{
  void* const module = dlopen(PCL_SSFR_COMPARISON_MODULE, RTLD_NOW | RTLD_LOCAL);
  void* const entry = module ? dlsym(module, "pclSsfrComparisonMethods") : nullptr;
  if (!entry)
    throw std::runtime_error(std::string("the methods of PCL and the comparison methods cannot be loaded: ") +
                             dlerror());
  return reinterpret_cast<decltype(&pclSsfrComparisonMethods)>(entry)();
}

} // namespace

const ComparisonMethods&
comparisonMethods()
{
  static const ComparisonMethods* const kMethods = loadModule();
  return *kMethods;
}

void
loadModuleOf(const Method& method)
{
  if (method.kind != MethodKind::Ssfr)
    comparisonMethods();
}

} // namespace apps
} // namespace pcl_ssfr
