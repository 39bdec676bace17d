#include "tools/atlas/charts/segmentation.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {
namespace {

constexpr int kRounds = 12;
// Of squared distances, in units of a piece's share of the area, against squared differences of unit normals.
constexpr double kCompactness = 6;
constexpr int kStraighteningRounds = 20;
constexpr int kDiffusionRounds = 4, kDiffusionSteps = 12;
// A change must shorten borders by this share of the edges that change.
constexpr double kLeastGain = 1e-6;

struct Center {
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
};

class Clustering {
 public:
  Clustering(const Surface& surface, std::span<const std::uint32_t> triangles, int count)
      : surface_(surface), triangles_(triangles), labels_(triangles.size(), -1) {
    for (std::uint32_t i = 0; i < triangles.size(); ++i) index_of_.emplace(triangles[i], i);
    double area = 0;
    for (const std::uint32_t t : triangles) area += surface.areas[t];
    position_weight_ = kCompactness * count / area;
    neighbors_.reserve(triangles.size());
    for (const std::uint32_t t : triangles) {
      centroids_.push_back((surface.corner(t, 0) + surface.corner(t, 1) + surface.corner(t, 2)) / 3);
      auto& neighbors = neighbors_.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t other = surface.passable(t, k);
        const auto it = other < 0 ? index_of_.end() : index_of_.find(static_cast<std::uint32_t>(other));
        neighbors[k] = it == index_of_.end() ? -1 : static_cast<std::int32_t>(it->second);
      }
    }
    spreadSeeds(count);
  }

  std::vector<std::int32_t> run() {
    for (int round = 0; round < kRounds; ++round) {
      flood();
      const std::vector<std::uint32_t> before = seeds_;
      recenter();
      if (seeds_ == before && round > 0) break;
    }
    flood();
    return labels_;
  }

 private:
  double cost(std::uint32_t i, const Center& center) const {
    return position_weight_ * (centroids_[i] - center.position).squaredNorm() +
           (surface_.normals[triangles_[i]] - center.normal).squaredNorm();
  }
  Center centerAt(std::uint32_t i) const { return {centroids_[i], surface_.normals[triangles_[i]]}; }

  // Farthest points: each new seed where the cost to all earlier ones is largest.
  void spreadSeeds(int count) {
    std::vector<double> nearest(triangles_.size(), std::numeric_limits<double>::infinity());
    std::uint32_t next = 0;
    for (int s = 0; s < count; ++s) {
      seeds_.push_back(next);
      centers_.push_back(centerAt(next));
      for (std::uint32_t i = 0; i < nearest.size(); ++i)
        nearest[i] = std::min(nearest[i], cost(i, centers_.back()));
      nearest[next] = -1;
      next = static_cast<std::uint32_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
      if (nearest[next] < 0) break;
    }
  }

  // Cheapest triangle first, grown from the seeds.
  void flood() {
    std::fill(labels_.begin(), labels_.end(), -1);
    using Entry = std::tuple<double, std::uint32_t, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto grow = [&](std::uint32_t i) {
      for (const std::int32_t other : neighbors_[i])
        if (other >= 0 && labels_[other] < 0)
          queue.emplace(cost(static_cast<std::uint32_t>(other), centers_[labels_[i]]), other, labels_[i]);
    };
    for (std::uint32_t s = 0; s < seeds_.size(); ++s) labels_[seeds_[s]] = static_cast<std::int32_t>(s);
    for (const std::uint32_t seed : seeds_) grow(seed);
    while (!queue.empty()) {
      const auto [ignored, i, label] = queue.top();
      queue.pop();
      if (labels_[i] >= 0) continue;
      labels_[i] = label;
      grow(i);
    }
  }

  // Centres to the mean of their pieces, seeds to the triangle that is nearest to that.
  void recenter() {
    std::vector<Center> sums(centers_.size());
    std::vector<double> areas(centers_.size(), 0);
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
      const double area = surface_.areas[triangles_[i]];
      sums[labels_[i]].position += area * centroids_[i];
      sums[labels_[i]].normal += area * surface_.normals[triangles_[i]];
      areas[labels_[i]] += area;
    }
    for (std::size_t c = 0; c < sums.size(); ++c) {
      centers_[c].position = sums[c].position / areas[c];
      if (sums[c].normal.norm() > 0) centers_[c].normal = sums[c].normal.normalized();
    }
    std::vector<double> best(centers_.size(), std::numeric_limits<double>::infinity());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
      const double c = cost(i, centers_[labels_[i]]);
      if (c < best[labels_[i]]) best[labels_[i]] = c, seeds_[labels_[i]] = i;
    }
  }

  const Surface& surface_;
  std::span<const std::uint32_t> triangles_;
  std::unordered_map<std::uint32_t, std::uint32_t> index_of_;
  std::vector<Vec3> centroids_;
  std::vector<std::array<std::int32_t, 3>> neighbors_;
  double position_weight_ = 0;
  std::vector<std::uint32_t> seeds_;
  std::vector<Center> centers_;
  std::vector<std::int32_t> labels_;
};

}  // namespace

