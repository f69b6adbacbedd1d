// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// ssfr_simulate as its users run it. PCL_SSFR_SIMULATE is the path of the program.

#include <apps/io/dataset_folder.h>
#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>
#include <apps/simulation/paper_sets.h>
#include <apps/simulation/sensor_model.h>
#include <apps/simulation/simulate_options.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

namespace pcl_ssfr::simulation::test_simulate_cli {
namespace {

namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::TemporaryFolder;

// ---------------------------------------------------------------------------------------------------------------------
// The command line as such

SimulateArguments
parse(const std::vector<std::string>& arguments)
{
  return parseSimulateArguments(arguments);
}

std::string
usageError(const std::vector<std::string>& arguments)
{
  try {
    parse(arguments);
  }
  catch (const apps::UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SimulateOptions, defaultsAreThoseOfThePlan)
{
  const auto arguments = parse({"--scene", "apartment", "--out", "x"});
  const DatasetPlan defaults;
  EXPECT_EQ(arguments.plan.scene, "apartment");
  EXPECT_EQ(arguments.plan.sensor, "");
  EXPECT_EQ(arguments.plan.trajectory.scans, defaults.trajectory.scans);
  EXPECT_EQ(arguments.plan.trajectory.turn, defaults.trajectory.turn);
  EXPECT_EQ(arguments.plan.seed, 1U);
  EXPECT_TRUE(arguments.plan.noise);
  EXPECT_EQ(arguments.plan.pair_reach, 1);
  EXPECT_FALSE(arguments.plan.random_rotation || arguments.overwrite || arguments.quiet);
}

TEST(SimulateOptions, buildingsAndSensorsCanBeChosen)
{
  const auto a = parse({"--scene",
                        "tower",
                        "--storeys",
                        "6",
                        "--alike",
                        "--sensor",
                        "livox_avia,leica_p20",
                        "--stations",
                        "--out",
                        "o"});
  EXPECT_EQ(a.plan.scene_options.storeys, 6);
  EXPECT_TRUE(a.plan.scene_options.alike);
  EXPECT_TRUE(a.plan.at_stations);
  EXPECT_THAT(sensorsOf(a.plan.sensor), ::testing::ElementsAre("livox_avia", "leica_p20"));
  EXPECT_THAT(usageError({"--scene", "tower", "--storeys", "1", "--out", "o"}), HasSubstr("--storeys: '1'"));
  EXPECT_THAT(usageError({"--scene", "hall", "--sensor", "leica_p20,kinect", "--out", "o"}), HasSubstr("'kinect'"));
  EXPECT_THAT(usageError({"--scene", "hall", "--sensor", "leica_p20,livox_avia", "--overlap", "0.5", "--out", "o"}),
              HasSubstr("--overlap contradicts several sensors"));
  EXPECT_THAT(usageError({"--scene", "tower", "--stations", "--scans", "3", "--out", "o"}),
              HasSubstr("--scans contradicts --stations"));
  EXPECT_THAT(usageError({"--paper-set", "ds1h", "--alike", "--out", "o"}), HasSubstr("--alike contradicts"));
}

TEST(SimulateOptions, everythingCanBeSet)
{
  const auto a = parse({"--scene=hall",
                        "--sensor",
                        "sick_lms200",
                        "--scans",
                        "7",
                        "--seed",
                        "9007199254740991",
                        "--start",
                        "3",
                        "--points",
                        "5e4",
                        "--step",
                        "1.5",
                        "--turn",
                        "90",
                        "--turn-limit",
                        "45",
                        "--tilt",
                        "18",
                        "--random-rotation",
                        "--velocity=-2",
                        "--turn-rate",
                        "180",
                        "--people",
                        "4",
                        "--doors",
                        "--shut-doors",
                        "0.25",
                        "--moved-furniture",
                        "0.5",
                        "--no-noise",
                        "--out",
                        "o",
                        "--pairs",
                        "3",
                        "--overwrite",
                        "--pictures",
                        "p",
                        "--quiet",
                        "--threads",
                        "2"});
  EXPECT_EQ(a.plan.scene, "hall");
  EXPECT_EQ(a.plan.sensor, "sick_lms200");
  EXPECT_EQ(a.plan.trajectory.scans, 7);
  EXPECT_EQ(a.plan.seed, 9007199254740991U);
  EXPECT_EQ(a.plan.start, 3);
  EXPECT_EQ(a.plan.beams, 50000U);
  EXPECT_EQ(a.plan.trajectory.step, 1.5);
  EXPECT_NEAR(a.plan.trajectory.turn, M_PI / 2, 1e-12);
  EXPECT_NEAR(a.plan.turn_limit, M_PI / 4, 1e-12);
  EXPECT_NEAR(a.plan.trajectory.tilt, M_PI / 10, 1e-12);
  EXPECT_TRUE(a.plan.random_rotation);
  EXPECT_EQ(a.plan.velocity, -2);
  EXPECT_NEAR(a.plan.turn_rate, M_PI, 1e-12);
  EXPECT_EQ(a.plan.movables.people, 4);
  EXPECT_TRUE(a.plan.movables.doors_move);
  EXPECT_EQ(a.plan.movables.shut_doors, 0.25);
  EXPECT_EQ(a.plan.movables.moved_furniture, 0.5);
  EXPECT_FALSE(a.plan.noise);
  EXPECT_EQ(a.out, "o");
  EXPECT_EQ(a.plan.pair_reach, 3);
  EXPECT_TRUE(a.overwrite && a.quiet);
  EXPECT_EQ(a.pictures, "p");
  EXPECT_EQ(a.threads, 2U);
  EXPECT_EQ(parse({"--scene", "hall", "--pairs", "all", "--out", "x"}).plan.pair_reach, kAllPairs);
  EXPECT_EQ(parse({"--scene", "hall", "--overlap", "0.4", "--out", "x"}).plan.trajectory.overlap, 0.4);
}

TEST(SimulateOptions, errorsNameOptionAndValue)
{
  const std::vector<std::string> good = {"--scene", "hall", "--out", "x"};
  const auto error_with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), good.begin(), good.end());
    return usageError(more);
  };
  EXPECT_EQ(error_with({}), "no error");
  struct Case {
    const char* option;
    const char* value;
  };
  for (const Case& c : {Case{"--scans", "0"}, {"--scans", "-1"},     {"--scans", "2.5"},
                        {"--scans", "many"},  {"--scans", "1e9"},    {"--seed", "-1"},
                        {"--seed", "1e30"},   {"--points", "0"},     {"--step", "0"},
                        {"--step", "nan"},    {"--step", "inf"},     {"--step", "1m"},
                        {"--overlap", "0"},   {"--overlap", "1"},    {"--turn", "-1"},
                        {"--tilt", "91"},     {"--velocity", "1e9"}, {"--turn-rate", "nan"},
                        {"--people", "-1"},   {"--people", "1.5"},   {"--moved-furniture", "1.1"},
                        {"--threads", "-1"},  {"--pairs", "0"},      {"--pairs", "some"},
                        {"--start", "-1"}})
    EXPECT_THAT(error_with({std::string(c.option) + "=" + c.value}),
                AllOf(StartsWith(c.option), HasSubstr(std::string("'") + c.value + "'")));
  EXPECT_THAT(error_with({"--step="}), HasSubstr("--step"));
  EXPECT_THAT(error_with({"--step", "1", "--overlap", "0.5"}), HasSubstr("contradicts"));
  EXPECT_THAT(error_with({"--start", "1", "--overlap", "0.5"}), HasSubstr("contradicts"));
  EXPECT_THAT(error_with({"--reduced"}), HasSubstr("--paper-set"));
  EXPECT_THAT(error_with({"--sensor", "lidar"}), AllOf(HasSubstr("'lidar'"), HasSubstr("leica_p20")));
  EXPECT_THAT(error_with({"--frobnicate"}), HasSubstr("--frobnicate"));
  EXPECT_THAT(error_with({"--scan", "3"}), HasSubstr("--scan"));
  EXPECT_THAT(error_with({"extra"}), HasSubstr("unexpected"));
  EXPECT_THAT(usageError({}), HasSubstr("--scene"));
  EXPECT_THAT(usageError({"--scene", "hall"}), HasSubstr("--out"));
  EXPECT_THAT(usageError({"--scene", "castle", "--out", "x"}),
              AllOf(HasSubstr("'castle'"), HasSubstr("two_floors_alike")));
  EXPECT_THAT(usageError({"--paper-set", "ds9", "--out", "x"}), AllOf(HasSubstr("'ds9'"), HasSubstr("ds4s")));
  EXPECT_THAT(usageError({"--paper-set", "ds1h", "--scene", "hall", "--out", "x"}), HasSubstr("--scene contradicts"));
  EXPECT_THAT(usageError({"--paper-set", "basic_model", "--scans", "3", "--out", "x"}),
              HasSubstr("--scans contradicts"));
  EXPECT_THAT(usageError({"--print-sensor", "lidar"}), HasSubstr("'lidar'"));
}

