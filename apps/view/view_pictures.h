// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/view/view_model.h>

#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// A picture in the folder, and what people should see in it.
struct ViewPicture {
  std::string file; ///< name within the folder
  std::string title;
  std::string caption;
};

/** \brief Draw everything as PNG files; a page can be made of them by writeViewPage().
 * \param[in] folder created when it does not exist
 * \throw io::IoError
 */
std::vector<ViewPicture>
drawViewPictures(const std::string& folder, const ViewModel& model);

/// Write index.html into the folder: the pictures with their captions, and all figures as tables. \throw io::IoError
void
writeViewPage(const std::string& folder, const ViewModel& model, const std::vector<ViewPicture>& pictures);

} // namespace apps
} // namespace pcl_ssfr
