#include "tools/simplify/relax.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "surface/parallel_lists.h"
#include "tools/simplify/samples.h"
#include "tools/simplify/surface_words.h"
#include "transport/triangle_distance.h"

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

// A vertex's neighbours seldom take more than eight; what does not fit stays where it is.
constexpr std::size_t kMaxColors = 64;
// Flips that run at once, and then those that had to wait for them, and so on.
constexpr int kMaxFlipSteps = 16;

struct Corners {
  Vec3 a, b, c;
  Vec3 areaVector() const { return (b - a).cross(c - a); }
};

// 0 for an equilateral triangle, infinite without area.
double shapeCost(const Corners& t, double twice_area) {
  const double sides2 = (t.b - t.a).squaredNorm() + (t.c - t.b).squaredNorm() + (t.a - t.c).squaredNorm();
  const double excess = sides2 / (2 * std::numbers::sqrt3 * twice_area) - 1;
  return excess * (1 + excess * excess);
}
double shapeCost(const Corners& t) {
  return shapeCost(t, t.areaVector().norm());
}

double cosine(const Vec3& u, const Vec3& v) {
  const double lengths = u.norm() * v.norm();
  return lengths > 0 ? u.dot(v) / lengths : -1.0;
}

// A triangle for many points: barycentric weights of those above its inside come from two products.
struct Prepared {
  explicit Prepared(const Corners& t) : corners(t) {
    const Vec3 ab = t.b - t.a, ac = t.c - t.a, area = ab.cross(ac);
    const double squared = area.squaredNorm();
    twice_area = std::sqrt(squared);
    to_b = ac.cross(area) / squared;
    to_c = area.cross(ab) / squared;
    normal = squared > 0 ? Vec3(area / twice_area) : Vec3(Vec3::Zero());
  }

  Corners corners;
  Vec3 to_b, to_c;  // gradients of the weights of b and c; not finite without area
  Vec3 normal;      // zero without area
  double twice_area;
};

// Triangles that an operation replaces, and the samples they hold.
struct Patch {
  std::vector<std::uint32_t> triangles;
  std::vector<Corners> before;
  std::vector<Vec3> normals_before;  // of unit length or zero; for moves only
  std::vector<Prepared> after;
  std::vector<std::uint32_t> samples;
  std::vector<std::uint32_t> start;  // of each sample, the triangle of the patch to look at first
};
// Where a sample comes to lie.
struct Foot {
  std::uint32_t triangle;  // of the patch
  Vec3 weights;
  double distance2;
};
// Room for what an operation gathers, one a thread.
struct Workspace {
  Patch patch;
  std::vector<Foot> feet, best_feet;
};

class Relaxation {
 public:
  Relaxation(CornerMesh& mesh, const SurfaceQuery& original)
      : mesh_(mesh),
        original_(original),
        samples_(original, static_cast<std::size_t>(kMinSamplesPerTriangle *
                                                    static_cast<double>(mesh.triangles.size()))) {
    samples_.assign(mesh_);
    weigh();
  }

  // To be called again whenever samples have moved much.
  void refresh() {
    samples_.walk(mesh_);
    weigh();
  }
  // Inserts vertices at the worst-fitted samples, no two in one triangle or its neighbours, until `triangles`
  // more are there (or one fewer).
  void insertWhereWorst(std::size_t triangles);
  std::int64_t flipEdges();
  std::int64_t moveVertices();

