#include "tools/rtt/seen_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "transport/directions.h"

namespace bakelight::rtt {
namespace {

using transport::SeenVertex;
using transport::Vec3;
using transport::vec3;

constexpr std::size_t kBlock = 64;  // points whose rays are traced together, direction by direction

class Tracer {
 public:
  Tracer(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
         const SurfaceSides& sides, const std::vector<Vec3>& directions)
      : geometry_(geometry),
        scene_(scene),
        sides_(sides),
        directions_(directions),
        sums_(directions.size()),
        hits_(kBlock) {}

  // Rows of the points first … first + count.
  std::vector<std::vector<SeenVertex>> trace(std::size_t first, std::size_t count,
                                             std::span<const double> sky_share, std::uint8_t* buried) {
    for (auto& met : met_) met.clear();
    for (std::size_t p = 0; p < count; ++p) {
      origins_[p] = vec3(sides_.points[first + p].origin);
      normals_[p] = vec3(sides_.points[first + p].normal);
    }
    outcome_.assign(count, {});
    for (const Vec3& direction : directions_) traceAlong(direction, count);
    std::vector<std::vector<SeenVertex>> rows(count);
    for (std::size_t p = 0; p < count; ++p) {
      const Outcome& outcome = outcome_[p];
      const double not_sky = outcome.all - outcome.sky;
      const double rest = std::max(1 - sky_share[first + p], 0.0);
      const double scale = not_sky > 0 ? rest / not_sky : 0;
      for (const Met& met : met_[p]) sums_.add(met.row, static_cast<float>(scale * met.cosine));
      rows[p] = sums_.take();
      buried[p] = sky_share[first + p] == 0 && outcome.dark > outcome.lit ? 1 : 0;
    }
    return rows;
  }

  std::uint64_t rays() const { return traced_; }

 private:
  struct Met {
    std::uint32_t row;
    float cosine;
  };
  struct Outcome {
    double all = 0, sky = 0, dark = 0, lit = 0;  // sums of cosines
  };

  void traceAlong(const Vec3& direction, std::size_t count) {
    rays_.clear(), sources_.clear();
    for (std::size_t p = 0; p < count; ++p) {
      const double cosine = normals_[p].dot(direction);
      if (cosine <= 0) continue;
      sources_.push_back({p, cosine});
      rays_.push(origins_[p], direction);
    }
    scene_.nearestHits(rays_, hits_);
    traced_ += rays_.size();
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const auto& [p, cosine] = sources_[i];
      Outcome& outcome = outcome_[p];
      outcome.all += cosine;
      if (hits_.blocked[i] == 0) {
        if (direction.z() > 0) outcome.sky += cosine;
        continue;
      }
      const std::uint32_t row = rowOfHit(i);
      (row == SurfaceSides::kDark ? outcome.dark : outcome.lit) += cosine;
      if (row != SurfaceSides::kDark) met_[p].push_back({row, static_cast<float>(cosine)});
    }
  }

  // Of the triangle's vertex that is nearest by its weights: a hit is one of many that are spread over what is seen, so
  // that interpolation would add work and no truth.
  std::uint32_t rowOfHit(std::size_t ray) const {
    const float u = hits_.u[ray], v = hits_.v[ray], rest = 1 - u - v;
    const std::size_t corner = u > v ? (u > rest ? 1 : 0) : (v > rest ? 2 : 0);
    const std::uint32_t vertex = geometry_.mesh.triangles[hits_.triangle[ray]][corner];
    return sides_.row_of_side[hits_.back_face[ray] != 0 ? vertex + sides_.vertices : vertex];
  }

  const patch::PatchGeometry& geometry_;
  const transport::PeriodicRayScene& scene_;
  const SurfaceSides& sides_;
  const std::vector<Vec3>& directions_;
  transport::SeenSums sums_;
  transport::FreeRays rays_;
  transport::HitBundle hits_;
  std::vector<std::pair<std::size_t, double>> sources_;
  std::array<std::vector<Met>, kBlock> met_;
  std::vector<Outcome> outcome_;
  std::array<Vec3, kBlock> origins_, normals_;
  std::uint64_t traced_ = 0;
};

}  // namespace

SeenSurface seenSurface(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                        const SurfaceSides& sides, int direction_count, std::span<const double> sky_share) {
  const std::vector<Vec3> directions = transport::sphereDirections(direction_count);
  SeenSurface seen;
  std::vector<std::uint8_t> buried(sides.points.size(), 0);
  std::vector<transport::FormFactors::Block> blocks((sides.points.size() + kBlock - 1) / kBlock);
  std::atomic<std::uint64_t> rays{0};
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    const std::size_t first = b * kBlock, count = std::min(kBlock, sides.points.size() - first);
    Tracer tracer(geometry, scene, sides, directions);
    blocks[b] = seen.factors.packed(tracer.trace(first, count, sky_share, &buried[first]));
    rays += tracer.rays();
  });
  for (auto& block : blocks) seen.factors.append(std::move(block));
  buried.resize(sides.vertices);
  seen.buried = std::move(buried);
  seen.rays = rays;
  return seen;
}

}  // namespace bakelight::rtt
