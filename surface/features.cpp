#include "surface/features.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace bakelight::surface {
namespace {

// A feature line that turns by more than this at a vertex has a corner there.
const double kCornerCosine = std::cos(45 * std::numbers::pi / 180);

void mark(CornerMesh& mesh, Side side, bool is_feature) {
  mesh.side_feature[side] = is_feature;
  if (mesh.opposite[side] != kNone) mesh.side_feature[mesh.opposite[side]] = is_feature;
}

// The feature edges around a vertex, each by one of its sides.
template <class Visit>
void forFeatures(const CornerMesh& mesh, std::uint32_t vertex, Visit visit) {
  mesh.forSidesAround(vertex, [&](Side s) {
    if (mesh.side_feature[s] != 0) visit(s);
    const Side in = previousSide(s);
    if (mesh.opposite[in] == kNone) visit(in);
  });
}

// The feature edges that hang together with `seed`, each marked in `seen` on both sides.
std::vector<Side> connectedFeatures(const CornerMesh& mesh, Side seed, std::vector<bool>& seen) {
  std::vector<Side> line;
  const auto add = [&](Side s) {
    if (seen[s]) return;
    seen[s] = true;
    if (mesh.opposite[s] != kNone) seen[mesh.opposite[s]] = true;
    line.push_back(s);
  };
  add(seed);
  for (std::size_t next = 0; next < line.size(); ++next) {
    const Side s = line[next];
    for (const std::uint32_t vertex : {mesh.start(s), mesh.end(s)}) forFeatures(mesh, vertex, add);
  }
  return line;
}

void unmarkNoise(CornerMesh& mesh, double min_length) {
  std::vector<bool> seen(mesh.opposite.size());
  for (Side s = 0; s < mesh.opposite.size(); ++s) {
    if (mesh.side_feature[s] == 0 || seen[s]) continue;
    const std::vector<Side> line = connectedFeatures(mesh, s, seen);
    double length = 0;
    for (const Side e : line) length += mesh.length(e);
    if (length >= min_length) continue;
    for (const Side e : line) mark(mesh, e, mesh.opposite[e] == kNone);
  }
}

// Lines between materials follow the edges of the input's triangles and may turn at each of them, which is no
// corner: the planes that decimation puts on them say what a turn is worth.
void markVertices(CornerMesh& mesh, double crease_cosine) {
  const auto isCrease = [&](Side s) {
    const Vec3 one = mesh.areaVector(s / 3), two = mesh.areaVector(mesh.opposite[s] / 3);
    const double lengths = one.norm() * two.norm();
    return (lengths > 0 ? one.dot(two) / lengths : 0.0) < crease_cosine;
  };
  tbb::parallel_for(std::size_t{0}, mesh.positions.size(), [&](std::size_t v) {
    const auto vertex = static_cast<std::uint32_t>(v);
    std::array<Vec3, 2> directions;
    std::size_t count = 0;
    bool only_materials = true;
    forFeatures(mesh, vertex, [&](Side s) {
      const std::uint32_t far = mesh.start(s) == vertex ? mesh.end(s) : mesh.start(s);
      if (count < 2) directions[count] = (mesh.positions[far] - mesh.positions[vertex]).normalized();
      ++count;
      only_materials = only_materials && mesh.isMaterialBorder(s) && !isCrease(s);
    });
    const bool line = count == 2 && (only_materials || directions[0].dot(directions[1]) < -kCornerCosine);
    mesh.feature[v] = count > 0;
    mesh.locked[v] = count > 0 && !line;
  });
}

double cosineOf(double angle_deg) {
  return std::cos(angle_deg * std::numbers::pi / 180);
}

}  // namespace

void markCreases(CornerMesh& mesh, double crease_angle_deg, double min_length) {
  const double crease_cosine = cosineOf(crease_angle_deg);
  const std::vector<Vec3> normals = mesh.normals();
  tbb::parallel_for(std::size_t{0}, mesh.opposite.size(), [&](std::size_t s) {
    const Side other = mesh.opposite[s];
    mesh.side_feature[s] = other == kNone || normals[s / 3].dot(normals[other / 3]) < crease_cosine;
  });
  unmarkNoise(mesh, min_length);
}

FeatureCounts markFeatures(CornerMesh& mesh, double crease_angle_deg, double min_length) {
  markCreases(mesh, crease_angle_deg, min_length);
  FeatureCounts counts;
  for (Side s = 0; s < mesh.opposite.size(); ++s) {
    if (mesh.opposite[s] == kNone || s > mesh.opposite[s]) continue;
    counts.crease_edges += mesh.side_feature[s];
    if (!mesh.isMaterialBorder(s)) continue;
    mark(mesh, s, true);
    ++counts.material_edges;
  }
  markVertices(mesh, cosineOf(crease_angle_deg));
  for (const std::uint8_t locked : mesh.locked) counts.corners += locked;
  return counts;
}

void releaseCreases(CornerMesh& mesh) {
  for (Side s = 0; s < mesh.opposite.size(); ++s) {
    if (mesh.alive(s / 3)) mesh.side_feature[s] = mesh.opposite[s] == kNone || mesh.isMaterialBorder(s);
  }
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (mesh.leaving[v] == kNone) continue;
    int borders = 0;  // between materials
    mesh.forSidesAround(v, [&](Side s) { borders += mesh.isMaterialBorder(s); });
    const bool on_border = mesh.isBorder(v);
    mesh.feature[v] = on_border || borders > 0;
    mesh.locked[v] = borders > 0 && (borders != 2 || on_border);
  }
}

}  // namespace bakelight::surface
