#include "formats/stage_record.h"

#include <nlohmann/json.hpp>

#include "formats/error.h"

namespace bakelight::formats {

Json toJson(const StageRecord& record) {
  return {{"tool", record.tool},         {"wall_s", record.wall_s},
          {"cpu_s", record.cpu_s},       {"peak_memory_bytes", record.peak_memory_bytes},
          {"warnings", record.warnings}, {"stats", record.stats}};
}

StageRecord stageRecordFromJson(const Json& json, const std::string& file) {
  std::string pointer;
  const auto member = [&](const char* key) -> const Json& {
    pointer = childPointer("", key);
    return json.at(key);
  };
  try {
    StageRecord record;
    record.tool = member("tool").get<std::string>();
    record.wall_s = member("wall_s").get<double>();
    record.cpu_s = member("cpu_s").get<double>();
    record.peak_memory_bytes = member("peak_memory_bytes").get<std::uint64_t>();
    record.warnings = member("warnings").get<std::vector<std::string>>();
    record.stats = member("stats");
    if (!record.stats.is_object()) throw std::invalid_argument("stats is not an object");
    return record;
  } catch (const std::exception& error) {
    throw badInput({file, "", pointer}, std::string("is not a stage record: ") + error.what(),
                   "the stats.json of docs/FORMATS.md", "run the stage again");
  }
}

}  // namespace bakelight::formats
