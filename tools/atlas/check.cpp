#include "tools/atlas/check.h"

#include <algorithm>
#include <cmath>

#include "formats/error.h"
#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/charts/surface.h"
#include "tools/atlas/flatten/border_crossings.h"
#include "tools/atlas/maps/label_grid.h"
#include "tools/atlas/maps/raster.h"
#include "tools/atlas/maps/texture_edges.h"

namespace bakelight::atlas {
namespace {

using formats::Float2;
using formats::TriangleMesh;

std::array<Vec2, 3> cornersOf(const TriangleMesh& mesh, std::size_t triangle) {
  return texelTriangle(mesh, triangle, 1);
}

int turnOf(const std::array<Vec2, 3>& corners) {
  const auto& [a, b, c] = corners;
  return a.allFinite() && b.allFinite() && c.allFinite() ? orientationOf(a, b, c) : 0;
}

// Counts how many spans lie over each texel, in O(1) a span: what begins there less what ends.
class CoverageCount {
 public:
  explicit CoverageCount(int resolution)
      : row_length_(resolution + 1), changes_(static_cast<std::size_t>(row_length_) * resolution, 0) {}

  void add(const RowSpan& span) {
    std::int32_t* row = &changes_[static_cast<std::size_t>(span.row) * row_length_];
    ++row[span.begin], --row[span.end];
  }
  std::int64_t texelsWithAtLeast(int count) const {
    std::int64_t texels = 0;
    std::int32_t depth = 0;  // 0 again behind each row
    for (const std::int32_t change : changes_) texels += (depth += change) >= count;
    return texels;
  }

 private:
  int row_length_;
  std::vector<std::int32_t> changes_;
};

// Texels by the chart that touches them.
class TouchedCharts {
 public:
  explicit TouchedCharts(int resolution) : grid_(resolution) {}

  void add(const RowSpan& span, std::int32_t chart) {
    for (int i = span.begin; i < span.end && !is_shared_; ++i) {
      std::int32_t& label = grid_.at(i, span.row);
      is_shared_ = label != LabelGrid::kNone && label != chart;
      label = chart;
    }
  }
  int smallestGutter() { return is_shared_ ? -1 : grid_.smallestGap().value_or(grid_.resolution()); }

