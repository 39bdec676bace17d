#include "surface/needles.h"

#include <algorithm>
#include <cmath>

#include "surface/half_edge_mesh.h"

namespace bakelight::surface {
namespace {

constexpr int kMaxPasses = 16;
// A needle has one short side; otherwise a corner lies on the opposite side (a cap).
constexpr double kShortSide = 1e-3;

// Height over the longest edge ÷ that edge; 0 for a point.
double flatness(const Point& a, const Point& b, const Point& c) {
  const double longest2 = std::max({(b - a).sqrnorm(), (c - b).sqrnorm(), (a - c).sqrnorm()});
  return longest2 > 0 ? ((b - a) % (c - a)).norm() / longest2 : 0.0;
}

struct Sides {
  HalfedgeHandle shortest, longest;
  double shortest_length = 0, longest_length = 0;
};

Sides sidesOf(const HalfEdgeMesh& mesh, FaceHandle face) {
  Sides sides;
  for (const auto side : mesh.fh_range(face)) {
    const double length = mesh.calc_edge_length(side);
    if (!sides.shortest.is_valid() || length < sides.shortest_length)
      sides.shortest = side, sides.shortest_length = length;
    if (!sides.longest.is_valid() || length > sides.longest_length)
      sides.longest = side, sides.longest_length = length;
  }
  return sides;
}

double flatness(const HalfEdgeMesh& mesh, FaceHandle face) {
  const HalfedgeHandle h = mesh.halfedge_handle(face);
  return flatness(mesh.point(mesh.from_vertex_handle(h)), mesh.point(mesh.to_vertex_handle(h)),
                  mesh.point(mesh.to_vertex_handle(mesh.next_halfedge_handle(h))));
}

bool isOnBorder(const HalfEdgeMesh& mesh, VertexHandle vertex) {
  if (mesh.is_boundary(vertex)) return true;
  for (const auto edge : mesh.ve_range(vertex)) {
    if (isMaterialBorder(mesh, edge)) return true;
  }
  return false;
}

bool collapseShortest(HalfEdgeMesh& mesh, HalfedgeHandle side) {
  // A border vertex stays where it is.
  if (isOnBorder(mesh, mesh.from_vertex_handle(side))) side = mesh.opposite_halfedge_handle(side);
  if (!mesh.is_collapse_ok(side)) return false;
  mesh.collapse(side);
  return true;
}

// Flips the longest side if both new triangles are less flat than this one was.
bool flipLongest(HalfEdgeMesh& mesh, HalfedgeHandle side, double flatness_before) {
  const EdgeHandle edge = mesh.edge_handle(side);
  if (!mesh.is_flip_ok(edge)) return false;
  const Point a = mesh.point(mesh.from_vertex_handle(side)), b = mesh.point(mesh.to_vertex_handle(side));
  const Point c = mesh.point(mesh.to_vertex_handle(mesh.next_halfedge_handle(side)));
  const Point d =
      mesh.point(mesh.to_vertex_handle(mesh.next_halfedge_handle(mesh.opposite_halfedge_handle(side))));
  if (std::min(flatness(c, d, b), flatness(d, c, a)) <= flatness_before) return false;
  // The flat triangle, which has no area, takes its neighbour's material.
  mesh.data(mesh.face_handle(side)).material = mesh.data(mesh.opposite_face_handle(side)).material;
  mesh.flip(edge);
  return true;
}

bool removeNeedle(HalfEdgeMesh& mesh, FaceHandle face, double flatness_before) {
  const Sides sides = sidesOf(mesh, face);
  const bool one_short_side = sides.shortest_length <= kShortSide * sides.longest_length;
  if (one_short_side && collapseShortest(mesh, sides.shortest)) return true;
  if (mesh.is_boundary(mesh.edge_handle(sides.longest))) {
    mesh.delete_face(face, true);
    return true;
  }
  return flipLongest(mesh, sides.longest, flatness_before);
}

}  // namespace

NeedleCounts removeNeedles(WorkingMesh& mesh, double min_height) {
  NeedleCounts counts;
  const auto flat = [&](std::size_t t) {
    return flatness(point(mesh.corner(t, 0)), point(mesh.corner(t, 1)), point(mesh.corner(t, 2))) <
           min_height;
  };
  const auto countFlat = [&] {
    std::int64_t count = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) count += flat(t);
    return count;
  };
  const std::int64_t before = countFlat();
  if (before == 0) return counts;  // the usual case: vertex order stays untouched
  HalfEdgeMesh half_edges = halfEdgeMesh(mesh);
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    bool changed = false;
    for (const auto face : half_edges.all_faces()) {
      if (half_edges.status(face).deleted()) continue;
      const double height = flatness(half_edges, face);
      if (height < min_height) changed |= removeNeedle(half_edges, face, height);
    }
    if (!changed) break;
  }
  mesh = workingMesh(half_edges);
  counts.kept = countFlat();
  counts.removed = std::max<std::int64_t>(before - counts.kept, 0);
  return counts;
}

}  // namespace bakelight::surface
