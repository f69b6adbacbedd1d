// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/result.h>

namespace pcl_ssfr {

const char*
toString(Status status)
{
  switch (status) {
  case Status::NotRun:
    return "not_run";
  case Status::Converged:
    return "converged";
  case Status::InvalidInput:
    return "invalid_input";
  case Status::TooFewPoints:
    return "too_few_points";
  case Status::TooFewDirections:
    return "too_few_directions";
  case Status::NoCandidate:
    return "no_candidate";
  case Status::Ambiguous:
    return "ambiguous";
  case Status::Unobservable:
    return "unobservable";
  case Status::LowOverlap:
    return "low_overlap";
  case Status::Contradicted:
    return "contradicted";
  case Status::TimeLimit:
    return "time_limit";
  }
  return "unknown";
}

} // namespace pcl_ssfr
