// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/map_stages.h"

#include "common/parallel.h"
#include "common/stage_clock.h"
#include "judgement/scored_pose.h"
#include "multiway/assembly.h"
#include "multiway/joint_adjustment.h"
#include "multiway/map_report.h"
#include "multiway/parts.h"
#include "multiway/rival_groups.h"
#include "multiway/scan_pair.h"
#include "multiway/storeys.h"
#include "profiles/prepared_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

namespace pcl_ssfr {

namespace {

constexpr const char* kSureLinksContradict = "places here look alike: too many sure links contradict each other";
constexpr const char* kGroupsContradict = "places here look alike: groups of scans contradict each other";
constexpr const char* kSameStation = "places here look alike: it would stand where other scans do, and sees the same";

/// Everything after linking, in order.
class MapMaker {
public:
  MapMaker(const MapInput& input,
           const std::vector<PairLink>& links,
           MultiwayMap& map,
           const MultiwayRegistration::Progress& progress)
      : input_(input), links_(links), map_(map), progress_(progress), threads_(static_cast<int>(input.options.threads))
  {
    for (std::size_t i = 0; i < map.scans.size(); ++i) {
      names_.push_back(map.scans[i].name);
      places_.push_back(map.scans[i].usable ? placeOf(input.prepared[i]) : Eigen::Vector3d::Zero());
    }
    for (std::size_t i = 0; i < map.scans.size() && input.is_large; ++i)
      sights_.push_back(map.scans[i].usable ? sightOf(input.prepared[i]) : SightOfScan());
    evidence_ = [this](int source, int target, const Eigen::Isometry3d& T, double looseness) {
      if (input_.is_large) {
        const auto s = static_cast<std::size_t>(source), t = static_cast<std::size_t>(target);
        if ((T * places_[s] - places_[t]).norm() > sights_[s].reach + sights_[t].reach) {
          PlacementEvidence nothing;
          nothing.total = sights_[s].total + sights_[t].total;
          return nothing;
        }
      }
      return evidenceAt(scan(source), scan(target), T, input_.options, looseness);
    };
  }

  void
  run()
  {
    StageClock clock;
    checkDecisions();
    Placement placed = choose({});
    map_.stages.push_back(clock.lap("choose", links_.size(), countParts(placed.assembly)));
    adjust(placed);
    const std::set<int> in_doubt = findInDoubt(placed);
    if (!in_doubt.empty()) { // once more, with what is nearly free of contradictions
      placed = choose(findContradicting(in_doubt));
      adjust(placed);
      separateSameStations(placed, in_doubt);
    }
    bool is_apart = separate(findRefuted(placed), kSureLinksContradict, placed);
    is_apart = separate(findAlike(placed), kGroupsContradict, placed) || is_apart;
    is_apart = separateStoreys(placed.assembly, placed.graph, placed.reasons) || is_apart;
    if (is_apart)
      adjustAnew(placed);
    const Assembly& assembly = placed.assembly;
    const HypothesisGraph& graph = placed.graph;
    const std::vector<std::string>& reasons = placed.reasons;
    const std::vector<Eigen::Isometry3d>& graph_poses = placed.graph_poses;
    map_.stages.push_back(clock.lap("adjust", names_.size(), countParts(assembly)));
    const ChosenMap chosen = {
        links_, graph, assembly, graph_poses, covariances_, fixedScans(assembly), reasons, places_, input_.decisions};
    describeMap(chosen, input_, map_);
    map_.graph_error = weight_ > 0 ? std::sqrt(squares_before_ / weight_) : 0;
    map_.bundle_error = weight_ > 0 ? std::sqrt(squares_ / weight_) : 0;
    map_.stages.push_back(clock.lap("report", links_.size(), links_.size()));
  }

private:
  /// What became of the scans.
  struct Placement {
    HypothesisGraph graph;
    Assembly assembly;
    std::vector<std::string> reasons;           ///< why scans stand apart
    std::vector<Eigen::Isometry3d> graph_poses; ///< before the joint adjustment
  };

