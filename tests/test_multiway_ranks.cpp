// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// ssfr_map as an MPI job: how pairs are dealt, what a rank does with them, and whole jobs. PCL_SSFR_MAP is the path of
// the program, PCL_SSFR_MPIRUN of mpirun or empty.

#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>
#include <apps/map/pair_tiles.h>
#include <apps/map/tile_linker.h>
#include <apps/methods/cloud_view.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

namespace pcl_ssfr::apps::test_multiway_ranks {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

std::vector<PairTask>
allPairs(int scans)
{
  std::vector<PairTask> tasks;
  for (int i = 0; i < scans; ++i)
    for (int j = i + 1; j < scans; ++j)
      tasks.push_back({i, j, 0, 0, std::nullopt});
  return tasks;
}

std::vector<std::string>
pathsOf(int scans)
{
  std::vector<std::string> paths;
  paths.reserve(static_cast<std::size_t>(scans));
  for (int i = 0; i < scans; ++i)
    paths.push_back("scan " + std::to_string(i));
  return paths;
}

TEST(PairTiles, everyPairIsDealtOnceInTilesOfFewScans)
{
  for (const int scans : {2, 9, 100})
    for (const int ranks : {1, 2, 63}) {
      const std::vector<std::string> paths = pathsOf(scans);
      PairTiles tiles(allPairs(scans), paths, ranks);
      std::set<std::pair<int, int>> dealt;
      std::size_t most = 0, count = 0;
      for (int rank = 1; !tiles.empty(); rank = rank % ranks + 1) {
        const PairTile tile = tiles.next(rank);
        most = std::max(most, tile.paths.size());
        count += 1;
        for (const PairTask& task : tile.tasks) {
          EXPECT_TRUE(dealt.emplace(task.source, task.target).second);
          EXPECT_EQ(tile.paths.at(task.source), paths[static_cast<std::size_t>(task.source)]);
          EXPECT_EQ(tile.paths.at(task.target), paths[static_cast<std::size_t>(task.target)]);
        }
      }
      EXPECT_EQ(dealt.size(), static_cast<std::size_t>(scans * (scans - 1) / 2));
      EXPECT_LE(most, static_cast<std::size_t>(2 * DealConfig().largest_side));
      EXPECT_GE(count, std::min<std::size_t>(dealt.size(), static_cast<std::size_t>(8 * ranks)));
    }
  EXPECT_TRUE(PairTiles({}, {}, 3).empty());
}

TEST(PairTiles, aRankGetsScansThatItHas)
{
  // 20 runs of 32 scans; a rank keeps four. In any order, two runs a tile would be new.
  constexpr int kScans = 640;
  const std::vector<std::string> paths = pathsOf(kScans);
  for (const int ranks : {1, 4}) {
    PairTiles tiles(allPairs(kScans), paths, ranks);
    std::map<int, std::vector<std::string>> kept; // by rank, used last at the end
    std::size_t prepared = 0;
    for (int rank = 1; !tiles.empty(); rank = rank % ranks + 1)
      for (const auto& [scan, path] : tiles.next(rank).paths) {
        std::vector<std::string>& mine = kept[rank];
        const auto found = std::find(mine.begin(), mine.end(), path);
        prepared += found == mine.end() ? 1 : 0;
        if (found != mine.end())
          mine.erase(found);
        mine.push_back(path);
        if (mine.size() > DealConfig().kept_scans)
          mine.erase(mine.begin());
      }
    EXPECT_LT(prepared, 210U * 32U) << ranks; // 210 tiles: less than one new run each
    EXPECT_GT(prepared, static_cast<std::size_t>(kScans)) << ranks;
  }
}

TEST(PairTiles, aTileGoesThroughAMessage)
{
  PairTile tile;
  tile.paths = {{3, "a\n7 b"}, {12, std::string("\0 \xff", 3)}, {40, ""}};
  tile.tasks = {{3, 12, 5, 6, std::nullopt}, {3, 40, 5, 7, PairGuess()}};
  const std::string bytes = toBytes(tile);
  const PairTile read = tileFromBytes(bytes);
  EXPECT_EQ(read.paths, tile.paths);
  ASSERT_EQ(read.tasks.size(), 2U);
  EXPECT_EQ(read.tasks[1].target_hash, 7U);
  EXPECT_TRUE(read.tasks[1].guess);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(tileFromBytes(bytes.substr(0, size)), std::runtime_error) << size;
}

/// Scans of the building in the repository.
std::string
scanFile(int scan)
{
  return std::string(PCL_SSFR_DATA_DIR) + "/building/scan_" + std::to_string(scan) + ".pcd";
}

ScanSource
load(const std::string& path)
{
  const auto points = std::make_shared<io::ScanPoints>(io::loadScanPoints(path));
  return {viewOf(*points), points};
}

/// All pairs of some scans.
PairTile
tileOf(const std::vector<int>& scans)
{
  PairTile tile;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    tile.paths[scans[i]] = scanFile(scans[i]);
    for (std::size_t j = i + 1; j < scans.size(); ++j)
      tile.tasks.push_back({scans[i],
                            scans[j],
                            hashOfScan(load(scanFile(scans[i])).view),
                            hashOfScan(load(scanFile(scans[j])).view),
                            std::nullopt});
  }
  return tile;
}

