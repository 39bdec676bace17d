// Which texels of a square are taken, and where a mask still fits.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/atlas/packing/texel_mask.h"

namespace bakelight::atlas {

class Occupancy {
 public:
  explicit Occupancy(int side);

  // Takes the mask's texels, moved by (x, y); what lies outside the square is left out.
  void take(const TexelMask& mask, int x, int y);

  // The least x for which the mask's box at (x, y) meets no taken texel and lies inside the square's columns
  // margin … side − margin − 1; nothing if there is none. The rows must be inside.
  std::optional<int> firstFree(const TexelMask& mask, int y, int margin) const;

  int side() const { return side_; }

 private:
  std::uint64_t* row(int level, int y) {
    return bits_.data() + (static_cast<std::size_t>(level) * side_ + y) * words_;
  }
  const std::uint64_t* row(int level, int y) const { return const_cast<Occupancy*>(this)->row(level, y); }

  int side_, words_, levels_;
  // levels × side × words; bit x of level k: any of the texels x … x + 2^k − 1 of the row is taken.
  std::vector<std::uint64_t> bits_;
};

}  // namespace bakelight::atlas
