#include "tools/simplify/relax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "tools/simplify/samples.h"
#include "tools/simplify/triangle_distance.h"

namespace bakelight::simplify {
namespace {

constexpr double kShapeWeight = 3;
// k of the cost: distances beyond √k·σ count by their eighth power, which keeps the greatest one down.
constexpr double kPeak = 6;
constexpr double kMinSamplesPerTriangle = 8;
// Rounds after which each sample looks for its closest triangle anew.
constexpr int kRoundsAssigned = 4;
constexpr double kMaxPeakWeight = 50;
// Normals of triangles that an operation replaces may turn by this much.
const double kTurnCosine = std::cos(35 * std::numbers::pi / 180);
// A move may not take a vertex farther than this many σ from the original, unless it comes from farther away.
constexpr double kStray = 4;
// Barycentric weight below which a place counts as on a side or at a corner.
constexpr double kInsertMargin = 0.2;
// Pull of a vertex towards its present height, as a share of its samples' weight.
constexpr double kStiffness = 0.02;

struct Corners {
  Vec3 a, b, c;
  Vec3 areaVector() const { return (b - a).cross(c - a); }
};

// 0 for an equilateral triangle, infinite without area.
double shapeCost(const Corners& t) {
  const double sides2 = (t.b - t.a).squaredNorm() + (t.c - t.b).squaredNorm() + (t.a - t.c).squaredNorm();
  const double excess = sides2 / (2 * std::numbers::sqrt3 * t.areaVector().norm()) - 1;
  return excess * (1 + excess * excess);
}

double cosine(const Vec3& u, const Vec3& v) {
  const double lengths = u.norm() * v.norm();
  return lengths > 0 ? u.dot(v) / lengths : -1.0;
}

class Relaxation {
 public:
  Relaxation(HalfEdgeMesh& mesh, const SurfaceQuery& original)
      : mesh_(mesh),
        original_(original),
        samples_(original,
                 static_cast<std::size_t>(kMinSamplesPerTriangle * static_cast<double>(mesh.n_faces()))) {}

  void start() {
    samples_.assign(mesh_);
    // A mesh that fits exactly is held to the rounding of its coordinates.
    sigma2_ = std::max(samples_.meanDistance2(), 1e-12);
    sample_weight_ = static_cast<double>(mesh_.n_faces()) / static_cast<double>(samples_.count());
  }
  // Inserts vertices at the worst-fitted samples, no two in one triangle or its neighbours, until `triangles`
  // more are there (or one fewer). Needs start() afterwards.
  void insertWhereWorst(std::size_t triangles);

  std::int64_t flipEdges() {
    std::int64_t flips = 0;
    for (const auto edge : mesh_.edges()) flips += flip(edge);
    return flips;
  }
  std::int64_t moveVertices() {
    std::int64_t moves = 0;
    for (const auto vertex : mesh_.vertices()) moves += move(vertex);
    return moves;
  }

 private:
  // Triangles that an operation replaces, and the samples they hold.
  struct Patch {
    std::vector<FaceHandle> faces;
    std::vector<Corners> corners;
    std::vector<std::uint32_t> samples;
  };
  // Where a sample comes to lie.
  struct Foot {
    std::uint32_t triangle;  // of the patch
    Vec3 weights;
    double distance2;
  };

  Vec3 position(VertexHandle vertex) const { return vec3(mesh_.point(vertex)); }
  double distanceCost(double distance2) const {
    const double relative = distance2 / sigma2_;
    const double peak = relative / kPeak;
    return sample_weight_ * relative * (1 + peak * peak * peak);
  }
  double currentCost(const Patch& patch) const {
    double cost = 0;
    for (const Corners& t : patch.corners) cost += kShapeWeight * shapeCost(t);
    for (const std::uint32_t s : patch.samples) cost += distanceCost(samples_.distance2(s));
    return cost;
  }
  // Finds the feet on `corners` and returns the cost; gives up once it passes `limit`.
  double costOf(std::span<const Corners> corners, std::span<const std::uint32_t> samples, double limit,
                std::vector<Foot>& feet) const {
    double cost = 0;
    for (const Corners& t : corners) cost += kShapeWeight * shapeCost(t);
    feet.clear();
    for (const std::uint32_t s : samples) {
      if (!(cost < limit)) return cost;
      Foot best{0, Vec3::Zero(), std::numeric_limits<double>::infinity()};
      for (std::uint32_t k = 0; k < corners.size(); ++k) {
        const Vec3 weights = closestWeights(corners[k].a, corners[k].b, corners[k].c, samples_.position(s));
        const double distance2 = (weights[0] * corners[k].a + weights[1] * corners[k].b +
                                  weights[2] * corners[k].c - samples_.position(s))
                                     .squaredNorm();
        if (distance2 < best.distance2) best = {k, weights, distance2};
      }
      feet.push_back(best);
      cost += distanceCost(best.distance2);
    }
    return cost;
  }
  void commit(const Patch& patch, const std::vector<Foot>& feet) {
    for (const FaceHandle face : patch.faces) samples_.clear(face);
    for (std::size_t i = 0; i < feet.size(); ++i) {
      samples_.put(patch.faces[feet[i].triangle], patch.samples[i], feet[i].distance2);
    }
  }
  void add(Patch& patch, FaceHandle face, const Corners& corners) const {
    patch.faces.push_back(face);
    patch.corners.push_back(corners);
    patch.samples.insert(patch.samples.end(), samples_.of(face).begin(), samples_.of(face).end());
  }

