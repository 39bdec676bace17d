#include "surface/inside_out.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>
#include <utility>

namespace bakelight::surface {
namespace {

using Index = std::uint32_t;

// Vertices of a component that are asked whether they lie inside of another: one alone could lie on it.
constexpr std::size_t kProbes = 8;

struct Shell {
  std::vector<Index> triangles;
  double volume = 0;  // signed
  Eigen::AlignedBox3d box;
};

std::vector<Shell> shells(const WorkingMesh& mesh, const Components& components) {
  std::vector<Shell> result(components.count());
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    Shell& shell = result[components.of_triangle[t]];
    shell.triangles.push_back(t);
    for (int k = 0; k < 3; ++k) shell.box.extend(mesh.corner(t, k));
    // About the component's own first vertex: far from the origin the sum would cancel.
    const Vec3& origin = mesh.corner(shell.triangles.front(), 0);
    shell.volume += (mesh.corner(t, 0) - origin).dot(mesh.areaVector(t)) / 6;
  }
  return result;
}

// How many times `shell` winds around the point; solid angles after Van Oosterom & Strackee 1983, eq. 8.
double windingNumber(const WorkingMesh& mesh, const Shell& shell, const Vec3& point) {
  double solid_angle_sr = 0;
  for (const Index t : shell.triangles) {
    const Vec3 a = mesh.corner(t, 0) - point, b = mesh.corner(t, 1) - point, c = mesh.corner(t, 2) - point;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    solid_angle_sr +=
        2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return solid_angle_sr / (4 * std::numbers::pi);
}

bool liesInside(const WorkingMesh& mesh, const Shell& inner, const Shell& outer) {
  if (!outer.box.contains(inner.box)) return false;
  const std::size_t probes = std::min(kProbes, inner.triangles.size());
  double sum = 0;
  for (std::size_t i = 0; i < probes; ++i) {
    const Index t = inner.triangles[i * inner.triangles.size() / probes];
    sum += std::abs(windingNumber(mesh, outer, mesh.corner(t, 0)));
  }
  return sum >= 0.5 * static_cast<double>(probes);
}

}  // namespace

std::int64_t turnInsideOutComponents(WorkingMesh& mesh, const Components& components) {
  const std::vector<Shell> all = shells(mesh, components);
  const auto negative = [&](std::size_t i) { return components.closed[i] && all[i].volume < 0; };
  std::size_t first = 0;
  while (first < all.size() && !negative(first)) ++first;
  if (first == all.size()) return 0;

  // Shells that hold the same one hold each other, so the largest of them is the outermost.
  const auto outermost = [&](std::size_t i) {
    std::size_t result = i;
    for (std::size_t j = 0; j < all.size(); ++j) {
      if (j == i || !components.closed[j] || std::abs(all[j].volume) <= std::abs(all[result].volume))
        continue;
      if (liesInside(mesh, all[i], all[j])) result = j;
    }
    return result;
  };
  std::int64_t turned = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!components.closed[i] || !negative(outermost(i))) continue;
    ++turned;
    for (const Index t : all[i].triangles) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
  return turned;
}

}  // namespace bakelight::surface
