// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "profiles/patch_profile.h"

#include "common/parallel.h"
#include "common/stage_clock.h"
#include "directions/scene_directions.h"
#include "judgement/confidence.h"
#include "judgement/decision.h"
#include "judgement/judged_pose.h"
#include "judgement/pose_priors.h"
#include "judgement/pose_uncertainty.h"
#include "profiles/patch_constants.h"
#include "profiles/patch_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace pcl_ssfr {

namespace {

constexpr double kPairAngle = 0.07; // [rad] inner angles of pairs agree within this; rotations closer are one

// Lengths at scale 1 [m]; the scale of the scene multiplies them.
constexpr double kBinWidth = 0.1;     // of the histograms along an axis
constexpr double kSearchStep = 0.25;  // of the shift along the third axis
constexpr double kNoiseFloor = 0.001; // least standard deviation of plane distances

/// How hard the search tries; the second effort, for scans that share little, is made only when the first finds nothing
/// that is surely right.
struct Effort {
  std::size_t poses;    ///< refined, at most
  double votes;         ///< of the best pose, that one must have to be refined before the others
  std::size_t distinct; ///< refined finely, at most
  int peaks_first, peaks_second;
  bool little_overlap;
};
// Of 271 real pairs, all solved ones had a pose near the truth with 0.65 of the most votes; of 375 simulated ones, 373
// with 0.4.
constexpr std::array<Effort, 2> kEfforts = {{{80, 0.4, 8, 5, 8, false}, {240, 0, 16, 8, 24, true}}};

/// The stages for one pair of scans.
class PatchRegistration {
public:
  PatchRegistration(const PatchRegistration&) = delete; // one part refers to another

  PatchRegistration(const PatchScan& source,
                    const PatchScan& target,
                    const Options& options,
                    const Eigen::Isometry3d* guess = nullptr,
                    const Deadline& deadline = Deadline())
      : source_(source), target_(target), options_(options), pair_(source, target, options, guess, deadline),
        priors_(pair_.priors()), scale_(pair_.scale()), threads_(pair_.threads())
  {
    if (guess)
      guess_ = pair_.toInner(*guess);
    source_normals_ = source.main_normals;
    target_normals_ = target.main_normals;
    if (options.gravity) {
      source_normals_ = withVertical(source_normals_, options.gravity->up_source);
      target_normals_ = withVertical(target_normals_, options.gravity->up_target);
    }
  }

  Result
  run()
  {
    result_.source_viewpoint_used = source_.viewpoint_used;
    result_.target_viewpoint_used = target_.viewpoint_used;
    result_.source_viewpoint_found = source_.viewpoint_found;
    result_.target_viewpoint_found = target_.viewpoint_found;
    if (source_.viewpoint_used)
      result_.source_viewpoint = source_.origin + source_.viewpoint;
    if (target_.viewpoint_used)
      result_.target_viewpoint = target_.origin + target_.viewpoint;
    for (const PatchScan* scan : {&source_, &target_})
      for (StageReport stage : scan->stages) {
        stage.name = (scan == &source_ ? "source " : "target ") + stage.name;
        result_.stages.push_back(stage);
      }
    if (!checkScans())
      return result_;
    const std::vector<RotationCandidate> rotations = proposeRotations();
    if (rotations.empty() && !guess_)
      return settle(Status::NoCandidate, "no rotation lays the main normals of the scans on each other");
    std::vector<JudgedPose> poses;
    for (const Effort& effort : kEfforts) {
      std::vector<JudgedPose> found = search(rotations, effort);
      dropKnown(found, poses);
      found.insert(found.end(), poses.begin(), poses.end());
      poses = keepDistinct(std::move(found), effort.distinct);
      guess_orders_ = guess_decides_ = false;
      if (poses.empty() && outOfTime())
        break;
      const bool last = &effort == &kEfforts.back();
      if (poses.empty() || (!last && !isSettled(poses)))
        continue;
      preferGuess(poses);
      polishBest(poses);
      // The polish may find that a pose is not as good as it seemed: a reason to look further.
      if (isSettled(poses) || isClear(poses))
        break;
    }
    if (!poses.empty())
      return cut_short_ ? settleUnfinished() : result_;
    result_.candidates.clear();
    return outOfTime() ? settle(Status::TimeLimit, "the time limit ran out before a pose could be judged")
                       : settle(Status::NoCandidate, nothingFound());
  }