TEST(SimulateOptions, picturesLieOutsideOfTheDataset)
{
  const TemporaryFolder folder;
  const std::string out = folder.file("flat");
  const auto error = [](const std::string& dataset, const std::string& pictures) {
    return usageError({"--scene", "hall", "--out", dataset, "--pictures", pictures});
  };
  for (const char* inside : {"", "/", "/pictures", "/a/b/", "/../flat/./pictures"})
    EXPECT_THAT(error(out, out + inside), AllOf(StartsWith("--pictures: '"), HasSubstr("lies in --out"))) << inside;
  EXPECT_THAT(error(out + "/", out + "/pictures"), HasSubstr("lies in --out"));
  for (const char* outside : {"_pictures", "/../pictures", "/pictures/../../other"})
    EXPECT_EQ(error(out, out + outside), "no error") << outside;
  EXPECT_EQ(error(out + "/below", out), "no error");
  fs::create_directory(out);
  fs::create_directory_symlink(out, folder.file("link"));
  EXPECT_THAT(error(out, folder.file("link/pictures")), HasSubstr("lies in --out"));
}

TEST(SimulateOptions, helpNamesEveryOption)
{
  const std::string help = simulateHelp();
  for (const char* option :
       {"--scene",           "--sensor",   "--paper-set",    "--reduced",   "--scans",    "--seed",
        "--start",           "--points",   "--step",         "--overlap",   "--turn",     "--tilt",
        "--random-rotation", "--velocity", "--turn-rate",    "--people",    "--doors",    "--moved-furniture",
        "--no-noise",        "--out",      "--pairs",        "--overwrite", "--pictures", "--quiet",
        "--threads",         "--list",     "--print-sensor", "--help",      "--version",  "Exit code"})
    EXPECT_THAT(help, HasSubstr(option));
}

