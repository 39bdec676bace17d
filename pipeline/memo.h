// What need not be found out again: content hashes of files that have not been touched, and what tools said
// of themselves. Losing the memo costs time, never a wrong result.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "formats/json.h"
#include "pipeline/disk.h"

namespace bakelight::pipeline {

class Memo {
 public:
  // Reads `file` if it is there; one that is damaged counts as empty.
  Memo(std::filesystem::path file, Disk& disk);

  // Content hash of the file at `path`; reads it only if size, modification time or inode differ from last
  // time. Throws Error(kBadInput) if it cannot be read.
  std::string hashOf(const std::filesystem::path& path);
  // For a file that this process has just put in place.
  void remember(const std::filesystem::path& path, const std::string& hash);

  // Answers of tools, by a key that changes whenever the answer may.
  std::optional<formats::Json> answer(const std::string& key) const;
  void rememberAnswer(const std::string& key, formats::Json answer);

  void save();  // nothing if nothing changed

 private:
  struct Known {
    FileStat stat;
    std::string hash;
  };
  void load();

  std::filesystem::path file_;
  Disk& disk_;
  std::map<std::string, Known> files_;
  formats::Json answers_ = formats::Json::object();
  bool changed_ = false;
};

}  // namespace bakelight::pipeline