std::vector<std::int32_t> cluster(const Surface& surface, std::span<const std::uint32_t> triangles,
                                  int count) {
  return Clustering(surface, triangles, count).run();
}

namespace {

// A few labels with their weights. Where more meet, the one of least weight is forgotten.
class Mixture {
 public:
  void clear() { count_ = 0; }
  void add(std::int32_t label, double weight) {
    std::size_t i = 0;
    while (i < count_ && labels_[i] != label) ++i;
    if (i < count_) {
      weights_[i] += weight;
      return;
    }
    if (count_ == kCapacity) {
      i = static_cast<std::size_t>(std::min_element(weights_.begin(), weights_.end()) - weights_.begin());
      if (weight <= weights_[i]) return;
    } else {
      ++count_;
    }
    labels_[i] = label, weights_[i] = weight;
  }
  void add(const Mixture& other, double weight) {
    for (std::size_t i = 0; i < other.count_; ++i) add(other.labels_[i], weight * other.weights_[i]);
  }
  // Of equally strong ones the lowest.
  std::int32_t strongest() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < count_; ++i)
      if (weights_[i] > weights_[best] || (weights_[i] == weights_[best] && labels_[i] < labels_[best]))
        best = i;
    return labels_[best];
  }

 private:
  static constexpr std::size_t kCapacity = 6;
  std::size_t count_ = 0;
  std::array<std::int32_t, kCapacity> labels_{};
  std::array<double, kCapacity> weights_{};
};

// The triangles that a border of labels within a region is less than `steps` triangles away from, ascending.
std::vector<std::uint32_t> nearBorders(const Surface& surface, std::span<const std::int32_t> regions,
                                       std::span<const std::int32_t> labels, int steps) {
  std::vector<std::uint8_t> is_near(labels.size(), 0);
  std::vector<std::uint32_t> queue;
  const auto take = [&](std::size_t t) {
    if (std::exchange(is_near[t], 1) == 0) queue.push_back(static_cast<std::uint32_t>(t));
  };
  const auto forNeighbors = [&](std::size_t t, const auto& visit) {
    for (std::size_t k = 0; k < 3; ++k)
      if (const std::int32_t other = surface.passable(t, k); other >= 0 && regions[other] == regions[t])
        visit(static_cast<std::size_t>(other));
  };
  for (std::size_t t = 0; t < labels.size(); ++t)
    forNeighbors(t, [&](std::size_t other) {
      if (labels[other] != labels[t]) take(t);
    });
  for (std::size_t begin = 0, step = 1; step < static_cast<std::size_t>(steps); ++step)
    for (const std::size_t end = queue.size(); begin < end; ++begin) forNeighbors(queue[begin], take);
  std::sort(queue.begin(), queue.end());
  return queue;
}

// One round of threshold dynamics (Merriman, Bence & Osher 1992): labels diffuse, then each triangle takes
// the strongest. Moves borders by their curvature, over more than one triangle at a time.
void diffuseLabels(const Surface& surface, std::span<const std::int32_t> regions,
                   std::span<std::int32_t> labels, int steps) {
  // Farther triangles keep a single label.
  const std::vector<std::uint32_t> active = nearBorders(surface, regions, labels, steps);
  std::vector<std::int32_t> index_of(labels.size(), -1);
  for (std::size_t i = 0; i < active.size(); ++i) index_of[active[i]] = static_cast<std::int32_t>(i);
  std::vector<Mixture> mixtures(active.size()), next(active.size());
  const auto forAll = [&](const auto& work) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, active.size(), 1024), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
    });
  };
  forAll([&](std::size_t i) { mixtures[i].add(labels[active[i]], 1); });
  for (int step = 0; step < steps; ++step) {
    forAll([&](std::size_t i) {
      const std::uint32_t t = active[i];
      double total = surface.areas[t];
      for (std::size_t k = 0; k < 3; ++k)
        if (const std::int32_t other = surface.passable(t, k); other >= 0 && regions[other] == regions[t])
          total += surface.areas[other];
      next[i].clear();
      next[i].add(mixtures[i], surface.areas[t] / total);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t other = surface.passable(t, k);
        if (other < 0 || regions[other] != regions[t]) continue;
        if (index_of[other] >= 0)
          next[i].add(mixtures[index_of[other]], surface.areas[other] / total);
        else
          next[i].add(labels[other], surface.areas[other] / total);
      }
    });
    std::swap(mixtures, next);
  }
  forAll([&](std::size_t i) { labels[active[i]] = mixtures[i].strongest(); });
}

