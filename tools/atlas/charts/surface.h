// The surface that is to be charted: triangles by distinct places, what lies across each edge, and the edges
// that no chart may cross.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::atlas {

using formats::Triangle;
using transport::Vec3;
using Vec2 = Eigen::Vector2d;

enum class EdgeMark : std::uint8_t {
  kNone,
  kCrease,  // separates charts where creases close up
  kCut      // no chart crosses it
};

// Edge k of a triangle runs from its corner k to corner (k + 1) % 3.
struct Surface {
  std::vector<Vec3> positions;                         // distinct places, about the bounding box's centre
  std::vector<Triangle> triangles;                     // of places; all have an area
  std::vector<std::array<std::int32_t, 3>> neighbors;  // the triangle across each edge, −1: none
  std::vector<std::array<EdgeMark, 3>> marks;          // of each edge
  std::vector<Vec3> normals;                           // of triangles, unit length
  std::vector<double> areas;                           // of triangles
  std::vector<std::uint32_t> source_triangles;         // of triangles: which of the mesh's
  std::vector<std::uint32_t> place_of_vertex;          // of the mesh's vertices
  double area = 0;

  // Positions are (the mesh's − center) · scale, such that the whole area is 1: all lengths in this room,
  // texture coordinates included until they are packed, are in this unit.
  Vec3 center = Vec3::Zero();
  double scale = 1;

  std::int64_t degenerate_triangles = 0;  // left out
  std::int64_t border_edges = 0;          // of one triangle
  std::int64_t non_manifold_edges = 0;    // of more than two: no triangle lies across them
  std::int64_t misoriented_edges = 0;     // two triangles run along them the same way: so neither

  std::size_t triangleCount() const { return triangles.size(); }
  const Vec3& corner(std::size_t triangle, std::size_t k) const { return positions[triangles[triangle][k]]; }
  double edgeLength(std::size_t triangle, std::size_t k) const {
    return (corner(triangle, (k + 1) % 3) - corner(triangle, k)).norm();
  }
  // The triangle that a chart may go on with across edge k, or −1.
  std::int32_t passable(std::size_t triangle, std::size_t k) const {
    return marks[triangle][k] == EdgeMark::kCut ? -1 : neighbors[triangle][k];
  }
};

// Vertices at one position are one place; so the copies along creases and seams of `mesh` do not separate
// triangles. A triangle is degenerate if its height is less than 1e-12 of its longest edge. Cost: O(n log n).
// Throws Error(kBadInput) naming `file` and element: no triangle with an area, an index out of range, a
// coordinate that is not finite.
Surface surfaceOf(const formats::TriangleMesh& mesh, const std::string& file);

// What lies across the edges of the triangles; no edge is marked, and edges of each kind are counted.
void findNeighbors(Surface& surface);

// Marks edges as creases whose triangles' normals differ by more than `angle_deg`. Returns how many.
std::int64_t markCreases(Surface& surface, double angle_deg);

// Cuts the edges between pairs of places, in any order; one may be given twice. Returns how many different
// ones of them are edges of triangles. Cost: O(n log n).
std::int64_t cutEdges(Surface& surface, std::span<const std::array<std::uint32_t, 2>> place_pairs);

}  // namespace bakelight::atlas
