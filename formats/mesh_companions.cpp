#include "formats/mesh_companions.h"

#include <algorithm>
#include <span>
#include <string>

#include "formats/file.h"
#include "formats/gltf_uri.h"
#include "formats/obj_materials.h"
#include "formats/obj_statements.h"
#include "formats/ply_textures.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace fs = std::filesystem;

std::vector<fs::path> meshCompanions(const fs::path& mesh, const FileLookup& files) {
  const std::string ending = lowerEnding(mesh);
  const bool is_gltf = ending == ".gltf" || ending == ".glb";
  if (ending != ".obj" && ending != ".ply" && !is_gltf) return {};
  std::string text = files.read(mesh);
  const fs::path folder = mesh.parent_path();
  std::vector<fs::path> companions;
  if (is_gltf) {
    for (const fs::path& path : gltfCompanions(std::as_bytes(std::span(text))))
      companions.push_back(folder / path);
  } else {
    if (auto converted = utf8FromUtf16(text)) text = std::move(*converted);
    companions = ending == ".obj" ? filesOfLibraries(objLibraries(text), folder, files)
                                  : plyTextures(std::as_bytes(std::span(text)), mesh, files);
  }
  std::sort(companions.begin(), companions.end());
  companions.erase(std::unique(companions.begin(), companions.end()), companions.end());
  return companions;
}

}  // namespace bakelight::formats
