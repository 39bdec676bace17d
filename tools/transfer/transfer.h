// Radiance self-transfer at the vertices of a mesh (Sloan, Kautz & Snyder 2002, sections 4 and 5).
#pragma once

#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/stage/progress.h"

namespace bakelight::transfer {

enum class Visibility {
  kUnshadowed,  // closed form A_l y_lm(n)/π; no rays
  kShadowed     // other parts of the mesh block light
};

struct DiffuseOptions {
  int order = 5;          // SH bands, 1–10
  int directions = 4096;  // over the whole sphere; each vertex traces the half above its tangent plane
  Visibility visibility = Visibility::kShadowed;
  // Distance by which rays start off the surface, as a share of the bounding sphere's radius. At least a few
  // roundings of the coordinates are kept whatever it says.
  double bias = 1e-4;
};

struct DiffuseTransfer {
  // n vertices × order², row-major: exit radiance of a white Lambertian surface per unit light coefficient,
  //   T_i = 1/π ∫ V(s) max(n·s, 0) y_i(s) ds.
  std::vector<float> vectors;

  std::uint64_t rays = 0, blocked_rays = 0;
  // See no light at all: inside a closed cavity, or buried.
  std::uint64_t fully_blocked_vertices = 0;
  // Inside another part of the mesh (buried.h), and how many of them took over their neighbours' transfer.
  std::uint64_t buried_vertices = 0, filled_vertices = 0;
  // Largest |quadrature − closed form| of an unshadowed coefficient over the vertices that see blockers: how
  // far the given number of directions is from resolving the basis. The control variate takes this error out
  // of what is not blocked.
  double quadrature_error = 0;
};

// The mesh has unit normals. The quadrature is a fixed set of directions with the unshadowed closed form as a
// control variate:
//   T = v A + (1 − v) Q[c y] − Q[blocked c y],  v = the cosine-weighted visible share,
// so a vertex that sees no blocker is exact to rounding, as is one that sees no light. Deterministic whatever
// the threads. Cost: vertices × directions / 2 rays, and as many rows of order² multiply-adds where something
// blocks. `progress` advances by one per vertex.
DiffuseTransfer bakeDiffuse(const formats::TriangleMesh& mesh, const DiffuseOptions& options,
                            stage::Progress& progress);

}  // namespace bakelight::transfer
