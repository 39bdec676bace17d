#include "surface/collapse.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bakelight::surface {
namespace {

// Collapsing an edge of length l costs as much as a deviation of this share of l does.
constexpr double kLengthPull = 0.04;
// Weight of the planes that stand on borders and creases, against the surface's own.
constexpr double kFeatureWeight = 10;
const double kMaxTurnCosine = std::cos(60 * std::numbers::pi / 180);
// Beyond this many the neighbours of a vertex are looked up in order.
constexpr std::size_t kFewNeighbors = 32;
// Neighbours that are tried, the cheapest first; a vertex all of whose cheapest are forbidden can wait.
constexpr std::size_t kMaxTries = 16;

bool contains(const Collapses::Workspace& work, std::uint32_t vertex) {
  if (work.neighbors.size() > kFewNeighbors)
    return std::binary_search(work.sorted_neighbors.begin(), work.sorted_neighbors.end(), vertex);
  return std::find(work.neighbors.begin(), work.neighbors.end(), vertex) != work.neighbors.end();
}

}  // namespace

void Collapses::Error::addPlane(const Vec3& n, const Vec3& point, double weight) {
  const double d = -n.dot(point);
  xx += weight * n.x() * n.x(), xy += weight * n.x() * n.y(), xz += weight * n.x() * n.z();
  yy += weight * n.y() * n.y(), yz += weight * n.y() * n.z(), zz += weight * n.z() * n.z();
  b += weight * d * n;
  c += weight * d * d;
}

Collapses::Error& Collapses::Error::operator+=(const Error& other) {
  xx += other.xx, xy += other.xy, xz += other.xz, yy += other.yy, yz += other.yz, zz += other.zz;
  b += other.b;
  c += other.c;
  area += other.area;
  return *this;
}

double Collapses::Error::at(const Vec3& p) const {
  const Vec3 a{xx * p.x() + xy * p.y() + xz * p.z(), xy * p.x() + yy * p.y() + yz * p.z(),
               xz * p.x() + yz * p.y() + zz * p.z()};
  return p.dot(a + 2 * b) + c;
}

Collapses::Collapses(CornerMesh& mesh)
    : mesh_(mesh), errors_(mesh.positions.size()), valence_(mesh.positions.size()) {
  const std::vector<Vec3> normals = mesh.normals();
  tbb::parallel_for(std::size_t{0}, mesh.positions.size(), [&](std::size_t v) {
    const auto vertex = static_cast<std::uint32_t>(v);
    errors_[v] = initialError(vertex, normals);
    mesh.forNeighbors(vertex, [&](std::uint32_t) { ++valence_[v]; });
  });
}

Collapses::Error Collapses::initialError(std::uint32_t vertex, const std::vector<Vec3>& normals) const {
  Error error;
  const Vec3& p = mesh_.positions[vertex];
  // The plane through a feature edge, perpendicular to its triangle.
  const auto addFeature = [&](Side s) {
    const Vec3 along = mesh_.positions[mesh_.end(s)] - mesh_.positions[mesh_.start(s)];
    const Vec3 across = along.cross(normals[s / 3]);
    const double length = across.norm();
    if (length > 0) error.addPlane(across / length, p, kFeatureWeight * along.squaredNorm());
  };
  mesh_.forSidesAround(vertex, [&](Side s) {
    const double area = mesh_.areaVector(s / 3).norm() / 2;
    error.addPlane(normals[s / 3], p, area);
    error.area += area;
    if (mesh_.side_feature[s] != 0) addFeature(s);
    if (mesh_.side_feature[previousSide(s)] != 0) addFeature(previousSide(s));
  });
  return error;
}

void Collapses::gather(std::uint32_t vertex, Workspace& work) const {
  work.neighbors.clear();
  work.sides.clear();
  work.border = mesh_.isBorder(vertex);
  mesh_.forSidesAround(vertex, [&](Side s) {
    work.sides.push_back(s);
    work.neighbors.push_back(mesh_.end(s));
  });
  if (work.border) work.neighbors.push_back(mesh_.apex(work.sides.back()));
  if (work.neighbors.size() <= kFewNeighbors) return;
  work.sorted_neighbors = work.neighbors;
  std::sort(work.sorted_neighbors.begin(), work.sorted_neighbors.end());
}

bool Collapses::keepsNormals(std::uint32_t vertex, std::uint32_t onto, const Workspace& work) const {
  const Vec3 &from = mesh_.positions[vertex], &to = mesh_.positions[onto];
  for (const Side s : work.sides) {
    const std::uint32_t a = mesh_.end(s), b = mesh_.apex(s);
    if (a == onto || b == onto) continue;
    const Vec3 &pa = mesh_.positions[a], ab = mesh_.positions[b] - pa;
    const Vec3 before = ab.cross(from - pa), after = ab.cross(to - pa);
    const double lengths2 = before.squaredNorm() * after.squaredNorm(), dot = before.dot(after);
    if (!(after.squaredNorm() > 0) || dot < 0 || dot * dot < kMaxTurnCosine * kMaxTurnCosine * lengths2)
      return false;
  }
  return true;
}

bool Collapses::keepsTopology(std::uint32_t vertex, std::uint32_t onto, Workspace& work) const {
  gather(vertex, work);
  return gatheredKeepTopology(vertex, onto, work);
}