  /// Scans of a part that are not to be trusted.
  struct Doubt {
    std::vector<int> scans;
    std::string note;
  };

  /// Put the scans together, but not by the hypotheses that are excluded.
  Placement
  choose(const ExcludedHypotheses& excluded) const
  {
    report("choose", 0, 3);
    Placement placed;
    placed.graph = weighHypotheses(links_, places_, input_.decisions, input_.options, excluded);
    report("choose", 1, 3);
    placed.assembly = assemble(links_, placed.graph, places_, evidence_, input_.decisions, names_, input_.options);
    report("choose", 2, 3);
    placed.reasons.resize(names_.size());
    separateHanging(placed.assembly, placed.graph, placed.reasons);
    report("choose", 3, 3);
    return placed;
  }

  /// Joint adjustment, and scans out that do not bear it.
  void
  adjust(Placement& placed)
  {
    adjustAnew(placed);
    if (separateHanging(placed.assembly, placed.graph, placed.reasons))
      adjustAnew(placed);
    if (separateRivals(placed.assembly, placed.graph, placed.reasons)) {
      separateHanging(placed.assembly, placed.graph, placed.reasons);
      adjustAnew(placed);
    }
  }
  void
  adjustAnew(Placement& placed)
  {
    placed.graph_poses = placed.assembly.poses;
    adjustAll(placed.assembly);
  }

  /// The scans of parts in which places look alike.
  std::set<int>
  findInDoubt(const Placement& placed) const
  {
    std::set<int> scans;
    for (const auto& doubts : {findRefuted(placed), findAlike(placed)})
      for (const Doubt& doubt : doubts)
        scans.insert(doubt.scans.begin(), doubt.scans.end());
    return scans;
  }

  /** \brief Hypotheses of the scans in doubt that put more than a very small share of what they match into free space.
   *
   * Furniture differs where walls are alike: a right pose contradicts nearly nothing, one of a place alike a few
   * percent. That is no rule for all jobs, as cars leave and poses of pairs are not exact.
   */
  ExcludedHypotheses
  findContradicting(const std::set<int>& scans) const
  {
    std::vector<std::pair<std::size_t, std::size_t>> all;
    for (std::size_t k = 0; k < links_.size(); ++k)
      if (scans.count(links_[k].source) + scans.count(links_[k].target) > 0 &&
          input_.decisions.accepted.count({links_[k].source, links_[k].target}) == 0)
        for (std::size_t rank = 0; rank < links_[k].hypotheses.size(); ++rank)
          all.emplace_back(k, rank);
    std::vector<char> is_out(all.size(), 0);
    forEachInParallel(static_cast<std::int64_t>(all.size()), 1, threads_, [&](std::int64_t index) {
      const auto [k, rank] = all[static_cast<std::size_t>(index)];
      const PairLink& link = links_[k];
      const PlacementEvidence e = evidence_(link.source, link.target, link.hypotheses[rank].T_target_source, 1);
      is_out[static_cast<std::size_t>(index)] =
          e.contradicted > input_.options.rival_groups.contradicted * e.matched ? 1 : 0;
    });
    ExcludedHypotheses excluded;
    for (std::size_t n = 0; n < all.size(); ++n)
      if (is_out[n])
        excluded.insert(all[n]);
    return excluded;
  }

