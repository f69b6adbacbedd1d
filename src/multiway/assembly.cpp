// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/assembly.h"

#include "common/parallel.h"
#include "multiway/growing_parts.h"
#include "multiway/rival_places.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <optional>

namespace pcl_ssfr {

namespace {

// Sure loops that close with a link which joins two parts with no other one: the best supported joins come first.
constexpr double kLeastLoops[] = {3, 1.5, 0.5};
constexpr std::size_t kRivals = 5;   // that are compared
constexpr double kOutnumbered = 0.3; // share of the belief against a join that is for it, at least

/// Links that are added to those that were seen, one in ChoiceConfig::clear_odds of them false: a small job has few.
constexpr double kLinksBefore = 25;

/// The links between two parts, at a pose between them.
struct Vote {
  double agree = 0;    ///< belief of those that agree
  double disagree = 0; ///< belief of those that do not
  int sure = 0;        ///< that agree and are sure
  double loops = 0;    ///< most loops of one that agrees
  bool accepted = false;
  std::vector<std::pair<double, Eigen::Isometry3d>> rivals; ///< belief and pose of the parts that a link says instead
};

class Assembler {
public:
  Assembler(const std::vector<PairLink>& links,
            const HypothesisGraph& graph,
            const std::vector<Eigen::Vector3d>& places,
            const EvidenceFunction& evidence,
            const Decisions& decisions,
            const std::vector<std::string>& names,
            const MultiwayOptions& options,
            const JoinTest& join_test)
      : links_(links), graph_(graph), places_(places), evidence_(evidence), decisions_(decisions), names_(names),
        options_(options), join_test_(join_test), parts_(links, graph, places, options.choice)
  {}

  Assembly
  run()
  {
    std::vector<std::size_t> order(graph_.hypotheses.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto belief = [&](std::size_t h) { return graph_.hypotheses[h].belief; };
    const auto loops = [&](std::size_t h) { return graph_.hypotheses[h].loops; };
    const auto isAccepted = [&](std::size_t h) { return graph_.hypotheses[h].rank == 0 && accepted(link(h)); };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      if (isAccepted(a) != isAccepted(b))
        return isAccepted(a);
      // Beliefs near one differ by rounding; then loops say more.
      const double sure_a = std::min(belief(a), 0.99), sure_b = std::min(belief(b), 0.99);
      return sure_a != sure_b ? sure_a > sure_b : loops(a) > loops(b);
    });
    const auto joinAll = [&](double least_loops, bool is_last) {
      for (bool has_grown = true; has_grown;) {
        has_grown = false;
        if (is_last)
          parts_.assembly().false_share = falseShare();
        for (const std::size_t h : order)
          if ((belief(h) >= options_.choice.sure || isAccepted(h)) && join(h, least_loops, is_last))
            has_grown = true;
      }
    };
    for (const double least_loops : kLeastLoops)
      joinAll(least_loops, false);
    joinAll(kLeastLoops[2], true);
    parts_.adjustAll();
    return std::move(parts_.assembly());
  }

private:
  const PairLink&
  link(std::size_t h) const
  {
    return links_[graph_.hypotheses[h].link];
  }
  bool
  accepted(const PairLink& pair) const
  {
    return isAccepted(decisions_, pair.source, pair.target);
  }
  int
  partOf(int scan) const
  {
    return parts_.partOf(scan);
  }
  const Eigen::Isometry3d&
  pose(int scan) const
  {
    return parts_.pose(scan);
  }

