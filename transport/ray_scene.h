// Visibility and nearest hits against one triangle mesh; Embree behind it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// Directions laid out for common-origin packets: structure of arrays, padded with copies of the last one to a
// multiple of kPacketWidth.
struct DirectionPackets {
  std::vector<float> x, y, z;
  std::size_t count = 0;  // without the padding
};

struct Hit {
  bool valid = false;
  float distance = 0;
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  // barycentric weights of the triangle's second and third vertex
};

class RayScene {
 public:
  static constexpr int kPacketWidth = 16;

  // Builds the bounding-volume hierarchy with `threads` threads (same tree whatever the number). Triangles
  // with a repeated index or zero area are kept; rays miss them. Throws std::bad_alloc, or std::runtime_error
  // with Embree's message.
  explicit RayScene(const formats::TriangleMesh& mesh);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  // Bit i of the result (bit 0 = first) says whether packet `first / 16`'s ray i is blocked; both sides of a
  // triangle block. `active` masks the rays to trace. Distances from `t_near` (metres along the unit
  // direction) to infinity. Thread-safe.
  std::uint32_t occluded16(const Float3& origin, const DirectionPackets& directions, std::size_t first,
                           std::uint32_t active, float t_near) const;
  Hit nearestHit(const Vec3& origin, const Vec3& direction, float t_near = 0) const;

  // "embree 3.13.5 avx512": the instruction set that Embree chose on this machine, which may move a hit by a
  // rounding.
  static std::string executionPath();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::transport
