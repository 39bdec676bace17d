#include "transport/periodic_ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

namespace bakelight::transport {
namespace {

using formats::TriangleMesh;

constexpr int kWidth = RayScene::kPacketWidth;
constexpr int kMostSegments = 4096;  // of a ray that is as good as horizontal
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Bounds {
  std::array<double, 3> low = {kInfinity, kInfinity, kInfinity}, high = {-kInfinity, -kInfinity, -kInfinity};

  void add(const Float3& p) {
    for (std::size_t c = 0; c < 3; ++c)
      low[c] = std::min<double>(low[c], p[c]), high[c] = std::max<double>(high[c], p[c]);
  }
};

Bounds boundsOf(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) bounds.add(mesh.positions[v]);
  return bounds;
}

}  // namespace

void FreeRays::grow() {
  const std::size_t capacity = std::max<std::size_t>(64, 2 * size_);
  for (std::vector<float>* values : {&x, &y, &z, &direction_x, &direction_y, &direction_z})
    values->resize(capacity);
}

struct PeriodicRayScene::Implementation {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = nullptr;
  std::array<double, 2> period, margin;
  double low = 0, high = 0;    // of the mesh
  double floor = 0, roof = 0;  // the same with a little room
  double overlap = 0;          // of segments
  std::vector<std::uint32_t> triangle_of_copy;

  Implementation(const TriangleMesh& mesh, const Period& period_in) : period{period_in.x, period_in.y} {
    if (!(period[0] > 0) || !(period[1] > 0)) throw std::invalid_argument("a period is not positive");
    requireTraceableScale(mesh, "");
    throwOnError();
    scene = rtcNewScene(device);
    try {
      hold(mesh);
    } catch (...) {
      release();
      throw;
    }
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
  ~Implementation() { release(); }

  void release() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
    scene = nullptr, device = nullptr;
  }

  void throwOnError() const {
    const RTCError code = rtcGetDeviceError(device);
    if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (code != RTC_ERROR_NONE || device == nullptr)
      throw std::runtime_error("Embree: error " + std::to_string(code));
  }

  // Rays at 60° from the zenith need no second segment, unless the surface is deep.
  void chooseMargins(double depth) {
    for (std::size_t c = 0; c < 2; ++c) margin[c] = std::clamp(2 * depth, 0.05 * period[c], period[c]);
  }

  void hold(const TriangleMesh& mesh) {
    const Bounds all = boundsOf(mesh);
    const double depth = mesh.triangleCount() > 0 ? all.high[2] - all.low[2] : 0;
    low = mesh.triangleCount() > 0 ? all.low[2] : 0, high = low + depth;
    const double size = std::max({period[0], period[1], depth});
    const double room = 1e-5 * size;
    floor = low - room, roof = high + room;
    overlap = room;
    chooseMargins(depth);
    std::vector<Float3> positions;
    std::vector<formats::Triangle> triangles;
    for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) addCopies(mesh, t, positions, triangles);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    if (!triangles.empty()) attach(positions, triangles);
    rtcCommitScene(scene);
    throwOnError();
  }

  void addCopies(const TriangleMesh& mesh, std::uint32_t triangle, std::vector<Float3>& positions,
                 std::vector<formats::Triangle>& triangles) {
    Bounds bounds;
    for (const std::uint32_t v : mesh.triangles[triangle]) bounds.add(mesh.positions[v]);
    std::array<int, 2> first, last;
    for (std::size_t c = 0; c < 2; ++c) {
      first[c] = static_cast<int>(std::ceil((-margin[c] - bounds.high[c]) / period[c]));
      last[c] = static_cast<int>(std::floor((period[c] + margin[c] - bounds.low[c]) / period[c]));
    }
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const auto base = static_cast<std::uint32_t>(positions.size());
        for (const std::uint32_t v : mesh.triangles[triangle]) {
          const Float3& p = mesh.positions[v];
          positions.push_back(
              {static_cast<float>(p[0] + i * period[0]), static_cast<float>(p[1] + j * period[1]), p[2]});
        }
        triangles.push_back({base, base + 1, base + 2});
        triangle_of_copy.push_back(triangle);
      }
  }

  void attach(const std::vector<Float3>& positions, const std::vector<formats::Triangle>& triangles) {
    if (positions.size() > std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* to = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Float3),
                                       positions.size());
    if (to != nullptr) std::copy(positions.begin(), positions.end(), static_cast<Float3*>(to));
    to = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                 sizeof(formats::Triangle), triangles.size());
    if (to != nullptr) std::copy(triangles.begin(), triangles.end(), static_cast<formats::Triangle*>(to));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, 0);
    rtcReleaseGeometry(geometry);
    throwOnError();
  }
};

