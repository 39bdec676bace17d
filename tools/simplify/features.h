// Creases, corners and borders: what decimation and relaxation must keep where it is.
#pragma once

#include <cstdint>

#include "tools/simplify/corner_mesh.h"

namespace bakelight::simplify {

struct FeatureCounts {
  std::int64_t crease_edges = 0;
  std::int64_t corners = 0;  // vertices where features end, meet or turn sharply
};

// Sets `side_feature` on border edges and on edges whose triangles' normals differ by more than
// `crease_angle_deg` (0–180), and `feature` on their vertices; a corner is `locked` as well. Creases of a few
// edges only, off any run into, are shorter than `min_length` are noise and stay unmarked.
FeatureCounts markFeatures(CornerMesh& mesh, double crease_angle_deg, double min_length);

// Forgets all marks except those of the border.
void releaseCreases(CornerMesh& mesh);

}  // namespace bakelight::simplify
