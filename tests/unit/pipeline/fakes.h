// A disk in memory and a runner that answers from it, so that the driver is tested without files, processes
// or clocks.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "pipeline/build.h"
#include "pipeline/disk.h"
#include "pipeline/runner.h"

namespace bakelight::pipeline {

// Counts what is read. Each change takes a second, so every time stamp is settled.
class FakeDisk : public Disk {
 public:
  std::optional<FileStat> stat(const Path& path) const override;
  std::vector<std::string> list(const Path& folder) const override;
  std::string read(const Path& path) const override;
  std::string hash(const Path& path) const override;
  std::int64_t now_ns() const override;
  void makeFolders(const Path& folder) override;
  void write(const Path& path, std::string_view text) override;
  void copy(const Path& from, const Path& to) override;
  void rename(const Path& from, const Path& to) override;
  void removeAll(const Path& path) override;

  void touch(const Path& path);
  void passTime(std::chrono::nanoseconds time) { clock_ns_ += time.count(); }
  std::vector<std::string> paths() const;  // of all files
  std::vector<std::string> pathsContaining(const std::string& text) const;

  mutable int reads = 0, hashes = 0;
  int writes = 0;
  // Writing and copying to a path that contains this fails as on a full disk; "" never.
  std::string full = "";

 private:
  struct File {
    std::string content;
    std::int64_t mtime_ns;
    std::uint64_t inode;
  };
  void put(const Path& path, std::string content);

  std::map<std::string, File> files_;
  std::set<std::string> folders_;
  std::int64_t clock_ns_ = 1'000'000'000;
  std::uint64_t last_inode_ = 0;
};

// A tool that exists in memory: its outputs tell what it was given.
struct FakeTool {
  nlohmann::json description;
  // Content of each output from contents of the inputs (by port) and the parameters. Throws Error to fail.
  std::function<std::map<std::string, std::string>(const std::map<std::string, std::string>& inputs,
                                                   const nlohmann::json& parameters)>
      make;
  nlohmann::json stats = nlohmann::json::object();  // figures that it tells
};

class FakeRunner : public Runner {
 public:
  explicit FakeRunner(FakeDisk& disk) : disk_(disk) {}

  // Installs an executable of that name in folder "tools"; `revision` is its content.
  void install(const std::string& name, FakeTool tool, const std::string& revision = "1");

  void start(Job job, const std::vector<std::string>& command) override;
  std::optional<Event> wait(int timeout_ms) override;
  void stopAll() override;
  bool interrupted() const override { return interrupted_; }
  Captured capture(const std::vector<std::string>& command) override;

  std::vector<std::vector<std::string>> commands;  // that were started
  std::size_t most_at_once = 0;
  int most_threads_at_once = 0;
  int descriptions = 0;                        // how often --describe was asked
  std::optional<std::size_t> interrupt_after;  // this many starts
  std::map<std::string, int> killed_by;        // tool → signal
  bool last_started_ends_first = false;

  void forgetInterruption();  // as a driver that is started again

  // Names of the tools started, in order.
  std::vector<std::string> toolsStarted() const;

 private:
  struct Started {
    Job job;
    std::vector<std::string> command;
  };
  ToolFinished work(const std::vector<std::string>& command);

  FakeDisk& disk_;
  std::map<std::string, FakeTool> tools_;
  std::deque<Started> running_;
  bool interrupted_ = false, interruption_told_ = false;
};

std::string valueOf(const std::vector<std::string>& command,
                    const std::string& option);  // "" if it is not there

}  // namespace bakelight::pipeline
