// Benchmarks of synthesis, part of bench_mesomesh.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "tests/support/textured_surface.h"

namespace bakelight::mesomesh {

// What the benchmarks lay patches out on: with directions of so many folds, and 1 for each vertex beside a
// chart's border of an atlas.
struct SynthesisSurface {
  tests::TexturedSurface surface;
  std::vector<std::uint8_t> on_seam;
};

// Registers synthesis of three exemplars over the surface, and what gives its figures a meaning: places at
// random on it, a tiling, and the exhaustive search.
void registerSynthesis(const std::function<const SynthesisSurface&(int folds)>& surface);

}  // namespace bakelight::mesomesh
