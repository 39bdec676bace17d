#include "tools/mesomesh/synthesis/surface_graph.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/mesomesh/synthesis/mesh_vertices.h"
#include "tools/mesomesh/synthesis/ordered_sum.h"

namespace bakelight::mesomesh {
namespace {

using formats::Float3;
using formats::Triangle;

float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Vertices around each vertex, those of each triangle after those of the one before.
struct Neighbors {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> list;
};

Neighbors neighborsOf(std::span<const Triangle> triangles, std::span<const std::uint32_t> vertex_of,
                      std::size_t vertices) {
  Neighbors result;
  result.first.assign(vertices + 1, 0);
  const auto forEachSide = [&](const auto& visit) {
    for (const Triangle& t : triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = vertex_of[t[k]], b = vertex_of[t[(k + 1) % 3]];
        if (a != b) visit(a, b), visit(b, a);
      }
  };
  forEachSide([&](std::uint32_t a, std::uint32_t) { ++result.first[a + 1]; });
  for (std::size_t v = 0; v < vertices; ++v) result.first[v + 1] += result.first[v];
  result.list.resize(result.first.back());
  std::vector<std::size_t> next(result.first.begin(), result.first.end() - 1);
  forEachSide([&](std::uint32_t a, std::uint32_t b) { result.list[next[a]++] = b; });
  return result;
}

Float3 wayBetween(const Float3& from, const Float3& to, const Float3& period) {
  Float3 way;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    way[axis] = to[axis] - from[axis];
    if (period[axis] > 0) way[axis] -= period[axis] * std::round(way[axis] / period[axis]);
  }
  return way;
}

// The way along the tangent plane, as long as the way through space: on a crease the plane is crossed
// steeply, the surface is not.
Offset laidDown(const SurfaceFrame& frame, const Float3& way) {
  const float x = dot(way, frame.tangent), y = dot(way, frame.bitangent);
  const float length = std::sqrt(dot(way, way)), flat = std::sqrt(x * x + y * y);
  if (flat <= 1e-4f * length) return {length, 0};
  return {x * (length / flat), y * (length / flat)};
}

// A rotation as cosine and sine.
using Rotation = std::array<float, 2>;

Offset rotatedBy(const Offset& offset, const Rotation& r) {
  return {offset[0] * r[0] - offset[1] * r[1], offset[0] * r[1] + offset[1] * r[0]};
}

// The direction of b's tangent in a's frame, after the shortest rotation of b's normal to a's.
Rotation tangentSeen(const SurfaceFrame& a, const SurfaceFrame& b) {
  const float cosine = dot(a.normal, b.normal);
  if (cosine < -0.999f) return {1, 0};
  const float tilt = dot(a.normal, b.tangent) / (1 + cosine);
  Float3 tangent;
  for (std::size_t k = 0; k < 3; ++k) tangent[k] = b.tangent[k] - tilt * (a.normal[k] + b.normal[k]);
  const Rotation seen = {dot(tangent, a.tangent), dot(tangent, a.bitangent)};
  const float length = std::sqrt(seen[0] * seen[0] + seen[1] * seen[1]);
  return length > 0 ? Rotation{seen[0] / length, seen[1] / length} : Rotation{1, 0};
}

std::uint32_t turnsOf(const Rotation& r, FieldFolds folds) {
  if (folds == FieldFolds::kOne) return 0;
  if (folds == FieldFolds::kTwo) return r[0] < 0 ? 2 : 0;
  if (std::abs(r[0]) >= std::abs(r[1])) return r[0] < 0 ? 2 : 0;
  return r[1] > 0 ? 1 : 3;
}

Rotation halfOf(const Rotation& r) {
  const float x = 1 + r[0], length = std::sqrt(x * x + r[1] * r[1]);
  return length > 1e-6f ? Rotation{x / length, r[1] / length} : Rotation{0, 1};
}

struct MeasuredLink {
  Link link;
  bool twisted;  // frames differ by more than 30° after turns
};

MeasuredLink measured(const SurfaceFrame& a, const SurfaceFrame& b, std::uint32_t to, FieldFolds folds,
                      const Float3& period) {
  const Float3 way = wayBetween(a.position, b.position, period);
  const Rotation seen = tangentSeen(a, b);
  const std::uint32_t turns = turnsOf(seen, folds);
  const Rotation rest = turned(seen, 4 - turns), half = halfOf(rest);
  // From either end; what they differ by is curvature, and halving it makes links their own reverse.
  const Offset from_a = rotatedBy(laidDown(a, way), {half[0], -half[1]});
  const Offset from_b = rotatedBy(turned(laidDown(b, {-way[0], -way[1], -way[2]}), turns), half);
  return {{to, turns, {0.5f * (from_a[0] - from_b[0]), 0.5f * (from_a[1] - from_b[1])}}, rest[0] < 0.866f};
}

bool closer(const Link& a, const Link& b) {
  const float length_a = squaredLength(a), length_b = squaredLength(b);
  return length_a != length_b ? length_a < length_b : a.to < b.to;
}

}  // namespace

