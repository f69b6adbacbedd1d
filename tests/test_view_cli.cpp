// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// ssfr_view as its users run it: exit codes, messages, pictures. PCL_SSFR_VIEW, PCL_SSFR_ALIGN and PCL_SSFR_BENCHMARK
// are the paths of the programs.

#include <apps/common/usage_error.h>
#include <apps/io/dataset_folder.h>
#include <apps/io/file_bytes.h>
#include <apps/io/transform_file.h>
#include <apps/methods/options_json.h>
#include <apps/view/view_model.h>
#include <apps/view/view_options.h>

#include <io_testing.h>

#include <cairo.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <regex>
#include <set>

namespace pcl_ssfr::test_view_cli {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using testing::TemporaryFolder;

constexpr int kPictureWidth = 1400; ///< of every picture
const std::string kData = PCL_SSFR_DATA_DIR;

// ---------------------------------------------------------------------------------------------------------------------
// The command line as such

std::string
usageError(const std::vector<std::string>& arguments)
{
  try {
    apps::parseViewArguments(arguments);
  }
  catch (const apps::UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(ViewOptions, everythingCanBeSet)
{
  const auto arguments =
      apps::parseViewArguments({"folder", "--pair",  "3",       "--perturb", "se3", "--seed",   "9",    "--candidate",
                                "4",      "--truth", "T.txt",   "--png",     "out", "--method", "gicp", "--leaf",
                                "0.1",    "--layer", "matches", "--dataset", "d",   "--window"});
  EXPECT_EQ(arguments.inputs, std::vector<std::string>{"folder"});
  EXPECT_EQ(arguments.pair, 3U);
  EXPECT_EQ(arguments.perturbation, apps::Perturbation::Se3);
  EXPECT_EQ(arguments.seed, 9U);
  EXPECT_EQ(arguments.candidate, 4U);
  EXPECT_EQ(arguments.truth, "T.txt");
  EXPECT_EQ(arguments.pictures, "out");
  EXPECT_EQ(arguments.method.method, "gicp");
  EXPECT_EQ(arguments.method.options.leaf, 0.1);
  EXPECT_EQ(arguments.layer, apps::WindowLayer::Matches);
  EXPECT_EQ(arguments.dataset, "d");
  EXPECT_TRUE(arguments.window);
}

TEST(ViewOptions, aWindowIsTheDefaultAndPicturesReplaceIt)
{
  EXPECT_TRUE(apps::parseViewArguments({"run.json"}).window);
  EXPECT_FALSE(apps::parseViewArguments({"run.json", "--png", "out"}).window);
  EXPECT_TRUE(apps::parseViewArguments({"run.json", "--png", "out", "--screenshot", "w.png"}).window);
  EXPECT_EQ(apps::parseViewArguments({"run.json", "--render", "out"}).pictures, "out");
}

TEST(ViewOptions, errorsNameWhatIsWrong)
{
  EXPECT_THAT(usageError({}), HasSubstr("RESULT"));
  EXPECT_THAT(usageError({"a", "b", "c"}), HasSubstr("'c'"));
  EXPECT_THAT(usageError({"a", "--frobnicate"}), HasSubstr("--frobnicate"));
  EXPECT_THAT(usageError({"a", "--candidate", "0"}), HasSubstr("--candidate: '0'"));
  EXPECT_THAT(usageError({"a", "--pair", "-1"}), HasSubstr("--pair: '-1'"));
  EXPECT_THAT(usageError({"a", "--pair", "99999999999999999999"}), HasSubstr("--pair"));
  EXPECT_THAT(usageError({"a", "--perturb", "much"}), AllOf(HasSubstr("--perturb"), HasSubstr("'much'")));
  EXPECT_THAT(usageError({"a", "--layer", "top"}), HasSubstr("--layer: 'top'"));
  EXPECT_THAT(usageError({"a", "--png="}), HasSubstr("--png"));
  EXPECT_THAT(usageError({"a", "--png", "x", "--render", "y"}), HasSubstr("--render"));
  EXPECT_THAT(usageError({"a", "--method", "magic"}), HasSubstr("'magic'"));
  EXPECT_THAT(usageError({"a", "--leaf=-1"}), HasSubstr("leaf"));
}

TEST(OptionsJson, everyOptionReturns)
{
  Options options = makeOptions(Profile::Default);
  options.viewpoint_mode = ViewpointMode::Unknown;
  options.normal_radius = 0.2;
  options.density_radius = 0.05;
  options.bin_width = 0.03;
  options.leaf = 0.1;
  options.overlap_radius = 0.15;
  options.refine = false;
  options.min_confidence = 0.7;
  options.time_limit = 9;
  options.threads = 3;
  options.max_candidates = 4;
  options.max_refinement_steps = 5;
  options.gravity = GravityPrior{Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0), 0.1};
  const auto json = apps::optionsJson(options);
  const Options read = apps::optionsFromJson(json);
  EXPECT_EQ(apps::optionsJson(read), json);
  EXPECT_EQ(read.viewpoint_mode, ViewpointMode::Unknown);
  EXPECT_EQ(read.leaf, 0.1);
  EXPECT_FALSE(read.refine);
  EXPECT_EQ(read.gravity->up_target, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(apps::optionsFromJson({{"profile", "paper2017"}}).profile, Profile::Paper2017);
  for (const auto& [key, value] : std::map<std::string, nlohmann::ordered_json>{
           {"profile", "best"}, {"viewpoint", 3}, {"leaf", "wide"}, {"refine", 1}, {"gravity", {1, 2}}})
    EXPECT_THROW(apps::optionsFromJson({{key, value}}), std::invalid_argument) << key;
}

// ---------------------------------------------------------------------------------------------------------------------
// What is drawn

/// A picture as a file holds it.
class Picture {
public:
  explicit Picture(const std::string& path)
      : surface_(cairo_image_surface_create_from_png(path.c_str()), cairo_surface_destroy)
  {
    EXPECT_EQ(cairo_surface_status(surface_.get()), CAIRO_STATUS_SUCCESS) << path;
  }

  int
  width() const
  {
    return cairo_image_surface_get_width(surface_.get());
  }
  int
  height() const
  {
    return cairo_image_surface_get_height(surface_.get());
  }
  /// Number of different colours, of which a picture that is blank or has only text holds few.
  std::size_t
  colours() const
  {
    std::set<std::uint32_t> seen;
    forEachPixel([&seen](int r, int g, int b) { seen.insert(static_cast<std::uint32_t>(r << 16 | g << 8 | b)); });
    return seen.size();
  }
  std::size_t
  greenPixels() const
  {
    std::size_t count = 0;
    forEachPixel([&count](int r, int g, int b) { count += g > r + 60 && g > b + 40; });
    return count;
  }
  /// Red as contradictions are, which the vermilion of the source is not.
  std::size_t
  redPixels() const
  {
    std::size_t count = 0;
    forEachPixel([&count](int r, int g, int b) { count += r > g + 140 && r > b + 120; });
    return count;
  }

private:
  template <typename Visit>
  void
  forEachPixel(const Visit& visit) const
  {
    const unsigned char* data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int y = 0; y < height(); ++y)
      for (int x = 0; x < width(); ++x) {
        const unsigned char* pixel = data + static_cast<std::ptrdiff_t>(y) * stride + 4 * x;
        visit(pixel[2], pixel[1], pixel[0]); // BGRx
      }
  }

  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
};

struct Outcome {
  int code = -1;
  std::string output;
  std::string errors;
};

class ViewProgram : public ::testing::Test {
protected:
  Outcome
  runAny(const std::string& program, const std::string& arguments) const
  {
    const std::string command =
        program + " " + arguments + " >'" + folder_.file("out") + "' 2>'" + folder_.file("err") + "'";
    const int status = std::system(command.c_str());
    EXPECT_TRUE(WIFEXITED(status)) << command;
    return {WEXITSTATUS(status), io::readFile(folder_.file("out")), io::readFile(folder_.file("err"))};
  }
  Outcome
  run(const std::string& arguments) const
  {
    return runAny("env -u DISPLAY '" PCL_SSFR_VIEW "'", arguments);
  }

  /// Every picture of a folder that the page names is there and shows something.
  void
  checkPictures(const std::string& path, const std::set<std::string>& wanted) const
  {
    const std::string page = io::readFile(path + "/index.html");
    const std::regex image("<img src=\"([^\"]+)\"");
    std::set<std::string> named;
    for (std::sregex_iterator i(page.begin(), page.end(), image), end; i != end; ++i)
      named.insert((*i)[1]);
    EXPECT_EQ(named, wanted);
    for (const std::string& name : named) {
      SCOPED_TRACE(name);
      const fs::path file = fs::path(path) / name;
      ASSERT_TRUE(fs::exists(file));
      const Picture picture(file.string());
      EXPECT_EQ(picture.width(), kPictureWidth);
      EXPECT_GT(picture.height(), 250);
      EXPECT_LT(picture.height(), 3000);
      EXPECT_GT(picture.colours(), 60U);
    }
  }

  static std::string
  data(const std::string& name)
  {
    return "'" + kData + "/" + name + "'";
  }

  TemporaryFolder folder_;
};

const std::set<std::string> kPictures{"before.png",
                                      "after.png",
                                      "matches.png",
                                      "candidates.png",
                                      "axes.png",
                                      "spheres.png",
                                      "patches_source.png",
                                      "patches_target.png",
                                      "stages.png"};
const std::set<std::string> kTruthPictures{"truth.png", "matches_truth.png", "axes_truth.png"};

std::set<std::string>
united(std::set<std::string> a, const std::set<std::string>& b)
{
  a.insert(b.begin(), b.end());
  return a;
}

TEST_F(ViewProgram, helpAndVersion)
{
  const Outcome help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.output, AllOf(StartsWith("Usage: ssfr_view RESULT"), HasSubstr("Exit code")));
  for (const char* option :
       {"--png", "--window", "--screenshot", "--candidate", "--truth", "--pair", "--perturb", "--method", "--leaf"})
    EXPECT_THAT(help.output, HasSubstr(option));
  EXPECT_THAT(run("--version").output, StartsWith("ssfr_view "));
}

TEST_F(ViewProgram, distancesAreThoseOfSsfrAlign)
{
  // In a frame of the site: a small rotation about its origin would be many metres.
  const Eigen::Vector3d place(900, 500, 0);
  std::string scans;
  for (const char* name : {"/hall_1", "/hall_0"}) {
    const std::string file = folder_.file(std::string(name).substr(1) + ".ply");
    io::saveMovedCloud(file, io::loadCloud(kData + name + ".pcd"), Eigen::Isometry3d(Eigen::Translation3d(place)));
    scans += " " + file;
  }
  ASSERT_EQ(runAny(PCL_SSFR_ALIGN, scans + " --json " + folder_.file("off.json")).code, 0);
  const auto json = nlohmann::json::parse(io::readFile(folder_.file("off.json")));
  const Eigen::Vector3d sensor(json["source_viewpoint_m"].get<std::array<double, 3>>().data());
  EXPECT_LT((sensor - place).norm(), 1);
  for (const std::vector<std::string>& inputs :
       {std::vector<std::string>{folder_.file("off.json")},
        std::vector<std::string>{folder_.file("hall_1.ply"), folder_.file("hall_0.ply")}}) {
    const apps::ViewRun run = apps::loadRun(apps::parseViewArguments(inputs));
    EXPECT_LT((run.reference - sensor).norm(), 1e-6) << inputs.front();
  }
}

TEST_F(ViewProgram, everyErrorIsOneLineThatNamesTheThing)
{
  io::writeFile(folder_.file("good.xyz"), "1 2 3\n");
  io::writeFile(folder_.file("broken.json"), "{\"method\": ");
  io::writeFile(folder_.file("empty.json"), "{}");
  const std::string pose = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
  const std::string start = "{\"method\": \"ssfr\", \"message\": \"\", \"overlap\": 0.5, \"time_s\": 1, "
                            "\"candidates\": [], \"stages\": [], \"source\": \"good.xyz\", \"T_target_source\": " +
                            pose;
  io::writeFile(folder_.file("status.json"), start + ", \"status\": \"happy\", \"target\": \"good.xyz\"}");
  io::writeFile(folder_.file("gone.json"), start + ", \"status\": \"converged\", \"target\": \"gone.xyz\"}");
  const std::string other = start + ", \"status\": \"converged\", \"target\": \"good.xyz\"}";
  io::writeFile(folder_.file("method.json"), std::string(other).replace(other.find("ssfr"), 4, "magic"));
  const std::string no_stages = "\"stages\": []";
  io::writeFile(
      folder_.file("replaced.json"),
      std::string(other).replace(other.find(no_stages),
                                 no_stages.size(),
                                 R"("stages": [{"name": "target thinning", "seconds": 1, "in": 7, "out": 5}])"));
  io::writeFile(folder_.file("options.json"),
                start + ", \"status\": \"converged\", \"target\": \"good.xyz\", \"options\": {\"leaf\": -1}}");
  io::writeFile(folder_.file("file"), "in the way");
  fs::create_directory(folder_.file("nothing"));
  struct Case {
    std::string arguments;
    int code;
    std::string named;
  };
  const std::string png = " --png " + folder_.file("pictures");
  const std::string good = folder_.file("good.xyz");
  const std::vector<Case> cases{{png, 2, "RESULT"},
                                {good + png, 2, "TARGET"},
                                {good + " " + good + png + " --wrong", 2, "--wrong"},
                                {good + " " + good + png + " --pair 1", 2, "--pair"},
                                {good + " " + good + png + " --candidate 2", 2, "--candidate: '2'"},
                                {good + " " + folder_.file("none.pcd") + png, 3, "none.pcd"},
                                {good + " " + good + png + " --truth " + folder_.file("T.txt"), 3, "T.txt"},
                                {good + " " + good + " --png " + folder_.file("file"), 3, "file"},
                                {folder_.file("none.json") + png, 3, "none.json"},
                                {folder_.file("broken.json") + png, 3, "broken.json: is not JSON"},
                                {folder_.file("empty.json") + png, 3, "empty.json: has no 'method'"},
                                {folder_.file("status.json") + png, 3, "status.json: 'status' is 'happy'"},
                                {folder_.file("gone.json") + png, 3, "gone.xyz"},
                                {folder_.file("method.json") + png, 3, "method.json: 'method' is 'magic'"},
                                {folder_.file("replaced.json") + png, 3, "'target' had 7 points when"},
                                {folder_.file("options.json") + png, 3, "options.json: 'options'"},
                                {folder_.file("gone.json") + png + " --leaf 0.1", 2, "--leaf"},
                                {folder_.file("nothing") + png, 3, "pairs.csv"},
                                {"'" + kData + "'" + png, 2, "--pair is missing"},
                                {"'" + kData + "'" + png + " --pair 3", 2, "--pair: '3'"},
                                {good + " " + good + " --screenshot " + folder_.file("none/w.png"), 3, "none"},
                                {good + " " + good, 2, "--png"}};
  for (const Case& c : cases) {
    const Outcome result = run(c.arguments);
    EXPECT_EQ(result.code, c.code) << c.arguments;
    EXPECT_THAT(result.errors, AllOf(StartsWith("ssfr_view: "), HasSubstr(c.named))) << c.arguments;
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
  }
}

TEST_F(ViewProgram, scansWithoutAnAnswerAreDrawnToo)
{
  std::string plane;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 60; ++k)
      plane += std::to_string(0.05 * i) + " " + std::to_string(0.05 * k) + " -1\n";
  io::writeFile(folder_.file("few.xyz"), "1 2 3\n4 5 6\n");
  io::writeFile(folder_.file("plane.xyz"), plane);
  io::writeFile(folder_.file("T.txt"), io::formatTransform(Eigen::Isometry3d::Identity()));
  for (const auto& [scan, status] :
       std::map<std::string, std::string>{{"few.xyz", "too_few_points"}, {"plane.xyz", "too_few_directions"}})
    for (const char* profile : {"default", "paper2017"}) {
      SCOPED_TRACE(scan + " " + profile);
      const std::string path = folder_.file("pictures");
      const Outcome result = run(folder_.file(scan) + " " + folder_.file(scan) + " --truth " + folder_.file("T.txt") +
                                 " --profile " + profile + " --png " + path);
      ASSERT_EQ(result.code, 0) << result.errors;
      EXPECT_THAT(result.output, StartsWith("Not aligned: " + status));
      EXPECT_THAT(result.output, Not(HasSubstr("candidate 1 is right")));
      for (const std::string& name : united(kPictures, kTruthPictures))
        EXPECT_EQ(Picture((fs::path(path) / name).string()).width(), kPictureWidth) << name;
    }
}

