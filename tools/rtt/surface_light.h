// What light falls on a patch's surface: solved once, looked up by all views.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patch/patch_geometry.h"
#include "tools/rtt/light_directions.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

struct SurfaceLightOptions {
  int order = 5;
  bool shadows = true;
};

// Irradiance / π of each side of each vertex under each spherical harmonic of the light above the mid-plane's
// horizon.
struct SurfaceLight {
  static constexpr std::uint32_t kDark = 0xffffffffU;

  std::size_t coefficients = 0;            // order²
  std::size_t channels = 1;                // 3 where bounces color it
  std::vector<std::uint32_t> row_of_side;  // front of vertex v, then backs (v + vertex count); kDark: none
  std::vector<float> rows;                 // channels × coefficients each
  std::uint64_t rays = 0;

  std::size_t rowSize() const { return channels * coefficients; }
  const float* row(std::uint32_t side) const {
    return row_of_side[side] == kDark ? nullptr : &rows[row_of_side[side] * rowSize()];
  }
};

SurfaceLight surfaceLight(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                          std::span<const LightDirection> lights, const SurfaceLightOptions& options);

}  // namespace bakelight::rtt
