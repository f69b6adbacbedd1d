// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// The figures of the comparison, against closed forms, brute force and laws.

#include <apps/benchmark/benchmark_results.h>
#include <apps/pairs/measures.h>

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace pcl_ssfr::apps::test_measures {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;
using ::testing::DoubleNear;
using ::testing::ElementsAre;

constexpr double kRadians = M_PI / 180;

double
uniform(std::mt19937& random, double low, double high)
{
  return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
}

Isometry3d
randomPose(std::mt19937& random)
{
  const Eigen::Vector4d q(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1), 0.3);
  return Translation3d(uniform(random, -9, 9), uniform(random, -9, 9), uniform(random, -9, 9)) *
         Eigen::Quaterniond(q.normalized());
}

TEST(PoseError, isTheAngleAndTheDistance)
{
  const Isometry3d truth(AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
  const Isometry3d off = Translation3d(0.3, 0, -0.4) * truth * AngleAxisd(12 * kRadians, Vector3d::UnitY());
  const PoseError error = poseError(off, truth, Vector3d::Zero());
  EXPECT_NEAR(error.rotation_deg, 12, 1e-9);
  EXPECT_NEAR(error.translation_m, 0.5, 1e-12);
  EXPECT_EQ(poseError(truth, truth, Vector3d(4, 5, 6)).translation_m, 0);
}

TEST(PoseError, keepsSmallAnglesAndReaches180)
{
  const Isometry3d truth = Isometry3d::Identity();
  for (const double degrees : {1e-7, 1e-3, 90.0, 179.999, 180.0})
    EXPECT_NEAR(
        poseError(Isometry3d(AngleAxisd(degrees * kRadians, Vector3d::UnitX())), truth, Vector3d::Zero()).rotation_deg,
        degrees,
        1e-9 + 1e-9 * degrees);
}

TEST(PoseError, doesNotDependOnTheFrameOfTheSource)
{
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const Isometry3d estimate = randomPose(random);
    const Isometry3d truth = randomPose(random);
    const Isometry3d motion = randomPose(random); // of the source, and of its sensor with it
    const Vector3d sensor(uniform(random, -5, 5), 1, 2);
    const PoseError a = poseError(estimate, truth, sensor);
    const PoseError b = poseError(estimate * motion.inverse(), truth * motion.inverse(), motion * sensor);
    EXPECT_NEAR(a.rotation_deg, b.rotation_deg, 1e-6);
    EXPECT_NEAR(a.translation_m, b.translation_m, 1e-9);
  }
}

TEST(PoseError, boundsAreInclusive)
{
  EXPECT_TRUE(isWithin({2, 0.3}, {2, 0.3}));
  EXPECT_FALSE(isWithin({2.0001, 0.1}, {2, 0.3}));
  EXPECT_FALSE(isWithin({0.1, 0.3001}, {2, 0.3}));
  EXPECT_FALSE(isWithin({std::nan(""), 0}, {2, 0.3}));
}

TEST(CorrespondenceSums, giveTheRmseOfTheSumOverAllPoints)
{
  std::mt19937 random(5);
  for (int round = 0; round < 20; ++round) {
    const Isometry3d truth = randomPose(random);
    Eigen::Matrix3Xd source(3, 400);
    Eigen::Matrix3Xd target(3, 400);
    for (Eigen::Index i = 0; i < source.cols(); ++i) {
      source.col(i) << uniform(random, -30, 60), uniform(random, -30, 30), uniform(random, -2, 6);
      target.col(i) = truth * source.col(i) + 0.01 * Vector3d(uniform(random, -1, 1), uniform(random, -1, 1), 0.5);
    }
    const CorrespondenceSums sums = sumCorrespondences(source, target);
    for (const Isometry3d& T : {truth, Isometry3d(truth * Translation3d(0.02, 0, 0)), randomPose(random)}) {
      double squares = 0;
      for (Eigen::Index i = 0; i < source.cols(); ++i)
        squares += (T * source.col(i) - target.col(i)).squaredNorm();
      EXPECT_NEAR(rmseOf(sums, T), std::sqrt(squares / 400), 1e-8);
    }
  }
}

