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

using transport::Float3, transport::SurfaceHit, transport::Vec3;

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
  GBuffer gbuffer{grid, object.triangleCount(), {}};
  gbuffer.hits.resize(static_cast<std::size_t>(grid.width_px) * grid.height_px * s * s,
                      {GBuffer::kNothing, 0, 0});
  tbb::parallel_for(0, grid.height_px, [&](int y) {
    transport::SurfaceHit* point = &gbuffer.hits[static_cast<std::size_t>(y) * grid.width_px * s * s];
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

Picture pictureOf(const GBuffer& gbuffer, const transport::RadianceAtHits& object,
                  const transport::RadianceAtHits& emitters) {
  const auto& grid = gbuffer.grid;
  const std::size_t subsamples = static_cast<std::size_t>(grid.supersampling) * grid.supersampling;
  const std::size_t row_samples = static_cast<std::size_t>(grid.width_px) * subsamples;
  Picture picture{formats::Image(grid.width_px, grid.height_px, {"R", "G", "B", "A"}), {}};
  picture.covered.resize(static_cast<std::size_t>(grid.width_px) * grid.height_px);
  tbb::parallel_for(0, grid.height_px, [&](int y) {
    const std::span<const SurfaceHit> hits(&gbuffer.hits[static_cast<std::size_t>(y) * row_samples],
                                           row_samples);
    std::vector<SurfaceHit> on_object, on_emitters;
    for (SurfaceHit hit : hits) {
      if (hit.triangle == GBuffer::kNothing) continue;
      if (hit.triangle < gbuffer.object_triangles) {
        on_object.push_back(hit);
      } else {
        hit.triangle -= static_cast<std::uint32_t>(gbuffer.object_triangles);
        on_emitters.push_back(hit);
      }
    }
    std::vector<Float3> of_object(on_object.size()), of_emitters(on_emitters.size());
    object(on_object, of_object);
    emitters(on_emitters, of_emitters);
    auto next_object = of_object.begin(), next_emitter = of_emitters.begin();
    for (int x = 0; x < grid.width_px; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * grid.width_px + x;
      std::array<double, 4> sum{};
      std::size_t seen_object = 0;
      for (const SurfaceHit& hit : hits.subspan(static_cast<std::size_t>(x) * subsamples, subsamples)) {
        if (hit.triangle == GBuffer::kNothing) continue;
        const bool is_object = hit.triangle < gbuffer.object_triangles;
        seen_object += is_object ? 1 : 0;
        const Float3& radiance = is_object ? *next_object++ : *next_emitter++;
        for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += radiance[channel];
        sum[3] += 1;
      }
      for (std::size_t channel = 0; channel < 4; ++channel)
        picture.linear.values[4 * pixel + channel] =
            static_cast<float>(sum[channel] / static_cast<double>(subsamples));
      picture.covered[pixel] = seen_object == subsamples;
    }
  });
  return picture;
}

}  // namespace bakelight::report
