#include "tools/simplify/relax.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace bakelight::simplify {
namespace {

constexpr int kMaxFlipPasses = 10;
// Normals of triangles that an operation replaces may turn by this much.
const double kTurnCosine = std::cos(35 * std::numbers::pi / 180);
// A move may lower the smallest angle around it only while that stays above this.
const double kGoodAngle_rad = 30 * std::numbers::pi / 180;

double angleAt(const Point& apex, const Point& a, const Point& b) {
  const Point u = a - apex, v = b - apex;
  return std::atan2((u % v).norm(), u | v);
}

double minAngle(const Point& a, const Point& b, const Point& c) {
  return std::min({angleAt(a, b, c), angleAt(b, c, a), angleAt(c, a, b)});
}

Point unitNormal(const Point& a, const Point& b, const Point& c) {
  return ((b - a) % (c - a)).normalize_cond();
}

// The two triangles at an edge: (a, b, c) left of a→b and (b, a, d) right of it.
struct Quad {
  Point a, b, c, d;
  Quad(const HalfEdgeMesh& mesh, EdgeHandle edge) {
    const HalfedgeHandle h = mesh.halfedge_handle(edge, 0), o = mesh.halfedge_handle(edge, 1);
    a = mesh.point(mesh.from_vertex_handle(h)), b = mesh.point(mesh.to_vertex_handle(h));
    c = mesh.point(mesh.to_vertex_handle(mesh.next_halfedge_handle(h)));
    d = mesh.point(mesh.to_vertex_handle(mesh.next_halfedge_handle(o)));
  }
};

double deviationAt(const SurfaceQuery& original, const Point& place, const Point& normal) {
  const SurfacePoint nearest = original.closestFacing(vec3(place), vec3(normal));
  return nearest.valid ? nearest.distance : std::numeric_limits<double>::infinity();
}

bool flipHelps(const HalfEdgeMesh& mesh, EdgeHandle edge, const SurfaceQuery& original,
               double max_deviation) {
  if (mesh.status(edge).feature() || mesh.is_boundary(edge)) return false;
  const Quad q(mesh, edge);
  const double before = std::min(minAngle(q.a, q.b, q.c), minAngle(q.b, q.a, q.d));
  const double after = std::min(minAngle(q.c, q.d, q.b), minAngle(q.d, q.c, q.a));
  if (after <= before + 1e-6 || !mesh.is_flip_ok(edge)) return false;
  const Point old_normal = ((q.b - q.a) % (q.c - q.a) + (q.a - q.b) % (q.d - q.b)).normalize_cond();
  const Point new_1 = unitNormal(q.c, q.d, q.b), new_2 = unitNormal(q.d, q.c, q.a);
  if ((new_1 | old_normal) < kTurnCosine || (new_2 | old_normal) < kTurnCosine) return false;
  return deviationAt(original, (q.c + q.d) / 2.0, old_normal) <=
         std::max(max_deviation, deviationAt(original, (q.a + q.b) / 2.0, old_normal));
}

std::int64_t flipEdges(HalfEdgeMesh& mesh, const SurfaceQuery& original, double max_deviation) {
  std::int64_t flips = 0;
  for (int pass = 0; pass < kMaxFlipPasses; ++pass) {
    const std::int64_t before = flips;
    for (const auto edge : mesh.edges()) {
      if (!flipHelps(mesh, edge, original, max_deviation)) continue;
      mesh.flip(edge);
      ++flips;
    }
    if (flips == before) break;
  }
  return flips;
}

// The triangles around a vertex as the other two corners of each, in turn.
struct Ring {
  struct Side {
    Point from, to;
  };
  std::vector<Side> sides;
  Ring(const HalfEdgeMesh& mesh, VertexHandle vertex) {
    for (const auto h : mesh.voh_range(vertex)) {
      if (mesh.is_boundary(h)) continue;
      const HalfedgeHandle next = mesh.next_halfedge_handle(h);
      sides.push_back({mesh.point(mesh.to_vertex_handle(h)), mesh.point(mesh.to_vertex_handle(next))});
    }
  }
  double minAngleWith(const Point& center) const {
    double smallest = std::numbers::pi;
    for (const Side& side : sides) smallest = std::min(smallest, minAngle(center, side.from, side.to));
    return smallest;
  }
  Point areaNormal(const Point& center) const {
    Point sum(0, 0, 0);
    for (const Side& side : sides) sum += (side.from - center) % (side.to - center);
    return sum.normalize_cond();
  }
  Point centroid(const Point& center) const {
    Point sum(0, 0, 0);
    double weight = 0;
    for (const Side& side : sides) {
      const double area = ((side.from - center) % (side.to - center)).norm();
      sum += (center + side.from + side.to) * (area / 3);
      weight += area;
    }
    return weight > 0 ? Point(sum / weight) : center;
  }
  bool turnsOver(const Point& before, const Point& after) const {
    return std::any_of(sides.begin(), sides.end(), [&](const Side& side) {
      return (unitNormal(before, side.from, side.to) | unitNormal(after, side.from, side.to)) < kTurnCosine;
    });
  }
};

bool moveVertex(HalfEdgeMesh& mesh, VertexHandle vertex, const SurfaceQuery& original) {
  if (mesh.status(vertex).feature() || mesh.is_boundary(vertex)) return false;
  const Point position = mesh.point(vertex);
  const Ring ring(mesh, vertex);
  const Point normal = ring.areaNormal(position);
  Point step = ring.centroid(position) - position;
  step -= normal * (normal | step);
  const double angle_before = ring.minAngleWith(position);
  for (int attempt = 0; attempt < 2; ++attempt, step *= 0.5) {
    const SurfacePoint target = original.closestFacing(vec3(position + step), vec3(normal));
    if (!target.valid) return false;
    const Point moved = point(target.position);
    const double angle = ring.minAngleWith(moved);
    if (angle < std::min(angle_before, kGoodAngle_rad) || ring.turnsOver(position, moved)) continue;
    mesh.set_point(vertex, moved);
    return true;
  }
  return false;
}

}  // namespace

RelaxCounts relax(HalfEdgeMesh& mesh, const SurfaceQuery& original, int rounds, double max_deviation) {
  RelaxCounts counts;
  for (int round = 0; round < rounds; ++round) {
    counts.flips += flipEdges(mesh, original, max_deviation);
    for (const auto vertex : mesh.vertices()) counts.moves += moveVertex(mesh, vertex, original);
  }
  counts.flips += flipEdges(mesh, original, max_deviation);
  return counts;
}

}  // namespace bakelight::simplify
