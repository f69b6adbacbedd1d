// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "judgement/visibility_score.h"

#include "common/place_block.h"
#include "common/vector_clones.h"
#include "judgement/matched_planes.h"
#include "preparation/sight_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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

namespace {

/// Where the places of a block lie in what a sensor saw, and what they weigh.
struct SeenBlock {
  SightBlock sight;
  std::array<Visibility, SightBlock::kSize> visibility;
  std::array<double, SightBlock::kSize> votes;

  PCL_SSFR_VECTOR_CLONES void
  look(const PlaceBlock& places, const RangeImage& image, const VisibilityOptions& options)
  {
    static_assert(PlaceBlock::kSize == SightBlock::kSize);
    sight.look(std::array{places.x.data(), places.y.data(), places.z.data()},
               1,
               places.count,
               image.viewpoint(),
               image.grid());
    for (std::size_t i = 0; i < places.count; ++i) {
      const auto cell = static_cast<std::size_t>(sight.cells[i]);
      const Visibility seen = visibilityAt(sight.range[i], image.freeRange(cell), image.farthest(cell), options);
      visibility[i] = sight.range[i] > 0 ? seen : Visibility::Unseen; // the sensor has no direction
    }
  }
  PCL_SSFR_VECTOR_CLONES void
  weigh(const double* weights, std::size_t count)
  {
    for (std::size_t i = 0; i < count; ++i)
      votes[i] = voteOf(weights[i]);
  }
};

} // namespace

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
  SeenBlock seen;
  std::array<int, PlaceBlock::kSize> found;
  for (Eigen::Index first = 0; first < samples.size(); first += PlaceBlock::kSize) {
    places.move(samples.points.col(first).data(),
                samples.normals.col(first).data(),
                std::min<Eigen::Index>(PlaceBlock::kSize, samples.size() - first),
                T);
    places.find(index, options.match, found.data());
    seen.weigh(samples.weights.data() + first, places.count);
    if (image)
      seen.look(places, *image, options);
    for (std::size_t i = 0; i < places.count; ++i) {
      const Eigen::Index sample = first + static_cast<Eigen::Index>(i);
      const double weight = samples.weights[sample], vote = seen.votes[i], facing_vote = faces(sample) ? vote : 0;
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
      if (seen.visibility[i] == Visibility::Free) {
        evidence.contradicted += weight;
        evidence.patches.contradicted += vote;
        const Eigen::Vector3d ray = Eigen::Vector3f(seen.sight.x[i], seen.sight.y[i], seen.sight.z[i]).cast<double>();
        if (std::abs(ray.dot(normal)) >= kMinFacing * seen.sight.range[i])
          evidence.facing.contradicted += facing_vote;
      }
      else if (seen.visibility[i] == Visibility::AtDepth) {
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

namespace {

/// Of \p count points from \p coordinates on, moved into what is seen from the viewpoint of \p image.
PCL_SSFR_VECTOR_CLONES std::size_t
countBlockAtDepth(SightBlock& sight,
                  const float* coordinates,
                  std::size_t count,
                  const RangeImage& image,
                  const Eigen::Matrix3f& R,
                  const Eigen::Vector3f& t,
                  float tolerance)
{
  const std::array<float, 9> r = {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)};
  for (std::size_t i = 0; i < count; ++i) {
    const float* const p = coordinates + 3 * i;
    sight.x[i] = r[0] * p[0] + (r[1] * p[1] + r[2] * p[2]) + t.x();
    sight.y[i] = r[3] * p[0] + (r[4] * p[1] + r[5] * p[2]) + t.y();
    sight.z[i] = r[6] * p[0] + (r[7] * p[1] + r[8] * p[2]) + t.z();
  }
  sight.locate(count, image.grid());
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto cell = static_cast<std::size_t>(sight.cells[i]);
    const float range = sight.range[i], farthest = image.farthest(cell); // 0: nothing was seen there
    sum += static_cast<std::int32_t>(farthest > 0) &
           static_cast<std::int32_t>(range >= image.nearest(cell) - tolerance) &
           static_cast<std::int32_t>(range <= farthest + tolerance);
  }
  return static_cast<std::size_t>(sum);
}

} // namespace

std::size_t
countAtDepth(const Eigen::Matrix3Xf& points, const RangeImage& image, const Eigen::Isometry3d& T, float tolerance)
{
  if (image.empty())
    return 0;
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>() - image.viewpoint();
  const auto all = static_cast<std::size_t>(points.cols());
  SightBlock sight;
  std::size_t count = 0;
  for (std::size_t first = 0; first < all; first += SightBlock::kSize)
    count += countBlockAtDepth(
        sight, points.data() + 3 * first, std::min(SightBlock::kSize, all - first), image, R, t, tolerance);
  return count;
}

} // namespace pcl_ssfr
