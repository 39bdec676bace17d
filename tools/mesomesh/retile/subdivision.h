// Each triangle becomes four.
#pragma once

#include "tools/mesomesh/retile/original_surface.h"

namespace bakelight::mesomesh {

// New vertices, in the order of their edges' first sides, follow those of `mesh`, which must be compacted;
// they lie in the middles of the edges. Children of triangle t are 4t … 4t + 3: those at its corners, then the
// inner one, each alike its parent, so shape and valence stay. All TBB threads, linear.
SlidingMesh subdivided(const SlidingMesh& mesh);

}  // namespace bakelight::mesomesh
