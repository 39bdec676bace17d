// The inner loops of glossy evaluation on tiles of 16 vertices, for the widest vector instructions that the
// processor has (chosen at run time). Private to the evaluators.
//
// "Lanes" are the vertices of a tile: a float[16] holds one number of each. Multiply-adds may be fused, so
// results differ by roundings between processors, never between runs or numbers of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/encoded_table.h"

namespace bakelight::transport {

constexpr std::size_t kTile = 16;

// Sums that are kept in registers at the same time: enough to hide the latency of a multiply-add, and few
// enough for the 16 registers of AVX2.
constexpr std::size_t kRowBlock = 4;  // rows × 3 colours

// Cuts `count` into the fewest blocks of at most `maximum`, whose sizes differ by at most one.
struct Blocks {
  std::size_t count, maximum;

  std::size_t blocks() const { return (count + maximum - 1) / maximum; }
  std::size_t begin(std::size_t block) const { return block * count / blocks(); }
};

// Values of a tile at their precision, in the order in which they are read, 16 lanes each. `scale` has one
// number a value for kUint8 (whose offsets the caller deals with), else it is null.
struct TileValues {
  formats::Precision precision;
  const std::byte* data;
  const float* scale;
};

// Batches of `batch` sums over the same `length` sources: a source list a batch, and its factors as
// [source][sum].
struct SumGroup {
  std::uint32_t batches, batch, length;
};
constexpr std::size_t kSumBatch = 4;  // at most

struct MatrixShape {
  std::size_t rows, columns;
};

struct Kernels {
  // lanes[e] = scale[e] · code[e] + offset[e] (or the number itself), e < count.
  void (*decode)(const TileValues& values, const float* offset, std::size_t count, float* lanes);

  // transferred[i · 3 + c] += Σ_j matrix[i][j] · light[j · 3 + c] for colours first_color … last_color − 1.
  // The matrix is row-major, decoded as above.
  void (*multiplyMatrices)(const TileValues& matrices, const float* offset, MatrixShape shape,
                           const float* light, int first_color, int last_color, float* transferred);
  // As multiplyMatrices for all colours, where entry e of the matrix is at lanes + slots[e] · 16.
  void (*multiplySlots)(const float* lanes, const std::uint16_t* slots, MatrixShape shape, const float* light,
                        float* transferred);

  // result[s] = Σ_e factor[e][s] · lanes at source[e]: sparse sums, those of a group one after the other.
  void (*sparseSums)(const SumGroup* groups, std::size_t group_count, const std::uint16_t* source,
                     const float* factor, const float* lanes, float* result);

  // The matrices of one cluster (its mean and basis: `members`) times the light. Here lanes are the rows of
  // the matrices, padded to whole vectors of 16: [block of members][row vector][j][member in the block][lane]
  // (Blocks of kRowBlock). The light is [j][3][row lane], with the scale of kUint8 inside; product is
  // [member][3][row lane], to which the colours as above are added.
  void (*multiplyBasis)(const TileValues& basis, std::size_t members, MatrixShape shape,
                        const float* light_lanes, int first_color, int last_color, float* product);

  // transferred[i · 3 + c] = product[0][c][i] + Σ_k weights[k] · product[1 + k][c][i].
  void (*transferCluster)(const float* product, std::size_t components, const float* weights,
                          std::size_t row_count, float* transferred);
};

// For the widest instructions of this machine (or of those that Highway's tests leave).
const Kernels& kernels();

}  // namespace bakelight::transport
