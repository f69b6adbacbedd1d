// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/e57_structure.h>

// In the place of e57_xml.cpp where pugixml was not found.
namespace pcl_ssfr {
namespace io {

std::vector<E57Structure>
parseE57Xml(const std::string& path, std::string) // NOLINT(performance-unnecessary-value-param): as in e57_xml.cpp
{
  throw IoError(path + ": E57 files cannot be read: this program was built without pugixml");
}

} // namespace io
} // namespace pcl_ssfr
