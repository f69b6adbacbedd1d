// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/visibility_score.h"

#include "common/place_block.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_ssfr {

namespace {

constexpr double kMinFacingShare = 0.02; // of the visible surface that must face a direction for it to count

} // namespace

Voices&
Voices::operator+=(const Voices& other)
{
  total += other.total;
  matched += other.matched;
  contradicted += other.contradicted;
  return *this;
}

SurfaceEvidence&
SurfaceEvidence::operator+=(const SurfaceEvidence& other)
{
  total += other.total;
  matched += other.matched;
  contradicted += other.contradicted;
  unmatched += other.unmatched;
  matched_normals += other.matched_normals;
  visible_normals += other.visible_normals;
  voices += other.voices;
  facing += other.facing;
  return *this;
}

double
weakestMatchedShare(const SurfaceEvidence& evidence)
{
  if (!(evidence.visible() > 0))
    return 0;
  // min over v of (v' M v) / (v' V v), on the directions that enough surface faces.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> visible(evidence.visible_normals);
  double share = 1;
  Eigen::Matrix3d whitening = Eigen::Matrix3d::Zero();
  int kept = 0;
  for (int k = 0; k < 3; ++k)
    if (visible.eigenvalues()[k] > kMinFacingShare * evidence.visible())
      whitening.col(kept++) = visible.eigenvectors().col(k) / std::sqrt(visible.eigenvalues()[k]);
  if (kept == 0)
    return 0;
  const Eigen::MatrixXd reduced =
      whitening.leftCols(kept).transpose() * evidence.matched_normals * whitening.leftCols(kept);
  share = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(reduced).eigenvalues()[0];
  return std::clamp(share, 0.0, 1.0);
}

SurfaceEvidence
collectEvidence(const OrientedSamples& samples,
                const PatchIndex& index,
                const RangeImage* image,
                const Eigen::Isometry3d& T,
                const VisibilityOptions& options)
{
  SurfaceEvidence evidence;
  const auto faces = [&](Eigen::Index i) {
    return samples.facing.size() == 0 || samples.facing[i] >= options.min_facing;
  };
  PlaceBlock places;
  std::array<int, PlaceBlock::kSize> found;
  for (Eigen::Index first = 0; first < samples.size(); first += PlaceBlock::kSize) {
    places.move(samples.points.col(first).data(),
                samples.normals.col(first).data(),
                std::min<Eigen::Index>(PlaceBlock::kSize, samples.size() - first),
                T);
    places.find(index, options.match, found.data());
    for (std::size_t i = 0; i < places.count; ++i) {
      const double weight = samples.weights[first + static_cast<Eigen::Index>(i)];
      const double voice = std::sqrt(std::sqrt(weight));
      const double facing_voice = faces(first + static_cast<Eigen::Index>(i)) ? voice : 0;
      evidence.total += weight;
      evidence.voices.total += voice;
      evidence.facing.total += facing_voice;
      const Eigen::Vector3d normal = places.normal(i);
      if (found[i] >= 0) {
        evidence.matched += weight;
        evidence.voices.matched += voice;
        evidence.facing.matched += facing_voice;
        evidence.matched_normals.noalias() += weight * normal * normal.transpose();
        continue;
      }
      if (!image)
        continue;
      const Eigen::Vector3f ray = places.place(i).cast<float>() - image->viewpoint();
      const float range = ray.norm();
      if (!(range > 0))
        continue;
      const std::size_t cell = image->cell(ray);
      const float free = image->freeRange(cell);
      if (free == 0)
        continue; // nothing was seen there
      if (range < options.free_ratio * free - options.free_margin) {
        evidence.contradicted += weight;
        evidence.voices.contradicted += voice;
        if (std::abs(ray.cast<double>().dot(normal)) >= options.min_facing * range)
          evidence.facing.contradicted += facing_voice;
      }
      else if (range < options.hidden_ratio * image->farthest(cell) + options.hidden_margin)
        evidence.unmatched += weight;
      else
        continue;
      evidence.visible_normals.noalias() += weight * normal * normal.transpose();
    }
  }
  evidence.visible_normals += evidence.matched_normals;
  return evidence;
}

} // namespace pcl_ssfr
