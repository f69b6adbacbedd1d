// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// main() of a program of several sources of tests: "program [test_x] [flags of GoogleTest]" runs the suites of
// test_x.cpp and no others, as if that were a program of its own; without a name all run.

#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <string>

namespace {

/// The name of the source of a test.
std::string
sourceOf(const ::testing::TestInfo& test)
{
  return std::filesystem::path(test.file()).stem().string();
}

/// The only source of the tests of a suite; empty when they are of several.
std::string
sourceOf(const ::testing::TestSuite& suite)
{
  std::string source = sourceOf(*suite.GetTestInfo(0));
  for (int i = 1; i < suite.total_test_count(); ++i)
    if (sourceOf(*suite.GetTestInfo(i)) != source)
      return "";
  return source;
}

} // namespace

int
main(int argc, char** argv)
{
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 2) {
    std::cerr << argv[0] << ": one name of a source and flags of GoogleTest, not '" << argv[2] << "'\n";
    return 2;
  }
  const std::string name = argc == 2 ? argv[1] : "";
  std::string chosen, others;
  const ::testing::UnitTest& tests = *::testing::UnitTest::GetInstance();
  for (int i = 0; i < tests.total_test_suite_count(); ++i) {
    const ::testing::TestSuite& suite = *tests.GetTestSuite(i);
    const std::string source = sourceOf(suite);
    if (source.empty()) {
      std::cerr << argv[0] << ": several sources have a suite " << suite.name() << "; a suite belongs to one\n";
      return 2;
    }
    (source == name ? chosen : others) += std::string(suite.name()) + ".*:";
  }
  if (!name.empty()) {
    if (chosen.empty()) {
      std::cerr << argv[0] << ": no test is of a source " << name << ".cpp\n";
      return 2;
    }
    std::string& filter = ::testing::GTEST_FLAG(filter);
    if (filter == "*")
      filter = chosen;
    else // what was asked for, without what is of other sources
      filter += (filter.find('-') == std::string::npos ? "-" : ":") + others;
  }
  return RUN_ALL_TESTS();
}
