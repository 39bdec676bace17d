#include "tools/rtt/baking.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/rtt/elements.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::rtt {
namespace {

constexpr int kMostMirrorings = 64;

ViewOptions viewOptions(const Options& options) {
  return {.supersampling = options.supersampling,
          .masking = options.masking,
          .shadows = options.shadows,
          .most_mirrorings = std::min(options.bounces.value_or(kMostMirrorings), kMostMirrorings),
          .glossy_samples = options.glossy_samples};
}

}  // namespace

int texelsDown(const Options& options, double aspect) {
  return std::max(1, static_cast<int>(std::lround(options.resolution * aspect)));
}

formats::Float3 meanAlbedo(const std::array<double, 3>& under_uniform_sky, int views, std::size_t texels) {
  double cosines = 0;
  for (int row = 0; row < views; ++row)
    for (int column = 0; column < views; ++column)
      cosines += transport::hemisphereCell(views, column, row).z();
  formats::Float3 albedo;
  for (std::size_t c = 0; c < 3; ++c)
    albedo[c] = static_cast<float>(under_uniform_sky[c] / (cosines * static_cast<double>(texels)));
  return albedo;
}

Baking::Baking(const patch::PatchGeometry& given, const Options& options, LightBasis basis)
    : options_(options),
      basis_(basis),
      longest_edge_(1.0 / options.elements),
      tree_s_(0),
      geometry_(withElements(given, longest_edge_)),
      scene_(geometry_.mesh, {geometry_.period_x, geometry_.period_y}) {
  tree_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
}

void Baking::solve(std::span<const LightDirection> lights) {
  light_ = surfaceLight(geometry_, scene_, lights,
                        {.coefficients = basis_.count(),
                         .shadows = options_.shadows,
                         .bounces = options_.bounces,
                         .bounce_directions = options_.bounce_directions});
}

ViewFigures Baking::render(const std::function<void()>& progress, const Responses& responses) const {
  return renderViews(geometry_, scene_, light_, viewOptions(options_), basis_, progress, responses);
}

Figures Baking::figures(const ViewFigures& seen) const {
  Figures figures;
  figures.tree_s = tree_s_;
  figures.direct_s = light_.direct_s, figures.seeing_s = light_.seeing_s;
  figures.solving_s = light_.solving_s;
  figures.longest_edge = longest_edge_;
  figures.surface_triangles = geometry_.mesh.triangleCount();
  figures.surface_points = light_.rows.pointCount();
  figures.rays = light_.rays + seen.rays + seen.glossy_rays;
  figures.glossy_rays = seen.glossy_rays;
  figures.hole_share = static_cast<double>(seen.through) / static_cast<double>(seen.rays);
  figures.inside_share = static_cast<double>(seen.inside) / static_cast<double>(seen.rays);
  figures.form_factors = light_.form_factors;
  figures.buried_points = light_.buried;
  figures.bounced = light_.bounced;
  figures.depth = scene_.highest() - scene_.lowest();
  return figures;
}

}  // namespace bakelight::rtt
