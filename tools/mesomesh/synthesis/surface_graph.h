// The surface as texture sees it: vertices, and how far their neighbors lie along the texture's axes. Nothing
// after this knows of positions, so that coordinates can wrap around a body in any way that links say.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::mesomesh {

// What synthesis sees of a mesh: all of one length but triangles. A fan, an open or a non-manifold mesh will
// do, as will vertices that no triangle uses.
struct SurfaceView {
  std::span<const formats::Float3> positions, normals;  // units; normals of any length above 0
  // Where the exemplar's u points; v points along normal × tangent. Any length; what they have along the
  // normal is taken away.
  std::span<const formats::Float3> tangents;
  std::span<const formats::Triangle> triangles;
  std::span<const std::uint32_t> exemplars;  // which exemplar each vertex takes
  // After which length along each axis space repeats; 0: never. A flat torus is a plane with two periods.
  formats::Float3 period = {0, 0, 0};
  std::string name = "mesh";  // for errors
};

// In what multiple of 90° frames may turn from a vertex to its neighbor without a seam: the field's symmetry.
enum class FieldFolds : std::uint8_t { kOne = 1, kTwo = 2, kFour = 4 };

using Offset = std::array<float, 2>;  // units

// `offset` by `turns` · 90° counter-clockwise.
template <class Point>
constexpr Point turned(Point offset, std::uint32_t turns) {
  switch (turns & 3) {
    case 1:
      return {-offset[1], offset[0]};
    case 2:
      return {-offset[0], -offset[1]};
    case 3:
      return {offset[1], -offset[0]};
    default:
      return offset;
  }
}

// From a vertex to `to`: the way in the frame halfway between both, after the frame of `to` was turned by
// `turns` · 90° to match. A coherent texture has u(from) = T(u(to)) − offset, T that many turns of the
// exemplar onto itself.
struct Link {
  std::uint32_t to = 0;
  std::uint32_t turns = 0;
  Offset offset = {0, 0};
};

Link reversed(const Link& link, std::uint32_t from);
// a then b.
Link joined(const Link& a, const Link& b);
float squaredLength(const Link& link);

// Links are mutual: whoever has one to a vertex has one back. None leads to a vertex of another exemplar.
struct SurfaceGraph {
  std::vector<std::size_t> first = {0};  // vertices + 1, into links
  std::vector<Link> links;
  std::vector<std::uint32_t> exemplars;

  std::size_t vertexCount() const { return exemplars.size(); }
  std::span<const Link> linksOf(std::size_t vertex) const {
    return {links.data() + first[vertex], first[vertex + 1] - first[vertex]};
  }
  double meanLength() const;  // of links; 0 without any
};

// Keeps the shortest of a vertex's links, as a fan of a thousand triangles would take its square.
constexpr std::size_t kMostLinks = 16;

struct MeshGraph {
  SurfaceGraph graph;
  // Of each of the mesh's vertices its vertex in the graph. The graph's follow a space-filling curve, whatever
  // order the mesh has, and vertices at one place whose normals agree (as cuts of an atlas leave them) are one.
  std::vector<std::uint32_t> vertex_of;
  std::size_t welded_vertices = 0;
  std::size_t twisted_vertices = 0;  // SynthesisReport
  // Of each of the graph's vertices: whether several of the mesh's are at its place, a frame next to it is
  // turned, or a neighbor takes another exemplar.
  std::vector<std::uint8_t> on_seam;
};

// Throws Error(kBadInput) naming the vertex or triangle: lengths that differ, an index out of range, a
// position, normal or tangent that is not finite, a normal without direction. A tangent without direction
// gets any. Linear in vertices but for sorting.
MeshGraph graphOf(const SurfaceView& surface, FieldFolds folds, std::size_t exemplar_count);

// Drops links that are not mutual.
void keepMutual(SurfaceGraph& graph);

}  // namespace bakelight::mesomesh
