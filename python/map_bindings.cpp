// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "bindings.h"
#include "common/angles.h"
#include "keyword_options.h"
#include "scan_array.h"

#include <pcl_ssfr/multiway/multiway_registration.h>

#include <apps/io/loaded_cloud.h>
#include <apps/methods/cloud_view.h>

#include <pybind11/stl.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace python {

namespace py = pybind11;

namespace {

/// A scan of a map: a file, or an array.
struct MapInput {
  std::string path;               ///< empty: an array
  std::optional<ScanArray> array; ///< of an array
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
};

/// All that a map depends on besides the scans.
struct MapDecisions {
  std::string project; ///< empty: none
  bool resume = false;
  std::vector<std::pair<std::string, std::string>> accept, reject;
  std::vector<std::string> pins;
  std::map<std::string, Eigen::Isometry3d> poses;
  std::pair<double, double> pose_tolerance; ///< [deg], [m]
};

/// \throw std::invalid_argument for another word than those of --pairs
PairRule
pairRuleFrom(const std::string& word)
{
  if (word == "auto")
    return PairRule::Auto;
  if (word == "all")
    return PairRule::All;
  if (word == "candidates")
    return PairRule::Candidates;
  throw std::invalid_argument("pairs: '" + word + "' is neither 'auto', 'all' nor 'candidates'");
}

/// Calls a function of Python from any thread. What it raises is kept until rethrow(), for no exception may leave a
/// thread.
class ProgressCall {
public:
  explicit ProgressCall(py::object function) : function_(std::move(function)) {}

  void
  operator()(const char* stage, std::size_t done, std::size_t total)
  {
    const py::gil_scoped_acquire with_interpreter;
    if (raised_)
      return;
    try {
      function_(stage, done, total);
    }
    catch (py::error_already_set& error) {
      raised_.emplace(std::move(error));
    }
  }

  /// With the interpreter.
  void
  rethrow()
  {
    if (raised_)
      throw py::error_already_set(*raised_);
  }

private:
  py::object function_;
  std::optional<py::error_already_set> raised_;
};

int
numberOf(const MultiwayRegistration& registration, const char* argument, const std::string& name)
{
  const int number = registration.find(name);
  if (number < 0)
    throw std::invalid_argument(std::string(argument) + ": " + name + " is none of the scans");
  return number;
}

/// Prepare the scans: files are read as there are threads, so that few are in memory.
void
addInputs(MultiwayRegistration& registration,
          const std::vector<std::string>& names,
          std::vector<MapInput>& inputs,
          const MultiwayRegistration::Progress& progress)
{
  registration.addScans(
      names,
      [&](std::size_t i) -> ScanSource {
        MapInput& input = inputs[i];
        if (input.array) {
          input.array->prepare();
          input.offset = input.array->offset();
          return {input.array->view(), std::shared_ptr<ScanArray>(&*input.array, std::mem_fn(&ScanArray::letCopiesGo))};
        }
        const auto points = std::make_shared<io::ScanPoints>(io::loadScanPoints(input.path));
        input.offset = points->offset;
        return {apps::viewOf(*points), points};
      },
      progress);
}

void
decide(MultiwayRegistration& registration, const MapDecisions& decisions, const std::vector<MapInput>& inputs)
{
  for (const auto& [name, pose] : decisions.poses) {
    const int scan = numberOf(registration, "poses", name);
    PosePrior prior;
    prior.T_map_scan = pose * Eigen::Translation3d(inputs[static_cast<std::size_t>(scan)].offset);
    prior.rotation = decisions.pose_tolerance.first * kDegree;
    prior.translation = decisions.pose_tolerance.second;
    registration.setPosePrior(scan, prior);
  }
  for (const std::string& name : decisions.pins)
    registration.pin(numberOf(registration, "pin", name));
  for (const auto& [a, b] : decisions.accept)
    registration.accept(numberOf(registration, "accept", a), numberOf(registration, "accept", b));
  for (const auto& [a, b] : decisions.reject)
    registration.reject(numberOf(registration, "reject", a), numberOf(registration, "reject", b));
}

/// From clouds that offsets were taken off to the coordinates of the caller; a scan with the identity keeps it.
void
toCallersCoordinates(MultiwayMap& map, const std::vector<MapInput>& inputs)
{
  std::map<int, Eigen::Isometry3d> frames; // of the components
  for (std::size_t i = 0; i < map.scans.size(); ++i)
    if (map.scans[i].T_map_scan.matrix().isIdentity(0))
      frames.emplace(map.scans[i].component, Eigen::Isometry3d(Eigen::Translation3d(inputs[i].offset)));
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    const auto frame = frames.find(map.scans[i].component);
    if (frame == frames.end() && inputs[i].offset.isZero(0))
      continue;
    map.scans[i].T_map_scan = (frame == frames.end() ? Eigen::Isometry3d::Identity() : frame->second) *
                              map.scans[i].T_map_scan * Eigen::Translation3d(-inputs[i].offset);
  }
  for (MapLink& link : map.links)
    link.T_target_source = Eigen::Translation3d(inputs[static_cast<std::size_t>(link.target)].offset) *
                           link.T_target_source *
                           Eigen::Translation3d(-inputs[static_cast<std::size_t>(link.source)].offset);
}

