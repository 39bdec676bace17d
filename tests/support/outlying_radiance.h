// Looks for single vertices that show as spots: the exit radiance of a bake under given lights, each vertex
// beside those around it.
#pragma once

#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/evaluator.h"

namespace bakelight::tests {

struct OutlyingRadiance {
  std::uint32_t vertex = 0;
  double excess =
      0;  // beyond the range of the neighbours and half its width, as a share of the surface's mean
  double radiance = 0, lowest = 0, highest = 0;  // of the vertex, of its neighbours

  std::string text() const {
    return "vertex " + std::to_string(vertex) + " has radiance " + std::to_string(radiance) +
           " among neighbours of " + std::to_string(lowest) + " to " + std::to_string(highest);
  }
};

// The worst vertex under one light, by luminance of the green kind: neighbours that face the same way (within
// 45°) are compared with, three at least. `vectors` is n × (channels · order²).
inline OutlyingRadiance worstOutlier(const formats::TriangleMesh& mesh, std::span<const float> vectors,
                                     int order, int channels, std::span<const formats::Float3> light) {
  const std::vector<formats::Float3> radiance = transport::evaluateDiffuse(vectors, order, light, channels);
  std::vector<std::set<std::uint32_t>> around(mesh.vertexCount());
  double mean = 0;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t a : triangle)
      for (const std::uint32_t b : triangle)
        if (a != b) around[a].insert(b);
  for (const auto& value : radiance) mean += value[1] / static_cast<double>(radiance.size());

  OutlyingRadiance worst;
  for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v) {
    OutlyingRadiance own{v, 0, radiance[v][1], std::numeric_limits<double>::infinity(), 0};
    own.highest = -own.lowest;
    int compared = 0;
    for (const std::uint32_t other : around[v]) {
      const auto &a = mesh.normals[v], &b = mesh.normals[other];
      if (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < 0.7f) continue;
      own.lowest = std::min<double>(own.lowest, radiance[other][1]);
      own.highest = std::max<double>(own.highest, radiance[other][1]);
      ++compared;
    }
    if (compared < 3) continue;
    own.excess =
        (std::max(own.lowest - own.radiance, own.radiance - own.highest) - 0.5 * (own.highest - own.lowest)) /
        mean;
    if (own.excess > worst.excess) worst = own;
  }
  return worst;
}

}  // namespace bakelight::tests
