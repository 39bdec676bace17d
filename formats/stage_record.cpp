#include "formats/stage_record.h"

#include <nlohmann/json.hpp>

#include "formats/json_reader.h"

namespace bakelight::formats {

Json toJson(const StageRecord& record) {
  return {{"tool", record.tool},         {"wall_s", record.wall_s},
          {"cpu_s", record.cpu_s},       {"peak_memory_bytes", record.peak_memory_bytes},
          {"warnings", record.warnings}, {"stats", record.stats}};
}

StageRecord stageRecordFromJson(const Json& json, const std::string& file) {
  const JsonReader object(json, file, "", "run the stage again");
  object.at("stats", "an object of figures");
  return {.tool = object.text("tool"),
          .wall_s = object.number("wall_s"),
          .cpu_s = object.number("cpu_s"),
          .peak_memory_bytes = object.at("peak_memory_bytes", "a number of bytes").whole(),
          .warnings = object.at("warnings", "a list of texts").texts(),
          .stats = object.object("stats").value()};
}

}  // namespace bakelight::formats
