// The meso-mesh: a dense, even tiling of a surface whose vertices each have a place on an exemplar (the
// texture over the surface), in a binary PLY that MeshLab, Blender and readPly open, too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// All lists have one entry a vertex.
struct MesoMesh {
  // With normals; colours are the exemplar's at `patch`, or absent; no texcoords. Along creases and borders
  // between materials each side has vertices of its own.
  TriangleMesh mesh;
  // Unit, perpendicular to the normal: along the exemplar's u. Its v runs along normal × tangent.
  std::vector<Float3> tangents;
  // In [0, 1): u to the right, v up, as texcoords have it: v = 1 is the upper edge of the image's row 0.
  std::vector<Float2> patch;
  // Index into mesh.material_names; 0 where there are none.
  std::vector<std::uint32_t> materials;
  // Of the tangents: 1, 2 or 4; turned by 360°/symmetry they are the same direction.
  int symmetry = 1;
};

// Properties after those of writePly: tangent_x tangent_y tangent_z patch_u patch_v (float), material (uint);
// symmetry is a comment "meso_mesh symmetry 4". Atomic. Throws std::logic_error for lists of other lengths,
// Error(kCannotWrite).
void writeMesoMesh(const std::filesystem::path& path, const MesoMesh& meso_mesh);

// What writeMesoMesh wrote, bit for bit. Throws Error(kBadInput) naming file and element as readPly does; and
// for a file without one of those properties or the comment, a tangent that is not of unit length or not
// perpendicular to the normal to within 0.1%, a patch coordinate outside of [0, 1), a material that has no
// name.
MesoMesh readMesoMesh(const std::filesystem::path& path);

// Whether the file is a PLY that says it is a meso-mesh. False for what is no PLY or damaged.
bool isMesoMesh(const std::filesystem::path& path);

}  // namespace bakelight::formats
