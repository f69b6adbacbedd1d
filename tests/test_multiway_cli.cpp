// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// ssfr_map as its users run it: exit codes, messages, files, resuming. PCL_SSFR_MAP is the path of the program.

#include <apps/io/csv_line.h>
#include <apps/io/e57_format.h>
#include <apps/io/e57_writer.h>
#include <apps/io/file_bytes.h>
#include <apps/io/loaded_cloud.h>
#include <apps/io/pcd_format.h>
#include <apps/map/control_points.h>
#include <apps/map/folder_lock.h>
#include <apps/map/map_clouds.h>
#include <apps/map/map_files.h>
#include <apps/map/map_inputs.h>
#include <apps/map/map_options.h>
#include <apps/map/map_truth.h>
#include <apps/map/merged_cloud.h>
#include <apps/map/pose_list.h>

#include <io_testing.h>
#include <synthetic_scene.h>

#include <pcl/io/pcd_io.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

namespace pcl_ssfr::test_multiway_cli {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using testing::TemporaryFolder;

/// What a run of the program left.
struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Four scans of a room in a folder, with their poses, made once.
class MapProgram : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    folder_ = std::make_unique<TemporaryFolder>();
    std::filesystem::create_directories(folder_->file("scans"));
    const testing::Scene scene = testing::makeFurnishedRoom(3);
    testing::Random random(11);
    std::ofstream poses(folder_->file("poses.txt"));
    for (int i = 0; i < 4; ++i) {
      const Eigen::Matrix3d R = testing::randomRotation(random);
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation() = scene.stations[static_cast<std::size_t>(i) % scene.stations.size()] +
                        0.2 * (i / static_cast<int>(scene.stations.size())) * Eigen::Vector3d::UnitX();
      const Eigen::Matrix3Xf points =
          R.cast<float>().transpose() * testing::castScan(scene, T, testing::roomScanner(0.025), 20 + i);
      T.linear() = R;
      pcl::PointCloud<pcl::PointXYZ> cloud;
      for (Eigen::Index k = 0; k < points.cols(); ++k)
        cloud.push_back(pcl::PointXYZ(points(0, k), points(1, k), points(2, k)));
      const std::string name = i == 2 ? "a, b.pcd" : "s" + std::to_string(i) + ".pcd";
      pcl::io::savePCDFileBinary(folder_->file("scans/" + name), cloud);
      const Eigen::Quaterniond q(T.linear());
      if (i != 2)
        poses << name << " " << T.translation().transpose() << " " << q.x() << " " << q.y() << " " << q.z() << " "
              << q.w() << "\n";
    }
  }
  static void
  TearDownTestSuite()
  {
    folder_.reset();
  }

  static std::string
  scans()
  {
    return folder_->file("scans");
  }
  Outcome
  run(const std::string& arguments) const
  {
    const std::string out = out_.file("stdout"), err = out_.file("stderr");
    const int status = std::system((PCL_SSFR_MAP " " + arguments + " >'" + out + "' 2>'" + err + "'").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, io::readFile(out), io::readFile(err)};
  }
  std::string
  out(const std::string& name = "map") const
  {
    return out_.file(name);
  }
  static std::vector<std::vector<std::string>>
  table(const std::string& path)
  {
    std::istringstream text(io::readFile(path));
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(text, line);)
      rows.push_back(io::splitCsvLine(line));
    return rows;
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
  TemporaryFolder out_;
};

TEST_F(MapProgram, placesAFolderAndWritesEverything)
{
  const Outcome result =
      run("'" + scans() + "' --out '" + out() + "' --truth '" + folder_->file("poses.txt") + "' --merged '" +
          out("all.ply") + "' --merged-leaf 0.1 --tum --json '" + out("copy.json") + "'");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto poses = table(out() + "/poses.csv");
  ASSERT_EQ(poses.size(), 5U);
  EXPECT_THAT(poses[0],
              ElementsAre("scan",
                          "component",
                          "T00",
                          "T01",
                          "T02",
                          "T03",
                          "T10",
                          "T11",
                          "T12",
                          "T13",
                          "T20",
                          "T21",
                          "T22",
                          "T23",
                          "T30",
                          "T31",
                          "T32",
                          "T33",
                          "sigma_rotation_deg",
                          "sigma_translation_m",
                          "links",
                          "reason"));
  EXPECT_EQ(poses[1][0], "a, b.pcd");
  for (std::size_t i = 1; i < poses.size(); ++i) {
    ASSERT_EQ(poses[i].size(), poses[0].size());
    EXPECT_EQ(poses[i][1], "0");
  }
  const auto links = table(out() + "/links.csv");
  ASSERT_EQ(links.size(), 7U);
  const std::vector<std::string> first(links[0].begin(), links[0].begin() + 13);
  EXPECT_THAT(first,
              ElementsAre("source",
                          "target",
                          "status",
                          "confidence",
                          "overlap",
                          "rmse_m",
                          "strength_x",
                          "strength_y",
                          "strength_z",
                          "below_6mm",
                          "residual_rotation_deg",
                          "residual_translation_m",
                          "reason"));
  for (const auto& row : links)
    EXPECT_EQ(row.size(), 29U);
  const auto json = nlohmann::json::parse(io::readFile(out() + "/map.json"));
  EXPECT_EQ(json["components"], 1);
  EXPECT_EQ(json["placed"], 4);
  EXPECT_EQ(json["truth"]["wrong"], 0);
  EXPECT_LT(json["truth"]["largest_translation_m"], 0.02);
  EXPECT_EQ(io::readFile(out("copy.json")), io::readFile(out() + "/map.json"));
  const std::string page = io::readFile(out() + "/report.html");
  EXPECT_THAT(page, HasSubstr("<svg id=\"plan\">"));
  EXPECT_THAT(page, HasSubstr("a, b.pcd"));
  EXPECT_EQ(page.find("http"), page.find("http://www.w3.org/2000/svg")); // a name space, no address of anything else
  EXPECT_EQ(page.find("/*DATA*/"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(out() + "/map.sqlite"));
  EXPECT_TRUE(std::filesystem::exists(out() + "/poses.tum"));
  const io::LoadedCloud merged = io::loadCloud(out("all.ply"));
  EXPECT_GT(merged.points->size(), 1000U);
  EXPECT_THAT(result.out, StartsWith("4 scans, 4 placed")) << "--json FILE is one more file";
  // What was written is read as approximate poses.
  const Outcome again = run("'" + scans() + "' --out '" + out("second") + "' --poses '" + out() +
                            "/poses.csv' --pose-tolerance 5,0.5 --json -");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["components"], 1);
}

TEST_F(MapProgram, whatWasKilledGoesOnToTheSameMap)
{
  ASSERT_EQ(run("'" + scans() + "' --out '" + out("whole") + "' --threads 1").code, 0);
  const pid_t child = fork();
  if (child == 0) {
    if (!std::freopen(out("log").c_str(), "w", stdout) || !std::freopen(out("log").c_str(), "a", stderr))
      _exit(126);
    execl(PCL_SSFR_MAP, "ssfr_map", scans().c_str(), "--out", out("killed").c_str(), "--threads", "1", nullptr);
    _exit(127);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  const Outcome resumed = run("'" + scans() + "' --out '" + out("killed") + "' --threads 2 --resume");
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(io::readFile(out("killed") + "/poses.csv"), io::readFile(out("whole") + "/poses.csv"));
  EXPECT_EQ(io::readFile(out("killed") + "/links.csv"), io::readFile(out("whole") + "/links.csv"));
}

TEST_F(MapProgram, severalComponentsAreCodeOneAndMendedByHand)
{
  std::string reject;
  for (const char* other : {"s0", "s1.pcd", "'a, b'"})
    reject += std::string(" --reject s3,") + other;
  // A name with a comma cannot be given in A,B.
  const Outcome bad = run("'" + scans() + "' --out '" + out() + "'" + reject);
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, HasSubstr("--reject"));
  std::filesystem::create_directories(out("in"));
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"})
    std::filesystem::copy(scans() + "/" + name, out("in"));
  const Outcome apart = run("'" + out("in") + "' --out '" + out() +
                            "' --reject s3,s0 --reject s3.pcd,s1.pcd --merged '" + out("all.pcd") + "'");
  EXPECT_EQ(apart.code, 1) << apart.err;
  EXPECT_THAT(apart.out, HasSubstr("not in the clouds, as they have no place in the largest component: s3.pcd\n"));
  const auto poses = table(out() + "/poses.csv");
  EXPECT_EQ(poses[3][1], "1");
  EXPECT_THAT(poses[3].back(), HasSubstr("rejected by a person"));
  const Outcome mended = run("'" + out("in") + "' --out '" + out() + "' --resume --accept s3,s0 --pin s1");
  EXPECT_EQ(mended.code, 0) << mended.err;
  EXPECT_EQ(table(out() + "/poses.csv")[2][2], "1"); // T00 of s1
  const Outcome both = run("'" + out("in") + "' --out '" + out() + "' --accept s3,s0 --reject s3,s0");
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.err, HasSubstr("the link s0.pcd, s3.pcd is both accepted and rejected"));
}

