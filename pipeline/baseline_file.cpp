#include "pipeline/baseline_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/error.h"
#include "formats/json_reader.h"
#include "pipeline/problems.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::CompareLimits;
using formats::Json;
using formats::JsonReader;

namespace {

constexpr const char* kFormat = "bakelight baseline";
constexpr int kVersion = 1;
constexpr const char* kSaveAgain = "save it again with `bakelight baseline save`";

struct Limit {
  const char* name;
  double CompareLimits::*value;
};
constexpr Limit kLimits[] = {{"distance", &CompareLimits::distance}, {"normal", &CompareLimits::normal},
                             {"maximum", &CompareLimits::maximum},   {"rms", &CompareLimits::rms},
                             {"share", &CompareLimits::share},       {"relative", &CompareLimits::relative}};
constexpr const char* kIgnoredKeys = "ignored_keys";

// Which of the limits mean something for a kind.
const std::map<std::string, std::vector<std::string>>& limitNames() {
  static const std::map<std::string, std::vector<std::string>> names = {
      {"mesh", {"distance", "normal", "maximum"}},
      {"meso_mesh", {"distance", "normal", "maximum"}},
      {"pack", {"distance", "normal", "relative", "maximum"}},
      {"tensors", {"relative", "maximum", kIgnoredKeys}},
      {"image", {"rms", "maximum"}},
      {"id_map", {"share"}},
      {"rtt", {"relative", "maximum"}},
      {"btf", {"relative", "maximum"}},
      {"json", {"relative", kIgnoredKeys}}};
  return names;
}

std::vector<std::string> limitNames(const std::string& kind) {
  return hasLimits(kind) ? limitNames().at(kind) : std::vector<std::string>();
}

bool tellsOfTheMachine(const std::string& name) {
  return name.ends_with("_s") || name.ends_with("_ms") || name.ends_with("_bytes");
}

void collectCounts(const Json& value, const std::string& pointer,
                   std::map<std::string, std::int64_t>& counts) {
  if (value.is_number_integer()) counts[pointer] = value.get<std::int64_t>();
  if (value.is_object())
    for (const auto& [name, member] : value.items())
      if (!tellsOfTheMachine(name)) collectCounts(member, formats::childPointer(pointer, name), counts);
  if (value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i)
      collectCounts(value[i], formats::childPointer(pointer, std::to_string(i)), counts);
}

Json limitsJson(const BaselineOutput& output) {
  Json json = Json::object();
  const std::vector<std::string> names = limitNames(output.kind);
  for (const Limit& limit : kLimits)
    if (std::find(names.begin(), names.end(), limit.name) != names.end())
      json[limit.name] = output.limits.*limit.value;
  if (std::find(names.begin(), names.end(), kIgnoredKeys) != names.end())
    json[kIgnoredKeys] = output.limits.ignored_keys;
  return json;
}

Json toJson(const BaselineStage& stage) {
  Json outputs = Json::object();
  for (const auto& [port, output] : stage.outputs)
    outputs[port] = {
        {"file", output.file}, {"kind", output.kind}, {"hash", output.hash}, {"limits", limitsJson(output)}};
  return {{"tool", stage.tool},
          {"execution_path", stage.execution_path},
          {"parameters", stage.parameters},
          {"outputs", outputs},
          {"counts", stage.counts},
          {"ignored_counts", stage.ignored_counts}};
}

class Reader {
 public:
  Reader(const fs::path& folder, const Disk& disk, Problems& problems)
      : folder_(folder), disk_(disk), problems_(problems) {}

  Baseline read(const JsonReader& json) {
    problems_.add(json.unknownKeys({"format", "version", "asset", "recipe", "stages"}));
    Baseline baseline{.asset = json.text("asset"), .recipe = json.text("recipe")};
    const JsonReader stages = json.object("stages");
    for (const std::string& name : stages.keys())
      problems_.attempt([&] { baseline.stages[name] = stage(stages.object(name)); });
    if (stages.keys().empty())
      throw badInput(json.placeOf("stages"), "has no stage", "what each stage made", kSaveAgain);
    return baseline;
  }

