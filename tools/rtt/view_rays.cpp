#include "tools/rtt/view_rays.h"

#include <algorithm>
#include <cmath>

namespace bakelight::rtt {

using transport::Vec3;

namespace {

// In double: far origins would lose what tells neighbors apart.
double wrapped(double at, double period) {
  return at - period * std::floor(at / period);
}

}  // namespace

void rowOfViewRays(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                   const Vec3& view, const TexelGrid& grid, int y, transport::FreeRays& rays) {
  const double size = std::max({geometry.period_x, geometry.period_y, scene.highest()});
  const double start = (scene.highest() + 1e-3 * size) / view.z();
  const double across = 1.0 / (grid.width * grid.supersampling);
  const double down = geometry.aspect / (grid.height * grid.supersampling);
  for (int x = 0; x < grid.width; ++x)
    for (int j = 0; j < grid.supersampling; ++j)
      for (int i = 0; i < grid.supersampling; ++i) {
        const Vec3 point((x * grid.supersampling + i + 0.5) * across,
                         geometry.aspect - (y * grid.supersampling + j + 0.5) * down, 0);
        const Vec3 origin = point + start * view;
        rays.push(
            {wrapped(origin.x(), geometry.period_x), wrapped(origin.y(), geometry.period_y), origin.z()},
            -view);
      }
}

}  // namespace bakelight::rtt
