#include "tests/bench/biscale_images.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/reference/estimates.h"
#include "transport/bi_scale_shading.h"
#include "transport/periodic_ray_scene.h"
#include "transport/random.h"

namespace bakelight::bench {
namespace {

using std::numbers::pi;
using transport::vec3;

constexpr int kSubsamples = 2;  // a side of a pixel, where nothing is random
constexpr double kFar = 1e5;    // of eyes, in widths

Image emptyImage(int side) {
  return {side, std::vector<Float3>(static_cast<std::size_t>(side) * side, Float3{0, 0, 0}), 0};
}

void add(Float3& sum, const Float3& value, float weight) {
  for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * value[c];
}

// Of points of the macro surface, evenly over each pixel.
template <class Shade>
Image sampledImage(Macro macro, int steps, const Window& window, const Shade& shade) {
  Image image = emptyImage(window.side);
  tbb::parallel_for(0, window.side, [&](int y) {
    for (int x = 0; x < window.side; ++x)
      for (int s = 0; s < kSubsamples * kSubsamples; ++s) {
        const int column = s % kSubsamples, row = s / kSubsamples;
        const double across = window.at(x + (column + 0.5) / kSubsamples),
                     up = window.at(y + (row + 0.5) / kSubsamples);
        add(image.values[static_cast<std::size_t>(y) * window.side + x],
            shade(macroPoint(macro, steps, across, up), across, up), 1.0F / (kSubsamples * kSubsamples));
      }
  });
  return image;
}

std::size_t texelAt(const Eigen::Vector2d& place, int side) {
  const auto texel = [side](double at) {
    return std::clamp(static_cast<int>((at - std::floor(at)) * side), 0, side - 1);
  };
  return static_cast<std::size_t>(texel(place.y())) * side + texel(place.x());
}

}  // namespace

Vec3 Window::towardsEye() const {
  const double polar = polar_deg * pi / 180, azimuth = azimuth_deg * pi / 180;
  return {std::sin(polar) * std::cos(azimuth), std::cos(polar), -std::sin(polar) * std::sin(azimuth)};
}

Image Image::blurred(int pixels) const {
  Image image = emptyImage(side / pixels);
  const double share = 1.0 / (pixels * pixels);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      add(image.values[static_cast<std::size_t>(y / pixels) * image.side + x / pixels],
          values[static_cast<std::size_t>(y) * side + x], static_cast<float>(share));
  image.variance = variance * share * share;
  return image;
}

void SquaredError::add(const Image& image, const Image& truth) {
  for (std::size_t i = 0; i < truth.values.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double right = truth.values[i][c];
      difference += std::pow(image.values[i][c] - right, 2);
      square += right * right;
    }
  difference -= truth.variance;
  square -= truth.variance;
}

void SquaredError::add(const SquaredError& other) {
  difference += other.difference;
  square += other.square;
}

double SquaredError::relative() const {
  return std::sqrt(std::max(difference, 0.0) / square);
}

Image truthImage(const reference::Scene& scene, Macro macro, const Window& window, int batches,
                 reference::Transport transport) {
  using transport::StratifiedBatch;
  const Vec3 towards = window.towardsEye();
  const reference::PathTracer tracer(scene, {.transport = transport});
  Image image = emptyImage(window.side);
  std::vector<double> variances(static_cast<std::size_t>(window.side), 0.0);
  tbb::parallel_for(0, window.side, [&](int y) {
    reference::TraceCounts counts;
    for (int x = 0; x < window.side; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * window.side + x;
      reference::BatchMeans means;
      for (int number = 0; number < batches; ++number) {
        const StratifiedBatch batch(7, pixel, static_cast<std::uint64_t>(number));
        reference::Rgb sum = reference::Rgb::Zero();
        for (int s = 0; s < StratifiedBatch::kSize; ++s) {
          const auto [i, j] = batch.pair(s, 0);
          const Vec3 through = macroPoint(macro, 1, window.at(x + i), window.at(y + j)).position;
          // Far enough to be above all of the relief, near enough not to meet the other side of a trough.
          const transport::Hit hit = scene.rays().nearestHit(through + 1.5 * kPatchWidth * towards, -towards);
          if (hit.valid) sum += tracer.exitRadiance(scene.pointAt(hit), towards, {batch, s}, counts);
        }
        means.add(sum / StratifiedBatch::kSize);
      }
      image.values[pixel] = transport::float3(means.mean().matrix());
      variances[static_cast<std::size_t>(y)] += means.variance().sum();
    }
  });
  for (const double variance : variances) image.variance += variance;
  return image;
}

Image shadedImage(transport::PackShading& shading, Macro macro, int steps, const Window& window) {
  shading.setView(transport::ViewPoint(kFar * window.towardsEye()));
  return sampledImage(macro, steps, window, [&](const MacroPoint& at, double, double) {
    Float3 radiance;
    shading.radianceAt({&at.hit, 1}, {&radiance, 1});
    return radiance;
  });
}

Image packImage(const formats::Pack& pack, Macro macro, int steps, std::span<const Float3> light,
                const Window& window) {
  transport::BiScaleShading shading(pack);
  shading.setLight(light, {});
  return shadedImage(shading, macro, steps, window);
}

NormalMap normalMapOf(const patch::PatchGeometry& geometry, int side) {
  constexpr int kSamples = 4;
  const transport::PeriodicRayScene scene(geometry.mesh, {geometry.period_x, geometry.period_y});
  NormalMap map{side, {}, {}};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      transport::FreeRays rays;
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i)
          rays.push(Vec3((x + (i + 0.5) / kSamples) / side, (y + (j + 0.5) / kSamples) / side,
                         scene.highest() + 0.1),
                    Vec3(0, 0, -1));
      transport::HitBundle hits(rays.size());
      scene.nearestHits(rays, hits);
      Vec3 normal = Vec3::Zero();
      Float3 albedo = {0, 0, 0};
      for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits.blocked[i] == 0) continue;
        const auto& corners = geometry.mesh.triangles[hits.triangle[i]];
        const std::array<float, 3> weights = {1 - hits.u[i] - hits.v[i], hits.u[i], hits.v[i]};
        for (std::size_t k = 0; k < 3; ++k) normal += weights[k] * vec3(geometry.mesh.normals[corners[k]]);
        add(albedo, geometry.albedoAt(hits.triangle[i], hits.u[i], hits.v[i]), 1.0F / (kSamples * kSamples));
      }
      map.normals.push_back(normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3(0, 0, 1));
      map.albedo.push_back(albedo);
    }
  return map;
}

