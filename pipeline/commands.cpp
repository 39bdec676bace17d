#include "pipeline/commands.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "formats/error.h"
#include "pipeline/asset.h"
#include "pipeline/build.h"
#include "pipeline/cache.h"
#include "pipeline/console.h"
#include "pipeline/disk.h"
#include "pipeline/explain.h"
#include "pipeline/graph.h"
#include "pipeline/graph_export.h"
#include "pipeline/json_object.h"
#include "pipeline/local_runner.h"
#include "pipeline/memo.h"
#include "pipeline/output_folder.h"
#include "pipeline/record.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr auto kLockRetry = std::chrono::milliseconds(100);

fs::path cacheFolder(const Request& request) {
  return request.out / ".cache";
}

Graph checkedGraph(const Request& request, const Disk& disk, RecipeBook& recipes, Toolbox& tools) {
  Problems problems;
  GraphOptions options{.deliver = request.deliver};
  for (const std::string& text : request.settings)
    problems.attempt([&] { options.settings.push_back(parseSetting(text)); });
  std::vector<Asset> assets = findAssets(request.paths, request.data, recipes, disk, problems);
  Graph graph = makeGraph(std::move(assets), recipes, tools, options, problems);
  problems.throwIfAny();
  return graph;
}

// What every command on assets works with. Making one changes nothing on the disk; the graph is whole and
// checked.
struct Session {
  RealDisk disk;
  LocalRunner runner;
  Memo memo;
  RecipeBook recipes;
  Toolbox tools;
  Graph graph;
  OutputFolder out;
  Cache cache;
  std::vector<PastRecord> past;  // by asset; see readRecords

  explicit Session(const Request& request)
      : memo(cacheFolder(request) / "memo.json", disk),
        recipes(request.recipes, disk),
        tools(request.tools, processorIdentity(), disk, runner, memo),
        graph(checkedGraph(request, disk, recipes, tools)),
        out(request.out, graph, disk, memo),
        cache(cacheFolder(request), disk, memo) {}

  // What the runs before left behind. A run does so once it holds the folder's lock.
  void readRecords() {
    for (std::size_t asset = 0; asset < graph.assets.size(); ++asset)
      past.emplace_back(out.recordOf(asset), disk);
  }

  std::vector<Explanation> explanations() {
    readRecords();
    return explain(graph, Explainer(graph, tools, cache, out, disk, memo, past));
  }
};

void print(const Graph& graph, const Explanation& explanation) {
  std::cout << graph.nameOf(explanation.task) << ": " << nameOf(explanation.state)
            << (explanation.reason.empty() ? "" : ": ") << explanation.reason << '\n';
}

int dryRun(const Request& request) {
  Session session(request);
  std::size_t shown = 0;
  for (const Explanation& explanation : session.explanations()) {
    using State = Explanation::State;
    if (explanation.state == State::kUpToDate || explanation.state == State::kLeftOut) continue;
    print(session.graph, explanation);
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

BuildSettings buildSettings(const Request& request) {
  const std::size_t machine = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t cores = request.cores != 0 ? request.cores : machine;
  return {.jobs = request.jobs != 0 ? request.jobs : cores, .cores = cores};
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

}  // namespace

int runCommand(const Request& request) {
  if (request.dry_run) return dryRun(request);
  Session session(request);  // nothing is made in the output folder before all is found to be right
  FolderLock lock(cacheFolder(request));
  if (!waitFor(lock, session.runner, request.out)) return static_cast<int>(ExitStatus::kInterrupted);
  session.readRecords();
  session.cache.removeTemporaries();
  Console console(session.graph, std::cout, std::cerr, ::isatty(STDERR_FILENO) == 1);
  Build build({session.graph, session.tools, session.cache, session.out, session.memo, session.disk,
               session.runner, console},
              session.past, buildSettings(request));
  const BuildResult result = build.run();
  console.summarise(result, session.out);
  session.memo.save();
  return result.exitStatus();
}

int explainCommand(const Request& request) {
  Session session(request);
  for (const Explanation& explanation : session.explanations()) print(session.graph, explanation);
  return 0;
}

int graphCommand(const Request& request) {
  Session session(request);
  if (request.format == "json")
    std::cout << toJson(session.graph).dump(2) << '\n';
  else
    std::cout << (request.format == "text" ? toText(session.graph) : toDot(session.graph));
  return 0;
}

int toolsCommand(const Request& request) {
  RealDisk disk;
  LocalRunner runner;
  Memo memo(cacheFolder(request) / "memo.json", disk);
  RecipeBook recipes(request.recipes, disk);
  Toolbox tools(request.tools, processorIdentity(), disk, runner, memo);
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
