// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>
#include <apps/simulation/footprint.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/scene_parts.h>
#include <apps/simulation/scenes.h>
#include <apps/simulation/sensor_model.h>
#include <apps/simulation/simulation_error.h>

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>

namespace pcl_ssfr::simulation::test_scenes {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kPi = 3.141592653589793;
constexpr double kPathFree = 0.35; // the documented room about the path [m]

template <typename Element>
bool
sameBytes(const std::vector<Element>& a, const std::vector<Element>& b)
{
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Element)) == 0);
}

bool
sameSurfaces(const SurfaceModel& a, const SurfaceModel& b)
{
  const auto same_sphere = [](const Sphere& s, const Sphere& t) {
    return s.centre == t.centre && s.radius == t.radius && s.material == t.material;
  };
  const auto same_tube = [](const Tube& s, const Tube& t) {
    return s.base == t.base && s.axis == t.axis && s.length == t.length && s.radius == t.radius &&
           s.material == t.material;
  };
  return sameBytes(a.mesh.vertices, b.mesh.vertices) && sameBytes(a.mesh.triangles, b.mesh.triangles) &&
         sameBytes(a.mesh.material, b.mesh.material) &&
         std::equal(a.spheres.begin(), a.spheres.end(), b.spheres.begin(), b.spheres.end(), same_sphere) &&
         std::equal(a.tubes.begin(), a.tubes.end(), b.tubes.begin(), b.tubes.end(), same_tube);
}

Eigen::Vector3d
randomDirection(RandomStream& random)
{
  return random.rotation().col(0);
}

/// Points along the path, at most 10 cm apart.
std::vector<Eigen::Vector3d>
alongPath(const Scene& scene)
{
  std::vector<Eigen::Vector3d> points{scene.path.front()};
  for (std::size_t i = 1; i < scene.path.size(); ++i) {
    const Eigen::Vector3d piece = scene.path[i] - scene.path[i - 1];
    const int count = std::max(1, static_cast<int>(std::ceil(piece.norm() / 0.1)));
    for (int k = 1; k <= count; ++k)
      points.emplace_back(scene.path[i - 1] + piece * (static_cast<double>(k) / count));
  }
  return points;
}

double
pathLength(const Scene& scene)
{
  double length = 0;
  for (std::size_t i = 1; i < scene.path.size(); ++i)
    length += (scene.path[i] - scene.path[i - 1]).norm();
  return length;
}

/// Distance along a ray, infinite when it meets nothing.
double
rangeOf(const RayCaster& caster, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double reach)
{
  const auto hit = caster.cast(from, direction, reach);
  return hit ? hit->distance : std::numeric_limits<double>::infinity();
}

/// What is documented of a scene.
struct Expected {
  const char* name;
  double shortest; ///< of the longer side of its outline [m]
  double longest;
  std::size_t least_triangles;
  bool covered;       ///< there is a ceiling over the whole path
  double rough_floor; ///< the floor is within this height of the path [m]
  double step_low;    ///< of natural_step [m]
  double step_high;
};

constexpr Expected kExpected[] = {{"basic_model", 9, 12, 300, true, 0.01, 0.3, 1},
                                  {"apartment", 11, 13, 3000, true, 0.01, 0.3, 0.6},
                                  {"office_floor", 24, 28, 8000, true, 0.01, 0.5, 1.5},
                                  {"hall", 62, 70, 15000, true, 0.01, 5, 12},
                                  {"street", 120, 190, 40000, false, 0.05, 2, 5},
                                  {"endless_corridor", 500, 700, 100, true, 0.01, 0.3, 1.5},
                                  {"symmetric_room", 8, 12, 1000, true, 0.01, 0.3, 1},
                                  {"cylinder_hall", 22, 30, 3000, true, 0.01, 0.5, 2},
                                  {"slanted", 8, 18, 80, true, 0.01, 0.3, 1},
                                  {"cave", 34, 48, 50000, true, 0.5, 0.5, 2},
                                  {"two_floors_alike", 25, 32, 20000, true, 0.35, 0.5, 2},
                                  {"tower", 25, 32, 20000, true, 0.35, 0.5, 3},
                                  {"hotel_corridor", 18, 24, 4000, true, 0.01, 0.5, 3},
                                  {"twin_wings", 35, 40, 12000, true, 0.01, 0.5, 3},
                                  {"plant_hall", 46, 52, 4000, true, 0.01, 1, 6},
                                  {"rooms_with_doors", 14, 22, 3000, true, 0.01, 0.5, 3},
                                  {"campus", 150, 175, 40000, false, 0.15, 4, 12},
                                  {"tree_road", 200, 240, 40000, false, 0.15, 2, 8},
                                  {"industrial_site", 140, 170, 20000, false, 0.15, 4, 12},
                                  {"car_park_levels", 46, 52, 1500, false, 0.35, 2, 8},
                                  {"forest_edge", 120, 160, 40000, false, 0.15, 2, 8}};
constexpr std::size_t kMostTriangles = 160000;