/// A map of files (str) and arrays with their viewpoints (tuples), in one frame per component.
MultiwayMap
mapObjects(const std::vector<std::string>& names,
           const py::list& scans,
           const py::object& gravity,
           const py::object& gravity_tolerance_deg,
           const std::string& pairs,
           const MapDecisions& decisions,
           const py::object& progress,
           const py::dict& keywords)
{
  std::vector<MapInput> inputs(py::len(scans));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const py::object scan = scans[i];
    if (py::isinstance<py::bytes>(scan))
      inputs[i].path = scan.cast<std::string>();
    else
      inputs[i].array.emplace(names[i], scan[py::int_(0)], scan[py::int_(1)], py::none());
  }
  if (keywords.contains("guess_tolerance"))
    throw std::invalid_argument("guess_tolerance: a map has no guess; poses and pose_tolerance say what is known");
  MultiwayOptions options;
  options.registration = optionsFrom(keywords, options.registration);
  options.threads = options.registration.threads;
  options.gravity = vectorOrNone("gravity", gravity);
  if (!gravity_tolerance_deg.is_none())
    options.gravity_tolerance = gravity_tolerance_deg.cast<double>() * kDegree;
  options.pairs = pairRuleFrom(pairs);
  ProgressCall call(progress);
  MultiwayRegistration::Progress show;
  if (!progress.is_none())
    show = std::ref(call);
  MultiwayMap map = [&] {
    const py::gil_scoped_release without_interpreter;
    MultiwayRegistration registration(options);
    if (!decisions.project.empty()) {
      try {
        registration.openProject(decisions.project, decisions.resume);
      }
      catch (const std::runtime_error& error) {
        throw io::IoError(error.what());
      }
    }
    addInputs(registration, names, inputs, show);
    decide(registration, decisions, inputs);
    MultiwayMap found = registration.run(show);
    toCallersCoordinates(found, inputs);
    registration.writeToProject(found);
    return found;
  }();
  call.rethrow();
  return map;
}

void
bindMapParts(py::module_& module)
{
  py::class_<MapScan>(module, "MapScan", "A scan in the map.")
      .def_readonly("name", &MapScan::name, "As it was given.")
      .def_readonly("points", &MapScan::points, "Number of points.")
      .def_readonly("usable", &MapScan::usable, "It could be read and can be registered.")
      .def_readonly("component", &MapScan::component, "Number of its component, by size from 0.")
      .def_property_readonly(
          "T_map_scan",
          [](const MapScan& s) { return rowMajor(s.T_map_scan.matrix()); },
          "Maps points of the scan into the frame of its component, (4, 4) float64 [m].")
      .def_property_readonly(
          "covariance",
          [](const MapScan& s) { return rowMajor(s.covariance); },
          "Of the pose, (6, 6) float64, order rotation [rad], translation [m]: small motions on the left, about the\n"
          "scan's sensor, relative to the scan that holds the frame.")
      .def_property_readonly(
          "sigma_rotation_deg",
          [](const MapScan& s) { return s.sigma_rotation / kDegree; },
          "Root of the trace of the covariance's rotation [deg].")
      .def_readonly(
          "sigma_translation_m", &MapScan::sigma_translation, "Root of the trace of the covariance's translation [m].")
      .def_readonly("links", &MapScan::links, "Number of links that are used.")
      .def_readonly("reason", &MapScan::reason, "Why it is not placed, or what is to be known of it.")
      .def("__repr__", [](const MapScan& s) {
        return "<pcl_ssfr.MapScan " + s.name + ", component " + std::to_string(s.component) + ">";
      });

  py::class_<MapLink>(module, "MapLink", "A pair of scans in the map.")
      .def_readonly("source", &MapLink::source, "Number of a scan in ScanMap.scans, less than target.")
      .def_readonly("target", &MapLink::target, "Number of the other scan.")
      .def_property_readonly(
          "status",
          [](const MapLink& l) { return enumerator("LinkStatus", toString(l.status)); },
          "What became of it: used, rejected, ambiguous or none.")
      .def_readonly("confidence", &MapLink::confidence, "That its pose is right, all pairs considered, [0, 1].")
      .def_readonly("overlap", &MapLink::overlap, "Share of the surface that meets, [0, 1].")
      .def_readonly("rmse", &MapLink::rmse, "Of plane distances of both scans [m].")
      .def_readonly("strength", &MapLink::strength, "Share of the matched surface that faces x, y, z of the target.")
      .def_readonly("below_6mm", &MapLink::below_6mm, "Share of the matches nearer than 6 mm, [0, 1].")
      .def_property_readonly(
          "residual_rotation_deg",
          [](const MapLink& l) { return l.residual_rotation / kDegree; },
          "Between the link's own pose and the map [deg].")
      .def_readonly("residual_translation_m", &MapLink::residual_translation, "The same, at the source's sensor [m].")
      .def_readonly("bridge", &MapLink::bridge, "It alone joins two parts of the map.")
      .def_readonly("reason", &MapLink::reason, "Why it is not used.")
      .def_property_readonly(
          "T_target_source",
          [](const MapLink& l) { return rowMajor(l.T_target_source.matrix()); },
          "Its own pose, (4, 4) float64 [m].");

  py::class_<LoopClosure>(module, "LoopClosure", "Three scans, and what is left after going round.")
      .def_readonly("scans", &LoopClosure::scans, "Their numbers, in order.")
      .def_property_readonly(
          "rotation_deg", [](const LoopClosure& l) { return l.rotation / kDegree; }, "What is left [deg].")
      .def_readonly("translation_m", &LoopClosure::translation, "What is left [m].");
}

} // namespace

