// In which frames a mesh's vertices see their light, so that it fits the patches laid out over a meso-mesh.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/meso_mesh.h"
#include "formats/triangle_mesh.h"

namespace bakelight::idmap {

// For each vertex of `mesh` the tangent of the meso-vertex that normal shooting finds, made perpendicular to
// the vertex's normal, with w = 1; a vertex that none faces has any tangent. `triangle_materials` as
// IdMapOptions. Throws Error(kBadInput) naming `meso_file` if the tangents are of a symmetry: where frames
// are turned, those of neighbors do not interpolate.
struct PatchFrames {
  std::vector<formats::Float4> tangents;
  std::size_t undetermined = 0;  // vertices that no meso-vertex faces: any tangent
};
PatchFrames patchFrames(const formats::TriangleMesh& mesh, const formats::MesoMesh& meso,
                        const std::vector<std::uint32_t>& triangle_materials, std::size_t neighbors,
                        const std::string& meso_file);

// Tensor "tangent" (n × 4) with the metadata mesh_hash, for transfer.
void writeFrames(const std::filesystem::path& path, const std::vector<formats::Float4>& tangents,
                 const formats::TriangleMesh& mesh);

}  // namespace bakelight::idmap
