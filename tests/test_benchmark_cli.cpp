// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// ssfr_benchmark as its users run it. PCL_SSFR_BENCHMARK is the path of the program, PCL_SSFR_MPIRUN of mpirun or
// empty.

#include "preparation/thinning.h"

#include <apps/benchmark/benchmark_plan.h>
#include <apps/io/dataset_folder.h>
#include <apps/io/file_bytes.h>
#include <apps/io/pcd_format.h>
#include <apps/io/transform_file.h>
#include <apps/pairs/result_row.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace pcl_ssfr::apps::test_benchmark_cli {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using testing::TemporaryFolder;

/// Whether a process runs; one that ended but that nobody has waited for does not.
bool
isAlive(pid_t process)
{
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string number, name, state;
  in >> number >> name >> state;
  return !state.empty() && state != "Z";
}

struct Outcome {
  int code = -1;
  std::string output;
  std::string errors;
};

class BenchmarkProgram : public ::testing::Test {
protected:
  /// The apartment of the test data, thinned: small enough for every method.
  static void
  SetUpTestSuite()
  {
    data_ = new TemporaryFolder;
    const io::DatasetFolder full = io::readDatasetFolder(PCL_SSFR_DATA_DIR);
    const io::ScanPair& pair = full.pairs.front();
    for (const std::string& name : {pair.source, pair.target}) {
      const io::LoadedCloud cloud = io::loadCloud(io::scanPath(full.path, name));
      constexpr double kLeaf = 0.15;
      const ThinnedCloud thinned = thinScan(viewOf(cloud), kLeaf, Eigen::Vector3d::Zero());
      std::string text;
      for (Eigen::Index i = 0; i < thinned.size(); ++i)
        text += std::to_string(thinned.points(0, i)) + " " + std::to_string(thinned.points(1, i)) + " " +
                std::to_string(thinned.points(2, i)) + "\n";
      io::writeFile(data_->file(name + ".xyz"), text);
    }
    std::string header = "source,target";
    std::string forth = pair.source + ".xyz," + pair.target + ".xyz";
    std::string back = pair.target + ".xyz," + pair.source + ".xyz";
    truth_ = pair.T_target_source;
    const Eigen::Isometry3d inverse = truth_.inverse();
    for (int i = 0; i < 12; ++i) {
      header += ",T" + std::to_string(i / 4) + std::to_string(i % 4);
      forth += "," + std::to_string(truth_.matrix()(i / 4, i % 4));
      back += "," + std::to_string(inverse.matrix()(i / 4, i % 4));
    }
    io::writeFile(data_->file("pairs.csv"), header + "\n" + forth + "\n" + back + "\n");
    io::writeFile(data_->file("dataset.json"),
                  R"({"name": "small", "success": {"rotation_deg": 2, "translation_m": 0.2}})");
    // Lots are drawn less often than in earnest: here it matters that every method runs, not that it succeeds.
    io::writeFile(
        data_->file("quick.json"),
        R"({"ransac_iterations": 300, "sac_ia_iterations": 20, "fpcs_samples": 40, "max_seconds": 1, "go_icp_points": 60,
                      "leaf": 0.2, "keypoint_leaf": 5})");
  }
  static void
  TearDownTestSuite()
  {
    delete data_;
    data_ = nullptr;
  }

  std::string
  command(const std::string& arguments) const
  {
    return std::string("'") + PCL_SSFR_BENCHMARK + "' " + arguments;
  }
  Outcome
  shell(const std::string& text) const
  {
    const int status =
        std::system((text + " >'" + folder_.file("stdout") + "' 2>'" + folder_.file("stderr") + "'").c_str());
    EXPECT_TRUE(WIFEXITED(status)) << text;
    return {WEXITSTATUS(status), io::readFile(folder_.file("stdout")), io::readFile(folder_.file("stderr"))};
  }
  Outcome
  run(const std::string& arguments) const
  {
    return shell(command(arguments));
  }
  std::string
  small() const
  {
    return "--dataset " + data_->file("") + " ";
  }
  std::string
  out(const std::string& name = "out") const
  {
    return " --out " + folder_.file(name) + " ";
  }
  std::vector<ResultRow>
  rows(const std::string& name = "out") const
  {
    std::ifstream in(folder_.file(name + "/results.csv"));
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, csvHeader());
    std::vector<ResultRow> result;
    while (std::getline(in, line))
      result.push_back(rowFromCsv(line));
    return result;
  }
  /// What must not depend on how the run was cut into processes: all but times and memory.
  std::map<std::string, std::string>
  answers(const std::string& name) const
  {
    std::map<std::string, std::string> result;
    for (ResultRow row : rows(name)) {
      row.time_s = row.cpu_s = row.peak_rss_mib = 0;
      EXPECT_TRUE(result.emplace(rowKey(row), toCsvLine(row)).second);
    }
    return result;
  }
  /// What report.html holds.
  nlohmann::json
  reportData(const std::string& name) const
  {
    const std::string page = io::readFile(folder_.file(name + "/report.html"));
    const std::string mark = "id=\"data\">";
    const std::size_t begin = page.find(mark) + mark.size();
    return nlohmann::json::parse(page.substr(begin, page.find("</script", begin) - begin));
  }
  /// A script to compare with.
  std::string
  script(const std::string& name, const std::string& text) const
  {
    io::writeFile(folder_.file(name), "#!/bin/sh\n" + text + "\n");
    chmod(folder_.file(name).c_str(), 0755);
    return folder_.file(name);
  }
  static std::string
  truthAsJson()
  {
    return matrixJson(truth_).dump();
  }

  TemporaryFolder folder_;
  static TemporaryFolder* data_;
  static Eigen::Isometry3d truth_;
};