const Expected&
expectedOf(const std::string& name)
{
  return *std::find_if(
      std::begin(kExpected), std::end(kExpected), [&](const Expected& entry) { return name == entry.name; });
}

class EveryScene : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryScene, IsAsDocumented)
{
  const Expected& expected = expectedOf(GetParam());
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = makeScene(GetParam(), seed);
    EXPECT_EQ(scene.name, GetParam());
    EXPECT_FALSE(scene.description.empty());
    EXPECT_NO_THROW(validate(scene.surfaces));
    const Eigen::Vector3d size = boundsOf(scene.surfaces).sizes();
    EXPECT_GE(size.head<2>().maxCoeff(), expected.shortest);
    EXPECT_LE(size.head<2>().maxCoeff(), expected.longest);
    EXPECT_GT(size.z(), 2.2);
    EXPECT_LT(size.z(), 25);
    EXPECT_GE(scene.surfaces.mesh.triangles.size(), expected.least_triangles);
    EXPECT_LE(scene.surfaces.mesh.triangles.size(), kMostTriangles);
    EXPECT_THAT(sensorNames(), Contains(scene.recommended_sensor));
    EXPECT_GE(scene.natural_step, expected.step_low);
    EXPECT_LE(scene.natural_step, expected.step_high);
    EXPECT_GE(pathLength(scene), 6 * scene.natural_step);
    EXPECT_FALSE(scene.walk_areas.empty());
    for (const LooseItem& item : scene.loose_items)
      EXPECT_NO_THROW(validate(item.surfaces));
  }
}

TEST_P(EveryScene, PathIsFreeAndHasAFloorAndACeiling)
{
  const Expected& expected = expectedOf(GetParam());
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = makeScene(GetParam(), seed);
    const RayCaster caster(surfacesAt(scene, {}, seed, 0));
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    for (const Eigen::Vector3d& foot : alongPath(scene)) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const double height : {0.21, 0.5, 0.8, 1.1, 1.4, 1.7, 2.0})
        for (int i = 0; i < 16; ++i) {
          const Eigen::Vector3d direction(std::cos(kPi * i / 8), std::sin(kPi * i / 8), 0);
          nearest = std::min(nearest, rangeOf(caster, foot + height * up, direction, 1));
        }
      ASSERT_GE(nearest, kPathFree) << foot.transpose();
      const double above = rangeOf(caster, foot + 0.21 * up, up, 100) + 0.21;
      ASSERT_GT(above, 2.0) << foot.transpose();
      if (expected.covered) {
        ASSERT_LT(above, 20) << "no ceiling over " << foot.transpose();
      }
      const double below = rangeOf(caster, foot + up, -up, 100) - 1;
      ASSERT_LE(std::abs(below), expected.rough_floor) << foot.transpose();
    }
  }
}

TEST_P(EveryScene, PeopleHaveFreeFloorBesideThePath)
{
  const double rough = expectedOf(GetParam()).rough_floor + 0.2; // tyres, kerbs and boulders' feet are no obstacle
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = makeScene(GetParam(), seed);
    const RayCaster caster(scene.surfaces);
    const std::vector<Eigen::Vector3d> path = alongPath(scene);
    for (const WalkArea& area : scene.walk_areas) {
      ASSERT_EQ(area.lower.z(), area.upper.z());
      ASSERT_GE((area.upper - area.lower).head<2>().minCoeff(), 0.6);
      for (int i = 0; i <= 8; ++i)
        for (int j = 0; j <= 8; ++j) {
          const Eigen::Vector3d share(0.02 + 0.12 * i, 0.02 + 0.12 * j, 0);
          const Eigen::Vector3d foot = area.lower + share.cwiseProduct(area.upper - area.lower);
          const double below = rangeOf(caster, foot + Eigen::Vector3d(0, 0, 1.8), -Eigen::Vector3d::UnitZ(), 10);
          ASSERT_NEAR(below, 1.8, rough) << "seed " << seed << ", " << foot.transpose();
          for (const Eigen::Vector3d& point : path)
            if (std::abs(point.z() - foot.z()) < 1) {
              ASSERT_GE((point - foot).head<2>().norm(), 0.5) << "seed " << seed << ", " << foot.transpose();
            }
        }
    }
  }
}

TEST_P(EveryScene, SeedDecidesEveryBit)
{
  const Scene first = makeScene(GetParam(), 7);
  const Scene again = makeScene(GetParam(), 7);
  const Scene other = makeScene(GetParam(), 8);
  EXPECT_TRUE(sameSurfaces(first.surfaces, again.surfaces));
  EXPECT_TRUE(sameBytes(first.path, again.path));
  ASSERT_EQ(first.loose_items.size(), again.loose_items.size());
  for (std::size_t i = 0; i < first.loose_items.size(); ++i) {
    EXPECT_TRUE(sameSurfaces(first.loose_items[i].surfaces, again.loose_items[i].surfaces));
    EXPECT_EQ(first.loose_items[i].place, again.loose_items[i].place);
  }
  EXPECT_FALSE(sameSurfaces(first.surfaces, other.surfaces));
}

