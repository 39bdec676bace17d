#include "pipeline/companions.h"

#include <nlohmann/json.hpp>
#include <set>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/hash.h"
#include "formats/json.h"
#include "formats/mesh_companions.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

class LookupOn : public formats::FileLookup {
 public:
  explicit LookupOn(const Disk& disk) : disk_(disk) {}
  bool isFile(const fs::path& path) const override { return disk_.isFile(path); }
  std::string read(const fs::path& path) const override { return disk_.read(path); }
  std::vector<std::string> list(const fs::path& folder) const override {
    try {
      return disk_.list(folder.empty() ? "." : folder);
    } catch (const Error&) {
      return {};  // there is none
    }
  }

 private:
  const Disk& disk_;
};

// The texts under `key` in the elements of the list `section`.
void collect(const Json& document, const char* section, const char* key, std::set<std::string>& texts) {
  if (!document.is_object() || !document.contains(section)) return;
  for (const Json& element : document[section])
    if (element.is_object() && element.contains(key) && element[key].is_string())
      texts.insert(element[key].get<std::string>());
}

// docs/LIGHTS.md
std::vector<fs::path> rigCompanions(const fs::path& rig, const Disk& disk) {
  const Json document = Json::parse(disk.read(rig), nullptr, false, /*ignore_comments=*/true);
  std::set<std::string> names;
  collect(document, "lights", "image", names);
  collect(document, "emitters", "mesh", names);
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(rig.parent_path() / name);
  return files;
}

// `own` with the hashes of the companions at `files`. By their places beside `path`, so that a folder that
// moves as a whole stays the same.
std::string combined(const std::string& own, const fs::path& path, const std::vector<fs::path>& files,
                     const Disk& disk, Memo& memo) {
  const bool is_rig = formats::lowerEnding(path) == ".json";
  std::string all = own;
  for (const fs::path& companion : files) {
    // A mesh of a rig may have companions of its own; a rig cannot be one.
    const bool nested = is_rig && formats::lowerEnding(companion) != ".json";
    all.append("\n").append(companion.lexically_relative(path.parent_path()).generic_string()).append(" ");
    all.append(!disk.isFile(companion) ? "missing"
               : nested                ? hashWithCompanions(companion, disk, memo)
                                       : memo.hashOf(companion));
  }
  return all == own ? own : formats::contentHash(all);
}

std::vector<fs::path> pathsFrom(const Json& names) {
  std::vector<fs::path> files;
  for (const Json& name : names) files.emplace_back(name.get<std::string>());
  return files;
}

Json namesOf(const std::vector<fs::path>& files) {
  Json names = Json::array();
  for (const fs::path& file : files) names.push_back(file.string());
  return names;
}

}  // namespace

std::string hashWithCompanions(const fs::path& path, const Disk& disk, Memo& memo) {
  const std::string own = memo.hashOf(path), key = "companions of " + path.lexically_normal().string();
  // Which files are named can change only with one of those that were looked into.
  if (const auto known = memo.answer(key)) {
    try {
      if (known->at("own") == own &&
          known->at("all") == combined(own, path, pathsFrom(known->at("files")), disk, memo))
        return known->at("all").get<std::string>();
    } catch (const Json::exception&) {
      // Damaged: found out again.
    }
  }
  const bool is_rig = formats::lowerEnding(path) == ".json";
  const auto files = is_rig ? rigCompanions(path, disk) : formats::meshCompanions(path, LookupOn(disk));
  const std::string all = combined(own, path, files, disk, memo);
  memo.rememberAnswer(key, {{"own", own}, {"all", all}, {"files", namesOf(files)}});
  return all;
}

}  // namespace bakelight::pipeline
