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
      const bool is_ours = formats::isStagePly(path);
      MeshFile file{{}, formats::readPlyEdges(path), {}};
      // Marked edges go by the file's own numbers of vertices, which the import need not keep.
      if (is_ours || !file.marked_edges.empty()) {
        file.mesh = formats::readPly(path);
        if (!is_ours)
          file.notes.push_back(
              "for the sake of its marked edges only positions, normals, s, t and colours "
              "in floats were read");
        return file;
      }
    } catch (const Error&) {
      // A PLY of another flavour, or one that importMesh has the right words about.
    }
  }
  formats::MeshImport imported = formats::importMesh(path);
  return {std::move(imported.mesh), {}, std::move(imported.notes)};
}

}  // namespace bakelight::atlas
