#include "tools/mesomesh/retile/original_surface.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numeric>
#include <utility>

namespace bakelight::mesomesh {
namespace {

double cornerAngle(const CornerMesh& mesh, Side s) {
  const Vec3& at = mesh.positions[mesh.start(s)];
  const Vec3 to_end = mesh.positions[mesh.end(s)] - at, to_apex = mesh.positions[mesh.apex(s)] - at;
  return std::atan2(to_end.cross(to_apex).norm(), to_end.dot(to_apex));
}

}  // namespace

OriginalSurface::OriginalSurface(const surface::WorkingMesh& mesh, double crease_angle_deg,
                                 double min_crease_length)
    : mesh_{CornerMesh(mesh), {}, {}, {}} {
  surface::markCreases(mesh_.mesh, crease_angle_deg, min_crease_length);
  const std::vector<std::uint8_t> is_crease = mesh_.mesh.side_feature;
  features_ = surface::markFeatures(mesh_.mesh, crease_angle_deg, min_crease_length);
  makeNormals(is_crease);
  findRegions(mesh);
  halveCornerEdges();
  findCurves();
  const CornerMesh& all = mesh_.mesh;
  surface_.emplace(transport::SurfaceMesh{all.positions, all.triangles, all.materials});
}

// By sides, as a crease that ends inside of a region parts its triangles' normals there and nowhere else.
void OriginalSurface::makeNormals(const std::vector<std::uint8_t>& is_crease) {
  const CornerMesh& mesh = mesh_.mesh;
  corner_normals_.assign(mesh.opposite.size(), Vec3::Zero());
  const std::vector<Vec3> normals = mesh.normals();
  tbb::parallel_for(std::size_t{0}, mesh.positions.size(), [&](std::size_t v) {
    std::vector<Side> around;
    mesh.forSidesAround(static_cast<std::uint32_t>(v), [&](Side s) { around.push_back(s); });
    if (around.empty()) return;
    std::size_t first = 0;
    while (first < around.size() && is_crease[around[first]] == 0) ++first;
    if (first == around.size()) first = 0;
    for (std::size_t begin = 0; begin < around.size();) {
      const auto side = [&](std::size_t i) { return around[(first + i) % around.size()]; };
      Vec3 sum = Vec3::Zero();
      std::size_t end = begin;
      do {
        sum += cornerAngle(mesh, side(end)) * normals[side(end) / 3];
        ++end;
      } while (end < around.size() && is_crease[side(end)] == 0);
      const double length = sum.norm();
      for (std::size_t i = begin; i < end; ++i)
        corner_normals_[side(i)] = length > 1e-12 ? Vec3(sum / length) : normals[side(i) / 3];
      begin = end;
    }
  });
}

void OriginalSurface::findRegions(const surface::WorkingMesh& original) {
  CornerMesh& mesh = mesh_.mesh;
  std::vector<std::uint32_t> region(mesh.triangles.size(), kNone), stack;
  for (std::uint32_t seed = 0; seed < region.size(); ++seed) {
    if (region[seed] != kNone) continue;
    const auto id = static_cast<std::uint32_t>(region_materials_.size());
    region_materials_.push_back(original.materials.empty() ? 0 : original.materials[seed]);
    stack.assign(1, seed);
    region[seed] = id;
    while (!stack.empty()) {
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (Side s = 3 * t; s < 3 * t + 3; ++s) {
        if (mesh.side_feature[s] != 0 || region[mesh.opposite[s] / 3] != kNone) continue;
        region[mesh.opposite[s] / 3] = id;
        stack.push_back(mesh.opposite[s] / 3);
      }
    }
  }
  mesh.materials = std::move(region);
}

void OriginalSurface::halveCornerEdges() {
  CornerMesh& mesh = mesh_.mesh;
  // A split moves the sides after it into the triangles it adds.
  for (Side s = 0; s < mesh.opposite.size(); ++s) {
    if (mesh.side_feature[s] == 0 || !mesh.isEdge(s)) continue;
    const std::uint32_t a = mesh.start(s), b = mesh.end(s);
    if (mesh.locked[a] == 0 || mesh.locked[b] == 0) continue;
    const Side other = mesh.opposite[s];
    const auto added_first = static_cast<std::uint32_t>(mesh.triangles.size());
    mesh.splitEdge(s, (mesh.positions[a] + mesh.positions[b]) / 2);
    // The corner normals move along: start → new vertex → end, and the new inner edge to the apex.
    corner_normals_.resize(mesh.opposite.size());
    const auto carry = [&](Side kept, std::uint32_t added) {
      const Side to_apex = nextSide(kept);
      const Vec3 at_start = corner_normals_[kept], at_end = corner_normals_[to_apex],
                 at_apex = corner_normals_[previousSide(kept)];
      const Vec3 between = at_start + at_end;
      const Vec3 middle = between.norm() > 0 ? Vec3(between.normalized()) : at_start;
      corner_normals_[to_apex] = middle;
      corner_normals_[3 * added] = middle;
      corner_normals_[3 * added + 1] = at_end;
      corner_normals_[3 * added + 2] = at_apex;
    };
    carry(s, added_first);
    if (other != kNone) carry(other, added_first + 1);
  }
}

void OriginalSurface::findCurves() {
  const CornerMesh& mesh = mesh_.mesh;
  mesh_.curve.assign(mesh.positions.size(), kNone);
  mesh_.near.assign(mesh.positions.size(), 0);
  mesh_.segment.assign(mesh.positions.size(), 0);
  for (Side s = 0; s < mesh.opposite.size(); ++s) mesh_.near[mesh.start(s)] = s / 3;
  // Vertices that features join, without passing a corner.
  std::vector<std::vector<std::uint32_t>> next(mesh.positions.size());
  std::vector<Side> edges;
  for (Side s = 0; s < mesh.opposite.size(); ++s) {
    if (mesh.side_feature[s] == 0 || !mesh.isEdge(s)) continue;
    edges.push_back(s);
    const std::uint32_t a = mesh.start(s), b = mesh.end(s);
    if (mesh.locked[a] != 0 || mesh.locked[b] != 0) continue;
    next[a].push_back(b), next[b].push_back(a);
  }
  std::uint32_t count = 0;
  std::vector<std::uint32_t> stack;
  for (std::uint32_t v = 0; v < next.size(); ++v) {
    if (mesh.feature[v] == 0 || mesh.locked[v] != 0 || mesh_.curve[v] != kNone) continue;
    stack.assign(1, v);
    mesh_.curve[v] = count;
    while (!stack.empty()) {
      const std::uint32_t at = stack.back();
      stack.pop_back();
      for (const std::uint32_t to : next[at]) {
        if (mesh_.curve[to] != kNone) continue;
        mesh_.curve[to] = count;
        stack.push_back(to);
      }
    }
    ++count;
  }
  if (edges.empty()) return;
  // Segments are triangles without area to the query, which takes them as such.
  transport::SurfaceMesh segments;
  segments.positions = mesh.positions;
  for (const Side s : edges) {
    const std::uint32_t a = mesh.start(s), b = mesh.end(s);
    mesh_.segment[a] = mesh_.segment[b] = static_cast<std::uint32_t>(segments.triangles.size());
    segments.triangles.push_back({a, b, b});
    segments.materials.push_back(mesh_.curve[mesh.locked[a] != 0 ? b : a]);
  }
  curves_.emplace(std::move(segments));
}

ClosestPoint OriginalSurface::onRegion(const Vec3& position, const Vec3& normal, std::uint32_t region,
                                       std::uint32_t near_triangle) const {
  return surface_->closestFacing(position, normal, region, near_triangle);
}

ClosestPoint OriginalSurface::onCurve(const Vec3& position, std::uint32_t curve,
                                      std::uint32_t near_segment) const {
  return curves_->closest(position, curve, near_segment);
}

Vec3 OriginalSurface::normalAt(std::uint32_t triangle, const Vec3& barycentric) const {
  Vec3 sum = Vec3::Zero();
  for (std::uint32_t k = 0; k < 3; ++k) sum += barycentric[k] * corner_normals_[3 * triangle + k];
  const double length = sum.norm();
  return length > 1e-6 ? Vec3(sum / length) : triangleNormal(triangle);
}

}  // namespace bakelight::mesomesh
