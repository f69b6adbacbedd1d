// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "keyword_options.h"
#include "common/angles.h"
#include "common/config_numbers.h"

#include "scan_array.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr {
namespace python {

namespace py = pybind11;

namespace {

constexpr std::pair<const char*, Profile> kProfiles[] = {{"default", Profile::Default},
                                                         {"paper2017", Profile::Paper2017}};
constexpr std::pair<const char*, ViewpointMode> kViewpointModes[] = {{"auto", ViewpointMode::Auto},
                                                                     {"sensor", ViewpointMode::SensorOrigin},
                                                                     {"unknown", ViewpointMode::Unknown},
                                                                     {"unused", ViewpointMode::Unused}};
constexpr std::pair<const char*, double Options::*> kNumbers[] = {{"normal_radius", &Options::normal_radius},
                                                                  {"density_radius", &Options::density_radius},
                                                                  {"bin_width", &Options::bin_width},
                                                                  {"leaf", &Options::leaf},
                                                                  {"overlap_radius", &Options::overlap_radius},
                                                                  {"time_limit", &Options::time_limit},
                                                                  {"min_confidence", &Options::min_confidence}};
/// Keywords that a preparation reads; all others are of a search.
constexpr const char* kOfPreparation[] = {
    "profile", "viewpoint_mode", "normal_radius", "density_radius", "leaf", "threads", "numbers"};
constexpr std::pair<const char*, int Options::*> kCounts[] = {{"max_refinement_steps", &Options::max_refinement_steps},
                                                              {"max_candidates", &Options::max_candidates}};
std::invalid_argument
wrong(const std::string& name, const py::handle& value, const std::string& bound)
{
  return std::invalid_argument(name + " = " + py::repr(value).cast<std::string>() + ", must " + bound);
}

/// The value of \p name in a table of pairs, null when it is not listed.
template <typename Table>
auto*
findIn(const Table& table, const std::string& name)
{
  const auto found = std::find_if(std::begin(table), std::end(table), [&](const auto& e) { return name == e.first; });
  return found == std::end(table) ? nullptr : &found->second;
}

/// The value of an option of words.
template <typename Table>
auto
wordFrom(const Table& table, const std::string& name, const py::handle& value)
{
  if (py::isinstance<py::str>(value))
    if (const auto* found = findIn(table, value.cast<std::string>()))
      return *found;
  std::string words;
  for (const auto& [word, meaning] : table)
    words.append(words.empty() ? "be one of '" : ", '").append(word).append("'");
  throw wrong(name, value, words);
}

template <typename Table, typename Value>
const char*
wordOf(const Table& table, Value value)
{
  return std::find_if(std::begin(table), std::end(table), [&](const auto& e) { return e.second == value; })->first;
}

double
numberFrom(const std::string& name, const py::handle& value)
{
  const double number = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred()) {
    PyErr_Clear();
    throw wrong(name, value, "be a number");
  }
  return number;
}

int
countFrom(const std::string& name, const py::handle& value)
{
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  const long count = index ? PyLong_AsLong(index.ptr()) : 0;
  if (PyErr_Occurred() || count < std::numeric_limits<int>::min() || count > std::numeric_limits<int>::max()) {
    PyErr_Clear();
    throw wrong(name, value, "be a whole number");
  }
  return static_cast<int>(count);
}

bool
flagFrom(const std::string& name, const py::handle& value)
{
  py::detail::make_caster<bool> flag;
  if (!flag.load(value, false)) // bool and numpy's
    throw wrong(name, value, "be True or False");
  return flag;
}

unsigned
threadsFrom(const py::handle& value)
{
  const int threads = countFrom("threads", value);
  if (threads < 0)
    throw wrong("threads", value, "be 0 (all) or more");
  return static_cast<unsigned>(threads);
}

Eigen::Vector3d
directionFrom(const py::object& value)
{
  Eigen::Vector3d direction = vectorOrNone("gravity", value).value_or(Eigen::Vector3d::Zero()).stableNormalized();
  if (!(std::abs(direction.norm() - 1) < 1e-9)) // of zero
    throw wrong("gravity", value, "be a direction");
  return direction;
}

/// One direction up for both scans, a pair of them, or None.
std::optional<GravityPrior>
gravityFrom(const py::handle& handle)
{
  if (handle.is_none())
    return std::nullopt;
  const auto value = py::reinterpret_borrow<py::object>(handle);
  if (!py::isinstance<py::sequence>(value))
    throw wrong("gravity", value, "be a direction");
  GravityPrior gravity;
  if (py::len_hint(value) == 2 && py::len_hint(value[py::int_(0)]) > 0) {
    gravity.up_source = directionFrom(value[py::int_(0)]);
    gravity.up_target = directionFrom(value[py::int_(1)]);
  }
  else {
    gravity.up_source = gravity.up_target = directionFrom(value);
  }
  return gravity;
}

/// A pair of degrees and metres, or None.
std::optional<GuessTolerance>
guessToleranceFrom(const py::handle& value)
{
  if (value.is_none())
    return std::nullopt;
  if (!py::isinstance<py::sequence>(value) || py::len(value) != 2)
    throw wrong("guess_tolerance", value, "be a pair of degrees and metres");
  const auto pair = py::reinterpret_borrow<py::sequence>(value);
  return GuessTolerance{numberFrom("guess_tolerance", pair[0]) * kDegree, numberFrom("guess_tolerance", pair[1])};
}

void
setTunedNumbers(const py::handle& numbers, Options& options)
{
  if (!py::isinstance<py::dict>(numbers))
    throw wrong("numbers", numbers, "be a dict");
  for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(numbers)) {
    const auto name = py::str(key).cast<std::string>();
    setNumber(options.patch_profile, name, numberFrom(name, value));
  }
}

} // namespace