 private:
  BaselineStage stage(const JsonReader& json) {
    problems_.add(
        json.unknownKeys({"tool", "execution_path", "parameters", "outputs", "counts", "ignored_counts"}));
    BaselineStage stage{.tool = json.text("tool"), .execution_path = json.text("execution_path")};
    json.object("parameters");
    if (json.has("parameters")) stage.parameters = json.value("parameters");
    const JsonReader outputs = json.object("outputs");
    for (const std::string& port : outputs.keys())
      problems_.attempt([&] { stage.outputs[port] = output(outputs.object(port)); });
    const JsonReader counts = json.object("counts");
    for (const std::string& name : counts.keys()) {
      if (!counts.value(name).is_number_integer())
        throw badInput(counts.placeOf(name), counts.value(name).dump() + " is not a count", "an integer");
      stage.counts[name] = counts.value(name).get<std::int64_t>();
    }
    stage.ignored_counts = json.texts("ignored_counts");
    for (const std::string& name : stage.ignored_counts)
      if (!stage.counts.contains(name))
        problems_.add(badInput(json.placeOf("ignored_counts"), "there is no count " + name,
                               "pointers that stand under \"counts\""));
    return stage;
  }

  BaselineOutput output(const JsonReader& json) {
    problems_.add(json.unknownKeys({"file", "kind", "hash", "limits"}));
    BaselineOutput output{.file = json.text("file"), .kind = json.text("kind"), .hash = json.text("hash")};
    output.limits = limits(json.object("limits"), output.kind);
    const fs::path file = folder_ / output.file;
    if (!disk_.isFile(file))
      throw badInput({file.string(), "", ""}, "is missing", "a file of the baseline", kSaveAgain);
    if (disk_.hash(file) != output.hash)
      throw badInput({file.string(), "", ""}, "is not as it was saved", "content of the hash " + output.hash,
                     kSaveAgain);
    return output;
  }

  CompareLimits limits(const JsonReader& json, const std::string& kind) {
    problems_.add(json.unknownKeys(limitNames(kind)));
    CompareLimits limits;
    for (const Limit& limit : kLimits) json.read(limit.name, limits.*limit.value, {.minimum = 0});
    limits.ignored_keys = json.texts(kIgnoredKeys);
    return limits;
  }

  const fs::path& folder_;
  const Disk& disk_;
  Problems& problems_;
};

}  // namespace

bool hasLimits(const std::string& kind) {
  return limitNames().contains(kind);
}

CompareLimits defaultLimits(const std::string& kind) {
  if (kind == "mesh" || kind == "meso_mesh") return {.distance = 1e-5, .normal = 1e-3, .maximum = 1e-5};
  if (kind == "tensors") return {.maximum = 1e-2, .relative = 1e-3, .ignored_keys = {"mesh_hash"}};
  if (kind == "pack") return {.distance = 1e-5, .normal = 1e-3, .maximum = 2e-2, .relative = 2e-3};
  if (kind == "image") return {.maximum = 0.5, .rms = 5e-3};
  if (kind == "id_map") return {.share = 1e-3};
  if (kind == "rtt" || kind == "btf") return {.maximum = 0.05, .relative = 2e-3};
  if (kind == "json") return {.relative = 1e-6};
  return {};
}

std::map<std::string, std::int64_t> countsOf(const Json& stats) {
  std::map<std::string, std::int64_t> counts;
  collectCounts(stats, "", counts);
  return counts;
}

Json toJson(const Baseline& baseline) {
  Json stages = Json::object();
  for (const auto& [name, stage] : baseline.stages) stages[name] = toJson(stage);
  return {{"format", kFormat},
          {"version", kVersion},
          {"asset", baseline.asset},
          {"recipe", baseline.recipe},
          {"stages", stages}};
}

Baseline readBaseline(const fs::path& folder, const Disk& disk) {
  const fs::path file = folder / kBaselineFile;
  if (!disk.isFile(file))
    throw badInput({folder.string(), "", ""}, "is no baseline: it has no " + std::string(kBaselineFile),
                   "a folder that `bakelight baseline save` made", "save one, or name it with --baseline");
  const Json json = formats::parseJson(disk.read(file), file.string());
  const JsonReader object(json, file.string());
  if (object.text("format") != kFormat)
    throw badInput(object.placeOf("format"), "is \"" + object.text("format") + "\"",
                   "\"" + std::string(kFormat) + "\"");
  if (!object.has("version") || object.value("version") != kVersion)
    throw badInput(object.placeOf("version"), "is not a version that this Bakelight reads",
                   std::to_string(kVersion), kSaveAgain);
  Problems problems;
  Baseline baseline;
  problems.attempt([&] { baseline = Reader(folder, disk, problems).read(object); });
  problems.throwIfAny();
  return baseline;
}

}  // namespace bakelight::pipeline
