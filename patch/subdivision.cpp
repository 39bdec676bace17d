#include "patch/subdivision.h"

#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "transport/vector_types.h"

namespace bakelight::patch {
namespace {

using formats::Float3;
using formats::Triangle;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

Float3 mean(const Float3& a, const Float3& b) {
  return transport::float3((vec3(a) + vec3(b)) / 2);
}

// One halving of all long edges.
class Halving {
 public:
  Halving(TriangleMesh& mesh, double longest_edge) : mesh_(mesh), longest_(longest_edge) {}

  bool split() {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> materials;
    bool any = false;
    for (std::size_t t = 0; t < mesh_.triangleCount(); ++t) {
      const std::size_t before = triangles.size();
      any = splitTriangle(mesh_.triangles[t], triangles) || any;
      if (!mesh_.triangle_materials.empty())
        materials.insert(materials.end(), triangles.size() - before, mesh_.triangle_materials[t]);
    }
    mesh_.triangles = std::move(triangles);
    mesh_.triangle_materials = std::move(materials);
    return any;
  }

 private:
  // Not by rounding that may differ between two copies of an edge.
  bool isLong(std::uint32_t a, std::uint32_t b) const {
    return (vec3(mesh_.positions[a]) - vec3(mesh_.positions[b])).norm() > longest_ * (1 + 1e-5);
  }

  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const auto [first, last] = std::minmax(a, b);
    const std::uint64_t key = static_cast<std::uint64_t>(first) << 32 | last;
    const auto [found, is_new] = middles_.try_emplace(key, static_cast<std::uint32_t>(mesh_.vertexCount()));
    if (!is_new) return found->second;
    mesh_.positions.push_back(mean(mesh_.positions[first], mesh_.positions[last]));
    if (!mesh_.normals.empty()) {
      const Vec3 sum = vec3(mesh_.normals[first]) + vec3(mesh_.normals[last]);
      mesh_.normals.push_back(sum.norm() > 0 ? transport::float3(sum.normalized())
                                             : Float3(mesh_.normals[first]));
    }
    if (!mesh_.colors.empty()) mesh_.colors.push_back(mean(mesh_.colors[first], mesh_.colors[last]));
    if (!mesh_.texcoords.empty()) {
      const auto &p = mesh_.texcoords[first], &q = mesh_.texcoords[last];
      mesh_.texcoords.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2});
    }
    return found->second;
  }

  bool splitTriangle(Triangle triangle, std::vector<Triangle>& into) {
    std::array<bool, 3> is_long;
    int count = 0;
    for (std::size_t i = 0; i < 3; ++i)
      count += (is_long[i] = isLong(triangle[i], triangle[(i + 1) % 3])) ? 1 : 0;
    if (count == 0) {
      into.push_back(triangle);
      return false;
    }
    // Turned so that the odd one out of the edges, or the first long one, is that from a to b.
    std::size_t first = 0;
    const bool odd_is_long = count != 2;
    while (is_long[first] != odd_is_long) ++first;
    const std::uint32_t a = triangle[first], b = triangle[(first + 1) % 3], c = triangle[(first + 2) % 3];
    if (count == 1) {
      const std::uint32_t ab = middle(a, b);
      into.insert(into.end(), {{a, ab, c}, {ab, b, c}});
    } else if (count == 2) {
      const std::uint32_t bc = middle(b, c), ca = middle(c, a);
      into.insert(into.end(), {{c, ca, bc}, {a, b, bc}, {a, bc, ca}});
    } else {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      into.insert(into.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    return true;
  }

  TriangleMesh& mesh_;
  double longest_;
  std::unordered_map<std::uint64_t, std::uint32_t> middles_;
};

}  // namespace

TriangleMesh subdivided(const TriangleMesh& mesh, double longest_edge) {
  TriangleMesh finer = mesh;
  while (Halving(finer, longest_edge).split()) {
  }
  return finer;
}

}  // namespace bakelight::patch
