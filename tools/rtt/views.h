// Pictures of a patch towards all views, through its mid-plane (Sloan, Liu, Shum & Snyder 2003, section 4.2).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "patch/patch_geometry.h"
#include "tools/rtt/light_basis.h"
#include "tools/rtt/surface_light.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

struct ViewOptions {
  int supersampling = 2;     // points a texel, a side
  bool masking = true;       // without, all views see what lies straight below or above the point
  bool shadows = true;       // without, all of the sky is mirrored
  int most_mirrorings = 64;  // of the surface in itself, on the way to the sky
  int glossy_samples = 16;   // directions that each look at a glossy surface goes on to
};

// What leaves through each texel towards each view, of each function of the light.
struct Responses {
  int views, width, height;       // a side of the grid of views; texels
  std::size_t coefficients;       // functions
  std::span<float> values;        // [view][y][x][channel][function], as in RadianceTransferTexture
  std::span<float> heights = {};  // [view][y][x]; empty: not asked for

  std::size_t size() const { return 3 * coefficients; }
  // Of the texel among all of all views.
  std::size_t number(int view, int x, int y) const {
    return (static_cast<std::size_t>(view) * height + y) * width + x;
  }
};

struct ViewFigures {
  std::uint64_t rays = 0;         // of views
  std::uint64_t through = 0;      // of them, that met nothing: they went through a hole
  std::uint64_t inside = 0;       // that met the inside of a closed part, which is dark
  std::uint64_t glossy_rays = 0;  // from glossy surfaces
  // Of the responses to the first function, by their view's cosine.
  std::array<double, 3> weighted_sums = {};
};

// Fills `responses`, which are 0. `light` is in terms of `basis`. Of each texel evenly spaced points are looked at along each
// view. What goes through a hole adds nothing. Glossy surfaces mirror the sky and the surface itself, again and again. A height is
// that of the highest point that a texel shows, as it hides the others from views beside; the lowest of the surface if there is none.
// `progress` is told of views that are done. Threads by TBB, same bytes for
// any number.
ViewFigures renderViews(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                        const SurfaceLight& light, const ViewOptions& options, const LightBasis& basis,
                        const std::function<void()>& progress, const Responses& responses);

}  // namespace bakelight::rtt
