#include "pipeline/workplace.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <thread>

#include "pipeline/console.h"

namespace bakelight::pipeline {

Workplace::Workplace(const Request& request)
    : memo(request.out / kCacheFolder / "memo.json", disk),
      recipes(request.recipes, disk),
      tools(request.tools, processorIdentity(), disk, runner, memo),
      cache(request.out / kCacheFolder, disk, memo) {}

std::vector<PastRecord> pastRecords(const Graph& graph, const OutputFolder& out, const Disk& disk) {
  std::vector<PastRecord> past;
  for (std::size_t asset = 0; asset < graph.assets.size(); ++asset)
    past.emplace_back(out.recordOf(asset), disk);
  return past;
}

BuildSettings buildSettings(const Request& request, std::size_t jobs) {
  const std::size_t machine = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t cores = request.cores != 0 ? request.cores : machine;
  const std::size_t otherwise = jobs != 0 ? jobs : cores;
  return {.jobs = request.jobs != 0 ? request.jobs : otherwise, .cores = cores};
}

BuildResult runGraph(Workplace& workplace, const Graph& graph, const std::filesystem::path& folder,
                     const BuildSettings& settings, bool quiet) {
  OutputFolder out(folder, graph, workplace.disk, workplace.memo);
  const std::vector<PastRecord> past = pastRecords(graph, out, workplace.disk);
  Console console(graph, std::cout, std::cerr, ::isatty(STDERR_FILENO) == 1);
  Build build({graph, workplace.tools, workplace.cache, out, workplace.memo, workplace.disk, workplace.runner,
               console},
              past, settings);
  BuildResult result = build.run();
  const bool nothing_done =
      std::all_of(result.outcomes.begin(), result.outcomes.end(), [](const Outcome& outcome) {
        return outcome.status == StageStatus::kLeftOut ||
               (outcome.status == StageStatus::kCached && !outcome.published);
      });
  if (!quiet || !nothing_done) console.summarize(result, out);
  return result;
}

}  // namespace bakelight::pipeline
