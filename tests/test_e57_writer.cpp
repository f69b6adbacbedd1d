// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <e57_files.h>

#include <apps/io/e57_format.h>
#include <apps/io/e57_writer.h>
#include <apps/io/file_bytes.h>

#include <gmock/gmock.h>

#include <cmath>

namespace pcl_ssfr::test_e57_writer {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// \p points points with all that a scan can have; every 7th has no return.
io::LoadedCloud
madeUpCloud(std::size_t points, bool as_double, bool with_fields)
{
  io::LoadedCloud cloud;
  cloud.path = "made/up.pcd";
  using Field = pcl::PCLPointField;
  for (const char* name : {"x", "y", "z"})
    io::addField(cloud.table, name, as_double ? Field::FLOAT64 : Field::FLOAT32);
  if (with_fields) {
    io::addField(cloud.table, "rgb", Field::FLOAT32);
    io::addField(cloud.table, "other", Field::FLOAT32);
    io::addField(cloud.table, "intensity", Field::FLOAT32);
    io::addField(cloud.table, "row", Field::INT32);
    io::addField(cloud.table, "time", Field::FLOAT64);
    io::addField(cloud.table, "return_count", Field::UINT8);
    for (const char* name : {"normal_x", "normal_y", "normal_z"})
      io::addField(cloud.table, name, Field::FLOAT32);
  }
  io::resizeTable(cloud.table, points);
  for (std::size_t i = 0; i < points; ++i) {
    std::uint8_t* point = cloud.table.data.data() + i * cloud.table.point_step;
    const auto put = [&](const char* name, double value) {
      const Field* field = io::findField(cloud.table, name);
      io::storeValue(point + field->offset, field->datatype, value);
    };
    const auto t = static_cast<double>(i);
    put("x", i % 7 == 3 ? NAN : 10 * std::sin(t));
    put("y", 10 * std::cos(t));
    put("z", as_double ? 5e5 + t / 1000 : t / 1000);
    if (with_fields) {
      const std::uint32_t packed = io::packRgb(i & 255U, 7, 255);
      std::memcpy(point + io::findField(cloud.table, "rgb")->offset, &packed, sizeof(packed));
      put("other", 1);
      put("intensity", t / 3);
      put("row", -5 + t);
      put("time", 1.3e9 + t * 1e-6);
      put("return_count", 3);
      put("normal_z", -1);
    }
  }
  return cloud;
}

Eigen::Isometry3d
somePose()
{
  return Eigen::Translation3d(12345.678, -3, 1e-9) * Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 3).normalized());
}

double
valueOf(const pcl::PCLPointCloud2& table, const char* name, std::size_t i)
{
  const auto* field = io::findField(table, name);
  if (!field)
    throw std::runtime_error(std::string("no field ") + name);
  return io::loadValue(table.data.data() + i * table.point_step + field->offset, field->datatype);
}

template <typename Float, typename Bits>
double
floatOf(std::uint64_t stored)
{
  const auto bits = static_cast<Bits>(stored);
  Float value;
  std::memcpy(&value, &bits, sizeof(value));
  return static_cast<double>(value);
}

class E57Writer : public ::testing::Test {
protected:
  TemporaryFolder folder_;
  const std::string path_ = folder_.file("map.e57");
};

