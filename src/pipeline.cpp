// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/pipeline.h>

#include "prepared_data.h"

#include <memory>

namespace pcl_ssfr {

PreparedScan
prepareScan(const ScanView& scan, const Options& options)
{
  validate(options);
  auto data = std::make_shared<PreparedData>();
  data->profile = options.profile;
  data->patches = preparePatchScan(scan, options);
  return PreparedScan(std::move(data));
}

Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess)
{
  validate(options);
  if (source.empty() || target.empty()) {
    Result result;
    result.status = Status::InvalidInput;
    result.message = source.empty() ? "the source scan was not prepared" : "the target scan was not prepared";
    return result;
  }
  return registerPatchScans(source.data().patches, target.data().patches, options, guess);
}

} // namespace pcl_ssfr
