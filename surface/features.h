// Creases, corners, and borders of the surface and of materials: what decimation and relaxation must keep
// where it is.
#pragma once

#include <cstdint>

#include "surface/corner_mesh.h"

namespace bakelight::surface {

struct FeatureCounts {
  std::int64_t crease_edges = 0;
  std::int64_t material_edges = 0;  // between two materials, creases or not
  std::int64_t corners = 0;         // vertices where features end, meet or turn sharply
};

// Sets `side_feature` on border edges and on edges whose triangles' normals differ by more than
// `crease_angle_deg` (0–180), and clears it elsewhere. Creases of a few edges only, off any run into, are
// shorter than `min_length` are noise and stay unmarked.
void markCreases(CornerMesh& mesh, double crease_angle_deg, double min_length);

// As well on edges between two materials, however short their line, and `feature` on the vertices of all
// these; a corner is `locked`, too.
FeatureCounts markFeatures(CornerMesh& mesh, double crease_angle_deg, double min_length);

// Forgets all marks except those of the borders.
void releaseCreases(CornerMesh& mesh);

}  // namespace bakelight::surface
