// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// ssfr_align as its users run it: exit codes, messages, files. PCL_SSFR_ALIGN is the path of the program.

#include <apps/align/align_options.h>
#include <apps/align/pictures.h>
#include <apps/drawing/scene_drawing.h>
#include <apps/io/e57_format.h>
#include <apps/io/e57_writer.h>
#include <apps/io/file_bytes.h>
#include <apps/io/transform_file.h>
#include <apps/methods/method_run.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <sstream>

namespace pcl_ssfr::test_cli {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using testing::TemporaryFolder;

// ---------------------------------------------------------------------------------------------------------------------
// The command line as such

apps::AlignArguments
parse(const std::vector<std::string>& arguments)
{
  return apps::parseAlignArguments(arguments);
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
  return {};
}

TEST(AlignOptions, defaultsAreThoseOfTheLibrary)
{
  const auto arguments = parse({"s.pcd", "t.pcd"});
  const Options defaults = makeOptions(Profile::Default);
  EXPECT_EQ(arguments.source, "s.pcd");
  EXPECT_EQ(arguments.target, "t.pcd");
  EXPECT_EQ(arguments.method, "ssfr");
  EXPECT_EQ(arguments.options.normal_radius, defaults.normal_radius);
  EXPECT_EQ(arguments.options.refine, defaults.refine);
  EXPECT_EQ(arguments.options.min_confidence, defaults.min_confidence);
  EXPECT_EQ(arguments.options.viewpoint_mode, ViewpointMode::Auto);
  EXPECT_FALSE(arguments.options.gravity);
  EXPECT_TRUE(arguments.output.empty() && arguments.json.empty() && arguments.pictures.empty());
}

TEST(AlignOptions, everythingCanBeSet)
{
  const auto arguments = parse({"--output",
                                "o.PLY",
                                "s.las",
                                "--transform=T.txt",
                                "t.csv",
                                "--json",
                                "-",
                                "--normal-radius",
                                "0.2",
                                "--density-radius",
                                "0.05",
                                "--bin-width",
                                "0.03",
                                "--leaf",
                                "0.1",
                                "--guess",
                                "g.txt",
                                "--viewpoint",
                                "unknown",
                                "--gravity=0,-2,0",
                                "--gravity-tolerance=2.5",
                                "--no-refine",
                                "--threads",
                                "3",
                                "--pictures",
                                "dir",
                                "--time-limit",
                                "9"});
  EXPECT_EQ(arguments.source, "s.las");
  EXPECT_EQ(arguments.target, "t.csv");
  EXPECT_EQ(arguments.output, "o.PLY");
  EXPECT_EQ(arguments.json, "-");
  EXPECT_EQ(arguments.guess_file, "g.txt");
  EXPECT_EQ(arguments.options.normal_radius, 0.2);
  EXPECT_EQ(arguments.options.density_radius, 0.05);
  EXPECT_EQ(arguments.options.bin_width, 0.03);
  EXPECT_EQ(arguments.options.leaf, 0.1);
  EXPECT_EQ(arguments.options.viewpoint_mode, ViewpointMode::Unknown);
  EXPECT_EQ(arguments.options.threads, 3U);
  EXPECT_EQ(arguments.options.time_limit, 9);
  EXPECT_FALSE(arguments.options.refine);
  ASSERT_TRUE(arguments.options.gravity);
  EXPECT_EQ(arguments.options.gravity->up_source, -Eigen::Vector3d::UnitY());
  EXPECT_NEAR(arguments.options.gravity->tolerance, 0.0436332, 1e-6);
}

TEST(AlignOptions, methodAndProfileAgree)
{
  for (const std::vector<std::string>& extra :
       {std::vector<std::string>{"--profile", "paper2017"}, {"--method", "ssfr_paper2017"}}) {
    std::vector<std::string> tokens{"s.pcd", "t.pcd"};
    tokens.insert(tokens.end(), extra.begin(), extra.end());
    const auto arguments = parse(tokens);
    EXPECT_EQ(arguments.method, "ssfr_paper2017");
    EXPECT_EQ(arguments.options.profile, Profile::Paper2017);
  }
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--profile", "default", "--method", "ssfr_paper2017"}),
              HasSubstr("contradicts"));
  for (const char* method : {"ssfr_icp", "ssfr_gicp", "ssfr_ndt"})
    EXPECT_EQ(usageError({"s.pcd", "t.pcd", "--profile", "paper2017", "--method", method}),
              std::string("--profile paper2017 contradicts --method ") + method);
}

