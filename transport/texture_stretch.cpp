#include "transport/texture_stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bakelight::transport {

Singular singularValues(const std::array<Vec3, 3>& surface, const std::array<Vec2, 3>& plane) {
  // The triangle in its own plane: a at the origin, b on the x axis.
  const Vec3 ab = surface[1] - surface[0], ac = surface[2] - surface[0];
  const double bx = ab.norm(), cx = ab.dot(ac) / bx, cy = ab.cross(ac).norm() / bx;
  const Vec2 column_x = (plane[1] - plane[0]) / bx;
  const Vec2 column_y = (plane[2] - plane[0] - column_x * cx) / cy;
  // Closed form of the 2×2 case: half sums and differences of the rotation and the mirrored part.
  const double similar = std::hypot(column_x.x() + column_y.y(), column_x.y() - column_y.x()) / 2;
  const double mirrored = std::hypot(column_x.x() - column_y.y(), column_x.y() + column_y.x()) / 2;
  return {similar + mirrored, similar - mirrored};
}

void StretchSum::add(double triangle_area, const Singular& singular, double triangle_plane_area) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double wide = singular.smaller > 0 ? 1 / singular.smaller : kInfinity;
  const double narrow = singular.larger > 0 ? 1 / singular.larger : kInfinity;
  area += triangle_area;
  plane_area += triangle_plane_area;
  weighted += triangle_area * (wide * wide + narrow * narrow) / 2;
  conformal += triangle_area * (singular.smaller > 0 ? singular.larger / singular.smaller : kInfinity);
  worst = std::max(worst, wide);
}

void StretchSum::add(const StretchSum& other) {
  area += other.area;
  plane_area += other.plane_area;
  weighted += other.weighted;
  conformal += other.conformal;
  worst = std::max(worst, other.worst);
}

double StretchSum::l2() const {
  return std::sqrt(weighted / area * plane_area / area);
}

double StretchSum::lInfinity() const {
  return worst * std::sqrt(plane_area / area);
}

}  // namespace bakelight::transport
