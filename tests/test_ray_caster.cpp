// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/simulation_error.h>
#include <apps/simulation/surface_model.h>

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace pcl_ssfr::simulation::test_ray_caster {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kFar = 1e4;
constexpr double kExact = 1e-10; // of distances computed in double, at the sizes used here [m]
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Eigen::Vector3d
randomDirection(RandomStream& random)
{
  return Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian()).normalized();
}

Eigen::Vector3d
randomPoint(RandomStream& random, double half)
{
  return {random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half)};
}

SurfaceModel
boxModel(const Eigen::Vector3d& size, const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity())
{
  SurfaceModel model;
  model.addBox(T, size, model.addMaterial("wall", 0.5));
  return model;
}

std::string
errorOf(const std::function<void()>& action)
{
  try {
    action();
  }
  catch (const SimulationError& error) {
    return error.what();
  }
  return "no error";
}

/// First crossing of a quadratic a t^2 + b t + c = 0 beyond \p from that \p accept takes, in long double.
std::optional<double>
firstRoot(
    long double a, long double b, long double c, const std::function<bool(long double)>& accept = [](long double) {
      return true;
    })
{
  const long double discriminant = b * b - 4 * a * c;
  if (a == 0 || discriminant < 0)
    return std::nullopt;
  for (const long double sign : {-1.0L, 1.0L}) {
    const long double t = (-b + sign * std::sqrt(discriminant)) / (2 * a);
    if (t > 0 && accept(t))
      return static_cast<double>(t);
  }
  return std::nullopt;
}

std::optional<double>
sphereOracle(const Sphere& sphere, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
{
  using Vector = Eigen::Matrix<long double, 3, 1>;
  const Vector o = (origin - sphere.centre).cast<long double>();
  const Vector d = direction.cast<long double>();
  const long double r = sphere.radius;
  return firstRoot(d.dot(d), 2 * o.dot(d), o.dot(o) - r * r);
}

std::optional<double>
tubeOracle(const Tube& tube, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
{
  using Vector = Eigen::Matrix<long double, 3, 1>;
  const Vector axis = tube.axis.cast<long double>();
  const Vector o = (origin - tube.base).cast<long double>();
  const Vector d = direction.cast<long double>();
  const Vector oc = o.cross(axis);
  const Vector dc = d.cross(axis);
  const long double r = tube.radius;
  return firstRoot(dc.dot(dc), 2 * oc.dot(dc), oc.dot(oc) - r * r, [&](long double t) {
    const long double at = (o + t * d).dot(axis);
    return at >= 0 && at <= static_cast<long double>(tube.length);
  });
}

/// A triangle met by a ray: distance, and how far inside its edges the point lies (barycentric, negative outside).
struct TriangleHit {
  double distance;
  double margin;
};

std::optional<TriangleHit>
triangleOracle(const TriangleMesh& mesh,
               std::size_t index,
               const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction)
{
  Eigen::Matrix3d A;
  const auto corner = [&](std::size_t i) {
    return Eigen::Vector3d(mesh.vertices[mesh.triangles[index][i]].cast<double>());
  };
  A << corner(1) - corner(0), corner(2) - corner(0), -direction;
  if (std::abs(A.determinant()) < 1e-12)
    return std::nullopt;
  const Eigen::Vector3d uvt = A.partialPivLu().solve(origin - corner(0));
  return TriangleHit{uvt.z(), std::min({uvt.x(), uvt.y(), 1 - uvt.x() - uvt.y()})};
}

TEST(SurfaceModel, BoxIsClosedAndFacesOutwards)
{
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  T.pretranslate(Eigen::Vector3d(2, -1, 4));
  const SurfaceModel model = boxModel({2, 3, 4}, T);
  ASSERT_EQ(model.mesh.triangles.size(), 12U);
  double volume = 0;
  double area = 0;
  for (const auto& t : model.mesh.triangles) {
    const Eigen::Vector3d a = model.mesh.vertices[t[0]].cast<double>();
    const Eigen::Vector3d b = model.mesh.vertices[t[1]].cast<double>();
    const Eigen::Vector3d c = model.mesh.vertices[t[2]].cast<double>();
    volume += a.dot(b.cross(c)) / 6;
    area += (b - a).cross(c - a).norm() / 2;
  }
  EXPECT_NEAR(volume, 24, 1e-4);
  EXPECT_NEAR(area, 2 * (6 + 8 + 12), 1e-4);
  EXPECT_NO_THROW(validate(model));
}

TEST(SurfaceModel, BlockStandsOnItsBase)
{
  SurfaceModel model;
  model.addBlock({1, 2, 3}, {2, 4, 5}, std::acos(-1.0) / 2, model.addMaterial("wood", 0.4));
  const Eigen::AlignedBox3d box = boundsOf(model);
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3d(-1, 1, 3), 1e-6)) << box.min().transpose();
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3d(3, 3, 8), 1e-6)) << box.max().transpose();
}

