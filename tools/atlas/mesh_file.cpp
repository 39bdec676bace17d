#include "tools/atlas/mesh_file.h"

#include <utility>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"

namespace bakelight::atlas {

MeshFile readMeshFile(const std::filesystem::path& path) {
  if (formats::lowerEnding(path) == ".ply") {
    try {
      return {formats::readPly(path), formats::readPlyEdges(path), {}};
    } catch (const Error&) {
      // A PLY of another flavour, or one that importMesh has the right words about.
    }
  }
  formats::MeshImport imported = formats::importMesh(path);
  return {std::move(imported.mesh), {}, std::move(imported.notes)};
}

}  // namespace bakelight::atlas