Link reversed(const Link& link, std::uint32_t from) {
  const Offset back = turned(link.offset, 4 - link.turns);
  return {from, (4 - link.turns) & 3, {-back[0], -back[1]}};
}

Link joined(const Link& a, const Link& b) {
  const Offset further = turned(b.offset, a.turns);
  return {b.to, (a.turns + b.turns) & 3, {a.offset[0] + further[0], a.offset[1] + further[1]}};
}

float squaredLength(const Link& link) {
  return link.offset[0] * link.offset[0] + link.offset[1] * link.offset[1];
}

double SurfaceGraph::meanLength() const {
  if (links.empty()) return 0;
  return orderedSum(links.size(),
                    [&](std::size_t l) { return std::sqrt(static_cast<double>(squaredLength(links[l]))); }) /
         static_cast<double>(links.size());
}

void keepMutual(SurfaceGraph& graph) {
  std::size_t kept = 0;
  const auto isMutual = [&](std::uint32_t from, std::uint32_t to) {
    // Looked for where it was, as links move only towards the front of vertices before `from`.
    for (const Link& link : graph.linksOf(to))
      if (link.to == from) return true;
    return false;
  };
  std::vector<std::uint8_t> mutual(graph.links.size());
  tbb::parallel_for(std::size_t{0}, graph.vertexCount(), [&](std::size_t v) {
    for (std::size_t l = graph.first[v]; l < graph.first[v + 1]; ++l)
      mutual[l] = isMutual(static_cast<std::uint32_t>(v), graph.links[l].to) ? 1 : 0;
  });
  std::size_t begin = 0;
  for (std::size_t v = 0; v < graph.vertexCount(); ++v) {
    const std::size_t end = graph.first[v + 1];
    for (std::size_t l = begin; l < end; ++l)
      if (mutual[l] != 0) graph.links[kept++] = graph.links[l];
    begin = end;
    graph.first[v + 1] = kept;
  }
  graph.links.resize(kept);
}

MeshGraph graphOf(const SurfaceView& surface, FieldFolds folds, std::size_t exemplar_count) {
  MeshVertices vertices = meshVertices(surface, exemplar_count);
  const std::size_t count = vertices.frames.size();
  const Neighbors neighbors = neighborsOf(surface.triangles, vertices.vertex_of, count);

  MeshGraph result;
  result.on_seam = std::move(vertices.on_seam);
  std::vector<Link> links(neighbors.list.size());
  std::vector<std::uint32_t> link_count(count);
  std::vector<std::uint8_t> any_dropped(count), twisted(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t v) {
    const auto own = static_cast<std::uint32_t>(v);
    std::vector<std::uint32_t> around(
        neighbors.list.begin() + static_cast<std::ptrdiff_t>(neighbors.first[v]),
        neighbors.list.begin() + static_cast<std::ptrdiff_t>(neighbors.first[v + 1]));
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    Link* const begin = links.data() + neighbors.first[v];
    Link* end = begin;
    for (const std::uint32_t w : around) {
      if (vertices.exemplars[w] != vertices.exemplars[v]) {
        result.on_seam[v] = 1;
        continue;
      }
      const MeasuredLink link =
          own < w ? measured(vertices.frames[v], vertices.frames[w], w, folds, surface.period)
                  : measured(vertices.frames[w], vertices.frames[v], own, folds, surface.period);
      if (link.twisted) twisted[v] = 1;
      if (link.link.turns != 0) result.on_seam[v] = 1;
      *end++ = own < w ? link.link : reversed(link.link, w);
    }
    if (end > begin + kMostLinks) {
      std::nth_element(begin, begin + kMostLinks, end, closer);
      end = begin + kMostLinks;
      std::sort(begin, end, [](const Link& a, const Link& b) { return a.to < b.to; });
      any_dropped[v] = 1;
    }
    link_count[v] = static_cast<std::uint32_t>(end - begin);
  });

  SurfaceGraph& graph = result.graph;
  graph.exemplars = std::move(vertices.exemplars);
  graph.first.resize(count + 1);
  for (std::size_t v = 0; v < count; ++v) graph.first[v + 1] = graph.first[v] + link_count[v];
  graph.links.resize(graph.first.back());
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t v) {
    std::copy_n(links.begin() + static_cast<std::ptrdiff_t>(neighbors.first[v]), link_count[v],
                graph.links.begin() + static_cast<std::ptrdiff_t>(graph.first[v]));
  });
  if (std::find(any_dropped.begin(), any_dropped.end(), 1) != any_dropped.end()) keepMutual(graph);
  result.twisted_vertices = static_cast<std::size_t>(std::count(twisted.begin(), twisted.end(), 1));
  result.welded_vertices = surface.positions.size() - count;
  result.vertex_of = std::move(vertices.vertex_of);
  return result;
}

}  // namespace bakelight::mesomesh
