// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "common/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <thread>
#include <vector>

namespace pcl_ssfr {
namespace {

/// How often each index was visited.
std::vector<int>
visits(std::int64_t count, std::int64_t grain, int threads)
{
  std::vector<std::atomic<int>> visited(static_cast<std::size_t>(count));
  forEachInParallel(count, grain, threads, [&](std::int64_t i) { ++visited[static_cast<std::size_t>(i)]; });
  return {visited.begin(), visited.end()};
}

TEST(ForEachInParallel, VisitsEveryIndexOnce)
{
  for (const std::int64_t count : {0, 1, 2, 7, 1000})
    for (const std::int64_t grain : {1, 3, 2000})
      for (const int threads : {0, 1, 2, 5})
        EXPECT_EQ(visits(count, grain, threads), std::vector<int>(static_cast<std::size_t>(count), 1))
            << count << " " << grain << " " << threads;
}

TEST(ForEachInParallel, VisitsEveryIndexOnceWithinAnother)
{
  constexpr std::int64_t kOuter = 5, kInner = 300;
  std::vector<std::atomic<int>> visited(kOuter * kInner);
  forEachInParallel(kOuter, 1, 3, [&](std::int64_t i) {
    forEachInParallel(kInner, 4, 3, [&](std::int64_t j) { ++visited[static_cast<std::size_t>(i * kInner + j)]; });
    // All of them are done when the inner call returns.
    for (std::int64_t j = 0; j < kInner; ++j)
      EXPECT_EQ(visited[static_cast<std::size_t>(i * kInner + j)], 1);
  });
}

/// Whether another thread helps with a loop of \p count iterations, which wait for that.
bool
isHelpedWith(std::int64_t count)
{
  std::atomic<bool> has_helper{false};
  std::atomic<int> patience{1000}; // [ms] of all iterations together
  const std::thread::id own = std::this_thread::get_id();
  forEachInParallel(count, 1, 2, [&](std::int64_t) {
    if (std::this_thread::get_id() != own)
      has_helper = true;
    while (!has_helper && patience-- > 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  return has_helper;
}

TEST(ForEachInParallel, WhoIsReadyHelps)
{
  // One of two outer iterations does nothing, whichever: its thread must take inner ones of the other.
  for (const std::int64_t idle : {0, 1})
    for (const std::int64_t count : {64, 10000}) {
      bool is_helped = false;
      forEachInParallel(2, 1, 2, [&](std::int64_t outer) {
        if (outer != idle)
          is_helped = isHelpedWith(count);
      });
      EXPECT_TRUE(is_helped) << idle << " " << count;
    }
}

TEST(RunInTeam, OthersHelpWithItsLoops)
{
  bool is_helped = false;
  runInTeam(2, [&] { is_helped = isHelpedWith(64) && isHelpedWith(10000); });
  EXPECT_TRUE(is_helped);
}

TEST(RunInTeam, RunsOnceAndThrowsWhatWasThrown)
{
  for (const int threads : {0, 1, 2, 5}) {
    std::atomic<int> calls{0};
    runInTeam(threads, [&] { runInTeam(threads, [&] { ++calls; }); });
    EXPECT_EQ(calls, 1) << threads;
    EXPECT_THROW(runInTeam(threads, [] { throw std::runtime_error("of the body"); }), std::runtime_error);
    EXPECT_EQ(visits(10, 1, threads), std::vector<int>(10, 1)); // and all is as before
  }
}

TEST(ForEachInParallel, OneThreadKeepsTheOrder)
{
  std::vector<std::int64_t> order;
  forEachInParallel(100, 1, 1, [&](std::int64_t i) { order.push_back(i); });
  ASSERT_EQ(order.size(), 100U);
  for (std::size_t i = 0; i < order.size(); ++i)
    EXPECT_EQ(order[i], static_cast<std::int64_t>(i));
}

TEST(ForEachInParallel, ThrowsWhatACallThrewAfterAllAreDone)
{
  for (const int threads : {2, 4}) {
    std::atomic<int> calls{0};
    EXPECT_THROW(forEachInParallel(100,
                                   1,
                                   threads,
                                   [&](std::int64_t i) {
                                     ++calls;
                                     if (i % 10 == 3)
                                       throw std::runtime_error("of a call");
                                   }),
                 std::runtime_error);
    EXPECT_EQ(calls, 100);
  }
  EXPECT_THROW(forEachInParallel(3, 1, 1, [](std::int64_t) { throw std::runtime_error("of a call"); }),
               std::runtime_error);
}

TEST(ForEachInParallel, ThrowsThroughAnother)
{
  EXPECT_THROW(forEachInParallel(4,
                                 1,
                                 2,
                                 [](std::int64_t i) {
                                   forEachInParallel(50, 1, 2, [i](std::int64_t j) {
                                     if (i == 2 && j == 30)
                                       throw std::runtime_error("of an inner call");
                                   });
                                 }),
               std::runtime_error);
}

} // namespace
} // namespace pcl_ssfr
