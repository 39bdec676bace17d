// Lays a chart flat with as little distortion as possible, its border free to move.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

struct FreeBoundaryOptions {
  int iterations = 25;  // Newton steps at most
  // Weight of Σ |border vertex − middle of its neighbours along the border|² beside the energy, both in units
  // of area, where the start's border has teeth: draws them flat, as teeth cannot be packed tightly, at the
  // cost of some stretch there. Corners, arcs and straight lines are left alone.
  double straightness = 0;
  // Stops when a step lowers the energy above that of an isometry by less, relatively.
  double least_progress = 1e-4;
  // Not 0: stops as soon as the L² stretch is no more than this, or will hardly ever be.
  double enough_l2 = 0;
};

// Orthographic; `normal` of unit length points to the viewer.
std::vector<Vec2> projectedAlong(const Chart& chart, const Vec3& normal);

// A start without flipped triangles: the projection along the mean normal if no triangle turns away from it,
// else least squares conformal maps (Lévy et al. 2002). Nothing if that flips triangles.
std::optional<std::vector<Vec2>> flatStart(const Chart& chart);

// Minimises the symmetric Dirichlet energy Σ area · (σ₁² + σ₂² + 1/σ₁² + 1/σ₂²) (Smith & Schaefer 2015) from
// `start`, which must not flip triangles, by Newton's method on the energy's positive part, whose
// eigenvectors are known in closed form (Smith, de Goes & Kim 2019); a line search keeps every triangle from
// turning over. It punishes stretching and shrinking alike, so near isometry its minimum is that of the L²
// stretch, too. Borders may come to cross: see injectivity.h. Cost: about 10 sparse factorisations of 2 ·
// vertices unknowns; 5 ms for 500 triangles.
std::vector<Vec2> minimizeDistortion(const Chart& chart, std::vector<Vec2> start,
                                     const FreeBoundaryOptions& options = {});

}  // namespace bakelight::atlas
