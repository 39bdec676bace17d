// Nearest hits and visibility against a mesh that repeats along x and y without end; Embree behind it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/ray_scene.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// Rays with origins of their own, as a structure of arrays. They are traced in packets of
// RayScene::kPacketWidth neighbors, which should be alike.
struct FreeRays {
  // Of at least size() elements each.
  std::vector<float> x, y, z;                                // origins
  std::vector<float> direction_x, direction_y, direction_z;  // unit

  void clear() { size_ = 0; }
  void push(const Vec3& origin, const Vec3& direction) {
    if (size_ == x.size()) grow();
    x[size_] = static_cast<float>(origin.x());
    y[size_] = static_cast<float>(origin.y());
    z[size_] = static_cast<float>(origin.z());
    direction_x[size_] = static_cast<float>(direction.x());
    direction_y[size_] = static_cast<float>(direction.y());
    direction_z[size_] = static_cast<float>(direction.z());
    ++size_;
  }
  std::size_t size() const { return size_; }

 private:
  void grow();
  std::size_t size_ = 0;
};

class PeriodicRayScene {
 public:
  struct Period {
    double x = 1, y = 1;  // positive
  };

  // `mesh` is one period of the surface, wherever its parts lie: every triangle is there at all sums of
  // multiples of the two periods. Copies that reach into a margin about the first cell are held as triangles;
  // rays go on from cell to cell beyond it. Throws as RayScene does.
  PeriodicRayScene(const formats::TriangleMesh& mesh, const Period& period);
  ~PeriodicRayScene();
  PeriodicRayScene(const PeriodicRayScene&) = delete;
  PeriodicRayScene& operator=(const PeriodicRayScene&) = delete;

  // Nearest hits of all rays; `hits` holds as many. Triangles are those of the mesh; distances are from the
  // origins. A ray that neither meets anything nor leaves the surface's range of heights within some thousand
  // cells has no hit. Thread-safe.
  void nearestHits(const FreeRays& rays, HitBundle& hits) const;
  // blocked[i] = 1 if ray i meets anything. Thread-safe.
  void occluded(const FreeRays& rays, std::span<std::uint8_t> blocked) const;

  double lowest() const;  // z of the mesh
  double highest() const;
  formats::TriangleMesh heldTriangles() const;  // with the copies

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::transport
