// What the points of a patch's surface see of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "patch/patch_geometry.h"
#include "tools/rtt/surface_sides.h"
#include "transport/form_factors.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

struct SeenSurface {
  transport::FormFactors factors;    // a row of each point: shares of the rows that it sees
  std::vector<std::uint8_t> buried;  // of each vertex: it sees no light, and mostly insides of closed parts
  std::uint64_t rays = 0;
};

// Of `directions` even directions over the sphere each point traces those above its tangent plane. `sky_share`: what
// of each point's cosine-weighted hemisphere its direct light came through. The rest is divided among what the
// rays met (and the light that falls out below, through holes, and insides of closed parts, which are dark), so that
// light is neither made nor lost.
SeenSurface seenSurface(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                        const SurfaceSides& sides, int directions, std::span<const double> sky_share);

}  // namespace bakelight::rtt