  /// What every effort tries.
  std::vector<PatchSearch>
  searches()
  {
    std::vector<PatchSearch> all;
    checkScans(); // says whether there are too few directions
    const std::vector<RotationCandidate> rotations = proposeRotations();
    for (const Effort& effort : kEfforts) {
      PatchSearch search;
      search.options = searchOptions(effort);
      search.source_normals = source_normals_;
      search.target_normals = target_normals_;
      search.rotations = rotations;
      search.poses = searchPoses(search.rotations, search.options);
      search.refined = promising(search.poses, effort);
      all.push_back(std::move(search));
    }
    return all;
  }

  Candidate
  judged(const Eigen::Isometry3d& T_target_source, bool refine) const
  {
    JudgedPose pose;
    pose.T_target_source = pair_.toInner(T_target_source);
    if (refine)
      pose.T_target_source = pair_.refinedFinely(pose.T_target_source);
    pair_.judgeFinely(pose);
    return makeCandidate(pose);
  }

private:
  bool
  outOfTime() const
  {
    return pair_.outOfTime();
  }

  /// Conclude from the judged poses, best first. \return whether there is nothing more to look for: the best pose is
  /// surely right, or others explain the scans as well, or time has run out
  bool
  isSettled(const std::vector<JudgedPose>& poses)
  {
    cut_short_ = outOfTime();
    const std::size_t equals = conclude(poses);
    return (result_.accepted() && result_.confidence >= kSureConfidence) ||
           (result_.status == Status::Ambiguous && equals > 1) || cut_short_;
  }

  /// The answer of a search that was cut short is no more than the best so far: its rivals were not all looked for, nor
  /// was it refined to the end.
  Result&
  settleUnfinished()
  {
    result_.confidence = std::min(result_.confidence, kUnfinishedConfidence);
    return settle(Status::TimeLimit, "the time limit cut the search short; so far: " + result_.message);
  }

  /// What there is to say, for now.
  Result&
  settle(Status status, const std::string& message)
  {
    result_.status = status;
    result_.message = message;
    return result_;
  }

  /// METHOD stages 9 to 13 with some effort: distinct finely refined poses; those that had few votes are looked at
  /// when none of the others is clear.
  std::vector<JudgedPose>
  search(const std::vector<RotationCandidate>& rotations, const Effort& effort)
  {
    std::vector<PoseHypothesis> hypotheses = searchPoses(rotations, searchOptions(effort));
    hypotheses.resize(std::min(hypotheses.size(), effort.poses));
    const auto few = hypotheses.begin() + static_cast<std::ptrdiff_t>(promising(hypotheses, effort));
    std::vector<JudgedPose> found = refineCoarsely({hypotheses.begin(), few}, true, effort);
    refineFinely(found);
    if (few != hypotheses.end() && !isClear(found) && !outOfTime()) {
      std::vector<JudgedPose> others = refineCoarsely({few, hypotheses.end()}, false, effort);
      refineFinely(others);
      found.insert(found.end(), others.begin(), others.end());
    }
    return found;
  }

  std::string
  nothingFound() const
  {
    return std::string("no ") +
           (priors_.guess()    ? "pose within the tolerance of the guess"
            : options_.gravity ? "pose that keeps the given vertical"
                               : "translation") +
           " lays surfaces of the scans on each other";
  }

  void
  report(const char* stage, std::uint64_t in, std::uint64_t out)
  {
    result_.stages.push_back(clock_.lap(stage, in, out));
  }

