// The mesh as the simplify stage works on it: double precision, positions and materials only, in any unit of
// length.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::simplify {

using formats::Triangle;
using transport::Vec3;

inline constexpr std::uint32_t kFirstSheet = std::uint32_t{1} << 31;

struct WorkingMesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;  // counter-clockwise seen from outside
  // Of each triangle; empty where there are none. From kFirstSheet on, what the triangle shows on its two
  // sides is an entry of `sheets`.
  std::vector<std::uint32_t> materials = {};
  struct Sheet {
    std::uint32_t front, back;  // materials
  };
  std::vector<Sheet> sheets = {};

  bool isSheet(std::size_t triangle) const {
    return !materials.empty() && materials[triangle] >= kFirstSheet;
  }
  const Vec3& corner(std::size_t triangle, int k) const { return positions[triangles[triangle][k]]; }
  // Twice the area, along the normal.
  Vec3 areaVector(std::size_t triangle) const {
    return (corner(triangle, 1) - corner(triangle, 0)).cross(corner(triangle, 2) - corner(triangle, 0));
  }
};

// Keeps the triangles for which `keep`, one entry a triangle, is true, in order. Vertices stay.
void keepTriangles(WorkingMesh& mesh, const std::vector<bool>& keep);

WorkingMesh workingMesh(const formats::TriangleMesh& mesh);

}  // namespace bakelight::simplify