TEST_P(EveryScene, ThingsMoveWithinTheirAreasAndKeepAway)
{
  // Everything moves, somebody is there, and what moves stays clear of the sensor.
  const Scene scene = makeScene(GetParam(), 2);
  const std::vector<Eigen::Vector3d> path = alongPath(scene);
  MovableOptions options;
  options.people = 3;
  options.doors_move = true;
  options.moved_furniture = 1;
  for (std::size_t scan = 0; scan < 4; ++scan) {
    const Eigen::Vector3d& sensor = path[path.size() * (2 * scan + 1) / 8];
    const SurfaceModel model = surfacesAt(scene, options, 5, scan, {sensor});
    const RayCaster caster(model);
    for (const double height : {0.3, 0.9, 1.5})
      for (int i = 0; i < 64; ++i) {
        const Eigen::Vector3d direction(std::cos(kPi * i / 32), std::sin(kPi * i / 32), 0);
        const double range = rangeOf(caster, sensor + Eigen::Vector3d(0, 0, height), direction, 5);
        ASSERT_GE(range, kPathFree) << "scan " << scan;
      }
    EXPECT_GT(model.mesh.triangles.size(), scene.surfaces.mesh.triangles.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, ::testing::ValuesIn(sceneNames()), [](const auto& suite) {
  return suite.param;
});

TEST(Scenes, NamesAreThoseOfTheContract)
{
  EXPECT_THAT(sceneNames(),
              ::testing::ElementsAre("basic_model",
                                     "apartment",
                                     "office_floor",
                                     "hall",
                                     "street",
                                     "endless_corridor",
                                     "symmetric_room",
                                     "cylinder_hall",
                                     "slanted",
                                     "cave",
                                     "two_floors_alike",
                                     "tower",
                                     "hotel_corridor",
                                     "twin_wings",
                                     "plant_hall",
                                     "rooms_with_doors",
                                     "campus",
                                     "tree_road",
                                     "industrial_site",
                                     "car_park_levels",
                                     "forest_edge"));
  try {
    makeScene("palace", 1);
    FAIL();
  }
  catch (const SimulationError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("'palace'"), HasSubstr("apartment")));
  }
}

TEST(Scenes, FurnitureReallyStands)
{
  // Materials that only furniture, cars and trees have.
  const auto count = [](const Scene& scene, const std::string& name) {
    std::size_t triangles = 0;
    for (const std::uint16_t material : scene.surfaces.mesh.material)
      triangles += scene.surfaces.materials[material].name == name ? 1U : 0U;
    return triangles;
  };
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene apartment = makeScene("apartment", seed);
    EXPECT_GE(count(apartment, "paper"), 200U);       // books
    EXPECT_GE(count(apartment, "light cloth"), 500U); // the bed
    EXPECT_GE(count(apartment, "tile"), 100U);        // bath and kitchen
    EXPECT_EQ(apartment.doors.size(), 4U);
    EXPECT_GE(apartment.loose_items.size(), 4U);
    const Scene office = makeScene("office_floor", seed);
    EXPECT_GE(office.doors.size(), 11U);
    EXPECT_GE(office.loose_items.size(), 12U);
    const Scene street = makeScene("street", seed);
    EXPECT_GE(count(street, "foliage"), 10U * 1400);
    EXPECT_GE(street.loose_items.size(), 10U); // cars
    EXPECT_GE(count(street, "glass"), 2000U);
    const Scene hall = makeScene("hall", seed);
    EXPECT_GE(hall.surfaces.tubes.size(), 150U); // columns, railings, pipes
    EXPECT_GE(count(hall, "foliage"), 3U * 1400);
  }
}

TEST(Traps, EndlessCorridorLooksTheSameEverywhere)
{
  constexpr double kReach = 60;
  const Scene scene = makeScene("endless_corridor", 3);
  const RayCaster caster(scene.surfaces);
  RandomStream random(1);
  std::size_t compared = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d direction = randomDirection(random);
    const Eigen::Vector3d from(random.uniform(-15, 15), random.uniform(-0.4, 0.4), random.uniform(0.5, 1.8));
    const double shift = random.uniform(-15, 15);
    const double here = rangeOf(caster, from, direction, kReach);
    const double there = rangeOf(caster, from + Eigen::Vector3d(shift, 0, 0), direction, kReach);
    if (std::isinf(here) && std::isinf(there))
      continue;
    ASSERT_NEAR(here, there, 1e-5) << direction.transpose();
    ++compared;
  }
  EXPECT_GT(compared, 3800U);
  // But not when one moves across it.
  const Eigen::Vector3d side = Eigen::Vector3d::UnitY();
  EXPECT_GT(std::abs(rangeOf(caster, {0, 0.3, 1.5}, side, kReach) - rangeOf(caster, {0, 0, 1.5}, side, kReach)), 0.2);
}

using Corner = std::array<float, 3>;

