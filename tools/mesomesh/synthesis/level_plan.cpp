#include "tools/mesomesh/synthesis/level_plan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bitset>

namespace bakelight::mesomesh {
namespace {

// Predictors reach this many steps around a sample point.
constexpr double kPredictorReach = 1.1;
// Two rings, full.
constexpr std::size_t kMostRings = kMostLinks * (kMostLinks + 1);

// The two rings around a vertex, each vertex once, along the mean of the ways to it.
class Rings {
 public:
  void collect(const SurfaceGraph& graph, std::size_t vertex) {
    places_.fill(kFree);
    links_.clear();
    ways_.clear();
    for (const Link& near : graph.linksOf(vertex)) insert(near);
    const std::size_t first_ring = links_.size();
    for (std::size_t r = 0; r < first_ring; ++r) {
      const Link near = links_[r];
      for (const Link& further : graph.linksOf(near.to))
        if (further.to != vertex) add(joined(near, further), first_ring);
    }
    for (std::size_t l = first_ring; l < links_.size(); ++l)
      for (float& axis : links_[l].offset) axis /= ways_[l];
  }
  std::span<const Link> links() const { return links_; }

 private:
  static constexpr std::uint16_t kFree = 0xffff;
  static constexpr std::size_t kPlaces = 512;  // more than there are vertices in two rings
  static_assert(kPlaces > kMostRings);

  // Where a vertex is, or will be.
  std::uint16_t& placeOf(std::uint32_t vertex) {
    std::size_t place = (vertex * 0x9e3779b9U) >> 23;
    while (places_[place] != kFree && links_[places_[place]].to != vertex) place = (place + 1) % kPlaces;
    return places_[place];
  }
  void insert(const Link& link) {
    placeOf(link.to) = static_cast<std::uint16_t>(links_.size());
    links_.push_back(link);
    ways_.push_back(1);
  }
  void add(const Link& link, std::size_t first_ring) {
    const std::size_t known = placeOf(link.to);
    if (known == kFree) return insert(link);
    if (known < first_ring || links_[known].turns != link.turns) return;
    for (std::size_t axis = 0; axis < 2; ++axis) links_[known].offset[axis] += link.offset[axis];
    ways_[known] += 1;
  }

  std::array<std::uint16_t, kPlaces> places_;
  std::vector<Link> links_;
  std::vector<float> ways_;
};

struct Candidate {
  float squared_distance;
  const Link* link;
};

void planSamplePoint(std::span<const Link> links, const Offset& at, double texel_size, float reach,
                     Predictor* predictors) {
  std::array<Candidate, kPredictors> nearest;
  std::size_t count = 0;
  for (const Link& link : links) {
    const float x = at[0] - link.offset[0], y = at[1] - link.offset[1], squared = x * x + y * y;
    if (squared >= reach * reach) continue;
    std::size_t place = count < kPredictors ? count++ : kPredictors;
    while (place > 0 && squared < nearest[place - 1].squared_distance) {
      if (place < kPredictors) nearest[place] = nearest[place - 1];
      --place;
    }
    if (place < kPredictors) nearest[place] = {squared, &link};
  }
  std::array<float, kPredictors> weights = {};
  float sum = 0;
  for (std::size_t c = 0; c < count; ++c) {
    const float share = 1 - nearest[c].squared_distance / (reach * reach);
    sum += weights[c] = share * share;
  }
  int left = kFullWeight;
  for (std::size_t c = 0; c < count; ++c) {
    const Link& link = *nearest[c].link;
    const auto weight = static_cast<int>(kFullWeight * (weights[c] / sum));
    predictors[c] = {link.to, static_cast<std::uint16_t>(weight), static_cast<std::uint16_t>(link.turns),
                     fixedOffset({at[0] - link.offset[0], at[1] - link.offset[1]}, texel_size)};
    left -= weight;
  }
  if (count > 0) predictors[0].weight = static_cast<std::uint16_t>(predictors[0].weight + left);
}

// First fit in order of number, against both rings: whatever a vertex reads is among those.
std::vector<std::uint16_t> classesOf(const SurfaceGraph& graph) {
  constexpr std::uint16_t kNone = 0xffff;
  std::vector<std::uint16_t> classes(graph.vertexCount(), kNone);
  std::bitset<kMostRings + 1> taken;
  for (std::size_t v = 0; v < classes.size(); ++v) {
    taken.reset();
    const auto take = [&](std::uint32_t vertex) {
      if (classes[vertex] != kNone) taken.set(classes[vertex]);
    };
    for (const Link& link : graph.linksOf(v)) {
      take(link.to);
      for (const Link& further : graph.linksOf(link.to)) take(further.to);
    }
    std::uint16_t own = 0;
    while (taken.test(own)) ++own;
    classes[v] = own;
  }
  return classes;
}

void orderByClass(const SurfaceGraph& graph, LevelPlan& plan) {
  const std::vector<std::uint16_t> classes = classesOf(graph);
  std::size_t count = 0;
  for (const std::uint16_t c : classes) count = std::max<std::size_t>(count, c + std::size_t{1});
  plan.class_first.assign(count + 1, 0);
  for (const std::uint16_t c : classes) ++plan.class_first[c + std::size_t{1}];
  for (std::size_t c = 0; c < count; ++c) plan.class_first[c + 1] += plan.class_first[c];
  plan.order.resize(classes.size());
  std::vector<std::size_t> next(plan.class_first.begin(), plan.class_first.end() - 1);
  for (std::size_t v = 0; v < classes.size(); ++v)
    plan.order[next[classes[v]]++] = static_cast<std::uint32_t>(v);
}

}  // namespace

FixedPoint fixedOffset(const Offset& offset, double texel_size) {
  // A vertex further away than any exemplar is wide proposes nothing of use; it must only not overflow.
  constexpr double kMost = 1 << 14;
  FixedPoint result;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double texels = std::clamp(offset[axis] / texel_size, -kMost, kMost) * kOneTexel;
    result[axis] = static_cast<Fixed>(texels < 0 ? texels - 0.5 : texels + 0.5);
  }
  return result;
}

LevelPlan planOf(const SurfaceGraph& graph, std::span<const ExemplarScale> scales) {
  const std::size_t count = graph.vertexCount();
  LevelPlan plan;
  plan.samples.resize(count);
  plan.first = graph.first;
  plan.proposers.resize(graph.links.size());
  constexpr std::size_t kBlock = 1024;
  tbb::parallel_for(std::size_t{0}, (count + kBlock - 1) / kBlock, [&](std::size_t block) {
    Rings rings;
    for (std::size_t v = block * kBlock; v < std::min(count, (block + 1) * kBlock); ++v) {
      const ExemplarScale& scale = scales[graph.exemplars[v]];
      for (std::size_t l = graph.first[v]; l < graph.first[v + 1]; ++l) {
        const Link& link = graph.links[l];
        plan.proposers[l] = {link.to, link.turns, fixedOffset(link.offset, scale.texel_size)};
      }
      if (scale.appearance == nullptr) continue;
      rings.collect(graph, v);
      const auto step = static_cast<float>(scale.texel_size * scale.appearance->step() / kOneTexel);
      for (std::size_t s = 0; s < kSamplePoints; ++s) {
        const Offset at = {step * static_cast<float>(kSampleDirections[s][0]),
                           step * static_cast<float>(kSampleDirections[s][1])};
        planSamplePoint(rings.links(), at, scale.texel_size, static_cast<float>(kPredictorReach) * step,
                        plan.samples[v].data() + s * kPredictors);
      }
    }
  });
  orderByClass(graph, plan);
  return plan;
}

}  // namespace bakelight::mesomesh
