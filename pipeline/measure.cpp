#include "pipeline/measure.h"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "pipeline/budget.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

Graph comparisonGraph(const Comparison& comparison, const fs::path& plan, Toolbox& tools) {
  const formats::ToolDescription& tool = tools.require(comparison.tool, {}).description;
  Graph graph{.assets = {{.name = comparison.tool, .label = {}, .file = plan.string()}}};
  Task task{.stage = comparison.tool, .tool = comparison.tool};
  task.inputs[comparison.plan_input] = {.port = comparison.plan_input, .file = plan};
  task.outputs = comparison.files;
  task.parameters = defaultParameters(tool);
  task.published = false;
  graph.tasks.push_back(std::move(task));
  return graph;
}

// The comparison's files in out/ASSET, by way of the cache: the plan names all that goes in by its hash.
Json compareVariants(Workplace& workplace, const Request& request, const Comparison& comparison,
                     const fs::path& folder, const fs::path& plan, bool quiet) {
  const Graph graph = comparisonGraph(comparison, plan, workplace.tools);
  const BuildResult result = runGraph(workplace, graph, folder / "sweep", buildSettings(request, 1), quiet);
  const std::optional<CacheEntry>& entry = result.outcomes.front().entry;
  if (!entry) {
    const std::optional<Error>& error = result.outcomes.front().error;
    throw error ? *error : Error(ExitStatus::kInterrupted, {}, "interrupted");
  }
  for (const auto& [port, file] : entry->outputs)
    workplace.disk.copy(entry->pathOf(file), folder / file.name);
  const fs::path figures = folder / comparison.files.at(comparison.figures_output);
  return formats::parseJson(workplace.disk.read(figures), figures.string());
}

void tellFailures(const Json& plan) {
  for (const Json& failed : plan.at("failed"))
    std::cerr << "bakelight: the variant " << failed.at("name").get<std::string>()
              << " is not in the report: " << failed.at("stage").get<std::string>() << ": "
              << failed.at("reason").get<std::string>() << '\n';
}

bool sameText(const Disk& disk, const fs::path& path, const std::string& text) {
  return disk.isFile(path) && disk.read(path) == text;
}

// One setting a parameter, as a variant has them.
std::vector<Setting> settingsOf(const Json& parameters) {
  std::vector<Setting> settings;
  for (const auto& [name, value] : parameters.items())
    settings.push_back(
        parseSetting(name + "=" + (value.is_string() ? value.get<std::string>() : value.dump())));
  return settings;
}

void apply(const Json& choice, Asset& asset) {
  asset.settings = settingsOf(choice.at("parameters"));
  asset.choice = choice;
}

std::string neighbourText(const char* which, const Json& neighbour) {
  if (neighbour.is_null()) return std::string("; there is no ") + which + " one";
  return std::string("; the next ") + which + " is " + neighbour.at("name").get<std::string>() + " with " +
         figuresText(neighbour);
}

}  // namespace

std::optional<Json> measureVariants(Workplace& workplace, const Request& request, const Asset& asset,
                                    const SweepOptions& options, bool quiet) {
  Problems problems;
  std::optional<Sweep> sweep;
  problems.attempt([&] { sweep = planSweep(asset, workplace.recipes, workplace.tools, options, problems); });
  problems.throwIfAny();
  const fs::path folder = request.out / asset.name;
  const BuildResult result =
      runGraph(workplace, sweep->graph, folder / "sweep", buildSettings(request, 1), quiet);
  workplace.memo.save();
  if (result.interrupted) return {};

  const Json plan = reportPlan(asset.name, *sweep, result.outcomes, workplace.memo);
  tellFailures(plan);
  if (plan.at("variants").empty())
    throw badInput({asset.file, "", ""},
                   "none of the " + std::to_string(sweep->variants.size()) + " variants could be made");
  const fs::path plan_file = folder / "sweep" / "plan.json";
  const std::string text = plan.dump(1) + "\n";
  if (!sameText(workplace.disk, plan_file, text)) workplace.disk.write(plan_file, text);
  return compareVariants(workplace, request, sweep->comparison, folder, plan_file, quiet);
}

bool settleBudgets(Workplace& workplace, const Request& request, std::vector<Asset>& assets) {
  for (Asset& asset : assets) {
    if (asset.budget.is_null()) continue;
    const ErrorPlace place{asset.file, "", "/budget"};
    const Budget budget = parseBudget(asset.budget, place);
    SweepOptions options;
    for (const std::string& text : request.settings) options.settings.push_back(parseSetting(text));
    const std::optional<Json> report = measureVariants(workplace, request, asset, options, true);
    if (!report) return false;
    const Json choice = chooseVariant(budget, *report, place);
    apply(choice, asset);
    std::cout << asset.name << ": " << choice.at("chosen").get<std::string>() << ", "
              << choice.at("why").get<std::string>() << neighbourText("better", choice.at("next_better"))
              << neighbourText("cheaper", choice.at("next_cheaper")) << '\n';
  }
  return true;
}

void recallBudgets(const Request& request, std::vector<Asset>& assets, const Disk& disk) {
  for (Asset& asset : assets) {
    if (asset.budget.is_null()) continue;
    parseBudget(asset.budget, {asset.file, "", "/budget"});
    const PastRecord record(request.out / asset.name / "record.json", disk);
    const Json choice = record.json().value("budget", Json());
    if (choice.is_object() && choice.contains("parameters")) apply(choice, asset);
  }
}

}  // namespace bakelight::pipeline