TEST_F(MapProgram, whatSpeaksAgainstAnAcceptedLinkIsSaid)
{
  std::filesystem::create_directories(out("in"));
  std::filesystem::copy(scans() + "/s0.pcd", out("in"));
  std::filesystem::copy(scans() + "/s1.pcd", out("in"));
  const testing::Scene scene = testing::makeFurnishedRoom(8); // another room
  const Eigen::Isometry3d T(Eigen::Translation3d(scene.stations.front()));
  const Eigen::Matrix3Xf points = testing::castScan(scene, T, testing::roomScanner(0.025), 5);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (Eigen::Index k = 0; k < points.cols(); ++k)
    cloud.push_back(pcl::PointXYZ(points(0, k), points(1, k), points(2, k)));
  pcl::io::savePCDFileBinary(out("in") + "/other.pcd", cloud);
  const std::string words = "'" + out("in") + "' --out '" + out() + "' --json - --accept ";
  const auto json = nlohmann::json::parse(run(words + "s0,other").out);
  const auto poses = table(out() + "/poses.csv");
  std::map<std::string, std::string> component; // of each scan
  for (const auto& row : poses)
    component[row[0]] = row[1];
  EXPECT_EQ(component.at("other.pcd"), component.at("s0.pcd"));
  EXPECT_NE(component.at("s1.pcd"), component.at("s0.pcd")); // it sees what cannot be where the person put the other
  ASSERT_FALSE(json["notes"].empty());
  EXPECT_THAT(std::string(json["notes"][0]),
              StartsWith("the accepted link other.pcd, s0.pcd is of little probability by the pair itself: 0."));
  for (const auto& row : table(out() + "/links.csv"))
    if (row[0] == "other.pcd" && row[1] == "s0.pcd") {
      EXPECT_LT(std::stod(row[3]), 0.5);
    }
  EXPECT_THAT(nlohmann::json::parse(run(words + "s0,s1").out)["notes"], IsEmpty());
}

TEST_F(MapProgram, nothingThatIsReadOrOfAnotherIsReplaced)
{
  std::filesystem::create_directories(out("in"));
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"})
    std::filesystem::copy(scans() + "/" + name, out("in"));
  const std::string in = "'" + out("in") + "'";
  std::ofstream(out("in") + "/poses.csv") << "mine\n";
  const Outcome occupied = run(in + " --out " + in);
  EXPECT_EQ(occupied.code, 3);
  EXPECT_THAT(occupied.err, HasSubstr("/in/poses.csv: is there already, and "));
  EXPECT_EQ(io::readFile(out("in") + "/poses.csv"), "mine\n");
  EXPECT_FALSE(std::filesystem::exists(out("in") + "/map.sqlite"));

  const std::string pcd = " --pcd '" + out() + "/copies'";
  ASSERT_EQ(run(in + " --out '" + out() + "' --tum" + pcd).code, 0) << "a folder within one that is not there yet";
  const std::string poses = io::readFile(out() + "/poses.csv");
  for (const char* option : {"--poses", "--truth"}) {
    const Outcome own = run(in + " --out '" + out() + "' --resume " + option + " '" + out() + "/poses.csv'");
    EXPECT_EQ(own.code, 2);
    EXPECT_THAT(own.err, HasSubstr("/poses.csv would be replaced, but is read"));
  }
  const Outcome json = run(in + " --out '" + out() + "' --resume --json '" + out("in") + "/s0.pcd'");
  EXPECT_EQ(json.code, 2);
  EXPECT_EQ(run(in + " --out '" + out() + "' --resume --json /nowhere/x.json").code, 3);
  EXPECT_EQ(io::readFile(out() + "/poses.csv"), poses);

  // What the next map has no place for does not stay behind from this one.
  EXPECT_TRUE(std::filesystem::exists(out() + "/copies/s3.pcd"));
  const Outcome apart = run(in + " --out '" + out() + "' --reject s3,s0 --reject s3,s1" + pcd);
  EXPECT_EQ(apart.code, 1) << apart.err;
  EXPECT_TRUE(std::filesystem::exists(out() + "/copies/s0.pcd"));
  EXPECT_FALSE(std::filesystem::exists(out() + "/copies/s3.pcd"));
  EXPECT_FALSE(std::filesystem::exists(out() + "/poses.tum"));
}

TEST_F(MapProgram, namesThatLookLikeSomethingElse)
{
  std::filesystem::create_directories(out("in"));
  std::filesystem::copy(scans() + "/s0.pcd", out("in") + "/#1.pcd");
  std::filesystem::copy(scans() + "/s1.pcd", out("in") + "/<!--<script>.pcd");
  ASSERT_EQ(run("'" + out("in") + "' --out '" + out() + "'").code, 0);
  const std::string page = io::readFile(out() + "/report.html");
  EXPECT_EQ(page.find("<!--<script>"), std::string::npos) << "it would hide all that follows";
  EXPECT_THAT(page, HasSubstr("\\u003c!--\\u003cscript>.pcd"));
  const Outcome again =
      run("'" + out("in") + "' --out '" + out("again") + "' --truth '" + out() + "/poses.csv' --json -");
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["truth"]["placed"], 2);
}

TEST_F(MapProgram, aBrokenScanIsOneRow)
{
  std::filesystem::create_directories(out("in"));
  std::filesystem::copy(scans(), out("in"), std::filesystem::copy_options::recursive);
  std::ofstream(out("in") + "/broken.pcd") << "no cloud\n";
  std::filesystem::copy(scans() + "/s0.pcd", out("in") + "/twice.pcd");
  const Outcome result = run("'" + out("in") + "' --out '" + out() + "'");
  EXPECT_EQ(result.code, 1) << result.err;
  const auto poses = table(out() + "/poses.csv");
  ASSERT_EQ(poses.size(), 7U);
  for (const auto& row : poses) {
    if (row[0] == "broken.pcd") {
      EXPECT_THAT(row.back(), HasSubstr("broken.pcd"));
    }
    if (row[0] == "twice.pcd") {
      EXPECT_THAT(row.back(), HasSubstr("same points as s0.pcd"));
    }
  }
  const Outcome accepted = run("'" + out("in") + "' --out '" + out() + "' --resume --accept s0,broken");
  EXPECT_EQ(accepted.code, 2);
  EXPECT_THAT(accepted.err, HasSubstr("the link broken.pcd, s0.pcd cannot be accepted: broken.pcd: "));
}

/// Rows of a table by the first field, without the header.
std::map<std::string, std::vector<std::string>>
byFirstField(const std::vector<std::vector<std::string>>& rows)
{
  std::map<std::string, std::vector<std::string>> found;
  for (std::size_t i = 1; i < rows.size(); ++i)
    found[rows[i][0]] = rows[i];
  return found;
}

