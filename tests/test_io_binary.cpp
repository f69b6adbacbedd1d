// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <las_files.h>

#include <gmock/gmock.h>

#include <cmath>

namespace pcl_ssfr::test_io_binary {
namespace {

using testing::bytesOf;
using testing::errorOf;
using testing::fuzz;
using ::testing::HasSubstr;
using testing::makeLas;
using testing::put;

constexpr int kFuzzRounds = 4000;

std::string
kittiPoint(float x, float y, float z, float intensity)
{
  return bytesOf(x) + bytesOf(y) + bytesOf(z) + bytesOf(intensity);
}

TEST(Kitti, pointsAndIntensity)
{
  const auto cloud = io::parseCloud("000000.bin", kittiPoint(1, 2, 3, 0.5F) + kittiPoint(NAN, 5, 6, 1));
  ASSERT_EQ(cloud.points->size(), 2U);
  EXPECT_EQ((*cloud.points)[0].z, 3.0F);
  EXPECT_EQ((*cloud.points)[0].intensity, 0.5F);
  EXPECT_TRUE(std::isnan((*cloud.points)[1].x));
  EXPECT_FALSE(cloud.points->is_dense);
}

TEST(Kitti, errors)
{
  EXPECT_THAT(errorOf("a.bin", kittiPoint(1, 2, 3, 4).substr(1)), HasSubstr("a.bin: 15 bytes"));
  EXPECT_THAT(errorOf("a.bin", "1 2 3 4\n5 6 7 8\n"), HasSubstr("a.bin: is a text"));
  EXPECT_THAT(errorOf("a.bin", kittiPoint(1, 2, 3, 4) + kittiPoint(0, -1e30F, 0, 0)), HasSubstr("point 1 has y ="));
  EXPECT_EQ(errorOf("a.bin", ""), "a.bin: is empty");
}

TEST(Las, everyPointFormat)
{
  struct Case {
    unsigned minor;
    unsigned format;
    std::uint16_t record;
  };
  const Case cases[] = {{2, 0, 20},
                        {2, 1, 28},
                        {2, 2, 26},
                        {2, 3, 34},
                        {3, 4, 57},
                        {3, 5, 63},
                        {4, 6, 30},
                        {4, 7, 36},
                        {4, 8, 38},
                        {4, 9, 59},
                        {4, 10, 67},
                        {2, 1, 40}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.format);
    const auto cloud = io::parseCloud("a.LAS", makeLas(c.minor, c.format, c.record, 3));
    ASSERT_EQ(cloud.points->size(), 3U);
    EXPECT_FLOAT_EQ((*cloud.points)[2].x, 2.001F);
    EXPECT_FLOAT_EQ((*cloud.points)[2].y, -2);
    EXPECT_FLOAT_EQ((*cloud.points)[2].z, 0.5);
    EXPECT_EQ((*cloud.points)[2].intensity, 40000.0F);
    const auto value = [&cloud](const char* name) {
      const auto* field = io::findField(cloud.table, name);
      return field ? io::loadValue(cloud.table.data.data() + field->offset, field->datatype) : -1;
    };
    EXPECT_EQ(value("classification"), 6);
    EXPECT_EQ(value("gps_time"), c.format == 0 || c.format == 2 ? -1 : 1234.5);
    const bool coloured =
        c.format == 2 || c.format == 3 || c.format == 5 || c.format == 7 || c.format == 8 || c.format == 10;
    const auto* rgb = io::findField(cloud.table, "rgb");
    ASSERT_EQ(rgb != nullptr, coloured);
    if (rgb) {
      std::uint32_t packed = 0;
      std::memcpy(&packed, cloud.table.data.data() + rgb->offset, sizeof(packed));
      EXPECT_EQ(packed, 0x010203U);
    }
  }
}

TEST(Las, mapCoordinatesKeepMillimetres)
{
  const auto cloud = io::parseCloud("a.las", makeLas(2, 0, 20, 3, 5e6));
  EXPECT_GT(cloud.offset.minCoeff(), 4.9e6);
  EXPECT_NEAR((*cloud.points)[2].x + cloud.offset.x(), 5e6 + 2.001, 1e-5);
}

TEST(Las, errors)
{
  const std::string good = makeLas(2, 0, 20, 3);
  const auto with = [&good](std::size_t at, auto value) {
    std::string bytes = good;
    put(bytes, at, value);
    return bytes;
  };
  EXPECT_THAT(errorOf("a.las", with(0, 'X')), HasSubstr("it starts with 'XASF'"));
  EXPECT_THAT(errorOf("a.las", good.substr(0, 100)), HasSubstr("the LAS header ends after 100 bytes"));
  EXPECT_THAT(errorOf("a.las", with(25, std::uint8_t{9})), HasSubstr("version 1.9"));
  EXPECT_THAT(errorOf("a.las", with(104, std::uint8_t{128})), HasSubstr("(LAZ), which is not read: 'pdal translate"));
  EXPECT_THAT(errorOf("a.las", with(104, std::uint8_t{11})), HasSubstr("point format 11"));
  EXPECT_THAT(errorOf("a.las", with(105, std::uint16_t{0})), HasSubstr("record length 0"));
  EXPECT_THAT(errorOf("a.las", with(107, std::uint32_t{4000000000U})), HasSubstr("4000000000"));
  EXPECT_THAT(errorOf("a.las", with(96, std::uint32_t{0xffffffffU})), HasSubstr("offset to point data"));
  EXPECT_THAT(errorOf("a.las", with(131, 0.0)), HasSubstr("scale"));
  EXPECT_THAT(errorOf("a.las", with(155, double{NAN})), HasSubstr("of x"));
  EXPECT_THAT(errorOf("a.las", good.substr(0, good.size() - 1)), HasSubstr("number of point records 3"));
  std::string huge = makeLas(4, 6, 30, 3);
  put(huge, 247, std::uint64_t{0xffffffffffffffffU});
  EXPECT_THAT(errorOf("a.las", huge), HasSubstr("do not fit"));
}

std::string
pcdHeader(const std::string& points, const std::string& data, const std::string& more = "")
{
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z _ ring\nSIZE 4 8 4 1 2\nTYPE F F F U U\nCOUNT 1 1 1 3 1\n" + more +
         "WIDTH " + points + "\nHEIGHT 1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

TEST(Pcd, mixedTypesAndPadding)
{
  // y is a double among floats: allowed; padding of 3 bytes is dropped, ring kept.
  std::string bytes = pcdHeader("2", "binary");
  for (int i = 0; i < 2; ++i)
    bytes += bytesOf(1.5F) + bytesOf(2.5) + bytesOf(3.5F) + "abc" + bytesOf(static_cast<std::uint16_t>(7 + i));
  const auto cloud = io::parseCloud("a.pcd", bytes);
  ASSERT_EQ(cloud.points->size(), 2U);
  EXPECT_EQ((*cloud.points)[1].y, 2.5F);
  ASSERT_TRUE(cloud.viewpoint);
  EXPECT_EQ(*cloud.viewpoint, Eigen::Vector3d(1, 2, 3));
  const auto* ring = io::findField(cloud.table, "ring");
  ASSERT_TRUE(ring);
  EXPECT_EQ(io::loadValue(cloud.table.data.data() + cloud.table.point_step + ring->offset, ring->datatype), 8);
  EXPECT_FALSE(io::findField(cloud.table, "_"));
}

TEST(Pcd, ascii)
{
  const auto cloud = io::parseCloud("a.pcd", pcdHeader("2", "ascii") + "1 2 3 0 0 0 9\nnan nan nan 0 0 0 4");
  ASSERT_EQ(cloud.points->size(), 2U);
  EXPECT_EQ((*cloud.points)[0].z, 3.0F);
  EXPECT_TRUE(std::isnan((*cloud.points)[1].x));
  EXPECT_EQ(errorOf("a.pcd", pcdHeader("2", "ascii") + "1 2 3 0 0 0 9\n1 2 3 0 zero 0 9\n"),
            "a.pcd:13: column 5: 'zero' is not a number");
  EXPECT_EQ(errorOf("a.pcd", pcdHeader("2", "ascii") + "1 2 3 0 0 0 9\n1 2 3 0 0 0    \n"),
            "a.pcd:13: 6 values, expected 7");
}

TEST(Pcd, hostileHeaders)
{
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("4000000000", "binary") + "xyz"),
              HasSubstr("a.pcd:11: POINTS 4000000000 of 21 bytes"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("4000000000", "ascii") + "1 2 3"), HasSubstr("POINTS 4000000000"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("-1", "binary")), HasSubstr("WIDTH: '-1' is not a count"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("ten", "binary")), HasSubstr("a.pcd:7: WIDTH: 'ten'"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary") + "short"), HasSubstr("do not fit into the 5 bytes"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "zip")), HasSubstr("DATA: 'zip'"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary", "SIZE 4 8 4 1 -2\n")), HasSubstr("SIZE: '-2' is not a count"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary", "SIZE 4 8 4 1 3\n")),
              HasSubstr("'ring' has TYPE U and SIZE 3"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary", "COUNT 1 1 1 4000000000 1\n")), HasSubstr("COUNT 4000000000"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary", "TYPE I I F U U\n")),
              HasSubstr("x, y and z of TYPE F are needed"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary", "SIZE 4 8\n")), HasSubstr("SIZE has 2 values, expected 5"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary_compressed") + bytesOf(4U) + bytesOf(4000000000U) + "abcd"),
              HasSubstr("compressed data give 4000000000 bytes"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary_compressed") + bytesOf(4000000000U) + bytesOf(42U) + "abcd"),
              HasSubstr("do not fit"));
  EXPECT_THAT(errorOf("a.pcd", pcdHeader("2", "binary_compressed") + bytesOf(4U) + bytesOf(42U) + "abcd"),
              HasSubstr("damaged"));
  EXPECT_THAT(errorOf("a.pcd", "ply\nformat ascii 1.0\n"), HasSubstr("a.pcd:1: 'ply' is not a line of a PCD header"));
  EXPECT_THAT(errorOf("a.pcd", "FIELDS x y z\n"), HasSubstr("ends before its DATA line"));
  EXPECT_THAT(errorOf("a.pcd", "FIELDS x y\nWIDTH 1\nDATA ascii\n1 2\n"), HasSubstr("fields x, y and z"));
}

