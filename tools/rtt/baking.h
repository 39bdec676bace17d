// What textures in spherical harmonics and BTFs have in common: light is solved on the surface, then looked at.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <span>

#include "patch/patch_geometry.h"
#include "tools/rtt/light_basis.h"
#include "tools/rtt/rtt.h"
#include "tools/rtt/surface_light.h"
#include "tools/rtt/views.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {

class Baking {
 public:
  Baking(const patch::PatchGeometry& given, const Options& options, LightBasis basis);

  // Of every function of the basis, by the given lights.
  void solve(std::span<const LightDirection> lights);
  // Of `responses`, which are 0.
  ViewFigures render(const std::function<void()>& progress, const Responses& responses) const;
  // What both took and met.
  Figures figures(const ViewFigures& seen) const;

  double aspect() const { return geometry_.aspect; }

 private:
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  Options options_;
  LightBasis basis_;
  double longest_edge_, tree_s_;
  patch::PatchGeometry geometry_;
  transport::PeriodicRayScene scene_;
  SurfaceLight light_;
};

// Texels of a patch whose height is `aspect` times its width.
int texelsDown(const Options& options, double aspect);

// What gives back `under_uniform_sky` of a sky of 1: of each channel the sum over texels and views of their radiance times the
// view's cosine. The mean over all, by cosines.
formats::Float3 meanAlbedo(const std::array<double, 3>& under_uniform_sky, int views, std::size_t texels);

}  // namespace bakelight::rtt
