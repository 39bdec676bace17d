// Transfer in a pixel basis (all-frequency bi-scale radiance transfer, IV.A): per vertex a sparse matrix from the texels of a
// cube map of light to the cells of the hemisphere over the vertex, as integers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/fields.h"
#include "formats/sum_grammar_code.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Sizes that codes of 8 bits and columns of 16 bits can hold.
inline constexpr int kMostCubeSide = 104, kMostLocalSide = 32, kMostSubsamples = 15;

// A view: rows of integers, ascending columns. Row v · local_side² + j is cell j (row by row, transport/hemisphere_grid.h) of vertex v;
// column (face · cube_side + y) · cube_side + x a texel of the cube map (transport/cube_map.h).
struct PixelCodes {
  int cube_side = 32, local_side = 8, subsamples = 2;
  std::span<const std::uint64_t> row_offsets;  // rows + 1
  std::span<const std::uint16_t> columns;
  std::span<const std::uint8_t> codes;  // 1 … subsamples²: of the texel's subsamples, how many are seen

  std::size_t rowCount() const { return row_offsets.empty() ? 0 : row_offsets.size() - 1; }
  std::size_t columnCount() const { return 6 * static_cast<std::size_t>(cube_side) * cube_side; }
};

// What a view may look at.
struct PixelRows {
  int cube_side = 32, local_side = 8, subsamples = 2;
  std::vector<std::uint64_t> row_offsets = {0};
  std::vector<std::uint16_t> columns;
  std::vector<std::uint8_t> codes;

  PixelCodes view() const { return {cube_side, local_side, subsamples, row_offsets, columns, codes}; }
  // The rows of `next` behind these; sizes must be the same.
  void append(const PixelRows& next) {
    const std::uint64_t before = row_offsets.back();
    row_offsets.reserve(row_offsets.size() + next.row_offsets.size() - 1);
    for (std::size_t row = 1; row < next.row_offsets.size(); ++row)
      row_offsets.push_back(before + next.row_offsets[row]);
    columns.insert(columns.end(), next.columns.begin(), next.columns.end());
    codes.insert(codes.end(), next.codes.begin(), next.codes.end());
  }
};

// What a compressor changed of a matrix: shares of the light of an open cell under a white sky.
struct PixelChanges {
  float tolerance = 0;  // of a row, that it was allowed
  float largest_error = 0, rms_error = 0;
};

// Rows as sums that they share, entropy-coded.
struct PixelSums {
  int block_count = 0;  // of local_side² rows
  std::array<IntegerArray, kSumStreams> streams;
  std::shared_ptr<const SumGrammar> grammar;  // what the streams tell; whoever reads a pack finds it decoded
};

// Transfer in a pixel basis as a pack's transfer: compressed sparse rows, or sums.
struct PixelTransfer {
  static constexpr const char* kKind = "pixel";
  void describe(FieldVisitor& fields);

  int cube_side = 32, local_side = 8, subsamples = 2;
  // Degrees: where the frames of a triangle's corners differ by more, or by their handedness, nothing is interpolated between
  // them, and the nearest corner counts: incident light in one frame is none in another.
  float crease_angle = 60;
  std::vector<Float4> tangents;  // of the vertices' frames
  // Rows come by blocks of local_side²; which block is a vertex's, so that copies of vertices share one and nothing moves with them.
  std::vector<std::uint32_t> blocks;
  std::optional<PixelChanges> changes;        // none: exact
  std::optional<PixelSums> sums;              // else:
  IntegerArray row_lengths{2, {}};            // blocks · local_side²: entries of each row
  IntegerArray columns{2, {}}, codes{1, {}};  // as PixelCodes

  std::size_t cells() const { return static_cast<std::size_t>(local_side) * local_side; }
  std::size_t texels() const { return 6 * static_cast<std::size_t>(cube_side) * cube_side; }
  std::size_t blockCount() const {
    return sums ? static_cast<std::size_t>(sums->block_count) : row_lengths.count() / cells();
  }

 private:
  void describeRows(FieldVisitor& fields);
};

// The rows of all blocks. Shares the bytes of columns and codes. Throws std::invalid_argument if sizes do not fit, or for sums.
class PixelTransferRows {
 public:
  explicit PixelTransferRows(const PixelTransfer& transfer);
  PixelCodes view() const;

 private:
  PixelTransfer transfer_;  // without tangents and blocks
  std::vector<std::uint64_t> row_offsets_;
};

// A block a vertex. Throws std::invalid_argument unless there are as many tangents.
PixelTransfer pixelTransferOf(const PixelCodes& codes, std::vector<Float4> tangents);
// Likewise; `grammar` is what `coded` tells.
PixelTransfer pixelTransferOf(const CodedSums& coded, std::shared_ptr<const SumGrammar> grammar,
                              std::vector<Float4> tangents);
// Of transfer that has sums.
CodedSums codedSumsOf(const PixelTransfer& transfer);

}  // namespace bakelight::formats