TEST_F(MapProgram, allScansOfAnE57File)
{
  if (!PCL_SSFR_READS_E57)
    GTEST_SKIP() << "built without pugixml";
  // Scans with a name, with one that is a number, with none; the poses in the file are those of the truth.
  const auto truth = apps::readPoses(folder_->file("poses.txt"));
  std::filesystem::create_directories(out("in"));
  const std::string file = out("in") + "/house.e57";
  io::E57Writer writer(file);
  writer.addScan("Lobby, 1.2", io::loadCloud(scans() + "/s0.pcd"), truth.at("s0.pcd"));
  writer.addScan("1", io::loadCloud(scans() + "/s1.pcd"), truth.at("s1.pcd"));
  writer.addScan("", io::loadCloud(scans() + "/s3.pcd"), truth.at("s3.pcd"));
  writer.finish();

  const Outcome result = run("'" + file + "' --out '" + out() + "' --truth '" + file + "'");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, Not(HasSubstr("of no scan"))); // each pose has several names
  const auto poses = table(out() + "/poses.csv");
  ASSERT_EQ(poses.size(), 4U);
  EXPECT_EQ(poses[1][0], "house.e57#Lobby, 1.2");
  EXPECT_EQ(poses[2][0], "house.e57#2");
  EXPECT_EQ(poses[3][0], "house.e57#3");
  const auto json = nlohmann::json::parse(io::readFile(out() + "/map.json"));
  EXPECT_EQ(json["truth"]["placed"], 3); // by names as well as by numbers
  EXPECT_EQ(json["truth"]["wrong"], 0);
  EXPECT_LT(json["truth"]["largest_translation_m"], 0.02);

  // The same map as of the files that it was made of: points are in the frames of the sensors.
  std::filesystem::create_directories(out("files"));
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"})
    std::filesystem::copy(scans() + "/" + name, out("files"));
  ASSERT_EQ(run("'" + out("files") + "' --out '" + out("of files") + "'").code, 0);
  const auto same = table(out("of files") + "/poses.csv");
  for (std::size_t i = 1; i < same.size(); ++i)
    EXPECT_TRUE(std::equal(same[i].begin() + 1, same[i].end(), poses[i].begin() + 1)) << i;

  // In a folder with other files; scans by name, by number and by what is behind the stroke.
  std::filesystem::copy(scans() + "/a, b.pcd", out("in"));
  const Outcome mended = run("'" + out("in") + "' --out '" + out("more") +
                             "' --reject '\"Lobby, 1.2\",house.e57#2' --reject 'house.e57#1,3' "
                             "--pin 3");
  EXPECT_LE(mended.code, 1) << mended.err;
  const auto rows = byFirstField(table(out("more") + "/poses.csv"));
  EXPECT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows.at("house.e57#3")[2], "1"); // T00 of the one that is pinned
  std::size_t rejected = 0;
  for (const auto& row : table(out("more") + "/links.csv"))
    if (row[2] == "rejected" && row[12].find("person") != std::string::npos)
      ++rejected;
  EXPECT_EQ(rejected, 2U);

  // What is wrong is one line.
  const Outcome none = run("'" + file + "#Hall' '" + scans() + "' --out '" + out("none") + "'");
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("house.e57: no scan is called 'Hall'; it holds "));
  EXPECT_THAT(none.err, HasSubstr("house.e57#1 ('Lobby, 1.2', "));
  EXPECT_EQ(std::count(none.err.begin(), none.err.end(), '\n'), 1);
  EXPECT_EQ(run("'" + file + "#1' --out '" + out("none") + "'").code, 2); // one scan
}

/// A scan with intensity and colour, and its sensor away from the origin, as a PCD file.
void
writeDecorated(const std::string& from, const std::string& to, const Eigen::Vector3d& sensor)
{
  const io::LoadedCloud cloud = io::loadCloud(from);
  pcl::PCLPointCloud2 table;
  for (const char* name : {"x", "y", "z", "intensity", "rgb"})
    io::addField(table, name, pcl::PCLPointField::FLOAT32);
  io::resizeTable(table, cloud.points->size());
  std::uint8_t* at = table.data.data();
  for (const auto& p : *cloud.points) {
    const Eigen::Vector3f moved = p.getVector3fMap() + sensor.cast<float>();
    const float intensity = p.x * 10;
    const std::uint32_t rgb =
        io::packRgb(static_cast<std::uint32_t>(at - table.data.data()) / table.point_step % 256, 128, 255);
    std::memcpy(at, moved.data(), 12);
    std::memcpy(at + 12, &intensity, 4);
    std::memcpy(at + 16, &rgb, 4);
    at += table.point_step;
  }
  io::writePcd(to, table, Eigen::Isometry3d(Eigen::Translation3d(sensor)));
}

/// The packed colours of all points; nothing where there are none.
std::vector<std::uint32_t>
coloursOf(const pcl::PCLPointCloud2& table)
{
  std::vector<std::uint32_t> colours;
  if (const pcl::PCLPointField* rgb = io::findField(table, "rgb"))
    for (std::size_t i = 0; i < io::pointCount(table); ++i) {
      colours.emplace_back();
      std::memcpy(&colours.back(), table.data.data() + i * table.point_step + rgb->offset, 4);
    }
  return colours;
}

TEST_F(MapProgram, scansAreWrittenWithTheirPoses)
{
  std::filesystem::create_directories(out("in"));
  const Eigen::Vector3d sensor(1, -2, 0.5);
  for (const char* name : {"s0.pcd", "s1.pcd"})
    writeDecorated(scans() + "/" + name, out("in") + "/" + name, sensor);
  std::filesystem::copy(scans() + "/s3.pcd", out("in"));
  const std::string begin = "'" + out("in") + "' --out '" + out();
  const Outcome result = run(begin + "' --e57 '" + out("map.e57") + "' --pcd '" + out("copies") + "'");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto poses = apps::readPoses(out() + "/poses.csv");
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"}) {
    SCOPED_TRACE(name);
    const io::LoadedCloud scan = io::loadCloud(out("in") + "/" + name);
    const Eigen::Vector3d place = scan.viewpoint.value_or(Eigen::Vector3d::Zero());
    const Eigen::Isometry3d& pose = poses.at(name);
    const io::LoadedCloud copy = io::loadCloud(out("copies") + "/" + name);
    ASSERT_EQ(copy.points->size(), scan.points->size());
    EXPECT_EQ(copy.has_intensity, scan.has_intensity);
    for (std::size_t i = 0; i < scan.points->size(); i += 97)
      ASSERT_LT(
          ((*copy.points)[i].getVector3fMap().cast<double>() - pose * (*scan.points)[i].getVector3fMap().cast<double>())
              .norm(),
          1e-5);
    const Eigen::Vector3d stands = pose * place;
    if (stands.norm() > 1e-6) {
      ASSERT_TRUE(copy.viewpoint);
      EXPECT_LT((*copy.viewpoint - stands).norm(), 1e-6);
    }
    pcl::PointCloud<pcl::PointXYZ> by_pcl;
    ASSERT_EQ(pcl::io::loadPCDFile(out("copies") + "/" + name, by_pcl), 0);
    EXPECT_TRUE(by_pcl.sensor_orientation_.toRotationMatrix().cast<double>().isApprox(pose.linear(), 1e-6));
    if (!PCL_SSFR_READS_E57)
      continue;
    const io::LoadedCloud again = io::loadCloud(out("map.e57") + "#" + std::filesystem::path(name).stem().string());
    ASSERT_EQ(again.points->size(), scan.points->size());
    EXPECT_EQ(again.has_intensity, scan.has_intensity);
    EXPECT_EQ(coloursOf(again.table), coloursOf(scan.table));
    EXPECT_EQ(coloursOf(again.table).empty(), std::string(name) == "s3.pcd");
    for (std::size_t i = 0; i < scan.points->size(); ++i) {
      ASSERT_LT(((*again.points)[i].getVector3fMap() + place.cast<float>() - (*scan.points)[i].getVector3fMap()).norm(),
                1e-5F);
      ASSERT_EQ((*again.points)[i].intensity, (*scan.points)[i].intensity);
    }
    ASSERT_TRUE(again.T_file_scan);
    EXPECT_TRUE(again.T_file_scan->isApprox(pose * Eigen::Translation3d(place), 1e-12));
  }
  // A disk that is full: a line about it, and the map is there.
  if (std::filesystem::exists("/dev/full")) {
    std::filesystem::remove(out() + "/poses.csv");
    std::filesystem::create_symlink("/dev/full", out("full.e57"));
    const Outcome full = run(begin + "' --resume --e57 '" + out("full.e57") + "'");
    EXPECT_EQ(full.code, 3);
    EXPECT_THAT(full.err, HasSubstr("full.e57: cannot be written"));
    EXPECT_EQ(table(out() + "/poses.csv").size(), 4U);
  }
}