  /// Of parts in doubt, put scans apart that stand where at least two others do and see the same.
  void
  separateSameStations(Placement& placed, const std::set<int>& in_doubt)
  {
    std::vector<int> out;
    for (const auto& [part, members] : membersOf(placed.assembly)) {
      if (isDecided(members) ||
          std::none_of(members.begin(), members.end(), [&](int i) { return in_doubt.count(i) > 0; }))
        continue;
      std::vector<Eigen::Vector3d> stations;
      for (const int i : members)
        stations.push_back(placed.assembly.poses[static_cast<std::size_t>(i)] * places_[static_cast<std::size_t>(i)]);
      const auto pairs = pairsOf(members);
      const std::vector<int> found =
          findSameStations(members, stations, pairs, evidenceOf(placed.assembly, members, pairs), input_.options);
      if (!found.empty())
        map_.notes.push_back(std::to_string(found.size()) + " scans (with " + name(found.front()) +
                             ") would stand at one place and see the same, where places look alike: they are kept "
                             "apart (approximate --poses or --accept decide)");
      out.insert(out.end(), found.begin(), found.end());
    }
    if (!putApart(out, kSameStation, placed.assembly, placed.graph, placed.reasons))
      return;
    separateHanging(placed.assembly, placed.graph, placed.reasons);
    adjustAnew(placed);
  }

  /// Put scans in doubt apart. \return whether there are any
  bool
  separate(const std::vector<Doubt>& doubts, const char* reason, Placement& placed) const
  {
    std::vector<int> out;
    for (const Doubt& doubt : doubts) {
      map_.notes.push_back(doubt.note);
      out.insert(out.end(), doubt.scans.begin(), doubt.scans.end());
    }
    return putApart(out, reason, placed.assembly, placed.graph, placed.reasons);
  }

  const PreparedScan&
  scan(int i) const
  {
    return input_.prepared[static_cast<std::size_t>(i)];
  }
  const std::string&
  name(int i) const
  {
    return names_[static_cast<std::size_t>(i)];
  }
  void
  report(const char* stage, std::size_t done, std::size_t total) const
  {
    if (progress_)
      progress_(stage, done, total);
  }

  void
  checkDecisions() const
  {
    for (const auto& pair : input_.decisions.accepted) {
      const auto link = std::find_if(links_.begin(), links_.end(), [&](const PairLink& l) {
        return l.source == pair.first && l.target == pair.second;
      });
      if (link == links_.end() || link->hypotheses.empty())
        throw std::invalid_argument("the link " + names_[static_cast<std::size_t>(pair.first)] + ", " +
                                    names_[static_cast<std::size_t>(pair.second)] +
                                    " cannot be accepted: no pose of these scans was found" +
                                    (link == links_.end() ? "" : ": " + link->message));
    }
  }

  static std::size_t
  countParts(const Assembly& assembly)
  {
    return membersOf(assembly).size();
  }

  /// The scan of each part that holds its frame.
  std::vector<int>
  fixedScans(const Assembly& assembly) const
  {
    std::vector<int> fixed;
    for (const auto& [part, members] : membersOf(assembly)) {
      const auto pinned =
          std::find_first_of(input_.pinned.begin(), input_.pinned.end(), members.begin(), members.end());
      const auto known = std::find_if(members.begin(), members.end(), [&](int i) {
        return input_.priors[static_cast<std::size_t>(i)].has_value();
      });
      fixed.push_back(pinned != input_.pinned.end() ? *pinned : known != members.end() ? *known : members.front());
    }
    return fixed;
  }

