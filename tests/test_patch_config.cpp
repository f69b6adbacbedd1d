// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/config_numbers.h"
#include "patch_scenes.h"
#include "profiles/patch_profile.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <apps/io/loaded_cloud.h>
#include <pcl_ssfr/patch_config.h>

#include <pcl/common/io.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <iomanip>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ssfr::test_patch_config {
namespace {

using testing::viewOfPoints;

const std::vector<double> kFactors = {0.5, 1.7};

/// The numbers whose range is flat from half to 1.7 times their value for all cases below, with the reason.
const std::map<std::string, std::string> kFlat = {
    {"preparation.viewpoint.levels[1].places", "so many that the best is among them anyway"},
    {"preparation.viewpoint.levels[2].places", "so many that the best is among them"},
    {"preparation.viewpoint.levels[3].places", "two end at the same place"},
    {"preparation.viewpoint.grid_directions", "matters on open roads: test_hard_real_pairs, OpenRoad"},
    {"judgement.uncertainty.max_rotation", "directions are determined well or not at all; see test_pose_uncertainty"},
};

/// Set a number to one of two values, by its kind.
void
assign(const ConfigNumber& number, double real, int count)
{
  if (number.count)
    *number.count = count;
  else
    *number.real = real;
}

/// What validate() says of a config; empty: nothing.
std::string
problemOf(const PatchProfileConfig& config)
{
  try {
    validate(config);
  }
  catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// The usual config with number \p k multiplied; none: it may not have that value, or has it already, as 0 has.
std::optional<PatchProfileConfig>
changed(std::size_t k, double factor)
{
  PatchProfileConfig config;
  const ConfigNumber number = numbersOf(config)[k];
  const double usual = number.value();
  assign(number, usual * factor, static_cast<int>(std::lround(usual * factor)));
  if (numbersOf(config)[k].value() == usual)
    return std::nullopt;
  return problemOf(config).empty() ? std::optional(config) : std::nullopt;
}

/// Run \p once for each of \p count cases. \return them, the fastest first: most numbers change their answers already
template <typename Once>
std::vector<std::size_t>
fastestFirst(std::size_t count, const Once& once)
{
  std::vector<std::pair<double, std::size_t>> times;
  for (std::size_t i = 0; i < count; ++i) {
    const auto start = std::chrono::steady_clock::now();
    once(i);
    times.emplace_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), i);
  }
  std::sort(times.begin(), times.end());
  std::vector<std::size_t> order;
  for (const auto& [seconds, i] : times)
    order.push_back(i);
  return order;
}

/** \brief Whether number \p k, multiplied, changes the answer of any case, as \p changes says of a case and a config.
 * \param[in,out] cases the fastest first; the one that shows it comes after the fastest two then, for the numbers of a
 * group often matter in one case
 */
template <typename Changes>
bool
changesAny(std::size_t k, std::vector<std::size_t>& cases, const Changes& changes)
{
  const auto found = std::find_if(cases.begin(), cases.end(), [&](std::size_t i) {
    return std::any_of(kFactors.begin(), kFactors.end(), [&](double factor) {
      const std::optional<PatchProfileConfig> config = changed(k, factor);
      return config && changes(i, *config);
    });
  });
  if (found == cases.end())
    return false;
  constexpr std::ptrdiff_t kFastest = 2;
  if (found - cases.begin() > kFastest)
    std::rotate(cases.begin() + kFastest, found, found + 1);
  return true;
}

bool
isOfPreparation(const std::string& name)
{
  return name.rfind("preparation.", 0) == 0;
}

/// A scan that is prepared, and whether the place of its sensor is to be found.
struct Input {
  Eigen::Matrix3Xf points;
  ViewpointMode mode = ViewpointMode::Auto;
};

