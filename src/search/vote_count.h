// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include "judgement/visibility_score.h"
#include "preparation/patch_index.h"
#include "preparation/range_image.h"
#include "search/pose_search.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace pcl_ssfr {

constexpr Eigen::Index kScreeningStride = 8; ///< every so many votes are counted first

/// Votes for poses that differ only by their translation.
class VoteCounter {
public:
  VoteCounter(const VotingSamples& votes,
              const PatchIndex& index,
              const RangeImage* image,
              const Eigen::Matrix3d& R,
              const VisibilityOptions& options)
      : index_(index), image_(image), options_(options)
  {
    const Eigen::Matrix3f rotation = R.cast<float>();
    const auto add = [&](bool screened) {
      for (Eigen::Index i = 0; i < votes.points.cols(); ++i)
        if ((i % kScreeningStride == 0) == screened)
          probes_.add(rotation * votes.points.col(i), rotation * votes.normals.col(i));
      return probes_.x.size();
    };
    screened_ = add(true);
    add(false);
  }

  Eigen::Index
  size() const
  {
    return static_cast<Eigen::Index>(probes_.x.size());
  }

  /// How many samples are screened.
  std::size_t
  screened() const
  {
    return screened_;
  }

  /// Votes for each of some translations among the samples that are screened, every kScreeningStride-th.
  std::vector<int>
  screen(const ShiftLine& line) const
  {
    return index_.countFacingAlong(line, probes_, 0, screened_);
  }
  /// And for one among the others.
  int
  otherVotesFor(const Eigen::Vector3f& t) const
  {
    return index_.countFacing(probes_, screened_, probes_.x.size(), t);
  }
  /// Votes for the translation among all.
  int
  votesFor(const Eigen::Vector3f& t) const
  {
    return index_.countFacing(probes_, 0, probes_.x.size(), t);
  }

  /// The same. \param[out] facing of size() elements: 1 for a vote for it, else 0
  int
  findVotesFor(const Eigen::Vector3f& t, std::vector<std::int32_t>& facing) const
  {
    index_.findFacing(probes_, 0, probes_.x.size(), t, facing.data());
    return std::accumulate(facing.begin(), facing.end(), 0);
  }
  /// Samples that hang in the free space of the target. Counting ends when there are more than \p most.
  /// \param[in] facing of findVotesFor()
  int
  votesAgainst(const Eigen::Vector3f& t, const std::vector<std::int32_t>& facing, double most) const
  {
    if (!image_)
      return 0;
    const std::size_t end = probes_.x.size();
    int votes = 0;
    std::array<float, kBatchSize> x, y, z;
    std::array<std::int32_t, kBatchSize> free;
    for (std::size_t first = 0; first < end && votes <= most; first += kBatchSize) {
      const std::size_t n = std::min(kBatchSize, end - first);
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = probes_.x[first + i] + t.x();
        y[i] = probes_.y[first + i] + t.y();
        z[i] = probes_.z[first + i] + t.z();
      }
      image_->findFree({x.data(), y.data(), z.data()}, n, options_.free_ratio, options_.free_margin, free.data());
      for (std::size_t i = 0; i < n; ++i)
        votes += free[i] & ~facing[first + i];
    }
    return votes;
  }

private:
  const PatchIndex& index_;
  const RangeImage* image_;
  const VisibilityOptions& options_;
  PatchIndex::Probes probes_; ///< first those that are screened
  std::size_t screened_ = 0;
};

/// A translation and how the samples voted on it.
struct VotedTranslation {
  Eigen::Vector3f translation; ///< [m]
  int votes = 0;               ///< for it
  double score = 0;            ///< what they say for it, see below
};

/// The shifts of a line that have the most votes, of those around them and not far below the best of all. They score
/// by the votes for them, less the weighted votes against them.
/// \param[in,out] best_screened votes of the best of all among those that are screened
void
findMostVoted(const VoteCounter& counter,
              const ShiftLine& line,
              const SearchConfig& config,
              int& best_screened,
              std::vector<VotedTranslation>& found);

/** \brief The shifts of a line that have votes. They score by the votes for them over those against them, and one.
 * \param[in] least_score what scores less than this, as a share of all votes, is left out. Every second shift must have
 * SearchConfig::screening_share of it for those around it to be looked at
 */
void
findLeastContradicted(const VoteCounter& counter,
                      const ShiftLine& line,
                      const SearchConfig& config,
                      double least_score,
                      std::vector<VotedTranslation>& found);

} // namespace pcl_ssfr
