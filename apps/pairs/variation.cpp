// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/pairs/variation.h>

#include <apps/common/format_text.h>
#include <apps/io/text_scanner.h>

#include <stdexcept>
#include <type_traits>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

void
read(const Json& json, Perturbation& value)
{
  value = parsePerturbation(json.get<std::string>());
}

void
read(const Json& json, PairsFrom& value)
{
  value = parsePairsFrom(json.get<std::string>());
}

template <typename Number>
void
read(const Json& json, Number& value)
{
  value = json.get<Number>();
}

} // namespace

const char*
toString(Perturbation perturbation)
{
  switch (perturbation) {
  case Perturbation::None:
    return "none";
  case Perturbation::Rotation:
    return "rotation";
  case Perturbation::Se3:
    return "se3";
  }
  return "none";
}

const char*
toString(PairsFrom pairs)
{
  switch (pairs) {
  case PairsFrom::Listed:
    return "listed";
  case PairsFrom::Unlisted:
    return "unlisted";
  case PairsFrom::All:
    return "all";
  case PairsFrom::Unrelated:
    return "unrelated";
  }
  return "listed";
}

Perturbation
parsePerturbation(const std::string& text)
{
  for (const Perturbation p : {Perturbation::None, Perturbation::Rotation, Perturbation::Se3})
    if (text == toString(p))
      return p;
  throw std::invalid_argument(io::inQuotes(text) + " is not none, rotation or se3");
}

PairsFrom
parsePairsFrom(const std::string& text)
{
  for (const PairsFrom p : {PairsFrom::Listed, PairsFrom::Unlisted, PairsFrom::All, PairsFrom::Unrelated})
    if (text == toString(p))
      return p;
  throw std::invalid_argument(io::inQuotes(text) + " is not listed, unlisted, all or unrelated");
}

Json
toJson(const Variation& variation)
{
  Json json;
  forEachField(variation, [&json](const char* name, const auto& value) {
    if constexpr (std::is_enum_v<std::decay_t<decltype(value)>>)
      json[name] = toString(value);
    else
      json[name] = value;
  });
  return json;
}

Variation
variationFromJson(const Json& json)
{
  Variation variation;
  forEachField(variation, [&json](const char* name, auto& value) { read(json.at(name), value); });
  return variation;
}

std::vector<double>
orderOf(const Variation& variation)
{
  std::vector<double> order;
  forEachField(variation, [&order](const char*, const auto& value) { order.push_back(static_cast<double>(value)); });
  return order;
}

std::string
describeVariation(const Variation& variation)
{
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  const Degradation& degradation = variation.degradation;
  if (variation.pairs_from == PairsFrom::Unlisted)
    add("pairs that are not listed");
  if (variation.pairs_from == PairsFrom::All)
    add("all pairs");
  if (variation.pairs_from == PairsFrom::Unrelated)
    add("unrelated scans");
  if (variation.merge_target)
    add("another scan merged into the target");
  if (degradation.sector_deg < 360)
    add(format("a sector of %g degrees of the source", degradation.sector_deg));
  if (degradation.nearest < 1)
    add(format("the nearest %g %% of the source", 100 * degradation.nearest));
  if (degradation.every > 1)
    add(format("one of %zu points of the source", degradation.every));
  if (variation.resolution_m > 0)
    add(format("thinned to %.9g m", variation.resolution_m));
  if (variation.noise_m > 0)
    add(format("noise %.9g m", variation.noise_m));
  if (variation.outliers > 0)
    add(format("outliers %.9g %%", 100 * variation.outliers));
  if (variation.overlap > 0)
    add(format("overlap at most %.9g %%", 100 * variation.overlap));
  if (variation.mirror_source)
    add("source mirrored");
  if (variation.perturbation == Perturbation::Rotation)
    add("source rotated at random");
  if (variation.perturbation == Perturbation::Se3)
    add("source moved at random");
  if (variation.origin_offset_m > 0)
    add(format("origins %g m from the sensors", variation.origin_offset_m));
  return text.empty() ? "as it is" : text;
}

} // namespace apps
} // namespace pcl_ssfr
