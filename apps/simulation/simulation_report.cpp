// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/simulation_report.h>

#include <pcl_ssfr/version.h>

#include <apps/common/degrees.h>
#include <apps/common/format_text.h>

#include <algorithm>
#include <limits>

namespace pcl_ssfr::simulation {

namespace {

constexpr double kBytesPerMegabyte = 1e6;

/// Least and greatest of some values.
struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void
  add(double value)
  {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

std::string
joinedNames(const std::vector<SensorModel>& sensors)
{
  std::string text;
  for (const SensorModel& sensor : sensors)
    text += (text.empty() ? "" : ", ") + sensor.name;
  return text;
}

std::string
pairsText(const std::vector<DatasetPair>& pairs)
{
  if (pairs.empty())
    return "  pairs   none\n";
  Extent overlap;
  Extent rotation;
  Extent translation;
  for (const DatasetPair& pair : pairs) {
    overlap.add(pair.overlap);
    rotation.add(kDegreesPerRadian * Eigen::AngleAxisd(pair.T_target_source.linear()).angle());
    translation.add(pair.T_target_source.translation().norm());
  }
  return format("  pairs   %zu: overlap %.2f to %.2f, rotation %.1f to %.1f deg, translation %.2f to %.2f m\n",
                pairs.size(),
                overlap.low,
                overlap.high,
                rotation.low,
                rotation.high,
                translation.low,
                translation.high);
}

} // namespace

std::optional<std::string>
informationFor(const SimulateArguments& arguments)
{
  if (arguments.help)
    return simulateHelp();
  if (arguments.version)
    return std::string("ssfr_simulate " PCL_SSFR_VERSION "\n");
  if (arguments.list)
    return simulateList();
  if (arguments.print_sensor.empty())
    return std::nullopt;
  std::string json = formatSensor(loadSensor(arguments.print_sensor));
  if (json.empty() || json.back() != '\n')
    json += '\n';
  return json;
}

std::string
toText(const std::string& folder, const PreparedPlan& prepared, const DatasetSummary& summary, double seconds)
{
  return "Wrote " + folder + ": " + prepared.plan.name + ", scene " + prepared.scene.name + ", sensor " +
         joinedNames(prepared.sensors) + "\n" +
         format("  scans   %zu of %zu beams, %.0f points on average (%zu to %zu)\n",
                summary.scans,
                summary.beams,
                summary.mean_points,
                summary.least_points,
                summary.most_points) +
         pairsText(summary.pairs) +
         format("  %.1f MB in %.1f s\n", static_cast<double>(summary.bytes) / kBytesPerMegabyte, seconds);
}

} // namespace pcl_ssfr::simulation
