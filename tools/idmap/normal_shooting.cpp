#include "tools/idmap/normal_shooting.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "tools/idmap/nearest_points.h"
#include "transport/morton.h"
#include "transport/vector_types.h"

namespace bakelight::idmap {
namespace {

using transport::Vec3;
using transport::vec3;

constexpr double kHeightFactor = 4;

// For points along a Morton curve, the first of each run at one place.
std::vector<std::uint32_t> placesAlongCurve(std::span<const Float3> positions) {
  std::vector<std::uint32_t> place(positions.size());
  for (std::size_t i = 0; i < place.size(); ++i)
    place[i] = i > 0 && positions[i] == positions[i - 1] ? place[i - 1] : static_cast<std::uint32_t>(i);
  return place;
}

// Neighbors of vertices by edges of triangles, of all vertices at a place alike.
class Adjacency {
 public:
  Adjacency() = default;
  // `rank`: what the triangles' vertices are called here.
  Adjacency(std::span<const formats::Triangle> triangles, std::vector<std::uint32_t> place,
            std::span<const std::uint32_t> rank)
      : place_(std::move(place)), first_(place_.size() + 1, 0), triangles_(triangles.size()) {
    tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t t) {
      for (std::size_t k = 0; k < 3; ++k) triangles_[t][k] = place_[rank[triangles[t][k]]];
    });
    for (const formats::Triangle& triangle : triangles_)
      for (const std::uint32_t a : triangle) ++first_[a + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    of_vertex_.resize(first_.back());
    std::vector<std::uint32_t> end(first_.begin(), first_.end() - 1);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (const std::uint32_t a : triangles_[t]) of_vertex_[end[a]++] = static_cast<std::uint32_t>(t);
  }

  // Whether they are at one place or an edge joins them.
  bool connected(std::uint32_t a, std::uint32_t b) const {
    if (a == b) return true;
    a = place_[a], b = place_[b];
    if (a == b) return true;
    return std::any_of(of_vertex_.begin() + first_[a], of_vertex_.begin() + first_[a + 1],
                       [&](std::uint32_t t) {
                         const formats::Triangle& corners = triangles_[t];
                         return corners[0] == b || corners[1] == b || corners[2] == b;
                       });
  }

 private:
  std::vector<std::uint32_t> place_, first_;
  std::vector<formats::Triangle> triangles_;  // by place
  std::vector<std::uint32_t> of_vertex_;      // triangles; those of vertex v from first_[v] on
};

}  // namespace

void ShotFigures::add(const ShotFigures& more) {
  shots += more.shots;
  widened += more.widened;
  other_sheets += more.other_sheets;
  distance_sum += more.distance_sum;
  offset_sum += more.offset_sum;
  farthest = std::max(farthest, more.farthest);
}

struct NormalShooting::Implementation {
  struct Vertex {
    Float3 position, normal;
    std::uint32_t material, index;  // index: in the mesh
  };
  // One that may be taken.
  struct Candidate {
    std::uint32_t vertex;  // in `vertices`
    double line_squared, sheet_squared;
  };

  struct Search {
    std::vector<Float3> positions = {};
    std::vector<std::uint32_t> nearest = {};
    std::vector<Candidate> candidates = {};
  };

  std::vector<Vertex> vertices;  // along a Morton curve, so that neighbors lie near each other in memory
  Adjacency adjacency;
  std::size_t neighbors;
  std::unique_ptr<NearestPoints> nearest_points;

  Implementation(const MesoSurface& surface, std::size_t k);

  // Of `points` those that the shot may take.
  void choose(const Shot& shot, std::span<const std::uint32_t> points,
              std::vector<Candidate>& candidates) const {
    candidates.clear();
    const Vec3 normal = vec3(shot.normal), position = vec3(shot.position);
    for (const std::uint32_t i : points) {
      const Vertex& vertex = vertices[i];
      if (shot.material && vertex.material != *shot.material) continue;
      if (!(normal.dot(vec3(vertex.normal)) > 0)) continue;
      candidates.push_back(candidateAt(i, position, normal));
    }
  }

