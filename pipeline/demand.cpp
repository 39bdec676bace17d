#include "pipeline/demand.h"

#include <algorithm>

#include "formats/words.h"

namespace bakelight::pipeline {

Demand::Demand(const Graph& graph)
    : graph_(graph),
      users_(graph.tasks.size()),
      asked_(graph.tasks.size()),
      undecided_(graph.tasks.size()),
      closed_(graph.tasks.size()) {
  for (TaskIndex task = 0; task < graph.tasks.size(); ++task) {
    closed_[task] = !graph.tasks[task].left_out.empty();
    if (closed_[task]) continue;
    for (const TaskIndex maker : graph.makersOf(task)) users_[maker].push_back(task);
    undecided_[task] = graph.mayBeOmitted(task);
  }
  std::vector<TaskIndex> newly;
  for (TaskIndex task = 0; task < graph.tasks.size(); ++task)
    if (!closed_[task] && (!graph.tasks[task].deliverables.empty() || users_[task].empty())) ask(task, newly);
}

std::set<TaskIndex> Demand::awaitedBy(TaskIndex task) const {
  return undecided_[task] ? graph_.judgesOf(task) : graph_.makersOf(task);
}

std::string Demand::userNames(TaskIndex task) const {
  std::set<std::string> names;
  for (const TaskIndex user : users_[task]) names.insert(graph_.tasks[user].stage);
  return formats::join({names.begin(), names.end()}, " and ");
}

std::string Demand::onlyFor(TaskIndex task) const {
  return "only " + userNames(task) + " would need it";
}

std::vector<TaskIndex> Demand::keep(TaskIndex task) {
  undecided_[task] = false;
  std::vector<TaskIndex> newly;
  for (const TaskIndex maker : awaitedBy(task)) ask(maker, newly);
  return newly;
}

std::vector<TaskIndex> Demand::close(TaskIndex task) {
  undecided_[task] = false;
  closed_[task] = true;
  std::vector<TaskIndex> unneeded;
  for (const TaskIndex maker : graph_.makersOf(task)) {
    const bool wanted = asked_[maker] || closed_[maker] ||
                        std::any_of(users_[maker].begin(), users_[maker].end(),
                                    [&](TaskIndex user) { return !closed_[user]; });
    if (wanted) continue;
    unneeded.push_back(maker);
    const std::vector<TaskIndex> further = close(maker);
    unneeded.insert(unneeded.end(), further.begin(), further.end());
  }
  return unneeded;
}

void Demand::ask(TaskIndex task, std::vector<TaskIndex>& newly) {
  if (asked_[task]) return;
  asked_[task] = true;
  newly.push_back(task);
  for (const TaskIndex maker : awaitedBy(task)) ask(maker, newly);
}

}  // namespace bakelight::pipeline
