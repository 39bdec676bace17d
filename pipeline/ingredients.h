// What a stage's outputs are made from. Equal ingredients make equal outputs, so their hash is the name under
// which the cache keeps what was made.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/json.h"

namespace bakelight::pipeline {

struct Ingredients {
  std::string tool;
  std::string tool_hash;                               // of the executable
  std::string execution_path;                          // formats::ToolDescription::execution_path
  formats::Json parameters = formats::Json::object();  // all, canonical
  struct InputFile {
    std::string hash;
    std::string ending;  // importers choose the format by it
    bool operator==(const InputFile&) const = default;
  };
  std::map<std::string, InputFile> inputs = {};     // by port
  std::map<std::string, std::string> outputs = {};  // file name by port

  std::string key() const;  // 32 hex digits
};

formats::Json toJson(const Ingredients& ingredients);
// Nothing if `json` is not what toJson writes: a record of another version, or damaged.
std::optional<Ingredients> ingredientsFromJson(const formats::Json& json);

// How `now` differs from `before`, one plain phrase each: "order changed from 5 to 4", "tool transfer was
// rebuilt". `origin_of`: for each input port what it comes from, as in "simplify made a different mesh.ply"
// or "bunny.obj".
std::vector<std::string> differences(const Ingredients& before, const Ingredients& now,
                                     const std::map<std::string, std::string>& origin_of);

}  // namespace bakelight::pipeline
