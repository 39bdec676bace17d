#include "tools/atlas/charts/stretch.h"

#include <cmath>

namespace bakelight::atlas {

StretchSum stretchOf(const Chart& chart, std::span<const Vec2> plane) {
  StretchSum sum;
  for (const Triangle& t : chart.triangles) {
    const std::array<Vec3, 3> corners = {chart.positions[t[0]], chart.positions[t[1]], chart.positions[t[2]]};
    const std::array<Vec2, 3> flat = {plane[t[0]], plane[t[1]], plane[t[2]]};
    const double area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2;
    sum.add(area, singularValues(corners, flat), crossOf(flat[0], flat[1], flat[2]) / 2);
  }
  return sum;
}

void scaleForLeastStretch(const Chart& chart, std::span<Vec2> plane) {
  const StretchSum sum = stretchOf(chart, plane);
  const double factor = std::pow(sum.weighted / sum.plane_area, 0.25);
  if (!(std::isfinite(factor) && factor > 0)) return;
  for (Vec2& p : plane) p *= factor;
}

}  // namespace bakelight::atlas
