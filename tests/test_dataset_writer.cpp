// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Dataset folders: what is in them, and that they are there completely or not at all.

#include <apps/io/dataset_folder.h>
#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/text_scanner.h>
#include <apps/simulation/dataset_writer.h>
#include <apps/simulation/progress.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <sstream>
#include <thread>

namespace pcl_ssfr::simulation::test_dataset_writer {
namespace {

namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using testing::TemporaryFolder;

Eigen::Isometry3d
makePose(double angle, const Eigen::Vector3d& translation)
{
  return Eigen::Translation3d(translation) * Eigen::AngleAxisd(angle, Eigen::Vector3d(0.2, -0.3, 1).normalized());
}

std::vector<std::string>
entriesOf(const fs::path& folder)
{
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Two scans of \p count points, their poses and their pair.
void
fill(DatasetWriter& writer, std::size_t count = 3)
{
  for (const char* name : {"scan000.pcd", "scan001.pcd"})
    writer.writeScan(name,
                     std::vector<Eigen::Vector3f>(count, Eigen::Vector3f(1.5F, -2.25F, 1e-3F)),
                     std::vector<float>(count, 0.5F));
  const std::vector<Eigen::Isometry3d> poses = {makePose(0.1, {1, 2, 3}), makePose(2.5, {-7.1, 0.3, 1e-7})};
  writer.writeTruth({"scan000.pcd", "scan001.pcd"}, poses, {{1, 0, poses[0].inverse() * poses[1], 0.625}});
  writer.writeDescription(R"({"name": "two", "sensor": "made up", "viewpoint": "sensor"})");
}

template <typename Action>
std::string
errorOf(Action action)
{
  try {
    action();
  }
  catch (const io::IoError& error) {
    return error.what();
  }
  return "no error";
}

TEST(DatasetWriter, writesWhatTheReaderReads)
{
  const TemporaryFolder folder;
  const std::string out = folder.file("a/b/two/");
  {
    DatasetWriter writer(out, false);
    fill(writer);
    EXPECT_FALSE(fs::exists(out));
    writer.commit();
    EXPECT_GT(writer.bytesWritten(), 2U * 3 * 16);
  }
  EXPECT_THAT(entriesOf(folder.file("a/b")), ElementsAre("two"));
  EXPECT_THAT(entriesOf(out), ElementsAre("dataset.json", "pairs.csv", "poses.txt", "scans"));
  const io::DatasetFolder read = io::readDatasetFolder(out);
  EXPECT_EQ(read.name, "two");
  ASSERT_EQ(read.pairs.size(), 1U);
  EXPECT_EQ(read.pairs[0].source, "scan001.pcd");
  EXPECT_EQ(read.pairs[0].target, "scan000.pcd");
  const auto cloud = io::loadCloud(io::scanPath(out, "scan001.pcd"));
  ASSERT_EQ(cloud.points->size(), 3U);
  EXPECT_TRUE(cloud.has_intensity);
  EXPECT_FALSE(cloud.viewpoint);
  EXPECT_EQ(cloud.points->back().getVector3fMap(), Eigen::Vector3f(1.5F, -2.25F, 1e-3F));
  EXPECT_EQ(cloud.points->back().intensity, 0.5F);
}

TEST(DatasetWriter, numbersReadBackToTheSameBits)
{
  const TemporaryFolder folder;
  DatasetWriter writer(folder.file("set"), false);
  fill(writer);
  writer.commit();
  const Eigen::Isometry3d target = makePose(0.1, {1, 2, 3});
  const Eigen::Isometry3d source = makePose(2.5, {-7.1, 0.3, 1e-7});
  const Eigen::Matrix4d truth = (target.inverse() * source).matrix();

  std::istringstream pairs(io::readFile(folder.file("set/pairs.csv")));
  std::string line;
  std::getline(pairs, line);
  EXPECT_THAT(line, StartsWith("source,target,T00,T01,T02,T03,T10,"));
  EXPECT_THAT(line, HasSubstr(",T33,overlap,rotation_deg,translation_m"));
  std::getline(pairs, line);
  const auto columns = io::splitTokens(line);
  ASSERT_EQ(columns.size(), 21U);
  for (std::size_t i = 0; i < 16; ++i)
    EXPECT_EQ(io::parseNumber(columns[i + 2]), truth(static_cast<int>(i / 4), static_cast<int>(i % 4))) << i;
  EXPECT_EQ(io::parseNumber(columns[18]), 0.625);
  EXPECT_NEAR(*io::parseNumber(columns[19]), 2.4 * 57.29577951308232, 1e-3);
  EXPECT_NEAR(*io::parseNumber(columns[20]), (source.translation() - target.translation()).norm(), 1e-4);

  std::istringstream poses(io::readFile(folder.file("set/poses.txt")));
  std::getline(poses, line);
  EXPECT_THAT(line, StartsWith("#"));
  for (const Eigen::Isometry3d& pose : {target, source}) {
    std::getline(poses, line);
    const auto values = io::splitTokens(line);
    ASSERT_EQ(values.size(), 8U);
    const auto number = [&](std::size_t i) { return *io::parseNumber(values[i]); };
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(number(1 + k), pose.translation()[static_cast<int>(k)]);
    const Eigen::Quaterniond q(number(7), number(4), number(5), number(6));
    EXPECT_LT((q.toRotationMatrix() - pose.linear()).norm(), 1e-14);
    EXPECT_GE(q.w(), 0);
  }
}

TEST(DatasetWriter, longScansKeepEveryPointInOrder)
{
  const TemporaryFolder folder;
  constexpr std::size_t kCount = 200001; // more than a block of the stream
  std::vector<Eigen::Vector3f> points;
  std::vector<float> intensity;
  for (std::size_t i = 0; i < kCount; ++i) {
    points.emplace_back(static_cast<float>(i) / 32, -1.0F, 0.25F);
    intensity.push_back(static_cast<float>(i % 100) / 100);
  }
  DatasetWriter writer(folder.file("set"), false);
  writer.writeScan("scan000.pcd", points, intensity);
  writer.commit();
  const auto cloud = io::loadCloud(folder.file("set/scans/scan000.pcd"));
  ASSERT_EQ(cloud.points->size(), kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ((*cloud.points)[i].getVector3fMap(), points[i]) << i;
    ASSERT_EQ((*cloud.points)[i].intensity, intensity[i]) << i;
  }
}

TEST(DatasetWriter, anEmptyScanIsAScan)
{
  const TemporaryFolder folder;
  DatasetWriter writer(folder.file("set"), false);
  writer.writeScan("scan000.pcd", {}, {});
  writer.commit();
  EXPECT_EQ(io::loadCloud(folder.file("set/scans/scan000.pcd")).points->size(), 0U);
}

TEST(DatasetWriter, withoutCommitNothingIsLeft)
{
  const TemporaryFolder folder;
  {
    DatasetWriter writer(folder.file("a/b/set"), false);
    fill(writer);
    EXPECT_THAT(entriesOf(folder.file("a/b")), ElementsAre(StartsWith("set.partial-")));
  }
  EXPECT_THAT(entriesOf(folder.file("")), IsEmpty());
}

TEST(DatasetWriter, whatExistsIsKept)
{
  const TemporaryFolder folder;
  const auto error_for = [&](const std::string& name, bool overwrite) {
    return errorOf([&] { DatasetWriter(folder.file(name), overwrite); });
  };
  io::writeFile(folder.file("file"), "mine");
  EXPECT_THAT(error_for("file", true), AllOf(HasSubstr("file"), HasSubstr("not a folder")));
  EXPECT_THAT(error_for("file/below", false), HasSubstr("file/below"));
  fs::create_directories(folder.file("empty"));
  EXPECT_EQ(error_for("empty", false), "no error");
  // A folder that is no dataset, with whatever --overwrite.
  fs::create_directories(folder.file("home"));
  io::writeFile(folder.file("home/letter.txt"), "dear");
  EXPECT_THAT(error_for("home", false), HasSubstr("not empty"));
  EXPECT_THAT(error_for("home", true), HasSubstr("letter.txt"));
  EXPECT_EQ(io::readFile(folder.file("home/letter.txt")), "dear");
  // A dataset with a file of the user's in it.
  {
    DatasetWriter writer(folder.file("set"), false);
    fill(writer);
    writer.commit();
  }
  EXPECT_THAT(error_for("set", false), HasSubstr("--overwrite"));
  io::writeFile(folder.file("set/scans/notes.txt"), "mine");
  EXPECT_THAT(error_for("set", true), HasSubstr("notes.txt"));
  fs::remove(folder.file("set/scans/notes.txt"));
  fs::create_directory_symlink(folder.file("home"), folder.file("set/link"));
  EXPECT_THAT(error_for("set", true), HasSubstr("link"));
  EXPECT_THAT(errorOf([] { DatasetWriter("", false); }), HasSubstr("''"));
  EXPECT_THAT(entriesOf(folder.file("")), ElementsAre("empty", "file", "home", "set"));
}

TEST(DatasetWriter, overwritingReplacesAtTheEnd)
{
  const TemporaryFolder folder;
  const auto write = [&](std::size_t count, bool commit) {
    DatasetWriter writer(folder.file("set"), true);
    fill(writer, count);
    if (commit)
      writer.commit();
  };
  const auto count = [&] { return io::loadCloud(folder.file("set/scans/scan000.pcd")).points->size(); };
  write(3, true);
  write(5, false);
  EXPECT_EQ(count(), 3U);
  io::writeFile(folder.file("set/scans/scan002.pcd"), "of a longer set");
  write(7, true);
  EXPECT_EQ(count(), 7U);
  EXPECT_THAT(entriesOf(folder.file("set/scans")), ElementsAre("scan000.pcd", "scan001.pcd"));
  EXPECT_THAT(entriesOf(folder.file("")), ElementsAre("set"));
}

TEST(DatasetWriter, aFolderThatAppearsMeanwhileIsNotReplaced)
{
  const TemporaryFolder folder;
  {
    DatasetWriter writer(folder.file("set"), false);
    fill(writer);
    fs::create_directories(folder.file("set"));
    io::writeFile(folder.file("set/other"), "of another process");
    EXPECT_THAT(errorOf([&] { writer.commit(); }), HasSubstr("not empty"));
  }
  EXPECT_THAT(entriesOf(folder.file("")), ElementsAre("set"));
  EXPECT_EQ(io::readFile(folder.file("set/other")), "of another process");
}

TEST(DatasetWriter, linksAreFollowed)
{
  const TemporaryFolder folder;
  fs::create_directories(folder.file("disk/empty"));
  fs::create_directory_symlink(folder.file("disk/empty"), folder.file("link"));
  {
    DatasetWriter writer(folder.file("link"), false);
    fill(writer);
    writer.commit();
  }
  EXPECT_TRUE(fs::is_symlink(folder.file("link")));
  EXPECT_TRUE(fs::exists(folder.file("disk/empty/pairs.csv")));
}

TEST(DatasetWriter, aFullDiskIsAnErrorAndLeavesNothing)
{
  const TemporaryFolder folder;
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{10000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string error = errorOf([&] {
    DatasetWriter writer(folder.file("set"), false);
    fill(writer, 3);
    fill(writer, 1000);
  });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(error, AllOf(HasSubstr("set/scans/scan000.pcd"), HasSubstr("cannot be written")));
  EXPECT_THAT(entriesOf(folder.file("")), IsEmpty());
}

/// A process that writes into \p out until a signal ends it; returns how it ended.
int
statusAfter(int number, const std::string& out)
{
  int ready[2] = {};
  EXPECT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    std::signal(number, SIG_DFL);
    DatasetWriter writer(out, false);
    fill(writer);
    if (write(ready[1], "x", 1) != 1)
      _exit(1);
    for (int i = 0; i < 1000; ++i) {
      fill(writer, 1000);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    _exit(0);
  }
  char byte = 0;
  EXPECT_EQ(read(ready[0], &byte, 1), 1);
  kill(child, number);
  int status = 0;
  waitpid(child, &status, 0);
  close(ready[0]);
  close(ready[1]);
  return status;
}

TEST(DatasetWriter, aSignalLeavesNothing)
{
  const TemporaryFolder folder;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const int status = statusAfter(number, folder.file("a/set"));
    EXPECT_TRUE(WIFSIGNALED(status)) << number;
    EXPECT_EQ(WTERMSIG(status), number);
    EXPECT_THAT(entriesOf(folder.file("")), IsEmpty()) << number;
  }
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(Progress, isHonestAboutShareAndTime)
{
  EXPECT_EQ(formatProgress(0, 4, 0, 0), "[..............................] scan 1 of 4, 0 %");
  EXPECT_EQ(formatProgress(1, 4, 0, 30), "[#######.......................] scan 2 of 4, 25 %, 90 s left");
  EXPECT_EQ(formatProgress(3, 4, 1, 30), "[##############################] scan 4 of 4, 100 %");
}

TEST(Progress, silentIsSilentAndABarIsRemoved)
{
  std::ostringstream silent;
  Progress none(silent, Progress::Style::Silent);
  std::ostringstream terminal;
  Progress bar(terminal, Progress::Style::Bar);
  std::ostringstream file;
  Progress lines(file, Progress::Style::Lines);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  for (Progress* progress : {&none, &bar, &lines}) {
    progress->update(0, 2, 0.5);
    progress->update(0, 2, 0.6); // too soon to be shown
    progress->finish();
  }
  EXPECT_EQ(silent.str(), "");
  EXPECT_EQ(file.str(), ""); // no line before some seconds
  EXPECT_THAT(terminal.str(), AllOf(StartsWith("\r[###"), HasSubstr("25 %"), ::testing::Not(HasSubstr("30 %"))));
  EXPECT_THAT(terminal.str(), ::testing::EndsWith(" \r"));
}

} // namespace
} // namespace pcl_ssfr::simulation::test_dataset_writer