TEST_F(ViewProgram, aRightPoseIsGreenAndAWrongOneRed)
{
  const std::string right = folder_.file("right");
  const std::string wrong = folder_.file("wrong");
  const std::string pair = "'" + kData + "' --pair 1 --png ";
  const Outcome first = run(pair + right);
  ASSERT_EQ(first.code, 0) << first.errors;
  EXPECT_THAT(first.output, StartsWith("Aligned, and right\n"));
  EXPECT_THAT(first.output, Not(HasSubstr("NO ")));
  checkPictures(right, united(kPictures, kTruthPictures));
  ASSERT_EQ(run(pair + wrong + " --candidate 2").code, 0);

  const Picture green(right + "/matches.png");
  const Picture red(wrong + "/matches.png");
  EXPECT_GT(green.greenPixels(), 10 * green.redPixels());
  EXPECT_GT(red.redPixels(), 2 * green.redPixels());
  EXPECT_LT(red.greenPixels() * green.redPixels(), green.greenPixels() * red.redPixels() / 3);
  EXPECT_GT(Picture(right + "/matches_truth.png").greenPixels(), 10 * green.redPixels());
  // The page of the wrong one says so.
  EXPECT_THAT(io::readFile(wrong + "/index.html"), HasSubstr("Matches and contradictions: candidate 2"));
}

