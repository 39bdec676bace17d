#include "tests/stages/scenes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace bakelight::stages {

using formats::Float3;
using formats::Triangle;
using formats::TriangleMesh;

namespace {

Float3 scaled(const Float3& v, float factor) {
  return {v[0] * factor, v[1] * factor, v[2] * factor};
}

// Splits triangles of a unit sphere at the middles of their edges.
class SphereSplitter {
 public:
  explicit SphereSplitter(TriangleMesh& mesh) : mesh_(mesh) {}

  void split() {
    std::vector<Triangle> smaller;
    for (const auto& [a, b, c] : mesh_.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      smaller.insert(smaller.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh_.triangles = std::move(smaller);
  }

 private:
  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const auto [entry, inserted] =
        middles_.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh_.positions.size()));
    if (inserted) {
      const Float3 p = mesh_.positions[a], q = mesh_.positions[b];
      const Float3 sum = {p[0] + q[0], p[1] + q[1], p[2] + q[2]};
      mesh_.positions.push_back(
          scaled(sum, 1 / std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2])));
    }
    return entry->second;
  }

  TriangleMesh& mesh_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles_;
};

}  // namespace

TriangleMesh sphere(int subdivisions) {
  TriangleMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < subdivisions; ++i) SphereSplitter(mesh).split();
  mesh.normals = mesh.positions;
  return mesh;
}

TriangleMesh bumpySphere(int subdivisions) {
  TriangleMesh mesh = sphere(subdivisions);
  for (Float3& p : mesh.positions) {
    const float x = p[0], y = p[1], z = p[2];
    const float bumps = 3 * x * y * z + x * x * y - 0.5f * y * y * z + 0.7f * (x * x - z * z) * y * y;
    p = scaled(p, 1 + 0.25f * bumps);
  }
  mesh.normals.clear();
  return mesh;
}

TriangleMesh twoSpheres(int subdivisions) {
  TriangleMesh mesh = sphere(subdivisions);
  const TriangleMesh unit = mesh;
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  for (const Float3& p : unit.positions)
    mesh.positions.push_back({0.5f * p[0], 0.5f * p[1] + 1.75f, 0.5f * p[2]});
  mesh.normals.insert(mesh.normals.end(), unit.normals.begin(), unit.normals.end());
  for (const Triangle& t : unit.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return mesh;
}

TriangleMesh bowl(int subdivisions) {
  const TriangleMesh whole = sphere(subdivisions);
  TriangleMesh mesh;
  std::map<std::uint32_t, std::uint32_t> kept;
  const auto keep = [&](std::uint32_t vertex) {
    const auto [entry, inserted] =
        kept.try_emplace(vertex, static_cast<std::uint32_t>(mesh.positions.size()));
    if (inserted) {
      mesh.positions.push_back(whole.positions[vertex]);
      mesh.normals.push_back(scaled(whole.normals[vertex], -1));
    }
    return entry->second;
  };
  for (const auto& [a, b, c] : whole.triangles) {
    const bool below = whole.positions[a][1] <= 0 && whole.positions[b][1] <= 0 && whole.positions[c][1] <= 0;
    if (below) mesh.triangles.push_back({keep(a), keep(c), keep(b)});
  }
  return mesh;
}

TriangleMesh makeScene(const std::string& name, int subdivisions) {
  if (name == "sphere") return sphere(subdivisions);
  if (name == "bumpy_sphere") return bumpySphere(subdivisions);
  if (name == "two_spheres") return twoSpheres(subdivisions);
  if (name == "bowl") return bowl(subdivisions);
  throw std::invalid_argument("there is no scene called " + name);
}

}  // namespace bakelight::stages
