// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/map_stages.h"

#include "common/logit.h"
#include "common/stage_clock.h"
#include "judgement/scored_pose.h"
#include "multiway/assembly.h"
#include "multiway/map_adjustment.h"
#include "multiway/map_report.h"
#include "multiway/parts.h"
#include "multiway/placed_evidence.h"
#include "multiway/places_alike.h"
#include "multiway/rival_places.h"
#include "multiway/same_place.h"
#include "multiway/scan_pair.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>

namespace pcl_ssfr {

namespace {

/// Where the sensors are, in the frames of their scans [m].
std::vector<Eigen::Vector3d>
placesOf(const MapInput& input, const MultiwayMap& map)
{
  std::vector<Eigen::Vector3d> places;
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    places.push_back(map.scans[i].usable ? placeOf(input.prepared[i]) : Eigen::Vector3d::Zero());
  return places;
}

constexpr const char* kHasRival = "another place in the map explains its surfaces nearly as well, or better";

/// Everything after linking, in order.
class MapMaker {
public:
  MapMaker(const MapInput& input,
           const std::vector<PairLink>& links,
           MultiwayMap& map,
           const MultiwayRegistration::Progress& progress)
      : input_(input), links_(links), map_(map), progress_(progress), places_(placesOf(input, map)),
        evidence_(input, map, places_), adjustment_(input, links, places_, evidence_, progress),
        alike_(input, links, map, places_, evidence_), accepted_(tiedScans(input.decisions, {}, map.scans.size()))
  {
    for (const MapScan& scan : map.scans)
      names_.push_back(scan.name);
  }

  void
  run()
  {
    StageClock clock;
    checkDecisions();
    notes_ = map_.notes.size();
    Placement placed = choose();
    map_.stages.push_back(clock.lap("choose", links_.size(), countParts(placed.assembly)));
    adjust(placed);
    chooseAnewInDoubt(placed);
    separateAlike(placed);
    const MapExactness exactness = adjustment_.adjustExactly(placed.assembly);
    for (std::string& note : alike_.repeatedStations(placed.assembly))
      map_.notes.push_back(std::move(note));
    map_.stages.push_back(clock.lap("adjust", names_.size(), countParts(placed.assembly)));
    const ChosenMap chosen = {links_,
                              placed.graph,
                              placed.assembly,
                              adjustment_.graphPoses(),
                              exactness.covariances,
                              fixedScans(placed.assembly, input_),
                              placed.reasons,
                              places_,
                              input_.decisions};
    describeMap(chosen, input_, map_);
    map_.graph_error = exactness.graph_error;
    map_.bundle_error = exactness.bundle_error;
    map_.stages.push_back(clock.lap("report", links_.size(), links_.size()));
  }

private:
  /// What became of the scans.
  struct Placement {
    HypothesisGraph graph;
    FurnitureFindings furniture;
    Assembly assembly;
    std::vector<std::string> reasons; ///< why scans stand apart
    bool is_distinguished = false;    ///< furniture distinguishes places that look alike
  };

  /// Put the scans together.
  Placement
  choose()
  {
    report("choose", 0, 3);
    Placement placed;
    placed.graph = weighHypotheses(links_, places_, input_.decisions, input_.options);
    placed.furniture = alike_.findFurniture(placed.graph);
    report("choose", 1, 3);
    SamePlaceOdds odds = samePlaceOdds(FurnitureOf::Walled);
    const double most_by_links = std::log(input_.options.choice.clear_odds);
    putTogether(odds, {most_by_links, logit(input_.options.registration.min_confidence), true}, placed);
    report("choose", 2, 3);
    separateHanging(placed);
    report("choose", 3, 3);
    return placed;
  }

  void
  putTogether(SamePlaceOdds& odds, const JoinRule& rule, Placement& placed)
  {
    placed.assembly =
        assemble(links_, placed.graph, places_, odds, rule, input_.decisions, names_, input_.options, poseTest());
    adjustment_.startFrom(placed.assembly.poses);
    placed.reasons.assign(names_.size(), "");
  }

