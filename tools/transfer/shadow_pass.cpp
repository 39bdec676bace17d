#include "tools/transfer/shadow_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/transfer/buried.h"
#include "tools/transfer/outliers.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using transport::Vec3;
using transport::vec3;

ShadowPass::Workspace::Workspace(const ShadowPass& pass)
    : hemisphere(pass.quadrature().size()),
      blocked(pass.quadrature().size()),
      blocked_rays(pass.options_.record_hits ? pass.quadrature().size() : 0),
      hits(pass.options_.record_hits ? pass.quadrature().size() : 0),
      ones(pass.quadrature().size(), 1.0f),
      all_sums(pass.quadrature().rowSize()),
      blocked_sums(pass.quadrature().rowSize()),
      seen(pass.options_.record_hits
               ? std::min<std::size_t>(3 * pass.quadrature().size() / 2, 2 * pass.mesh().vertexCount())
               : 0) {}

ShadowPass::ShadowPass(const formats::TriangleMesh& mesh, const transport::RayScene& scene,
                       const ShadowOptions& options, int directions, std::uint32_t turn)
    : mesh_(mesh),
      scene_(scene),
      options_(options),
      quadrature_(std::max({options.order, options.visibility_order, kJudgedOrder}), directions, turn),
      cosine_factors_(cosineFactors(std::max(options.order, kJudgedOrder), options.entered_ior)) {
  if (options.visibility_order > 0)
    hemisphere_zonal_ = transport::diskLightZonal(options.visibility_order, std::numbers::pi / 2);
}

TracedPoint ShadowPass::trace(const SurfacePoint& point, std::span<const formats::Triangle> sides_from_behind,
                              const PointTransfer& result, Workspace& work) const {
  Hemisphere& hemisphere = work.hemisphere;
  hemisphere.collect(quadrature_, point.normal);
  if (options_.entered_ior > 0) hemisphere.enter(options_.entered_ior);
  scene_.occluded(point.origin, hemisphere.rays, 0, std::span(work.blocked).first(hemisphere.count));
  listBlocked(work);
  work.sees_light = hemisphere.count == 0 || work.blocked_directions.size() < hemisphere.count;
  if (options_.record_hits) {
    traceBlocked(point, work);
    letGrazingRaysPass(work);
  }

  TracedPoint figures;
  figures.rays = static_cast<std::uint32_t>(hemisphere.count);
  figures.blocked =
      work.sees_light ? static_cast<std::uint32_t>(work.blocked_directions.size()) : figures.rays;
  combine(point, result, work, figures);
  figures.buried = figures.rays > 0 && !work.sees_light && isBuried(scene_, point.origin, point.normal);
  if (options_.record_hits && !figures.buried) figures.seen = collectSeen(sides_from_behind, work, figures);
  if (options_.keep_blocked)
    figures.blocked_rays.assign(work.blocked.begin(),
                                work.blocked.begin() + static_cast<std::ptrdiff_t>(hemisphere.count));
  return figures;
}

namespace {

// Every direction is written and the end moves on only past those wanted, as the branch would be mispredicted
// too often.
void compact(const Hemisphere& hemisphere, std::span<const std::uint8_t> flags, std::uint8_t wanted,
             std::vector<std::uint32_t>& directions, std::vector<float>& cosines) {
  directions.resize(hemisphere.count + 1);
  cosines.resize(hemisphere.count + 1);
  std::size_t end = 0;
  for (std::size_t k = 0; k < hemisphere.count; ++k) {
    directions[end] = hemisphere.directions[k];
    cosines[end] = hemisphere.cosines[k];
    end += flags[k] == wanted ? 1 : 0;
  }
  directions.resize(end);
  cosines.resize(end);
}

}  // namespace

void ShadowPass::listBlocked(Workspace& work) {
  compact(work.hemisphere, work.blocked, 1, work.blocked_directions, work.blocked_cosines);
}
void ShadowPass::listVisible(Workspace& work) {
  compact(work.hemisphere, work.blocked, 0, work.visible_directions, work.visible_cosines);
}

// Nearest hits are dearer than any hit, so only the rays that are known to hit something look for theirs.
void ShadowPass::traceBlocked(const SurfacePoint& point, Workspace& work) const {
  const transport::RayBundle& rays = quadrature_.directions();
  for (std::size_t k = 0; k < work.blocked_directions.size(); ++k) {
    const std::uint32_t d = work.blocked_directions[k];
    work.blocked_rays.set(k, {rays.x[d], rays.y[d], rays.z[d]});
  }
  scene_.nearestHits(point.origin, work.blocked_rays, 0, work.blocked_directions.size(), work.hits);
}

void ShadowPass::findHits(const SurfacePoint& point, const std::vector<bool>& blocked_rays,
                          Workspace& work) const {
  work.hemisphere.collect(quadrature_, point.normal);
  work.blocked_directions.clear();
  for (std::size_t k = 0; k < work.hemisphere.count; ++k)
    if (blocked_rays[k]) work.blocked_directions.push_back(work.hemisphere.directions[k]);
  traceBlocked(point, work);
}