TEST(CorrespondenceSums, ofNothingAreNoNumber)
{
  EXPECT_TRUE(std::isnan(rmseOf(sumCorrespondences({}, {}), Isometry3d::Identity())));
  const CorrespondenceSums one = sumCorrespondences(Vector3d(1, 2, 3), Vector3d(1, 2, 5));
  EXPECT_NEAR(rmseOf(one, Isometry3d::Identity()), 2, 1e-12);
}

TEST(WilsonInterval, agreesWithPublishedValues)
{
  // R: binom::binom.confint(x, n, methods = "wilson")
  const Interval half = wilsonInterval(5, 10);
  EXPECT_NEAR(half.low, 0.2365931, 1e-6);
  EXPECT_NEAR(half.high, 0.7634069, 1e-6);
  const Interval all = wilsonInterval(20, 20);
  EXPECT_NEAR(all.low, 0.8388748, 1e-6);
  EXPECT_EQ(all.high, 1);
  EXPECT_EQ(wilsonInterval(0, 20).low, 0);
}

TEST(WilsonInterval, holdsTheRateAndShrinksWithTheNumber)
{
  EXPECT_EQ(wilsonInterval(0, 0).low, 0);
  EXPECT_EQ(wilsonInterval(0, 0).high, 1);
  for (std::size_t n = 1; n < 60; ++n) {
    for (std::size_t k = 0; k <= n; ++k) {
      const double rate = static_cast<double>(k) / static_cast<double>(n);
      const Interval interval = wilsonInterval(k, n);
      EXPECT_LE(interval.low, rate);
      EXPECT_GE(interval.high, rate);
      const Interval more = wilsonInterval(4 * k, 4 * n);
      EXPECT_LT(more.high - more.low, interval.high - interval.low);
      EXPECT_NEAR(interval.low, 1 - wilsonInterval(n - k, n).high, 1e-12);
    }
  }
}

