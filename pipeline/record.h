// out/<asset>/record.json: what became of each stage, why, and what its outputs in the folder are made from.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "pipeline/cache.h"
#include "pipeline/ingredients.h"
#include "pipeline/leave_out.h"
#include "pipeline/output_folder.h"

namespace bakelight::pipeline {

enum class StageStatus { kRan, kCached, kLeftOut, kFailed, kNotRun };
const char* nameOf(StageStatus status);  // "ran", "cached", "left-out", "failed", "not-run"

// What became of one stage.
struct Outcome {
  StageStatus status = StageStatus::kNotRun;
  std::string reason;
  bool published = false;                // something in the output folder was made, put right or removed
  Ingredients ingredients = {};          // if ran or cached
  std::vector<Omission> omissions = {};  // what is left out of the stage by measurement, or why all of it is
  std::optional<CacheEntry> entry = {};  // if ran or cached
  std::optional<Error> error = {};       // if failed
  int exit_status = 0;                   // of the failed tool, or of the error
};

// What record.json says of the run before.
class PastRecord {
 public:
  PastRecord() = default;
  // A file that is missing or damaged counts as empty.
  PastRecord(const std::filesystem::path& file, const Disk& disk);

  struct Stage {
    std::string status, reason;
    std::optional<Ingredients> ingredients;  // of the outputs that lie in the folder; nothing: never made
  };
  Stage stage(const std::string& name) const;

  const std::string& text() const { return text_; }
  const formats::Json& json() const { return json_; }

 private:
  std::string text_;
  formats::Json json_ = formats::Json::object();
};

// The record of one asset. A stage without an entry keeps what `past` says of its outputs if they still lie there:
// unless it is left out by measurement.
formats::Json recordOf(const Graph& graph, std::size_t asset, const std::vector<Outcome>& outcomes,
                       const OutputFolder& out, const PastRecord& past);

}  // namespace bakelight::pipeline
