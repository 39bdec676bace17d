#include "tools/simplify/features.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace bakelight::simplify {
namespace {

// A feature line that turns by more than this at a vertex has a corner there.
const double kCornerCosine = std::cos(45 * std::numbers::pi / 180);

double cosineOf(double angle_deg) {
  return std::cos(angle_deg * std::numbers::pi / 180);
}

bool isFeature(const HalfEdgeMesh& mesh, EdgeHandle edge) {
  return mesh.status(edge).feature();
}

// The feature edges that hang together with `seed`, each marked in `seen`.
std::vector<EdgeHandle> connectedFeatures(const HalfEdgeMesh& mesh, EdgeHandle seed,
                                          std::vector<bool>& seen) {
  std::vector<EdgeHandle> line = {seed};
  seen[static_cast<std::size_t>(seed.idx())] = true;
  for (std::size_t next = 0; next < line.size(); ++next) {
    const HalfedgeHandle h = mesh.halfedge_handle(line[next], 0);
    for (const VertexHandle vertex : {mesh.from_vertex_handle(h), mesh.to_vertex_handle(h)}) {
      for (const auto edge : mesh.ve_range(vertex)) {
        if (!isFeature(mesh, edge) || seen[static_cast<std::size_t>(edge.idx())]) continue;
        seen[static_cast<std::size_t>(edge.idx())] = true;
        line.push_back(edge);
      }
    }
  }
  return line;
}

void unmarkNoise(HalfEdgeMesh& mesh, double min_length) {
  std::vector<bool> seen(mesh.n_edges());
  for (const auto edge : mesh.edges()) {
    if (!isFeature(mesh, edge) || seen[static_cast<std::size_t>(edge.idx())]) continue;
    const std::vector<EdgeHandle> line = connectedFeatures(mesh, edge, seen);
    double length = 0;
    for (const EdgeHandle e : line) length += mesh.calc_edge_length(e);
    if (length >= min_length) continue;
    for (const EdgeHandle e : line) mesh.status(e).set_feature(mesh.is_boundary(e));
  }
}

bool isCrease(const HalfEdgeMesh& mesh, EdgeHandle edge, double crease_cosine) {
  if (mesh.is_boundary(edge)) return false;
  const HalfedgeHandle h = mesh.halfedge_handle(edge, 0);
  return (mesh.normal(mesh.face_handle(h)) | mesh.normal(mesh.opposite_face_handle(h))) < crease_cosine;
}

// Lines between materials follow the edges of the input's triangles and may turn at each of them, which is no
// corner: the planes that decimation puts on them say what a turn is worth.
bool isCorner(const HalfEdgeMesh& mesh, const std::vector<HalfedgeHandle>& features, double crease_cosine) {
  if (features.size() != 2) return !features.empty();
  const bool only_materials = std::all_of(features.begin(), features.end(), [&](HalfedgeHandle h) {
    const EdgeHandle edge = mesh.edge_handle(h);
    return isMaterialBorder(mesh, edge) && !isCrease(mesh, edge, crease_cosine);
  });
  const auto direction = [&](HalfedgeHandle h) { return mesh.calc_edge_vector(h).normalize_cond(); };
  return !only_materials && !((direction(features[0]) | direction(features[1])) < -kCornerCosine);
}

void markVertices(HalfEdgeMesh& mesh, double crease_cosine) {
  for (const auto vertex : mesh.vertices()) {
    std::vector<HalfedgeHandle> features;
    for (const auto h : mesh.voh_range(vertex)) {
      if (isFeature(mesh, mesh.edge_handle(h))) features.push_back(h);
    }
    mesh.status(vertex).set_feature(!features.empty());
    mesh.status(vertex).set_locked(isCorner(mesh, features, crease_cosine));
  }
}

}  // namespace

void markCreases(HalfEdgeMesh& mesh, double crease_angle_deg, double min_length) {
  const double crease_cosine = cosineOf(crease_angle_deg);
  for (const auto edge : mesh.edges())
    mesh.status(edge).set_feature(mesh.is_boundary(edge) || isCrease(mesh, edge, crease_cosine));
  unmarkNoise(mesh, min_length);
}

FeatureCounts markFeatures(HalfEdgeMesh& mesh, double crease_angle_deg, double min_length) {
  markCreases(mesh, crease_angle_deg, min_length);
  FeatureCounts counts;
  for (const auto edge : mesh.edges()) {
    counts.crease_edges += isFeature(mesh, edge) && !mesh.is_boundary(edge);
    if (!isMaterialBorder(mesh, edge)) continue;
    mesh.status(edge).set_feature(true);
    ++counts.material_edges;
  }
  markVertices(mesh, cosineOf(crease_angle_deg));
  for (const auto vertex : mesh.vertices()) counts.corners += mesh.status(vertex).locked();
  return counts;
}

void releaseCreases(HalfEdgeMesh& mesh) {
  for (const auto edge : mesh.edges())
    mesh.status(edge).set_feature(mesh.is_boundary(edge) || isMaterialBorder(mesh, edge));
  for (const auto vertex : mesh.vertices()) {
    int borders = 0;  // between materials
    for (const auto edge : mesh.ve_range(vertex)) borders += isMaterialBorder(mesh, edge);
    mesh.status(vertex).set_feature(mesh.is_boundary(vertex) || borders > 0);
    mesh.status(vertex).set_locked(borders > 0 && (borders != 2 || mesh.is_boundary(vertex)));
  }
}

}  // namespace bakelight::simplify
