#include "tools/rtt/rtt.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "tools/rtt/baking.h"
#include "tools/rtt/view_dependence.h"

namespace bakelight::rtt {
namespace {

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A uniform sky of 1 has the coefficient √(4π).
formats::Float3 meanAlbedoOf(const formats::RadianceTransferTexture& texture, const ViewFigures& seen) {
  std::array<double, 3> sums = seen.weighted_sums;
  for (double& sum : sums) sum *= std::sqrt(4 * std::numbers::pi);
  return meanAlbedo(sums, texture.views, texture.texelCount());
}

// Where views differ only by their sampling error, one stands for all; few texels and views tell.
constexpr int kMeasuredViews = 8, kMeasuredTexels = 32;

formats::RadianceTransferTexture emptyTexture(const Options& options, double aspect) {
  formats::RadianceTransferTexture texture;
  texture.order = options.order;
  texture.views = options.views;
  texture.width = options.resolution;
  texture.height = texelsDown(options, aspect);
  texture.allocate();
  return texture;
}

Responses responsesOf(formats::RadianceTransferTexture& texture) {
  return {texture.views,  texture.width,  texture.height, texture.coefficientCount(),
          texture.values, texture.heights};
}

// Of a texture of many views itself; for one of a single view, of a small one of many.
ViewDependence measuredViewDependence(const Baking& baking, Options options,
                                      const formats::RadianceTransferTexture& texture) {
  if (texture.views > 1) return viewDependence(texture);
  options.views = kMeasuredViews;
  options.resolution = std::min(options.resolution, kMeasuredTexels);
  formats::RadianceTransferTexture measured = emptyTexture(options, baking.aspect());
  baking.render([] {}, responsesOf(measured));
  return viewDependence(measured);
}

}  // namespace

Rtt makeRtt(const patch::PatchGeometry& geometry, const Options& options,
            const std::function<void()>& progress) {
  Baking baking(geometry, options, LightBasis::sphericalHarmonics(options.order));
  baking.solve(
      lightDirections(options.light_rule, options.polar_lights, options.azimuth_lights, options.order));
  Rtt rtt;
  rtt.texture = emptyTexture(options, geometry.aspect);
  const auto viewing = Clock::now();
  // Where a view sees what another sees; one that stands for all needs none.
  if (options.masking && options.views > 1) rtt.texture.heights.assign(rtt.texture.responseCount(), 0.0F);
  const ViewFigures seen = baking.render(progress, responsesOf(rtt.texture));
  rtt.figures = baking.figures(seen);
  rtt.figures.views_s = secondsSince(viewing);
  rtt.figures.mean_albedo = meanAlbedoOf(rtt.texture, seen);
  rtt.figures.view_dependence = measuredViewDependence(baking, options, rtt.texture);
  return rtt;
}

}  // namespace bakelight::rtt
