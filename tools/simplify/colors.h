// Albedo carried from the original surface to the simplified one: from vertex colours and materials'
// textures.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/mesh_import.h"
#include "formats/triangle_mesh.h"

namespace bakelight::simplify {

// Puts one picture on the whole of the mesh, in place of all its textures and colours. What it replaces is
// told. Throws Error(kBadInput) naming `file` if the mesh has no texture coordinates.
std::vector<std::string> replaceAlbedo(formats::MeshImport& source, const std::filesystem::path& texture,
                                       const std::string& file);

struct CarriedAlbedo {
  std::vector<formats::Float3> colors;  // empty if the source has neither colours nor textures
  std::vector<std::string> notes;       // texels that were clamped
};

// Linear albedo at the vertices of `simplified`, 0–1: the mean over the triangles around each, weighted by
// its hat function, of the colour at the closest point of `source` that has the triangle's material; so
// textures are filtered down to the vertices' density, and colours end at borders between materials where
// these have vertices of their own. The colour is that of the source's vertices times the material's texture.
// Throws Error(kBadInput) as readAlbedoTexture (albedo_map.h) does, for textures of materials in use, `file`
// being the mesh. Deterministic, all TBB threads: about 30 µs a triangle of `simplified` on one.
CarriedAlbedo carryAlbedo(const formats::MeshImport& source, const formats::TriangleMesh& simplified,
                          const std::string& file);

}  // namespace bakelight::simplify
