// stats.json: what a stage says of its own run, beside its outputs. The driver copies it into
// out/<asset>/record.json.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/json.h"

namespace bakelight::formats {

struct StageRecord {
  std::string tool;
  double wall_s = 0, cpu_s = 0;
  std::uint64_t peak_memory_bytes = 0;
  std::vector<std::string> warnings;
  Json stats = Json::object();  // counts, energies, residuals, by name; units in the names
};

Json toJson(const StageRecord& record);
// Throws Error(kBadInput) at the offending pointer.
StageRecord stageRecordFromJson(const Json& json, const std::string& file);

}  // namespace bakelight::formats
