// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/pipeline.h>

#include "prepared_data.h"

#include <algorithm>
#include <future>
#include <memory>
#include <thread>
#include <utility>

namespace pcl_ssfr {

PreparedScan
prepareScan(const ScanView& scan, const Options& options)
{
  validate(options);
  auto data = std::make_shared<PreparedData>();
  data->profile = options.profile;
  // The paper takes the sensor to be at the origin: its profile believes the viewpoint unless told otherwise.
  if (options.profile == Profile::Paper2017)
    data->paper = preparePaperScan(scan,
                                   options,
                                   options.viewpoint_mode == ViewpointMode::Auto ||
                                       options.viewpoint_mode == ViewpointMode::SensorOrigin);
  else
    data->patches = preparePatchScan(scan, options);
  return PreparedScan(std::move(data));
}

std::pair<PreparedScan, PreparedScan>
prepareScans(const ScanView& source, const ScanView& target, const Options& options)
{
  const unsigned threads = options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  if (threads < 2) {
    PreparedScan prepared = prepareScan(source, options);
    return {std::move(prepared), prepareScan(target, options)};
  }
  // Much of a preparation is serial; two of them side by side use two threads all the time.
  Options half = options;
  half.threads = (threads + 1) / 2;
  std::future<PreparedScan> other = std::async(std::launch::async, [&] { return prepareScan(target, half); });
  PreparedScan prepared = prepareScan(source, half);
  return {std::move(prepared), other.get()};
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
  for (const PreparedScan* scan : {&source, &target}) {
    if (scan->data().profile == options.profile)
      continue;
    Result result;
    result.status = Status::InvalidInput;
    result.message = "a scan was prepared for another profile than the one to be run";
    return result;
  }
  if (options.profile == Profile::Paper2017)
    return registerPaperScans(source.data().paper, target.data().paper, options, guess);
  return registerPatchScans(source.data().patches, target.data().patches, options, guess);
}

} // namespace pcl_ssfr
