// Binary little-endian PLY, the mesh file between stages: MeshLab, Blender and assimp open it.
//
// The reader is our own and strict, as assimp's PLY reader does not keep the order of shared vertices and
// repairs silently; a per-vertex table baked beside a mesh needs both order and bits kept.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Properties: x y z, then nx ny nz if there are normals, then s t if there are texcoords, then
// red green blue (linear albedo) if there are colours, all float32; faces
// as `list uchar uint vertex_indices`, then `uint material_index` if there are materials, whose names are
// comments of the header (ply_materials.h). Atomic. Throws Error(kCannotWrite).
void writePly(const std::filesystem::path& path, const TriangleMesh& mesh);

// Reads what writePly wrote, bit for bit and in the same order, and tolerates further properties and
// elements. Throws Error(kBadInput) naming file and element: not a PLY, truncated, not little-endian binary,
// an index out of range (of a material, too), a polygon, a position that is not finite, a normal
// that is not of unit length to within 0.1%.
TriangleMesh readPly(const std::filesystem::path& path);

// Whether the file is a PLY with nothing in it but what readPly reads: another program's may hold colours of
// 8 bits, texture coordinates under other names or of face corners, which importMesh reads. False for what is
// no PLY or damaged.
bool isStagePly(const std::filesystem::path& path);

// Pairs of vertices from the file's `element edge` (integers vertex1 and vertex2), as MeshLab and Blender
// write marked edges; none if it has no such element. Throws like readPly, also for a vertex out of range.
std::vector<std::array<std::uint32_t, 2>> readPlyEdges(const std::filesystem::path& path);

// Names positions, normals and triangles (values and order) in 32 hex digits. What was baked for one mesh
// carries it, so that it is never put on another. Texture coordinates, colours and materials do not
// count.
std::string geometryHash(const TriangleMesh& mesh);

}  // namespace bakelight::formats