Eigen::Matrix3Xf
load(const std::string& name)
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  pcl::copyPointCloud(*io::loadCloud(std::string(PCL_SSFR_DATA_DIR) + "/" + name).points, cloud);
  Eigen::Matrix3Xf points(3, static_cast<Eigen::Index>(cloud.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = cloud[static_cast<std::size_t>(i)].getVector3fMap();
  return points;
}

/// Scans as they are, where the sensor is not known, thin, noisy, very noisy, tiny and huge.
std::vector<Input>
makeInputs()
{
  const Eigen::Matrix3Xf room = load("apartment_0.pcd");
  const Eigen::Matrix3Xf street = load("street_0.pcd");
  Eigen::Matrix3Xf thin(3, room.cols() / 30);
  for (Eigen::Index i = 0; i < thin.cols(); ++i)
    thin.col(i) = room.col(30 * i);
  testing::Random random(4);
  const auto noisy = [&](double deviation) {
    Eigen::Matrix3Xf points = room;
    for (Eigen::Index i = 0; i < points.size(); ++i)
      points.data()[i] += static_cast<float>(deviation * random.gaussian());
    return points;
  };
  const Eigen::Vector3f away(4, 3, 1);
  // Four rooms side by side: from everywhere some of one is behind another.
  const Eigen::Matrix3Xf one_room = testing::samplePoints(testing::roomRectangles(), 100, 3);
  Eigen::Matrix3Xf rooms(3, 4 * one_room.cols());
  for (int k = 0; k < 4; ++k)
    rooms.middleCols(k * one_room.cols(), one_room.cols()) =
        one_room.colwise() + Eigen::Vector3f(k % 2 ? 6.2f : 0, k / 2 ? 5.2f : 0, 0);
  std::vector<Input> inputs = {{room},
                               {street},
                               {room.colwise() + away, ViewpointMode::Unknown},
                               {street.colwise() + away, ViewpointMode::Unknown},
                               {rooms, ViewpointMode::Unknown},
                               {thin},
                               {noisy(0.03)},
                               {noisy(0.15)},
                               {0.01f * room},
                               {100.f * room}};
  // Off the sensor, where its place has hardly a contrast to those around.
  for (const float x : {-7.f, -7.5f})
    inputs.push_back({street.colwise() + Eigen::Vector3f(x, 0, 0)});
  return inputs;
}

/// Numbers that a change of the prepared scan changes.
std::vector<double>
fingerprint(const Input& input, const Options& options)
{
  Options these = options;
  these.viewpoint_mode = input.mode;
  const PatchScan scan = preparePatchScan(viewOfPoints(input.points), these);
  std::vector<double> numbers = {scan.scale,
                                 scan.thickness,
                                 scan.viewpoint.x(),
                                 scan.viewpoint.y(),
                                 scan.viewpoint.z(),
                                 scan.viewpoint_used ? 1. : 0.,
                                 static_cast<double>(scan.patches.size()),
                                 static_cast<double>(scan.coarse.size()),
                                 static_cast<double>(scan.votes.points.cols()),
                                 static_cast<double>(scan.surface.points.cols()),
                                 static_cast<double>(scan.clutter.cols()),
                                 static_cast<double>(scan.range_image.size()),
                                 scan.index.voxel()};
  numbers.push_back(0); // directions that patches face, where they are
  for (Eigen::Index i = 0; i < scan.patches.size(); ++i) {
    const Eigen::Vector3f place = scan.patches.samples.points.col(i).cast<float>();
    numbers.back() += static_cast<double>(std::bitset<64>(scan.index.mask(place)).count());
  }
  for (const MainNormal& m : scan.main_normals)
    numbers.insert(numbers.end(), {m.direction.x(), m.direction.y(), m.direction.z()});
  return numbers;
}

TEST(PatchConfig, EveryNumberOfThePreparationMattersOrIsFlat)
{
  const std::vector<Input> inputs = makeInputs();
  const Options usual = makeOptions(Profile::Default);
  std::vector<std::vector<double>> expected(inputs.size());
  std::vector<std::size_t> order =
      fastestFirst(inputs.size(), [&](std::size_t i) { expected[i] = fingerprint(inputs[i], usual); });
  const std::vector<std::string> names = numberNames();
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!isOfPreparation(names[k]) || names[k] == "preparation.min_points")
      continue;
    const bool changes = changesAny(k, order, [&](std::size_t i, const PatchProfileConfig& config) {
      if (names[k].find("levels") != std::string::npos && inputs[i].mode == ViewpointMode::Auto)
        return false; // sensors that are accepted at once
      Options options = usual;
      options.patch_profile = config;
      return fingerprint(inputs[i], options) != expected[i];
    });
    EXPECT_NE(changes, kFlat.count(names[k]) > 0) << names[k];
  }
}