TEST_F(MapProgram, noOutputReplacesAnotherOne)
{
  std::filesystem::create_directories(out("in"));
  for (const char* name : {"s0.pcd", "s1.pcd"})
    std::filesystem::copy(scans() + "/" + name, out("in"));
  std::filesystem::create_hard_link(out("in") + "/s0.pcd", out("linked.pcd"));
  const std::string begin = "'" + out("in") + "' --out '" + out() + "' ";
  const struct {
    std::string arguments;
    const char* text;
  } cases[] = {
      {"--json '" + out() + "/map.sqlite'", "/map.sqlite is a file of the map"},
      {"--json '" + out() + "/../map/poses.csv'", "/poses.csv is a file of the map"},
      {"--merged '" + out("linked.pcd") + "'", "linked.pcd would replace the scan "},
      {"--merged '" + out("x.pcd") + "' --json '" + out("x.pcd") + "'", "/x.pcd is also that of --merged"},
      {"--pcd '" + out("copies") + "' --merged '" + out("copies") + "/s1.pcd'", "/s1.pcd is also that of --merged"},
      {"--truth '" + folder_->file("poses.txt") + "' --json '" + folder_->file("poses.txt") + "'", "but is read"},
  };
  for (const auto& c : cases)
    for (const char* folder : {"none", "made"}) {
      if (std::string(folder) == "made")
        std::filesystem::create_directories(out());
      const Outcome result = run(begin + c.arguments);
      EXPECT_EQ(result.code, 2) << c.arguments;
      EXPECT_THAT(result.err, HasSubstr(c.text));
      EXPECT_FALSE(std::filesystem::exists(out() + "/map.sqlite"));
      std::filesystem::remove_all(out());
    }
  // The same where the map is there already.
  ASSERT_EQ(run(begin).code, 0);
  const std::string bytes = io::readFile(out() + "/map.sqlite");
  for (const auto& c : cases)
    EXPECT_EQ(run(begin + "--resume " + c.arguments).code, 2) << c.arguments;
  EXPECT_EQ(io::readFile(out() + "/map.sqlite"), bytes);
}

TEST_F(MapProgram, copiesSayWhereTheSensorWasFound)
{
  // In a national grid, in a format that says nothing of the sensor.
  std::filesystem::create_directories(out("in"));
  const Eigen::Vector3d sensor(2600000.5, 1200000.25, 450);
  for (const char* name : {"s0", "s1"})
    io::saveMovedCloud(out("in") + "/" + name + ".ply",
                       io::loadCloud(scans() + "/" + name + ".pcd"),
                       Eigen::Isometry3d(Eigen::Translation3d(sensor)));
  const Outcome result = run("'" + out("in") + "' --out '" + out() + "' --pcd '" + out("copies") + "'");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto poses = apps::readPoses(out() + "/poses.csv");
  for (const std::string name : {"s0", "s1"}) {
    const io::LoadedCloud copy = io::loadCloud(out("copies") + "/" + name + ".pcd");
    ASSERT_TRUE(copy.viewpoint);
    EXPECT_LT((*copy.viewpoint - poses.at(name + ".ply") * sensor).norm(), 0.3) << name;
  }
}

TEST_F(MapProgram, copiesReplaceCopiesOnly)
{
  const std::string mine = out("copies") + "/s3.pcd";
  std::filesystem::create_directories(out("copies"));
  const std::string begin = "'" + scans() + "' --out '" + out() + "' --pcd '" + out("copies") + "'";
  const auto expectRefusal = [&] {
    const Outcome refused = run(begin);
    EXPECT_EQ(refused.code, 3);
    EXPECT_THAT(refused.err, HasSubstr(mine + ": is there already, and ssfr_map --pcd did not write it"));
    EXPECT_FALSE(std::filesystem::exists(out() + "/map.sqlite")) << "the work did not begin";
  };
  // A PCD file of this project is not a copy in a map either.
  io::saveMovedCloud(mine, io::loadCloud(scans() + "/s3.pcd"), Eigen::Isometry3d::Identity());
  const std::string bytes = io::readFile(mine);
  expectRefusal();
  EXPECT_EQ(io::readFile(mine), bytes);
  std::filesystem::remove(mine);
  std::filesystem::create_symlink("nowhere.pcd", mine);
  expectRefusal();
  // One that came while the program worked.
  std::filesystem::remove(mine);
  std::vector<apps::MapInputFile> files{{scans() + "/s3.pcd", "s3.pcd"}};
  MultiwayMap map;
  map.scans.resize(1);
  map.scans[0].component = 1;
  apps::CloudOutputs outputs;
  outputs.pcd = out("copies");
  apps::checkOutputs(outputs, files);
  io::writeFile(mine, bytes);
  EXPECT_THROW(apps::writeClouds(outputs, files, map, {}, {}, [](std::size_t, std::size_t) {}), io::IoError);
  EXPECT_EQ(io::readFile(mine), bytes);
}

TEST(MapFiles, tumKeepsMillimetresOfANationalGrid)
{
  MultiwayMap map;
  map.scans.resize(1);
  map.scans[0].component = 0;
  const Eigen::Vector3d scan(2600000.123, 1200000.456, 450.789); // both frames are that of the grid
  const Eigen::Isometry3d truth = Eigen::Translation3d(scan) *
                                  Eigen::AngleAxisd(1.234, Eigen::Vector3d(1, 2, 3).normalized()) *
                                  Eigen::Translation3d(-scan);
  map.scans[0].T_map_scan = truth;
  std::istringstream text(apps::posesTum(map));
  std::string comment;
  std::getline(text, comment);
  std::size_t number = 7;
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  text >> number >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w();
  EXPECT_EQ(number, 0U);
  const Eigen::Isometry3d read = Eigen::Translation3d(t) * q.normalized();
  EXPECT_LT((read * scan - truth * scan).norm(), 1e-6);
}

TEST(MapClouds, mergedByTheExtensionInAnyCase)
{
  TemporaryFolder folder;
  for (const char* name : {"x.Pcd", "x.PLY"}) {
    apps::MergedCloud merged(folder.file(name), 0, false);
    merged.add(io::parseCloud("a.xyz", "1 2 3\n4 5 6\n"), Eigen::Isometry3d::Identity(), 0);
    EXPECT_EQ(merged.finish(), 2U);
    EXPECT_EQ(io::loadCloud(folder.file(name)).points->size(), 2U);
  }
}

TEST(MapClouds, names)
{
  const auto named = [](const std::vector<std::string>& names) {
    std::vector<apps::MapInputFile> files;
    for (const std::string& name : names)
      files.push_back({"in/" + name, name});
    return files;
  };
  const auto files = named({"a/s.pcd", "b/s.pcd", "x.e57#way/out", "x.e57#2", "y.ply", "z.e57#way_out"});
  EXPECT_THAT(apps::shortNames(files), ElementsAre("a/s.pcd", "b/s.pcd", "way/out", "2", "y", "way_out"));
  EXPECT_THAT(apps::copyNames(files),
              ElementsAre("a_s.pcd.pcd", "b_s.pcd.pcd", "way_out.pcd", "2.pcd", "y.pcd", "way_out_2.pcd"));
  EXPECT_THAT(apps::copyNames(named({"x.e57#..", "x.e57#a b"})), ElementsAre("_...pcd", "a b.pcd"));
}

