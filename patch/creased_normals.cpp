#include "patch/creased_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "patch/periodic_places.h"
#include "transport/vector_types.h"

namespace bakelight::patch {
namespace {

using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

double cornerAngle(const std::array<Vec3, 3>& p, std::size_t i) {
  const Vec3 a = p[(i + 1) % 3] - p[i], b = p[(i + 2) % 3] - p[i];
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

struct Corner {
  std::uint32_t triangle;
  double angle;
};

}  // namespace

TriangleMesh withCreasedNormals(const TriangleMesh& mesh, double period_x, double period_y,
                                double crease_angle_deg) {
  const std::vector<std::uint32_t> place = periodicPlaces(mesh, period_x, period_y);
  std::vector<Vec3> facet(mesh.triangleCount());
  std::vector<std::vector<Corner>> around(mesh.vertexCount());  // by place
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = vec3(mesh.positions[mesh.triangles[t][i]]);
    const Vec3 area = (p[1] - p[0]).cross(p[2] - p[0]);
    facet[t] = area.norm() > 0 ? area.normalized() : Vec3::Zero();
    if (area.norm() == 0) continue;
    for (std::size_t i = 0; i < 3; ++i) around[place[mesh.triangles[t][i]]].push_back({t, cornerAngle(p, i)});
  }

  const double least_cosine = std::cos(crease_angle_deg * std::numbers::pi / 180);
  TriangleMesh creased;
  creased.triangle_materials = mesh.triangle_materials;
  creased.material_names = mesh.material_names;
  creased.triangles.resize(mesh.triangleCount());
  std::vector<std::vector<std::uint32_t>> copies(mesh.vertexCount());
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = mesh.triangles[t][i];
      Vec3 sum = Vec3::Zero();
      for (const Corner& corner : around[place[v]])
        if (facet[corner.triangle].dot(facet[t]) >= least_cosine)
          sum += corner.angle * facet[corner.triangle];
      const formats::Float3 normal =
          transport::float3(sum.norm() > 0 ? sum.normalized().eval() : Vec3(0, 0, 1));
      const auto same = std::find_if(copies[v].begin(), copies[v].end(), [&](std::uint32_t copy) {
        return (vec3(creased.normals[copy]) - vec3(normal)).norm() < 1e-5;
      });
      if (same != copies[v].end()) {
        creased.triangles[t][i] = *same;
        continue;
      }
      const auto copy = static_cast<std::uint32_t>(creased.positions.size());
      copies[v].push_back(copy);
      creased.positions.push_back(mesh.positions[v]);
      creased.normals.push_back(normal);
      if (!mesh.colors.empty()) creased.colors.push_back(mesh.colors[v]);
      creased.triangles[t][i] = copy;
    }
  return creased;
}

}  // namespace bakelight::patch
