// Rays through a patch's mid-plane.
#pragma once

#include "patch/patch_geometry.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

struct TexelGrid {
  int width, height;  // texels
  int supersampling;  // points a texel, a side
};

// Those of one row of texels, texel by texel, each through an evenly spaced point of z = 0 against the direction
// `view` (z > 0), from above the surface.
void rowOfViewRays(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                   const transport::Vec3& view, const TexelGrid& grid, int y, transport::FreeRays& rays);

}  // namespace bakelight::rtt
