// Low-frequency transfer as bi-scale radiance transfer stores it (Sloan, Liu, Shum & Snyder 2003): a matrix a vertex from the spherical harmonics of light
// to those of the radiance that falls on it, in its frame.
#pragma once

#include <cstdint>

#include "compression/compressed_transfer.h"

namespace bakelight::compression {

// Projected from the matrix, so that what errs is order and quantisation alone; a step for all entries, solved for the budget. L* is what the
// harmonics say at the cells' middles, × their solid angle: a BTF's sum over cells is then that of the two band-limited functions. Order 1–10. Throws std::invalid_argument
// if the budget is too small.
CompressedTransfer harmonicsWithin(std::uint64_t budget, const formats::PixelCodes& codes, int order);

}  // namespace bakelight::compression