/// A linker that counts what it reads and keeps three scans.
class Linker : public ::testing::Test {
protected:
  static MultiwayOptions
  twoThreads()
  {
    MultiwayOptions options;
    options.threads = 2;
    return options;
  }
  static DealConfig
  keepsThree()
  {
    DealConfig config;
    config.kept_scans = 3;
    return config;
  }
  std::string
  problemOf(const PairTile& tile)
  {
    try {
      linker_.link(tile, on_link_, stop_);
    }
    catch (const io::IoError& error) {
      return error.what();
    }
    return "";
  }

  std::atomic<int> loads_{0};
  std::atomic<bool> stop_{false};
  std::vector<PairLink> links_;
  OnLink on_link_ = [this](const PairLink& link) { links_.push_back(link); };
  TileLinker linker_{twoThreads(),
                     [this](const std::string& path) {
                       ++loads_;
                       return load(path);
                     },
                     keepsThree()};
};

TEST_F(Linker, preparesWhatItHasNotAndKeepsNoMoreThanItMay)
{
  linker_.link(tileOf({0, 1}), on_link_, stop_);
  EXPECT_EQ(loads_, 2);
  linker_.link(tileOf({1, 2}), on_link_, stop_);
  EXPECT_EQ(loads_, 3);
  EXPECT_EQ(linker_.kept(), 3U);
  linker_.link(tileOf({0, 3}), on_link_, stop_); // 1 and 2 were used after 0; one of them makes room
  EXPECT_EQ(loads_, 4);
  EXPECT_EQ(linker_.kept(), 3U);
  linker_.link(tileOf({0, 3, 4, 5}), on_link_, stop_); // more than it keeps
  EXPECT_EQ(loads_, 6);
  EXPECT_EQ(linker_.kept(), 4U);
  EXPECT_EQ(links_.size(), 9U);
  // As by anybody else.
  MultiwayOptions options;
  const PairLink expected = linkPair(tileOf({0, 1}).tasks[0],
                                     prepareScan(load(scanFile(0)).view, options.registration),
                                     prepareScan(load(scanFile(1)).view, options.registration),
                                     options);
  EXPECT_EQ(links_[0].target, 1);
  EXPECT_EQ(links_[0].confidence, expected.confidence);
  ASSERT_EQ(links_[0].hypotheses.size(), expected.hypotheses.size());
  ASSERT_FALSE(expected.hypotheses.empty());
  EXPECT_TRUE(links_[0].hypotheses[0].information == expected.hypotheses[0].information);
}

TEST_F(Linker, saysWhatIsWrongWithAScan)
{
  PairTile tile = tileOf({0, 1});
  tile.tasks[0].target_hash += 1;
  EXPECT_THAT(problemOf(tile), HasSubstr("scan_1.pcd: holds other points here"));
  tile = tileOf({0, 1});
  tile.paths[1] = "/nowhere/scan.pcd";
  std::string same;
  try {
    load("/nowhere/scan.pcd");
  }
  catch (const io::IoError& error) {
    same = error.what();
  }
  EXPECT_EQ(problemOf(tile), same);
  EXPECT_TRUE(links_.empty());
  EXPECT_EQ(problemOf(tileOf({0, 1})), "");
  EXPECT_EQ(links_.size(), 1U);
}

