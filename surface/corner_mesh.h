// The triangles of a mesh and how they join, in flat arrays that threads can change in different places at
// once: what decimation and relaxation work on.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/edge_groups.h"
#include "surface/working_mesh.h"

namespace bakelight::surface {

// A corner table (Rossignac et al. 2001) of an oriented manifold. An operation on a vertex or an edge writes
// only to what it says below, so that operations far enough from each other may run at once.
class CornerMesh {
 public:
  // All TBB threads.
  explicit CornerMesh(const SurfaceMesh& mesh);

  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;         // a removed one has kNone for its first corner
  std::vector<Side> opposite;              // the side on the other triangle; kNone on the border
  std::vector<Side> leaving;               // of each vertex one side that starts there: on the border the one
                                           // that has no opposite; kNone for a vertex without triangles
  std::vector<std::uint8_t> side_feature;  // 1 on creases and borders (features.h), on both sides
  std::vector<std::uint8_t> feature, locked;  // of each vertex

  std::vector<std::uint32_t> materials;  // of each triangle; empty where there are none

  std::uint32_t start(Side s) const { return triangles[s / 3][s % 3]; }
  std::uint32_t end(Side s) const { return start(nextSide(s)); }
  std::uint32_t apex(Side s) const { return start(previousSide(s)); }
  bool alive(std::uint32_t triangle) const { return triangles[triangle][0] != kNone; }
  bool isBorder(std::uint32_t vertex) const { return opposite[leaving[vertex]] == kNone; }
  Vec3 areaVector(std::uint32_t triangle) const {
    const Triangle& t = triangles[triangle];
    return (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
  }

  // The sides that start at `vertex`, counter-clockwise; on the border it ends where the surface does.
  template <class Visit>
  void forSidesAround(std::uint32_t vertex, Visit visit) const {
    const Side first = leaving[vertex];
    for (Side s = first; s != kNone;) {
      visit(s);
      s = opposite[previousSide(s)];
      if (s == first) break;
    }
  }
  // All vertices that share an edge with `vertex`, counter-clockwise.
  template <class Visit>
  void forNeighbors(std::uint32_t vertex, Visit visit) const {
    const Side first = leaving[vertex];
    for (Side s = first; s != kNone;) {
      visit(end(s));
      const Side in = previousSide(s);
      s = opposite[in];
      if (s == kNone) visit(start(in));
      if (s == first) break;
    }
  }
  bool areNeighbors(std::uint32_t a, std::uint32_t b) const;

  // Turns `leaving` of the vertex to `side`, which starts there, or on the border to where it has to be.
  void settle(std::uint32_t vertex, Side side);
  // Turns the edge of two triangles inside of their quadrilateral. `side` is, and its opposite too, the new
  // edge afterwards: from the apex of the opposite's triangle to that of its own. Writes to the two
  // triangles, their vertices' `leaving` and the opposites of the triangles next to them. The caller sees to
  // it that no edge joins the two apexes.
  void flip(Side side);
  // Puts a new vertex into the triangle: it becomes the first of three, the others follow at the end.
  void splitTriangle(std::uint32_t triangle, const Vec3& place);
  // Puts a new vertex on the edge; the part of each triangle at the end of its side follows at the end, that
  // of `side` first.
  void splitEdge(Side side, const Vec3& place);

  // An edge between triangles of two materials.
  bool isMaterialBorder(Side s) const {
    return !materials.empty() && opposite[s] != kNone && materials[s / 3] != materials[opposite[s] / 3];
  }
  // One of the two sides of an edge, for loops over edges.
  bool isEdge(Side s) const { return alive(s / 3) && (opposite[s] == kNone || s < opposite[s]); }
  double length(Side s) const { return (positions[end(s)] - positions[start(s)]).norm(); }
  // Unit; zero for triangles without area. All TBB threads.
  std::vector<Vec3> normals() const;

  // Drops what was removed; keeps the order.
  void compact();

 private:
  void join(Side a, Side b) {
    if (a != kNone) opposite[a] = b;
    if (b != kNone) opposite[b] = a;
  }
  std::uint32_t addVertex(const Vec3& place);
  std::uint32_t addTriangle(const Triangle& triangle, std::uint32_t like);
};

}  // namespace bakelight::surface
