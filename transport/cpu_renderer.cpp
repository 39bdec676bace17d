#include "transport/cpu_renderer.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "transport/color.h"

namespace bakelight::transport {

CpuPicture renderOnCpu(const RayScene& scene, const RadianceAtHits& shade, const OrbitCamera& camera,
                       const PictureGrid& grid, const Backdrop& backdrop) {
  if (grid.width_px < 1 || grid.height_px < 1 || grid.supersampling < 1)
    throw std::invalid_argument("the picture has no pixels");
  const int s = grid.supersampling;
  const int columns = grid.width_px * s, rows = grid.height_px * s;
  const Vec3 eye = camera.eye();
  CpuPicture picture{formats::Image(grid.width_px, grid.height_px, {"R", "G", "B", "A"}),
                     std::vector<SubsampleHit>(static_cast<std::size_t>(columns) * rows)};

  // RGBA of a row of subsamples.
  const auto seenInRow = [&](int row) {
    std::vector<formats::Float4> seen(columns);
    std::vector<SurfaceHit> hits;
    std::vector<int> of_column;
    for (int column = 0; column < columns; ++column) {
      const Vec3 direction = camera.directionThrough(column + 0.5, row + 0.5, columns, rows);
      const Hit hit = scene.nearestHit(eye, direction);
      if (!hit.valid) {
        seen[column] = backdrop(direction);
        continue;
      }
      picture.hits[static_cast<std::size_t>(row) * columns + column] = {hit.distance, hit.triangle};
      hits.push_back({hit.triangle, hit.u, hit.v});
      of_column.push_back(column);
    }
    std::vector<Float3> radiance(hits.size());
    shade(hits, radiance);
    for (std::size_t i = 0; i < hits.size(); ++i)
      seen[of_column[i]] = {radiance[i][0], radiance[i][1], radiance[i][2], 1};
    return seen;
  };
  tbb::parallel_for(0, grid.height_px, [&](int y) {
    std::vector<std::array<double, 4>> sums(grid.width_px);
    for (int row = y * s; row < (y + 1) * s; ++row) {
      const std::vector<formats::Float4> seen = seenInRow(row);
      for (int column = 0; column < columns; ++column)
        for (std::size_t c = 0; c < 4; ++c) sums[column / s][c] += seen[column][c];
    }
    for (int x = 0; x < grid.width_px; ++x)
      for (std::size_t c = 0; c < 4; ++c)
        picture.linear.texel(x, y)[c] = static_cast<float>(sums[x][c] / (s * s));
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
