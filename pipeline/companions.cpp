#include "pipeline/companions.h"

#include <nlohmann/json.hpp>
#include <set>

#include "formats/hash.h"
#include "formats/json.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

// The texts under `key` in the elements of the list `section`.
void collect(const Json& document, const char* section, const char* key, std::set<std::string>& texts) {
  if (!document.is_object() || !document.contains(section)) return;
  for (const Json& element : document[section])
    if (element.is_object() && element.contains(key) && element[key].is_string()) {
      const std::string text = element[key];
      if (!text.starts_with("data:")) texts.insert(text);  // embedded
    }
}

// Relative to the file that they stand in.
std::set<std::string> companionsIn(const Json& document, const std::string& ending) {
  std::set<std::string> files;
  if (ending == ".gltf") {  // glTF 2.0, 3.6.1.1 and 3.8.4
    collect(document, "buffers", "uri", files);
    collect(document, "images", "uri", files);
  } else {  // docs/LIGHTS.md
    collect(document, "lights", "image", files);
    collect(document, "emitters", "mesh", files);
  }
  return files;
}

}  // namespace

std::string hashWithCompanions(const fs::path& path, const Disk& disk, Memo& memo) {
  const std::string own = memo.hashOf(path), ending = path.extension().string();
  if (ending != ".gltf" && ending != ".json") return own;
  std::string all = own;
  const Json document = Json::parse(disk.read(path), nullptr, false, /*ignore_comments=*/true);
  for (const std::string& file : companionsIn(document, ending)) {
    const fs::path companion = path.parent_path() / file;
    // A mesh of a rig may have companions of its own; a rig cannot be one.
    const bool nested = ending == ".json" && companion.extension() == ".gltf";
    all += "\n" + file + " " +
           (!disk.isFile(companion) ? "missing"
            : nested                ? hashWithCompanions(companion, disk, memo)
                                    : memo.hashOf(companion));
  }
  return all == own ? own : formats::contentHash(all);
}

}  // namespace bakelight::pipeline
