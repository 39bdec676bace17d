#include "tools/atlas/charts/chart.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace bakelight::atlas {
namespace {

// For each edge of each triangle of the chart the chart's triangle across it, or −1.
std::vector<std::array<std::int32_t, 3>> neighborsWithin(const Surface& surface,
                                                         std::span<const std::uint32_t> triangles) {
  const auto indexOf = [&](std::int32_t triangle) -> std::int32_t {
    if (triangle < 0) return -1;
    const auto it =
        std::lower_bound(triangles.begin(), triangles.end(), static_cast<std::uint32_t>(triangle));
    return it != triangles.end() && *it == static_cast<std::uint32_t>(triangle)
               ? static_cast<std::int32_t>(it - triangles.begin())
               : -1;
  };
  std::vector<std::array<std::int32_t, 3>> result(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) result[i][k] = indexOf(surface.passable(triangles[i], k));
  return result;
}

std::size_t cornerAt(const Triangle& triangle, std::uint32_t place) {
  return triangle[0] == place ? 0 : triangle[1] == place ? 1 : 2;
}

template <class MayPass>
std::vector<std::vector<std::uint32_t>> partsAcross(const Surface& surface, const MayPass& mayPass) {
  std::vector<std::vector<std::uint32_t>> parts;
  std::vector<std::uint8_t> seen(surface.triangleCount(), 0);
  for (std::uint32_t first = 0; first < surface.triangleCount(); ++first) {
    if (seen[first]) continue;
    std::vector<std::uint32_t> part = {first};
    seen[first] = 1;
    for (std::size_t i = 0; i < part.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        if (!mayPass(part[i], k)) continue;
        const std::int32_t other = surface.neighbors[part[i]][k];
        if (std::exchange(seen[other], 1) == 0) part.push_back(static_cast<std::uint32_t>(other));
      }
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace

Chart chartOf(const Surface& surface, std::span<const std::uint32_t> triangles) {
  Chart chart;
  chart.surface_triangles.assign(triangles.begin(), triangles.end());
  const auto neighbors = neighborsWithin(surface, triangles);

  // Corners that share a place and hang together across edges are one vertex.
  std::vector<std::uint32_t> parent(3 * triangles.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto unite = [&](std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent[std::max(a, b)] = std::min(a, b);
  };
  std::int64_t inner_edges_twice = 0, border_edges = 0;
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::int32_t other = neighbors[i][k];
      if (other < 0) {
        ++border_edges;
        continue;
      }
      ++inner_edges_twice;
      if (static_cast<std::uint32_t>(other) < i) continue;
      const Triangle &mine = surface.triangles[triangles[i]], &theirs = surface.triangles[triangles[other]];
      for (const std::uint32_t end : {k, (k + 1) % 3})
        unite(3 * i + end, 3 * static_cast<std::uint32_t>(other) +
                               static_cast<std::uint32_t>(cornerAt(theirs, mine[end])));
    }

  std::vector<std::uint32_t> vertex_of(parent.size());
  chart.triangles.resize(triangles.size());
  for (std::uint32_t corner = 0; corner < parent.size(); ++corner) {
    if (parent[corner] == corner) {
      vertex_of[corner] = static_cast<std::uint32_t>(chart.positions.size());
      const std::uint32_t place = surface.triangles[triangles[corner / 3]][corner % 3];
      chart.places.push_back(place);
      chart.positions.push_back(surface.positions[place]);
    }
    chart.triangles[corner / 3][corner % 3] = vertex_of[root(corner)];
  }
  for (const std::uint32_t triangle : triangles) chart.area += surface.areas[triangle];
  chart.euler_characteristic = static_cast<std::int64_t>(chart.vertexCount()) - inner_edges_twice / 2 -
                               border_edges + static_cast<std::int64_t>(triangles.size());

  // A vertex has one border edge that leaves it, as its triangles are one fan.
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> next(chart.vertexCount(), kNone);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      if (neighbors[i][k] < 0) next[chart.triangles[i][k]] = chart.triangles[i][(k + 1) % 3];
  std::vector<double> lengths;
  for (std::uint32_t start = 0; start < next.size(); ++start) {
    if (next[start] == kNone) continue;
    std::vector<std::uint32_t> loop;
    double length = 0;
    for (std::uint32_t v = start; next[v] != kNone;) {
      loop.push_back(v);
      length += (chart.positions[next[v]] - chart.positions[v]).norm();
      v = std::exchange(next[v], kNone);
    }
    const auto longer = std::find_if(lengths.begin(), lengths.end(), [&](double l) { return l < length; });
    chart.borders.insert(chart.borders.begin() + (longer - lengths.begin()), std::move(loop));
    lengths.insert(longer, length);
  }
  return chart;
}

std::vector<std::vector<std::uint32_t>> connectedParts(const Surface& surface,
                                                       std::span<const std::int32_t> labels) {
  return partsAcross(surface, [&](std::uint32_t triangle, std::size_t k) {
    const std::int32_t other = surface.passable(triangle, k);
    return other >= 0 && labels[other] == labels[triangle];
  });
}

std::vector<std::vector<std::uint32_t>> connectedParts(const Surface& surface,
                                                       std::span<const std::uint32_t> triangles,
                                                       std::span<const std::int32_t> labels) {
  const auto neighbors = neighborsWithin(surface, triangles);
  std::vector<std::vector<std::uint32_t>> parts;
  std::vector<std::uint8_t> seen(triangles.size(), 0);
  for (std::uint32_t first = 0; first < triangles.size(); ++first) {
    if (std::exchange(seen[first], 1) != 0) continue;
    std::vector<std::uint32_t> part = {first};
    for (std::size_t i = 0; i < part.size(); ++i)
      for (const std::int32_t other : neighbors[part[i]])
        if (other >= 0 && labels[other] == labels[first] && std::exchange(seen[other], 1) == 0)
          part.push_back(static_cast<std::uint32_t>(other));
    for (std::uint32_t& index : part) index = triangles[index];
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  return parts;
}

std::vector<std::vector<std::uint32_t>> smoothParts(const Surface& surface) {
  return partsAcross(surface, [&](std::uint32_t triangle, std::size_t k) {
    return surface.neighbors[triangle][k] >= 0 && surface.marks[triangle][k] == EdgeMark::kNone;
  });
}

}  // namespace bakelight::atlas
