// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/decision.h"

#include "common/angles.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

namespace pcl_ssfr {

namespace {

std::string
formatted(const char* format, double a, double b = 0)
{
  char text[160];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

/// What speaks for and against a pose, for people.
std::string
explained(const Candidate& pose)
{
  return formatted("%.0f %% of the surface meets its counterpart, %.1f %% contradicts the pose",
                   100 * pose.overlap,
                   100 * pose.contradiction);
}

/// "confidence 0.62 is less than the 0.7 that is asked for", with as many digits as it takes to be so.
std::string
notConfidentText(double confidence, double asked)
{
  char text[24];
  for (int digits = 2; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::snprintf(text, sizeof(text), "%.*f", digits, confidence);
    if (std::strtod(text, nullptr) < asked)
      break;
  }
  return std::string("confidence ") + text + formatted(" is less than the %.9g that is asked for", asked);
}

/// "along (1.00, 0.00, 0.00) of the target frame".
std::string
directionText(const char* preposition, const Eigen::Vector3d& direction)
{
  char text[100];
  std::snprintf(text,
                sizeof(text),
                "%s (%.2f, %.2f, %.2f) of the target frame",
                preposition,
                direction.x(),
                direction.y(),
                direction.z());
  return text;
}

/// The direction that the scene determines least, for people; \p decision has one.
std::string
unobservableText(const Decision& decision, const PoseUncertainty& uncertainty)
{
  const UnobservableDirection& open = decision.unobservable.front();
  const std::string direction = directionText(open.rotation ? "rotation about" : "translation along", open.direction);
  const double deviation = uncertainty.largestRotationDeviation();
  if (!open.rotation || std::isinf(deviation))
    return "the scene does not determine the " + direction;
  return "the " + direction + formatted(" is poorly constrained (sigma = %.2f deg)", deviation / kDegree);
}

/// Where the most probable rival lies, for people; empty: there is none.
std::string
rivalText(const std::vector<ScoredPose>& poses, const Eigen::Vector3d& place)
{
  if (poses.size() < 2)
    return "";
  const Eigen::Isometry3d& T_best = poses[0].T_target_source;
  const Eigen::Isometry3d& T_rival = poses[1].T_target_source;
  return formatted("the strongest rival lies %.2f m and %.1f degrees away",
                   translationBetween(T_best, T_rival, place),
                   rotationBetween(T_best, T_rival) / kDegree);
}

/// Why the truth is probably none of the poses.
void
refuse(Decision& decision, const Candidate& best, const DecisionContext& context)
{
  const double visible = best.overlap + best.contradiction + best.evidence.unmatched;
  if (best.contradiction > context.config.named_share * visible) {
    decision.status = Status::Contradicted;
    decision.message = formatted("the best pose puts %.1f %% of the surface into space that the other sensor saw to be "
                                 "free, while %.0f %% meets its counterpart",
                                 100 * best.contradiction,
                                 100 * best.overlap);
    return;
  }
  decision.status = Status::LowOverlap;
  decision.message =
      best.overlap >= context.config.named_share
          ? notConfidentText(decision.confidence, context.min_confidence) + ": " + explained(best)
          : formatted("under the best pose only %.0f %% of the surface meets its counterpart: the scans may not show "
                      "the same place",
                      100 * best.overlap);
}

/// A line along which poses are one pose with the first, but for a shift.
struct SharedLine {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(); ///< unit; zero: no other pose has this rotation
  double probability = 0;                              ///< of all poses on it together
};

/// The line through the first pose that most of the probability of those with its rotation lies on: in a corridor
/// whose walls alone match, and where bays repeat.
SharedLine
sharedLine(const std::vector<ScoredPose>& poses, const DecisionContext& context)
{
  const Eigen::Isometry3d& T_best = poses.front().T_target_source;
  std::vector<std::pair<Eigen::Vector3d, double>> shifts;
  Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const Eigen::Isometry3d& T = poses[k].T_target_source;
    if (rotationBetween(T_best, T) >= context.distinct_angle)
      continue;
    const Eigen::Vector3d shift = T * context.source_viewpoint - T_best * context.source_viewpoint;
    shifts.emplace_back(shift, context.posterior.poses[k]);
    directions += context.posterior.poses[k] * shift.normalized() * shift.normalized().transpose();
  }
  SharedLine line;
  if (shifts.empty())
    return line;
  line.direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(directions).eigenvectors().col(2);
  line.probability = context.posterior.poses.front();
  for (const auto& [shift, probability] : shifts)
    if ((shift - line.direction * line.direction.dot(shift)).norm() < context.distinct_distance)
      line.probability += probability;
  return line;
}

/// Ambiguous: the truth probably is among the poses, but which of them it is stays open.
void
reportAmbiguous(Decision& decision, const std::vector<ScoredPose>& poses, const DecisionContext& context)
{
  const std::vector<double>& p = context.posterior.poses;
  const auto is_about_equal = [&](double probability) { return 2 * probability >= p.front(); };
  const auto equals = std::count_if(p.begin(), p.end(), is_about_equal);
  decision.status = Status::Ambiguous;
  decision.message = (equals > 1 ? std::to_string(equals) + " distinct poses explain the scans about equally well "
                                                            "(symmetry or repetition): "
                                 : std::string("other poses explain the scans nearly as well: ")) +
                     rivalText(poses, context.source_viewpoint);
  const SharedLine line = sharedLine(poses, context);
  if (line.probability >= context.min_confidence && line.direction.squaredNorm() > 0) {
    decision.unobservable.push_back({line.direction, false, 0});
    decision.message += formatted("; with probability %.2f all is known but the ", line.probability) +
                        directionText("translation along", line.direction);
  }
}

} // namespace

Decision
decide(const std::vector<ScoredPose>& poses, const DecisionContext& context)
{
  const Candidate best = describe(poses.front());
  Decision decision;
  decision.confidence = context.posterior.best();
  decision.unobservable = unobservableDirections(context.uncertainty, context.config.uncertainty);
  const bool is_undetermined = !decision.unobservable.empty();
  if (is_undetermined)
    decision.confidence = std::min(decision.confidence, context.config.unsettled);

  const double none = context.posterior.none;
  const bool is_probably_none = none > 1 - context.min_confidence || !(none < 1);
  // Where much of the surface meets, what the scene does not determine is the reason for both.
  if (is_undetermined && (!is_probably_none || best.overlap >= context.config.named_share)) {
    decision.status = Status::Unobservable;
    decision.message = unobservableText(decision, context.uncertainty);
  }
  else if (is_probably_none)
    refuse(decision, best, context);
  else if (decision.confidence < context.min_confidence)
    reportAmbiguous(decision, poses, context);
  else {
    decision.status = Status::Converged;
    decision.message = explained(best);
  }
  // Nothing but the things on the plane could have determined it.
  if (!context.few_directions.empty() && decision.status != Status::Converged) {
    decision.status = Status::TooFewDirections;
    decision.message =
        context.few_directions + ", and what is no plane does not determine its rotation: " + decision.message;
  }
  // Its rivals were not all looked for, nor was it refined to the end.
  if (context.is_cut_short) {
    decision.confidence = std::min(decision.confidence, context.config.unsettled);
    decision.status = Status::TimeLimit;
    decision.message = "the time limit cut the search short; so far: " + decision.message;
  }
  return decision;
}

} // namespace pcl_ssfr
