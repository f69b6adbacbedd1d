// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/decision.h"

#include "judgement/confidence.h"
#include "judgement/pose_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace pcl_ssfr {

namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr double kNoRival = std::numeric_limits<double>::infinity(); // lead over it

constexpr double kHopelessOverlap = 0.15;
// Of 261 best poses below 5 % two were right. Scans of different places reached 3.8 % with some confidence, right
// answers that were believed 4.8 % and more.
constexpr double kLeastOverlap = 0.044;
constexpr double kLeastOverlapConfidence = 0.3;
constexpr double kTellingContradiction = 0.1; // of the visible surface
constexpr double kUnobservableConfidence = 0.3;
constexpr double kSameSensor = 0.1;           // [m] at scale 1
constexpr double kSensorOnSensorRatio = 0.85; // of the best score: a rival of a pose that lays sensor on sensor
constexpr double kPatternRatio = 0.5;         // the same where the scene hardly tells the place along a direction ...
constexpr double kWeakInformation = 0.02;     // ... with less than this of the information along the best one
// Several poses that come near the best one:
constexpr double kNear = 0.9; // of the best score and of its matched surface
constexpr std::size_t kSeveral = 3;

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
  constexpr int kMostDigits = 12;
  char text[24];
  for (int digits = 2; digits <= kMostDigits; ++digits) {
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

/// By how much the best pose scores more than a \p rival: by all patches or by those that face their sensor, where it
/// is less.
double
leadOver(const JudgedPose& rival, const JudgedPose& best)
{
  return std::min(best.score - rival.score, best.facing_score - rival.facing_score);
}

/// The pose over which the best one's lead is least, of those that the guess has not ruled out; null: there is none.
const JudgedPose*
findRival(const std::vector<JudgedPose>& poses, const DecisionContext& context)
{
  const JudgedPose& best = poses.front();
  const double ruled_out = ambiguousRatio(context.free_space) * best.score;
  const JudgedPose* rival = nullptr;
  for (auto pose = poses.begin() + 1; pose != poses.end(); ++pose)
    if (!(context.guess_decides && pose->score >= ruled_out) &&
        (!rival || leadOver(*pose, best) < leadOver(*rival, best)))
      rival = &*pose;
  return rival;
}

/// Whether a pose lays one sensor on the other. Then the patterns of their rays coincide, and with them what is wrong
/// with the patches: more matches than the surface accounts for. Along a corridor that alone picks a place.
bool
laysSensorOnSensor(const JudgedPose& pose, const DecisionContext& context)
{
  return context.free_space && (pose.T_target_source * context.source_viewpoint - context.target_viewpoint).norm() <
                                   kSameSensor * context.scale;
}

/// Whether little surface tells where along some direction the source is: there the pattern of the rays weighs much.
bool
isWeaklyDetermined(const PoseUncertainty& uncertainty)
{
  return !uncertainty.translations.empty() && uncertainty.translations.front().strength < kWeakInformation;
}

/// Poses that explain the scans about as well as the best, itself included. One that matches more surface may score a
/// little less: what little contradicts it may be things that moved, or curved surface told by flat patches. And
/// where several come near, the scene repeats itself: the truth may be one more that was not even found.
std::size_t
countEquals(const std::vector<JudgedPose>& poses, const PoseUncertainty& uncertainty, const DecisionContext& context)
{
  const JudgedPose& best = poses.front();
  const double least = !laysSensorOnSensor(best, context) ? ambiguousRatio(context.free_space)
                       : isWeaklyDetermined(uncertainty)       ? kPatternRatio
                                                          : kSensorOnSensorRatio;
  std::size_t equal = 0;
  std::size_t near = 0;
  for (const JudgedPose& pose : poses) {
    const bool is_near = pose.score >= kNear * best.score && pose.evidence.matched >= kNear * best.evidence.matched;
    near += is_near;
    equal += pose.score >= least * best.score || (is_near && pose.evidence.matched > best.evidence.matched);
  }
  return std::max<std::size_t>(1, near >= kSeveral ? near : equal);
}

/// What the decision goes by.
struct Findings {
  const std::vector<JudgedPose>& poses;
  const PoseUncertainty& uncertainty;
  const DecisionContext& context;
  Candidate best;          ///< the first of the poses, as users are told of it
  const JudgedPose* rival; ///< the strongest; null: there is none
};

/// What the scene does not tell, for people; empty: it tells everything, or nothing was polished.
std::string
unobservableText(const Decision& decision, const Findings& found)
{
  if (decision.unobservable.empty())
    return "";
  const UnobservableDirection& open = decision.unobservable.front();
  const std::string direction = directionText(open.rotation ? "rotation about" : "translation along", open.direction);
  const double deviation = found.uncertainty.largestRotationDeviation();
  if (!open.rotation || std::isinf(deviation))
    return "the scene does not determine the " + direction;
  return "the scene hardly determines the " + direction +
         formatted(": to %.2f degrees, one standard deviation", deviation * kDegrees);
}

/// Where the strongest rival lies, for people; empty: there is none.
std::string
rivalText(const Findings& found)
{
  if (!found.rival)
    return "";
  const Eigen::Isometry3d& T_best = found.poses.front().T_target_source;
  const Eigen::Isometry3d& T_rival = found.rival->T_target_source;
  return formatted("the strongest rival lies %.2f m and %.1f degrees away",
                   shiftBetween(T_best, T_rival, found.context.source_viewpoint),
                   turnBetween(T_best, T_rival) * kDegrees);
}

void
settle(Decision& decision, Status status, const std::string& message)
{
  decision.status = status;
  decision.message = message;
}

/// Status and message from the evidence; lowers the confidence where the scene or a rival leaves the pose open.
void
decideOnEvidence(Decision& decision, const Findings& found)
{
  const Candidate& best = found.best;
  const DecisionContext& context = found.context;
  if (best.overlap < kLeastOverlap)
    decision.confidence = std::min(decision.confidence, kLeastOverlapConfidence);
  const bool confident = decision.confidence >= context.min_confidence && best.overlap >= kLeastOverlap;
  const std::string low_overlap = formatted(
      "under the best pose only %.0f %% of the surface meets its counterpart: the scans may not show the same place",
      100 * best.overlap);
  if (best.overlap < kHopelessOverlap && !confident)
    return settle(decision, Status::LowOverlap, low_overlap);

  const std::string unobservable = unobservableText(decision, found);
  if (!unobservable.empty()) {
    decision.confidence = std::min(decision.confidence, kUnobservableConfidence);
    return settle(decision, Status::Unobservable, unobservable);
  }

  if (best.score > 0) {
    if (decision.equals > 1 && !context.guess_decides) {
      decision.confidence = std::min(decision.confidence, 1.0 / static_cast<double>(decision.equals));
      return settle(
          decision,
          Status::Ambiguous,
          std::to_string(decision.equals) +
              " distinct poses explain the scans about equally well (symmetry or repetition): " + rivalText(found));
    }
    if (confident)
      return settle(decision, Status::Converged, explained(best));
    if (estimateConfidence(best, kNoRival, context.free_space) >= context.min_confidence)
      return settle(decision, Status::Ambiguous, "another pose explains the scans nearly as well: " + rivalText(found));
  }

  const double visible = best.overlap + best.contradiction + best.evidence.unmatched;
  if (best.contradiction > kTellingContradiction * visible)
    return settle(decision,
                  Status::Contradicted,
                  formatted("the best pose puts %.1f %% of the surface into space that the other sensor saw to be "
                            "free, while %.0f %% meets its counterpart",
                            100 * best.contradiction,
                            100 * best.overlap));
  if (best.overlap >= kHopelessOverlap)
    return settle(decision,
                  Status::LowOverlap,
                  notConfidentText(decision.confidence, context.min_confidence) + ": " + explained(best));
  settle(decision, Status::LowOverlap, low_overlap);
}

} // namespace

Decision
decide(const std::vector<JudgedPose>& poses, const Refinement& polish, const DecisionContext& context)
{
  const PoseUncertainty uncertainty = poseUncertainty(polish, context.noise_floor, context.rotation_prior);
  const Findings found{poses, uncertainty, context, describe(poses.front()), findRival(poses, context)};
  Decision decision;
  decision.confidence = estimateConfidence(
      found.best, found.rival ? leadOver(*found.rival, poses.front()) : kNoRival, context.free_space);
  decision.unobservable = unobservableDirections(uncertainty);
  decision.equals = countEquals(poses, uncertainty, context);
  decideOnEvidence(decision, found);
  // Nothing but the things on the plane could have told.
  if (!context.few_directions.empty() && decision.status != Status::Converged)
    settle(decision,
           Status::TooFewDirections,
           context.few_directions + ", and what is no plane does not tell its rotation: " + decision.message);
  return decision;
}

} // namespace pcl_ssfr