/// A pair of scans and what is known of it.
struct PairCase {
  Eigen::Matrix3Xf source, target;
  Options options = makeOptions(Profile::Default);
  std::optional<Eigen::Isometry3d> guess = std::nullopt;
};

Eigen::Matrix3Xf
moved(const Eigen::Matrix3Xf& points, const Eigen::Isometry3f& T)
{
  return (T.linear() * points).colwise() + T.translation();
}

/// Points that a sensor with a narrow view sees.
Eigen::Matrix3Xf
ahead(const Eigen::Matrix3Xf& points, float least_cos)
{
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    if (points(0, i) > least_cos * points.col(i).norm())
      kept.push_back(i);
  Eigen::Matrix3Xf some(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k)
    some.col(static_cast<Eigen::Index>(k)) = points.col(kept[k]);
  return some;
}

/// Pairs that share much, little and nothing, with and without priors, where sensors are known and not, with a
/// direction that nothing determines, round, symmetric, and of few points.
std::vector<PairCase>
makePairs()
{
  const Eigen::Matrix3Xf room = load("apartment_0.pcd"), next = load("apartment_1.pcd");
  const Eigen::Matrix3Xf street = load("street_0.pcd"), farther = load("street_1.pcd");
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
  T.linear() = Eigen::AngleAxisf(2, Eigen::Vector3f(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<PairCase> cases = {{room, next}, {street, farther}, {moved(room, T), ahead(next, 0)}};
  cases.push_back({ahead(street, 0), ahead(farther, 0.3f)});
  cases.push_back({room, farther});
  for (const double tolerance : {0.01, 0.3}) {
    cases.push_back({ahead(street, 0.3f), ahead(farther, 0.3f)});
    cases.back().options.gravity = GravityPrior();
    cases.back().options.gravity->tolerance = tolerance;
  }
  cases.push_back({street, farther});
  cases.back().guess = Eigen::Isometry3d(Eigen::Translation3d(1, 0.5, 0));
  cases.push_back(cases.back());
  cases.back().options.guess_tolerance = GuessTolerance{0.3, 5};
  cases.push_back({moved(room, Eigen::Isometry3f(Eigen::Translation3f(4, 3, 1))), next});
  cases.back().options.viewpoint_mode = ViewpointMode::Unused;
  // A corridor without ends and a bare box.
  for (const float length : {40.f, 6.f}) {
    testing::Random random(8);
    Eigen::Matrix3Xf box(3, 40000);
    for (Eigen::Index i = 0; i < box.cols(); ++i) {
      Eigen::Vector3d p(
          (random.uniform(-0.5, 0.5)) * length, 3 * (random.uniform(-0.5, 0.5)), 2.5 * (random.uniform(-0.5, 0.5)));
      if (const Eigen::Index side = i % (length > 10 ? 4 : 6); side < 2)
        p.y() = side == 0 ? -1.5 : 1.5;
      else if (side < 4)
        p.z() = side == 2 ? -1.25 : 1.25;
      else
        p.x() = (side == 4 ? -0.5 : 0.5) * length;
      box.col(i) = (p + 0.003 * Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian())).cast<float>();
    }
    cases.push_back({moved(box.leftCols(20000), T), box.rightCols(20000)});
    if (length > 10) { // no other place along it is near enough
      cases.push_back(cases.back());
      cases.back().guess = T.inverse().cast<double>();
      cases.back().options.guess_tolerance = GuessTolerance{0.1, 0.2};
    }
  }
  // Walls all around.
  testing::Random random(9);
  Eigen::Matrix3Xf hall(3, 40000);
  for (Eigen::Index i = 0; i < hall.cols(); ++i) {
    const double angle = 2 * M_PI * random.uniform(0, 1);
    hall.col(i) =
        (i % 3 == 0 ? Eigen::Vector3d(6 * random.uniform(0, 1) - 3, 6 * random.uniform(0, 1) - 3, -1.5)
                    : Eigen::Vector3d(8 * std::cos(angle), 8 * std::sin(angle), 4 * random.uniform(0, 1) - 1.5))
            .cast<float>();
  }
  cases.push_back({moved(hall.leftCols(20000), T), hall.rightCols(20000)});
  // So few that what meets is not much.
  for (const auto& [points, step] : {std::pair(ahead(street, 0.5f), 20), {street, 20}, {street, 40}, {street, 80}}) {
    Eigen::Matrix3Xf few(3, points.cols() / step);
    for (Eigen::Index i = 0; i < few.cols(); ++i)
      few.col(i) = points.col(step * i);
    cases.push_back({few, farther});
  }
  cases.push_back({ahead(room, 0), ahead(next, 0.7f)});
  // As many points as are needed, almost.
  cases.push_back({room.leftCols(60), next});
  return cases;
}

/// A pair, prepared once for all numbers, which are not of the preparation.
struct PreparedCase {
  explicit PreparedCase(const PairCase& pair)
      : source(preparePatchScan(viewOfPoints(pair.source), pair.options)),
        target(preparePatchScan(viewOfPoints(pair.target), pair.options)), options(pair.options), guess(pair.guess)
  {}

  PatchScan source, target;
  Options options;
  std::optional<Eigen::Isometry3d> guess;
};

/// All that is said of a pair.
std::string
answer(const PreparedCase& pair, const Options& options)
{
  const Result result =
      registerPatchScans(pair.source, pair.target, options, pair.guess ? &*pair.guess : nullptr, Deadline(), nullptr);
  std::ostringstream text;
  text << std::setprecision(17) << toString(result.status) << result.message << result.confidence
       << result.T_target_source.matrix() << result.information << result.correspondence_distance;
  for (const Candidate& candidate : result.candidates)
    text << candidate.probability << ' ' << candidate.T_target_source.matrix();
  for (const StageReport& stage : result.stages)
    text << stage.name << stage.count_in << ' ' << stage.count_out << ' ';
  return text.str();
}

TEST(PatchConfig, EveryOtherNumberMattersOrIsFlat)
{
  std::vector<PreparedCase> pairs;
  for (const PairCase& pair : makePairs())
    pairs.emplace_back(pair);
  std::vector<std::string> expected(pairs.size());
  std::vector<std::size_t> order =
      fastestFirst(pairs.size(), [&](std::size_t i) { expected[i] = answer(pairs[i], pairs[i].options); });
  const std::vector<std::string> names = numberNames();
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (isOfPreparation(names[k]) && names[k] != "preparation.min_points")
      continue;
    const bool changes = changesAny(k, order, [&](std::size_t i, const PatchProfileConfig& config) {
      Options options = pairs[i].options;
      options.patch_profile = config;
      return answer(pairs[i], options) != expected[i];
    });
    EXPECT_NE(changes, kFlat.count(names[k]) > 0) << names[k];
  }
}