  SamePlaceOdds
  samePlaceOdds(FurnitureOf whose) const
  {
    return {[this, whose](const PlacedPair& pair) { return alike_.samePlaceLogOdds(pair, whose); },
            places_,
            input_.options,
            [this](int source, int target, double distance) { return alike_.areUnrelated(source, target, distance); }};
  }

  JoinTest
  poseTest() const
  {
    const auto& priors = input_.priors;
    if (std::none_of(priors.begin(), priors.end(), [](const auto& prior) { return prior.has_value(); }))
      return nullptr;
    return [this](const std::vector<PlacedPair>& pairs) { return againstPoses(pairs); };
  }
  /// Why scans whose poses are known approximately cannot stand so; empty: they may.
  std::string
  againstPoses(const std::vector<PlacedPair>& pairs) const
  {
    for (const PlacedPair& pair : pairs) {
      const auto s = static_cast<std::size_t>(pair.source), t = static_cast<std::size_t>(pair.target);
      if (!input_.priors[s] || !input_.priors[t])
        continue;
      const PairGuess guess = guessOf(*input_.priors[s], *input_.priors[t], places_[s], places_[t]);
      if (rotationBetween(guess.T_target_source, pair.T_target_source) > guess.tolerance.rotation ||
          translationBetween(guess.T_target_source, pair.T_target_source, places_[s]) > guess.tolerance.translation)
        return "approximate poses say otherwise of " + name(pair.source) + " and " + name(pair.target);
    }
    return "";
  }

  /// Where sure links refute each other, or furniture finds many of them false, places look alike: all is put together
  /// once more, by what distinguishes them.
  void
  chooseAnewInDoubt(Placement& placed)
  {
    if (!input_.options.alias.check)
      return;
    const FurnitureFindings& furniture = placed.furniture;
    const double least_false = input_.options.furniture.least_false;
    const bool distinguishes = furniture.false_share >= least_false;
    const double refuted_share = alike_.refutedShare(placed.assembly, placed.graph);
    if (furniture.false_share_of_walled < least_false && !(refuted_share > 0) &&
        !(distinguishes && !alike_.storeys(placed.assembly).empty()))
      return;
    placed.is_distinguished = distinguishes;
    map_.notes.resize(notes_); // of what is chosen anew
    report("choose", 2, 3);
    SamePlaceOdds odds = samePlaceOdds(FurnitureOf::All);
    const double most_by_links =
        mostLogOddsByLinks(std::max(furniture.false_share, refuted_share), input_.options.choice);
    // The beliefs by loops stay in the graph: what only outvoted links hold falls apart where scans are put apart.
    putTogether(odds, {most_by_links, 0, false}, placed);
    report("choose", 3, 3);
    separateHanging(placed);
    adjustHanging(placed);
    const PlacedScans scans = {placed.assembly, links_, placed.graph, places_};
    putApart(findScansWithRivalsAlike(alike_.undecidedScans(placed.assembly),
                                      scans,
                                      odds,
                                      evidenceFunction(),
                                      most_by_links,
                                      input_.decisions,
                                      input_.options),
             kHasRival,
             alike_.tied(),
             placed);
    separateGroups(odds, most_by_links, placed);
    separateHanging(placed);
  }

  /// Put groups of scans apart, each a part of its own, for which it is not clear where they belong. What a person tied
  /// to each other stays together.
  void
  separateGroups(SamePlaceOdds& odds, double most_by_links, Placement& placed) const
  {
    std::set<std::vector<int>> clear; // parts without such a group
    while (true) {
      const PlacedScans scans = {placed.assembly, links_, placed.graph, places_};
      std::vector<int> group;
      for (const auto& [part, members] : membersOf(placed.assembly)) {
        if (clear.count(members) > 0)
          continue;
        std::vector<std::vector<int>> groups = groupsOf(members, scans, odds);
        const auto is_tied = [&tied = alike_.tied(), &all = members](const std::vector<int>& one) {
          return areTiedToOthers(one, all, tied);
        };
        groups.erase(std::remove_if(groups.begin(), groups.end(), is_tied), groups.end());
        group = findGroupWithRivalAlike(groups, scans, odds, evidenceFunction(), most_by_links, input_.options);
        if (!group.empty())
          break;
        clear.insert(members);
      }
      if (group.empty())
        return;
      const int next = nextPart(placed.assembly);
      for (const int scan : group) {
        placed.assembly.part[static_cast<std::size_t>(scan)] = next;
        placed.reasons[static_cast<std::size_t>(scan)] = kHasRival;
      }
      chooseLinksAnew(placed);
    }
  }