TEST(PaperSetPlans, areThoseOfThePaper)
{
  const auto plan = [](const char* name) { return makePaperSet(name, false).plan; };
  EXPECT_EQ(plan("ds1h").trajectory.scans, 45);
  EXPECT_EQ(plan("ds1h").points, 365000U);
  EXPECT_EQ(plan("ds2l").trajectory.scans, 6);
  EXPECT_EQ(plan("ds2l").points, 9000000U);
  EXPECT_EQ(plan("ds3v").trajectory.scans, 41);
  EXPECT_EQ(plan("ds3v").points, 56000U);
  EXPECT_EQ(plan("ds4s").trajectory.scans, 63);
  EXPECT_EQ(plan("ds4s").points, 81600U);
  EXPECT_EQ(plan("basic_model").motions.size(), 4U);
  EXPECT_FALSE(plan("basic_model").noise);
  for (const std::string& name : paperSetNames()) {
    const DatasetPlan small = makePaperSet(name, true).plan;
    EXPECT_GT(small.points, 0U) << name;
    EXPECT_LE(small.points * 16, 1.9e6) << name;
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// The program

struct Outcome {
  int code = -1;
  std::string output;
  std::string errors;
};

class SimulateProgram : public ::testing::Test {
protected:
  Outcome
  run(const std::string& arguments, const std::string& before = "") const
  {
    const std::string command = before + "'" + PCL_SSFR_SIMULATE + "' " + arguments + " >'" + folder_.file("stdout") +
                                "' 2>'" + folder_.file("stderr") + "'";
    const int status = std::system(command.c_str());
    EXPECT_TRUE(WIFEXITED(status)) << command;
    return {WEXITSTATUS(status), io::readFile(folder_.file("stdout")), io::readFile(folder_.file("stderr"))};
  }

  /// All files of a dataset, by name.
  std::string
  contentOf(const std::string& name) const
  {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.file(name)))
      if (entry.is_regular_file())
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::string content;
    for (const fs::path& file : files)
      content += fs::relative(file, folder_.file(name)).string() + "\n" + io::readFile(file.string());
    return content;
  }

  double
  meanPoints(const std::string& name) const
  {
    return nlohmann::json::parse(io::readFile(folder_.file(name + "/dataset.json")))["mean_points"].get<double>();
  }

  /// Names in the folder besides what run() puts there.
  std::vector<std::string>
  leftOver() const
  {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.file("")))
      if (entry.path().filename() != "stdout" && entry.path().filename() != "stderr")
        names.push_back(entry.path().filename().string());
    return names;
  }

  TemporaryFolder folder_;
};

