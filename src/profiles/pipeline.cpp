// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/pipeline.h>

#include "common/parallel.h"
#include "common/rotation_math.h"
#include "profiles/prepared_data.h"

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace pcl_ssfr {

namespace {

/// Stage in which the time for preparing a scan ran out; empty when it is complete.
const std::string&
unfinishedStage(const PreparedData& data)
{
  return std::visit([](const auto& scan) -> const std::string& { return scan.unfinished; }, data.scan);
}

/// What is reported of scans of which one is not complete.
Result
reportUnfinished(const PreparedScan& source, const PreparedScan& target)
{
  Result result;
  result.status = Status::TimeLimit;
  for (const PreparedScan* scan : {&source, &target}) {
    const PreparedData& data = scan->data();
    const std::string name = scan == &source ? "source" : "target";
    const char* separator = data.options.profile == Profile::Paper2017 ? "_" : " ";
    for (StageReport stage : std::visit([](const auto& prepared) { return prepared.stages; }, data.scan)) {
      stage.name = name + separator + stage.name;
      result.stages.push_back(std::move(stage));
    }
    if (!scan->isComplete() && result.message.empty())
      result.message = "the time limit ran out while the " + name + " scan was prepared, in the stage \"" +
                       unfinishedStage(data) + "\"";
  }
  return result;
}

/// Why two scans cannot be laid on each other with \p options; null: they can, if they are complete.
const char*
problemOf(const PreparedScan& source, const PreparedScan& target, const Options& options)
{
  if (source.empty() || target.empty())
    return source.empty() ? "the source scan was not prepared" : "the target scan was not prepared";
  for (const PreparedScan* scan : {&source, &target})
    if (scan->data().options.profile != options.profile)
      return "a scan was prepared for another profile than the one to be run";
  return nullptr;
}

/// A result without a search.
Result
reportInvalid(const char* message)
{
  Result result;
  result.status = Status::InvalidInput;
  result.message = message;
  return result;
}

} // namespace

bool
PreparedScan::isComplete() const
{
  return data_ && unfinishedStage(*data_).empty();
}

bool
PreparedScan::isPreparedWith(const Options& options) const
{
  return data_ && haveSamePreparation(data_->options, options);
}

PreparedScan
prepareScan(const ScanView& scan, const Options& options, const Deadline& deadline)
{
  validate(options);
  auto data = std::make_shared<PreparedData>();
  data->options = options;
  runInTeam(static_cast<int>(threadCount(options)), [&] {
    if (options.profile == Profile::Paper2017)
      data->scan = preparePaperScan(scan, options, deadline);
    else
      data->scan = preparePatchScan(scan, options, deadline);
  });
  return PreparedScan(std::move(data));
}

std::pair<PreparedScan, PreparedScan>
prepareScans(const ScanView& source, const ScanView& target, const Options& options, const Deadline& deadline)
{
  validate(options);
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
              const Deadline& deadline,
              SearchTrace* trace)
{
  validate(options);
  if (guess)
    requireRigid(*guess, "guess");
  if (const char* problem = problemOf(source, target, options))
    return reportInvalid(problem);
  if (!source.isComplete() || !target.isComplete())
    return reportUnfinished(source, target);
  Result result;
  runInTeam(static_cast<int>(threadCount(options)), [&] {
    const auto& from = source.data().scan;
    const auto& to = target.data().scan;
    result =
        options.profile == Profile::Paper2017
            ? registerPaperScans(std::get<PaperScan>(from), std::get<PaperScan>(to), options, guess, deadline)
            : registerPatchScans(std::get<PatchScan>(from), std::get<PatchScan>(to), options, guess, deadline, trace);
  });
  return result;
}

Candidate
scorePose(const PreparedScan& source,
          const PreparedScan& target,
          const Options& options,
          const Eigen::Isometry3d& T_target_source)
{
  validate(options);
  if (const char* problem = problemOf(source, target, options))
    throw std::invalid_argument(problem);
  for (const PreparedScan* scan : {&source, &target})
    if (!scan->isComplete())
      throw std::invalid_argument(std::string("the preparation of the ") + (scan == &source ? "source" : "target") +
                                  " scan was not complete when its deadline passed");
  requireRigid(T_target_source, "T_target_source");
  Candidate candidate;
  runInTeam(static_cast<int>(threadCount(options)), [&] {
    const auto& from = source.data().scan;
    const auto& to = target.data().scan;
    candidate = options.profile == Profile::Paper2017
                    ? scorePaperPose(std::get<PaperScan>(from), std::get<PaperScan>(to), options, T_target_source)
                    : scorePatchPose(std::get<PatchScan>(from), std::get<PatchScan>(to), options, T_target_source);
  });
  return candidate;
}

} // namespace pcl_ssfr
