// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Real scans with ground truth (CMake: PCL_SSFR_TEST_DATA_DIR): a row a set with the least number of pairs that must
// be solved. To update a row, run scripts/success_table and raise the number; never lower it without a reason in the
// changelog. Every source is rotated by a seeded random rotation about its sensor first.

#include "pose_matchers.h"
#include "real_scans.h"
#include "scan_views.h"
#include "synthetic_scene.h"

#include <pcl_ssfr/pipeline.h>

#include <apps/io/dataset_folder.h>

#include <gtest/gtest.h>

#include <cstdio>
#include <ostream>
#include <string>

namespace pcl_ssfr::test_real_data {
namespace {

using pcl_ssfr::testing::loadPoints;
using pcl_ssfr::testing::PoseError;
using pcl_ssfr::testing::Random;
using pcl_ssfr::testing::realScansFolder;
using pcl_ssfr::testing::toColumns;
using pcl_ssfr::testing::viewOfPoints;

#ifdef __SANITIZE_ADDRESS__
constexpr std::size_t kSlowdown = 5; // take every fifth of the pairs only
#else
constexpr std::size_t kSlowdown = 1;
#endif

/// A dataset and what is asked of it.
struct Row {
  const char* folder;
  std::size_t every;    ///< take every k-th pair
  std::size_t may_fail; ///< pairs that may be missed
};

std::ostream&
operator<<(std::ostream& out, const Row& row)
{
  return out << row.folder;
}

class RealData : public ::testing::TestWithParam<Row> {};

TEST_P(RealData, isSolved)
{
  const Row row = GetParam();
  if (realScansFolder().empty())
    GTEST_SKIP() << pcl_ssfr::testing::kNoRealScans;
  const io::DatasetFolder dataset = io::readDatasetFolder((realScansFolder() / row.folder).string());
  const auto scanOf = [&](const std::string& name) { return toColumns(*loadPoints(io::scanPath(dataset.path, name))); };
  Options options = makeOptions(Profile::Default);
  options.threads = 2;
  std::size_t solved = 0, tried = 0, wrong_but_converged = 0;
  for (std::size_t i = 0; i < dataset.pairs.size(); i += row.every * kSlowdown) {
    const io::ScanPair& pair = dataset.pairs[i];
    Random random(1000 + i);
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() = pcl_ssfr::testing::randomRotation(random);
    const Eigen::Matrix3Xf source = pcl_ssfr::testing::transformed(turn, scanOf(pair.source));
    const Eigen::Matrix3Xf target = scanOf(pair.target);
    const Result result =
        registerScans(prepareScan(viewOfPoints(source), options), prepareScan(viewOfPoints(target), options), options);
    const PoseError error = pcl_ssfr::testing::poseError(result.T_target_source * turn, pair.T_target_source);
    const bool right = error.rotation < 2 * 0.017453 && error.translation < 0.3;
    ++tried;
    solved += right;
    wrong_but_converged += result.accepted() && !right;
    if (!right)
      std::printf("  pair %zu, %s -> %s: %.2f deg, %.2f m off, %s: %s\n",
                  i,
                  pair.source.c_str(),
                  pair.target.c_str(),
                  error.rotation * 57.3,
                  error.translation,
                  toString(result.status),
                  result.message.c_str());
  }
  EXPECT_GE(solved + row.may_fail, tried);
  EXPECT_LE(wrong_but_converged, row.may_fail);
}

INSTANTIATE_TEST_SUITE_P(Sets,
                         RealData,
                         ::testing::Values(Row{"apartment_pair", 1, 0},
                                           Row{"room_pair_pcl", 1, 0},
                                           Row{"outdoor_smoke_pair", 1, 0},
                                           Row{"corridor_sick_3dtk", 1, 0},
                                           Row{"eth_facade", 2, 0},
                                           Row{"parking_tls", 2, 1},
                                           Row{"hall_livox_balm", 4, 1},
                                           Row{"imm_A", 2, 1},
                                           Row{"imm_D", 1, 1}));

} // namespace
} // namespace pcl_ssfr::test_real_data