  // Samples pull the mesh to the original, but a vertex that is closest to none of them would be free to
  // leave it.
  bool strays(const Vec3& from, const Vec3& to) const {
    const double after = original_.closest(to).distance;
    return after > kStray * std::sqrt(sigma2_) && after > original_.closest(from).distance;
  }

  bool insert(FaceHandle face, const Vec3& place);
  bool flip(EdgeHandle edge);
  bool move(VertexHandle vertex);
  double bestLift(const Patch& patch, std::span<const Corners> corners, const std::vector<Foot>& feet,
                  const Vec3& normal) const;

  HalfEdgeMesh& mesh_;
  const SurfaceQuery& original_;
  Samples samples_;
  double sigma2_ = 0, sample_weight_ = 0;
  std::vector<Foot> feet_, best_feet_;
};

bool Relaxation::insert(FaceHandle face, const Vec3& place) {
  // Sides and the weights of the corners opposite to them.
  const HalfedgeHandle first = mesh_.halfedge_handle(face);
  const std::array sides = {first, mesh_.next_halfedge_handle(first), mesh_.prev_halfedge_handle(first)};
  const Vec3 weights =
      closestWeights(position(mesh_.to_vertex_handle(sides[1])), position(mesh_.to_vertex_handle(sides[2])),
                     position(mesh_.to_vertex_handle(sides[0])), place);
  Eigen::Index least = 0;
  const double smallest = weights.minCoeff(&least);
  if (weights.maxCoeff() > 1 - kInsertMargin) return false;  // too near a vertex
  if (smallest > kInsertMargin) {
    splitFace(mesh_, face, point(place));
    return true;
  }
  const EdgeHandle edge = mesh_.edge_handle(sides[static_cast<std::size_t>(least)]);
  if (mesh_.status(edge).feature() || mesh_.is_boundary(edge)) return false;
  splitEdge(mesh_, edge, point(place));
  return true;
}

void Relaxation::insertWhereWorst(std::size_t triangles) {
  struct Place {
    double distance2;
    std::uint32_t sample;
    FaceHandle face;
  };
  std::vector<Place> places;
  for (const auto face : mesh_.faces()) {
    for (const std::uint32_t s : samples_.of(face)) places.push_back({samples_.distance2(s), s, face});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.distance2 > b.distance2 || (a.distance2 == b.distance2 && a.sample < b.sample);
  });
  const std::size_t target = mesh_.n_faces() + triangles;
  std::vector<bool> touched(target, false);
  const auto isTouched = [&](FaceHandle face) { return touched[static_cast<std::size_t>(face.idx())]; };
  for (const Place& place : places) {
    if (mesh_.n_faces() + 2 > target) break;
    std::vector<FaceHandle> neighbourhood = {place.face};
    for (const auto face : mesh_.ff_range(place.face)) neighbourhood.push_back(face);
    if (std::any_of(neighbourhood.begin(), neighbourhood.end(), isTouched)) continue;
    const std::size_t before = mesh_.n_faces();
    if (!insert(place.face, samples_.position(place.sample))) continue;
    for (const FaceHandle face : neighbourhood) touched[static_cast<std::size_t>(face.idx())] = true;
    for (std::size_t f = before; f < mesh_.n_faces(); ++f) touched[f] = true;
  }
}

bool Relaxation::flip(EdgeHandle edge) {
  if (mesh_.status(edge).feature() || mesh_.is_boundary(edge)) return false;
  const HalfedgeHandle h = mesh_.halfedge_handle(edge, 0), o = mesh_.halfedge_handle(edge, 1);
  const Vec3 a = position(mesh_.from_vertex_handle(h)), b = position(mesh_.to_vertex_handle(h));
  const Vec3 c = position(mesh_.to_vertex_handle(mesh_.next_halfedge_handle(h)));
  const Vec3 d = position(mesh_.to_vertex_handle(mesh_.next_halfedge_handle(o)));
  const std::array after = {Corners{c, d, b}, Corners{d, c, a}};
  const double shape_before = shapeCost({a, b, c}) + shapeCost({b, a, d});
  if (shapeCost(after[0]) + shapeCost(after[1]) > shape_before || !mesh_.is_flip_ok(edge)) return false;
  const Vec3 sum = Corners{a, b, c}.areaVector() + Corners{b, a, d}.areaVector();
  const double straight_before =
      std::min(cosine(Corners{a, b, c}.areaVector(), sum), cosine(Corners{b, a, d}.areaVector(), sum));
  for (const Corners& t : after) {
    if (cosine(t.areaVector(), sum) < std::min(kTurnCosine, straight_before)) return false;
  }
  Patch patch;
  add(patch, mesh_.face_handle(h), {a, b, c});
  add(patch, mesh_.face_handle(o), {b, a, d});
  const double before = currentCost(patch);
  if (!(costOf(after, patch.samples, before, feet_) < before * (1 - 1e-9))) return false;
  mesh_.flip(edge);
  // The triangle (c, d, b) comes first, whichever face holds it now.
  patch.faces = {};
  for (const unsigned side : {0u, 1u}) {
    const HalfedgeHandle g = mesh_.halfedge_handle(edge, side);
    const Vec3 apex = position(mesh_.to_vertex_handle(mesh_.next_halfedge_handle(g)));
    if (apex == b)
      patch.faces.insert(patch.faces.begin(), mesh_.face_handle(g));
    else
      patch.faces.push_back(mesh_.face_handle(g));
  }
  commit(patch, feet_);
  return true;
}

double Relaxation::bestLift(const Patch& patch, std::span<const Corners> corners,
                            const std::vector<Foot>& feet, const Vec3& normal) const {
  double right = 0, left = 0;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    const Corners& t = corners[feet[i].triangle];
    const Vec3 n = t.areaVector().normalized();
    const Vec3 foot = feet[i].weights[0] * t.a + feet[i].weights[1] * t.b + feet[i].weights[2] * t.c;
    const double peak = feet[i].distance2 / (sigma2_ * kPeak);
    const double weight = 1 + 4 * std::min(peak * peak * peak, kMaxPeakWeight);
    const double slope = feet[i].weights[0] * n.dot(normal);
    right += weight * slope * n.dot(samples_.position(patch.samples[i]) - foot);
    left += weight * (slope * slope + kStiffness * feet[i].weights[0]);
  }
  return left > 0 ? right / left : 0.0;
}

