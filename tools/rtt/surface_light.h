// What light falls on a patch's surface: solved once, looked up by all views.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "patch/patch_geometry.h"
#include "tools/rtt/light_directions.h"
#include "tools/rtt/surface_sides.h"
#include "transport/interreflection.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

struct SurfaceLightOptions {
  std::size_t coefficients = 25;  // functions in the lights' basis
  bool shadows = true;
  std::optional<int> bounces = 0;  // nothing: all of them, by a solver
  double threshold = 1e-4;         // light that a solution of all bounces may still lack, of all light
  int bounce_directions = 256;     // over the sphere, that points look for others in
};

struct SurfaceLight {
  SurfaceSides sides;
  std::size_t coefficients = 0;  // functions of the basis
  std::size_t channels = 1;      // 3 where bounces color it
  // Irradiance / π by row (SurfaceSides), under each function of the light above the mid-plane's horizon.
  transport::TransferField rows{0, 1};
  std::uint64_t rays = 0, form_factors = 0, buried = 0;
  std::optional<transport::InterreflectionReport> bounced;
  double direct_s = 0, seeing_s = 0, solving_s = 0;  // what took how long

  // Nothing for a side that is dark.
  const float* row(std::uint32_t side) const {
    const std::uint32_t row = sides.row_of_side[side];
    return row == SurfaceSides::kDark ? nullptr : rows.row(row).data();
  }
};

// Direct light by the given directions; light then bounces between diffuse surfaces (x = x0 + F ρ x). Threads by TBB,
// same bytes for any number.
SurfaceLight surfaceLight(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                          std::span<const LightDirection> lights, const SurfaceLightOptions& options);

}  // namespace bakelight::rtt
