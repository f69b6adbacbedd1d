// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/folder_lock.h>

#include <apps/io/io_error.h>

#include <cerrno>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace pcl_ssfr {
namespace apps {

FolderLock::FolderLock(const std::string& folder) : folder_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC))
{
  if (folder_ < 0 || flock(folder_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
    return;
  close(folder_);
  throw io::IoError(folder + ": another ssfr_map works in this folder; wait for it, or take another one");
}

FolderLock::~FolderLock()
{
  if (folder_ >= 0)
    close(folder_);
}

} // namespace apps
} // namespace pcl_ssfr