TEST_F(SimulateProgram, helpVersionAndList)
{
  const Outcome help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.output, StartsWith("Usage: ssfr_simulate "));
  EXPECT_EQ(help.errors, "");
  EXPECT_THAT(run("--version").output, StartsWith("ssfr_simulate "));
  const Outcome list = run("--list");
  EXPECT_EQ(list.code, 0);
  for (const char* name : {"basic_model",
                           "apartment",
                           "office_floor",
                           "hall",
                           "street",
                           "endless_corridor",
                           "symmetric_room",
                           "cylinder_hall",
                           "slanted",
                           "cave",
                           "two_floors_alike",
                           "tower",
                           "hotel_corridor",
                           "twin_wings",
                           "plant_hall",
                           "rooms_with_doors",
                           "campus",
                           "tree_road",
                           "industrial_site",
                           "car_park_levels",
                           "forest_edge",
                           "hokuyo_utm30lx",
                           "leica_p20",
                           "velodyne_hdl32e",
                           "velodyne_vlp16",
                           "sick_lms200",
                           "livox_mid360",
                           "ouster_os1_128",
                           "livox_avia",
                           "aeva_aeries2",
                           "ds1h",
                           "ds2l",
                           "ds3v",
                           "ds4s"})
    EXPECT_THAT(list.output, HasSubstr(std::string("  ") + name + " "));
}

TEST_F(SimulateProgram, everyErrorIsOneLineAndLeavesNothing)
{
  io::writeFile(folder_.file("stdout"), "");
  const std::string files = folder_.file("files");
  fs::create_directories(files);
  io::writeFile(files + "/empty.obj", "# nothing\n");
  io::writeFile(files + "/nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n");
  io::writeFile(files + "/bad.json", "{\"name\": 3}");
  struct Case {
    std::string arguments;
    int code;
    std::string named;
  };
  const std::string out = " --out " + folder_.file("set");
  const Case cases[] = {
      {"", 2, "--scene"},
      {"--scene castle" + out, 2, "castle"},
      {"--scene hall --sensor lidar" + out, 2, "lidar"},
      {"--scene hall --scans 0" + out, 2, "--scans"},
      {"--scene hall --points 0" + out, 2, "--points"},
      {"--scene hall --frobnicate" + out, 2, "--frobnicate"},
      {"--scene " + files + "/none.obj" + out, 3, "none.obj"},
      {"--scene " + files + "/empty.obj --sensor leica_p20" + out, 3, "empty.obj"},
      {"--scene " + files + "/nan.obj --sensor leica_p20" + out, 3, "nan.obj"},
      {"--scene hall --sensor " + files + "/none.json" + out, 3, "none.json"},
      {"--scene hall --sensor " + files + "/bad.json" + out, 3, "bad.json"},
      {"--scene basic_model --out " + files + "/bad.json/set", 3, "bad.json/set"},
      {"--scene basic_model --out " + files, 3, "not empty"},
      {"--scene basic_model --overwrite --out " + files, 3, "not replaced"},
      {"--scene basic_model --out /proc/set", 3, "/proc/set"},
      {"--scene basic_model --pictures /proc/set", 3, "/proc/set"},
      {"--scene basic_model" + out + " --pictures " + folder_.file("set/pictures"), 2, "--pictures"},
  };
  for (const Case& c : cases) {
    const Outcome result = run(c.arguments);
    EXPECT_EQ(result.code, c.code) << c.arguments;
    EXPECT_EQ(result.output, "") << c.arguments;
    EXPECT_THAT(result.errors, AllOf(StartsWith("ssfr_simulate: "), HasSubstr(c.named))) << c.arguments;
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    EXPECT_THAT(leftOver(), ::testing::ElementsAre("files")) << c.arguments;
  }
}