TEST(SurfaceModel, PolygonHasThreeOrFourCorners)
{
  SurfaceModel model;
  const auto wall = model.addMaterial("wall", 0.5);
  model.addPolygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, wall);
  model.addPolygon({{0, 0, 1}, {1, 0, 1}, {1, 1, 1}}, wall);
  EXPECT_EQ(model.mesh.triangles.size(), 3U);
  EXPECT_THAT(errorOf([&] { model.addPolygon({{0, 0, 0}, {1, 0, 0}}, wall); }), HasSubstr("corners 2"));
}

TEST(SurfaceModel, AppendMovesEverythingAndMergesMaterials)
{
  SurfaceModel part;
  part.addMaterial("unused", 0.1);
  const auto steel = part.addMaterial("steel", 0.3);
  part.addPolygon({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, steel);
  part.spheres.push_back({{1, 0, 0}, 0.5, steel});
  part.tubes.push_back({{0, 0, 0}, {1, 0, 0}, 2, 0.1, steel});
  SurfaceModel model;
  model.addMaterial("steel", 0.7);
  Eigen::Isometry3d T(Eigen::AngleAxisd(std::acos(-1.0) / 2, Eigen::Vector3d::UnitZ()));
  T.pretranslate(Eigen::Vector3d(10, 0, 0));
  model.append(part, T);
  model.append(part);
  ASSERT_EQ(model.materials.size(), 2U);
  EXPECT_EQ(model.materials[model.mesh.material[0]].name, "steel");
  EXPECT_EQ(model.materials[model.mesh.material[0]].reflectance, 0.7); // the first one stays
  EXPECT_TRUE(model.spheres[0].centre.isApprox(Eigen::Vector3d(10, 1, 0), 1e-12));
  EXPECT_TRUE(model.tubes[0].axis.isApprox(Eigen::Vector3d(0, 1, 0), 1e-12));
  EXPECT_TRUE(model.mesh.vertices[1].isApprox(Eigen::Vector3f(10, 1, 0), 1e-6F));
  EXPECT_EQ(model.mesh.triangles[1][0], 3U);
  model.append(model, T);
  EXPECT_EQ(model.mesh.triangles.size(), 4U);
  EXPECT_EQ(model.spheres.size(), 4U);
  EXPECT_EQ(model.materials.size(), 2U);
  EXPECT_NO_THROW(validate(model));
}

TEST(SurfaceModel, BoundsHoldEveryPointTightly)
{
  SurfaceModel model;
  model.addMaterial("wall", 0.5);
  const Tube tube{{1, 2, 3}, Eigen::Vector3d(1, -2, 0.5).normalized(), 4, 0.7, 0};
  model.tubes.push_back(tube);
  const Eigen::AlignedBox3d box = boundsOf(model);
  Eigen::AlignedBox3d sampled;
  const Eigen::Vector3d u = tube.axis.unitOrthogonal();
  for (int i = 0; i < 3600; ++i) {
    const double a = i * std::acos(-1.0) / 1800;
    for (const double at : {0.0, tube.length})
      sampled.extend(tube.base + at * tube.axis + tube.radius * (std::cos(a) * u + std::sin(a) * tube.axis.cross(u)));
  }
  EXPECT_LT((box.min() - sampled.min()).norm(), 1e-5);
  EXPECT_LT((box.max() - sampled.max()).norm(), 1e-5);
  EXPECT_TRUE(boundsOf(SurfaceModel()).isEmpty());
}

TEST(SurfaceModel, BadModelsAreNamed)
{
  EXPECT_THAT(errorOf([] { validate(SurfaceModel()); }), HasSubstr("empty"));
  const auto broken = [](const std::function<void(SurfaceModel&)>& breakIt) {
    SurfaceModel model = boxModel({1, 1, 1});
    model.spheres.push_back({{0, 0, 0}, 1, 0});
    model.tubes.push_back({{0, 0, 0}, {0, 0, 1}, 1, 1, 0});
    breakIt(model);
    return errorOf([&] { RayCaster caster(model); });
  };
  EXPECT_EQ(broken([](SurfaceModel&) {}), "no error");
  EXPECT_THAT(broken([](SurfaceModel& m) { m.mesh.vertices[3].y() = std::nanf(""); }),
              AllOf(HasSubstr("vertex 3"), HasSubstr("nan")));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.mesh.triangles[5][1] = 99; }),
              AllOf(HasSubstr("triangle 5"), HasSubstr("99")));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.mesh.material[2] = 7; }), AllOf(HasSubstr("triangle 2"), HasSubstr("7")));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.mesh.material.pop_back(); }), HasSubstr("11"));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.spheres[0].radius = -1; }),
              AllOf(HasSubstr("sphere 0"), HasSubstr("radius -1")));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.spheres[0].centre.x() = INFINITY; }), HasSubstr("sphere 0"));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.tubes[0].axis = {0, 0, 2}; }), AllOf(HasSubstr("tube 0"), HasSubstr("2")));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.tubes[0].length = kNaN; }), HasSubstr("tube 0"));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.materials[0].reflectance = 0; }), HasSubstr("reflectance 0"));
  EXPECT_THAT(broken([](SurfaceModel& m) { m.materials[0].reflectance = 1.5; }), HasSubstr("reflectance 1.5"));
  SurfaceModel model;
  EXPECT_THAT(errorOf([&] { model.addBox(Eigen::Isometry3d::Identity(), {1, 0, 1}, 0); }), HasSubstr("box has size"));
  EXPECT_THAT(errorOf([&] { model.addColumn({0, 0, 0}, -1, 1, 0); }), HasSubstr("radius -1"));
}