TemporaryFolder* BenchmarkProgram::data_ = nullptr;
Eigen::Isometry3d BenchmarkProgram::truth_ = Eigen::Isometry3d::Identity();

TEST_F(BenchmarkProgram, helpAndVersion)
{
  const Outcome help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.output, StartsWith("Usage: ssfr_benchmark"));
  const Outcome version = run("--version");
  EXPECT_EQ(version.code, 0);
  EXPECT_THAT(version.output, StartsWith("ssfr_benchmark "));
}

TEST_F(BenchmarkProgram, badInputIsOneLineBeforeAnyWork)
{
  std::filesystem::create_directories(folder_.file("bad"));
  io::writeFile(folder_.file("bad/a.xyz"), "1 2 3\n");
  io::writeFile(folder_.file("bad/pairs.csv"),
                "source,target,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n"
                "a.xyz,a.xyz,1,0,0,0,0,1,0,0,0,0,one,0\n");
  io::writeFile(folder_.file("broken.json"), "{");
  struct Case {
    std::string arguments;
    int code;
    std::string named;
  };
  const Case cases[] = {{"", 2, "--dataset"},
                        {small() + out() + "--frobnicate", 2, "--frobnicate"},
                        {small() + out() + "--methods magic", 2, "'magic'"},
                        {small() + out() + "--methods ''", 2, "--methods: the value is empty"},
                        {small() + out() + "--cpu-timeout soon", 2, "--cpu-timeout: 'soon'"},
                        {small() + out() + "--pairs 7", 2, "--pairs: '7'"},
                        {"--dataset " + folder_.file("none") + out(), 3, "none"},
                        {"--dataset " + folder_.file("bad") + out(), 3, "pairs.csv:2: column T22: 'one'"},
                        {small() + out() + "--external " + folder_.file("broken.json"), 3, "broken.json:1: column"},
                        {small() + out() + "--parameters " + folder_.file("no.json"), 3, "no.json"},
                        {small() + "--out /proc/none", 3, "/proc/none"}};
  for (const Case& c : cases) {
    const Outcome result = run(c.arguments);
    EXPECT_EQ(result.code, c.code) << c.arguments;
    EXPECT_EQ(result.output, "") << c.arguments;
    EXPECT_THAT(result.errors, AllOf(StartsWith("ssfr_benchmark: "), HasSubstr(c.named))) << c.arguments;
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    EXPECT_FALSE(std::filesystem::exists(folder_.file("out/results.csv"))) << c.arguments;
  }
}

TEST_F(BenchmarkProgram, everyMethodRuns)
{
  const Outcome result =
      run(small() + out() + "--methods all --pairs 0 --timeout 30 --jobs 2 --parameters " + data_->file("quick.json"));
  ASSERT_EQ(result.code, 0) << result.errors;
  const std::vector<ResultRow> all = rows();
  EXPECT_EQ(all.size(), methods().size());
  for (const ResultRow& row : all) {
    SCOPED_TRACE(row.method + " " + row.status + " " + row.message);
    for (const char* broken : {"crashed", "failed", "missing", "bad_output", "out_of_memory", "timeout"})
      EXPECT_NE(row.status, broken);
    EXPECT_GT(row.time_s, 0);
    EXPECT_GE(row.cpu_s, 0);
    EXPECT_GT(row.peak_rss_mib, 1);
    EXPECT_GT(row.overlap, 0.3);
    EXPECT_GT(row.gt_rmse_m, 0);
    EXPECT_LT(row.gt_rmse_m, 0.2);
    if (row.method.rfind("ssfr", 0) == 0 && row.method != "ssfr_paper2017") {
      EXPECT_TRUE(row.success);
      EXPECT_LT(row.rmse_m, 1.5 * row.gt_rmse_m + 0.02);
      EXPECT_GT(row.confidence, 0.5);
    }
  }
  const auto summary = nlohmann::json::parse(io::readFile(folder_.file("out/summary.json")));
  EXPECT_EQ(summary["complete"], true);
  EXPECT_EQ(summary["methods"].size(), methods().size());
  EXPECT_EQ(summary["settings"]["parameters"]["leaf"], 0.2);
  EXPECT_THAT(io::readFile(folder_.file("out/summary.md")), HasSubstr("| ssfr | 1 of 1, 100 % [21, 100] |"));
}