TEST(AlignOptions, errorsNameWhatIsWrong)
{
  EXPECT_EQ(usageError({}), "SOURCE and TARGET are missing");
  EXPECT_EQ(usageError({"s.pcd"}), "TARGET is missing");
  EXPECT_EQ(usageError({"", "t.pcd"}), "SOURCE is empty");
  EXPECT_EQ(usageError({"s.pcd", ""}), "TARGET is empty");
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "u.pcd"}), HasSubstr("'u.pcd'"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--wrong"}), HasSubstr("--wrong"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--no-ref"}), HasSubstr("--no-ref")); // no abbreviations
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--leaf", "wide"}), AllOf(HasSubstr("leaf"), HasSubstr("wide")));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--leaf"}), HasSubstr("leaf"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--leaf=-1"}), AllOf(HasSubstr("leaf"), HasSubstr("-1")));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--normal-radius", "nan"}), HasSubstr("normal"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--threads=-2"}), HasSubstr("--threads: '-2'"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--method", "magic"}), AllOf(HasSubstr("'magic'"), HasSubstr("gicp")));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--profile", "best"}), HasSubstr("--profile: 'best'"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--viewpoint", "here"}), HasSubstr("--viewpoint: 'here'"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--gravity", "0,0"}), HasSubstr("--gravity: '0,0'"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--gravity", "0,0,up"}), HasSubstr("'up'"));
  for (const char* none : {"0,0,0", "nan,0,1", "inf,0,0"})
    EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--gravity", none}), HasSubstr("not a direction")) << none;
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--gravity-tolerance", "2"}), HasSubstr("needs --gravity"));
  for (const char* degrees : {"0", "-1", "181", "nan"}) {
    EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--gravity", "0,0,1", std::string("--gravity-tolerance=") + degrees}),
                HasSubstr("(0, 180] degrees"));
  }
  const auto tolerance = [](const std::string& value) {
    return usageError({"s.pcd", "t.pcd", "--guess", "T.txt", "--guess-tolerance", value});
  };
  EXPECT_THAT(tolerance("5"), HasSubstr("--guess-tolerance: '5' is not DEG,M"));
  EXPECT_THAT(tolerance("5,m"), HasSubstr("--guess-tolerance: 'm' is not a number"));
  EXPECT_THAT(tolerance("0,1"), HasSubstr("(0, 180]"));
  EXPECT_THAT(tolerance("5,-1"), HasSubstr("greater than 0"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--guess-tolerance", "5,1"}), HasSubstr("needs --guess"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--guess", "T.txt", "--guess-tolerance", "5,1", "--method", "ndt"}),
              HasSubstr("not read by --method ndt"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--output", "moved.las"}), HasSubstr("moved.las"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--output="}), HasSubstr("--output"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--refine", "--no-refine"}), HasSubstr("--refine"));
  EXPECT_THAT(usageError({"s.pcd", "t.pcd", "--leaf", "1", "--leaf", "2"}), HasSubstr("leaf"));
}

TEST(AlignOptions, gravityOfAnyLengthIsADirection)
{
  for (const char* up : {"0,0,1e300", "0,0,1e-300", "0,0,9.81"}) {
    const auto options = apps::parseAlignArguments({"s.pcd", "t.pcd", "--gravity", up}).options;
    ASSERT_TRUE(options.gravity) << up;
    EXPECT_TRUE(options.gravity->up_source.isApprox(Eigen::Vector3d::UnitZ())) << up;
  }
}

