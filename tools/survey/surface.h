// Points on a mesh by area, and what a ray that arrives there meets.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/ray_scene.h"
#include "transport/vector_types.h"

namespace bakelight::survey {

struct SurfacePoint {
  transport::Vec3 origin;  // where its rays start: a little off the surface
  transport::Vec3 normal;  // of the triangle, on the side that the point is on; unit length
  transport::Vec3 albedo;
  std::uint32_t triangle;
};

class Surface {
 public:
  // Keeps a reference to `mesh`, which has a triangle with an area (std::invalid_argument).
  Surface(const formats::TriangleMesh& mesh, const formats::Float3& albedo);

  // On a front; `along` in [0, 1) runs through the triangles in proportion to their areas, `u` and `v` in
  // [0, 1) place it within.
  SurfacePoint pointAt(double along, double u, double v) const;
  // Where a ray ends; false if in the dark inside of a closed part.
  bool pointAt(std::uint32_t triangle, double u, double v, bool back_face, SurfacePoint& point) const;
  // Means over the area.
  transport::Vec3 meanAlbedo() const;
  transport::Vec3 mean(const std::vector<formats::Float3>& of_triangles) const;

 private:
  SurfacePoint pointOn(std::uint32_t triangle, double u, double v, bool back) const;
  transport::Vec3 across(std::uint32_t triangle) const;  // normal × twice the area

  const formats::TriangleMesh& mesh_;
  transport::Vec3 albedo_;
  double offset_;
  std::vector<double> area_up_to_;  // running sum, by triangle
  std::vector<std::uint8_t> lit_behind_;
};

}  // namespace bakelight::survey
