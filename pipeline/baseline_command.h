// `bakelight baseline`, once the assets are made.
#pragma once

#include <filesystem>

#include "pipeline/build.h"
#include "pipeline/graph.h"
#include "pipeline/workplace.h"

namespace bakelight::pipeline {

// Baselines of all assets of `graph`, which `result` made without a failure: in baselineFolder() of each, or
// in `folder` if that is not empty; of several assets each in a folder of its name there. Tell on standard
// output what they do.
//
// Throws Error or ProblemsFound; what was saved by then stays.
int saveBaselines(const Graph& graph, const BuildResult& result, const std::filesystem::path& folder,
                  Workplace& workplace);
// 1 if anything differs. Compares all assets before it throws Error or ProblemsFound (exit status 2) for
// those that have no baseline, a damaged one, or one of another recipe. `request` names tools and cache.
int checkBaselines(const Graph& graph, const BuildResult& result, const std::filesystem::path& folder,
                   const Request& request, Workplace& workplace);

}  // namespace bakelight::pipeline
