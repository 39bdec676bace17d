// One tile: a few thousand rows and the sums that they share.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/pixel_transfer.h"

namespace bakelight::compression {

struct SumOptions {
  // Most. Tables of some 40,000 sums still fit into a core's second cache. With a quarter of the rows operations are 3 to 6 % more.
  std::uint32_t rows_per_tile = 24576;
  // A sum is made only for so many uses: 2 gives the fewest additions, more gives smaller tables.
  std::uint32_t least_uses = 2;
};

struct TileSums {
  bool plain = false;  // nothing below but `rows`, as sharing would gain nothing
  struct Leaf {
    std::uint16_t column;
    std::uint8_t code;
  };
  std::vector<Leaf> leaves;
  std::vector<std::array<std::uint16_t, 2>> sums;  // by level
  std::vector<std::uint32_t> level_ends;
  // Rows by the number of their terms, then by their lowest column (so that rows near each other use the same entries), then by
  // their place.
  std::vector<std::uint32_t> rows;        // places in the matrix
  std::vector<std::uint32_t> row_begins;  // of their terms; one more
  std::vector<std::uint16_t> terms;
};

// `rows` are places of rows that have entries. Deterministic. Nothing if their table would have more than kMostTileEntries.
std::optional<TileSums> shareSums(const formats::PixelCodes& codes, std::span<const std::uint32_t> rows,
                                  const SumOptions& options);

// The rows as they are.
TileSums plainTile(const formats::PixelCodes& codes, std::span<const std::uint32_t> rows);

}  // namespace bakelight::compression
