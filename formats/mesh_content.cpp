#include "formats/mesh_content.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

struct Archive {
  std::string_view begin;
  const char* name;
};
constexpr Archive kArchives[] = {{{"PK\x03\x04", 4}, "a zip archive"},
                                 {{"\x1F\x8B", 2}, "a gzip archive"},
                                 {{"BZh", 3}, "a bzip2 archive"},
                                 {{"\xFD"
                                   "7zXZ\0",
                                   6},
                                  "an xz archive"},
                                 {{"7z\xBC\xAF\x27\x1C", 6}, "a 7-Zip archive"},
                                 {{"Rar!", 4}, "a RAR archive"},
                                 {{"\x28\xB5\x2F\xFD", 4}, "a Zstandard archive"}};

// Formats that say in their first bytes what they are, and the endings they go by.
struct Format {
  std::string_view begin;
  const char* name;
  std::vector<std::string> endings;
};

const std::vector<Format>& formatsWithMarks() {
  static const std::vector<Format> formats = {{"glTF", "a binary glTF file", {".glb", ".gltf"}},
                                              {"ply\n", "a PLY file", {".ply"}},
                                              {"ply\r", "a PLY file", {".ply"}},
                                              {"OFF\n", "an OFF file", {".off"}},
                                              {"OFF\r", "an OFF file", {".off"}},
                                              {"Kaydara FBX Binary", "an FBX file", {".fbx"}},
                                              {"\x89PNG", "a PNG picture", {}},
                                              {"\xFF\xD8\xFF", "a JPEG picture", {}},
                                              {"%PDF", "a PDF document", {}},
                                              {"BLENDER", "a Blender file", {}}};
  return formats;
}

}  // namespace

void checkMeshContent(std::span<const std::byte> bytes, const std::string& ending, const std::string& file) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    return badInput({file, "", ""}, what, "a mesh file", remedy);
  };
  if (bytes.empty()) throw refuse("it is empty", "copy or export the file again");
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("version https://git-lfs"))
    throw refuse("it is a pointer of Git LFS, which stands in the file's place until that is fetched",
                 "git lfs pull, in the folder that the file comes from");
  // Others are left to assimp, which knows formats that are archives.
  const auto& endings = meshFileEndings();
  if (std::find(endings.begin(), endings.end(), ending) == endings.end()) return;
  const std::string_view words = trimmed(withoutByteOrderMark(text.substr(0, 1024)));
  if (startsIgnoringCase(words, "<!doctype html") || startsIgnoringCase(words, "<html"))
    throw refuse("it is a web page", "download the file that the page offers");
  for (const Archive& archive : kArchives)
    if (text.starts_with(archive.begin))
      throw refuse(std::string("it is ") + archive.name, "unpack it, and take the mesh file inside");
  for (const Format& format : formatsWithMarks()) {
    if (!text.starts_with(format.begin)) continue;
    if (std::find(format.endings.begin(), format.endings.end(), ending) != format.endings.end()) continue;
    throw refuse(std::string("it is ") + format.name + " under the ending of another",
                 format.endings.empty() ? "a mesh file" : "rename it to end in " + format.endings[0]);
  }
}

}  // namespace bakelight::formats