std::set<std::array<Corner, 3>>
trianglesOf(const SurfaceModel& model, bool half_turn)
{
  std::set<std::array<Corner, 3>> all;
  for (const auto& triangle : model.mesh.triangles) {
    std::array<Corner, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f& v = model.mesh.vertices[triangle[k]];
      const float sign = half_turn ? -1.F : 1.F;
      corners[k] = {sign * v.x() + 0.F, sign * v.y() + 0.F, v.z()};
    }
    std::sort(corners.begin(), corners.end());
    all.insert(corners);
  }
  return all;
}

TEST(Traps, SymmetricRoomIsItsOwnHalfTurn)
{
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = makeScene("symmetric_room", seed);
    const SurfaceModel model = surfacesAt(scene, {}, 1, 0);
    EXPECT_EQ(trianglesOf(model, false), trianglesOf(model, true)); // to the last bit
    EXPECT_EQ(scene.loose_items.size() % 2, 0U);
    EXPECT_TRUE(scene.doors.empty());
    const RayCaster caster(model);
    RandomStream random(seed);
    const Eigen::Matrix3d half_turn = Eigen::Vector3d(-1, -1, 1).asDiagonal();
    const Eigen::Matrix3d quarter_turn = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    std::size_t differs = 0;
    for (int i = 0; i < 5000; ++i) {
      const Eigen::Vector3d from(random.uniform(-1.5, 1.5), random.uniform(-0.3, 0.3), random.uniform(0.5, 2));
      const Eigen::Vector3d direction = randomDirection(random);
      const double here = rangeOf(caster, from, direction, 30);
      ASSERT_NEAR(here, rangeOf(caster, half_turn * from, half_turn * direction, 30), 1e-6);
      differs += std::abs(here - rangeOf(caster, quarter_turn * from, quarter_turn * direction, 30)) > 0.1 ? 1U : 0U;
    }
    EXPECT_GT(differs, 1500U);
  }
}

TEST(Traps, TwoFloorsLookTheSame)
{
  constexpr double kStorey = 3.5;
  for (const std::uint64_t seed : {1, 2}) {
    const Scene scene = makeScene("two_floors_alike", seed);
    const RayCaster caster(surfacesAt(scene, {}, 1, 0));
    std::vector<Eigen::Vector3d> lower;
    for (const Eigen::Vector3d& point : alongPath(scene))
      if (point.z() == 0)
        lower.push_back(point);
    ASSERT_GT(lower.size(), 100U);
    // The path visits the same places upstairs.
    EXPECT_TRUE(scene.path.front().head<2>() == scene.path.back().head<2>());
    EXPECT_NEAR(scene.path.back().z() - scene.path.front().z(), kStorey, 1e-9);
    RandomStream random(seed);
    std::size_t same = 0;
    std::size_t elsewhere = 0;
    constexpr std::size_t kRays = 10000;
    for (std::size_t i = 0; i < kRays; ++i) {
      const auto& foot = lower[static_cast<std::size_t>(random.index(static_cast<int>(lower.size())))];
      const Eigen::Vector3d eye = foot + Eigen::Vector3d(0, 0, 1.2);
      const Eigen::Vector3d direction = randomDirection(random);
      const double here = rangeOf(caster, eye, direction, 60);
      const auto distance = [&](const Eigen::Vector3d& shift) {
        return std::abs(rangeOf(caster, eye + shift, direction, 60) - here);
      };
      same += distance({0, 0, kStorey}) < 1e-4 ? 1U : 0U;
      elsewhere += distance({0, 0.4, 0}) < 1e-4 ? 1U : 0U;
    }
    EXPECT_GE(same, kRays * 999 / 1000);
    EXPECT_LT(elsewhere, kRays * 7 / 10); // floor and ceiling look the same from there, walls do not
  }
}

TEST(Traps, SlantedRoomHasNoRightAngles)
{
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const Scene scene = makeScene("slanted", seed);
    // Planes by direction and distance: triangles of one wall add up.
    std::vector<std::pair<Eigen::Vector4d, double>> planes;
    const TriangleMesh& mesh = scene.surfaces.mesh;
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
      const Eigen::Vector3d cross =
          (mesh.vertices[t[1]].cast<double>() - a).cross(mesh.vertices[t[2]].cast<double>() - a);
      Eigen::Vector4d plane;
      plane << cross.normalized(), cross.normalized().dot(a);
      const auto known = std::find_if(planes.begin(), planes.end(), [&](const auto& entry) {
        return std::min((entry.first - plane).norm(), (entry.first + plane).norm()) < 1e-3;
      });
      if (known == planes.end())
        planes.emplace_back(plane, cross.norm() / 2);
      else
        known->second += cross.norm() / 2;
    }
    std::vector<Eigen::Vector3d> large;
    for (const auto& [plane, area] : planes)
      if (area > 3)
        large.emplace_back(plane.head<3>());
    EXPECT_GE(large.size(), 7U) << "seed " << seed;
    for (std::size_t i = 0; i < large.size(); ++i)
      for (std::size_t j = i + 1; j < large.size(); ++j)
        EXPECT_GT(std::abs(large[i].dot(large[j])), std::sin(10 * kPi / 180)) << "seed " << seed;
  }
}

