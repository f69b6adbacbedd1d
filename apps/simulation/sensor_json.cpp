// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/file_bytes.h>
#include <apps/simulation/built_in_sensors.h>
#include <apps/simulation/sensor_fields.h>
#include <apps/simulation/sensor_model.h>
#include <apps/simulation/simulation_error.h>

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ssfr::simulation {

namespace {

// Keeps the order in which fields are written.
using Json = nlohmann::ordered_json;

constexpr const char* kJsonEnding = ".json";
constexpr std::size_t kShownLength = 40;

/// A value for a one-line message.
std::string
shown(const Json& value)
{
  const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  return text.size() <= kShownLength ? text : text.substr(0, kShownLength) + "...";
}

[[noreturn]] void
fail(const std::string& field, const Json& value, const std::string& need)
{
  throw SimulationError(field + " is " + shown(value) + ", needs " + need);
}

/// Reads the fields of one object, and knows which were read: any other is an error.
class ObjectReader {
public:
  ObjectReader(const Json& object, std::string prefix) : object_(object), prefix_(std::move(prefix))
  {
    if (!object.is_object())
      fail(prefix_.empty() ? "the sensor" : prefix_.substr(0, prefix_.size() - 1), object, "an object {...}");
  }

  /// The value of a field; nothing when it is absent and not required.
  const Json*
  find(const std::string& name, bool required)
  {
    read_.push_back(name);
    const auto it = object_.find(name);
    if (it == object_.end() && required)
      throw SimulationError("field " + prefix_ + name + " is missing");
    return it == object_.end() ? nullptr : &*it;
  }
  void
  number(const std::string& name, double& value, bool required)
  {
    if (const Json* json = find(name, required))
      value = asNumber(prefix_ + name, *json);
  }
  template <typename Struct>
  void
  numbers(const std::vector<NumberField<Struct>>& fields, Struct& data)
  {
    for (const auto& field : fields)
      if (const Json* json = find(field.name, field.required)) {
        const double value = asNumber(prefix_ + field.name, *json);
        data.*field.member = field.degrees ? toRadians(value) : value;
      }
  }
  void
  text(const std::string& name, std::string& value, bool required)
  {
    if (const Json* json = find(name, required))
      value = asText(prefix_ + name, *json);
  }
  /// Three numbers.
  bool
  vector(const std::string& name, Eigen::Ref<Eigen::Vector3d> value)
  {
    const Json* json = find(name, false);
    if (json == nullptr)
      return false;
    if (!json->is_array() || json->size() != 3)
      fail(prefix_ + name, *json, "three numbers");
    for (std::size_t i = 0; i < 3; ++i)
      value(static_cast<Eigen::Index>(i)) = asNumber(prefix_ + name, (*json)[i]);
    return true;
  }
  /// Every field must have been read by now.
  void
  finish() const
  {
    for (const auto& item : object_.items())
      if (std::find(read_.begin(), read_.end(), item.key()) == read_.end())
        throw SimulationError("field " + prefix_ + io::inQuotes(item.key()) + " is not known, its value is " +
                              shown(item.value()));
  }

  static double
  asNumber(const std::string& field, const Json& json)
  {
    if (!json.is_number() || !std::isfinite(json.get<double>()))
      fail(field, json, "a number");
    return json.get<double>();
  }
  static std::string
  asText(const std::string& field, const Json& json)
  {
    if (!json.is_string())
      fail(field, json, "a text in quotes");
    return json.get<std::string>();
  }

private:
  const Json& object_;
  std::string prefix_;
  std::vector<std::string> read_;
};

BeamPattern
readPattern(const Json& json)
{
  ObjectReader reader(json, "pattern.");
  BeamPattern pattern;
  std::string kind;
  reader.text("kind", kind, true);
  const std::vector<PatternKind> kinds = patternKinds();
  const auto found =
      std::find_if(kinds.begin(), kinds.end(), [&](PatternKind known) { return patternName(known) == kind; });
  if (found == kinds.end()) {
    std::string known;
    for (const PatternKind name : kinds)
      known += (known.empty() ? "" : ", ") + patternName(name);
    fail("pattern.kind", kind, "one of " + known);
  }
  pattern.kind = *found;
  reader.numbers(patternNumbers(pattern.kind), pattern);
  for (const auto& field : patternCounts(pattern.kind)) {
    const Json& value = *reader.find(field.name, true);
    const double count = value.is_number() ? value.get<double>() : 0;
    if (!(count >= 1 && count <= std::numeric_limits<int>::max()) || count != std::floor(count))
      fail(std::string("pattern.") + field.name, value, "a positive whole number");
    pattern.*field.member = static_cast<int>(count);
  }
  if (pattern.kind == PatternKind::Rings) {
    const Json& rings = *reader.find("ring_elevations_deg", true);
    if (!rings.is_array())
      fail("pattern.ring_elevations_deg", rings, "a list of numbers");
    for (const Json& ring : rings)
      pattern.ring_elevations.push_back(toRadians(ObjectReader::asNumber("pattern.ring_elevations_deg", ring)));
  }
  if (pattern.kind == PatternKind::TurningLine) {
    reader.vector("turn_axis", pattern.turn_axis);
    const bool forward = reader.vector("plane_forward", pattern.plane_axes.col(0));
    const bool sideways = reader.vector("plane_sideways", pattern.plane_axes.col(1));
    if (forward != sideways)
      throw SimulationError(std::string("field pattern.") + (forward ? "plane_sideways" : "plane_forward") +
                            " is missing");
    if (!reader.vector("plane_normal", pattern.plane_axes.col(2)))
      pattern.plane_axes.col(2) = pattern.plane_axes.col(0).cross(pattern.plane_axes.col(1));
  }
  reader.finish();
  return pattern;
}

SensorModel
readSensor(const Json& json)
{
  ObjectReader reader(json, "");
  SensorModel sensor;
  reader.text("name", sensor.name, true);
  reader.text("description", sensor.description, false);
  if (const Json* sources = reader.find("sources", false)) {
    if (!sources->is_array())
      fail("sources", *sources, "a list of texts");
    for (const Json& source : *sources)
      sensor.sources.push_back(ObjectReader::asText("sources", source));
  }
  sensor.pattern = readPattern(*reader.find("pattern", true));
  ObjectReader range(*reader.find("range", true), "range.");
  range.numbers(rangeNumbers(), sensor.range);
  range.finish();
  reader.numbers(sensorNumbers(), sensor);
  reader.finish();
  validate(sensor);
  return sensor;
}

template <typename Struct>
void
write(Json& json, const std::vector<NumberField<Struct>>& fields, const Struct& data)
{
  for (const auto& field : fields) {
    const double value = data.*field.member;
    json[field.name] = field.degrees ? toDegrees(value) : value;
  }
}

Json
toJson(const Eigen::Vector3d& v)
{
  return Json::array({v.x(), v.y(), v.z()});
}

} // namespace

SensorModel
parseSensor(const std::string& json, const std::string& origin)
{
  try {
    return readSensor(Json::parse(json));
  }
  catch (const nlohmann::json::exception& error) {
    std::string what = error.what();
    std::replace_if(
        what.begin(), what.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    throw SimulationError(origin + ": is not JSON: " + what);
  }
  catch (const SimulationError& error) {
    throw SimulationError(origin + ": " + error.what());
  }
}

std::string
formatSensor(const SensorModel& sensor)
{
  validate(sensor);
  const BeamPattern& pattern = sensor.pattern;
  Json json;
  json["name"] = sensor.name;
  json["description"] = sensor.description;
  json["sources"] = sensor.sources;
  Json& beams = json["pattern"];
  beams["kind"] = patternName(pattern.kind);
  write(beams, patternNumbers(pattern.kind), pattern);
  for (const auto& field : patternCounts(pattern.kind))
    beams[field.name] = pattern.*field.member;
  if (pattern.kind == PatternKind::Rings) {
    Json& rings = beams["ring_elevations_deg"] = Json::array();
    for (const double elevation : pattern.ring_elevations)
      rings.push_back(toDegrees(elevation));
  }
  if (pattern.kind == PatternKind::TurningLine) {
    beams["turn_axis"] = toJson(pattern.turn_axis);
    beams["plane_forward"] = toJson(pattern.plane_axes.col(0));
    beams["plane_sideways"] = toJson(pattern.plane_axes.col(1));
    beams["plane_normal"] = toJson(pattern.plane_axes.col(2));
  }
  write(json["range"], rangeNumbers(), sensor.range);
  write(json, sensorNumbers(), sensor);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string>
sensorNames()
{
  std::vector<std::string> names;
  for (const BuiltInSensor& sensor : builtInSensors())
    names.push_back(sensor.name);
  return names;
}

SensorModel
makeSensor(const std::string& name)
{
  const std::string ending = kJsonEnding;
  if (name.size() > ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0) {
    std::string json;
    try {
      json = io::readFile(name);
    }
    catch (const io::IoError& error) {
      throw SimulationError(error.what());
    }
    return parseSensor(json, name);
  }
  std::string known;
  for (const BuiltInSensor& sensor : builtInSensors()) {
    if (sensor.name == name)
      return parseSensor(sensor.json, name);
    known += sensor.name + ", ";
  }
  throw SimulationError("sensor " + io::inQuotes(name) + " is not known; known are " + known +
                        "or the path of a sensor file that ends in .json");
}

} // namespace pcl_ssfr::simulation
