// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/results_store.h>

#include <apps/io/file_bytes.h>
#include <apps/io/io_error.h>
#include <apps/io/text_scanner.h>

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
  if (key == "candidates")
    return false;
  if (key == "rmse")
    return true;
  return key == "cpu_timeout_s" ? Json(0.0) : Json();
}

/// The name under which a folder holds a dataset that is now called otherwise: one of the same pairs that is not among
/// those of \p now; empty: it holds none.
std::string
otherName(const Json& before, const Json& now, const std::string& name)
{
  const auto pairsOf = [](const Json& dataset) { return dataset.value("pairs_checksum", ""); };
  for (const auto& [other, value] : before.items())
    if (!now.contains(other) && !pairsOf(value).empty() && pairsOf(value) == pairsOf(now[name]))
      return other;
  return {};
}

std::string
systemMessage()
{
  return std::strerror(errno);
}

std::string
candidatesFile(const std::string& folder)
{
  return (fs::path(folder) / "candidates.csv").string();
}

void
writeThrough(int descriptor, const std::string& path, const std::string& text)
{
  if (write(descriptor, text.data(), text.size()) != static_cast<ssize_t>(text.size()) || fdatasync(descriptor) != 0)
    throw IoError(path + ": cannot be written: " + systemMessage());
}

/// The descriptor of a file, which begins with a header.
int
openForAppending(const std::string& path, const std::string& header)
{
  std::error_code error;
  const bool empty = !fs::exists(path, error) || fs::file_size(path, error) == 0;
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0)
    throw IoError(path + ": cannot be created: " + systemMessage());
  if (empty)
    writeThrough(descriptor, path, header + "\n");
  return descriptor;
}

} // namespace

ResultsStore::ResultsStore(const std::string& folder, const Json& settings, bool resume, bool candidates)
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
    output_ = openForAppending(file_, csvHeader());
    if (candidates) {
      cutCandidates();
      candidates_ = openForAppending(candidatesFile(folder_), candidateHeader());
    }
  }
  catch (...) {
    if (lock_ >= 0)
      close(lock_);
    throw;
  }
}

ResultsStore::~ResultsStore()
{
  for (const int descriptor : {output_, candidates_})
    if (descriptor >= 0)
      close(descriptor);
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
    throw IoError(path + ": is missing, the settings of the results next to it are not known");
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
      for (const auto& [entry, value] : now.items()) {
        if (before.contains(entry))
          compare(std::string(key).append(".").append(entry), before[entry], value);
        else if (const std::string other = key == "datasets" ? otherName(before, now, entry) : ""; !other.empty())
          throw IoError(path + ": dataset " + io::inQuotes(entry) + " is in this folder as " + io::inQuotes(other) +
                        ": its pairs are not run again under another name, choose another --out");
      }
      if (before.is_object())
        for (const auto& [entry, value] : before.items())
          settings_[key][entry] = value;
    }
  }
  io::writeFile(path, settings_.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
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
    keys_.insert(rowKey(rows_.back()));
  }
}

void
ResultsStore::cutCandidates()
{
  const std::string path = candidatesFile(folder_);
  std::error_code error;
  if (!fs::exists(path, error))
    return;
  const std::string content = io::readFile(path);
  std::size_t kept = 0;
  for (std::size_t end = content.find('\n'); end != std::string::npos; end = content.find('\n', kept)) {
    const std::string_view line(content.data() + kept, end - kept);
    if (kept == 0 && line != candidateHeader())
      throw IoError(path + ":1: is not the header that this version writes");
    const auto row = io::parseCount(line.substr(0, line.find(',')));
    if (kept > 0 && (!row || *row > rows_.size()))
      break;
    kept = end + 1;
  }
  fs::resize_file(path, kept, error);
  if (error)
    throw IoError(path + ": cannot be written: " + error.message());
}

void
ResultsStore::append(const PairResult& result)
{
  std::string candidates;
  for (std::size_t k = 0; candidates_ >= 0 && k < result.candidates.size(); ++k)
    candidates += candidateLine(rows_.size() + 1, result.row, k + 1, result.candidates[k]) + "\n";
  if (!candidates.empty())
    writeThrough(candidates_, candidatesFile(folder_), candidates);
  const std::string line = toCsvLine(result.row);
  writeThrough(output_, file_, line + "\n");
  rows_.push_back(rowFromCsv(line)); // as it will be read back
  keys_.insert(rowKey(result.row));
}

} // namespace apps
} // namespace pcl_ssfr
