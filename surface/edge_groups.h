// The sides of a mesh's triangles, put together by the edge they lie on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "surface/working_mesh.h"

namespace bakelight::surface {

// One corner of a triangle and the side that starts there: 3 × triangle + corner.
using Side = std::uint32_t;
inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

constexpr Side nextSide(Side s) {
  return s % 3 == 2 ? s - 2 : s + 1;
}
constexpr Side previousSide(Side s) {
  return s % 3 == 0 ? s + 2 : s - 1;
}

// Groups are in order of the edge's smaller vertex, then its greater one; the sides of a group are in index
// order. All TBB threads, linear in the number of triangles where no vertex joins very many.
class EdgeGroups {
 public:
  explicit EdgeGroups(const SurfaceMesh& mesh);

  std::size_t count() const { return first_.size() - 1; }
  std::span<const Side> group(std::size_t g) const {
    return std::span(sides_).subspan(first_[g], first_[g + 1] - first_[g]);
  }

 private:
  std::vector<Side> sides_;
  std::vector<std::uint32_t> first_;  // of each group, and one past the last
};

}  // namespace bakelight::surface
