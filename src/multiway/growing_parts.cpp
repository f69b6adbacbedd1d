// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/growing_parts.h"

#include "multiway/parts.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace pcl_ssfr {

namespace {

constexpr double kGrowth = 1.2; // of a part, after which its poses are adjusted again

} // namespace

GrowingParts::GrowingParts(const std::vector<PairLink>& links,
                           const HypothesisGraph& graph,
                           const std::vector<Eigen::Vector3d>& places,
                           const ChoiceConfig& config)
    : links_(links), graph_(graph), places_(places), config_(config), adjusted_size_(places.size(), 1)
{
  const std::size_t n = places.size();
  assembly_.part.resize(n);
  std::iota(assembly_.part.begin(), assembly_.part.end(), 0);
  assembly_.poses.assign(n, Eigen::Isometry3d::Identity());
  assembly_.used.assign(links.size(), -1);
  assembly_.refusal.resize(links.size());
  members_.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    members_[i] = {static_cast<int>(i)};
}

Eigen::Vector3d
GrowingParts::placeOf(int part) const
{
  const int first = members(part).front();
  return pose(first) * places_[static_cast<std::size_t>(first)];
}

std::vector<PlacedPair>
GrowingParts::pairsAt(int a, int b, const Eigen::Isometry3d& T_b_a, const PairTest& left_out) const
{
  return pairsBetween(members(a), members(b), T_b_a, assembly_.poses, places_, left_out);
}

void
GrowingParts::merge(int a, int b, const Eigen::Isometry3d& T_b_a)
{
  auto from = static_cast<std::size_t>(a);
  auto into = static_cast<std::size_t>(b);
  Eigen::Isometry3d T = T_b_a;
  if (members_[from].size() > members_[into].size()) {
    std::swap(from, into);
    T = T.inverse();
  }
  for (const int scan : members_[from]) {
    auto& its = assembly_.poses[static_cast<std::size_t>(scan)];
    its = T * its;
    assembly_.part[static_cast<std::size_t>(scan)] = static_cast<int>(into);
  }
  members_[into].insert(members_[into].end(), members_[from].begin(), members_[from].end());
  std::sort(members_[into].begin(), members_[into].end());
  members_[from].clear();
  if (static_cast<double>(members_[into].size()) >= kGrowth * static_cast<double>(adjusted_size_[into]))
    adjust(into);
}

void
GrowingParts::adjustAll()
{
  for (std::size_t part = 0; part < members_.size(); ++part)
    if (members_[part].size() > 1)
      adjust(part);
}

void
GrowingParts::adjust(std::size_t part)
{
  chooseLinks(assembly_, links_, graph_, places_, config_);
  adjustPart(assembly_, static_cast<int>(part), links_, places_);
  adjusted_size_[part] = members_[part].size();
}

} // namespace pcl_ssfr
