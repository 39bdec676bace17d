#include "pipeline/companions.h"

#include <nlohmann/json.hpp>
#include <set>

#include "formats/hash.h"
#include "formats/json.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

// glTF 2.0, 3.6.1.1 and 3.8.4: "uri" of a buffer or image, relative to the .gltf; "data:" ones are embedded.
std::set<std::string> urisOf(const Json& gltf) {
  std::set<std::string> uris;
  for (const char* section : {"buffers", "images"}) {
    if (!gltf.is_object() || !gltf.contains(section)) continue;
    for (const Json& element : gltf[section])
      if (element.is_object() && element.contains("uri") && element["uri"].is_string()) {
        const std::string uri = element["uri"];
        if (!uri.starts_with("data:")) uris.insert(uri);
      }
  }
  return uris;
}

}  // namespace

std::string hashWithCompanions(const fs::path& path, const Disk& disk, Memo& memo) {
  const std::string own = memo.hashOf(path);
  if (path.extension() != ".gltf") return own;
  std::string all = own;
  for (const std::string& uri : urisOf(Json::parse(disk.read(path), nullptr, false))) {
    const fs::path companion = path.parent_path() / uri;
    all += "\n" + uri + " " + (disk.isFile(companion) ? memo.hashOf(companion) : "missing");
  }
  return all == own ? own : formats::contentHash(all);
}

}  // namespace bakelight::pipeline
