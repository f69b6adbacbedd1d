// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "bindings.h"
#include "keyword_options.h"
#include "scan_array.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/methods/file_frames.h>

#include <pybind11/stl.h>

#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>

namespace pcl_ssfr {
namespace python {

namespace py = pybind11;

namespace {

/// A prepared scan with what it was made of.
struct PreparedArray {
  PreparedScan scan;
  Eigen::Vector3d offset; ///< that was taken off its points [m]
  Options options;
  std::size_t points = 0;
};

/// One side of a registration: an array, or a scan that is prepared.
class Side {
public:
  Side(const std::string& name, const py::object& scan, const py::object& viewpoint, const py::object& normals)
  {
    if (!py::isinstance<PreparedArray>(scan)) {
      array_.emplace(name, scan, viewpoint, normals);
      return;
    }
    if (!viewpoint.is_none() || !normals.is_none()) {
      std::string message = name;
      message.append(viewpoint.is_none() ? "_normals" : "_viewpoint").append(": the ").append(name);
      throw std::invalid_argument(message + " is prepared already, give it to prepare_scan()");
    }
    prepared_ = scan.cast<PreparedArray>();
  }

  bool
  isArray() const
  {
    return array_.has_value();
  }
  ScanArray&
  array()
  {
    return *array_;
  }
  const PreparedArray&
  prepared() const
  {
    return *prepared_;
  }
  Eigen::Vector3d
  offset() const
  {
    return array_ ? array_->offset() : prepared_->offset;
  }
  /// The prepared scan; an array is prepared now.
  PreparedScan
  prepare(const Options& options, const Deadline& deadline) const
  {
    return array_ ? prepareScan(array_->view(), options, deadline) : prepared_->scan;
  }

private:
  std::optional<ScanArray> array_;
  std::optional<PreparedArray> prepared_;
};

/// As the programs register two files: the same calls, the same bits.
Result
registerSides(Side& source, Side& target, const Options& options, const std::optional<Eigen::Isometry3d>& guess)
{
  const Deadline deadline = Deadline::after(options.time_limit);
  for (Side* side : {&source, &target})
    if (side->isArray())
      side->array().prepare();
  const apps::FileFrames frames(source.offset(), target.offset());
  std::optional<Eigen::Isometry3d> cloud_guess;
  if (guess)
    cloud_guess = frames.toClouds(*guess);
  const auto [prepared_source, prepared_target] =
      source.isArray() && target.isArray()
          ? prepareScans(source.array().view(), target.array().view(), options, deadline)
          : std::pair(source.prepare(options, deadline), target.prepare(options, deadline));
  return frames.toFiles(
      registerScans(prepared_source, prepared_target, options, cloud_guess ? &*cloud_guess : nullptr, deadline));
}

Result
registerObjects(const py::object& source,
                const py::object& target,
                const py::object& guess,
                const py::object& source_viewpoint,
                const py::object& target_viewpoint,
                const py::object& source_normals,
                const py::object& target_normals,
                const py::dict& keywords)
{
  Side from("source", source, source_viewpoint, source_normals);
  Side to("target", target, target_viewpoint, target_normals);
  std::optional<Eigen::Isometry3d> pose;
  if (!guess.is_none())
    pose = poseFrom("guess", guess);
  const Options options = optionsFrom(keywords,
                                      !from.isArray() ? from.prepared().options
                                      : !to.isArray() ? to.prepared().options
                                                      : makeOptions(Profile::Default));
  for (const auto& [name, side] : {std::pair("source", &from), {"target", &to}})
    if (!side->isArray() && !side->prepared().scan.isPreparedWith(options))
      throw std::invalid_argument(std::string(name) + ": was prepared with other options than it is registered with");
  if (!from.isArray() && !to.isArray() && !keywords.contains("numbers") &&
      !haveSameNumbers(from.prepared().options, to.prepared().options))
    throw std::invalid_argument("numbers: source and target were prepared with other ones, say which");
  if (options.guess_tolerance && !pose)
    throw std::invalid_argument("guess_tolerance needs guess");
  const py::gil_scoped_release without_interpreter;
  return registerSides(from, to, options, pose);
}

PreparedArray
prepareObject(const py::object& points,
              const py::object& viewpoint,
              const py::object& normals,
              const py::dict& keywords)
{
  PreparedArray prepared;
  prepared.options = preparationOptionsFrom(keywords);
  ScanArray array("points", points, viewpoint, normals);
  const py::gil_scoped_release without_interpreter;
  array.prepare();
  prepared.scan = prepareScan(array.view(), prepared.options);
  prepared.offset = array.offset();
  prepared.points = array.view().size;
  return prepared;
}

/// A place that is None when it was not used.
py::object
placeOrNone(bool used, const Eigen::Vector3d& place)
{
  return used ? py::cast(place) : py::none();
}

std::string
describe(const Result& result)
{
  std::string text(120, '\0');
  const int size = std::snprintf(text.data(),
                                 text.size(),
                                 "<pcl_ssfr.Result %s, confidence %.3f, overlap %.2f>",
                                 toString(result.status),
                                 result.confidence,
                                 result.overlap);
  text.resize(static_cast<std::size_t>(size));
  return text;
}

void
bindCandidates(py::module_& module)
{
  py::class_<CandidateEvidence>(
      module, "CandidateEvidence", "Evidence about a pose beyond overlap and contradiction; of the default profile.")
      .def_readonly(
          "patches_matched", &CandidateEvidence::patches_matched, "Share of the patches that met one, [0, 1].")
      .def_readonly("patches_contradicted",
                    &CandidateEvidence::patches_contradicted,
                    "Share of the patches that lie in the other sensor's free space, [0, 1].")
      .def_readonly("facing_matched",
                    &CandidateEvidence::facing_matched,
                    "As patches_matched, of the patches that face their own sensor.")
      .def_readonly("beyond_planes",
                    &CandidateEvidence::beyond_planes,
                    "Of facing_matched, the patches that are in none of the three planes that determine the pose.")
      .def_readonly("facing_score", &CandidateEvidence::facing_score, "As Candidate.score, of these patches.")
      .def_readonly("unmatched",
                    &CandidateEvidence::unmatched,
                    "Share of the surface in view of the other sensor that met nothing, [0, 1].")
      .def_readonly("third_direction",
                    &CandidateEvidence::third_direction,
                    "Share of the matched surface that faces the least faced direction, [0, 1/3].")
      .def_readonly("held_second",
                    &CandidateEvidence::held_second,
                    "Matched surface that faces the second of the directions that it faces [m^2].")
      .def_readonly("held_third", &CandidateEvidence::held_third, "The same of the least faced direction [m^2].")
      .def_readonly("clutter",
                    &CandidateEvidence::clutter,
                    "Points that fit no plane and lie at the depth that the other sensor saw there.")
      .def_readonly("patches", &CandidateEvidence::patches, "Patches of both scans, by the fourth root of their area.")
      .def_readonly(
          "facing_patches", &CandidateEvidence::facing_patches, "Of these, those that face their own sensor.");

  py::class_<Candidate>(module, "Candidate", "A pose that was considered, with the evidence for and against it.")
      .def_property_readonly(
          "T_target_source",
          [](const Candidate& c) { return rowMajor(c.T_target_source.matrix()); },
          "Maps source points into the target frame, (4, 4) float64 [m].")
      .def_readonly("probability", &Candidate::probability, "That this pose is the right one, [0, 1].")
      .def_readonly("score", &Candidate::score, "Evidence for the pose less that against it.")
      .def_readonly("overlap", &Candidate::overlap, "Share of the surface that met its counterpart, [0, 1].")
      .def_readonly("contradiction", &Candidate::contradiction, "Share of the surface in free space, [0, 1].")
      .def_readonly("rmse", &Candidate::rmse, "As that of the result [m]; 0 where it was not measured.")
      .def_readonly("evidence", &Candidate::evidence, "What the probability is computed from.")
      .def_readonly("from_guess", &Candidate::from_guess, "It is the caller's guess, refined.");

  py::class_<UnobservableDirection>(
      module, "UnobservableDirection", "A direction of motion that the scene does not determine.")
      .def_readonly("direction", &UnobservableDirection::direction, "Unit vector in the target frame, (3,) float64.")
      .def_readonly("rotation", &UnobservableDirection::rotation, "A rotation about it; else a translation along it.")
      .def_readonly("strength",
                    &UnobservableDirection::strength,
                    "Information along it relative to the best determined one of its kind, [0, 1].");

  py::class_<StageReport>(module, "StageReport", "What went into and came out of one stage, and how long it took.")
      .def_readonly("name", &StageReport::name, "The stage.")
      .def_readonly("seconds", &StageReport::seconds, "Wall clock [s].")
      .def_readonly("count_in", &StageReport::count_in, "Things that went in: points, patches, poses, ...")
      .def_readonly("count_out", &StageReport::count_out, "Things that came out.");
}

void
bindResult(py::module_& module)
{
  py::class_<Result>(module, "Result", "All that a registration found. The pose may be used when it converged.")
      .def_property_readonly(
          "status",
          [](const Result& r) { return enumerator("Status", toString(r.status)); },
          "Why the registration ended; Status is a str: result.status == 'converged' works.")
      .def_property_readonly("converged", &Result::accepted, "The pose may be used: the status is converged.")
      .def_readonly("message", &Result::message, "One sentence: what was found, or why nothing was accepted.")
      .def_property_readonly(
          "T_target_source",
          [](const Result& r) { return rowMajor(r.T_target_source.matrix()); },
          "Maps source points into the target frame, (4, 4) float64 [m].")
      .def_readonly("overlap", &Result::overlap, "Of the best pose: share of the surface that met, [0, 1].")
      .def_readonly("contradiction", &Result::contradiction, "Of the best pose: share in free space, [0, 1].")
      .def_readonly(
          "confidence", &Result::confidence, "Estimated probability that the pose is right, [0, 1]; 0 in paper2017.")
      .def_readonly("probability_of_none", &Result::probability_of_none, "That none of the candidates is right.")
      .def_readonly("rmse", &Result::rmse, "Root mean square point-to-plane distance of the matches [m].")
      .def_readonly("correspondence_distance",
                    &Result::correspondence_distance,
                    "Largest distance of a correspondence that suits a refiner from this pose [m]; 0: not judged.")
      .def_property_readonly(
          "information",
          [](const Result& r) { return rowMajor(r.information); },
          "Inverse covariance of the pose, (6, 6) float64, order rotation [rad], translation [m]: small motions on "
          "the\n"
          "left, about the target's origin. Zero when nothing was judged.")
      .def_readonly("candidates", &Result::candidates, "Distinct poses, best first; the first is T_target_source.")
      .def_readonly("unobservable", &Result::unobservable, "Directions that the scene does not determine.")
      .def_readonly("stages", &Result::stages, "Counts and times of the stages, in order.")
      .def_property_readonly(
          "source_viewpoint",
          [](const Result& r) { return placeOrNone(r.source_viewpoint_used, r.source_viewpoint); },
          "Place of the source's sensor that was used, source frame, (3,) [m]; None: none was.")
      .def_property_readonly(
          "target_viewpoint",
          [](const Result& r) { return placeOrNone(r.target_viewpoint_used, r.target_viewpoint); },
          "Place of the target's sensor that was used, target frame, (3,) [m]; None: none was.")
      .def_readonly("source_viewpoint_found", &Result::source_viewpoint_found, "It was found in the points, not given.")
      .def_readonly("target_viewpoint_found", &Result::target_viewpoint_found, "It was found in the points, not given.")
      .def("__repr__", &describe);
}

} // namespace

void
bindPairs(py::module_& module)
{
  bindCandidates(module);
  bindResult(module);
  py::class_<PreparedArray>(
      module, "PreparedScan", "A scan made ready for registration with any number of others; made by prepare_scan().")
      .def_readonly("points", &PreparedArray::points, "Number of points that it was made of.")
      .def_property_readonly(
          "options", [](const PreparedArray& p) { return keywordsOf(p.options); }, "What it was prepared with.")
      .def("__repr__",
           [](const PreparedArray& p) { return "<pcl_ssfr.PreparedScan of " + std::to_string(p.points) + " points>"; });
  module.def("register_scans",
             &registerObjects,
             py::arg("source"),
             py::arg("target"),
             py::arg("guess"),
             py::arg("source_viewpoint"),
             py::arg("target_viewpoint"),
             py::arg("source_normals"),
             py::arg("target_normals"),
             py::arg("options"),
             "See pcl_ssfr.register_scans().");
  module.def("prepare_scan",
             &prepareObject,
             py::arg("points"),
             py::arg("viewpoint"),
             py::arg("normals"),
             py::arg("options"),
             "See pcl_ssfr.prepare_scan().");
  module.def(
      "default_options",
      [](const std::string& profile) {
        py::dict keywords;
        keywords["profile"] = profile;
        keywords["threads"] = 0;
        return keywordsOf(optionsFrom(keywords, Options()));
      },
      py::arg("profile"),
      "See pcl_ssfr.default_options().");
  module.def("default_numbers", &defaultNumbers, "See pcl_ssfr.default_numbers().");
}

} // namespace python
} // namespace pcl_ssfr
