// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// In place of view_window.cpp where PCL's visualization is not there.

#include <apps/view/view_window.h>

#include <stdexcept>

namespace pcl_ssfr {
namespace apps {

bool
hasWindow()
{
  return false;
}

bool
canOpenDisplay()
{
  return false;
}

void
showWindow(const ViewModel&, WindowLayer, const std::string&)
{
  throw std::logic_error("built without a window");
}

} // namespace apps
} // namespace pcl_ssfr