TEST_F(E57Writer, isReadByAnIndependentDecoder)
{
  constexpr std::size_t kPoints = 5000; // several packets
  const io::LoadedCloud full = madeUpCloud(kPoints, false, true);
  const io::LoadedCloud far = madeUpCloud(20, true, false);
  io::E57Writer writer(path_);
  writer.addScan("full", full, somePose());
  writer.addScan("far <&> \1 \xC3\xA4", far, Eigen::Isometry3d::Identity());
  writer.addScan("bad \xC3( ]]>", madeUpCloud(0, false, false), somePose());
  writer.finish();

  const auto scans = decodeE57(io::readFile(path_));
  ASSERT_EQ(scans.size(), 3U);
  std::size_t record = 0;
  for (std::size_t i = 0; i < kPoints; ++i) {
    if (i % 7 == 3)
      continue; // no return
    const auto same = [&](const char* column, const char* field) {
      return floatOf<float, std::uint32_t>(scans[0].column(column).at(record)) == valueOf(full.table, field, i);
    };
    ASSERT_TRUE(same("cartesianX", "x") && same("cartesianY", "y") && same("cartesianZ", "z")) << i;
    ASSERT_TRUE(same("intensity", "intensity") && same("nor:normalZ", "normal_z")) << i;
    ASSERT_EQ(scans[0].column("colorRed").at(record), i & 255U);
    ASSERT_EQ(scans[0].column("colorGreen").at(record), 7U);
    ASSERT_EQ(scans[0].column("colorBlue").at(record), 255U);
    ASSERT_EQ(static_cast<double>(scans[0].column("rowIndex").at(record)) - 2147483648.0,
              valueOf(full.table, "row", i));
    ASSERT_EQ((floatOf<double, std::uint64_t>(scans[0].column("timeStamp").at(record))),
              valueOf(full.table, "time", i));
    ASSERT_EQ(scans[0].column("returnCount").at(record), 3U);
    ++record;
  }
  EXPECT_EQ(scans[0].column("cartesianX").size(), record);
  EXPECT_EQ((floatOf<double, std::uint64_t>(scans[1].column("cartesianZ").at(1))), 5e5 + 0.001);
  EXPECT_EQ(scans[1].columns.size(), 3U);
  EXPECT_EQ(scans[2].column("cartesianX").size(), 0U);

  EXPECT_EQ(scans[0].text("name"), "full");
  EXPECT_EQ(scans[1].text("name"), "far &lt;&amp;&gt; ? \xC3\xA4");
  EXPECT_EQ(scans[2].text("name"), "bad ?( ]]&gt;");
  EXPECT_NE(scans[0].text("guid"), scans[1].text("guid"));
  // The pose as another reader would put it together.
  const auto at = [&scans](const char* name, const char* parent) { return std::stod(scans[0].text(name, parent)); };
  const Eigen::Quaterniond q(at("w", "<rotation"), at("x", "<rotation"), at("y", "<rotation"), at("z", "<rotation"));
  EXPECT_NEAR(q.norm(), 1, 1e-15);
  EXPECT_TRUE(q.toRotationMatrix().isApprox(somePose().linear(), 1e-14));
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(at(k == 0 ? "x" : k == 1 ? "y" : "z", "<translation"), somePose().translation()[k]);
  EXPECT_EQ(at("zMaximum", "<cartesianBounds"), static_cast<float>(4999 / 1000.0));
  EXPECT_EQ(at("intensityMinimum", "<intensityLimits"), 0);
}

TEST_F(E57Writer, isReadByOurReader)
{
  if (!PCL_SSFR_READS_E57)
    GTEST_SKIP() << "built without pugixml";
  const io::LoadedCloud full = madeUpCloud(5000, false, true);
  const io::LoadedCloud far = madeUpCloud(20, true, false);
  io::E57Writer writer(path_);
  writer.addScan("full", full, somePose());
  writer.addScan("far <&> \xC3\xA4", far, Eigen::Isometry3d::Identity());
  writer.addScan("empty", madeUpCloud(0, false, false), somePose());
  writer.finish();

  const auto list = io::listE57Scans(path_);
  ASSERT_EQ(list.size(), 3U);
  EXPECT_EQ(list[1].name, "far <&> \xC3\xA4");
  EXPECT_TRUE(list[0].T_file_scan->matrix().isApprox(somePose().matrix(), 1e-14));
  for (const auto& [pick, truth] : {std::pair(path_ + "#full", full), std::pair(path_ + "#2", far)}) {
    const auto cloud = io::loadCloud(pick);
    std::size_t got = 0;
    for (std::size_t i = 0; i < io::pointCount(truth.table); ++i) {
      if (i % 7 == 3)
        continue;
      for (const auto& field : truth.table.fields) {
        if (field.name == "other")
          continue;
        const double a = valueOf(cloud.table, field.name.c_str(), got);
        const double b = valueOf(truth.table, field.name.c_str(), i);
        ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b) && field.name == "rgb")) << field.name << ' ' << i;
      }
      ++got;
    }
    EXPECT_EQ(io::pointCount(cloud.table), got);
  }
  EXPECT_EQ(io::loadCloud(path_ + "#3").points->size(), 0U);
}

