// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

// Scans of a furnished room into one map: poses, covariances, bits, bad scans, a person's word, the project file,
// pairs linked elsewhere.

#include "common/angles.h"
#include "multiway/project_file.h"
#include "multiway/scan_pair.h"

#include <pcl_ssfr/multiway/multiway_registration.h>
#include <pcl_ssfr/pipeline.h>

#include <io_testing.h>
#include <link_cache.h>
#include <pose_matchers.h>
#include <scan_views.h>
#include <synthetic_scene.h>

#include <pcl/point_types.h>

#include <gmock/gmock.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>

namespace pcl_ssfr::test_multiway_registration {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

/// Five scans of a room, each in a frame of its own.
class Room : public ::testing::Test {
protected:
  static void
  SetUpTestSuite()
  {
    const testing::Scene scene = testing::makeFurnishedRoom(3);
    testing::Random random(11);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector3d station = scene.stations[static_cast<std::size_t>(i) % scene.stations.size()] +
                                      0.2 * (i / static_cast<int>(scene.stations.size())) * Eigen::Vector3d::UnitX();
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation() = station;
      const Eigen::Matrix3Xf points = testing::castScan(scene, T, testing::roomScanner(0.02), 20 + i);
      const Eigen::Matrix3d R = testing::randomRotation(random);
      scans_.push_back(R.cast<float>().transpose() * points);
      T.linear() = R;
      truth_.push_back(T);
    }
  }
  static void
  TearDownTestSuite()
  {
    scans_.clear();
    truth_.clear();
    maps_.clear();
    room_links_.clear();
  }

  static ScanView
  view(int scan)
  {
    const Eigen::Matrix3Xf& points = scans_[static_cast<std::size_t>(scan)];
    ScanView result;
    result.xyz = points.data();
    result.size = static_cast<std::size_t>(points.cols());
    return result;
  }
  static void
  addAll(MultiwayRegistration& registration)
  {
    for (int i = 0; i < 5; ++i)
      registration.addScan("s" + std::to_string(i), view(i));
  }
  /// All scans with the usual options; made once for each number of threads.
  static const MultiwayMap&
  mapOf(unsigned threads)
  {
    const auto [map, is_new] = maps_.try_emplace(threads);
    if (is_new) {
      MultiwayOptions options;
      options.threads = threads;
      MultiwayRegistration registration(options);
      addAll(registration);
      map->second = registration.run();
    }
    return map->second;
  }
  static void
  expectSameBits(const MultiwayMap& a, const MultiwayMap& b)
  {
    ASSERT_EQ(a.scans.size(), b.scans.size());
    for (std::size_t i = 0; i < a.scans.size(); ++i) {
      EXPECT_TRUE(a.scans[i].T_map_scan.matrix() == b.scans[i].T_map_scan.matrix()) << i;
      EXPECT_TRUE(a.scans[i].covariance == b.scans[i].covariance) << i;
      EXPECT_EQ(a.scans[i].component, b.scans[i].component);
    }
    ASSERT_EQ(a.links.size(), b.links.size());
    for (std::size_t k = 0; k < a.links.size(); ++k) {
      EXPECT_EQ(a.links[k].confidence, b.links[k].confidence);
      EXPECT_TRUE(a.links[k].T_target_source.matrix() == b.links[k].T_target_source.matrix());
    }
  }

  static inline std::vector<Eigen::Matrix3Xf> scans_;
  static inline std::vector<Eigen::Isometry3d> truth_;
  static inline std::map<unsigned, MultiwayMap> maps_;
  static inline testing::LinkCache room_links_; ///< by the usual options, once for all tests
};

TEST_F(Room, allScansAreWhereTheyBelong)
{
  const MultiwayMap& map = mapOf(3);
  EXPECT_EQ(map.components, 1);
  EXPECT_EQ(map.placed, 5U);
  EXPECT_TRUE(map.scans[0].T_map_scan.matrix().isIdentity(1e-12));
  for (std::size_t i = 0; i < 5; ++i) {
    const Eigen::Isometry3d expected = truth_[0].inverse() * truth_[i];
    EXPECT_LT((map.scans[i].T_map_scan.translation() - expected.translation()).norm(), 0.01);
    EXPECT_GT(map.scans[i].links, 0);
    EXPECT_GT(map.scans[i].bytes, 1000U);
    if (i > 0) {
      EXPECT_GT(map.scans[i].sigma_translation, 1e-5);
      EXPECT_LT(map.scans[i].sigma_translation, 0.02);
    }
  }
  for (const MapLink& link : map.links)
    if (link.status == LinkStatus::Used) {
      EXPECT_NEAR(link.strength.sum(), 1, 1e-6); // normals are floats
      EXPECT_GT(link.overlap, 0.05);
    }
  EXPECT_GT(map.bundle_error, 0);
  EXPECT_FALSE(map.loops.empty());
}

TEST_F(Room, posesOfTheGraphAreThoseBeforeAnyAdjustment)
{
  const MultiwayMap& map = mapOf(3);
  MultiwayOptions options;
  options.threads = 3;
  options.adjustment.damping = 1e3; // then hardly anything moves
  MultiwayRegistration registration(options);
  addAll(registration);
  room_links_.serve(registration);
  const MultiwayMap unmoved = registration.run();
  double moved = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_TRUE(unmoved.graph_poses[i].matrix() == map.graph_poses[i].matrix()) << i;
    moved = std::max(moved, (unmoved.scans[i].T_map_scan.matrix() - map.scans[i].T_map_scan.matrix()).norm());
  }
  EXPECT_GT(moved, 1e-5); // else it would show nothing
}

