// A transfer matrix in a pixel basis as sums that its rows share: each sum is worked out once, from smaller ones, and a row adds up
// the few that make it up. Exact in integers: every row is a disjoint union of its sums. Nothing is ever subtracted, so a sun beside
// a dark sky costs no digits.
//
// Rows that look at the same part of the sphere are a tile, with tables of its own that stay in a processor's nearest cache (or in
// a work group's shared memory). A tile's table holds its leaves (a texel's light times a code), then its sums, level by level: a
// sum's two parts are of lower levels, so the sums of a level can be worked out in any order, or at once. Rows of a tile lie by
// the number of their terms, so that there is no branch to predict.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bakelight::formats {

inline constexpr std::size_t kMostTileEntries = 65536;

// Where a tile's part of each array begins; it ends where the next tile's begins.
struct SumTile {
  std::uint64_t leaf = 0, sum = 0, level = 0, group = 0, term = 0, code = 0, row = 0;
};

// Rows of equal length behind each other.
struct RowGroup {
  std::uint32_t terms = 0;  // of each row, at least 1
  std::uint32_t rows = 0;
};

struct SumGrammar {
  int cube_side = 32, local_side = 8, subsamples = 2;
  std::uint64_t row_count = 0;  // of the matrix; rows without an entry are in no tile
  std::vector<SumTile> tiles;   // one more than there are

  // Of a tile: entry i < leaves is code · light[column] / subsamples²; ascending by column, then code.
  std::vector<std::uint16_t> leaf_columns;
  std::vector<std::uint8_t> leaf_codes;
  // Entry leaves + i is the sum of entries sum_parts[2i] and sum_parts[2i + 1], which are before it. The first holds
  // the sum's lowest column. Within a level by lowest column.
  std::vector<std::uint16_t> sum_parts;
  std::vector<std::uint32_t> level_ends;  // of a tile: how many sums there are up to each level
  std::vector<RowGroup> groups;
  // Rows by the number of their terms, then by lowest column, then by place; as they are: without regard to columns.
  // Row by row, group by group: entries of the tile by their lowest columns, whose sum is the row. Of a tile without leaves, which would gain nothing,
  // columns instead, with a code each.
  std::vector<std::uint16_t> terms;
  std::vector<std::uint8_t> term_codes;
  // Of each row in the order in which they lie: its place in the matrix.
  std::vector<std::uint32_t> row_places;

  std::size_t tileCount() const { return tiles.empty() ? 0 : tiles.size() - 1; }
  std::size_t columnCount() const { return 6 * static_cast<std::size_t>(cube_side) * cube_side; }
};

}  // namespace bakelight::formats