TEST(RayCaster, PlanesAreExact)
{
  // Corners that single precision holds exactly: the plane is known exactly, too.
  SurfaceModel model;
  model.addPolygon({{-64, -64, 8}, {64, -64, 24}, {64, 64, 24}, {-64, 64, 8}}, model.addMaterial("roof", 0.5));
  const RayCaster caster(model);
  const Eigen::Vector3d normal = Eigen::Vector3d(-16, 0, 128).normalized();
  RandomStream random(1);
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d origin = randomPoint(random, 5);
    const Eigen::Vector3d direction = randomDirection(random);
    const double expected = normal.dot(Eigen::Vector3d(-64, -64, 8) - origin) / normal.dot(direction);
    const Eigen::Vector3d point = origin + expected * direction;
    const double inside = 64 - std::max(std::abs(point.x()), std::abs(point.y()));
    if (std::abs(inside) < 1e-3)
      continue;
    const auto hit = caster.cast(origin, direction, kFar);
    ASSERT_EQ(hit.has_value(), expected > 0 && inside > 0) << "ray " << i;
    if (!hit)
      continue;
    ++hits;
    EXPECT_NEAR(hit->distance, expected, kExact * std::max(1.0, expected));
    EXPECT_NEAR(std::abs(hit->normal.dot(normal)), 1, 1e-12);
    EXPECT_LT(hit->normal.dot(direction), 0);
  }
  EXPECT_GT(hits, 1000);
}

TEST(RayCaster, SpheresAreExactInsideAndOutside)
{
  SurfaceModel model;
  const auto paint = model.addMaterial("paint", 0.8);
  const Sphere sphere{{3, -2, 1}, 1.7, paint};
  model.spheres.push_back(sphere);
  const RayCaster caster(model);
  RandomStream random(2);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d origin = sphere.centre + randomPoint(random, i % 2 == 0 ? 1 : 20);
    const Eigen::Vector3d target = sphere.centre + randomPoint(random, 2);
    const Eigen::Vector3d direction = (target - origin).normalized();
    const auto expected = sphereOracle(sphere, origin, direction);
    const double off = std::abs((origin - sphere.centre).cross(direction).norm() - sphere.radius);
    if (off < 1e-5)
      continue; // a touch
    const auto hit = caster.cast(origin, direction, kFar);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << "ray " << i;
    if (!hit)
      continue;
    ++hits;
    EXPECT_NEAR(hit->distance, *expected, kExact);
    const Eigen::Vector3d point = origin + hit->distance * direction;
    EXPECT_NEAR((point - sphere.centre).norm(), sphere.radius, kExact);
    EXPECT_NEAR(std::abs(hit->normal.dot((point - sphere.centre) / sphere.radius)), 1, kExact);
    EXPECT_LT(hit->normal.dot(direction), 0);
    EXPECT_EQ(caster.material(hit->material).name, "paint");
  }
  EXPECT_GT(hits, 10000);
}

