// Figures of a triangle mesh: size, shape of its triangles, topology.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/inspect/moments.h"

namespace bakelight::inspect {

struct MeshFigures {
  std::uint64_t vertices = 0, triangles = 0;
  formats::Float3 minimum = {}, maximum = {};  // bounding box
  double diagonal = 0, area = 0;

  // Edges of all triangles (a shared edge counts once), in the mesh's unit of length.
  Moments edge_length;
  // The smallest angle of each triangle with an area, in degrees; 60 is the best.
  Moments smallest_angle_deg;
  std::uint64_t degenerate_triangles = 0;  // no area, or a vertex twice

  // Topology, where vertices at equal positions count as one and degenerate triangles are left out.
  std::uint64_t distinct_positions = 0;
  std::uint64_t isolated_vertices = 0;  // in no triangle
  std::uint64_t edges = 0;
  std::uint64_t border_edges = 0;         // of one triangle
  std::uint64_t non_manifold_edges = 0;   // of more than two
  std::uint64_t misoriented_edges = 0;    // of two triangles that run along it the same way
  std::uint64_t borders = 0;              // connected sets of border edges
  std::uint64_t components = 0;           // connected by edges' ends
  std::int64_t euler_characteristic = 0;  // positions in use − edges + triangles
  bool closed = false;                    // every edge has two triangles
  double volume = 0;                      // enclosed; positive if triangles face outwards; 0 unless closed

  // Of the material of each triangle, in the order of their names; empty without materials.
  struct Material {
    std::uint64_t triangles = 0;
    double area = 0;
  };
  std::vector<Material> materials;

  bool has_normals = false, has_texcoords = false, has_colors = false;
  double normal_length_error = 0;  // largest |length − 1|
};

// Cost: O(n log n), single-threaded, about 1 s a million triangles.
MeshFigures measureMesh(const formats::TriangleMesh& mesh);

// For each vertex the lowest vertex at the same position.
std::vector<std::uint32_t> firstVertexAtPosition(const formats::TriangleMesh& mesh);

}  // namespace bakelight::inspect
