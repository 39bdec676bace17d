// Lays one chart flat, in the way that the atlas is to be parameterised.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/atlas/charts/chart.h"
#include "tools/atlas/charts/stretch.h"
#include "tools/atlas/flatten/guided_start.h"

namespace bakelight::atlas {

enum class Parameterization {
  kFree,        // borders free, least distortion (free_boundary.h)
  kConvex,      // convex polygons with their corners on a circle (convex_boundary.h)
  kProjection,  // orthographic, charts of similar normals (Lensch et al. 2002, 5.1)
};

struct FlatteningOptions {
  Parameterization parameterization = Parameterization::kFree;
  double max_stretch = std::numeric_limits<double>::infinity();  // L² stretch of each chart, ≥ 1
  // Charts with less area than this may have 4 times the stretch above 1: a surface that is rough at the
  // scale of its triangles has stretch in the smallest chart, and would fall to thousands of them.
  double small_area = 0;
  double straightness = 0;                   // free: see free_boundary.h
  double normal_threshold_deg = 30;          // projection: of triangles from the line of sight
  int corners = 8;                           // convex: of a polygon without chosen ones
  std::vector<std::uint32_t> corner_places;  // convex: chosen ones, ascending places of the surface
};

struct FlatPiece {
  Chart chart;
  std::vector<Vec2> plane;  // of the chart's vertices, counter-clockwise, at the scale of least stretch
  StretchSum stretch;
};

// Nothing if the triangles (connected, ascending) cannot be laid flat one-to-one within the limits: then they
// have to be divided. One triangle always can. Free borders are left as soon as they are within the limits:
// see finish(). They start from the guides where all triangles have one.
struct Flattening {
  std::optional<FlatPiece> piece;
  // By how many times the stretch above 1 exceeds the limit, where it could be told; else 0.
  double excess = 0;
  // Of the triangles, where none was flipped (guided_start.h).
  std::vector<Vec2> directions;
};
Flattening flatten(const Surface& surface, std::span<const std::uint32_t> triangles,
                   const FlatteningOptions& options, const Guides& guides = {});

// Free borders: the least distortion, with the teeth of borders drawn flat where that keeps within the
// limits.
void finish(FlatPiece& piece, const FlatteningOptions& options);

// Draws the teeth of a piece's borders flat where that keeps within the limits; else leaves it as it is and
// returns false. For free borders.
bool straightenTeeth(FlatPiece& piece, const FlatteningOptions& options);

// The mean normal, weighted by area; zero if the normals cancel.
Vec3 meanNormal(const Surface& surface, std::span<const std::uint32_t> triangles);
// Whether a triangle's normal is at most so far from the axis.
bool isWithin(const Surface& surface, std::uint32_t triangle, const Vec3& axis, double threshold_deg);

}  // namespace bakelight::atlas
