// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// What report.html holds. How it looks and works is report_browser_test.py's matter.

#include <apps/benchmark/report_html.h>
#include <apps/io/file_bytes.h>

#include <io_testing.h>
#include <made_up_results.h>

#include <gmock/gmock.h>

#include <regex>

namespace pcl_ssfr::apps::test_report_html {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;
using namespace pcl_ssfr::testing;

/// The content of the data element; a failure when it is not what a browser would read.
Json
dataOf(const std::string& page)
{
  static const std::string kBegin = R"(<script type="application/json" id="data">)";
  const std::size_t begin = page.find(kBegin);
  if (begin == std::string::npos || page.find(kBegin, begin + 1) != std::string::npos) {
    ADD_FAILURE() << "no data element, or two";
    return {};
  }
  const std::size_t end = page.find("</script", begin);
  return Json::parse(page.substr(begin + kBegin.size(), end - begin - kBegin.size()), nullptr, false);
}

std::size_t
count(const std::string& text, const std::string& part)
{
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++n;
  return n;
}

std::vector<std::int16_t>
decode(const std::string& text)
{
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  unsigned held = 0;
  for (const char c : text) {
    if (c == '=')
      break;
    bits = (bits << 6U) | static_cast<unsigned>(alphabet.find(c));
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes += static_cast<char>((bits >> held) & 0xffU);
    }
  }
  std::vector<std::int16_t> values;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
    values.push_back(io::valueAt<std::int16_t>(bytes, i));
  return values;
}

Eigen::Isometry3d
poseOf(const Json& json)
{
  const auto v = json.get<std::vector<double>>();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(v.at(0), v.at(1), v.at(2), v.at(3)).toRotationMatrix();
  T.translation() << v.at(4), v.at(5), v.at(6);
  return T;
}

// ---------------------------------------------------------------------------------------------------------------------
// The page

