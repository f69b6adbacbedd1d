// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/visibility_score.h"

#include "common/place_block.h"
#include "judgement/matched_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace pcl_ssfr {

WeightedEvidence&
WeightedEvidence::operator+=(const WeightedEvidence& other)
{
  total += other.total;
  matched += other.matched;
  contradicted += other.contradicted;
  unmatched += other.unmatched;
  beyond += other.beyond;
  return *this;
}

WeightedEvidence&
WeightedEvidence::operator*=(double factor)
{
  total *= factor;
  matched *= factor;
  contradicted *= factor;
  unmatched *= factor;
  beyond *= factor;
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
  patches += other.patches;
  facing += other.facing;
  clutter += other.clutter;
  return *this;
}

SurfaceEvidence
collectEvidence(const OrientedSamples& samples,
                const PatchIndex& index,
                const RangeImage* image,
                const Eigen::Isometry3d& T,
                const VisibilityOptions& options)
{
  SurfaceEvidence evidence;
  const auto faces = [&](Eigen::Index i) { return samples.facing.size() == 0 || samples.facing[i] >= kMinFacing; };
  std::vector<Eigen::Index> matched;
  PlaceBlock places;
  std::array<int, PlaceBlock::kSize> found;
  for (Eigen::Index first = 0; first < samples.size(); first += PlaceBlock::kSize) {
    places.move(samples.points.col(first).data(),
                samples.normals.col(first).data(),
                std::min<Eigen::Index>(PlaceBlock::kSize, samples.size() - first),
                T);
    places.find(index, options.match, found.data());
    for (std::size_t i = 0; i < places.count; ++i) {
      const Eigen::Index sample = first + static_cast<Eigen::Index>(i);
      const double weight = samples.weights[sample], vote = voteOf(weight), facing_vote = faces(sample) ? vote : 0;
      evidence.total += weight;
      evidence.patches.total += vote;
      evidence.facing.total += facing_vote;
      const Eigen::Vector3d normal = places.normal(i);
      if (found[i] >= 0) {
        matched.push_back(sample);
        evidence.matched += weight;
        evidence.patches.matched += vote;
        evidence.facing.matched += facing_vote;
        evidence.matched_normals.noalias() += weight * normal * normal.transpose();
        continue;
      }
      if (!image)
        continue;
      const Eigen::Vector3f ray = places.place(i).cast<float>() - image->viewpoint();
      const float range = ray.norm();
      if (!(range > 0))
        continue;
      const Visibility visibility = visibilityAt(ray, *image, options);
      if (visibility == Visibility::Free) {
        evidence.contradicted += weight;
        evidence.patches.contradicted += vote;
        if (std::abs(ray.cast<double>().dot(normal)) >= kMinFacing * range)
          evidence.facing.contradicted += facing_vote;
      }
      else if (visibility == Visibility::AtDepth) {
        evidence.unmatched += weight;
        evidence.patches.unmatched += vote;
        evidence.facing.unmatched += facing_vote;
      }
    }
  }
  for (const Eigen::Index sample : beyondThreePlanes(samples, std::move(matched), options.match)) {
    const double vote = voteOf(samples.weights[sample]);
    evidence.patches.beyond += vote;
    evidence.facing.beyond += faces(sample) ? vote : 0;
  }
  return evidence;
}

std::size_t
countAtDepth(const Eigen::Matrix3Xf& points, const RangeImage& image, const Eigen::Isometry3d& T, float tolerance)
{
  if (image.empty())
    return 0;
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>() - image.viewpoint();
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3f ray = R * points.col(i) + t;
    const std::size_t cell = image.cell(ray);
    const float range = ray.norm(), farthest = image.farthest(cell); // 0: nothing was seen there
    count += static_cast<std::size_t>(farthest > 0 && range >= image.nearest(cell) - tolerance &&
                                      range <= farthest + tolerance);
  }
  return count;
}

} // namespace pcl_ssfr