TEST(MapInputs, scansOfE57Files)
{
  if (!PCL_SSFR_READS_E57)
    GTEST_SKIP() << "built without pugixml";
  TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::vector<std::string>& scans) {
    std::filesystem::create_directories(std::filesystem::path(folder.file(name)).parent_path());
    io::E57Writer writer(folder.file(name));
    io::LoadedCloud cloud;
    for (const char* axis : {"x", "y", "z"})
      io::addField(cloud.table, axis, pcl::PCLPointField::FLOAT32);
    io::resizeTable(cloud.table, 1);
    for (const std::string& scan : scans)
      writer.addScan(scan, cloud, Eigen::Isometry3d::Identity());
    writer.finish();
  };
  write("a/x.e57", {"hall", "way/out", "hall"});
  write("b/x.e57", {"hall", "yard"});
  write("b/one.E57", {"hall"});
  io::writeFile(folder.file("b/broken.e57"), "no e57");
  const auto named = [&](const std::vector<std::string>& inputs) {
    std::vector<std::string> paths;
    for (const std::string& input : inputs)
      paths.push_back(folder.file(input));
    std::string text;
    for (const apps::MapInputFile& file : apps::findScans(paths))
      text += file.name + " = " + file.path.substr(folder.file("").size()) + "; ";
    return text;
  };
  EXPECT_EQ(named({"a"}), "x.e57#1 = a/x.e57#1; x.e57#way/out = a/x.e57#2; x.e57#3 = a/x.e57#3; ");
  EXPECT_EQ(named({"b"}),
            "broken.e57 = b/broken.e57; one.E57 = b/one.E57; x.e57#hall = b/x.e57#1; x.e57#yard = b/x.e57#2; ");
  // Files of one name, and a scan that is given three times.
  EXPECT_EQ(named({"a/x.e57#1", "b/x.e57", "b/x.e57#1", "b/x.e57#hall", "a/x.e57#way/out"}),
            "x.e57#1 = a/x.e57#1; x.e57#hall = b/x.e57#1; x.e57#yard = b/x.e57#2; x.e57#way/out = a/x.e57#2; ");
  write("c/x.e57", {"hall", "yard"});
  EXPECT_EQ(named({"b/x.e57#hall", "c/x.e57#1", "c/x.e57#2"}),
            "b/x.e57#hall = b/x.e57#1; c/x.e57#hall = c/x.e57#1; x.e57#yard = c/x.e57#2; ");
  EXPECT_THROW(named({"a/x.e57#hall"}), io::IoError); // two of them
  EXPECT_THROW(named({"a/x.e57#4"}), io::IoError);
  EXPECT_THROW(named({"a/y.e57#1"}), io::IoError);

  EXPECT_THAT(apps::namesOfScan("b/x.e57#way/out"),
              ElementsAre("b/x.e57#way/out", "x.e57#way/out", "x#way/out", "way/out"));
  EXPECT_THAT(apps::namesOfScan("b/s.1.pcd"), ElementsAre("b/s.1.pcd", "s.1.pcd", "s.1"));
  EXPECT_TRUE(io::isE57("a.E57"));
  EXPECT_TRUE(io::isE57("a.e57#b"));
  EXPECT_FALSE(io::isE57("a.e57.pcd"));
  EXPECT_FALSE(io::isE57(".e57"));
}

/// Lines of a control file: places that scans show, true in a site frame far from the origin.
std::vector<std::string>
controlOf(const std::string& poses)
{
  const Eigen::Isometry3d T_site_world =
      Eigen::Translation3d(3.2e5, 5.6e6, 112) * Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ());
  const auto truth = apps::readPoses(poses);
  const auto row = [](const std::string& name, const Eigen::Vector3d& site, const std::string& in_scan) {
    char text[200];
    std::snprintf(
        text, sizeof(text), "%s,%.4f,%.4f,%.4f,%s", name.c_str(), site.x(), site.y(), site.z(), in_scan.c_str());
    return std::string(text);
  };
  std::vector<std::string> lines = {"scan,x,y,z,point,sx,sy,sz"};
  lines.push_back(row("s0", T_site_world * truth.at("s0.pcd").translation(), ",,,"));
  lines.push_back(row("s1", T_site_world * truth.at("s1.pcd").translation(), ",,,"));
  lines.push_back(row("s3", T_site_world * truth.at("s3.pcd") * Eigen::Vector3d(2, 0, 0), "door,2,0,0"));
  lines.push_back(row("s3", T_site_world * truth.at("s3.pcd") * Eigen::Vector3d(0, 2, 0), "sill,0,2,0"));
  lines.push_back(row("s0", T_site_world * truth.at("s0.pcd") * Eigen::Vector3d(0, 1, -2), "lamp,0,1,-2"));
  return lines;
}

void
writeLines(const std::string& path, const std::vector<std::string>& lines)
{
  std::ofstream file(path);
  for (const std::string& line : lines)
    file << line << "\n";
}

TEST_F(MapProgram, theMapIsLaidOntoControl)
{
  const std::string begin = "'" + scans() + "' --out '" + out() + "' --control '" + out("control.csv") + "' --json -";
  std::vector<std::string> lines = controlOf(folder_->file("poses.txt"));
  writeLines(out("control.csv"), lines);
  const Outcome result = run(begin + " --truth '" + folder_->file("poses.txt") + "'");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json["control"].size(), 5U);
  for (const auto& point : json["control"]) {
    EXPECT_LT(point["residual_m"], 0.02) << point;
    const double dx = point["dx_m"], dy = point["dy_m"], dz = point["dz_m"];
    EXPECT_NEAR(std::sqrt(dx * dx + dy * dy + dz * dz), double(point["residual_m"]), 1e-9);
  }
  EXPECT_EQ(json["control"][2]["point"], "s3 door");
  EXPECT_THAT(json["notes"], IsEmpty());
  EXPECT_EQ(json["truth"]["wrong"], 0);
  EXPECT_LT(json["truth"]["normalised_error_squared"], 20); // its covariances follow into the other frame
  const auto poses = table(out() + "/poses.csv");
  EXPECT_GT(std::stod(poses[2][9]), 5e6); // T13 of s0, the northing
  EXPECT_THAT(io::readFile(out() + "/report.html"), HasSubstr("s3 door"));

  // Easting and northing swapped: the map stands on its head.
  std::vector<std::string> swapped = lines;
  for (std::size_t k = 1; k < swapped.size(); ++k) {
    const std::vector<std::string> fields = io::splitCsvLine(swapped[k]);
    const std::string ahead = fields[0] + "," + fields[1] + "," + fields[2];
    swapped[k].replace(0, ahead.size(), fields[0] + "," + fields[2] + "," + fields[1]);
  }
  writeLines(out("control.csv"), swapped);
  EXPECT_THAT(nlohmann::json::parse(run(begin).out)["notes"].dump(), HasSubstr("tilts the map by "));

  // A figure that was read wrongly: named, and how far it is off.
  lines[3].replace(lines[3].find(','), 1, ",1"); // 1 before the easting of the door
  writeLines(out("control.csv"), lines);
  const Outcome typed = run(begin + " --resume");
  ASSERT_EQ(typed.code, 0) << typed.err;
  const auto notes = nlohmann::json::parse(typed.out)["notes"];
  ASSERT_EQ(notes.size(), 1U);
  const std::string note = notes[0];
  ASSERT_THAT(note, StartsWith("control s3 door is "));
  EXPECT_NEAR(std::stod(note.substr(std::string("control s3 door is ").size())), 1e6, 0.1);
}

