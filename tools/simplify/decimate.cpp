#include "tools/simplify/decimate.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "surface/collapse.h"
#include "surface/features.h"
#include "surface/parallel_lists.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

// The share of the collapses still to be done, and that of all vertices, whose cheapest are looked at in one
// round.
constexpr double kShareOfRest = 0.5, kShareOfAll = 0.2;
// So many collapses at least, however few are left to do.
constexpr std::size_t kMinBatch = 64;
constexpr std::size_t kGrain = 256;
constexpr std::uint64_t kNoKey = ~std::uint64_t{0};

// By cost; equal ones in an order that has nothing to do with where they lie, or a flat region would be eaten
// from one end. Invertible in the vertex, so no two are equal.
std::uint64_t keyOf(float cost, std::uint32_t vertex) {
  std::uint32_t h = vertex;
  h = (h ^ (h >> 16)) * 0x7FEB352Du;
  h = (h ^ (h >> 15)) * 0x846CA68Bu;
  h ^= h >> 16;
  return std::uint64_t{std::bit_cast<std::uint32_t>(cost)} << 32 | h;
}

void lower(std::uint64_t& value, std::uint64_t key) {
  std::atomic_ref shared(value);
  std::uint64_t seen = shared.load(std::memory_order_relaxed);
  while (key < seen && !shared.compare_exchange_weak(seen, key, std::memory_order_relaxed)) {
  }
}