  Candidate candidateAt(std::uint32_t vertex, const Vec3& position, const Vec3& normal) const {
    const Vec3 way = vec3(vertices[vertex].position) - position;
    const double height = way.dot(normal);
    const double line = (way - height * normal).squaredNorm();
    return {vertex, line, line + kHeightFactor * kHeightFactor * height * height};
  }

  // Of equal values the vertex that comes first in the mesh.
  struct Least {
    std::uint32_t vertex = kNone;
    double value = std::numeric_limits<double>::infinity();

    void take(std::uint32_t other, double of_other, const std::vector<Vertex>& all) {
      if (of_other < value || (of_other == value && vertex != kNone && all[other].index < all[vertex].index))
        vertex = other, value = of_other;
    }
  };

  template <double Candidate::*kValue>
  std::size_t least(const std::vector<Candidate>& candidates) const {
    std::size_t best = 0;
    Least found;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const std::uint32_t before = found.vertex;
      found.take(candidates[i].vertex, candidates[i].*kValue, vertices);
      if (found.vertex != before) best = i;
    }
    return best;
  }

  // Leaves those that hang together with candidate `start`.
  void keepSheetOf(std::size_t start, std::vector<Candidate>& candidates) const {
    std::swap(candidates[0], candidates[start]);
    std::size_t end = 1;  // those before it are of the sheet
    for (std::size_t i = 0; i < end; ++i)
      for (std::size_t j = end; j < candidates.size(); ++j)
        if (adjacency.connected(candidates[i].vertex, candidates[j].vertex))
          std::swap(candidates[end++], candidates[j]);
    candidates.resize(end);
  }

  std::uint32_t taken(const Shot& shot, const Candidate& candidate, ShotFigures& figures) const {
    figures.offset_sum += std::sqrt(squaredDistance(shot.position, vertices[candidate.vertex].position));
    const double distance = std::sqrt(candidate.line_squared);
    figures.distance_sum += distance;
    figures.farthest = std::max(figures.farthest, distance);
    return vertices[candidate.vertex].index;
  }

  // Of candidates, of which there are some.
  std::uint32_t take(const Shot& shot, std::vector<Candidate>& candidates, ShotFigures& figures) const {
    std::size_t best = least<&Candidate::line_squared>(candidates);
    const std::size_t sheet = least<&Candidate::sheet_squared>(candidates);
    const std::uint32_t nearest = candidates[best].vertex;
    if (!adjacency.connected(nearest, candidates[sheet].vertex)) {
      keepSheetOf(sheet, candidates);
      best = least<&Candidate::line_squared>(candidates);
      figures.other_sheets += candidates[best].vertex != nearest ? 1 : 0;
    }
    return taken(shot, candidates[best], figures);
  }

  // Without finding out which of the group's points are the k nearest, where what is taken is surely one of
  // them: nearly always.
  std::optional<std::uint32_t> takeAtOnce(const Shot& shot, const NearestPoints::Group& group,
                                          ShotFigures& figures) const {
    Least line, sheet;
    const Vec3 normal = vec3(shot.normal), position = vec3(shot.position);
    for (const std::uint32_t i : group.points) {
      const Vertex& vertex = vertices[i];
      if (shot.material && vertex.material != *shot.material) continue;
      if (!(normal.dot(vec3(vertex.normal)) > 0)) continue;
      const Candidate candidate = candidateAt(i, position, normal);
      line.take(i, candidate.line_squared, vertices);
      sheet.take(i, candidate.sheet_squared, vertices);
    }
    if (line.vertex == kNone) return {};
    const double reach = group.reach - std::sqrt(squaredDistance(shot.position, group.center));
    const auto isSure = [&](std::uint32_t vertex) {
      return squaredDistance(shot.position, vertices[vertex].position) < reach * reach;
    };
    if (reach <= 0 || !isSure(line.vertex) || !isSure(sheet.vertex) ||
        !adjacency.connected(line.vertex, sheet.vertex))
      return {};
    return taken(shot, {line.vertex, line.value, 0}, figures);
  }

  std::uint32_t take(const Shot& shot, const NearestPoints::Group& group, std::size_t k, Search& work,
                     ShotFigures& figures) const {
    if (const auto vertex = takeAtOnce(shot, group, figures)) return *vertex;
    work.nearest.assign(group.points.begin(), group.points.end());
    nearest_points->keepNearest(shot.position, k, work.nearest);
    choose(shot, work.nearest, work.candidates);
    if (!work.candidates.empty()) return take(shot, work.candidates, figures);
    return shot.required ? shootFarther(shot, figures) : kNone;
  }

  std::uint32_t shootFarther(const Shot& shot, ShotFigures& figures) const {
    ++figures.widened;
    Search work;
    const std::size_t most = std::min(kMostNeighbors, vertices.size());
    for (std::size_t k = std::min(neighbors, most); k < most;) {
      k = std::min(4 * k, most);
      NearestPoints::Walk walk(*nearest_points, {&shot.position, 1}, k);
      walk.next();
      work.nearest.assign(walk.group().points.begin(), walk.group().points.end());
      nearest_points->keepNearest(shot.position, k, work.nearest);
      choose(shot, work.nearest, work.candidates);
      if (!work.candidates.empty()) return take(shot, work.candidates, figures);
    }
    return kNone;
  }
};