TEST_F(ViewProgram, aVariedPairHasItsOwnTruth)
{
  const Outcome result = run("'" + kData + "' --pair 0 --perturb se3 --seed 7 --png " + folder_.file("pictures"));
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_THAT(result.output, StartsWith("Aligned, and right\n"));
  EXPECT_THAT(result.output, HasSubstr("source moved at random"));
}

/// Lines about poses: the same for the same answer.
std::vector<std::string>
poseLines(const std::string& output)
{
  std::vector<std::string> lines;
  std::istringstream stream(output);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("  candidate ", 0) == 0)
      lines.push_back(line);
  return lines;
}

TEST_F(ViewProgram, aJsonResultShowsWhatTheRunFound)
{
  const std::string scans = data("apartment_1.pcd") + " " + data("apartment_0.pcd");
  const Outcome align = runAny("'" PCL_SSFR_ALIGN "'", scans + " --leaf 0.03 --json " + folder_.file("run.json"));
  ASSERT_EQ(align.code, 0) << align.errors;
  const auto json = nlohmann::json::parse(io::readFile(folder_.file("run.json")));
  EXPECT_EQ(json["source_path"], kData + "/apartment_1.pcd");
  EXPECT_EQ(json["options"]["leaf"], 0.03);
  const Outcome of_json = run(folder_.file("run.json") + " --png " + folder_.file("a"));
  ASSERT_EQ(of_json.code, 0) << of_json.errors;
  checkPictures(folder_.file("a"), kPictures);
  const Outcome of_scans = run(scans + " --leaf 0.03 --png " + folder_.file("b"));
  EXPECT_EQ(poseLines(of_json.output), poseLines(of_scans.output));
  EXPECT_GE(poseLines(of_json.output).size(), 2U);
  EXPECT_EQ(io::readFile(folder_.file("a") + "/axes.png"), io::readFile(folder_.file("b") + "/axes.png"));
}