  /// Votes on laying part \p a into the frame of part \p b.
  Vote
  vote(int a, int b, const Eigen::Isometry3d& T_b_a) const
  {
    Vote result;
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const PairLink& pair = links_[k];
      const bool forward = partOf(pair.source) == a && partOf(pair.target) == b;
      if (!forward && !(partOf(pair.source) == b && partOf(pair.target) == a))
        continue;
      const Eigen::Isometry3d T_map_source = forward ? T_b_a * pose(pair.source) : pose(pair.source);
      const Eigen::Isometry3d T_map_target = forward ? pose(pair.target) : T_b_a * pose(pair.target);
      const Eigen::Isometry3d T = T_map_target.inverse() * T_map_source;
      double for_it = 0, against = 0;
      std::optional<Eigen::Isometry3d> T_rival;
      for (std::size_t h = graph_.first[k]; h < graph_.first[k + 1]; ++h) {
        const WeighedHypothesis& w = graph_.hypotheses[h];
        if (agree(pair.hypotheses[w.rank].T_target_source,
                  T,
                  places_[static_cast<std::size_t>(pair.source)],
                  options_.choice)) {
          for_it = std::max(for_it, w.belief);
          result.loops = std::max(result.loops, w.loops);
          result.accepted = result.accepted || (w.rank == 0 && accepted(pair));
        }
        else if (w.belief > against) {
          against = w.belief;
          const Eigen::Isometry3d& T_target_source = pair.hypotheses[w.rank].T_target_source;
          const Eigen::Isometry3d there = parts_.partPose(pair, T_target_source);
          T_rival = forward ? there : there.inverse();
        }
      }
      result.agree += for_it;
      result.sure += for_it >= options_.choice.sure ? 1 : 0;
      if (for_it < against)
        result.disagree += against;
      if (T_rival && against >= options_.choice.rival)
        addRival(result.rivals, against, *T_rival, a, T_b_a);
    }
    std::stable_sort(
        result.rivals.begin(), result.rivals.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
    result.rivals.resize(std::min(result.rivals.size(), kRivals));
    return result;
  }

  /// Rivals that agree with each other are one.
  void
  addRival(std::vector<std::pair<double, Eigen::Isometry3d>>& rivals,
           double belief,
           const Eigen::Isometry3d& T_b_a,
           int a,
           const Eigen::Isometry3d& T_considered) const
  {
    const Eigen::Vector3d place = parts_.placeOf(a);
    if (!areDistinct(T_b_a, T_considered, place, options_.choice))
      return;
    for (auto& [sum, T] : rivals)
      if (agree(T, T_b_a, place, options_.choice)) {
        sum += belief;
        return;
      }
    rivals.emplace_back(belief, T_b_a);
  }

  /// What the surfaces say of it.
  PlacementEvidence
  verify(int a, int b, const Eigen::Isometry3d& T_b_a) const
  {
    const std::vector<PlacedPair> pairs = parts_.pairsAt(a, b, T_b_a);
    std::vector<PlacementEvidence> found(pairs.size());
    forEachInParallel(
        static_cast<std::int64_t>(pairs.size()), 1, static_cast<int>(options_.threads), [&](std::int64_t k) {
          const PlacedPair& pair = pairs[static_cast<std::size_t>(k)];
          found[static_cast<std::size_t>(k)] =
              evidence_(pair.source, pair.target, pair.T_target_source, options_.choice.loose);
        });
    PlacementEvidence sum;
    for (const PlacementEvidence& e : found)
      sum += e;
    return sum;
  }

  double
  scoreOf(const PlacementEvidence& e) const
  {
    return pcl_ssfr::scoreOf(e, contradictionWeight(options_));
  }

  bool
  join(std::size_t h, double least_loops, bool is_last)
  {
    const WeighedHypothesis& w = graph_.hypotheses[h];
    const PairLink& pair = links_[w.link];
    const int a = partOf(pair.source);
    const int b = partOf(pair.target);
    if (a == b) {
      if (accepted(pair) && w.rank == 0)
        checkAccepted(pair);
      return false;
    }
    const Eigen::Isometry3d T_b_a = parts_.partPose(pair, pair.hypotheses[w.rank].T_target_source);
    const Vote votes = vote(a, b, T_b_a);
    const std::string refusal = votes.accepted ? "" : whyNot(w, pair, votes, a, b, T_b_a, least_loops, is_last);
    parts_.assembly().refusal[w.link] = refusal;
    if (!refusal.empty())
      return false;
    parts_.merge(a, b, T_b_a);
    return true;
  }

