// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/benchmark/candidate_rows.h>

#include <nlohmann/json.hpp>

#include <set>
#include <string>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/** \brief The output folder of a run: results.csv, of which every line is on the disk before the next method starts,
 * and settings.json, so that results of different settings are never mixed. Candidates
 * go to candidates.csv, whose rows name the line of results.csv that they belong to.
 *
 * The folder is locked while the object lives; the lock ends with the process, however it ends.
 */
class ResultsStore {
public:
  /** \brief Open or create the folder.
   * \param[in] settings an object whose values must be those of the results that the folder holds; of "datasets" and
   * "external", only the entries that both have are compared; a dataset that the folder holds under another name is
   * refused
   * \param[in] resume keep what is there; false: the folder must hold no results yet
   * \param[in] candidates write candidates.csv
   * \throw io::IoError when the folder is in use, holds results of other settings, or cannot be written
   */
  ResultsStore(const std::string& folder, const nlohmann::ordered_json& settings, bool resume, bool candidates = false);
  ~ResultsStore();
  ResultsStore(const ResultsStore&) = delete;
  ResultsStore&
  operator=(const ResultsStore&) = delete;

  /// All results, those of earlier runs first.
  const std::vector<ResultRow>&
  rows() const
  {
    return rows_;
  }
  bool
  contains(const std::string& key) const
  {
    return keys_.count(key) > 0;
  }
  /// Settings of all runs in this folder.
  const nlohmann::ordered_json&
  settings() const
  {
    return settings_;
  }
  /// Write a row and, where candidates.csv is written, its candidates through to the disk. \throw io::IoError
  void
  append(const PairResult& result);

private:
  void
  lock();
  void
  checkSettings(const nlohmann::ordered_json& settings, bool resume);
  void
  readRows();
  /// Drop what a run that was killed wrote of a row that is not there.
  void
  cutCandidates();

  std::string folder_;
  std::string file_;
  int lock_ = -1;
  int output_ = -1;
  int candidates_ = -1; ///< candidates.csv; -1: it is not written
  nlohmann::ordered_json settings_;
  std::vector<ResultRow> rows_;
  std::set<std::string> keys_;
};

} // namespace apps
} // namespace pcl_ssfr