TEST(Pcd, noPointsIsAnEmptyCloud)
{
  EXPECT_EQ(io::parseCloud("a.pcd", pcdHeader("0", "binary")).points->size(), 0U);
  EXPECT_EQ(io::parseCloud("a.pcd", pcdHeader("0", "ascii")).points->size(), 0U);
}

TEST(Pcd, headersOfAnyLengthAreReadInPieces)
{
  // Comments so long that each byte of the end of the header is the last one of a piece once.
  const std::string end = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ";
  const std::string point = bytesOf(1.0F) + bytesOf(-2.0F) + bytesOf(3.0F);
  const std::string packed = bytesOf(13U) + bytesOf(12U) + '\13' + point;
  for (const std::size_t piece : {std::size_t{1} << 14, std::size_t{1} << 18})
    for (std::size_t length = piece - end.size() - 30; length < piece + 2; ++length) {
      const std::string comment = "#" + std::string(length - 2, 'c') + "\n";
      for (const std::string& data :
           {"binary\n" + point, std::string("ascii\n1 -2 3\n"), "binary_compressed\n" + packed}) {
        const auto cloud = io::parseCloud("a.pcd", comment + end + data);
        ASSERT_EQ(cloud.points->size(), 1U) << length;
        ASSERT_EQ((*cloud.points)[0].y, -2) << length;
      }
    }
}