Image normalMapImage(const NormalMap& map, Macro macro, std::span<const Float3> light, const Window& window) {
  const int order = static_cast<int>(std::lround(std::sqrt(light.size())));
  const std::vector<double> cosine = transport::clampedCosineFactors(order);
  return sampledImage(macro, 1, window, [&](const MacroPoint& at, double across, double up) {
    // All macro surfaces have a whole number of patches on either side of the middle.
    const std::size_t index = texelAt({across, up}, map.side);
    const Vec3 n = at.normal, along = Vec3(1, 0, 0), t = (along - along.dot(n) * n).normalized();
    const Vec3 normal =
        map.normals[index].x() * t + map.normals[index].y() * n.cross(t) + map.normals[index].z() * n;
    const std::vector<double> basis = transport::evaluateSh(order, normal);
    Float3 radiance = {0, 0, 0};
    for (int l = 0; l < order; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i)
        add(radiance, light[static_cast<std::size_t>(i)],
            static_cast<float>(cosine[static_cast<std::size_t>(l)] / pi *
                               basis[static_cast<std::size_t>(i)]));
    for (std::size_t c = 0; c < 3; ++c) radiance[c] = std::max(radiance[c], 0.0F) * map.albedo[index][c];
    return radiance;
  });
}

}  // namespace bakelight::bench
