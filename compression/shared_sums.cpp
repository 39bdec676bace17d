#include "compression/shared_sums.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "transport/morton.h"
#include "transport/sum_product.h"

namespace bakelight::compression {
namespace {

void check(const formats::PixelCodes& codes) {
  const int full = codes.subsamples * codes.subsamples;
  if (codes.rowCount() >= ~std::uint32_t{0}) throw std::invalid_argument("too many rows");
  if (codes.columnCount() > 65536 || full > 255) throw std::invalid_argument("a cube map or codes too large");
  if (codes.columns.size() != codes.codes.size())
    throw std::invalid_argument("columns and codes differ in number");
  std::atomic<std::uint64_t> wrong{codes.rowCount()};
  tbb::parallel_for(std::size_t{0}, codes.rowCount(), [&](std::size_t row) {
    const std::uint64_t begin = codes.row_offsets[row], end = codes.row_offsets[row + 1];
    bool fine = begin <= end && end <= codes.columns.size();
    for (std::uint64_t i = begin; fine && i < end; ++i)
      fine = codes.columns[i] < codes.columnCount() && codes.codes[i] > 0 && codes.codes[i] <= full &&
             (i == begin || codes.columns[i - 1] < codes.columns[i]);
    if (fine) return;
    for (std::uint64_t seen = wrong; row < seen && !wrong.compare_exchange_weak(seen, row);) {
    }
  });
  if (wrong < codes.rowCount())
    throw std::invalid_argument("row " + std::to_string(wrong) + " is not sorted or out of range");
}

// Where a row looks: the face of its middle texel, and the mean of its texels on that face, along a curve.
std::uint32_t placeOfRow(const formats::PixelCodes& codes, std::size_t row) {
  const std::uint64_t begin = codes.row_offsets[row], end = codes.row_offsets[row + 1];
  const int side = codes.cube_side;
  const int face = codes.columns[begin + (end - begin) / 2] / (side * side);
  std::uint64_t x = 0, y = 0, count = 0;
  for (std::uint64_t i = begin; i < end; ++i) {
    if (codes.columns[i] / (side * side) != face) continue;
    x += codes.columns[i] % side, y += codes.columns[i] / side % side, ++count;
  }
  return static_cast<std::uint32_t>(face) << 16 |
         transport::mortonCode(static_cast<std::uint16_t>(2 * x / count),
                               static_cast<std::uint16_t>(2 * y / count));
}

// Rows that have entries, by where they look.
std::vector<std::uint32_t> sortedRows(const formats::PixelCodes& codes) {
  std::vector<std::uint64_t> keys;
  for (std::size_t row = 0; row < codes.rowCount(); ++row)
    if (codes.row_offsets[row] != codes.row_offsets[row + 1]) keys.push_back(row);
  tbb::parallel_for(std::size_t{0}, keys.size(),
                    [&](std::size_t i) { keys[i] |= std::uint64_t{placeOfRow(codes, keys[i])} << 32; });
  tbb::parallel_sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> rows(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) rows[i] = static_cast<std::uint32_t>(keys[i]);
  return rows;
}

// One tile, or as many halves as tables must be cut into to be small enough.
void shareInHalves(const formats::PixelCodes& codes, std::span<const std::uint32_t> rows,
                   const SumOptions& options, std::vector<TileSums>& tiles) {
  if (std::optional<TileSums> tile = shareSums(codes, rows, options)) {
    tiles.push_back(std::move(*tile));
  } else if (rows.size() == 1) {
    tiles.push_back(plainTile(codes, rows));
  } else {
    shareInHalves(codes, rows.first(rows.size() / 2), options, tiles);
    shareInHalves(codes, rows.subspan(rows.size() / 2), options, tiles);
  }
}

void append(const TileSums& tile, const formats::PixelCodes& codes, formats::SumGrammar& grammar) {
  for (const auto& leaf : tile.leaves)
    if (!tile.plain) grammar.leaf_columns.push_back(leaf.column), grammar.leaf_codes.push_back(leaf.code);
  for (const auto& sum : tile.sums) grammar.sum_parts.insert(grammar.sum_parts.end(), sum.begin(), sum.end());
  grammar.level_ends.insert(grammar.level_ends.end(), tile.level_ends.begin(), tile.level_ends.end());
  grammar.terms.insert(grammar.terms.end(), tile.terms.begin(), tile.terms.end());
  grammar.row_places.insert(grammar.row_places.end(), tile.rows.begin(), tile.rows.end());
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < tile.rows.size(); ++i) {
    const std::uint64_t begin = codes.row_offsets[tile.rows[i]], end = codes.row_offsets[tile.rows[i] + 1];
    const auto length =
        tile.plain ? static_cast<std::uint32_t>(end - begin) : tile.row_begins[i + 1] - tile.row_begins[i];
    if (length != last) grammar.groups.push_back({length, 0});
    last = length;
    ++grammar.groups.back().rows;
    if (!tile.plain) continue;
    const auto columns = codes.columns.subspan(begin, end - begin);
    grammar.terms.insert(grammar.terms.end(), columns.begin(), columns.end());
    const auto row_codes = codes.codes.subspan(begin, end - begin);
    grammar.term_codes.insert(grammar.term_codes.end(), row_codes.begin(), row_codes.end());
  }
}

formats::SumTile endOf(const formats::SumGrammar& grammar) {
  return {grammar.leaf_columns.size(), grammar.sum_parts.size() / 2, grammar.level_ends.size(),
          grammar.groups.size(),       grammar.terms.size(),         grammar.term_codes.size(),
          grammar.row_places.size()};
}

struct Entry {
  std::uint16_t column;
  std::uint8_t code;
};

// A tile's rows, one after the other.
template <class Function>
void forRows(const formats::SumGrammar& grammar, std::size_t tile, const Function& function) {
  const formats::SumTile &begin = grammar.tiles[tile], &end = grammar.tiles[tile + 1];
  const std::size_t leaves = end.leaf - begin.leaf, sums = end.sum - begin.sum;
  std::vector<std::vector<Entry>> entries(leaves + sums);
  for (std::size_t i = 0; i < leaves; ++i)
    entries[i] = {{grammar.leaf_columns[begin.leaf + i], grammar.leaf_codes[begin.leaf + i]}};
  for (std::size_t i = 0; i < sums; ++i)
    for (int part = 0; part < 2; ++part) {
      const auto& from = entries[grammar.sum_parts[2 * (begin.sum + i) + part]];
      entries[leaves + i].insert(entries[leaves + i].end(), from.begin(), from.end());
    }
  std::size_t term = begin.term, code = begin.code, row = begin.row;
  std::vector<Entry> whole;
  for (std::uint64_t group = begin.group; group < end.group; ++group)
    for (std::uint32_t i = 0; i < grammar.groups[group].rows; ++i) {
      whole.clear();
      for (std::uint32_t t = 0; t < grammar.groups[group].terms; ++t, ++term) {
        if (leaves == 0) {
          whole.push_back({grammar.terms[term], grammar.term_codes[code++]});
        } else {
          const auto& from = entries[grammar.terms[term]];
          whole.insert(whole.end(), from.begin(), from.end());
        }
      }
      std::sort(whole.begin(), whole.end(), [](const Entry& a, const Entry& b) {
        return a.column != b.column ? a.column < b.column : a.code < b.code;
      });
      function(grammar.row_places[row++], whole);
    }
}

}  // namespace

