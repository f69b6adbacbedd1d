// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "common/stage_clock.h"
#include "directions/mean_shift.h"
#include "profiles/patch_pair.h"
#include "search/pose_search.h"
#include "search/rotation_candidates.h"

#include <pcl_ssfr/search_trace.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ssfr {

/// Poses to be refined together: between the inner frames.
struct HypothesisBatch {
  std::vector<Eigen::Isometry3d> poses; ///< most votes first
  bool has_guess = false;               ///< the last of them is the caller's guess
  std::size_t distinct = 0;             ///< so many distinct ones are worth the fine refinement
};

/** \brief Where hypotheses about the pose of a pair come from (METHOD stages 6 to 12): in batches, the most promising
 * first, each made only when it is asked for.
 *
 * First the poses with most votes, with the guess; then the others of that pass; then a pass for scans that share
 * little; last poses under which one direction only of the scans agrees. A new kind of hypothesis is a new batch in
 * next().
 */
class HypothesisSource {
public:
  /// \param[in] pair must outlive it
  /// \param[in] guess between the inner frames, may be absent
  /// \param[in] stages where what was done is reported
  /// \param[in,out] trace may be null
  HypothesisSource(const PatchPair& pair,
                   const std::optional<Eigen::Isometry3d>& guess,
                   StageLog& stages,
                   SearchTrace* trace);

  /// The next batch; none when there is nothing left to try. May be empty.
  std::optional<HypothesisBatch>
  next();

  /// Main normals with the vertical where it is given.
  const std::vector<MainNormal>&
  sourceNormals() const
  {
    return source_normals_;
  }
  const std::vector<MainNormal>&
  targetNormals() const
  {
    return target_normals_;
  }
  /// Rotations that are searched, best supported first.
  const std::vector<RotationCandidate>&
  rotations() const
  {
    return rotations_;
  }
  /// Which scan has planes in fewer than two directions, for people; empty: neither.
  const std::string&
  fewDirections() const
  {
    return few_directions_;
  }
  /// How translations are searched in a pass.
  PoseSearchOptions
  searchOptions(const SearchPass& pass) const;

private:
  /// What a batch is made of, in order; a stage that has nothing leaves its turn to the next one.
  enum class Stage {
    MostVotes,     ///< the pass for scans that share much: the promising poses, and the guess
    OtherVotes,    ///< ... and the others of that pass
    LittleOverlap, ///< the pass for scans that share little
    Plans,         ///< poses under which one direction only agrees
    Done
  };

  HypothesisBatch
  searchMostVotes();
  std::vector<RotationCandidate>
  proposeRotations() const;
  std::vector<PoseHypothesis>
  searchTranslations(const SearchPass& pass);
  std::vector<PoseHypothesis>
  searchTranslationsOfAll(PoseSearchOptions options) const;
  HypothesisBatch
  takeBatch(std::size_t end, const SearchPass& pass);
  HypothesisBatch
  searchPlans() const;

  const PatchPair& pair_;
  std::optional<Eigen::Isometry3d> guess_;
  StageLog& stages_;
  SearchTrace* trace_;
  std::vector<MainNormal> source_normals_, target_normals_;
  std::string few_directions_;
  std::vector<RotationCandidate> rotations_;
  std::vector<PoseHypothesis> hypotheses_; ///< of the current pass, most votes first
  std::size_t taken_ = 0;                  ///< of these
  Stage stage_ = Stage::MostVotes;         ///< that next() tries first
};

} // namespace pcl_ssfr
