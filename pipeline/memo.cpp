#include "pipeline/memo.h"

#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

constexpr int kVersion = 1;

// Time stamps tick in steps of some milliseconds. A file younger than this could be changed once more within
// the same tick, unseen, so its hash is not kept (the "racy" entries of version control systems).
constexpr std::int64_t kSettledAfter_ns = 20'000'000;

std::string nameOf(const fs::path& path) {
  return path.lexically_normal().string();
}

}  // namespace

Memo::Memo(fs::path file, Disk& disk) : file_(std::move(file)), disk_(disk) {
  load();
}

void Memo::load() {
  if (!disk_.isFile(file_)) return;
  const Json json = Json::parse(disk_.read(file_), nullptr, false);
  if (!json.is_object() || json.value("version", 0) != kVersion) return;
  try {
    std::map<std::string, Known> files;
    for (const auto& [name, entry] : json.at("files").items())
      files[name] = {.stat = {.folder = false,
                              .bytes = entry.at(0).get<std::uint64_t>(),
                              .mtime_ns = entry.at(1).get<std::int64_t>(),
                              .inode = entry.at(2).get<std::uint64_t>()},
                     .hash = entry.at(3).get<std::string>()};
    answers_ = json.at("answers");
    files_ = std::move(files);
  } catch (const Json::exception&) {
    answers_ = Json::object();
  }
}

std::string Memo::hashOf(const fs::path& path) {
  const auto stat = disk_.stat(path);
  if (!stat || stat->folder)
    throw badInput({path.string(), "", ""}, stat ? "is a folder" : "does not exist", "a file");
  const auto known = files_.find(nameOf(path));
  if (known != files_.end() && known->second.stat == *stat) return known->second.hash;

  const std::string hash = disk_.hash(path);
  if (disk_.now_ns() - stat->mtime_ns > kSettledAfter_ns) {
    files_[nameOf(path)] = {*stat, hash};
    changed_ = true;
  }
  return hash;
}

void Memo::remember(const fs::path& path, const std::string& hash) {
  const auto stat = disk_.stat(path);
  if (!stat) return;
  files_[nameOf(path)] = {*stat, hash};
  changed_ = true;
}

std::optional<Json> Memo::answer(const std::string& key) const {
  const auto known = answers_.find(key);
  if (known == answers_.end()) return std::nullopt;
  return *known;
}

void Memo::rememberAnswer(const std::string& key, Json answer) {
  answers_[key] = std::move(answer);
  changed_ = true;
}

void Memo::save() {
  if (!changed_) return;
  Json files = Json::object();
  for (const auto& [name, known] : files_)
    files[name] = {known.stat.bytes, known.stat.mtime_ns, known.stat.inode, known.hash};
  const Json json = {{"version", kVersion}, {"files", std::move(files)}, {"answers", answers_}};
  disk_.write(file_, json.dump(-1, ' ', false, Json::error_handler_t::replace));
  changed_ = false;
}

}  // namespace bakelight::pipeline
