#include "pipeline/cache.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

constexpr const char* kManifest = "entry.json";
constexpr const char* kTemporaryPrefix = "tmp-";
constexpr std::int64_t kDay_ns = 86'400'000'000'000;

Json toJson(const CachedFile& file) {
  return {{"file", file.name}, {"bytes", file.bytes}, {"hash", file.hash}};
}

CachedFile fileFromJson(const Json& json) {
  return {json.at("file"), json.at("bytes"), json.at("hash")};
}

const std::string& hostName() {
  static const std::string name = [] {
    std::array<char, 256> text{};
    ::gethostname(text.data(), text.size() - 1);
    std::string host = text.data();
    std::replace(host.begin(), host.end(), '/', '_');
    return host;
  }();
  return name;
}

// "tmp-<key>-<host>-<process>-<count>": no two processes fill the same folder, whether or not the file system
// has locks, and it can be told whose one is.
std::string newTemporaryName(const std::string& key) {
  static std::atomic<unsigned> count{0};
  return kTemporaryPrefix + key + "-" + hostName() + "-" + std::to_string(::getpid()) + "-" +
         std::to_string(count++);
}

// The process of this machine that a temporary folder's name tells of; 0 for another machine's.
pid_t ownerOf(const std::string& name) {
  const std::size_t last = name.rfind('-'), middle = name.rfind('-', last - 1);
  const std::size_t key = name.find('-', std::char_traits<char>::length(kTemporaryPrefix));
  if (last == std::string::npos || middle == std::string::npos || key >= middle) return 0;
  if (name.substr(key + 1, middle - key - 1) != hostName()) return 0;
  pid_t process = 0;
  const auto parsed = std::from_chars(name.data() + middle + 1, name.data() + last, process);
  return parsed.ec == std::errc() && parsed.ptr == name.data() + last && process > 0 ? process : 0;
}

bool isLeftBehind(const std::string& name, const std::optional<FileStat>& stat, std::int64_t now_ns) {
  if (const pid_t owner = ownerOf(name); owner > 0) return ::kill(owner, 0) != 0 && errno == ESRCH;
  return stat && now_ns - stat->mtime_ns > kDay_ns;
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
  const fs::path folder = folder_ / newTemporaryName(key);
  disk_.makeFolders(folder);
  temporaries_[key] = folder;
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
  const fs::path temporary = temporaries_.at(key);
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
  if (auto theirs = finishedByAnother(key, temporary)) return *theirs;
  disk_.removeAll(entry.folder);  // a damaged one, if any
  try {
    disk_.rename(temporary, entry.folder);
  } catch (const Error&) {
    if (auto theirs = finishedByAnother(key, temporary)) return *theirs;
    throw;
  }
  temporaries_.erase(key);
  memo_.remember(entry.pathOf(entry.stats), entry.stats.hash);
  for (const auto& [port, file] : entry.outputs) memo_.remember(entry.pathOf(file), file.hash);
  return entry;
}

void Cache::dropEntry(const std::string& key) {
  const auto temporary = temporaries_.find(key);
  if (temporary == temporaries_.end()) return;
  disk_.removeAll(temporary->second);
  temporaries_.erase(temporary);
}

std::optional<CacheEntry> Cache::finishedByAnother(const std::string& key, const fs::path& temporary) {
  std::optional<CacheEntry> theirs = find(key).entry;
  if (!theirs) return std::nullopt;
  disk_.removeAll(temporary);
  temporaries_.erase(key);
  return theirs;
}

void Cache::removeTemporaries() {
  if (!disk_.isFolder(folder_)) return;
  for (const std::string& name : disk_.list(folder_))
    if (name.starts_with(kTemporaryPrefix) && isLeftBehind(name, disk_.stat(folder_ / name), disk_.now_ns()))
      disk_.removeAll(folder_ / name);
}

}  // namespace bakelight::pipeline
