// baseline.json: what the stages of an asset made when the baseline was saved, and how far a later run may be
// off. Its limits are for people to edit (docs/BASELINE.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/compare.h"
#include "formats/json.h"
#include "pipeline/disk.h"

namespace bakelight::pipeline {

inline constexpr const char* kBaselineFile = "baseline.json";

struct BaselineOutput {
  std::string file;  // relative to the baseline's folder
  std::string kind;  // as formats::PortDescription::kind
  std::string hash;
  formats::CompareLimits limits = {};
};

struct BaselineStage {
  std::string tool;
  std::string execution_path;  // formats::ToolDescription::execution_path
  formats::Json parameters = formats::Json::object();
  std::map<std::string, BaselineOutput> outputs = {};  // by port
  std::map<std::string, std::int64_t> counts = {};     // by JSON pointer into the stage's stats
  std::vector<std::string> ignored_counts = {};        // pointers that are not compared
};

struct Baseline {
  std::string asset, recipe;
  std::map<std::string, BaselineStage> stages = {};
};

// Whether files of this kind can be compared otherwise than byte by byte.
bool hasLimits(const std::string& kind);
// Those that a new baseline gets; docs/BASELINE.md says why these.
formats::CompareLimits defaultLimits(const std::string& kind);

// Every integer of `stats`, by JSON pointer, but those that tell of the machine or of time: where a name on
// the way to it ends in _s, _ms or _bytes.
std::map<std::string, std::int64_t> countsOf(const formats::Json& stats);

formats::Json toJson(const Baseline& baseline);
// Reads `folder`/baseline.json and checks that each file in it is as it was saved. Throws Error(kBadInput) or
// ProblemsFound, with JSON pointers, if there is none, it is damaged or of another version.
Baseline readBaseline(const std::filesystem::path& folder, const Disk& disk);

}  // namespace bakelight::pipeline
