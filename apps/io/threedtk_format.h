// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/io_error.h>

#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

/** \brief Read a .3d scan of 3DTK: centimetres, left-handed (x right, y up, z forward).
 *
 * The result is in metres and right-handed: x forward, y left, z up = (z, -x, y) / 100. Further columns: an intensity
 * when it is one, a colour when there are three. \throw IoError
 */
RawCloud
readThreedtk(const std::string& path, std::string_view bytes);

} // namespace io
} // namespace pcl_ssfr
