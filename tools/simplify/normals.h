// Vertex normals for shading.
#pragma once

#include <cstdint>

#include "formats/triangle_mesh.h"
#include "surface/working_mesh.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {

struct ShadedMesh {
  formats::TriangleMesh mesh;          // with normals
  std::int64_t split_vertices = 0;     // copies made along creases
  std::int64_t material_vertices = 0;  // copies made along borders between materials
};

// Angle-weighted normals (Thürmer & Wüthrich 1998). Where creases part the triangles around a vertex, each
// part gets its own copy and normal. Creases are those of features.h: edges sharper than `crease_angle_deg`,
// in lines of at least `min_crease_length`, as a fold of a few triangles is noise. Where two materials meet,
// each gets its own copy, too, with the same normal. `mesh` must be an oriented manifold. Vertex and triangle
// order is kept; copies follow at the end. A vertex whose triangles have no area gets +Y.
ShadedMesh withNormals(const WorkingMesh& mesh, double crease_angle_deg, double min_crease_length);

}  // namespace bakelight::simplify
