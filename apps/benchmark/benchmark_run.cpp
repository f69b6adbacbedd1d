// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/benchmark_run.h>

#include <apps/benchmark/benchmark_plan.h>
#include <apps/benchmark/pair_runner.h>
#include <apps/benchmark/progress.h>
#include <apps/benchmark/report_html.h>
#include <apps/benchmark/report_pictures.h>
#include <apps/benchmark/results_store.h>
#include <apps/benchmark/summary_files.h>
#include <apps/cluster/mpi_ranks.h>
#include <apps/io/file_bytes.h>
#include <apps/methods/method_registry.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <ctime>
#include <deque>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <sys/utsname.h>
#include <thread>
#include <unistd.h>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr std::chrono::milliseconds kTick(200); ///< between looks at the clock while nothing happens
constexpr int kSignalExit = 128;

std::atomic<int> stop_signal{0}; // set by the signal handler

void
onSignal(int signal)
{
  stop_signal = signal;
}

/// One method on one pair, by their indices in the plan.
struct Task {
  std::size_t pair;
  std::size_t method;
};

/** \brief Runs tasks on some threads and hands the rows to the thread that called, in the order in which they come. */
class TaskPool {
public:
  TaskPool(const BenchmarkPlan& plan, std::vector<Task> tasks) : plan_(plan), tasks_(std::move(tasks))
  {
    for (const Task& task : tasks_)
      ++pending_[task.pair];
  }

  void
  run(unsigned jobs, const std::function<void(const PairResult&)>& on_row, const std::function<void()>& on_idle)
  {
    std::vector<std::thread> threads;
    running_ = std::min<std::size_t>(jobs, tasks_.size());
    for (std::size_t i = running_; i > 0; --i)
      threads.emplace_back([this] { work(); });
    std::exception_ptr failure;
    try {
      collect(on_row, on_idle);
    }
    catch (...) { // results cannot be written: no more of them
      failure = std::current_exception();
      stop_signal = SIGTERM;
    }
    for (std::thread& thread : threads)
      thread.join();
    if (failure)
      std::rethrow_exception(failure);
  }

private:
  void
  collect(const std::function<void(const PairResult&)>& on_row, const std::function<void()>& on_idle)
  {
    std::unique_lock<std::mutex> guard(mutex_);
    while (running_ > 0 || !rows_.empty()) {
      if (rows_.empty()) {
        changed_.wait_for(guard, kTick);
        on_idle();
        continue;
      }
      const PairResult row = rows_.front();
      rows_.pop_front();
      guard.unlock();
      on_row(row);
      guard.lock();
    }
  }

  void
  work()
  {
    std::unique_lock<std::mutex> guard(mutex_);
    while (next_ < tasks_.size() && stop_signal.load() == 0) {
      const Task task = tasks_[next_++];
      auto& runner = runners_[task.pair];
      if (!runner)
        runner = std::make_shared<PairRunner>(plan_, task.pair, stop_signal);
      const std::shared_ptr<PairRunner> mine = runner;
      guard.unlock();
      const std::optional<PairResult> row = mine->run(task.method);
      guard.lock();
      if (--pending_[task.pair] == 0)
        runners_.erase(task.pair);
      if (row)
        rows_.push_back(*row);
      changed_.notify_one();
    }
    --running_;
    changed_.notify_one();
  }

  const BenchmarkPlan& plan_;
  std::vector<Task> tasks_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t next_ = 0;
  std::size_t running_ = 0;
  std::map<std::size_t, std::size_t> pending_; ///< tasks of each pair that have not ended
  std::map<std::size_t, std::shared_ptr<PairRunner>> runners_;
  std::deque<PairResult> rows_;
};

/// What is not in the folder yet, pair by pair.
std::vector<Task>
tasksToDo(const BenchmarkPlan& plan, const ResultsStore& store)
{
  std::vector<Task> tasks;
  for (std::size_t pair = 0; pair < plan.pairs.size(); ++pair)
    for (std::size_t method = 0; method < plan.methods.size(); ++method)
      if (!store.contains(plan.key(pair, method)))
        tasks.push_back({pair, method});
  return tasks;
}

