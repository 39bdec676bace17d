#include "transport/ray_scene.h"

#include <embree3/rtcore.h>

#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>

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

}  // namespace

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

  // Embree owns the buffers: it pads them for its 16-byte loads.
  void attach(const formats::TriangleMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(formats::Float3), mesh.vertexCount());
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              sizeof(formats::Triangle), mesh.triangleCount());
    throwOnError();
    std::memcpy(vertices, mesh.positions.data(), mesh.vertexCount() * sizeof(formats::Float3));
    std::memcpy(triangles, mesh.triangles.data(), mesh.triangleCount() * sizeof(formats::Triangle));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, 0);
    rtcReleaseGeometry(geometry);
  }
};

RayScene::RayScene(const formats::TriangleMesh& mesh) : implementation_(std::make_unique<Implementation>()) {
  if (mesh.vertexCount() > kIndexLimit || mesh.triangleCount() > kIndexLimit) throw std::bad_alloc();
  if (mesh.triangleCount() > 0) implementation_->attach(mesh);
  // Robust: a ray along an edge must not slip between two triangles, it would let light into closed bodies.
  rtcSetSceneFlags(implementation_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(implementation_->scene, RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(implementation_->scene);
  implementation_->throwOnError();
}

RayScene::~RayScene() = default;

std::uint32_t RayScene::occluded16(const Float3& origin, const DirectionPackets& directions,
                                   std::size_t first, std::uint32_t active, float t_near) const {
  alignas(64) RTCRay16 rays;
  alignas(64) int valid[kPacketWidth];
  std::memcpy(rays.dir_x, &directions.x[first], sizeof rays.dir_x);
  std::memcpy(rays.dir_y, &directions.y[first], sizeof rays.dir_y);
  std::memcpy(rays.dir_z, &directions.z[first], sizeof rays.dir_z);
  for (int i = 0; i < kPacketWidth; ++i) {
    valid[i] = (active >> i & 1u) != 0 ? -1 : 0;
    rays.org_x[i] = origin[0];
    rays.org_y[i] = origin[1];
    rays.org_z[i] = origin[2];
    rays.tnear[i] = t_near;
    rays.tfar[i] = std::numeric_limits<float>::infinity();
    rays.time[i] = 0;
    rays.mask[i] = ~0u;
    rays.flags[i] = 0;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded16(valid, implementation_->scene, &context, &rays);
  std::uint32_t blocked = 0;
  for (int i = 0; i < kPacketWidth; ++i) blocked |= (rays.tfar[i] < 0 ? 1u : 0u) << i;
  return blocked & active;
}

Hit RayScene::nearestHit(const Vec3& origin, const Vec3& direction, float t_near) const {
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(origin.x());
  query.ray.org_y = static_cast<float>(origin.y());
  query.ray.org_z = static_cast<float>(origin.z());
  query.ray.dir_x = static_cast<float>(direction.x());
  query.ray.dir_y = static_cast<float>(direction.y());
  query.ray.dir_z = static_cast<float>(direction.z());
  query.ray.tnear = t_near;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = ~0u;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(implementation_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {true, query.ray.tfar, query.hit.primID, query.hit.u, query.hit.v};
}

std::string RayScene::executionPath() {
  RTCDevice device = newDevice();
  const auto version = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
  std::string isa = "sse2";
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0) isa = "avx";
  if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0) isa = "avx512";
  rtcReleaseDevice(device);
  return "embree " + std::to_string(version) + " " + isa;
}

}  // namespace bakelight::transport
