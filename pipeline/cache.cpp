#include "pipeline/cache.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

constexpr const char* kManifest = "entry.json";
constexpr const char* kTemporaryPrefix = "tmp-";

Json toJson(const CachedFile& file) {
  return {{"file", file.name}, {"bytes", file.bytes}, {"hash", file.hash}};
}

CachedFile fileFromJson(const Json& json) {
  return {json.at("file"), json.at("bytes"), json.at("hash")};
}

std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

Cache::Cache(fs::path folder, Disk& disk, Memo& memo)
    : folder_(std::move(folder)), disk_(disk), memo_(memo) {}

fs::path Cache::folderOf(const std::string& key) const {
  return folder_ / key.substr(0, 2) / key;
}
fs::path Cache::temporaryOf(const std::string& key) const {
  return folder_ / (kTemporaryPrefix + key);
}

Lookup Cache::find(const std::string& key) const {
  const fs::path folder = folderOf(key), manifest = folder / kManifest;
  if (!disk_.isFile(manifest)) return {std::nullopt, disk_.isFolder(folder) ? "entry.json is missing" : ""};
  CacheEntry entry{.key = key, .folder = folder};
  try {
    const Json json = Json::parse(disk_.read(manifest));
    for (const auto& [port, file] : json.at("outputs").items()) entry.outputs[port] = fileFromJson(file);
    entry.stats = fileFromJson(json.at("stats"));
    entry.run = formats::stageRecordFromJson(json.at("run"), manifest.string());
  } catch (const std::exception&) {
    return {std::nullopt, "entry.json is damaged"};
  }
  std::string damage = damageOf(entry);
  if (!damage.empty()) return {std::nullopt, std::move(damage)};
  return {std::move(entry), ""};
}

std::string Cache::damageOf(const CacheEntry& entry) const {
  std::vector<const CachedFile*> files = {&entry.stats};
  for (const auto& [port, file] : entry.outputs) files.push_back(&file);
  for (const CachedFile* file : files) {
    const auto stat = disk_.stat(entry.pathOf(*file));
    if (!stat) return file->name + " is missing";
    if (stat->bytes != file->bytes || memo_.hashOf(entry.pathOf(*file)) != file->hash)
      return file->name + " is damaged";
  }
  return "";
}

void Cache::readStats(const fs::path& path, formats::StageRecord& run) const {
  formats::StageRecord told =
      formats::stageRecordFromJson(formats::parseJson(disk_.read(path), path.string()), path.string());
  run.tool = std::move(told.tool);
  run.warnings = std::move(told.warnings);
  run.stats = std::move(told.stats);
}

fs::path Cache::startEntry(const std::string& key) {
  const fs::path folder = temporaryOf(key);
  disk_.removeAll(folder);
  disk_.makeFolders(folder);
  return folder;
}

CachedFile Cache::examined(const fs::path& folder, const std::string& name) const {
  const auto stat = disk_.stat(folder / name);
  if (!stat || stat->folder)
    throw badInput({(folder / name).string(), "", ""}, "the tool ended well but did not write this file", "",
                   "report this as a bug of the tool");
  return {name, stat->bytes, disk_.hash(folder / name)};
}

CacheEntry Cache::finishEntry(const std::string& key, const Ingredients& ingredients,
                              formats::StageRecord run) {
  const fs::path temporary = temporaryOf(key);
  CacheEntry entry{.key = key, .folder = folderOf(key), .run = std::move(run)};
  Json outputs = Json::object();
  for (const auto& [port, name] : ingredients.outputs) {
    entry.outputs[port] = examined(temporary, name);
    outputs[port] = toJson(entry.outputs[port]);
  }
  entry.stats = examined(temporary, kStatsFile);
  readStats(temporary / kStatsFile, entry.run);
  disk_.write(temporary / kManifest, dump({{"key", key},
                                           {"ingredients", toJson(ingredients)},
                                           {"outputs", std::move(outputs)},
                                           {"stats", toJson(entry.stats)},
                                           {"run", formats::toJson(entry.run)}}));
  disk_.removeAll(entry.folder);  // a damaged one, if any
  disk_.rename(temporary, entry.folder);
  memo_.remember(entry.pathOf(entry.stats), entry.stats.hash);
  for (const auto& [port, file] : entry.outputs) memo_.remember(entry.pathOf(file), file.hash);
  return entry;
}

void Cache::dropEntry(const std::string& key) {
  disk_.removeAll(temporaryOf(key));
}

void Cache::removeTemporaries() {
  if (!disk_.isFolder(folder_)) return;
  for (const std::string& name : disk_.list(folder_))
    if (name.starts_with(kTemporaryPrefix)) disk_.removeAll(folder_ / name);
}

}  // namespace bakelight::pipeline