TEST(RayCaster, TubesAreExactInsideAndOutside)
{
  SurfaceModel model;
  const Tube tube{{1, 2, -1}, Eigen::Vector3d(0.3, -0.4, 1.2).normalized(), 3, 0.6, model.addMaterial("steel", 0.3)};
  model.tubes.push_back(tube);
  const RayCaster caster(model);
  RandomStream random(3);
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d middle = tube.base + tube.length / 2 * tube.axis;
    const Eigen::Vector3d origin = middle + randomPoint(random, i % 2 == 0 ? 0.4 : 10);
    const Eigen::Vector3d direction = (middle + randomPoint(random, 2) - origin).normalized();
    const auto expected = tubeOracle(tube, origin, direction);
    const auto hit = caster.cast(origin, direction, kFar);
    // Rays along the silhouette or through the rim may go either way.
    const double off = std::abs((origin - tube.base).dot(direction.cross(tube.axis).normalized()));
    if (std::abs(off - tube.radius) < 1e-5)
      continue;
    ASSERT_EQ(hit.has_value(), expected.has_value()) << "ray " << i;
    if (!hit) {
      ++misses;
      continue;
    }
    ++hits;
    EXPECT_NEAR(hit->distance, *expected, 1e-8);
    const Eigen::Vector3d point = origin + hit->distance * direction;
    EXPECT_NEAR((point - tube.base).cross(tube.axis).norm(), tube.radius, 1e-9);
    EXPECT_NEAR(hit->normal.dot(tube.axis), 0, 1e-9);
    EXPECT_LT(hit->normal.dot(direction), 0);
  }
  EXPECT_GT(hits, 5000);
  EXPECT_GT(misses, 1000);
  // Along the axis a tube is open.
  EXPECT_FALSE(caster.cast(tube.base - tube.axis, tube.axis, kFar));
}

TEST(RayCaster, FindsTheNearestOfManySurfaces)
{
  SurfaceModel model;
  RandomStream random(4);
  std::vector<std::uint16_t> materials;
  materials.reserve(5);
  for (int i = 0; i < 5; ++i)
    materials.push_back(model.addMaterial("m" + std::to_string(i), 0.1 + 0.1 * i));
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d at = randomPoint(random, 10);
    model.addPolygon({at, at + randomPoint(random, 6), at + randomPoint(random, 6)},
                     materials[static_cast<std::size_t>(random.index(5))]);
  }
  for (int i = 0; i < 20; ++i) {
    model.spheres.push_back({randomPoint(random, 10), random.uniform(0.1, 1), materials[0]});
    model.tubes.push_back({randomPoint(random, 10),
                           randomDirection(random),
                           random.uniform(0.5, 3),
                           random.uniform(0.1, 1),
                           materials[1]});
  }
  const RayCaster caster(model);
  int compared = 0;
  int skipped = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d origin = randomPoint(random, 12);
    const Eigen::Vector3d direction = randomDirection(random);
    double nearest = kFar;
    std::uint16_t material = 0;
    double least_margin = 1;
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
      if (const auto hit = triangleOracle(model.mesh, t, origin, direction)) {
        if (hit->distance > -0.01)
          least_margin = std::min(least_margin, std::abs(hit->margin));
        if (hit->margin >= 0 && hit->distance > 0 && hit->distance < nearest) {
          nearest = hit->distance;
          material = model.mesh.material[t];
        }
      }
    for (const Sphere& sphere : model.spheres)
      if (const auto t = sphereOracle(sphere, origin, direction); t && *t < nearest) {
        nearest = *t;
        material = sphere.material;
      }
    for (const Tube& tube : model.tubes)
      if (const auto t = tubeOracle(tube, origin, direction); t && *t < nearest) {
        nearest = *t;
        material = tube.material;
      }
    if (least_margin < 1e-5) {
      ++skipped; // through an edge, within single precision
      continue;
    }
    const auto hit = caster.cast(origin, direction, kFar);
    ASSERT_EQ(hit.has_value(), nearest < kFar) << "ray " << i;
    if (!hit)
      continue;
    ++compared;
    ASSERT_NEAR(hit->distance, nearest, 1e-8) << "ray " << i;
    ASSERT_EQ(hit->material, material) << "ray " << i;
  }
  EXPECT_GT(compared, 1500);
  EXPECT_LT(skipped, 200);
}

