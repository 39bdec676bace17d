// The last phase of a bake: everything that needs all points at once.
#pragma once

#include "tools/transfer/bake_setup.h"
#include "tools/transfer/trace_phase.h"

namespace bakelight::transfer {

// `fronts` are those of all vertices. Resamples outliers, fills what is buried, traces the backs that are
// seen, bounces light, fits what is at the vertices to samples all over the triangles, and makes matrices, as the setup
// asks for. `progress` advances by one per triangle whose samples are traced.
Transfer solve(BakeSetup setup, TracedPoints fronts, stage::Progress* progress = nullptr);

}  // namespace bakelight::transfer
