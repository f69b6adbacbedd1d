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
#include <limits>
#include <vector>

namespace pcl_ssfr {

// Every so many votes are counted first of all, and more as long as they are this share of the best count so far.
constexpr Eigen::Index kGlanceStride = 8;
constexpr double kGlanceShare = 0.1;
constexpr Eigen::Index kScreeningStride = 4;
constexpr double kScreeningShare = 0.5;
static_assert(kGlanceStride % kScreeningStride == 0);
// Where little overlaps:
constexpr double kLeastShare = 0.05; // of the votes that must be for a pose
constexpr int kGlancedAgainst = 2;   // votes against it at the first glance that no pose survives

/// Votes for poses that differ only by their translation.
class Ballot {
public:
  Ballot(const VotingSamples& votes,
         const PatchIndex& index,
         const RangeImage* image,
         const Eigen::Matrix3d& R,
         const VisibilityOptions& options)
      : index_(index), image_(image), options_(options)
  {
    const Eigen::Matrix3f rotation = R.cast<float>();
    // Every stride-th of the samples, those of the stride before left out; 0: none came before.
    const auto add = [&](Eigen::Index stride, Eigen::Index before) {
      for (Eigen::Index i = 0; i < votes.points.cols(); i += stride)
        if (before == 0 || i % before != 0)
          probes_.add(rotation * votes.points.col(i), rotation * votes.normals.col(i));
      return probes_.x.size();
    };
    glanced_ = add(kGlanceStride, 0);
    screened_ = add(kScreeningStride, kGlanceStride);
    add(1, kScreeningStride);
  }

  Eigen::Index
  size() const
  {
    return static_cast<Eigen::Index>(probes_.x.size());
  }

  /// Votes for each of some translations at a first glance, among every kGlanceStride-th of the samples.
  std::vector<int>
  glance(const ShiftLine& line) const
  {
    return index_.countFacingAlong(line, probes_, 0, glanced_);
  }

  /// Votes for the translation among every kScreeningStride-th of the samples; 0 when those of the first glance,
  /// \p glanced, are far fewer than \p best.
  int
  screenedVotesFor(const Eigen::Vector3f& t, int glanced, int best) const
  {
    if (glanced * static_cast<double>(screened_) < kGlanceShare * best * static_cast<double>(glanced_))
      return 0;
    return glanced + index_.countFacing(probes_, glanced_, screened_, t);
  }
  /// And among the others.
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

  /// Whether the translation has the least share of the votes among those that are screened, and next to none against
  /// it among those of the first glance, of which \p glanced are for it.
  bool
  isWorthCounting(const Eigen::Vector3f& t, int glanced) const
  {
    return glanced > 0 &&
           glanced + index_.countFacing(probes_, glanced_, screened_, t) >=
               kLeastShare * static_cast<double>(screened_) &&
           votesAgainst(t, glanced_, kGlancedAgainst) < kGlancedAgainst;
  }

  /// Samples that hang in the free space of the target; counting ends at \p most.
  int
  votesAgainst(const Eigen::Vector3f& t, int most = std::numeric_limits<int>::max()) const
  {
    return votesAgainst(t, probes_.x.size(), most);
  }

private:
  /// The same among the first \p end.
  int
  votesAgainst(const Eigen::Vector3f& t, std::size_t end, int most) const
  {
    if (!image_)
      return 0;
    int votes = 0;
    std::array<float, kCounted> x, y, z;
    std::array<std::int32_t, kCounted> facing, free;
    for (std::size_t first = 0; first < end && votes < most; first += kCounted) {
      const std::size_t n = std::min(kCounted, end - first);
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = probes_.x[first + i] + t.x();
        y[i] = probes_.y[first + i] + t.y();
        z[i] = probes_.z[first + i] + t.z();
      }
      index_.findFacing(probes_, first, first + n, t, facing.data());
      image_->findFree({x.data(), y.data(), z.data()}, n, options_.free_ratio, options_.free_margin, free.data());
      for (std::size_t i = 0; i < n; ++i)
        votes += free[i] & ~facing[i];
    }
    return std::min(votes, most);
  }

  static constexpr std::size_t kCounted = 32; // votes against at once

  const PatchIndex& index_;
  const RangeImage* image_;
  const VisibilityOptions& options_;
  PatchIndex::Probes probes_; ///< first those of the first glance, then the others that are screened
  std::size_t glanced_ = 0;
  std::size_t screened_ = 0;
};

/// A translation and how the samples voted on it.
struct Verdict {
  Eigen::Vector3f translation; ///< [m]
  int votes = 0;               ///< for it
  double score = 0;            ///< votes for it, less the weighted votes against it
};

/// The shifts of a line that have the most votes, of those around them and not far below the best of all.
/// \param[in,out] best_screened votes of the best of all among those that are screened, of every kScreeningStride-th
/// sample
void
findMostVoted(const Ballot& ballot,
              const ShiftLine& line,
              double contradiction_weight,
              int& best_screened,
              std::vector<Verdict>& found);

/// The shifts of a line that have enough votes, and more than the weighted ones against them.
void
findUncontradicted(const Ballot& ballot,
                   const ShiftLine& line,
                   double contradiction_weight,
                   std::vector<Verdict>& found);

} // namespace pcl_ssfr
