// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/simulation/ray_caster.h>

#include <apps/simulation/simulation_error.h>

#if PCL_SSFR_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

namespace pcl_ssfr::simulation {

namespace {

// One build thread: the same tree every time. A pinned instruction set: the same hits on every machine.
#if defined(__x86_64__) || defined(_M_X64)
constexpr const char* kDeviceConfig = "threads=1,set_affinity=0,isa=sse4.2";
#else
constexpr const char* kDeviceConfig = "threads=1,set_affinity=0";
#endif

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kInfinityF = std::numeric_limits<float>::infinity();
/// Embree computes in float: what it says about a distance may be off by this share of the coordinates involved.
constexpr double kFloatError = 1e-5;
/// Distance to both ends that isVisible() does not look at [m].
constexpr double kVisibleGap = 1e-3;
/// Sine of the angle to the axis below which a ray cannot meet the side of a tube.
constexpr double kParallel = 1e-12;

// Embree 4 renamed the context of Embree 3, and takes it in a struct of arguments.
#if PCL_SSFR_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;

void
initContext(QueryContext& context)
{
  rtcInitRayQueryContext(&context);
}

void
intersectFirst(RTCScene scene, QueryContext& context, RTCRayHit& rayhit)
{
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &rayhit, &arguments);
}
#else
using QueryContext = RTCIntersectContext;

void
initContext(QueryContext& context)
{
  rtcInitIntersectContext(&context);
}

void
intersectFirst(RTCScene scene, QueryContext& context, RTCRayHit& rayhit)
{
  rtcIntersect1(scene, &context, &rayhit);
}
#endif

/// A ray in double with Embree's context in front, so that a pointer to one is a pointer to the other.
struct Query {
  QueryContext context;
  const Eigen::Vector3d* origin;
  const Eigen::Vector3d* direction;
  double min_distance;
};

/// The first of two ordered distances that is beyond the minimum and accepted; infinity when neither is.
template <typename Accept>
double
firstBeyond(double near, double far, double min_distance, const Accept& accept)
{
  if (near > min_distance && accept(near))
    return near;
  if (far > min_distance && accept(far))
    return far;
  return kInfinity;
}

/// Distance to a sphere along the ray, infinity when it is missed.
double
intersect(const Sphere& sphere, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double min_distance)
{
  const Eigen::Vector3d to_centre = sphere.centre - origin;
  const double middle = to_centre.dot(direction);
  // By the distance of the ray from the centre: no difference of large squares.
  const double squared = sphere.radius * sphere.radius - (to_centre - middle * direction).squaredNorm();
  if (!(squared >= 0))
    return kInfinity;
  const double half_chord = std::sqrt(squared);
  return firstBeyond(middle - half_chord, middle + half_chord, min_distance, [](double) { return true; });
}

Eigen::Vector3d
normalAt(const Sphere& sphere, const Eigen::Vector3d& point)
{
  return (point - sphere.centre).normalized();
}

/// Distance to the side of a tube along the ray, infinity when it is missed.
double
intersect(const Tube& tube, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double min_distance)
{
  const Eigen::Vector3d from_base = origin - tube.base;
  const double height = from_base.dot(tube.axis);
  const double climb = direction.dot(tube.axis);
  const Eigen::Vector3d across = direction - climb * tube.axis;
  const double sine = across.norm();
  if (!(sine > kParallel))
    return kInfinity;
  const Eigen::Vector3d side = across / sine;
  const Eigen::Vector3d offset = from_base - height * tube.axis;
  const double middle = -offset.dot(side);
  const double squared = tube.radius * tube.radius - (offset + middle * side).squaredNorm();
  if (!(squared >= 0))
    return kInfinity;
  const double half_chord = std::sqrt(squared);
  const auto within = [&](double distance) {
    const double at = height + distance * climb;
    return at >= 0 && at <= tube.length;
  };
  return firstBeyond((middle - half_chord) / sine, (middle + half_chord) / sine, min_distance, within);
}

Eigen::Vector3d
normalAt(const Tube& tube, const Eigen::Vector3d& point)
{
  const Eigen::Vector3d from_base = point - tube.base;
  return (from_base - from_base.dot(tube.axis) * tube.axis).normalized();
}

/// Embree's callback of user geometry: \p Round is Sphere or Tube, the user pointer its first element.
template <typename Round>
void
intersectRound(const RTCIntersectFunctionNArguments* args)
{
  if (args->N != 1 || args->valid[0] == 0)
    return;
  const auto& query = *reinterpret_cast<const Query*>(args->context);
  const Round& round = static_cast<const Round*>(args->geometryUserPtr)[args->primID];
  const auto distance = static_cast<float>(intersect(round, *query.origin, *query.direction, query.min_distance));
  auto& rayhit = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  if (!(distance < rayhit.ray.tfar))
    return;
  rayhit.ray.tfar = distance;
  rayhit.hit.geomID = args->geomID;
  rayhit.hit.primID = args->primID;
  rayhit.hit.instID[0] = args->context->instID[0];
}

/// Embree's callback for the box about an element, widened to floats.
template <typename Round>
void
boundRound(const RTCBoundsFunctionArguments* args)
{
  SurfaceModel one;
  const Round& round = static_cast<const Round*>(args->geometryUserPtr)[args->primID];
  if constexpr (std::is_same_v<Round, Sphere>)
    one.spheres.push_back(round);
  else
    one.tubes.push_back(round);
  const Eigen::AlignedBox3d box = boundsOf(one);
  const double margin = kFloatError * (1 + box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff());
  const Eigen::Vector3f lower = (box.min().array() - margin).cast<float>();
  const Eigen::Vector3f upper = (box.max().array() + margin).cast<float>();
  RTCBounds& bounds = *args->bounds_o;
  bounds.lower_x = lower.x();
  bounds.lower_y = lower.y();
  bounds.lower_z = lower.z();
  bounds.upper_x = upper.x();
  bounds.upper_y = upper.y();
  bounds.upper_z = upper.z();
}

struct DeviceRelease {
  void
  operator()(RTCDevice device) const
  {
    rtcReleaseDevice(device);
  }
};
struct SceneRelease {
  void
  operator()(RTCScene scene) const
  {
    rtcReleaseScene(scene);
  }
};
struct GeometryRelease {
  void
  operator()(RTCGeometry geometry) const
  {
    rtcReleaseGeometry(geometry);
  }
};
using DevicePtr = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using ScenePtr = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;
using GeometryPtr = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, GeometryRelease>;

const char*
reason(RTCError error)
{
  switch (error) {
  case RTC_ERROR_NONE:
    return "no error";
  case RTC_ERROR_INVALID_ARGUMENT:
    return "invalid argument";
  case RTC_ERROR_INVALID_OPERATION:
    return "invalid operation";
  case RTC_ERROR_OUT_OF_MEMORY:
    return "out of memory";
  case RTC_ERROR_UNSUPPORTED_CPU:
    return "this processor is not supported";
  case RTC_ERROR_CANCELLED:
    return "cancelled";
  default: // also what later versions add
    break;
  }
  return "unknown error";
}

} // namespace

