// The transfer stage's file as the transfer of a pack.
#pragma once

#include <cstdint>
#include <string>

#include "formats/pack_contents.h"
#include "formats/pixel_transfer.h"
#include "tools/pack/tensor_source.h"

namespace bakelight::packing {

// Throws Error(kBadInput) naming tensor or key for what does not fit `vertices`, for what a
// pack cannot hold, and for values that do not fit `precision` (see PackingOptions).
formats::ShTransfer readTransfer(const TensorSource& source, std::uint64_t vertices,
                                 formats::Precision precision);

// Of transfer in a pixel basis: rows, as transfer writes them, or bicluster's sums.
bool isPixelTechnique(const std::string& technique);
// Of such a technique. Throws likewise.
formats::PixelTransfer readPixelTransfer(const TensorSource& source, std::uint64_t vertices);

}  // namespace bakelight::packing
