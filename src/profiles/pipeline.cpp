// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/pipeline.h>

#include "common/parallel.h"
#include "profiles/prepared_data.h"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Stage in which the time for preparing a scan ran out; empty when it is complete.
const std::string&
unfinishedStage(const PreparedData& data)
{
  return data.profile == Profile::Paper2017 ? data.paper.unfinished : data.patches.unfinished;
}

/// What is told of scans of which one is not complete.
Result
reportUnfinished(const PreparedScan& source, const PreparedScan& target)
{
  Result result;
  result.status = Status::TimeLimit;
  for (const PreparedScan* scan : {&source, &target}) {
    const PreparedData& data = scan->data();
    const bool is_paper = data.profile == Profile::Paper2017;
    const std::string name = scan == &source ? "source" : "target";
    for (StageReport stage : is_paper ? data.paper.stages : data.patches.stages) {
      stage.name = name + (is_paper ? "_" : " ") + stage.name;
      result.stages.push_back(std::move(stage));
    }
    if (!scan->isComplete() && result.message.empty())
      result.message = "the time limit ran out while the " + name + " scan was prepared, in the stage \"" +
                       unfinishedStage(data) + "\"";
  }
  return result;
}

} // namespace

bool
PreparedScan::isComplete() const
{
  return data_ && unfinishedStage(*data_).empty();
}

PreparedScan
prepareScan(const ScanView& scan, const Options& options, const Deadline& deadline)
{
  validate(options);
  auto data = std::make_shared<PreparedData>();
  data->profile = options.profile;
  runInTeam(static_cast<int>(threadCount(options)), [&] {
    // The paper takes the sensor to be at the origin: its profile believes the viewpoint unless told otherwise.
    if (options.profile == Profile::Paper2017)
      data->paper = preparePaperScan(scan,
                                     options,
                                     options.viewpoint_mode == ViewpointMode::Auto ||
                                         options.viewpoint_mode == ViewpointMode::SensorOrigin,
                                     deadline);
    else
      data->patches = preparePatchScan(scan, options, deadline);
  });
  return PreparedScan(std::move(data));
}

std::pair<PreparedScan, PreparedScan>
prepareScans(const ScanView& source, const ScanView& target, const Options& options, const Deadline& deadline)
{
  const auto threads = static_cast<int>(threadCount(options));
  // Much of a preparation is serial; two of them side by side use two threads most of the time.
  std::array<PreparedScan, 2> prepared;
  forEachInParallel(2, 1, threads, [&](std::int64_t i) {
    prepared[static_cast<std::size_t>(i)] = prepareScan(i == 0 ? source : target, options, deadline);
  });
  return {std::move(prepared[0]), std::move(prepared[1])};
}

Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess)
{
  return registerScans(source, target, options, guess, Deadline::after(options.time_limit));
}

Result
registerScans(const PreparedScan& source,
              const PreparedScan& target,
              const Options& options,
              const Eigen::Isometry3d* guess,
              const Deadline& deadline)
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
  if (!source.isComplete() || !target.isComplete())
    return reportUnfinished(source, target);
  Result result;
  runInTeam(static_cast<int>(threadCount(options)), [&] {
    result = options.profile == Profile::Paper2017
                 ? registerPaperScans(source.data().paper, target.data().paper, options, guess, deadline)
                 : registerPatchScans(source.data().patches, target.data().patches, options, guess, deadline);
  });
  return result;
}

} // namespace pcl_ssfr
