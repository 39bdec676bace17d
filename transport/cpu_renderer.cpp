#include "transport/cpu_renderer.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "transport/color.h"

namespace bakelight::transport {
namespace {

formats::Float4 interpolate(const formats::Triangle& triangle, std::span<const Float3> vertex_radiance,
                            float u, float v) {
  formats::Float4 radiance = {0, 0, 0, 1};
  for (std::size_t c = 0; c < 3; ++c)
    radiance[c] = (1 - u - v) * vertex_radiance[triangle[0]][c] + u * vertex_radiance[triangle[1]][c] +
                  v * vertex_radiance[triangle[2]][c];
  return radiance;
}

}  // namespace

CpuPicture renderOnCpu(const formats::TriangleMesh& mesh, const RayScene& scene,
                       std::span<const Float3> vertex_radiance, const OrbitCamera& camera,
                       const PictureGrid& grid, const Backdrop& backdrop) {
  if (vertex_radiance.size() != mesh.vertexCount())
    throw std::invalid_argument("one radiance a vertex is needed");
  if (grid.width_px < 1 || grid.height_px < 1 || grid.supersampling < 1)
    throw std::invalid_argument("the picture has no pixels");
  const int columns = grid.width_px * grid.supersampling, rows = grid.height_px * grid.supersampling;
  const Vec3 eye = camera.eye();
  CpuPicture picture{formats::Image(grid.width_px, grid.height_px, {"R", "G", "B", "A"}),
                     std::vector<SubsampleHit>(static_cast<std::size_t>(columns) * rows)};

  const auto seenThrough = [&](int column, int row) {
    const Vec3 direction = camera.directionThrough(column + 0.5, row + 0.5, columns, rows);
    const Hit hit = scene.nearestHit(eye, direction);
    if (!hit.valid) return backdrop(direction);
    picture.hits[static_cast<std::size_t>(row) * columns + column] = {hit.distance, hit.triangle};
    return interpolate(mesh.triangles[hit.triangle], vertex_radiance, hit.u, hit.v);
  };
  const auto shadePixel = [&](int x, int y) {
    std::array<double, 4> sum{};
    for (int row = y * grid.supersampling; row < (y + 1) * grid.supersampling; ++row)
      for (int column = x * grid.supersampling; column < (x + 1) * grid.supersampling; ++column) {
        const formats::Float4 seen = seenThrough(column, row);
        for (std::size_t c = 0; c < 4; ++c) sum[c] += seen[c];
      }
    for (std::size_t c = 0; c < 4; ++c)
      picture.linear.texel(x, y)[c] = static_cast<float>(sum[c] / (grid.supersampling * grid.supersampling));
  };
  tbb::parallel_for(0, grid.height_px, [&](int y) {
    for (int x = 0; x < grid.width_px; ++x) shadePixel(x, y);
  });
  return picture;
}

formats::Image encodeForDisplay(const formats::Image& linear, float exposure) {
  formats::Image display(linear.width, linear.height, {"R", "G", "B", "A"});
  for (int y = 0; y < linear.height; ++y)
    for (int x = 0; x < linear.width; ++x) {
      const float* from = linear.texel(x, y);
      float* to = display.texel(x, y);
      const float coverage = from[3];
      for (int c = 0; c < 3; ++c)
        to[c] = coverage > 0 ? static_cast<float>(displayCode(from[c] * (exposure / coverage))) / 255 : 0.0f;
      to[3] = static_cast<float>(std::lround(255 * coverage)) / 255;
    }
  return display;
}

}  // namespace bakelight::transport