TEST(Traps, NothingInTheCaveIsFlat)
{
  constexpr double kRadius = 0.4; // a disc of 0.5 m2
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = makeScene("cave", seed);
    const RayCaster caster(scene.surfaces);
    const std::vector<Eigen::Vector3d> path = alongPath(scene);
    RandomStream random(seed);
    for (int i = 0; i < 300; ++i) {
      const auto& foot = path[static_cast<std::size_t>(random.index(static_cast<int>(path.size())))];
      ASSERT_TRUE(caster.cast(foot + Eigen::Vector3d(0, 0, 1.2), randomDirection(random), 40)) << "a hole";
    }
    // Every disc of the radius: the points of the mesh about random vertices are off any plane.
    const auto& vertices = scene.surfaces.mesh.vertices;
    double flattest = std::numeric_limits<double>::infinity();
    int discs = 0;
    for (int i = 0; i < 400; ++i) {
      const Eigen::Vector3d centre =
          vertices[static_cast<std::size_t>(random.index(static_cast<int>(vertices.size())))].cast<double>();
      std::vector<Eigen::Vector3d> near;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3f& vertex : vertices)
        if ((vertex.cast<double>() - centre).norm() < kRadius) {
          near.emplace_back(vertex.cast<double>());
          mean += near.back();
        }
      mean /= static_cast<double>(near.size());
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
      for (const Eigen::Vector3d& point : near)
        covariance += (point - mean) * (point - mean).transpose();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
      // At both ends of the cave many vertices fall into one: they span no disc.
      const double wide = std::sqrt(solver.eigenvalues()[1] / static_cast<double>(near.size()));
      if (near.size() < 8 || wide < kRadius / 4)
        continue;
      ++discs;
      double thickest = 0;
      for (const Eigen::Vector3d& point : near)
        thickest = std::max(thickest, std::abs(solver.eigenvectors().col(0).dot(point - mean)));
      flattest = std::min(flattest, thickest);
    }
    EXPECT_GT(discs, 350);
    EXPECT_GT(flattest, 0.02) << "seed " << seed;
  }
}

/// A room of 8 m by 6 m with a door, two areas and a loose box.
Scene
smallScene()
{
  Scene scene;
  scene.name = "small";
  SurfaceModel& m = scene.surfaces;
  const auto plaster = m.addMaterial("plaster", 0.7);
  m.addPolygon({{0, 0, 0}, {8, 0, 0}, {8, 6, 0}, {0, 6, 0}}, plaster);
  scene.path = {{1, 1, 0}, {7, 1, 0}};
  scene.walk_areas = {{{1, 3, 0}, {4, 5, 0}}, {{5, 3, 0}, {7, 5, 0}}};
  Door door;
  door.hinge = {0, 2, 0};
  door.swing = 1.5;
  scene.doors = {door};
  LooseItem item;
  item.surfaces.addBlock({0, 0, 0}, {0.4, 0.2, 0.5}, 0, item.surfaces.addMaterial("paper", 0.6));
  item.place = {6, 2, 0};
  item.yaw = 0.3;
  item.area = scene.walk_areas[1];
  scene.loose_items.assign(4, item);
  for (std::size_t i = 0; i < 4; ++i)
    scene.loose_items[i].place.x() = 4 + static_cast<double>(i);
  return scene;
}

/// Vertices of the model beyond what never moves.
std::vector<Eigen::Vector3f>
movables(const Scene& scene, const SurfaceModel& model)
{
  const auto first = static_cast<std::ptrdiff_t>(scene.surfaces.mesh.vertices.size());
  return {model.mesh.vertices.begin() + first, model.mesh.vertices.end()};
}

TEST(SurfacesAt, NothingMovesUnlessAskedTo)
{
  const Scene scene = smallScene();
  const SurfaceModel model = surfacesAt(scene, {}, 1, 0);
  EXPECT_TRUE(sameSurfaces(model, surfacesAt(scene, {}, 1, 5)));
  EXPECT_TRUE(sameSurfaces(model, surfacesAt(scene, {}, 9, 5)));
  EXPECT_NO_THROW(validate(model));
  const RayCaster caster(model);
  // The box stands at its place, the door wide open: 1.5 rad from +x.
  EXPECT_NEAR(rangeOf(caster, {4, 2, 3}, -Eigen::Vector3d::UnitZ(), 5), 2.5, 1e-6);
  const Eigen::Vector3d leaf(0.4 * std::cos(1.5), 2 + 0.4 * std::sin(1.5), 0);
  EXPECT_NEAR(rangeOf(caster, leaf + Eigen::Vector3d(0, 0, 3), -Eigen::Vector3d::UnitZ(), 5), 1.0, 1e-6);
}