/// The tasks of each pair as a message "pair method method ...".
std::vector<std::string>
messagesOf(const std::vector<Task>& tasks)
{
  std::vector<std::string> messages;
  std::size_t last = 0;
  for (const Task& task : tasks) {
    if (messages.empty() || task.pair != last)
      messages.push_back(std::to_string(task.pair));
    last = task.pair;
    messages.back() += ' ' + std::to_string(task.method);
  }
  return messages;
}

std::vector<Task>
tasksOf(const std::string& message)
{
  std::istringstream stream(message);
  std::vector<Task> tasks;
  std::size_t pair = 0;
  stream >> pair;
  for (std::size_t method = 0; stream >> method;)
    tasks.push_back({pair, method});
  return tasks;
}

/// A result as a message: the row, and a line of JSON per candidate.
std::string
messageOf(const PairResult& result)
{
  std::string message = toCsvLine(result.row);
  for (const CandidateAnswer& candidate : result.candidates)
    message += '\n' + toJson(candidate).dump();
  return message;
}

PairResult
resultOf(const std::string& message)
{
  std::istringstream stream(message);
  std::string line;
  std::getline(stream, line);
  PairResult result;
  result.row = rowFromCsv(line);
  while (std::getline(stream, line))
    result.candidates.push_back(candidateFromJson(nlohmann::ordered_json::parse(line)));
  return result;
}

/// Processor, cores, memory and system in a line.
std::string
describeMachine()
{
  std::string processor;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; processor.empty() && std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos)
      processor = line.substr(colon + 2);
  }
  utsname system{};
  uname(&system);
  constexpr double kGib = 1 << 30;
  const double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)) / kGib;
  std::ostringstream text;
  text << (processor.empty() ? system.machine : processor) << ", " << std::thread::hardware_concurrency()
       << " processors, " << std::lround(memory) << " GiB, " << system.sysname << ' ' << system.release;
  return text.str();
}

std::string
dateNow()
{
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &utc);
  return text.data();
}

/// What the last run in the folder said of itself, for reports that are written again.
void
readLastRun(const std::string& folder, BenchmarkResults& results)
{
  const std::string path = (std::filesystem::path(folder) / "summary.json").string();
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return;
  const auto json = nlohmann::ordered_json::parse(io::readFile(path), nullptr, false);
  if (!json.is_object())
    return;
  results.run = json.value("run", nlohmann::ordered_json());
  const auto planned = json.find("planned");
  if (planned != json.end() && planned->is_number_unsigned())
    results.planned = std::max(results.planned, planned->get<std::size_t>());
  results.complete = results.planned == results.rows.size();
}

/// The reports of everything in the folder; the tables are shown. The page is there before its pictures are loaded.
void
writeReports(const BenchmarkArguments& arguments,
             const BenchmarkResults& results,
             const std::vector<io::DatasetFolder>& datasets)
{
  writeSummaries(arguments.out, results);
  std::cout << summaryMarkdown(results) << std::flush;
  writeReport(arguments.out, results, {});
  const ReportPictures pictures = loadReportPictures(results.rows, datasets, arguments.pictures);
  if (!pictures.pairs.empty())
    writeReport(arguments.out, results, pictures);
}

BenchmarkResults
summarize(const std::vector<io::DatasetFolder>& folders, const ResultsStore& store)
{
  std::vector<std::string> datasets;
  datasets.reserve(folders.size());
  for (const io::DatasetFolder& dataset : folders)
    datasets.push_back(dataset.name);
  std::vector<std::string> names;
  for (const Method& method : methods())
    names.push_back(method.name);
  BenchmarkResults results = summarize(store.rows(), datasets, names);
  results.settings = store.settings();
  return results;
}

void
report(const BenchmarkArguments& arguments, const BenchmarkPlan& plan, const ResultsStore& store)
{
  BenchmarkResults results = summarize(plan.datasets, store);
  results.run = {{"date", dateNow()}, {"machine", describeMachine()}, {"command", arguments.command}};
  for (const io::DatasetFolder& dataset : plan.datasets) // where ssfr_view finds the scans
    results.run["datasets"][dataset.name] = std::filesystem::absolute(dataset.path).lexically_normal().string();
  const std::size_t missing = tasksToDo(plan, store).size();
  results.complete = missing == 0;
  results.planned = results.rows.size() + missing;
  writeReports(arguments, results, plan.datasets);
}

