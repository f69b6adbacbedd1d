// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>
#include <apps/methods/pcl_methods.h>

#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/ia_fpcs.h>
#include <pcl/registration/ia_kfpcs.h>

#include <cmath>
#include <cstdlib>

namespace pcl_ssfr {
namespace apps {

namespace {

using Fpcs = pcl::registration::FPCSInitialAlignment<MethodPoint, MethodPoint, MethodPoint>;
using Kfpcs = pcl::registration::KFPCSInitialAlignment<MethodPoint, MethodPoint, MethodPoint>;

/** \brief PCL seeds its congruent sets by the clock. This one drops the first base, which was drawn so, and draws all
 * others from the seed that it is given, on one thread.
 */
template <typename Base>
class Seeded : public Base {
public:
  explicit Seeded(std::uint64_t seed) : seed_(static_cast<unsigned>(seed)) {}

protected:
  int
  bruteForceCorrespondences(int index1, int index2, pcl::Correspondences& pairs) override
  {
    if (started_)
      return Base::bruteForceCorrespondences(index1, index2, pairs);
    std::srand(seed_);
    started_ = true;
    return -1; // no match for this base
  }

private:
  unsigned seed_;
  bool started_ = false;
};

/// Judged by all its points: PCL would draw some by the clock.
class SeededKfpcs : public Seeded<Kfpcs> {
public:
  using Seeded<Kfpcs>::Seeded;

protected:
  bool
  initCompute() override
  {
    const bool ready = Seeded<Kfpcs>::initCompute();
    indices_validation_ = indices_;
    return ready;
  }
};

/// A random part of a cloud, in its order.
MethodCloud::Ptr
sampled(const MethodCloud& cloud, std::size_t count, std::uint64_t seed)
{
  auto sample = pcl::make_shared<MethodCloud>();
  RandomStream random(seed);
  std::size_t wanted = std::min(count, cloud.size());
  for (std::size_t i = 0; i < cloud.size() && wanted > 0; ++i) {
    if (random.uniform() * static_cast<double>(cloud.size() - i) < static_cast<double>(wanted)) {
      sample->push_back(cloud[i]);
      --wanted;
    }
  }
  return sample;
}

MethodCloud::Ptr
keypointsOf(const MethodCloud::Ptr& cloud, const MethodInput& input)
{
  pcl::VoxelGrid<MethodPoint> grid;
  const auto leaf = static_cast<float>(input.scales.keypoint_leaf);
  grid.setLeafSize(leaf, leaf, leaf);
  grid.setInputCloud(cloud);
  auto keypoints = pcl::make_shared<MethodCloud>();
  grid.filter(*keypoints);
  return keypoints;
}

template <typename Method>
void
setCommon(Method& method, const MethodInput& input)
{
  method.setNumberOfThreads(1); // more would draw from one sequence of random numbers in any order
  method.setApproxOverlap(static_cast<float>(input.rule.expected_overlap));
  method.setMaxComputationTime(static_cast<int>(std::ceil(input.rule.max_seconds)));
}

} // namespace

MethodRegistration::Ptr
makeFpcs(const MethodInput& input)
{
  auto method = pcl::make_shared<Seeded<Fpcs>>(input.seed);
  setCommon(*method, input);
  method->setInputSource(sampled(*input.source, static_cast<std::size_t>(input.rule.fpcs_samples), input.seed));
  method->setInputTarget(input.target);
  method->setDelta(static_cast<float>(input.scales.threshold), false);
  return method;
}

MethodRegistration::Ptr
makeKfpcs(const MethodInput& input)
{
  auto method = pcl::make_shared<SeededKfpcs>(input.seed);
  setCommon(*method, input);
  method->setInputSource(keypointsOf(input.source, input));
  method->setInputTarget(keypointsOf(input.target, input));
  method->setDelta(static_cast<float>(input.scales.threshold), false);
  return method;
}

} // namespace apps
} // namespace pcl_ssfr
