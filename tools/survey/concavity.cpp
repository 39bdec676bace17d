#include "tools/survey/concavity.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "tools/survey/support_tree.h"
#include "transport/camera.h"

namespace bakelight::survey {

using formats::Triangle;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr std::size_t kBlock = 256;       // triangles that share one look at the best height so far
constexpr std::size_t kFirstLook = 1009;  // every so many

std::vector<Vec3> usedPositions(const TriangleMesh& mesh) {
  std::vector<std::uint8_t> used(mesh.vertexCount(), 0);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) used[v] = 1;
  std::vector<Vec3> positions;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) positions.push_back(vec3(mesh.positions[v]));
  return positions;
}

// How far rounding to float can have moved a vertex.
double positionRounding(const TriangleMesh& mesh) {
  const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
  const double farthest_coordinate = bounds.center.cwiseAbs().maxCoeff() + bounds.radius;
  return std::sqrt(3.0) * farthest_coordinate * std::numeric_limits<float>::epsilon() / 2;
}

// Whether the triangle has an area that is more than rounding.
bool planeOf(const TriangleMesh& mesh, const Triangle& triangle, double rounding, Plane& plane) {
  const Vec3 a = vec3(mesh.positions[triangle[0]]), b = vec3(mesh.positions[triangle[1]]),
             c = vec3(mesh.positions[triangle[2]]);
  const Vec3 across = (b - a).cross(c - a);
  const double longest_edge = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const double smallest_height = longest_edge > 0 ? across.norm() / longest_edge : 0;
  if (!(smallest_height > rounding)) return false;
  plane = {across.normalized(), (a + b + c) / 3, 2 * rounding, 3 * rounding / smallest_height};
  return true;
}

void raise(std::atomic<double>& best, double height) {
  double known = best.load();
  while (height > known && !best.compare_exchange_weak(known, height)) {
  }
}

}  // namespace

double concavity(const TriangleMesh& mesh) {
  const SupportTree tree(usedPositions(mesh));
  const double rounding = positionRounding(mesh), radius = transport::boundingSphere(mesh).radius;
  std::atomic<double> best{0};
  const auto search = [&](std::size_t begin, std::size_t end, std::size_t step) {
    double highest = best.load();
    for (std::size_t t = begin; t < end; t += step) {
      Plane plane;
      if (planeOf(mesh, mesh.triangles[t], rounding, plane)) highest = tree.highest(plane, highest);
    }
    raise(best, highest);
  };
  // A first look at all parts of the mesh finds a height that most of the rest need not be searched for.
  // Neighbours in a block look at the same boxes.
  search(0, mesh.triangleCount(), kFirstLook);
  const std::size_t block_count = (mesh.triangleCount() + kBlock - 1) / kBlock;
  tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    search(block * kBlock, std::min((block + 1) * kBlock, mesh.triangleCount()), 1);
  });
  return radius > 0 ? best.load() / radius : 0;
}

}  // namespace bakelight::survey