TEST_F(Linker, stopsWhenItIsAsked)
{
  stop_ = true;
  linker_.link(tileOf({0, 1}), on_link_, stop_);
  EXPECT_EQ(loads_, 0);
  stop_ = false;
  linker_.link(
      tileOf({0, 1, 2, 3}), [&](const PairLink&) { stop_ = true; }, stop_);
  stop_ = false;
  linker_.link(tileOf({0, 1, 2, 3}), on_link_, stop_);
  EXPECT_EQ(loads_, 4);
  EXPECT_EQ(links_.size(), 6U);
}

/// What a run of the program left.
struct Outcome {
  int code = -1;
  std::string err;
};

/// Jobs on five scans of the building in the repository.
class Job : public ::testing::Test {
protected:
  void
  SetUp() override
  {
    if (std::string(PCL_SSFR_MPIRUN).empty())
      GTEST_SKIP() << "built without MPI, or there is no mpirun";
    std::filesystem::create_directories(folder_.file("building"));
    for (int i = 0; i < 5; ++i)
      std::filesystem::copy(scanFile(i), folder_.file("building"));
    std::istringstream all(io::readFile(std::string(PCL_SSFR_DATA_DIR) + "/building/poses.txt"));
    std::ofstream poses(folder_.file("building/poses.txt"));
    for (std::string line; std::getline(all, line);)
      if (line.front() == '#' || std::filesystem::exists(folder_.file("building/" + line.substr(0, line.find(' ')))))
        poses << line << '\n';
  }
  static std::string
  mpirun(int ranks, const std::string& options = "")
  {
    return std::string("'") + PCL_SSFR_MPIRUN + "' --allow-run-as-root --oversubscribe " + options + "-n " +
           std::to_string(ranks) + " ";
  }
  /// The same of a job that fails: it does not wait a second for ranks that have nothing more to say.
  static std::string
  failing(int ranks)
  {
    return mpirun(ranks, "--mca odls_base_sigkill_timeout 0 ");
  }
  static std::string
  program()
  {
    return std::string("'") + PCL_SSFR_MAP + "' ";
  }
  std::string
  arguments(const std::string& out) const
  {
    const std::string scans = folder_.file("building");
    return "'" + scans + "' --truth '" + scans + "/poses.txt' --tum --merged '" + folder_.file(out + ".ply") +
           "' --merged-leaf 0.2 --out '" + folder_.file(out) + "' ";
  }
  Outcome
  shell(const std::string& command) const
  {
    const std::string err = folder_.file("stderr");
    const int status = std::system((command + " >/dev/null 2>'" + err + "'").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, io::readFile(err)};
  }
  /// All that is written of a map but times, memory and the command line.
  std::string
  mapIn(const std::string& out) const
  {
    const auto withoutTimes = [](nlohmann::ordered_json json) {
      for (const char* name : {"command", "time_s"})
        json.erase(name);
      json["memory"].erase("peak_rss_mib");
      for (auto& stage : json["stages"])
        stage.erase("seconds");
      return json;
    };
    const std::string dir = folder_.file(out);
    std::string text = io::readFile(dir + ".ply");
    for (const char* name : {"/poses.csv", "/links.csv", "/poses.tum"})
      text += io::readFile(dir + name);
    text += withoutTimes(nlohmann::ordered_json::parse(io::readFile(dir + "/map.json"))).dump();
    const std::string page = io::readFile(dir + "/report.html");
    const std::size_t begin = page.find('>', page.find("<script id=\"data\"")) + 1;
    const std::size_t end = page.find("</script>", begin);
    nlohmann::ordered_json data = nlohmann::ordered_json::parse(page.substr(begin, end - begin));
    data["summary"] = withoutTimes(data["summary"]);
    return text + page.substr(0, begin) + data.dump() + page.substr(end);
  }
  /// Start a job, and end one of its ranks without a warning once some pairs are linked. \return the code of mpirun
  int
  killWhileLinking(int ranks, int victim, const std::string& out) const
  {
    const std::string log = folder_.file("log");
    std::filesystem::remove(log);
    const pid_t child = fork();
    if (child == 0) {
      const std::string command =
          "exec " + mpirun(ranks) + program() + arguments(out) + "--threads 1 >'" + log + "' 2>&1";
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
    const auto began = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - began < std::chrono::minutes(2)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      if (std::filesystem::exists(log) && io::readFile(log).find(": link ") != std::string::npos)
        break;
    }
    const pid_t process = processOf(victim, folder_.file(out));
    EXPECT_GT(process, 0) << io::readFile(log);
    if (process > 0)
      kill(process, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  TemporaryFolder folder_;

private:
  /// The process of a rank of the job that writes \p out; 0: there is none.
  static pid_t
  processOf(int rank, const std::string& out)
  {
    const auto contentOf = [](const std::filesystem::path& path) {
      std::ifstream in(path, std::ios::binary);
      return '\0' + std::string(std::istreambuf_iterator<char>(in), {});
    };
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      const std::string command = contentOf(entry.path() / "cmdline"), variables = contentOf(entry.path() / "environ");
      if (command.rfind('\0' + std::string(PCL_SSFR_MAP), 0) != 0 || command.find(out) == std::string::npos)
        continue;
      for (const char* name : {"OMPI_COMM_WORLD_RANK=", "PMI_RANK="})
        if (variables.find('\0' + (name + std::to_string(rank)) + '\0') != std::string::npos)
          return std::stoi(entry.path().filename());
    }
    return 0;
  }
};

TEST_F(Job, givesTheSameFilesForAnyNumberOfRanksAndThreads)
{
  ASSERT_EQ(shell(program() + arguments("alone") + "--threads 1").code, 0);
  const std::string expected = mapIn("alone");
  const std::vector<std::pair<int, std::string>> jobs = {{1, ""}, {2, "--threads 3"}, {3, ""}, {4, "--threads 2"}};
  for (const auto& [ranks, threads] : jobs) {
    const std::string out = "ranks" + std::to_string(ranks);
    const Outcome result = shell(mpirun(ranks) + program() + arguments(out) + threads);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("link 10 of 10"));
    EXPECT_TRUE(mapIn(out) == expected) << ranks;
  }
  // All links are in the project: whoever goes on, alone or not, links nothing again.
  for (const std::string& start : {std::string(), mpirun(2)}) {
    const Outcome again = shell(start + program() + arguments("ranks3") + "--resume");
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_THAT(again.err, Not(HasSubstr("link 10 of 10")));
    EXPECT_TRUE(mapIn("ranks3") == expected);
  }
}

