// The real runner: child processes of this machine, each in a process group of its own.
#pragma once

#include <sys/types.h>
#include <chrono>
#include <deque>
#include <map>

#include "pipeline/runner.h"

namespace bakelight::pipeline {

// While one exists, SIGINT and SIGTERM do not end the process but become Interrupted events. One at a time.
class LocalRunner : public Runner {
 public:
  // `process_descriptors`: whether to try the kernel's; without them (Linux before 5.3, the system call
  // filters of some containers) ends of processes are asked for every few milliseconds.
  explicit LocalRunner(bool process_descriptors = true);
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
    int exit_descriptor = -1;   // readable once the process has ended; -1: the kernel gives none
    int error_descriptor = -1;  // its standard output and error
    std::chrono::steady_clock::time_point start;
    std::string unfinished_line;
    std::optional<Error> error;
  };

  void readLines(Job job, Child& child);
  void takeLine(Job job, Child& child, std::string_view line);
  void reap(Job job);
  void killAll(int signal);
  static bool hasEnded(const Child& child);

  bool process_descriptors_;
  std::map<Job, Child> children_;
  std::deque<Event> events_;
  int signals_reported_ = 0;
  std::optional<std::chrono::steady_clock::time_point> kill_at_;
};

}  // namespace bakelight::pipeline