  /// Whether both scans hold what the method needs; says what is missing.
  bool
  checkScans()
  {
    for (const PatchScan* scan : {&source_, &target_}) {
      const std::string name = scan == &source_ ? "the source scan" : "the target scan";
      if (scan->extent.finite_points < kMinPoints) {
        settle(Status::TooFewPoints,
               name + " has " + std::to_string(scan->extent.finite_points) + " finite points, at least " +
                   std::to_string(kMinPoints) + " are needed");
        return false;
      }
      const std::vector<MainNormal>& normals = scan == &source_ ? source_normals_ : target_normals_;
      if (!hasPair(normals, RotationOptions{}) && few_directions_.empty())
        few_directions_ = name + " has planes in fewer than two directions";
      if (normals.empty() && !priors_.guess()) {
        settle(Status::TooFewDirections, name + " has no planes: its rotation cannot be observed");
        return false;
      }
    }
    return true;
  }

  /// METHOD stages 6 to 8, merged and ranked (METHOD point 3); where main normals do not tell the rotation, also such
  /// all around.
  std::vector<RotationCandidate>
  proposeRotations()
  {
    RotationOptions rotation;
    rotation.angle_tolerance = kPairAngle;
    rotation.merge_angle = kPairAngle;
    rotation.refit_angle = kRefitAngle;
    std::vector<RotationCandidate> rotations =
        pcl_ssfr::proposeRotations(source_normals_, target_normals_, rotation, static_cast<unsigned>(threads_));
    const auto contradicts_priors = [&](const RotationCandidate& r) {
      return !priors_.allow(r.R_target_source, Exactness::Proposed);
    };
    rotations.erase(std::remove_if(rotations.begin(), rotations.end(), contradicts_priors), rotations.end());
    const std::size_t all = rotations.size();
    rotations.resize(std::min(all, kMaxRotations));
    const bool few = !few_directions_.empty();
    for (const RotationCandidate& r : sweepRotations(sweepAxes(source_normals_, source_.patches.samples, few),
                                                     sweepAxes(target_normals_, target_.patches.samples, few),
                                                     kSweepSteps))
      if (!contradicts_priors(r))
        rotations.push_back(r);
    if (priors_.guess()) {
      rotations.emplace_back();
      rotations.back().R_target_source = priors_.guess()->linear();
    }
    report("rotations", all, rotations.size());
    return rotations;
  }

  PoseSearchOptions
  searchOptions(const Effort& effort) const
  {
    PoseSearchOptions search;
    search.peaks_first = effort.peaks_first;
    search.peaks_second = effort.peaks_second;
    search.bin_width = boundBinWidth(options_.bin_width > 0 ? options_.bin_width : kBinWidth * scale_,
                                     source_.patches.samples,
                                     target_.patches.samples,
                                     HistogramOptions{}.max_bins);
    search.little_overlap = effort.little_overlap;
    if (effort.little_overlap)
      search.contradiction_weight = kContradictionWeight;
    search.peak_separation = kDistinctDistance * scale_;
    search.step = kSearchStep * scale_;
    search.visibility = pair_.searchTolerances();
    search.deadline = pair_.deadline();
    return search;
  }

  using Rotations = std::vector<RotationCandidate>::const_iterator;

  /// METHOD stages 9 to 12 for some rotations, each by a thread of its own; appends to \p poses in their order.
  void
  searchTranslationsOf(Rotations begin,
                       Rotations end,
                       const PoseSearchOptions& search,
                       std::vector<PoseHypothesis>& poses) const
  {
    std::vector<std::vector<PoseHypothesis>> found(static_cast<std::size_t>(end - begin));
    forEachInParallel(end - begin, 1, threads_, [&](std::int64_t i) {
      if (outOfTime())
        return;
      const Eigen::Matrix3d& R = begin[i].R_target_source;
      PoseSearchOptions near = search;
      near.window = priors_.shiftWindow(R, search.peak_separation);
      found[static_cast<std::size_t>(i)] = searchTranslations(source_.patches.samples,
                                                              source_.votes,
                                                              target_.patches.samples,
                                                              target_normals_,
                                                              target_.index,
                                                              pair_.targetImage(),
                                                              R,
                                                              near);
    });
    for (const std::vector<PoseHypothesis>& some : found)
      poses.insert(poses.end(), some.begin(), some.end());
  }