TEST(ReportHtml, isOneFileThatLoadsNothing)
{
  const std::string page = reportHtml(makeUpResults({}), {});
  EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0U);
  // Elements, styles and scripts that would load something; addresses in comments and licences do not.
  const std::regex loads(
      R"re(<link[^>]*href="(?!data:)|<(script|img|iframe|object|embed|audio|video|source)[^>]*\ssrc=|@import|url\(\s*['"]?(?!data:)[a-z]|\bfetch\(|XMLHttpRequest|importScripts|\bimport\(|new\s+(WebSocket|EventSource|Worker)|sendBeacon|sourceMappingURL)re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(page, found, loads)) << found.str();
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, HasSubstr("Chart.js v"));
  EXPECT_THAT(page, HasSubstr("Permission is hereby granted"));
  EXPECT_THAT(page, Not(HasSubstr("@@")));
  EXPECT_LT(page.size(), 1U << 20U);
}

TEST(ReportHtml, hostileNamesStayText)
{
  const std::string plain = reportHtml(makeUpResults({}), {});
  const BenchmarkResults results = makeUpHostileResults();
  const std::string page = reportHtml(results, makeUpPictures({}, 1));
  EXPECT_EQ(count(page, "</script"), count(plain, "</script"));
  EXPECT_EQ(count(page, "<script"), count(plain, "<script"));
  EXPECT_EQ(count(page, "<!--"), count(plain, "<!--"));
  EXPECT_EQ(count(page, "<img"), 0U);
  const Json data = dataOf(page);
  ASSERT_FALSE(data.is_discarded());
  for (std::size_t i = 0; i + 1 < hostileNames().size(); ++i) { // as they were; the last is no text
    EXPECT_EQ(data["methods"][i], hostileNames()[i]);
    EXPECT_EQ(data["datasets"][i], hostileNames()[i]);
  }
  EXPECT_EQ(data["methods"].back(), "no \xef\xbf\xbd\xef\xbf\xbd text");
  EXPECT_EQ(data["rows"].size(), results.rows.size());
}

TEST(ReportHtml, nothingRanYet)
{
  const Json data = dataOf(reportHtml(summarize({}, {}, {}), {}));
  ASSERT_TRUE(data.is_object());
  EXPECT_EQ(data["rows"].size(), 0U);
  EXPECT_EQ(data["groups"].size(), 0U);
}

TEST(ReportHtml, unknownNumbersAreNull)
{
  ResultRow row;
  row.dataset = "d";
  row.method = "m";
  row.status = "crashed";
  row.time_s = std::numeric_limits<double>::infinity();
  const Json data = dataOf(reportHtml(summarize({row}, {}, {}), {}));
  ASSERT_TRUE(data.is_object());
  for (std::size_t column = 9; column <= 17; ++column)
    EXPECT_TRUE(data["rows"][0][column].is_null()) << column;
  EXPECT_TRUE(data["groups"][0]["time_box"].is_null());
  EXPECT_TRUE(data["groups"][0]["degrees"].is_null());
  EXPECT_EQ(data["groups"][0]["failures"]["crashed"], 1);
}

TEST(ReportHtml, isReplacedAsAWhole)
{
  const TemporaryFolder folder;
  io::writeFile(folder.file("report.html"), "old");
  writeReport(folder.file(""), makeUpResults({}), {});
  EXPECT_TRUE(dataOf(io::readFile(folder.file("report.html"))).is_object());
  EXPECT_FALSE(std::filesystem::exists(folder.file("report.html.new")));
  EXPECT_THROW(writeReport(folder.file("no such folder"), makeUpResults({}), {}), io::IoError);
}

// ---------------------------------------------------------------------------------------------------------------------
// The numbers

TEST(ReportJson, curvesCountPairsWithinEachThreshold)
{
  const BenchmarkResults results = makeUpResults({});
  const Json json = reportJson(results, {});
  ASSERT_EQ(json["groups"].size(), 3U * 7U); // two datasets and both together
  for (const Json& group : json["groups"]) {
    const int d = group["dataset"].get<int>();
    const std::string method = json["methods"][group["method"].get<std::size_t>()];
    std::vector<const ResultRow*> rows;
    for (const ResultRow& row : results.rows)
      if (row.method == method && (d < 0 || row.dataset == json["datasets"][static_cast<std::size_t>(d)]))
        rows.push_back(&row);
    ASSERT_EQ(group["success"][1], rows.size());
    const auto& bounds = json["degree_bounds"];
    ASSERT_EQ(bounds.size(), group["degree_curve"].size());
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      std::size_t within = 0;
      for (const ResultRow* row : rows)
        within += row->T_target_source && row->rotation_error_deg <= bounds[i].get<double>() ? 1 : 0;
      const double share = static_cast<double>(within) / static_cast<double>(rows.size());
      EXPECT_NEAR(group["degree_curve"][i].get<double>(), share, 1.01 / static_cast<double>(rows.size())) << i;
    }
    // At the end all that have an answer: 180 degrees.
    const auto answered = static_cast<double>(
        std::count_if(rows.begin(), rows.end(), [](const ResultRow* row) { return bool(row->T_target_source); }));
    EXPECT_NEAR(group["degree_curve"].back().get<double>(), answered / static_cast<double>(rows.size()), 1e-4);
    const auto box = group["time_box"].get<std::vector<double>>();
    EXPECT_TRUE(std::is_sorted(box.begin(), box.end()));
    EXPECT_NEAR(box.at(2), group["time"].get<double>(), 1e-4 * box.at(2));
  }
}

TEST(ReportJson, largeRunsListWhatFailedFirst)
{
  std::vector<ResultRow> rows(kReportRows + 1000);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].dataset = "d";
    rows[i].method = "m";
    rows[i].pair = i;
    rows[i].status = "converged";
    rows[i].converged = true;
    rows[i].success = i < kReportRows + 500; // the last 500 failed
  }
  const Json json = reportJson(summarize(rows, {}, {}), {});
  ASSERT_EQ(json["rows"].size(), kReportRows);
  EXPECT_EQ(json["rows_total"], rows.size());
  std::size_t failed = 0;
  for (const Json& row : json["rows"])
    failed += row[6] == 0 ? 1 : 0;
  EXPECT_EQ(failed, 500U);
  EXPECT_EQ(json["groups"][0]["success"][0], kReportRows + 500);
}

