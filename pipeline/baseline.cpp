#include "pipeline/baseline.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "formats/error.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;

namespace {

// Beside `folder`, so that renaming them does not leave the file system.
fs::path unfinished(const fs::path& folder) {
  return fs::path(folder).concat(".unfinished");
}
fs::path replaced(const fs::path& folder) {
  return fs::path(folder).concat(".replaced");
}

void refuseWhatIsNoBaseline(const fs::path& folder, const Disk& disk) {
  const auto stat = disk.stat(folder);
  if (!stat || (stat->folder && disk.list(folder).empty()) || disk.isFile(folder / kBaselineFile)) return;
  throw badInput({folder.string(), "", ""}, "is there, but is not a baseline", "a new or empty folder",
                 "remove it, or name another folder with --baseline");
}

// Puts the folder `from` at `to`; what was there goes only then.
void replaceFolder(const fs::path& from, const fs::path& to, Disk& disk) {
  const fs::path old = replaced(to);
  disk.removeAll(old);
  const bool had_one = disk.stat(to).has_value();
  if (had_one) disk.rename(to, old);
  try {
    disk.rename(from, to);
  } catch (...) {
    if (had_one) disk.rename(old, to);
    throw;
  }
  disk.removeAll(old);
}

BaselineStage storedStage(const MadeStage& made, const fs::path& folder, Disk& disk) {
  BaselineStage stage{
      .tool = made.tool, .execution_path = made.execution_path, .parameters = made.parameters};
  for (const auto& [port, file] : made.entry.outputs) {
    const std::string& kind = made.kinds.at(port);
    const std::string stored = made.stage + "/" + file.name;
    disk.copy(made.entry.pathOf(file), folder / stored);
    stage.outputs[port] = {stored, kind, file.hash, defaultLimits(kind)};
  }
  stage.counts = countsOf(made.entry.run.stats);
  return stage;
}

}  // namespace

MadeAsset madeAsset(const Graph& graph, std::size_t asset, const BuildResult& result, Toolbox& tools) {
  MadeAsset made{graph.assets[asset].name, graph.assets[asset].recipe, {}};
  for (TaskIndex index = 0; index < graph.tasks.size(); ++index) {
    const Task& task = graph.tasks[index];
    const Outcome& outcome = result.outcomes[index];
    if (task.asset != asset) continue;
    if (outcome.status == StageStatus::kLeftOut) {
      made.left_out[task.stage] = outcome.reason;
      continue;
    }
    if (!outcome.entry)
      throw badInput({graph.assets[asset].file, "stage " + task.stage, ""}, "was not made: " + outcome.reason,
                     "a run in which every stage succeeds");
    MadeStage stage{
        task.stage, task.tool,     outcome.ingredients.execution_path, outcome.ingredients.parameters,
        {},         *outcome.entry};
    const formats::ToolDescription& tool = tools.require(task.tool, {}).description;
    for (const auto& [port, file] : outcome.entry->outputs) stage.kinds[port] = tool.findOutput(port)->kind;
    made.stages.push_back(std::move(stage));
  }
  return made;
}

fs::path baselineFolder(const Asset& asset) {
  const fs::path file = asset.file;
  return file.filename() == "asset.json" ? file.parent_path() / "baseline"
                                         : fs::path(file).replace_extension(".baseline");
}

void saveBaseline(const MadeAsset& made, const fs::path& folder, Disk& disk) {
  refuseWhatIsNoBaseline(folder, disk);
  const fs::path temporary = unfinished(folder);
  disk.removeAll(temporary);
  try {
    Baseline baseline{.asset = made.name, .recipe = made.recipe};
    std::size_t outputs = 0;
    for (const MadeStage& stage : made.stages) {
      baseline.stages[stage.stage] = storedStage(stage, temporary, disk);
      outputs += stage.entry.outputs.size();
    }
    if (outputs == 0)
      throw badInput({folder.string(), "", ""}, "would be empty: no stage made an output",
                     "an asset that delivers something", "look at its \"deliver\"");
    disk.write(temporary / kBaselineFile, toJson(baseline).dump(2) + "\n");
    replaceFolder(temporary, folder, disk);
  } catch (...) {
    disk.removeAll(temporary);
    throw;
  }
}

Comparer compareTool(const fs::path& tools, const fs::path& scratch, Runner& runner, Disk& disk) {
  return [=, &runner, &disk](const std::string& kind, const fs::path& file, const fs::path& reference,
                             const formats::CompareLimits& limits) {
    const fs::path executable = tools / "compare", answer_file = scratch / "comparison.json";
    const auto number = [](double value) { return fmt::format("{:.17g}", value); };
    std::string ignored_keys;
    for (const std::string& key : limits.ignored_keys) ignored_keys += key + " ";
    const Captured captured = runner.capture({executable.string(),
                                              "--file",
                                              file.string(),
                                              "--reference",
                                              reference.string(),
                                              "--kind",
                                              kind,
                                              "--distance",
                                              number(limits.distance),
                                              "--normal",
                                              number(limits.normal),
                                              "--maximum",
                                              number(limits.maximum),
                                              "--rms",
                                              number(limits.rms),
                                              "--relative",
                                              number(limits.relative),
                                              "--ignored-keys",
                                              ignored_keys,
                                              "--stats",
                                              answer_file.string(),
                                              "--progress",
                                              "none"});
    if (captured.exit_status != 0 || captured.signal != 0)
      throw badInput({file.string(), "", ""}, "cannot be compared with " + reference.string(),
                     "two files of the kind " + kind);
    const Json answer = formats::parseJson(disk.read(answer_file), answer_file.string()).at("stats");
    disk.removeAll(answer_file);
    formats::Comparison comparison;
    comparison.compared_values = answer.at("compared_values");
    comparison.mismatches = answer.at("mismatches").get<std::vector<std::string>>();
    for (const Json& difference : answer.at("differences")) {
      const Json& measured = difference.at("measured");  // null: not a number
      comparison.differences.push_back(
          {difference.at("what"),
           measured.is_number() ? measured.get<double>() : std::numeric_limits<double>::quiet_NaN(),
           difference.at("limit")});
    }
    return comparison;
  };
}

}  // namespace bakelight::pipeline