  /// METHOD stages 9 to 12 for every rotation; all poses, best first.
  std::vector<PoseHypothesis>
  searchPoses(const std::vector<RotationCandidate>& rotations, const PoseSearchOptions& search)
  {
    std::vector<PoseHypothesis> poses;
    // The votes for the best of the first rotations spare the others the counting of what is hopeless.
    const std::size_t first = std::min(rotations.size(), kFirstRotations);
    PoseSearchOptions options = search;
    searchTranslationsOf(rotations.begin(), rotations.begin() + static_cast<std::ptrdiff_t>(first), options, poses);
    for (const PoseHypothesis& pose : poses)
      options.rival_votes = std::max(options.rival_votes, pose.votes);
    searchTranslationsOf(rotations.begin() + static_cast<std::ptrdiff_t>(first), rotations.end(), options, poses);
    std::stable_sort(
        poses.begin(), poses.end(), [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; });
    report("translations", rotations.size(), poses.size());
    return poses;
  }

  /// Whether the first of the poses explains the scans so well that what had few votes need not be looked at.
  static bool
  isClear(const std::vector<JudgedPose>& poses)
  {
    if (poses.empty())
      return false;
    const JudgedPose& best = poses.front();
    const Voices& voices = best.evidence.voices;
    return best.score > kClearScore && best.score * voices.total > kClearShare * voices.matched;
  }

  /// How many of the poses, which are sorted by their votes, are refined first.
  static std::size_t
  promising(const std::vector<PoseHypothesis>& poses, const Effort& effort)
  {
    const double least = poses.empty() ? 0 : effort.votes * std::max(poses.front().score, 0.0);
    std::size_t count = 0;
    while (count < std::min(poses.size(), effort.poses) && (least <= 0 || poses[count].score >= least))
      ++count;
    return count;
  }

  /// Apply \p refine to every pose, in parallel, one slot each.
  template <typename Refine>
  void
  forEachPose(std::vector<JudgedPose>& poses, const Refine& refine) const
  {
    forEachInParallel(static_cast<std::int64_t>(poses.size()), 1, threads_, [&](std::int64_t i) {
      refine(poses[static_cast<std::size_t>(i)]);
    });
  }

  /// Drop the poses that are one of those that were polished: each is polished once.
  void
  dropKnown(std::vector<JudgedPose>& poses, const std::vector<JudgedPose>& known) const
  {
    const auto is_known = [&](const JudgedPose& pose) {
      return std::any_of(known.begin(), known.end(), [&](const JudgedPose& other) {
        return other.polish && pair_.isSamePlace(pose.T_target_source, other.T_target_source);
      });
    };
    poses.erase(std::remove_if(poses.begin(), poses.end(), is_known), poses.end());
  }

  /// The best of poses that differ, at most \p most.
  std::vector<JudgedPose>
  keepDistinct(std::vector<JudgedPose> poses, std::size_t most) const
  {
    sortByScore(poses);
    return firstDistinct(poses, most);
  }

