#include "pipeline/cache.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

constexpr const char* kManifest = "entry.json";
constexpr const char* kTemporaryPrefix = "tmp-";
constexpr std::int64_t kAbandonedAfter_ns = std::chrono::nanoseconds(std::chrono::hours(7 * 24)).count();

Json toJson(const CachedFile& file) {
  return {{"file", file.name}, {"bytes", file.bytes}, {"hash", file.hash}};
}

CachedFile fileFromJson(const Json& json) {
  return {json.at("file"), json.at("bytes"), json.at("hash")};
}

std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool isRunning(long process) {
  return ::kill(static_cast<pid_t>(process), 0) == 0 || errno != ESRCH;
}

// "@host-process": what the owner's temporaries have after the key. "@" is in no key.
std::string mark(const Owner& owner) {
  return "@" + owner.host + "-" + std::to_string(owner.process);
}

}  // namespace

Owner Owner::thisProcess() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name = {"unknown"};
  Owner owner{name.data(), ::getpid()};
  for (char& c : owner.host)
    if (c == '/') c = '_';
  return owner;
}

Cache::Cache(fs::path folder, Disk& disk, Memo& memo, Owner owner)
    : folder_(std::move(folder)), disk_(disk), memo_(memo), owner_(std::move(owner)) {}

fs::path Cache::folderOf(const std::string& key) const {
  return folder_ / key.substr(0, 2) / key;
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
  const std::string name = kTemporaryPrefix + key + mark(owner_);
  // An earlier process of the same number may have left one behind.
  int count = 0;
  fs::path folder;
  do folder = folder_ / (name + "-" + std::to_string(count++));
  while (disk_.stat(folder));
  disk_.makeFolders(folder);
  started_[key] = folder;
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
  const fs::path temporary = started_.at(key);
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
  if (Lookup other = find(key); other.entry) {
    dropEntry(key);
    return *std::move(other.entry);
  }
  disk_.removeAll(entry.folder);  // a damaged one, if any
  disk_.rename(temporary, entry.folder);
  started_.erase(key);
  memo_.remember(entry.pathOf(entry.stats), entry.stats.hash);
  for (const auto& [port, file] : entry.outputs) memo_.remember(entry.pathOf(file), file.hash);
  return entry;
}

void Cache::dropEntry(const std::string& key) {
  const auto started = started_.find(key);
  if (started == started_.end()) return;
  disk_.removeAll(started->second);
  started_.erase(started);
}

bool Cache::isAbandoned(const std::string& temporary) const {
  const std::string ours = "@" + owner_.host + "-";
  const std::size_t at = temporary.find(ours);
  if (at != std::string::npos) {
    long process = 0;
    const char* const end = temporary.data() + temporary.size();
    const auto parsed = std::from_chars(temporary.data() + at + ours.size(), end, process);
    if (parsed.ec == std::errc() && process > 0 && parsed.ptr != end && *parsed.ptr == '-' &&
        !isRunning(process))
      return true;
  }
  const auto stat = disk_.stat(folder_ / temporary);
  return stat && disk_.now_ns() - stat->mtime_ns > kAbandonedAfter_ns;
}

void Cache::removeTemporaries() {
  if (!disk_.isFolder(folder_)) return;
  for (const std::string& name : disk_.list(folder_))
    if (name.starts_with(kTemporaryPrefix) && isAbandoned(name)) disk_.removeAll(folder_ / name);
}

}  // namespace bakelight::pipeline
