// Removal of triangles that have length but no area.
#pragma once

#include <cstdint>

#include "surface/working_mesh.h"

namespace bakelight::surface {

struct NeedleCounts {
  std::int64_t removed = 0;
  std::int64_t kept = 0;
};

// Triangles whose height ÷ longest edge is below `min_height`: a short side is collapsed, a corner on the
// opposite side is taken in by flipping that side, a flat triangle on the border is dropped. So no hole and
// no T-junction appears. `mesh` must be an oriented manifold and stays one. Bounded number of passes.
NeedleCounts removeNeedles(WorkingMesh& mesh, double min_height);

}  // namespace bakelight::surface