  /// The poses that are none of those before them, at most \p most.
  std::vector<JudgedPose>
  firstDistinct(const std::vector<JudgedPose>& poses, std::size_t most) const
  {
    std::vector<JudgedPose> distinct;
    for (const JudgedPose& pose : poses) {
      if (distinct.size() >= most)
        break;
      const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const JudgedPose& other) {
        return pair_.isSamePlace(pose.T_target_source, other.T_target_source);
      });
      if (!known)
        distinct.push_back(pose);
    }
    return distinct;
  }

  std::vector<JudgedPose>
  refineCoarsely(const std::vector<PoseHypothesis>& hypotheses, bool with_guess, const Effort& effort)
  {
    std::vector<JudgedPose> poses(hypotheses.size());
    for (std::size_t i = 0; i < hypotheses.size(); ++i)
      poses[i].T_target_source = hypotheses[i].T_target_source;
    if (with_guess && guess_) {
      poses.emplace_back();
      poses.back().T_target_source = *guess_;
      poses.back().from_guess = true;
    }
    forEachPose(poses, [&](JudgedPose& pose) {
      if (outOfTime())
        return; // without evidence it is dropped below
      pose.T_target_source = pair_.refinedCoarsely(pose.T_target_source);
      pair_.judgeCoarsely(pose);
    });
    poses.erase(
        std::remove_if(poses.begin(), poses.end(), [](const JudgedPose& pose) { return !(pose.evidence.matched > 0); }),
        poses.end());
    priors_.dropOthers(poses, Exactness::Proposed); // what comes in is not yet exact
    const auto kept_guess = std::find_if(poses.begin(), poses.end(), [](const JudgedPose& p) { return p.from_guess; });
    std::vector<JudgedPose> distinct = keepDistinct(poses, effort.distinct);
    // Whether the guess is right is for the finer stages to say.
    if (kept_guess != poses.end() &&
        std::none_of(distinct.begin(), distinct.end(), [](const JudgedPose& p) { return p.from_guess; }))
      distinct.push_back(*kept_guess);
    report("coarse refinement", hypotheses.size(), distinct.size());
    return distinct;
  }

  void
  refineFinely(std::vector<JudgedPose>& poses)
  {
    const std::size_t before = poses.size();
    const double best = poses.empty() ? 0 : poses.front().score;
    forEachPose(poses, [&](JudgedPose& pose) {
      const bool hopeless = !pose.from_guess && best > kClearScore && pose.score < kHopelessShare * best;
      pair_.judgeFinely(pose);
      if (options_.refine && !outOfTime() && !hopeless)
        pair_.moveUnlessWorse(pose, pair_.refinedFinely(pose.T_target_source));
    });
    priors_.dropOthers(poses, Exactness::Refined);
    poses = keepDistinct(std::move(poses), before);
    report("fine refinement", before, poses.size());
  }

  /// Among poses that explain the scans equally well, take the one next to the caller's guess; when it is clearly the
  /// nearest, the guess has told them apart and the answer is no longer ambiguous.
  void
  preferGuess(std::vector<JudgedPose>& poses)
  {
    if (!guess_ || poses.size() < 2)
      return;
    const auto distance = [&](const JudgedPose& pose) {
      const Eigen::Isometry3d& T = pose.T_target_source;
      return shiftBetween(T, *guess_, source_.viewpoint) + source_.extent.radius * turnBetween(T, *guess_);
    };
    const double least = ambiguousRatio(pair_.seesFreeSpace()) * poses.front().score;
    std::size_t nearest = 0;
    double second = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < poses.size() && poses[i].score >= least; ++i) {
      const bool nearer = distance(poses[i]) < distance(poses[nearest]);
      second = std::min(second, distance(poses[nearer ? nearest : i]));
      if (nearer)
        nearest = i;
    }
    guess_orders_ = std::isfinite(second);
    guess_decides_ = distance(poses[nearest]) < kClearlyNearer * second;
    std::rotate(poses.begin(),
                poses.begin() + static_cast<std::ptrdiff_t>(nearest),
                poses.begin() + static_cast<std::ptrdiff_t>(nearest) + 1);
  }

  /// Polish the best pose and, unless the guess has told them apart, the rivals that come near it: which of them is
  /// best must not hang on how far the coarser refinements got.
  void
  polishBest(std::vector<JudgedPose>& poses)
  {
    const double least = kPolishedShare * poses.front().score;
    std::size_t polished = 1;
    while (!guess_decides_ && polished < std::min(poses.size(), kMaxPolished) && poses[polished].score >= least)
      ++polished;
    std::size_t points = 0;
    std::array<bool, kMaxPolished> is_new{};
    for (std::size_t i = 0; i < polished && (i == 0 || !outOfTime()); ++i)
      if (!poses[i].polish) {
        pair_.polish(poses[i]);
        is_new[i] = true;
        points += static_cast<std::size_t>(source_.surface.points.cols() + target_.surface.points.cols());
      }
    // The guess has ordered the equals; otherwise the score decides.
    std::size_t best = 0;
    for (std::size_t i = 1; !guess_orders_ && i < polished; ++i)
      if (poses[i].polish && poses[i].score > poses[best].score)
        best = i;
    std::rotate(poses.begin(),
                poses.begin() + static_cast<std::ptrdiff_t>(best),
                poses.begin() + static_cast<std::ptrdiff_t>(best) + 1);
    if (is_new[best] && !outOfTime() && options_.refine)
      searchBeside(poses.front());
    // Polished, rivals may have changed their order, or turned out to be the same pose.
    sortByScore(poses, 1);
    poses = firstDistinct(poses, poses.size());
    report("polish", points, static_cast<std::uint64_t>(poses.front().polish->matches));
  }

  /// Where the scans hardly tell a pose along some directions, as level rings hardly tell its tilt, a refinement ends
  /// in the nearest of several places that explain them almost equally well. So start it from places beside the best
  /// pose, along those directions, and take the one that explains most.
  void
  searchBeside(JudgedPose& best)
  {
    for (int round = 0; round < kBesideRounds && best.score > 0 && !outOfTime() && !isSureOfTurn(*best.polish);
         ++round) {
      std::vector<JudgedPose> beside = placesBeside(best);
      forEachPose(beside, [&](JudgedPose& pose) {
        if (outOfTime())
          return;
        pair_.judgeFinely(pose);
        if (pose.score < kBesideShare * best.score)
          return;
        pose.T_target_source = pair_.refinedFinely(pose.T_target_source);
        pair_.judgeFinely(pose);
      });
      priors_.dropOthers(beside, Exactness::Refined);
      sortByScore(beside);
      if (outOfTime() || beside.empty() || beside.front().score < kBesideGain * best.score)
        return;
      pair_.polish(beside.front());
      if (beside.front().score < kBesideGain * best.score)
        return;
      best = beside.front();
    }
  }

  PoseUncertainty
  uncertaintyOf(const Refinement& polish) const
  {
    return poseUncertainty(polish, kNoiseFloor * scale_, priors_.rotationInformation());
  }

  /// Whether the matches of the polish and the priors tell every turn so well that there is one place only.
  bool
  isSureOfTurn(const Refinement& polish) const
  {
    return uncertaintyOf(polish).largestRotationDeviation() < kSureTurn;
  }

  /// The polished best pose, moved to and fro along what the matches tell least about.
  std::vector<JudgedPose>
  placesBeside(const JudgedPose& best) const
  {
    std::vector<JudgedPose> beside;
    const Eigen::Vector3d& centre = best.polish->centre;
    const std::vector<PrincipalMotion> motions = uncertaintyOf(*best.polish).motions;
    for (std::size_t k = 0; k < std::min(kBesideDirections, motions.size()); ++k)
      if (motions[k].deviation > motions.back().deviation / std::sqrt(kBesideStrength))
        for (const double distance : kBesideDistances)
          for (const int sign : {-1, 1}) {
            JudgedPose place = best;
            place.polish.reset();
            place.T_target_source = Eigen::Translation3d(centre) *
                                    expSe3(sign * distance * scale_ * motions[k].motion) *
                                    Eigen::Translation3d(-centre) * best.T_target_source;
            beside.push_back(place);
          }
    return beside;
  }

  Candidate
  makeCandidate(const JudgedPose& pose) const
  {
    Candidate candidate = describe(pose);
    candidate.T_target_source = pair_.toOuter(pose.T_target_source);
    return candidate;
  }

  /// Fill the result from the judged poses, best first, and decide whether the best is accepted. \return how many poses
  /// explain the scans as well as the best, itself included
  std::size_t
  conclude(const std::vector<JudgedPose>& poses)
  {
    const auto listed =
        static_cast<std::ptrdiff_t>(std::min(poses.size(), static_cast<std::size_t>(options_.max_candidates)));
    result_.candidates.clear();
    for (auto pose = poses.begin(); pose != poses.begin() + listed; ++pose)
      result_.candidates.push_back(makeCandidate(*pose));
    const Candidate& best = result_.candidates.front();
    result_.T_target_source = best.T_target_source;
    result_.overlap = best.overlap;
    result_.contradiction = best.contradiction;
    const Refinement polish = poses.front().polish.value_or(Refinement());
    result_.rmse = polish.rms;
    result_.information.setZero();
    if (polish.matches > 0)
      result_.information = uncertaintyOf(polish).informationAbout(-target_.origin);
    const Decision decision = decide(poses, polish, decisionContext());
    result_.confidence = decision.confidence;
    result_.unobservable = decision.unobservable;
    settle(decision.status, decision.message);
    return decision.equals;
  }

  DecisionContext
  decisionContext() const
  {
    DecisionContext context;
    context.min_confidence = options_.min_confidence;
    context.scale = scale_;
    context.noise_floor = kNoiseFloor * scale_;
    context.free_space = pair_.seesFreeSpace();
    context.source_viewpoint = source_.viewpoint;
    context.target_viewpoint = target_.viewpoint;
    context.rotation_prior = priors_.rotationInformation();
    context.guess_decides = guess_decides_;
    context.few_directions = few_directions_;
    return context;
  }

  static constexpr std::size_t kMaxRotations = 24;
  static constexpr std::size_t kFirstRotations = 6;
  static constexpr double kSureConfidence = 0.9;       // what is accepted with less is held against what else there is
  static constexpr double kUnfinishedConfidence = 0.5; // at most, of the best pose when the time ran out
  static constexpr double kClearScore = 0.2;
  static constexpr double kClearShare = 0.65;   // of the matched voices, that contradictions leave of the score
  static constexpr int kSweepSteps = 80;        // 4.5 degrees: half of it is well within reach of the refinement
  static constexpr double kHopelessShare = 0.4; // of a clear best score: what has less is not refined any more
  static constexpr int kBesideRounds = 2;
  static constexpr std::size_t kBesideDirections = 4;
  static constexpr double kSureTurn = 0.0006;    // [rad] standard deviation: what is told better has one place only
  static constexpr double kBesideStrength = 0.4; // of the best told motion: what is told better has one place only
  static constexpr double kBesideDistances[] = {0.15, 0.3}; // [m] at scale 1, of the matched surface
  static constexpr double kBesideShare = 0.85;              // of the score, that a place must have to be refined
  static constexpr double kBesideGain = 1.02;               // of the score, that another place must have when it is
  static constexpr double kPolishedShare = 0.85;            // of the best score: a rival that is polished too
  static constexpr std::size_t kMaxPolished = 4;
  static constexpr double kClearlyNearer = 0.5; // of the distance of the next pose to the guess

  const PatchScan& source_;
  const PatchScan& target_;
  const Options& options_;
  const PatchPair pair_;
  const PosePriors& priors_;
  const double scale_;
  const int threads_;
  std::optional<Eigen::Isometry3d> guess_; ///< inner frames
  std::vector<MainNormal> source_normals_, target_normals_;
  std::string few_directions_; ///< which scan has planes in fewer than two directions; empty: none
  bool guess_orders_ = false;  ///< several poses explain the scans equally well: the one next to the guess goes first
  bool guess_decides_ = false; ///< and is clearly the next one
  bool cut_short_ = false;     ///< the time had run out when the poses were judged last
  StageClock clock_;
  Result result_;
};

} // namespace

Result
registerPatchScans(const PatchScan& source,
                   const PatchScan& target,
                   const Options& options,
                   const Eigen::Isometry3d* guess,
                   const Deadline& deadline)
{
  return PatchRegistration(source, target, options, guess, deadline).run();
}

std::vector<PatchSearch>
repeatSearch(const PatchScan& source, const PatchScan& target, const Options& options)
{
  return PatchRegistration(source, target, options).searches();
}

Candidate
judgePose(const PatchScan& source,
          const PatchScan& target,
          const Eigen::Isometry3d& T_target_source,
          const Options& options,
          bool refine)
{
  return PatchRegistration(source, target, options).judged(T_target_source, refine);
}

VisibilityOptions
judgementOptions(const PatchScan& source, const PatchScan& target, const Options& options)
{
  return PatchPair(source, target, options, nullptr, Deadline()).fineTolerances();
}

} // namespace pcl_ssfr