TEST_F(SimulateProgram, aScanOfNothingIsAnError)
{
  std::filesystem::create_directory(folder_.file("files"));
  struct Case {
    const char* field;
    double value;
    int code;
    const char* named;
  };
  for (const Case& c : {Case{"mount_height_m", 20, 2, "scan 0: nothing returns to "},
                        Case{"max_range_m", 0.6, 2, "scan 0: nothing returns to "},
                        Case{"mount_height_m", -1, 3, "mount_height_m is -1"}}) {
    auto sensor = nlohmann::json::parse(simulation::formatSensor(simulation::makeSensor("velodyne_vlp16")));
    nlohmann::json& owner = sensor.contains(c.field) ? sensor : sensor["range"];
    owner[c.field] = c.value;
    io::writeFile(folder_.file("files/sensor.json"), sensor.dump());
    const Outcome result = run("--scene apartment --scans 2 --sensor " + folder_.file("files/sensor.json") + " --out " +
                               folder_.file("set") + " --quiet");
    EXPECT_EQ(result.code, c.code) << c.field;
    EXPECT_THAT(result.errors, HasSubstr(c.named));
    EXPECT_THAT(leftOver(), ::testing::ElementsAre("files"));
  }
}

TEST_F(SimulateProgram, aFullDiskIsAnErrorAndLeavesNothing)
{
  // Files may have 64 blocks of 512 bytes at most.
  const Outcome result = run(
      "--scene basic_model --sensor velodyne_vlp16 --points 20000 --out " + folder_.file("a/set"), "ulimit -f 64; ");
  EXPECT_EQ(result.code, 3);
  EXPECT_THAT(
      result.errors,
      AllOf(StartsWith("ssfr_simulate: " + folder_.file("a/set/scans/scan000.pcd")), HasSubstr("cannot be written")));
  EXPECT_THAT(leftOver(), ::testing::IsEmpty());
}

TEST_F(SimulateProgram, anInterruptionLeavesNothing)
{
  const std::string out = folder_.file("a/set");
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGINT, SIG_DFL);
    execl(PCL_SSFR_SIMULATE,
          "ssfr_simulate",
          "--quiet",
          "--scene",
          "basic_model",
          "--sensor",
          "leica_p20",
          "--points",
          "1000000",
          "--scans",
          "1000",
          "--out",
          out.c_str(),
          nullptr);
    _exit(99);
  }
  // Wait until a scan is being written.
  const auto started = [&] {
    std::error_code ignored;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.file(""), ignored))
      if (entry.path().extension() == ".pcd")
        return true;
    return false;
  };
  for (int i = 0; i < 600 && !started(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(started());
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) << status;
  EXPECT_THAT(leftOver(), ::testing::IsEmpty());
}

TEST_F(SimulateProgram, sensorsPrintAndReadBack)
{
  const Outcome first = run("--print-sensor velodyne_vlp16");
  ASSERT_EQ(first.code, 0) << first.errors;
  EXPECT_EQ(nlohmann::json::parse(first.output)["name"], "velodyne_vlp16");
  io::writeFile(folder_.file("mine.json"), first.output);
  EXPECT_EQ(run("--print-sensor " + folder_.file("mine.json")).output, first.output);
}

