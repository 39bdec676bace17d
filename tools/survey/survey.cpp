#include "tools/survey/survey.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <variant>
#include <vector>

#include "tools/survey/concavity.h"
#include "tools/survey/surface.h"
#include "transport/lights.h"
#include "transport/ray_scene.h"

namespace bakelight::survey {

using transport::float3;
using transport::RayScene;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr int kStrata = 8;  // of the square that directions come from, an axis
static_assert(kStrata * kStrata == kDirections);
constexpr int kWalks = 4;  // of each point, at most
// A walk ends by chance, and what is left goes to the others (Russian roulette), so that it is finite in a
// closed white cavity, too.
constexpr double kLargestSurvival = 0.99;

// Random numbers of one sample, by its index only: SplitMix64 (Steele, Lea & Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t sample) : state_(sample << 32) {}
  double next() {  // in [0, 1)
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

// About `normal`, with density cosine/π.
Vec3 cosineDirection(const Vec3& normal, double u, double v) {
  const double radius = std::sqrt(u), angle = 2 * std::numbers::pi * v;
  const Vec3 tangent = normal.unitOrthogonal();
  return (radius * std::cos(angle) * tangent + radius * std::sin(angle) * normal.cross(tangent) +
          std::sqrt(1 - u) * normal)
      .normalized();
}

double luminance(const Vec3& rgb) {
  return transport::luminance(float3(rgb));
}

// What one point of the surface sees.
struct Sample {
  double blocked_share = 0;
  Vec3 albedo = Vec3::Zero();
  std::uint32_t triangle = 0;
  Vec3 bounced = Vec3::Zero();  // mean radiance that arrives from blocked directions, cosine-weighted
  std::uint64_t rays = 0;

  double directExit() const { return luminance(albedo) * (1 - blocked_share); }
  double bouncedExit() const { return luminance(albedo.cwiseProduct(bounced)); }
  // Mean radiance that arrives.
  Vec3 arriving() const { return Vec3::Constant(1 - blocked_share) + bounced; }
};

class Sampler {
 public:
  Sampler(const Surface& surface, const RayScene& scene) : surface_(surface), scene_(scene) {}

  Sample sample(int index, int count) const {
    Random random(index);
    const double along = (index + random.next()) / count;
    const double u = random.next(), v = random.next();
    const SurfacePoint point = surface_.pointAt(along, u, v);
    transport::RayBundle rays(kDirections);
    for (int i = 0; i < kDirections; ++i) {
      const int row = i / kStrata, column = i % kStrata;
      const double x = (row + random.next()) / kStrata, y = (column + random.next()) / kStrata;
      rays.set(i, float3(cosineDirection(point.normal, x, y)));
    }
    transport::HitBundle hits(kDirections);
    scene_.nearestHits(float3(point.origin), rays, 0, kDirections, hits);

    Sample result;
    result.albedo = point.albedo;
    result.triangle = point.triangle;
    result.rays = kDirections;
    std::vector<int> blocked;
    for (int i = 0; i < kDirections; ++i)
      if (hits.blocked[i] != 0) blocked.push_back(i);
    result.blocked_share = static_cast<double>(blocked.size()) / kDirections;
    followSome(hits, blocked, random, result);
    return result;
  }

 private:
  // Walks from some of the blocked directions, evenly spread over them, stand for all of them.
  void followSome(const transport::HitBundle& hits, const std::vector<int>& blocked, Random& random,
                  Sample& result) const {
    const int walks = std::min(kWalks, static_cast<int>(blocked.size()));
    const double shift = random.next();
    for (int walk = 0; walk < walks; ++walk) {
      const auto place =
          static_cast<std::size_t>((walk + shift) * static_cast<double>(blocked.size()) / walks);
      const int i = blocked[std::min(place, blocked.size() - 1)];
      SurfacePoint hit;
      if (surface_.pointAt(hits.triangle[i], hits.u[i], hits.v[i], hits.back_face[i] != 0, hit))
        result.bounced += exitRadiance(hit, random, result.rays);
    }
    if (walks > 0) result.bounced *= result.blocked_share / walks;
  }

  // Estimate of what leaves `point` by diffuse reflection under a sky of 1: a random walk that counts when it
  // escapes.
  Vec3 exitRadiance(SurfacePoint point, Random& random, std::uint64_t& rays) const {
    Vec3 throughput = Vec3::Ones();
    while (true) {
      throughput = throughput.cwiseProduct(point.albedo);
      const double survival = std::min(throughput.maxCoeff(), kLargestSurvival);
      if (random.next() >= survival) return Vec3::Zero();
      throughput /= survival;
      const double u = random.next(), v = random.next();
      const transport::Hit hit = scene_.nearestHit(point.origin, cosineDirection(point.normal, u, v));
      ++rays;
      if (!hit.valid) return throughput;
      if (!surface_.pointAt(hit.triangle, hit.u, hit.v, hit.back_face, point)) return Vec3::Zero();
    }
  }

  const Surface& surface_;
  const RayScene& scene_;
};

// Mean of part / mean of whole, with the standard error of a ratio of means (to first order).
template <class Part, class Whole>
Estimate ratioOfMeans(const std::vector<Sample>& samples, Part part, Whole whole) {
  double parts = 0, wholes = 0, squares = 0;
  for (const Sample& sample : samples) parts += part(sample), wholes += whole(sample);
  if (wholes <= 0) return {};
  const double ratio = parts / wholes, count = static_cast<double>(samples.size());
  for (const Sample& sample : samples) squares += std::pow(part(sample) - ratio * whole(sample), 2);
  return {ratio, std::sqrt(squares * count / (count - 1)) / wholes};
}

// Under a sky whose light arrives alike everywhere.
double unblockedViewDependence(const Surface& surface, const SurveyOptions& options) {
  const double specular =
      luminance(options.triangle_specular.empty() ? vec3(options.specular_color)
                                                  : surface.mean(options.triangle_specular));
  const double diffuse = luminance(surface.meanAlbedo());
  return specular + diffuse > 0 ? specular / (specular + diffuse) : 0;
}

Estimate viewDependence(const std::vector<Sample>& samples, const Surface& surface,
                        const SurveyOptions& options) {
  if (options.lobe == SurveyOptions::Lobe::kNone) return {};
  if (options.lobe == SurveyOptions::Lobe::kTable) return {1, 0};
  if (samples.empty()) return {unblockedViewDependence(surface, options), 0};
  const auto specular = [&](const Sample& s) -> Vec3 {
    return vec3(options.triangle_specular.empty() ? options.specular_color
                                                  : options.triangle_specular[s.triangle]);
  };
  const auto lobe = [&](const Sample& s) { return luminance(specular(s).cwiseProduct(s.arriving())); };
  const auto all = [&](const Sample& s) {
    return luminance((specular(s) + s.albedo).cwiseProduct(s.arriving()));
  };
  return ratioOfMeans(samples, lobe, all);
}

Float3 reflectanceOf(const formats::Reflection& reflection) {
  if (const auto* phong = std::get_if<formats::PhongReflection>(&reflection)) return phong->specular_color;
  const auto* ggx = std::get_if<formats::GgxReflection>(&reflection);
  if (ggx == nullptr) return {0, 0, 0};
  Float3 reflectance = ggx->specular_color;
  if (ggx->fresnel)
    for (float& value : reflectance) value = (1 + 20 * value) / 21;
  return reflectance;
}

template <class Kind>
bool anyIs(const std::vector<formats::Reflection>& reflections) {
  return std::any_of(reflections.begin(), reflections.end(),
                     [](const auto& reflection) { return std::holds_alternative<Kind>(reflection); });
}

}  // namespace

SurveyOptions optionsFor(const formats::SurfaceMaterials& materials) {
  using Lobe = SurveyOptions::Lobe;
  const auto& reflections = materials.reflections;
  SurveyOptions options{.albedo = materials.albedo, .specular_color = reflectanceOf(reflections.front())};
  if (anyIs<formats::PhongReflection>(reflections) || anyIs<formats::GgxReflection>(reflections))
    options.lobe = Lobe::kTinted;
  if (anyIs<formats::TableReflection>(reflections)) options.lobe = Lobe::kTable;
  for (const std::uint32_t material : materials.of_triangle)
    options.triangle_specular.push_back(reflectanceOf(reflections[material]));
  return options;
}

Survey survey(const formats::TriangleMesh& mesh, const SurveyOptions& options) {
  if (options.samples < 2) throw std::invalid_argument("a survey takes 2 samples or more");
  const Surface surface(mesh, options.albedo);
  Survey result;
  result.concavity = concavity(mesh);

  std::vector<Sample> samples;
  if (result.concavity > kConvex) {
    samples.resize(options.samples);
    const RayScene scene(mesh);
    const Sampler sampler(surface, scene);
    tbb::parallel_for(0, options.samples, [&](int i) { samples[i] = sampler.sample(i, options.samples); });
    const auto one = [](const Sample&) { return 1.0; };
    result.blocked_share = ratioOfMeans(
        samples, [](const Sample& s) { return s.blocked_share; }, one);
    result.bounce_energy =
        ratioOfMeans(samples, std::mem_fn(&Sample::bouncedExit), std::mem_fn(&Sample::directExit));
  }
  for (const Sample& sample : samples) {
    result.largest_blocked_share = std::max(result.largest_blocked_share, sample.blocked_share);
    result.rays += sample.rays;
  }
  result.view_dependence = viewDependence(samples, surface, options);
  return result;
}

}  // namespace bakelight::survey
