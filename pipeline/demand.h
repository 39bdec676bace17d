// Which tasks of a graph have to be done. Deliverables ask for what they are made from, and so on; but a task that
// a rule may omit asks for its inputs only once it is known to be kept, so that nothing is made for what is left
// out. Known step by step, as tasks are judged; the same for those who build and those who explain.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "pipeline/graph.h"

namespace bakelight::pipeline {

class Demand {
 public:
  // Asked for from the start: what delivers something, what nothing else uses, and what these need.
  explicit Demand(const Graph& graph);

  bool asked(TaskIndex task) const { return asked_[task]; }
  // Whether a rule may still omit `task`: it has such rules, and was neither kept nor closed.
  bool undecided(TaskIndex task) const { return undecided_[task]; }
  // What has to be settled before something can be done about `task`: while it is undecided the makers of the
  // figures that decide, then all its makers.
  std::set<TaskIndex> awaitedBy(TaskIndex task) const;
  // All that may ask for `task`.
  const std::vector<TaskIndex>& usersOf(TaskIndex task) const { return users_[task]; }
  std::string userNames(TaskIndex task) const;  // "idmap and normals"
  std::string onlyFor(TaskIndex task) const;    // why it is left out if nothing asks for it

  // None of the rules omits `task`. Returns what is asked for only now.
  std::vector<TaskIndex> keep(TaskIndex task);
  // `task` is omitted, or will not be made for another reason. Returns what nothing can ask for any more, which is
  // closed, too.
  std::vector<TaskIndex> close(TaskIndex task);

 private:
  void ask(TaskIndex task, std::vector<TaskIndex>& newly);

  const Graph& graph_;
  std::vector<std::vector<TaskIndex>> users_;  // by task, as all that follow
  std::vector<bool> asked_, undecided_, closed_;
};

}  // namespace bakelight::pipeline