TEST_F(BenchmarkProgram, perturbedPairsAreTheSameForEveryNumberOfJobs)
{
  const std::string common = small() +
                             "--methods ssfr,icp_point_to_plane,fpfh_sac_ia --perturb se3 --resolution 0,0.25 "
                             "--noise 0.01 --outliers 0.05 --overlap 0.4 --parameters " +
                             data_->file("quick.json");
  ASSERT_EQ(run(common + out("one")).code, 0);
  ASSERT_EQ(run(common + out("two") + " --jobs 3 --threads 2 ").code, 0);
  const auto one = answers("one");
  EXPECT_EQ(one.size(), 12U);
  EXPECT_EQ(one, answers("two"));
  for (const ResultRow& row : rows("one")) {
    EXPECT_LT(row.overlap, 0.5); // the target was cut: nine tenths before; points at the cut find others
    ASSERT_TRUE(row.truth);
    EXPECT_GT((row.truth->matrix() - truth_.matrix()).norm(), 0.1); // ground truth follows
    if (row.method == "icp_point_to_plane") {
      EXPECT_FALSE(row.success);
    }
  }
}

TEST_F(BenchmarkProgram, candidatesAndMovedOrigins)
{
  const std::string what = small() + "--methods ssfr,icp_point_to_point --pairs 0 --random-rotation ";
  const std::string common = what + out();
  ASSERT_EQ(run(common + "--origin-offset 30 --candidates").code, 0);
  const std::vector<ResultRow> all = rows();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].method, "ssfr");
  EXPECT_TRUE(all[0].success) << all[0].message;
  EXPECT_EQ(all[0].right_rank, 1);
  ASSERT_TRUE(all[0].truth);
  EXPECT_EQ(all[0].variation.origin_offset_m, 30);
  std::ifstream in(folder_.file("out/candidates.csv"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    lines.push_back(line);
  ASSERT_GE(lines.size(), 3U);
  EXPECT_THAT(lines[0], HasSubstr("score,overlap,contradiction,"));
  EXPECT_THAT(lines[1], HasSubstr(",ssfr,1,1,")); // the first of ssfr is right, that of ICP is not
  EXPECT_THAT(lines.back(), AllOf(StartsWith("2,small,"), HasSubstr(",icp_point_to_point,1,0,")));
  EXPECT_THAT(run(common + "--origin-offset 30 --resume").errors, HasSubstr("candidates was true and is now false"));
  EXPECT_GT(all[0].overlap, 0.3);
  EXPECT_THAT(run(common + "--origin-offset 30 --candidates --no-rmse --resume").errors,
              HasSubstr("rmse was true and is now false"));
  ASSERT_EQ(run(what + "--origin-offset 30 --candidates --no-rmse" + out("quick")).code, 0);
  const ResultRow quick = rows("quick").front();
  EXPECT_TRUE(std::isnan(quick.overlap) && std::isnan(quick.rmse_m) && std::isnan(quick.gt_rmse_m));
  EXPECT_EQ(quick.rotation_error_deg, all[0].rotation_error_deg); // nothing else changes
  EXPECT_EQ(quick.source_points, all[0].source_points);
  // Another variation is another row of the same folder.
  ASSERT_EQ(run(common + "--degrade-every 3 --candidates --resume").code, 0);
  EXPECT_EQ(rows().size(), 4U);
  const auto summary = nlohmann::json::parse(io::readFile(folder_.file("out/summary.json")));
  ASSERT_EQ(summary["methods"].size(), 4U);
  std::set<std::pair<double, int>> variations;
  for (const auto& entry : summary["methods"])
    variations.emplace(entry["variation"]["origin_offset_m"].get<double>(),
                       entry["variation"]["degrade_every"].get<int>());
  EXPECT_EQ(variations, (std::set<std::pair<double, int>>{{30., 1}, {0., 3}}));
}

TEST_F(BenchmarkProgram, theStageThatLostTheTruthIsNamed)
{
  // The true pose by the file is 77 m off: the evidence is for the answer.
  std::filesystem::copy(data_->file(""), folder_.file("wrong"));
  const io::ScanPair pair = io::readDatasetFolder(data_->file("")).pairs.front();
  io::writeFile(folder_.file("wrong/pairs.csv"),
                "source,target,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n" + pair.source + "," + pair.target +
                    ",1,0,0,0,0,1,0,77,0,0,1,0\n");
  ASSERT_EQ(run("--dataset " + folder_.file("wrong") + out() + "--methods ssfr,icp_point_to_point --no-rmse").code, 0);
  const std::vector<ResultRow> all = rows();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_FALSE(all[0].success);
  EXPECT_EQ(all[0].lost_at, "evidence");
  EXPECT_EQ(all[1].lost_at, ""); // only ssfr can say
  const std::string summary = io::readFile(folder_.file("out/summary.json"));
  EXPECT_THAT(summary, HasSubstr("\"lost_at\": {\n        \"evidence\": 1\n"));
  // A right answer lost nothing.
  ASSERT_EQ(run(small() + out("right") + "--methods ssfr --pairs 0 --no-rmse").code, 0);
  EXPECT_TRUE(rows("right").at(0).success);
  EXPECT_EQ(rows("right").at(0).lost_at, "");
}

TEST_F(BenchmarkProgram, acceptedAnswersAreFalseWhereNoPoseIsRight)
{
  const Outcome run_once = run(small() + out() + "--methods icp_point_to_point,ssfr --pairs 0 --mirror-source");
  ASSERT_EQ(run_once.code, 0);
  EXPECT_THAT(run_once.errors, HasSubstr("icp_point_to_point: accepted, converged, no pose is right, "));
  EXPECT_THAT(run_once.errors, AllOf(Not(HasSubstr("wrong")), Not(HasSubstr("nan"))));
  for (const ResultRow& row : rows()) {
    EXPECT_FALSE(row.success);
    EXPECT_FALSE(row.truth);
    EXPECT_TRUE(std::isnan(row.rotation_error_deg));
    EXPECT_TRUE(std::isnan(row.overlap));
  }
  const auto summary = nlohmann::json::parse(io::readFile(folder_.file("out/summary.json")));
  for (const auto& entry : summary["methods"]) {
    EXPECT_EQ(entry["solved"], 0);
    if (entry["method"] == "icp_point_to_point") {
      EXPECT_EQ(entry["accepted"], 1); // it accepts where it stops
    }
    EXPECT_EQ(entry["false_positives"], entry["accepted"]);
    EXPECT_EQ(entry["log_loss"].is_number(), entry["method"] == "ssfr");
  }
}

TEST_F(BenchmarkProgram, externalProgramsCannotHurt)
{
  const std::string good =
      script("good.sh",
             "test -f \"$1\" && test -f \"$2\" || exit 3\necho chatter\necho '{\"T\": " + truthAsJson() +
                 ", \"time_s\": 1.25, \"converged\": true, \"confidence\": 0.75}'\necho bye");
  const std::string flat =
      script("flat.sh", "echo '{\"T_target_source\": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1], \"converged\": false}'");
  const std::string crash = script("crash.sh", "echo about to fall >&2\nkill -SEGV $$");
  // A child in a session of its own must not outlive the time limit.
  const std::string hang =
      script("hang.sh", "setsid sh -c 'echo $$ > " + folder_.file("stray") + "; sleep 300' &\nsleep 300");
  const std::string rubbish = script("rubbish.sh", "echo 'not {json'\nhead -c 100000 /dev/zero");
  const std::string scaled = script("scaled.sh", "echo '{\"T\": [2,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}'");
  const std::string fails = script("fails.sh", "echo no licence >&2\nexit 7");
  const std::string hungry = script("hungry.sh", "python3 -c 'x = bytearray(150 << 20); print(\"{}\")'");
  nlohmann::json json;
  for (const auto& [name, program] : std::map<std::string, std::string>{{"good", good},
                                                                        {"flat", flat},
                                                                        {"crash", crash},
                                                                        {"rubbish", rubbish},
                                                                        {"scaled", scaled},
                                                                        {"fails", fails},
                                                                        {"hungry", hungry}})
    json[name]["command"] = "'" + program + "' {source} {target}";
  json["missing"]["command"] = folder_.file("nowhere") + " {source}";
  json["missing2"]["command"] = "no-such-program-anywhere";
  io::writeFile(folder_.file("methods.json"), json.dump());
  const Outcome result =
      run(small() + out() + "--methods good --pairs 0 --perturb none --external " + folder_.file("methods.json"));
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(rows().size(), 1U); // only the one that was named
  ASSERT_EQ(run(small() + out() + "--pairs 0 --jobs 2 --resume --external " + folder_.file("methods.json")).code, 0);
  std::map<std::string, ResultRow> by_name;
  for (const ResultRow& row : rows())
    by_name[row.method] = row;
  EXPECT_EQ(by_name.size(), 10U); // all of them and ssfr
  EXPECT_TRUE(by_name["good"].success);
  EXPECT_TRUE(by_name["good"].converged);
  EXPECT_EQ(by_name["good"].time_s, 1.25);
  EXPECT_EQ(by_name["good"].confidence, 0.75);
  EXPECT_LT(by_name["good"].rotation_error_deg, 1e-3);
  EXPECT_NEAR(by_name["good"].rmse_m, by_name["good"].gt_rmse_m, 1e-5);
  EXPECT_EQ(by_name["flat"].status, "no_candidate");
  EXPECT_FALSE(by_name["flat"].success);
  EXPECT_GT(by_name["flat"].rotation_error_deg, 2);
  EXPECT_EQ(by_name["crash"].status, "crashed");
  EXPECT_THAT(by_name["crash"].message, HasSubstr("about to fall"));
  EXPECT_EQ(by_name["rubbish"].status, "bad_output");
  EXPECT_EQ(by_name["scaled"].status, "bad_output");
  EXPECT_THAT(by_name["scaled"].message, HasSubstr("rigid motion"));
  EXPECT_EQ(by_name["fails"].status, "failed");
  EXPECT_EQ(by_name["fails"].message, "exit code 7: no licence");
  EXPECT_EQ(by_name["missing"].status, "missing");
  EXPECT_EQ(by_name["missing2"].status, "missing");
  EXPECT_THAT(by_name["missing2"].message, HasSubstr("no-such-program-anywhere"));
  EXPECT_EQ(by_name["hungry"].status, "bad_output");
  EXPECT_GT(by_name["hungry"].peak_rss_mib, 150);
  EXPECT_LT(by_name["hungry"].peak_rss_mib, 300);
  EXPECT_LT(by_name["fails"].peak_rss_mib, 60);

  // Alone, as the others have all the time that they need to start on a busy machine.
  const nlohmann::json hangs{{"hang", {{"command", "'" + hang + "' {source} {target}"}}}};
  io::writeFile(folder_.file("hangs.json"), hangs.dump());
  ASSERT_EQ(
      run(small() + out("hung") + "--methods hang --pairs 0 --timeout 2 --external " + folder_.file("hangs.json")).code,
      0);
  ASSERT_EQ(rows("hung").size(), 1U);
  EXPECT_EQ(rows("hung")[0].status, "timeout");
  EXPECT_NEAR(rows("hung")[0].time_s, 2, 1);
  const int stray = std::stoi(io::readFile(folder_.file("stray")));
  EXPECT_FALSE(isAlive(stray)) << "a child of the program that hung is still there";
}

TEST_F(BenchmarkProgram, externalProgramsMayPrintWhatTheyLike)
{
  const std::string answer = "echo '{\"T\": " + truthAsJson() + "}'";
  // Bytes of which each takes six in JSON, before and after a result, and in one.
  const std::string chatty = script("chatty.sh", "head -c 3000000 /dev/zero\necho\n" + answer);
  const std::string first = script("first.sh", answer + "\nhead -c 500000 /dev/zero");
  io::writeFile(folder_.file("wordy.py"),
                R"(print('{"x": "' + r'\u0001' * 150000 + '", "T": )" + truthAsJson() + R"(}'))");
  const std::string wordy = script("wordy.sh", "python3 " + folder_.file("wordy.py"));
  // What is cut to 200 bytes is not cut within a character.
  const std::string cut = script("cut.sh", R"(printf '%0199d\303\244 and more\n' 0 >&2; exit 7)");
  const std::string bytes = script("bytes.sh", R"(printf 'B\374ro\n' >&2; exit 7)");
  nlohmann::json json{{"endless", {{"command", "yes"}}}};
  io::writeFile(folder_.file("endless.json"), json.dump());
  ASSERT_EQ(run(small() + out("endless") + "--methods endless --pairs 0 --timeout 1 --external " +
                folder_.file("endless.json"))
                .code,
            0);
  ASSERT_EQ(rows("endless").size(), 1U);
  EXPECT_EQ(rows("endless")[0].status, "timeout") << rows("endless")[0].message;
  json.clear();
  for (const auto& [name, program] : std::map<std::string, std::string>{
           {"chatty", chatty}, {"first", first}, {"wordy", wordy}, {"cut", cut}, {"bytes", bytes}})
    json[name]["command"] = program;
  io::writeFile(folder_.file("methods.json"), json.dump());
  const Outcome result = run(small() + out() + "--methods chatty,first,wordy,cut,bytes --pairs 0 --external " +
                             folder_.file("methods.json"));
  ASSERT_EQ(result.code, 0) << result.errors;
  std::map<std::string, ResultRow> by_name;
  for (const ResultRow& row : rows())
    by_name[row.method] = row;
  for (const char* name : {"chatty", "first", "wordy"}) {
    EXPECT_EQ(by_name[name].status, "converged") << name << ": " << by_name[name].message;
    EXPECT_TRUE(by_name[name].success) << name;
  }
  EXPECT_EQ(by_name["cut"].message, "exit code 7: " + std::string(199, '0'));
  EXPECT_EQ(by_name["bytes"].message, "exit code 7: B\xef\xbf\xbdro");
}

TEST_F(BenchmarkProgram, externalProgramsGetBinaryFiles)
{
  // It says which source it got, and how its points are stored.
  const std::string shows = script("shows.sh",
                                   "stored=$(grep -a -m 1 ^DATA $1)\nprintf '{\"T\": " + truthAsJson() +
                                       R"(, "message": "%s %s"}\n' "$1" "$stored")");
  io::writeFile(folder_.file("methods.json"), nlohmann::json{{"shows", {{"command", shows + " {source}"}}}}.dump());
  const auto shown = [&](const std::string& name, const std::function<void(const std::string&)>& write) {
    const std::string folder = folder_.file(name);
    std::filesystem::create_directory(folder);
    for (const char* scan : {"/s.pcd", "/t.pcd"})
      write(folder + scan);
    io::writeFile(folder + "/pairs.csv",
                  "source,target,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n"
                  "s.pcd,t.pcd,1,0,0,0,0,1,0,0,0,0,1,0\n");
    EXPECT_EQ(run("--dataset " + folder + out("out_" + name) + "--methods shows --no-rmse --external " +
                  folder_.file("methods.json"))
                  .code,
              0);
    return rows("out_" + name).at(0).message;
  };
  const io::LoadedCloud cloud = io::parseCloud("cloud.xyz", "1 2 3\n4 5 6\n7 8 9\n");
  const std::string binary = shown(
      "binary", [&cloud](const std::string& path) { io::writePcd(path, cloud.table, Eigen::Isometry3d::Identity()); });
  EXPECT_EQ(binary, folder_.file("binary/s.pcd") + " DATA binary"); // as it is
  const std::string ascii = shown("ascii", [](const std::string& path) {
    io::writeFile(path,
                  "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
                  "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n1 2 3\n4 5 6\n7 8 9\n");
  });
  EXPECT_THAT(ascii, AllOf(HasSubstr("/source.pcd"), ::testing::EndsWith(" DATA binary"))); // written again
}

TEST_F(BenchmarkProgram, foldersMayHaveAnyName)
{
  const std::string folder = folder_.file("B\xfcro");
  std::filesystem::copy(data_->file(""), folder);
  std::filesystem::remove(folder + "/dataset.json");
  const std::string common = "--dataset '" + folder + "'" + out() + "--methods icp_point_to_point --pairs 0";
  const Outcome result = run(common);
  ASSERT_EQ(result.code, 0) << result.errors;
  ASSERT_EQ(rows().size(), 1U);
  EXPECT_EQ(rows().front().dataset, "B\xef\xbf\xbdro");
  EXPECT_EQ(rows().front().status, "converged") << rows().front().message;
  EXPECT_EQ(reportData("out")["pairs"].size(), 1U);
  ASSERT_EQ(run(common + " --resume").code, 0);
  EXPECT_EQ(rows().size(), 1U); // it is known again
}

TEST_F(BenchmarkProgram, datasetsOfOneNameKeepTheirNames)
{
  for (const char* folder : {"a", "b"})
    std::filesystem::copy(data_->file(""), folder_.file(folder));
  const std::string pairs = io::readFile(folder_.file("b/pairs.csv"));
  io::writeFile(folder_.file("b/pairs.csv"), pairs.substr(0, pairs.rfind('\n', pairs.size() - 2) + 1)); // but the last
  const std::string a = folder_.file("a"), b = folder_.file("b");
  const std::string common = "--methods icp_point_to_point --pairs 0 --no-rmse ";
  ASSERT_EQ(run("--dataset " + a + " " + b + out() + common).code, 0);
  const nlohmann::json first = reportData("out");
  EXPECT_EQ(first["pairs"].size(), 2U);
  Outcome again = run("--dataset " + a + " " + b + out() + "--report-only");
  ASSERT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(again.errors, "");
  EXPECT_EQ(reportData("out")["pairs"], first["pairs"]);
  again = run("--dataset " + a + out() + "--report-only"); // alone it goes by another name
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.errors, AllOf(HasSubstr("warning: --dataset " + a), HasSubstr("'small'")));
  // Nor are its pairs run a second time.
  again = run("--dataset " + a + out() + common + "--resume");
  EXPECT_EQ(again.code, 3);
  EXPECT_THAT(again.errors, HasSubstr("dataset 'small' is in this folder as 'a'"));
  EXPECT_EQ(rows().size(), 2U);
}