struct RayCaster::Impl {
  explicit Impl(const SurfaceModel& surfaces);
  void
  addMesh() const;
  template <typename Round>
  void
  addRounds(std::vector<Round>& rounds);
  GeometryPtr
  newGeometry(RTCGeometryType type) const;
  void
  attach(const GeometryPtr& geometry, unsigned id) const;
  void
  check(const char* step) const;
  RayHit
  refine(const RTCRayHit& hit,
         const Eigen::Vector3d& origin,
         const Eigen::Vector3d& direction,
         double min_distance) const;

  static constexpr unsigned kMesh = 0;
  static constexpr unsigned kSpheres = 1;
  static constexpr unsigned kTubes = 2;

  SurfaceModel model;
  DevicePtr device; // outlives the scene
  ScenePtr scene;
};

void
RayCaster::Impl::check(const char* step) const
{
  const RTCError error = rtcGetDeviceError(device.get());
  if (error != RTC_ERROR_NONE)
    throw SimulationError(std::string("Embree: ") + step + ": " + reason(error));
}

GeometryPtr
RayCaster::Impl::newGeometry(RTCGeometryType type) const
{
  GeometryPtr geometry(rtcNewGeometry(device.get(), type));
  check("new geometry");
  return geometry;
}

void
RayCaster::Impl::attach(const GeometryPtr& geometry, unsigned id) const
{
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), id);
  check("adding a geometry");
}

