// Which way closed surfaces face.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/working_mesh.h"

namespace bakelight::surface {

// Triangles that hang together through shared edges.
struct Components {
  std::vector<std::uint32_t> of_triangle;  // component of each triangle
  std::vector<bool> closed;                // of each component: no edge of one triangle only
  std::size_t count() const { return closed.size(); }
};

// Turns closed components that are inside out, and returns how many. One that no other closed component holds
// has to enclose a positive volume. One that lies inside of others turns if, and only if, the outermost of
// those does: so cavities stay cavities, and a hollow body that is inside out turns as a whole. Cost: O(n)
// where no volume is negative; otherwise O(n) more for each component within the bounding box of another.
std::int64_t turnInsideOutComponents(WorkingMesh& mesh, const Components& components);

}  // namespace bakelight::surface