  /// What the surfaces of all pairs of a part say, in the order of the pairs; valid until it is called again for the
  /// part. Stages ask again before anything has moved: for n scans that is n^2 / 2 looks at two scans.
  const std::vector<PlacementEvidence>&
  evidenceOf(const Assembly& assembly,
             const std::vector<int>& members,
             const std::vector<std::pair<int, int>>& pairs) const
  {
    PartEvidence& known = known_evidence_[members.front()];
    std::vector<Eigen::Isometry3d> poses;
    poses.reserve(members.size());
    for (const int i : members)
      poses.push_back(assembly.poses[static_cast<std::size_t>(i)]);
    const auto isSame = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) { return a.matrix() == b.matrix(); };
    if (known.members == members && std::equal(poses.begin(), poses.end(), known.poses.begin(), isSame))
      return known.evidence;
    known.members = members;
    known.poses = std::move(poses);
    known.evidence.assign(pairs.size(), {});
    forEachInParallel(static_cast<std::int64_t>(pairs.size()), 1, threads_, [&](std::int64_t index) {
      const auto k = static_cast<std::size_t>(index);
      const auto [i, j] = pairs[k];
      known.evidence[k] = evidence_(i, j, relative(assembly, i, j), 1);
    });
    return known.evidence;
  }
  static Eigen::Isometry3d
  relative(const Assembly& assembly, int source, int target)
  {
    return assembly.poses[static_cast<std::size_t>(target)].inverse() *
           assembly.poses[static_cast<std::size_t>(source)];
  }
  /** \brief Put scans apart, each into a part of its own, for one reason; the links of all are chosen anew.
   * \return whether there are any
   */
  bool
  putApart(const std::vector<int>& scans,
           const char* reason,
           Assembly& assembly,
           const HypothesisGraph& graph,
           std::vector<std::string>& reasons) const
  {
    if (scans.empty())
      return false;
    for (const int i : scans) {
      assembly.part[static_cast<std::size_t>(i)] = nextPart(assembly);
      reasons[static_cast<std::size_t>(i)] = reason;
    }
    chooseLinks(assembly, links_, graph, places_, input_.options.choice);
    splitUnconnected(assembly, links_, graph, input_.options.choice);
    return true;
  }

  /** \brief Take scans out of their parts that hang in what the other scans saw to be free: each scan against all
   * others of its part, the worst one first. \return whether any was
   */
  bool
  separateHanging(Assembly& assembly, const HypothesisGraph& graph, std::vector<std::string>& reasons) const
  {
    std::vector<int> out;
    for (const auto& [part, members] : membersOf(assembly)) {
      if (members.size() < 2)
        continue;
      const auto pairs = pairsOf(members);
      const std::vector<int> hanging =
          findHanging(members, pairs, evidenceOf(assembly, members, pairs), input_.options.choice.contradiction_weight);
      out.insert(out.end(), hanging.begin(), hanging.end());
    }
    return putApart(out,
                    "where its links put it, its surfaces hang in the free space of other scans, or theirs in its own",
                    assembly,
                    graph,
                    reasons);
  }

  /// What the scans of a part say of one of them at a pose, loosely; its own entry is not read.
  double
  scoreAt(const Assembly& assembly, const std::vector<int>& members, int which, const Eigen::Isometry3d& pose) const
  {
    PlacementEvidence sum;
    for (const int other : members)
      if (other != which)
        sum += evidence_(which,
                         other,
                         assembly.poses[static_cast<std::size_t>(other)].inverse() * pose,
                         input_.options.choice.loose);
    return sum.total > 0 ? (sum.matched - input_.options.choice.contradiction_weight * sum.contradicted) / sum.total
                         : 0;
  }

  /** \brief Each scan once more, now that all others are placed: it stands apart where another place in its part, which
   * a link of it says, explains all surfaces better, or nearly as well. \return whether any does
   */
  bool
  separateRivals(Assembly& assembly, const HypothesisGraph& graph, std::vector<std::string>& reasons) const
  {
    std::vector<char> has_rival(names_.size(), 0);
    const auto parts = membersOf(assembly);
    forEachInParallel(static_cast<std::int64_t>(names_.size()), 1, threads_, [&](std::int64_t index) {
      const auto i = static_cast<std::size_t>(index);
      const std::vector<int>& members = parts.at(assembly.part[i]);
      if (members.size() > 2 && hasRival(assembly, graph, members, static_cast<int>(i)))
        has_rival[i] = 1;
    });
    std::vector<int> out;
    for (std::size_t i = 0; i < has_rival.size(); ++i)
      if (has_rival[i])
        out.push_back(static_cast<int>(i));
    return putApart(
        out, "another place in the map explains its surfaces nearly as well, or better", assembly, graph, reasons);
  }