TEST_F(Job, roundsOfCandidatesGiveTheSameFiles)
{
  std::string more; // what shares nothing with the building, so that one round is not all; of few points, to be quick
  for (const std::string name : {"apartment_0", "apartment_1", "hall_0", "hall_1"}) {
    const io::ScanPoints points = io::loadScanPoints(std::string(PCL_SSFR_DATA_DIR) + "/" + name + ".pcd");
    const std::string file = folder_.file(name + ".xyz");
    std::ofstream out(file);
    const ScanView view = viewOf(points);
    for (std::size_t i = 0; i < view.size; i += view.size / 400)
      out << view.point(i).transpose() << '\n';
    more += "'" + file + "' ";
  }
  const auto job = [&](const std::string& out) { return program() + more + arguments(out) + "--pairs candidates "; };
  const Outcome alone = shell(job("alone"));
  ASSERT_EQ(alone.code, 1) << alone.err; // there are more places than one
  const Outcome ranks = shell(mpirun(3) + job("ranks"));
  ASSERT_EQ(ranks.code, 1) << ranks.err;
  EXPECT_TRUE(mapIn("ranks") == mapIn("alone"));
  // The ranks were given pairs more than once, and the end of each round is shown.
  std::size_t rounds = 0;
  for (std::size_t line = ranks.err.find("ssfr_map: link "); line != std::string::npos;
       line = ranks.err.find("ssfr_map: link ", line + 1)) {
    std::size_t done = 0, total = 1;
    ASSERT_EQ(std::sscanf(ranks.err.c_str() + line, "ssfr_map: link %zu of %zu", &done, &total), 2);
    rounds += done == total ? 1 : 0;
  }
  EXPECT_GE(rounds, 2U) << ranks.err;
}

