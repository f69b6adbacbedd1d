// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/io/file_bytes.h>
#include <apps/io/output_file.h>
#include <apps/io/text_scanner.h>
#include <apps/io/transform_file.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>

namespace pcl_ssfr::test_io_text {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::errorOf;
using testing::fuzz;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

constexpr int kFuzzRounds = 3000;

io::LoadedCloud
parse(const std::string& name, const std::string& text)
{
  return io::parseCloud(name, text);
}

void
expectPoint(const io::LoadedCloud& cloud, std::size_t i, double x, double y, double z, double tolerance = 1e-6)
{
  ASSERT_LT(i, cloud.points->size());
  const Eigen::Vector3d point = (*cloud.points)[i].getVector3fMap().cast<double>() + cloud.offset;
  EXPECT_NEAR(point.x(), x, tolerance);
  EXPECT_NEAR(point.y(), y, tolerance);
  EXPECT_NEAR(point.z(), z, tolerance);
}

std::uint32_t
rgbOf(const io::LoadedCloud& cloud, std::size_t i)
{
  const auto* field = io::findField(cloud.table, "rgb");
  std::uint32_t packed = 0;
  if (field)
    std::memcpy(&packed, cloud.table.data.data() + i * cloud.table.point_step + field->offset, sizeof(packed));
  return packed;
}

TEST(TextScanner, countsLinesOfEveryKind)
{
  const std::string path = "f";
  io::TextScanner scanner("a\nb\r\nc\rd", path);
  for (const char* line : {"a", "b", "c", "d"}) {
    ASSERT_TRUE(scanner.next());
    EXPECT_EQ(scanner.line(), line);
  }
  EXPECT_THAT(scanner.error("bad").what(), ::testing::StrEq("f:4: bad"));
  EXPECT_FALSE(scanner.next());
}

TEST(TextScanner, numbersDoNotDependOnTheLocale)
{
  EXPECT_EQ(io::parseNumber("+1.5e2"), 150.0);
  EXPECT_EQ(io::parseNumber("-0.25"), -0.25);
  EXPECT_TRUE(std::isnan(*io::parseNumber("NaN")));
  EXPECT_EQ(io::parseNumber("inf"), INFINITY);
  for (const char* wrong : {"", "+", "1.5x", "1,5", "0x10", "--1", "+-1", "1e", "1e999"})
    EXPECT_FALSE(io::parseNumber(wrong)) << wrong;
  const std::string before = std::setlocale(LC_ALL, nullptr);
  if (std::setlocale(LC_ALL, "de_DE.UTF-8")) {
    EXPECT_EQ(io::parseNumber("1.5"), 1.5);
    std::setlocale(LC_ALL, before.c_str());
  }
  EXPECT_EQ(io::parseCount("4000000000"), 4000000000U);
  for (const char* wrong : {"-1", "1.5", "99999999999999999999", "", "x"})
    EXPECT_FALSE(io::parseCount(wrong)) << wrong;
}

TEST(Xyz, plainColumns)
{
  const auto cloud = parse("a.xyz", "# made by hand\n\n1 2 3\n-4.5\t5e-1 , +6\r\nnan 0 0\n");
  ASSERT_EQ(cloud.points->size(), 3U);
  expectPoint(cloud, 0, 1, 2, 3);
  expectPoint(cloud, 1, -4.5, 0.5, 6);
  EXPECT_TRUE(std::isnan((*cloud.points)[2].x));
  EXPECT_FALSE(cloud.points->is_dense);
  EXPECT_FALSE(cloud.has_intensity);
  EXPECT_FALSE(cloud.has_normals);
  EXPECT_FALSE(cloud.viewpoint);
  EXPECT_EQ(cloud.offset, Eigen::Vector3d::Zero());
}

TEST(Xyz, extraColumnsAreToldByTheirValues)
{
  const auto four = parse("a.XYZ", "1 2 3 77\n4 5 6 88\n");
  EXPECT_TRUE(four.has_intensity);
  EXPECT_EQ((*four.points)[1].intensity, 88.0F);
  const auto normals = parse("a.txt", "1 2 3 0 0 1\n4 5 6 0.6 0.8 0\n");
  EXPECT_TRUE(normals.has_normals);
  EXPECT_FLOAT_EQ((*normals.points)[1].normal_y, 0.8F);
  const auto colours = parse("a.txt", "1 2 3 255 128 1\n4 5 6 0 0 0\n");
  EXPECT_FALSE(colours.has_normals);
  EXPECT_EQ(rgbOf(colours, 0), 0xff8001U);
  const auto all = parse("a.asc", "1 2 3 9 255 128 1 0 0 1\n4 5 6 9 0 0 7 0 1 0\n");
  EXPECT_TRUE(all.has_intensity);
  EXPECT_TRUE(all.has_normals);
  EXPECT_EQ(rgbOf(all, 1), 7U);
  const auto unknown = parse("a.txt", "1 2 3 4.5 5.5\n");
  EXPECT_FALSE(unknown.has_intensity);
  EXPECT_TRUE(io::findField(unknown.table, "column_5"));
}

TEST(Xyz, largeCoordinatesKeepMillimetres)
{
  const auto cloud = parse("utm.xyz", "691234.567 5312345.678 412.345\n691235.001 5312344.002 411.003\n9 9 9\n");
  EXPECT_GT(cloud.offset.norm(), 5e6);
  expectPoint(cloud, 0, 691234.567, 5312345.678, 412.345, 1e-4);
  expectPoint(cloud, 1, 691235.001, 5312344.002, 411.003, 1e-4);
}

TEST(Xyz, commasBetweenColumnsAreNotDecimal)
{
  for (const char* text : {"1, 2, 3\n", "1 ,2 ,3\n", "1,2,3 \n", "1.5,2 3.5\n", "1 2 3 255,0,10\n", "1,2 3\n"})
    EXPECT_EQ(io::parseCloud("a.xyz", text).points->size(), 1U) << text;
}

TEST(TextScanner, byteOrderMarkIsSkippedOnce)
{
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(io::parseCloud("a.xyz", mark + "1 2 3\n4 5 6\n").points->size(), 2U);
  EXPECT_EQ(io::parseCloud("a.csv", mark + "x,y,z\n1,2,3\n").points->size(), 1U);
  EXPECT_EQ(io::parseCloud("a.csv", mark + "# x,y,z\n1,2,3\n").points->size(), 1U);
  EXPECT_THAT(errorOf("a.xyz", "1 2 3\n" + mark + "4 5 6\n"), HasSubstr("a.xyz:2: "));
  EXPECT_THAT(errorOf("a.xyz", mark + mark + "1 2 3\n"), HasSubstr("a.xyz:1: "));
  const TemporaryFolder folder;
  io::writeFile(folder.file("T.txt"), io::formatTransform(Eigen::Isometry3d::Identity()));
  io::writeFile(folder.file("T.txt"), mark + io::readFile(folder.file("T.txt")));
  EXPECT_TRUE(io::readTransform(folder.file("T.txt")).isApprox(Eigen::Isometry3d::Identity()));
}

TEST(Xyz, errorsNameFileLineAndValue)
{
  EXPECT_EQ(errorOf("a.xyz", "1 2 3\n1 abc 3\n"), "a.xyz:2: column 2: 'abc' is not a number");
  EXPECT_EQ(errorOf("a.xyz", "1 2 3\n\n1 2\n"), "a.xyz:3: 2 columns, expected 3 as in the first line of points");
  EXPECT_EQ(errorOf("a.xyz", "1 2\n"), "a.xyz:1: 2 columns, at least x, y and z are needed");
  EXPECT_EQ(errorOf("a.xyz", ""), "a.xyz: is empty");
  EXPECT_EQ(errorOf("a.xyz", "# nothing\n"), "a.xyz: holds no points");
  EXPECT_THAT(errorOf("a.xyz", "1,5;2,5;3,5\n"), HasSubstr("decimal commas"));
  EXPECT_THAT(errorOf("a.xyz", "# x y z\n0,72 0,00 -1,25\n"),
              AllOf(HasSubstr("a.xyz:2: "), HasSubstr("decimal commas")));
  EXPECT_THAT(errorOf("a.csv", "x y z i\n0,72\t2\t-1,25\t+3\n"), HasSubstr("a.csv:2: "));
  EXPECT_THAT(errorOf("a.xyz", std::string("\x7f\x45\x4c\x46\0\0\n\0", 8)), HasSubstr("a.xyz:1: neither numbers nor"));
}

TEST(Pts, countComesFirstAndMustBeRight)
{
  const auto cloud = parse("a.pts", "2\n1 2 3 -500 10 20 30\n4 5 6 7 40 50 60\n");
  ASSERT_EQ(cloud.points->size(), 2U);
  EXPECT_EQ((*cloud.points)[0].intensity, -500.0F);
  EXPECT_EQ(rgbOf(cloud, 1), 0x28323cU);
  EXPECT_EQ(parse("a.pts", "1\n1 2 3\n2\n4 5 6\n7 8 9\n").points->size(), 3U);
  EXPECT_EQ(errorOf("a.pts", "4000000000\n1 2 3\n"), "a.pts: declares 4000000000 points, holds 1");
  EXPECT_EQ(errorOf("a.pts", "3\n1 2 3\n4 5 6\n"), "a.pts: declares 3 points, holds 2");
  EXPECT_THAT(errorOf("a.pts", "-5\n1 2 3\n"), HasSubstr("a.pts:1: 1 columns"));
}

TEST(Csv, columnsByName)
{
  const auto cloud = parse("PointCloud0.csv",
                           "\"Time in sec\", x [m], Y, z, Intensities, nx, ny, nz\n"
                           "1300000000.25,1,2,3,0.5,0,0,1\n1300000000.50,4,5,6,0.75,1,0,0\n");
  ASSERT_EQ(cloud.points->size(), 2U);
  expectPoint(cloud, 1, 4, 5, 6);
  EXPECT_EQ((*cloud.points)[1].intensity, 0.75F);
  EXPECT_EQ((*cloud.points)[1].normal_x, 1.0F);
  const auto* time = io::findField(cloud.table, "time_in_sec");
  ASSERT_TRUE(time);
  EXPECT_EQ(time->datatype, pcl::PCLPointField::FLOAT64);
  EXPECT_EQ(io::loadValue(cloud.table.data.data() + cloud.table.point_step + time->offset, time->datatype),
            1300000000.5);
  EXPECT_EQ(parse("a.csv", "1,2,3\n").points->size(), 1U);
  EXPECT_EQ(parse("a.txt", "//X Y Z R G B\n1 2 3 1 2 3\n").points->size(), 1U);
}

TEST(Csv, equalNamesAreMadeDistinctAndThousandsOfThemTakeNoTime)
{
  const auto cloud = parse("f.csv", "x,y,z,a,a,a_2,a\n1,2,3,4,5,6,7\n");
  for (const char* name : {"a", "a_2", "a_2_2", "a_3"})
    EXPECT_TRUE(io::findField(cloud.table, name)) << name;
  const std::clock_t start = std::clock();
  EXPECT_THROW(parse("f.csv", "t" + std::string(100000, ';') + "\n1;2;3\n"), io::IoError);
  EXPECT_LT(std::clock() - start, 5 * CLOCKS_PER_SEC); // hours, where each name is compared with all before
}

TEST(Csv, errors)
{
  EXPECT_EQ(errorOf("a.csv", "time,x,y\n1,2,3\n"),
            "a.csv:1: neither numbers nor a line of column names with 'z': 'time,x,y'");
  EXPECT_EQ(errorOf("a.csv", "x,y,z\n1,2,3,4\n"), "a.csv:2: 4 columns, but there are 3 names");
  EXPECT_EQ(errorOf("a.csv", "x,y,z\n1,,3\n"), "a.csv:2: 2 columns, but there are 3 names");
  EXPECT_EQ(errorOf("a.csv", "x,y,z\n1,2,three\n"), "a.csv:2: column 3: 'three' is not a number");
  EXPECT_EQ(errorOf("a.csv", "x,y,z\n"), "a.csv: holds no points");
}

const char* const kPtx = "2\n2\n10 20 30\n0 -1 0\n1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n"
                         "1 0 0 0.5 255 0 0\n0 0 0 0.5 0 0 0\n0 2 0 0.25 0 255 0\n0 0 3 1 0 0 255\n";

TEST(Ptx, poseIsApplied)
{
  const auto cloud = parse("a.ptx", kPtx);
  ASSERT_EQ(cloud.points->size(), 3U); // one without a return
  expectPoint(cloud, 0, 10, 21, 30);
  expectPoint(cloud, 1, 8, 20, 30);
  expectPoint(cloud, 2, 10, 20, 33);
  EXPECT_TRUE(cloud.has_intensity);
  EXPECT_EQ(rgbOf(cloud, 2), 0x0000ffU);
  ASSERT_TRUE(cloud.viewpoint);
  EXPECT_EQ(*cloud.viewpoint, Eigen::Vector3d(10, 20, 30));
  const auto two = parse("a.ptx", std::string(kPtx) + kPtx);
  EXPECT_EQ(two.points->size(), 6U);
  EXPECT_FALSE(two.viewpoint);
}

TEST(Ptx, errors)
{
  const std::string good = kPtx;
  const auto replaced = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_EQ(errorOf("a.ptx", replaced("2\n2\n", "-2\n2\n")), "a.ptx:1: number of columns: '-2' is not a count");
  EXPECT_THAT(errorOf("a.ptx", replaced("2\n2\n", "60000\n60000\n")), HasSubstr("a.ptx:10: 60000 columns of 60000"));
  EXPECT_THAT(errorOf("a.ptx", replaced("2\n2\n", "4294967295\n4294967295\n")), HasSubstr("do not fit"));
  EXPECT_EQ(errorOf("a.ptx", replaced("0 2 0 0.25", "0 two 0 0.25")), "a.ptx:13: column 2: 'two' is not a number");
  EXPECT_EQ(errorOf("a.ptx", replaced("10 20 30 1", "10 20 30 2")), "a.ptx:10: the transform is not a rigid motion");
  EXPECT_EQ(errorOf("a.ptx", replaced("\n0 1 0 0\n", "\n0 nan 0 0\n")),
            "a.ptx:10: the transform is not a rigid motion");
  EXPECT_THAT(errorOf("a.ptx", good.substr(0, good.size() - 40)), HasSubstr("a.ptx:1"));
  EXPECT_THAT(errorOf("a.ptx", "2\n"), HasSubstr("ends before the number of rows"));
}

TEST(Threedtk, metresAndRightHanded)
{
  const auto cloud = parse("scan000.3d", "100 200 300\n-50 0 25\n");
  ASSERT_EQ(cloud.points->size(), 2U);
  expectPoint(cloud, 0, 3, -1, 2);
  expectPoint(cloud, 1, 0.25, 0.5, 0);
  EXPECT_EQ(parse("a.3d", "361 x 245\n1 2 3\n").points->size(), 1U);
  EXPECT_EQ(parse("a.3d", "3\n1 2 3 7\n").has_intensity, true);
  EXPECT_EQ(errorOf("a.3d", "1 2 3\n1 2 z\n"), "a.3d:2: column 3: 'z' is not a number");
  EXPECT_THAT(errorOf("a.3d", "1 2 3\n1 2\n"), HasSubstr("a.3d:2: 2 values"));
  EXPECT_EQ(errorOf("a.3d", "5\n"), "a.3d: holds no points");
}

TEST(TextFormats, mutationsNeverCrash)
{
  std::string table = "x,y,z,intensity\n";
  std::string pts = "40\n";
  std::string threedtk = "40\n";
  for (int i = 0; i < 40; ++i) {
    const std::string row = std::to_string(i * 0.25) + "," + std::to_string(-i) + "," + std::to_string(1e3 / (i + 1));
    table += row + "," + std::to_string(i) + "\n";
    pts += row + ",5,1,2,3\n";
    threedtk += row + "\n";
  }
  fuzz("a.csv", table, kFuzzRounds);
  fuzz("a.pts", pts, kFuzzRounds);
  fuzz("a.3d", threedtk, kFuzzRounds);
  fuzz("a.ptx", kPtx, kFuzzRounds);
}

TEST(TextFormats, columnsAreBounded)
{
  const std::string many(1000, ',');
  EXPECT_EQ(errorOf("a.csv", "x,y,z" + many + "\n1,2,3\n"), "a.csv:1: more than 1000 names of columns");
  EXPECT_EQ(parse("a.csv", "# x y z" + many + "\n1,2,3\n").points->size(), 1U) << "a remark";
  std::string row = "1";
  for (int i = 0; i < 1000; ++i)
    row += " 1";
  EXPECT_THAT(errorOf("a.xyz", row + "\n"), HasSubstr("1001 columns, at most 1000"));
}

TEST(TextScanner, readsBlockByBlockWhatItReadsAtOnce)
{
  std::mt19937 random(11);
  const std::string path = "a.xyz";
  for (int trial = 0; trial < 300; ++trial) {
    std::string text;
    const std::size_t length = random() % 40;
    while (text.size() < length)
      text += "ab1 \n\n\r\r#"[random() % 9];
    io::TextScanner whole(text, path);
    std::vector<std::string> lines;
    std::vector<std::uint64_t> left;
    while (whole.next()) {
      lines.emplace_back(whole.line());
      left.push_back(whole.left());
    }
    const io::MemoryBytes source(text);
    for (const std::size_t block : {1U, 2U, 3U, 7U, 64U}) {
      io::TextScanner scanner(source, path, block);
      for (std::size_t i = 0; i < lines.size(); ++i) {
        ASSERT_TRUE(scanner.next());
        EXPECT_EQ(scanner.line(), lines[i]);
        EXPECT_EQ(scanner.left(), left[i]);
        EXPECT_STREQ(scanner.error("x").what(), (path + ":" + std::to_string(i + 1) + ": x").c_str());
      }
      EXPECT_FALSE(scanner.next());
    }
  }
}

TEST(TextFormats, inLittleMemoryTheyHaveTheSamePoints)
{
  // Several blocks of every kind of table; normals and colours are recognised in columns without names.
  std::string plain, normals, no_normals, colours_first, named, ply, ptx;
  constexpr int kRows = 12000;
  for (int i = 0; i < kRows; ++i) {
    const std::string xyz = std::to_string(i) + ".25 " + std::to_string(i % 7) + " -3.5";
    plain += xyz + "\r\n";
    normals += xyz + " 17 0 0.6 0.8\n";
    no_normals += xyz + (i + 1 < kRows ? " 0 0.6 0.8\n" : " 0 0.6 0.9\n");
    colours_first += xyz + " 255 0 7 0 0 -1\n";
    named += "0.8," + std::to_string(i) + ",5,1,1e9,0.6,0\n";
    ply += xyz + " 0 0.6 0.8 44\n";
    ptx += xyz + " 0.5 1 2 3\n";
  }
  named = "normal_z,x,y,z,time,normal_x,normal_y\n" + named;
  ply = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(kRows) +
        "\nproperty double x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
        "property float nz\nproperty uchar red\nend_header\n" +
        ply;
  // On a map: the digits hold millimetres, the type that is declared does not.
  const std::string map = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                          "property float z\nend_header\n4567890.123 512345.678 12.3\n4567891.456 512344.321 12.5\n";
  ptx = std::to_string(kRows) + "\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n9 8 7 1\n" + ptx;
  const std::string pcd = "VERSION .7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n"
                          "COUNT 1 1 1 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n"
                          "1 2 3 0 0.6 0.8\n4 5 6 0 0 1\n7 8 9 1 0 0";
  struct Case {
    const char* name;
    const std::string& bytes;
    bool has_normals;
    std::size_t points;
  };
  for (const Case& c : {Case{"a.xyz", plain, false, kRows},
                        Case{"a.pts", normals, true, kRows},
                        Case{"a.txt", no_normals, false, kRows},
                        Case{"a.asc", colours_first, true, kRows},
                        Case{"a.csv", named, true, kRows},
                        Case{"a.ply", ply, true, kRows},
                        Case{"map.ply", map, false, 2},
                        Case{"a.ptx", ptx, false, kRows},
                        Case{"a.pcd", pcd, true, 3}}) {
    const io::ScanPoints points = io::parseScanPoints(c.name, c.bytes);
    EXPECT_EQ(points.size, c.points) << c.name;
    EXPECT_EQ(points.has_normals, c.has_normals) << c.name;
    EXPECT_NO_THROW(testing::requireSamePoints(c.name, io::parseCloud(c.name, c.bytes), points));
  }
}

/// While it lives, no more than this can be allocated besides what is; with AddressSanitizer, which reserves terabytes,
/// there is no limit.
class MemoryLimit {
public:
  explicit MemoryLimit([[maybe_unused]] std::size_t bytes)
  {
    getrlimit(RLIMIT_AS, &before_);
#ifndef __SANITIZE_ADDRESS__
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = before_;
    limit.rlim_cur = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + bytes;
    setrlimit(RLIMIT_AS, &limit);
#endif
  }
  ~MemoryLimit()
  {
    setrlimit(RLIMIT_AS, &before_);
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit&
  operator=(const MemoryLimit&) = delete;

private:
  rlimit before_{};
};

// What was found once, by libFuzzer (scripts/fuzz begins with these as well) or by reading: each loads or is refused in
// one line, in a moment and in little memory.
TEST(Files, findingsStayMended)
{
  const MemoryLimit limit(std::size_t{64} << 20);
  const std::clock_t start = std::clock();
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(PCL_SSFR_FUZZ_FINDINGS)) {
    if (!entry.is_regular_file())
      continue;
    ++files;
    const std::string reader = entry.path().parent_path().filename().string();
    EXPECT_NO_THROW(testing::readAnyBytes("a." + reader, io::readFile(entry.path().string()))) << entry.path();
  }
  EXPECT_GE(files, 2);
  EXPECT_LT(std::clock() - start, 8 * CLOCKS_PER_SEC); // 17 s for the one with thousands of equal names
}

TEST(Files, whatCannotBeReadIsNamed)
{
  const TemporaryFolder folder;
  const auto error = [](const std::string& path) -> std::string {
    try {
      io::loadCloud(path);
    }
    catch (const io::IoError& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_EQ(error(folder.file("none.pcd")), folder.file("none.pcd") + ": no such file");
  std::filesystem::create_directory(folder.file("folder.pcd"));
  EXPECT_EQ(error(folder.file("folder.pcd")), folder.file("folder.pcd") + ": is a directory");
  EXPECT_THAT(error("/dev/null.pcd"), HasSubstr("/dev/null.pcd: "));
  EXPECT_THAT(error(folder.file("a.docx")), AllOf(HasSubstr("a.docx: unknown format"), HasSubstr(".pcd .ply")));
  EXPECT_THAT(error(folder.file("noextension")), HasSubstr("unknown format"));
  io::writeFile(folder.file("empty.ply"), "");
  EXPECT_EQ(error(folder.file("empty.ply")), folder.file("empty.ply") + ": is empty");
  EXPECT_THROW(io::writeFile(folder.file("no/such/folder.pcd"), "x"), io::IoError);
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_THROW(io::writeFile("/dev/full", std::string(100000, 'x')), io::IoError);
  }
}

TEST(Files, areCompleteOrAsTheyWere)
{
  const TemporaryFolder folder;
  const auto names = [&folder] {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder.file("")))
      found.push_back(entry.path().filename().string());
    std::sort(found.begin(), found.end());
    return found;
  };
  const std::string path = folder.file("a.txt");
  io::writeFile(path, "first");
  std::filesystem::permissions(path, std::filesystem::perms(0640));
  {
    io::OutputFile file(path);
    file.write("half of the sec");
    EXPECT_EQ(names().size(), 2U) << "it is written next to it";
  }
  EXPECT_EQ(io::readFile(path), "first");
  EXPECT_THAT(names(), ElementsAre("a.txt"));
  std::filesystem::create_symlink("a.txt", folder.file("link.txt"));
  io::writeFile(folder.file("link.txt"), "second");
  EXPECT_TRUE(std::filesystem::is_symlink(folder.file("link.txt")));
  EXPECT_EQ(io::readFile(path), "second");
  EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms(0640));
  EXPECT_THAT(names(), ElementsAre("a.txt", "link.txt"));
  // As on a disk that gets full: the system cuts files at a size.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(io::writeFile(path, std::string(100000, 'x')), io::IoError);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_DFL);
  EXPECT_EQ(io::readFile(path), "second");
  EXPECT_THAT(names(), ElementsAre("a.txt", "link.txt"));
}