  bool
  hasRival(const Assembly& assembly, const HypothesisGraph& graph, const std::vector<int>& members, int which) const
  {
    const ChoiceConfig& config = input_.options.choice;
    const auto i = static_cast<std::size_t>(which);
    double agree_here = 0;
    std::vector<std::pair<double, Eigen::Isometry3d>> rivals; // belief, place
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const PairLink& link = links_[k];
      if (link.source != which && link.target != which)
        continue;
      if (input_.decisions.accepted.count({link.source, link.target}) > 0)
        return false;
      const auto other = static_cast<std::size_t>(link.source == which ? link.target : link.source);
      if (assembly.part[other] != assembly.part[i])
        continue;
      for (std::size_t h = graph.first[k]; h < graph.first[k + 1]; ++h) {
        const WeighedHypothesis& w = graph.hypotheses[h];
        const Eigen::Isometry3d& T = link.hypotheses[w.rank].T_target_source;
        const Eigen::Isometry3d pose = assembly.poses[other] * (link.source == which ? T : T.inverse());
        if (!areDistinct(assembly.poses[i], pose, places_[i], config)) {
          agree_here += w.belief;
          continue;
        }
        if (w.prior < config.rival)
          continue;
        const auto same = std::find_if(rivals.begin(), rivals.end(), [&](const auto& rival) {
          return !areDistinct(rival.second, pose, places_[i], config);
        });
        if (same != rivals.end())
          same->first += w.prior;
        else
          rivals.emplace_back(w.prior, pose);
      }
    }
    if (rivals.empty())
      return false;
    // Places alike may explain more than the right one, of which little is seen: links that agree on another place are
    // a reason for doubt by themselves.
    if (std::any_of(rivals.begin(), rivals.end(), [&](const auto& rival) {
          return rival.first >= config.rival_links && agree_here < config.clear_majority * rival.first;
        }))
      return true;
    const PlaceOdds here{agree_here, scoreAt(assembly, members, which, assembly.poses[i])};
    return std::any_of(rivals.begin(), rivals.end(), [&](const auto& rival) {
      return !isClear(here, {rival.first, scoreAt(assembly, members, which, rival.second)}, config);
    });
  }

  /// Whether a person said where a scan of the part is.
  bool
  isDecided(const std::vector<int>& members) const
  {
    return std::any_of(members.begin(), members.end(), [&](int i) {
      return input_.priors[static_cast<std::size_t>(i)].has_value() ||
             std::any_of(input_.decisions.accepted.begin(), input_.decisions.accepted.end(), [&](const auto& pair) {
               return pair.first == i || pair.second == i;
             });
    });
  }

  /// Parts whose sure links contradict each other too often, unless a person has spoken.
  std::vector<Doubt>
  findRefuted(const Placement& placed) const
  {
    std::vector<Doubt> doubts;
    if (!input_.options.alias.check)
      return doubts;
    const ChoiceConfig& config = input_.options.choice;
    for (const auto& [part, members] : membersOf(placed.assembly)) {
      if (members.size() < 2 || isDecided(members))
        continue;
      SureLinks sure = countSureLinks(placed.assembly, links_, placed.graph, part, SureBy::Pair, config);
      if (!isRefuted(sure, config))
        sure = countSureLinks(placed.assembly, links_, placed.graph, part, SureBy::Loops, config);
      if (isRefuted(sure, config))
        doubts.push_back({members,
                          std::to_string(sure.contradicted) + " of the " + std::to_string(sure.wrong.size()) +
                              " sure links of a part of " + std::to_string(members.size()) +
                              " scans contradict it: places look alike there, so its scans are kept apart "
                              "(approximate --poses or --accept decide)"});
    }
    return doubts;
  }

