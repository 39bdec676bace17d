// The spherical polygon: its SH coefficients in closed form, and which directions it covers.
#pragma once

#include <span>
#include <vector>

#include "transport/sh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// ∫ y_lm over the polygon whose corners lie in the directions `vertices` (of any length but 0) and whose
// edges are great-circle arcs; order² values, exact to rounding (about 1e-14). The polygon is simple; either
// orientation, and of the two regions that its outline bounds the smaller one is meant. Fewer than three
// different corners give zero.
//
// Band 0 is the solid angle (van Oosterom & Strackee 1983). Since y_lm is an eigenfunction of the spherical
// Laplacian, Green's theorem makes of the other bands an integral along the outline,
//   ∫_P y_lm = −1/(l(l+1)) ∮ ∂y_lm/∂ν,
// and with an edge turned into the equator the derivative is a constant × cos mφ or sin mφ. (Other closed
// forms: Wang & Ramamoorthi 2018, "Analytic Spherical Harmonic Coefficients for Polygonal Area Lights";
// Belcour et al. 2018.)
//
// Throws Error(kBadInput) naming the vertex that has no direction, or whose edge to the next joins opposite
// directions. Cost: one ShRotation an edge.
std::vector<double> polygonSh(int order, std::span<const Vec3> vertices);

// Steradians, 0–2π; the same polygons and errors.
double polygonSolidAngle(std::span<const Vec3> vertices);

class PolygonOutline {
 public:
  // Throws Error(kBadInput) if the polygon does not lie within an open hemisphere.
  explicit PolygonOutline(std::span<const Vec3> vertices);

  bool contains(const Vec3& direction) const;
  // A direction from which all corners are less than 90° away.
  const Vec3& axis() const { return frame_[2]; }

 private:
  Eigen::Vector2d projected(const Vec3& direction) const;

  std::vector<Vec3> frame_;  // x, y and the axis
  std::vector<Eigen::Vector2d>
      corners_;  // on the plane at distance 1 along the axis, where arcs are straight
};

}  // namespace bakelight::transport
