// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/view/view_model.h>
#include <apps/view/view_options.h>

#include <string>

namespace pcl_ssfr {
namespace apps {

/// Whether this program was built with a window at all.
bool
hasWindow();

/// Whether the display that DISPLAY names can be opened.
bool
canOpenDisplay();

/** \brief Show a run in a window until it is closed.
 * \param[in] screenshot when not empty: write the window to this PNG file and close it
 * \throw io::IoError when the screenshot cannot be written
 */
void
showWindow(const ViewModel& model, WindowLayer layer, const std::string& screenshot);

} // namespace apps
} // namespace pcl_ssfr