TEST(AlignOptions, noResultTakesThePlaceOfAnotherOrOfAScan)
{
  EXPECT_EQ(usageError({"s.pcd", "t.pcd", "--json", "s.pcd"}), "--json: 's.pcd' is also SOURCE");
  EXPECT_EQ(usageError({"s.pcd", "d/../t.pcd", "--output", "./t.pcd"}), "--output: './t.pcd' is also TARGET");
  EXPECT_EQ(usageError({"s.pcd", "t.pcd", "--guess", "T.txt", "--transform", "T.txt"}),
            "--transform: 'T.txt' is also --guess");
  EXPECT_EQ(usageError({"s.pcd", "t.pcd", "--json", "a", "--transform", "a"}), "--json: 'a' is also --transform");
  EXPECT_EQ(apps::parseAlignArguments({"s.pcd", "s.pcd", "--json", "-", "--transform", "T.txt"}).json, "-");
  EXPECT_EQ(apps::parseAlignArguments({"s.pcd", "s.pcd", "--json", "a", "--transform", "-"}).transform, "-");
  EXPECT_EQ(usageError({"s.pcd", "t.pcd", "--json", "-", "--transform", "-"}), "--json: '-' is also --transform");
  EXPECT_EQ(apps::parseAlignArguments({"s.pcd", "t.pcd", "--json", "/dev/null", "--transform", "/dev/null"}).json,
            "/dev/null");
}

TEST(AlignOptions, whatAMethodDoesNotReadIsNamed)
{
  const auto unread = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"s.pcd", "t.pcd"});
    return apps::parseAlignArguments(arguments).unread;
  };
  const std::vector<std::string> many = {
      "--gravity", "0,0,1", "--time-limit", "2", "--guess", "T.txt", "--no-refine", "--leaf", "0.1"};
  const auto with = [&many](const char* method) {
    std::vector<std::string> all = many;
    all.insert(all.end(), {"--method", method});
    return all;
  };
  EXPECT_THAT(unread(many), IsEmpty());
  EXPECT_THAT(unread(with("ssfr_icp")), IsEmpty());
  EXPECT_THAT(unread(with("ssfr_paper2017")), ElementsAre("--no-refine"));
  EXPECT_THAT(unread(with("ndt")), ElementsAre("--gravity", "--no-refine", "--time-limit"));
  EXPECT_THAT(unread(with("fgr")), ElementsAre("--gravity", "--no-refine", "--guess", "--time-limit"));
  EXPECT_THAT(unread(with("go_icp")), ElementsAre("--gravity", "--no-refine", "--guess"));
  EXPECT_THAT(unread({"--method", "icp_point_to_point", "--normal-radius", "0.3", "--viewpoint", "auto"}),
              ElementsAre("--viewpoint", "--normal-radius"));
  EXPECT_THAT(unread({"--method", "icp_point_to_plane", "--normal-radius", "0.3"}), IsEmpty());

  std::ostringstream text;
  apps::warnOfUnread(
      apps::parseAlignArguments({"s.pcd", "t.pcd", "--method", "gicp", "--bin-width", "0.1"}), "p", text);
  EXPECT_EQ(text.str(), "p: warning: --bin-width is not read by --method gicp\n");
}

TEST(AlignOptions, helpNamesEveryOptionAndMethod)
{
  const std::string help = apps::alignHelp();
  for (const char* option : {"--output",
                             "--transform",
                             "--json",
                             "--method",
                             "--profile",
                             "--normal-radius",
                             "--density-radius",
                             "--bin-width",
                             "--leaf",
                             "--guess",
                             "--viewpoint",
                             "--gravity",
                             "--refine",
                             "--no-refine",
                             "--threads",
                             "--pictures",
                             "--help",
                             "--version"})
    EXPECT_THAT(help, HasSubstr(option));
  for (const apps::Method& method : apps::methods())
    EXPECT_THAT(help, HasSubstr(method.name));
  EXPECT_THAT(help, HasSubstr("Exit code"));
}

