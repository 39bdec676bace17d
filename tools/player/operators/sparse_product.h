// A sparse matrix on the GPU, at the precision of the pack, and its product with a colour a column.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/translucency.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"

namespace bakelight::player {

class SparseProduct {
 public:
  // Values × 1 or × 3. `largest_block_bytes`: see rowRanges. Throws std::invalid_argument if there are other numbers of values, and
  // Error(kNotAvailable) if one row is larger than a block.
  explicit SparseProduct(const formats::SparseRows& matrix, std::size_t largest_block_bytes = 0);

  // x: RGB and padding, float32, a column; y: likewise, a row; it becomes M x, or y + M x if `adds`. Same bytes each time. What comes
  // next sees y in shader storage. Cost: entries · 3 multiply-adds.
  void multiply(const Buffer& x, const Buffer& y, bool adds = false) const;

  std::size_t rows() const { return rows_; }
  std::size_t entries() const { return values_.rows(); }
  std::size_t dispatchCount() const { return ranges_.size(); }  // of one product
  std::size_t gpuBytes() const { return values_.gpuBytes() + sizeInBytes(ends_) + sizeInBytes(columns_); }

 private:
  struct Range {
    RowRange rows, entries;  // of which the first begins where GL allows
  };
  std::vector<Range> rangesOf(std::span<const std::uint32_t> ends, std::size_t largest_block_bytes) const;

  std::size_t rows_;
  GpuTable values_;
  std::size_t lanes_;
  std::vector<Range> ranges_;
  Buffer ends_, columns_;
  Program program_;
};

}  // namespace bakelight::player
