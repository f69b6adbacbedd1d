// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/pair_runner.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr std::size_t kLongestHeader = 1U << 12; ///< of a PCD file that is not written again [bytes]
constexpr milliseconds kNoWait(0);
constexpr milliseconds kStopTick(20);
constexpr milliseconds kStopGrace(1000); ///< who ends all processes of a run does not reach all of them at once

/// Whether a file is a PCD file that every reader of binary ones takes: neither text nor compressed.
bool
isBinaryPcd(const std::string& path)
{
  if (fs::path(path).extension() != ".pcd")
    return false;
  std::ifstream file(path, std::ios::binary);
  std::string header(kLongestHeader, '\0');
  file.read(header.data(), static_cast<std::streamsize>(header.size()));
  header.resize(static_cast<std::size_t>(file.gcount()));
  std::istringstream lines(header);
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("DATA", 0) == 0)
      return line == "DATA binary";
  return false;
}

/// Whether the scans that methods get are others than those of the files.
bool
isVaried(Variation variation)
{
  variation.pairs_from = PairsFrom::Listed; // another choice of scans leaves them as they are
  return orderOf(variation) != orderOf(Variation());
}

SuccessBound
boundOf(const io::DatasetFolder& dataset)
{
  return {dataset.success_rotation_deg, dataset.success_translation_m};
}

std::string
makeTemporaryFolder()
{
  std::string pattern = (fs::temp_directory_path() / "ssfr_benchmark_XXXXXX").string();
  if (!mkdtemp(pattern.data()))
    throw std::runtime_error(pattern + ": cannot be created");
  return pattern;
}

} // namespace

PairRunner::PairRunner(const BenchmarkPlan& plan, std::size_t pair, const std::atomic<int>& stop)
    : plan_(plan), pair_(plan.pairs[pair]), stop_(stop)
{}

PairRunner::~PairRunner()
{
  std::error_code ignored;
  if (!folder_.empty())
    fs::remove_all(folder_, ignored);
}

bool
PairRunner::knowsTruth()
{
  const std::lock_guard<std::mutex> guard(mutex_);
  return truth_ || !truth_error_.empty();
}

void
PairRunner::keepTruth(const PairTruth& truth)
{
  const std::lock_guard<std::mutex> guard(mutex_);
  if (!truth_)
    truth_ = truth;
}

const PairTruth&
PairRunner::truth()
{
  const std::lock_guard<std::mutex> guard(mutex_);
  if (!truth_ && truth_error_.empty()) {
    try {
      truth_ = askTruth(pair_.request, plan_.run, stop_);
    }
    catch (const std::exception& error) {
      truth_error_ = error.what();
    }
  }
  if (!truth_)
    throw std::runtime_error(truth_error_);
  return *truth_;
}

const PairRunner::Files&
PairRunner::files()
{
  const std::lock_guard<std::mutex> guard(mutex_);
  if (!files_) {
    const PairRequest& request = pair_.request;
    Files files{request.source, request.target};
    if (isVaried(request.variation) || !isBinaryPcd(files.source) || !isBinaryPcd(files.target)) {
      if (folder_.empty())
        folder_ = makeTemporaryFolder();
      files = {folder_ + "/source.pcd", folder_ + "/target.pcd"};
      askExport(request, files.source, files.target, stop_);
    }
    files_ = files;
  }
  return *files_;
}

MethodAnswer
PairRunner::ask(const BenchmarkMethod& method)
{
  if (method.words.empty()) {
    const SuccessBound bound = boundOf(plan_.datasets[pair_.dataset]);
    MethodAnswer answer = askMethod(method.name, pair_.request, plan_.run, bound, !knowsTruth(), stop_);
    if (answer.truth)
      keepTruth(*answer.truth);
    return answer;
  }
  const Files& paths = files();
  return askExternal(method, paths.source, paths.target, pair_.request.seed, plan_.run, stop_);
}

void
PairRunner::waitForStop() const
{
  for (auto waited = kNoWait; waited < kStopGrace && stop_.load() == 0; waited += kStopTick)
    std::this_thread::sleep_for(kStopTick);
}

std::optional<PairResult>
PairRunner::run(std::size_t method)
{
  const BenchmarkMethod& chosen = plan_.methods[method];
  MethodAnswer answer;
  const PairTruth* known = nullptr;
  try {
    if (knowsTruth())
      known = &truth();
    answer = ask(chosen);
    if (!known && !answer.stopped)
      known = &truth();
  }
  catch (const std::exception& error) {
    answer = MethodAnswer();
    answer.status = "failed";
    answer.message = error.what();
    answer.asked_to_end = true; // reading and measuring rarely fail but for that
  }
  if (answer.asked_to_end)
    waitForStop();
  if (answer.stopped || stop_.load() != 0)
    return std::nullopt;
  PairResult result = judgeAnswer(plan_, pair_, answer, known);
  result.row.method = chosen.name;
  return result;
}

PairResult
judgeAnswer(const BenchmarkPlan& plan, const PlannedPair& pair, const MethodAnswer& answer, const PairTruth* truth)
{
  const io::DatasetFolder& dataset = plan.datasets[pair.dataset];
  const SuccessBound bound = boundOf(dataset);
  PairResult result;
  ResultRow& row = result.row;
  row.dataset = dataset.name;
  row.source = pair.source;
  row.target = pair.target;
  row.target_dataset = pair.target_dataset;
  row.pair = pair.pair;
  row.variation = pair.request.variation;
  row.seed = pair.request.seed;
  row.status = answer.status;
  row.message = answer.message;
  row.converged = answer.converged;
  row.confidence = answer.confidence.value_or(ResultRow::kUnknown);
  row.found_overlap = answer.overlap.value_or(ResultRow::kUnknown);
  row.time_s = answer.seconds;
  row.cpu_s = answer.cpu_seconds;
  row.peak_rss_mib = answer.peak_rss_mib;
  row.T_target_source = answer.T_target_source;
  row.lost_at = answer.lost_at;
  result.candidates = answer.candidates;
  if (!truth)
    return result;
  row.truth = truth->T_target_source;
  row.gt_rmse_m = truth->gt_rmse;
  row.overlap = truth->overlap;
  row.source_points = static_cast<double>(truth->source_points);
  row.target_points = static_cast<double>(truth->target_points);
  if (!truth->T_target_source)
    return result;
  const auto errorOf = [truth](const Eigen::Isometry3d& T) {
    return poseError(T, *truth->T_target_source, truth->reference);
  };
  for (std::size_t k = result.candidates.size(); k-- > 0;) {
    CandidateAnswer& candidate = result.candidates[k];
    candidate.right = isWithin(errorOf(candidate.T_target_source), bound);
    if (candidate.right)
      row.right_rank = static_cast<double>(k + 1);
  }
  if (!answer.T_target_source)
    return result;
  const PoseError error = errorOf(*answer.T_target_source);
  row.rotation_error_deg = error.rotation_deg;
  row.translation_error_m = error.translation_m;
  row.rmse_m = truth->rmse(*answer.T_target_source);
  row.success = isWithin(error, bound);
  return result;
}

} // namespace apps
} // namespace pcl_ssfr
