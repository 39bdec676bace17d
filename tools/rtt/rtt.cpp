#include "tools/rtt/rtt.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "tools/rtt/elements.h"
#include "tools/rtt/surface_light.h"
#include "tools/rtt/view_dependence.h"
#include "tools/rtt/views.h"
#include "transport/hemisphere_grid.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {
namespace {

constexpr int kMostMirrorings = 64;

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A uniform sky of 1 has the coefficient √(4π).
formats::Float3 meanAlbedo(const formats::RadianceTransferTexture& texture, const ViewFigures& seen) {
  double cosines = 0;
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column)
      cosines += transport::hemisphereCell(texture.views, column, row).z();
  const double sky = std::sqrt(4 * std::numbers::pi) / (cosines * static_cast<double>(texture.texelCount()));
  formats::Float3 albedo;
  for (std::size_t c = 0; c < 3; ++c) albedo[c] = static_cast<float>(seen.weighted_sums[c] * sky);
  return albedo;
}

// Where views differ only by their sampling error, one stands for all; few texels and views tell.
constexpr int kMeasuredViews = 8, kMeasuredTexels = 32;

ViewOptions viewOptions(const Options& options) {
  return {.supersampling = options.supersampling,
          .masking = options.masking,
          .shadows = options.shadows,
          .most_mirrorings = std::min(options.bounces.value_or(kMostMirrorings), kMostMirrorings),
          .glossy_samples = options.glossy_samples};
}

formats::RadianceTransferTexture emptyTexture(const Options& options, double aspect) {
  formats::RadianceTransferTexture texture;
  texture.order = options.order;
  texture.views = options.views;
  texture.width = options.resolution;
  texture.height = std::max(1, static_cast<int>(std::lround(options.resolution * aspect)));
  return texture;
}

// Of a texture of many views itself; for one of a single view, of a small one of many.
ViewDependence measuredViewDependence(const patch::PatchGeometry& geometry,
                                      const transport::PeriodicRayScene& scene, const SurfaceLight& light,
                                      Options options, const formats::RadianceTransferTexture& texture) {
  if (texture.views > 1) return viewDependence(texture);
  options.views = kMeasuredViews;
  options.resolution = std::min(options.resolution, kMeasuredTexels);
  formats::RadianceTransferTexture measured = emptyTexture(options, geometry.aspect);
  renderViews(
      geometry, scene, light, viewOptions(options), [] {}, measured);
  return viewDependence(measured);
}

}  // namespace

Rtt makeRtt(const patch::PatchGeometry& given, const Options& options,
            const std::function<void()>& progress) {
  const auto start = Clock::now();
  double longest_edge = 1.0 / options.elements;
  const patch::PatchGeometry geometry = withElements(given, longest_edge);
  const transport::PeriodicRayScene scene(geometry.mesh, {geometry.period_x, geometry.period_y});
  const double tree_s = secondsSince(start);
  const std::vector<LightDirection> lights =
      lightDirections(options.light_rule, options.polar_lights, options.azimuth_lights, options.order);
  const SurfaceLight light = surfaceLight(geometry, scene, lights,
                                          {.order = options.order,
                                           .shadows = options.shadows,
                                           .bounces = options.bounces,
                                           .bounce_directions = options.bounce_directions});
  Rtt rtt;
  rtt.texture = emptyTexture(options, geometry.aspect);
  const auto viewing = Clock::now();
  const ViewFigures seen = renderViews(geometry, scene, light, viewOptions(options), progress, rtt.texture);
  rtt.figures.views_s = secondsSince(viewing);
  rtt.figures.tree_s = tree_s;
  rtt.figures.direct_s = light.direct_s, rtt.figures.seeing_s = light.seeing_s;
  rtt.figures.solving_s = light.solving_s;
  rtt.figures.longest_edge = longest_edge;
  rtt.figures.surface_triangles = geometry.mesh.triangleCount();
  rtt.figures.surface_points = light.rows.pointCount();
  rtt.figures.rays = light.rays + seen.rays + seen.glossy_rays;
  rtt.figures.glossy_rays = seen.glossy_rays;
  rtt.figures.hole_share = static_cast<double>(seen.through) / static_cast<double>(seen.rays);
  rtt.figures.inside_share = static_cast<double>(seen.inside) / static_cast<double>(seen.rays);
  rtt.figures.form_factors = light.form_factors;
  rtt.figures.buried_points = light.buried;
  rtt.figures.bounced = light.bounced;
  rtt.figures.depth = scene.highest() - scene.lowest();
  rtt.figures.mean_albedo = meanAlbedo(rtt.texture, seen);
  rtt.figures.view_dependence = measuredViewDependence(geometry, scene, light, options, rtt.texture);
  return rtt;
}

}  // namespace bakelight::rtt