Options
optionsFrom(const py::dict& keywords, const Options& base)
{
  Options options = base;
  if (keywords.contains("profile")) {
    const Profile profile = wordFrom(kProfiles, "profile", keywords["profile"]);
    if (profile != base.profile)
      options = makeOptions(profile);
  }
  for (const auto& [key, value] : keywords) {
    const auto name = py::str(key).cast<std::string>();
    if (const auto* number = findIn(kNumbers, name))
      options.** number = numberFrom(name, value);
    else if (const auto* count = findIn(kCounts, name))
      options.** count = countFrom(name, value);
    else if (name == "threads")
      options.threads = threadsFrom(value);
    else if (name == "refine")
      options.refine = flagFrom(name, value);
    else if (name == "viewpoint_mode")
      options.viewpoint_mode = wordFrom(kViewpointModes, name, value);
    else if (name == "numbers")
      setTunedNumbers(value, options);
    else if (name == "guess_tolerance")
      options.guess_tolerance = guessToleranceFrom(value);
    else if (name == "gravity")
      options.gravity = gravityFrom(value);
    else if (name != "profile" && name != "gravity_tolerance_deg")
      throw std::invalid_argument(name + " is no option (default_options() lists them)");
  }
  if (keywords.contains("gravity_tolerance_deg")) {
    if (!options.gravity)
      throw std::invalid_argument("gravity_tolerance_deg needs gravity");
    options.gravity->tolerance = numberFrom("gravity_tolerance_deg", keywords["gravity_tolerance_deg"]) * kDegree;
  }
  validate(options);
  return options;
}

Options
preparationOptionsFrom(const py::dict& keywords)
{
  Options options = optionsFrom(keywords, makeOptions(Profile::Default)); // says what is no option at all
  for (const auto& [key, value] : keywords) {
    const auto name = py::str(key).cast<std::string>();
    if (std::find(std::begin(kOfPreparation), std::end(kOfPreparation), name) == std::end(kOfPreparation))
      throw std::invalid_argument(name + " is read by register_scans() only, give it there");
  }
  return options;
}

bool
haveSameNumbers(const Options& a, const Options& b)
{
  PatchProfileConfig of_a = a.patch_profile, of_b = b.patch_profile;
  const std::vector<ConfigNumber> numbers_a = numbersOf(of_a), numbers_b = numbersOf(of_b);
  return std::equal(numbers_a.begin(),
                    numbers_a.end(),
                    numbers_b.begin(),
                    [](const ConfigNumber& x, const ConfigNumber& y) { return x.value() == y.value(); });
}

py::dict
keywordsOf(const Options& options)
{
  py::dict keywords;
  keywords["profile"] = wordOf(kProfiles, options.profile);
  keywords["viewpoint_mode"] = wordOf(kViewpointModes, options.viewpoint_mode);
  for (const auto& [name, number] : kNumbers)
    keywords[name] = options.*number;
  for (const auto& [name, count] : kCounts)
    keywords[name] = options.*count;
  keywords["refine"] = options.refine;
  keywords["threads"] = options.threads;
  keywords["guess_tolerance"] = py::none();
  if (options.guess_tolerance)
    keywords["guess_tolerance"] =
        py::make_tuple(options.guess_tolerance->rotation / kDegree, options.guess_tolerance->translation);
  return keywords;
}

py::dict
defaultNumbers()
{
  PatchProfileConfig config;
  py::dict numbers;
  for (const ConfigNumber& number : numbersOf(config)) {
    const py::str name{std::string(number.name)};
    if (number.count)
      numbers[name] = *number.count;
    else
      numbers[name] = *number.real;
  }
  return numbers;
}

} // namespace python
} // namespace pcl_ssfr