TEST_F(Room, scansAtOnePlaceAreNamedAndKept)
{
  const auto stationNotes = [](const MultiwayMap& map) {
    return std::count_if(map.notes.begin(), map.notes.end(), [](const std::string& note) {
      return note.find("stand where others do and see the same") != std::string::npos;
    });
  };
  EXPECT_EQ(stationNotes(mapOf(3)), 0);
  // A sensor that turned on the spot twice.
  const testing::Scene scene = testing::makeFurnishedRoom(3);
  testing::Random random(5);
  std::vector<Eigen::Matrix3Xf> again;
  for (const std::uint64_t seed : {31, 32}) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = scene.stations[0];
    const Eigen::Matrix3d R = testing::randomRotation(random);
    again.push_back(R.cast<float>().transpose() * testing::castScan(scene, T, testing::roomScanner(0.02), seed));
  }
  MultiwayRegistration registration;
  room_links_.serve(registration);
  addAll(registration);
  registration.addScan("again1", testing::viewOfPoints(again[0]));
  registration.addScan("again2", testing::viewOfPoints(again[1]));
  const MultiwayMap map = registration.run();
  EXPECT_EQ(map.placed, 7U);
  EXPECT_EQ(stationNotes(map), 1);
}

TEST_F(Room, coordinatesThatAreHardlyMetresAreAskedAbout)
{
  const auto notesOfPair = [](float unit) {
    std::vector<Eigen::Matrix3Xf> points{scans_[0] * unit, scans_[1] * unit};
    MultiwayRegistration registration{MultiwayOptions()};
    for (std::size_t i = 0; i < 2; ++i) {
      ScanView view;
      view.xyz = points[i].data();
      view.size = static_cast<std::size_t>(points[i].cols());
      registration.addScan("s" + std::to_string(i), view);
    }
    return registration.run().notes;
  };
  const auto asks = ::testing::ContainsRegex("s0 reaches .* m, and 1 other .*: are coordinates in metres");
  EXPECT_THAT(notesOfPair(1000), ::testing::Contains(asks));
  EXPECT_THAT(notesOfPair(1), ::testing::Not(::testing::Contains(::testing::HasSubstr("metres"))));
}

TEST_F(Room, sameBitsForAnyNumberOfThreads)
{
  expectSameBits(mapOf(1), mapOf(3));
}

TEST_F(Room, aTimeLimitOfThePairsIsNotRead)
{
  MultiwayOptions options;
  options.threads = 2;
  options.registration.time_limit = 1e-6; // which would leave no link
  MultiwayRegistration registration(options);
  addAll(registration);
  expectSameBits(mapOf(3), registration.run());
}

TEST_F(Room, aProjectGivesTheSameMapAndLinksNothingAgain)
{
  const TemporaryFolder folder;
  const std::string file = folder.file("map.sqlite");
  const auto run = [&](bool resume, std::size_t& first_done, bool stop = false) {
    MultiwayOptions options;
    options.threads = 2;
    MultiwayRegistration registration(options);
    registration.openProject(file, resume);
    addAll(registration);
    bool is_first = true;
    return registration.run([&](const std::string& stage, std::size_t done, std::size_t) {
      if (stage != "link" || !is_first)
        return;
      is_first = false;
      first_done = done;
      if (stop)
        throw std::runtime_error("seen");
    });
  };
  std::size_t done = 99;
  const MultiwayMap first = run(false, done);
  EXPECT_EQ(done, 0U);
  const MultiwayMap again = run(true, done);
  EXPECT_EQ(done, first.links.size());
  expectSameBits(first, again);
  EXPECT_THROW(run(false, done, true), std::runtime_error); // to see that it would link all again
  EXPECT_EQ(done, 0U);
}

TEST_F(Room, aProjectKnowsAnotherViewpointAndOtherNumbers)
{
  const TemporaryFolder folder;
  const auto linked = [&](bool resume, const Eigen::Vector3d& viewpoint, const MultiwayOptions& options) {
    MultiwayRegistration registration(options);
    registration.openProject(folder.file("map.sqlite"), resume);
    for (int i = 0; i < 3; ++i) {
      ScanView scan = view(i);
      if (i == 1)
        scan.viewpoint = viewpoint;
      registration.addScan("s" + std::to_string(i), scan);
    }
    std::size_t known = 99;
    registration.run([&](const std::string& stage, std::size_t done, std::size_t) {
      if (stage == "link")
        known = std::min(known, done);
    });
    return 3 - known;
  };
  MultiwayOptions options;
  options.threads = 2;
  EXPECT_EQ(linked(false, {0, 0, 0}, options), 3U);
  EXPECT_EQ(linked(true, {0, 0, -0.0}, options), 0U);
  EXPECT_EQ(linked(true, {0, 0, 0.1}, options), 2U) << "the pairs of this scan";
  options.registration.patch_profile.judgement.decided *= 0.99;
  EXPECT_EQ(linked(true, {0, 0, 0.1}, options), 3U);
  options.registration.max_candidates = 2;
  EXPECT_EQ(linked(true, {0, 0, 0.1}, options), 3U);
  options.registration.gravity = GravityPrior{};
  options.registration.gravity->tolerance = kPi;
  EXPECT_EQ(linked(true, {0, 0, 0.1}, options), 3U);
  options.registration.time_limit = 1e-6;
  EXPECT_EQ(linked(true, {0, 0, 0.1}, options), 0U) << "links do not depend on it";
  EXPECT_EQ(linked(false, {0, 0, 0.1}, options), 3U);
}

