// BTFs as a pack holds them: factored, with a pyramid.
#pragma once

#include <string>

#include "formats/btf.h"
#include "formats/btf_reflection.h"
#include "tools/pack/rtt_packing.h"

namespace bakelight::packing {

struct BtfPackingOptions {
  // Principal components are taken until what they leave is less: relative root mean square over all lights, views, texels and
  // colors. 0 takes all.
  double error = 0.04;
  formats::Precision precision = formats::Precision::kFloat16;
};

struct PackedBtf {
  formats::BtfReflection reflection;  // without patch_width, index and repeats
  double ratio = 0;                   // bytes of all values as floats ÷ those of factors and basis
};

// The BTF's views and lights are the middles of hemisphere grids, in any order, as `rtt --btf` writes them: values are means over
// the cells of light. Where the file has no cosines inside, the mean cosine of each cell is multiplied in. Throws Error(kBadInput)
// naming the file for other directions, missing pictures or another grid of lights than `local_side`. Holds all values as floats.
PackedBtf packBtf(const formats::Btf& btf, int local_side, const BtfPackingOptions& options);

}  // namespace bakelight::packing
