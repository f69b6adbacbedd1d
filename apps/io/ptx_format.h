// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <string>

namespace pcl_ssfr {
namespace io {

/** \brief Read a PTX file: scans with their pose, in the frame that the poses lead to [m].
 *
 * Points without a return (0 0 0) are dropped. The position of the scanner becomes RawCloud::viewpoint when there is
 * one scan and it is away from the origin. \throw IoError
 */
RawCloud
readPtx(const std::string& path, const ByteSource& source, FieldChoice fields);

} // namespace io
} // namespace pcl_ssfr