TEST_F(Room, framesFarFromTheSensorsGiveTheSameMap)
{
  const Eigen::Vector3f away(400, -300, 20);
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  std::vector<Eigen::Matrix3Xf> moved;
  for (int i = 0; i < 5; ++i) {
    moved.emplace_back(scans_[static_cast<std::size_t>(i)].colwise() + away);
    ScanView scan = testing::viewOfPoints(moved.back());
    scan.viewpoint = away.cast<double>();
    registration.addScan("s" + std::to_string(i), scan);
  }
  const MultiwayMap far = registration.run();
  const MultiwayMap& near = mapOf(3);
  ASSERT_EQ(far.components, 1);
  for (std::size_t i = 1; i < 5; ++i) {
    const Eigen::Vector3d sensor = far.scans[i].T_map_scan * away.cast<double>() - away.cast<double>();
    EXPECT_LT((sensor - near.scans[i].T_map_scan.translation()).norm(), 0.002) << i;
    EXPECT_NEAR(far.scans[i].sigma_rotation, near.scans[i].sigma_rotation, 0.1 * near.scans[i].sigma_rotation) << i;
    EXPECT_NEAR(far.scans[i].sigma_translation, near.scans[i].sigma_translation, 0.1 * near.scans[i].sigma_translation)
        << i;
  }
}

TEST_F(Room, aScanAndItsMirrorImageAreTwo)
{
  Eigen::Matrix3Xf points = scans_[0].leftCols(scans_[0].cols() / 2 * 2); // an even number of signs changes
  const std::uint64_t hash = hashOfPoints(testing::viewOfPoints(points));
  for (Eigen::Index row = 0; row < 3; ++row) {
    points.row(row) *= -1;
    EXPECT_NE(hashOfPoints(testing::viewOfPoints(points)), hash) << row;
    points.row(row) *= -1;
  }
  EXPECT_EQ(hashOfPoints(testing::viewOfPoints(points)), hash);
}

TEST_F(Room, decisionsOnACopyAreOnTheScan)
{
  const auto problem = [](MultiwayRegistration& registration) -> std::string {
    try {
      registration.run();
    }
    catch (const DecisionError& error) {
      return error.what();
    }
    return "";
  };
  MultiwayOptions options;
  options.threads = 2;
  {
    MultiwayRegistration registration(options);
    room_links_.serve(registration);
    addAll(registration);
    const int copy = registration.addScan("copy of 2", view(2));
    for (const int other : {0, 1, 3, 4})
      registration.reject(copy, other);
    registration.pin(registration.addScan("copy of 3", view(3)));
    const MultiwayMap map = registration.run();
    EXPECT_EQ(map.scans[2].component, 1);
    EXPECT_EQ(map.scans[3].component, 0);
    EXPECT_TRUE(map.scans[3].T_map_scan.matrix().isIdentity(1e-12));
    EXPECT_TRUE(map.scans[6].T_map_scan.matrix().isIdentity(1e-12));
    registration.accept(2, 0);
    EXPECT_THAT(problem(registration), HasSubstr("s0, s2 is both accepted and rejected"));
  }
  {
    MultiwayRegistration registration(options);
    room_links_.serve(registration);
    addAll(registration);
    const int copy = registration.addScan("copy of 2", view(2));
    registration.accept(copy, 0);
    PosePrior prior;
    prior.T_map_scan = truth_[2];
    registration.setPosePrior(copy, prior);
    const MultiwayMap map = registration.run();
    EXPECT_EQ(map.components, 1);
    EXPECT_TRUE(map.scans[2].T_map_scan.isApprox(truth_[2], 0.01));
    registration.accept(copy, 2);
    EXPECT_THAT(problem(registration), HasSubstr("accepted link of s2 is of a scan with itself"));
  }
}

TEST_F(Room, theProjectHoldsTheMapAsItWasBroughtToTheUsersFrame)
{
  const TemporaryFolder folder;
  const std::string file = folder.file("map.sqlite");
  MultiwayRegistration registration;
  registration.openProject(file, false);
  room_links_.serve(registration);
  addAll(registration);
  registration.pin(0);
  MultiwayMap map = registration.run();
  for (MapScan& scan : map.scans)
    scan.T_map_scan = Eigen::Translation3d(3e5, 4e6, 100) * scan.T_map_scan;
  registration.writeToProject(map);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  sqlite3_stmt* rows = nullptr;
  ASSERT_EQ(sqlite3_prepare_v2(database, "SELECT T_map_scan FROM scans ORDER BY scan", -1, &rows, nullptr), SQLITE_OK);
  for (const MapScan& scan : map.scans) {
    ASSERT_EQ(sqlite3_step(rows), SQLITE_ROW);
    EXPECT_EQ(std::memcmp(sqlite3_column_blob(rows, 0), scan.T_map_scan.matrix().data(), 16 * sizeof(double)), 0);
  }
  EXPECT_EQ(sqlite3_step(rows), SQLITE_DONE);
  sqlite3_finalize(rows);
  ASSERT_EQ(sqlite3_prepare_v2(database, "SELECT kind, value FROM decisions", -1, &rows, nullptr), SQLITE_OK);
  ASSERT_EQ(sqlite3_step(rows), SQLITE_ROW);
  EXPECT_STREQ(reinterpret_cast<const char*>(sqlite3_column_text(rows, 1)), "s0");
  sqlite3_finalize(rows);
  sqlite3_close(database);
}

TEST_F(Room, badScansAreRowsWithReasons)
{
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  room_links_.serve(registration);
  addAll(registration);
  registration.addScan("empty", ScanView());
  registration.addScan("twice", view(1));
  registration.addScans({"broken"}, [](std::size_t) -> ScanSource { throw std::runtime_error("cannot be read"); });
  const MultiwayMap map = registration.run();
  EXPECT_EQ(map.components, 3);
  EXPECT_THAT(map.scans[5].reason, HasSubstr("0 finite points"));
  EXPECT_THAT(map.scans[6].reason, HasSubstr("same points as s1"));
  EXPECT_EQ(map.scans[6].component, 0);
  EXPECT_TRUE(map.scans[6].T_map_scan.matrix() == map.scans[1].T_map_scan.matrix());
  EXPECT_EQ(map.scans[7].reason, "cannot be read");
  EXPECT_EQ(map.placed, 6U);
}

