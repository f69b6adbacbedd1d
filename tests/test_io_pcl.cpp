// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Our PCD and PLY against PCL's own: what PCL writes we read, what we write PCL reads.

#include <apps/io/file_bytes.h>

#include <io_testing.h>

#include <gmock/gmock.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <cmath>

namespace pcl_ssfr::test_io_pcl {
namespace {

using testing::errorOf;
using testing::fuzz;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

constexpr int kFuzzRounds = 4000;

/// Points with colour and normal on a helix.
pcl::PointCloud<pcl::PointXYZRGBNormal>
makeCloud(int points)
{
  pcl::PointCloud<pcl::PointXYZRGBNormal> cloud;
  for (int i = 0; i < points; ++i) {
    const float a = 0.1F * static_cast<float>(i);
    pcl::PointXYZRGBNormal point;
    point.getVector3fMap() << std::cos(a), std::sin(a), a;
    point.getNormalVector3fMap() << -std::sin(a), std::cos(a), 0;
    point.r = static_cast<std::uint8_t>(i);
    point.g = 200;
    point.b = 10;
    point.curvature = a;
    cloud.push_back(point);
  }
  return cloud;
}

void
expectSame(const io::LoadedCloud& ours, const pcl::PointCloud<pcl::PointXYZRGBNormal>& truth, float tolerance)
{
  ASSERT_EQ(ours.points->size(), truth.size());
  EXPECT_TRUE(ours.has_normals);
  EXPECT_FALSE(ours.has_intensity);
  const auto* rgb = io::findField(ours.table, "rgb");
  ASSERT_TRUE(rgb);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_LE(((*ours.points)[i].getVector3fMap() - truth[i].getVector3fMap()).norm(), tolerance) << i;
    ASSERT_LE(((*ours.points)[i].getNormalVector3fMap() - truth[i].getNormalVector3fMap()).norm(), tolerance) << i;
    std::uint32_t packed = 0;
    std::memcpy(&packed, ours.table.data.data() + i * ours.table.point_step + rgb->offset, sizeof(packed));
    ASSERT_EQ(packed & 0xffffffU, truth[i].rgba & 0xffffffU) << i;
  }
}

TEST(PcdParity, weReadWhatPclWrites)
{
  const TemporaryFolder folder;
  const auto cloud = makeCloud(500);
  pcl::PCDWriter writer;
  ASSERT_EQ(writer.writeBinary(folder.file("b.pcd"), cloud), 0);
  ASSERT_EQ(writer.writeBinaryCompressed(folder.file("c.pcd"), cloud), 0);
  ASSERT_EQ(writer.writeASCII(folder.file("a.pcd"), cloud, 9), 0);
  expectSame(io::loadCloud(folder.file("b.pcd")), cloud, 0);
  expectSame(io::loadCloud(folder.file("c.pcd")), cloud, 0);
  expectSame(io::loadCloud(folder.file("a.pcd")), cloud, 1e-6F);
}

TEST(PlyParity, weReadWhatPclWrites)
{
  const TemporaryFolder folder;
  const auto cloud = makeCloud(500);
  pcl::PLYWriter writer;
  ASSERT_EQ(writer.write(folder.file("b.ply"), cloud, true), 0);
  ASSERT_EQ(writer.write(folder.file("a.ply"), cloud, false), 0);
  expectSame(io::loadCloud(folder.file("b.ply")), cloud, 0);
  expectSame(io::loadCloud(folder.file("a.ply")), cloud, 1e-5F);
}

TEST(MovedCloud, pclReadsWhatWeWrite)
{
  const TemporaryFolder folder;
  const auto cloud = makeCloud(300);
  pcl::PCDWriter().writeBinary(folder.file("in.pcd"), cloud);
  const auto loaded = io::loadCloud(folder.file("in.pcd"));
  const Eigen::Isometry3d T =
      Eigen::Translation3d(1, -2, 3) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized());
  for (const char* name : {"out.pcd", "out.PLY"}) {
    SCOPED_TRACE(name);
    io::saveMovedCloud(folder.file(name), loaded, T);
    pcl::PointCloud<pcl::PointXYZRGBNormal> back;
    if (std::string(name) == "out.pcd")
      ASSERT_EQ(pcl::io::loadPCDFile(folder.file(name), back), 0);
    else
      ASSERT_EQ(pcl::io::loadPLYFile(folder.file(name), back), 0);
    ASSERT_EQ(back.size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d point = T * cloud[i].getVector3fMap().cast<double>();
      const Eigen::Vector3d normal = T.linear() * cloud[i].getNormalVector3fMap().cast<double>();
      ASSERT_LT((back[i].getVector3fMap().cast<double>() - point).norm(), 1e-5) << i;
      ASSERT_LT((back[i].getNormalVector3fMap().cast<double>() - normal).norm(), 1e-5) << i;
      ASSERT_EQ(back[i].rgba & 0xffffffU, cloud[i].rgba & 0xffffffU) << i;
      ASSERT_EQ(back[i].curvature, cloud[i].curvature) << i;
    }
  }
  EXPECT_NE(pcl::PCDReader().readHeader(folder.file("out.pcd"), *std::make_unique<pcl::PCLPointCloud2>()), -1);
}

