// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/methods/report.h>

#include <string>

namespace pcl_ssfr {
namespace apps {

/// The line below the title of after.png: how the source was moved, at Report::reference, and how sure that is.
std::string
subtitleAfter(const Report& report);

/** \brief Draw before.png and after.png: both scans in the frame of the target, from above and from the side, to scale.
 *
 * Before, the source lies as its file says; after, as the result says (the best pose considered when none was accepted,
 * and the picture says so). Up is the gravity of the options when it is given, else the z axis of the target; the view
 * is rotated about it until the walls are straight. What is far off, the floor and the ceiling are cut away.
 *
 * \param[in] folder created when it does not exist
 *
 * \throw io::IoError
 */
void
drawPair(const std::string& folder,
         const io::LoadedCloud& source,
         const io::LoadedCloud& target,
         const Report& report,
         const Options& options);

} // namespace apps
} // namespace pcl_ssfr