bool Collapses::gatheredKeepTopology(std::uint32_t vertex, std::uint32_t onto, const Workspace& work) const {
  // The triangles of the edge, by their third corners.
  std::uint32_t left = kNone, right = kNone;
  for (const Side s : work.sides) {
    if (mesh_.end(s) == onto) left = mesh_.apex(s);
    if (mesh_.apex(s) == onto) right = mesh_.end(s);
  }
  if (left == right) return false;  // no edge, or both sides of one triangle
  if (work.border) {
    if (left != kNone && right != kNone) return false;  // would join two borders
    if (work.sides.size() < 2) return false;
    const std::uint32_t third = left != kNone ? left : right;
    if (valence_[third] == 2 && mesh_.isBorder(third)) return false;
  } else {
    if (left == kNone || right == kNone) return false;
    if (valence_[left] == 3 && valence_[right] == 3 && contains(work, left) &&
        mesh_.areNeighbors(left, right))
      return false;  // a tetrahedron
  }
  bool ok = true;
  mesh_.forNeighbors(onto, [&](std::uint32_t other) {
    if (ok && other != left && other != right && other != vertex) ok = !contains(work, other);
  });
  return ok;
}

Collapse Collapses::find(std::uint32_t vertex, DecimationLevel level, Workspace& work) const {
  gather(vertex, work);
  Collapse best;
  best.near_hub = valence_[vertex] >= kHubTriangles;
  for (const std::uint32_t v : work.neighbors) best.near_hub |= valence_[v] >= kHubTriangles;
  if (mesh_.locked[vertex] != 0) return best;
  const Error& error = errors_[vertex];
  const std::size_t count = work.neighbors.size();
  work.costs.assign(count, std::numeric_limits<float>::infinity());
  for (std::size_t k = 0; k < count; ++k) {
    const bool last_on_border = k == work.sides.size();
    const bool border_edge = work.border && (k == 0 || last_on_border);
    if (work.border && !border_edge) continue;
    const Side side = last_on_border ? previousSide(work.sides.back()) : work.sides[k];
    if (mesh_.feature[vertex] != 0 && mesh_.side_feature[side] == 0) continue;
    const std::uint32_t v = work.neighbors[k];
    const Vec3& p = mesh_.positions[v];
    const double area = error.area + errors_[v].area;
    const double mean2 = area > 0 ? std::max(error.at(p) + errors_[v].at(p), 0.0) / area : 0.0;
    work.costs[k] =
        static_cast<float>(mean2 + kLengthPull * kLengthPull * (p - mesh_.positions[vertex]).squaredNorm());
  }
  const std::size_t tries = level == DecimationLevel::kUnconstrained ? count : std::min(count, kMaxTries);
  for (std::size_t i = 0; i < tries; ++i) {
    const auto least = std::min_element(work.costs.begin(), work.costs.end());
    if (!std::isfinite(*least)) break;
    const std::uint32_t v = work.neighbors[static_cast<std::size_t>(least - work.costs.begin())];
    if ((level == DecimationLevel::kUnconstrained || keepsNormals(vertex, v, work)) &&
        gatheredKeepTopology(vertex, v, work)) {
      best.cost = *least;
      best.onto = v;
      break;
    }
    *least = std::numeric_limits<float>::infinity();
  }
  return best;
}

std::size_t Collapses::apply(std::uint32_t vertex, std::uint32_t onto, Workspace& work) {
  gather(vertex, work);
  Side out = kNone, in = kNone, kept = kNone;  // vertex → onto, onto → vertex; a side that will leave `onto`
  for (const Side s : work.sides) {
    if (mesh_.end(s) == onto)
      out = s;
    else if (mesh_.apex(s) == onto)
      in = previousSide(s);
    else
      kept = s;
  }
  for (const Side s : work.sides) mesh_.triangles[s / 3][s % 3] = onto;
  // Takes away the triangle of the edge on one side: its two other sides become one.
  const auto close = [&](Side s) {
    const Side one = nextSide(s), two = previousSide(s);
    const Side beyond_one = mesh_.opposite[one], beyond_two = mesh_.opposite[two];
    const std::uint8_t is_feature = mesh_.side_feature[one] | mesh_.side_feature[two];
    for (const auto& [a, b] : {std::pair(beyond_one, beyond_two), std::pair(beyond_two, beyond_one)}) {
      if (a == kNone) continue;
      mesh_.opposite[a] = b;
      mesh_.side_feature[a] = is_feature;
    }
    mesh_.triangles[s / 3][0] = kNone;
    return std::pair(beyond_one, beyond_two);
  };
  std::size_t removed = 0;
  if (out != kNone) {
    const std::uint32_t apex = mesh_.apex(out);
    // onto → apex and apex → vertex on this triangle; beyond, apex → onto and vertex → apex.
    const auto [to_onto, from_vertex] = close(out);
    if (from_vertex != kNone) kept = from_vertex;
    mesh_.settle(apex, to_onto != kNone ? to_onto : nextSide(from_vertex));
    --valence_[apex];
    ++removed;
  }
  if (in != kNone) {
    const std::uint32_t apex = mesh_.apex(in);
    // vertex → apex and apex → onto on this triangle; beyond, apex → vertex and onto → apex.
    const auto [to_vertex, from_onto] = close(in);
    if (from_onto != kNone) kept = from_onto;
    mesh_.settle(apex, to_vertex != kNone ? to_vertex : nextSide(from_onto));
    --valence_[apex];
    ++removed;
  }
  mesh_.settle(onto, kept);
  mesh_.leaving[vertex] = kNone;
  valence_[onto] = valence_[onto] + valence_[vertex] - 2 - static_cast<std::uint32_t>(removed);
  errors_[onto] += errors_[vertex];
  return removed;
}

}  // namespace bakelight::surface