class Decimation {
 public:
  explicit Decimation(CornerMesh& mesh)
      : mesh_(mesh),
        collapses_(mesh),
        best_(mesh.positions.size()),
        key_(mesh.positions.size(), kNoKey),
        claim_(mesh.positions.size(), kNoKey),
        dirty_(mesh.positions.size(), 1) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) triangles_ += mesh.alive(t);
  }

  std::size_t triangles() const { return triangles_; }

  // Returns the number of collapses.
  std::size_t collapseTo(std::size_t target, DecimationLevel level) {
    std::fill(dirty_.begin(), dirty_.end(), 1);
    std::size_t collapses = 0;
    alive_ = filtered(mesh_.positions.size(), [&](std::size_t v) { return mesh_.leaving[v] != kNone; });
    while (triangles_ > target) {
      findBest(level);
      const std::uint64_t limit = limitOfRound((triangles_ - target + 1) / 2);
      if (limit == kNoKey) break;  // none is allowed any more
      claimSurroundings(limit);
      collapses += collapseWinners(target);
      collapses += collapseNearHubs(target, limit, level);
      alive_ = filtered(alive_, [&](std::uint32_t v) { return mesh_.leaving[v] != kNone; });
    }
    return collapses;
  }

 private:
  template <class Body>
  void forAlive(Body body) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, alive_.size(), kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        Collapses::Workspace work;
                        for (std::size_t i = range.begin(); i < range.end(); ++i) body(alive_[i], work);
                      });
  }

  void findBest(DecimationLevel level) {
    forAlive([&](std::uint32_t v, Collapses::Workspace& work) {
      claim_[v] = kNoKey;
      if (dirty_[v] == 0) return;
      dirty_[v] = 0;
      refresh(v, level, work);
    });
  }
  void refresh(std::uint32_t v, DecimationLevel level, Collapses::Workspace& work) {
    best_[v] = collapses_.find(v, level, work);
    key_[v] = best_[v].onto == kNone ? kNoKey : keyOf(best_[v].cost, v);
  }

  // Keys up to this one take part in the round; kNoKey if there is none at all. An estimate from every so
  // manyth vertex does, as it only trades rounds for order.
  std::uint64_t limitOfRound(std::size_t rest) const {
    const auto wanted = std::max<double>(
        kMinBatch,
        std::min(kShareOfRest * static_cast<double>(rest), kShareOfAll * static_cast<double>(alive_.size())));
    constexpr std::size_t kLookedAt = 4096;
    const std::size_t stride = std::max<std::size_t>(1, alive_.size() / kLookedAt);
    std::vector<std::uint64_t> keys;
    for (std::size_t i = 0; i < alive_.size(); i += stride) {
      if (key_[alive_[i]] != kNoKey) keys.push_back(key_[alive_[i]]);
    }
    if (keys.empty()) {  // rare ones may be left between
      for (const std::uint32_t v : alive_) {
        if (key_[v] != kNoKey) keys.push_back(key_[v]);
      }
      if (keys.empty()) return kNoKey;
    }
    const auto rank =
        std::min(keys.size() - 1, static_cast<std::size_t>(wanted / static_cast<double>(stride)));
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(rank), keys.end());
    return keys[rank];
  }

  bool takesPart(std::uint32_t v, std::uint64_t limit) const {
    return key_[v] <= limit && key_[v] != kNoKey && !best_[v].near_hub;
  }

  // A collapse reads and changes nothing but the triangles of its vertex and of its neighbours: what claims
  // all of these vertices for itself may run beside any other that does.
  void claimSurroundings(std::uint64_t limit) {
    forAlive([&](std::uint32_t v, Collapses::Workspace&) {
      if (!takesPart(v, limit)) return;
      lower(claim_[v], key_[v]);
      mesh_.forNeighbors(v, [&](std::uint32_t n) { lower(claim_[n], key_[v]); });
    });
    winners_ = filtered(alive_, [&](std::uint32_t v) {
      if (!takesPart(v, limit)) return false;
      bool wins = claim_[v] == key_[v];
      mesh_.forNeighbors(v, [&](std::uint32_t n) { wins = wins && claim_[n] == key_[v]; });
      return wins;
    });
  }

  std::size_t collapseWinners(std::size_t target) {
    // Near the end only as many as the target asks for.
    if (triangles_ - std::min(triangles_, 2 * winners_.size()) < target) {
      std::sort(winners_.begin(), winners_.end(),
                [&](std::uint32_t a, std::uint32_t b) { return key_[a] < key_[b]; });
      std::size_t removed = 0, count = 0;
      while (count < winners_.size() && triangles_ - removed > target)
        removed += mesh_.isBorder(winners_[count++]) ? 1 : 2;
      winners_.resize(count);
    }
    std::vector<std::uint8_t> removed(winners_.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, winners_.size(), kGrain / 4),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        Collapses::Workspace work;
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          removed[i] = static_cast<std::uint8_t>(collapse(winners_[i], work));
                      });
    std::size_t collapses = 0;
    for (const std::uint8_t count : removed) {
      triangles_ -= count;
      collapses += count > 0;
    }
    return collapses;
  }

  // Returns the number of triangles removed; none where the neighbour's surroundings have changed too much
  // since the collapse was found.
  std::size_t collapse(std::uint32_t v, Collapses::Workspace& work) {
    if (!collapses_.keepsTopology(v, best_[v].onto, work)) {
      dirty_[v] = 1;
      return 0;
    }
    const std::size_t removed = collapses_.apply(v, best_[v].onto, work);
    for (const std::uint32_t n : work.neighbors) dirty_[n] = 1;
    key_[v] = kNoKey;
    return removed;
  }

  std::size_t collapseNearHubs(std::size_t target, std::uint64_t limit, DecimationLevel level) {
    std::vector<std::uint32_t> near = filtered(
        alive_, [&](std::uint32_t v) { return key_[v] != kNoKey && key_[v] <= limit && best_[v].near_hub; });
    std::sort(near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) { return key_[a] < key_[b]; });
    Collapses::Workspace work;
    std::size_t collapses = 0;
    for (const std::uint32_t v : near) {
      if (triangles_ <= target) break;
      if (mesh_.leaving[v] == kNone) continue;
      if (dirty_[v] != 0) {
        dirty_[v] = 0;
        refresh(v, level, work);
      }
      if (key_[v] > limit || key_[v] == kNoKey) continue;
      const std::size_t removed = collapse(v, work);
      triangles_ -= removed;
      collapses += removed > 0;
    }
    return collapses;
  }

  CornerMesh& mesh_;
  Collapses collapses_;
  std::size_t triangles_ = 0;
  std::vector<std::uint32_t> alive_, winners_;
  std::vector<Collapse> best_;        // of each vertex
  std::vector<std::uint64_t> key_;    // of that; kNoKey where none is allowed
  std::vector<std::uint64_t> claim_;  // of each vertex the least key that claims it
  std::vector<std::uint8_t> dirty_;   // whose best has to be found anew
};

}  // namespace

const char* name(DecimationLevel level) {
  switch (level) {
    case DecimationLevel::kFull:
      return "full";
    case DecimationLevel::kWithoutCreases:
      return "without_creases";
    case DecimationLevel::kUnconstrained:
      break;
  }
  return "unconstrained";
}

DecimationResult decimate(CornerMesh& mesh, std::size_t target) {
  DecimationResult result;
  constexpr std::array kLevels = {DecimationLevel::kFull, DecimationLevel::kWithoutCreases,
                                  DecimationLevel::kUnconstrained};
  Decimation decimation(mesh);
  for (const DecimationLevel level : kLevels) {
    if (decimation.triangles() <= target) break;
    result.level = level;
    if (level == DecimationLevel::kWithoutCreases) releaseCreases(mesh);
    result.collapses += decimation.collapseTo(target, level);
  }
  result.triangles = decimation.triangles();
  result.reached = result.triangles <= target;
  return result;
}

}  // namespace bakelight::simplify
