// What the CPU and the GPU make of a translucent object's tables (formats/translucency.h) before they play it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/pack_contents.h"
#include "formats/translucency.h"
#include "formats/triangle_mesh.h"

namespace bakelight::transport {

// Throws std::invalid_argument if the tables' sizes contradict each other.
void requireFit(const formats::Translucency& translucency);

// With values at their precision; columns ascend in each row. `columns`: of the matrix.
formats::SparseRows transposed(const formats::SparseRows& rows, std::size_t columns);

// What a texel gives to a knot: to e its weight times its area, to d its blend.
struct Gift {
  std::uint32_t texel;
  float power;
  formats::Float3 blend;
};
// By knot: that of k has [ends[k − 1], ends[k]), texels ascending.
struct Gifts {
  std::vector<std::uint32_t> ends;
  std::vector<Gift> gifts;
};
Gifts giftsOf(const formats::Translucency& translucency);

// Of the three knots of each texel.
std::vector<formats::Float3> knotWeights(const formats::Translucency& translucency);

// A stain on the surface: the share of exit radiance of each vertex that passes.
std::vector<formats::Float3> stainOf(const formats::Pack& pack);

// receivers × 147, without a basis. On all TBB threads; same values for any number.
std::vector<float> expandedKernels(const formats::Translucency& translucency);

}  // namespace bakelight::transport