TEST(Files, identityIsThatOfTheFile)
{
  const TemporaryFolder folder;
  const std::string path = folder.file("a.txt");
  EXPECT_EQ(io::fileIdentity(path), io::fileIdentity(folder.file("./a.txt"))) << "it is not there yet";
  EXPECT_NE(io::fileIdentity(path), io::fileIdentity(folder.file("b.txt")));
  io::writeFile(path, "a");
  std::filesystem::create_hard_link(path, folder.file("hard.txt"));
  std::filesystem::create_symlink(path, folder.file("soft.txt"));
  io::writeFile(folder.file("b.txt"), "a");
  EXPECT_EQ(io::fileIdentity(path), io::fileIdentity(folder.file("hard.txt")));
  EXPECT_EQ(io::fileIdentity(path), io::fileIdentity(folder.file("soft.txt")));
  EXPECT_NE(io::fileIdentity(path), io::fileIdentity(folder.file("b.txt")));
  EXPECT_EQ(io::fileIdentity("/dev/null"), "");
}

TEST(Transforms, readBackToTheSameBits)
{
  const TemporaryFolder folder;
  Eigen::Isometry3d T =
      Eigen::Translation3d(1e6 + 0.1, -2.0 / 3, 3) * Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized());
  io::writeFile(folder.file("T.txt"), io::formatTransform(T));
  EXPECT_EQ(io::readTransform(folder.file("T.txt")).matrix(), T.matrix());
}

