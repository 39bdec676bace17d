// Vertex shading in one call.
#pragma once

#include "transport/vertex_shading.h"

namespace bakelight::transport {

// Exit radiance of each vertex towards `eye`.
inline std::vector<Float3> evaluatePack(const formats::Pack& pack, std::span<const Float3> light,
                                        std::span<const Float3> near_light, const Vec3& eye) {
  VertexShading shading(pack);
  shading.setLight(light, near_light);
  shading.setView(eye);
  const std::span<const Float3> radiance = shading.vertexRadiance();
  return {radiance.begin(), radiance.end()};
}

}  // namespace bakelight::transport
