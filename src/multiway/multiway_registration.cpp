// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/multiway/multiway_registration.h>

#include "common/angles.h"
#include "common/parallel.h"
#include "common/rotation_math.h"
#include "common/stage_clock.h"
#include "common/types.h"
#include "multiway/candidate_pairs.h"
#include "multiway/link_settings.h"
#include "multiway/map_stages.h"
#include "multiway/project_file.h"
#include "multiway/scan_pair.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ssfr {

struct MultiwayRegistration::State {
  MultiwayOptions options;
  std::vector<PreparedScan> prepared;
  std::vector<MapScan> scans;        ///< what is known of them before the map
  std::vector<int> original;         ///< of each scan: the first one with its points
  std::vector<std::uint64_t> points; ///< of each scan: hashOfPoints()
  std::vector<std::optional<PosePrior>> priors;
  Decisions decisions; ///< as a person gave them
  PairLinker linker;
  std::unique_ptr<ProjectFile> project;
  double prepare_seconds = 0;

  void
  check(int scan) const
  {
    if (scan < 0 || scan >= static_cast<int>(scans.size()))
      throw std::invalid_argument("scan " + std::to_string(scan) + " is none of the " + std::to_string(scans.size()));
  }

  /// \throw std::invalid_argument
  void
  checkNew(const std::vector<std::string>& names) const
  {
    std::set<std::string> known;
    for (const MapScan& scan : scans)
      known.insert(scan.name);
    for (const std::string& name : names)
      if (name.empty() || !known.insert(name).second)
        throw std::invalid_argument(name.empty() ? "a scan has no name" : "two scans are named " + name);
  }

  /// Scans that are new are the originals of their points, as far as is known.
  void
  resize(std::size_t count)
  {
    const std::size_t before = scans.size();
    scans.resize(count);
    prepared.resize(count);
    priors.resize(count);
    points.resize(count);
    original.resize(count);
    for (std::size_t i = before; i < count; ++i)
      original[i] = static_cast<int>(i);
  }

  /// What the priors of two scans say of their pose.
  std::optional<PairGuess>
  guess(int source, int target) const
  {
    const auto& s = priors[static_cast<std::size_t>(source)];
    const auto& t = priors[static_cast<std::size_t>(target)];
    if (!s || !t)
      return std::nullopt;
    return guessOf(*s,
                   *t,
                   placeOf(prepared[static_cast<std::size_t>(source)]),
                   placeOf(prepared[static_cast<std::size_t>(target)]));
  }

  void
  linkHere(const std::vector<PairTask>& tasks, const OnLink& on_link) const;
  /// It can be registered, and is no copy of another one.
  bool
  isLinked(std::size_t scan) const;
  std::vector<ScanPair>
  allPairs() const;
  /// Not all pairs are linked.
  bool
  isByCandidates() const;
  /// \param[in] wanted pairs that are linked in any case
  CandidatePairs
  candidates(const std::set<ScanPair>& wanted) const;
  std::vector<PairLink>
  linkAll(const std::set<ScanPair>& wanted, const Progress& progress) const;

private:
  class LinkStage;
};

void
MultiwayRegistration::State::linkHere(const std::vector<PairTask>& tasks, const OnLink& on_link) const
{
  std::atomic<bool> has_failed{false}; // a link that cannot be kept: no other one is worth the time
  forEachInParallel(
      static_cast<std::int64_t>(tasks.size()), 1, static_cast<int>(options.threads), [&](std::int64_t index) {
        if (has_failed)
          return;
        const PairTask& task = tasks[static_cast<std::size_t>(index)];
        const PairLink link = linkPair(task,
                                       prepared[static_cast<std::size_t>(task.source)],
                                       prepared[static_cast<std::size_t>(task.target)],
                                       options);
        try {
          on_link(link);
        }
        catch (...) {
          has_failed = true;
          throw;
        }
      });
}

/// Links pairs that nobody linked, and finds those that somebody did.
class MultiwayRegistration::State::LinkStage {
public:
  LinkStage(const State& state, const Progress& progress)
      : state_(state), progress_(progress), settings_(settingsOf(state.options))
  {}