TEST(ReportJson, sweepsGoAlongVariationsThatHaveAllElseInCommon)
{
  MadeUpRun run;
  run.resolutions = {0.1, 0.2};
  run.also_mirrored = true;
  const Json variations = reportJson(makeUpResults(run), {})["variations"];
  ASSERT_EQ(variations.size(), 4U);
  for (const Json& a : variations)
    for (const Json& b : variations) {
      const auto isMirrored = [](const Json& v) {
        return v["text"].get<std::string>().find("mirrored") != std::string::npos;
      };
      EXPECT_EQ(a["rest"] == b["rest"], isMirrored(a) == isMirrored(b)) << a << b;
    }
}

TEST(ReportJson, theStageThatLostTheTruthIsTheLastColumn)
{
  BenchmarkResults results = makeUpResults(MadeUpRun());
  results.rows.front().lost_at = "translation";
  const Json json = reportJson(results, ReportPictures());
  EXPECT_EQ(json["rows"][0].back(), "translation");
  EXPECT_EQ(json["rows"][1].back(), "");
}

// ---------------------------------------------------------------------------------------------------------------------
// The pictures

TEST(ReportJson, posesPutTheDrawnPointsWhereTheMethodDid)
{
  MadeUpRun run;
  run.perturbation = Perturbation::Se3;
  const BenchmarkResults results = makeUpResults(run);
  ReportPictures pictures = makeUpPictures(run, 3);
  pictures.clouds[0].origin << 691234.5, 5338000.25, 512; // a map's coordinates
  const Json json = reportJson(results, pictures);
  const Eigen::Vector3d drawn(0.3, -1.2, 0.8); // relative to the middle of the source, as in the file
  std::size_t compared = 0;
  for (std::size_t i = 0; i < results.rows.size(); ++i) {
    const ResultRow& row = results.rows[i];
    const Json& fields = json["rows"][i];
    if (row.pair >= 3) {
      EXPECT_TRUE(fields[19].is_null());
      continue;
    }
    const ReportCloud& source = pictures.clouds[row.pair + 1];
    const ReportCloud& target = pictures.clouds[row.pair];
    const Eigen::Vector3d in_file = source.origin + drawn;
    // The method got the file's points moved so that its truth differs from the file's.
    const Eigen::Vector3d given = row.truth->inverse() * (truthOfPair(row.pair) * in_file);
    const Json& pair = json["pairs"][row.dataset == run.datasets[0] ? row.pair : 3 + row.pair];
    ASSERT_EQ(pair["pair"], row.pair);
    EXPECT_EQ(json["datasets"][pair["dataset"].get<std::size_t>()], row.dataset);
    const double tolerance = 1e-6 * target.origin.norm() + 1e-4;
    EXPECT_LT((poseOf(pair["before"]["0"]) * drawn - (given - target.origin)).norm(), tolerance);
    EXPECT_LT((poseOf(pair["truth"]) * drawn - (truthOfPair(row.pair) * in_file - target.origin)).norm(), tolerance);
    if (row.T_target_source) {
      EXPECT_LT((poseOf(fields[19]) * drawn - (*row.T_target_source * given - target.origin)).norm(), tolerance);
      ++compared;
    }
    else {
      EXPECT_TRUE(fields[19].is_null());
    }
  }
  EXPECT_GT(compared, 20U);
}

TEST(ReportJson, pointsComeBackFromText)
{
  ReportPictures pictures;
  for (const std::vector<std::int16_t>& values :
       {std::vector<std::int16_t>{}, {-32768, 32767, 0}, {1, 2, 3, -4, -5, -6}, {7, 8, 9, 10, 11, 12, -13, 14, 15}}) {
    pictures.clouds.push_back({});
    pictures.clouds.back().step = 0.001;
    pictures.clouds.back().coordinates = values;
  }
  const Json json = reportJson(makeUpResults({}), pictures);
  for (std::size_t i = 0; i < pictures.clouds.size(); ++i)
    EXPECT_EQ(decode(json["clouds"][i]["points"].get<std::string>()), pictures.clouds[i].coordinates);
}

