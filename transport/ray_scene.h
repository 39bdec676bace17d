// Visibility and nearest hits against one triangle mesh; Embree behind it.
#pragma once

#include <cstdint>
#include <limits>
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
  float u = 0, v = 0;      // barycentric weights of the triangle's second and third vertex
  bool back_face = false;  // the ray met the side that the triangle is clockwise on
};

// Nearest hits of a bundle's rays, as a structure of arrays.
struct HitBundle {
  std::vector<std::uint8_t> blocked;    // 1 where something was hit; the rest is set for those only
  std::vector<std::uint8_t> back_face;  // as in Hit
  std::vector<std::uint32_t> triangle;
  std::vector<float> u, v, distance;

  HitBundle() = default;
  explicit HitBundle(std::size_t size)
      : blocked(size), back_face(size), triangle(size), u(size), v(size), distance(size) {}
};

// Throws Error(kBadInput) naming `file` for a mesh whose farthest coordinate is not 10⁻¹⁵ to 10¹⁵: beyond,
// areas and distances leave the range of floats.
void requireTraceableScale(const formats::TriangleMesh& mesh, const std::string& file);

class RayScene {
 public:
  static constexpr int kPacketWidth = 16;

  // Builds the bounding-volume hierarchy (same tree whatever the number of threads). Lengths are the mesh's
  // own whatever its scale: where single precision would run out, the scene is held scaled by a power of two.
  // Throws as requireTraceableScale does. Triangles
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
  // The nearest hits of the first `count` rays of the bundle, into the first entries of `hits`, which holds
  // as many. Thread-safe; allocates nothing.
  void nearestHits(const Float3& origin, const RayBundle& bundle, float t_near, std::size_t count,
                   HitBundle& hits) const;
  Hit nearestHit(const Vec3& origin, const Vec3& direction, float t_near = 0) const;
  // Whether anything lies along the ray at a distance from 0 to `t_far`.
  bool occluded(const Vec3& origin, const Vec3& direction,
                float t_far = std::numeric_limits<float>::infinity()) const;

  // "embree 3.13.5 avx512": the instruction set that Embree chose on this machine, which may move a hit by a
  // rounding.
  static std::string executionPath();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::transport
