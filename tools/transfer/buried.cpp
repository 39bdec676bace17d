#include "tools/transfer/buried.h"

#include <algorithm>

#include "transport/directions.h"

namespace bakelight::transfer {

using formats::Float3;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr int kProbeDirections = 128;  // over the sphere

bool isBackFace(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& direction) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const Vec3 ab = vec3(mesh.positions[b]) - vec3(mesh.positions[a]);
  const Vec3 ac = vec3(mesh.positions[c]) - vec3(mesh.positions[a]);
  return ab.cross(ac).dot(direction) > 0;
}

using Ring = std::vector<std::uint32_t>;

// Vertices that share an edge with each buried one; empty for the others.
std::vector<Ring> neighboursOf(const TriangleMesh& mesh, std::span<const std::uint8_t> buried) {
  std::vector<Ring> rings(mesh.vertexCount());
  for (const auto& triangle : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      if (buried[triangle[i]] == 0) continue;
      rings[triangle[i]].push_back(triangle[(i + 1) % 3]);
      rings[triangle[i]].push_back(triangle[(i + 2) % 3]);
    }
  for (Ring& ring : rings) {
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  }
  return rings;
}

}  // namespace

bool isBuried(const TriangleMesh& mesh, const transport::RayScene& scene, const Float3& origin,
              const Float3& normal) {
  static const std::vector<Vec3> directions = transport::sphereDirections(kProbeDirections);
  int front = 0, back = 0;
  for (const Vec3& direction : directions) {
    if (direction.dot(vec3(normal)) <= 0) continue;
    const transport::Hit hit = scene.nearestHit(vec3(origin), direction);
    if (hit.valid) ++(isBackFace(mesh, hit.triangle, direction) ? back : front);
  }
  return back > front;
}

std::uint64_t fillBuried(const TriangleMesh& mesh, std::span<const std::uint8_t> buried,
                         std::span<float> vectors, std::size_t count) {
  const std::vector<Ring> rings = neighboursOf(mesh, buried);
  std::vector<std::uint8_t> open(buried.begin(), buried.end());
  std::uint64_t filled = 0;
  while (true) {
    // Who borders on a filled vertex is decided before any of this round is filled, so the order does not
    // matter.
    std::vector<std::uint32_t> round;
    for (std::uint32_t v = 0; v < open.size(); ++v)
      if (open[v] != 0 && std::any_of(rings[v].begin(), rings[v].end(), [&](auto n) { return open[n] == 0; }))
        round.push_back(v);
    if (round.empty()) return filled;

    for (const std::uint32_t v : round) {
      std::vector<double> sum(count, 0.0);
      int neighbours = 0;
      for (const std::uint32_t n : rings[v]) {
        if (open[n] != 0) continue;
        for (std::size_t i = 0; i < count; ++i) sum[i] += vectors[n * count + i];
        ++neighbours;
      }
      for (std::size_t i = 0; i < count; ++i)
        vectors[v * count + i] = static_cast<float>(sum[i] / neighbours);
    }
    for (const std::uint32_t v : round) open[v] = 0;
    filled += round.size();
  }
}

}  // namespace bakelight::transfer