  std::string
  whyNot(const WeighedHypothesis& w,
         const PairLink& pair,
         const Vote& votes,
         int a,
         int b,
         const Eigen::Isometry3d& T_b_a,
         double least_loops,
         bool is_last) const
  {
    if (votes.agree < kOutnumbered * votes.disagree)
      return "other links between the same parts say otherwise";
    const bool is_supported = votes.loops >= least_loops || (votes.sure >= 2 && votes.sure > least_loops);
    if (!is_supported) {
      if (!is_last)
        return "nothing else supports it";
      // Loops that would close with it do not count here: they may be of places alike.
      const double sure = std::min({w.belief, w.prior, pair.confidence}) * (1 - parts_.assembly().false_share);
      if (pair.status != Status::Converged || w.rank != 0 || sure < options_.choice.lone) {
        char text[160];
        std::snprintf(text,
                      sizeof(text),
                      "it alone would join two parts, and is not sure enough for that: %.2f of the %.2f needed",
                      w.rank == 0 ? sure : 0.0,
                      options_.choice.lone);
        return text;
      }
    }
    const PlacementEvidence e = verify(a, b, T_b_a);
    if (!(scoreOf(e) > 0))
      return "it puts surfaces into the free space of other scans";
    if (std::string reason = join_test_ ? join_test_(parts_.pairsAt(a, b, T_b_a)) : ""; !reason.empty())
      return reason;
    if (votes.agree >= options_.choice.outvoted * votes.disagree)
      return "";
    // Right links may be outvoted by those of places alike: then what all scans of both parts see of each other
    // decides.
    for (const auto& rival : votes.rivals)
      if (!isClear({1, scoreOf(e)}, {1, scoreOf(verify(a, b, rival.second))}, options_))
        return "another pose of the same parts explains their surfaces nearly as well";
    return "";
  }

  void
  checkAccepted(const PairLink& pair)
  {
    const Eigen::Isometry3d T = pose(pair.target).inverse() * pose(pair.source);
    if (!agree(pair.hypotheses.front().T_target_source,
               T,
               places_[static_cast<std::size_t>(pair.source)],
               options_.choice))
      throw DecisionError(
          "the accepted link " + names_[static_cast<std::size_t>(pair.source)] + ", " +
          names_[static_cast<std::size_t>(pair.target)] +
          " does not agree with the other accepted links between them: " + loopOf(pair.source, pair.target));
  }

  /// The accepted links that lead from one scan to the other, for people.
  std::string
  loopOf(int from, int to) const
  {
    std::vector<int> before(places_.size(), -1);
    std::vector<int> queue = {from};
    before[static_cast<std::size_t>(from)] = from;
    for (std::size_t q = 0; q < queue.size(); ++q)
      for (const auto& [i, j] : decisions_.accepted)
        for (const auto& [x, y] : {std::pair(i, j), std::pair(j, i)})
          if (x == queue[q] && before[static_cast<std::size_t>(y)] < 0 && !(x == from && y == to)) {
            before[static_cast<std::size_t>(y)] = x;
            queue.push_back(y);
          }
    if (before[static_cast<std::size_t>(to)] < 0)
      return "the links that were found lead elsewhere";
    std::string text = names_[static_cast<std::size_t>(to)];
    for (int at = to; at != from;) {
      at = before[static_cast<std::size_t>(at)];
      text.insert(0, names_[static_cast<std::size_t>(at)] + " - ");
    }
    return "the loop " + text + " - " + names_[static_cast<std::size_t>(from)] + " does not close";
  }