 private:
  void weigh() {
    // A mesh that fits exactly is held to the rounding of its coordinates.
    sigma2_ = std::max(samples_.meanDistance2(), 1e-12);
    sample_weight_ = static_cast<double>(mesh_.triangles.size()) / static_cast<double>(samples_.count());
  }
  const Vec3& position(std::uint32_t vertex) const { return mesh_.positions[vertex]; }
  Corners cornersOf(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return {position(a), position(b), position(c)};
  }
  double distanceCost(double distance2) const {
    const double relative = distance2 / sigma2_;
    const double peak = relative / kPeak;
    return sample_weight_ * relative * (1 + peak * peak * peak);
  }
  double currentCost(const Patch& patch) const {
    double cost = 0;
    for (const Corners& t : patch.before) cost += kShapeWeight * shapeCost(t);
    for (const std::uint32_t s : patch.samples) cost += distanceCost(samples_.distance2(s));
    return cost;
  }
  Foot footOn(const Prepared& prepared, std::uint32_t triangle, const Vec3& sample) const {
    const Corners& t = prepared.corners;
    const Vec3 from_a = sample - t.a;
    const double b = prepared.to_b.dot(from_a), c = prepared.to_c.dot(from_a);
    if (b > 0 && c > 0 && b + c < 1) {
      const double height = prepared.normal.dot(from_a);
      return {triangle, {1 - b - c, b, c}, height * height};
    }
    const Vec3 weights = transport::closestWeights(t.a, t.b, t.c, sample);
    return {triangle, weights,
            (weights[0] * t.a + weights[1] * t.b + weights[2] * t.c - sample).squaredNorm()};
  }
  Foot footInRing(const Patch& patch, std::uint32_t start, const Vec3& sample) const;
  double costOfRing(Patch& patch, double limit, std::vector<Foot>& feet) const;
  double costOfQuadrilateral(const Patch& patch, double limit, std::vector<Foot>& feet) const;
  void commit(const Patch& patch, const std::vector<Foot>& feet) {
    for (const std::uint32_t triangle : patch.triangles) samples_.clear(triangle);
    for (std::size_t i = 0; i < feet.size(); ++i)
      samples_.put(patch.triangles[feet[i].triangle], patch.samples[i], feet[i].distance2);
  }
  static void clear(Patch& patch) {
    patch.triangles.clear(), patch.before.clear(), patch.normals_before.clear(), patch.after.clear();
    patch.samples.clear(), patch.start.clear();
  }
  void add(Patch& patch, std::uint32_t triangle, const Corners& corners) const {
    const auto k = static_cast<std::uint32_t>(patch.triangles.size());
    patch.triangles.push_back(triangle);
    patch.before.push_back(Corners(corners));
    samples_.forSamples(triangle, [&](std::uint32_t s) {
      patch.samples.push_back(s);
      patch.start.push_back(k);
    });
  }

  // Samples pull the mesh to the original, but a vertex that is closest to none of them would be free to
  // leave it.
  bool strays(const Vec3& from, const Vec3& to) const {
    if (original_.within(to, kStray * std::sqrt(sigma2_))) return false;
    return original_.closest(to).distance > original_.closest(from).distance;
  }

  bool insert(std::uint32_t triangle, const Vec3& place);
  std::optional<float> gainOfFlip(Side side, Workspace& work) const;
  void flip(Side side, Workspace& work);
  std::vector<std::uint32_t> movableByColor(std::vector<std::size_t>& first) const;
  bool move(std::uint32_t vertex, Workspace& work);
  double bestLift(const Patch& patch, const std::vector<Foot>& feet, const Vec3& normal) const;

  CornerMesh& mesh_;
  const SurfaceQuery& original_;
  Samples samples_;
  double sigma2_ = 0, sample_weight_ = 0;
  tbb::enumerable_thread_specific<Workspace> workspaces_;
};

// ---- insertion
// --------------------------------------------------------------------------------------------------

bool Relaxation::insert(std::uint32_t triangle, const Vec3& place) {
  const auto [a, b, c] = mesh_.triangles[triangle];
  const Vec3 weights = transport::closestWeights(position(a), position(b), position(c), place);
  Eigen::Index least = 0;
  const double smallest = weights.minCoeff(&least);
  if (weights.maxCoeff() > 1 - kInsertMargin) return false;  // too near a vertex
  if (smallest > kInsertMargin) {
    mesh_.splitTriangle(triangle, place);
    return true;
  }
  // The side opposite to the corner that weighs least.
  const Side side = 3 * triangle + (static_cast<std::uint32_t>(least) + 1) % 3;
  if (mesh_.side_feature[side] != 0 || mesh_.opposite[side] == kNone) return false;
  mesh_.splitEdge(side, place);
  return true;
}

void Relaxation::insertWhereWorst(std::size_t triangles) {
  struct Place {
    double distance2;
    std::uint32_t sample, triangle;
  };
  std::vector<Place> places(samples_.count());
  tbb::parallel_for(std::size_t{0}, mesh_.triangles.size(), [&](std::size_t t) {
    const auto triangle = static_cast<std::uint32_t>(t);
    samples_.forSamples(triangle, [&](std::uint32_t s) { places[s] = {samples_.distance2(s), s, triangle}; });
  });
  tbb::parallel_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.distance2 > b.distance2 || (a.distance2 == b.distance2 && a.sample < b.sample);
  });
  const std::size_t target = mesh_.triangles.size() + triangles;
  std::vector<bool> touched(target, false);
  for (const Place& place : places) {
    if (mesh_.triangles.size() + 2 > target) break;
    std::array<std::uint32_t, 4> neighborhood{place.triangle};
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Side beyond = mesh_.opposite[3 * place.triangle + k];
      neighborhood[k + 1] = beyond == kNone ? place.triangle : beyond / 3;
    }
    if (std::any_of(neighborhood.begin(), neighborhood.end(), [&](std::uint32_t t) { return touched[t]; }))
      continue;
    const std::size_t before = mesh_.triangles.size();
    if (!insert(place.triangle, samples_.position(place.sample))) continue;
    for (const std::uint32_t t : neighborhood) touched[t] = true;
    for (std::size_t t = before; t < mesh_.triangles.size(); ++t) touched[t] = true;
  }
  samples_.resize(mesh_.triangles.size());
}