TEST(MovedCloud, keepsMillimetresFarFromTheOrigin)
{
  const TemporaryFolder folder;
  io::writeFile(folder.file("near.xyz"), "1.234 2.345 3.456 7\n2 3 4 8\nnan nan nan 9\n");
  const auto near = io::loadCloud(folder.file("near.xyz"));
  const Eigen::Isometry3d T(Eigen::Translation3d(691234.001, 5312345.002, 400.003));
  io::saveMovedCloud(folder.file("far.pcd"), near, T);
  const auto far = io::loadCloud(folder.file("far.pcd"));
  ASSERT_EQ(far.points->size(), 3U);
  EXPECT_EQ(far.table.fields[0].datatype, pcl::PCLPointField::FLOAT64);
  EXPECT_NEAR((*far.points)[0].y + far.offset.y(), 5312347.347, 2e-6 + 1e-4);
  EXPECT_EQ((*far.points)[1].intensity, 8.0F);
  EXPECT_TRUE(std::isnan((*far.points)[2].x));
  // Where the sensor was moves along.
  ASSERT_TRUE(far.viewpoint);
  EXPECT_LT((*far.viewpoint - T.translation()).norm(), 1e-6);
  // And back again, through PLY.
  io::saveMovedCloud(folder.file("far.ply"), far, Eigen::Isometry3d::Identity());
  const auto ply = io::loadCloud(folder.file("far.ply"));
  io::saveMovedCloud(folder.file("back.pcd"), ply, T.inverse());
  const auto back = io::loadCloud(folder.file("back.pcd"));
  EXPECT_EQ(back.offset, Eigen::Vector3d::Zero());
  EXPECT_NEAR((*back.points)[0].x, 1.234, 1e-6);
  EXPECT_NEAR((*back.points)[0].z, 3.456, 1e-6);
}

TEST(LoadedCloud, floatsThatHaveLostTheShapeAreRefused)
{
  const auto fileOf = [](const char* type, double northing) {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 60\n";
    for (const char* name : {"x", "y", "z"})
      text += "property " + std::string(type) + " " + name + "\n";
    text += "end_header\n";
    for (int i = 0; i < 60; ++i)
      for (const double value : {500000.0, northing + 0.37 * i, 200.0})
        text += type == std::string("double") ? testing::bytesOf(value) : testing::bytesOf(static_cast<float>(value));
    return text;
  };
  const std::string refused = testing::errorOf("grid.ply", fileOf("float", 5.5e6));
  EXPECT_THAT(refused, ::testing::HasSubstr("grid.ply: x, y, z are no finer than floats of 4 bytes"));
  EXPECT_THAT(refused, ::testing::HasSubstr("steps of 0.5 m at 5500011 m"));
  EXPECT_EQ(io::parseCloud("grid.ply", fileOf("double", 5.5e6)).points->size(), 60U);
  EXPECT_EQ(io::parseCloud("near.ply", fileOf("float", 1e6)).points->size(), 60U); // steps of 6 cm
  EXPECT_THROW(io::parseScanPoints("grid.ply", fileOf("float", 5.5e6)), io::IoError);
}

TEST(MovedCloud, errors)
{
  const TemporaryFolder folder;
  const auto cloud = io::parseCloud("a.xyz", "1 2 3\n");
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  EXPECT_THROW(io::saveMovedCloud(folder.file("a.las"), cloud, T), io::IoError);
  EXPECT_THROW(io::saveMovedCloud(folder.file("none/a.pcd"), cloud, T), io::IoError);
}

TEST(Ply, elementsAndByteOrders)
{
  const std::string header =
      "ply\nformat ascii 1.0\ncomment c\nelement camera 1\nproperty float view\nelement vertex 2\n"
      "property double x\nproperty double y\nproperty double z\nproperty uchar scalar_Intensity\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto ascii = io::parseCloud("a.ply", header + "5\n1 2 3 4\n5 6 7 8\n3 0 1 0\n");
  ASSERT_EQ(ascii.points->size(), 2U);
  EXPECT_EQ((*ascii.points)[1].z, 7.0F);
  EXPECT_EQ((*ascii.points)[1].intensity, 8.0F);

  // Big endian, with a list before the vertices.
  std::string big = "ply\nformat binary_big_endian 1.0\nelement face 2\nproperty list uchar short i\nelement vertex 1\n"
                    "property float x\nproperty float y\nproperty short z\nend_header\n";
  big += std::string("\x02\0\1\0\2\x00", 6);              // two faces: two indices, none
  big += std::string("\x3f\x80\0\0\xc0\0\0\0\0\x07", 10); // 1, -2, 7
  const auto cloud = io::parseCloud("b.ply", big);
  ASSERT_EQ(cloud.points->size(), 1U);
  EXPECT_EQ((*cloud.points)[0].x, 1.0F);
  EXPECT_EQ((*cloud.points)[0].y, -2.0F);
  EXPECT_EQ((*cloud.points)[0].z, 7.0F);
  EXPECT_THAT(errorOf("b.ply", big.substr(0, big.size() - 1)), HasSubstr("element 'vertex': 1 times 10 bytes"));
}