TEST(SurfacesAt, SeedAndScanDecideEveryBit)
{
  const Scene scene = smallScene();
  MovableOptions options;
  options.people = 3;
  options.doors_move = true;
  options.moved_furniture = 0.5;
  const SurfaceModel model = surfacesAt(scene, options, 1, 2);
  EXPECT_NO_THROW(validate(model));
  EXPECT_TRUE(sameSurfaces(model, surfacesAt(scene, options, 1, 2)));
  EXPECT_FALSE(sameSurfaces(model, surfacesAt(scene, options, 1, 3)));
  EXPECT_FALSE(sameSurfaces(model, surfacesAt(scene, options, 2, 2)));
  // What does not move stays first and untouched.
  const auto& fixed = scene.surfaces.mesh.vertices;
  EXPECT_EQ(std::memcmp(model.mesh.vertices.data(), fixed.data(), fixed.size() * sizeof(fixed[0])), 0);
}

TEST(SurfacesAt, TheShareOfFurnitureMoves)
{
  const Scene scene = smallScene();
  for (const auto& [share, expected] : {std::pair(0.0, 0), std::pair(0.25, 1), std::pair(0.5, 2), std::pair(1.0, 4)}) {
    MovableOptions options;
    options.moved_furniture = share;
    for (std::size_t scan = 0; scan < 5; ++scan) {
      const SurfaceModel model = surfacesAt(scene, options, 1, scan);
      const RayCaster caster(model);
      int gone = 0;
      for (const LooseItem& item : scene.loose_items)
        gone += std::isinf(rangeOf(caster, item.place + Eigen::Vector3d(0, 0, 0.1), Eigen::Vector3d::UnitZ(), 2));
      EXPECT_EQ(gone, expected) << share;
      // The items that moved are within their area, all of each, and do not touch.
      const std::vector<Eigen::Vector3f> vertices = movables(scene, model);
      int inside = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        Eigen::AlignedBox3d box;
        for (std::size_t k = 0; k < 8; ++k)
          box.extend(vertices[8 * i + k].cast<double>());
        const WalkArea& area = scene.loose_items[i].area;
        inside += box.min().x() >= area.lower.x() && box.max().x() <= area.upper.x() &&
                  box.min().y() >= area.lower.y() && box.max().y() <= area.upper.y();
      }
      EXPECT_EQ(inside, expected);
    }
  }
}

TEST(SurfacesAt, WhatCannotTurnKeepsItsDirection)
{
  Scene scene = smallScene();
  LooseItem car = scene.loose_items[0];
  car.surfaces = SurfaceModel();
  car.surfaces.addBlock({0, 0, 0}, {1.8, 4, 1.5}, 0, car.surfaces.addMaterial("paint", 0.5));
  car.area = {{0, -2, 0}, {20, 0, 0}};
  car.place = {3, -1, 0};
  car.yaw = kPi / 2;
  scene.loose_items = {car};
  MovableOptions options;
  options.moved_furniture = 1;
  std::set<float> places;
  for (std::size_t scan = 0; scan < 8; ++scan) {
    Eigen::AlignedBox3d box;
    const std::vector<Eigen::Vector3f> vertices = movables(scene, surfacesAt(scene, options, 1, scan));
    for (std::size_t k = 0; k < 8; ++k)
      box.extend(vertices[k].cast<double>());
    EXPECT_NEAR(box.sizes().x(), 4, 1e-5);
    EXPECT_GE(box.min().x(), 0);
    EXPECT_LE(box.max().x(), 20);
    EXPECT_GE(box.min().y(), -2 - 1e-6);
    places.insert(static_cast<float>(box.min().x()));
  }
  EXPECT_GE(places.size(), 7U);
}

TEST(SurfacesAt, PeopleStandInTheirAreas)
{
  const Scene scene = smallScene();
  const SurfaceModel empty = surfacesAt(scene, {}, 1, 0);
  MovableOptions options;
  options.people = 5;
  const SurfaceModel model = surfacesAt(scene, options, 1, 0);
  EXPECT_EQ(model.spheres.size(), 5U); // heads
  std::vector<Eigen::Vector3d> heads;
  for (const Sphere& head : model.spheres) {
    EXPECT_GT(head.centre.z(), 1.3);
    EXPECT_LT(head.centre.z() + head.radius, 2.0);
    EXPECT_TRUE(std::any_of(scene.walk_areas.begin(), scene.walk_areas.end(), [&](const WalkArea& area) {
      return head.centre.x() > area.lower.x() + 0.2 && head.centre.x() < area.upper.x() - 0.2 &&
             head.centre.y() > area.lower.y() + 0.2 && head.centre.y() < area.upper.y() - 0.2;
    }));
    for (const Eigen::Vector3d& other : heads)
      EXPECT_GT((other - head.centre).head<2>().norm(), 0.5);
    heads.push_back(head.centre);
  }
  EXPECT_GT(model.mesh.triangles.size(), empty.mesh.triangles.size() + 5 * 100); // bodies
  // A person fits in its circle.
  RandomStream random(4);
  for (int i = 0; i < 20; ++i) {
    const Eigen::AlignedBox3d box = boundsOf(parts::makePerson(random));
    EXPECT_LE(box.min().head<2>().cwiseAbs().maxCoeff(), 0.31);
    EXPECT_LE(box.max().head<2>().cwiseAbs().maxCoeff(), 0.31);
    EXPECT_GT(box.sizes().z(), 1.5);
    EXPECT_LT(box.sizes().z(), 2.0);
  }
}