  /// Links of pairs, which must be new, are added. \param[in] pairs by source, then target
  void
  link(const std::vector<ScanPair>& pairs)
  {
    std::vector<std::size_t> missing; // links that are not in the project, each with a task in the same order
    std::vector<PairTask> tasks;
    const std::size_t first = links_.size();
    links_.resize(first + pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      PairTask task = taskOf(pairs[k]);
      std::optional<PairLink> known;
      if (state_.project)
        known = state_.project->readLink(task.source_hash, task.target_hash, withGuess(settings_, task.guess));
      if (known) {
        links_[first + k] = std::move(*known);
        links_[first + k].source = task.source;
        links_[first + k].target = task.target;
        continue;
      }
      missing.push_back(first + k);
      tasks.push_back(std::move(task));
    }
    std::mutex mutex;
    std::size_t done = links_.size() - missing.size();
    std::vector<bool> is_done(missing.size());
    report(done);
    const auto on_link = [&](const PairLink& link) {
      const std::lock_guard<std::mutex> lock(mutex);
      const auto pair = std::pair(link.source, link.target);
      const auto task = std::lower_bound(tasks.begin(), tasks.end(), pair, [](const PairTask& a, const auto& b) {
        return std::pair(a.source, a.target) < b;
      });
      const auto m = static_cast<std::size_t>(task - tasks.begin());
      if (task == tasks.end() || std::pair(task->source, task->target) != pair || is_done[m])
        throw std::runtime_error("a linker gave a link of the scans " + std::to_string(link.source) + " and " +
                                 std::to_string(link.target) + ", which was not asked for");
      if (state_.project)
        state_.project->writeLink(link, task->source_hash, task->target_hash, withGuess(settings_, task->guess));
      links_[missing[m]] = link;
      is_done[m] = true;
      report(++done);
    };
    if (!state_.linker)
      state_.linkHere(tasks, on_link);
    else if (!tasks.empty())
      state_.linker(tasks, on_link);
    if (done != links_.size())
      throw std::runtime_error("a linker left out " + std::to_string(links_.size() - done) + " of " +
                               std::to_string(tasks.size()) + " pairs");
    if (state_.project)
      state_.project->flush();
  }
  /// By source, then target.
  std::vector<PairLink>
  takeLinks()
  {
    std::sort(links_.begin(), links_.end(), [](const PairLink& a, const PairLink& b) {
      return std::pair(a.source, a.target) < std::pair(b.source, b.target);
    });
    return std::move(links_);
  }
  const std::vector<PairLink>&
  links() const
  {
    return links_;
  }

private:
  PairTask
  taskOf(const ScanPair& pair) const
  {
    return {pair.first,
            pair.second,
            state_.scans[static_cast<std::size_t>(pair.first)].hash,
            state_.scans[static_cast<std::size_t>(pair.second)].hash,
            state_.guess(pair.first, pair.second)};
  }
  void
  report(std::size_t done) const
  {
    if (progress_)
      progress_("link", done, links_.size());
  }

  const State& state_;
  const Progress& progress_;
  const std::string settings_;
  std::vector<PairLink> links_;
};

bool
MultiwayRegistration::State::isLinked(std::size_t scan) const
{
  return scans[scan].usable && original[scan] == static_cast<int>(scan);
}

std::vector<ScanPair>
MultiwayRegistration::State::allPairs() const
{
  std::vector<ScanPair> pairs;
  for (std::size_t i = 0; i < scans.size(); ++i)
    for (std::size_t k = i + 1; k < scans.size(); ++k)
      if (isLinked(i) && isLinked(k))
        pairs.emplace_back(static_cast<int>(i), static_cast<int>(k));
  return pairs;
}

