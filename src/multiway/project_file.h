// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/multiway/multiway_map.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace pcl_ssfr {

/** \brief The project: one SQLite database that other tools can read.
 *
 * A link is stored with the contents of its scans (hashes) and the settings that it was found with, in one transaction:
 * whenever the process ends, what is in the file is complete, and what comes out of it has the bits that went in.
 * Every function throws std::runtime_error with a line that names the file.
 */
class ProjectFile {
public:
  /// Whether there is anything to go on with; true as well of a file that cannot be read, or is none of ours.
  static bool
  holdsLinks(const std::string& path);

  /// \param[in] resume false: links of earlier runs are dropped
  ProjectFile(const std::string& path, bool resume);
  ~ProjectFile();
  ProjectFile(const ProjectFile&) = delete;
  ProjectFile&
  operator=(const ProjectFile&) = delete;

  /// The stored link of a source and a target; none: it was not found yet, or with other settings.
  std::optional<PairLink>
  readLink(std::uint64_t source_hash, std::uint64_t target_hash, const std::string& settings);

  /// Store a link; one transaction for all that come within half a second.
  void
  writeLink(const PairLink& link, std::uint64_t source_hash, std::uint64_t target_hash, const std::string& settings);
  /// What was written is on the disk.
  void
  flush();

  /// Replace what is said of scans, links and decisions by that of a map, in one transaction.
  void
  writeMap(const MultiwayMap& map, const std::vector<std::pair<std::string, std::string>>& decisions);

private:
  void
  writeAtOnce(const std::function<void()>& write);
  void
  insert(const PairLink& link, std::uint64_t source_hash, std::uint64_t target_hash, const std::string& settings);
  void
  insert(const MultiwayMap& map, const std::vector<std::pair<std::string, std::string>>& decisions);
  void
  execute(const char* sql);
  sqlite3_stmt*
  prepare(const char* sql);
  void
  step(sqlite3_stmt* statement);
  [[noreturn]] void
  fail() const;

  std::string path_;
  sqlite3* database_ = nullptr;
  bool in_transaction_ = false;
  double began_ = 0; ///< the transaction [s]
  std::vector<sqlite3_stmt*> statements_;
  sqlite3_stmt* insert_link_ = nullptr;
  sqlite3_stmt* insert_hypothesis_ = nullptr;
};

} // namespace pcl_ssfr
