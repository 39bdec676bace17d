// How good a synthesized texture is, as figures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/mesomesh/synthesis/correction.h"

namespace bakelight::mesomesh {

// Errors compare what the vertices around a vertex predict with what is there, as synthesis sees it: 0 fits
// exactly, 1 is how much two places of the exemplar that were taken at random differ. In ratios, what is below
// the rounding of appearances counts as that.
struct SynthesisQuality {
  double neighborhood_error = 0;  // mean over a hashed sample of 4096 vertices
  // The same with each vertex of the sample at the best of all places of the exemplar (to a quarter of a
  // texel), its neighbors as they are.
  double best_neighborhood_error = 0;
  // The first ÷ the second.
  double neighborhood_error_ratio = 1;
  // What the ratio would be with each vertex of the sample at a random place, its neighbors as they are.
  double random_ratio = 1;
  // Share of neighboring pairs whose coordinates differ by their distance on the surface, to half a texel:
  // below 0.4 it is noise, above 0.95 a tiling.
  double coherent_share = 1;
  // Share of the exemplars' texels that some vertex takes, where there are vertices enough (four a texel;
  // of exemplars with fewer, the share of as many cells); mean over exemplars in use.
  double coverage = 1;
  // Of how often cells are taken, ÷ its greatest value: 1 where all are as often. Mean over exemplars.
  double entropy = 1;
  // Mean error of vertices on a seam ÷ that of the others, over all vertices; 1 where there is no seam.
  double seam_ratio = 1;
  std::size_t seam_vertices = 0;
};

// Of the finest level. `on_seam`: of each vertex. Cost: 4096 · 16 · texels beside what is linear in vertices.
SynthesisQuality measureQuality(const LevelState& level, std::span<const std::uint8_t> on_seam,
                                const std::vector<FixedPoint>& coordinates);

}  // namespace bakelight::mesomesh