TEST(PatchConfig, NumbersAreSetByName)
{
  PatchProfileConfig config;
  setNumber(config, "search.screening_share", 0.25);
  EXPECT_EQ(config.search.screening_share, 0.25);
  setNumber(config, "search.little_overlap.refined", 7);
  EXPECT_EQ(config.search.little_overlap.refined, 7);
  EXPECT_THROW(setNumber(config, "search.rotations", 2.5), std::invalid_argument);
  EXPECT_THROW(setNumber(config, "search.rotations", 0), std::invalid_argument);
  EXPECT_THROW(setNumber(config, "search.no_such_number", 1), std::invalid_argument);
  const std::vector<std::string> names = numberNames();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  for (const std::string& name : names) {
    PatchProfileConfig usual;
    const double value =
        numbersOf(usual)[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())].value();
    EXPECT_NO_THROW(setNumber(config, name, value)) << name;
  }
}

TEST(PatchConfig, LengthsOfAPairAreScaledOnce)
{
  const PatchProfileConfig config, large = scaledForPair(config, 10, 2);
  EXPECT_DOUBLE_EQ(large.refinement.distinct_distance, 10 * config.refinement.distinct_distance);
  EXPECT_DOUBLE_EQ(large.judgement.evidence.loose_match, 20 * config.judgement.evidence.loose_match); // of noisy scans
  EXPECT_DOUBLE_EQ(large.preparation.match, 20 * config.preparation.match);
  EXPECT_DOUBLE_EQ(large.preparation.margin, 10 * config.preparation.margin);
  EXPECT_EQ(large.preparation.loose_facing, config.preparation.loose_facing);
  EXPECT_DOUBLE_EQ(large.preparation.leaf, scaled(config.preparation, 10).leaf); // as for each scan
  EXPECT_EQ(config.preparation.leaf, PreparationConfig().leaf);
}

