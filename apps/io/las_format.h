// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <string>

namespace pcl_ssfr {
namespace io {

/** \brief Read an uncompressed LAS file, versions 1.0 to 1.4, point formats 0 to 10, block by block.
 *
 * Coordinates are scaled in double. Intensity, classification, GPS time and colour are kept. Compressed files (LAZ) are
 * an error that says so. \throw IoError
 */
RawCloud
readLas(const std::string& path, const ByteSource& source, FieldChoice fields);

} // namespace io
} // namespace pcl_ssfr
