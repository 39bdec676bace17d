#include "tools/mesomesh/retile/parted_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "transport/triangle_distance.h"

namespace bakelight::mesomesh {
namespace {

// From a vertex on a feature towards the middle of its triangles on one side: near enough to stay there.
constexpr double kStep = 0.25;

// The fans that features part the triangles around a vertex into, each by its sides from the vertex.
template <class Visit>
void forFans(const CornerMesh& mesh, std::uint32_t v, std::vector<Side>& around, const Visit& visit) {
  around.clear();
  mesh.forSidesAround(v, [&](Side s) { around.push_back(s); });
  const auto first =
      std::find_if(around.begin(), around.end(), [&](Side s) { return mesh.side_feature[s] != 0; });
  if (first != around.end()) std::rotate(around.begin(), first, around.end());
  for (std::size_t begin = 0; begin < around.size();) {
    std::size_t end = begin + 1;
    while (end < around.size() && mesh.side_feature[around[end]] == 0) ++end;
    visit(std::span<const Side>(around).subspan(begin, end - begin));
    begin = end;
  }
}

Vec3 normalOf(const SlidingMesh& sliding, const OriginalSurface& original, std::uint32_t v,
              std::span<const Side> fan) {
  const CornerMesh& mesh = sliding.mesh;
  const Vec3& at = mesh.positions[v];
  Vec3 area = Vec3::Zero(), middle = Vec3::Zero();
  for (const Side s : fan) {
    area += mesh.areaVector(s / 3);
    middle += (mesh.positions[mesh.end(s)] + mesh.positions[mesh.apex(s)]) / 2;
  }
  std::uint32_t triangle = sliding.near[v];
  if (sliding.isOnCurve(v) || sliding.isCorner(v)) {
    const Vec3 inside = at + kStep * (middle / static_cast<double>(fan.size()) - at);
    const Side s = fan.front();
    // Whichever vertex of the fan lies inside of its region knows a triangle of it.
    const ClosestPoint foot = original.surface().closestFacing(inside, area, mesh.materials[s / 3]);
    if (!foot.valid) return area.norm() > 0 ? Vec3(area.normalized()) : Vec3(Vec3::UnitY());
    triangle = foot.triangle;
  }
  const transport::SurfaceMesh& surface = original.surface().mesh();
  return original.normalAt(triangle,
                           transport::closestWeights(surface.corner(triangle, 0), surface.corner(triangle, 1),
                                                     surface.corner(triangle, 2), at));
}

}  // namespace

PartedMesh parted(const SlidingMesh& sliding, const OriginalSurface& original,
                  const std::vector<surface::WorkingMesh::Sheet>& sheets) {
  const CornerMesh& mesh = sliding.mesh;
  const std::size_t vertex_count = mesh.positions.size(), triangle_count = mesh.triangles.size();
  // Each fan is named by one of its sides.
  std::vector<Side> fan_of(3 * triangle_count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertex_count, 1024), [&](const auto& range) {
    std::vector<Side> around;
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      forFans(mesh, static_cast<std::uint32_t>(v), around, [&](std::span<const Side> fan) {
        for (const Side s : fan) fan_of[s] = fan.front();
      });
  });
  PartedMesh result;
  std::vector<std::uint32_t> vertex_of(3 * triangle_count, kNone), source;
  std::vector<Side> fan;
  result.triangles.resize(triangle_count);
  for (Side s = 0; s < 3 * triangle_count; ++s) {
    std::uint32_t& vertex = vertex_of[fan_of[s]];
    if (vertex == kNone) {
      vertex = static_cast<std::uint32_t>(source.size());
      source.push_back(mesh.start(s));
      fan.push_back(fan_of[s]);
    }
    result.triangles[s / 3][s % 3] = vertex;
  }
  const auto materialOf = [&](std::uint32_t triangle) {
    return original.materialOf(mesh.materials[triangle]);
  };
  result.positions.resize(source.size()), result.normals.resize(source.size());
  result.vertex_materials.resize(source.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, source.size(), 1024), [&](const auto& range) {
    std::vector<Side> around;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      result.positions[i] = mesh.positions[source[i]];
      result.vertex_materials[i] = materialOf(fan[i] / 3);
      forFans(mesh, source[i], around, [&](std::span<const Side> sides) {
        if (sides.front() == fan[i]) result.normals[i] = normalOf(sliding, original, source[i], sides);
      });
    }
  });
  result.triangle_materials.resize(triangle_count);
  for (std::uint32_t t = 0; t < triangle_count; ++t) result.triangle_materials[t] = materialOf(t);
  result.crease_copies =
      static_cast<std::int64_t>(source.size()) -
      std::count_if(mesh.leaving.begin(), mesh.leaving.end(), [](Side s) { return s != kNone; });
  if (sheets.empty()) return result;

  // Backs.
  std::vector<std::uint32_t> back(source.size(), kNone);
  for (std::size_t t = 0; t < triangle_count; ++t) {
    if (result.triangle_materials[t] < surface::kFirstSheet) continue;
    formats::Triangle mirrored = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = result.triangles[t][k];
      if (back[v] == kNone) {
        back[v] = static_cast<std::uint32_t>(result.positions.size());
        result.positions.push_back(Vec3(result.positions[v]));
        result.normals.push_back(Vec3(-result.normals[v]));
        result.vertex_materials.push_back(sheets[result.vertex_materials[v] - surface::kFirstSheet].back);
      }
      mirrored[2 - k] = back[v];
    }
    result.triangles.push_back(mirrored);
    result.triangle_materials.push_back(sheets[result.triangle_materials[t] - surface::kFirstSheet].back);
  }
  for (std::vector<std::uint32_t>* materials : {&result.vertex_materials, &result.triangle_materials})
    for (std::uint32_t& m : *materials)
      if (m >= surface::kFirstSheet) m = sheets[m - surface::kFirstSheet].front;
  return result;
}

std::int64_t partedCount(const CornerMesh& mesh, int subdivisions) {
  std::int64_t vertices = 0, edges = 0, triangles = 0, creases = 0;
  for (const Side s : mesh.leaving) vertices += s != kNone;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) triangles += mesh.alive(t);
  for (Side s = 0; s < mesh.opposite.size(); ++s) {
    if (!mesh.isEdge(s)) continue;
    ++edges;
    creases += mesh.side_feature[s] != 0 && mesh.opposite[s] != kNone;
  }
  for (int i = 0; i < subdivisions; ++i) {
    vertices += edges;
    edges = 2 * edges + 3 * triangles;
    triangles *= 4;
    creases *= 2;
  }
  // A line of creases copies about as many vertices as it has edges.
  return vertices + creases;
}

}  // namespace bakelight::mesomesh
