// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <string>

namespace pcl_ssfr {
namespace apps {

/** \brief One process at a time works in a folder: until this is destroyed, or the process ends, however it does.
 *
 * Nothing is written for it. On a file system that has no locks nothing is held.
 */
class FolderLock {
public:
  /// \throw io::IoError when another process holds it
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock&
  operator=(const FolderLock&) = delete;

private:
  int folder_ = -1;
};

} // namespace apps
} // namespace pcl_ssfr
