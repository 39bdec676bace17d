// Unbiased Monte Carlo estimates of exit radiance.
#pragma once

#include <cstdint>

#include "formats/words.h"
#include "tools/reference/scene.h"
#include "tools/reference/trace_counts.h"
#include "transport/random.h"

namespace bakelight::reference {

enum class Transport {
  kFull,            // every bounce reflects diffusely and glossily
  kInterreflected,  // bounced light comes from diffuse reflection alone, as in a bake; the last reflection,
                    // towards the eye, has both parts
  kShadowed,        // direct light, blocked by the mesh
  kUnshadowed       // direct light, as if the point were alone with the lights
};
inline constexpr formats::Word<Transport> kTransports[] = {{"full", Transport::kFull},
                                                           {"interreflected", Transport::kInterreflected},
                                                           {"shadowed", Transport::kShadowed},
                                                           {"unshadowed", Transport::kUnshadowed}};

enum class Integrator {
  kMis,     // lights and reflection sampled, combined by the power heuristic (Veach & Guibas 1995)
  kUniform  // directions uniform over the hemisphere; of lights, only directional and punctual ones are sampled
};
inline constexpr formats::Word<Integrator> kIntegrators[] = {{"mis", Integrator::kMis},
                                                             {"uniform", Integrator::kUniform}};

struct PathOptions {
  Transport transport = Transport::kFull;
  Integrator integrator = Integrator::kMis;
  int bounces = 0;  // at most so many between surface and surface; 0: no limit
};

// One sample of a batch, and the dimensions that are its own.
struct SampleOfBatch {
  const transport::StratifiedBatch& batch;
  int index;  // below StratifiedBatch::kSize

  static constexpr int kFirstPathDimension = 8;  // smaller ones are free for the caller
};

class PathTracer {
 public:
  PathTracer(const Scene& scene, const PathOptions& options) : scene_(scene), options_(options) {}

  // One estimate of the radiance that leaves `point` towards `outgoing` (unit). Its mean over samples is
  // exact: paths end by Russian roulette only. Emitters take part in the light on the point, absorb what
  // falls on them and bound what the point sees. Adds to `counts`. Thread-safe.
  Rgb exitRadiance(const ShadingPoint& point, const Vec3& outgoing, const SampleOfBatch& sample,
                   TraceCounts& counts) const;

 private:
  struct Vertex;
  Rgb directLight(const Vertex& vertex, const Bsdf& bsdf, std::uint64_t& rays) const;
  Rgb emittedTowards(const ShadingPoint& point, const Bsdf::Sample& sample, const transport::Hit& hit) const;
  Rgb lightFromBelow(Vertex& vertex, const Subsurface& inside, const Vec3& towards_eye,
                     std::uint64_t& rays) const;
  Rgb walkedFrom(Vertex& vertex, const RandomWalk& inside, const Vec3& towards_eye,
                 TraceCounts& counts) const;
  bool blocked(const Vec3& origin, const Vec3& direction, double distance) const;
  transport::Hit nextHit(const Vec3& origin, const Vec3& direction) const;

  const Scene& scene_;
  PathOptions options_;
};

}  // namespace bakelight::reference
