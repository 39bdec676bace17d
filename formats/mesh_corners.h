// Vertices of files that index their attributes apart, or have them by corner of a face. Private to the
// importers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/mesh_parts.h"

namespace bakelight::formats {

// Numbers different corners from 0, in order of their first appearance.
class CornerTable {
 public:
  // What makes a corner: indices, or the bits of values.
  using Corner = std::array<std::uint32_t, 4>;

  std::uint32_t numberOf(const Corner& corner);
  const std::vector<Corner>& corners() const { return corners_; }

 private:
  void grow();
  std::size_t slotOf(const Corner& corner) const;

  static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;
  std::vector<Corner> corners_;
  std::vector<std::uint32_t> slots_;  // open addressing; a power of two of them, at most half full
};

// Leaves out the vertices that no triangle names and returns how many they were; the others keep their order.
std::size_t keepUsedVertices(MeshPart& part);

}  // namespace bakelight::formats
