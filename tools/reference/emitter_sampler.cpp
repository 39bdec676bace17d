#include "tools/reference/emitter_sampler.h"

#include <cmath>

#include "transport/random.h"

namespace bakelight::reference {

using transport::vec3;

EmitterSampler::EmitterSampler(const transport::EmitterMesh& emitters) {
  const auto& [mesh, radiance] = emitters;
  cumulative_power_.push_back(0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 corner = vec3(mesh.positions[a]);
    Triangle triangle{corner, vec3(mesh.positions[b]) - corner, vec3(mesh.positions[c]) - corner,
                      Vec3::Zero(), vec3(radiance[a])};
    const Vec3 cross = triangle.edge1.cross(triangle.edge2);
    if (cross.norm() > 0) triangle.normal = cross.normalized();
    triangle.density_per_area = transport::luminance(radiance[a]);
    cumulative_power_.push_back(cumulative_power_.back() + triangle.density_per_area * cross.norm() / 2);
    triangles_.push_back(triangle);
  }
  const double power = cumulative_power_.back();
  if (!(power > 0)) return;
  for (double& value : cumulative_power_) value /= power;
  for (Triangle& triangle : triangles_) triangle.density_per_area /= power;
}

EmitterSampler::Sample EmitterSampler::sample(double u, double v) const {
  const transport::DrawnInterval drawn = transport::drawInterval(cumulative_power_, u);
  const Triangle& triangle = triangles_[drawn.index];
  // Uniform in the triangle: Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
  double b1 = drawn.rest, b2 = v;
  if (b2 > b1) {
    b1 /= 2;
    b2 -= b1;
  } else {
    b2 /= 2;
    b1 -= b2;
  }
  return {triangle.corner + b1 * triangle.edge1 + b2 * triangle.edge2,
          static_cast<std::uint32_t>(drawn.index)};
}

double EmitterSampler::densityPerSr(std::uint32_t index, const Vec3& direction, double distance) const {
  const Triangle& triangle = triangles_[index];
  return triangle.density_per_area * distance * distance / std::abs(triangle.normal.dot(direction));
}

}  // namespace bakelight::reference
