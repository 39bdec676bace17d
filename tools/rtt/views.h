// Pictures of a patch towards all views, through its mid-plane (Sloan, Liu, Shum & Snyder 2003, section 4.2).
#pragma once

#include <cstdint>
#include <functional>

#include "formats/radiance_transfer_texture.h"
#include "patch/patch_geometry.h"
#include "tools/rtt/surface_light.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

struct ViewFigures {
  std::uint64_t rays = 0;
  std::uint64_t through = 0;  // that met nothing: they went through a hole
  std::uint64_t inside = 0;   // that met the inside of a closed part, which is dark
};

// Fills `texture`, whose sizes, order and views are set. Of each texel supersampling² points, evenly spaced, are
// looked at along each view; without `masking` all views see what lies straight below or above the point. What goes
// through a hole adds nothing. `progress` is told of views that are done. Threads by TBB, same bytes for any
// number.
ViewFigures renderViews(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                        const SurfaceLight& light, int supersampling, bool masking,
                        const std::function<void()>& progress, formats::RadianceTransferTexture& texture);

}  // namespace bakelight::rtt