formats::SumGrammar compress(const formats::PixelCodes& codes, const SumOptions& options) {
  check(codes);
  formats::SumGrammar grammar;
  grammar.cube_side = codes.cube_side, grammar.local_side = codes.local_side,
  grammar.subsamples = codes.subsamples;
  grammar.row_count = codes.rowCount();
  const std::vector<std::uint32_t> rows = sortedRows(codes);
  const std::size_t tiles = (rows.size() + options.rows_per_tile - 1) / options.rows_per_tile;
  std::vector<std::vector<TileSums>> done(tiles);
  tbb::parallel_for(
      std::size_t{0}, tiles,
      [&](std::size_t tile) {
        const std::size_t begin = rows.size() * tile / tiles, end = rows.size() * (tile + 1) / tiles;
        shareInHalves(codes, std::span(rows).subspan(begin, end - begin), options, done[tile]);
      },
      tbb::simple_partitioner());
  grammar.tiles.push_back({});
  for (std::vector<TileSums>& parts : done) {
    for (const TileSums& tile : parts) {
      append(tile, codes, grammar);
      grammar.tiles.push_back(endOf(grammar));
    }
    parts = {};
  }
  return grammar;
}

formats::PixelRows decode(const formats::SumGrammar& grammar) {
  std::vector<std::vector<Entry>> rows(grammar.row_count);
  tbb::parallel_for(std::size_t{0}, grammar.tileCount(), [&](std::size_t tile) {
    forRows(grammar, tile,
            [&](std::uint32_t row, const std::vector<Entry>& entries) { rows[row] = entries; });
  });
  formats::PixelRows decoded;
  decoded.cube_side = grammar.cube_side, decoded.local_side = grammar.local_side;
  decoded.subsamples = grammar.subsamples;
  for (const auto& row : rows) {
    for (const Entry& entry : row)
      decoded.columns.push_back(entry.column), decoded.codes.push_back(entry.code);
    decoded.row_offsets.push_back(decoded.columns.size());
  }
  return decoded;
}

