// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/candidate_rows.h>

#include <apps/common/format_text.h>
#include <apps/common/json_values.h>
#include <apps/io/csv_line.h>
#include <apps/pairs/pair_input.h>

#include <cmath>
#include <limits>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

std::string
number(double value)
{
  return std::isfinite(value) ? format("%.9g", value) : std::string();
}

} // namespace

std::vector<std::pair<const char*, double>>
candidateFields(const Result& result, const Candidate& candidate)
{
  const CandidateEvidence& evidence = candidate.evidence;
  return {{"score", candidate.score},
          {"overlap", candidate.overlap},
          {"contradiction", candidate.contradiction},
          {"from_guess", candidate.from_guess ? 1 : 0},
          {"patches_matched", evidence.patches_matched},
          {"patches_contradicted", evidence.patches_contradicted},
          {"facing_matched", evidence.facing_matched},
          {"beyond_planes", evidence.beyond_planes},
          {"facing_score", evidence.facing_score},
          {"unmatched", evidence.unmatched},
          {"third_direction", evidence.third_direction},
          {"held_second", evidence.held_second},
          {"held_third", evidence.held_third},
          {"clutter", evidence.clutter},
          {"patches", evidence.patches},
          {"facing_patches", evidence.facing_patches},
          {"probability", candidate.probability},
          {"probability_of_none", result.probability_of_none},
          {"viewpoints_used", result.source_viewpoint_used && result.target_viewpoint_used ? 1 : 0}};
}

std::vector<CandidateAnswer>
candidatesOf(const Result& result)
{
  std::vector<CandidateAnswer> answers;
  for (const Candidate& candidate : result.candidates) {
    answers.emplace_back();
    answers.back().T_target_source = candidate.T_target_source;
    for (const auto& [name, value] : candidateFields(result, candidate))
      answers.back().values.push_back(value);
  }
  return answers;
}

Json
toJson(const CandidateAnswer& candidate)
{
  Json values = Json::array();
  for (const double value : candidate.values)
    values.push_back(numberOrNull(value));
  return {{"T_target_source", matrixJson(candidate.T_target_source)}, {"values", values}, {"right", candidate.right}};
}

CandidateAnswer
candidateFromJson(const Json& json)
{
  CandidateAnswer candidate;
  candidate.T_target_source = poseFromJson(json.at("T_target_source"));
  for (const Json& value : json.at("values"))
    candidate.values.push_back(value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN());
  candidate.right = json.at("right").get<bool>();
  return candidate;
}

std::string
candidateHeader()
{
  std::string header = "row,dataset,source,target,method,rank,right";
  for (int i = 0; i < 16; ++i)
    header += format(",T%d%d", i / 4, i % 4);
  for (const auto& [name, value] : candidateFields(Result(), Candidate()))
    header += std::string(",") + name;
  return header;
}

std::string
candidateLine(std::size_t number_of_row, const ResultRow& row, std::size_t rank, const CandidateAnswer& candidate)
{
  std::string line = std::to_string(number_of_row) + "," + io::csvField(row.dataset) + "," + io::csvField(row.source) +
                     "," + io::csvField(row.target) + "," + io::csvField(row.method) + "," + std::to_string(rank) +
                     (candidate.right ? ",1" : ",0");
  for (Eigen::Index i = 0; i < 16; ++i)
    line += "," + number(candidate.T_target_source.matrix()(i / 4, i % 4));
  for (const double value : candidate.values)
    line += "," + number(value);
  return line;
}

} // namespace apps
} // namespace pcl_ssfr
