// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/map/map_options.h>

namespace pcl_ssfr {
namespace apps {

/** \brief Make a map and write all files of it; as one of several ranks of an MPI job but the first: link for it.
 * \return whether all scans are in one component, true where that is not known
 * \throw UsageError, io::IoError, std::exception with one line that says what is wrong
 */
bool
runMap(const MapArguments& arguments);

} // namespace apps
} // namespace pcl_ssfr