// ---------------------------------------------------------------------------------------------------------------------
// What is said of a result

TEST(AlignReport, distancesAreMeasuredAtTheReferencePoint)
{
  // Coordinates of a map: half a turn about the sensor, and a metre away.
  const Eigen::Vector3d sensor(691234.5, 5338000.25, 512);
  const Eigen::Isometry3d T = Eigen::Translation3d(sensor + Eigen::Vector3d::UnitX()) *
                              Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(-sensor);
  apps::Report report;
  report.method = "ssfr";
  report.reference = sensor;
  report.run.result.candidates.resize(2);
  report.run.result.candidates[1].T_target_source = T;
  EXPECT_THAT(apps::toText(report), HasSubstr("180.0 deg and 1.00 m away"));
  report.run.result.T_target_source = T;
  EXPECT_THAT(apps::subtitleAfter(report), HasSubstr("moved by 1.00 m"));
}

// ---------------------------------------------------------------------------------------------------------------------
// The program

struct Outcome {
  int code = -1;
  std::string output;
  std::string errors;
};

class AlignProgram : public ::testing::Test {
protected:
  Outcome
  run(const std::string& arguments) const
  {
    const std::string command = std::string("'") + PCL_SSFR_ALIGN + "' " + arguments + " >'" + folder_.file("out") +
                                "' 2>'" + folder_.file("err") + "'";
    const int status = std::system(command.c_str());
    EXPECT_TRUE(WIFEXITED(status)) << command;
    return {WEXITSTATUS(status), io::readFile(folder_.file("out")), io::readFile(folder_.file("err"))};
  }

  /// An L-shaped room of 8 by 6 m with a pillar and boxes, seen by nobody in particular: dense points on its surfaces.
  static std::string
  room(const Eigen::Isometry3d& T)
  {
    std::string text;
    const auto add = [&](double x, double y, double z) {
      // Millimetres of noise that is the same every time, and not the same for neighbours.
      const double noise = 0.002 * std::sin(1234.5 * x + 987.6 * y + 555.5 * z);
      const Eigen::Vector3d p = T * Eigen::Vector3d(x + noise, y - noise, z + noise);
      text += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    };
    constexpr double kStep = 0.06;
    const auto box = [&](Eigen::Vector3d low, Eigen::Vector3d high) {
      for (double u = low.x(); u <= high.x(); u += kStep)
        for (double v = low.y(); v <= high.y(); v += kStep)
          add(u, v, low.z()), add(u, v, high.z());
      for (double u = low.x(); u <= high.x(); u += kStep)
        for (double w = low.z(); w <= high.z(); w += kStep)
          add(u, low.y(), w), add(u, high.y(), w);
      for (double v = low.y(); v <= high.y(); v += kStep)
        for (double w = low.z(); w <= high.z(); w += kStep)
          add(low.x(), v, w), add(high.x(), v, w);
    };
    box({-3, -2, -1.2}, {5, 4, 1.5});
    box({-0.2, -2, -1.2}, {0, 1.2, 1.5}); // walls within the room: without them its half turns fit nearly as well
    box({2.2, 2.4, -1.2}, {5, 2.6, 1.5});
    box({1, 1, -1.2}, {2.1, 1.7, 0.3});
    box({-2.8, 2.9, -1.2}, {-1.5, 3.9, 1});
    box({3.5, -1.9, -1.2}, {4.9, -1.1, -0.2});
    return text;
  }

  TemporaryFolder folder_;
};

TEST_F(AlignProgram, helpAndVersion)
{
  const Outcome help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.output, StartsWith("Usage: ssfr_align SOURCE TARGET"));
  EXPECT_EQ(help.errors, "");
  const Outcome version = run("--version");
  EXPECT_EQ(version.code, 0);
  EXPECT_THAT(version.output, StartsWith("ssfr_align "));
}