namespace {

// A ray on its way: what it has gone is that of its origin plus `gone` times its direction.
struct Way {
  double gone = 0, end = 0;  // of the present segment
  double leaves = 0;         // the surface's range of heights
  bool open = false;         // something may still be met
};

// A packet of rays from cell to cell.
template <class Scene>
class PacketWalk {
 public:
  PacketWalk(const Scene& scene, const FreeRays& rays, std::size_t first)
      : scene_(scene),
        rays_(rays),
        first_(first),
        count_(std::min<std::size_t>(kWidth, rays.size() - first)) {
    for (std::size_t i = 0; i < count_; ++i) enter(i);
  }

  std::size_t count() const { return count_; }
  bool anyOpen() const {
    return std::any_of(ways_.begin(), ways_.begin() + static_cast<std::ptrdiff_t>(count_),
                       [](const Way& way) { return way.open; });
  }
  bool isOpen(std::size_t lane) const { return ways_[lane].open; }
  double gone(std::size_t lane) const { return ways_[lane].gone; }
  void close(std::size_t lane) { ways_[lane].open = false; }

  // The next segments of all rays that are still open.
  void fill(RTCRay16& packet, int* valid) {
    for (std::size_t i = 0; i < kWidth; ++i) {
      const bool used = i < count_ && ways_[i].open;
      valid[i] = used ? -1 : 0;
      packet.tnear[i] = 0;
      packet.time[i] = 0, packet.mask[i] = ~0U, packet.id[i] = 0, packet.flags[i] = 0;
      if (used) {
        fillLane(packet, i);
      } else {  // where Embree has no packets of 16 it goes by the rays rather than by `valid`
        packet.org_x[i] = packet.org_y[i] = packet.org_z[i] = 0;
        packet.dir_x[i] = packet.dir_y[i] = 0, packet.dir_z[i] = 1;
        packet.tfar[i] = -std::numeric_limits<float>::infinity();
      }
    }
  }

  // Of a ray that has met nothing so far.
  void goOn(std::size_t lane) {
    Way& way = ways_[lane];
    way.gone = way.end;
    way.open = way.gone < way.leaves;
  }

 private:
  std::array<double, 3> originOf(std::size_t lane) const {
    const std::size_t r = first_ + lane;
    return {rays_.x[r], rays_.y[r], rays_.z[r]};
  }
  std::array<double, 3> directionOf(std::size_t lane) const {
    const std::size_t r = first_ + lane;
    return {rays_.direction_x[r], rays_.direction_y[r], rays_.direction_z[r]};
  }

  void enter(std::size_t lane) {
    const double z = originOf(lane)[2], dz = directionOf(lane)[2];
    Way& way = ways_[lane];
    const double to_floor = (scene_.floor - z) / dz, to_roof = (scene_.roof - z) / dz;
    if (dz == 0) {
      way.leaves = z > scene_.floor && z < scene_.roof ? kInfinity : 0;
    } else {
      way.gone = std::max(0.0, std::min(to_floor, to_roof));
      way.leaves = std::max(to_floor, to_roof);
    }
    way.open = way.gone < way.leaves;
  }

  void fillLane(RTCRay16& packet, std::size_t lane) {
    const auto origin = originOf(lane), direction = directionOf(lane);
    Way& way = ways_[lane];
    std::array<double, 2> at;
    double length = way.leaves - way.gone;
    for (std::size_t c = 0; c < 2; ++c) {
      at[c] = origin[c] + way.gone * direction[c];
      if (at[c] < 0 || at[c] >= scene_.period[c])
        at[c] -= scene_.period[c] * std::floor(at[c] / scene_.period[c]);
      const double wall = direction[c] > 0 ? scene_.period[c] + scene_.margin[c] : -scene_.margin[c];
      if (direction[c] != 0) length = std::min(length, (wall - at[c]) / direction[c]);
    }
    // Straight into nothing, or along for ever.
    if (!(length < 1e30)) length = 1e30, way.leaves = 0;
    if (++segments_[lane] >= kMostSegments) way.leaves = 0;
    way.end = way.gone + length;
    packet.org_x[lane] = static_cast<float>(at[0]);
    packet.org_y[lane] = static_cast<float>(at[1]);
    packet.org_z[lane] = static_cast<float>(origin[2] + way.gone * direction[2]);
    packet.dir_x[lane] = static_cast<float>(direction[0]);
    packet.dir_y[lane] = static_cast<float>(direction[1]);
    packet.dir_z[lane] = static_cast<float>(direction[2]);
    packet.tfar[lane] = static_cast<float>(length + scene_.overlap);
  }