CandidatePairs
MultiwayRegistration::State::candidates(const std::set<ScanPair>& wanted) const
{
  CandidateScans known;
  known.usable.resize(scans.size(), 0);
  known.places.resize(scans.size(), Eigen::Vector3d::Zero());
  known.T_map_scan.resize(scans.size());
  known.wanted = wanted;
  std::vector<double> scales;
  for (std::size_t i = 0; i < scans.size(); ++i)
    if (isLinked(i)) {
      known.usable[i] = 1;
      known.places[i] = placeOf(prepared[i]);
      if (priors[i])
        known.T_map_scan[i] = priors[i]->T_map_scan;
      scales.push_back(scaleOf(prepared[i]));
    }
  // One for all: their lengths are compared.
  std::nth_element(scales.begin(), scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2), scales.end());
  const double scale = scales[scales.size() / 2];
  known.signatures.resize(scans.size(), signatureOf({}, scale, options));
  const auto threads = static_cast<int>(options.threads);
  forEachInParallel(static_cast<std::int64_t>(scans.size()), 1, threads, [&](std::int64_t index) {
    const auto i = static_cast<std::size_t>(index);
    if (known.usable[i])
      known.signatures[i] = signatureOf(votesOf(prepared[i]), scale, options);
  });
  const auto overlap = [this](int source, int target, const Eigen::Isometry3d& T_target_source) {
    const PlacementEvidence evidence = evidenceAt(prepared[static_cast<std::size_t>(source)],
                                                  prepared[static_cast<std::size_t>(target)],
                                                  T_target_source,
                                                  options,
                                                  options.choice.loose);
    return evidence.total > 0 ? evidence.matched / evidence.total : 0;
  };
  return CandidatePairs(std::move(known), overlap, options);
}

bool
MultiwayRegistration::State::isByCandidates() const
{
  std::size_t count = 0;
  for (std::size_t i = 0; i < scans.size(); ++i)
    count += isLinked(i) ? 1 : 0;
  return options.pairs == PairRule::Candidates ||
         (options.pairs == PairRule::Auto && count > options.candidates.all_up_to);
}

std::vector<PairLink>
MultiwayRegistration::State::linkAll(const std::set<ScanPair>& wanted, const Progress& progress) const
{
  LinkStage stage(*this, progress);
  if (!isByCandidates()) {
    stage.link(allPairs());
    return stage.takeLinks();
  }
  CandidatePairs chosen = candidates(wanted);
  for (auto pairs = chosen.next(stage.links()); !pairs.empty(); pairs = chosen.next(stage.links()))
    stage.link(pairs);
  return stage.takeLinks();
}

MultiwayRegistration::MultiwayRegistration(const MultiwayOptions& options) : state_(std::make_unique<State>())
{
  validate(options);
  state_->options = options;
  state_->options.threads = threadCount(options.threads);
}

MultiwayRegistration::~MultiwayRegistration() = default;
MultiwayRegistration::MultiwayRegistration(MultiwayRegistration&&) noexcept = default;
MultiwayRegistration&
MultiwayRegistration::operator=(MultiwayRegistration&&) noexcept = default;

void
MultiwayRegistration::addScans(const std::vector<std::string>& names, const Loader& load, const Progress& progress)
{
  StageClock clock;
  const std::size_t first = state_->scans.size();
  state_->checkNew(names);
  state_->resize(first + names.size());
  for (std::size_t i = 0; i < names.size(); ++i)
    state_->scans[first + i].name = names[i];
  Options options = state_->options.registration;
  options.threads = 1;
  std::mutex mutex;
  std::size_t done = 0;
  const auto threads = static_cast<int>(state_->options.threads);
  const auto prepare = [&](std::int64_t index) {
    const std::size_t i = first + static_cast<std::size_t>(index);
    MapScan& scan = state_->scans[i];
    try {
      const ScanSource source = load(static_cast<std::size_t>(index));
      scan.points = source.view.count();
      state_->points[i] = hashOfPoints(source.view);
      scan.hash = hashOfScan(source.view, state_->points[i]);
      state_->prepared[i] = prepareScan(source.view, options);
      scan.reason = problemOf(state_->prepared[i]);
      scan.usable = scan.reason.empty();
      scan.bytes = bytesOf(state_->prepared[i]);
    }
    catch (const std::exception& error) {
      scan.reason = error.what();
    }
    const std::lock_guard<std::mutex> lock(mutex);
    ++done;
    if (progress)
      progress("prepare", done, names.size());
  };
  try {
    forEachInParallel(static_cast<std::int64_t>(names.size()), 1, threads, prepare);
  }
  catch (...) {
    state_->resize(first);
    throw;
  }
  for (std::size_t i = first; i < state_->scans.size(); ++i)
    for (std::size_t k = 0; k < i && state_->scans[i].usable; ++k)
      if (state_->scans[k].usable && state_->points[k] == state_->points[i]) {
        state_->original[i] = static_cast<int>(k);
        break;
      }
  state_->prepare_seconds += clock.elapsed();
}

