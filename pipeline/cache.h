// Outputs by the hash of what they are made from: <folder>/<aa>/<key>/ holds the outputs, stats.json and
// entry.json. An entry is made under a temporary name and renamed into place, so it is whole or not there;
// entry.json tells whether it still is. Temporary names carry host and process, so that drivers may share the
// folder even where the file system has no locks.
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

// Who makes an entry.
struct Owner {
  std::string host;
  long process = 0;
  static Owner thisProcess();
};

class Cache {
 public:
  Cache(std::filesystem::path folder, Disk& disk, Memo& memo, Owner owner = Owner::thisProcess());

  // Checks sizes, and content where a file was touched since it was last checked.
  Lookup find(const std::string& key) const;

  // An empty folder for a stage to write into.
  std::filesystem::path startEntry(const std::string& key);
  // Puts what is in startEntry's folder in place, unless another driver has done so meanwhile: then its entry
  // is returned. Of `run` time and memory count, as measured from outside;
  // the rest is read from stats.json. Throws Error(kBadInput) if an output is missing or stats.json is
  // damaged, Error(kCannotWrite).
  CacheEntry finishEntry(const std::string& key, const Ingredients& ingredients, formats::StageRecord run);
  void dropEntry(const std::string& key);  // gives up what startEntry began

  // What interrupted processes left behind: those of processes of this host that have ended, and whatever
  // nobody has written into for a week.
  void removeTemporaries();

 private:
  std::filesystem::path folderOf(const std::string& key) const;
  bool isAbandoned(const std::string& temporary) const;
  CachedFile examined(const std::filesystem::path& folder, const std::string& name) const;
  std::string damageOf(const CacheEntry& entry) const;
  void readStats(const std::filesystem::path& path, formats::StageRecord& run) const;

  std::filesystem::path folder_;
  Disk& disk_;
  Memo& memo_;
  Owner owner_;
  std::map<std::string, std::filesystem::path> started_;  // folders of entries in the making, by key
};

}  // namespace bakelight::pipeline
