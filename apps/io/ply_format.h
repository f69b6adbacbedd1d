// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <string>

namespace pcl_ssfr {
namespace io {

/** \brief Read the vertices of a PLY file (ascii, binary of either byte order), a binary one block by block; other
 * elements are skipped.
 *
 * Sizes are checked against the file before anything is allocated. \throw IoError
 */
RawCloud
readPly(const std::string& path, const ByteSource& source, FieldChoice fields);

/// Write a binary PLY file (little endian) with one element vertex; rgb as red, green, blue. \throw IoError
void
writePly(const std::string& path, const pcl::PCLPointCloud2& table);

} // namespace io
} // namespace pcl_ssfr
