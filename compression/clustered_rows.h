// A transfer matrix as clustered principal components, quantised.
#pragma once

#include <cstdint>
#include <span>

#include "compression/compressed_transfer.h"
#include "compression/row_clusters.h"

namespace bakelight::compression {

// Weights, and components times the size of their weights, are multiples of one step, which is what errs least in the mean square for the bytes; the
// step is solved for the budget. Streams: clusters of rows, weights a component, bases. Throws std::invalid_argument if the budget is too small.
CompressedTransfer clusteredWithin(std::uint64_t budget, const RowClusters& rows);

// The same of the numbers of clusters and components that err least, among some that spend different shares of the budget on bases. Error is the mean square
// of the matrix's entries. Cost: a clustering, of `rounds`, for each number that is tried.
CompressedTransfer clusteredWithin(std::uint64_t budget, const formats::PixelCodes& codes,
                                   std::span<const int> components_tried, int rounds = 8);

}  // namespace bakelight::compression
