#include "tools/inspect/mesh_figures.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>
#include <numeric>

#include "transport/vector_types.h"

namespace bakelight::inspect {

using formats::Float3;
using formats::Triangle;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::uint32_t find(std::uint32_t element) {
    while (parent_[element] != element) element = parent_[element] = parent_[parent_[element]];
    return element;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }
  // Of the sets that the marked elements belong to.
  std::uint64_t count(const std::vector<bool>& marked) {
    std::vector<bool> counted(parent_.size());
    std::uint64_t sets = 0;
    for (std::uint32_t i = 0; i < parent_.size(); ++i) {
      if (!marked[i] || counted[find(i)]) continue;
      counted[find(i)] = true;
      ++sets;
    }
    return sets;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// One side of a triangle, by its ends in ascending order.
struct Side {
  std::uint32_t low, high;
  bool ascending;  // the triangle runs from low to high

  bool sameEdge(const Side& other) const { return low == other.low && high == other.high; }
};

double areaOf(const TriangleMesh& mesh, const Triangle& t) {
  const Vec3 a = vec3(mesh.positions[t[0]]);
  return 0.5 * (vec3(mesh.positions[t[1]]) - a).cross(vec3(mesh.positions[t[2]]) - a).norm();
}

double smallestAngleDeg(const TriangleMesh& mesh, const Triangle& t) {
  double smallest_rad = std::numbers::pi;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const Vec3 apex = vec3(mesh.positions[t[corner]]);
    const Vec3 a = vec3(mesh.positions[t[(corner + 1) % 3]]) - apex;
    const Vec3 b = vec3(mesh.positions[t[(corner + 2) % 3]]) - apex;
    smallest_rad = std::min(smallest_rad, std::atan2(a.cross(b).norm(), a.dot(b)));
  }
  return smallest_rad * 180 / std::numbers::pi;
}

void measureBounds(const TriangleMesh& mesh, MeshFigures& figures) {
  if (mesh.positions.empty()) return;
  figures.minimum = figures.maximum = mesh.positions.front();
  for (const Float3& position : mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      figures.minimum[axis] = std::min(figures.minimum[axis], position[axis]);
      figures.maximum[axis] = std::max(figures.maximum[axis], position[axis]);
    }
  }
  figures.diagonal = (vec3(figures.maximum) - vec3(figures.minimum)).norm();
}

void measureNormals(const TriangleMesh& mesh, MeshFigures& figures) {
  figures.has_normals = !mesh.normals.empty();
  figures.has_texcoords = !mesh.texcoords.empty();
  figures.has_colors = !mesh.colors.empty();
  for (const Float3& normal : mesh.normals)
    figures.normal_length_error = std::max(figures.normal_length_error, std::abs(vec3(normal).norm() - 1));
}

void measureMaterials(const TriangleMesh& mesh, MeshFigures& figures) {
  figures.materials.resize(mesh.material_names.size());
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    MeshFigures::Material& material = figures.materials[mesh.triangle_materials[t]];
    ++material.triangles;
    material.area += areaOf(mesh, mesh.triangles[t]);
  }
}

// Triangles with an area, by the first vertex at each corner's position.
std::vector<Triangle> measureTriangles(const TriangleMesh& mesh, const std::vector<std::uint32_t>& first,
                                       MeshFigures& figures) {
  std::vector<Triangle> sound;
  for (const Triangle& t : mesh.triangles) {
    const Triangle welded = {first[t[0]], first[t[1]], first[t[2]]};
    const double area = areaOf(mesh, t);
    const bool repeated = welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0];
    if (repeated || !(area > 0)) {
      ++figures.degenerate_triangles;
      continue;
    }
    figures.area += area;
    figures.smallest_angle_deg.add(smallestAngleDeg(mesh, t));
    sound.push_back(welded);
  }
  return sound;
}

std::vector<Side> sidesOf(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t from = t[corner], to = t[(corner + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return std::tie(a.low, a.high) < std::tie(b.low, b.high); });
  return sides;
}

void measureTopology(const TriangleMesh& mesh, const std::vector<Triangle>& triangles, MeshFigures& figures) {
  const std::vector<Side> sides = sidesOf(triangles);
  DisjointSets surfaces(mesh.vertexCount()), borders(mesh.vertexCount());
  std::vector<bool> used(mesh.vertexCount()), on_border(mesh.vertexCount());
  for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
    while (next < sides.size() && sides[next].sameEdge(sides[i])) ++next;
    const Side& side = sides[i];
    ++figures.edges;
    figures.edge_length.add((vec3(mesh.positions[side.high]) - vec3(mesh.positions[side.low])).norm());
    used[side.low] = used[side.high] = true;
    surfaces.join(side.low, side.high);
    if (next - i > 2) ++figures.non_manifold_edges;
    if (next - i == 2 && side.ascending == sides[i + 1].ascending) ++figures.misoriented_edges;
    if (next - i == 1) {
      ++figures.border_edges;
      on_border[side.low] = on_border[side.high] = true;
      borders.join(side.low, side.high);
    }
  }
  figures.components = surfaces.count(used);
  figures.borders = borders.count(on_border);
  figures.closed = !triangles.empty() && figures.border_edges == 0 && figures.non_manifold_edges == 0;
  figures.euler_characteristic = std::count(used.begin(), used.end(), true) -
                                 static_cast<std::int64_t>(figures.edges) +
                                 static_cast<std::int64_t>(triangles.size());
}

// By the divergence theorem, about the box's centre so that a far origin costs no digits.
double enclosedVolume(const TriangleMesh& mesh, const MeshFigures& figures) {
  const Vec3 center = 0.5 * (vec3(figures.minimum) + vec3(figures.maximum));
  double volume = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = vec3(mesh.positions[t[0]]) - center, b = vec3(mesh.positions[t[1]]) - center;
    volume += a.dot(b.cross(vec3(mesh.positions[t[2]]) - center)) / 6;
  }
  return volume;
}

}  // namespace

std::vector<std::uint32_t> firstVertexAtPosition(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertexCount()), first(mesh.vertexCount());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(mesh.positions[a], a) < std::tie(mesh.positions[b], b);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool repeats = i > 0 && mesh.positions[order[i]] == mesh.positions[order[i - 1]];
    first[order[i]] = repeats ? first[order[i - 1]] : order[i];
  }
  return first;
}

MeshFigures measureMesh(const TriangleMesh& mesh) {
  MeshFigures figures;
  figures.vertices = mesh.vertexCount();
  figures.triangles = mesh.triangleCount();
  measureBounds(mesh, figures);
  measureNormals(mesh, figures);
  measureMaterials(mesh, figures);

  const std::vector<std::uint32_t> first = firstVertexAtPosition(mesh);
  for (std::uint32_t i = 0; i < first.size(); ++i)
    if (first[i] == i) ++figures.distinct_positions;
  std::vector<bool> in_triangle(mesh.vertexCount());
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t vertex : t) in_triangle[vertex] = true;
  figures.isolated_vertices =
      static_cast<std::uint64_t>(std::count(in_triangle.begin(), in_triangle.end(), false));

  measureTopology(mesh, measureTriangles(mesh, first, figures), figures);
  if (figures.closed) figures.volume = enclosedVolume(mesh, figures);
  return figures;
}

}  // namespace bakelight::inspect
