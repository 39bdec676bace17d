// Dense isotropic retiling: the meso-mesh of Sloan, Liu, Shum & Snyder, Bi-Scale Radiance Transfer (2003),
// section 4.3, which they make by Turk's retiling.
//
// The mesh is remeshed at a fraction of the vertices that still resolves it (remesher.h), then each triangle
// becomes four, as often as it takes, and all vertices are put back onto the original surface and evened out:
// children have their parent's shape and six neighbours.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "surface/repair.h"

namespace bakelight::mesomesh {

struct RetileOptions {
  std::int64_t vertices = 960'000;  // of the result, copies along creases included
  double crease_angle_deg = 80;     // edges sharper than this keep their place and part normals
};

// Largest difference of the number of vertices from the one asked for, as a share of it.
inline constexpr double kCountTolerance = 0.05;

struct RetileReport {
  surface::RepairCounts repairs;
  std::int64_t vertices = 0, triangles = 0, crease_copies = 0, components = 0;
  std::int64_t coarse_vertices = 0;
  int subdivisions = 0;
  std::int64_t crease_edges = 0, material_edges = 0, border_edges = 0, corners = 0;  // of the original
  double edge_length = 0;                                                            // root mean square
  // 4√3·area ÷ Σ side²: 1 for an equilateral triangle.
  double mean_quality = 0, least_quality = 0;
  double six_neighbors = 0;           // share of vertices, of those inside of the surface
  std::int64_t folded_triangles = 0;  // that face away from the original below them
  // From the original's vertices to the retiled mesh, and from the middles of triangles (a sample) to the
  // original: the largest and the mean of both, over the diagonal of the bounding box.
  double largest_deviation = 0, mean_deviation = 0;
  std::map<std::string, double> seconds;  // by step
  std::vector<std::string> warnings;
};

struct RetiledMesh {
  // With unit normals, interpolated from the original's smooth ones. Along creases and borders between
  // materials each side has vertices of its own (at the same places), so that each vertex has one normal and
  // one material: a search for vertices that face a direction finds the right one on a crease, too. Triangles
  // and vertices are in an order that keeps neighbours close.
  formats::TriangleMesh mesh;
  std::vector<std::uint32_t> materials;  // of each vertex, an index into the mesh's material names
  RetileReport report;
};

// The input is repaired as simplify's is, and told: welded, cut where it is not an oriented manifold. Sheets
// of two sides lying on one another keep both. Throws Error(kBadInput) naming `file`: no triangle; a
// coordinate that is not finite; edges finer than single precision tells apart at the mesh's distance from the origin; a
// number of vertices that features and components do not let be met to within kCountTolerance. The same bytes
// for any number of threads. Linear in the number of vertices (docs/MESOMESH.md has figures).
RetiledMesh retile(const formats::TriangleMesh& mesh, const RetileOptions& options, const std::string& file);

}  // namespace bakelight::mesomesh