TEST_F(SimulateProgram, writesADatasetThatReadsBack)
{
  const Outcome result =
      run("--scene basic_model --sensor velodyne_vlp16 --scans 4 --pairs all --people 2 --out " + folder_.file("set"));
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_THAT(result.output, AllOf(StartsWith("Wrote " + folder_.file("set")), HasSubstr("pairs   6:")));
  const io::DatasetFolder set = io::readDatasetFolder(folder_.file("set"));
  EXPECT_TRUE(set.sensor_at_origin);
  EXPECT_EQ(set.sensor, "velodyne_vlp16");
  EXPECT_EQ(set.pairs.size(), 6U);
  const auto description = nlohmann::json::parse(io::readFile(folder_.file("set/dataset.json")));
  for (const char* key : {"name", "sensor", "viewpoint", "success", "note"})
    EXPECT_TRUE(description.contains(key)) << key;
  EXPECT_EQ(description["viewpoint"], "sensor");
  EXPECT_EQ(description["success"]["rotation_deg"], 2);
  EXPECT_EQ(description["success"]["translation_m"], 0.3);
  const auto cloud = io::loadCloud(io::scanPath(set.path, "scan003.pcd"));
  EXPECT_GT(cloud.points->size(), 1000U);
  EXPECT_TRUE(cloud.has_intensity);
}

TEST_F(SimulateProgram, theSameSeedGivesTheSameBytesForAnyThreads)
{
  const std::string arguments = "--quiet --scene apartment --sensor velodyne_vlp16 --points 20000 --scans 3 --people 2 "
                                "--doors --random-rotation --out ";
  ASSERT_EQ(run(arguments + folder_.file("one") + " --threads 1").code, 0);
  ASSERT_EQ(run(arguments + folder_.file("two") + " --threads 2").code, 0);
  ASSERT_EQ(run(arguments + folder_.file("other") + " --seed 2").code, 0);
  EXPECT_GT(contentOf("one").size(), 300000U);
  EXPECT_TRUE(contentOf("one") == contentOf("two"));
  EXPECT_FALSE(contentOf("one") == contentOf("other"));
}

TEST_F(SimulateProgram, aWalkCanBeWrittenInParts)
{
  const std::string arguments = "--quiet --scene basic_model --sensor velodyne_vlp16 --points 5000 --out ";
  ASSERT_EQ(run(arguments + folder_.file("all") + " --scans 4").code, 0);
  ASSERT_EQ(run(arguments + folder_.file("part") + " --scans 2 --start 2").code, 0);
  for (const char* scan : {"/scans/scan002.pcd", "/scans/scan003.pcd"})
    EXPECT_TRUE(io::readFile(folder_.file("all") + scan) == io::readFile(folder_.file("part") + scan)) << scan;
}

TEST_F(SimulateProgram, turnsCanBeLimited)
{
  // Back and forth: without a limit the sensor turns round at the ends of its path.
  const std::string arguments = "--quiet --scene basic_model --sensor velodyne_vlp16 --points 500 --scans 40 --out ";
  ASSERT_EQ(run(arguments + folder_.file("free")).code, 0);
  ASSERT_EQ(run(arguments + folder_.file("limited") + " --turn-limit 20").code, 0);
  const auto largest = [&](const char* name) {
    double angle = 0;
    for (const io::ScanPair& pair : io::readDatasetFolder(folder_.file(name)).pairs)
      angle = std::max(angle, Eigen::AngleAxisd(pair.T_target_source.linear()).angle() * 180 / M_PI);
    return angle;
  };
  EXPECT_GT(largest("free"), 60);
  EXPECT_LT(largest("limited"), 20.001);
}

TEST_F(SimulateProgram, quietIsQuiet)
{
  const Outcome result = run("--quiet --scene basic_model --points 2000 --scans 1 --out " + folder_.file("set"));
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.output + result.errors, "");
  EXPECT_EQ(io::readFile(folder_.file("set/pairs.csv")).find('\n') + 1,
            io::readFile(folder_.file("set/pairs.csv")).size()); // one scan has no pair
}

