#include "transport/ray_scene.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

#include "formats/error.h"

namespace bakelight::transport {
namespace {

constexpr std::uint64_t kIndexLimit = std::numeric_limits<std::uint32_t>::max();

[[noreturn]] void throwDeviceError(RTCError code, const char* what) {
  if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error(std::string("Embree: ") + (what != nullptr ? what : "unknown error"));
}

RTCDevice newDevice() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (device == nullptr) throwDeviceError(rtcGetDeviceError(nullptr), "no device");
  return device;
}

constexpr float kSmallestCoordinate = 1e-15F, kLargestCoordinate = 1e15F;

float farthestCoordinate(const formats::TriangleMesh& mesh) {
  float farthest = 0;
  for (const formats::Float3& position : mesh.positions)
    for (const float value : position) farthest = std::max(farthest, std::abs(value));
  return farthest;
}

// Embree multiplies up to four lengths and holds some of its thresholds absolute. What it traces well as it
// is stays untouched.
float embreeScale(float farthest) {
  constexpr int kOrdinaryExponent = 20;
  if (!(farthest > 0)) return 1;
  const int exponent = std::ilogb(farthest);
  return std::abs(exponent) <= kOrdinaryExponent ? 1.0F : std::ldexp(1.0F, -exponent);
}

formats::Float3 scaled(const formats::Float3& v, float scale) {
  return {v[0] * scale, v[1] * scale, v[2] * scale};
}

}  // namespace

void requireTraceableScale(const formats::TriangleMesh& mesh, const std::string& file) {
  const float farthest = farthestCoordinate(mesh);
  if (farthest == 0 || (farthest >= kSmallestCoordinate && farthest <= kLargestCoordinate)) return;
  throw badInput({file, "", ""},
                 fmt::format("the mesh's farthest coordinate is {:.3g}", farthest) +
                     ", beyond what can be traced in single precision",
                 "from 1e-15 to 1e15", "scale the mesh, for example to a size of 1");
}

struct RayScene::Implementation {
  RTCDevice device = newDevice();
  RTCScene scene = rtcNewScene(device);

  Implementation() = default;
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
  ~Implementation() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  void throwOnError() const {
    const RTCError code = rtcGetDeviceError(device);
    if (code != RTC_ERROR_NONE) throwDeviceError(code, "the scene could not be built");
  }

  float scale = 1;  // of the scene in Embree, a power of two, so that nothing is rounded

  // Embree owns the buffers: it pads them for its 16-byte loads.
  void attach(const formats::TriangleMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(formats::Float3), mesh.vertexCount());
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              sizeof(formats::Triangle), mesh.triangleCount());
    throwOnError();
    scale = embreeScale(farthestCoordinate(mesh));
    std::transform(mesh.positions.begin(), mesh.positions.end(), static_cast<formats::Float3*>(vertices),
                   [&](const formats::Float3& p) { return scaled(p, scale); });
    std::memcpy(triangles, mesh.triangles.data(), mesh.triangleCount() * sizeof(formats::Triangle));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, 0);
    rtcReleaseGeometry(geometry);
  }
};

