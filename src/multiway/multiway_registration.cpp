// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/multiway/multiway_registration.h>

#include "common/angles.h"
#include "common/parallel.h"
#include "common/stage_clock.h"
#include "multiway/map_stages.h"
#include "multiway/project_file.h"
#include "multiway/scan_pair.h"

#include <pcl_ssfr/version.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace pcl_ssfr {

namespace {

/// Text that differs where links would.
std::string
settingsOf(const MultiwayOptions& options, const std::optional<PairGuess>& guess)
{
  std::string text = PCL_SSFR_VERSION;
  const auto add = [&text](double value) {
    char number[32];
    std::snprintf(number, sizeof(number), " %.17g", value);
    text += number;
  };
  const Options& r = options.registration;
  add(static_cast<double>(r.profile));
  add(static_cast<double>(r.viewpoint_mode));
  for (const double value :
       {r.normal_radius, r.density_radius, r.leaf, r.bin_width, r.overlap_radius, r.min_confidence})
    add(value);
  add(r.refine ? 1 : 0);
  add(options.link.hypotheses);
  add(options.link.least_probability);
  if (options.gravity) {
    for (const double value : *options.gravity)
      add(value);
    add(options.gravity_tolerance);
  }
  if (guess) {
    const Eigen::Matrix4d m = guess->T_target_source.matrix();
    for (Eigen::Index i = 0; i < m.size(); ++i)
      add(m.data()[i]);
    add(guess->tolerance.rotation);
    add(guess->tolerance.translation);
  }
  return text;
}

} // namespace

struct MultiwayRegistration::State {
  MultiwayOptions options;
  std::vector<PreparedScan> prepared;
  std::vector<MapScan> scans; ///< what is known of them before the map
  std::vector<int> original;  ///< of each scan: the first one with its points
  std::vector<std::optional<PosePrior>> priors;
  Decisions decisions;
  std::vector<int> pinned;
  PairLinker linker;
  std::unique_ptr<ProjectFile> project;
  double prepare_seconds = 0;

  void
  check(int scan) const
  {
    if (scan < 0 || scan >= static_cast<int>(scans.size()))
      throw std::invalid_argument("scan " + std::to_string(scan) + " is none of the " + std::to_string(scans.size()));
  }

  /// What the priors of two scans say of their pose.
  std::optional<PairGuess>
  guess(int source, int target) const
  {
    const auto& s = priors[static_cast<std::size_t>(source)];
    const auto& t = priors[static_cast<std::size_t>(target)];
    if (!s || !t)
      return std::nullopt;
    const double distance = (s->T_map_scan.translation() - t->T_map_scan.translation()).norm();
    GuessTolerance tolerance;
    tolerance.rotation = std::min(kPi, s->rotation + t->rotation);
    tolerance.translation = s->translation + t->translation + distance * t->rotation;
    return PairGuess{t->T_map_scan.inverse() * s->T_map_scan, tolerance};
  }

  void
  linkHere(const std::vector<PairTask>& tasks, const OnLink& on_link) const;
  std::vector<PairLink>
  linkAll(const Progress& progress) const;
};

void
MultiwayRegistration::State::linkHere(const std::vector<PairTask>& tasks, const OnLink& on_link) const
{
  forEachInParallel(
      static_cast<std::int64_t>(tasks.size()), 1, static_cast<int>(options.threads), [&](std::int64_t index) {
        const PairTask& task = tasks[static_cast<std::size_t>(index)];
        on_link(linkPair(task,
                         prepared[static_cast<std::size_t>(task.source)],
                         prepared[static_cast<std::size_t>(task.target)],
                         options));
      });
}

std::vector<PairLink>
MultiwayRegistration::State::linkAll(const Progress& progress) const
{
  std::vector<PairLink> links;
  for (std::size_t i = 0; i < scans.size(); ++i)
    for (std::size_t j = i + 1; j < scans.size(); ++j)
      if (scans[i].usable && scans[j].usable && original[i] == static_cast<int>(i) &&
          original[j] == static_cast<int>(j)) {
        PairLink link;
        link.source = static_cast<int>(i);
        link.target = static_cast<int>(j);
        links.push_back(link);
      }
  std::map<std::string, std::map<std::pair<std::uint64_t, std::uint64_t>, PairLink>> stored;
  std::vector<std::size_t> missing; // links that are not in the project, each with a task in the same order
  std::vector<PairTask> tasks;
  for (std::size_t k = 0; k < links.size(); ++k) {
    const auto [source, target] = std::pair(links[k].source, links[k].target);
    PairTask task{source,
                  target,
                  scans[static_cast<std::size_t>(source)].hash,
                  scans[static_cast<std::size_t>(target)].hash,
                  guess(source, target)};
    if (project) {
      const std::string settings = settingsOf(options, task.guess);
      auto found = stored.find(settings);
      if (found == stored.end())
        found = stored.emplace(settings, project->readLinks(settings)).first;
      const auto link = found->second.find({task.source_hash, task.target_hash});
      if (link != found->second.end()) {
        links[k] = link->second;
        links[k].source = source;
        links[k].target = target;
        continue;
      }
    }
    missing.push_back(k);
    tasks.push_back(std::move(task));
  }
  std::mutex mutex;
  std::size_t done = links.size() - missing.size();
  std::vector<bool> is_done(missing.size());
  if (progress)
    progress("link", done, links.size());
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
    if (project)
      project->writeLink(link, task->source_hash, task->target_hash, settingsOf(options, task->guess));
    links[missing[m]] = link;
    is_done[m] = true;
    ++done;
    if (progress)
      progress("link", done, links.size());
  };
  if (!linker)
    linkHere(tasks, on_link);
  else if (!tasks.empty())
    linker(tasks, on_link);
  if (done != links.size())
    throw std::runtime_error("a linker left out " + std::to_string(links.size() - done) + " of " +
                             std::to_string(tasks.size()) + " pairs");
  if (project)
    project->flush();
  return links;
}

