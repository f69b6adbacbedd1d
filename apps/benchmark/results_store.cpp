// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/results_store.h>

#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <stdexcept>
#include <sys/file.h>
#include <unistd.h>

namespace pcl_ssfr {
namespace apps {

namespace {

namespace fs = std::filesystem;
using io::IoError;
using Json = nlohmann::ordered_json;

/// Settings whose entries are compared one by one, so that a folder can grow by datasets and methods.
bool
growsByEntries(const std::string& key)
{
  return key == "datasets" || key == "external";
}

/// What a run was made with that did not know a setting yet.
Json
defaultOf(const std::string& key)
{
  return key == "cpu_timeout_s" ? Json(0.0) : Json();
}

std::string
systemMessage()
{
  return std::strerror(errno);
}

/// Replace a file by a complete one, or leave it as it is.
void
replaceFile(const std::string& path, const std::string& content)
{
  const std::string beside = path + ".new";
  io::writeFile(beside, content);
  std::error_code error;
  fs::rename(beside, path, error);
  if (error)
    throw IoError(path + ": cannot be written: " + error.message());
}

} // namespace

ResultsStore::ResultsStore(const std::string& folder, const Json& settings, bool resume)
    : folder_(folder), file_((fs::path(folder) / "results.csv").string())
{
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw IoError(folder + ": cannot be created: " + (error ? error.message() : "it is no folder"));
  try {
    lock();
    checkSettings(settings, resume);
    readRows();
    openForAppending();
  }
  catch (...) {
    if (lock_ >= 0)
      close(lock_);
    throw;
  }
}

ResultsStore::~ResultsStore()
{
  if (output_ >= 0)
    close(output_);
  if (lock_ >= 0)
    close(lock_); // the file stays: removing it would let two runs lock two files of the same name
}

void
ResultsStore::lock()
{
  const std::string path = (fs::path(folder_) / ".lock").string();
  lock_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0)
    throw IoError(path + ": cannot be created: " + systemMessage());
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0)
    throw IoError(folder_ + ": another run is writing into this folder");
}

void
ResultsStore::checkSettings(const Json& settings, bool resume)
{
  const std::string path = (fs::path(folder_) / "settings.json").string();
  std::error_code error;
  settings_ = settings;
  if (fs::exists(file_, error) && !resume)
    throw IoError(file_ + ": holds results already; --resume goes on with them, another --out keeps them apart");
  if (fs::exists(file_, error) && !fs::exists(path, error))
    throw IoError(path + ": is missing, the settings of the results beside it are not known");
  if (fs::exists(path, error) && fs::exists(file_, error)) {
    const Json stored = Json::parse(io::readFile(path), nullptr, false);
    if (!stored.is_object())
      throw IoError(path + ": is not a JSON object");
    const auto compare = [&](const std::string& name, const Json& before, const Json& now) {
      if (before != now)
        throw IoError(path + ": " + name + " was " + before.dump() + " and is now " + now.dump() +
                      ": results of different settings are not mixed, choose another --out");
    };
    for (const auto& [key, now] : settings.items()) {
      const Json before = stored.contains(key) ? stored[key] : defaultOf(key);
      if (!growsByEntries(key)) {
        compare(key, before, now);
        continue;
      }
      for (const auto& [entry, value] : now.items())
        if (before.contains(entry))
          compare(std::string(key).append(".").append(entry), before[entry], value);
      if (before.is_object())
        for (const auto& [entry, value] : before.items())
          settings_[key][entry] = value;
    }
  }
  replaceFile(path, settings_.dump(2) + "\n");
}

void
ResultsStore::readRows()
{
  std::error_code error;
  if (!fs::exists(file_, error))
    return;
  std::string content = io::readFile(file_);
  // A run that was killed may have left a torn line: what has no end is dropped.
  const std::size_t complete = content.rfind('\n');
  const std::size_t kept = complete == std::string::npos ? 0 : complete + 1;
  if (kept < content.size()) {
    fs::resize_file(file_, kept, error);
    if (error)
      throw IoError(file_ + ": cannot be written: " + error.message());
    content.resize(kept);
  }
  std::size_t begin = 0;
  for (std::size_t number = 1; begin < content.size(); ++number) {
    const std::size_t end = content.find('\n', begin);
    const std::string_view line = std::string_view(content).substr(begin, end - begin);
    begin = end + 1;
    if (number == 1) {
      if (line != csvHeader())
        throw IoError(file_ + ":1: is not the header that this version writes");
      continue;
    }
    try {
      rows_.push_back(rowFromCsv(line));
    }
    catch (const std::invalid_argument& problem) {
      throw IoError(file_ + ":" + std::to_string(number) + ": " + problem.what());
    }
    const ResultRow& row = rows_.back();
    keys_.insert(rowKey(row.dataset, row.pair, row.variation, row.method));
  }
}

void
ResultsStore::openForAppending()
{
  std::error_code error;
  const bool empty = !fs::exists(file_, error) || fs::file_size(file_, error) == 0;
  output_ = open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (output_ < 0)
    throw IoError(file_ + ": cannot be created: " + systemMessage());
  const std::string header = csvHeader() + "\n";
  if (empty && write(output_, header.data(), header.size()) != static_cast<ssize_t>(header.size()))
    throw IoError(file_ + ": cannot be written: " + systemMessage());
}

void
ResultsStore::append(const ResultRow& row)
{
  const std::string line = toCsvLine(row) + "\n";
  if (write(output_, line.data(), line.size()) != static_cast<ssize_t>(line.size()) || fdatasync(output_) != 0)
    throw IoError(file_ + ": cannot be written: " + systemMessage());
  rows_.push_back(rowFromCsv(toCsvLine(row))); // as it will be read back
  keys_.insert(rowKey(row.dataset, row.pair, row.variation, row.method));
}

} // namespace apps
} // namespace pcl_ssfr
