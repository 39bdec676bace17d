// Products of transfer in a pixel basis with light on the GPU: from a cube map to the cells of the hemispheres over vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/pixel_transfer.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gl_program.h"

namespace bakelight::player {

class PixelProduct {
 public:
  virtual ~PixelProduct() = default;
  // `light`: RGB a texel, radiance × solid angle ÷ subsamples². `incident`: RGB a row; rows without an entry may be left as they are. The
  // caller sets the barrier after it.
  virtual void run(const Buffer& light, const Buffer& incident) const = 0;
  virtual std::size_t gpuBytes() const = 0;
};

// A row of entries an item.
class RowProduct final : public PixelProduct {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;

  // No buffer of more than `most_bytes`, as far as a block of cells needs no more.
  explicit RowProduct(const formats::PixelCodes& codes, std::size_t most_bytes = kMostBytes);
  void run(const Buffer& light, const Buffer& incident) const override;
  std::size_t gpuBytes() const override;

 private:
  struct Rows {
    std::size_t first = 0, count = 0;
    Buffer offsets;  // rows + 1
    Buffer entries;  // column, and code from bit 16 on
  };
  std::vector<Rows> rows_;
  Program program_;
};

// Sums that rows share: leaves, then level by level the sums of all tiles at once, then rows. Rows are cut into slices of a work
// group's size, in which all are as long as the longest: those of a tile lie by length, so little is filled up, neighbours read
// neighbours and no item waits for another.
class SumProduct final : public PixelProduct {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;

  // Tiles are taken as many at a time as fit into a table of `most_bytes`, and slices likewise.
  explicit SumProduct(const formats::SumGrammar& grammar, std::size_t most_bytes = kMostBytes);
  void run(const Buffer& light, const Buffer& incident) const override;
  std::size_t gpuBytes() const override;
  std::size_t partCount() const { return parts_.size(); }

 private:
  struct Level {
    std::uint32_t first = 0, count = 0;  // entries of the table
  };
  struct Slices {
    std::uint32_t count = 0;
    Buffer begins;  // of their terms; one more
    Buffer terms;   // entries of the table: a slice's first terms, its second ones, …
    Buffer places;  // of rows in the matrix
  };
  struct Part {
    std::uint32_t leaf_count = 0;
    Buffer leaves;  // column, and code from bit 16 on
    Buffer sums;    // pairs of entries
    std::vector<Level> levels;
    std::vector<Slices> slices;
  };
  class PartMaker;

  std::vector<Part> parts_;
  Buffer table_;  // RGB and 0 an entry; the first is 0
  Texture table_texels_;
  Program leaves_program_, sums_program_, rows_program_;
};

// What the pack holds. Throws std::invalid_argument for sums that were not decoded.
std::unique_ptr<PixelProduct> makePixelProduct(const formats::PixelTransfer& transfer);

}  // namespace bakelight::player
