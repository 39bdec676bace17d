// What the user sees: out/<asset>/<deliverable>, out/<asset>/<stage>/<other outputs and stats.json>,
// out/<asset>/record.json. All are copies of cache entries, so editing one hurts nothing and the next run
// puts it right.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cache.h"
#include "pipeline/disk.h"
#include "pipeline/graph.h"
#include "pipeline/memo.h"

namespace bakelight::pipeline {

class OutputFolder {
 public:
  OutputFolder(std::filesystem::path folder, const Graph& graph, Disk& disk, Memo& memo);

  std::filesystem::path assetFolder(std::size_t asset) const;
  std::filesystem::path recordOf(std::size_t asset) const;
  std::filesystem::path pathOf(TaskIndex task, const std::string& port) const;
  std::filesystem::path statsOf(TaskIndex task) const;

  // How the files of `task` differ from `entry`: "mesh.ply is missing", "mesh.ply was edited"; empty if they
  // do not.
  std::vector<std::string> differences(TaskIndex task, const CacheEntry& entry) const;
  // Whether files of `task` lie there, of whatever entry.
  bool holds(TaskIndex task) const;
  // Removes them.
  void withdraw(TaskIndex task);
  // Copies those that differ.
  void publish(TaskIndex task, const CacheEntry& entry);

 private:
  struct Placed {
    const CachedFile* file;
    std::filesystem::path path;
  };
  std::vector<Placed> placesOf(TaskIndex task, const CacheEntry& entry) const;
  std::vector<std::filesystem::path> lying(TaskIndex task) const;
  std::string differenceOf(const Placed& placed) const;  // "" if there is none

  std::filesystem::path folder_;
  const Graph& graph_;
  Disk& disk_;
  Memo& memo_;
};

}  // namespace bakelight::pipeline
