// What every command on assets works with, and how a graph is run on it.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/build.h"
#include "pipeline/commands.h"
#include "pipeline/disk.h"
#include "pipeline/local_runner.h"
#include "pipeline/memo.h"
#include "pipeline/recipe.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {

// Making one changes nothing on the disk.
struct Workplace {
  RealDisk disk;
  LocalRunner runner;
  Memo memo;
  RecipeBook recipes;
  Toolbox tools;
  Cache cache;

  explicit Workplace(const Request& request);
};

// The records that earlier runs left in `out`, by asset.
std::vector<PastRecord> pastRecords(const Graph& graph, const OutputFolder& out, const Disk& disk);

// The request's stages at once and cores; `jobs` where it does not say.
BuildSettings buildSettings(const Request& request, std::size_t jobs = 0);

// Runs `graph` into `folder` and tells on the console what happens. With `quiet`, not that all is up to date.
// The caller holds the lock of the cache.
BuildResult runGraph(Workplace& workplace, const Graph& graph, const std::filesystem::path& folder,
                     const BuildSettings& settings, bool quiet = false);

}  // namespace bakelight::pipeline