TEST_F(Room, copiesOfAScanThatIsNotPlacedAreNotPlaced)
{
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  const Eigen::Matrix3Xf elsewhere = 0.05F * Eigen::Matrix3Xf::Random(3, 20000).colwise().normalized();
  registration.addScan("blob", testing::viewOfPoints(elsewhere));
  registration.addScan("s0", view(0));
  registration.addScan("s1", view(1));
  const MultiwayMap alone = registration.run();
  ASSERT_EQ(alone.placed, 2U);
  for (const char* name : {"copy 1", "copy 2"})
    registration.addScan(name, testing::viewOfPoints(elsewhere));
  const MultiwayMap map = registration.run();
  EXPECT_EQ(map.placed, 2U);
  EXPECT_EQ(map.components, 2);
  EXPECT_EQ(map.scans[1].component, 0);
  EXPECT_EQ(map.scans[0].reason, alone.scans[0].reason);
  EXPECT_FALSE(map.scans[0].reason.empty());
  for (const std::size_t copy : {3, 4}) {
    EXPECT_EQ(map.scans[copy].component, 1);
    EXPECT_THAT(map.scans[copy].reason, HasSubstr("same points as blob, which is not placed"));
  }
}

TEST_F(Room, whatAPersonAcceptedStaysTogether)
{
  // A link that is sure and wrong: the walls of the one scan hang in what the other one saw to be free.
  PairLink link;
  link.source = 0;
  link.target = 1;
  link.status = Status::Converged;
  link.confidence = 0.99;
  link.probability_of_none = 0.01;
  link.hypotheses.resize(1);
  link.hypotheses[0].probability = 0.99;
  link.hypotheses[0].score = link.hypotheses[0].overlap = 0.5;
  link.hypotheses[0].information = 1e6 * Eigen::Matrix<double, 6, 6>::Identity();
  link.hypotheses[0].T_target_source = truth_[1].inverse() * Eigen::Translation3d(0.6, 0.5, 0) * truth_[0];
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  registration.setLinker([&](const std::vector<PairTask>&, const OnLink& on_link) { on_link(link); });
  registration.addScan("s0", view(0));
  registration.addScan("s1", view(1));
  const MultiwayMap doubted = registration.run();
  EXPECT_EQ(doubted.components, 2);
  EXPECT_THAT(doubted.scans[0].reason + doubted.scans[1].reason, HasSubstr("in view of both parts is not the same"));
  registration.accept(0, 1);
  const MultiwayMap map = registration.run();
  EXPECT_EQ(map.components, 1);
  ASSERT_FALSE(map.notes.empty());
  EXPECT_THAT(map.notes.front(), HasSubstr("that a person accepted, though where its links put it, its surfaces hang"));
}

TEST_F(Room, whatCannotBeAddedLeavesNothingBehind)
{
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  const auto load = [](std::size_t i) { return ScanSource{view(static_cast<int>(i)), nullptr}; };
  EXPECT_THROW(registration.addScans({"s0", "s1", "s0"}, load), std::invalid_argument);
  EXPECT_EQ(registration.size(), 0U);
  const auto cancel = [](const std::string&, std::size_t done, std::size_t) {
    if (done == 2)
      throw std::runtime_error("cancelled");
  };
  EXPECT_THROW(registration.addScans({"s0", "s1", "s2"}, load, cancel), std::runtime_error);
  EXPECT_EQ(registration.size(), 0U);
  EXPECT_THROW(registration.setPosePrior(0, PosePrior()), std::invalid_argument);
  registration.addScans({"s0", "s1", "s2"}, load);
  EXPECT_EQ(registration.run().placed, 3U);
}

TEST_F(Room, linkingStopsWhenALinkCannotBeKept)
{
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  addAll(registration);
  int shown = 0;
  EXPECT_THROW(registration.run([&](const std::string& stage, std::size_t done, std::size_t) {
    shown += stage == "link" ? 1 : 0;
    if (stage == "link" && done > 0)
      throw std::runtime_error("the disk is full");
  }),
               std::runtime_error);
  EXPECT_LE(shown, 3); // the start, this one, one that was being made
}

TEST_F(Room, posesThatAreNoneAndPriorsFarFromTheSensor)
{
  MultiwayRegistration registration;
  const Eigen::Matrix3Xf moved = scans_[1].colwise() + Eigen::Vector3f(30, 0, 0);
  ScanView far = testing::viewOfPoints(moved);
  far.viewpoint = {30, 0, 0};
  registration.addScan("s0", view(0));
  registration.addScan("s1", far);
  PosePrior prior;
  prior.T_map_scan(0, 3) = std::nan("");
  EXPECT_THROW(registration.setPosePrior(0, prior), std::invalid_argument);
  prior = {};
  prior.T_map_scan.linear() *= 2;
  EXPECT_THROW(registration.setPosePrior(0, prior), std::invalid_argument);
  prior = {};
  prior.translation = std::numeric_limits<double>::infinity();
  EXPECT_THROW(registration.setPosePrior(0, prior), std::invalid_argument);
  prior = {};
  registration.setPosePrior(0, prior);
  registration.setPosePrior(1, prior);
  GuessTolerance tolerance;
  registration.setLinker([&](const std::vector<PairTask>& tasks, const OnLink&) {
    if (!tasks.empty() && tasks[0].guess)
      tolerance = tasks[0].guess->tolerance;
  });
  EXPECT_THROW(registration.run(), std::runtime_error); // the linker gave none
  EXPECT_NEAR(tolerance.translation, 2 + 30 * prior.rotation, 1e-9) << "of the sensors, wherever the origins are";
  EXPECT_NEAR(tolerance.rotation, 2 * prior.rotation, 1e-12);
}

