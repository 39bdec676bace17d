#include "tools/atlas/flatten/flattening.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/atlas/flatten/convex_boundary.h"
#include "tools/atlas/flatten/free_boundary.h"
#include "tools/atlas/flatten/injectivity.h"
#include "tools/atlas/flatten/untangling.h"

namespace bakelight::atlas {
namespace {

// The axis of about the narrowest cone that holds all normals: steps towards the farthest one (Bădoiu &
// Clarkson 2003).
Vec3 narrowestConeAxis(const Surface& surface, std::span<const std::uint32_t> triangles) {
  constexpr int kSteps = 64;
  Vec3 axis = meanNormal(surface, triangles);
  for (int step = 1; step <= kSteps; ++step) {
    const std::uint32_t farthest =
        *std::min_element(triangles.begin(), triangles.end(), [&](std::uint32_t a, std::uint32_t b) {
          return surface.normals[a].dot(axis) < surface.normals[b].dot(axis);
        });
    const Vec3 next = axis + (surface.normals[farthest] - axis) / (step + 1);
    if (!(next.norm() > 0)) break;
    axis = next.normalized();
  }
  return axis;
}

using Plane = std::optional<std::vector<Vec2>>;

// What rounding makes of an isometry, generously: so that flat charts pass a limit of 1.
constexpr double kRoundingStretch = 1e-6;
// How much more stretch a small chart may have.
constexpr double kSmallChartsExcess = 4;
// Of the last steps, see FreeBoundaryOptions.
constexpr double kLeastProgress = 1e-3;

Plane convexly(const Chart& chart, const FlatteningOptions& options) {
  if (!canBeConvex(chart)) return std::nullopt;
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t v : chart.borders[0])
    if (std::binary_search(options.corner_places.begin(), options.corner_places.end(), chart.places[v]))
      corners.push_back(v);
  auto result = convexBoundary(chart, corners, {options.corners});
  if (!result) return std::nullopt;
  return std::move(result->plane);
}

double largestStretch(const Chart& chart, const FlatteningOptions& options) {
  const double excess = chart.area < options.small_area ? kSmallChartsExcess : 1;
  return 1 + excess * (options.max_stretch - 1) + kRoundingStretch;
}

bool isWithinStretch(const Chart& chart, const std::vector<Vec2>& plane, const FlatteningOptions& options) {
  return stretchOf(chart, plane).l2() <= largestStretch(chart, options);
}

// From a start without flipped triangles until it is within the limits, or will hardly ever be.
std::vector<Vec2> relaxed(const Chart& chart, std::vector<Vec2> start, const FlatteningOptions& options) {
  return minimizeDistortion(chart, std::move(start), {.enough_l2 = largestStretch(chart, options)});
}

bool isGood(const Chart& chart, const std::vector<Vec2>& plane, const FlatteningOptions& options) {
  return isWithinStretch(chart, plane, options) && isInjective(chart, plane);
}

// Mends borders where that keeps within the limits.
bool mend(const Chart& chart, std::vector<Vec2>& plane, const FlatteningOptions& options) {
  std::vector<Vec2> before = plane;
  if (uncrossBorders(chart, plane) && isWithinStretch(chart, plane, options)) return true;
  plane = std::move(before);
  return false;
}

// Guides give a start near the least distortion, where parts that lie on each other still will.
Plane guided(const Surface& surface, const Chart& chart, const FlatteningOptions& options,
             const Guides& guides) {
  Plane plane = guidedStart(surface, chart, guides);
  if (!plane || !(isInjective(chart, *plane) || uncrossBorders(chart, *plane))) return std::nullopt;
  *plane = relaxed(chart, std::move(*plane), options);
  if (!isGood(chart, *plane, options)) mend(chart, *plane, options);
  return plane;
}

// Convex polygons are a start for whatever they take, but a slow one: what is larger is divided sooner.
Plane freely(const Surface& surface, const Chart& chart, const FlatteningOptions& options,
             const Guides& guides) {
  constexpr std::size_t kMostForConvex = 400, kMostForSecondTry = 10'000;
  if (!chart.isPlanar()) return std::nullopt;
  Plane plane = guided(surface, chart, options, guides);
  if (plane && (chart.triangles.size() > kMostForSecondTry || isGood(chart, *plane, options))) return plane;
  plane = flatStart(chart);
  if (!plane && (chart.triangles.size() <= kMostForConvex || !std::isfinite(options.max_stretch)))
    plane = convexly(chart, options);
  if (!plane) return plane;
  *plane = relaxed(chart, std::move(*plane), options);
  if (!isWithinStretch(chart, *plane, options) || isInjective(chart, *plane) || mend(chart, *plane, options))
    return plane;
  // Where little stretch comes sooner than that no part lies on another.
  *plane = minimizeDistortion(chart, std::move(*plane));
  uncrossBorders(chart, *plane);
  return plane;
}

Plane projected(const Surface& surface, const Chart& chart, double threshold_deg) {
  if (!chart.isPlanar()) return std::nullopt;
  const auto& triangles = chart.surface_triangles;
  for (const Vec3& axis : {meanNormal(surface, triangles), narrowestConeAxis(surface, triangles)})
    if (std::all_of(triangles.begin(), triangles.end(),
                    [&](std::uint32_t t) { return isWithin(surface, t, axis, threshold_deg); }))
      return projectedAlong(chart, axis);
  return std::nullopt;
}

// As it is, so that whatever else fails, one triangle lies flat.
Plane triangleAsItIs(const Chart& chart) {
  const Triangle& t = chart.triangles[0];
  const Vec3 ab = chart.positions[t[1]] - chart.positions[t[0]],
             ac = chart.positions[t[2]] - chart.positions[t[0]];
  std::vector<Vec2> plane(3, Vec2::Zero());
  plane[t[1]] = {ab.norm(), 0};
  plane[t[2]] = {ab.dot(ac) / ab.norm(), ab.cross(ac).norm() / ab.norm()};
  return plane;
}

Plane planeOf(const Surface& surface, const Chart& chart, const FlatteningOptions& options,
              const Guides& guides) {
  if (chart.triangles.size() == 1) return triangleAsItIs(chart);
  switch (options.parameterization) {
    case Parameterization::kFree:
      return freely(surface, chart, options, guides);
    case Parameterization::kConvex:
      return convexly(chart, options);
    case Parameterization::kProjection:
      return projected(surface, chart, options.normal_threshold_deg);
  }
  return std::nullopt;
}

void measure(FlatPiece& piece) {
  scaleForLeastStretch(piece.chart, piece.plane);
  piece.stretch = stretchOf(piece.chart, piece.plane);
}

bool isWithinStretch(const FlatPiece& piece, const FlatteningOptions& options) {
  return piece.stretch.l2() <= largestStretch(piece.chart, options);
}

// Takes the other plane if it is within the limits.
bool takeIfValid(FlatPiece& piece, std::vector<Vec2> plane, const FlatteningOptions& options) {
  if (!uncrossBorders(piece.chart, plane) || !isInjective(piece.chart, plane) ||
      !survivesRounding(piece.chart, plane))
    return false;
  std::swap(piece.plane, plane);
  const StretchSum before = piece.stretch;
  measure(piece);
  if (isWithinStretch(piece, options)) return true;
  std::swap(piece.plane, plane);
  piece.stretch = before;
  return false;
}

}  // namespace

