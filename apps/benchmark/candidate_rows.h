// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <pcl_ssfr/result.h>

#include <apps/pairs/result_row.h>

#include <nlohmann/json.hpp>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace apps {

/// What is written of a candidate besides its pose: a column of candidates.csv per field. Add fields here.
std::vector<std::pair<const char*, double>>
candidateFields(const Result& result, const Candidate& candidate);

/// A candidate of a method, in file coordinates.
struct CandidateAnswer {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  std::vector<double> values; ///< of candidateFields(), in its order
  bool right = false;         ///< by the dataset's bound
};

/// The candidates of a result, best first.
std::vector<CandidateAnswer>
candidatesOf(const Result& result);

/// A candidate as processes send it to each other.
nlohmann::ordered_json
toJson(const CandidateAnswer& candidate);

/// \throw nlohmann::json::exception, std::invalid_argument
CandidateAnswer
candidateFromJson(const nlohmann::ordered_json& json);

/// A row, and the candidates that its pose was chosen from, best first.
struct PairResult {
  ResultRow row;
  std::vector<CandidateAnswer> candidates;
};

/// The first line of candidates.csv, without its end.
std::string
candidateHeader();

/** \brief A candidate as a line of candidates.csv without its end.
 * \param[in] number of the row in results.csv, from 1
 * \param[in] rank place among the candidates, from 1
 */
std::string
candidateLine(std::size_t number, const ResultRow& row, std::size_t rank, const CandidateAnswer& candidate);

} // namespace apps
} // namespace pcl_ssfr