// ---- flips
// ------------------------------------------------------------------------------------------------------

double Relaxation::costOfQuadrilateral(const Patch& patch, double limit, std::vector<Foot>& feet) const {
  double cost = 0;
  for (const Prepared& t : patch.after) cost += kShapeWeight * shapeCost(t.corners, t.twice_area);
  feet.clear();
  for (const std::uint32_t s : patch.samples) {
    if (!(cost < limit)) return cost;
    const Foot one = footOn(patch.after[0], 0, samples_.position(s)),
               two = footOn(patch.after[1], 1, samples_.position(s));
    feet.push_back(two.distance2 < one.distance2 ? two : one);
    cost += distanceCost(feet.back().distance2);
  }
  return cost;
}

// By how much flipping the edge lowers the cost, if it does; leaves the feet and the patch in `work`.
std::optional<float> Relaxation::gainOfFlip(Side side, Workspace& work) const {
  const Side other = mesh_.opposite[side];
  if (other == kNone || mesh_.side_feature[side] != 0) return std::nullopt;
  const std::uint32_t apex = mesh_.apex(side), other_apex = mesh_.apex(other);
  const Vec3 &a = position(mesh_.start(side)), &b = position(mesh_.end(side)), &c = position(apex),
             &d = position(other_apex);
  // In the order in which CornerMesh::flip leaves the two triangles.
  const std::array after = {Corners{d, c, a}, Corners{c, d, b}};
  const double shape_before = shapeCost({a, b, c}) + shapeCost({b, a, d});
  if (shapeCost(after[0]) + shapeCost(after[1]) > shape_before) return std::nullopt;
  const Vec3 sum = Corners{a, b, c}.areaVector() + Corners{b, a, d}.areaVector();
  const double straight_before =
      std::min(cosine(Corners{a, b, c}.areaVector(), sum), cosine(Corners{b, a, d}.areaVector(), sum));
  for (const Corners& t : after) {
    if (cosine(t.areaVector(), sum) < std::min(kTurnCosine, straight_before)) return std::nullopt;
  }
  if (mesh_.areNeighbors(apex, other_apex)) return std::nullopt;
  Patch& patch = work.patch;
  clear(patch);
  add(patch, side / 3, {a, b, c});
  add(patch, other / 3, {b, a, d});
  for (const Corners& t : after) patch.after.emplace_back(t);
  const double before = currentCost(patch);
  const double cost = costOfQuadrilateral(patch, before, work.feet);
  if (!(cost < before * (1 - 1e-9))) return std::nullopt;
  return static_cast<float>(before - cost);
}

void Relaxation::flip(Side side, Workspace& work) {
  if (!gainOfFlip(side, work)) return;
  mesh_.flip(side);
  commit(work.patch, work.feet);
}