TEST_F(MapProgram, controlThatDoesNotFitLosesNothing)
{
  std::vector<std::string> lines = controlOf(folder_->file("poses.txt"));
  const std::string begin = "'" + scans() + "' --out '" + out() + "' --control '" + out("control.csv") + "'";
  // All but one scan stand apart from the two that control knows.
  writeLines(out("control.csv"), {lines[0], lines[1], lines[3], lines[4]});
  std::filesystem::create_directories(out("in"));
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"})
    std::filesystem::copy(scans() + "/" + name, out("in"));
  const Outcome apart = run("'" + out("in") + "' --out '" + out() + "' --control '" + out("control.csv") +
                            "' --reject s3,s0 --reject s3,s1");
  EXPECT_EQ(apart.code, 3) << apart.err;
  EXPECT_THAT(apart.err, HasSubstr("1 of 3 places are of the largest component"));
  EXPECT_EQ(table(out() + "/poses.csv").size(), 4U); // the map is there
  // Known before anything is done.
  const struct {
    std::vector<std::string> lines;
    const char* text;
  } cases[] = {
      {{lines[0], lines[1], lines[2]}, "not on a line"},
      {{"scan,x,y,z", "s0,0,0,0", "s1,1,1,1", "s3,2,2,2"}, "not on a line"},
      {{"scan,x,y", "s0,0,0"}, "column z"},
      {{"scan,x,y,z", "s0,0,0,0", "s1,1,0,nan", "s3,2,2,2"}, "nan"},
      {{lines[0], lines[1], lines[1], lines[3]}, "second place"},
      {{"scan,x,y,z,sx", "s0,0,0,0,1", "s1,1,0,0,1", "s3,2,2,2,1"}, "column sy"},
      {{"scan,x,y,z,sy,sz", "s0,0,0,0,1,1", "s1,1,0,0,,", "s3,2,2,2,,"}, "column sx"},
      {{"scan,x,y,z,sx,sy,sz", "s0,0,0,0,,,", "s1,1,0,0,,2,3", "s3,2,2,2,,,"}, "control.csv:3: the column sx is ''"},
  };
  for (const auto& c : cases) {
    writeLines(out("control.csv"), c.lines);
    const Outcome bad = run(begin);
    EXPECT_EQ(bad.code, 3) << c.text;
    EXPECT_THAT(bad.err, HasSubstr(c.text));
    EXPECT_THAT(bad.err, HasSubstr("control.csv"));
  }
  writeLines(out("control.csv"), {lines[0], lines[1], lines[2], "nowhere,1,2,3,,,,"});
  const Outcome unknown = run(begin);
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("nowhere"));
}

TEST_F(MapProgram, whatIsWrongIsOneLineThatNamesIt)
{
  const std::string in = "'" + scans() + "'";
  io::writeFile(out("other.txt"), "z.pcd 1 2 3 0 0 0 1\n");
  const struct {
    std::string arguments;
    int code;
    const char* text;
  } cases[] = {
      {"--out x", 2, "INPUT is missing"},
      {in, 2, "--out is missing"},
      {in + " --out '" + out() + "' --thraeds 2", 2, "--thraeds"},
      {in + " --out '" + out() + "' --gravity 0,0", 2, "--gravity"},
      {in + " --out '" + out() + "' --gravity 0,0,up", 2, "--gravity: 'up' is not a number"},
      {in + " --out '" + out() + "' --gravity 0,0,inf", 2, "--gravity: '0,0,inf' is not finite"},
      {in + " --out '" + out() + "' --threads 1.5", 2, "--threads"},
      {in + " --out '" + out() + "' --pose-tolerance 1,1", 2, "--pose-tolerance"},
      {in + " --out '" + out() + "' --accept s0", 2, "--accept"},
      {in + " --out '" + out() + "' --accept s0,s9", 2, "s9"},
      {in + " --out '" + out() + "' --pin nothing", 2, "nothing"},
      {in + " --out '" + out() + "' --pairs some", 2, "--pairs: 'some' is neither all, candidates nor auto"},
      {in + " --out '" + out() + "' --merged all.las", 2, "all.las"},
      {in + " --out '" + out() + "' --merged all.e57", 2, "all.e57"},
      {in + " --out '" + out() + "' --e57 all.pcd", 2, "--e57: all.pcd is not an .e57 file"},
      {in + " --out '" + out() + "' --e57 'all.e57#1'", 2, "is not an .e57 file"},
      {in + " --out '" + out() + "' --e57 /nowhere/all.e57", 3, "/nowhere/all.e57: the folder /nowhere does not exist"},
      {in + " --out '" + out() + "' --merged '" + scans() + "/s0.pcd'", 2, "would replace the scan"},
      {in + " --out '" + out() + "' --pcd " + in, 2, "would replace the scan"},
      {in + " --out '" + out() + "' --merged '" + scans() + "/all.ply'", 2, "would be read as a scan by the next run"},
      {in + " --out '" + out() + "' --e57 '" + scans() + "/all.e57'", 2, "would be read as a scan by the next run"},
      {in + " --out '" + out() + "' --pcd '" + scans() + "/s0.pcd'", 3, "s0.pcd: the folder cannot be created"},
      {"'" + scans() + "/s0.pcd' --out '" + out() + "'", 2, "two scans or more"},
      {"'" + out("missing") + "' --out '" + out() + "'", 3, "missing"},
      {in + " --out /proc/nowhere", 3, "/proc/nowhere"},
      {in + " --out '" + out() + "' --truth '" + out("no.txt") + "'", 3, "no.txt"},
      {in + " --out '" + out() + "' --truth '" + out("other.txt") + "'", 3, "other.txt: names none of the scans"},
      {in + " --out '" + out() + "' --poses '" + out("other.txt") + "'", 3, "other.txt: names none of the scans"},
  };
  for (const auto& c : cases) {
    const Outcome result = run(c.arguments);
    EXPECT_EQ(result.code, c.code) << c.arguments;
    EXPECT_THAT(result.err, HasSubstr(c.text)) << c.arguments;
    EXPECT_THAT(result.err, StartsWith("ssfr_map: ")) << c.arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.out, IsEmpty()) << c.arguments;
  }
  EXPECT_EQ(run("--help").code, 0);
  EXPECT_THAT(run("--version").out, StartsWith("ssfr_map "));
}

TEST_F(MapProgram, oneRunAtATimeWorksInAFolder)
{
  const std::string words = "'" + scans() + "' --out '" + out() + "'";
  std::filesystem::create_directories(out());
  {
    const apps::FolderLock other(out());
    const Outcome locked = run(words);
    EXPECT_EQ(locked.code, 3);
    EXPECT_THAT(locked.err, HasSubstr(out() + ": another ssfr_map works in this folder"));
    EXPECT_TRUE(std::filesystem::is_empty(out()));
    EXPECT_THROW(apps::FolderLock{out()}, io::IoError);
  }
  EXPECT_EQ(run(words).code, 0);
}

TEST_F(MapProgram, whatKeepsScansApartIsNamed)
{
  // Far from where the scans are to each other, and a vertical that none of the rotated scans has.
  std::string poses;
  for (int i = 0; i < 2; ++i)
    poses += "s" + std::to_string(i) + ".pcd " + std::to_string(40 * i) + " 0 0 0 0 0 1\n";
  io::writeFile(out("far.txt"), poses);
  const std::string begin = "'" + scans() + "/s0.pcd' '" + scans() + "/s1.pcd' --out '";
  EXPECT_THAT(run(begin + out("a") + "' --poses '" + out("far.txt") + "'").out,
              HasSubstr("no other scan shares enough with it near its approximate pose"));
  EXPECT_THAT(run(begin + out("b") + "' --gravity 0,0,1").out,
              HasSubstr("no other scan shares enough with it by the given vertical"));
}

