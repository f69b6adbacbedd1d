// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <Eigen/Geometry>

#include <string>
#include <string_view>

namespace pcl_ssfr {
namespace io {

/** \brief Read a PCD file (ascii, binary, binary_compressed), all fields but padding; a binary one block by block.
 *
 * The header is checked against the size of the file before anything is allocated, which PCL's own reader does not do.
 * A VIEWPOINT away from the origin becomes RawCloud::viewpoint. \throw IoError
 */
RawCloud
readPcd(const std::string& path, const ByteSource& source, FieldChoice fields);

/** \brief Write a binary PCD file.
 * \param[in] sensor where the sensor stands and its orientation, in the coordinates of the points.
 * \param[in] comment one line of the header, empty: none
 * \throw IoError
 */
void
writePcd(const std::string& path,
         const pcl::PCLPointCloud2& table,
         const Eigen::Isometry3d& sensor,
         std::string_view comment = {});

/// Whether the file is a PCD file that writePcd() wrote with this comment; no for a file that is not there.
bool
isPcdWithComment(const std::string& path, std::string_view comment);

} // namespace io
} // namespace pcl_ssfr