TEST(RayCaster, NoRayEscapesAClosedBox)
{
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 1, 2).normalized()));
  T.pretranslate(Eigen::Vector3d(0.1, 0.2, 0.3));
  const SurfaceModel model = boxModel({7, 5, 3}, T);
  const RayCaster caster(model);
  RandomStream random(5);
  int rays = 0;
  const auto expectInside = [&](const Eigen::Vector3d& origin, const Eigen::Vector3d& target) {
    const auto hit = caster.cast(origin, (target - origin).normalized(), kFar);
    ASSERT_TRUE(hit) << "from " << origin.transpose() << " to " << target.transpose();
    EXPECT_NEAR(hit->distance, (target - origin).norm(), 1e-4);
    ++rays;
  };
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin = T * randomPoint(random, 1.4);
    for (const Eigen::Vector3f& corner : model.mesh.vertices)
      expectInside(origin, corner.cast<double>());
    // Along every edge of every triangle, diagonals of the faces included.
    const auto& t = model.mesh.triangles[static_cast<std::size_t>(random.index(12))];
    const double share = random.uniform();
    for (std::size_t e = 0; e < 3; ++e)
      expectInside(origin,
                   (1 - share) * model.mesh.vertices[t[e]].cast<double>() +
                       share * model.mesh.vertices[t[(e + 1) % 3]].cast<double>());
  }
  for (int i = 0; i < 20000; ++i)
    ASSERT_TRUE(caster.cast(T * randomPoint(random, 1.4), randomDirection(random), kFar));
  EXPECT_EQ(rays, 2000 * 11);
}

TEST(RayCaster, NoRayGetsIntoAColumnFromAbove)
{
  SurfaceModel model;
  model.addColumn({1, 1, 0}, 0.4, 3, model.addMaterial("stone", 0.5));
  const RayCaster caster(model);
  RandomStream random(6);
  for (int i = 0; i < 5000; ++i) {
    const double angle = random.uniform(0, 6.3);
    const double radius = 0.4 * std::sqrt(random.uniform());
    const Eigen::Vector3d at(1 + radius * std::cos(angle), 1 + radius * std::sin(angle), 5);
    const auto hit = caster.cast(at, -Eigen::Vector3d::UnitZ(), kFar);
    ASSERT_TRUE(hit);
    ASSERT_NEAR(hit->distance, 2, 1e-9);
  }
}

TEST(RayCaster, KeepsTheLimitsOfDistance)
{
  SurfaceModel model;
  const auto wall = model.addMaterial("wall", 0.5);
  for (const double x : {2.0, 4.0})
    model.addPolygon({{x, -1, -1}, {x, 1, -1}, {x, 1, 1}, {x, -1, 1}}, wall);
  model.spheres.push_back({{8, 0, 0}, 1, wall});
  const RayCaster caster(model);
  const Eigen::Vector3d origin(0, 0.1, 0.2);
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const auto distance = [&](double max, double min) {
    const auto hit = caster.cast(origin, x, max, min);
    return hit ? hit->distance : -1;
  };
  EXPECT_DOUBLE_EQ(distance(10, 0), 2);
  EXPECT_DOUBLE_EQ(distance(10, std::nextafter(2.0, 0)), 2);
  EXPECT_DOUBLE_EQ(distance(10, 2), 4); // the limits themselves are outside
  EXPECT_DOUBLE_EQ(distance(10, 2 + 1e-9), 4);
  EXPECT_NEAR(distance(10, 4), 8 - std::sqrt(1 - 0.05), 1e-12);
  EXPECT_NEAR(distance(10, 8), 8 + std::sqrt(1 - 0.05), 1e-12);
  EXPECT_EQ(distance(10, 9.5), -1);
  EXPECT_EQ(distance(2, 0), -1);
  EXPECT_DOUBLE_EQ(distance(2 + 1e-9, 0), 2);
  EXPECT_EQ(distance(1, 0), -1);
  EXPECT_EQ(distance(1, 2), -1);
  EXPECT_DOUBLE_EQ(distance(INFINITY, 0), 2);
  EXPECT_EQ(distance(kNaN, 0), -1);
}

