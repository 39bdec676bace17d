// What a build says to the person who started it: one line a finished stage, on a terminal a live line below.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <ostream>
#include <string>

#include "pipeline/build.h"
#include "pipeline/graph.h"
#include "pipeline/output_folder.h"

namespace bakelight::pipeline {

class Console : public BuildObserver {
 public:
  // Lines go to `lines`, errors and the live line to `errors`; `live`: `errors` is a terminal.
  Console(const Graph& graph, std::ostream& lines, std::ostream& errors, bool live);

  void started(TaskIndex task) override;
  void progressed(TaskIndex task, const ToolProgress& progress) override;
  void said(TaskIndex task, const std::string& line) override;
  void settled(TaskIndex task, const Outcome& outcome) override;

  // One line if nothing had to be done, else counts and where the deliverables are.
  void summarize(const BuildResult& result, const OutputFolder& out);

 private:
  std::string label(TaskIndex task) const;  // "bunny transfer ", padded to one width
  void tellLeftOut(TaskIndex task, const Outcome& outcome);
  void line(const std::string& text);
  void error(const std::string& text);
  void clearLive();
  void drawLive();

  const Graph& graph_;
  std::ostream& lines_;
  std::ostream& errors_;
  const bool live_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point next_draw_ = start_;
  std::size_t label_width_ = 0, settled_count_ = 0, stage_count_ = 0;  // without what is left out
  std::map<TaskIndex, ToolProgress> running_;
  TaskIndex latest_ = 0;  // that told its progress last
  bool live_shown_ = false;
};

// "1.9 s", "2 min 5 s", "3 h 20 min".
std::string durationText(double seconds);
// [████      ] without the brackets, `fraction` from 0 to 1.
std::string barText(double fraction, int width);

}  // namespace bakelight::pipeline
