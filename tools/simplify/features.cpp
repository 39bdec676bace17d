#include "tools/simplify/features.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace bakelight::simplify {
namespace {

// A feature line that turns by more than this at a vertex has a corner there.
const double kCornerCosine = std::cos(45 * std::numbers::pi / 180);

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

void markVertices(HalfEdgeMesh& mesh) {
  for (const auto vertex : mesh.vertices()) {
    std::vector<Point> directions;
    for (const auto h : mesh.voh_range(vertex)) {
      if (isFeature(mesh, mesh.edge_handle(h)))
        directions.push_back(mesh.calc_edge_vector(h).normalize_cond());
    }
    const bool line = directions.size() == 2 && (directions[0] | directions[1]) < -kCornerCosine;
    mesh.status(vertex).set_feature(!directions.empty());
    mesh.status(vertex).set_locked(!directions.empty() && !line);
  }
}

}  // namespace

FeatureCounts markFeatures(HalfEdgeMesh& mesh, double crease_angle_deg, double min_length) {
  const double crease_cosine = std::cos(crease_angle_deg * std::numbers::pi / 180);
  for (const auto edge : mesh.edges()) {
    const HalfedgeHandle h = mesh.halfedge_handle(edge, 0);
    const bool border = mesh.is_boundary(edge);
    const bool crease = !border && (mesh.normal(mesh.face_handle(h)) |
                                    mesh.normal(mesh.opposite_face_handle(h))) < crease_cosine;
    mesh.status(edge).set_feature(border || crease);
  }
  unmarkNoise(mesh, min_length);
  markVertices(mesh);
  FeatureCounts counts;
  for (const auto edge : mesh.edges())
    counts.crease_edges += isFeature(mesh, edge) && !mesh.is_boundary(edge);
  for (const auto vertex : mesh.vertices()) counts.corners += mesh.status(vertex).locked();
  return counts;
}

void releaseCreases(HalfEdgeMesh& mesh) {
  for (const auto edge : mesh.edges()) mesh.status(edge).set_feature(mesh.is_boundary(edge));
  for (const auto vertex : mesh.vertices()) {
    mesh.status(vertex).set_feature(mesh.is_boundary(vertex));
    mesh.status(vertex).set_locked(false);
  }
}

}  // namespace bakelight::simplify