std::int64_t Relaxation::flipEdges() {
  std::vector<std::uint32_t> edges =
      filtered(mesh_.opposite.size(), [&](std::size_t s) { return mesh_.isEdge(static_cast<Side>(s)); });
  std::vector<std::uint64_t> claim(mesh_.positions.size(), 0);
  std::int64_t flips = 0;
  for (int step = 0; step < kMaxFlipSteps && !edges.empty(); ++step) {
    // Those of the greatest gain first, in their surroundings.
    std::vector<std::uint64_t> key(edges.size());
    const auto forEdges = [&](auto&& body) {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, edges.size(), 128),
                        [&](const tbb::blocked_range<std::size_t>& range) {
                          Workspace& work = workspaces_.local();
                          for (std::size_t i = range.begin(); i < range.end(); ++i) body(i, work);
                        });
    };
    const auto corners = [&](Side s) {
      return std::array{mesh_.start(s), mesh_.end(s), mesh_.apex(s), mesh_.apex(mesh_.opposite[s])};
    };
    forEdges([&](std::size_t i, Workspace& work) {
      const std::optional<float> gain = gainOfFlip(edges[i], work);
      key[i] = gain ? std::uint64_t{std::bit_cast<std::uint32_t>(*gain)} << 32 | (edges[i] + 1) : 0;
      if (!gain) return;
      for (const std::uint32_t v : corners(edges[i])) {
        std::atomic_ref shared(claim[v]);
        std::uint64_t seen = shared.load(std::memory_order_relaxed);
        while (key[i] > seen && !shared.compare_exchange_weak(seen, key[i], std::memory_order_relaxed)) {
        }
      }
    });
    std::vector<std::uint8_t> wins(edges.size());
    forEdges([&](std::size_t i, Workspace&) {
      if (key[i] == 0) return;
      const auto vertices = corners(edges[i]);
      wins[i] =
          std::all_of(vertices.begin(), vertices.end(), [&](std::uint32_t v) { return claim[v] == key[i]; });
    });
    forEdges([&](std::size_t i, Workspace&) {
      if (key[i] == 0) return;
      for (const std::uint32_t v : corners(edges[i]))
        std::atomic_ref(claim[v]).store(0, std::memory_order_relaxed);
    });
    forEdges([&](std::size_t i, Workspace& work) {
      if (wins[i] != 0) flip(edges[i], work);
    });
    // What gained but had to wait, and the edges around those that were flipped.
    std::vector<std::uint32_t> next;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      if (key[i] == 0) continue;
      const Side s = edges[i], other = mesh_.opposite[s];
      next.push_back(s);
      if (wins[i] == 0) continue;
      ++flips;
      next.back() = nextSide(s);
      next.insert(next.end(), {previousSide(s), nextSide(other), previousSide(other)});
    }
    for (std::uint32_t& s : next) s = std::min(s, mesh_.opposite[s]);
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    edges = std::move(next);
  }
  return flips;
}

// ---- moves
// ------------------------------------------------------------------------------------------------------

// From where the sample was, on to the next triangle around the vertex as long as that is closer.
Foot Relaxation::footInRing(const Patch& patch, std::uint32_t start, const Vec3& sample) const {
  const auto count = static_cast<std::uint32_t>(patch.after.size());
  Foot best = footOn(patch.after[start], start, sample);
  // The weights belong to the vertex in the middle, then to those towards the last and the next triangle.
  for (const bool forward : {true, false}) {
    for (std::uint32_t step = 1; step < count; ++step) {
      if (best.weights[forward ? 1 : 2] > 0) break;
      const std::uint32_t k = (best.triangle + (forward ? 1 : count - 1)) % count;
      const Foot met = footOn(patch.after[k], k, sample);
      if (!(met.distance2 < best.distance2)) break;
      best = met;
    }
  }
  return best;
}

double Relaxation::costOfRing(Patch& patch, double limit, std::vector<Foot>& feet) const {
  double cost = 0;
  for (const Prepared& t : patch.after) cost += kShapeWeight * shapeCost(t.corners, t.twice_area);
  feet.clear();
  for (std::size_t i = 0; i < patch.samples.size(); ++i) {
    if (!(cost < limit)) return cost;
    feet.push_back(footInRing(patch, patch.start[i], samples_.position(patch.samples[i])));
    cost += distanceCost(feet.back().distance2);
  }
  return cost;
}

double Relaxation::bestLift(const Patch& patch, const std::vector<Foot>& feet, const Vec3& normal) const {
  double right = 0, left = 0;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    const Corners& t = patch.after[feet[i].triangle].corners;
    const Vec3& n = patch.after[feet[i].triangle].normal;
    const Vec3 foot = feet[i].weights[0] * t.a + feet[i].weights[1] * t.b + feet[i].weights[2] * t.c;
    const double peak = feet[i].distance2 / (sigma2_ * kPeak);
    const double weight = 1 + 4 * std::min(peak * peak * peak, kMaxPeakWeight);
    const double slope = feet[i].weights[0] * n.dot(normal);
    right += weight * slope * n.dot(samples_.position(patch.samples[i]) - foot);
    left += weight * (slope * slope + kStiffness * feet[i].weights[0]);
  }
  return left > 0 ? right / left : 0.0;
}