TEST(Ply, errors)
{
  const auto header = [](const std::string& count, const std::string& format = "ascii") {
    return "ply\nformat " + format + " 1.0\nelement vertex " + count +
           "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  };
  EXPECT_THAT(errorOf("a.ply", "solid\n"), HasSubstr("a.ply:1: not a PLY file: it starts with 'solid'"));
  EXPECT_THAT(errorOf("a.ply", header("-3")), HasSubstr("a.ply:3: element 'vertex': '-3' is not a count"));
  EXPECT_THAT(errorOf("a.ply", header("4000000000") + "1 2 3\n"), HasSubstr("4000000000"));
  EXPECT_THAT(errorOf("a.ply", header("2000000000", "binary_little_endian") + "123"), HasSubstr("do not fit"));
  EXPECT_THAT(errorOf("a.ply", header("2") + "1.123456 2.123456 3.123456\n"),
              HasSubstr("ends after 1 of 2 vertex lines"));
  EXPECT_EQ(errorOf("a.ply", header("2") + "1 2 3\n1 b 3\n"), "a.ply:9: column 2: 'b' is not a number");
  EXPECT_THAT(errorOf("a.ply", header("1", "binary_middle_endian")), HasSubstr("unknown PLY format"));
  EXPECT_THAT(errorOf("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("no property 'y'"));
  EXPECT_THAT(errorOf("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\nend_header\n"),
              HasSubstr("unknown type 'real'"));
  EXPECT_THAT(errorOf("a.ply", "ply\nformat ascii 1.0\nend_header\n"), HasSubstr("no element 'vertex'"));
  EXPECT_THAT(errorOf("a.ply", "ply\nformat ascii 1.0\n"), HasSubstr("ends before its end_header"));
}

TEST(PclFormats, headersAreBounded)
{
  std::string names, properties;
  for (int i = 0; i < 1001; ++i) {
    names += " f" + std::to_string(i);
    properties += "property float f" + std::to_string(i) + "\n";
  }
  EXPECT_EQ(errorOf("a.pcd", "FIELDS" + names + "\n"), "a.pcd:1: a point of more than 1000 fields");
  EXPECT_EQ(errorOf("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + properties + "end_header\n"),
            "a.ply:1004: element 'vertex' has more than 1000 properties");

  const std::string comments(std::size_t{5} << 20, '\n');
  EXPECT_THAT(errorOf("a.pcd", "FIELDS x y z\n#" + comments + "SIZE 4 4 4\n"),
              HasSubstr("the PCD header ends before its DATA line; a header may have 4 MiB"));
  EXPECT_THAT(errorOf("a.ply", "ply\nformat ascii 1.0\ncomment " + comments + "end_header\n"),
              HasSubstr("; a header may have 4 MiB"));
}

// LZF makes at most 264 bytes of 3: a header that promises more reserves no memory for it.
TEST(CompressedPcd, compressionIsBounded)
{
  const auto withSizes = [](std::uint32_t packed, std::uint32_t points) {
    return "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH " + std::to_string(points) + "\nDATA binary_compressed\n" +
           testing::bytesOf(packed) + testing::bytesOf(12 * points) + std::string(packed, '\0');
  };
  EXPECT_THAT(errorOf("a.pcd", withSizes(30, 220)), HasSubstr("compressed data are damaged")) << "2640 bytes: 88 each";
  EXPECT_THAT(errorOf("a.pcd", withSizes(30, 230)), HasSubstr("compressed data give 2760 bytes"));
}

TEST(PclFormats, mutationsNeverCrash)
{
  const TemporaryFolder folder;
  const auto cloud = makeCloud(30);
  pcl::PCDWriter().writeBinaryCompressed(folder.file("c.pcd"), cloud);
  fuzz("c.pcd", io::readFile(folder.file("c.pcd")), kFuzzRounds);
  io::saveMovedCloud(folder.file("b.ply"), io::loadCloud(folder.file("c.pcd")), Eigen::Isometry3d::Identity());
  fuzz("b.ply", io::readFile(folder.file("b.ply")), kFuzzRounds);
  pcl::PLYWriter().write(folder.file("a.ply"), cloud, false);
  fuzz("a.ply", io::readFile(folder.file("a.ply")), kFuzzRounds);
}

} // namespace
} // namespace pcl_ssfr::test_io_pcl