TEST_F(Job, whatWasKilledGoesOnToTheSameMap)
{
  ASSERT_EQ(shell(program() + arguments("alone")).code, 0);
  const std::string expected = mapIn("alone");
  for (const int victim : {0, 1}) {
    const std::string out = "victim" + std::to_string(victim);
    EXPECT_NE(killWhileLinking(2, victim, out), 0);
    if (victim > 0) {
      EXPECT_THAT(io::readFile(folder_.file("log")), HasSubstr("ssfr_map: the job was ended; --resume goes on"));
    }
    EXPECT_FALSE(std::filesystem::exists(folder_.file(out) + "/poses.csv"));
    const Outcome resumed = shell(mpirun(3) + program() + arguments(out) + "--resume");
    ASSERT_EQ(resumed.code, 0) << resumed.err;
    EXPECT_TRUE(mapIn(out) == expected) << victim;
  }
}

TEST_F(Job, whatIsWrongIsSaidOnce)
{
  const auto times = [](const std::string& text, const std::string& what) {
    int count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++count;
    return count;
  };
  const Outcome usage = shell(failing(3) + program() + "--magic");
  EXPECT_EQ(usage.code, 2);
  EXPECT_EQ(times(usage.err, "--magic"), 1) << usage.err;
  const std::string good = program() + arguments("out");
  const Outcome odd = shell(failing(1) + good + " : -n 1 " + program() + "--magic"); // one rank only has it
  EXPECT_EQ(odd.code, 3);
  EXPECT_EQ(times(odd.err, "--magic"), 1) << odd.err;
  EXPECT_THAT(odd.err, HasSubstr("ssfr_map: rank 1 on "));
  const Outcome nothing = shell(failing(3) + program() + "/nowhere --out '" + folder_.file("out") + "'");
  EXPECT_EQ(nothing.code, 3);
  EXPECT_EQ(times(nothing.err, "ssfr_map: /nowhere: "), 1) << nothing.err;

  // Another rank sees another folder: a scan is missing there, or is another one.
  for (const char* view : {"here", "there"}) {
    std::filesystem::create_directories(folder_.file(view) + "/scans");
    for (int i = 0; i < 3; ++i)
      std::filesystem::copy(scanFile(i), folder_.file(view) + "/scans");
  }
  const std::string call = program() + "scans --out '" + folder_.file("out") + "' --resume ";
  const std::string start = failing(1) + "-wdir '" + folder_.file("here") + "' " + call + " : -n 2 -wdir '" +
                            folder_.file("there") + "' " + call;
  const std::string scan = folder_.file("there") + "/scans/scan_2.pcd";
  std::filesystem::remove(scan);
  const Outcome missing = shell(start);
  EXPECT_EQ(missing.code, 3);
  EXPECT_EQ(times(missing.err, "ssfr_map: rank "), 1) << missing.err;
  EXPECT_THAT(missing.err, HasSubstr(": scans/scan_2.pcd: no such file\n"));
  std::filesystem::copy(scanFile(5), scan);
  const Outcome other = shell(start);
  EXPECT_EQ(other.code, 3);
  EXPECT_THAT(other.err, HasSubstr(": scans/scan_2.pcd: holds other points here than where the map is made"));
  std::filesystem::copy(scanFile(2), scan, std::filesystem::copy_options::overwrite_existing);
  const Outcome mended = shell(start);
  EXPECT_LE(mended.code, 1) << mended.err;
  EXPECT_TRUE(std::filesystem::exists(folder_.file("out") + "/poses.csv"));
}

} // namespace
} // namespace pcl_ssfr::apps::test_multiway_ranks
