// The triangle mesh that stages hand to each other.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace bakelight::formats {

using Float2 = std::array<float, 2>;
using Float3 = std::array<float, 3>;
using Float4 = std::array<float, 4>;
using Triangle = std::array<std::uint32_t, 3>;

// Right-handed, +Y up, counter-clockwise seen from outside. `normals`, `texcoords` and `colors` are empty or
// have one entry a vertex; texcoords have their origin at the lower left (u right, v up), as OBJ and OpenGL
// have.
struct TriangleMesh {
  std::vector<Float3> positions;  // n vertices, in the asset's unit of length
  std::vector<Float3> normals;    // unit length
  std::vector<Float2> texcoords;
  std::vector<Triangle> triangles;  // indices into the vertices
  // Diffuse albedo, linear, 0–1.
  std::vector<Float3> colors = {};
  // The material of each triangle, an index into the names; both are empty where a mesh tells no materials
  // apart. Names are those of the mesh's file: they may be empty, repeat, or belong to no triangle.
  std::vector<std::uint32_t> triangle_materials = {};
  std::vector<std::string> material_names = {};

  std::size_t vertexCount() const { return positions.size(); }
  std::size_t triangleCount() const { return triangles.size(); }
};

}  // namespace bakelight::formats