  /// Put scans apart of storeys that may be several, where furniture does not distinguish these, and of piles that may
  /// belong elsewhere.
  void
  separateAlike(Placement& placed) const
  {
    if (!placed.is_distinguished)
      separate(alike_.storeys(placed.assembly),
               "it may be of a storey that only looks like the one of the scans it is linked to",
               placed);
    const Piles piles = alike_.piles(placed.assembly);
    std::vector<int> in_piles;
    for (const auto& [i, pile] : piles)
      in_piles.push_back(i);
    separateRivals(in_piles, piles, placed);
  }

  /// Joint adjustment, and scans out that do not bear it.
  void
  adjust(Placement& placed)
  {
    adjustHanging(placed);
    if (separateRivals(all(), {}, placed)) {
      separateHanging(placed);
      adjustment_.adjustRoughly(placed.assembly);
    }
  }
  /// Joint adjustment, and scans out that hang in free space by it.
  void
  adjustHanging(Placement& placed)
  {
    adjustment_.adjustRoughly(placed.assembly);
    if (separateHanging(placed))
      adjustment_.adjustRoughly(placed.assembly);
  }

  /// Put scans in doubt apart.
  void
  separate(const std::vector<Doubt>& doubts, const char* reason, Placement& placed) const
  {
    std::vector<int> out;
    for (const Doubt& doubt : doubts) {
      map_.notes.push_back(doubt.note);
      out.insert(out.end(), doubt.scans.begin(), doubt.scans.end());
    }
    putApart(out, reason, alike_.tied(), placed);
  }

  EvidenceFunction
  evidenceFunction() const
  {
    return [this](int source, int target, const Eigen::Isometry3d& T, double looseness) {
      return evidence_.at(source, target, T, looseness);
    };
  }

