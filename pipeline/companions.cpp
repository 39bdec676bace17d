#include "pipeline/companions.h"

#include <functional>
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

std::vector<std::string> namesIn(const fs::path& folder, const Disk& disk) {
  try {
    return disk.list(folder.empty() ? "." : folder);
  } catch (const Error&) {
    return {};  // there is none
  }
}

std::string hashOfNames(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all.append(name).append("\n");
  return formats::contentHash(all);
}

// Remembers what it was asked for: which file a name means can change when another one appears.
class LookupOn : public formats::FileLookup {
 public:
  explicit LookupOn(const Disk& disk) : disk_(disk) {}
  bool isFile(const fs::path& path) const override {
    const bool there = disk_.isFile(path);
    files_[path.string()] = there;
    return there;
  }
  std::string read(const fs::path& path) const override { return disk_.read(path); }
  std::vector<std::string> list(const fs::path& folder) const override {
    std::vector<std::string> names = namesIn(folder, disk_);
    folders_[folder.string()] = hashOfNames(names);
    return names;
  }
  Json seen() const { return {{"files", files_}, {"folders", folders_}}; }

 private:
  const Disk& disk_;
  mutable Json files_ = Json::object(), folders_ = Json::object();
};

// Whether all that a lookup has seen is as it was.
bool isAsSeen(const Json& seen, const Disk& disk) {
  for (const auto& [path, there] : seen.at("files").items())
    if (disk.isFile(path) != there.get<bool>()) return false;
  for (const auto& [folder, names] : seen.at("folders").items())
    if (hashOfNames(namesIn(folder, disk)) != names.get<std::string>()) return false;
  return true;
}

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
  collect(document, "punctual", "image", names);
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

// Calls rename(name) for each file that the text names.
void renameFiles(Json& value, const std::function<std::string(const std::string&)>& rename) {
  if (!value.is_structured()) return;
  for (auto& [key, member] : value.items())
    if (key == "file" && member.is_string())
      member = rename(member.get<std::string>());
    else
      renameFiles(member, rename);
}

}  // namespace

std::string hashWithNamedFiles(const Json& value, const Disk& disk, Memo& memo) {
  Json by_content = value;
  renameFiles(by_content,
              [&](const std::string& file) { return hashWithCompanions(fs::path(file), disk, memo); });
  return formats::contentHash(by_content.dump(-1, ' ', false, Json::error_handler_t::replace));
}

Json withAbsolutePaths(Json value) {
  renameFiles(value, [](const std::string& file) { return fs::absolute(file).lexically_normal().string(); });
  return value;
}

std::string hashWithCompanions(const fs::path& path, const Disk& disk, Memo& memo) {
  const std::string own = memo.hashOf(path), key = "companions of " + path.lexically_normal().string();
  // Which files are named can change only with one of those that were looked into or looked for.
  if (const auto known = memo.answer(key)) {
    try {
      if (known->at("own") == own && isAsSeen(known->at("seen"), disk) &&
          known->at("all") == combined(own, path, pathsFrom(known->at("files")), disk, memo))
        return known->at("all").get<std::string>();
    } catch (const Json::exception&) {
      // Damaged: found out again.
    }
  }
  const bool is_rig = formats::lowerEnding(path) == ".json";
  const LookupOn lookup(disk);
  const auto files = is_rig ? rigCompanions(path, disk) : formats::meshCompanions(path, lookup);
  const std::string all = combined(own, path, files, disk, memo);
  memo.rememberAnswer(key, {{"own", own}, {"all", all}, {"files", namesOf(files)}, {"seen", lookup.seen()}});
  return all;
}

}  // namespace bakelight::pipeline
