// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/io_error.h>

#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

/** \brief Read a KITTI .bin scan: x, y, z [m] and intensity as little-endian 32-bit floats. \throw IoError */
RawCloud
readKitti(const std::string& path, std::string_view bytes);

} // namespace io
} // namespace pcl_ssfr