// Of each label the largest connected part keeps it; the others take that of the neighbour they share most
// border with.
void joinScraps(const Surface& surface, std::span<const std::int32_t> regions,
                std::span<std::int32_t> labels) {
  const auto parts = connectedParts(surface, labels);
  std::unordered_map<std::int32_t, std::size_t> largest;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto [it, is_new] = largest.try_emplace(labels[parts[p][0]], p);
    if (!is_new && parts[p].size() > parts[it->second].size()) it->second = p;
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::int32_t own = labels[parts[p][0]];
    if (largest[own] == p) continue;
    std::map<std::int32_t, double> shared;
    for (const std::uint32_t t : parts[p])
      for (std::size_t k = 0; k < 3; ++k)
        if (const std::int32_t other = surface.passable(t, k);
            other >= 0 && labels[other] != own && regions[other] == regions[t])
          shared[labels[other]] += surface.edgeLength(t, k);
    if (shared.empty()) continue;
    const auto best = std::max_element(shared.begin(), shared.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    for (const std::uint32_t t : parts[p]) labels[t] = best->first;
  }
}

}  // namespace

void straightenBorders(const Surface& surface, std::span<const std::int32_t> regions,
                       std::span<std::int32_t> labels) {
  for (int round = 0; round < kDiffusionRounds; ++round) {
    diffuseLabels(surface, regions, labels, kDiffusionSteps);
    joinScraps(surface, regions, labels);
  }
  std::unordered_map<std::int32_t, std::size_t> sizes;
  for (const std::int32_t label : labels) ++sizes[label];
  // The triangles around the corner of t opposite its edge k must stay connected without t: t leaves its
  // piece across one edge only, or keeps a fan there. A triangle with two neighbours in its piece is safe if
  // those meet around the shared corner.
  const auto staysConnected = [&](std::size_t t, std::int32_t label) {
    std::array<std::size_t, 3> kept{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (const std::int32_t other = surface.passable(t, k); other >= 0 && labels[other] == label)
        kept[count++] = k;
    if (count <= 1) return count == 1;
    if (count == 3) return false;
    // The corner that both edges share, and a walk around it from one neighbour to the other within the
    // piece.
    const std::size_t corner = (kept[0] + 1) % 3 == kept[1] ? kept[1] : kept[0];
    const std::uint32_t place = surface.triangles[t][corner];
    const std::int32_t goal = surface.passable(t, corner);
    std::int32_t at = surface.passable(t, (corner + 2) % 3);
    for (int steps = 0; steps < 1000 && at >= 0 && labels[at] == label; ++steps) {
      if (at == goal) return true;
      const Triangle& triangle = surface.triangles[at];
      const std::size_t here = triangle[0] == place ? 0 : triangle[1] == place ? 1 : 2;
      // Entered across the edge that leaves `place`, or the other: go on across the one that arrives.
      at = surface.passable(static_cast<std::size_t>(at), (here + 2) % 3);
    }
    return false;
  };
  for (int round = 0; round < kStraighteningRounds; ++round) {
    std::size_t changes = 0;
    for (std::size_t t = 0; t < surface.triangleCount(); ++t) {
      const std::int32_t own = labels[t];
      double kept = 0, best = 0, perimeter = 0;
      std::int32_t best_label = own;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t other = surface.passable(t, k);
        if (other < 0) continue;
        const double length = surface.edgeLength(t, k);
        perimeter += length;
        if (labels[other] == own) {
          kept += length;
          continue;
        }
        if (regions[other] != regions[t]) continue;
        double shared = 0;
        for (std::size_t m = 0; m < 3; ++m)
          if (const std::int32_t third = surface.passable(t, m); third >= 0 && labels[third] == labels[other])
            shared += surface.edgeLength(t, m);
        if (shared > best || (shared == best && labels[other] < best_label))
          best = shared, best_label = labels[other];
      }
      if (best_label == own || best - kept <= kLeastGain * perimeter || sizes[own] <= 1 ||
          !staysConnected(t, own))
        continue;
      --sizes[own], ++sizes[best_label];
      labels[t] = best_label;
      ++changes;
    }
    if (changes == 0) break;
  }
}

}  // namespace bakelight::atlas
