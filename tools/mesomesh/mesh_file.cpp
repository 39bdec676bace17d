#include "tools/mesomesh/mesh_file.h"

#include <utility>

#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"

namespace bakelight::mesomesh {

MeshFile readMeshFile(const std::filesystem::path& path) {
  if (formats::isStagePly(path)) return {formats::readPly(path), {}};
  formats::MeshImport imported = formats::importMesh(path);
  return {std::move(imported.mesh), std::move(imported.notes)};
}

}  // namespace bakelight::mesomesh
