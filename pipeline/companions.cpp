#include "pipeline/companions.h"

#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "formats/file.h"
#include "formats/gltf_uri.h"
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

bool isGltf(const fs::path& path) {
  const std::string ending = formats::lowerEnding(path);
  return ending == ".gltf" || ending == ".glb";
}

// Relative to the file that they stand in.
std::set<std::string> companionsIn(const std::string& content, bool is_gltf) {
  std::set<std::string> files;
  if (is_gltf) {
    for (const fs::path& file : formats::gltfCompanions(std::as_bytes(std::span(content))))
      files.insert(file.string());
  } else {  // docs/LIGHTS.md
    const Json document = Json::parse(content, nullptr, false, /*ignore_comments=*/true);
    collect(document, "lights", "image", files);
    collect(document, "emitters", "mesh", files);
  }
  return files;
}

}  // namespace

std::string hashWithCompanions(const fs::path& path, const Disk& disk, Memo& memo) {
  const std::string own = memo.hashOf(path), ending = formats::lowerEnding(path);
  if (!isGltf(path) && ending != ".json") return own;
  std::string all = own;
  for (const std::string& file : companionsIn(disk.read(path), isGltf(path))) {
    const fs::path companion = path.parent_path() / file;
    // A mesh of a rig may have companions of its own; a rig cannot be one.
    const bool nested = ending == ".json" && isGltf(companion);
    all += "\n" + file + " " +
           (!disk.isFile(companion) ? "missing"
            : nested                ? hashWithCompanions(companion, disk, memo)
                                    : memo.hashOf(companion));
  }
  return all == own ? own : formats::contentHash(all);
}

}  // namespace bakelight::pipeline
