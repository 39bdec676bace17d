// Outputs by the hash of what they are made from: <folder>/<aa>/<key>/ holds the outputs, stats.json and
// entry.json. An entry is made under a temporary name and renamed into place, so it is whole or not there;
// entry.json tells whether it still is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "formats/stage_record.h"
#include "pipeline/disk.h"
#include "pipeline/ingredients.h"
#include "pipeline/memo.h"

namespace bakelight::pipeline {

inline constexpr const char* kStatsFile = "stats.json";

struct CachedFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::string hash;
};

struct CacheEntry {
  std::string key;
  std::filesystem::path folder;
  std::map<std::string, CachedFile> outputs = {};  // by port
  CachedFile stats = {};
  formats::StageRecord run = {};  // figures of the run that made it

  std::filesystem::path pathOf(const CachedFile& file) const { return folder / file.name; }
};

// What asking the cache came to.
struct Lookup {
  std::optional<CacheEntry> entry;
  std::string damage;  // why there is an entry but none to use: "mesh.ply is damaged"; else ""
};

class Cache {
 public:
  Cache(std::filesystem::path folder, Disk& disk, Memo& memo);

  // Checks sizes, and content where a file was touched since it was last checked.
  Lookup find(const std::string& key) const;

  // An empty folder for a stage to write into.
  std::filesystem::path startEntry(const std::string& key);
  // Puts what is in startEntry's folder in place. Of `run` time and memory count, as measured from outside;
  // the rest is read from stats.json. Throws Error(kBadInput) if an output is missing or stats.json is
  // damaged, Error(kCannotWrite).
  CacheEntry finishEntry(const std::string& key, const Ingredients& ingredients, formats::StageRecord run);
  // If another process has finished the same key by then, its entry is returned and this one dropped.
  void dropEntry(const std::string& key);  // gives up what startEntry began

  // What interrupted processes left behind: of this machine's processes that have ended, and what is a day
  // old. Never what a living process of this machine fills, so it is safe on file systems without locks, too.
  void removeTemporaries();

 private:
  std::filesystem::path folderOf(const std::string& key) const;
  std::optional<CacheEntry> finishedByAnother(const std::string& key, const std::filesystem::path& temporary);
  CachedFile examined(const std::filesystem::path& folder, const std::string& name) const;
  std::string damageOf(const CacheEntry& entry) const;
  void readStats(const std::filesystem::path& path, formats::StageRecord& run) const;

  std::filesystem::path folder_;
  Disk& disk_;
  Memo& memo_;
  std::map<std::string, std::filesystem::path> temporaries_;  // of entries that are being made, by key
};

}  // namespace bakelight::pipeline
