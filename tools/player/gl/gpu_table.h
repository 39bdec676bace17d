// Tables of radiance transfer on the GPU, at the precision of the pack, and the work over their rows.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/encoded_table.h"
#include "tools/player/gl/gl_objects.h"

namespace bakelight::player {

// Work items of one row a compute shader's work group has, in each of our shaders (local_size_x).
inline constexpr std::size_t kGroupSize = 64;

// Rows that one dispatch handles.
struct RowRange {
  std::size_t first = 0, count = 0;
};

// Cuts `rows` into ranges of which none needs a binding of more than `largest_block_bytes` (0:
// GL_MAX_SHADER_STORAGE_BLOCK_SIZE, which is 128 MiB on llvmpipe) or more work groups than GL dispatches at
// once. `bytes_per_row` is of the widest buffer that is bound, `items_per_row` the work items a row takes.
// Every range starts at a multiple of 256 rows, so that a table of single bytes starts where GL allows a
// binding to start.
std::vector<RowRange> rowRanges(std::size_t rows, std::size_t bytes_per_row, std::size_t items_per_row,
                                std::size_t largest_block_bytes = 0);

// Binds rows `range` of a buffer of `row_bytes` a row as shader storage.
void bindRows(GLuint binding, const Buffer& buffer, const RowRange& range, std::size_t row_bytes);
// Dispatches at least `items` work items of the current program.
void dispatchItems(std::size_t items);

// formats::EncodedTable; shaders read it through gl/shaders/table.glsl.
class GpuTable {
 public:
  GpuTable() = default;
  // Throws std::invalid_argument if the table's sizes contradict each other.
  explicit GpuTable(const formats::EncodedTable& table);

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  std::size_t rowBytes() const { return columns_ * formats::bytesPerValue(precision_); }
  bool empty() const { return rows_ == 0; }
  // What table.glsl needs to know of it.
  std::string definitions() const;
  // Bindings 0 and 1.
  void bind(const RowRange& range) const;
  std::size_t gpuBytes() const { return sizeInBytes(words_) + sizeInBytes(quantization_); }

 private:
  formats::Precision precision_ = formats::Precision::kFloat32;
  std::size_t rows_ = 0, columns_ = 0;
  Buffer words_;         // padded to whole 32-bit words
  Buffer quantization_;  // scale and offset of each column, kUint8 only
};

}  // namespace bakelight::player
