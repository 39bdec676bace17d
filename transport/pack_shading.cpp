#include "transport/pack_shading.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "formats/error.h"
#include "transport/all_frequency_shading.h"
#include "transport/bi_scale_shading.h"
#include "transport/translucent_shading.h"
#include "transport/vertex_shading.h"

namespace bakelight::transport {

void PackShading::setCubeLight(std::span<const Float3>) {
  throw std::logic_error("this technique's light is not a cube map");
}

void PackShading::setPunctualLights(std::span<const PlacedPunctualLight> lights, const Occlusion&) {
  if (!lights.empty()) throw std::logic_error("punctual lights cannot fall on what this technique shades");
}

void requirePunctualTaken(const formats::LightRig& rig, const LightNeeds& needs, const std::string& file) {
  if (rig.punctual.empty() || needs.punctual) return;
  throw badInput(
      {file, "", "/punctual"},
      "the pack cannot be lit by punctual lights: its light comes as coefficients, from all around",
      "a pack of a translucent object, which takes light at each texel of its surface",
      "use \"emitters\", or a disk or directional light in \"lights\"");
}

std::vector<ShadingTechnique>& shadingTechniques() {
  static std::vector<ShadingTechnique> techniques = {
      {"vertices", VertexShading::shades,
       [](const formats::Pack& pack) -> std::unique_ptr<PackShading> {
         return std::make_unique<VertexShading>(pack);
       }},
      {"bi-scale", BiScaleShading::shades,
       [](const formats::Pack& pack) -> std::unique_ptr<PackShading> {
         return std::make_unique<BiScaleShading>(pack);
       }},
      {"all-frequency", AllFrequencyShading::shades,
       [](const formats::Pack& pack) -> std::unique_ptr<PackShading> {
         return std::make_unique<AllFrequencyShading>(pack);
       }},
      {"translucent", TranslucentShading::shades,
       [](const formats::Pack& pack) -> std::unique_ptr<PackShading> {
         return std::make_unique<TranslucentShading>(pack);
       }},
  };
  return techniques;
}

std::unique_ptr<PackShading> makePackShading(const formats::Pack& pack) {
  const std::vector<ShadingTechnique>& techniques = shadingTechniques();
  const auto found = std::find_if(techniques.rbegin(), techniques.rend(),
                                  [&](const ShadingTechnique& technique) { return technique.shades(pack); });
  if (found == techniques.rend())
    throw std::invalid_argument(std::string("no technique shades transfer ") + pack.transfer.kind() +
                                " with reflection " + pack.appearances.front().reflection.kind());
  return found->make(pack);
}

RadianceAtHits radianceOf(const PackShading& shading) {
  return [&shading](std::span<const SurfaceHit> hits, std::span<Float3> radiance) {
    shading.radianceAt(hits, radiance);
  };
}

RadianceAtHits interpolated(std::span<const formats::Triangle> triangles,
                            std::span<const Float3> vertex_radiance) {
  return [=](std::span<const SurfaceHit> hits, std::span<Float3> radiance) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const formats::Triangle& corners = triangles[hits[i].triangle];
      const float u = hits[i].u, v = hits[i].v;
      for (std::size_t c = 0; c < 3; ++c)
        radiance[i][c] = (1 - u - v) * vertex_radiance[corners[0]][c] + u * vertex_radiance[corners[1]][c] +
                         v * vertex_radiance[corners[2]][c];
    }
  };
}

}  // namespace bakelight::transport