TEST_F(MapProgram, whatCountsForNothingIsSaid)
{
  const std::string poses = io::readFile(folder_->file("poses.txt"));
  io::writeFile(out("more.txt"), poses + "s8.pcd 0 0 0 0 0 0 1\ns9.pcd 0 0 0 0 0 0 1\n");
  const Outcome result =
      run("'" + scans() + "' --out '" + out() + "' --truth '" + out("more.txt") + "' --pin s3 --pin s1");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("more.txt: 2 of 5 poses are of no scan here"));
  EXPECT_THAT(result.out, HasSubstr("s1.pcd is pinned, but s3.pcd, pinned before it, holds the frame"));
}

TEST_F(MapProgram, noScanThatCanBeUsed)
{
  std::filesystem::create_directories(out("bad"));
  for (const char* name : {"/1.pcd", "/2.pcd"})
    io::writeFile(out("bad") + name, "no cloud\n");
  for (const char* decision : {"", " --accept 1,2"}) {
    const Outcome result = run("'" + out("bad") + "' --out '" + out() + "' --resume" + decision);
    EXPECT_EQ(result.code, 3);
    EXPECT_THAT(result.err, HasSubstr("a map takes two scans or more, 0 of 2 can be used; 1.pcd: ")) << decision;
    EXPECT_THAT(result.err, HasSubstr("/bad/1.pcd:1: 'no' is not a line of a PCD header")) << decision;
  }
}

TEST_F(MapProgram, aRunThatLinkedNothingHoldsNothing)
{
  std::filesystem::create_directories(out("in"));
  std::filesystem::copy(scans() + "/s0.pcd", out("in"));
  io::writeFile(out("in") + "/s1.pcd", "no cloud\n");
  const std::string words = "'" + out("in") + "' --out '" + out() + "'";
  ASSERT_EQ(run(words).code, 3);
  std::filesystem::copy(scans() + "/s1.pcd", out("in"), std::filesystem::copy_options::overwrite_existing);
  const Outcome mended = run(words);
  EXPECT_EQ(mended.code, 0) << mended.err;
  const Outcome again = run(words);
  EXPECT_EQ(again.code, 3);
  EXPECT_THAT(again.err, HasSubstr("map.sqlite: holds a map already"));
  // What is known besides is a decision on the map that is there.
  for (const std::string& known : {" --poses '" + folder_->file("poses.txt") + "'", std::string(" --gravity 0,0,1")}) {
    const Outcome decided = run(words + known);
    EXPECT_LT(decided.code, 2) << known << decided.err;
  }
}

TEST_F(MapProgram, oneScanTwiceIsSaid)
{
  std::filesystem::create_directories(out("in"));
  std::filesystem::copy(scans() + "/s0.pcd", out("in"));
  std::filesystem::copy(scans() + "/s0.pcd", out("in") + "/twice.pcd");
  const Outcome result = run("'" + out("in") + "' --out '" + out() + "'");
  EXPECT_EQ(result.code, 3);
  EXPECT_THAT(result.err, HasSubstr("1 of 2 can be used; twice.pcd: it holds the same points as s0.pcd"));
}

TEST_F(MapProgram, whereNothingIsLinkedEveryScanHasItsReason)
{
  std::filesystem::create_directories(out("in"));
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"})
    std::filesystem::copy(scans() + "/" + name, out("in"));
  const Outcome apart =
      run("'" + out("in") + "' --out '" + out() + "' --reject s0,s1 --reject s0,s3 --reject s1,s3 --truth '" +
          folder_->file("poses.txt") + "'");
  EXPECT_EQ(apart.code, 1) << apart.err;
  EXPECT_THAT(apart.out, HasSubstr("3 scans, 0 placed"));
  for (const char* name : {"s0.pcd", "s1.pcd", "s3.pcd"})
    EXPECT_THAT(apart.out, HasSubstr(std::string("\n") + name + ": "));
  EXPECT_THAT(apart.out, HasSubstr("truth: 0 of 0 placed scans are wrong\n"));
  EXPECT_THAT(apart.out, Not(HasSubstr("nan")));
  // One of two is as good as the other: their error says nothing of the covariance.
  io::writeFile(out("wrong.txt"), "s0.pcd 0 0 0 0 0 0 1\ns1.pcd 99 0 0 0 0 0 1\n");
  const Outcome two = run("'" + out("in") + "/s0.pcd' '" + out("in") + "/s1.pcd' --out '" + out("two") + "' --truth '" +
                          out("wrong.txt") + "'");
  EXPECT_THAT(two.out, AllOf(HasSubstr("truth: 1 of 2 placed scans are wrong"), Not(HasSubstr("nan"))));
}