std::uint64_t reconstructionErrors(const formats::SumGrammar& grammar, const formats::PixelCodes& codes) {
  if (grammar.row_count != codes.rowCount())
    return std::max<std::uint64_t>(grammar.row_count, codes.rowCount());
  std::vector<std::uint8_t> right(codes.rowCount(), 0);
  tbb::parallel_for(std::size_t{0}, grammar.tileCount(), [&](std::size_t tile) {
    forRows(grammar, tile, [&](std::uint32_t row, const std::vector<Entry>& entries) {
      const std::uint64_t begin = codes.row_offsets[row];
      bool same = codes.row_offsets[row + 1] - begin == entries.size();
      for (std::size_t i = 0; same && i < entries.size(); ++i)
        same = codes.columns[begin + i] == entries[i].column && codes.codes[begin + i] == entries[i].code;
      right[row] = same ? 1 : 0;
    });
  });
  std::uint64_t errors = 0;
  for (std::size_t row = 0; row < right.size(); ++row)
    if (right[row] == 0 && codes.row_offsets[row] != codes.row_offsets[row + 1]) ++errors;
  return errors;
}

Operations operationsOf(const formats::SumGrammar& grammar) {
  Operations operations;
  const int full = grammar.subsamples * grammar.subsamples;
  const bool tabled = grammar.subsamples <= transport::kMostTabledSubsamples;
  const std::uint64_t scaled =
      tabled ? (full - 1) * grammar.columnCount()
             : static_cast<std::uint64_t>(std::count_if(grammar.leaf_codes.begin(), grammar.leaf_codes.end(),
                                                        [&](std::uint8_t code) { return code != full; }));
  operations.counted = scaled + grammar.sum_parts.size() / 2 + grammar.terms.size();
  if (!tabled) operations.counted += grammar.term_codes.size();
  operations.executed = operations.counted - grammar.row_places.size();
  return operations;
}

std::uint64_t bytesInMemory(const formats::SumGrammar& grammar) {
  const auto bytes = [](const auto& values) { return values.size() * sizeof(values[0]); };
  return bytes(grammar.tiles) + bytes(grammar.leaf_columns) + bytes(grammar.leaf_codes) +
         bytes(grammar.sum_parts) + bytes(grammar.level_ends) + bytes(grammar.groups) + bytes(grammar.terms) +
         bytes(grammar.term_codes) + bytes(grammar.row_places);
}

}  // namespace bakelight::compression