bool Relaxation::move(VertexHandle vertex) {
  if (mesh_.status(vertex).feature() || mesh_.is_boundary(vertex)) return false;
  const Vec3 start = position(vertex);
  Patch patch;
  Vec3 normal = Vec3::Zero(), centroid = Vec3::Zero();
  double area = 0;
  for (const auto h : mesh_.voh_range(vertex)) {
    const HalfedgeHandle next = mesh_.next_halfedge_handle(h);
    const Corners t{start, position(mesh_.to_vertex_handle(h)), position(mesh_.to_vertex_handle(next))};
    add(patch, mesh_.face_handle(h), t);
    const Vec3 n = t.areaVector();
    normal += n;
    centroid += (t.a + t.b + t.c) * (n.norm() / 3);
    area += n.norm();
  }
  if (!(area > 0) || !(normal.norm() > 0)) return false;
  normal.normalize();
  Vec3 step = centroid / area - start;
  step -= normal * normal.dot(step);
  const double before = currentCost(patch);
  double best = before * (1 - 1e-9);
  std::optional<Vec3> target;
  std::vector<Corners> corners = patch.corners;
  const auto place = [&](const Vec3& p) {
    for (Corners& t : corners) t.a = p;
  };
  const auto allowed = [&] {
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec3 n = corners[k].areaVector(), n0 = patch.corners[k].areaVector();
      if (cosine(n, n0) < kTurnCosine && cosine(n, normal) < cosine(n0, normal)) return false;
    }
    return true;
  };
  for (const double share : {1.0, 0.4, 0.0}) {
    Vec3 candidate = start + share * step;
    place(candidate);
    costOf(corners, patch.samples, std::numeric_limits<double>::infinity(), feet_);
    candidate += bestLift(patch, corners, feet_, normal) * normal;
    place(candidate);
    if (!allowed()) continue;
    const double cost = costOf(corners, patch.samples, best, feet_);
    if (!(cost < best)) continue;
    if (strays(start, candidate)) continue;
    best = cost;
    target = candidate;
    best_feet_ = feet_;
  }
  if (!target) return false;
  mesh_.set_point(vertex, point(*target));
  commit(patch, best_feet_);
  return true;
}

}  // namespace

RelaxCounts relax(HalfEdgeMesh& mesh, const SurfaceQuery& original, int rounds,
                  std::size_t insert_triangles) {
  RelaxCounts counts;
  mesh.garbage_collection();
  Relaxation relaxation(mesh, original);
  const int insertion = rounds / 2;
  for (int round = 0; round < rounds; ++round) {
    if (round == insertion) relaxation.start();
    if (round == insertion) relaxation.insertWhereWorst(insert_triangles);
    if (round % kRoundsAssigned == 0 || round == insertion) relaxation.start();
    counts.flips += relaxation.flipEdges();
    counts.moves += relaxation.moveVertices();
  }
  counts.flips += relaxation.flipEdges();
  return counts;
}

}  // namespace bakelight::simplify
