// Sweeps as commands: run the variants, measure them, and choose by what was measured.
#pragma once

#include <optional>

#include "formats/json.h"
#include "pipeline/sweep.h"
#include "pipeline/workplace.h"

namespace bakelight::pipeline {

// Runs all variants of `asset` through the cache, one stage at a time so that times can be compared, then the
// comparison that its recipe names (`report`). Leaves its files (report.json, report.html) in out/ASSET, variants' packs and references in
// out/ASSET/sweep. Returns the figures, nothing if interrupted. Variants that fail are in it;
// throws Error(kBadInput) if none is left, and what is wrong with the sweep itself. The caller holds the lock
// of the cache.
std::optional<formats::Json> measureVariants(Workplace& workplace, const Request& request, const Asset& asset,
                                             const SweepOptions& options, bool quiet);

// Lets each asset with a budget have the parameters of the variant that keeps it, by measuring its variants.
// False if interrupted.
bool settleBudgets(Workplace& workplace, const Request& request, std::vector<Asset>& assets);

// The same by what the records of the last run say, without measuring.
void recallBudgets(const Request& request, std::vector<Asset>& assets, const Disk& disk);

}  // namespace bakelight::pipeline