TEST_F(Room, aPoseOfFewDigitsLeavesTheMapRigid)
{
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  registration.addScan("s0", view(0));
  registration.addScan("s1", view(1));
  PosePrior prior;
  prior.T_map_scan.matrix().topLeftCorner<2, 2>() << 0.707, -0.707, 0.707, 0.707;
  prior.T_map_scan.translation() << 100, 50, 0;
  registration.setPosePrior(0, prior);
  room_links_.serve(registration);
  for (const MapScan& scan : registration.run().scans) {
    ASSERT_GE(scan.component, 0);
    EXPECT_TRUE(scan.T_map_scan.linear().isUnitary(1e-12)) << scan.name;
  }
}

TEST(PairOptions, drawPlansWhereOneMainNormalIsCommon)
{
  MultiwayOptions options;
  EXPECT_EQ(options.registration.patch_profile.search.plans_below, 1);
  EXPECT_EQ(pairOptions(options).patch_profile.search.plans_below, options.link.plans_below);
  options.registration.patch_profile.search.plans_below = 0.1;
  EXPECT_EQ(pairOptions(options).patch_profile.search.plans_below, 0.1);
  for (const double share : {0.0, -0.3, 1.1, std::numeric_limits<double>::quiet_NaN()}) {
    options.link.plans_below = share;
    EXPECT_THROW(validate(options), std::invalid_argument) << share;
  }
}

TEST_F(Room, aLinkWithoutHypothesesSaysNothing)
{
  MultiwayOptions options;
  options.threads = 2;
  options.link.least_probability = 0.9999999; // more than any pose of these pairs has
  MultiwayRegistration registration(options);
  addAll(registration);
  const MultiwayMap map = registration.run();
  for (const MapScan& scan : map.scans)
    EXPECT_EQ(scan.links, 0) << scan.name;
}

TEST_F(Room, aJoinNeedsTheConfidenceOfAnAcceptedPair)
{
  MultiwayOptions options;
  options.threads = 2;
  options.registration.min_confidence = 1;
  MultiwayRegistration registration(options);
  addAll(registration);
  const MultiwayMap map = registration.run();
  EXPECT_EQ(map.components, 5);
  EXPECT_THAT(map.scans[0].reason, HasSubstr("not sure enough"));
}

TEST_F(Room, aPersonsWordAndPriorsCount)
{
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration registration(options);
  room_links_.serve(registration);
  addAll(registration);
  for (const int other : {0, 1, 3, 4})
    registration.reject(2, other);
  registration.pin(3);
  const MultiwayMap map = registration.run();
  EXPECT_EQ(map.components, 2);
  EXPECT_EQ(map.scans[2].component, 1);
  EXPECT_TRUE(map.scans[3].T_map_scan.matrix().isIdentity(1e-12));
  PosePrior prior;
  prior.T_map_scan = truth_[3];
  registration.setPosePrior(3, prior);
  EXPECT_TRUE(registration.run().scans[3].T_map_scan.isApprox(truth_[3], 1e-9));
}

/// Links as another process does: from a message and from points of its own, the last pair first.
std::string
answer(const std::string& message, const std::function<ScanView(int)>& view, const MultiwayOptions& options)
{
  std::vector<PairTask> tasks = tasksFromBytes(message);
  std::reverse(tasks.begin(), tasks.end());
  std::vector<PairLink> links;
  for (const PairTask& task : tasks) {
    EXPECT_EQ(task.source_hash, hashOfScan(view(task.source)));
    EXPECT_EQ(task.target_hash, hashOfScan(view(task.target)));
    links.push_back(linkPair(task,
                             prepareScan(view(task.source), options.registration),
                             prepareScan(view(task.target), options.registration),
                             options));
  }
  return toBytes(links);
}

TEST_F(Room, pairsLinkedElsewhereGiveTheSameBits)
{
  const TemporaryFolder folder;
  MultiwayOptions options;
  options.threads = 2;
  MultiwayRegistration here(options), there(options);
  there.openProject(folder.file("map.sqlite"), false);
  for (MultiwayRegistration* registration : {&here, &there}) {
    addAll(*registration);
    for (const int scan : {1, 3}) {
      PosePrior prior;
      prior.T_map_scan = truth_[static_cast<std::size_t>(scan)];
      registration->setPosePrior(scan, prior);
    }
  }
  std::size_t asked = 0, shown = 0;
  there.setLinker([&](const std::vector<PairTask>& tasks, const OnLink& on_link) {
    asked += tasks.size();
    EXPECT_EQ(std::count_if(tasks.begin(), tasks.end(), [](const PairTask& task) { return task.guess.has_value(); }),
              1);
    for (const PairLink& link : linksFromBytes(answer(toBytes(tasks), view, options)))
      on_link(link);
  });
  const MultiwayMap expected = here.run();
  expectSameBits(expected, there.run([&](const std::string& stage, std::size_t, std::size_t) {
    shown += stage == "link" ? 1 : 0;
  }));
  EXPECT_EQ(asked, 10U);
  EXPECT_EQ(shown, 11U);
  expectSameBits(expected, there.run()); // all are in the project: nobody is asked
  EXPECT_EQ(asked, 10U);
}