TEST(Quantile, isThatOfNumpy)
{
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_NEAR(quantile({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, 0.9), 9.1, 1e-12);
  EXPECT_EQ(quantile({7}, 0.9), 7);
  EXPECT_EQ(quantile({std::nan(""), 7}, 0), 7);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  EXPECT_TRUE(std::isnan(quantile({std::nan("")}, 0.5)));
}

TEST(PrecisionRecall, countsFromTheSurestDown)
{
  const auto curve = precisionRecall({{0.5, false}, {0.9, true}, {0.7, true}, {0.7, false}}, 5);
  ASSERT_EQ(curve.size(), 3U); // equally sure answers are accepted together
  EXPECT_EQ(curve[0].confidence, 0.9);
  EXPECT_EQ(curve[0].precision, 1);
  EXPECT_EQ(curve[0].recall, 0.2);
  EXPECT_NEAR(curve[1].precision, 2.0 / 3, 1e-12);
  EXPECT_EQ(curve[1].recall, 0.4);
  EXPECT_EQ(curve[2].precision, 0.5);
  EXPECT_EQ(curve[2].recall, 0.4);
  EXPECT_TRUE(precisionRecall({}, 5).empty());
}

TEST(LogLoss, isThatOfWhatCameTrue)
{
  EXPECT_NEAR(logLoss({{0.8, true}, {0.3, false}}), -(std::log(0.8) + std::log(0.7)) / 2, 1e-12);
  EXPECT_NEAR(logLoss({{1, false}, {0, true}}), -std::log(1e-4), 1e-9); // a false certainty is not infinite
  EXPECT_TRUE(std::isnan(logLoss({})));
}

TEST(CalibrationError, isTheMeanGapOfTenBins)
{
  // 0.82 and 0.88 share a bin: their gap is that of the sums. 1 is in the last bin.
  EXPECT_NEAR(calibrationError({{0.82, true}, {0.88, false}, {0.11, false}, {1, true}}), (0.7 + 0.11) / 4, 1e-12);
  EXPECT_EQ(calibrationError({{1, true}, {0, false}}), 0);
  EXPECT_TRUE(std::isnan(calibrationError({})));
}

// ---------------------------------------------------------------------------------------------------------------------
// Tables

ResultRow
row(const std::string& dataset, std::size_t pair, const std::string& method, bool right, bool converged)
{
  ResultRow result;
  result.dataset = dataset;
  result.pair = pair;
  result.method = method;
  result.status = converged ? "converged" : "ambiguous";
  result.converged = converged;
  result.success = right;
  result.T_target_source = Isometry3d::Identity();
  result.rotation_error_deg = right ? 0.5 : 30;
  result.translation_error_m = right ? 0.05 : 4;
  result.rmse_m = 0.02;
  result.gt_rmse_m = 0.01;
  result.time_s = 1 + static_cast<double>(pair);
  result.cpu_s = 2;
  result.peak_rss_mib = 100 + static_cast<double>(pair);
  return result;
}

TEST(Summarize, countsWhatHappened)
{
  std::vector<ResultRow> rows{row("a", 1, "icp", false, true),
                              row("a", 0, "icp", true, true),
                              row("a", 0, "ssfr", true, true),
                              row("a", 1, "ssfr", false, false),
                              row("b", 0, "ssfr", true, false)};
  rows[2].confidence = 0.9;
  rows[3].confidence = 0.2;
  ResultRow crashed;
  crashed.dataset = "b";
  crashed.method = "icp";
  crashed.status = "crashed";
  crashed.time_s = 9;
  rows.push_back(crashed);
  const BenchmarkResults results = summarize(rows, {"b", "a"}, {"ssfr", "icp"});
  std::vector<std::string> order;
  for (const ResultRow& r : results.rows)
    order.push_back(r.dataset + std::to_string(r.pair) + r.method);
  EXPECT_THAT(order, ElementsAre("b0ssfr", "b0icp", "a0ssfr", "a0icp", "a1ssfr", "a1icp"));

  ASSERT_EQ(results.summaries.size(), 6U); // two methods on b, on a, on all
  const MethodSummary& b_icp = results.summaries[1];
  EXPECT_EQ(b_icp.success.count, 0U);
  EXPECT_EQ(b_icp.failures.at("crashed"), 1U);
  EXPECT_TRUE(std::isnan(b_icp.median_rmse_m));
  EXPECT_EQ(b_icp.within[0].count, 0U);
  const MethodSummary& a_ssfr = results.summaries[2];
  EXPECT_EQ(a_ssfr.method, "ssfr");
  EXPECT_EQ(a_ssfr.success.count, 1U);
  EXPECT_EQ(a_ssfr.converged_wrong.count, 0U);
  EXPECT_EQ(a_ssfr.failures.at("ambiguous"), 1U);
  EXPECT_EQ(a_ssfr.precision_recall.size(), 2U);
  EXPECT_NEAR(a_ssfr.log_loss, -(std::log(0.9) + std::log(0.8)) / 2, 1e-12);
  EXPECT_NEAR(a_ssfr.calibration_error, (0.1 + 0.2) / 2, 1e-12);
  const MethodSummary& a_icp = results.summaries[3];
  EXPECT_EQ(a_icp.converged.count, 2U);
  EXPECT_EQ(a_icp.converged_wrong.count, 1U);
  EXPECT_EQ(a_icp.converged_wrong.of, 2U);
  EXPECT_EQ(a_icp.failures.at("wrong pose"), 1U);
  EXPECT_TRUE(a_icp.precision_recall.empty());
  EXPECT_TRUE(std::isnan(a_icp.log_loss));
  EXPECT_EQ(a_icp.median_time_s, 1.5);
  EXPECT_EQ(a_icp.peak_rss_mib, 101);
  const MethodSummary& all_icp = results.summaries[5];
  EXPECT_EQ(all_icp.dataset, "");
  EXPECT_EQ(all_icp.success.of, 3U);
}

TEST(Summarize, keepsVariationsApartAndOneDatasetOnce)
{
  ResultRow thinned = row("a", 0, "ssfr", false, true);
  thinned.variation.resolution_m = 0.1;
  const BenchmarkResults results = summarize({thinned, row("a", 0, "ssfr", true, true)}, {"a"}, {"ssfr"});
  ASSERT_EQ(results.summaries.size(), 2U);
  EXPECT_EQ(results.summaries[0].variation.resolution_m, 0);
  EXPECT_EQ(results.summaries[0].success.count, 1U);
  EXPECT_EQ(results.summaries[1].variation.resolution_m, 0.1);
  EXPECT_TRUE(summarize({}, {}, {}).summaries.empty());
}

} // namespace
} // namespace pcl_ssfr::apps::test_measures
