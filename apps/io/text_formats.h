// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/io/field_table.h>
#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <string>

namespace pcl_ssfr {
namespace io {

/** \brief Read a table of numbers as text: XYZ, TXT, ASC, PTS, and the CSV files of ASL/ETH.
 *
 * Columns are separated by blanks, commas or semicolons. A line of names (x, y, z, ..., in any order, also as a
 * comment) says what they are; without one the first three are x, y, z [m], and the values of the others decide:
 * one left over is the intensity, three of unit length a normal, three integers of 0..255 a colour. A first line with
 * one number is the number of points (PTS), which must then be right. \throw IoError
 */
RawCloud
readTextTable(const std::string& path, const ByteSource& source, FieldChoice fields);

} // namespace io
} // namespace pcl_ssfr
