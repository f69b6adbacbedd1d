// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/lost_stage.h>

#include <pcl_ssfr/pipeline.h>

#include <apps/methods/cloud_view.h>
#include <apps/methods/file_frames.h>

#include <algorithm>
#include <iterator>
#include <vector>

namespace pcl_ssfr {
namespace apps {

namespace {

constexpr SuccessBound kReach{5, 1}; ///< from within it, a refinement leads to the pose

class Loss {
public:
  explicit Loss(const LostSearch& search) : search_(search) {}

  bool
  isRight(const Eigen::Isometry3d& T_target_source) const
  {
    return isWithin(errorOf(T_target_source), search_.bound);
  }

  bool
  isAnswerRight(const Result& result) const
  {
    return !result.candidates.empty() && isRight(result.T_target_source);
  }

  bool
  isRightFound(const Result& result) const
  {
    return std::any_of(result.candidates.begin(), result.candidates.end(), [&](const Candidate& candidate) {
      return isRight(candidate.T_target_source);
    });
  }

  /// Whether a rotation near the true one was searched, by which plan views count as well: they propose their own.
  bool
  isRotationProposed() const
  {
    const auto isNear = [&](const Eigen::Matrix3d& R) {
      Eigen::Isometry3d T = search_.truth;
      T.linear() = R;
      return errorOf(T).rotation_deg <= kReach.rotation_deg;
    };
    const auto ofPass = [&](const TracedPass& pass) {
      return std::any_of(pass.rotations.begin(), pass.rotations.end(), isNear);
    };
    const auto ofPlan = [&](const TracedHypothesis& pose) { return isNear(pose.T_target_source.linear()); };
    const SearchTrace& trace = search_.trace;
    return std::any_of(trace.passes.begin(), trace.passes.end(), ofPass) ||
           std::any_of(trace.plan_hypotheses.begin(), trace.plan_hypotheses.end(), ofPlan);
  }

  /// All proposed poses near the truth.
  std::vector<TracedHypothesis>
  proposedNear() const
  {
    std::vector<TracedHypothesis> near;
    const auto take = [&](const std::vector<TracedHypothesis>& poses) {
      std::copy_if(poses.begin(), poses.end(), std::back_inserter(near), [&](const TracedHypothesis& pose) {
        return isWithin(errorOf(pose.T_target_source), kReach);
      });
    };
    for (const TracedPass& pass : search_.trace.passes)
      take(pass.hypotheses);
    take(search_.trace.plan_hypotheses);
    return near;
  }

private:
  PoseError
  errorOf(const Eigen::Isometry3d& T_target_source) const
  {
    return poseError(T_target_source, search_.truth, search_.reference);
  }

  const LostSearch& search_;
};

} // namespace

std::string
lostStage(const LostSearch& search)
{
  const Loss loss(search);
  if (loss.isAnswerRight(search.result))
    return "";
  if (search.result.candidates.empty() && search.trace.passes.empty() && search.trace.plan_hypotheses.empty())
    return "preparation";
  if (loss.isRightFound(search.result) || !loss.isAnswerRight(search.from_truth))
    return "evidence";
  if (!loss.isRotationProposed())
    return "rotation";
  const std::vector<TracedHypothesis> near = loss.proposedNear();
  if (near.empty())
    return "translation";
  return std::any_of(near.begin(), near.end(), [](const TracedHypothesis& pose) { return pose.refined; })
             ? "refinement"
             : "not refined";
}

std::string
findLostStage(const PairInput& pair, const Options& options, const SuccessBound& bound)
{
  if (!pair.T_target_source)
    return "";
  const FileFrames frames(pair.source.offset, pair.target.offset);
  const auto [source, target] = prepareScans(viewOf(pair.source), viewOf(pair.target), options);
  LostSearch search;
  search.truth = frames.toClouds(*pair.T_target_source);
  search.reference = pair.reference - pair.source.offset;
  search.bound = bound;
  const Deadline deadline = Deadline::after(options.time_limit);
  search.result = registerScans(source, target, options, nullptr, deadline, &search.trace);
  search.from_truth = registerScans(source, target, options, &search.truth);
  return lostStage(search);
}

} // namespace apps
} // namespace pcl_ssfr