TEST_F(AlignProgram, startsWithoutTheLibrariesThatOnlyOtherMethodsNeed)
{
  // The loader lists what a program needs to start, in place of starting it.
  const std::string list = folder_.file("libraries");
  for (const char* program : {PCL_SSFR_ALIGN, PCL_SSFR_BENCHMARK}) {
    const std::string command = std::string("LD_TRACE_LOADED_OBJECTS=1 '") + program + "' >'" + list + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const std::string libraries = io::readFile(list);
    EXPECT_THAT(libraries, HasSubstr("libpcl_search"));
    for (const char* other : {"libpcl_features", "libpcl_filters", "libpcl_registration", "libpcl_sample_consensus"})
      EXPECT_THAT(libraries, Not(HasSubstr(other)));
  }
}

TEST_F(AlignProgram, everyErrorIsOneLineThatNamesTheThing)
{
  io::writeFile(folder_.file("good.xyz"), "1 2 3\n");
  io::writeFile(folder_.file("bad.xyz"), "1 2 3\n4 five 6\n");
  io::writeFile(folder_.file("huge.pcd"),
                "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 4000000000\nHEIGHT 1\nDATA binary\n");
  struct Case {
    std::string arguments;
    int code;
    std::string named;
  };
  const std::string good = folder_.file("good.xyz");
  const Case cases[] = {{"", 2, "SOURCE"},
                        {good, 2, "TARGET"},
                        {good + " " + good + " --frobnicate", 2, "--frobnicate"},
                        {good + " " + good + " --leaf=-3", 2, "leaf"},
                        {good + " " + good + " --method nothing", 2, "nothing"},
                        {good + " " + folder_.file("none.pcd"), 3, "none.pcd"},
                        {folder_.file("bad.xyz") + " " + good, 3, "bad.xyz:2: column 2: 'five'"},
                        {folder_.file("huge.pcd") + " " + good, 3, "huge.pcd:6: POINTS 4000000000"},
                        {folder_.file("") + " " + good, 3, "unknown format"},
                        {good + " " + good + " --guess " + folder_.file("guess.txt"), 3, "guess.txt"},
                        // Said before the work, or the points of these files would be too few (code 1).
                        {good + " " + good + " --output " + folder_.file("no/x.pcd"), 3, "/no does not exist"},
                        {good + " " + good + " --transform " + folder_.file("no/T.txt"), 3, "/no does not exist"},
                        {good + " " + good + " --json " + folder_.file("no/a.json"), 3, "/no does not exist"}};
  for (const Case& c : cases) {
    const Outcome result = run(c.arguments);
    EXPECT_EQ(result.code, c.code) << c.arguments;
    EXPECT_EQ(result.output, "") << c.arguments;
    EXPECT_THAT(result.errors, AllOf(StartsWith("ssfr_align: "), HasSubstr(c.named))) << c.arguments;
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
  }
}

TEST_F(AlignProgram, tooFewPointsIsNotAligned)
{
  io::writeFile(folder_.file("few.xyz"), "1 2 3\n4 5 6\n");
  const std::string pair = folder_.file("few.xyz") + " " + folder_.file("few.xyz");
  for (const char* method :
       {"ssfr", "ssfr_paper2017", "ssfr_icp", "icp_point_to_point", "icp_point_to_plane", "gicp", "ndt"}) {
    SCOPED_TRACE(method);
    const Outcome result = run(pair + " --json - --method " + method + " --output " + folder_.file("moved.pcd"));
    EXPECT_EQ(result.code, 1) << result.errors;
    const auto json = nlohmann::json::parse(result.output);
    EXPECT_EQ(json["status"], "too_few_points");
    EXPECT_EQ(json["converged"], false);
    EXPECT_EQ(json["method"], method);
    EXPECT_FALSE(json["message"].get<std::string>().empty());
    EXPECT_THAT(result.errors, HasSubstr("Not aligned"));
    EXPECT_FALSE(std::filesystem::exists(folder_.file("moved.pcd")));
  }
  EXPECT_THAT(run(pair).output, HasSubstr("Not aligned, too_few_points"));
  const Outcome piped = run(pair + " --transform -");
  EXPECT_EQ(piped.code, 1);
  EXPECT_EQ(piped.output, "");
  EXPECT_THAT(piped.errors, StartsWith("ssfr_align: Not aligned, too_few_points"));
}