void
bindMaps(py::module_& module)
{
  bindMapParts(module);
  py::class_<MultiwayMap>(module, "ScanMap", "Scans in one frame per component.")
      .def_readonly("scans", &MultiwayMap::scans, "In the order in which they were given.")
      .def_readonly("links", &MultiwayMap::links, "Of all pairs, by source, then target.")
      .def_readonly("components", &MultiwayMap::components, "Number of them, scans that were not placed included.")
      .def_readonly("placed", &MultiwayMap::placed, "Number of scans in components of two and more.")
      .def_readonly("bundle_error", &MultiwayMap::bundle_error, "Root mean square plane distance over all pairs [m].")
      .def_readonly("graph_error", &MultiwayMap::graph_error, "The same before the joint adjustment [m].")
      .def_readonly("median_misclosure", &MultiwayMap::median_misclosure, "Over triangles of used links [m].")
      .def_readonly("largest_misclosure", &MultiwayMap::largest_misclosure, "Over triangles of used links [m].")
      .def_readonly("loops", &MultiwayMap::loops, "Those that close worst, worst first.")
      .def_readonly("notes", &MultiwayMap::notes, "What is to be known of the map as a whole.")
      .def_readonly("stages", &MultiwayMap::stages, "Counts and times of the stages.")
      .def("__repr__", [](const MultiwayMap& m) {
        return "<pcl_ssfr.ScanMap of " + std::to_string(m.scans.size()) + " scans, " + std::to_string(m.components) +
               (m.components == 1 ? " component>" : " components>");
      });
  module.def(
      "map_scans",
      [](const std::vector<std::string>& names,
         const py::list& scans,
         const py::object& gravity,
         const py::object& gravity_tolerance_deg,
         const std::string& pairs,
         const std::string& project,
         bool resume,
         const std::map<std::string, py::object>& poses,
         const std::pair<double, double>& pose_tolerance,
         const std::vector<std::string>& pins,
         const std::vector<std::pair<std::string, std::string>>& accept,
         const std::vector<std::pair<std::string, std::string>>& reject,
         const py::object& progress,
         const py::dict& keywords) {
        MapDecisions decisions{project, resume, accept, reject, pins, {}, pose_tolerance};
        for (const auto& [name, pose] : poses)
          decisions.poses.emplace(name, poseFrom("poses: " + name, pose));
        return mapObjects(names, scans, gravity, gravity_tolerance_deg, pairs, decisions, progress, keywords);
      },
      py::arg("names"),
      py::arg("scans"),
      py::arg("gravity"),
      py::arg("gravity_tolerance_deg"),
      py::arg("pairs"),
      py::arg("project"),
      py::arg("resume"),
      py::arg("poses"),
      py::arg("pose_tolerance"),
      py::arg("pins"),
      py::arg("accept"),
      py::arg("reject"),
      py::arg("progress"),
      py::arg("options"),
      "See pcl_ssfr.map_scans().");
}

} // namespace python
} // namespace pcl_ssfr
