#include "tools/atlas/charts/surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "formats/error.h"
#include "transport/mesh_topology.h"

namespace bakelight::atlas {
namespace {

constexpr double kLeastRelativeHeight = 1e-12;

void check(const formats::TriangleMesh& mesh, const std::string& file) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t i : mesh.triangles[t])
      if (i >= mesh.positions.size())
        throw badInput({file, "face " + std::to_string(t), ""},
                       "vertex index " + std::to_string(i) + " is out of range",
                       "an index below " + std::to_string(mesh.positions.size()));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    for (const float x : mesh.positions[v])
      if (!std::isfinite(x))
        throw badInput({file, "vertex " + std::to_string(v), ""}, "a coordinate is not finite");
}

struct EdgeUse {
  std::uint32_t low, high;  // places
  std::uint32_t triangle;
  std::uint8_t edge;
  bool upwards;  // the triangle runs from low to high
};

std::vector<EdgeUse> sortedEdgeUses(const Surface& surface) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangleCount());
  for (std::uint32_t t = 0; t < surface.triangleCount(); ++t)
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return uses;
}

}  // namespace

void findNeighbors(Surface& surface) {
  surface.neighbors.assign(surface.triangleCount(), {-1, -1, -1});
  surface.marks.assign(surface.triangleCount(), {EdgeMark::kNone, EdgeMark::kNone, EdgeMark::kNone});
  const std::vector<EdgeUse> uses = sortedEdgeUses(surface);
  for (std::size_t begin = 0, end; begin < uses.size(); begin = end) {
    end = begin + 1;
    while (end < uses.size() && uses[end].low == uses[begin].low && uses[end].high == uses[begin].high) ++end;
    const EdgeUse &a = uses[begin], &b = uses[end - 1];
    if (end - begin == 1) {
      ++surface.border_edges;
    } else if (end - begin > 2) {
      ++surface.non_manifold_edges;
    } else if (a.upwards == b.upwards) {
      ++surface.misoriented_edges;
    } else {
      surface.neighbors[a.triangle][a.edge] = static_cast<std::int32_t>(b.triangle);
      surface.neighbors[b.triangle][b.edge] = static_cast<std::int32_t>(a.triangle);
    }
  }
}

Surface surfaceOf(const formats::TriangleMesh& mesh, const std::string& file) {
  check(mesh, file);
  Surface surface;
  const std::vector<std::uint32_t> first = transport::coincidentVertices(mesh);
  surface.place_of_vertex.resize(mesh.vertexCount());
  Eigen::AlignedBox3d box;
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    if (first[v] == v) {
      surface.place_of_vertex[v] = static_cast<std::uint32_t>(surface.positions.size());
      surface.positions.push_back(transport::vec3(mesh.positions[v]));
      box.extend(surface.positions.back());
    }
  }
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
    surface.place_of_vertex[v] = surface.place_of_vertex[first[v]];
  if (!box.isEmpty()) surface.center = box.center();
  for (Vec3& position : surface.positions) position -= surface.center;

  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    Triangle places;
    for (std::size_t k = 0; k < 3; ++k) places[k] = surface.place_of_vertex[mesh.triangles[t][k]];
    const Vec3 &a = surface.positions[places[0]], &b = surface.positions[places[1]],
               &c = surface.positions[places[2]];
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    // In units of the longest edge, so that no product underflows however small the triangle.
    const Vec3 relative =
        longest > 0 ? Vec3(((b - a) / longest).cross((c - a) / longest)) : Vec3(Vec3::Zero());
    const double height = relative.norm();
    if (!(height > kLeastRelativeHeight)) {
      ++surface.degenerate_triangles;
      continue;
    }
    surface.triangles.push_back(places);
    surface.source_triangles.push_back(t);
    surface.normals.push_back(relative / height);
    surface.areas.push_back(height / 2 * longest * longest);
    surface.area += surface.areas.back();
  }
  if (surface.triangles.empty() || !(surface.area > 0))
    throw badInput({file, "", ""}, "no triangle of the mesh has an area",
                   "at least one triangle with an area");

  surface.scale = 1 / std::sqrt(surface.area);
  for (Vec3& position : surface.positions) position *= surface.scale;
  for (double& area : surface.areas) area /= surface.area;
  surface.area = 1;
  findNeighbors(surface);
  return surface;
}

std::int64_t markCreases(Surface& surface, double angle_deg) {
  const double least_cosine = std::cos(angle_deg * std::numbers::pi / 180);
  std::int64_t count = 0;
  for (std::size_t t = 0; t < surface.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t other = surface.neighbors[t][k];
      if (other < 0 || surface.normals[t].dot(surface.normals[other]) >= least_cosine) continue;
      surface.marks[t][k] = EdgeMark::kCrease;
      count += static_cast<std::size_t>(other) > t;
    }
  return count;
}

std::int64_t cutEdges(Surface& surface, std::span<const std::array<std::uint32_t, 2>> place_pairs) {
  std::vector<std::array<std::uint32_t, 2>> wanted;
  for (const auto& [a, b] : place_pairs) wanted.push_back({std::min(a, b), std::max(a, b)});
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<std::uint8_t> found(wanted.size(), 0);
  for (std::size_t t = 0; t < surface.triangleCount(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      const std::array<std::uint32_t, 2> edge = {std::min(a, b), std::max(a, b)};
      const auto it = std::lower_bound(wanted.begin(), wanted.end(), edge);
      if (it == wanted.end() || *it != edge) continue;
      surface.marks[t][k] = EdgeMark::kCut;
      found[it - wanted.begin()] = 1;
    }
  return std::count(found.begin(), found.end(), 1);
}

}  // namespace bakelight::atlas
