// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <pcl_ssfr/deadline.h>

#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <limits>
#include <thread>

namespace pcl_ssfr::test_deadline {
namespace {

TEST(Deadline, NeverComesByDefault)
{
  EXPECT_FALSE(Deadline().hasPassed());
}

TEST(Deadline, NeverComesWithoutALimit)
{
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double seconds : {0.0, -1.0, -kInf, kNan, kInf, 1e18, std::numeric_limits<double>::max()})
    EXPECT_FALSE(Deadline::after(seconds).hasPassed()) << seconds;
}

TEST(Deadline, ComesAfterItsSecondsAndStays)
{
  const Deadline::Clock::time_point start = Deadline::Clock::now();
  const Deadline deadline = Deadline::after(0.01);
  while (!deadline.hasPassed())
    std::this_thread::yield();
  EXPECT_GE(Deadline::Clock::now() - start, std::chrono::milliseconds(10));
  const Deadline copy = deadline;
  EXPECT_TRUE(deadline.hasPassed());
  EXPECT_TRUE(copy.hasPassed());
}

TEST(Deadline, IsNotThereBefore)
{
  EXPECT_FALSE(Deadline::after(3600).hasPassed());
  // As little as an option can ask for is over at once.
  const Deadline least = Deadline::after(1e-9);
  std::this_thread::sleep_for(std::chrono::microseconds(10));
  EXPECT_TRUE(least.hasPassed());
}

TEST(Deadline, ProcessorTimeDoesNotPassWhileNothingIsDone)
{
  constexpr double kLimit = 0.1; // [s]
  const Deadline wall = Deadline::after(kLimit);
  const Deadline processor = Deadline::after(kLimit, TimeLimitClock::Processor);
  EXPECT_FALSE(wall.hasPassed());
  std::this_thread::sleep_for(std::chrono::duration<double>(1.5 * kLimit));
  EXPECT_TRUE(wall.hasPassed());
  EXPECT_FALSE(processor.hasPassed());
  const std::clock_t before = std::clock();
  while (static_cast<double>(std::clock() - before) < 1.1 * kLimit * CLOCKS_PER_SEC) {
  }
  EXPECT_TRUE(processor.hasPassed());
  EXPECT_FALSE(Deadline::after(0, TimeLimitClock::Processor).hasPassed());
  EXPECT_FALSE(Deadline::after(std::numeric_limits<double>::infinity(), TimeLimitClock::Processor).hasPassed());
}

} // namespace
} // namespace pcl_ssfr::test_deadline