int
MultiwayRegistration::addScan(const std::string& name, const ScanView& scan)
{
  addScans({name}, [&](std::size_t) { return ScanSource{scan, nullptr}; });
  return static_cast<int>(size()) - 1;
}

std::size_t
MultiwayRegistration::size() const
{
  return state_->scans.size();
}

int
MultiwayRegistration::find(const std::string& name) const
{
  for (std::size_t i = 0; i < state_->scans.size(); ++i)
    if (state_->scans[i].name == name)
      return static_cast<int>(i);
  return -1;
}

const PreparedScan&
MultiwayRegistration::preparedScan(int scan) const
{
  state_->check(scan);
  return state_->prepared[static_cast<std::size_t>(scan)];
}

void
MultiwayRegistration::openProject(const std::string& file, bool resume)
{
  state_->project = std::make_unique<ProjectFile>(file, resume);
}

void
MultiwayRegistration::accept(int a, int b)
{
  state_->check(a);
  state_->check(b);
  state_->decisions.accepted.emplace(std::min(a, b), std::max(a, b));
}

void
MultiwayRegistration::reject(int a, int b)
{
  state_->check(a);
  state_->check(b);
  state_->decisions.rejected.emplace(std::min(a, b), std::max(a, b));
}

void
MultiwayRegistration::pin(int scan)
{
  state_->check(scan);
  state_->decisions.pinned.push_back(scan);
}

void
MultiwayRegistration::setPosePrior(int scan, const PosePrior& prior)
{
  state_->check(scan);
  requireRigid(prior.T_map_scan, "T_map_scan");
  if (!(prior.rotation > 0 && prior.rotation <= kPi) || !(prior.translation > 0 && std::isfinite(prior.translation)))
    throw std::invalid_argument("the tolerance of a pose prior must be positive and finite, its rotation not more than "
                                "half a turn");
  const auto number = static_cast<std::size_t>(scan);
  PosePrior rigid = prior; // of a few digits it was close to a rotation, and all poses of the map follow from it
  if (!rigid.T_map_scan.linear().isUnitary(kRoundingOfSums))
    rigid.T_map_scan.linear() = nearestRotation(rigid.T_map_scan.linear());
  state_->priors[number] = rigid;
  if (std::optional<PosePrior>& first = state_->priors[static_cast<std::size_t>(state_->original[number])]; !first)
    first = rigid;
}

void
MultiwayRegistration::setLinker(const PairLinker& linker)
{
  state_->linker = linker;
}

void
MultiwayRegistration::writeToProject(const MultiwayMap& map)
{
  if (state_->project)
    state_->project->writeMap(map, inWords(state_->decisions, state_->scans));
}

MultiwayMap
MultiwayRegistration::run(const Progress& progress)
{
  State& s = *state_;
  std::size_t usable = 0;
  std::string reason;
  for (std::size_t i = 0; i < s.scans.size(); ++i) {
    usable += s.isLinked(i) ? 1 : 0;
    if (reason.empty() && !s.isLinked(i))
      reason =
          "; " + s.scans[i].name + ": " +
          (s.scans[i].usable ? "it holds the same points as " + s.scans[static_cast<std::size_t>(s.original[i])].name
                             : s.scans[i].reason);
  }
  if (usable < 2)
    throw std::invalid_argument("a map takes two scans or more, " + std::to_string(usable) + " of " +
                                std::to_string(s.scans.size()) + " can be used" + reason);
  const Decisions decisions = onOriginals(s.decisions, s.original, s.scans);
  StageClock clock;
  MultiwayMap map;
  map.scans = s.scans;
  map.stages.push_back({"prepare", s.prepare_seconds, s.scans.size(), usable});
  const std::vector<PairLink> links = s.linkAll(decisions.accepted, progress);
  map.stages.push_back(clock.lap("link", usable, links.size()));
  const MapInput input = {s.prepared, s.original, s.priors, decisions, s.options};
  makeMap(input, links, map, progress);
  writeToProject(map);
  return map;
}

} // namespace pcl_ssfr
