// What coder and decoder of sum grammars share. Private to formats/sum_grammar_*.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/sum_grammar_code.h"

namespace bakelight::formats {

// Draco counts in int.
inline constexpr std::size_t kMostSymbols = std::size_t{1} << 24;

// Ranks are coded apart by how many entries there are with the lowest column, as they are lower the fewer there are: 2–3, 4–7, …, 256 or more.
// Of a single one nothing is coded.
inline constexpr std::array<SumStream, 3> kRankStreams = {kSumRanks, kPartRanks, kTermRanks};
inline constexpr std::size_t kRankContexts = 8;
inline std::size_t rankContextOf(std::size_t entries) {
  return std::min(static_cast<std::size_t>(std::bit_width(entries)) - 2, kRankContexts - 1);
}
inline std::size_t rankIndexOf(SumStream stream) {
  return stream == kSumRanks ? 0 : stream == kPartRanks ? 1 : 2;
}
template <class T>
using ByRank = std::array<std::array<T, kRankContexts>, kRankStreams.size()>;

inline constexpr std::uint32_t kNoTile = ~std::uint32_t{0};

// What is told of a row's tile if those of other rows are known.
class TileGuess {
 public:
  explicit TileGuess(int local_side) : above_(static_cast<std::size_t>(local_side)) {}
  std::uint32_t above(const std::vector<std::uint32_t>& tiles, std::size_t row) const {
    return row >= above_ ? tiles[row - above_] : kNoTile;
  }
  static std::uint32_t before(const std::vector<std::uint32_t>& tiles, std::size_t row) {
    return row >= 1 ? tiles[row - 1] : kNoTile;
  }

 private:
  std::size_t above_;
};

}  // namespace bakelight::formats