/// Name the datasets of which the folder holds no result: the report will have no pictures of them.
void
warnOfUnused(const std::vector<io::DatasetFolder>& datasets, const ResultsStore& store, const std::string& folder)
{
  for (const io::DatasetFolder& dataset : datasets)
    if (std::none_of(store.rows().begin(), store.rows().end(), [&dataset](const ResultRow& row) {
          return row.dataset == dataset.name;
        }))
      std::cerr << "ssfr_benchmark: warning: --dataset " << dataset.path << ": " << folder << " holds no result of "
                << io::inQuotes(dataset.name) << '\n';
}

/// Nothing is run; the settings of the folder stay as they are.
int
reportOnly(const BenchmarkArguments& arguments)
{
  const std::string path = (std::filesystem::path(arguments.out) / "settings.json").string();
  const auto settings = nlohmann::ordered_json::parse(io::readFile(path), nullptr, false);
  if (!settings.is_object())
    throw io::IoError(path + ": is not a JSON object");
  const std::vector<io::DatasetFolder> datasets = readDatasets(arguments.datasets);
  const ResultsStore store(arguments.out, settings, true);
  warnOfUnused(datasets, store, arguments.out);
  BenchmarkResults results = summarize(datasets, store);
  readLastRun(arguments.out, results);
  writeReports(arguments, results, datasets);
  return 0;
}

/// The process that writes: alone, or with other ranks that work for it.
int
runFirst(const BenchmarkArguments& arguments, const BenchmarkPlan& plan, MpiRanks* ranks, ResultsStore& store)
{
  const std::vector<Task> tasks = tasksToDo(plan, store);
  Progress progress(tasks.size(), plan.pairs.size() * plan.methods.size() - tasks.size());
  const auto on_row = [&](const PairResult& result) {
    store.append(result);
    progress.add(result.row);
  };
  const auto on_idle = [&progress] { progress.tick(); };
  if (ranks) {
    const std::vector<std::string> messages = messagesOf(tasks);
    std::size_t next = 0;
    ranks->deal(
        [&](int) {
          return next < messages.size() && stop_signal.load() == 0 ? std::optional(messages[next++]) : std::nullopt;
        },
        [&on_row](const std::string& message) { on_row(resultOf(message)); },
        on_idle);
  }
  else
    TaskPool(plan, tasks).run(arguments.jobs, on_row, on_idle);
  progress.finish();
  report(arguments, plan, store);
  if (stop_signal != 0)
    std::cerr << "ssfr_benchmark: stopped; --resume goes on with the results in " << arguments.out << '\n';
  return stop_signal == 0 ? 0 : kSignalExit + stop_signal;
}

void
catchSignals()
{
  struct sigaction action {};
  action.sa_handler = onSignal;
  action.sa_flags = SA_RESETHAND; // a second Ctrl-C ends it at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction before {};
  if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) // nohup: the run goes on
    sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int
runPlan(const BenchmarkArguments& arguments, MpiRanks* ranks)
{
  const BenchmarkPlan plan = makePlan(arguments);
  for (const BenchmarkMethod& planned : plan.methods) // a program without its module is no failure of a method
    if (planned.command.empty())
      loadModuleOf(*findMethod(planned.name));
  ResultsStore store(arguments.out, plan.settings, arguments.resume, plan.candidates);
  return runFirst(arguments, plan, ranks, store);
}

int
runRanks(const BenchmarkArguments& arguments)
{
  MpiRanks ranks;
  if (ranks.rank() == 0)
    return runPlan(arguments, &ranks);
  std::optional<BenchmarkPlan> plan; // made once rank 0 has checked everything
  ranks.work([&](const std::string& task, const MpiRanks::Send& send) {
    if (!plan)
      plan = makePlan(arguments);
    TaskPool(*plan, tasksOf(task))
        .run(
            arguments.jobs, [&send](const PairResult& result) { send(messageOf(result)); }, [] {});
  });
  return 0;
}

} // namespace

int
runBenchmark(const BenchmarkArguments& arguments)
{
  const bool with_ranks = MpiRanks::areLaunched();
  if (arguments.report_only && with_ranks)
    throw UsageError("--report-only: one process writes the reports, without mpirun");
  if (arguments.report_only)
    return reportOnly(arguments);
  catchSignals();
  return with_ranks ? runRanks(arguments) : runPlan(arguments, nullptr);
}

} // namespace apps
} // namespace pcl_ssfr