Vec3 meanNormal(const Surface& surface, std::span<const std::uint32_t> triangles) {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t t : triangles) sum += surface.areas[t] * surface.normals[t];
  return sum.norm() > 0 ? sum.normalized() : sum;
}

bool isWithin(const Surface& surface, std::uint32_t triangle, const Vec3& axis, double threshold_deg) {
  return surface.normals[triangle].dot(axis) >= std::cos(threshold_deg * std::numbers::pi / 180);
}

Flattening flatten(const Surface& surface, std::span<const std::uint32_t> triangles,
                   const FlatteningOptions& options, const Guides& guides) {
  FlatPiece piece;
  piece.chart = chartOf(surface, triangles);
  Plane plane = planeOf(surface, piece.chart, options, guides);
  Flattening result;
  if (!plane) return result;
  piece.plane = std::move(*plane);
  result.directions = directionsIn(piece.chart, piece.plane);
  if (triangles.size() > 1 &&
      !(isInjective(piece.chart, piece.plane) && survivesRounding(piece.chart, piece.plane)))
    return result;

  measure(piece);
  if (triangles.size() > 1 && !isWithinStretch(piece, options))
    result.excess = (piece.stretch.l2() - 1) / (largestStretch(piece.chart, options) - 1);
  else
    result.piece = std::move(piece);
  return result;
}

bool straightenTeeth(FlatPiece& piece, const FlatteningOptions& options) {
  if (options.parameterization != Parameterization::kFree || !(options.straightness > 0) ||
      piece.chart.triangles.size() == 1)
    return false;
  return takeIfValid(
      piece,
      minimizeDistortion(piece.chart, piece.plane,
                         {.straightness = options.straightness, .least_progress = kLeastProgress}),
      options);
}

void finish(FlatPiece& piece, const FlatteningOptions& options) {
  if (options.parameterization != Parameterization::kFree || piece.chart.triangles.size() == 1) return;
  if (!straightenTeeth(piece, options))
    takeIfValid(piece, minimizeDistortion(piece.chart, piece.plane, {.least_progress = kLeastProgress}),
                options);
}

}  // namespace bakelight::atlas