TEST_F(E57Writer, thePoseLeadsFromTheSensor)
{
  // A sensor away from the origin of its file: E57 has it in the origin of the scan.
  io::LoadedCloud cloud = madeUpCloud(10, false, false);
  cloud.viewpoint = Eigen::Vector3d(4, 5, 6);
  io::saveMovedCloud(path_, cloud, somePose());
  const auto scans = decodeE57(io::readFile(path_));
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].text("name"), "up");
  Eigen::Vector3d first;
  Eigen::Vector3d position;
  Eigen::Vector4d q;
  const char* const axes[] = {"x", "y", "z"};
  const char* const columns[] = {"cartesianX", "cartesianY", "cartesianZ"};
  for (int k = 0; k < 3; ++k) {
    first[k] = floatOf<float, std::uint32_t>(scans[0].column(columns[k])[0]);
    position[k] = std::stod(scans[0].text(axes[k], "<translation"));
    q[k] = std::stod(scans[0].text(axes[k], "<rotation"));
  }
  q[3] = std::stod(scans[0].text("w", "<rotation"));
  EXPECT_TRUE(position.isApprox(somePose() * Eigen::Vector3d(4, 5, 6), 1e-14));
  const Eigen::Vector3d in_map = Eigen::Quaterniond(q) * first + position;
  const Eigen::Vector3d truth =
      somePose() *
      Eigen::Vector3d(valueOf(cloud.table, "x", 0), valueOf(cloud.table, "y", 0), valueOf(cloud.table, "z", 0));
  EXPECT_LT((in_map - truth).norm(), 1e-5);
}

TEST_F(E57Writer, sameScansSameBytesAndErrors)
{
  const io::LoadedCloud cloud = madeUpCloud(3000, false, true);
  for (const char* name : {"a.e57", "b.e57"})
    io::saveMovedCloud(folder_.file(name), cloud, somePose());
  EXPECT_TRUE(io::readFile(folder_.file("a.e57")) == io::readFile(folder_.file("b.e57")));

  const auto error = [](const std::function<void()>& run) -> std::string {
    try {
      run();
    }
    catch (const io::IoError& caught) {
      return caught.what();
    }
    return "none";
  };
  const std::string nowhere = folder_.file("none/a.e57");
  EXPECT_THAT(error([&] { io::saveMovedCloud(nowhere, cloud, somePose()); }),
              HasSubstr(nowhere + ": cannot be created"));
  Eigen::Isometry3d wrong = somePose();
  wrong.translation().x() = NAN;
  EXPECT_THAT(error([&] { io::saveMovedCloud(path_, cloud, wrong); }),
              HasSubstr("the pose of scan 'up' is not finite"));
  EXPECT_THAT(error([&] { io::saveMovedCloud(path_, io::LoadedCloud(), somePose()); }), HasSubstr("has no table"));
  // What is not finished is no E57 file, and nothing is left of it.
  {
    io::E57Writer writer(path_);
    writer.addScan("a", cloud, somePose());
    for (const auto& entry : std::filesystem::directory_iterator(folder_.file("")))
      if (entry.path().extension() == ".part") {
        EXPECT_THAT(errorOf("map.e57", io::readFile(entry.path().string())), HasSubstr("not an E57 file"));
      }
  }
  EXPECT_FALSE(std::filesystem::exists(path_));
  if (std::filesystem::exists("/dev/full")) {
    std::filesystem::create_symlink("/dev/full", folder_.file("full.e57"));
    EXPECT_THAT(error([&] { io::saveMovedCloud(folder_.file("full.e57"), cloud, somePose()); }),
                HasSubstr("full.e57: cannot be written"));
  }
}

} // namespace
} // namespace pcl_ssfr::test_e57_writer