bool Relaxation::move(std::uint32_t vertex, Workspace& work) {
  const Vec3 start = position(vertex);
  Patch& patch = work.patch;
  clear(patch);
  Vec3 normal = Vec3::Zero(), centroid = Vec3::Zero();
  double area = 0;
  mesh_.forSidesAround(vertex, [&](Side s) {
    const Corners t{start, position(mesh_.end(s)), position(mesh_.apex(s))};
    add(patch, s / 3, t);
    const Vec3 n = t.areaVector();
    const double length = n.norm();
    patch.normals_before.push_back(length > 0 ? Vec3(n / length) : n);
    normal += n;
    centroid += (t.a + t.b + t.c) * (length / 3);
    area += length;
  });
  if (!(area > 0) || !(normal.norm() > 0)) return false;
  normal.normalize();
  Vec3 step = centroid / area - start;
  step -= normal * normal.dot(step);
  const double before = currentCost(patch);
  double best = before * (1 - 1e-9);
  std::optional<Vec3> target;
  const auto place = [&](const Vec3& p) {
    patch.after.clear();
    for (const Corners& t : patch.before) patch.after.emplace_back(Corners{p, t.b, t.c});
  };
  const auto allowed = [&] {
    for (std::size_t k = 0; k < patch.after.size(); ++k) {
      const Vec3 &n = patch.after[k].normal, &n0 = patch.normals_before[k];
      if (n.dot(n0) < kTurnCosine && n.dot(normal) < n0.dot(normal)) return false;
    }
    return true;
  };
  for (const double share : {1.0, 0.4, 0.0}) {
    Vec3 candidate = start + share * step;
    place(candidate);
    costOfRing(patch, std::numeric_limits<double>::infinity(), work.feet);
    candidate += bestLift(patch, work.feet, normal) * normal;
    place(candidate);
    if (!allowed()) continue;
    const double cost = costOfRing(patch, best, work.feet);
    if (!(cost < best)) continue;
    if (strays(start, candidate)) continue;
    best = cost;
    target = candidate;
    std::swap(work.best_feet, work.feet);
  }
  if (!target) return false;
  mesh_.positions[vertex] = *target;
  commit(patch, work.best_feet);
  return true;
}

// Vertices that may move, none of one color next to another: those of color k from first[k] to first[k + 1].
std::vector<std::uint32_t> Relaxation::movableByColor(std::vector<std::size_t>& first) const {
  std::vector<std::uint8_t> color(mesh_.positions.size(), kMaxColors);
  first.assign(kMaxColors + 2, 0);
  for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
    if (mesh_.feature[v] != 0 || mesh_.isBorder(v)) continue;
    std::uint64_t taken = 0;
    mesh_.forNeighbors(v, [&](std::uint32_t n) {
      if (color[n] < kMaxColors) taken |= std::uint64_t{1} << color[n];
    });
    color[v] = static_cast<std::uint8_t>(std::countr_one(taken));
    ++first[color[v] + 1u];
  }
  for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  std::vector<std::uint32_t> order(first[kMaxColors]);
  for (std::uint32_t v = 0; v < color.size(); ++v) {
    if (color[v] < kMaxColors) order[next[color[v]]++] = v;
  }
  return order;
}

std::int64_t Relaxation::moveVertices() {
  std::vector<std::size_t> first;
  const std::vector<std::uint32_t> order = movableByColor(first);
  std::vector<std::uint8_t> moved(mesh_.positions.size());
  for (std::size_t k = 0; k < kMaxColors; ++k) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(first[k], first[k + 1], 32),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        Workspace& work = workspaces_.local();
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          moved[order[i]] = move(order[i], work);
                      });
  }
  std::int64_t moves = 0;
  for (const std::uint8_t m : moved) moves += m;
  return moves;
}

}  // namespace

RelaxCounts relax(CornerMesh& mesh, const SurfaceQuery& original, int rounds, std::size_t insert_triangles) {
  RelaxCounts counts;
  Relaxation relaxation(mesh, original);
  // Half of them later: what is worst by then may be elsewhere.
  const std::array<int, 2> insertions = {rounds / 2, 3 * rounds / 4};
  for (int round = 0; round < rounds; ++round) {
    std::size_t share = 0;
    if (round == insertions[0]) share = insert_triangles / 4 * 2;
    if (round == insertions[1]) share = insert_triangles;
    if (share > 0) relaxation.insertWhereWorst(share), insert_triangles -= std::min(insert_triangles, share);
    if (share > 0 || (round > 0 && round % kRoundsAssigned == 0)) relaxation.refresh();
    counts.flips += relaxation.flipEdges();
    counts.moves += relaxation.moveVertices();
  }
  counts.flips += relaxation.flipEdges();
  return counts;
}

}  // namespace bakelight::simplify