TEST_F(Room, whatALinkerOwesIsSaid)
{
  MultiwayOptions options;
  options.threads = 1;
  MultiwayRegistration registration(options);
  addAll(registration);
  const auto problemWith = [&](const PairLinker& linker) -> std::string {
    registration.setLinker(linker);
    try {
      registration.run();
    }
    catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  PairLink link;
  link.source = 1;
  link.target = 2;
  EXPECT_THAT(problemWith([&](const auto&, const OnLink& on_link) { on_link(link); }), HasSubstr("left out 9 of 10"));
  const std::string twice = "a link of the scans 1 and 2, which was not asked for";
  EXPECT_THAT(problemWith([&](const auto&, const OnLink& on_link) {
                on_link(link);
                on_link(link);
              }),
              HasSubstr(twice));
  link.target = 5;
  EXPECT_THAT(problemWith([&](const auto&, const OnLink& on_link) { on_link(link); }), HasSubstr("scans 1 and 5"));
  EXPECT_EQ(problemWith([](const auto&, const OnLink&) { throw std::runtime_error("a rank died"); }), "a rank died");
}

/// Five scans in each of two rooms, each in a frame of its own. A pair is linked once for all tests.
class Rooms : public Room {
protected:
  static constexpr std::size_t kScans = 10;

  static void
  SetUpTestSuite()
  {
    testing::Random random(17);
    const testing::Scene scene = testing::makeFurnishedRoom(3);
    for (std::size_t i = 0; i < kScans; ++i) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation() = scene.stations[i / 2 % 2] + 0.2 * static_cast<double>(i / 4) * Eigen::Vector3d::UnitX();
      const Eigen::Matrix3Xf points = testing::castScan(scene, T, testing::roomScanner(0.03), 50 + i);
      const float size = roomOf(i) == 0 ? 1.0F : 1.35F; // one room is larger than the other
      rooms_.push_back(size * testing::randomRotation(random).cast<float>() * points);
    }
  }
  static void
  TearDownTestSuite()
  {
    rooms_.clear();
    linked_.clear();
  }
  static std::size_t
  roomOf(std::size_t scan)
  {
    return scan % 2;
  }
  static MultiwayOptions
  optionsOf(PairRule rule)
  {
    MultiwayOptions options;
    options.threads = 1;
    options.pairs = rule;
    options.candidates.alike = 2;
    options.candidates.apart = 2;
    options.candidates.apart_of_scan = 1;
    return options;
  }
  /// \param[in,out] count of the pairs that are linked by no project, which end the run when there are \p most
  static MultiwayMap
  mapOfRooms(const MultiwayOptions& options, std::size_t& count, const std::string& project = "", std::size_t most = 99)
  {
    MultiwayRegistration registration(options);
    if (!project.empty())
      registration.openProject(project, true);
    for (std::size_t i = 0; i < kScans; ++i) {
      ScanView view;
      view.xyz = rooms_[i].data();
      view.size = static_cast<std::size_t>(rooms_[i].cols());
      registration.addScan("s" + std::to_string(i), view);
    }
    registration.setLinker([&](const std::vector<PairTask>& tasks, const OnLink& on_link) {
      for (const PairTask& task : tasks) {
        if (count >= most)
          throw std::runtime_error("killed");
        ++count;
        on_link(linked_.link(registration, task, options));
      }
    });
    return registration.run();
  }

  static inline std::vector<Eigen::Matrix3Xf> rooms_;
  static inline testing::LinkCache linked_;
};

TEST_F(Rooms, candidatesPlaceWhatAllPairsPlace)
{
  std::size_t of_all = 0, of_candidates = 0, of_threads = 0, of_many = 0;
  const MultiwayMap all = mapOfRooms(optionsOf(PairRule::Auto), of_all);
  MultiwayOptions options = optionsOf(PairRule::Candidates);
  const MultiwayMap chosen = mapOfRooms(options, of_candidates);
  EXPECT_EQ(of_all, 45U);
  EXPECT_EQ(of_candidates, chosen.links.size());
  EXPECT_LE(of_candidates, 35U);
  EXPECT_EQ(all.components, 2);
  EXPECT_EQ(chosen.components, 2);
  for (const MultiwayMap* map : {&all, &chosen})
    for (std::size_t i = 0; i < kScans; ++i)
      for (std::size_t k = 0; k < i; ++k)
        EXPECT_EQ(map->scans[i].component == map->scans[k].component, roomOf(i) == roomOf(k)) << i << " " << k;
  EXPECT_TRUE(std::is_sorted(chosen.links.begin(), chosen.links.end(), [](const MapLink& a, const MapLink& b) {
    return std::pair(a.source, a.target) < std::pair(b.source, b.target);
  }));
  options.threads = 3;
  expectSameBits(chosen, mapOfRooms(options, of_threads));
  // Candidates without being asked for, where there are many scans.
  options.pairs = PairRule::Auto;
  options.candidates.all_up_to = kScans - 1;
  expectSameBits(chosen, mapOfRooms(options, of_many));
  EXPECT_EQ(of_many, of_candidates);
}

TEST_F(Room, whatIsSaidOfScansWithoutALookIsWhatALookSays)
{
  const Options options;
  const PreparedScan a = prepareScan(view(0), options), b = prepareScan(view(1), options);
  const SightOfScan sight_a = sightOf(a), sight_b = sightOf(b);
  EXPECT_GT(sight_a.reach, 2);
  EXPECT_LT(sight_a.reach, 12);
  // Nothing meets so far away, and the weight of all is the same.
  const double apart = sight_a.reach + sight_b.reach + 20;
  const Eigen::Isometry3d far(Eigen::Translation3d(apart, 0, 0));
  const PlacementEvidence evidence = evidenceAt(a, b, far, MultiwayOptions(), 2);
  EXPECT_EQ(evidence.matched, 0);
  EXPECT_EQ(evidence.contradicted, 0);
  EXPECT_EQ(evidence.total, sight_a.total + sight_b.total);
  EXPECT_GT(evidence.total, 0);
}

