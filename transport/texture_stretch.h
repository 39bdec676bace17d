// How far texture coordinates are from the surface: singular values, texture stretch (Sander et al. 2001,
// section 3).
#pragma once

#include <array>

#include "transport/vector_types.h"

namespace bakelight::transport {

using Vec2 = Eigen::Vector2d;

// Lengths in the plane by lengths on the surface: the largest and smallest factor in any direction. `smaller`
// is negative if the triangle is flipped. Not finite for a triangle of the surface without area.
struct Singular {
  double larger = 0, smaller = 0;
};
Singular singularValues(const std::array<Vec3, 3>& surface, const std::array<Vec2, 3>& plane);

// Twice the signed area.
inline double crossOf(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Sums over triangles, so that charts, or whole atlases, can be put together. Sander's Γ and γ are 1/smaller
// and 1/larger, as his map goes from the plane to the surface.
struct StretchSum {
  double area = 0;        // of the surface
  double plane_area = 0;  // signed
  double weighted = 0;    // Σ area · (Γ² + γ²) / 2
  double conformal = 0;   // Σ area · Γ / γ
  double worst = 0;       // largest Γ

  // An infinite stretch for a triangle without area in the plane, or flipped.
  void add(double triangle_area, const Singular& singular, double triangle_plane_area);
  void add(const StretchSum& other);
  // L² stretch at the scale that gives the plane the area of the surface: 1 for an isometry, else larger.
  double l2() const;
  // L∞ stretch at that scale.
  double lInfinity() const;
  // Area-weighted mean of Γ/γ, 1 for a conformal map.
  double meanAnisotropy() const { return conformal / area; }
};

}  // namespace bakelight::transport
