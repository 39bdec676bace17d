#include "formats/ply_textures.h"

#include "formats/error.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

constexpr const char* kTextureComment = "TextureFile";

}  // namespace

std::vector<std::string> plyTextureNames(const PlyHeader& header) {
  std::vector<std::string> names;
  for (const std::string& comment : header.comments) {
    std::string_view rest = comment;
    if (equalIgnoringCase(takeWord(rest), kTextureComment)) names.emplace_back(trimmed(rest));
  }
  return names;
}

std::vector<fs::path> plyTextures(std::span<const std::byte> bytes, const fs::path& file,
                                  const FileLookup& files) {
  std::vector<fs::path> result;
  bytes =
      bytes.last(withoutByteOrderMark({reinterpret_cast<const char*>(bytes.data()), bytes.size()}).size());
  try {
    for (const std::string& name : plyTextureNames(readPlyHeader(bytes, file.string()))) {
      const auto found = findNamedFile(files, file.parent_path(), name);
      result.push_back(found ? found->path : plainPathOf(file.parent_path(), name));
    }
  } catch (const Error&) {
    // The importer will say what is wrong with it.
  }
  return result;
}

}  // namespace bakelight::formats
