// The last phase of a bake: everything that needs all points at once.
#pragma once

#include "tools/transfer/bake_setup.h"
#include "tools/transfer/trace_phase.h"

namespace bakelight::transfer {

// `fronts` are those of all vertices. Resamples outliers, fills what is buried, traces the backs that are
// seen, bounces light, and makes matrices, as the setup asks for.
Transfer solve(BakeSetup setup, TracedPoints fronts);

}  // namespace bakelight::transfer
