#include "formats/mesh_import.h"

#include <string_view>

#include "formats/file.h"
#include "formats/mesh_content.h"
#include "formats/mesh_gltf.h"
#include "formats/mesh_module.h"
#include "formats/mesh_obj.h"
#include "formats/mesh_off.h"
#include "formats/mesh_parts.h"
#include "formats/mesh_stl.h"
#include "formats/module.h"
#include "formats/named_file.h"
#include "formats/ply_parts.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

// One reader a format.
MeshParts readParts(const std::filesystem::path& path, const std::string& ending,
                    std::span<const std::byte> bytes) {
  const std::string file = path.string();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (ending == ".obj") return readObj(text, path, filesOnDisk());
  if (ending == ".ply")
    return readPlyParts(bytes.last(withoutByteOrderMark(text).size()), path, filesOnDisk());
  if (ending == ".stl") return readStl(bytes, file);
  if (ending == ".off") return readOff(bytes, file);
  static const auto* readers =
      static_cast<const MeshReaders*>(moduleEntry("meshes", "bakelight_mesh_readers"));
  return readers->read_with_assimp(path);
}

bool mayBeText(const std::string& ending) {
  return ending == ".obj" || ending == ".ply" || ending == ".stl" || ending == ".off";
}

}  // namespace

MeshImport importMesh(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  const std::string ending = lowerEnding(path);
  checkMeshContent(bytes, ending, path.string());
  if (ending == ".gltf" || ending == ".glb") return merged(readGltf(path, bytes), path.string());
  if (mayBeText(ending)) {
    const auto converted = utf8FromUtf16({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (converted)
      return merged(readParts(path, ending, std::as_bytes(std::span(*converted))), path.string());
  }
  return merged(readParts(path, ending, bytes), path.string());
}

const std::vector<std::string>& meshFileEndings() {
  static const std::vector<std::string> endings = {".obj", ".ply", ".stl", ".off", ".gltf",
                                                   ".glb", ".3ds", ".dae", ".fbx"};
  return endings;
}

}  // namespace bakelight::formats
