#include "tools/rtt/surface_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <numbers>
#include <vector>

#include "tools/rtt/seen_surface.h"

namespace bakelight::rtt {
namespace {

using transport::SurfacePoint;
using transport::vec3;

constexpr std::size_t kBlock = 64;  // points whose rays are traced together, light by light
using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr std::size_t kFieldBytes = std::size_t{1} << 31;

// Direct light of points side by side.
class DirectBlock {
 public:
  DirectBlock(const transport::PeriodicRayScene& scene, std::span<const LightDirection> lights, bool shadows)
      : scene_(scene), lights_(lights), shadows_(shadows) {}

  void gather(std::span<const SurfacePoint> points, std::size_t coefficients) {
    sums_.assign(points.size() * coefficients, 0.0);
    sky_.assign(points.size(), 0.0);
    for (std::size_t p = 0; p < points.size(); ++p)
      origins_[p] = vec3(points[p].origin), normals_[p] = vec3(points[p].normal);
    for (const LightDirection& light : lights_) {
      findLit(points.size(), light);
      for (std::size_t i = 0; i < lit_.size(); ++i) {
        if (blocked_[i] != 0) continue;
        const double weight = light.solid_angle_sr * cosines_[i] / std::numbers::pi;
        sky_[lit_[i]] += weight;
        double* sum = &sums_[lit_[i] * coefficients + light.first];
        for (std::size_t c = 0; c < light.basis.size(); ++c) sum[c] += weight * light.basis[c];
      }
    }
  }

  std::span<const double> sums() const { return sums_; }      // points × coefficients
  std::span<const double> skyShares() const { return sky_; }  // of the points
  std::uint64_t rays() const { return traced_; }

 private:
  void findLit(std::size_t count, const LightDirection& light) {
    rays_.clear(), lit_.clear(), cosines_.clear();
    for (std::size_t p = 0; p < count; ++p) {
      const double cosine = normals_[p].dot(light.towards);
      if (cosine <= 0) continue;
      lit_.push_back(p), cosines_.push_back(cosine);
      rays_.push(origins_[p], light.towards);
    }
    blocked_.assign(lit_.size(), 0);
    if (!shadows_) return;
    scene_.occluded(rays_, blocked_);
    traced_ += lit_.size();
  }

  const transport::PeriodicRayScene& scene_;
  std::span<const LightDirection> lights_;
  bool shadows_;
  transport::FreeRays rays_;
  std::array<Vec3, kBlock> origins_, normals_;
  std::vector<std::size_t> lit_;
  std::vector<double> cosines_, sums_, sky_;
  std::vector<std::uint8_t> blocked_;
  std::uint64_t traced_ = 0;
};

struct DirectLight {
  std::vector<float> values;      // points × coefficients
  std::vector<double> sky_share;  // of each point's cosine-weighted hemisphere
  std::uint64_t rays = 0;
};

DirectLight directLight(std::span<const SurfacePoint> points, const transport::PeriodicRayScene& scene,
                        std::span<const LightDirection> lights, std::size_t coefficients, bool shadows) {
  DirectLight direct{std::vector<float>(points.size() * coefficients), std::vector<double>(points.size())};
  std::atomic<std::uint64_t> rays{0};
  tbb::parallel_for(std::size_t{0}, (points.size() + kBlock - 1) / kBlock, [&](std::size_t b) {
    const std::size_t first = b * kBlock, count = std::min(kBlock, points.size() - first);
    DirectBlock block(scene, lights, shadows);
    block.gather(points.subspan(first, count), coefficients);
    std::transform(block.sums().begin(), block.sums().end(), &direct.values[first * coefficients],
                   [](double sum) { return static_cast<float>(sum); });
    std::copy(block.skyShares().begin(), block.skyShares().end(), &direct.sky_share[first]);
    rays += block.rays();
  });
  direct.rays = rays;
  return direct;
}

bool allGray(std::span<const formats::Float3> colors) {
  return std::all_of(colors.begin(), colors.end(),
                     [](const formats::Float3& c) { return c[0] == c[1] && c[1] == c[2]; });
}

// The same for all channels.
void putDirect(const DirectLight& direct, std::size_t coefficients, transport::TransferField& field) {
  tbb::parallel_for(std::size_t{0}, field.pointCount(), [&](std::size_t p) {
    const auto row = field.row(p);
    for (std::size_t c = 0; c < row.size(); ++c) row[c] = direct.values[p * coefficients + c % coefficients];
  });
}

}  // namespace

SurfaceLight surfaceLight(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                          std::span<const LightDirection> lights, const SurfaceLightOptions& options) {
  SurfaceLight light;
  light.sides = surfaceSides(geometry);
  light.coefficients = options.coefficients;
  const bool bounces = options.bounces != 0;
  if (bounces && !allGray(light.sides.albedo)) light.channels = 3;
  const auto start = Clock::now();
  const DirectLight direct =
      directLight(light.sides.points, scene, lights, light.coefficients, options.shadows);
  light.direct_s = secondsSince(start);
  light.rays = direct.rays;
  light.rows = transport::TransferField(light.sides.points.size(), light.channels * light.coefficients);
  const auto put = [&](transport::TransferField& field) { putDirect(direct, light.coefficients, field); };
  if (!bounces) {
    put(light.rows);
    return light;
  }
  const auto seeing = Clock::now();
  const SeenSurface seen =
      seenSurface(geometry, scene, light.sides, options.bounce_directions, direct.sky_share);
  light.seeing_s = secondsSince(seeing);
  light.rays += seen.rays;
  light.form_factors = seen.factors.shareCount();
  const transport::BuriedFill fill(geometry.mesh, seen.buried);
  light.buried = fill.filledVertices();
  std::vector<std::uint8_t> channel_of_column(light.rows.columns);
  for (std::size_t c = 0; c < channel_of_column.size(); ++c)
    channel_of_column[c] = static_cast<std::uint8_t>(c / light.coefficients);
  transport::InterreflectionOptions solver;
  solver.threshold = options.threshold;
  solver.bounces = options.bounces.value_or(0);
  solver.max_passes = 400;
  solver.field_bytes = kFieldBytes;
  const auto solving = Clock::now();
  light.bounced = transport::solveInterreflection(seen.factors, light.sides.albedo, channel_of_column, fill,
                                                  solver, put, light.rows);
  light.solving_s = secondsSince(solving);
  return light;
}

}  // namespace bakelight::rtt
