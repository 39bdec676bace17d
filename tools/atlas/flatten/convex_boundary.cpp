#include "tools/atlas/flatten/convex_boundary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/exact.h"
#include "tools/atlas/flatten/convex_border.h"
#include "tools/atlas/flatten/disk_interior.h"

namespace bakelight::atlas {
namespace {

// What the area that fills a hole or a notch counts for: it only keeps it open.
constexpr double kFillingWeight = 1e-3;

// The first corner at the origin, the second on the x axis.
std::array<Vec2, 3> laidFlat(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a;
  const double length = ab.norm();
  return {Vec2(0, 0), Vec2(length, 0), Vec2(ab.dot(ac) / length, ab.cross(ac).norm() / length)};
}

// A slice of the regular cone over a hole of `sides` edges: its angle at the last corner is that of a regular
// polygon.
std::array<Vec2, 3> slice(double edge_length, std::size_t sides) {
  const double height = edge_length / 2 / std::tan(std::numbers::pi / static_cast<double>(sides));
  return {Vec2(0, 0), Vec2(edge_length, 0), Vec2(edge_length / 2, height)};
}

// The chart with what fills its notches, and a fan around a vertex of its own in each hole. A hole of two
// edges is a slit: the map closes it.
DiskMesh filledDisk(const Chart& chart, const ConvexBorder& border) {
  DiskMesh mesh;
  mesh.triangles = chart.triangles;
  for (const auto& [a, b, c] : chart.triangles)
    mesh.shapes.push_back(laidFlat(chart.positions[a], chart.positions[b], chart.positions[c]));
  mesh.weights.assign(chart.triangles.size(), 1.0);
  mesh.fixed.assign(chart.vertexCount(), 0);
  for (std::size_t i = 0; i < border.points.size(); ++i) mesh.fixed[chart.borders[0][i]] = !border.inside[i];
  for (const NotchTriangle& notch : border.notches) {
    mesh.triangles.push_back(notch.vertices);
    mesh.shapes.push_back(notch.shape);
    mesh.weights.push_back(kFillingWeight);
  }
  for (std::size_t hole = 1; hole < chart.borders.size(); ++hole) {
    const std::vector<std::uint32_t>& loop = chart.borders[hole];
    if (loop.size() < 3) continue;
    const auto center = static_cast<std::uint32_t>(mesh.vertexCount());
    mesh.fixed.push_back(0);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::uint32_t a = loop[i], b = loop[(i + 1) % loop.size()];
      mesh.triangles.push_back({b, a, center});  // the chart is to the left of a → b
      mesh.shapes.push_back(slice((chart.positions[b] - chart.positions[a]).norm(), loop.size()));
      mesh.weights.push_back(kFillingWeight);
    }
  }
  return mesh;
}

// Those that fill holes and notches included: only then does no part lie over another.
bool isOneToOne(const DiskMesh& mesh, const std::vector<Vec2>& plane) {
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    return orientation(plane[t[0]], plane[t[1]], plane[t[2]]) > 0;
  });
}

std::vector<Vec2> atChartsArea(const Chart& chart, std::vector<Vec2> plane) {
  double twice_area = 0;
  for (const auto& [a, b, c] : chart.triangles) twice_area += crossOf(plane[a], plane[b], plane[c]);
  for (Vec2& point : plane) point *= std::sqrt(2 * chart.area / twice_area);
  return plane;
}

ConvexChart oneTriangle(const Chart& chart) {
  ConvexChart result;
  const auto& [a, b, c] = chart.triangles.front();
  const auto shape = laidFlat(chart.positions[a], chart.positions[b], chart.positions[c]);
  result.plane.resize(3);
  result.plane[a] = shape[0], result.plane[b] = shape[1], result.plane[c] = shape[2];
  result.corners = chart.borders.front();
  result.mean_value_l2 = result.l2 = 1;
  return result;
}

}  // namespace

bool canBeConvex(const Chart& chart) {
  return chart.isPlanar() && chart.borders.front().size() >= 3;
}

std::optional<ConvexChart> convexBoundary(const Chart& chart, std::span<const std::uint32_t> chosen_corners,
                                          const ConvexOptions& options) {
  if (!canBeConvex(chart)) throw std::logic_error("a chart that is no disk has no convex border");
  if (chart.triangles.size() == 1) return oneTriangle(chart);
  const ConvexBorder border = convexBorder(chart, chosen_corners, options.corners);
  ConvexChart result;
  for (const std::uint32_t i : border.corners) result.corners.push_back(chart.borders[0][i]);
  result.added_corners = border.added_corners;
  result.bulged_sides = border.bulged_sides;
  result.shortened_sides = border.shortened_sides;
  result.vertices_inside = static_cast<std::int64_t>(border.notches.size());

  const DiskMesh mesh = filledDisk(chart, border);
  for (const InteriorWeights weights : {InteriorWeights::kMeanValue, InteriorWeights::kUniform}) {
    std::vector<Vec2> start(mesh.vertexCount(), Vec2::Zero());
    for (std::size_t i = 0; i < border.points.size(); ++i) start[chart.borders[0][i]] = border.points[i];
    if (!solveInterior(mesh, weights, start)) continue;
    start = atChartsArea(chart, std::move(start));
    if (!isOneToOne(mesh, start)) continue;
    result.mean_value_l2 = stretchOf(chart, start).l2();

    std::vector<Vec2> best = start;
    minimizeStretch(mesh, best);
    best = atChartsArea(chart, std::move(best));
    result.l2 = stretchOf(chart, best).l2();
    if (!isOneToOne(mesh, best) || !(result.l2 <= result.mean_value_l2)) {
      best = start;
      result.l2 = result.mean_value_l2;
    }
    best.resize(chart.vertexCount());
    result.plane = std::move(best);
    return result;
  }
  return std::nullopt;
}

}  // namespace bakelight::atlas