MultiwayRegistration::MultiwayRegistration(const MultiwayOptions& options) : state_(std::make_unique<State>())
{
  validate(options);
  state_->options = options;
  Options threads;
  threads.threads = options.threads;
  state_->options.threads = threadCount(threads);
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
  for (const std::string& name : names) {
    if (name.empty() || find(name) >= 0)
      throw std::invalid_argument(name.empty() ? "a scan has no name" : "two scans are named " + name);
    state_->scans.emplace_back();
    state_->scans.back().name = name;
  }
  state_->prepared.resize(state_->scans.size());
  state_->priors.resize(state_->scans.size());
  Options options = state_->options.registration;
  options.threads = 1;
  std::mutex mutex;
  std::size_t done = 0;
  const auto threads = static_cast<int>(state_->options.threads);
  forEachInParallel(static_cast<std::int64_t>(names.size()), 1, threads, [&](std::int64_t index) {
    const std::size_t i = first + static_cast<std::size_t>(index);
    MapScan& scan = state_->scans[i];
    try {
      const ScanSource source = load(static_cast<std::size_t>(index));
      scan.points = source.view.count();
      scan.hash = hashOfPoints(source.view);
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
  });
  for (std::size_t i = first; i < state_->scans.size(); ++i) {
    int original = static_cast<int>(i);
    for (std::size_t k = 0; k < i && state_->scans[i].usable; ++k)
      if (state_->scans[k].usable && state_->scans[k].hash == state_->scans[i].hash) {
        original = static_cast<int>(k);
        break;
      }
    state_->original.push_back(original);
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
  state_->pinned.push_back(scan);
}

void
MultiwayRegistration::setPosePrior(int scan, const PosePrior& prior)
{
  state_->check(scan);
  if (!(prior.rotation > 0 && prior.rotation <= kPi) || !(prior.translation > 0))
    throw std::invalid_argument("the tolerance of a pose prior must be positive, and not more than half a turn");
  state_->priors[static_cast<std::size_t>(scan)] = prior;
}

void
MultiwayRegistration::setLinker(const PairLinker& linker)
{
  state_->linker = linker;
}

MultiwayMap
MultiwayRegistration::run(const Progress& progress)
{
  State& s = *state_;
  std::size_t usable = 0;
  for (std::size_t i = 0; i < s.scans.size(); ++i)
    usable += s.scans[i].usable && s.original[i] == static_cast<int>(i) ? 1 : 0;
  if (usable < 2)
    throw std::invalid_argument("a map takes two scans or more, " + std::to_string(usable) + " of " +
                                std::to_string(s.scans.size()) + " can be used");
  for (const auto& [a, b] : s.decisions.accepted) {
    const std::string pair =
        s.scans[static_cast<std::size_t>(a)].name + ", " + s.scans[static_cast<std::size_t>(b)].name;
    if (s.decisions.rejected.count({a, b}) > 0)
      throw std::invalid_argument("the link " + pair + " is both accepted and rejected");
    if (a == b)
      throw std::invalid_argument("the accepted link " + pair + " is of a scan with itself");
  }
  StageClock clock;
  MultiwayMap map;
  map.scans = s.scans;
  map.stages.push_back({"prepare", s.prepare_seconds, s.scans.size(), usable});
  const std::vector<PairLink> links = s.linkAll(progress);
  map.stages.push_back(clock.lap("link", usable, links.size()));
  const MapInput input = {s.prepared, s.original, s.priors, s.decisions, s.pinned, s.options};
  makeMap(input, links, map, progress);
  if (s.project) {
    std::vector<std::pair<std::string, std::string>> decisions;
    const auto name = [&](int i) { return s.scans[static_cast<std::size_t>(i)].name; };
    for (const auto& [a, b] : s.decisions.accepted)
      decisions.emplace_back("accept", name(a) + "," + name(b));
    for (const auto& [a, b] : s.decisions.rejected)
      decisions.emplace_back("reject", name(a) + "," + name(b));
    for (const int i : s.pinned)
      decisions.emplace_back("pin", name(i));
    s.project->writeMap(map, decisions);
  }
  return map;
}

} // namespace pcl_ssfr
