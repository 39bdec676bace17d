// The subcommands of `bakelight`, after the command line is read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace bakelight::pipeline {

struct Request {
  std::vector<std::filesystem::path> paths;  // of assets
  std::filesystem::path out = "out";
  std::filesystem::path tools, data, recipes;  // folders
  std::vector<std::string> settings;           // "transfer.order=5"
  std::vector<std::string> deliver;
  std::size_t jobs = 0, cores = 0;  // 0: as many as the machine has
  bool dry_run = false;
  bool keep_all = false;           // nothing is left out by measurement
  std::string format = "dot";      // of the graph: dot, text, json
  std::filesystem::path baseline;  // folder; empty: beside each asset
  std::vector<std::string> vary;   // of a sweep: "transfer.order=2..6"
};

inline constexpr const char* kCacheFolder = ".cache";  // in Request::out

// Each returns the process's exit status and throws Error or ProblemsFound for what is wrong before anything
// starts.
int runCommand(const Request& request);
int explainCommand(const Request& request);
int graphCommand(const Request& request);
int toolsCommand(const Request& request);
int sweepCommand(const Request& request);
int saveBaselineCommand(const Request& request);
int checkBaselineCommand(const Request& request);

}  // namespace bakelight::pipeline
