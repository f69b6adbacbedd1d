// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/paper_sets.h>

#include "common/angles.h"

#include <apps/io/io_error.h>
#include <apps/simulation/simulation_error.h>

#include <algorithm>
#include <iterator>

namespace pcl_ssfr::simulation {

namespace {

constexpr int kReducedScans = 3;
constexpr std::size_t kReducedPoints = 110000; // of 16 bytes each: under 2 MB with every scan's own deviation
constexpr std::size_t kBasicModelPoints = 100000;

/// A set as the paper describes it.
struct Entry {
  const char* name;
  const char* description;
  const char* scene;
  const char* sensor;
  int scans;
  std::size_t points; ///< a scan
  double step;        ///< between scans [m]
  double turn;        ///< largest, beyond that of the path [deg]
  double turn_limit;  ///< largest of all; 0: that of the path [deg]
};

// The paper gives scans and points; "small motions" (DS1-H), "large" (DS2-L), and navigation (DS3-V, DS4-S) in words.
constexpr Entry kEntries[] = {
    {"ds1h", "DS1-H: room scale, small motions", "apartment", "hokuyo_utm30lx", 45, 365000, 0.5, 10, 10},
    {"ds2l", "DS2-L: hall, large motions", "hall", "leica_p20", 6, 9000000, 10, 90, 0},
    {"ds3v", "DS3-V: street, driven", "street", "velodyne_hdl32e", 41, 56000, 2, 5, 10},
    {"ds4s", "DS4-S: corridor with rooms, driven", "office_floor", "sick_lms200", 63, 81600, 1, 10, 15},
};

PaperSet
makeBasicModel(bool reduced)
{
  PaperSet set;
  set.description = "basic model: no noise, three motions of growing size onto one target";
  DatasetPlan& plan = set.plan;
  plan.scene = "basic_model";
  plan.sensor = "leica_p20";
  plan.points = reduced ? kBasicModelPoints / 2 : kBasicModelPoints;
  plan.noise = false;
  plan.motions = {{},
                  {0.25, 4 * kDegree, 5 * kDegree, 0.02},
                  {1, 20 * kDegree, 8 * kDegree, 0.1},
                  {3, 75 * kDegree, 12 * kDegree, 0.25}};
  plan.pairs = PairRule::OntoFirst;
  return set;
}

} // namespace

std::vector<std::string>
paperSetNames()
{
  std::vector<std::string> names = {"basic_model"};
  for (const Entry& entry : kEntries)
    names.emplace_back(entry.name);
  return names;
}

PaperSet
makePaperSet(const std::string& name, bool reduced)
{
  PaperSet set;
  if (name == "basic_model")
    set = makeBasicModel(reduced);
  else {
    const auto entry =
        std::find_if(std::begin(kEntries), std::end(kEntries), [&](const Entry& e) { return e.name == name; });
    if (entry == std::end(kEntries))
      throw SimulationError("paper set " + io::inQuotes(name) + " is not known");
    set.description = entry->description;
    DatasetPlan& plan = set.plan;
    plan.scene = entry->scene;
    plan.sensor = entry->sensor;
    plan.points = reduced ? std::min(entry->points, kReducedPoints) : entry->points;
    plan.trajectory.scans = reduced ? kReducedScans : entry->scans;
    plan.trajectory.step = entry->step;
    plan.trajectory.turn = entry->turn * kDegree;
    plan.turn_limit = entry->turn_limit * kDegree;
  }
  set.plan.name = name + (reduced ? "_reduced" : "");
  set.plan.note = "simulated after Sanchez et al. 2017, " + set.description;
  return set;
}

} // namespace pcl_ssfr::simulation