TEST_F(AlignProgram, aScanWithoutPointsSaysNothingOfTheOtherOne)
{
  io::writeFile(folder_.file("nan.xyz"), "nan nan nan\nnan 1 2\n");
  const std::string room = PCL_SSFR_DATA_DIR "/apartment_1.pcd";
  for (const char* method : {"icp_point_to_plane", "fgr"}) {
    const std::string options = std::string(" --json - --method ") + method;
    EXPECT_THAT(run(folder_.file("nan.xyz") + " " + room + options).output,
                ContainsRegex("too few usable points: 0 in the source, [1-9][0-9]+ in the target"));
    EXPECT_THAT(run(room + " " + folder_.file("nan.xyz") + options).output,
                ContainsRegex("too few usable points: [1-9][0-9]+ in the source, 0 in the target"));
  }
}

TEST_F(AlignProgram, alignsARoomWithOffsetsAndWritesEverything)
{
  // The target lies in a map frame, the source was rotated: only double arithmetic keeps the millimetres.
  const Eigen::Isometry3d T_target_room(Eigen::Translation3d(691234.5, 5312345.25, 412.125));
  const Eigen::Isometry3d T_source_room =
      Eigen::Translation3d(2, -1, 0.5) * Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.1, 0.2, 1).normalized());
  const Eigen::Isometry3d truth = T_target_room * T_source_room.inverse();
  io::writeFile(folder_.file("source.xyz"), room(T_source_room));
  io::writeFile(folder_.file("target.xyz"), room(T_target_room));
  const Outcome result = run(folder_.file("source.xyz") + " " + folder_.file("target.xyz") + " --json - --transform " +
                             folder_.file("T.txt") + " --output " + folder_.file("moved.pcd") + " --pictures " +
                             folder_.file("pictures") + " --viewpoint unknown");
  ASSERT_EQ(result.code, 0) << result.errors << result.output;
  EXPECT_EQ(result.errors, "");

  const auto json = nlohmann::json::parse(result.output);
  for (const char* key : {"method",
                          "status",
                          "converged",
                          "message",
                          "T_target_source",
                          "overlap",
                          "confidence",
                          "correspondence_distance_m",
                          "time_s",
                          "peak_rss_mib",
                          "candidates",
                          "stages",
                          "version"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["status"], "converged");
  EXPECT_GT(json["time_s"], 0);
  EXPECT_GT(json["peak_rss_mib"], 1);
  ASSERT_FALSE(json["candidates"].empty());
  for (const char* key : {"T_target_source", "score", "overlap"})
    EXPECT_TRUE(json["candidates"][0].contains(key)) << key;
  ASSERT_FALSE(json["stages"].empty());
  for (const char* key : {"name", "seconds", "in", "out"})
    EXPECT_TRUE(json["stages"][0].contains(key)) << key;

  const Outcome piped =
      run(folder_.file("source.xyz") + " " + folder_.file("target.xyz") + " --transform - --viewpoint unknown");
  EXPECT_EQ(piped.errors, "");
  EXPECT_EQ(piped.output, io::readFile(folder_.file("T.txt"))); // that alone
  const Eigen::Isometry3d T = io::readTransform(folder_.file("T.txt"));
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_EQ(json["T_target_source"][row][column].get<double>(), T.matrix()(row, column));
  // Compared at the middle of the room: far from the origin a microradian of rotation would be metres of translation.
  const Eigen::Vector3d middle = T_source_room * Eigen::Vector3d(1, 1, 0);
  EXPECT_LT((T * middle - truth * middle).norm(), 0.02);
  EXPECT_LT(Eigen::AngleAxisd(T.linear().transpose() * truth.linear()).angle(), 0.005);

  const auto source = io::loadCloud(folder_.file("source.xyz"));
  const auto moved = io::loadCloud(folder_.file("moved.pcd"));
  ASSERT_EQ(moved.points->size(), source.points->size());
  const Eigen::Vector3d first = (*moved.points)[0].getVector3fMap().cast<double>() + moved.offset;
  EXPECT_LT((first - T * (*source.points)[0].getVector3fMap().cast<double>()).norm(), 1e-3);
  for (const char* name : {"pictures/before.png", "pictures/after.png"}) {
    const std::string png = io::readFile(folder_.file(name));
    EXPECT_EQ(png.substr(1, 3), "PNG");
    EXPECT_GT(png.size(), 10000U);
  }
}

