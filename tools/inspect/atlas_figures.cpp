#include "tools/inspect/atlas_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "tools/inspect/mesh_figures.h"
#include "transport/texture_stretch.h"

namespace bakelight::inspect {

using formats::Triangle;
using formats::TriangleMesh;
using transport::Vec2;
using transport::Vec3;

namespace {

struct EdgeUse {
  std::uint32_t low, high;
  bool upwards;  // the triangle runs from low to high
  std::uint32_t triangle;
  std::uint8_t edge;

  bool sameEdge(const EdgeUse& other) const { return low == other.low && high == other.high; }
};

// All edges of triangles, sorted, with vertices named by `name_of_vertex`.
std::vector<EdgeUse> sortedEdges(const TriangleMesh& mesh, const std::vector<std::uint32_t>& name_of_vertex) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangleCount());
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = name_of_vertex[mesh.triangles[t][k]],
                          b = name_of_vertex[mesh.triangles[t][(k + 1) % 3]];
      uses.push_back({std::min(a, b), std::max(a, b), a < b, t, k});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle, a.edge) < std::tie(b.low, b.high, b.triangle, b.edge);
  });
  return uses;
}

// Calls visit(begin, end) for the uses of each edge.
template <class Visit>
void forEachEdge(const std::vector<EdgeUse>& uses, const Visit& visit) {
  for (std::size_t begin = 0, end; begin < uses.size(); begin = end) {
    end = begin + 1;
    while (end < uses.size() && uses[end].sameEdge(uses[begin])) ++end;
    visit(begin, end);
  }
}

// For each vertex the first one with its position and texture coordinate.
std::vector<std::uint32_t> firstVertexAtBoth(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = firstVertexAtPosition(mesh);
  std::map<std::pair<std::uint32_t, formats::Float2>, std::uint32_t> first;
  std::vector<std::uint32_t> result(mesh.vertexCount());
  for (std::uint32_t v = 0; v < result.size(); ++v)
    result[v] = first.try_emplace({place[v], mesh.texcoords[v]}, v).first->second;
  return result;
}

void findCharts(const TriangleMesh& mesh, AtlasFigures& figures) {
  const std::vector<EdgeUse> uses = sortedEdges(mesh, firstVertexAtBoth(mesh));
  std::vector<std::array<std::int64_t, 3>> across(mesh.triangleCount(), {-1, -1, -1});
  figures.chart_borders.assign(mesh.triangleCount(), {1, 1, 1});
  forEachEdge(uses, [&](std::size_t begin, std::size_t end) {
    const EdgeUse &a = uses[begin], &b = uses[end - 1];
    if (end - begin != 2 || a.upwards == b.upwards) return;
    across[a.triangle][a.edge] = b.triangle;
    across[b.triangle][b.edge] = a.triangle;
    figures.chart_borders[a.triangle][a.edge] = figures.chart_borders[b.triangle][b.edge] = 0;
  });
  constexpr std::uint32_t kNone = ~0U;
  figures.triangle_charts.assign(mesh.triangleCount(), kNone);
  std::vector<std::uint32_t> open;
  for (std::uint32_t first = 0; first < mesh.triangleCount(); ++first) {
    if (figures.triangle_charts[first] != kNone) continue;
    figures.triangle_charts[first] = figures.charts;
    open = {first};
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (const std::int64_t other : across[t]) {
        if (other < 0 || figures.triangle_charts[other] != kNone) continue;
        figures.triangle_charts[other] = figures.charts;
        open.push_back(static_cast<std::uint32_t>(other));
      }
    }
    ++figures.charts;
  }
}

bool isOutside(const Vec2& texcoord) {
  return texcoord.minCoeff() < 0 || texcoord.maxCoeff() > 1;
}

void measureStretch(const TriangleMesh& mesh, AtlasFigures& figures) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  transport::StretchSum sum;
  std::vector<double> chart_areas(figures.charts, 0.0), signed_areas;
  for (const Triangle& t : mesh.triangles) {
    std::array<Vec3, 3> surface;
    std::array<Vec2, 3> plane;
    for (std::size_t k = 0; k < 3; ++k) {
      surface[k] = transport::vec3(mesh.positions[t[k]]);
      plane[k] = Vec2(mesh.texcoords[t[k]][0], mesh.texcoords[t[k]][1]);
    }
    const double area = (surface[1] - surface[0]).cross(surface[2] - surface[0]).norm() / 2;
    const double signed_area = transport::crossOf(plane[0], plane[1], plane[2]) / 2;
    figures.unit_square_share += std::abs(signed_area);
    chart_areas[figures.triangle_charts[signed_areas.size()]] += signed_area;
    signed_areas.push_back(signed_area);
    figures.collapsed_triangles += signed_area == 0;
    figures.triangles_outside += std::any_of(plane.begin(), plane.end(), isOutside);
    figures.triangle_stretch.push_back(0);
    if (!(area > 0)) continue;
    transport::Singular singular = transport::singularValues(surface, plane);
    singular.smaller = std::abs(singular.smaller);  // a mirrored chart is no less even
    sum.add(area, singular, std::abs(signed_area));
    figures.triangle_stretch.back() =
        signed_area == 0
            ? kInfinity
            : std::sqrt(
                  (1 / (singular.smaller * singular.smaller) + 1 / (singular.larger * singular.larger)) / 2);
  }
  for (const double chart_area : chart_areas) figures.mirrored_charts += chart_area < 0;
  for (std::size_t t = 0; t < signed_areas.size(); ++t)
    figures.flipped_triangles += signed_areas[t] * chart_areas[figures.triangle_charts[t]] < 0;
  if (sum.area > 0) figures.l2_stretch = sum.plane_area > 0 ? sum.l2() : kInfinity;
  const double scale = sum.area > 0 ? std::sqrt(sum.plane_area / sum.area) : 1;
  for (double& stretch : figures.triangle_stretch)
    if (std::isfinite(stretch)) stretch = stretch > 0 ? stretch * scale : 1;
}

}  // namespace

AtlasFigures measureAtlas(const TriangleMesh& mesh) {
  AtlasFigures figures;
  findCharts(mesh, figures);
  measureStretch(mesh, figures);
  return figures;
}

std::vector<std::uint32_t> alternateNumbers(const TriangleMesh& mesh, const AtlasFigures& figures,
                                            std::uint32_t count) {
  const std::vector<EdgeUse> uses = sortedEdges(mesh, firstVertexAtPosition(mesh));
  std::vector<std::vector<std::uint32_t>> neighbors(figures.charts);
  forEachEdge(uses, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i + 1 < end; ++i) {
      const std::uint32_t a = figures.triangle_charts[uses[i].triangle],
                          b = figures.triangle_charts[uses[i + 1].triangle];
      if (a != b) neighbors[a].push_back(b), neighbors[b].push_back(a);
    }
  });
  constexpr std::uint32_t kNone = ~0U;
  std::vector<std::uint32_t> numbers(figures.charts, kNone);
  std::vector<std::uint64_t> uses_of(count, 0);
  for (std::uint32_t chart = 0; chart < figures.charts; ++chart) {
    std::vector<std::uint64_t> meetings(count, 0);
    for (const std::uint32_t other : neighbors[chart])
      if (numbers[other] != kNone) ++meetings[numbers[other]];
    std::uint32_t best = 0;
    for (std::uint32_t n = 1; n < count; ++n)
      if (std::tie(meetings[n], uses_of[n]) < std::tie(meetings[best], uses_of[best])) best = n;
    numbers[chart] = best;
    ++uses_of[best];
  }
  return numbers;
}

}  // namespace bakelight::inspect