TEST(MapOptions, whichPairsAreLinked)
{
  const auto rule = [](const std::vector<std::string>& words) {
    std::vector<std::string> arguments = {"scans", "--out", "map"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    return apps::parseMapArguments(arguments).pairs;
  };
  EXPECT_EQ(rule({}), PairRule::Auto);
  EXPECT_EQ(rule({"--pairs", "auto"}), PairRule::Auto);
  EXPECT_EQ(rule({"--pairs", "all"}), PairRule::All);
  EXPECT_EQ(rule({"--pairs", "candidates"}), PairRule::Candidates);
}

TEST(PoseList, aByteOrderMarkIsNoPartOfTheFirstName)
{
  const TemporaryFolder folder;
  const std::string mark = "\xEF\xBB\xBF";
  io::writeFile(folder.file("p.txt"), mark + "a.pcd 1 2 3 0 0 0 1\nb.pcd 1 2 3 0 0 0 1\n");
  EXPECT_EQ(apps::readPoses(folder.file("p.txt")).count("a.pcd"), 1U);
  io::writeFile(folder.file("control.csv"), mark + "scan,x,y,z\na,0,0,0\nb,9,0,0\nc,0,9,0\n");
  EXPECT_EQ(apps::readControl(folder.file("control.csv")).size(), 3U);
}

TEST(PoseList, bothFormatsAndWhatIsWrongInThem)
{
  const TemporaryFolder folder;
  const auto errorOf = [&](const std::string& text) -> std::string {
    io::writeFile(folder.file("p.txt"), text);
    try {
      apps::readPoses(folder.file("p.txt"));
    }
    catch (const io::IoError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(errorOf("# scan ...\na.pcd 1 2 3 0 0 0 1\n"), "");
  EXPECT_EQ(errorOf("a.pcd 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\n"), "");
  EXPECT_THAT(errorOf("a.pcd 2 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1\n"), HasSubstr("rigid motion"));
  io::writeFile(folder.file("m.txt"), "a.pcd 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\n");
  const Eigen::Vector3d place = apps::readPoses(folder.file("m.txt")).at("a.pcd").translation();
  EXPECT_TRUE(place == Eigen::Vector3d(5, 6, 7));
  EXPECT_THAT(errorOf("a.pcd 1 2 3 0 0 0\n"), HasSubstr("qx qy qz qw"));
  EXPECT_THAT(errorOf("a.pcd 1 2 3 0 0 0 2\n"), HasSubstr("length"));
  EXPECT_THAT(errorOf("a 1 2 3 0 0 0 1\na 1 2 3 0 0 0 1\n"), HasSubstr("second pose"));
  EXPECT_THAT(errorOf(""), HasSubstr("no pose"));
  EXPECT_THAT(errorOf("scan,T00\na,1\n"), HasSubstr("T01"));
}

TEST(PoseList, aPoseIsOfTheScanThatAloneAnswersToItsName)
{
  std::map<std::string, Eigen::Isometry3d> poses;
  const auto add = [&](const char* name, double x) { poses[name] = Eigen::Translation3d(x, 0, 0); };
  /// The x of each scan, 0 where it has no pose.
  const auto found = [&](const std::vector<std::string>& names) {
    std::vector<double> x;
    for (const std::optional<Eigen::Isometry3d>& pose : apps::posesOfScans(poses, names, "p.txt"))
      x.push_back(pose ? pose->translation().x() : 0);
    return x;
  };
  const auto problem = [&](const std::vector<std::string>& names) -> std::string {
    try {
      found(names);
    }
    catch (const io::IoError& error) {
      return error.what();
    }
    return "";
  };
  add("a", 1);
  add("b.pcd", 2);
  EXPECT_THAT(found({"x/a.pcd", "b.pcd", "c.pcd"}), ElementsAre(1, 2, 0));
  EXPECT_EQ(problem({"x/b.pcd", "y/b.pcd"}), "p.txt: 'b.pcd' may be x/b.pcd or y/b.pcd");
  EXPECT_EQ(problem({"a.ply", "a.pcd"}), "p.txt: 'a' may be a.ply or a.pcd");
  EXPECT_THAT(found({"b.pcd", "y/b.pcd"}), ElementsAre(2, 0)) << "it is the whole name of one of them";
  add("y/b.pcd", 3);
  EXPECT_THAT(problem({"x/b.pcd", "y/b.pcd"}), HasSubstr("'b.pcd' may be"));
  add("x/b.pcd", 4);
  EXPECT_THAT(found({"x/b.pcd", "y/b.pcd"}), ElementsAre(4, 3));

  poses.clear(); // as of an E57 file: by number, with and without the name of the file
  add("1", 1);
  add("2", 2);
  add("a.e57#1", 1);
  add("a.e57#2", 2);
  EXPECT_THAT(found({"a.e57#1", "a.e57#2", "b.e57#1", "b.e57#2"}), ElementsAre(1, 2, 0, 0));
  EXPECT_THAT(found({"b.e57#1", "b.e57#2"}), ElementsAre(1, 2)) << "a file by another name";
}

TEST(PoseList, placesAreFitted)
{
  const Eigen::Isometry3d T =
      Eigen::Translation3d(3e5, 4e6, 100) * Eigen::AngleAxisd(2, Eigen::Vector3d(1, 1, 3).normalized());
  const std::vector<Eigen::Vector3d> from = {{0, 0, 0}, {5, 0, 0}, {0, 4, 1}, {1, 1, 0}};
  std::vector<Eigen::Vector3d> to;
  for (const Eigen::Vector3d& p : from)
    to.push_back(T * p);
  EXPECT_TRUE(apps::fitPlaces(from, to).isApprox(T, 1e-9));
  EXPECT_THROW(apps::fitPlaces({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
               std::invalid_argument);
}

TEST(ControlPoints, theOneThatContradictsIsFound)
{
  const std::vector<Eigen::Vector3d> site = {{0, 0, 0}, {9, 0, 1}, {9, 7, 0}, {0, 7, 2}, {4, 3, 1}};
  std::vector<Eigen::Vector3d> map = site;
  for (std::size_t i = 0; i < map.size(); ++i)
    map[i] += Eigen::Vector3d(i % 2 ? 0.004 : -0.004, 0.003, i % 3 ? 0.002 : -0.002);
  const apps::ControlFit good = apps::fitControl(map, site);
  EXPECT_FALSE(good.misfit);
  ASSERT_EQ(good.residuals.size(), 5U);
  for (const Eigen::Vector3d& r : good.residuals)
    EXPECT_LT(r.norm(), 0.01);
  for (std::size_t wrong = 0; wrong < map.size(); ++wrong) {
    std::vector<Eigen::Vector3d> other = site;
    other[wrong].y() += 0.5;
    const apps::ControlFit bad = apps::fitControl(map, other);
    ASSERT_TRUE(bad.misfit);
    EXPECT_EQ(*bad.misfit, wrong);
    EXPECT_NEAR(bad.misfit_distance, 0.5, 0.03);
    EXPECT_LT(bad.others, 0.01);
  }
  // Three leave nothing to check one by.
  EXPECT_FALSE(apps::fitControl({map[0], map[1], map[2]}, {site[0], site[1], site[3]}).misfit);
}

TEST(ControlPoints, whatSpeaksAgainstAFitIsSaid)
{
  apps::ControlledPlaces places;
  places.labels = {"a", "b", "c"};
  places.map = {{0, 0, 0}, {9, 0, 1}, {9, 7, 0}};
  places.sigma = {0, 0.002, 0.003};
  const Eigen::Isometry3d T = Eigen::Translation3d(3e5, 5e6, 100) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  for (const Eigen::Vector3d& place : places.map)
    places.site.emplace_back(T * place);
  const auto doubts = [](const apps::ControlledPlaces& of, const std::optional<apps::MapVertical>& vertical) {
    return apps::doubtsOfControl(of, apps::fitControl(of.map, of.site), vertical, 0.0873);
  };
  const apps::MapVertical up{Eigen::Vector3d::UnitZ(), true}, down{-Eigen::Vector3d::UnitZ(), true},
      axis{-Eigen::Vector3d::UnitZ(), false}, tilted{Eigen::Vector3d(0.17, 0, 1).normalized(), true};
  EXPECT_THAT(doubts(places, std::nullopt), IsEmpty());
  EXPECT_THAT(doubts(places, up), IsEmpty());
  EXPECT_THAT(doubts(places, axis), IsEmpty());
  EXPECT_THAT(doubts(places, down), ElementsAre(HasSubstr("tilts the map by 180.0 degrees")));
  EXPECT_THAT(doubts(places, tilted),
              ElementsAre(AllOf(HasSubstr("tilts the map by 9.6 degrees"), Not(HasSubstr("swapped")))));
  // Easting and northing swapped: of a plane nothing but the vertical shows it.
  apps::ControlledPlaces swapped = places;
  for (Eigen::Vector3d& place : swapped.site)
    std::swap(place.x(), place.y());
  EXPECT_THAT(doubts(swapped, up), ElementsAre(HasSubstr("; with x and y swapped it would be upright")));
  // Of three the largest residual is named, where the map is known better than that.
  apps::ControlledPlaces off = places;
  off.site[1] += T.linear() * Eigen::Vector3d(1, 0, 0);
  EXPECT_THAT(doubts(off, up), ElementsAre(HasSubstr("control does not fit: ")));
  off.sigma = {0.5, 0.5, 0.5};
  EXPECT_THAT(doubts(off, up), IsEmpty());
  // Millimetres.
  apps::ControlledPlaces other = places;
  for (Eigen::Vector3d& place : other.site)
    place *= 1000;
  EXPECT_THAT(doubts(other, up),
              ElementsAre(HasSubstr("control does not fit: "), HasSubstr("are 1000 times those in the map")));
}

TEST(MapTruth, aBentStreetIsOneFrameAndAScanAsideIsWrong)
{
  // Ten scans 10 m apart: the map bends by 1.5 degrees over 90 m, and scan 7 is 1 m aside.
  MultiwayMap map;
  std::vector<std::optional<Eigen::Isometry3d>> truth;
  for (int i = 0; i < 10; ++i) {
    truth.emplace_back(Eigen::Translation3d(10 * i, 0, 0));
    MapScan scan;
    scan.name = "s" + std::to_string(i);
    scan.component = 0;
    scan.T_map_scan = Eigen::Translation3d(10 * i, 0.0002 * i * i + (i == 7 ? 1 : 0), 0) *
                      Eigen::AngleAxisd(0.0029 * i, Eigen::Vector3d::UnitZ());
    map.scans.push_back(scan);
    map.graph_poses.push_back(scan.T_map_scan);
    map.chain_poses.push_back(scan.T_map_scan);
  }
  const apps::MapErrors errors = apps::compareWithTruth(map, truth, std::vector<Eigen::Vector3d>(10, {0, 0, 0}));
  EXPECT_EQ(errors.placed, 10U);
  EXPECT_EQ(errors.wrong, 1U);
  EXPECT_TRUE(errors.scans[7]->wrong);
  EXPECT_EQ(errors.wrong_coarsely, 0U);
}

} // namespace
} // namespace pcl_ssfr::test_multiway_cli