  /// Of the links that are sure by themselves: the share that the parts contradict.
  double
  falseShare() const
  {
    double right = 0, wrong = 0;
    for (const PairLink& pair : links_) {
      if (pair.hypotheses.empty() || pair.status != Status::Converged || partOf(pair.source) != partOf(pair.target))
        continue;
      const Eigen::Isometry3d T = pose(pair.target).inverse() * pose(pair.source);
      (agree(
           pair.hypotheses.front().T_target_source, T, places_[static_cast<std::size_t>(pair.source)], options_.choice)
           ? right
           : wrong) += 1;
    }
    return (wrong + kLinksBefore / options_.choice.clear_odds) / (right + wrong + kLinksBefore);
  }

  const std::vector<PairLink>& links_;
  const HypothesisGraph& graph_;
  const std::vector<Eigen::Vector3d>& places_;
  const EvidenceFunction& evidence_;
  const Decisions& decisions_;
  const std::vector<std::string>& names_;
  const MultiwayOptions& options_;
  const JoinTest& join_test_;
  GrowingParts parts_;
};

} // namespace

Assembly
assemble(const std::vector<PairLink>& links,
         const HypothesisGraph& graph,
         const std::vector<Eigen::Vector3d>& places,
         const EvidenceFunction& evidence,
         const Decisions& decisions,
         const std::vector<std::string>& names,
         const MultiwayOptions& options,
         const JoinTest& join_test)
{
  Assembly assembly = Assembler(links, graph, places, evidence, decisions, names, options, join_test).run();
  chooseLinks(assembly, links, graph, places, options.choice);
  return assembly;
}

void
chooseLinks(Assembly& assembly,
            const std::vector<PairLink>& links,
            const HypothesisGraph& graph,
            const std::vector<Eigen::Vector3d>& places,
            const ChoiceConfig& config)
{
  for (std::size_t k = 0; k < links.size(); ++k) {
    assembly.used[k] = -1;
    const auto source = static_cast<std::size_t>(links[k].source);
    const auto target = static_cast<std::size_t>(links[k].target);
    if (assembly.part[source] != assembly.part[target])
      continue;
    const Eigen::Isometry3d T = assembly.poses[target].inverse() * assembly.poses[source];
    double most = 0;
    for (std::size_t h = graph.first[k]; h < graph.first[k + 1]; ++h) {
      const WeighedHypothesis& w = graph.hypotheses[h];
      // A bent chain may have strayed from a link that two others of its part support.
      if (w.belief > most && agree(links[k].hypotheses[w.rank].T_target_source, T, places[source], config)) {
        most = w.belief;
        assembly.used[k] = static_cast<int>(w.rank);
      }
    }
  }
}

std::vector<char>
findBridges(const Assembly& assembly, const std::vector<PairLink>& links)
{
  // A link is a bridge when without it its scans are not connected: a search for each used link of a sparse graph is
  // cheap enough, as a part with many links has few bridges and a search ends soon.
  const std::size_t n = assembly.part.size();
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> neighbours(n); // scan, link
  for (std::size_t k = 0; k < links.size(); ++k)
    if (assembly.used[k] >= 0) {
      neighbours[static_cast<std::size_t>(links[k].source)].emplace_back(static_cast<std::size_t>(links[k].target), k);
      neighbours[static_cast<std::size_t>(links[k].target)].emplace_back(static_cast<std::size_t>(links[k].source), k);
    }
  std::vector<char> bridges(links.size(), 0);
  for (std::size_t k = 0; k < links.size(); ++k) {
    if (assembly.used[k] < 0)
      continue;
    std::vector<char> seen(n, 0);
    std::vector<std::size_t> stack = {static_cast<std::size_t>(links[k].source)};
    seen[stack.front()] = 1;
    const auto goal = static_cast<std::size_t>(links[k].target);
    while (!stack.empty() && !seen[goal]) {
      const std::size_t at = stack.back();
      stack.pop_back();
      for (const auto& [next, by] : neighbours[at])
        if (by != k && !seen[next]) {
          seen[next] = 1;
          stack.push_back(next);
        }
    }
    bridges[k] = seen[goal] ? 0 : 1;
  }
  return bridges;
}

} // namespace pcl_ssfr
