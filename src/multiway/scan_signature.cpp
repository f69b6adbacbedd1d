// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/scan_signature.h"

#include "directions/scene_directions.h"

#include <cmath>

namespace pcl_ssfr {

Eigen::VectorXf
signatureOf(const VotingSamples& votes, double scale, const MultiwayOptions& options)
{
  const PatchProfileConfig& config = options.registration.patch_profile;
  const double width = config.preparation.match; // of a bin, as in the histograms of a pair
  const auto bins = static_cast<Eigen::Index>(std::ceil(options.candidates.reach / width));
  const float per_length = static_cast<float>(1 / (width * scale));
  const auto parallel = static_cast<float>(parallelCos(config.search));
  Eigen::VectorXf sums = Eigen::VectorXf::Zero(bins + 1);
  for (Eigen::Index i = 0; i < votes.points.cols(); ++i)
    for (Eigen::Index k = i + 1; k < votes.points.cols(); ++k) {
      if (std::abs(votes.normals.col(i).dot(votes.normals.col(k))) < parallel)
        continue;
      const Eigen::Vector3f way = votes.points.col(k) - votes.points.col(i);
      const float across = 0.5f * (std::abs(way.dot(votes.normals.col(i))) + std::abs(way.dot(votes.normals.col(k))));
      const float at = across * per_length;
      if (!(at < static_cast<float>(bins)))
        continue;
      // Shared between the next two bins, so that a little does not move it from one into another.
      const float bin = std::floor(at);
      sums[static_cast<Eigen::Index>(bin)] += 1 - (at - bin);
      sums[static_cast<Eigen::Index>(bin) + 1] += at - bin;
    }
  const float sum = sums.sum();
  return sum > 0 ? Eigen::VectorXf((sums / sum).cwiseSqrt()) : sums;
}

ScanLikeness::ScanLikeness(const std::vector<Eigen::VectorXf>& signatures)
{
  if (signatures.empty())
    return;
  columns_.resize(signatures.front().size(), static_cast<Eigen::Index>(signatures.size()));
  Eigen::VectorXf mean = Eigen::VectorXf::Zero(columns_.rows());
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < signatures.size(); ++i) {
    columns_.col(static_cast<Eigen::Index>(i)) = signatures[i];
    if (!signatures[i].isZero(0)) {
      mean += signatures[i];
      ++count;
    }
  }
  if (count > 0)
    mean /= static_cast<float>(count);
  for (Eigen::Index i = 0; i < columns_.cols(); ++i) {
    auto column = columns_.col(i);
    if (column.isZero(0))
      continue;
    column -= mean;
    const float length = column.norm();
    column *= length > 0 ? 1 / length : 0.f;
  }
}

Eigen::VectorXf
ScanLikeness::of(std::size_t scan) const
{
  return columns_.transpose() * columns_.col(static_cast<Eigen::Index>(scan));
}

} // namespace pcl_ssfr