TEST_F(Rooms, candidatesGoOnWhereTheyWereKilled)
{
  const TemporaryFolder folder;
  const std::string file = folder.file("map.sqlite");
  const MultiwayOptions options = optionsOf(PairRule::Candidates);
  std::size_t undisturbed = 0, killed = 0, resumed = 0, again = 0;
  const MultiwayMap expected = mapOfRooms(options, undisturbed);
  ASSERT_GT(undisturbed, 9U);
  EXPECT_THROW(mapOfRooms(options, killed, file, 4), std::runtime_error);
  std::size_t later = killed;
  EXPECT_THROW(mapOfRooms(options, later, file, undisturbed - 2), std::runtime_error); // in a later round
  resumed = later;
  expectSameBits(expected, mapOfRooms(options, resumed, file));
  EXPECT_EQ(resumed, undisturbed); // none twice
  expectSameBits(expected, mapOfRooms(options, again, file));
  EXPECT_EQ(again, 0U);
}

TEST(PairLinking, bytesThatAreDamagedAreRefused)
{
  PairTask task{3, 7, 0xffffffffffffffffu, 1, PairGuess()};
  task.guess->T_target_source = Eigen::Translation3d(1.0 / 3, -1e-17, 4e5);
  task.guess->tolerance.rotation = 0.1;
  const std::string tasks = toBytes(std::vector<PairTask>{task, PairTask()});
  const std::vector<PairTask> read = tasksFromBytes(tasks);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].target, 7);
  EXPECT_EQ(read[0].source_hash, task.source_hash);
  ASSERT_TRUE(read[0].guess);
  EXPECT_TRUE(read[0].guess->T_target_source.matrix() == task.guess->T_target_source.matrix());
  EXPECT_EQ(read[0].guess->tolerance.rotation, 0.1);
  EXPECT_EQ(read[0].guess->tolerance.translation, task.guess->tolerance.translation);
  EXPECT_FALSE(read[1].guess);

  PairLink link;
  link.status = Status::Ambiguous;
  link.message = std::string("zero \0 in it", 12);
  link.hypotheses.resize(2);
  link.hypotheses[1].information.setRandom();
  const std::string links = toBytes(std::vector<PairLink>{link});
  const std::vector<PairLink> found = linksFromBytes(links);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].status, link.status);
  EXPECT_EQ(found[0].message, link.message);
  ASSERT_EQ(found[0].hypotheses.size(), 2U);
  EXPECT_TRUE(found[0].hypotheses[1].information == link.hypotheses[1].information);

  EXPECT_TRUE(linksFromBytes(toBytes(std::vector<PairLink>())).empty());
  EXPECT_THROW(linksFromBytes(tasks), std::runtime_error);
  EXPECT_THROW(tasksFromBytes(links), std::runtime_error);
  EXPECT_THROW(linksFromBytes(links + "x"), std::runtime_error);
  for (std::size_t size = 0; size < links.size(); ++size)
    EXPECT_THROW(linksFromBytes(links.substr(0, size)), std::runtime_error) << size;
}

TEST_F(Room, onePointCloudOfPclIsAScan)
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (Eigen::Index k = 0; k < scans_[0].cols(); ++k)
    cloud.push_back(pcl::PointXYZ(scans_[0](0, k), scans_[0](1, k), scans_[0](2, k)));
  MultiwayRegistration registration;
  EXPECT_EQ(registration.addPointCloud("a", cloud), 0);
  EXPECT_EQ(registration.find("a"), 0);
  EXPECT_EQ(registration.find("b"), -1);
  EXPECT_TRUE(registration.preparedScan(0).isComplete());
  // A sensor nowhere is one that is not given.
  cloud.sensor_origin_.setConstant(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(registration.addPointCloud("c", cloud), 1);
  EXPECT_TRUE(registration.preparedScan(1).isComplete());
}

TEST_F(Room, givenNormalsAreOfTheScan)
{
  ScanView scan = view(0);
  const std::uint64_t without = hashOfScan(scan);
  Eigen::Matrix3Xf normals = Eigen::Vector3f::UnitZ().replicate(1, scans_[0].cols());
  scan.normals = normals.data();
  const std::uint64_t up = hashOfScan(scan);
  normals = -normals;
  EXPECT_NE(up, without);
  EXPECT_NE(up, hashOfScan(scan));
  EXPECT_EQ(hashOfPoints(scan), hashOfPoints(view(0))) << "the points are the same";
}

TEST_F(Room, theEquationsOfALinkFollowItsConfigurationButNoVertical)
{
  MultiwayOptions options;
  const auto prepared = prepareScans(view(0), view(1), options.registration);
  const Eigen::Isometry3d T = truth_[1].inverse() * truth_[0];
  const auto equations = [&] { return equationsAt(prepared.first, prepared.second, T, options); };
  double& share = options.registration.patch_profile.judgement.uncertainty.unseen_curvature;
  const SurfaceEquations usual = equations();
  ASSERT_GT(usual.weight, 100); // no match weighs more than 1
  share = 0;
  const SurfaceEquations least = equations();
  EXPECT_LT(least.curvature.trace(), 0.999 * usual.curvature.trace());
  EXPECT_EQ(least.hessian, usual.hessian);
  share = UncertaintyConfig().unseen_curvature;
  options.gravity = Eigen::Vector3d::UnitX();
  options.gravity_tolerance = 1e-3;
  EXPECT_EQ(equations().hessian, usual.hessian);
  EXPECT_EQ(equations().gradient, usual.gradient);
}

