#include "tools/inspect/file_kind.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json.h"
#include "formats/mesh_import.h"
#include "formats/meso_mesh.h"
#include "formats/radiance_transfer_texture.h"
#include "tools/inspect/patch_preview.h"

namespace bakelight::inspect {
namespace {

const std::vector<std::string>& imageEndings() {
  static const std::vector<std::string> endings = {".exr", ".hdr", ".png", ".jpg", ".jpeg", ".tif", ".tiff"};
  return endings;
}

bool contains(const std::vector<std::string>& endings, const std::string& ending) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

std::string listed(const std::vector<std::string>& endings) {
  std::string text;
  for (const std::string& ending : endings) text += (text.empty() ? "" : " ") + ending;
  return text;
}

// A pack says so by name in its JSON chunk, which stands before all binary data.
bool isPack(const std::filesystem::path& path) {
  const formats::Bytes bytes = formats::readFile(path);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("glTF") && text.find("BAKELIGHT_radiance_transfer") != std::string_view::npos;
}

// A record says which tool or asset it is of; a material has some of its own members, and it may be empty.
bool isMaterial(const std::filesystem::path& path) {
  const formats::Json json = formats::readJson(path);
  if (!json.is_object() || json.contains("tool") || json.contains("asset")) return false;
  const auto has = [&](const char* name) { return json.contains(name); };
  return json.empty() || has("albedo") || has("reflection") || has("medium") || has("material") ||
         has("materials");
}

}  // namespace

const char* nameOf(FileKind kind) {
  switch (kind) {
    case FileKind::kMesh:
      return "mesh";
    case FileKind::kImage:
      return "image";
    case FileKind::kTensors:
      return "tensors";
    case FileKind::kPack:
      return "pack";
    case FileKind::kMaterial:
      return "material";
    case FileKind::kRecord:
      return "record";
    case FileKind::kMesoMesh:
      return "meso_mesh";
    case FileKind::kIdMap:
      return "id_map";
    case FileKind::kBtf:
      return "btf";
    case FileKind::kRtt:
      return "rtt";
  }
  return "";
}

FileKind kindOfFile(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return FileKind::kBtf;
  if (!std::filesystem::is_regular_file(path))
    throw badInput({path.string(), "", ""}, "there is no such file", "a file to look into");
  const std::string ending = formats::lowerEnding(path);
  if (ending == ".glb" && isPack(path)) return FileKind::kPack;
  if (ending == ".ply" && formats::isMesoMesh(path)) return FileKind::kMesoMesh;
  if (ending == ".exr" && isIdMap(path)) return FileKind::kIdMap;
  if (ending == ".exr" && formats::isRadianceTransferTexture(path)) return FileKind::kRtt;
  if (contains(formats::meshFileEndings(), ending)) return FileKind::kMesh;
  if (contains(imageEndings(), ending)) return FileKind::kImage;
  if (ending == ".btf" || ending == ".zip") return FileKind::kBtf;
  if (ending == ".safetensors") return FileKind::kTensors;
  if (ending == ".json") return isMaterial(path) ? FileKind::kMaterial : FileKind::kRecord;
  throw badInput({path.string(), "", ""},
                 ending.empty() ? "its name has no ending that says what it is"
                                : "nothing here opens " + ending + " files",
                 "a mesh (" + listed(formats::meshFileEndings()) + "), an image (" + listed(imageEndings()) +
                     "), .safetensors, a pack (.glb), a BTF (.btf, or a zip or folder of pictures), a "
                     "material (.json), or a stage's stats.json or an "
                     "asset's record.json",
                 "give the file its usual ending");
}

}  // namespace bakelight::inspect
