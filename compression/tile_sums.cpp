#include "compression/tile_sums.h"

#include <algorithm>
#include <numeric>

#include "compression/symbol_lists.h"
#include "formats/sum_grammar.h"
#include "transport/cube_map.h"
#include "transport/morton.h"

namespace bakelight::compression {
namespace {

constexpr std::uint32_t kPieceUses = 4;
constexpr std::uint32_t kThresholds[] = {8, 5, 4, 3, 2, 2, 2};

std::uint64_t randomNumber(std::uint64_t x) {  // splitmix64
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
  x = (x ^ x >> 27) * 0x94d049bb133111ebU;
  return x ^ x >> 31;
}

struct TexelAt {
  std::uint32_t place, leaf;
};

// Along a curve on which a square of 2ⁿ × 2ⁿ texels is one piece, as are its halves. Texels that are seen in part lie apart: few rows
// have the same, and what is whole beside them is common.
std::uint32_t placeOf(std::uint16_t column, bool whole, int side) {
  const auto x = static_cast<std::uint16_t>(column % side),
             y = static_cast<std::uint16_t>(column / side % side);
  const auto face = static_cast<std::uint32_t>(column / side / side) + (whole ? 0U : transport::kCubeFaces);
  return face << 14 | transport::mortonCode(x, y);
}

// Empty if there are more leaves than a tile may have.
TileTexels texelsOf(const formats::PixelCodes& codes, std::span<const std::uint32_t> rows,
                    std::vector<TileSums::Leaf>& leaves) {
  const std::size_t full = static_cast<std::size_t>(codes.subsamples) * codes.subsamples;
  const auto keyOf = [&](std::uint64_t i) { return codes.columns[i] * full + codes.codes[i] - 1; };
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> leaf_of_key(codes.columnCount() * full, kUnused);
  for (const std::uint32_t row : rows)
    for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i)
      leaf_of_key[keyOf(i)] = 0;
  TileTexels texels;
  for (std::size_t key = 0; key < leaf_of_key.size(); ++key) {
    if (leaf_of_key[key] == kUnused) continue;
    leaf_of_key[key] = static_cast<std::uint32_t>(leaves.size());
    leaves.push_back({static_cast<std::uint16_t>(key / full), static_cast<std::uint8_t>(key % full + 1)});
    texels.leaf_hashes.push_back(randomNumber(key));
  }
  if (leaves.size() > formats::kMostTileEntries / 2) return texels;
  std::vector<TexelAt> row_texels;
  for (const std::uint32_t row : rows) {
    row_texels.clear();
    for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i)
      row_texels.push_back(
          {placeOf(codes.columns[i], codes.codes[i] == full, codes.cube_side), leaf_of_key[keyOf(i)]});
    std::sort(row_texels.begin(), row_texels.end(),
              [](const TexelAt& a, const TexelAt& b) { return a.place < b.place; });
    for (const TexelAt& texel : row_texels)
      texels.places.push_back(texel.place), texels.leaves.push_back(texel.leaf);
    texels.row_begins.push_back(static_cast<std::uint32_t>(texels.leaves.size()));
  }
  return texels;
}

// From lists to tables: sums used once are put in the place of their use, sums of more than two parts become chains, and all are
// sorted by level.
class Tables {
 public:
  Tables(const SymbolLists& lists, std::span<const std::uint32_t> rows, TileSums& out)
      : lists_(lists), rows_(rows), out_(out), uses_(lists.hashes.size(), 0) {}

  bool build() {
    countUses();
    for (std::size_t sum = 0; sum < lists_.sumCount(); ++sum) {
      const std::size_t symbol = lists_.leaves + sum;
      if (uses_[symbol] >= 2) addSum(symbol);
    }
    sortByLevel();
    if (lists_.leaves + sums_.size() > formats::kMostTileEntries) return false;
    addRows();
    return true;
  }

 private:
  struct Sum {
    std::uint32_t parts[2];  // leaves, then sums in the order in which they were made
    std::uint32_t level, uses;
    std::uint32_t anchor;  // its first leaf
  };

  void countUses() {
    for (const Symbol symbol : lists_.symbols) ++uses_[symbol];
    // A sum that nothing uses uses nothing itself; sums of a higher number use those of lower ones or, of pieces, the reverse.
    bool changed = true;
    std::vector<std::uint8_t> dropped(lists_.sumCount(), 0);
    while (changed) {
      changed = false;
      for (std::size_t sum = 0; sum < lists_.sumCount(); ++sum) {
        if (dropped[sum] != 0 || uses_[lists_.leaves + sum] != 0) continue;
        dropped[sum] = 1, changed = true;
        for (const Symbol part : lists_.list(lists_.rows + sum)) --uses_[part];
      }
    }
    entry_of_.assign(lists_.hashes.size(), kNone);
  }

  // The list's terms once sums with a single use are written out.
  void expand(std::span<const Symbol> list, std::vector<std::uint32_t>& terms) {
    for (const Symbol symbol : list) {
      if (symbol < lists_.leaves) {
        terms.push_back(symbol);
      } else if (uses_[symbol] >= 2) {
        terms.push_back(addSum(symbol));
      } else {
        expand(lists_.list(lists_.rows + symbol - lists_.leaves), terms);
      }
    }
  }

  std::uint32_t levelOf(std::uint32_t entry) const {
    return entry < lists_.leaves ? 0 : sums_[entry - lists_.leaves].level;
  }

  std::uint32_t anchorOf(std::uint32_t entry) const {
    return entry < lists_.leaves ? entry : sums_[entry - lists_.leaves].anchor;
  }
  void sortByAnchor(std::span<std::uint32_t> entries) const {
    std::sort(entries.begin(), entries.end(),
              [&](std::uint32_t a, std::uint32_t b) { return anchorOf(a) < anchorOf(b); });
  }

