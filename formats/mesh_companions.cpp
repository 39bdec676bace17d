#include "formats/mesh_companions.h"

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "formats/file.h"
#include "formats/gltf_uri.h"
#include "formats/obj_materials.h"
#include "formats/obj_statements.h"
#include "formats/ply_textures.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPictureEndings[] = {"png", "jpg",  "jpeg", "tga", "bmp", "tif", "tiff",
                                                "gif", "webp", "dds",  "exr", "hdr", "psd", "jp2"};

// Whether a name cannot contain it in text (XML, ASCII FBX) or binary (control characters end it in FBX and
// 3DS).
bool endsName(char c) {
  return static_cast<unsigned char>(c) < ' ' || std::string_view("\"<>|*?").find(c) != std::string_view::npos;
}

// All names of pictures in a file, whatever its format is.
std::set<std::string> pictureNames(std::string_view text) {
  constexpr std::size_t kLongest = 1024;
  std::set<std::string> names;
  for (std::size_t dot = text.find('.'); dot != std::string_view::npos; dot = text.find('.', dot + 1)) {
    for (const std::string_view ending : kPictureEndings) {
      // What follows may be a letter: in binary FBX the code of the next value.
      if (!equalIgnoringCase(text.substr(dot + 1, ending.size()), ending)) continue;
      std::size_t begin = dot;
      while (begin > 0 && dot - begin < kLongest && !endsName(text[begin - 1])) --begin;
      names.emplace(text.substr(begin, dot + 1 + ending.size() - begin));
    }
  }
  return names;
}

// As text stands in XML, as a URI, or after an ASCII FBX's key: the name may be any of these.
std::vector<fs::path> picturesNamedIn(std::string_view text, const fs::path& folder,
                                      const FileLookup& files) {
  std::vector<fs::path> pictures;
  for (const std::string& name : pictureNames(text)) {
    auto found = findNamedFile(files, folder, name);
    if (!found) found = findNamedFile(files, folder, percentDecoded(name));
    pictures.push_back(found ? found->path : plainPathOf(folder, name));
  }
  return pictures;
}

}  // namespace

std::vector<fs::path> meshCompanions(const fs::path& mesh, const FileLookup& files) {
  const std::string ending = lowerEnding(mesh);
  const bool is_gltf = ending == ".gltf" || ending == ".glb";
  const bool is_other = ending == ".dae" || ending == ".fbx" || ending == ".3ds";
  if (ending != ".obj" && ending != ".ply" && !is_gltf && !is_other) return {};
  std::string text = files.read(mesh);
  const fs::path folder = mesh.parent_path();
  std::vector<fs::path> companions;
  if (is_gltf) {
    for (const fs::path& path : gltfCompanions(std::as_bytes(std::span(text))))
      companions.push_back(folder / path);
  } else if (is_other) {
    if (auto converted = utf8FromUtf16(text); ending == ".dae" && converted) text = std::move(*converted);
    companions = picturesNamedIn(text, folder, files);
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