io::LoadedCloud
gridCloud(int side, double spacing)
{
  io::LoadedCloud cloud;
  cloud.offset << 1000, 2000, 0;
  cloud.points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZINormal>>();
  for (int i = 0; i < side * side; ++i) {
    const int row = i / side;
    pcl::PointXYZINormal point{};
    point.x = static_cast<float>(spacing * (i % side));
    point.y = static_cast<float>(spacing * row);
    cloud.points->push_back(point);
  }
  return cloud;
}

TEST(ReportCloud, isThinnedEvenly)
{
  io::LoadedCloud cloud = gridCloud(300, 0.02); // 6 m x 6 m
  cloud.points->front().x = std::numeric_limits<float>::quiet_NaN();
  cloud.points->back().x = 5000; // an echo from far away
  const ReportCloud drawn = makeReportCloud(cloud);
  EXPECT_NEAR(drawn.origin.x(), 1003, 0.1);
  EXPECT_NEAR(drawn.origin.y(), 2003, 0.1);
  ASSERT_EQ(drawn.coordinates.size(), 3U * 1500U);
  int quarters[4] = {};
  for (std::size_t i = 0; i < drawn.coordinates.size(); i += 3) {
    const double x = drawn.coordinates[i] * drawn.step;
    const double y = drawn.coordinates[i + 1] * drawn.step;
    EXPECT_LT(std::max(std::abs(x), std::abs(y)), 3.1);
    EXPECT_EQ(drawn.coordinates[i + 2], 0);
    ++quarters[(x < 0 ? 0 : 1) + (y < 0 ? 0 : 2)];
  }
  for (const int quarter : quarters)
    EXPECT_NEAR(quarter, 375, 60);
}

TEST(ReportCloud, ofNothingIsEmpty)
{
  io::LoadedCloud cloud = gridCloud(0, 1);
  EXPECT_TRUE(makeReportCloud(cloud).coordinates.empty());
  cloud = gridCloud(1, 1);
  EXPECT_EQ(makeReportCloud(cloud).coordinates.size(), 3U); // a single place
  cloud.points->front().x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(makeReportCloud(cloud).coordinates.empty());
}

TEST(ReportPictures, thoseThatFailedMostComeFirst)
{
  const TemporaryFolder folder;
  io::DatasetFolder dataset;
  dataset.path = folder.file("");
  dataset.name = "d";
  for (int i = 0; i < 5; ++i)
    io::writeFile(folder.file(std::to_string(i) + ".xyz"), "1 2 3\n4 5 6\n");
  for (int i = 0; i < 4; ++i)
    dataset.pairs.push_back({std::to_string(i + 1) + ".xyz", std::to_string(i) + ".xyz", truthOfPair(0)});
  dataset.pairs.push_back({"gone.xyz", "0.xyz", truthOfPair(0)});
  std::vector<ResultRow> rows;
  for (const std::size_t pair : {0, 1, 1, 2, 3, 4, 4, 4}) {
    rows.emplace_back();
    rows.back().dataset = "d";
    rows.back().pair = pair;
    rows.back().success = pair == 0;
  }
  const ReportPictures pictures = loadReportPictures(rows, {dataset}, 3);
  ASSERT_EQ(pictures.pairs.size(), 3U); // the pair that cannot be read has none
  EXPECT_EQ(pictures.pairs[0].pair, 1U);
  EXPECT_EQ(pictures.pairs[1].pair, 2U);
  EXPECT_EQ(pictures.pairs[2].pair, 3U);
  EXPECT_EQ(pictures.pairs[0].source, pictures.pairs[1].target); // scan 2, once
  EXPECT_TRUE(loadReportPictures(rows, {dataset}, 0).clouds.empty());
}

} // namespace
} // namespace pcl_ssfr::apps::test_report_html
