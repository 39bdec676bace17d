// The mesh as the simplify stage works on it: double precision, positions and materials only, in any unit of
// length.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/surface_query.h"
#include "transport/vector_types.h"

namespace bakelight::surface {

using formats::Triangle;
using transport::ClosestPoint;
using transport::SurfaceMesh;
using transport::SurfaceQuery;
using transport::Vec3;

inline constexpr std::uint32_t kFirstSheet = std::uint32_t{1} << 31;

// From kFirstSheet on, a material says what the triangle shows on its two sides: an entry of `sheets`.
struct WorkingMesh : SurfaceMesh {
  WorkingMesh() = default;
  WorkingMesh(std::vector<Vec3> places, std::vector<Triangle> corners,
              std::vector<std::uint32_t> materials_of_triangles = {})
      : SurfaceMesh{std::move(places), std::move(corners), std::move(materials_of_triangles)} {}

  struct Sheet {
    std::uint32_t front, back;  // materials
  };
  std::vector<Sheet> sheets = {};

  bool isSheet(std::size_t triangle) const {
    return !materials.empty() && materials[triangle] >= kFirstSheet;
  }
};

// Keeps the triangles for which `keep`, one entry a triangle, is true, in order. Vertices stay.
void keepTriangles(WorkingMesh& mesh, const std::vector<bool>& keep);

WorkingMesh workingMesh(const formats::TriangleMesh& mesh);

}  // namespace bakelight::surface