// Puts closed form and quadrature together.
void ShadowPass::combine(const SurfacePoint& point, const PointTransfer& result, Workspace& work,
                         PointFigures& figures) const {
  const std::size_t count = result.vector.size();
  std::array<double, transport::coefficientCount(transport::kMaxOrder)> exact, difference;
  const auto bands = static_cast<int>(cosine_factors_.size());
  transport::evaluateSh(bands, vec3(point.normal),
                        std::span(exact).first(transport::coefficientCount(bands)));
  for (int l = 0; l * l < static_cast<int>(count); ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i) exact[i] *= cosine_factors_[l] / std::numbers::pi;

  if (work.sees_light && work.blocked_directions.empty()) {
    std::copy_n(exact.begin(), count, result.vector.begin());
  } else {
    std::fill(work.all_sums.begin(), work.all_sums.end(), 0.0);
    std::fill(work.blocked_sums.begin(), work.blocked_sums.end(), 0.0);
    quadrature_.accumulate(work.hemisphere.usedDirections(), work.hemisphere.usedCosines(), count,
                           work.all_sums);
    quadrature_.accumulate(work.blocked_directions, work.blocked_cosines, count, work.blocked_sums);
    // Coefficient 0 is constant, so its sums are the cosine-weighted counts.
    const double visible = work.sees_light ? 1 - work.blocked_sums[0] / work.all_sums[0] : 0;
    const double weight = quadrature_.weight() / std::numbers::pi;
    double error = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double all = weight * work.all_sums[i], blocked = weight * work.blocked_sums[i];
      result.vector[i] =
          work.sees_light ? static_cast<float>(visible * exact[i] + (1 - visible) * all - blocked) : 0.0f;
      error = std::max(error, std::abs(all - exact[i]));
    }
    figures.quadrature_error = static_cast<float>(error);
  }
  if (options_.sphere) {
    listVisible(work);
    nearFieldDifference(*options_.sphere, vec3(point.origin), options_.order, quadrature_,
                        work.visible_directions, work.visible_cosines,
                        std::span(difference).first(result.near_vector.size()));
    for (std::size_t i = 0; i < result.near_vector.size(); ++i)
      result.near_vector[i] = static_cast<float>(result.vector[i] + difference[i]);
  }
  if (!result.visibility.empty()) combineVisibility(point, result.visibility, work);
}

// The visibility itself, from whichever are fewer: the closed form of the hemisphere less what is blocked, or
// what is visible. Exact for a point that nothing blocks and for one that sees nothing.
void ShadowPass::combineVisibility(const SurfacePoint& point, std::span<float> visibility,
                                   Workspace& work) const {
  const bool mostly_open = 2 * work.blocked_directions.size() <= work.hemisphere.count;
  if (!mostly_open) listVisible(work);
  const std::vector<std::uint32_t>& chosen = mostly_open ? work.blocked_directions : work.visible_directions;
  std::fill(work.blocked_sums.begin(), work.blocked_sums.end(), 0.0);
  quadrature_.accumulate(chosen, std::span(work.ones).first(chosen.size()), visibility.size(),
                         work.blocked_sums);
  std::vector<double> open(visibility.size(), 0.0);
  if (mostly_open) open = transport::orientZonal(hemisphere_zonal_, vec3(point.normal));
  const double weight = mostly_open ? -quadrature_.weight() : quadrature_.weight();
  for (std::size_t i = 0; i < visibility.size(); ++i)
    visibility[i] = static_cast<float>(open[i] + weight * work.blocked_sums[i]);
}

// Cosine-weighted shares of the hemisphere, normalised over the directions that were traced. Each blocked one
// has a hit, so blocked and visible share add up to one: bounces make no light, and lose only what meets the
// dark inside of a body.
std::vector<transport::SeenVertex> ShadowPass::collectSeen(
    std::span<const formats::Triangle> sides_from_behind, Workspace& work, PointFigures& figures) const {
  const std::span<const float> traced =
      work.sees_light ? work.hemisphere.usedCosines() : std::span<const float>(work.blocked_cosines);
  double cosine_sum = 0;
  for (const float cosine : traced) cosine_sum += cosine;
  const auto scale = static_cast<float>(1 / cosine_sum);
  for (std::size_t k = 0; k < work.blocked_directions.size(); ++k) {
    const std::uint32_t triangle = work.hits.triangle[k];
    const formats::Triangle& corners =
        work.hits.back_face[k] != 0 ? sides_from_behind[triangle] : mesh_.triangles[triangle];
    if (corners[0] == kDarkSide) {
      ++figures.inside_hits;
      continue;
    }
    const float weight = work.blocked_cosines[k] * scale, u = work.hits.u[k], v = work.hits.v[k];
    const std::array<float, 3> shares = {std::max(1 - u - v, 0.0f), u, v};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      // Never zero: a corner that the ray met at the opposite edge is seen, too.
      work.seen.add(corners[corner], std::max(weight * shares[corner], 1e-30f));
    }
  }
  return work.seen.take();
}

void letGrazingRaysPass(ShadowPass::Workspace& work) {
  transport::HitBundle& hits = work.hits;
  std::size_t end = 0, direction = 0;
  for (std::size_t k = 0; k < work.blocked_directions.size(); ++k) {
    while (work.hemisphere.directions[direction] != work.blocked_directions[k]) ++direction;
    if (hits.blocked[k] == 0) {
      if (work.sees_light) work.blocked[direction] = 0;
      continue;
    }
    work.blocked_directions[end] = work.blocked_directions[k];
    work.blocked_cosines[end] = work.blocked_cosines[k];
    hits.blocked[end] = 1;
    hits.back_face[end] = hits.back_face[k];
    hits.triangle[end] = hits.triangle[k];
    hits.u[end] = hits.u[k], hits.v[end] = hits.v[k], hits.distance[end] = hits.distance[k];
    ++end;
  }
  work.blocked_directions.resize(end);
  work.blocked_cosines.resize(end);
}

}  // namespace bakelight::transfer
