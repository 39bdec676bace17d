// Transfer fitted at the vertices to samples all over the triangles, in place of that at the vertices (Kavan, Bargteil &
// Sloan 2011, "Least Squares Vertex Baking"): what is interpolated errs less, of the same bytes.
#pragma once

#include <cstdint>
#include <span>

#include "tools/stage/progress.h"
#include "tools/transfer/bake_setup.h"
#include "transport/interreflection.h"

namespace bakelight::transfer {

// Corrects the vectors and near-field vectors of `result`, which are those at the vertices, and fills in its figures. Rays
// of a sample start at transport::smoothPoint, as those of a path-traced pixel do; what they meet sends on what `exit`
// says of it (null without bounces; columns: sets × channels × order²; a row a side of the vertices, by `row_of_side`).
// With an original each sample is moved to the nearest point of that, and its rays meet nothing else: what the simplified
// mesh lost is fitted, too.
//
// Samples are not kept: memory is that of transport::VertexFit. `progress` advances by one a triangle.
void fitToSamples(const BakeSetup& setup, const transport::TransferField* exit,
                  std::span<const std::uint32_t> row_of_side, Transfer& result, stage::Progress* progress);

}  // namespace bakelight::transfer
