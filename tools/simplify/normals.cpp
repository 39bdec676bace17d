#include "tools/simplify/normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/simplify/features.h"
#include "tools/simplify/half_edge_mesh.h"

namespace bakelight::simplify {
namespace {

bool isCrease(const HalfEdgeMesh& mesh, HalfedgeHandle h) {
  return mesh.status(mesh.edge_handle(h)).feature();
}

// Triangles around a vertex, counter-clockwise, each as the half-edge leaving the vertex.
using Fan = std::vector<HalfedgeHandle>;

// Parted at creases.
std::vector<Fan> smoothFans(const HalfEdgeMesh& mesh, VertexHandle vertex) {
  Fan around;
  for (const auto h : mesh.voh_ccw_range(vertex)) around.push_back(h);
  std::size_t first = 0;  // begin at a crease, if there is one
  while (first < around.size() && !isCrease(mesh, around[first])) ++first;
  const bool any_crease = first < around.size();
  std::vector<Fan> fans;
  for (std::size_t i = 0; i < around.size(); ++i) {
    const HalfedgeHandle h = around[(any_crease ? first + i : i) % around.size()];
    if (fans.empty() || (isCrease(mesh, h) && !fans.back().empty())) fans.emplace_back();
    if (!mesh.is_boundary(h)) fans.back().push_back(h);
  }
  if (fans.back().empty()) fans.pop_back();
  return fans;
}

formats::Float3 fanNormal(const HalfEdgeMesh& mesh, const Fan& fan) {
  Point sum(0, 0, 0);
  for (const HalfedgeHandle h : fan) {
    const Point u = mesh.calc_edge_vector(h), v = -mesh.calc_edge_vector(mesh.prev_halfedge_handle(h));
    sum += mesh.normal(mesh.face_handle(h)) * std::atan2((u % v).norm(), u | v);
  }
  const double length = sum.norm();
  if (!(length > 0)) return {0, 1, 0};
  return transport::float3(vec3(sum / length));
}

// The parts of a fan that have one material each, in the order in which they begin.
std::vector<Fan> byMaterial(const HalfEdgeMesh& mesh, const Fan& fan) {
  const auto material = [&](HalfedgeHandle h) { return mesh.data(mesh.face_handle(h)).material; };
  std::vector<Fan> parts;
  for (const HalfedgeHandle h : fan) {
    auto part = std::find_if(parts.begin(), parts.end(),
                             [&](const Fan& other) { return material(other.front()) == material(h); });
    if (part == parts.end()) part = parts.emplace(parts.end());
    part->push_back(h);
  }
  return parts;
}

void giveOwnVertex(const HalfEdgeMesh& mesh, const Fan& fan, std::uint32_t vertex,
                   const formats::Float3& normal, formats::TriangleMesh& result) {
  const auto copy = static_cast<std::uint32_t>(result.positions.size());
  result.positions.push_back(formats::Float3(result.positions[vertex]));
  result.normals.push_back(normal);
  for (const HalfedgeHandle h : fan) {
    Triangle& triangle = result.triangles[static_cast<std::size_t>(mesh.face_handle(h).idx())];
    for (std::uint32_t& index : triangle) index = index == vertex ? copy : index;
  }
}

}  // namespace

ShadedMesh withNormals(const WorkingMesh& working, double crease_angle_deg, double min_crease_length) {
  HalfEdgeMesh mesh = halfEdgeMesh(working);
  mesh.update_face_normals();
  markCreases(mesh, crease_angle_deg, min_crease_length);
  ShadedMesh shaded;
  formats::TriangleMesh& result = shaded.mesh;
  result.triangles = working.triangles;
  result.triangle_materials = working.materials;
  for (const Vec3& position : working.positions) result.positions.push_back(transport::float3(position));
  result.normals.resize(result.positions.size());
  for (const auto vertex : mesh.vertices()) {
    const auto fans = smoothFans(mesh, vertex);
    const auto original = static_cast<std::uint32_t>(vertex.idx());
    for (std::size_t k = 0; k < fans.size(); ++k) {
      const formats::Float3 normal = fanNormal(mesh, fans[k]);
      const std::vector<Fan> parts = byMaterial(mesh, fans[k]);
      for (std::size_t m = 0; m < parts.size(); ++m) {
        if (k == 0 && m == 0) {
          result.normals[original] = normal;
          continue;
        }
        ++(m == 0 ? shaded.split_vertices : shaded.material_vertices);
        giveOwnVertex(mesh, parts[m], original, normal, result);
      }
    }
  }
  return shaded;
}

}  // namespace bakelight::simplify
