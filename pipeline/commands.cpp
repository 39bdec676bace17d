#include "pipeline/commands.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <thread>

#include "formats/error.h"
#include "pipeline/baseline_command.h"
#include "pipeline/budget.h"
#include "pipeline/explain.h"
#include "pipeline/graph.h"
#include "pipeline/graph_export.h"
#include "pipeline/measure.h"
#include "pipeline/problems.h"
#include "pipeline/workplace.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr auto kLockRetry = std::chrono::milliseconds(100);

fs::path cacheFolder(const Request& request) {
  return request.out / kCacheFolder;
}

GraphOptions graphOptions(const Request& request, Problems& problems) {
  GraphOptions options{.deliver = request.deliver, .keep_all = request.keep_all};
  for (const std::string& text : request.settings)
    problems.attempt([&] { options.settings.push_back(parseSetting(text)); });
  return options;
}

// Checked together with all their stages.
std::vector<Asset> checkedAssets(const Request& request, Workplace& workplace) {
  Problems problems;
  const GraphOptions options = graphOptions(request, problems);
  std::vector<Asset> assets =
      findAssets(request.paths, request.data, workplace.recipes, workplace.disk, problems);
  problems.attempt([&] { recallBudgets(request, assets, workplace.disk); });
  makeGraph(assets, workplace.recipes, workplace.tools, options, problems);
  problems.throwIfAny();
  return assets;
}

Graph graphOf(const Request& request, Workplace& workplace, std::vector<Asset> assets) {
  Problems problems;
  const GraphOptions options = graphOptions(request, problems);
  Graph graph = makeGraph(std::move(assets), workplace.recipes, workplace.tools, options, problems);
  problems.throwIfAny();
  return graph;
}

std::vector<Explanation> explanations(const Request& request, Workplace& workplace, const Graph& graph) {
  const OutputFolder out(request.out, graph, workplace.disk, workplace.memo);
  const std::vector<PastRecord> past = pastRecords(graph, out, workplace.disk);
  return explain(
      graph, Explainer(graph, workplace.tools, workplace.cache, out, workplace.disk, workplace.memo, past));
}

void print(const Graph& graph, const Explanation& explanation) {
  std::cout << graph.nameOf(explanation.task) << ": " << nameOf(explanation.state)
            << (explanation.reason.empty() ? "" : ": ") << explanation.reason << '\n';
}

int dryRun(const Request& request) {
  Workplace workplace(request);
  const Graph graph = graphOf(request, workplace, checkedAssets(request, workplace));
  std::size_t shown = 0;
  for (const Explanation& explanation : explanations(request, workplace, graph)) {
    using State = Explanation::State;
    if (explanation.state == State::kUpToDate || explanation.state == State::kLeftOut) continue;
    print(graph, explanation);
    ++shown;
  }
  if (shown == 0) std::cout << "everything is up to date\n";
  return 0;
}

// Whether the lock was got: false if the user gave up waiting.
bool waitFor(FolderLock& lock, const LocalRunner& runner, const fs::path& folder) {
  if (lock.tryLock()) return true;
  std::cerr << "bakelight: another run works in " << folder.string() << "; waiting for it" << std::endl;
  while (!runner.interrupted()) {
    std::this_thread::sleep_for(kLockRetry);
    if (lock.tryLock()) return true;
  }
  return false;
}

std::string text(const formats::ParameterDescription& parameter) {
  std::string line = "    " + parameter.name + " = " + parameter.default_value.dump();
  if (!parameter.unit.empty()) line += " " + parameter.unit;
  return line + ": " + parameter.help + "; " + formats::expectation(parameter) + "\n";
}

std::string text(const char* direction, const formats::PortDescription& port) {
  return std::string("    ") + direction + " " + port.name + " (" + port.kind +
         (port.required ? "" : ", optional") + "): " + port.help + "\n";
}

void print(const formats::ToolDescription& tool) {
  std::string lines = tool.tool + ": " + tool.summary + "\n";
  for (const auto& port : tool.inputs) lines += text("input", port);
  for (const auto& port : tool.outputs) lines += text("output", port);
  for (const auto& parameter : tool.parameters) lines += text(parameter);
  std::cout << lines;
}

