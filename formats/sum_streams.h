// What coder and decoder of sum grammars share. Private to formats/sum_grammar_*.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bakelight::formats {

// Draco counts in int.
inline constexpr std::size_t kMostSymbols = std::size_t{1} << 24;

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