TEST(SurfacesAt, DoorsTakeAllAngles)
{
  const Scene scene = smallScene();
  MovableOptions options;
  options.doors_move = true;
  const std::size_t items = 4 * 8; // vertices of the boxes, which come first
  double lowest = kPi;
  double highest = 0;
  for (std::size_t scan = 0; scan < 40; ++scan) {
    const std::vector<Eigen::Vector3f> vertices = movables(scene, surfacesAt(scene, options, 1, scan));
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 8; ++k)
      middle += vertices[items + k].cast<double>() / 8;
    const Eigen::Vector3d leaf = middle - scene.doors[0].hinge;
    EXPECT_NEAR(leaf.head<2>().norm(), 0.45, 1e-5);
    const double angle = std::atan2(leaf.y(), leaf.x());
    EXPECT_GE(angle, -1e-6);
    EXPECT_LE(angle, 1.5 + 1e-6);
    lowest = std::min(lowest, angle);
    highest = std::max(highest, angle);
  }
  EXPECT_LT(lowest, 0.2);
  EXPECT_GT(highest, 1.3);
}

TEST(SurfacesAt, KeepsClearOfTheSensor)
{
  const Scene scene = smallScene();
  MovableOptions options;
  options.people = 4;
  options.doors_move = true;
  options.moved_furniture = 1;
  const Eigen::Vector3d in_area(6, 4, 1.2);
  const Eigen::Vector3d at_door(0.7, 2.5, 1.2);
  double nearest = 10;
  for (std::size_t scan = 0; scan < 30; ++scan) {
    for (const Eigen::Vector3f& vertex : movables(scene, surfacesAt(scene, options, 1, scan, {in_area, at_door})))
      for (const Eigen::Vector3d& sensor : {in_area, at_door})
        ASSERT_GE((vertex.cast<double>() - sensor).head<2>().norm(), 0.48);
    for (const Eigen::Vector3f& vertex : movables(scene, surfacesAt(scene, options, 1, scan)))
      nearest = std::min(nearest, (vertex.cast<double>() - in_area).head<2>().norm());
  }
  EXPECT_LT(nearest, 0.3); // as nobody knew of the sensor
}

std::string
errorOf(const Scene& scene, const MovableOptions& options)
{
  try {
    surfacesAt(scene, options, 1, 3);
  }
  catch (const SimulationError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SurfacesAt, NamesTheSettingThatIsWrong)
{
  Scene scene = smallScene();
  MovableOptions options;
  options.people = -1;
  EXPECT_THAT(errorOf(scene, options), AllOf(HasSubstr("people"), HasSubstr("-1")));
  options.people = 0;
  for (const double share : {-0.1, 1.1, std::nan("")}) {
    options.moved_furniture = share;
    EXPECT_THAT(errorOf(scene, options), HasSubstr("moved_furniture"));
  }
  options.moved_furniture = 0;
  options.people = 1000;
  EXPECT_THAT(errorOf(scene, options), AllOf(HasSubstr("people"), HasSubstr("1000"), HasSubstr("'small'")));
  scene.walk_areas.clear();
  options.people = 1;
  EXPECT_THAT(errorOf(scene, options), AllOf(HasSubstr("people"), HasSubstr("only 0")));
}

TEST(Footprint, MeetsAndKeepsDistanceAsByHand)
{
  const Footprint square{{0, 0}, {1, 1}, 0, 0, 1};
  const Footprint rotated{{2.3, 0}, {1, 1}, kPi / 4, 0, 1}; // its corner is at x = 0.886
  EXPECT_TRUE(meet(square, rotated));
  EXPECT_TRUE(meet(rotated, square));
  EXPECT_FALSE(meet(square, {{2.5, 0}, {1, 1}, kPi / 4, 0, 1}));
  EXPECT_FALSE(meet(square, {{0, 0}, {1, 1}, 0, 1.5, 2})); // above
  EXPECT_NEAR(distance(square, {3, 0}, {3, 0}), 2, 1e-12);
  EXPECT_NEAR(distance(square, {2, 2}, {2, 2}), std::sqrt(2), 1e-12);
  EXPECT_EQ(distance(square, {-5, 0.5}, {5, 0.5}), 0);
  EXPECT_NEAR(distance(square, {3, -1}, {-1, 3}), 0, 1e-12);
  EXPECT_NEAR(distance(square, {4, -1}, {-1, 4}), 1 / std::sqrt(2), 1e-12); // a corner is nearest
  EXPECT_NEAR(distance(rotated, {2.3, 3}, {2.3, 3}), 3 - std::sqrt(2), 1e-12);
  // Against the nearest of many points.
  RandomStream random(3);
  for (int i = 0; i < 50; ++i) {
    const Footprint box{{random.uniform(-1, 1), random.uniform(-1, 1)},
                        {random.uniform(0.2, 1), random.uniform(0.2, 1)},
                        random.uniform(-3, 3),
                        0,
                        1};
    const Eigen::Vector2d a(random.uniform(-4, 4), random.uniform(-4, 4));
    const Eigen::Vector2d b(random.uniform(-4, 4), random.uniform(-4, 4));
    double nearest = 10;
    const Eigen::Matrix2d back = Eigen::Rotation2Dd(-box.yaw).toRotationMatrix();
    for (int k = 0; k <= 2000; ++k) {
      const Eigen::Vector2d local = back * (a + (b - a) * (k / 2000.0) - box.centre);
      nearest = std::min(nearest, (local.cwiseAbs() - box.half).cwiseMax(0).norm());
    }
    EXPECT_NEAR(distance(box, a, b), nearest, 4e-3);
  }
}

TEST(SmoothNoise, IsSmoothAndBounded)
{
  RandomStream random(1);
  double least = 0;
  double most = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d at(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9));
    const double value = parts::smoothNoise(at, 4);
    least = std::min(least, value);
    most = std::max(most, value);
    EXPECT_NEAR(parts::smoothNoise(at + 1e-4 * randomDirection(random), 4), value, 2e-3);
  }
  EXPECT_GT(most, 0.5);
  EXPECT_LT(most, 2);
  EXPECT_LT(least, -0.5);
  EXPECT_GT(least, -2);
  EXPECT_NE(parts::smoothNoise({0.3, 0.4, 0.5}, 1), parts::smoothNoise({0.3, 0.4, 0.5}, 2));
}