TEST_F(ViewProgram, resultsOfTheBenchmarkAreFoundAgain)
{
  const std::string results = folder_.file("results");
  io::writeFile(folder_.file("coarse.json"), R"({"leaf": 0.2})"); // of what ICP gets
  const Outcome benchmark = runAny("'" PCL_SSFR_BENCHMARK "'",
                                   "--dataset '" + kData +
                                       "' --methods ssfr,icp_point_to_point --pairs 0 --perturb se3 "
                                       "--pictures 0 --parameters " +
                                       folder_.file("coarse.json") + " --out " + results);
  ASSERT_EQ(benchmark.code, 0) << benchmark.errors;
  const Outcome ours = run(results + " --pair 0 --png " + folder_.file("ours"));
  ASSERT_EQ(ours.code, 0) << ours.errors;
  EXPECT_THAT(ours.output, AllOf(StartsWith("Aligned, and right\n"), HasSubstr("the same pose as in results.csv")));
  const Outcome icp = run(results + " --pair 0 --method icp_point_to_point --png " + folder_.file("icp"));
  ASSERT_EQ(icp.code, 0) << icp.errors;
  EXPECT_THAT(icp.output, AllOf(HasSubstr("WRONG"), HasSubstr("The pose is that of results.csv")));
  const Outcome other = run(results + " --pair 0 --method fgr --png " + folder_.file("fgr"));
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.errors, AllOf(HasSubstr("--method"), HasSubstr("icp_point_to_point, ssfr")));
  EXPECT_EQ(run(results + " --pair 1 --png " + folder_.file("none")).code, 2);
}