TEST_F(AlignProgram, distancesInAMapAreThoseAtTheScan)
{
  // Both scans in one map frame: the pose is near the identity, and so are the distances of other poses.
  const Eigen::Isometry3d T_map_room(Eigen::Translation3d(691234.5, 5312345.25, 412.125));
  io::writeFile(folder_.file("source.xyz"), room(T_map_room));
  io::writeFile(folder_.file("target.xyz"), room(T_map_room));
  const Outcome result =
      run(folder_.file("source.xyz") + " " + folder_.file("target.xyz") + " --viewpoint unknown --method ssfr_icp");
  ASSERT_EQ(result.code, 0) << result.errors;
  std::istringstream lines(result.output);
  std::size_t others = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find(" deg and ");
    if (at == std::string::npos)
      continue;
    ++others;
    EXPECT_LT(std::stod(line.substr(at + 9)), 30) << line;
  }
  EXPECT_GT(others, 0U) << result.output;
}

TEST_F(AlignProgram, aSensorThatWasFoundIsWrittenAndDrawn)
{
  // In a frame of the site, in a format that says nothing of the sensor.
  const Eigen::Isometry3d T_site_scan(Eigen::Translation3d(900, 500, 0));
  const std::string data = PCL_SSFR_DATA_DIR "/";
  for (const char* name : {"hall_0", "hall_1"})
    io::saveMovedCloud(folder_.file(std::string(name) + ".ply"), io::loadCloud(data + name + ".pcd"), T_site_scan);
  const Outcome result = run(folder_.file("hall_1.ply") + " " + folder_.file("hall_0.ply") + " --transform " +
                             folder_.file("T.txt") + " --output " + folder_.file("moved.pcd") + " --json -");
  ASSERT_EQ(result.code, 0) << result.errors;
  const auto json = nlohmann::json::parse(result.output);
  ASSERT_EQ(json["source_viewpoint_found"], true);
  const Eigen::Vector3d sensor(json["source_viewpoint_m"].get<std::array<double, 3>>().data());
  EXPECT_LT((sensor - T_site_scan.translation()).norm(), 1);
  const auto moved = io::loadCloud(folder_.file("moved.pcd"));
  ASSERT_TRUE(moved.viewpoint);
  EXPECT_LT((*moved.viewpoint - io::readTransform(folder_.file("T.txt")) * sensor).norm(), 1e-6);

  const auto scan = io::loadCloud(folder_.file("hall_1.ply"));
  const Eigen::Isometry3d T(Eigen::Translation3d(1, 2, 3));
  const auto layer = apps::makeScanLayer(scan, T, apps::kSourceColour, "", sensor);
  ASSERT_TRUE(layer.sensor);
  EXPECT_LT((layer.sensor->cast<double>() - T * sensor).norm(), 1e-3);
}

TEST_F(AlignProgram, picturesAreStraightWhereverAScanLies)
{
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.227, Eigen::Vector3d::UnitZ())); // by 13 degrees
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(900, 500, 0)}) {
    const auto cloud = io::parseCloud("room.xyz", room(Eigen::Translation3d(place) * turn));
    const Eigen::Matrix3d R = apps::pictureFrame(cloud, Eigen::Vector3d::UnitZ()).linear() * turn.linear();
    EXPECT_LT(std::min(std::abs(R(0, 0)), std::abs(R(1, 0))), 0.026) << R;
  }
}

