// From a mesh that slides on its original to the one handed on.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/mesomesh/retile/original_surface.h"

namespace bakelight::mesomesh {

struct PartedMesh {
  std::vector<Vec3> positions, normals;
  std::vector<formats::Triangle> triangles;
  std::vector<std::uint32_t> vertex_materials,
      triangle_materials;  // surface::WorkingMesh's, sheets resolved
  std::int64_t crease_copies = 0;
};

// Gives each side of a crease, and of a border between materials, vertices of its own, all of them normals,
// and the triangles of sheets (surface::WorkingMesh) their backs. Vertices are in the order of their first
// triangles; backs follow. All TBB threads.
PartedMesh parted(const SlidingMesh& mesh, const OriginalSurface& original,
                  const std::vector<surface::WorkingMesh::Sheet>& sheets);

// How many vertices parted() makes of a mesh after `subdivisions` of it, without backs.
std::int64_t partedCount(const CornerMesh& mesh, int subdivisions);

}  // namespace bakelight::mesomesh
