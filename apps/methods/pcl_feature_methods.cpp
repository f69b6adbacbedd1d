// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/methods/pcl_methods.h>

#include <pcl/features/fpfh_omp.h>
#include <pcl/registration/ia_ransac.h>
#include <pcl/registration/sample_consensus_prerejective.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <cstdlib>

namespace pcl_ssfr {
namespace apps {

namespace {

using Feature = pcl::FPFHSignature33;
using Features = pcl::PointCloud<Feature>;

// Settings of PCL's tutorials that have no length.
constexpr int kRansacSamples = 3;
constexpr int kRansacRandomness = 5;        ///< nearest features to choose from
constexpr float kRansacSimilarity = 0.9F;   ///< of edge lengths
constexpr float kRansacInlierShare = 0.25F; ///< below it there is no answer
constexpr int kSacIaRandomness = 10;        ///< nearest features to choose from
constexpr float kSacIaSampleDistance = 10;  ///< between samples [leafs]

Features::Ptr
featuresOf(const MethodCloud::Ptr& cloud, const MethodInput& input)
{
  pcl::FPFHEstimationOMP<MethodPoint, MethodPoint, Feature> estimation(input.threads);
  estimation.setInputCloud(cloud);
  estimation.setInputNormals(cloud);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<MethodPoint>>());
  estimation.setRadiusSearch(input.scales.feature_radius);
  auto features = pcl::make_shared<Features>();
  estimation.compute(*features);
  for (Feature& feature : *features) // PCL leaves NaN where a point has no neighbour
    for (float& value : feature.histogram)
      if (!std::isfinite(value))
        value = 0;
  return features;
}

/// Clouds and features, and the random numbers of PCL, which are those of the process.
template <typename Method>
void
setInput(Method& method, const MethodInput& input)
{
  std::srand(static_cast<unsigned>(input.seed));
  method.setInputSource(input.source);
  method.setInputTarget(input.target);
  method.setSourceFeatures(featuresOf(input.source, input));
  method.setTargetFeatures(featuresOf(input.target, input));
}

} // namespace

MethodRegistration::Ptr
makeFpfhRansac(const MethodInput& input)
{
  auto method = pcl::make_shared<pcl::SampleConsensusPrerejective<MethodPoint, MethodPoint, Feature>>();
  setInput(*method, input);
  method->setMaximumIterations(static_cast<int>(input.rule.ransac_iterations));
  method->setNumberOfSamples(kRansacSamples);
  method->setCorrespondenceRandomness(kRansacRandomness);
  method->setSimilarityThreshold(kRansacSimilarity);
  method->setMaxCorrespondenceDistance(input.scales.threshold);
  method->setInlierFraction(kRansacInlierShare);
  return method;
}

MethodRegistration::Ptr
makeFpfhSacIa(const MethodInput& input)
{
  auto method = pcl::make_shared<pcl::SampleConsensusInitialAlignment<MethodPoint, MethodPoint, Feature>>();
  setInput(*method, input);
  method->setMaximumIterations(static_cast<int>(input.rule.sac_ia_iterations));
  method->setCorrespondenceRandomness(kSacIaRandomness);
  method->setMinSampleDistance(kSacIaSampleDistance * static_cast<float>(input.scales.leaf));
  method->setMaxCorrespondenceDistance(input.scales.threshold);
  return method;
}

} // namespace apps
} // namespace pcl_ssfr
