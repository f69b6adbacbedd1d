// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Datasets, plans, rows and the folder of results: what is checked before a run, and what survives one.

#include <apps/benchmark/benchmark_options.h>
#include <apps/benchmark/benchmark_plan.h>
#include <apps/benchmark/results_store.h>
#include <apps/common/utf8_text.h>
#include <apps/io/csv_line.h>
#include <apps/io/dataset_folder.h>
#include <apps/io/file_bytes.h>
#include <apps/pairs/result_row.h>

#include <io_testing.h>

#include <gmock/gmock.h>

#include <filesystem>
#include <functional>

namespace pcl_ssfr::apps::test_benchmark_table {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;
using Json = nlohmann::ordered_json;

std::string
messageOf(const std::function<void()>& action)
{
  try {
    action();
  }
  catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

// ---------------------------------------------------------------------------------------------------------------------
// CSV

TEST(CsvLine, splitsAndQuotes)
{
  EXPECT_THAT(io::splitCsvLine("a, b ,,\"c,d\",\"say \"\"hi\"\"\"\r"), ElementsAre("a", "b", "", "c,d", "say \"hi\""));
  EXPECT_THAT(io::splitCsvLine(""), ElementsAre(""));
  for (const std::string text : {"plain", "a,b", "\"", "a \"b\", c", " blanks ", "", "ä"})
    EXPECT_THAT(io::splitCsvLine(io::csvField(text) + ",end"), ElementsAre(text, "end"));
  EXPECT_EQ(io::csvField("two\nlines"), "two lines");
}

TEST(CsvLine, isUtf8WhateverTheBytes)
{
  EXPECT_EQ(io::csvField("B\xfcro"), "B\xef\xbf\xbdro");
  EXPECT_EQ(io::csvField("cut \xc3"), "cut \xef\xbf\xbd");
}

TEST(Utf8Text, isKeptAndTheRestReplaced)
{
  // The smallest and largest characters of each length.
  for (const std::string text : {"",
                                 "a",
                                 "\xc2\x80",
                                 "\xdf\xbf",
                                 "\xe0\xa0\x80",
                                 "\xed\x9f\xbf",
                                 "\xef\xbf\xbf",
                                 "\xf0\x90\x80\x80",
                                 "\xf4\x8f\xbf\xbf"})
    EXPECT_EQ(validUtf8(text + "|" + text), text + "|" + text);
  // Too long for its value, a surrogate, beyond the last character, cut, bytes that nothing begins with.
  for (const std::string text :
       {"\xc0\x80", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\xff", "\x80"}) {
    const std::string valid = validUtf8("a" + text + "b");
    std::string replaced; // one character in place of the sequence, or of each of its bytes
    while (replaced.size() + 2 < valid.size())
      replaced += "\xef\xbf\xbd";
    EXPECT_EQ(valid, "a" + replaced + "b");
    EXPECT_FALSE(replaced.empty());
    EXPECT_LE(replaced.size(), 3 * text.size());
    EXPECT_EQ(validUtf8(text), replaced);
  }
}

TEST(Utf8Text, isCutBetweenCharacters)
{
  const std::string text = "a\xc3\xa4\xe2\x82\xac";
  EXPECT_EQ(utf8Prefix(text, 99), text);
  EXPECT_EQ(utf8Prefix(text, 6), text);
  for (const std::size_t length : {3, 4, 5})
    EXPECT_EQ(utf8Prefix(text, length), "a\xc3\xa4") << length;
  for (const std::size_t length : {1, 2})
    EXPECT_EQ(utf8Prefix(text, length), "a") << length;
  EXPECT_EQ(utf8Prefix(text, 0), "");
}

TEST(ResultRow, comesBackFromItsLine)
{
  ResultRow row;
  row.dataset = "a, \"b\"";
  row.source = "s.pcd";
  row.target = "t.pcd";
  row.method = "ssfr";
  row.status = "converged";
  row.message = "first\nsecond, third";
  row.converged = true;
  row.rotation_error_deg = 0.125;
  row.time_s = 1e-3;
  row.pair = 12;
  row.seed = 18446744073709551557ULL;
  row.variation = {0.05, 0.01, 0.1, 0.5, Perturbation::Se3, PairsFrom::All, 50, true, true, {3, 240, 0.5}};
  row.target_dataset = "other, place";
  row.right_rank = 3;
  row.lost_at = "translation";
  row.T_target_source = Eigen::Isometry3d(Eigen::Translation3d(691234.123456789, 1. / 3, 0) *
                                          Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  const std::string line = toCsvLine(row);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const ResultRow back = rowFromCsv(line);
  EXPECT_EQ(back.dataset, row.dataset);
  EXPECT_EQ(back.message, "first second, third");
  EXPECT_EQ(back.seed, row.seed);
  EXPECT_EQ(back.variation.perturbation, Perturbation::Se3);
  EXPECT_EQ(back.target_dataset, "other, place");
  EXPECT_EQ(back.right_rank, 3);
  EXPECT_EQ(back.lost_at, "translation");
  EXPECT_TRUE(std::isnan(back.rmse_m));
  EXPECT_FALSE(back.truth);
  ASSERT_TRUE(back.T_target_source);
  EXPECT_EQ(back.T_target_source->translation(), row.T_target_source->translation());
  EXPECT_EQ(toCsvLine(back), line);
  EXPECT_EQ(io::splitCsvLine(line).size(), io::splitCsvLine(csvHeader()).size());
}

TEST(ResultRow, headerBeginsAsScriptsRelyOn)
{
  EXPECT_THAT(csvHeader(),
              StartsWith("dataset,source,target,method,status,converged,success,rotation_error_deg,translation_error_m,"
                         "rmse_m,gt_rmse_m,overlap,confidence,time_s,cpu_s,peak_rss_mib,message,T00,T01,T02,T03,"));
}

TEST(ResultRow, errorsNameTheColumn)
{
  EXPECT_THAT(messageOf([] { rowFromCsv("a,b"); }), HasSubstr("2 columns"));
  const std::string line = toCsvLine(ResultRow());
  ASSERT_THAT(line, StartsWith(",,,,,0,0,"));
  EXPECT_EQ(messageOf([&] { rowFromCsv("d,s,t,m,st,yes,0," + line.substr(9)); }),
            "column converged: 'yes' is not 0 or 1");
  EXPECT_EQ(messageOf([&] { rowFromCsv(",,,,,0,0,1o," + line.substr(10)); }),
            "column rotation_error_deg: '1o' is not a number");
}

// ---------------------------------------------------------------------------------------------------------------------
// Datasets

class Dataset : public ::testing::Test {
protected:
  static constexpr const char* kHeader = "source,target,extra,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n";
  static constexpr const char* kGood = "a.xyz,b.xyz,x,1,0,0,1.5,0,1,0,0,0,0,1,0\n";

  Dataset()
  {
    io::writeFile(folder_.file("a.xyz"), "1 2 3\n");
    std::filesystem::create_directory(folder_.file("scans"));
    io::writeFile(folder_.file("scans/b.xyz"), "1 2 3\n");
  }
  std::string
  error(const std::string& pairs, const std::string& json = "")
  {
    io::writeFile(folder_.file("pairs.csv"), pairs);
    if (!json.empty())
      io::writeFile(folder_.file("dataset.json"), json);
    return messageOf([this] { io::readDatasetFolder(folder_.file("")); });
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Dataset, isReadWithAndWithoutDescription)
{
  EXPECT_EQ(error(std::string(kHeader) + kGood + "\n"), "nothing was thrown");
  const io::DatasetFolder plain = io::readDatasetFolder(folder_.file(""));
  EXPECT_EQ(plain.success_rotation_deg, 2);
  EXPECT_TRUE(plain.sensor_at_origin);
  ASSERT_EQ(plain.pairs.size(), 1U);
  EXPECT_EQ(plain.pairs[0].T_target_source.translation().x(), 1.5);
  EXPECT_THAT(io::scanPath(plain.path, "b.xyz"), EndsWith("scans/b.xyz"));
  EXPECT_EQ(error(std::string(kHeader) + kGood,
                  R"({"name": "n", "viewpoint": "unknown", "success": {"rotation_deg": 5, "translation_m": 1}})"),
            "nothing was thrown");
  const io::DatasetFolder described = io::readDatasetFolder(folder_.file(""));
  EXPECT_EQ(described.name, "n");
  EXPECT_FALSE(described.sensor_at_origin);
  EXPECT_EQ(described.success_translation_m, 1);
}

TEST_F(Dataset, errorsNameFileLineAndColumn)
{
  const std::string head = kHeader;
  EXPECT_THAT(error(""), HasSubstr("pairs.csv: is empty"));
  EXPECT_THAT(error(head), HasSubstr("holds no pair"));
  EXPECT_THAT(error("source,target\n"), AllOf(HasSubstr("pairs.csv:1:"), HasSubstr("T00")));
  EXPECT_THAT(error("a,b,c\n"), AllOf(HasSubstr("pairs.csv:1:"), HasSubstr("source")));
  EXPECT_THAT(error(head + kGood + "a.xyz,b.xyz,x,1,0,zero,1.5,0,1,0,0,0,0,1,0\n"),
              AllOf(HasSubstr("pairs.csv:3: column T02"), HasSubstr("'zero'")));
  EXPECT_THAT(error(head + "a.xyz,b.xyz,x,1,0,inf,1.5,0,1,0,0,0,0,1,0\n"), HasSubstr("pairs.csv:2: column T02"));
  EXPECT_THAT(error(head + "a.xyz,none.xyz,x,1,0,0,1.5,0,1,0,0,0,0,1,0\n"),
              AllOf(HasSubstr("pairs.csv:2: column target"), HasSubstr("none.xyz")));
  EXPECT_THAT(error(head + "a.xyz,b.xyz,x,2,0,0,1.5,0,1,0,0,0,0,1,0\n"),
              AllOf(HasSubstr("pairs.csv:2: columns T00 to T23"), HasSubstr("rigid motion")));
  EXPECT_THAT(error(head + "a.xyz,b.xyz,x,-1,0,0,1.5,0,1,0,0,0,0,1,0\n"), HasSubstr("rigid motion"));
  EXPECT_THAT(error(head + "a.xyz,b.xyz\n"), AllOf(HasSubstr("pairs.csv:2: 2 columns"), HasSubstr("15")));
  EXPECT_THAT(error(head + kGood, "[1]"), HasSubstr("dataset.json"));
  EXPECT_THAT(error(head + kGood, "{"), HasSubstr("dataset.json: is not JSON"));
  EXPECT_THAT(error(head + kGood, R"({"name": ""})"), HasSubstr("name: \"\" is empty"));
  EXPECT_THAT(error(head + kGood, R"({"name": "a\nb"})"), HasSubstr(R"(name: "a\nb")"));
  EXPECT_THAT(error(head + kGood, R"({"viewpoint": "here"})"), HasSubstr("viewpoint: 'here'"));
  EXPECT_THAT(error(head + kGood, R"({"success": {"rotation_deg": -1}})"), HasSubstr("success.rotation_deg: '-1'"));
}

// ---------------------------------------------------------------------------------------------------------------------
// Arguments and plans

std::string
usageError(std::vector<std::string> arguments)
{
  return messageOf([&] { parseBenchmarkArguments(arguments); });
}

TEST(BenchmarkOptions, errorsNameWhatIsWrong)
{
  EXPECT_EQ(usageError({}), "--dataset is missing");
  EXPECT_EQ(usageError({"--dataset", "d"}), "--out is missing");
  const std::vector<std::string> good{"--dataset", "d", "--out", "o"};
  const auto with = [&good](std::vector<std::string> more) {
    more.insert(more.end(), good.begin(), good.end());
    return usageError(more);
  };
  EXPECT_EQ(with({}), "nothing was thrown");
  EXPECT_THAT(with({"--frobnicate"}), HasSubstr("--frobnicate"));
  EXPECT_THAT(with({"--jobs", "0"}), HasSubstr("--jobs: '0'"));
  EXPECT_THAT(with({"--every", "x"}), HasSubstr("--every: 'x'"));
  EXPECT_THAT(with({"--timeout=-1"}), HasSubstr("--timeout: '-1'"));
  EXPECT_THAT(with({"--pairs", "1,b"}), HasSubstr("--pairs: 'b'"));
  EXPECT_THAT(with({"--perturb", "much"}), HasSubstr("--perturb: 'much'"));
  EXPECT_THAT(with({"--overlap", "0.5,1.5"}), HasSubstr("--overlap: '1.5'"));
  EXPECT_THAT(with({"--resolution", "nan"}), HasSubstr("--resolution: 'nan'"));
  EXPECT_THAT(with({"--random-rotation", "--perturb", "se3"}),
              HasSubstr("--random-rotation contradicts --perturb se3"));
  EXPECT_THAT(with({"--pairs-from", "some"}), HasSubstr("--pairs-from: 'some'"));
  EXPECT_THAT(with({"--origin-offset=-1"}), HasSubstr("--origin-offset: '-1'"));
  EXPECT_THAT(with({"--degrade-every", "0"}), HasSubstr("--degrade-every: '0'"));
  EXPECT_THAT(with({"--degrade-sector", "361"}), HasSubstr("--degrade-sector: '361'"));
  EXPECT_THAT(with({"--degrade-nearest", "0"}), HasSubstr("--degrade-nearest: '0'"));
}

TEST(BenchmarkOptions, listsAreRead)
{
  const BenchmarkArguments arguments = parseBenchmarkArguments({"--dataset",
                                                                "a",
                                                                "b",
                                                                "--methods",
                                                                "ssfr,gicp",
                                                                "--out",
                                                                "o",
                                                                "--pairs",
                                                                "0,3",
                                                                "--resolution",
                                                                "0,0.1",
                                                                "--resume",
                                                                "--perturb",
                                                                "se3"});
  EXPECT_THAT(arguments.datasets, ElementsAre("a", "b"));
  EXPECT_THAT(arguments.methods, ElementsAre("ssfr", "gicp"));
  EXPECT_THAT(arguments.pairs, ElementsAre(0, 3));
  EXPECT_THAT(arguments.resolutions, ElementsAre(0, 0.1));
  EXPECT_TRUE(arguments.resume);
  EXPECT_EQ(arguments.variation.perturbation, Perturbation::Se3);
}

TEST(BenchmarkOptions, variationsAreRead)
{
  const Variation variation = parseBenchmarkArguments({"--dataset",
                                                       "a",
                                                       "--out",
                                                       "o",
                                                       "--random-rotation",
                                                       "--pairs-from",
                                                       "unlisted",
                                                       "--origin-offset",
                                                       "50",
                                                       "--merge-target",
                                                       "--mirror-source",
                                                       "--degrade-every",
                                                       "5",
                                                       "--degrade-sector",
                                                       "240",
                                                       "--degrade-nearest",
                                                       "0.65"})
                                  .variation;
  EXPECT_EQ(variation.perturbation, Perturbation::Rotation);
  EXPECT_EQ(variation.pairs_from, PairsFrom::Unlisted);
  EXPECT_EQ(variation.origin_offset_m, 50);
  EXPECT_TRUE(variation.merge_target);
  EXPECT_TRUE(variation.mirror_source);
  EXPECT_EQ(variation.degradation.every, 5U);
  EXPECT_EQ(variation.degradation.sector_deg, 240);
  EXPECT_EQ(variation.degradation.nearest, 0.65);
  EXPECT_TRUE(
      parseBenchmarkArguments({"--dataset", "a", "--out", "o", "--degrade-sector", "360", "--degrade-nearest", "1"})
          .variation.degradation.keepsAll());
}

TEST(BenchmarkOptions, helpNamesEveryMethodAndParameter)
{
  const std::string help = benchmarkHelp();
  for (const Method& method : methods())
    EXPECT_THAT(help, HasSubstr(method.name));
  for (const Parameter& parameter : parameterTable())
    EXPECT_THAT(help, HasSubstr(parameter.name));
}

class Plan : public Dataset {
protected:
  BenchmarkArguments
  arguments()
  {
    io::writeFile(folder_.file("pairs.csv"), std::string(kHeader) + kGood + kGood + kGood);
    BenchmarkArguments result;
    result.datasets = {folder_.file("")};
    result.methods = {"ssfr", "gicp"};
    result.out = folder_.file("out");
    return result;
  }
};

TEST_F(Plan, isEveryCombination)
{
  BenchmarkArguments wanted = arguments();
  wanted.resolutions = {0, 0.1, 0.1};
  wanted.every = 2;
  const BenchmarkPlan plan = makePlan(wanted);
  EXPECT_EQ(plan.pairs.size(), 4U); // rows 0 and 2, two resolutions
  std::set<std::string> keys;
  for (std::size_t p = 0; p < plan.pairs.size(); ++p)
    for (std::size_t m = 0; m < plan.methods.size(); ++m)
      keys.insert(plan.key(p, m));
  EXPECT_EQ(keys.size(), 8U);
}

TEST_F(Plan, takesPairsThatAreNotListed)
{
  BenchmarkArguments wanted = arguments();
  for (const char* scan : {"c.xyz", "d.xyz", "e.xyz"})
    io::writeFile(folder_.file(scan), "1 2 3\n");
  const auto line = [](const std::string& names) { return names + ",x,1,0,0,1.5,0,1,0,0,0,0,1,0\n"; };
  // a -> b -> c, d -> b; e -> e apart from them.
  io::writeFile(folder_.file("pairs.csv"),
                kHeader + line("a.xyz,b.xyz") + line("b.xyz,c.xyz") + line("d.xyz,b.xyz") + line("e.xyz,e.xyz"));
  const auto planned = [&] {
    std::vector<std::string> names;
    for (const PlannedPair& pair : makePlan(wanted).pairs)
      names.push_back(pair.source.substr(0, 1) + pair.target.substr(0, 1) +
                      (pair.request.T_target_source ? "" : " unknown"));
    return names;
  };
  wanted.variation.pairs_from = PairsFrom::All;
  EXPECT_THAT(
      planned(),
      UnorderedElementsAre("ab", "bc", "ac", "db", "ad", "cd", "ae unknown", "be unknown", "ce unknown", "de unknown"));
  wanted.overlaps = {0.5};
  EXPECT_THAT(messageOf([&] { makePlan(wanted); }), AllOf(HasSubstr("--overlap"), HasSubstr("e.xyz")));
  wanted.overlaps = {};
  wanted.pairs = {10};
  EXPECT_THAT(messageOf([&] { makePlan(wanted); }), HasSubstr("rows 0 to 9"));
  wanted.pairs = {};
  wanted.variation.pairs_from = PairsFrom::Unlisted;
  EXPECT_THAT(planned(), UnorderedElementsAre("ba", "cb", "bd", "ac", "ca", "ad", "da", "cd", "dc"));
  wanted.variation.pairs_from = PairsFrom::Unrelated;
  EXPECT_THAT(messageOf([&] { makePlan(wanted); }), HasSubstr("two datasets"));
  wanted.variation.pairs_from = PairsFrom::Listed;
  wanted.variation.merge_target = true;
  EXPECT_THAT(planned(), ElementsAre("ab", "db")); // two scans lie in b
  EXPECT_THAT(makePlan(wanted).pairs[0].request.merged->path, EndsWith("d.xyz"));
}

TEST_F(Plan, pairsTheSourcesOfOneDatasetWithTheTargetsOfTheNext)
{
  BenchmarkArguments wanted = arguments();
  const testing::TemporaryFolder other;
  io::writeFile(other.file("p.xyz"), "1 2 3\n");
  io::writeFile(other.file("q.xyz"), "1 2 3\n");
  io::writeFile(other.file("pairs.csv"), std::string(kHeader) + "p.xyz,q.xyz,x,1,0,0,1.5,0,1,0,0,0,0,1,0\n");
  wanted.datasets.push_back(other.file(""));
  wanted.variation.pairs_from = PairsFrom::Unrelated;
  const BenchmarkPlan plan = makePlan(wanted);
  ASSERT_EQ(plan.pairs.size(), 4U); // three rows of the first, one of the second
  EXPECT_EQ(plan.pairs[2].source, "a.xyz");
  EXPECT_EQ(plan.pairs[2].target, "q.xyz");
  EXPECT_EQ(plan.pairs[2].target_dataset, plan.datasets[1].name);
  EXPECT_EQ(plan.pairs[3].source, "p.xyz");
  EXPECT_EQ(plan.pairs[3].target, "b.xyz");
  for (const PlannedPair& pair : plan.pairs)
    EXPECT_FALSE(pair.request.T_target_source);
}

TEST_F(Plan, datasetsOfOneNameGoByTheirFolders)
{
  BenchmarkArguments wanted = arguments();
  const testing::TemporaryFolder other;
  for (const testing::TemporaryFolder* folder :
       std::initializer_list<const testing::TemporaryFolder*>{&folder_, &other}) {
    io::writeFile(folder->file("a.xyz"), "1 2 3\n");
    io::writeFile(folder->file("pairs.csv"), std::string(kHeader) + "a.xyz,a.xyz,x,1,0,0,1.5,0,1,0,0,0,0,1,0\n");
    io::writeFile(folder->file("dataset.json"), R"({"name": "place"})");
  }
  EXPECT_EQ(makePlan(wanted).datasets[0].name, "place");
  wanted.datasets.push_back(other.file(""));
  const BenchmarkPlan plan = makePlan(wanted);
  EXPECT_NE(plan.datasets[0].name, plan.datasets[1].name);
  EXPECT_THAT(other.file(""), HasSubstr(plan.datasets[1].name));
  const std::vector<io::DatasetFolder> read = readDatasets(wanted.datasets);
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < read.size(); ++i)
    EXPECT_EQ(read[i].name, plan.datasets[i].name);
}

TEST_F(Plan, namesOfDatasetsAreUtf8)
{
  const std::string folder = folder_.file("B\xfcro");
  std::filesystem::create_directory(folder);
  io::writeFile(folder + "/a.xyz", "1 2 3\n");
  io::writeFile(folder + "/pairs.csv", std::string(kHeader) + "a.xyz,a.xyz,x,1,0,0,1.5,0,1,0,0,0,0,1,0\n");
  EXPECT_EQ(readDatasets({folder}).front().name, "B\xef\xbf\xbdro");
}

TEST_F(Plan, errorsComeBeforeWork)
{
  const auto error = [this](const std::function<void(BenchmarkArguments&)>& change) {
    BenchmarkArguments wanted = arguments();
    change(wanted);
    return messageOf([&] { makePlan(wanted); });
  };
  EXPECT_EQ(error([](auto&) {}), "nothing was thrown");
  EXPECT_THAT(error([](auto& a) { a.methods = {"magic"}; }), HasSubstr("'magic'"));
  EXPECT_THAT(error([](auto& a) { a.pairs = {0, 3}; }), HasSubstr("--pairs: '3'"));
  EXPECT_THAT(error([](auto& a) { a.datasets.push_back(a.datasets[0]); }), HasSubstr("same name"));
  const auto external = [&](const std::string& json) {
    io::writeFile(folder_.file("methods.json"), json);
    return error([this](auto& a) { a.external = folder_.file("methods.json"); });
  };
  EXPECT_EQ(external(R"({"mine": {"command": "prog {source} {target}"}})"), "nothing was thrown");
  EXPECT_THAT(external("{\n  \"mine\": }"), HasSubstr("methods.json:2: column"));
  EXPECT_THAT(external(R"({"ssfr": {"command": "x"}})"), HasSubstr("'ssfr'"));
  EXPECT_THAT(external(R"({"mine": {"comand": "x"}})"), HasSubstr("command"));
  EXPECT_THAT(external(R"({"mine": {"command": "x 'y"}})"), HasSubstr("not closed"));
  EXPECT_THAT(external(R"({"mine": {"command": " "}})"), HasSubstr("empty"));
  const auto parameters = [&](const std::string& json) {
    io::writeFile(folder_.file("parameters.json"), json);
    return error([this](auto& a) { a.parameters = folder_.file("parameters.json"); });
  };
  EXPECT_EQ(parameters(R"({"leaf": 0.1, "ssfr": {"bin_width": 0.02}})"), "nothing was thrown");
  EXPECT_THAT(parameters(R"({"leef": 0.1})"), AllOf(HasSubstr("parameters.json"), HasSubstr("leef")));
  EXPECT_THAT(parameters(R"({"leaf": -0.1})"), HasSubstr("leaf = -0.1"));
  EXPECT_THAT(parameters(R"({"ssfr": {"bin_width": -1}})"), HasSubstr("bin_width"));
}

TEST_F(Plan, commandsAreSplitAsAShellWould)
{
  EXPECT_THAT(splitWords(R"(prog  -a 'b c' "d \" e" f\ g '')"), ElementsAre("prog", "-a", "b c", "d \" e", "f g", ""));
  EXPECT_TRUE(splitWords(" ").empty());
}

TEST_F(Plan, externalProgramsJoinUnlessSomeAreNamed)
{
  io::writeFile(folder_.file("methods.json"), R"({"x": {"command": "x"}, "y": {"command": "y"}})");
  const auto names = [this](std::vector<std::string> wanted) {
    BenchmarkArguments all = arguments();
    all.methods = std::move(wanted);
    all.external = folder_.file("methods.json");
    std::vector<std::string> result;
    for (const BenchmarkMethod& method : makePlan(all).methods)
      result.push_back(method.name);
    return result;
  };
  EXPECT_THAT(names({"ssfr"}), ElementsAre("ssfr", "x", "y"));
  EXPECT_THAT(names({"y", "ssfr", "y"}), ElementsAre("y", "ssfr"));
  EXPECT_EQ(names({"all"}).size(), methods().size() + 2);
}

TEST(ParameterRule, roundTripsThroughJson)
{
  ParameterRule rule;
  rule.leaf = 0.123;
  rule.ssfr.bin_width = 0.02;
  ParameterRule back;
  applyParameters(toJson(rule), back);
  EXPECT_EQ(toJson(back).dump(), toJson(rule).dump());
}

TEST(PairSeed, dependsOnNamesAndSeedOnly)
{
  EXPECT_EQ(pairSeed(1, "d", "s", "t"), pairSeed(1, "d", "s", "t"));
  std::set<std::uint64_t> seeds{
      pairSeed(1, "d", "s", "t"), pairSeed(2, "d", "s", "t"), pairSeed(1, "d", "t", "s"), pairSeed(1, "ds", "", "t")};
  EXPECT_EQ(seeds.size(), 4U);
}

// ---------------------------------------------------------------------------------------------------------------------
// The folder of results

class Store : public ::testing::Test {
protected:
  static Json
  settings(int seed = 1)
  {
    return {{"seed", seed}, {"datasets", {{"d", {{"sum", "1"}}}}}, {"external", Json::object()}};
  }
  static ResultRow
  row(std::size_t pair)
  {
    ResultRow result;
    result.dataset = "d";
    result.method = "ssfr";
    result.status = "converged";
    result.pair = pair;
    return result;
  }
  std::string
  openError(const Json& json, bool resume)
  {
    return messageOf([&] { ResultsStore(out(), json, resume); });
  }
  std::string
  out() const
  {
    return folder_.file("out");
  }
  std::string
  csv() const
  {
    return io::readFile(folder_.file("out/results.csv"));
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Store, rowsAreOnTheDiskAtOnceAndAreKept)
{
  {
    ResultsStore store(out(), settings(), false);
    store.append({row(0), {}});
    EXPECT_EQ(csv(), csvHeader() + "\n" + toCsvLine(row(0)) + "\n");
    store.append({row(1), {}});
  }
  EXPECT_THAT(openError(settings(), false), AllOf(HasSubstr("results.csv"), HasSubstr("--resume")));
  ResultsStore again(out(), settings(), true);
  EXPECT_EQ(again.rows().size(), 2U);
  EXPECT_TRUE(again.contains(rowKey("d", "", 1, {}, "ssfr")));
  EXPECT_FALSE(again.contains(rowKey("d", "", 2, {}, "ssfr")));
}

TEST_F(Store, aRowIsFoundAgainWhateverItsDatasetIsCalled)
{
  const std::vector<std::string> names{"two\nlines", "a\ttab", " blanks ", "comma, \"quote\""};
  {
    ResultsStore store(out(), settings(), false);
    for (const std::string& name : names) {
      ResultRow named = row(0);
      named.dataset = name;
      store.append({named, {}});
    }
  }
  const ResultsStore again(out(), settings(), true);
  for (const std::string& name : names)
    EXPECT_TRUE(again.contains(rowKey(name, "", 0, {}, "ssfr"))) << name;
  EXPECT_FALSE(again.contains(rowKey("other", "", 0, {}, "ssfr")));
}

TEST_F(Store, aTornLastLineIsDroppedAndWrittenAgain)
{
  {
    ResultsStore store(out(), settings(), false);
    store.append({row(0), {}});
    store.append({row(1), {}});
  }
  const std::string whole = csv();
  const std::string first = whole.substr(0, whole.find('\n', whole.find('\n') + 1) + 1);
  for (std::size_t kept = 0; kept < whole.size(); ++kept) {
    io::writeFile(folder_.file("out/results.csv"), whole.substr(0, kept));
    ResultsStore store(out(), settings(), true);
    EXPECT_EQ(store.rows().size(), kept >= first.size() ? 1U : 0U) << kept;
    for (const std::size_t pair : {std::size_t{0}, std::size_t{1}})
      if (!store.contains(rowKey("d", "", pair, {}, "ssfr")))
        store.append({row(pair), {}});
    EXPECT_EQ(csv(), whole) << kept;
  }
}

TEST_F(Store, differentSettingsAreNotMixed)
{
  {
    ResultsStore store(out(), settings(), false);
    store.append({row(0), {}});
  }
  EXPECT_THAT(openError(settings(2), true), AllOf(HasSubstr("seed was 1 and is now 2"), HasSubstr("settings.json")));
  Json other = settings();
  other["datasets"]["d"]["sum"] = "2";
  EXPECT_THAT(openError(other, true), HasSubstr("datasets.d"));
  EXPECT_THAT(csv(), HasSubstr(toCsvLine(row(0)))); // kept
  Json more = settings();
  more["datasets"]["e"] = {{"sum", "3"}};
  EXPECT_EQ(openError(more, true), "nothing was thrown"); // a folder may grow
  more["datasets"]["e"] = {{"sum", "4"}};
  EXPECT_THAT(openError(more, true), HasSubstr("datasets.e"));
  std::filesystem::remove(folder_.file("out/settings.json"));
  EXPECT_THAT(openError(settings(), true), HasSubstr("settings.json"));
}

TEST_F(Store, aDatasetIsNotRunAgainUnderAnotherName)
{
  const auto named = [](const std::vector<std::pair<std::string, std::string>>& datasets) {
    Json json = settings();
    json["datasets"] = Json::object();
    for (const auto& [name, checksum] : datasets)
      json["datasets"][name]["pairs_checksum"] = checksum;
    return json;
  };
  {
    ResultsStore store(out(), named({{"n", "1"}}), false);
    store.append({row(0), {}});
  }
  EXPECT_THAT(openError(named({{"a", "1"}, {"b", "2"}}), true), HasSubstr("dataset 'a' is in this folder as 'n'"));
  EXPECT_EQ(openError(named({{"b", "2"}}), true), "nothing was thrown");
  // Another dataset with the same pairs, of scans that were thinned for instance.
  EXPECT_EQ(openError(named({{"n", "1"}, {"thin", "1"}}), true), "nothing was thrown");
}

TEST_F(Store, settingsAreWrittenWhateverTheBytes)
{
  Json json = settings();
  json["datasets"]["B\xfcro"] = {{"sum", "1"}};
  EXPECT_EQ(openError(json, false), "nothing was thrown");
  EXPECT_THAT(io::readFile(folder_.file("out/settings.json")), HasSubstr("B\xef\xbf\xbdro"));
}

TEST_F(Store, oneRunAtATime)
{
  {
    const ResultsStore store(out(), settings(), false);
    EXPECT_THAT(openError(settings(), true), HasSubstr("another run"));
  }
  EXPECT_EQ(openError(settings(), true), "nothing was thrown");
}

TEST_F(Store, aWrongLineIsNamed)
{
  {
    ResultsStore store(out(), settings(), false);
    store.append({row(0), {}});
  }
  io::writeFile(folder_.file("out/results.csv"), csv() + "what,is,this\n");
  EXPECT_THAT(openError(settings(), true), HasSubstr("results.csv:3: 3 columns"));
  io::writeFile(folder_.file("out/results.csv"), "other,header\n");
  EXPECT_THAT(openError(settings(), true), HasSubstr("results.csv:1:"));
}

TEST_F(Store, candidatesNameTheirRowAndThoseOfALostRowGo)
{
  const std::string path = folder_.file("out/candidates.csv");
  const auto result = [](std::size_t pair) {
    PairResult with{row(pair), candidatesOf(Result())};
    for (int k = 0; k < 2; ++k)
      with.candidates.push_back(
          {Eigen::Isometry3d::Identity(), std::vector<double>(candidateFields({}, {}).size(), 0.5), k == 1});
    return with;
  };
  {
    ResultsStore store(out(), settings(), false, true);
    store.append(result(0));
    store.append(result(1));
  }
  const std::string whole = io::readFile(path);
  EXPECT_THAT(whole, StartsWith("row,dataset,source,target,method,rank,right,T00,"));
  EXPECT_THAT(whole, HasSubstr("\n1,d,,,ssfr,1,0,1,0,"));
  EXPECT_THAT(whole, HasSubstr("\n2,d,,,ssfr,2,1,1,0,"));
  const auto columns = [](const std::string& line) { return io::splitCsvLine(line).size(); };
  EXPECT_EQ(columns(whole.substr(0, whole.find('\n'))), 7 + 16 + candidateFields({}, {}).size());
  // Killed between the candidates and their row, and within a line.
  io::writeFile(path, whole + candidateLine(3, row(2), 1, result(2).candidates[0]) + "\n3,d,,");
  {
    ResultsStore store(out(), settings(), true, true);
    EXPECT_EQ(io::readFile(path), whole);
    store.append(result(2));
  }
  EXPECT_EQ(io::readFile(path),
            whole + candidateLine(3, row(2), 1, result(2).candidates[0]) + "\n" +
                candidateLine(3, row(2), 2, result(2).candidates[1]) + "\n");
}

} // namespace
} // namespace pcl_ssfr::apps::test_benchmark_table