  const PreparedScan&
  scan(int i) const
  {
    return input_.prepared[static_cast<std::size_t>(i)];
  }
  std::vector<int>
  all() const
  {
    std::vector<int> scans(names_.size());
    std::iota(scans.begin(), scans.end(), 0);
    return scans;
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

  /// Why a pair has no pose: one of the scans is of no use, or what linking says.
  std::string
  whyNoPose(const std::pair<int, int>& pair, const std::string& message) const
  {
    for (const int i : {pair.first, pair.second}) {
      const MapScan& scan = map_.scans[static_cast<std::size_t>(i)];
      if (!scan.usable)
        return scan.name + ": " + scan.reason;
    }
    return "no pose of these scans was found" + (message.empty() ? "" : ": " + message);
  }

  /// What speaks against an accepted link is noted.
  void
  checkDecisions() const
  {
    for (const auto& pair : input_.decisions.accepted) {
      const auto link = std::find_if(links_.begin(), links_.end(), [&](const PairLink& l) {
        return l.source == pair.first && l.target == pair.second;
      });
      if (link == links_.end() || link->hypotheses.empty())
        throw DecisionError("the link " + name(pair.first) + ", " + name(pair.second) +
                            " cannot be accepted: " + whyNoPose(pair, link == links_.end() ? "" : link->message));
      const PairHypothesis& best = link->hypotheses.front();
      if (link->status == Status::Converged && best.probability >= input_.options.choice.sure)
        continue;
      char text[120];
      std::snprintf(text,
                    sizeof(text),
                    " is of little probability by the pair itself: %.2f, with an overlap of %.0f %%",
                    best.probability,
                    100 * best.overlap);
      map_.notes.push_back("the accepted link " + name(pair.first) + ", " + name(pair.second) + text +
                           (link->message.empty() ? "" : " (" + link->message + ")"));
    }
  }

  static std::size_t
  countParts(const Assembly& assembly)
  {
    return membersOf(assembly).size();
  }

  /// What a person said of a scan that is tied to others, for people.
  const char*
  whoPuts(int scan) const
  {
    return hasAcceptedLink(input_.decisions, scan) ? "a link puts it that a person accepted"
                                                   : "approximate poses put it";
  }

  /** \brief Put scans apart, each into a part of its own, for one reason; the links of all are chosen anew. Those that
   * a person tied to each other stay together: where scans of the part are tied to them that are not put apart, with
   * these, and with a note.
   * \param[in] tied tiedScans()
   * \return whether there are any
   */
  bool
  putApart(const std::vector<int>& scans, const char* reason, const std::vector<int>& tied, Placement& placed) const
  {
    Assembly& assembly = placed.assembly;
    const std::set<int> out(scans.begin(), scans.end());
    const auto piece = [&tied, before = assembly.part](std::size_t i) { return std::pair(before[i], tied[i]); };
    std::set<std::pair<int, int>> staying;
    for (std::size_t i = 0; i < tied.size(); ++i)
      if (out.count(static_cast<int>(i)) == 0)
        staying.insert(piece(i));
    std::map<std::pair<int, int>, int> parts; // of the pieces that are put apart
    for (const int scan : out) {
      const auto i = static_cast<std::size_t>(scan);
      if (staying.count(piece(i)) > 0) {
        const std::string note = name(scan) + " stays where " + whoPuts(scan) + ", though " + reason;
        if (std::find(map_.notes.begin(), map_.notes.end(), note) == map_.notes.end())
          map_.notes.push_back(note);
        continue;
      }
      assembly.part[i] = parts.try_emplace(piece(i), nextPart(assembly)).first->second;
      placed.reasons[i] = reason;
    }
    if (parts.empty())
      return false;
    chooseLinksAnew(placed);
    return true;
  }

  /// After scans were put apart: which links are used, and what they still hold together.
  void
  chooseLinksAnew(Placement& placed) const
  {
    chooseLinks(placed.assembly, links_, placed.graph, places_, input_.options.choice);
    splitUnconnected(placed.assembly, links_, placed.graph, input_.options.choice);
  }

  /** \brief Take scans out of their parts that hang in what the other scans saw to be free: each scan against all
   * others of its part, the worst one first. \return whether any was
   */
  bool
  separateHanging(Placement& placed)
  {
    std::vector<int> out;
    for (const auto& [part, members] : membersOf(placed.assembly)) {
      if (members.size() < 2)
        continue;
      const auto pairs = pairsOf(members);
      const std::vector<int> hanging = findHanging(
          members, pairs, evidence_.of(placed.assembly, members, pairs), contradictionWeight(input_.options));
      out.insert(out.end(), hanging.begin(), hanging.end());
    }
    return putApart(out,
                    "where its links put it, its surfaces hang in the free space of other scans, or theirs in its own",
                    accepted_,
                    placed);
  }

  /** \brief Put scans apart, of those asked about, that have a rival.
   * \param[in] piles PlacesAlike::piles()
   * \return whether there are any
   */
  bool
  separateRivals(const std::vector<int>& asked, const Piles& piles, Placement& placed) const
  {
    const std::vector<int> out = findScansWithRivals(asked,
                                                     {placed.assembly, links_, placed.graph, places_},
                                                     evidenceFunction(),
                                                     piles,
                                                     input_.decisions,
                                                     input_.options);
    return putApart(out, kHasRival, piles.empty() ? accepted_ : alike_.tied(), placed);
  }

  const MapInput& input_;
  const std::vector<PairLink>& links_;
  MultiwayMap& map_;
  const MultiwayRegistration::Progress& progress_;
  std::vector<std::string> names_;
  std::vector<Eigen::Vector3d> places_; ///< of the sensors in the frames of their scans [m]
  PlacedEvidence evidence_;
  MapAdjustment adjustment_;
  PlacesAlike alike_;
  std::vector<int> accepted_; ///< tiedScans() by accepted links alone
  std::size_t notes_ = 0;     ///< on what was decided
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
