#include "tools/simplify/normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "surface/corner_mesh.h"
#include "surface/features.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

// Triangles around a vertex, counter-clockwise, each as its side that leaves the vertex.
using Fan = std::vector<Side>;

// Parted at creases.
std::vector<Fan> smoothFans(const CornerMesh& mesh, std::uint32_t vertex) {
  Fan around;
  mesh.forSidesAround(vertex, [&](Side s) { around.push_back(s); });
  std::size_t first = 0;  // begin at a crease, if there is one; on the border there is one at the start
  while (first < around.size() && mesh.side_feature[around[first]] == 0) ++first;
  const bool any_crease = first < around.size();
  std::vector<Fan> fans;
  for (std::size_t i = 0; i < around.size(); ++i) {
    const Side s = around[(any_crease ? first + i : i) % around.size()];
    if (fans.empty() || mesh.side_feature[s] != 0) fans.emplace_back();
    fans.back().push_back(s);
  }
  return fans;
}

formats::Float3 fanNormal(const CornerMesh& mesh, const std::vector<Vec3>& normals, const Fan& fan) {
  Vec3 sum = Vec3::Zero();
  for (const Side s : fan) {
    const Vec3& corner = mesh.positions[mesh.start(s)];
    const Vec3 u = mesh.positions[mesh.end(s)] - corner, v = mesh.positions[mesh.apex(s)] - corner;
    sum += normals[s / 3] * std::atan2(u.cross(v).norm(), u.dot(v));
  }
  const double length = sum.norm();
  if (!(length > 0)) return {0, 1, 0};
  return transport::float3(sum / length);
}

// The parts of a fan that have one material each, in the order in which they begin.
std::vector<Fan> byMaterial(const CornerMesh& mesh, const Fan& fan) {
  if (mesh.materials.empty()) return {fan};
  const auto material = [&](Side s) { return mesh.materials[s / 3]; };
  std::vector<Fan> parts;
  for (const Side s : fan) {
    auto part = std::find_if(parts.begin(), parts.end(),
                             [&](const Fan& other) { return material(other.front()) == material(s); });
    if (part == parts.end()) part = parts.emplace(parts.end());
    part->push_back(s);
  }
  return parts;
}

void giveOwnVertex(const Fan& fan, std::uint32_t vertex, const formats::Float3& normal,
                   formats::TriangleMesh& result) {
  const auto copy = static_cast<std::uint32_t>(result.positions.size());
  result.positions.push_back(formats::Float3(result.positions[vertex]));
  result.normals.push_back(normal);
  for (const Side s : fan) result.triangles[s / 3][s % 3] = copy;
}

}  // namespace

ShadedMesh withNormals(const WorkingMesh& working, double crease_angle_deg, double min_crease_length) {
  CornerMesh mesh(working);
  const std::vector<Vec3> normals = mesh.normals();
  markCreases(mesh, crease_angle_deg, min_crease_length);
  ShadedMesh shaded;
  formats::TriangleMesh& result = shaded.mesh;
  result.triangles = working.triangles;
  result.triangle_materials = working.materials;
  for (const Vec3& position : working.positions) result.positions.push_back(transport::float3(position));
  result.normals.resize(result.positions.size());
  for (std::uint32_t original = 0; original < working.positions.size(); ++original) {
    const auto fans = smoothFans(mesh, original);
    for (std::size_t k = 0; k < fans.size(); ++k) {
      const formats::Float3 normal = fanNormal(mesh, normals, fans[k]);
      const std::vector<Fan> parts = byMaterial(mesh, fans[k]);
      for (std::size_t m = 0; m < parts.size(); ++m) {
        if (k == 0 && m == 0) {
          result.normals[original] = normal;
          continue;
        }
        ++(m == 0 ? shaded.split_vertices : shaded.material_vertices);
        giveOwnVertex(parts[m], original, normal, result);
      }
    }
  }
  return shaded;
}

}  // namespace bakelight::simplify