TEST(PatchConfig, LengthsAreScaledOnce)
{
  const PreparationConfig config;
  const PreparationConfig large = scaled(config, 10);
  EXPECT_DOUBLE_EQ(large.leaf, 10 * config.leaf);
  EXPECT_DOUBLE_EQ(large.thickness, 10 * config.thickness);
  EXPECT_DOUBLE_EQ(large.match, 10 * config.match);
  EXPECT_DOUBLE_EQ(large.margin, 10 * config.margin);
  EXPECT_DOUBLE_EQ(large.viewpoint.contrast_distance, 10 * config.viewpoint.contrast_distance);
  for (std::size_t k = 0; k < config.viewpoint.levels.size(); ++k)
    EXPECT_DOUBLE_EQ(large.viewpoint.levels[k].step, 10 * config.viewpoint.levels[k].step);
  // What is no length stays.
  EXPECT_EQ(large.range_cell, config.range_cell);
  EXPECT_EQ(large.density_radius, config.density_radius);
  EXPECT_EQ(large.smallest_radius, config.smallest_radius);
  EXPECT_EQ(large.viewpoint.reach, config.viewpoint.reach);
  EXPECT_EQ(large.viewpoint.min_contrast, config.viewpoint.min_contrast);
}

TEST(PatchConfig, ErrorsNameTheFieldAndItsValue)
{
  EXPECT_NO_THROW(validate(PatchProfileConfig()));
  PatchProfileConfig usual;
  for (std::size_t k = 0; k < numbersOf(usual).size(); ++k) {
    PatchProfileConfig config;
    const ConfigNumber number = numbersOf(config)[k];
    assign(number, std::numeric_limits<double>::quiet_NaN(), -1);
    EXPECT_THAT(problemOf(config), ::testing::StartsWith(std::string(number.name) + " = "));
  }
  PatchProfileConfig config;
  config.preparation.leaf = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = PatchProfileConfig();
  config.preparation.viewpoint.levels[1].step *= 2; // coarser than the level before
  EXPECT_THROW(validate(config), std::invalid_argument);
  Options options = makeOptions(Profile::Default);
  options.patch_profile.preparation.range_cell = 2;
  EXPECT_THROW(validate(options), std::invalid_argument);
}

} // namespace
} // namespace pcl_ssfr::test_patch_config
