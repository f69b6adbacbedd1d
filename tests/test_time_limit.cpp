// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The time limit covers preparation: where it ends is said, and nothing half done is kept.

#include "cloud_views.h"
#include "pcl_clouds.h"

#include <pcl_ssfr/pipeline.h>
#include <pcl_ssfr/structured_scene_registration.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <string>
#include <vector>

namespace pcl_ssfr::test_time_limit {
namespace {

using namespace pcl_ssfr::testing;
using ::testing::HasSubstr;
using ::testing::Not;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Registration = StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ>;

constexpr double kAtOnce = 1e-9; // [s]

Cloud::Ptr
castHall(std::size_t station, double step, std::uint64_t seed)
{
  const Scene scene = makeHall(2);
  const Eigen::Matrix3Xf points = castScan(
      scene, sensorPose(scene.stations.at(station), static_cast<double>(station)), terrestrialScanner(step), seed);
  auto cloud = pcl::make_shared<Cloud>();
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    cloud->push_back(pcl::PointXYZ(points(0, i), points(1, i), points(2, i)));
  return cloud;
}

struct Clouds {
  Cloud::Ptr source, target;
};

/// Two scans of a hall, some 9,000 points each.
const Clouds&
smallClouds()
{
  static const Clouds clouds{castHall(1, 0.026, 1), castHall(0, 0.026, 2)};
  return clouds;
}

/// Some 400,000 points each.
const Clouds&
bigClouds()
{
  static const Clouds clouds{castHall(1, 0.004, 3), castHall(0, 0.004, 4)};
  return clouds;
}

void
setClouds(Registration& registration, const Clouds& clouds)
{
  registration.setInputSource(clouds.source);
  registration.setInputTarget(clouds.target);
}

std::vector<std::string>
namesOf(const std::vector<StageReport>& stages, const std::string& beginning)
{
  std::vector<std::string> names;
  for (const StageReport& stage : stages)
    if (stage.name.rfind(beginning, 0) == 0)
      names.push_back(stage.name.substr(beginning.size()));
  return names;
}

/// Seconds of the stages whose names begin so: the same to the last bit only when they were not run again.
std::vector<double>
secondsOf(const std::vector<StageReport>& stages, const std::string& beginning)
{
  std::vector<double> seconds;
  for (const StageReport& stage : stages)
    if (stage.name.rfind(beginning, 0) == 0)
      seconds.push_back(stage.seconds);
  return seconds;
}

void
expectSameAnswer(const Result& a, const Result& b)
{
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.T_target_source.matrix(), b.T_target_source.matrix());
  EXPECT_EQ(a.confidence, b.confidence);
  EXPECT_EQ(a.candidates.size(), b.candidates.size());
}

Options
withProfile(Profile profile)
{
  Options options = makeOptions(profile);
  options.threads = 2;
  return options;
}

class TimeLimit : public ::testing::TestWithParam<Profile> {};

TEST_P(TimeLimit, AScanThatIsNotReadySaysSo)
{
  const Options options = withProfile(GetParam());
  const auto [source, target] = prepareScans(
      viewOfCloud(*smallClouds().source), viewOfCloud(*smallClouds().target), options, Deadline::after(kAtOnce));
  for (const PreparedScan& scan : {source, target}) {
    EXPECT_FALSE(scan.empty());
    EXPECT_FALSE(scan.isComplete());
  }
  EXPECT_FALSE(PreparedScan().isComplete());
  const PreparedScan ready = prepareScan(viewOfCloud(*smallClouds().target), options);
  EXPECT_TRUE(ready.isComplete());

  const std::string first_stage = GetParam() == Profile::Default ? "thinning" : "normals";
  const Result result = registerScans(source, ready, options);
  EXPECT_EQ(result.status, Status::TimeLimit);
  EXPECT_THAT(result.message, HasSubstr("source"));
  EXPECT_THAT(result.message, HasSubstr('"' + first_stage + '"'));
  EXPECT_TRUE(result.candidates.empty());
  EXPECT_TRUE(result.T_target_source.matrix().isIdentity(0));
  EXPECT_THAT(registerScans(ready, target, options).message, HasSubstr("target"));
}

TEST_P(TimeLimit, PreparationEndsInAnyStage)
{
  const Options options = withProfile(GetParam());
  const ScanView scan = viewOfCloud(*smallClouds().source);
  const PreparedScan partner = prepareScan(viewOfCloud(*smallClouds().target), options);
  const auto start = Deadline::Clock::now();
  const PreparedScan whole = prepareScan(scan, options);
  const double seconds = std::chrono::duration<double>(Deadline::Clock::now() - start).count();
  const Result expected = registerScans(whole, partner, options);
  const std::string beginning = GetParam() == Profile::Default ? "source " : "source_";
  const std::vector<std::string> all = namesOf(expected.stages, beginning);
  ASSERT_GE(all.size(), 5U);

  constexpr int kSteps = 24;
  for (int k = 0; k <= kSteps; ++k) {
    const double limit = kAtOnce + 1.2 * seconds * k / kSteps;
    const PreparedScan scanned = prepareScan(scan, options, Deadline::after(limit));
    if (scanned.isComplete() && k < kSteps)
      continue; // of those the last is enough
    const Result result = registerScans(scanned, partner, options);
    const std::vector<std::string> names = namesOf(result.stages, beginning);
    ASSERT_FALSE(names.empty());
    ASSERT_LE(names.size(), all.size());
    EXPECT_TRUE(std::equal(names.begin(), names.end(), all.begin())) << "stages are left out at the end only";
    if (scanned.isComplete()) {
      EXPECT_EQ(names.size(), all.size());
      expectSameAnswer(result, expected);
    }
    else {
      EXPECT_EQ(result.status, Status::TimeLimit);
      EXPECT_THAT(result.message, HasSubstr('"' + names.back() + '"'));
    }
  }
}

TEST_P(TimeLimit, NothingHalfDoneIsKept)
{
  Registration fresh;
  fresh.setOptions(withProfile(GetParam()));
  setClouds(fresh, smallClouds());
  Cloud output;
  fresh.align(output);
  ASSERT_TRUE(fresh.hasConverged()) << fresh.getResult().message;

  Registration registration;
  registration.setOptions(withProfile(GetParam()));
  setClouds(registration, smallClouds());
  for (const double limit : {kAtOnce, 0.001, 0.004, 0.01, 0.02}) {
    registration.setTimeLimit(limit);
    registration.align(output);
    EXPECT_EQ(output.size(), smallClouds().source->size());
  }
  registration.setTimeLimit(0);
  registration.align(output);
  expectSameAnswer(registration.getResult(), fresh.getResult());
}

INSTANTIATE_TEST_SUITE_P(Profiles, TimeLimit, ::testing::Values(Profile::Default, Profile::Paper2017));

TEST(TimeLimitOfTheSearch, NoAnswerIsBelievedBeforeTheSearchIsComplete)
{
  const Options options = withProfile(Profile::Default);
  const auto [source, target] =
      prepareScans(viewOfCloud(*smallClouds().source), viewOfCloud(*smallClouds().target), options);
  const auto start = Deadline::Clock::now();
  const Result whole = registerScans(source, target, options);
  const double seconds = std::chrono::duration<double>(Deadline::Clock::now() - start).count();
  ASSERT_TRUE(whole.accepted()) << whole.message;

  constexpr int kSteps = 60;
  int cut_short = 0;
  for (int k = 0; k <= kSteps; ++k) {
    const double limit = kAtOnce + seconds * k / kSteps;
    const Result result = registerScans(source, target, options, nullptr, Deadline::after(limit));
    if (result.status != Status::TimeLimit) {
      expectSameAnswer(result, whole);
      EXPECT_EQ(result.message, whole.message);
      continue;
    }
    EXPECT_THAT(result.message, HasSubstr("time limit"));
    EXPECT_LE(result.confidence, 0.5);
    if (result.candidates.empty()) {
      EXPECT_TRUE(result.T_target_source.matrix().isIdentity(0));
      EXPECT_EQ(result.confidence, 0);
      continue;
    }
    ++cut_short;
    EXPECT_THAT(result.message, HasSubstr("so far: "));
    EXPECT_EQ(result.T_target_source.matrix(), result.candidates.front().T_target_source.matrix());
  }
  EXPECT_GT(cut_short, 0) << "of " << kSteps << " limits up to " << seconds << " s";
}

TEST(TimeLimitOfAlign, CutsPreparationShort)
{
  // By processor time: other processes take none of that.
  const auto secondsOfAlign = [](Registration& registration) {
    Cloud output;
    const std::clock_t start = std::clock();
    registration.align(output);
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  Registration free;
  setClouds(free, bigClouds());
  const double whole = secondsOfAlign(free);

  constexpr double kLimit = 0.005; // [s] far less than thinning takes
  Registration bound;
  setClouds(bound, bigClouds());
  bound.setTimeLimit(kLimit);
  EXPECT_LT(secondsOfAlign(bound), kLimit + 0.35 * whole);
  const Result& result = bound.getResult();
  EXPECT_EQ(result.status, Status::TimeLimit);
  EXPECT_FALSE(bound.hasConverged());
  EXPECT_THAT(result.message, HasSubstr("prepared"));
  EXPECT_LT(result.stages.size(), namesOf(free.getResult().stages, "source ").size());
  EXPECT_TRUE(bound.getFinalTransformation().isIdentity(0));
}

TEST(TimeLimitOfAlign, CachedScansCostNothing)
{
  Registration registration;
  setClouds(registration, smallClouds());
  Cloud output;
  registration.align(output);
  const std::vector<StageReport> stages = registration.getResult().stages;
  registration.setTimeLimit(kAtOnce);
  registration.align(output);
  const Result& result = registration.getResult();
  EXPECT_EQ(result.status, Status::TimeLimit);
  EXPECT_THAT(result.message, Not(HasSubstr("prepared")));
  for (const char* scan : {"source ", "target "})
    EXPECT_EQ(secondsOf(result.stages, scan), secondsOf(stages, scan));

  // Another target is not ready in time; the source still is.
  registration.setInputTarget(bigClouds().target);
  registration.align(output);
  EXPECT_EQ(result.status, Status::TimeLimit);
  EXPECT_THAT(result.message, HasSubstr("target scan was prepared"));
  registration.setInputTarget(smallClouds().target);
  registration.setTimeLimit(0);
  registration.align(output);
  EXPECT_TRUE(registration.hasConverged());
  EXPECT_EQ(secondsOf(result.stages, "source "), secondsOf(stages, "source "));
  EXPECT_NE(secondsOf(result.stages, "target "), secondsOf(stages, "target "));
}

TEST(TimeLimitOfAlign, OutputIsTheSourceMovedByTheGuess)
{
  for (const bool guessed : {false, true}) {
    Registration registration;
    setClouds(registration, smallClouds());
    registration.setTimeLimit(kAtOnce);
    Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
    if (guessed)
      guess(0, 3) = 3;
    Cloud output;
    registration.align(output, guess);
    EXPECT_EQ(registration.getResult().status, Status::TimeLimit);
    EXPECT_EQ(registration.getFinalTransformation(), guess);
    ASSERT_EQ(output.size(), smallClouds().source->size());
    for (std::size_t i = 0; i < output.size(); i += 97)
      EXPECT_NEAR(output[i].x, smallClouds().source->at(i).x + guess(0, 3), 1e-5);
  }
}

} // namespace
} // namespace pcl_ssfr::test_time_limit