void tellFront(const formats::Json& report, const fs::path& folder) {
  std::cout << "on the front of error against milliseconds a frame, of " << report.at("variants").size()
            << " variants:\n";
  for (const formats::Json& variant : report.at("variants")) {
    const formats::Json& front = report.at("pareto");
    if (std::find(front.begin(), front.end(), variant.at("name")) == front.end()) continue;
    std::cout << "  " << variant.at("name").get<std::string>() << ": " << figuresText(variant) << '\n';
  }
  std::cout << "  " << (folder / "report.html").string() << '\n';
}

// The report of the asset's variants; false if that was interrupted.
bool measure(Workplace& workplace, const Request& request, const Asset& asset,
             const std::vector<std::string>& vary) {
  SweepOptions options{.vary = vary};
  for (const std::string& text : request.settings) options.settings.push_back(parseSetting(text));
  const std::optional<formats::Json> report = measureVariants(workplace, request, asset, options, false);
  workplace.memo.save();
  if (report) tellFront(*report, request.out / asset.name);
  return report.has_value();
}

// Makes what the assets deliver, then `finish`, which returns the exit status.
int runAssets(const Request& request,
              const std::function<int(const Graph&, const BuildResult&, Workplace&)>& finish) {
  Workplace workplace(request);  // nothing is made in the output folder before all is found to be right
  std::vector<Asset> assets = checkedAssets(request, workplace);
  FolderLock lock(cacheFolder(request));
  if (!waitFor(lock, workplace.runner, request.out)) return static_cast<int>(ExitStatus::kInterrupted);
  workplace.cache.removeTemporaries();
  if (!settleBudgets(workplace, request, assets)) return static_cast<int>(ExitStatus::kInterrupted);
  const Graph graph = graphOf(request, workplace, std::move(assets));
  const BuildResult result = runGraph(workplace, graph, request.out, buildSettings(request));
  workplace.memo.save();
  return finish(graph, result, workplace);
}

}  // namespace

int runCommand(const Request& request) {
  if (request.dry_run) return dryRun(request);
  return runAssets(request, [&](const Graph& graph, const BuildResult& result, Workplace& workplace) {
    if (const int status = result.exitStatus(); status != 0) return status;
    for (const Asset& asset : graph.assets)
      if (asset.report_with_run && !measure(workplace, request, asset, {}))
        return static_cast<int>(ExitStatus::kInterrupted);
    return 0;
  });
}

int saveBaselineCommand(const Request& request) {
  return runAssets(request, [&](const Graph& graph, const BuildResult& result, Workplace& workplace) {
    const int status = result.exitStatus();
    return status != 0 ? status : saveBaselines(graph, result, request.baseline, workplace);
  });
}

int checkBaselineCommand(const Request& request) {
  return runAssets(request, [&](const Graph& graph, const BuildResult& result, Workplace& workplace) {
    const int status = result.exitStatus();
    return status != 0 ? status : checkBaselines(graph, result, request.baseline, request, workplace);
  });
}

int explainCommand(const Request& request) {
  Workplace workplace(request);
  const Graph graph = graphOf(request, workplace, checkedAssets(request, workplace));
  for (const Explanation& explanation : explanations(request, workplace, graph)) print(graph, explanation);
  return 0;
}

int graphCommand(const Request& request) {
  Workplace workplace(request);
  const Graph graph = graphOf(request, workplace, checkedAssets(request, workplace));
  if (request.format == "json")
    std::cout << toJson(graph).dump(2) << '\n';
  else
    std::cout << (request.format == "text" ? toText(graph) : toDot(graph));
  return 0;
}

int sweepCommand(const Request& request) {
  Workplace workplace(request);
  const std::vector<Asset> assets = checkedAssets(request, workplace);
  FolderLock lock(cacheFolder(request));
  if (!waitFor(lock, workplace.runner, request.out)) return static_cast<int>(ExitStatus::kInterrupted);
  workplace.cache.removeTemporaries();
  for (const Asset& asset : assets)
    if (!measure(workplace, request, asset, request.vary)) return static_cast<int>(ExitStatus::kInterrupted);
  return 0;
}

int toolsCommand(const Request& request) {
  Workplace workplace(request);
  RecipeBook& recipes = workplace.recipes;
  Toolbox& tools = workplace.tools;
  std::set<std::string> names;
  for (const std::string& recipe : recipes.names())
    for (const auto& [name, stage] : recipes.require(recipe, {}).stages) names.insert(stage.tool);
  for (const std::string& name : names) {
    if (tools.has(name))
      print(tools.require(name, {}).description);
    else
      std::cout << name << ": not in " << request.tools.string() << '\n';
  }
  return 0;
}

}  // namespace bakelight::pipeline
