#include "pipeline/record.h"

#include <utility>

namespace bakelight::pipeline {
using formats::Json;
namespace {

Json outputsOf(const Graph& graph, TaskIndex task, const CacheEntry& entry, const OutputFolder& out) {
  Json outputs = Json::object();
  const auto folder = out.assetFolder(graph.tasks[task].asset);
  for (const auto& [port, file] : entry.outputs)
    outputs[port] = {{"path", out.pathOf(task, port).lexically_relative(folder).string()},
                     {"bytes", file.bytes},
                     {"hash", file.hash}};
  return outputs;
}

Json madeStage(const Graph& graph, TaskIndex task, const Outcome& outcome, const OutputFolder& out) {
  const CacheEntry& entry = *outcome.entry;
  Json stage = formats::toJson(entry.run);
  stage["key"] = entry.key;
  stage["ingredients"] = toJson(outcome.ingredients);
  stage["outputs"] = outputsOf(graph, task, entry, out);
  return stage;
}

// What the outputs that still lie in the folder were made from.
Json keptStage(const Task& task, const Outcome& outcome, const PastRecord& past) {
  const bool withdrawn = outcome.status == StageStatus::kLeftOut && task.left_out.empty();
  if (withdrawn || !past.stage(task.stage).ingredients) return Json::object();
  return past.json().at("stages").at(task.stage);
}

}  // namespace

const char* nameOf(StageStatus status) {
  switch (status) {
    case StageStatus::kRan:
      return "ran";
    case StageStatus::kCached:
      return "cached";
    case StageStatus::kLeftOut:
      return "left-out";
    case StageStatus::kFailed:
      return "failed";
    case StageStatus::kNotRun:
      return "not-run";
  }
  return "";
}

PastRecord::PastRecord(const std::filesystem::path& file, const Disk& disk) {
  if (!disk.isFile(file)) return;
  text_ = disk.read(file);
  const Json json = Json::parse(text_, nullptr, false);
  if (json.is_object() && json.contains("stages") && json["stages"].is_object()) json_ = json;
}

PastRecord::Stage PastRecord::stage(const std::string& name) const {
  const Json stages = json_.value("stages", Json::object());
  if (!stages.contains(name) || !stages[name].is_object()) return {};
  const Json& found = stages[name];
  const auto text = [&](const char* key) {
    return found.contains(key) && found[key].is_string() ? found[key].get<std::string>() : std::string();
  };
  return {text("status"), text("reason"), ingredientsFromJson(found.value("ingredients", Json()))};
}

Json recordOf(const Graph& graph, std::size_t asset, const std::vector<Outcome>& outcomes,
              const OutputFolder& out, const PastRecord& past) {
  Json stages = Json::object();
  for (TaskIndex task = 0; task < graph.tasks.size(); ++task) {
    if (graph.tasks[task].asset != asset) continue;
    const Outcome& outcome = outcomes[task];
    Json stage =
        outcome.entry ? madeStage(graph, task, outcome, out) : keptStage(graph.tasks[task], outcome, past);
    stage.erase("error");
    for (const Omission& omission : outcome.omissions) stage["left_out"].push_back(toJson(omission));
    stage["tool"] = graph.tasks[task].tool;
    stage["status"] = nameOf(outcome.status);
    stage["reason"] = outcome.reason;
    if (outcome.error) stage["error"] = outcome.error->paragraph();
    stages[graph.tasks[task].stage] = std::move(stage);
  }
  Json record = {{"asset", graph.assets[asset].name},
                 {"recipe", graph.assets[asset].recipe},
                 {"stages", std::move(stages)}};
  if (!graph.assets[asset].choice.is_null()) record["budget"] = graph.assets[asset].choice;
  return record;
}

}  // namespace bakelight::pipeline
