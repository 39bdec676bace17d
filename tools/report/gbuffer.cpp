#include "tools/report/gbuffer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "transport/near_light.h"
#include "transport/ray_scene.h"

namespace bakelight::report {

using transport::Float3, transport::Vec3;

transport::OrbitCamera cameraFrom(const Vec3& eye, const Vec3& target, double field_of_view_deg) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const Vec3 offset = eye - target;
  transport::OrbitCamera camera;
  camera.target = target;
  camera.distance = offset.norm();
  if (!(camera.distance > 0)) throw std::invalid_argument("a camera does not stand where it looks");
  camera.yaw_deg = std::atan2(offset.x(), offset.z()) * kDegrees;
  camera.pitch_deg = std::asin(std::clamp(offset.y() / camera.distance, -1.0, 1.0)) * kDegrees;
  camera.field_of_view_deg = field_of_view_deg;
  return camera;
}

GBuffer traceGBuffer(const formats::TriangleMesh& object, const transport::EmitterMesh& emitters,
                     const Eigen::Matrix3d& world_from_object, const transport::OrbitCamera& camera,
                     const transport::PictureGrid& grid) {
  formats::TriangleMesh world;
  world.positions = object.positions;
  world.triangles = object.triangles;
  transport::turnAbout(camera.target, world_from_object, world.positions);
  const auto first = static_cast<std::uint32_t>(world.vertexCount());
  world.positions.insert(world.positions.end(), emitters.mesh.positions.begin(),
                         emitters.mesh.positions.end());
  for (const auto& [a, b, c] : emitters.mesh.triangles)
    world.triangles.push_back({first + a, first + b, first + c});

  const transport::RayScene scene(world);
  const Vec3 eye = camera.eye();
  const int s = grid.supersampling;
  GBuffer gbuffer{grid, std::move(world.triangles), object.triangleCount(), {}};
  gbuffer.points.resize(static_cast<std::size_t>(grid.width_px) * grid.height_px * s * s);
  tbb::parallel_for(0, grid.height_px, [&](int y) {
    SurfacePoint* point = &gbuffer.points[static_cast<std::size_t>(y) * grid.width_px * s * s];
    for (int x = 0; x < grid.width_px; ++x)
      for (int row = y * s; row < (y + 1) * s; ++row)
        for (int column = x * s; column < (x + 1) * s; ++column, ++point) {
          const transport::Hit hit = scene.nearestHit(
              eye, camera.directionThrough(column + 0.5, row + 0.5, grid.width_px * s, grid.height_px * s));
          if (hit.valid) *point = {hit.triangle, hit.u, hit.v};
        }
  });
  return gbuffer;
}

Picture pictureOf(const GBuffer& gbuffer, std::span<const Float3> object_radiance,
                  std::span<const Float3> emitter_radiance) {
  const auto& grid = gbuffer.grid;
  const std::size_t subsamples = static_cast<std::size_t>(grid.supersampling) * grid.supersampling;
  const auto radianceOf = [&](std::uint32_t vertex) -> const Float3& {
    return vertex < object_radiance.size() ? object_radiance[vertex]
                                           : emitter_radiance[vertex - object_radiance.size()];
  };
  Picture picture{formats::Image(grid.width_px, grid.height_px, {"R", "G", "B", "A"}), {}};
  picture.covered.resize(static_cast<std::size_t>(grid.width_px) * grid.height_px);
  tbb::parallel_for(std::size_t{0}, picture.covered.size(), [&](std::size_t pixel) {
    std::array<double, 4> sum{};
    std::size_t on_object = 0;
    for (std::size_t i = 0; i < subsamples; ++i) {
      const SurfacePoint& point = gbuffer.points[pixel * subsamples + i];
      if (point.triangle == SurfacePoint::kNothing) continue;
      if (point.triangle < gbuffer.object_triangles) ++on_object;
      const auto& [a, b, c] = gbuffer.triangles[point.triangle];
      for (std::size_t channel = 0; channel < 3; ++channel)
        sum[channel] += (1 - point.u - point.v) * radianceOf(a)[channel] + point.u * radianceOf(b)[channel] +
                        point.v * radianceOf(c)[channel];
      sum[3] += 1;
    }
    for (std::size_t channel = 0; channel < 4; ++channel)
      picture.linear.values[4 * pixel + channel] =
          static_cast<float>(sum[channel] / static_cast<double>(subsamples));
    picture.covered[pixel] = on_object == subsamples;
  });
  return picture;
}

}  // namespace bakelight::report
