#include "tools/rtt/surface_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <numbers>
#include <numeric>

#include "transport/surface_points.h"

namespace bakelight::rtt {
namespace {

using transport::SurfacePoint;
using transport::vec3;

constexpr std::size_t kBlock = 64;  // points whose rays are traced together, light by light

// Direct light of points side by side.
class DirectBlock {
 public:
  DirectBlock(const transport::PeriodicRayScene& scene, std::span<const LightDirection> lights,
              const SurfaceLightOptions& options)
      : scene_(scene), lights_(lights), options_(options) {}

  // Into rows of `coefficients` floats; how many rays it took.
  std::uint64_t gather(std::span<const SurfacePoint> points, std::size_t coefficients,
                       std::span<float> rows) {
    sums_.assign(points.size() * coefficients, 0.0);
    std::uint64_t rays = 0;
    for (const LightDirection& light : lights_) {
      rays_.clear(), lit_.clear(), cosines_.clear();
      for (std::size_t p = 0; p < points.size(); ++p) {
        const double cosine = vec3(points[p].normal).dot(light.towards);
        if (cosine <= 0) continue;
        lit_.push_back(p), cosines_.push_back(cosine);
        rays_.push(vec3(points[p].origin), light.towards);
      }
      blocked_.assign(lit_.size(), 0);
      if (options_.shadows) scene_.occluded(rays_, blocked_), rays += lit_.size();
      for (std::size_t i = 0; i < lit_.size(); ++i) {
        if (blocked_[i] != 0) continue;
        const double weight = light.solid_angle_sr * cosines_[i] / std::numbers::pi;
        double* sum = &sums_[lit_[i] * coefficients];
        for (std::size_t c = 0; c < coefficients; ++c) sum[c] += weight * light.basis[c];
      }
    }
    std::transform(sums_.begin(), sums_.end(), rows.begin(),
                   [](double sum) { return static_cast<float>(sum); });
    return rays;
  }

 private:
  const transport::PeriodicRayScene& scene_;
  std::span<const LightDirection> lights_;
  const SurfaceLightOptions& options_;
  transport::FreeRays rays_;
  std::vector<std::size_t> lit_;
  std::vector<double> cosines_, sums_;
  std::vector<std::uint8_t> blocked_;
};

}  // namespace

SurfaceLight surfaceLight(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                          std::span<const LightDirection> lights, const SurfaceLightOptions& options) {
  SurfaceLight light;
  light.coefficients = static_cast<std::size_t>(options.order) * options.order;
  const std::vector<SurfacePoint> points = transport::frontPoints(geometry.mesh, transport::kDefaultBias);
  light.row_of_side.assign(2 * points.size(), SurfaceLight::kDark);
  std::iota(light.row_of_side.begin(), light.row_of_side.begin() + static_cast<std::ptrdiff_t>(points.size()),
            0U);
  light.rows.resize(points.size() * light.rowSize());
  const std::size_t blocks = (points.size() + kBlock - 1) / kBlock;
  std::atomic<std::uint64_t> rays{0};
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    const std::size_t first = b * kBlock, count = std::min(kBlock, points.size() - first);
    DirectBlock block(scene, lights, options);
    rays += block.gather(std::span(points).subspan(first, count), light.coefficients,
                         std::span(light.rows).subspan(first * light.rowSize(), count * light.rowSize()));
  });
  light.rays = rays;
  return light;
}

}  // namespace bakelight::rtt
