#include "tools/simplify/normals.h"

#include <cmath>
#include <vector>

#include "tools/simplify/corner_mesh.h"
#include "tools/simplify/features.h"

namespace bakelight::simplify {
namespace {

// The triangles around a vertex, counter-clockwise, parted at creases; each as its side that leaves the
// vertex.
std::vector<std::vector<Side>> smoothFans(const CornerMesh& mesh, std::uint32_t vertex) {
  std::vector<Side> around;
  mesh.forSidesAround(vertex, [&](Side s) { around.push_back(s); });
  std::size_t first = 0;  // begin at a crease, if there is one; on the border there is one at the start
  while (first < around.size() && mesh.side_feature[around[first]] == 0) ++first;
  const bool any_crease = first < around.size();
  std::vector<std::vector<Side>> fans;
  for (std::size_t i = 0; i < around.size(); ++i) {
    const Side s = around[(any_crease ? first + i : i) % around.size()];
    if (fans.empty() || mesh.side_feature[s] != 0) fans.emplace_back();
    fans.back().push_back(s);
  }
  return fans;
}

formats::Float3 fanNormal(const CornerMesh& mesh, const std::vector<Vec3>& normals,
                          const std::vector<Side>& fan) {
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

}  // namespace

ShadedMesh withNormals(const WorkingMesh& working, double crease_angle_deg, double min_crease_length) {
  CornerMesh mesh(working);
  const std::vector<Vec3> normals = mesh.normals();
  markFeatures(mesh, crease_angle_deg, min_crease_length);
  ShadedMesh shaded;
  formats::TriangleMesh& result = shaded.mesh;
  result.triangles = working.triangles;
  for (const Vec3& position : working.positions) result.positions.push_back(transport::float3(position));
  result.normals.resize(result.positions.size());
  for (std::uint32_t original = 0; original < working.positions.size(); ++original) {
    const auto fans = smoothFans(mesh, original);
    for (std::size_t k = 0; k < fans.size(); ++k) {
      const formats::Float3 normal = fanNormal(mesh, normals, fans[k]);
      if (k == 0) {
        result.normals[original] = normal;
        continue;
      }
      const auto copy = static_cast<std::uint32_t>(result.positions.size());
      result.positions.push_back(formats::Float3(result.positions[original]));
      result.normals.push_back(normal);
      ++shaded.split_vertices;
      for (const Side s : fans[k]) result.triangles[s / 3][s % 3] = copy;
    }
  }
  return shaded;
}

}  // namespace bakelight::simplify