TEST_F(ViewProgram, thePapersProfileIsShownWithItsOwnStages)
{
  const Outcome result = run("'" + kData + "' --pair 0 --method ssfr_paper2017 --png " + folder_.file("pictures"));
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(StartsWith("Aligned"), HasSubstr("paper's profile")));
  EXPECT_THAT(result.output, HasSubstr("shift along axis 3"));
  checkPictures(folder_.file("pictures"), united(kPictures, kTruthPictures));
}

// ---------------------------------------------------------------------------------------------------------------------
// What the pictures are made of

apps::ViewModel
modelOf(std::size_t pair)
{
  apps::ViewArguments arguments =
      apps::parseViewArguments({kData, "--pair", std::to_string(pair), "--png", "none", "--threads", "1"});
  return apps::ViewModel(apps::loadRun(arguments), 1);
}

TEST(ViewModel, showsTheSameFiguresAsTheResult)
{
  const apps::ViewModel model = modelOf(0);
  for (const apps::ViewedPose& pose : model.poses()) {
    const Candidate judged = apps::scoredPose(
        model.source(), model.target(), pose.candidate.T_target_source, model.run().report.options, false);
    EXPECT_NEAR(judged.score, pose.candidate.score, 1e-9) << pose.name;
    EXPECT_NEAR(judged.overlap, pose.candidate.overlap, 1e-9) << pose.name;
    const apps::SurfaceFates source = model.fates(pose, true);
    const apps::SurfaceFates target = model.fates(pose, false);
    const auto share = [&](apps::SurfaceFate fate) {
      const auto k = static_cast<std::size_t>(fate);
      return (source.surface[k] + target.surface[k]) / (source.total() + target.total());
    };
    EXPECT_NEAR(share(apps::SurfaceFate::Matched), pose.candidate.overlap, 1e-9);
    EXPECT_NEAR(share(apps::SurfaceFate::Contradicted), pose.candidate.contradiction, 1e-9);
  }
  EXPECT_EQ(model.sphere(true).main_normals.size(), model.source().main_normals.size());
  EXPECT_GE(model.sphere(true).regions.size(), model.source().main_normals.size());
}

