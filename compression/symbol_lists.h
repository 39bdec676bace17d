// What a tile's compressor works on: rows and the sums they share, as lists of symbols.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bakelight::compression {

using Symbol = std::uint32_t;

// Symbols 0 … leaves − 1 are leaves; symbol leaves + s is sum s. Lists 0 … rows − 1 are the rows, list rows + s the parts of sum s.
// The sets of leaves that a list's symbols stand for are disjoint. `hashes` holds one number a symbol: the sum over its leaves
// of random numbers of theirs, so that equal sets have equal numbers however they were put together.
struct SymbolLists {
  std::size_t leaves = 0, rows = 0;
  std::vector<std::uint32_t> begins = {0};  // lists + 1
  std::vector<Symbol> symbols;
  std::vector<std::uint64_t> hashes;

  std::size_t listCount() const { return begins.size() - 1; }
  std::size_t sumCount() const { return listCount() - rows; }
  std::span<const Symbol> list(std::size_t i) const {
    return {symbols.data() + begins[i], symbols.data() + begins[i + 1]};
  }
};

// Of rows only, as texels: for each leaf of each row its place along a curve that halves squares, its symbol and its hash.
struct TileTexels {
  std::vector<std::uint32_t> row_begins = {0};
  std::vector<std::uint32_t> places;  // ascending within a row
  std::vector<Symbol> leaves;
  std::vector<std::uint64_t> leaf_hashes;  // by symbol
};

// Cuts rows along a fixed lattice: squares of 8 × 8 texels, halved until the piece is one that occurs at least `least_uses` times, or a
// leaf. Pieces become sums of their halves. Time and memory linear in the texels.
SymbolLists cutIntoPieces(const TileTexels& texels, std::uint32_t least_uses);

// Puts pairs of symbols that occur together in `threshold` lists or more in the place of a sum, as many at once as do not overlap
// (recursive pairing, Larsson & Moffat 1999, on sets and in rounds). At most `most_symbols` symbols come to be.
void pairUp(SymbolLists& lists, std::uint32_t threshold, std::size_t most_symbols);

}  // namespace bakelight::compression
