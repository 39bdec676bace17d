// Visibility and nearest hits against one triangle mesh; Embree behind it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// Rays of one common origin, as a structure of arrays. Embree traces them in packets of kPacketWidth
// neighbours, so directions that are near each other in the list should be near each other on the sphere.
struct RayBundle {
  std::vector<float> x, y, z;  // unit directions

  RayBundle() = default;
  explicit RayBundle(std::size_t size) : x(size), y(size), z(size) {}
  std::size_t size() const { return x.size(); }
  void set(std::size_t i, const Float3& direction) {
    x[i] = direction[0], y[i] = direction[1], z[i] = direction[2];
  }
  void push(const Float3& direction) {
    x.push_back(direction[0]), y.push_back(direction[1]), z.push_back(direction[2]);
  }
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

  // blocked[i] = 1 if anything lies along ray i at a distance from `t_near` (in units of length) to infinity,
  // else 0; both sides of a triangle block. Traces the first blocked.size() rays of the bundle (at most all
  // of them). Thread-safe; allocates nothing.
  void occluded(const Float3& origin, const RayBundle& bundle, float t_near,
                std::span<std::uint8_t> blocked) const;
  Hit nearestHit(const Vec3& origin, const Vec3& direction, float t_near = 0) const;

  // "embree 3.13.5 avx512": the instruction set that Embree chose on this machine, which may move a hit by a
  // rounding.
  static std::string executionPath();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::transport
