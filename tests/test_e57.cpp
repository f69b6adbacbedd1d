// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <e57_files.h>

#include <apps/io/dataset_folder.h>
#include <apps/io/e57_format.h>
#include <apps/io/e57_pages.h>
#include <apps/io/file_bytes.h>

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <random>

namespace pcl_ssfr::test_e57 {
namespace {

using namespace testing;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr int kFuzzRounds = 4000;

/// Tests that read skip where pugixml was not found.
class E57 : public ::testing::Test {
protected:
  void
  SetUp() override
  {
    if (!PCL_SSFR_READS_E57)
      GTEST_SKIP() << "built without pugixml";
  }
};

double
valueOf(const io::LoadedCloud& cloud, const char* name, std::size_t i)
{
  const auto* field = io::findField(cloud.table, name);
  if (!field)
    throw std::runtime_error(std::string("no field ") + name);
  return io::loadValue(cloud.table.data.data() + i * cloud.table.point_step + field->offset, field->datatype);
}

std::uint32_t
rgbOf(const io::LoadedCloud& cloud, std::size_t i)
{
  const auto* field = io::findField(cloud.table, "rgb");
  std::uint32_t packed = 0;
  std::memcpy(&packed, cloud.table.data.data() + i * cloud.table.point_step + field->offset, sizeof(packed));
  return packed;
}

/// A scan of \p points points (i, -2, 0.5), single precision.
E57Made
lineScan(std::size_t points, const std::string& head = "")
{
  std::vector<float> x;
  for (std::size_t i = 0; i < points; ++i)
    x.push_back(static_cast<float>(i));
  E57Made scan;
  scan.head = head;
  scan.columns = {singleColumn("cartesianX", x),
                  singleColumn("cartesianY", std::vector<float>(points, -2.0F)),
                  singleColumn("cartesianZ", std::vector<float>(points, 0.5F))};
  return scan;
}

#if !PCL_SSFR_READS_E57
TEST(E57Support, isNamedWhereItWasNotBuilt)
{
  EXPECT_EQ(errorOf("a.e57", makeE57({lineScan(1)})),
            "a.e57: E57 files cannot be read: this program was built without pugixml");
}
#endif

std::string
wrongScan(const std::function<void(E57Made&)>& change)
{
  E57Made scan = lineScan(100);
  change(scan);
  return errorOf("a.e57", makeE57({scan}));
}

// ---------------------------------------------------------------------------------------------------------------------
// Pages

TEST(E57Pages, checksum)
{
  EXPECT_EQ(io::crc32c("123456789"), 0xE3069283U); // the check value of CRC-32C
  EXPECT_EQ(io::crc32c(""), 0U);
  std::mt19937 random(5);
  std::string bytes;
  for (int i = 0; i < 70; ++i) {
    EXPECT_EQ(io::crc32c(bytes), slowCrc32c(bytes)) << i;
    bytes += static_cast<char>(random());
  }
}

TEST(E57Pages, anyRangeOfAnyPageSize)
{
  std::mt19937 random(1);
  for (const std::size_t page_size : {52U, 64U, 1000U, 1024U, 4096U}) {
    SCOPED_TRACE(page_size);
    std::string logical = makeE57Logical({lineScan(500)}, page_size);
    const std::string file = toPages(logical, page_size);
    const io::MemoryBytes source(file);
    io::E57PageReader pages("a.e57", source);
    logical.resize(pages.size());
    for (int round = 0; round < 200; ++round) {
      const std::size_t at = random() % logical.size();
      const std::size_t count = random() % (logical.size() - at + 1);
      std::string got(count, 'x');
      pages.read(at, count, got.data());
      ASSERT_TRUE(got == logical.substr(at, count)) << at << " + " << count;
    }
    EXPECT_EQ(pages.toLogical(page_size + 5, "x"), page_size - 4 + 5);
    EXPECT_THROW(pages.toLogical(page_size - 4, "x"), io::IoError);
    EXPECT_THROW(pages.toLogical(file.size(), "x"), io::IoError);
    EXPECT_THROW(pages.toLogical(~std::uint64_t{0}, "x"), io::IoError);
    std::string more(2, '\0');
    EXPECT_THROW(pages.read(logical.size() - 1, 2, more.data()), io::IoError);
  }
}

TEST_F(E57, everyFlippedPageIsFound)
{
  const std::string good = makeE57({lineScan(400)});
  ASSERT_GT(good.size(), 5 * 1024U);
  EXPECT_EQ(io::parseCloud("a.e57", good).points->size(), 400U);
  for (std::size_t page = 0; page < good.size() / 1024; ++page)
    for (const std::size_t at : {100U, 1019U, 1020U, 1023U}) {
      std::string bad = good;
      bad[page * 1024 + at] = static_cast<char>(bad[page * 1024 + at] ^ 4);
      EXPECT_THAT(errorOf("a.e57", bad), HasSubstr("a.e57: the checksum of page " + std::to_string(page) + " "));
    }
}

/// A file of more than 4 GiB that is never stored: between its two ends lie pages of zeros.
class LongFile : public io::ByteSource {
public:
  LongFile(std::string first, std::string last, std::uint64_t pages_between)
      : first_(std::move(first)), last_(std::move(last)), zeros_(toPages(std::string(1020, '\0'))),
        between_(pages_between)
  {}
  std::uint64_t
  size() const override
  {
    return first_.size() + between_ * 1024 + last_.size();
  }
  void
  read(std::uint64_t at, std::size_t count, char* to) const override
  {
    for (; count > 0; ++at, --count, ++to, ++bytes_read)
      *to = at < first_.size()                     ? first_[at]
            : at - first_.size() < between_ * 1024 ? zeros_[at % 1024]
                                                   : last_[at - first_.size() - between_ * 1024];
  }
  mutable std::uint64_t bytes_read = 0;

private:
  std::string first_;
  std::string last_;
  std::string zeros_;
  std::uint64_t between_;
};

TEST_F(E57, beyondFourGibibytes)
{
  constexpr std::uint64_t kPages = 5 * (std::uint64_t{1} << 20) + 7; // of 1024 bytes: 5 GiB
  const std::string normal = makeE57Logical({lineScan(50)});
  // All but the header moves behind the zeros.
  std::string header = normal.substr(0, 48);
  header.resize(1020);
  std::string rest(48, '\0');
  rest += normal.substr(48);
  const std::uint64_t shift = (kPages + 1) * 1024;
  const auto move = [&](std::string& bytes, std::size_t at) {
    const std::uint64_t value = io::valueAt<std::uint64_t>(bytes, at) + shift;
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  };
  move(header, 16);
  move(header, 24);
  move(rest, 48 + 16);
  const std::string place = "fileOffset=\"48\"";
  const std::string moved = "fileOffset=\"" + std::to_string(48 + shift) + "\"";
  rest.replace(rest.find(place), place.size(), moved);
  const std::uint64_t xml = io::valueAt<std::uint64_t>(header, 32) + moved.size() - place.size();
  std::memcpy(header.data() + 32, &xml, sizeof(xml));
  const LongFile file(toPages(header), toPages(rest), kPages);
  ASSERT_GT(file.size(), std::uint64_t{5} << 30);
  // The length in the header counts the pages of the end as they are now.
  std::string whole = header;
  const std::uint64_t length = file.size();
  std::memcpy(whole.data() + 16, &length, sizeof(length));
  const LongFile right(toPages(whole), toPages(rest), kPages);
  const io::RawCloud cloud = io::readE57("long.e57", right, io::FieldChoice::kAll);
  ASSERT_EQ(io::pointCount(cloud.table), 50U);
  EXPECT_EQ(io::loadValue(cloud.table.data.data() + 49 * cloud.table.point_step, pcl::PCLPointField::FLOAT32), 49);
  EXPECT_LT(right.bytes_read, 20000U); // streaming: what lies between is not read
}

// ---------------------------------------------------------------------------------------------------------------------
// Values

TEST_F(E57, everyBitWidthCutAnywhere)
{
  constexpr std::size_t kRecords = 300;
  std::mt19937_64 random(3);
  for (unsigned width = 0; width <= 64; ++width) {
    SCOPED_TRACE(width);
    const std::uint64_t range = width == 0 ? 0 : width == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << width) - 1;
    const std::int64_t minimum = width == 64 ? INT64_MIN : -static_cast<std::int64_t>(range / 3);
    const auto maximum = static_cast<std::int64_t>(static_cast<std::uint64_t>(minimum) + range);
    std::vector<std::uint64_t> stored;
    for (std::size_t i = 0; i < kRecords; ++i)
      stored.push_back(range == 0 ? 0 : i == 0 ? range : random() & range);
    E57Made scan = lineScan(kRecords);
    const std::string limits =
        "minimum=\"" + std::to_string(minimum) + "\" maximum=\"" + std::to_string(maximum) + "\" ";
    scan.columns[1] = integerColumn("cartesianY", limits + "scale=\"0.001\" offset=\"5\"", width, stored);
    scan.columns.insert(scan.columns.begin(), integerColumn("timeStamp", limits, width, stored));
    scan.piece = [](std::size_t k, std::size_t packet) { return (k * 37 + packet * 11) % 50; };
    scan.other_packets = true;
    const auto cloud = io::parseCloud("a.e57", makeE57({scan}));
    ASSERT_EQ(cloud.points->size(), kRecords);
    for (std::size_t i = 0; i < kRecords; ++i) {
      const auto integer = static_cast<std::int64_t>(static_cast<std::uint64_t>(minimum) + stored[i]);
      ASSERT_EQ(valueOf(cloud, "time", i), static_cast<double>(integer)) << i;
      const double y = static_cast<double>(integer) * 0.001 + 5;
      ASSERT_EQ(valueOf(cloud, "y", i), width < 24 ? static_cast<float>(y) : y) << i;
      ASSERT_EQ(valueOf(cloud, "x", i), static_cast<double>(i));
    }
  }
}

TEST_F(E57, sphericalCoordinatesInvalidPointsAndStrings)
{
  const double pi = M_PI;
  E57Made scan;
  // In an order of their own, between fields that are skipped.
  E57Column text{"label type=\"String\"", 0, {}, std::string("\6abc\0\2x\4yz", 9)};
  text.bytes = std::string("\6abc", 4) + '\0' + "\2x" + "\4yz";
  scan.columns = {doubleColumn("sphericalElevation", {0, pi / 2, 0.3, pi / 6}),
                  text,
                  integerColumn("sphericalInvalidState", "minimum=\"0\" maximum=\"2\"", 2, {0, 1, 2, 0}),
                  integerColumn("ext:thing", "", 64, {1, 2, 3, 4}),
                  doubleColumn("sphericalAzimuth", {pi / 2, 0, 0, 0}),
                  doubleColumn("sphericalRange", {2, 3, 4, 2}),
                  integerColumn("intensity", "minimum=\"-66\" maximum=\"66\"", 8, {0, 1, 2, 132}),
                  integerColumn("isIntensityInvalid", "minimum=\"0\" maximum=\"1\"", 1, {0, 0, 0, 1})};
  scan.records = "4";
  const auto cloud = io::parseCloud("a.e57", makeE57({scan}));
  ASSERT_EQ(cloud.points->size(), 2U);
  EXPECT_NEAR(valueOf(cloud, "x", 0), 0, 1e-15);
  EXPECT_NEAR(valueOf(cloud, "y", 0), 2, 1e-15);
  EXPECT_NEAR(valueOf(cloud, "x", 1), std::sqrt(3), 1e-15);
  EXPECT_NEAR(valueOf(cloud, "z", 1), 1, 1e-15);
  EXPECT_EQ((*cloud.points)[0].intensity, -66);
  EXPECT_EQ((*cloud.points)[1].intensity, 0); // invalid
  EXPECT_FALSE(cloud.T_file_scan);
  EXPECT_FALSE(cloud.viewpoint); // the origin
}

TEST_F(E57, coloursOfAnyDepth)
{
  const auto read = [](const std::string& attributes, unsigned width, std::uint64_t value, const std::string& head) {
    E57Made scan = lineScan(1, head);
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
      scan.columns.push_back(integerColumn(name, attributes, width, {value}));
    return rgbOf(io::parseCloud("a.e57", makeE57({scan})), 0);
  };
  EXPECT_EQ(read("minimum=\"0\" maximum=\"255\"", 8, 200, ""), 0xC8C8C8U);
  EXPECT_EQ(read("minimum=\"0\" maximum=\"65535\"", 16, 0xFF00, ""), 0xFFFFFFU);
  EXPECT_EQ(read("minimum=\"0\" maximum=\"65535\"", 16, 0x1234, ""), 0x121212U);
  EXPECT_EQ(read("minimum=\"0\" maximum=\"1023\"", 10, 512, ""), 0x808080U);
  const std::string limits = "<colorLimits type=\"Structure\"><colorRedMinimum type=\"Integer\"/>"
                             "<colorRedMaximum type=\"Integer\">65535</colorRedMaximum></colorLimits>";
  EXPECT_EQ(read("", 64, std::uint64_t{0x8000000000000000U} + 0x7F00, limits), 0x7F7F7FU);
  EXPECT_EQ(read("", 64, std::uint64_t{0x8000000000000000U} + 200, ""), 0xC8C8C8U) << "no bound: 8 bits";
}

TEST_F(E57, poseOfTheScan)
{
  const std::string pose = "<pose type=\"Structure\"><translation type=\"Structure\"><x type=\"Float\">1.5</x>"
                           "<z type=\"Float\"> -3e0 </z></translation><rotation type=\"Structure\">"
                           "<w type=\"Float\">2</w><x type=\"Float\"/><y type=\"Float\">0</y>"
                           "<z type=\"Float\">2</z></rotation></pose>";
  const auto cloud = io::parseCloud("a.e57", makeE57({lineScan(3, pose)}));
  ASSERT_TRUE(cloud.T_file_scan);
  Eigen::Matrix4d expected;
  expected << 0, -1, 0, 1.5, 1, 0, 0, 0, 0, 0, 1, -3, 0, 0, 0, 1; // 90 degrees about z
  EXPECT_TRUE(cloud.T_file_scan->matrix().isApprox(expected, 1e-15));
  EXPECT_EQ((*cloud.points)[2].x, 2); // in the frame of the sensor
}

TEST_F(E57, farAndNestedAndEmpty)
{
  E57Made far = lineScan(2);
  far.columns[0] = doubleColumn("cartesianX", {5e6 + 0.125, 5e6 + 1.125});
  const auto cloud = io::parseCloud("a.E57", makeE57({far}));
  EXPECT_EQ(valueOf(cloud, "x", 1), 5e6 + 1.125);
  EXPECT_NEAR(cloud.offset.x(), 5e6, 2);

  // A structure of an extension is as many streams as it has leaves, and its names are its own.
  E57Made nested = lineScan(2);
  nested.columns.insert(
      nested.columns.begin(),
      E57Column{"ext:a type=\"Structure\"><cartesianX type=\"Integer\" minimum=\"0\" maximum=\"3\"", 2, {3, 3}, {}});
  std::string logical = makeE57Logical({nested}, 1024, [](std::string xml) {
    const std::size_t at = xml.find("maximum=\"3\"/>") + 13;
    return xml.insert(at, "</ext:a>");
  });
  EXPECT_EQ((*io::parseCloud("a.e57", toPages(logical)).points)[1].x, 1);

  EXPECT_EQ(io::parseCloud("a.e57", makeE57({lineScan(0)})).points->size(), 0U);
}

// ---------------------------------------------------------------------------------------------------------------------
// Several scans

std::string
named(const std::string& name)
{
  return "<name type=\"String\"><![CDATA[" + name + "]]></name><guid type=\"String\">g</guid>";
}

TEST_F(E57, picksAScan)
{
  TemporaryFolder folder;
  const std::string path = folder.file("all.e57");
  io::writeFile(path,
                makeE57({lineScan(3, named("hall & yard")),
                         lineScan(4),
                         lineScan(5, named("1")),
                         lineScan(6, named("a")),
                         lineScan(7, named("a"))}));
  const auto count = [&path](const std::string& pick) { return io::loadCloud(path + pick).points->size(); };
  EXPECT_EQ(count("#1"), 3U); // a number is a number, even where a scan has it as its name
  EXPECT_EQ(count("#2"), 4U);
  EXPECT_EQ(count("#hall & yard"), 3U);
  EXPECT_EQ(io::loadCloud(path + "#2").path, path + "#2");
  const auto message = [&path](const std::string& pick) -> std::string {
    try {
      io::loadCloud(path + pick);
    }
    catch (const io::IoError& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_EQ(message("").substr(path.size()),
            ": holds 5 scans, pick one of " + path + "#1 ('hall & yard', 3 points), " + path + "#2 (4 points), " +
                path + "#3 ('1', 5 points), " + path + "#4 ('a', 6 points), " + path + "#5 ('a', 7 points)");
  EXPECT_THAT(message("#6"), HasSubstr("no scan is called '6'; it holds"));
  EXPECT_THAT(message("#0"), HasSubstr("no scan is called '0'"));
  EXPECT_THAT(message("#"), HasSubstr("no scan is called ''"));
  EXPECT_THAT(message("#b"), HasSubstr("no scan is called 'b'"));
  EXPECT_THAT(message("#a"), HasSubstr("several scans are called 'a'"));

  const auto scans = io::listE57Scans(path);
  ASSERT_EQ(scans.size(), 5U);
  EXPECT_EQ(scans[2].path, path + "#3");
  EXPECT_EQ(scans[0].name, "hall & yard");
  EXPECT_EQ(scans[0].guid, "g");
  EXPECT_EQ(scans[4].records, 7U);
  EXPECT_FALSE(scans[0].T_file_scan);
  EXPECT_THROW(io::listE57Scans(folder.file("none.e57")), io::IoError);

  EXPECT_EQ(io::fileOfScan("a/b.E57#c#d/e"), "a/b.E57");
  EXPECT_EQ(io::fileOfScan("a#1.e57"), "a#1.e57");
  EXPECT_EQ(io::fileOfScan("a.pcd#1"), "a.pcd#1");
  EXPECT_TRUE(io::isReadableFormat("a.e57#b"));
  EXPECT_FALSE(io::isReadableFormat("a.pcd#1"));
  EXPECT_FALSE(io::isWritableFormat("a.e57#1"));

  // Pairs of a dataset.
  const std::string pairs = "source,target,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\nall.e57#1,all.e57#";
  io::writeFile(folder.file("pairs.csv"), pairs + "2,1,0,0,0,0,1,0,0,0,0,1,0\n");
  const io::DatasetFolder dataset = io::readDatasetFolder(folder.file(""));
  EXPECT_EQ(io::loadCloud(io::scanPath(dataset.path, dataset.pairs.at(0).target)).points->size(), 4U);
}

// ---------------------------------------------------------------------------------------------------------------------
// What is wrong with files

TEST_F(E57, cutOffAnywhere)
{
  const std::string good = makeE57({lineScan(200)});
  for (std::size_t bytes = 0; bytes < good.size(); bytes += bytes < 60 ? 1 : 7) {
    const std::string message = errorOf("a.e57", good.substr(0, bytes));
    EXPECT_THAT(message, StartsWith("a.e57: ")) << bytes;
  }
  EXPECT_EQ(errorOf("a.e57", ""), "a.e57: is empty");
  EXPECT_THAT(errorOf("a.e57", good.substr(0, 47)), HasSubstr("the E57 header ends after 47 bytes"));
  EXPECT_THAT(errorOf("a.e57", good.substr(0, 2048)), HasSubstr("the file is cut off: its header says"));
  EXPECT_EQ(io::parseCloud("a.e57", good + "appended").points->size(), 200U);
}

TEST_F(E57, wrongHeaders)
{
  const std::string good = makeE57Logical({lineScan(10)});
  const auto with = [&good](std::size_t at, auto value) {
    std::string bytes = good;
    bytes.replace(at, sizeof(value), bytesOf(value));
    return errorOf("a.e57", toPages(bytes));
  };
  constexpr std::uint64_t kHuge = ~std::uint64_t{0};
  EXPECT_THAT(with(0, 'X'), HasSubstr("it starts with 'XSTM-E57'"));
  EXPECT_THAT(with(8, 2U), HasSubstr("E57 version 2"));
  EXPECT_THAT(with(16, kHuge), HasSubstr("cut off"));
  EXPECT_THAT(with(16, std::uint64_t{0}), HasSubstr("page size 1024 does not cut 0 bytes"));
  for (const std::uint64_t at : {kHuge, kHuge / 2, std::uint64_t{1} << 33})
    EXPECT_THAT(with(24, at), HasSubstr("offset of the XML section " + std::to_string(at) + " is outside the file"));
  EXPECT_THAT(with(24, std::uint64_t{1021}), HasSubstr("is inside a checksum"));
  for (const std::uint64_t length : {kHuge, kHuge / 2, std::uint64_t{0}, std::uint64_t{5000}})
    EXPECT_THAT(with(32, length), HasSubstr("length of the XML section " + std::to_string(length)));
  for (const std::uint64_t size : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{51}, std::uint64_t{1000}, kHuge})
    EXPECT_THAT(with(40, size), HasSubstr("page size " + std::to_string(size)));
}

TEST_F(E57, wrongXml)
{
  const auto changed = [](const std::function<std::string(std::string)>& change) {
    return errorOf("a.e57", toPages(makeE57Logical({lineScan(10)}, 1024, change)));
  };
  const auto replaced = [&changed](const std::string& from, const std::string& to) {
    return changed([&](std::string xml) { return xml.replace(xml.find(from), from.size(), to); });
  };
  EXPECT_THAT(changed([](const std::string&) { return "no XML"; }), HasSubstr("XML section is wrong at its byte"));
  EXPECT_THAT(changed([](const std::string&) { return "<other/>"; }), HasSubstr("is of 'other', not of 'e57Root'"));
  EXPECT_THAT(changed([](std::string xml) { return xml.substr(0, xml.size() / 2); }),
              HasSubstr("XML section is wrong"));
  EXPECT_THAT(changed([](const std::string&) { return "<e57Root/>"; }), HasSubstr("holds no scan"));
  EXPECT_THAT(changed([](const std::string&) { return "<e57Root><data3D><a/></data3D></e57Root>"; }),
              HasSubstr("scan 1: points: type '' is not CompressedVector"));
  // Nothing recurses, and entities of the document's own are not resolved.
  std::string deep;
  for (int i = 0; i < 200000; ++i)
    deep += "<a type=\"Structure\">";
  EXPECT_THAT(changed([&deep](const std::string&) { return "<e57Root>" + deep; }), HasSubstr("XML section is wrong"));
  std::string closed = deep;
  for (int i = 0; i < 200000; ++i)
    closed += "</a>";
  EXPECT_THAT(replaced("<cartesianX type", closed + "<cartesianX typo"), HasSubstr("type '' cannot be in a record"));
  EXPECT_THAT(changed([](const std::string& xml) {
                return "<!DOCTYPE e57Root [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>" +
                       std::string("<e57Root><data3D><c><points type=\"&b;\"/></c></data3D></e57Root>") +
                       std::string(xml.size() / 1000, ' ');
              }),
              HasSubstr("points: type '&b;' is not"));

  EXPECT_THAT(replaced("fileOffset=\"48\"", ""), HasSubstr("points: fileOffset is missing"));
  EXPECT_THAT(replaced("recordCount=\"10\"", ""), HasSubstr("points: recordCount is missing"));
  EXPECT_THAT(replaced("=\"10\"", "=\"-1\""), HasSubstr("points: recordCount '-1' is not an integer"));
  EXPECT_THAT(replaced("=\"10\"", "=\"99999999999999999999\""), HasSubstr("is not an integer"));
  EXPECT_THAT(replaced("=\"10\"", "=\"1e3\""), HasSubstr("recordCount '1e3' is not an integer"));
  EXPECT_THAT(replaced("=\"48\"", "=\"nan\""), HasSubstr("fileOffset 'nan'"));
  EXPECT_THAT(replaced("single", "half"), HasSubstr("field 'cartesianX': precision 'half'"));
  EXPECT_THAT(replaced("\"Float\"", "\"Blob\""), HasSubstr("field 'cartesianX': type 'Blob' cannot be in a record"));
  EXPECT_THAT(replaced("cartesianX", "cartesianW"), HasSubstr("have neither cartesianX, Y, Z nor sphericalRange"));
  EXPECT_THAT(replaced("<codecs type=\"Vector\">", "<codecs><a><zip/></a>"),
              HasSubstr("codecs: 'zip' is not supported"));
}

TEST_F(E57, wrongNumbers)
{
  const auto field = [](const std::string& attributes) {
    return wrongScan([&](E57Made& scan) { scan.columns[2] = integerColumn("cartesianZ", attributes, 8, {}); });
  };
  EXPECT_THAT(field("minimum=\"3\" maximum=\"2\""), HasSubstr("'cartesianZ': maximum '2' is less than the minimum"));
  EXPECT_THAT(field("minimum=\"0.5\""), HasSubstr("minimum '0.5' is not an integer"));
  EXPECT_THAT(field("maximum=\"9223372036854775808\""), HasSubstr("is not an integer"));
  EXPECT_THAT(field("scale=\"0\""), HasSubstr("scale '0' gives no values"));
  EXPECT_THAT(field("scale=\"nan\""), HasSubstr("scale 'nan' is not a finite number"));
  EXPECT_THAT(field("scale=\"1\" offset=\"inf\""), HasSubstr("offset 'inf' is not a finite number"));
  const auto pose = [](const std::string& rotation) {
    return wrongScan([&](E57Made& scan) {
      scan.head = "<pose type=\"Structure\"><rotation type=\"Structure\">" + rotation + "</rotation></pose>";
    });
  };
  EXPECT_THAT(pose(""), HasSubstr("scan 1: pose/rotation: a quaternion of length 0"));
  EXPECT_THAT(pose("<w>1e-200</w>"), HasSubstr("is no rotation"));
  EXPECT_THAT(pose("<w>1e200</w>"), HasSubstr("is no rotation"));
  EXPECT_THAT(pose("<w>nan</w>"), HasSubstr("pose/rotation/w 'nan' is not a finite number"));
}

TEST_F(E57, wrongSections)
{
  const auto damaged = [](std::size_t at, auto value) {
    return wrongScan([&](E57Made& scan) {
      scan.damage = [&](std::string& section) { section.replace(at, sizeof(value), bytesOf(value)); };
    });
  };
  constexpr std::uint64_t kHuge = ~std::uint64_t{0};
  EXPECT_THAT(damaged(0, std::uint8_t{7}), HasSubstr("the section of the points is of kind 7"));
  for (const std::uint64_t length : {kHuge, std::uint64_t{31}, std::uint64_t{1} << 40})
    EXPECT_THAT(damaged(8, length), HasSubstr("the section of the points has " + std::to_string(length) + " bytes"));
  EXPECT_THAT(damaged(8, std::uint64_t{1230}), HasSubstr("does not fit into the"));
  EXPECT_THAT(damaged(16, kHuge), HasSubstr("offset of the first packet"));
  EXPECT_THAT(damaged(16, std::uint64_t{48}), HasSubstr("the first packet is outside")); // the section itself: a cycle
  EXPECT_THAT(damaged(16, std::uint64_t{0}), HasSubstr("the first packet is outside"));
  // The first packet, from byte 32 on: kind, flags, length - 1, streams, their lengths.
  EXPECT_THAT(damaged(32, std::uint8_t{9}), HasSubstr("packet of kind 9"));
  EXPECT_THAT(damaged(34, std::uint16_t{0}), HasSubstr("a packet of 1 bytes does not fit"));
  EXPECT_THAT(damaged(34, std::uint16_t{0xffff}), HasSubstr("a packet of 65536 bytes does not fit"));
  EXPECT_THAT(damaged(34, std::uint16_t{4}), HasSubstr("a packet has 0 streams, the records have 3 fields"));
  EXPECT_THAT(damaged(34, std::uint16_t{7}), HasSubstr("the streams of a packet take more than its 8 bytes"));
  EXPECT_THAT(damaged(36, std::uint16_t{4}), HasSubstr("a packet has 4 streams"));
  EXPECT_THAT(damaged(38, std::uint16_t{0xffff}), HasSubstr("the streams of a packet take more than its"));
  EXPECT_THAT(damaged(38, std::uint16_t{396}), HasSubstr("ends after 99 of 100 records"));
  // An ignored packet in the place of the data.
  EXPECT_THAT(damaged(32, std::uint8_t{2}), HasSubstr("the section of the points ends after 0 of 100 records"));
  for (const char* records : {"101", "1000000000000", "18446744073709551615"})
    EXPECT_THAT(
        wrongScan([&](E57Made& scan) { scan.records = records; }),
        HasSubstr(std::string(records).size() == 3 ? "ends after 100 of 101" : "recordCount " + std::string(records)));
  // No bits, so no data: a count alone gives no points.
  EXPECT_THAT(wrongScan([](E57Made& scan) {
                scan.columns.clear();
                for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
                  scan.columns.push_back(integerColumn(name, "minimum=\"1\" maximum=\"1\"", 0, {}));
                scan.records = "4000000000";
              }),
              HasSubstr("recordCount 4000000000"));
}

TEST_F(E57, mutationsNeverCrash)
{
  E57Made scan =
      lineScan(40, named("a") + "<pose type=\"Structure\"><rotation type=\"Structure\"><w>1</w></rotation></pose>");
  std::vector<std::uint64_t> bits(40, 1);
  scan.columns.push_back(integerColumn("intensity", "minimum=\"-3\" maximum=\"90\" scale=\"0.5\"", 7, bits));
  scan.columns.push_back(integerColumn("cartesianInvalidState", "minimum=\"0\" maximum=\"2\"", 2, bits));
  for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
    scan.columns.push_back(integerColumn(name, "minimum=\"0\" maximum=\"65535\"", 16, bits));
  scan.piece = [](std::size_t, std::size_t packet) { return 10 + packet; };
  scan.other_packets = true;
  // Behind right checksums: the parser is to be reached.
  fuzz("a.e57", makeE57Logical({scan}), kFuzzRounds, 1, [](const std::string& logical) { return toPages(logical); });
}

// ---------------------------------------------------------------------------------------------------------------------
// Files of other programs

class RealE57 : public E57 {
protected:
  void
  SetUp() override
  {
    E57::SetUp();
    const std::filesystem::path data = PCL_SSFR_TEST_DATA_DIR;
    folder_ = data.empty() ? data : data.parent_path() / "e57";
    if (!IsSkipped() && !std::filesystem::is_directory(folder_))
      GTEST_SKIP() << "no E57 files of other programs: there is no folder e57 next to PCL_SSFR_TEST_DATA_DIR";
  }
  std::string
  file(const std::string& name) const
  {
    return (folder_ / name).string();
  }
  std::string
  message(const std::string& name) const
  {
    try {
      io::loadCloud(file(name));
    }
    catch (const io::IoError& error) {
      return error.what();
    }
    return "read";
  }
  std::filesystem::path folder_;
};

TEST_F(RealE57, oneBunnyInEveryEncoding)
{
  const auto exact = io::loadCloud(file("bunnyDouble.e57"));
  ASSERT_EQ(exact.points->size(), 30571U);
  Eigen::Array3d low = Eigen::Array3d::Constant(1);
  Eigen::Array3d high = -low;
  for (const auto& point : *exact.points) {
    low = low.min(point.getArray3fMap().cast<double>());
    high = high.max(point.getArray3fMap().cast<double>());
  }
  // cartesianBounds of the file.
  EXPECT_TRUE(low.isApprox(Eigen::Array3d(-0.094689, 0.040011, -0.061873), 1e-6)) << low.transpose();
  EXPECT_TRUE(high.isApprox(Eigen::Array3d(0.061009, 0.187321, 0.058799), 1e-6)) << high.transpose();
  for (const char* name : {"bunnyFloat.e57", "bunnyInt19.e57", "bunnyInt21.e57", "bunnyInt32.e57"}) {
    const auto cloud = io::loadCloud(file(name));
    ASSERT_EQ(cloud.points->size(), exact.points->size()) << name;
    for (std::size_t i = 0; i < cloud.points->size(); ++i)
      for (const char* axis : {"x", "y", "z"})
        ASSERT_NEAR(valueOf(cloud, axis, i), valueOf(exact, axis, i), 0.6e-6) << name << ' ' << i;
  }
}

TEST_F(RealE57, smallFiles)
{
  const auto count = [this](const std::string& name) { return io::loadCloud(file(name)).points->size(); };
  EXPECT_EQ(count("empty_pc.e57"), 0U);
  EXPECT_EQ(count("original_guids.e57"), 1U);
  EXPECT_EQ(count("tiny_pc_and_images.e57"), 2U);
  EXPECT_FALSE(io::loadCloud(file("tiny_pc_and_images.e57")).T_file_scan) << "the pose in it is that of an image";
  EXPECT_EQ(count("las2e57_no_images_tag.e57"), 153U);
  EXPECT_EQ(count("cartesian_invalid_state_single.e57"), 1U); // of 3, as is the next
  EXPECT_EQ(count("tiny_spherical.e57"), 180U);               // of 360
  EXPECT_THAT(message("empty.e57"), HasSubstr("empty.e57: holds no scan"));
  EXPECT_THAT(message("corrupt_crc.e57"), HasSubstr("the checksum of page 33 (bytes from 33792) is wrong"));

  const auto ranged = io::loadCloud(file("integer_intensity.e57"));
  EXPECT_EQ((*ranged.points)[0].intensity, -66);
  EXPECT_EQ((*ranged.points)[1].intensity, 66);
  const auto scaled = io::loadCloud(file("scaled_integer_intensity.e57"));
  EXPECT_FLOAT_EQ((*scaled.points)[0].intensity, -66.6F);
  EXPECT_FLOAT_EQ((*scaled.points)[1].intensity, 66.6F);
  EXPECT_TRUE(io::loadCloud(file("tiny_pc_with_extension.e57")).has_normals);
  EXPECT_EQ(rgbOf(io::loadCloud(file("las2e57_no_images_tag.e57")), 5) & 0xFFU, 0xFFU);
}

TEST_F(RealE57, colouredAndSpherical)
{
  const auto coloured = io::loadCloud(file("tinyCartesianFloatRgb.e57"));
  ASSERT_EQ(coloured.points->size(), 2090U);
  Eigen::Array3f low = Eigen::Array3f::Constant(1e3F);
  for (const auto& point : *coloured.points)
    low = low.min(point.getArray3fMap());
  EXPECT_TRUE(low.isApprox(Eigen::Array3f(-9.77952957F, 4.5138793F, 295.524689F), 1e-6F)) << low.transpose();

  // Ends in a packet of one record behind one of 2650.
  EXPECT_EQ(io::loadCloud(file("read_error.e57")).points->size(), 2651U);

  const auto sphere = io::loadCloud(file("tiny_spherical.e57"));
  for (const auto& point : *sphere.points)
    EXPECT_TRUE(point.getVector3fMap().allFinite());
}

} // namespace
} // namespace pcl_ssfr::test_e57
