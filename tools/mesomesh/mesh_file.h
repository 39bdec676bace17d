// Meshes as this tool takes them: files of any format.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::mesomesh {

struct MeshFile {
  formats::TriangleMesh mesh;
  std::vector<std::string> notes;  // of the import
};

// A PLY like those between stages keeps its vertices as they are (formats::readPly), all else is imported.
// Throws as formats::importMesh does.
MeshFile readMeshFile(const std::filesystem::path& path);

}  // namespace bakelight::mesomesh
