#include "tools/reference/path_tracer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "transport/diffusion.h"

namespace bakelight::reference {
namespace {

// Dimensions of a path, by what they are for.
enum Purpose { kLobeChoice, kReflection, kDistantLight, kEmitter, kRoulette, kPurposes };

// Of light that goes through a medium, far from the others, which pictures without one need as they are.
enum MediumPurpose { kMediumChoice, kEntryChoice, kEntryPoint, kEntryPick, kMediumPurposes };
constexpr int kFirstMediumDimension = 1 << 24;

constexpr int kBouncesBeforeRoulette = 2;
// Paths in a closed white cavity end too.
constexpr double kLargestSurvival = 0.95;
// Share of the distance to an emitter that a shadow ray leaves out, so that it does not meet the emitter.
constexpr double kEmitterMargin = 1e-4;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Of a sample from a strategy of density `own`, against one other.
double powerHeuristic(double own, double other) {
  if (!(own > 0)) return 0;
  const double ratio = other / own;
  return 1 / (1 + ratio * ratio);
}

}  // namespace

// A surface point of a path.
struct PathTracer::Vertex {
  ShadingPoint point;
  int depth;  // 0: the one that is seen
  const SampleOfBatch& sample;

  double single(Purpose purpose) const { return sample.batch.single(sample.index, dimension(purpose)); }
  std::array<double, 2> pair(Purpose purpose) const {
    return sample.batch.pair(sample.index, dimension(purpose));
  }
  int dimension(Purpose purpose) const {
    return SampleOfBatch::kFirstPathDimension + depth * kPurposes + purpose;
  }
  double single(MediumPurpose purpose) const { return sample.batch.single(sample.index, dimension(purpose)); }
  std::array<double, 2> pair(MediumPurpose purpose) const {
    return sample.batch.pair(sample.index, dimension(purpose));
  }
  int dimension(MediumPurpose purpose) const {
    return kFirstMediumDimension + depth * kMediumPurposes + purpose;
  }
};

bool PathTracer::blocked(const Vec3& origin, const Vec3& direction, double distance) const {
  const auto& scene = options_.transport == Transport::kUnshadowed ? scene_.emitterRays() : scene_.rays();
  return scene.occluded(origin, direction, static_cast<float>(distance));
}

transport::Hit PathTracer::nextHit(const Vec3& origin, const Vec3& direction) const {
  if (options_.transport != Transport::kUnshadowed) return scene_.rays().nearestHit(origin, direction);
  transport::Hit hit = scene_.emitterRays().nearestHit(origin, direction);
  hit.triangle += static_cast<std::uint32_t>(scene_.mesh().triangleCount());
  return hit;
}

Rgb PathTracer::directLight(const Vertex& vertex, const Bsdf& bsdf, std::uint64_t& rays) const {
  const Vec3& origin = vertex.point.origin;
  Rgb light = Rgb::Zero();
  const auto add = [&](const Vec3& direction, double distance, const Rgb& contribution) {
    if ((contribution == 0).all()) return;
    ++rays;
    if (!blocked(origin, direction, distance)) light += contribution;
  };

  const DistantLightSampler& distant = scene_.distantLight();
  for (const auto& directional : distant.directional())
    add(directional.direction, kInfinity, bsdf.value(directional.direction) * directional.irradiance);
  for (const transport::PlacedPunctualLight& punctual : scene_.punctualLights()) {
    const Vec3 way = punctual.position - origin;
    const double distance = way.norm();
    if (!(distance > 0)) continue;
    const Vec3 direction = way / distance;
    add(direction, distance, bsdf.value(direction) * punctual.irradianceFacing(origin));
  }
  if (options_.integrator == Integrator::kUniform) return light;

  const auto [u, v] = vertex.pair(kDistantLight);
  const auto [direction, incident] = distant.sample(vertex.point.normal, u, v);
  if (incident.density_per_sr > 0) {
    const double share = powerHeuristic(incident.density_per_sr, bsdf.densityPerSr(direction));
    add(direction, kInfinity, bsdf.value(direction) * incident.radiance * (share / incident.density_per_sr));
  }
  const auto [across, along] = vertex.pair(kEmitter);
  const auto emitter = scene_.emitters().sample(origin, vertex.point.normal, across, along);
  if (emitter.density_per_sr > 0) {
    const double share = powerHeuristic(emitter.density_per_sr, bsdf.densityPerSr(emitter.direction));
    add(emitter.direction, emitter.distance * (1 - kEmitterMargin),
        bsdf.value(emitter.direction) * scene_.emitters().radiance(emitter.triangle) *
            (share / emitter.density_per_sr));
  }
  return light;
}

// What the ray of a reflection sample brings from a light, weighed against sampling that light.
Rgb PathTracer::emittedTowards(const ShadingPoint& point, const Bsdf::Sample& sample,
                               const transport::Hit& hit) const {
  const bool weighed = options_.integrator == Integrator::kMis && sample.density_per_sr > 0;
  if (!hit.valid) {
    if (!weighed) return scene_.distantLight().radiance(sample.incoming);
    const auto incident = scene_.distantLight().towards(sample.incoming, point.normal);
    return powerHeuristic(sample.density_per_sr, incident.density_per_sr) * incident.radiance;
  }
  const std::uint32_t triangle = scene_.emitterTriangle(hit.triangle);
  if (!weighed) return scene_.emitters().radiance(triangle);
  const double density =
      scene_.emitters().densityPerSr(point.origin, point.normal, triangle, sample.incoming, hit.distance);
  return powerHeuristic(sample.density_per_sr, density) * scene_.emitters().radiance(triangle);
}

// Moves the vertex to where the light enters that leaves it towards the eye; what becomes of light on it.
Rgb PathTracer::lightFromBelow(Vertex& vertex, const Subsurface& inside, const Vec3& towards_eye,
                               std::uint64_t& rays) const {
  const ShadingPoint exit = vertex.point;
  const auto entry = inside.sample(exit.position, exit.reflectance, exit.normal, vertex.single(kEntryChoice),
                                   vertex.pair(kEntryPoint), vertex.single(kEntryPick), rays);
  if (!entry) return Rgb::Zero();
  vertex.point = scene_.pointAt(entry->place);
  const double leaving =
      transport::schlickTransmittance(std::abs(exit.normal.dot(towards_eye)), inside.relativeIor());
  return entry->weight * exit.albedo * (leaving / std::numbers::pi);
}

// The same through the medium itself.
Rgb PathTracer::walkedFrom(Vertex& vertex, const RandomWalk& inside, const Vec3& towards_eye,
                           TraceCounts& counts) const {
  const ShadingPoint exit = vertex.point;
  const RandomWalk::Start start{exit.position, exit.normal, exit.triangle, exit.back_face};
  // Walks are too long for dimensions of their own.
  const auto [first, second] = vertex.pair(kEntryPoint);
  const std::uint64_t seed =
      transport::scrambled(std::bit_cast<std::uint64_t>(first)) ^ std::bit_cast<std::uint64_t>(second);
  const auto entry = inside.walk(start, inside.refracted(start, towards_eye), seed, counts);
  if (!entry) return Rgb::Zero();
  vertex.point = scene_.pointAt(entry->place);
  const double leaving =
      1 - transport::fresnelReflectance(std::abs(exit.normal.dot(towards_eye)), inside.relativeIor());
  return entry->weight * exit.albedo * leaving;
}

Rgb PathTracer::exitRadiance(const ShadingPoint& point, const Vec3& outgoing, const SampleOfBatch& sample,
                             TraceCounts& counts) const {
  const bool direct_only =
      options_.transport == Transport::kShadowed || options_.transport == Transport::kUnshadowed;
  const int last_depth = direct_only            ? 0
                         : options_.bounces > 0 ? options_.bounces
                                                : std::numeric_limits<int>::max() / kPurposes - 1;
  Rgb radiance = Rgb::Zero(), throughput = Rgb::Ones();
  Vertex vertex{point, 0, sample};
  Vec3 towards_eye = outgoing;
  while (true) {
    const bool glossy = vertex.depth == 0 || options_.transport == Transport::kFull;
    const Glossy* material = glossy ? &scene_.material(vertex.point.material) : nullptr;
    const auto reflecting = [&] {
      const Subsurface* diffusion = scene_.subsurface(vertex.point.material);
      const RandomWalk* walk = scene_.randomWalk(vertex.point.material);
      if (diffusion == nullptr && walk == nullptr)
        return Bsdf(material, vertex.point.albedo, vertex.point.normal, towards_eye);
      if (material != nullptr && !std::holds_alternative<std::monostate>(*material)) {
        throughput *= 2;
        if (vertex.single(kMediumChoice) < 0.5)
          return Bsdf(material, Rgb::Zero(), vertex.point.normal, towards_eye);
      }
      if (walk != nullptr) {
        throughput *= walkedFrom(vertex, *walk, towards_eye, counts);
        return Bsdf::enteringDiffusely(walk->relativeIor(), walk->diffuseTransmittance(),
                                       vertex.point.normal);
      }
      throughput *= lightFromBelow(vertex, *diffusion, towards_eye, counts.rays);
      return Bsdf::entering(diffusion->relativeIor(), vertex.point.normal);
    };
    const Bsdf bsdf = reflecting();
    if ((throughput == 0).all()) return radiance;
    radiance += throughput * directLight(vertex, bsdf, counts.rays);

    const auto [u, v] = vertex.pair(kReflection);
    const double choice = vertex.single(kLobeChoice);
    const Bsdf::Sample next = options_.integrator == Integrator::kMis ? bsdf.sample(choice, u, v)
                                                                      : bsdf.sampleUniformly(choice, u, v);
    throughput *= next.weight;
    if ((throughput == 0).all()) return radiance;
    ++counts.rays;
    const transport::Hit hit = nextHit(vertex.point.origin, next.incoming);
    if (!hit.valid || scene_.isEmitter(hit.triangle))
      return radiance + throughput * emittedTowards(vertex.point, next, hit);
    if (vertex.depth == last_depth) return radiance;

    if (vertex.depth >= kBouncesBeforeRoulette) {
      const double survival = std::min(throughput.abs().maxCoeff(), kLargestSurvival);
      if (vertex.single(kRoulette) >= survival) return radiance;
      throughput /= survival;
    }
    vertex.point = scene_.pointAt(hit);
    ++vertex.depth;
    towards_eye = -next.incoming;
  }
}

}  // namespace bakelight::reference
