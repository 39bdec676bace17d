#include "pipeline/output_folder.h"

#include <utility>

namespace bakelight::pipeline {
namespace fs = std::filesystem;

OutputFolder::OutputFolder(fs::path folder, const Graph& graph, Disk& disk, Memo& memo)
    : folder_(std::move(folder)), graph_(graph), disk_(disk), memo_(memo) {}

fs::path OutputFolder::assetFolder(std::size_t asset) const {
  return folder_ / graph_.assets[asset].name;
}

fs::path OutputFolder::recordOf(std::size_t asset) const {
  return assetFolder(asset) / "record.json";
}

fs::path OutputFolder::pathOf(TaskIndex index, const std::string& port) const {
  const Task& task = graph_.tasks[index];
  const fs::path folder = assetFolder(task.asset);
  return (task.deliverables.count(port) != 0 ? folder : folder / task.stage) / task.outputs.at(port);
}

fs::path OutputFolder::statsOf(TaskIndex index) const {
  const Task& task = graph_.tasks[index];
  return assetFolder(task.asset) / task.stage / kStatsFile;
}

std::vector<OutputFolder::Placed> OutputFolder::placesOf(TaskIndex task, const CacheEntry& entry) const {
  std::vector<Placed> places;
  if (!graph_.tasks[task].published) return places;
  for (const auto& [port, file] : entry.outputs) places.push_back({&file, pathOf(task, port)});
  places.push_back({&entry.stats, statsOf(task)});
  return places;
}

std::string OutputFolder::differenceOf(const Placed& placed) const {
  const auto stat = disk_.stat(placed.path);
  if (!stat) return placed.file->name + " is missing";
  if (stat->folder) return placed.file->name + " is a folder";
  const bool same = stat->bytes == placed.file->bytes && memo_.hashOf(placed.path) == placed.file->hash;
  return same ? "" : placed.file->name + " was edited";
}

std::vector<std::string> OutputFolder::differences(TaskIndex task, const CacheEntry& entry) const {
  std::vector<std::string> phrases;
  for (const Placed& placed : placesOf(task, entry)) {
    std::string phrase = differenceOf(placed);
    if (!phrase.empty()) phrases.push_back(std::move(phrase));
  }
  return phrases;
}

std::vector<fs::path> OutputFolder::lying(TaskIndex index) const {
  std::vector<fs::path> files;
  const Task& task = graph_.tasks[index];
  if (!task.published) return files;
  for (const auto& [port, file] : task.outputs) files.push_back(pathOf(index, port));
  files.push_back(statsOf(index));
  std::erase_if(files, [&](const fs::path& file) { return !disk_.isFile(file); });
  return files;
}

bool OutputFolder::holds(TaskIndex task) const {
  return !lying(task).empty();
}

void OutputFolder::withdraw(TaskIndex task) {
  for (const fs::path& file : lying(task)) disk_.removeAll(file);
  const fs::path folder = statsOf(task).parent_path();
  if (disk_.isFolder(folder) && disk_.list(folder).empty()) disk_.removeAll(folder);
}

void OutputFolder::publish(TaskIndex task, const CacheEntry& entry) {
  for (const Placed& placed : placesOf(task, entry)) {
    if (differenceOf(placed).empty()) continue;
    disk_.copy(entry.pathOf(*placed.file), placed.path);
    memo_.remember(placed.path, placed.file->hash);
  }
}

}  // namespace bakelight::pipeline
