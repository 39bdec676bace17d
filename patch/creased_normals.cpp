#include "patch/creased_normals.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::patch {
namespace {

using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

// Numbers places, modulo the periods.
class Places {
 public:
  Places(double period_x, double period_y)
      : period_x_(period_x), period_y_(period_y), cell_(1e-6 * std::max(period_x, period_y)) {}

  std::uint32_t numberOf(const Vec3& position) {
    const Vec3 place(wrapped(position.x(), period_x_), wrapped(position.y(), period_y_), position.z());
    // One that lies beside the cell's wall, or the period's, is found from the next cell.
    for (int k = 0; k < 27; ++k) {
      const Vec3 shifted = place + cell_ * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const auto found = cells_.find(keyOf(shifted));
      if (found != cells_.end()) return found->second;
    }
    const auto number = static_cast<std::uint32_t>(cells_.size());
    cells_.emplace(keyOf(place), number);
    return number;
  }

 private:
  static double wrapped(double at, double period) { return at - period * std::floor(at / period); }
  std::uint64_t keyOf(const Vec3& place) const {
    std::uint64_t key = 0;
    const Vec3 inside(wrapped(place.x(), period_x_), wrapped(place.y(), period_y_), place.z());
    for (int c = 0; c < 3; ++c)
      key = key * 0x9e3779b97f4a7c15ULL +
            static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(inside[c] / cell_)));
    return key;
  }

  double period_x_, period_y_, cell_;
  std::unordered_map<std::uint64_t, std::uint32_t> cells_;
};

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
  Places places(period_x, period_y);
  std::vector<std::uint32_t> place(mesh.vertexCount());
  for (std::size_t v = 0; v < place.size(); ++v) place[v] = places.numberOf(vec3(mesh.positions[v]));
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