TEST(ViewModel, shiftsOfAPoseAreItsTranslationAlongTheAxes)
{
  const apps::ViewModel model = modelOf(1);
  const apps::ViewedPose& pose = model.chosenPose();
  const std::array<apps::AxisView, 3> axes = model.axes(pose, true);
  const Eigen::Isometry3d T = model.toPatches(pose.candidate.T_target_source);
  for (const apps::AxisView& axis : axes) {
    EXPECT_NEAR(axis.shift, axis.axis.dot(T.translation()), 1e-9);
    ASSERT_TRUE(axis.true_shift);
    EXPECT_NEAR(axis.shift, *axis.true_shift, 0.05);
    // The pose is right: along no axis does another shift make more surface meet its counterpart.
    const auto best = std::max_element(axis.scores.begin(), axis.scores.end(), [](const auto& a, const auto& b) {
      return a.matched - 12 * a.contradicted < b.matched - 12 * b.contradicted;
    });
    EXPECT_NEAR(best->offset, 0, 0.2);
  }
  EXPECT_FALSE(axes[0].peaks.empty());
  EXPECT_TRUE(axes[2].every_shift);
}

TEST(ViewModel, saysWhereTheTruthIsLost)
{
  const apps::ViewModel right = modelOf(0);
  for (const apps::LossStep& step : right.findLoss())
    EXPECT_TRUE(step.passed) << step.stage << ": " << step.finding;
  // A truth that is none: rotated by 20 degrees, no candidate rotation is near it.
  apps::ViewArguments arguments = apps::parseViewArguments({kData, "--pair", "0", "--png", "none"});
  apps::ViewRun run = apps::loadRun(arguments);
  run.truth = *run.truth * Eigen::AngleAxisd(0.35, Eigen::Vector3d(1, 1, 1).normalized());
  const apps::ViewModel rotated(std::move(run), 1);
  const std::vector<apps::LossStep> lost = rotated.findLoss();
  ASSERT_FALSE(lost.empty());
  EXPECT_EQ(lost.front().stage, "rotation");
  EXPECT_FALSE(lost.front().passed);
  EXPECT_FALSE(lost.back().passed);
  // One that is shifted: the rotation is there, the selection fails.
  run = apps::loadRun(arguments);
  run.truth = Eigen::Translation3d(1.7, 2.3, 0) * *run.truth;
  const apps::ViewModel shifted(std::move(run), 1);
  EXPECT_TRUE(shifted.findLoss().front().passed);
  EXPECT_FALSE(shifted.findLoss().back().passed);
}