TEST_F(BenchmarkProgram, processorTimeIsLimitedWhateverTheClockSays)
{
  const std::string burn = "x = 0\nwhile True:\n  x += 1\n";
  io::writeFile(folder_.file("burn.py"), burn);
  io::writeFile(folder_.file("short.py"), "import time\nwhile time.process_time() < 0.4:\n  pass\n");
  const std::string burns = script("burns.sh", "python3 " + folder_.file("burn.py"));
  const std::string many = script("many.sh", "while true; do python3 " + folder_.file("short.py") + "; done");
  const std::string sleeps = script("sleeps.sh", "sleep 3\necho '{\"T\": " + truthAsJson() + "}'");
  nlohmann::json json;
  for (const auto& [name, program] :
       std::map<std::string, std::string>{{"burns", burns}, {"many", many}, {"sleeps", sleeps}})
    json[name]["command"] = program;
  io::writeFile(folder_.file("methods.json"), json.dump());
  io::writeFile(folder_.file("endless.json"), R"({"ransac_iterations": 1e9, "leaf": 0.2})");
  const std::string common = small() + out() +
                             "--methods burns,many,sleeps,fpfh_ransac --pairs 0 --jobs 2 --external " +
                             folder_.file("methods.json") + " --parameters " + folder_.file("endless.json");
  ASSERT_EQ(run(common + " --cpu-timeout 1.5").code, 0);
  std::map<std::string, ResultRow> by_name;
  for (const ResultRow& row : rows())
    by_name[row.method] = row;
  for (const char* name : {"burns", "many", "fpfh_ransac"}) {
    EXPECT_EQ(by_name[name].status, "timeout") << name;
    EXPECT_EQ(by_name[name].message, "no answer within 1.5 s of processor time") << name;
    EXPECT_GT(by_name[name].cpu_s, 1.5) << name;
    EXPECT_LT(by_name[name].cpu_s, 4) << name;
  }
  EXPECT_EQ(by_name["sleeps"].status, "converged");
  EXPECT_GT(by_name["sleeps"].time_s, 2.9);
  EXPECT_LT(by_name["sleeps"].cpu_s, 0.5);
  EXPECT_THAT(io::readFile(folder_.file("out/summary.md")),
              HasSubstr("300 s of wall clock and 1.5 s of processor time"));
  EXPECT_THAT(run(common + " --resume --cpu-timeout 2").errors, HasSubstr("cpu_timeout_s was 1.5 and is now 2"));
  EXPECT_THAT(run(common + " --resume").errors, HasSubstr("cpu_timeout_s was 1.5 and is now 0"));
  EXPECT_EQ(run(common + " --resume --cpu-timeout 0").code, 2);
}

