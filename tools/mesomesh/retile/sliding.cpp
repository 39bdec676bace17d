#include "tools/mesomesh/retile/sliding.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <functional>

namespace bakelight::mesomesh {
namespace {

constexpr std::size_t kGrain = 1024;

struct Ring {
  Vec3 area = Vec3::Zero();  // sum of area vectors
  Vec3 middle = Vec3::Zero();
  Vec3 along_curve = Vec3::Zero();
  int neighbors = 0, curve_neighbors = 0;
};

Ring ringOf(const CornerMesh& mesh, std::uint32_t v) {
  Ring ring;
  const Side first = mesh.leaving[v];
  for (Side s = first; s != kNone;) {
    const Vec3& end = mesh.positions[mesh.end(s)];
    ring.area += mesh.areaVector(s / 3);
    ring.middle += end;
    ++ring.neighbors;
    if (mesh.side_feature[s] != 0) ring.along_curve += end, ++ring.curve_neighbors;
    const Side in = previousSide(s);
    s = mesh.opposite[in];
    if (s == kNone) {  // the border's other edge
      const Vec3& start = mesh.positions[mesh.start(in)];
      ring.middle += start;
      ++ring.neighbors;
      if (mesh.side_feature[in] != 0) ring.along_curve += start, ++ring.curve_neighbors;
    }
    if (s == first) break;
  }
  return ring;
}

// Where the vertex comes to lie; remembers what is near there.
Vec3 onOriginal(SlidingMesh& sliding, const OriginalSurface& original, std::uint32_t v, const Vec3& position,
                const Vec3& normal) {
  if (sliding.isOnCurve(v)) {
    const ClosestPoint foot = original.onCurve(position, sliding.curve[v], sliding.segment[v]);
    sliding.segment[v] = foot.triangle;
    return foot.position;
  }
  const std::uint32_t region = sliding.mesh.materials[sliding.mesh.leaving[v] / 3];
  const ClosestPoint foot = original.onRegion(position, normal, region, sliding.near[v]);
  if (!foot.valid) return sliding.mesh.positions[v];
  sliding.near[v] = foot.triangle;
  return foot.position;
}

template <class Visit>
void forVertices(std::size_t first, std::size_t end, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(first, end, kGrain), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) visit(static_cast<std::uint32_t>(v));
  });
}

}  // namespace

void evenOut(SlidingMesh& sliding, const OriginalSurface& original, int rounds) {
  CornerMesh& mesh = sliding.mesh;
  std::vector<Vec3> places(mesh.positions.size());
  for (int round = 0; round < rounds; ++round) {
    forVertices(0, mesh.positions.size(), [&](std::uint32_t v) {
      places[v] = mesh.positions[v];
      if (mesh.leaving[v] == kNone || sliding.isCorner(v)) return;
      const Ring ring = ringOf(mesh, v);
      const double length = ring.area.norm();
      if (!(length > 0)) return;
      const Vec3 normal = ring.area / length;
      Vec3 target;
      if (sliding.isOnCurve(v)) {
        if (ring.curve_neighbors != 2) return;
        target = ring.along_curve / 2;
      } else {
        const Vec3 move = ring.middle / ring.neighbors - mesh.positions[v];
        target = mesh.positions[v] + move - normal.dot(move) * normal;
      }
      places[v] = onOriginal(sliding, original, v, target, normal);
    });
    mesh.positions.swap(places);
  }
}

void drop(SlidingMesh& sliding, const OriginalSurface& original, std::size_t first) {
  CornerMesh& mesh = sliding.mesh;
  std::vector<Vec3> places(mesh.positions.size() - first);
  forVertices(first, mesh.positions.size(), [&](std::uint32_t v) {
    places[v - first] = mesh.positions[v];
    if (mesh.leaving[v] == kNone || sliding.isCorner(v)) return;
    const Ring ring = ringOf(mesh, v);
    const double length = ring.area.norm();
    places[v - first] =
        onOriginal(sliding, original, v, mesh.positions[v],
                   length > 0 ? Vec3(ring.area / length) : original.triangleNormal(sliding.near[v]));
  });
  std::copy(places.begin(), places.end(), mesh.positions.begin() + static_cast<std::ptrdiff_t>(first));
}

std::size_t foldedTriangles(const SlidingMesh& sliding, const OriginalSurface& original) {
  const CornerMesh& mesh = sliding.mesh;
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.triangles.size(), kGrain), std::size_t{0},
      [&](const auto& range, std::size_t count) {
        for (std::size_t t = range.begin(); t < range.end(); ++t) {
          const auto triangle = static_cast<std::uint32_t>(t);
          if (!mesh.alive(triangle)) continue;
          // Only what lies in the triangle's own region says how it should face.
          Vec3 below = Vec3::Zero();
          for (const std::uint32_t v : mesh.triangles[t])
            if (!sliding.isOnCurve(v) && !sliding.isCorner(v))
              below += original.triangleNormal(sliding.near[v]);
          const Vec3 area = mesh.areaVector(triangle);
          const bool knows = below.squaredNorm() > 0;
          count += (knows && area.dot(below) < 0) || !(area.squaredNorm() > 0);
        }
        return count;
      },
      std::plus<>());
}

}  // namespace bakelight::mesomesh
