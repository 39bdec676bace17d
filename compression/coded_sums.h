// The sums that rows share as one of the ways to store a matrix: by the bytes that their file takes.
#pragma once

#include <cstdint>

#include "compression/compressed_transfer.h"

namespace bakelight::compression {

// Exact.
CompressedTransfer exactSums(const formats::PixelCodes& codes);

// Within the least tolerance whose bytes are within the budget: as many of them as can be had. Cost: a compression for each of some eight tolerances. Throws
// std::invalid_argument if not even a tolerance of 1 fits.
CompressedTransfer sumsWithin(std::uint64_t budget, const formats::PixelCodes& codes);

}  // namespace bakelight::compression
