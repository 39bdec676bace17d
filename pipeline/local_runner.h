// The real runner: child processes of this machine, each in a process group of its own.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <deque>
#include <map>

#include "pipeline/runner.h"

namespace bakelight::pipeline {

// While one exists, SIGINT and SIGTERM do not end the process but become Interrupted events, and SIGCHLD
// wakes wait(): every kernel and container has it, which cannot be said of process descriptors. One at a
// time.
class LocalRunner : public Runner {
 public:
  LocalRunner();
  ~LocalRunner() override;
  LocalRunner(const LocalRunner&) = delete;
  LocalRunner& operator=(const LocalRunner&) = delete;

  void start(Job job, const std::vector<std::string>& command) override;
  std::optional<Event> wait(int timeout_ms) override;
  void stopAll() override;
  bool interrupted() const override;
  Captured capture(const std::vector<std::string>& command) override;

 private:
  struct Child {
    pid_t pid = -1;
    int error_descriptor = -1;  // its standard output and error
    std::chrono::steady_clock::time_point start;
    std::string unfinished_line;
    std::optional<Error> error;
  };

  void readLines(Job job, Child& child);
  void takeLine(Job job, Child& child, std::string_view line);
  void reap(Job job);
  void reapEnded();
  void killAll(int signal);

  std::map<Job, Child> children_;
  std::deque<Event> events_;
  int signals_reported_ = 0;
  std::optional<std::chrono::steady_clock::time_point> kill_at_;
};

}  // namespace bakelight::pipeline