TEST(Transforms, onlyRigidMotions)
{
  const TemporaryFolder folder;
  const auto error = [&folder](const std::string& text) -> std::string {
    io::writeFile(folder.file("T.txt"), text);
    try {
      io::readTransform(folder.file("T.txt"));
    }
    catch (const io::IoError& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_EQ(error("1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"), "");
  EXPECT_EQ(error("0.707,-0.707,0,1\n0.707,0.707,0,2\n0,0,1,3\n0,0,0,1\n"), ""); // written with few digits
  EXPECT_LT((io::readTransform(folder.file("T.txt")).linear().determinant() - 1), 1e-12);
  EXPECT_THAT(error("2 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"), HasSubstr("not a rigid motion"));
  EXPECT_THAT(error("-1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"), HasSubstr("not a rigid motion"));
  EXPECT_THAT(error("1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 1 1\n"), HasSubstr("not a rigid motion"));
  EXPECT_THAT(error("1 0 0 nan\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"), HasSubstr("not finite"));
  EXPECT_THAT(error("1 0 0\n"), HasSubstr("found 3"));
  EXPECT_THAT(error("1 0 0 1\n0 one 0 2\n"), HasSubstr("T.txt:2: column 2: 'one' is not a number"));
}

} // namespace
} // namespace pcl_ssfr::test_io_text
