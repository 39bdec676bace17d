#include "pipeline/explain.h"

#include <algorithm>
#include <set>
#include <utility>

#include "formats/words.h"
#include "pipeline/companions.h"
#include "pipeline/demand.h"

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

// Follows the demand as a build does, as far as that can be known without running anything.
class Teller {
 public:
  Teller(const Graph& graph, const Explainer& explainer)
      : graph_(graph),
        explainer_(explainer),
        demand_(graph),
        entries_(graph.tasks.size()),
        told_(graph.tasks.size()) {}

  std::vector<Explanation> tellAll() {
    for (TaskIndex task = 0; task < graph_.tasks.size(); ++task)
      if (!graph_.tasks[task].left_out.empty()) tell(task, State::kLeftOut, graph_.tasks[task].left_out);
    while (tellWhatCanBeTold()) {
    }
    std::vector<Explanation> explanations;
    for (TaskIndex task = 0; task < graph_.tasks.size(); ++task) {
      if (!told_[task]) tell(task, State::kWaits, "on whether " + demand_.userNames(task) + " will need it");
      explanations.push_back(*told_[task]);
    }
    return explanations;
  }

 private:
  using State = Explanation::State;

  void tell(TaskIndex task, State state, std::string reason = "") {
    told_[task] = {task, state, std::move(reason)};
  }

  bool tellWhatCanBeTold() {
    bool more = false;
    for (TaskIndex task = 0; task < graph_.tasks.size(); ++task) {
      if (told_[task] || !demand_.asked(task)) continue;
      const std::set<TaskIndex> awaited = demand_.awaitedBy(task);
      if (!std::all_of(awaited.begin(), awaited.end(),
                       [&](TaskIndex maker) { return told_[maker].has_value(); }))
        continue;
      tellNext(task, awaited);
      more = true;
    }
    return more;
  }

  void tellNext(TaskIndex task, const std::set<TaskIndex>& awaited) {
    std::set<std::string> waits;
    for (const TaskIndex maker : awaited)
      if (!entries_[maker] && !isLeftOut(maker)) waits.insert(graph_.tasks[maker].stage);
    if (!waits.empty()) return tellWaiting(task, waits);
    if (!demand_.undecided(task)) return tellVerdict(task);
    if (const auto omission = omissionOf(graph_, task, entries_)) {
      tellLeftOut(task, text(*omission));
      for (const TaskIndex unneeded : demand_.close(task)) tellLeftOut(unneeded, demand_.onlyFor(unneeded));
    } else {
      demand_.keep(task);
    }
  }

  bool isLeftOut(TaskIndex task) const {
    return told_[task]->state == State::kLeftOut || told_[task]->state == State::kLeaveOut;
  }

  void tellWaiting(TaskIndex task, const std::set<std::string>& waits) {
    std::string reason = "on what ";
    reason += formats::join(std::vector<std::string>(waits.begin(), waits.end()), " and ");
    reason += demand_.undecided(task) ? " will tell" : " will make";
    for (const std::string& change : explainer_.changesBesidesInputs(task)) reason += "; " + change;
    tell(task, State::kWaits, std::move(reason));
  }

  void tellLeftOut(TaskIndex task, const std::string& reason) {
    tell(task, explainer_.newlyLeftOut(task, reason) ? State::kLeaveOut : State::kLeftOut, reason);
  }

  void tellVerdict(TaskIndex task) {
    const Verdict verdict = explainer_.judge(task, entries_);
    entries_[task] = verdict.entry;
    if (verdict.mustRun())
      tell(task, State::kRun, formats::join(verdict.changes, "; "));
    else if (!verdict.changes.empty())
      tell(task, State::kFromCache, formats::join(verdict.changes, "; "));
    else if (!verdict.misplaced.empty())
      tell(task, State::kRestore, formats::join(verdict.misplaced, "; "));
    else
      tell(task, State::kUpToDate);
  }

  const Graph& graph_;
  const Explainer& explainer_;
  Demand demand_;
  std::vector<std::optional<CacheEntry>> entries_;  // by task
  std::vector<std::optional<Explanation>> told_;    // by task
};

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
      if (!entries.at(*input.maker)) continue;
      const CachedFile& made = entries.at(*input.maker)->outputs.at(input.port);
      ingredients.inputs[port] = {made.hash, std::filesystem::path(made.name).extension().string()};
    } else if (!input.value.is_null()) {
      ingredients.inputs[port] = {hashWithNamedFiles(input.value, disk_, memo_), ".json"};
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
  else if (past.status.empty())
    changes.emplace_back("never run");
  else if (past.status == nameOf(StageStatus::kLeftOut))
    changes.emplace_back("left out last time");
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

bool Explainer::newlyLeftOut(TaskIndex index, const std::string& reason) const {
  const Task& task = graph_.tasks[index];
  const PastRecord::Stage past = past_.at(task.asset).stage(task.stage);
  return past.status != nameOf(StageStatus::kLeftOut) || past.reason != reason || out_.holds(index);
}

std::vector<std::string> Explainer::changesBesidesInputs(TaskIndex index) const {
  const Task& task = graph_.tasks[index];
  const PastRecord::Stage past = past_.at(task.asset).stage(task.stage);
  if (!past.ingredients) return {};
  Ingredients now = withoutInputs(task);
  now.inputs = past.ingredients->inputs;
  // What figures and rules will make of a parameter is not known yet.
  for (const MeasuredParameter& parameter : task.measured)
    if (past.ingredients->parameters.contains(parameter.name))
      now.parameters[parameter.name] = past.ingredients->parameters[parameter.name];
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
    case Explanation::State::kLeaveOut:
      return "would be left out";
  }
  return "";
}

std::vector<Explanation> explain(const Graph& graph, const Explainer& explainer) {
  return Teller(graph, explainer).tellAll();
}

}  // namespace bakelight::pipeline
