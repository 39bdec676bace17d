// Sum grammars entropy-coded, as files and packs hold them (docs/FORMATS.md): entries by where they lie and how often they are used.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "formats/shared_bytes.h"
#include "formats/sum_grammar.h"

namespace bakelight::formats {

// What is coded together, as it is alike. Lowest columns are told by their places among the columns that the tile has leaves of,
// steps from one to a higher one as differences of columns, less 1.
enum SumStream {
  kRowTiles,  // a row of the matrix: 0 none, 1 and 2 as the row above it in its cells or before it, 3 + its tile
  kRowTerms,      // of rows that have a tile, less 1
  kTileCounts,    // a tile: leaves, levels
  kRankCounts,    // a tile: of sum, part and term ranks how many are in each context
  kLeafColumns,   // from leaf to leaf
  kLeafCodes,     // less 1
  kLevelCounts,   // sums of a level
  kSumAnchors,    // lowest column of a sum, from sum to sum
  kSumRanks,      // of its first part among the entries with that lowest column
  kPartSteps,     // from its first part's lowest column to its second's
  kPartRanks,     // of its second part
  kRowAnchors,    // lowest column of a row, from that of the tile's row before it, the sign in the lowest bit
  kTermRanks,     // of each of its terms
  kTermSteps,     // from lowest column to lowest column
  kPlainColumns,  // of a row that is stored as it is: from column to column
  kPlainCodes,    // less 1
  kSumStreams
};
inline constexpr std::array<const char*, kSumStreams> kSumStreamNames = {
    "row_tiles",    "row_terms",   "tile_counts",   "rank_counts", "leaf_columns", "leaf_codes",
    "level_counts", "sum_anchors", "sum_ranks",     "part_steps",  "part_ranks",   "row_anchors",
    "term_ranks",   "term_steps",  "plain_columns", "plain_codes"};

// The same as keys of a pack.
inline constexpr std::array<const char*, kSumStreams> kSumStreamKeys = {
    "rowTiles",    "rowTerms",   "tileCounts",   "rankCounts", "leafColumns", "leafCodes",
    "levelCounts", "sumAnchors", "sumRanks",     "partSteps",  "partRanks",   "rowAnchors",
    "termRanks",   "termSteps",  "plainColumns", "plainCodes"};

struct CodedSums {
  int cube_side = 32, local_side = 8, subsamples = 2;
  std::uint64_t row_count = 0;
  std::array<SharedBytes, kSumStreams> streams;

  std::uint64_t byteCount() const {
    std::uint64_t bytes = 0;
    for (const SharedBytes& stream : streams) bytes += stream.size();
    return bytes;
  }
};

// The same grammar gives the same bytes.
CodedSums encodeSums(const SumGrammar& grammar);

// Equal to what was encoded. On all TBB threads. Whatever the values are, the result is one that products can be taken of; else
// Error(kBadInput) is thrown naming `file` and stream. The bytes of the entropy coder itself must be those that were written, as
// a checksum shows: its decoder is for whole bytes. Sizes must be in the ranges of pixel_transfer.h, and fewer than 2³² − 1 rows.
SumGrammar decodeSums(const CodedSums& coded, const std::string& file);

}  // namespace bakelight::formats
