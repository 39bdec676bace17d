#include "pipeline/explain.h"

#include <set>
#include <utility>

#include "pipeline/companions.h"
#include "pipeline/json_object.h"

namespace bakelight::pipeline {
namespace {

// For each input: what it is, and what became of it if it is another one than before.
std::map<std::string, std::string> originsOf(const Graph& graph, const Task& task) {
  std::map<std::string, std::string> origins;
  for (const auto& [port, input] : task.inputs) {
    if (!input.maker) {
      origins[port] = input.file.string();
      continue;
    }
    const Task& maker = graph.tasks[*input.maker];
    origins[port] = maker.stage + " made a different " + maker.outputs.at(input.port);
  }
  return origins;
}

}  // namespace

Explainer::Explainer(const Graph& graph, Toolbox& tools, const Cache& cache, const OutputFolder& out,
                     const Disk& disk, Memo& memo, const std::vector<PastRecord>& past)
    : graph_(graph), tools_(tools), cache_(cache), out_(out), disk_(disk), memo_(memo), past_(past) {}

Ingredients Explainer::withoutInputs(const Task& task) const {
  const InstalledTool& tool = tools_.require(task.tool, {});
  return {.tool = task.tool,
          .tool_hash = tool.hash,
          .execution_path = tool.description.execution_path,
          .parameters = task.parameters,
          .outputs = task.outputs};
}

Ingredients Explainer::ingredientsOf(const Task& task, formats::Json parameters,
                                     const std::vector<std::optional<CacheEntry>>& entries) const {
  Ingredients ingredients = withoutInputs(task);
  ingredients.parameters = std::move(parameters);
  for (const auto& [port, input] : task.inputs) {
    if (input.maker) {
      const CachedFile& made = entries.at(*input.maker)->outputs.at(input.port);
      ingredients.inputs[port] = {made.hash, std::filesystem::path(made.name).extension().string()};
    } else if (!input.value.is_null()) {
      ingredients.inputs[port] = {hashWithCompanions(input.value, memo_), ".json"};
    } else {
      ingredients.inputs[port] = {hashWithCompanions(input.file, disk_, memo_),
                                  input.file.extension().string()};
    }
  }
  return ingredients;
}

std::vector<std::string> Explainer::changesSince(const PastRecord::Stage& past, const Task& task,
                                                 const Verdict& verdict, const std::string& damage) const {
  std::vector<std::string> changes;
  if (past.ingredients)
    changes = differences(*past.ingredients, verdict.ingredients, originsOf(graph_, task));
  else if (past.status.empty() || past.status == nameOf(StageStatus::kLeftOut))
    changes.emplace_back("never run");
  if (past.status == nameOf(StageStatus::kFailed)) changes.emplace_back("failed last time");
  if (past.status == nameOf(StageStatus::kNotRun)) changes.push_back(past.reason + " last time");
  if (verdict.entry) return changes;
  if (!damage.empty())
    changes.push_back(damage + " in the cache");
  else if (changes.empty())
    changes.emplace_back("the cache has it no more");
  return changes;
}

Verdict Explainer::judge(TaskIndex index, const std::vector<std::optional<CacheEntry>>& entries) const {
  const Task& task = graph_.tasks[index];
  Verdict verdict;
  SettledTask settled = settle(graph_, index, entries);
  verdict.ingredients = ingredientsOf(task, std::move(settled.parameters), entries);
  verdict.omissions = std::move(settled.omissions);
  Lookup lookup = cache_.find(verdict.ingredients.key());
  verdict.entry = std::move(lookup.entry);
  verdict.changes = changesSince(past_.at(task.asset).stage(task.stage), task, verdict, lookup.damage);
  if (verdict.entry) verdict.misplaced = out_.differences(index, *verdict.entry);
  return verdict;
}

std::vector<std::string> Explainer::changesBesidesInputs(TaskIndex index) const {
  const Task& task = graph_.tasks[index];
  const PastRecord::Stage past = past_.at(task.asset).stage(task.stage);
  if (!past.ingredients) return {};
  Ingredients now = withoutInputs(task);
  now.inputs = past.ingredients->inputs;
  // What the rules will make of a parameter is not known yet.
  for (const TaskRule& rule : task.rules)
    for (const auto& [parameter, values] : rule.rule.set)
      if (past.ingredients->parameters.contains(parameter))
        now.parameters[parameter] = past.ingredients->parameters[parameter];
  return differences(*past.ingredients, now, originsOf(graph_, task));
}

const char* nameOf(Explanation::State state) {
  switch (state) {
    case Explanation::State::kUpToDate:
      return "up to date";
    case Explanation::State::kRestore:
      return "would be restored";
    case Explanation::State::kFromCache:
      return "would come from the cache";
    case Explanation::State::kRun:
      return "would run";
    case Explanation::State::kWaits:
      return "depends";
    case Explanation::State::kLeftOut:
      return "left out";
  }
  return "";
}

std::vector<Explanation> explain(const Graph& graph, const Explainer& explainer) {
  using State = Explanation::State;
  std::vector<std::optional<CacheEntry>> entries(graph.tasks.size());
  std::vector<Explanation> explanations;
  for (TaskIndex index = 0; index < graph.tasks.size(); ++index) {
    const Task& task = graph.tasks[index];
    if (!task.left_out.empty()) {
      explanations.push_back({index, State::kLeftOut, task.left_out});
      continue;
    }
    std::set<std::string> waits;
    for (const TaskIndex maker : graph.makersOf(index))
      if (!entries[maker]) waits.insert(graph.tasks[maker].stage);
    if (!waits.empty()) {
      std::string reason = "on what ";
      reason += join(std::vector<std::string>(waits.begin(), waits.end()), " and ");
      reason += " will make";
      for (const std::string& change : explainer.changesBesidesInputs(index)) reason += "; " + change;
      explanations.push_back({index, State::kWaits, std::move(reason)});
      continue;
    }
    const Verdict verdict = explainer.judge(index, entries);
    entries[index] = verdict.entry;
    if (verdict.mustRun())
      explanations.push_back({index, State::kRun, join(verdict.changes, "; ")});
    else if (!verdict.changes.empty())
      explanations.push_back({index, State::kFromCache, join(verdict.changes, "; ")});
    else if (!verdict.misplaced.empty())
      explanations.push_back({index, State::kRestore, join(verdict.misplaced, "; ")});
    else
      explanations.push_back({index, State::kUpToDate, ""});
  }
  return explanations;
}

}  // namespace bakelight::pipeline
