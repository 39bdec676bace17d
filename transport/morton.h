// An order of points in space in which neighbors are near each other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::transport {

// The indices of the points along a Morton curve (Morton 1966) through a cube about them of 2^21 cells a side;
// within a cell by coordinates, then by index, so that those at one place follow each other. On all TBB threads, the same whatever their number.
std::vector<std::uint32_t> mortonOrder(std::span<const formats::Float3> points);

// Bits of x and y in turn, x's lowest: a texel's place along a Morton curve in the plane.
constexpr std::uint32_t mortonCode(std::uint16_t x, std::uint16_t y) {
  const auto spread = [](std::uint32_t bits) {
    bits = (bits | bits << 8) & 0x00ff00ffU;
    bits = (bits | bits << 4) & 0x0f0f0f0fU;
    bits = (bits | bits << 2) & 0x33333333U;
    return (bits | bits << 1) & 0x55555555U;
  };
  return spread(x) | spread(y) << 1;
}

}  // namespace bakelight::transport
