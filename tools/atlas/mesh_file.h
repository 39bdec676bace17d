// Meshes as the tools of this room take them: files of any format.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::atlas {

struct MeshFile {
  formats::TriangleMesh mesh;
  std::vector<std::array<std::uint32_t, 2>> marked_edges;  // of a PLY like those between stages, else none
  std::vector<std::string> notes;                          // of the import
};

// A PLY like those between stages keeps its vertices as they are (formats::readPly), all else is imported.
// Throws as formats::importMesh does.
MeshFile readMeshFile(const std::filesystem::path& path);

}  // namespace bakelight::atlas
