// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// How well limits are kept: the peak memory of a registration relative to its two clouds, and the time that it takes
// under a time limit. Simulated scans of a hall. See `limits_table --help`.

#include "cloud_views.h"
#include "common/angles.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/pipeline.h>
#include <pcl_ssfr/structured_scene_registration.h>

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ssfr;
using testing::viewOfCloud;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Registration = StructuredSceneRegistration<pcl::PointXYZ, pcl::PointXYZ>;

constexpr double kMebibyte = 1048576;
constexpr double kLimits[] = {0.01, 0.03, 0.1, 0.3, 1}; // [s]
constexpr std::uint64_t kSeed = 2;

const char* const kUsage =
    "usage: limits_table --memory | --time [options]\n"
    "  --memory         peak memory over the size of the two clouds, each in a process of its own\n"
    "  --time           time taken over the time limit, for scans of different places: the search\n"
    "                   goes on to its end there\n"
    "  --points N...    sizes of a cloud (default 100000 1000000 10000000)\n"
    "  --threads N      (default 2)\n";

struct Settings {
  bool memory = false;
  bool time = false;
  unsigned threads = 2;
  std::vector<double> points;
};

Settings
parse(int argc, char** argv)
{
  Settings settings;
  const auto isValue = [&](int i) { return i < argc && std::string(argv[i]).rfind("--", 0) != 0; };
  const auto number = [&](int i) {
    const double value = isValue(i) ? std::stod(argv[i]) : 0;
    if (!(value >= 1))
      throw std::invalid_argument("numbers must be at least 1");
    return value;
  };
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--memory")
      settings.memory = true;
    else if (argument == "--time")
      settings.time = true;
    else if (argument == "--threads")
      settings.threads = static_cast<unsigned>(number(++i));
    else if (argument == "--points")
      while (isValue(i + 1))
        settings.points.push_back(number(++i));
    else
      throw std::invalid_argument("unknown option " + argument);
  }
  if (settings.memory == settings.time)
    throw std::invalid_argument("give --memory or --time");
  if (settings.points.empty())
    settings.points = {1e5, 1e6, 1e7};
  return settings;
}

/// A scan of about \p points points from a station of a scene.
Cloud::Ptr
scanScene(const testing::Scene& scene, std::size_t station, double points)
{
  testing::SensorPattern pattern = testing::terrestrialScanner();
  pattern.azimuth_step = std::sqrt(2 * kPi * (pattern.elevation_max - pattern.elevation_min) / points);
  pattern.elevation_step = pattern.azimuth_step;
  const double yaw = 1.8 * static_cast<double>(station);
  const Eigen::Matrix3Xf scan = testing::castScan(
      scene, testing::sensorPose(scene.stations.at(station), 0.1 + yaw, 0.05 * yaw), pattern, station + 1);
  auto cloud = pcl::make_shared<Cloud>();
  cloud->resize(static_cast<std::size_t>(scan.cols()));
  for (Eigen::Index i = 0; i < scan.cols(); ++i)
    (*cloud)[static_cast<std::size_t>(i)].getVector3fMap() = scan.col(i);
  return cloud;
}

Options
optionsOf(const Settings& settings)
{
  Options options = makeOptions(Profile::Default);
  options.threads = settings.threads;
  return options;
}

double
secondsOf(const std::function<void()>& work)
{
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// ---------------------------------------------------------------------------------------------------------------------
// Memory

/// A value of /proc/self/status in bytes, "VmHWM:" (peak) or "VmRSS:" (now). \throw std::runtime_error it is not there
double
processBytes(const std::string& key)
{
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string name;
    double kibibytes = 0;
    if (words >> name >> kibibytes && name == key)
      return 1024 * kibibytes;
  }
  throw std::runtime_error("/proc/self/status has no " + key);
}

/// Let the peak begin anew. \throw std::runtime_error where the system does not allow it
void
forgetPeak()
{
  malloc_trim(0);
  std::ofstream clear("/proc/self/clear_refs");
  if (!(clear << "5" << std::flush))
    throw std::runtime_error("/proc/self/clear_refs cannot be written");
}

/// Memory beyond what was there before, at most, while \p work runs [bytes].
double
peakBytes(const std::function<void()>& work)
{
  forgetPeak();
  const double before = processBytes("VmRSS:");
  work();
  return processBytes("VmHWM:") - before;
}

