// The published compressor, as its authors give it (all-frequency bi-scale radiance transfer, Algorithm 1 with the priority queue of
// "Precomputation Optimization"): biclusters of constant columns, taken out of the matrix one by one, what does not fit left behind
// as a residual that may be negative. Here to be compared with.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/pixel_transfer.h"
#include "transport/sum_product.h"

namespace bakelight::bicluster {

struct Bicluster {
  std::vector<std::uint32_t> rows;
  std::vector<std::uint16_t> columns;
  std::vector<std::int16_t> values;  // one a column
};

struct Biclusters {
  int cube_side = 32, local_side = 8, subsamples = 2;
  std::uint64_t row_count = 0;
  std::vector<Bicluster> clusters;

  std::uint64_t operations() const;  // the paper's equation 7: Σ r + 2l − 1
  std::uint64_t bytes() const;       // 4 a row, 3 a column, 6 a bicluster
};

// The first element of each bicluster is drawn evenly from all that are left; the same seed gives the same biclusters. On one
// thread. Throws std::logic_error if the number of elements left does not fall: it would go on forever.
Biclusters greedyBiclusters(const formats::PixelCodes& codes, std::uint64_t seed = 1);

// The matrix, from its biclusters. Throws std::logic_error for an element that is not a code.
formats::PixelRows decode(const Biclusters& biclusters);

// Value r is row r's. On one thread.
void multiply(const Biclusters& biclusters, std::span<const transport::Radiance4> light,
              std::span<transport::Radiance4> values);

}  // namespace bakelight::bicluster