  const Scene& scene_;
  const FreeRays& rays_;
  std::size_t first_, count_;
  std::array<Way, kWidth> ways_ = {};
  std::array<int, kWidth> segments_ = {};
};

}  // namespace

PeriodicRayScene::PeriodicRayScene(const TriangleMesh& mesh, const Period& period)
    : implementation_(std::make_unique<Implementation>(mesh, period)) {}

PeriodicRayScene::~PeriodicRayScene() = default;

double PeriodicRayScene::lowest() const {
  return implementation_->low;
}
double PeriodicRayScene::highest() const {
  return implementation_->high;
}
TriangleMesh PeriodicRayScene::heldTriangles() const {
  TriangleMesh mesh;
  const std::size_t count = implementation_->triangle_of_copy.size();
  if (count == 0) return mesh;
  const RTCGeometry geometry = rtcGetGeometry(implementation_->scene, 0);
  const auto* positions =
      static_cast<const Float3*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  mesh.positions.assign(positions, positions + 3 * count);
  const auto* triangles =
      static_cast<const formats::Triangle*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0));
  mesh.triangles.assign(triangles, triangles + count);
  return mesh;
}

void PeriodicRayScene::nearestHits(const FreeRays& rays, HitBundle& hits) const {
  alignas(64) RTCRayHit16 query;
  alignas(64) int valid[kWidth];
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (std::size_t first = 0; first < rays.size(); first += kWidth) {
    PacketWalk walk(*implementation_, rays, first);
    std::fill_n(&hits.blocked[first], walk.count(), std::uint8_t{0});
    while (walk.anyOpen()) {
      walk.fill(query.ray, valid);
      std::fill_n(query.hit.geomID, kWidth, RTC_INVALID_GEOMETRY_ID);
      rtcIntersect16(valid, implementation_->scene, &context, &query);
      for (std::size_t i = 0; i < walk.count(); ++i) {
        if (!walk.isOpen(i)) continue;
        if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
          walk.goOn(i);
          continue;
        }
        walk.close(i);
        const std::size_t r = first + i;
        hits.blocked[r] = 1;
        hits.triangle[r] = implementation_->triangle_of_copy[query.hit.primID[i]];
        hits.u[r] = query.hit.u[i];
        hits.v[r] = query.hit.v[i];
        hits.distance[r] = static_cast<float>(walk.gone(i) + query.ray.tfar[i]);
        const float towards = query.hit.Ng_x[i] * query.ray.dir_x[i] +
                              query.hit.Ng_y[i] * query.ray.dir_y[i] + query.hit.Ng_z[i] * query.ray.dir_z[i];
        hits.back_face[r] = towards > 0 ? 1 : 0;
      }
    }
  }
}

void PeriodicRayScene::occluded(const FreeRays& rays, std::span<std::uint8_t> blocked) const {
  alignas(64) RTCRay16 packet;
  alignas(64) int valid[kWidth];
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (std::size_t first = 0; first < rays.size(); first += kWidth) {
    PacketWalk walk(*implementation_, rays, first);
    std::fill_n(&blocked[first], walk.count(), std::uint8_t{0});
    while (walk.anyOpen()) {
      walk.fill(packet, valid);
      rtcOccluded16(valid, implementation_->scene, &context, &packet);
      for (std::size_t i = 0; i < walk.count(); ++i) {
        if (!walk.isOpen(i)) continue;
        if (packet.tfar[i] < 0)
          blocked[first + i] = 1, walk.close(i);
        else
          walk.goOn(i);
      }
    }
  }
}

}  // namespace bakelight::transport
