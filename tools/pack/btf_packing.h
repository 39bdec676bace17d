// BTFs as a pack holds them: factored, with a pyramid.
#pragma once

#include <string>

#include "formats/btf.h"
#include "formats/btf_reflection.h"
#include "tools/pack/rtt_packing.h"

namespace bakelight::packing {

struct BtfPackingOptions {
  // Relative root mean square over all lights, views, texels and colors that the pack may leave. 0: all components, uncoded.
  double error = 0.075;
  formats::Precision precision = formats::Precision::kFloat16;  // of factors as they are played
};

struct PackedBtf {
  formats::BtfReflection reflection;  // without patch_width, index and repeats
  double components_error = 0;        // of `reflection.error`, what the components leave
  std::size_t value_count = 0;        // texels · views · lights · colors
  std::size_t stored_bytes = 0;       // of factors, basis and heights in the pack
};

// All values of a BTF, [view][texel][color][light], as factored() takes them.
struct BtfSamples {
  std::string file;  // for messages
  int views = 1, lights = 1, width = 0, height = 0;
  std::vector<float> values;
};
// Views and lights are the middles of hemisphere grids, in any order, as `rtt --btf` writes them: values are means over the cells of light. Where the
// file has no cosines inside, the mean cosine of each cell is multiplied in. Throws Error(kBadInput) naming the file for other directions or missing
// pictures.
BtfSamples samplesOf(const formats::Btf& btf);
BtfSamples samplesOf(const formats::BtfTable& table);

// `texture` (or null) is of the same run and brings heights if it is of the same size. Throws Error(kBadInput) naming the file for another grid of
// lights than `local_side`.
PackedBtf packBtf(const BtfSamples& samples, int local_side, const BtfPackingOptions& options,
                  const formats::RadianceTransferTexture* texture = nullptr,
                  const RttPackingOptions& relief = {});

}  // namespace bakelight::packing