TEST(Multiway, whatCannotBeDoneIsSaid)
{
  MultiwayRegistration registration;
  registration.addScan("a", ScanView());
  const auto problem = [](const auto& call) -> std::string {
    try {
      call();
    }
    catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem([&] { registration.run(); }),
              HasSubstr("two scans or more, 0 of 1 can be used; a: it has 0 finite"));
  EXPECT_THAT(problem([&] { registration.addScan("a", ScanView()); }), HasSubstr("named a"));
  EXPECT_THAT(problem([&] { registration.accept(0, 7); }), HasSubstr("scan 7"));
  MultiwayOptions options;
  options.choice.lone = 2;
  EXPECT_THAT(problem([&] { MultiwayRegistration bad(options); }), HasSubstr("choice.lone = 2"));
  for (double AliasConfig::*of : {&AliasConfig::level_normal,
                                  &AliasConfig::most_floor,
                                  &AliasConfig::flat_view,
                                  &AliasConfig::least_level_share,
                                  &AliasConfig::same_level,
                                  &AliasConfig::storey}) {
    options = MultiwayOptions();
    options.alias.*of = -0.1;
    EXPECT_THAT(problem([&] { MultiwayRegistration bad(options); }), HasSubstr(" = -0.1"));
  }
  options = MultiwayOptions();
  options.furniture.agreement = 1.5;
  EXPECT_THAT(problem([&] { MultiwayRegistration bad(options); }), HasSubstr("furniture.agreement = 1.5"));
  options = MultiwayOptions();
  options.gravity = Eigen::Vector3d::Zero();
  EXPECT_THAT(problem([&] { MultiwayRegistration bad(options); }), HasSubstr("gravity"));
}

TEST(ProjectFile, whatIsNoProjectIsLeftAlone)
{
  const TemporaryFolder folder;
  const std::string file = folder.file("other.sqlite");
  std::ofstream(file) << "this is no database at all, but long enough to look like one: " << std::string(200, 'x');
  EXPECT_THROW(ProjectFile(file, true), std::runtime_error);
  EXPECT_THROW(ProjectFile(folder.file("no/such/folder.sqlite"), true), std::runtime_error);
}

TEST(ProjectFile, linksComeOutAsTheyWentInAndOnlyOfTheSameSettings)
{
  const TemporaryFolder folder;
  const std::string file = folder.file("map.sqlite");
  PairLink link;
  link.status = Status::Ambiguous;
  link.message = "it's \"so\"; 3 % of it\n";
  link.confidence = 1.0 / 3;
  link.probability_of_none = std::nextafter(0.25, 1);
  PairHypothesis hypothesis;
  hypothesis.T_target_source =
      Eigen::Translation3d(1.0 / 3, -1e-17, 4e5) * Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 3).normalized());
  hypothesis.information.setRandom();
  hypothesis.probability = 0.1;
  link.hypotheses = {hypothesis, hypothesis};
  const std::uint64_t source = 0xffffffffffffffffu, target = 7;
  {
    ProjectFile project(file, false);
    project.writeLink(link, source, target, "settings a");
    project.writeLink(link, target, source, "settings b");
  }
  ProjectFile project(file, true);
  const std::optional<PairLink> found = project.readLink(source, target, "settings a");
  ASSERT_TRUE(found);
  const PairLink& read = *found;
  EXPECT_EQ(read.status, link.status);
  EXPECT_EQ(read.message, link.message);
  EXPECT_EQ(read.confidence, link.confidence);
  EXPECT_EQ(read.probability_of_none, link.probability_of_none);
  ASSERT_EQ(read.hypotheses.size(), 2U);
  EXPECT_TRUE(read.hypotheses[1].T_target_source.matrix() == hypothesis.T_target_source.matrix());
  EXPECT_TRUE(read.hypotheses[1].information == hypothesis.information);
  // A link that is written again replaces what it had.
  link.hypotheses.pop_back();
  project.writeLink(link, source, target, "settings a");
  project.flush();
  EXPECT_EQ(project.readLink(source, target, "settings a").value().hypotheses.size(), 1U);
  EXPECT_EQ(project.readLink(target, source, "settings b").value().hypotheses.size(), 2U);
  EXPECT_FALSE(project.readLink(source, target, "settings b"));
  EXPECT_FALSE(project.readLink(source, source, "settings a"));
}

TEST(ProjectFile, whatFailsHalfWayLeavesTheMapAsItWas)
{
  const TemporaryFolder folder;
  const std::string file = folder.file("map.sqlite");
  MultiwayMap map;
  map.scans.resize(2);
  map.scans[1].name = "first";
  map.links.resize(1);
  map.links[0].target = 1;
  const auto countOf = [&](const char* query) {
    sqlite3* database = nullptr;
    sqlite3_open(file.c_str(), &database);
    sqlite3_stmt* row = nullptr;
    sqlite3_prepare_v2(database, query, -1, &row, nullptr);
    const int count = sqlite3_step(row) == SQLITE_ROW ? sqlite3_column_int(row, 0) : -1;
    sqlite3_finalize(row);
    sqlite3_close(database);
    return count;
  };
  {
    ProjectFile project(file, false);
    project.writeMap(map, {});
    MultiwayMap twice = map;
    twice.scans.resize(3);
    twice.links.push_back(twice.links[0]); // a pair has one link
    EXPECT_THROW(project.writeMap(twice, {}), std::runtime_error);
    EXPECT_EQ(countOf("SELECT count(*) FROM scans"), 2);
  }
  EXPECT_EQ(countOf("SELECT count(*) FROM scans"), 2) << "nor when the file is closed";
  EXPECT_EQ(countOf("SELECT count(*) FROM links"), 1);
}

} // namespace
} // namespace pcl_ssfr::test_multiway_registration