TEST(ScanPoints, takeTwelveBytesAPoint)
{
  constexpr std::uint32_t kPoints = 9500; // several blocks; from 10 km on coordinates are double
  std::string pcd = pcdHeader(std::to_string(kPoints), "binary");
  pcd.replace(pcd.find("SIZE 4 8"), 8, "SIZE 4 4");
  pcd.replace(pcd.find("COUNT 1 1 1 3"), 13, "COUNT 1 1 1 30");
  for (std::uint32_t i = 0; i < kPoints; ++i)
    pcd += bytesOf(static_cast<float>(i)) + bytesOf(2.5F) + bytesOf(3.5F) + std::string(30, 'c') +
           bytesOf(std::uint16_t{7});
  // Lists of many lengths before the vertices, so that blocks begin anywhere.
  std::string ply = "ply\nformat binary_little_endian 1.0\nelement face 3000\nproperty list uchar int corners\n"
                    "element vertex " +
                    std::to_string(kPoints) +
                    "\nproperty uchar red\nproperty float z\nproperty float x\nproperty double time\n"
                    "property float y\nend_header\n";
  for (int i = 0; i < 3000; ++i)
    ply += static_cast<char>(i % 50) + std::string(static_cast<std::size_t>(4 * (i % 50)), 'l');
  for (std::uint32_t i = 0; i < kPoints; ++i)
    ply += 'r' + bytesOf(3.5F) + bytesOf(static_cast<float>(i)) + bytesOf(1e9 + i) + bytesOf(2.5F);
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>("a.pcd", pcd),
                                    std::pair<std::string, std::string>("a.ply", ply),
                                    std::pair<std::string, std::string>("a.las", makeLas(4, 10, 67, kPoints))}) {
    const io::ScanPoints points = io::parseScanPoints(name, bytes);
    ASSERT_EQ(points.size, kPoints) << name;
    EXPECT_EQ(points.bytes.capacity(), 12 * kPoints) << name;
    testing::requireSamePoints(name, io::parseCloud(name, bytes), points);
  }
  const auto cloud = io::parseCloud("a.ply", ply);
  EXPECT_EQ((*cloud.points)[kPoints - 1].x, kPoints - 1);
  EXPECT_EQ((*cloud.points)[kPoints - 1].y, 2.5F);
  // Map coordinates are relative to their offset here, too.
  const std::string far = makeLas(2, 3, 34, 100, 5e6);
  const io::ScanPoints points = io::parseScanPoints("a.las", far);
  EXPECT_GT(points.offset.norm(), 5e6);
  testing::requireSamePoints("a.las", io::parseCloud("a.las", far), points);
  EXPECT_EQ(io::parseScanPoints("a.pcd", pcdHeader("0", "binary")).size, 0U);
  EXPECT_THROW(io::parseScanPoints("a.pcd", ""), io::IoError);
}

TEST(BinaryFormats, mutationsNeverCrash)
{
  std::string kitti;
  std::string pcd = pcdHeader("20", "binary");
  std::string ascii = pcdHeader("20", "ascii");
  for (int i = 0; i < 20; ++i) {
    kitti += kittiPoint(static_cast<float>(i), 1, 2, 3);
    pcd += bytesOf(1.5F) + bytesOf(2.5) + bytesOf(3.5F) + "abc" + bytesOf(static_cast<std::uint16_t>(i));
    ascii += std::to_string(i) + " 1.5 -2e3 0 0 0 3\n";
  }
  fuzz("a.bin", kitti, kFuzzRounds);
  fuzz("a.pcd", pcd, kFuzzRounds);
  fuzz("a.pcd", ascii, kFuzzRounds);
  fuzz("a.las", makeLas(2, 3, 34, 20), kFuzzRounds);
  fuzz("a.las", makeLas(4, 7, 36, 20, 5e6), kFuzzRounds);
}

} // namespace
} // namespace pcl_ssfr::test_io_binary
