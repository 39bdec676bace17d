// A small pipeline in memory: four tools, the recipe "prt", and what it takes to run it.
#pragma once

#include <string>
#include <vector>

#include "fakes.h"
#include "pipeline/asset.h"
#include "pipeline/build.h"
#include "pipeline/explain.h"

namespace bakelight::pipeline {

class Workshop : public BuildObserver {
 public:
  Workshop();  // tools, recipe, and one asset "assets/cube" with cube.obj and sky.hdr

  void addAsset(const std::string& name, const std::string& mesh_content);
  void writeAssetFile(const std::string& name, const nlohmann::json& content);
  void installAll();

  // Plans and runs, as `bakelight run PATHS`. Throws ProblemsFound.
  BuildResult run(std::vector<std::filesystem::path> paths = {"assets/cube"});
  // "up to date", or the state and the reason: "would run: order changed from 5 to 4".
  std::map<std::string, std::string> explain(std::vector<std::filesystem::path> paths = {"assets/cube"});
  Graph graph(std::vector<std::filesystem::path> paths = {"assets/cube"});
  // What is wrong, one paragraph each; empty if nothing.
  std::vector<std::string> problems(std::vector<std::filesystem::path> paths = {"assets/cube"});

  nlohmann::json record(const std::string& asset = "cube");
  std::vector<std::string> toolsStarted();  // since the last call

  FakeDisk disk;
  FakeRunner runner{disk};
  GraphOptions options;
  BuildSettings settings{.jobs = 1, .cores = 4};
  std::string failing_mesh;  // transfer refuses a mesh of this content
  std::vector<std::string> said_lines;

  void started(TaskIndex) override {}
  void progressed(TaskIndex, const ToolProgress&) override {}
  void said(TaskIndex, const std::string& line) override { said_lines.push_back(line); }
  void settled(TaskIndex, const Outcome&) override {}

 private:
  template <class Work>
  auto withGraph(const std::vector<std::filesystem::path>& paths, Work&& work);
};

}  // namespace bakelight::pipeline