TEST_F(SimulateProgram, randomRotationTurnsTheFramesAndKeepsTheScene)
{
  const std::string arguments = "--quiet --scene basic_model --sensor velodyne_vlp16 --points 3000 --scans 2 --out ";
  ASSERT_EQ(run(arguments + folder_.file("plain")).code, 0);
  ASSERT_EQ(run(arguments + folder_.file("rotated") + " --random-rotation").code, 0);
  const auto plain = io::readDatasetFolder(folder_.file("plain"));
  const auto rotated = io::readDatasetFolder(folder_.file("rotated"));
  const auto load = [&](const char* set, const std::string& scan) {
    return io::loadCloud(io::scanPath(folder_.file(set), scan));
  };
  const auto a = load("plain", plain.pairs[0].source);
  const auto b = load("rotated", rotated.pairs[0].source);
  ASSERT_EQ(a.points->size(), b.points->size());
  EXPECT_GT(Eigen::AngleAxisd(rotated.pairs[0].T_target_source.linear()).angle(), 0.5);
  // Both truths bring a point of the source to the same place of the scene: the same distances to every target point.
  const auto ta = load("plain", plain.pairs[0].target);
  const auto tb = load("rotated", rotated.pairs[0].target);
  ASSERT_EQ(ta.points->size(), tb.points->size());
  const auto at = [](const io::LoadedCloud& cloud, std::size_t i) -> Eigen::Vector3d {
    return (*cloud.points)[i].getVector3fMap().cast<double>();
  };
  for (std::size_t i = 0; i < std::min(a.points->size(), ta.points->size()); i += 37) {
    EXPECT_NEAR(at(a, i).norm(), at(b, i).norm(), 1e-4);
    EXPECT_NEAR((plain.pairs[0].T_target_source * at(a, i) - at(ta, i)).norm(),
                (rotated.pairs[0].T_target_source * at(b, i) - at(tb, i)).norm(),
                1e-4);
  }
}

TEST_F(SimulateProgram, meshesAreScenes)
{
  // A room of 8 by 6 by 3 m as a cube of quadrilaterals.
  io::writeFile(folder_.file("room.obj"),
                "v 0 0 0\nv 8 0 0\nv 8 6 0\nv 0 6 0\nv 0 0 3\nv 8 0 3\nv 8 6 3\nv 0 6 3\n"
                "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const Outcome result =
      run("--scene " + folder_.file("room.obj") + " --sensor leica_p20 --points 5000 --no-noise --out " +
          folder_.file("set") + " --pictures " + folder_.file("pictures"));
  ASSERT_EQ(result.code, 0) << result.errors;
  const auto set = io::readDatasetFolder(folder_.file("set"));
  EXPECT_EQ(set.name, "room_leica_p20");
  ASSERT_EQ(set.pairs.size(), 1U);
  const std::string png = io::readFile(folder_.file("pictures/room.png"));
  EXPECT_EQ(png.substr(1, 3), "PNG");
}

TEST_F(SimulateProgram, reducedPaperSetsHaveTheirPointsAndAreSmall)
{
  for (const std::string& name : paperSetNames()) {
    SCOPED_TRACE(name);
    const Outcome result = run("--paper-set " + name + " --reduced --out " + folder_.file(name));
    ASSERT_EQ(result.code, 0) << result.errors;
    const DatasetPlan plan = makePaperSet(name, true).plan;
    EXPECT_NEAR(meanPoints(name) / static_cast<double>(plan.points), 1, 0.02);
    std::size_t scans = 0;
    for (const auto& entry : fs::directory_iterator(folder_.file(name + "/scans"))) {
      EXPECT_LT(fs::file_size(entry.path()), 2000000U) << entry.path();
      ++scans;
    }
    EXPECT_EQ(scans, name == "basic_model" ? 4U : 3U);
    EXPECT_EQ(io::readDatasetFolder(folder_.file(name)).pairs.size(), scans - 1);
  }
}

TEST_F(SimulateProgram, theBasicModelHasThreeGrowingMotionsOntoOneTarget)
{
  ASSERT_EQ(run("--quiet --paper-set basic_model --reduced --out " + folder_.file("set")).code, 0);
  const auto set = io::readDatasetFolder(folder_.file("set"));
  ASSERT_EQ(set.pairs.size(), 3U);
  double angle = 0;
  double length = 0;
  for (const io::ScanPair& pair : set.pairs) {
    EXPECT_EQ(pair.target, "scan000.pcd");
    EXPECT_GT(Eigen::AngleAxisd(pair.T_target_source.linear()).angle(), angle);
    EXPECT_GT(pair.T_target_source.translation().norm(), length);
    angle = Eigen::AngleAxisd(pair.T_target_source.linear()).angle();
    length = pair.T_target_source.translation().norm();
  }
}

} // namespace
} // namespace pcl_ssfr::simulation::test_simulate_cli
