// Adaptive four-dimensional wavelets of the whole transfer matrix, after Cheslack-Postava, Goodnight, Ng, Ramamoorthi & Humphreys 2007 ("4D
// Compression and Relighting with High-Resolution Light Transport Matrices"): rows in the Haar basis of light's faces (two dimensions), then
// columns in a Haar basis of what receives, as deep as makes a column sparser and no deeper, since light of high frequencies makes
// pictures that no wavelet compresses.
//
// What receives is here vertices in an order along a curve, in blocks of kBlockVertices (one dimension, as theirs of vertices is), × the
// cells of each hemisphere (two dimensions). For each wavelet of light and each block the depths of both are chosen by the cost Σ min(c², t²) of its weighted coefficients c, which
// is what is lost of those dropped and a price for those kept, at the threshold t that the bytes allow. Coefficients are weighted by the solid angle of the
// support on light's side, as those of haar_rows.h are: by magnitude alone they err more under every light but a sun.
#pragma once

#include <cstdint>
#include <span>

#include "compression/compressed_transfer.h"
#include "compression/haar.h"

namespace bakelight::compression {

inline constexpr std::size_t kBlockVertices = 64;

// `order` is a permutation of the vertices (row r of the matrix is cell r % local_side² of vertex r / local_side²) in which neighbors follow each
// other. Coefficients are quantised to 5 or 6 bits, whichever errs least. Throws std::invalid_argument if the budget holds none or sizes do not fit.
CompressedTransfer wavelets4dWithin(std::uint64_t budget, const WaveletRows& rows, int local_side,
                                    std::span<const std::uint32_t> order);

}  // namespace bakelight::compression