class MeshScene : public ::testing::Test {
protected:
  /// The model as an OBJ file.
  static std::string
  write(const std::string& name, const SurfaceModel& model)
  {
    std::string path = ::testing::TempDir() + "pcl_ssfr_scene_" + name + ".obj";
    std::ofstream file(path);
    for (const Eigen::Vector3f& v : model.mesh.vertices)
      file << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    for (const auto& t : model.mesh.triangles)
      file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    return path;
  }
};

TEST_F(MeshScene, PathLeadsThroughTheMiddle)
{
  // A room of 12 m by 5 m, its floor at 2 m, with a cupboard in the middle of its southern half.
  SurfaceModel room;
  const auto any = room.addMaterial("any", 0.5);
  for (const double z : {2.0, 4.6})
    room.addPolygon({{0, 0, z}, {12, 0, z}, {12, 5, z}, {0, 5, z}}, any);
  room.addPolygon({{0, 0, 2}, {12, 0, 2}, {12, 0, 4.6}, {0, 0, 4.6}}, any);
  room.addPolygon({{0, 5, 2}, {12, 5, 2}, {12, 5, 4.6}, {0, 5, 4.6}}, any);
  room.addPolygon({{0, 0, 2}, {0, 5, 2}, {0, 5, 4.6}, {0, 0, 4.6}}, any);
  room.addPolygon({{12, 0, 2}, {12, 5, 2}, {12, 5, 4.6}, {12, 0, 4.6}}, any);
  room.addBlock({6, 1.2, 2}, {2, 1.6, 2}, 0, any);
  const std::string path = write("room", room);
  const Scene scene = makeMeshScene(path);
  EXPECT_EQ(scene.name, path);
  EXPECT_TRUE(sameBytes(scene.path, makeMeshScene(path).path));
  EXPECT_GT(pathLength(scene), 9.5);
  const RayCaster caster(scene.surfaces);
  for (const Eigen::Vector3d& foot : alongPath(scene)) {
    EXPECT_NEAR(foot.z(), 2, 1e-6);
    for (const double height : {0.4, 1.2, 1.8})
      for (int i = 0; i < 16; ++i)
        ASSERT_GE(
            rangeOf(
                caster, foot + Eigen::Vector3d(0, 0, height), {std::cos(kPi * i / 8), std::sin(kPi * i / 8), 0}, 10),
            0.38)
            << foot.transpose();
  }
  EXPECT_GT(scene.natural_step, 0.2);
  EXPECT_THAT(sensorNames(), Contains(scene.recommended_sensor));
}

TEST_F(MeshScene, SaysWhenThereIsNoRoom)
{
  SurfaceModel box;
  box.addBlock({0, 0, 0}, {0.5, 0.5, 0.5}, 0, box.addMaterial("any", 0.5));
  const std::string path = write("box", box);
  try {
    makeMeshScene(path);
    FAIL();
  }
  catch (const SimulationError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(path), HasSubstr("no free place")));
  }
  EXPECT_THROW(makeMeshScene("no_such_file.obj"), SimulationError);
}

} // namespace
} // namespace pcl_ssfr::simulation::test_scenes
