// Exactly lossless compression of a transfer matrix in a pixel basis.
//
// The published method (all-frequency bi-scale radiance transfer, IV.B–C) takes submatrices of constant columns out of the matrix, with
// negative residuals. This one takes disjoint sets of texels that rows share: rows are sorted into tiles by where they look;
// a tile's rows are cut along a fixed lattice into pieces that are common, and pieces that occur together are joined, again and
// again. The result is a straight-line program of additions (formats/sum_grammar.h).
#pragma once

#include <cstdint>

#include "compression/tile_sums.h"
#include "formats/pixel_transfer.h"
#include "formats/sum_grammar.h"

namespace bakelight::compression {

// On all TBB threads; the same whatever their number. Time and memory are linear in the entries. Throws std::invalid_argument for rows
// that are not as formats/pixel_transfer.h says, or 2³² of them or more.
formats::SumGrammar compress(const formats::PixelCodes& codes, const SumOptions& options = {});

// The matrix, from its sums.
formats::PixelRows decode(const formats::SumGrammar& grammar);

// Rows that are not equal, in integers.
std::uint64_t reconstructionErrors(const formats::SumGrammar& grammar, const formats::PixelCodes& codes);

// Floating-point operations on one channel as the paper counts them (its equation 7): every term that is added to a row, from zero, every
// addition of a sum and every multiplication by a code but the full one.
struct Operations {
  std::uint64_t counted = 0;
  std::uint64_t executed = 0;  // the first term of a row is not added to anything
};
Operations operationsOf(const formats::SumGrammar& grammar);
std::uint64_t bytesInMemory(const formats::SumGrammar& grammar);

}  // namespace bakelight::compression