TEST(RayCaster, IsExactInScenesOfAKilometre)
{
  SurfaceModel model;
  model.addPolygon({{512, -512, -512}, {640, 512, -512}, {640, 512, 512}, {512, -512, 512}},
                   model.addMaterial("wall", 0.5));
  const RayCaster caster(model);
  const Eigen::Vector3d normal = Eigen::Vector3d(1024, -128, 0).normalized();
  RandomStream random(7);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin = Eigen::Vector3d(-500, 0, 0) + randomPoint(random, 10);
    const Eigen::Vector3d direction =
        Eigen::Vector3d(1, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)).normalized();
    const auto hit = caster.cast(origin, direction, kFar);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, normal.dot(Eigen::Vector3d(512, -512, -512) - origin) / normal.dot(direction), 1e-9);
  }
}

TEST(RayCaster, SeesFromPointToPoint)
{
  const RayCaster caster(boxModel({2, 2, 2}));
  const Eigen::Vector3d left(-5, 0.1, 0.2);
  EXPECT_FALSE(caster.isVisible(left, {5, 0.1, 0.2}));
  EXPECT_TRUE(caster.isVisible(left, {-5, 30, 0}));
  EXPECT_TRUE(caster.isVisible(left, {-1, 0.1, 0.2})); // on the surface itself
  EXPECT_TRUE(caster.isVisible(left, {-1.0005, 0.1, 0.2}));
  EXPECT_FALSE(caster.isVisible(left, {-0.99, 0.1, 0.2}));
  EXPECT_TRUE(caster.isVisible({0, 0, 0}, {0.5, 0.5, 0.5})); // inside
  EXPECT_FALSE(caster.isVisible({0, 0, 0}, {3, 0, 0}));
  EXPECT_TRUE(caster.isVisible(left, left));
  EXPECT_FALSE(caster.isVisible(left, {kNaN, 0, 0}));
}

TEST(RayCaster, NoNumberMeetsNothing)
{
  const RayCaster caster(boxModel({2, 2, 2}));
  EXPECT_FALSE(caster.cast({kNaN, 0, 0}, {1, 0, 0}, kFar));
  EXPECT_FALSE(caster.cast({0, 0, 0}, {kNaN, 0, 0}, kFar));
  EXPECT_FALSE(caster.cast({0, 0, 0}, {INFINITY, 0, 0}, kFar));
}

TEST(RayCaster, FlatTrianglesAreNoTrap)
{
  SurfaceModel model = boxModel({4, 4, 4});
  model.addPolygon({{0, 0, 1}, {1, 0, 1}, {0.5, 0, 1}}, 0); // no area
  const RayCaster caster(model);
  RandomStream random(8);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d target(random.uniform(-1, 1), 0, 1);
    const auto hit = caster.cast({0, 0, -1}, (target - Eigen::Vector3d(0, 0, -1)).normalized(), kFar);
    ASSERT_TRUE(hit);
    ASSERT_TRUE(hit->normal.allFinite());
    ASSERT_NEAR(hit->normal.norm(), 1, 1e-12);
  }
}

TEST(RayCaster, CastersLiveSideBySideAndMove)
{
  RayCaster small(boxModel({2, 2, 2}));
  RayCaster large(boxModel({10, 10, 10}));
  const auto distance = [](const RayCaster& caster) {
    return caster.cast({0, 0, 0}, Eigen::Vector3d::UnitX(), kFar)->distance;
  };
  EXPECT_DOUBLE_EQ(distance(small), 1);
  EXPECT_DOUBLE_EQ(distance(large), 5);
  const RayCaster moved = std::move(small);
  small = std::move(large);
  EXPECT_DOUBLE_EQ(distance(moved), 1);
  EXPECT_DOUBLE_EQ(distance(small), 5);
}

} // namespace
} // namespace pcl_ssfr::simulation::test_ray_caster