 private:
  LabelGrid grid_;
  bool is_shared_ = false;
};

void judgeTexels(const Atlas& atlas, AtlasFigures& figures) {
  const int resolution = figures.resolution;
  CoverageCount centers(resolution), touched(resolution);
  TouchedCharts charts(resolution);
  std::vector<RowSpan> spans;
  for (std::size_t t = 0; t < atlas.mesh.triangleCount(); ++t) {
    const TexelTriangle triangle = texelTriangle(atlas.mesh, t, resolution);
    figures.triangles_below_texel += !(std::abs(crossOf(triangle[0], triangle[1], triangle[2])) >= 2);
    centerSpans(triangle, resolution, spans);
    figures.triangles_without_texel += spans.empty();
    for (const RowSpan& span : spans) centers.add(span);
    if (turnOf(triangle) == 0) continue;
    touchedSpans(triangle, resolution, spans);
    for (const RowSpan& span : spans) {
      touched.add(span);
      charts.add(span, static_cast<std::int32_t>(atlas.triangle_charts[t]));
    }
  }
  const double texels = static_cast<double>(resolution) * resolution;
  figures.overlapping_texels = centers.texelsWithAtLeast(2);
  figures.utilisation = static_cast<double>(centers.texelsWithAtLeast(1)) / texels;
  figures.touched = static_cast<double>(touched.texelsWithAtLeast(1)) / texels;
  figures.smallest_gutter = charts.smallestGutter();
}

void judgeBorders(const TriangleMesh& mesh, double surface_area, AtlasFigures& figures) {
  std::vector<BorderSegment> segments;
  double length = 0;
  for (const TextureEdge& edge : borderEdges(mesh)) {
    const std::size_t next = (edge.edge + 1u) % 3;
    const formats::Triangle& t = mesh.triangles[edge.triangle];
    length +=
        (transport::vec3(mesh.positions[t[next]]) - transport::vec3(mesh.positions[t[edge.edge]])).norm();
    const std::array<Vec2, 3> corners = cornersOf(mesh, edge.triangle);
    const Vec2 &from = corners[edge.edge], &to = corners[next];
    if (from.allFinite() && to.allFinite() && from != to) segments.push_back({from, to, turnOf(corners)});
  }
  figures.border_length = length / std::sqrt(surface_area);
  figures.crossing_edges = countCrossings(segments, kMostCrossings);
}

// 1: counter-clockwise, −1: mirrored; of each chart.
std::vector<int> chartTurns(const Atlas& atlas) {
  std::vector<double> areas(atlas.chart_count, 0);
  for (std::size_t t = 0; t < atlas.mesh.triangleCount(); ++t) {
    const std::array<Vec2, 3> corners = cornersOf(atlas.mesh, t);
    if (turnOf(corners) != 0) areas[atlas.triangle_charts[t]] += crossOf(corners[0], corners[1], corners[2]);
  }
  std::vector<int> turns(areas.size());
  std::transform(areas.begin(), areas.end(), turns.begin(), [](double area) { return area < 0 ? -1 : 1; });
  return turns;
}

// Stretch of each chart; and what has turned over or collapsed.
std::vector<StretchSum> judgeTriangles(const Atlas& atlas, const Surface& surface, AtlasFigures& figures) {
  const std::vector<int> turns = chartTurns(atlas);
  figures.mirrored_charts = std::count(turns.begin(), turns.end(), -1);
  for (std::size_t t = 0; t < atlas.mesh.triangleCount(); ++t)
    figures.flipped += turnOf(cornersOf(atlas.mesh, t)) == -turns[atlas.triangle_charts[t]];

  std::vector<StretchSum> charts(atlas.chart_count);
  for (std::size_t s = 0; s < surface.triangleCount(); ++s) {
    const std::uint32_t t = surface.source_triangles[s], chart = atlas.triangle_charts[t];
    std::array<Vec2, 3> plane = cornersOf(atlas.mesh, t);
    const int turn = turnOf(plane);
    figures.collapsed += turn == 0;
    if (turn != turns[chart]) continue;
    for (Vec2& corner : plane) corner.x() *= turn;
    const std::array<Vec3, 3> corners = {surface.corner(s, 0), surface.corner(s, 1), surface.corner(s, 2)};
    charts[chart].add(surface.areas[s], singularValues(corners, plane),
                      crossOf(plane[0], plane[1], plane[2]) / 2);
  }
  return charts;
}

void sumStretch(const std::vector<StretchSum>& charts, AtlasFigures& figures) {
  StretchSum whole;
  double least_density = 0, largest_density = 0;
  for (const StretchSum& chart : charts) {
    if (!(chart.area > 0)) continue;
    const double density = std::sqrt(chart.plane_area / chart.area);
    least_density = whole.area > 0 ? std::min(least_density, density) : density;
    largest_density = std::max(largest_density, density);
    figures.worst_chart_l2 = std::max(figures.worst_chart_l2, chart.l2());
    whole.add(chart);
  }
  if (!(whole.area > 0)) return;
  figures.l2_stretch = whole.l2();
  figures.l_infinity_stretch = whole.lInfinity();
  figures.mean_anisotropy = whole.meanAnisotropy();
  figures.texel_density_spread = largest_density / least_density;
}

// Vertices that no triangle has do not count.
std::int64_t verticesOutside(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> outside(mesh.vertexCount(), 0);
  for (const formats::Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle)
      for (const float x : mesh.texcoords[v]) outside[v] |= !(x >= 0 && x <= 1);
  return std::count(outside.begin(), outside.end(), 1);
}

}  // namespace

AtlasFigures check(const Atlas& atlas, int resolution, const std::string& file) {
  if (atlas.mesh.texcoords.empty())
    throw badInput({file, "", ""}, "the mesh has no texture coordinates", "an atlas",
                   "run atlas on it first");
  AtlasFigures figures;
  figures.charts = atlas.chart_count;
  figures.triangles = static_cast<std::int64_t>(atlas.mesh.triangleCount());
  figures.resolution = resolution;
  figures.outside = verticesOutside(atlas.mesh);

  const Surface surface = surfaceOf(atlas.mesh, file);
  sumStretch(judgeTriangles(atlas, surface, figures), figures);
  judgeTexels(atlas, figures);
  judgeBorders(atlas.mesh, 1 / (surface.scale * surface.scale), figures);
  return figures;
}

}  // namespace bakelight::atlas
