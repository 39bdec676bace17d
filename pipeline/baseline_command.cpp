#include "pipeline/baseline_command.h"

#include <algorithm>
#include <iostream>

#include "pipeline/baseline.h"
#include "pipeline/problems.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;

namespace {

fs::path folderFor(const Graph& graph, std::size_t asset, const fs::path& folder) {
  if (folder.empty()) return baselineFolder(graph.assets[asset]);
  return graph.assets.size() == 1 ? folder : folder / graph.assets[asset].name;
}

}  // namespace

int saveBaselines(const Graph& graph, const BuildResult& result, const fs::path& folder,
                  Workplace& workplace) {
  for (std::size_t asset = 0; asset < graph.assets.size(); ++asset) {
    const fs::path own = folderFor(graph, asset, folder);
    saveBaseline(madeAsset(graph, asset, result, workplace.tools), own, workplace.disk);
    std::cout << graph.assets[asset].name << ": baseline saved in " << own.string() << '\n';
  }
  return 0;
}

int checkBaselines(const Graph& graph, const BuildResult& result, const fs::path& folder,
                   const Request& request, Workplace& workplace) {
  const Comparer compare =
      compareTool(request.tools, request.out / kCacheFolder, workplace.runner, workplace.disk);
  Problems problems;
  int status = 0;
  for (std::size_t asset = 0; asset < graph.assets.size(); ++asset)
    problems.attempt([&] {
      const fs::path own = folderFor(graph, asset, folder);
      const BaselineReport report =
          checkBaseline(madeAsset(graph, asset, result, workplace.tools), own, workplace.disk, compare);
      std::cout << graph.assets[asset].name << ", against " << own.string() << '\n';
      print(report, std::cout);
      status = std::max(status, report.exitStatus());
    });
  std::cout.flush();
  problems.throwIfAny();
  return status;
}

}  // namespace bakelight::pipeline
