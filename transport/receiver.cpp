#include "transport/receiver.h"

#include <Eigen/Geometry>
#include <numbers>

namespace bakelight::transport {

Vec3 Receiver::middleAt(double time_s) const {
  const double turn = orbit_s > 0 ? 2 * std::numbers::pi * time_s / orbit_s : 0;
  return Eigen::AngleAxisd(turn, Vec3::UnitY()) * vec3(position);
}

formats::TriangleMesh unitSphere() {
  constexpr std::uint32_t kRings = 32, kSides = 64;
  formats::TriangleMesh mesh;
  for (std::uint32_t ring = 0; ring <= kRings; ++ring)
    for (std::uint32_t side = 0; side <= kSides; ++side) {
      const double polar = std::numbers::pi * ring / kRings, azimuth = 2 * std::numbers::pi * side / kSides;
      mesh.normals.push_back(float3(
          {std::sin(polar) * std::sin(azimuth), std::cos(polar), std::sin(polar) * std::cos(azimuth)}));
      if (ring == kRings || side == kSides) continue;
      const std::uint32_t a = ring * (kSides + 1) + side, b = a + kSides + 1;
      if (ring > 0) mesh.triangles.push_back({a, b, a + 1});
      if (ring + 1 < kRings) mesh.triangles.push_back({a + 1, b, b + 1});
    }
  mesh.positions = mesh.normals;
  return mesh;
}

formats::TriangleMesh unitSized(formats::TriangleMesh mesh) {
  const BoundingSphere bounds = boundingSphere(mesh);
  for (formats::Float3& position : mesh.positions)
    position = float3((vec3(position) - bounds.center) / (bounds.radius > 0 ? bounds.radius : 1));
  return mesh;
}

}  // namespace bakelight::transport