NormalShooting::Implementation::Implementation(const MesoSurface& surface, std::size_t k) : neighbors(k) {
  const formats::TriangleMesh& mesh = surface.mesh;
  const std::vector<std::uint32_t> order = transport::mortonOrder(mesh.positions);
  std::vector<std::uint32_t> rank(order.size());
  std::vector<Float3> positions(order.size());
  vertices.resize(order.size());
  tbb::parallel_for(std::size_t{0}, order.size(), [&](std::size_t i) {
    const std::uint32_t v = order[i];
    rank[v] = static_cast<std::uint32_t>(i);
    positions[i] = mesh.positions[v];
    vertices[i] = {positions[i], mesh.normals[v], surface.materials.empty() ? 0 : surface.materials[v], v};
  });
  if (vertices.empty()) return;
  tbb::parallel_invoke([&] { nearest_points = std::make_unique<NearestPoints>(positions); },
                       [&] { adjacency = Adjacency(mesh.triangles, placesAlongCurve(positions), rank); });
}

NormalShooting::NormalShooting(const MesoSurface& surface, std::size_t neighbors)
    : implementation_(std::make_unique<Implementation>(surface, neighbors)) {}

NormalShooting::~NormalShooting() = default;

ShotFigures NormalShooting::shoot(std::span<const Shot> shots, std::span<std::uint32_t> vertices) const {
  const Implementation& own = *implementation_;
  ShotFigures figures;
  if (own.vertices.empty()) std::fill(vertices.begin(), vertices.end(), kNone);
  if (shots.empty() || own.vertices.empty()) return figures;
  thread_local Implementation::Search work;
  work.positions.clear();
  for (const Shot& shot : shots) work.positions.push_back(shot.position);
  const std::size_t k = std::min(own.neighbors, own.vertices.size());
  NearestPoints::Walk walk(*own.nearest_points, work.positions, k);
  while (walk.next())
    for (std::size_t i = 0; i < walk.group().queries.size(); ++i) {
      const std::size_t s = figures.shots++;
      vertices[s] = own.take(shots[s], walk.group(), k, work, figures);
      if (vertices[s] == kNone && shots[s].required) return figures;
    }
  return figures;
}

}  // namespace bakelight::idmap