/// Run \p work in a process of its own, so that nothing is left of what was measured before.
void
inProcessOfItsOwn(const std::function<void()>& work)
{
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0)
    throw std::runtime_error("no process can be started");
  if (child == 0) {
    int code = 0;
    try {
      work();
    }
    catch (const std::exception& error) {
      std::fprintf(stderr, "limits_table: %s\n", error.what());
      code = 3;
    }
    std::fflush(stdout);
    _exit(code);
  }
  int status = 0;
  if (waitpid(child, &status, 0) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("a measurement failed");
}

void
printMemoryRow(const char* name, double points, const Settings& settings, bool through_pcl)
{
  const Cloud::Ptr source = scanScene(testing::makeHall(kSeed), 1, points);
  const Cloud::Ptr target = scanScene(testing::makeHall(kSeed), 0, points);
  const double clouds =
      static_cast<double>(sizeof(pcl::PointXYZ)) * static_cast<double>(source->size() + target->size());
  Status status = Status::NotRun;
  const double peak = peakBytes([&] {
    if (through_pcl) {
      Registration registration;
      registration.setOptions(optionsOf(settings));
      registration.setInputSource(source);
      registration.setInputTarget(target);
      Cloud moved;
      registration.align(moved);
      status = registration.getResult().status;
      return;
    }
    const auto [s, t] = prepareScans(viewOfCloud(*source), viewOfCloud(*target), optionsOf(settings));
    status = registerScans(s, t, optionsOf(settings)).status;
  });
  std::printf("| %s | %.0f | %.0f | %.0f | %.2f | %.2f | %s |\n",
              name,
              0.5 * static_cast<double>(source->size() + target->size()),
              clouds / kMebibyte,
              peak / kMebibyte,
              peak / clouds,
              1 + peak / clouds,
              toString(status));
}

void
printMemory(const Settings& settings)
{
  std::printf(
      "Peak memory of one registration with %u threads, clouds of pcl::PointXYZ (16 bytes a point).\n\n"
      "| through | points a cloud | clouds [MiB] | beyond them [MiB] | beyond / clouds | clouds included / clouds | "
      "status |\n|---|---|---|---|---|---|---|\n",
      settings.threads);
  for (const double points : settings.points)
    for (const bool through_pcl : {false, true})
      inProcessOfItsOwn([&] {
        printMemoryRow(
            through_pcl ? "the PCL class" : "prepareScans(), registerScans()", points, settings, through_pcl);
      });
}

// ---------------------------------------------------------------------------------------------------------------------
// Time limit

void
printTime(const Settings& settings)
{
  std::printf(
      "Time over the time limit, %u threads, a scan of a street and one of a hall. "
      "Prepared: registerScans()\nof prepared scans. Whole: align() of the PCL class with new clouds.\n\n"
      "| points a cloud | preparation [s] | search without a limit [s] | limit [s] | prepared / limit | status | "
      "whole / limit | status |\n|---|---|---|---|---|---|---|---|\n",
      settings.threads);
  for (const double points : settings.points) {
    const Cloud::Ptr source = scanScene(testing::makeStreet(kSeed), 1, points);
    const Cloud::Ptr target = scanScene(testing::makeHall(kSeed), 0, points);
    Options options = optionsOf(settings);
    PreparedScan prepared_source;
    PreparedScan prepared_target;
    const double preparation = secondsOf([&] {
      std::tie(prepared_source, prepared_target) = prepareScans(viewOfCloud(*source), viewOfCloud(*target), options);
    });
    const double whole_search = secondsOf([&] { registerScans(prepared_source, prepared_target, options); });
    for (const double limit : kLimits) {
      options.time_limit = limit;
      Result result;
      const double search = secondsOf([&] { result = registerScans(prepared_source, prepared_target, options); });
      Registration registration;
      registration.setOptions(options);
      registration.setInputSource(source);
      registration.setInputTarget(target);
      Cloud moved;
      const double whole = secondsOf([&] { registration.align(moved); });
      std::printf("| %.0f | %.3f | %.3f | %.2f | %.2f | %s | %.2f | %s |\n",
                  points,
                  preparation,
                  whole_search,
                  limit,
                  search / limit,
                  toString(result.status),
                  whole / limit,
                  toString(registration.getResult().status));
      std::fflush(stdout);
    }
  }
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    if (argc == 2 && std::string(argv[1]) == "--help") {
      std::cout << kUsage;
      return 0;
    }
    const Settings settings = parse(argc, argv);
    if (settings.memory)
      printMemory(settings);
    else
      printTime(settings);
  }
  catch (const std::invalid_argument& error) {
    std::cerr << "limits_table: " << error.what() << '\n' << kUsage;
    return 2;
  }
  catch (const std::exception& error) {
    std::cerr << "limits_table: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