RayScene::RayScene(const formats::TriangleMesh& mesh) : implementation_(std::make_unique<Implementation>()) {
  if (mesh.vertexCount() > kIndexLimit || mesh.triangleCount() > kIndexLimit) throw std::bad_alloc();
  requireTraceableScale(mesh, "");
  if (mesh.triangleCount() > 0) implementation_->attach(mesh);
  // Robust: a ray along an edge must not slip between two triangles, it would let light into closed bodies.
  rtcSetSceneFlags(implementation_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(implementation_->scene, RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(implementation_->scene);
  implementation_->throwOnError();
}

RayScene::~RayScene() = default;

namespace {

using IntMask = int[RayScene::kPacketWidth];

void setOrigin(RTCRay16& rays, const Float3& origin, float t_near) {
  for (int i = 0; i < RayScene::kPacketWidth; ++i) {
    rays.org_x[i] = origin[0];
    rays.org_y[i] = origin[1];
    rays.org_z[i] = origin[2];
    rays.tnear[i] = t_near;
    rays.time[i] = 0;
    rays.mask[i] = ~0u;
    rays.id[i] = 0;
    rays.flags[i] = 0;
  }
}

// Rays first … first + count of the bundle into the packet. Where Embree has no packets of 16 (without
// AVX-512), it goes by the rays themselves rather than by `valid`: a place that is left over holds a ray of
// finite numbers that ends before it begins.
void setDirections(RTCRay16& rays, IntMask& valid, const RayBundle& bundle, std::size_t first,
                   std::size_t count) {
  std::copy_n(&bundle.x[first], count, rays.dir_x);
  std::copy_n(&bundle.y[first], count, rays.dir_y);
  std::copy_n(&bundle.z[first], count, rays.dir_z);
  for (std::size_t i = 0; i < RayScene::kPacketWidth; ++i) {
    const bool used = i < count;
    valid[i] = used ? -1 : 0;
    rays.tfar[i] = std::numeric_limits<float>::infinity() * (used ? 1 : -1);
    if (!used) rays.dir_x[i] = 0, rays.dir_y[i] = 0, rays.dir_z[i] = 1;
  }
}

}  // namespace

void RayScene::occluded(const Float3& origin, const RayBundle& bundle, float t_near,
                        std::span<std::uint8_t> blocked) const {
  alignas(64) RTCRay16 rays;
  alignas(64) IntMask valid;
  const float scale = implementation_->scale;
  setOrigin(rays, scaled(origin, scale), t_near * scale);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (std::size_t first = 0; first < blocked.size(); first += kPacketWidth) {
    const std::size_t count = std::min<std::size_t>(kPacketWidth, blocked.size() - first);
    setDirections(rays, valid, bundle, first, count);
    rtcOccluded16(valid, implementation_->scene, &context, &rays);
    for (std::size_t i = 0; i < count; ++i) blocked[first + i] = rays.tfar[i] < 0 ? 1 : 0;
  }
}

void RayScene::nearestHits(const Float3& origin, const RayBundle& bundle, float t_near, std::size_t count,
                           HitBundle& hits) const {
  alignas(64) RTCRayHit16 query;
  alignas(64) IntMask valid;
  const float scale = implementation_->scale;
  setOrigin(query.ray, scaled(origin, scale), t_near * scale);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (std::size_t first = 0; first < count; first += kPacketWidth) {
    const std::size_t lanes = std::min<std::size_t>(kPacketWidth, count - first);
    setDirections(query.ray, valid, bundle, first, lanes);
    std::fill_n(query.hit.geomID, kPacketWidth, RTC_INVALID_GEOMETRY_ID);
    rtcIntersect16(valid, implementation_->scene, &context, &query);
    for (std::size_t i = 0; i < lanes; ++i) {
      hits.blocked[first + i] = query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
      hits.triangle[first + i] = query.hit.primID[i];
      hits.u[first + i] = query.hit.u[i];
      hits.v[first + i] = query.hit.v[i];
      hits.distance[first + i] = query.ray.tfar[i] / scale;
      const float towards = query.hit.Ng_x[i] * query.ray.dir_x[i] + query.hit.Ng_y[i] * query.ray.dir_y[i] +
                            query.hit.Ng_z[i] * query.ray.dir_z[i];
      hits.back_face[first + i] = towards > 0 ? 1 : 0;
    }
  }
}

namespace {

RTCRay singleRay(const Vec3& origin, const Vec3& direction, float t_near, float t_far) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = t_near;
  ray.tfar = t_far;
  ray.mask = ~0u;
  return ray;
}

}  // namespace

bool RayScene::occluded(const Vec3& origin, const Vec3& direction, float t_far) const {
  const float scale = implementation_->scale;
  RTCRay ray = singleRay(origin * scale, direction, 0, t_far * scale);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(implementation_->scene, &context, &ray);
  return ray.tfar < 0;
}

Hit RayScene::nearestHit(const Vec3& origin, const Vec3& direction, float t_near) const {
  RTCRayHit query{};
  const float scale = implementation_->scale;
  query.ray = singleRay(origin * scale, direction, t_near * scale, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(implementation_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const float towards =
      query.hit.Ng_x * query.ray.dir_x + query.hit.Ng_y * query.ray.dir_y + query.hit.Ng_z * query.ray.dir_z;
  return {true, query.ray.tfar / scale, query.hit.primID, query.hit.u, query.hit.v, towards > 0};
}

std::string RayScene::executionPath() {
  RTCDevice device = newDevice();
  const auto version = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
  rtcReleaseDevice(device);
  // Embree picks the widest of these that the processor has, and does not tell which.
  __builtin_cpu_init();
  const char* isa = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") ? "avx512"
                    : __builtin_cpu_supports("avx2")                                        ? "avx2"
                    : __builtin_cpu_supports("avx")                                         ? "avx"
                                                                                            : "sse";
  return "embree " + std::to_string(version) + " " + isa;
}

}  // namespace bakelight::transport