  std::uint32_t addSum(std::size_t symbol) {
    if (entry_of_[symbol] != kNone) return entry_of_[symbol];
    std::vector<std::uint32_t> terms;
    expand(lists_.list(lists_.rows + symbol - lists_.leaves), terms);
    std::sort(terms.begin(), terms.end(), [&](std::uint32_t a, std::uint32_t b) {
      return levelOf(a) != levelOf(b) ? levelOf(a) < levelOf(b) : a < b;
    });
    std::uint32_t entry = terms[0];
    for (std::size_t i = 1; i < terms.size(); ++i) {
      const std::uint32_t level = 1 + std::max(levelOf(entry), levelOf(terms[i]));
      std::array<std::uint32_t, 2> parts = {entry, terms[i]};
      sortByAnchor(parts);
      sums_.push_back(
          {{parts[0], parts[1]}, level, i + 1 == terms.size() ? uses_[symbol] : 1, anchorOf(parts[0])});
      entry = static_cast<std::uint32_t>(lists_.leaves + sums_.size() - 1);
    }
    return entry_of_[symbol] = entry;
  }

  void sortByLevel() {
    std::vector<std::uint32_t> order(sums_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (sums_[a].level != sums_[b].level) return sums_[a].level < sums_[b].level;
      if (sums_[a].anchor != sums_[b].anchor) return sums_[a].anchor < sums_[b].anchor;
      return sums_[a].uses != sums_[b].uses ? sums_[a].uses > sums_[b].uses : a < b;
    });
    final_.resize(lists_.leaves + sums_.size());
    std::iota(final_.begin(), final_.begin() + static_cast<std::ptrdiff_t>(lists_.leaves), 0U);
    for (std::size_t i = 0; i < order.size(); ++i)
      final_[lists_.leaves + order[i]] = static_cast<std::uint32_t>(lists_.leaves + i);
    for (std::size_t i = 0; i < order.size(); ++i) {
      const Sum& sum = sums_[order[i]];
      out_.sums.push_back({static_cast<std::uint16_t>(final_[sum.parts[0]]),
                           static_cast<std::uint16_t>(final_[sum.parts[1]])});
      if (i + 1 == order.size() || sums_[order[i + 1]].level != sum.level)
        out_.level_ends.push_back(static_cast<std::uint32_t>(i + 1));
    }
  }

  void addRows() {
    std::vector<std::uint32_t> terms, begins = {0}, first_columns;
    for (std::size_t row = 0; row < lists_.rows; ++row) {
      const std::size_t begin = terms.size();
      expand(lists_.list(row), terms);
      sortByAnchor(std::span(terms).subspan(begin));
      first_columns.push_back(out_.leaves[anchorOf(terms[begin])].column);
      for (std::size_t i = begin; i < terms.size(); ++i) terms[i] = final_[terms[i]];
      begins.push_back(static_cast<std::uint32_t>(terms.size()));
    }
    std::vector<std::uint32_t> order(lists_.rows);
    std::iota(order.begin(), order.end(), 0U);
    const auto length = [&](std::uint32_t row) { return begins[row + 1] - begins[row]; };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (length(a) != length(b)) return length(a) < length(b);
      return first_columns[a] != first_columns[b] ? first_columns[a] < first_columns[b] : rows_[a] < rows_[b];
    });
    out_.row_begins.push_back(0);
    for (const std::uint32_t row : order) {
      out_.rows.push_back(rows_[row]);
      for (std::uint32_t i = begins[row]; i < begins[row + 1]; ++i)
        out_.terms.push_back(static_cast<std::uint16_t>(terms[i]));
      out_.row_begins.push_back(static_cast<std::uint32_t>(out_.terms.size()));
    }
  }

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  const SymbolLists& lists_;
  std::span<const std::uint32_t> rows_;
  TileSums& out_;
  std::vector<std::uint32_t> uses_, entry_of_, final_;
  std::vector<Sum> sums_;
};

}  // namespace

TileSums plainTile(const formats::PixelCodes& codes, std::span<const std::uint32_t> rows) {
  TileSums tile;
  tile.plain = true;
  tile.rows.assign(rows.begin(), rows.end());
  const auto length = [&](std::uint32_t row) { return codes.row_offsets[row + 1] - codes.row_offsets[row]; };
  std::sort(tile.rows.begin(), tile.rows.end(), [&](std::uint32_t a, std::uint32_t b) {
    return length(a) != length(b) ? length(a) < length(b) : a < b;
  });
  return tile;
}

std::optional<TileSums> shareSums(const formats::PixelCodes& codes, std::span<const std::uint32_t> rows,
                                  const SumOptions& options) {
  TileSums tile;
  const TileTexels texels = texelsOf(codes, rows, tile.leaves);
  if (texels.leaves.empty()) return std::nullopt;
  SymbolLists lists = cutIntoPieces(texels, std::max(kPieceUses, options.least_uses));
  for (const std::uint32_t threshold : kThresholds)
    pairUp(lists, std::max(threshold, options.least_uses), formats::kMostTileEntries);
  if (!Tables(lists, rows, tile).build()) return std::nullopt;
  const std::size_t entries = texels.leaves.size();
  const std::size_t bytes = 3 * tile.leaves.size() + 4 * tile.sums.size() + 2 * tile.terms.size();
  const std::size_t additions = tile.leaves.size() + tile.sums.size() + tile.terms.size();
  if (bytes >= 3 * entries || additions >= 2 * entries) return plainTile(codes, rows);
  return tile;
}

}  // namespace bakelight::compression