void
RayCaster::Impl::addMesh() const
{
  const TriangleMesh& mesh = model.mesh;
  const GeometryPtr geometry = newGeometry(RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  auto* triangles = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
  check("memory of the triangles");
  if (vertices == nullptr || triangles == nullptr)
    throw SimulationError("Embree: memory of the triangles: out of memory");
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    vertices = std::copy_n(vertex.data(), 3, vertices);
  for (const auto& triangle : mesh.triangles)
    triangles = std::copy_n(triangle.data(), 3, triangles);
  attach(geometry, kMesh);
}

template <typename Round>
void
RayCaster::Impl::addRounds(std::vector<Round>& rounds)
{
  constexpr unsigned id = std::is_same_v<Round, Sphere> ? kSpheres : kTubes;
  const GeometryPtr geometry = newGeometry(RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(rounds.size()));
  rtcSetGeometryUserData(geometry.get(), rounds.data());
  rtcSetGeometryBoundsFunction(
      geometry.get(), [](const RTCBoundsFunctionArguments* args) { boundRound<Round>(args); }, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(),
                                  [](const RTCIntersectFunctionNArguments* args) { intersectRound<Round>(args); });
  attach(geometry, id);
}

RayCaster::Impl::Impl(const SurfaceModel& surfaces) : model(surfaces)
{
  validate(model);
  device.reset(rtcNewDevice(kDeviceConfig));
  if (device == nullptr)
    throw SimulationError(std::string("Embree: no device: ") + reason(rtcGetDeviceError(nullptr)));
  scene.reset(rtcNewScene(device.get()));
  check("new scene");
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  if (!model.mesh.triangles.empty())
    addMesh();
  if (!model.spheres.empty())
    addRounds(model.spheres);
  if (!model.tubes.empty())
    addRounds(model.tubes);
  rtcCommitScene(scene.get());
  check("building the tree");
}

RayHit
RayCaster::Impl::refine(const RTCRayHit& hit,
                        const Eigen::Vector3d& origin,
                        const Eigen::Vector3d& direction,
                        double min_distance) const
{
  RayHit result;
  const unsigned index = hit.hit.primID;
  if (hit.hit.geomID == kMesh) {
    const auto& triangle = model.mesh.triangles[index];
    const Eigen::Vector3d a = model.mesh.vertices[triangle[0]].cast<double>() - origin;
    const Eigen::Vector3d b = model.mesh.vertices[triangle[1]].cast<double>() - origin;
    const Eigen::Vector3d c = model.mesh.vertices[triangle[2]].cast<double>() - origin;
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const double cosine = normal.dot(direction);
    const double distance = cosine != 0 ? normal.dot(a) / cosine : static_cast<double>(hit.ray.tfar);
    // However flat the ray meets the plane, the point is in the triangle.
    const double da = a.dot(direction);
    const double db = b.dot(direction);
    const double dc = c.dot(direction);
    result.distance = std::clamp(distance, std::min({da, db, dc}), std::max({da, db, dc}));
    result.normal = normal.squaredNorm() > 0 ? normal.normalized() : Eigen::Vector3d(-direction);
    result.material = model.mesh.material[index];
  }
  else if (hit.hit.geomID == kSpheres) {
    const Sphere& sphere = model.spheres[index];
    result.distance = intersect(sphere, origin, direction, min_distance);
    result.normal = normalAt(sphere, origin + result.distance * direction);
    result.material = sphere.material;
  }
  else {
    const Tube& tube = model.tubes[index];
    result.distance = intersect(tube, origin, direction, min_distance);
    result.normal = normalAt(tube, origin + result.distance * direction);
    result.material = tube.material;
  }
  if (result.normal.dot(direction) > 0)
    result.normal = -result.normal;
  return result;
}

RayCaster::RayCaster(const SurfaceModel& model) : impl_(std::make_unique<Impl>(model))
{}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster&
RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayHit>
RayCaster::cast(const Eigen::Vector3d& origin,
                const Eigen::Vector3d& direction,
                double max_distance,
                double min_distance) const
{
  min_distance = std::max(min_distance, 0.0);
  if (!(max_distance > min_distance) || !origin.allFinite() || !direction.allFinite())
    return std::nullopt;
  // Embree looks a little beyond both ends; the exact distance decides.
  const double reach = 1 + origin.cwiseAbs().maxCoeff();
  const auto near = static_cast<float>(std::max(0.0, min_distance - kFloatError * (reach + min_distance)));
  const auto far = static_cast<float>(max_distance + kFloatError * (reach + max_distance));

  Query query{};
  initContext(query.context);
  query.origin = &origin;
  query.direction = &direction;
  query.min_distance = min_distance;

  RTCRayHit rayhit{};
  rayhit.ray.org_x = static_cast<float>(origin.x());
  rayhit.ray.org_y = static_cast<float>(origin.y());
  rayhit.ray.org_z = static_cast<float>(origin.z());
  rayhit.ray.dir_x = static_cast<float>(direction.x());
  rayhit.ray.dir_y = static_cast<float>(direction.y());
  rayhit.ray.dir_z = static_cast<float>(direction.z());
  rayhit.ray.mask = ~0U;
  rayhit.ray.tnear = near;
  while (rayhit.ray.tnear < far) {
    rayhit.ray.tfar = far;
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    intersectFirst(impl_->scene.get(), query.context, rayhit);
    if (rayhit.hit.geomID == RTC_INVALID_GEOMETRY_ID)
      return std::nullopt;
    const RayHit hit = impl_->refine(rayhit, origin, direction, min_distance);
    if (hit.distance > min_distance)
      return hit.distance < max_distance ? std::optional<RayHit>(hit) : std::nullopt;
    rayhit.ray.tnear = std::nextafter(rayhit.ray.tfar, kInfinityF);
  }
  return std::nullopt;
}

bool
RayCaster::isVisible(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const
{
  const Eigen::Vector3d line = to - from;
  const double length = line.norm();
  if (!(length > 2 * kVisibleGap))
    return std::isfinite(length);
  return !cast(from, line / length, length - kVisibleGap, kVisibleGap);
}

const Material&
RayCaster::material(std::uint16_t index) const
{
  return impl_->model.materials.at(index);
}

} // namespace pcl_ssfr::simulation
