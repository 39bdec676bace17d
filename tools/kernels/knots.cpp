#include "tools/kernels/knots.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "transport/mesh_topology.h"

namespace bakelight::kernels {
namespace {

void countUp(std::vector<std::uint32_t>& ends) {
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
}

}  // namespace

Knots knotsOf(const formats::TriangleMesh& mesh) {
  Knots knots;
  const std::vector<std::uint32_t> places = transport::coincidentVertices(mesh);
  knots.of_vertex.resize(places.size());
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (places[v] == v) {
      knots.of_vertex[v] = static_cast<std::uint32_t>(knots.positions.size());
      knots.positions.push_back(transport::vec3(mesh.positions[v]));
    } else {
      knots.of_vertex[v] = knots.of_vertex[places[v]];
    }
  }
  const std::size_t count = knots.count();
  for (const formats::Triangle& t : mesh.triangles)
    knots.triangles.push_back({knots.of_vertex[t[0]], knots.of_vertex[t[1]], knots.of_vertex[t[2]]});

  knots.areas.assign(count, 0);
  std::vector<std::vector<std::uint32_t>> around(count);
  knots.fan_ends.assign(count, 0);
  for (const auto& t : knots.triangles) {
    const Vec3& a = knots.positions[t[0]];
    const double area = (knots.positions[t[1]] - a).cross(knots.positions[t[2]] - a).norm() / 2;
    knots.triangle_areas.push_back(area);
    for (const std::uint32_t k : t) {
      knots.areas[k] += area / 3;
      ++knots.fan_ends[k];
      for (const std::uint32_t other : t)
        if (other != k) around[k].push_back(other);
    }
  }
  countUp(knots.fan_ends);
  knots.fans.resize(3 * knots.triangles.size());
  std::vector<std::uint32_t> next(count);
  for (std::size_t k = 1; k < count; ++k) next[k] = knots.fan_ends[k - 1];
  for (std::size_t t = 0; t < knots.triangles.size(); ++t)
    for (const std::uint32_t k : knots.triangles[t]) knots.fans[next[k]++] = static_cast<std::uint32_t>(t);

  for (std::size_t k = 0; k < count; ++k) {
    std::sort(around[k].begin(), around[k].end());
    around[k].erase(std::unique(around[k].begin(), around[k].end()), around[k].end());
    double squares = 0;
    knots.rings.push_back(static_cast<std::uint32_t>(k));
    for (const std::uint32_t other : around[k]) {
      squares += (knots.positions[other] - knots.positions[k]).squaredNorm();
      knots.rings.push_back(other);
    }
    knots.ring_ends.push_back(static_cast<std::uint32_t>(knots.rings.size()));
    knots.spacings.push_back(
        around[k].empty() ? 0
                          : static_cast<float>(std::sqrt(squares / static_cast<double>(around[k].size()))));
  }

  // Of hats over a triangle of area A, the mass matrix has A/6 on its diagonal and A/12 beside it.
  knots.sharpening.assign(knots.rings.size(), 0);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t first = k == 0 ? 0 : knots.ring_ends[k - 1];
    const auto ring = knots.ring(k);
    std::vector<double> mass(ring.size(), 0);
    for (const std::uint32_t t : knots.fan(k))
      for (const std::uint32_t other : knots.triangles[t]) {
        const auto place = static_cast<std::size_t>(
            other == k ? 0 : std::lower_bound(ring.begin() + 1, ring.end(), other) - ring.begin());
        mass[place] += knots.triangle_areas[t] / (other == k ? 6 : 12);
      }
    // A fan that meets itself names a corner twice.
    const double sum = std::accumulate(mass.begin(), mass.end(), 0.0);
    for (std::size_t i = 0; i < ring.size(); ++i)
      knots.sharpening[first + i] =
          static_cast<float>((i == 0 ? 1.5 : 0) - (sum > 0 ? mass[i] / sum : i == 0) / 2);
  }
  return knots;
}

double Knots::meanSpacing() const {
  double squares = 0;
  for (const float spacing : spacings) squares += static_cast<double>(spacing) * spacing;
  return std::sqrt(squares / static_cast<double>(count()));
}

}  // namespace bakelight::kernels