/// A run in the background.
class Background {
public:
  Background(const std::string& command, const std::string& log)
  {
    process_ = fork();
    if (process_ == 0) {
      execl("/bin/sh", "sh", "-c", ("exec " + command + " >'" + log + "' 2>&1").c_str(), nullptr);
      _exit(127);
    }
  }
  /// A process that works for the run on a method, once there is one; 0 when there is none for long.
  pid_t
  worker() const
  {
    for (int i = 0; i < 300; ++i) {
      for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process_) + "/task")) {
        std::ifstream children(task.path() / "children");
        for (pid_t child = 0; children >> child;) {
          std::ifstream stat("/proc/" + std::to_string(child) + "/stat");
          constexpr int kUserTime = 14; // its field; no name here has a blank
          std::string field;
          for (int k = 0; k < kUserTime; ++k)
            stat >> field;
          constexpr int kBusyTicks = 50; // 0.5 s: it has read the scans
          if (!field.empty() && std::stoi(field) > kBusyTicks)
            return child;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return 0;
  }
  int
  end(int signal) const
  {
    kill(process_, signal);
    return wait();
  }
  int
  wait() const
  {
    int status = 0;
    waitpid(process_, &status, 0);
    return status;
  }

private:
  pid_t process_;
};

class Interrupted : public BenchmarkProgram {
protected:
  /// A run of slow methods, once it has a result.
  std::unique_ptr<Background>
  start() const
  {
    const std::string slow =
        script("slow.sh", "echo $$ >> " + folder_.file("started") + "\nsleep 1\necho '{\"T\": " + truthAsJson() + "}'");
    nlohmann::json json;
    for (const char* name : {"slow1", "slow2", "slow3", "slow4"})
      json[name]["command"] = slow;
    io::writeFile(folder_.file("methods.json"), json.dump());
    auto run = std::make_unique<Background>(command(arguments()), folder_.file("log"));
    for (int i = 0; i < 300 && lines(folder_.file("started")) < 2; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return run;
  }
  std::string
  arguments() const
  {
    return small() + out() + "--methods slow1,slow2,slow3,slow4 --pairs 0 --external " + folder_.file("methods.json");
  }
  static std::size_t
  lines(const std::string& path)
  {
    std::ifstream in(path);
    std::size_t count = 0;
    for (std::string line; std::getline(in, line);)
      ++count;
    return count;
  }
  /// True when every process that was started has ended.
  bool
  allEnded() const
  {
    std::ifstream in(folder_.file("started"));
    bool ended = true;
    for (pid_t process = 0; in >> process;)
      ended = ended && !isAlive(process);
    return ended;
  }
};

TEST_F(Interrupted, killedRunsGoOn)
{
  start()->end(SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(allEnded()) << "a program outlived the run that started it";
  const std::string before = io::readFile(folder_.file("out/results.csv"));
  EXPECT_GE(rows().size(), 1U);
  EXPECT_LT(rows().size(), 4U);
  io::writeFile(folder_.file("out/results.csv"), before + "small,torn");
  EXPECT_EQ(run(arguments()).code, 3); // not without --resume
  EXPECT_THAT(run(arguments() + " --resume --seed 5").errors, HasSubstr("seed was 1 and is now 5"));
  ASSERT_EQ(run(arguments() + " --resume").code, 0);
  EXPECT_EQ(answers("out").size(), 4U); // each once
  EXPECT_THAT(io::readFile(folder_.file("out/results.csv")), StartsWith(before));
}

TEST_F(Interrupted, stoppedRunsReport)
{
  const auto background = start();
  const Outcome second = run(arguments() + " --resume");
  EXPECT_EQ(second.code, 3);
  EXPECT_THAT(second.errors, HasSubstr("another run"));
  const int status = background->end(SIGINT);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_TRUE(allEnded());
  const auto summary = nlohmann::json::parse(io::readFile(folder_.file("out/summary.json")));
  EXPECT_EQ(summary["complete"], false);
  EXPECT_EQ(summary["planned"], 4);
  EXPECT_EQ(summary["rows"], rows().size());
  EXPECT_THAT(io::readFile(folder_.file("log")), HasSubstr("--resume"));
  const nlohmann::json page = reportData("out");
  EXPECT_EQ(page["complete"], false);
  EXPECT_EQ(page["rows"].size(), rows().size());
}

// Who ends a batch job signals all of its processes, not the first one first.
TEST_F(Interrupted, whatWasEndedWithTheRunIsNoResult)
{
  io::writeFile(folder_.file("endless.json"), R"({"ransac_iterations": 1e9, "leaf": 0.2})");
  const std::string endless =
      small() + out() + "--methods fpfh_ransac --pairs 0 --parameters " + folder_.file("endless.json");
  Background all(command(endless), folder_.file("log"));
  const pid_t first = all.worker();
  ASSERT_GT(first, 0);
  kill(first, SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const int status = all.end(SIGTERM);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM);
  EXPECT_EQ(rows().size(), 0U);

  Background rest(command(endless + " --resume"), folder_.file("log")); // it is run again
  const pid_t second = rest.worker();
  ASSERT_GT(second, 0);
  kill(second, SIGTERM); // this one alone: somebody's verdict on the method
  EXPECT_EQ(rest.wait(), 0);
  ASSERT_EQ(rows().size(), 1U);
  EXPECT_EQ(rows().front().status, "crashed");
}

TEST_F(BenchmarkProgram, reportsAreWrittenAndWrittenAgain)
{
  ASSERT_EQ(run(small() + out() + "--methods ssfr,icp_point_to_point --perturb rotation").code, 0);
  const nlohmann::json first = reportData("out");
  EXPECT_EQ(first["rows"].size(), 4U);
  EXPECT_EQ(first["pairs"].size(), 2U);
  EXPECT_EQ(first["clouds"].size(), 2U); // both are source and target
  EXPECT_THAT(first["run"]["command"].get<std::string>(), HasSubstr("--methods ssfr,icp_point_to_point"));
  const auto ofRuns = [this] { return io::readFile(folder_.file("out/results.csv")); };
  const std::string results = ofRuns();
  const std::string settings = io::readFile(folder_.file("out/settings.json"));

  std::filesystem::remove(folder_.file("out/report.html"));
  ASSERT_EQ(run(out() + "--report-only").code, 0); // without the dataset, without its pictures
  nlohmann::json again = reportData("out");
  EXPECT_EQ(again["pairs"].size(), 0U);
  EXPECT_EQ(again["run"], first["run"]);
  EXPECT_EQ(again["groups"], first["groups"]);

  ASSERT_EQ(run(small() + out() + "--report-only --pictures 1").code, 0);
  again = reportData("out");
  EXPECT_EQ(again["pairs"].size(), 1U);
  ASSERT_EQ(run(small() + out() + "--report-only").code, 0);
  EXPECT_EQ(reportData("out"), first);
  EXPECT_EQ(ofRuns(), results);
  EXPECT_EQ(io::readFile(folder_.file("out/settings.json")), settings);
  EXPECT_EQ(run(out("nowhere") + "--report-only").code, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("nowhere")));
}

TEST_F(BenchmarkProgram, ranksOfMpiGiveTheSameResults)
{
  if (std::string(PCL_SSFR_MPIRUN).empty())
    GTEST_SKIP() << "built without MPI";
  const std::string common = small() + "--methods ssfr,icp_point_to_point --perturb rotation ";
  ASSERT_EQ(run(common + out("alone")).code, 0);
  const std::string mpirun = std::string("'") + PCL_SSFR_MPIRUN + "' --allow-run-as-root --oversubscribe -n 3 ";
  const Outcome result = shell(mpirun + command(common + out("ranks")));
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_EQ(answers("ranks").size(), 4U);
  EXPECT_EQ(answers("alone"), answers("ranks"));
  const Outcome bad = shell(mpirun + command(small() + "--methods magic " + out("bad")));
  EXPECT_NE(bad.code, 0);
  EXPECT_THAT(bad.errors, HasSubstr("'magic'"));
}

} // namespace
} // namespace pcl_ssfr::apps::test_benchmark_cli
