#include "formats/mesh_corners.h"

#include <algorithm>
#include <cstddef>

namespace bakelight::formats {
namespace {

// Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators": the finaliser of SplitMix64.
std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
  return z ^ (z >> 31);
}

std::uint64_t hashOf(const CornerTable::Corner& corner) {
  const std::uint64_t low = corner[0] | static_cast<std::uint64_t>(corner[1]) << 32;
  const std::uint64_t high = corner[2] | static_cast<std::uint64_t>(corner[3]) << 32;
  return mixed(mixed(low + 0x9E3779B97F4A7C15) ^ high);
}

template <class T>
void keep(std::vector<T>& values, const std::vector<std::uint32_t>& kept) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
  values.resize(kept.size());
}

}  // namespace

std::size_t CornerTable::slotOf(const Corner& corner) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hashOf(corner) & mask;
  while (slots_[slot] != kEmpty && corners_[slots_[slot]] != corner) slot = (slot + 1) & mask;
  return slot;
}

std::uint32_t CornerTable::numberOf(const Corner& corner) {
  if (2 * (corners_.size() + 1) > slots_.size()) grow();
  const std::size_t slot = slotOf(corner);
  if (slots_[slot] == kEmpty) {
    slots_[slot] = static_cast<std::uint32_t>(corners_.size());
    corners_.push_back(corner);
  }
  return slots_[slot];
}

void CornerTable::grow() {
  slots_.assign(std::max<std::size_t>(64, slots_.size() * 2), kEmpty);
  for (std::size_t i = 0; i < corners_.size(); ++i)
    slots_[slotOf(corners_[i])] = static_cast<std::uint32_t>(i);
}

std::size_t keepUsedVertices(MeshPart& part) {
  const std::size_t count = part.positions.size();
  std::vector<std::uint32_t> new_from_old(count, 0);
  for (const Triangle& triangle : part.triangles)
    for (const std::uint32_t vertex : triangle) new_from_old[vertex] = 1;
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < count; ++i) {
    if (new_from_old[i] == 0) continue;
    new_from_old[i] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(static_cast<std::uint32_t>(i));
  }
  if (kept.size() == count) return 0;
  keep(part.positions, kept);
  keep(part.normals, kept);
  keep(part.texcoords, kept);
  keep(part.texture_lookups, kept);
  keep(part.colors, kept);
  for (Triangle& triangle : part.triangles)
    for (std::uint32_t& vertex : triangle) vertex = new_from_old[vertex];
  return count - kept.size();
}

}  // namespace bakelight::formats