  /// Parts in which groups of scans contradict each other, unless a person has spoken.
  std::vector<Doubt>
  findAlike(const Placement& placed) const
  {
    std::vector<Doubt> doubts;
    if (!input_.options.alias.check)
      return doubts;
    for (const auto& [part, members] : membersOf(placed.assembly)) {
      if (members.size() < 4 || isDecided(members))
        continue;
      const auto pairs = pairsOf(members);
      const auto groups =
          findRivalGroups(members, pairs, evidenceOf(placed.assembly, members, pairs), input_.options.rival_groups);
      if (groups)
        doubts.push_back({members,
                          std::to_string(groups->first.size()) + " and " + std::to_string(groups->second.size()) +
                              " scans (with " + name(groups->first.front()) + " and " + name(groups->second.front()) +
                              ") contradict each other more than among themselves: places look alike there, or "
                              "changed between the scans, so all scans of that part are kept apart (approximate "
                              "--poses or --accept decide)"});
    }
    return doubts;
  }

  /** \brief Take parts apart that may be several storeys laid onto one another, unless a person has spoken.
   *
   * The scans of the storey stand alone then; those on the ways up and down stay together where links hold them.
   */
  bool
  separateStoreys(Assembly& assembly, const HypothesisGraph& graph, std::vector<std::string>& reasons) const
  {
    if (!input_.options.alias.check)
      return false;
    std::vector<int> out;
    std::size_t usable = 0;
    for (std::size_t i = 0; i < names_.size(); ++i)
      usable += map_.scans[i].usable && input_.original[i] == static_cast<int>(i) ? 1 : 0;
    for (const auto& [part, members] : membersOf(assembly)) {
      if (members.size() < 2 || isDecided(members))
        continue;
      std::vector<StoreyScan> scans;
      for (const int i : members) {
        const auto& patches = std::get<PatchScan>(scan(i).data().scan);
        StoreyScan storey;
        storey.surface = &patches.patches.samples;
        storey.T_map_surface = assembly.poses[static_cast<std::size_t>(i)] * Eigen::Translation3d(patches.origin);
        storey.place = assembly.poses[static_cast<std::size_t>(i)] * places_[static_cast<std::size_t>(i)];
        scans.push_back(storey);
      }
      const std::optional<Eigen::Vector3d> up = upOf(assembly, members, scans);
      const std::optional<StoreyDoubt> doubt =
          up ? findStoreyDoubt(scans, *up, members.size() < usable, input_.options.alias) : std::nullopt;
      if (!doubt)
        continue;
      map_.notes.push_back(
          "a storey of " + std::to_string(doubt->level.size()) +
          " scans may be several that look alike, laid onto one another: stairs lead from it to no other level, and no "
          "scan tells the storeys apart; its scans are kept apart (approximate --poses or --accept decide)");
      for (const std::size_t k : doubt->level)
        out.push_back(members[k]);
    }
    return putApart(out,
                    "it may be of a storey that only looks like the one of the scans it is linked to",
                    assembly,
                    graph,
                    reasons);
  }

