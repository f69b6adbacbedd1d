// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/rival_groups.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace pcl_ssfr {

namespace {

double
median(std::vector<double> values)
{
  const auto upper = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), upper, values.end());
  return values.size() % 2 == 1 ? *upper : (*upper + *std::max_element(values.begin(), upper)) / 2;
}

/// By how many standard deviations the ranks of \p larger are above those of \p smaller (Mann and Whitney); both
/// sorted.
double
rankDeviation(const std::vector<double>& larger, const std::vector<double>& smaller)
{
  double wins = 0; // pairs of values whose first is larger, those that are equal count half
  for (const double value : larger) {
    const auto [low, high] = std::equal_range(smaller.begin(), smaller.end(), value);
    wins += static_cast<double>((low - smaller.begin()) + (high - smaller.begin())) / 2;
  }
  const auto a = static_cast<double>(larger.size());
  const auto b = static_cast<double>(smaller.size());
  return (wins - a * b / 2) / std::sqrt(a * b * (a + b + 1) / 12);
}

class Clustering {
public:
  Clustering(const std::vector<int>& members,
             const std::vector<std::pair<int, int>>& pairs,
             const std::vector<PlacementEvidence>& evidence,
             const RivalGroupsConfig& config,
             const std::vector<int>& tied)
      : config_(config), members_(members)
  {
    const auto n = static_cast<Eigen::Index>(members.size());
    in_view_ = seen_through_ = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (evidence[k].in_view <= 0 || evidence[k].matched < config.least_matched * evidence[k].total)
        continue;
      const Eigen::Index i = indexOf(pairs[k].first);
      const Eigen::Index j = indexOf(pairs[k].second);
      in_view_(i, j) = in_view_(j, i) = evidence[k].in_view;
      seen_through_(i, j) = seen_through_(j, i) = evidence[k].seen_through;
    }
    between_in_view_ = in_view_;
    between_seen_through_ = seen_through_;
    for (Eigen::Index i = 0; i < n; ++i)
      clusters_.push_back({i});
    const auto isTied = [&](std::size_t a, std::size_t b) {
      return tied[static_cast<std::size_t>(members[a])] == tied[static_cast<std::size_t>(members[b])];
    };
    for (std::size_t a = 0; a < members.size() && !tied.empty(); ++a)
      for (std::size_t b = a + 1; b < members.size() && !clusters_[a].empty(); ++b)
        if (isTied(a, b))
          join(a, b);
  }

  std::optional<RivalGroups>
  run()
  {
    while (const auto next = closest()) {
      const auto [a, b] = *next;
      if (auto rivals = compare(clusters_[a], clusters_[b]))
        return rivals;
      join(a, b);
    }
    return std::nullopt;
  }

private:
  using Cluster = std::vector<Eigen::Index>;

  Eigen::Index
  indexOf(int scan) const
  {
    return std::lower_bound(members_.begin(), members_.end(), scan) - members_.begin();
  }

  /// The two clusters, the smaller number first, of which the least is seen through; none: no two meet.
  std::optional<std::pair<std::size_t, std::size_t>>
  closest() const
  {
    std::optional<std::pair<std::size_t, std::size_t>> best;
    double least = 0;
    for (std::size_t a = 0; a < clusters_.size(); ++a)
      for (std::size_t b = a + 1; b < clusters_.size() && !clusters_[a].empty(); ++b) {
        const auto i = static_cast<Eigen::Index>(a);
        const auto j = static_cast<Eigen::Index>(b);
        if (clusters_[b].empty() || between_in_view_(i, j) <= 0)
          continue;
        const double rate = (between_seen_through_(i, j) + config_.seen_through * config_.prior_patches) /
                            (between_in_view_(i, j) + config_.prior_patches);
        if (!best || rate < least) {
          best = {a, b};
          least = rate;
        }
      }
    return best;
  }

  void
  join(std::size_t a, std::size_t b)
  {
    const auto i = static_cast<Eigen::Index>(a);
    const auto j = static_cast<Eigen::Index>(b);
    for (Eigen::MatrixXd* sums : {&between_in_view_, &between_seen_through_}) {
      sums->row(i) += sums->row(j);
      sums->col(i) += sums->col(j);
    }
    clusters_[a].insert(clusters_[a].end(), clusters_[b].begin(), clusters_[b].end());
    clusters_[b].clear();
  }

  /// The share of what is in view that is seen through, of all pairs of two clusters, or of one with itself; sorted.
  std::vector<double>
  rates(const Cluster& a, const Cluster& b) const
  {
    std::vector<double> found;
    for (const Eigen::Index i : a)
      for (const Eigen::Index j : b)
        if (in_view_(i, j) > 0 && (&a != &b || i < j))
          found.push_back(seen_through_(i, j) / in_view_(i, j));
    std::sort(found.begin(), found.end());
    return found;
  }

  std::optional<RivalGroups>
  compare(const Cluster& a, const Cluster& b) const
  {
    if (a.size() < 2 || b.size() < 2)
      return std::nullopt;
    const std::vector<double> between = rates(a, b);
    std::vector<double> within = rates(a, a);
    const std::vector<double> others = rates(b, b);
    within.insert(within.end(), others.begin(), others.end());
    std::sort(within.begin(), within.end());
    RivalGroups groups;
    groups.within = median(within);
    groups.between = median(between);
    if (groups.between < std::max(config_.seen_through, config_.ratio * groups.within) ||
        rankDeviation(between, within) < config_.significance)
      return std::nullopt;
    const auto scans = [&](const Cluster& cluster) {
      std::vector<int> list;
      for (const Eigen::Index i : cluster)
        list.push_back(members_[static_cast<std::size_t>(i)]);
      std::sort(list.begin(), list.end());
      return list;
    };
    groups.first = scans(a);
    groups.second = scans(b);
    return groups;
  }

  const RivalGroupsConfig& config_;
  const std::vector<int>& members_;
  Eigen::MatrixXd in_view_, seen_through_;                 ///< of two scans; zero where too little meets [patches]
  Eigen::MatrixXd between_in_view_, between_seen_through_; ///< of two clusters
  std::vector<Cluster> clusters_;                          ///< empty: joined to another
};

} // namespace

std::optional<RivalGroups>
findRivalGroups(const std::vector<int>& members,
                const std::vector<std::pair<int, int>>& pairs,
                const std::vector<PlacementEvidence>& evidence,
                const RivalGroupsConfig& config,
                const std::vector<int>& tied)
{
  return Clustering(members, pairs, evidence, config, tied).run();
}

} // namespace pcl_ssfr
