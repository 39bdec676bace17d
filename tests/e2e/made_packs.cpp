#include "tests/e2e/made_packs.h"

#include <cmath>
#include <Eigen/Geometry>
#include <numbers>

#include "transport/sh.h"
#include "transport/vector_types.h"

namespace bakelight::tests {
namespace {

using formats::TriangleMesh;
using transport::Vec3;

// Latitude rings from the north pole; quads at the poles shrink to triangles with a repeated position.
template <class Radius>
void addBall(TriangleMesh& mesh, int rings, const Vec3& center, const Radius& radius) {
  const int columns = 2 * rings;
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  for (int ring = 0; ring <= rings; ++ring)
    for (int column = 0; column < columns; ++column) {
      const double polar = std::numbers::pi * ring / rings, azimuth = 2 * std::numbers::pi * column / columns;
      const Vec3 direction(std::sin(polar) * std::sin(azimuth), std::cos(polar),
                           std::sin(polar) * std::cos(azimuth));
      mesh.positions.push_back(transport::float3(center + radius(polar, azimuth) * direction));
    }
  const auto index = [&](int ring, int column) {
    return first + static_cast<std::uint32_t>(ring * columns + column % columns);
  };
  for (int ring = 0; ring < rings; ++ring)
    for (int column = 0; column < columns; ++column) {
      const auto a = index(ring, column), b = index(ring + 1, column), c = index(ring + 1, column + 1),
                 d = index(ring, column + 1);
      if (ring + 1 < rings) mesh.triangles.push_back({a, b, c});
      if (ring > 0) mesh.triangles.push_back({a, c, d});
    }
}

void setNormals(TriangleMesh& mesh) {
  std::vector<Vec3> sums(mesh.vertexCount(), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 origin = transport::vec3(mesh.positions[a]);
    const Vec3 doubled_area =
        (transport::vec3(mesh.positions[b]) - origin).cross(transport::vec3(mesh.positions[c]) - origin);
    for (const auto vertex : {a, b, c}) sums[vertex] += doubled_area;
  }
  mesh.normals.clear();
  for (const Vec3& sum : sums)
    mesh.normals.push_back(transport::float3(sum.squaredNorm() > 0 ? Vec3(sum.normalized()) : Vec3::UnitY()));
}

formats::Pack packOf(TriangleMesh mesh, int order) {
  formats::Pack pack;
  pack.name = "made";
  pack.mesh = std::move(mesh);
  pack.transfer.order = order;
  pack.transfer.visibility = "unshadowed";
  const auto factors = transport::clampedCosineFactors(order);
  for (const auto& normal : pack.mesh.normals) {
    const auto basis = transport::evaluateSh(order, transport::vec3(normal).normalized());
    for (int l = 0; l < order; ++l)
      for (int m = -l; m <= l; ++m)
        pack.transfer.vectors.push_back(
            static_cast<float>(factors[l] / std::numbers::pi * basis[transport::coefficientIndex(l, m)]));
  }
  return pack;
}

}  // namespace

formats::Pack spherePack(int order, int rings) {
  TriangleMesh mesh;
  addBall(mesh, rings, Vec3::Zero(), [](double, double) { return 1.0; });
  mesh.normals = mesh.positions;
  return packOf(std::move(mesh), order);
}

formats::Pack wavyPack(int order, int rings) {
  const Vec3 center(3, -2, 5);
  TriangleMesh mesh;
  addBall(mesh, rings, center, [](double polar, double azimuth) {
    return 1 + 0.12 * std::sin(3 * polar) * std::sin(3 * polar) * std::cos(5 * azimuth);
  });
  addBall(mesh, rings / 2, center + Vec3(0.7, 0.35, 1.1), [](double, double) { return 0.25; });
  setNormals(mesh);
  formats::Pack pack = packOf(std::move(mesh), order);
  pack.base_color = {0.9f, 0.6f, 0.3f};
  return pack;
}

}  // namespace bakelight::tests