  std::optional<Eigen::Vector3d>
  upOf(const Assembly& assembly, const std::vector<int>& members, const std::vector<StoreyScan>& scans) const
  {
    if (!input_.options.gravity)
      return findUp(scans, input_.options.alias);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int i : members)
      sum += assembly.poses[static_cast<std::size_t>(i)].linear() * input_.options.gravity->normalized();
    return sum.norm() > 0 ? std::optional<Eigen::Vector3d>(sum.normalized()) : std::nullopt;
  }

  void
  adjustAll(Assembly& assembly)
  {
    covariances_.assign(names_.size(), Eigen::Matrix<double, 6, 6>::Zero());
    squares_before_ = squares_ = weight_ = 0;
    const std::vector<int> fixed = fixedScans(assembly);
    std::size_t done = 0;
    const auto parts = membersOf(assembly);
    for (const auto& [part, members] : parts) {
      report("adjust", done++, parts.size());
      if (members.size() < 2)
        continue;
      adjustPart(assembly, members, fixed);
    }
    report("adjust", parts.size(), parts.size());
  }

  void
  adjustPart(Assembly& assembly, const std::vector<int>& members, const std::vector<int>& fixed)
  {
    const auto pairs = pairsOf(members);
    const std::vector<PlacementEvidence>& evidence = evidenceOf(assembly, members, pairs);
    std::map<std::pair<int, int>, char> linked;
    for (std::size_t k = 0; k < links_.size(); ++k)
      if (assembly.used[k] >= 0)
        linked[{links_[k].source, links_[k].target}] = 1;
    std::vector<int> number(names_.size(), -1);
    std::vector<Eigen::Isometry3d> poses;
    std::vector<Eigen::Vector3d> places;
    std::vector<int> held;
    for (const int i : members) {
      number[static_cast<std::size_t>(i)] = static_cast<int>(poses.size());
      if (std::find(fixed.begin(), fixed.end(), i) != fixed.end())
        held.push_back(static_cast<int>(poses.size()));
      poses.push_back(assembly.poses[static_cast<std::size_t>(i)]);
      places.push_back(places_[static_cast<std::size_t>(i)]);
    }
    std::vector<std::pair<int, int>> taken, numbered;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const PlacementEvidence& e = evidence[k];
      const bool overlaps = e.matched >= input_.options.adjustment.least_matched * e.total &&
                            e.matched > input_.options.choice.contradiction_weight * e.contradicted;
      if (!overlaps && linked.count(pairs[k]) == 0)
        continue;
      taken.push_back(pairs[k]);
      numbered.emplace_back(number[static_cast<std::size_t>(pairs[k].first)],
                            number[static_cast<std::size_t>(pairs[k].second)]);
    }
    AdjustmentConfig config = input_.options.adjustment;
    if (input_.is_large)
      config.damping = config.damping_of_large;
    const EquationsFunction equations = [&](std::size_t k, const Eigen::Isometry3d& T) {
      return equationsAt(scan(taken[k].first), scan(taken[k].second), T, input_.options);
    };
    const PatchGradientsFunction patches = [&](std::size_t k, const Eigen::Isometry3d& T, bool of_source) {
      return patchGradientsAt(scan(taken[k].first), scan(taken[k].second), T, input_.options, of_source);
    };
    const JointAdjustment adjusted = adjustJointly(poses, numbered, held, places, equations, patches, config, threads_);
    for (std::size_t m = 0; m < members.size(); ++m) {
      assembly.poses[static_cast<std::size_t>(members[m])] = adjusted.poses[m];
      covariances_[static_cast<std::size_t>(members[m])] = adjusted.covariances[m];
    }
    const auto count = static_cast<double>(taken.size());
    weight_ += count;
    squares_before_ += count * adjusted.rms_before * adjusted.rms_before;
    squares_ += count * adjusted.rms * adjusted.rms;
  }

  const MapInput& input_;
  const std::vector<PairLink>& links_;
  MultiwayMap& map_;
  const MultiwayRegistration::Progress& progress_;
  int threads_;
  std::vector<std::string> names_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<SightOfScan> sights_; ///< of a large job
  EvidenceFunction evidence_;
  struct PartEvidence {
    std::vector<int> members;
    std::vector<Eigen::Isometry3d> poses; ///< of the members, that the evidence is of
    std::vector<PlacementEvidence> evidence;
  };
  mutable std::map<int, PartEvidence> known_evidence_; ///< of parts, by their first scan
  std::vector<Eigen::Matrix<double, 6, 6>> covariances_;
  double squares_before_ = 0, squares_ = 0, weight_ = 0;
};

} // namespace

void
makeMap(const MapInput& input,
        const std::vector<PairLink>& links,
        MultiwayMap& map,
        const MultiwayRegistration::Progress& progress)
{
  MapMaker(input, links, map, progress).run();
}

} // namespace pcl_ssfr