TEST(ViewModel, explainsEveryEffortThatWasMade)
{
  const auto passesExplained = [](const std::vector<std::string>& scans) {
    std::vector<std::string> arguments = scans;
    arguments.insert(arguments.end(), {"--png", "none", "--threads", "1"});
    apps::ViewRun run = apps::loadRun(apps::parseViewArguments(arguments));
    run.truth = Eigen::Isometry3d::Identity();
    const apps::ViewModel model(std::move(run), 1);
    std::set<std::string> passes;
    for (const apps::LossStep& step : model.findLoss())
      if (step.stage.rfind("rotation", 0) == 0)
        passes.insert(step.stage);
    return passes;
  };
  const std::string data = kData;
  // The scans of one place are laid on each other at once, those of two places are looked at twice.
  EXPECT_EQ(passesExplained({data + "/hall_1.pcd", data + "/hall_0.pcd"}), std::set<std::string>({"rotation"}));
  EXPECT_EQ(passesExplained({data + "/apartment_1.pcd", data + "/hall_0.pcd"}),
            std::set<std::string>({"rotation, pass 1", "rotation, pass 2"}));
}

// ---------------------------------------------------------------------------------------------------------------------
// The window

TEST_F(ViewProgram, theWindowOpensIsPhotographedAndCloses)
{
#ifndef PCL_SSFR_HAS_VIEWER
  GTEST_SKIP() << "ssfr_view was built without a window";
#else
  if (std::system("command -v xvfb-run >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "xvfb-run is not installed: no display to open a window on";
  const std::string shot = folder_.file("window.png");
  // Leaks of X, GL and VTK are theirs.
  const std::string xvfb =
      "env ASAN_OPTIONS=detect_leaks=0 xvfb-run -a -s '-screen 0 1600x1000x24' '" PCL_SSFR_VIEW "'";
  const std::string pair = "'" + kData + "' --pair 0 --screenshot ";
  const Outcome points = runAny(xvfb, pair + shot);
  ASSERT_EQ(points.code, 0) << points.errors;
  EXPECT_EQ(points.errors, "");
  const Picture plain(shot);
  EXPECT_EQ(plain.width(), 1400);
  EXPECT_EQ(plain.height(), 860);
  EXPECT_GT(plain.colours(), 100U);
  const Outcome matches = runAny(xvfb, pair + shot + " --layer matches");
  ASSERT_EQ(matches.code, 0) << matches.errors;
  EXPECT_GT(Picture(shot).greenPixels(), 20000U);
  EXPECT_LT(plain.greenPixels(), 2000U);

  const Outcome broken = runAny("env DISPLAY=:7654321 '" PCL_SSFR_VIEW "'", "'" + kData + "' --pair 0");
  EXPECT_EQ(broken.code, 2);
  EXPECT_THAT(broken.errors, AllOf(HasSubstr(":7654321"), HasSubstr("--png")));
#endif
}

} // namespace
} // namespace pcl_ssfr::test_view_cli