TEST_F(AlignProgram, scansOfOneE57File)
{
  const Eigen::Isometry3d T_source_room =
      Eigen::Translation3d(2, -1, 0.5) * Eigen::AngleAxisd(2.6, Eigen::Vector3d::UnitZ());
  io::writeFile(folder_.file("source.xyz"), room(T_source_room));
  io::writeFile(folder_.file("target.xyz"), room(Eigen::Isometry3d::Identity()));
  {
    io::E57Writer writer(folder_.file("both.e57"));
    writer.addScan("target", io::loadCloud(folder_.file("target.xyz")), T_source_room); // poses are not used
    writer.addScan("source", io::loadCloud(folder_.file("source.xyz")), T_source_room);
    writer.finish();
  }
  const std::string both = folder_.file("both.e57");
  if (!PCL_SSFR_READS_E57) {
    EXPECT_THAT(run(both + " " + both).errors, HasSubstr("built without pugixml"));
    GTEST_SKIP() << "built without pugixml";
  }
  const auto transform = [this](const std::string& scans) {
    const Outcome result =
        run(scans + " --transform " + folder_.file("T.txt") + " --output " + folder_.file("moved.e57"));
    EXPECT_EQ(result.code, 0) << result.errors;
    return io::readFile(folder_.file("T.txt"));
  };
  const std::string text = transform(folder_.file("source.xyz") + " " + folder_.file("target.xyz"));
  EXPECT_EQ(transform("'" + both + "#source' '" + both + "#1'"), text);
  const auto moved = io::loadCloud(folder_.file("moved.e57"));
  ASSERT_TRUE(moved.T_file_scan);
  EXPECT_TRUE(moved.T_file_scan->isApprox(io::readTransform(folder_.file("T.txt")), 1e-12));
  EXPECT_EQ(io::listE57Scans(folder_.file("moved.e57")).at(0).name, "both#source");

  const Outcome several = run(both + " " + folder_.file("target.xyz"));
  EXPECT_EQ(several.code, 3);
  EXPECT_THAT(several.errors, HasSubstr("holds 2 scans, pick one of " + both + "#1 ('target', "));
  const Outcome same = run("'" + both + "#1' '" + both + "#2' --output " + both);
  EXPECT_EQ(same.code, 2);
  EXPECT_THAT(same.errors, HasSubstr("--output: "));
}

TEST_F(AlignProgram, refinersStartFromTheGuess)
{
  const Eigen::Isometry3d T_source_room =
      Eigen::Translation3d(2, -1, 0.5) * Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ());
  const Eigen::Isometry3d truth = T_source_room.inverse();
  const Eigen::Isometry3d guess = truth * Eigen::Translation3d(0.05, -0.04, 0.03);
  io::writeFile(folder_.file("source.xyz"), room(T_source_room));
  io::writeFile(folder_.file("target.xyz"), room(Eigen::Isometry3d::Identity()));
  io::writeFile(folder_.file("guess.txt"), io::formatTransform(guess));
  for (const char* method : {"icp_point_to_point", "icp_point_to_plane", "gicp", "ndt"}) {
    SCOPED_TRACE(method);
    const Outcome result = run(folder_.file("source.xyz") + " " + folder_.file("target.xyz") +
                               " --leaf 0.15 --method " + method + " --guess " + folder_.file("guess.txt") +
                               " --json " + folder_.file("report.json") + " --transform " + folder_.file("T.txt"));
    ASSERT_EQ(result.code, 0) << result.errors;
    EXPECT_EQ(result.output, "");
    const Eigen::Isometry3d T = io::readTransform(folder_.file("T.txt"));
    EXPECT_LT((T.translation() - truth.translation()).norm(), 0.03);
    const auto json = nlohmann::json::parse(io::readFile(folder_.file("report.json")));
    EXPECT_TRUE(json["confidence"].is_null()); // PCL's refiners know none
    EXPECT_GT(json["overlap"], 0.9);
  }
}

} // namespace
} // namespace pcl_ssfr::test_cli
