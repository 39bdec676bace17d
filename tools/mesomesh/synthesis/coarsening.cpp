#include "tools/mesomesh/synthesis/coarsening.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <numeric>

#include "transport/random.h"

namespace bakelight::mesomesh {
namespace {

enum class Choice : std::uint8_t { kOpen, kKept, kLeft };

// A vertex is kept once all its neighbors of higher rank are left, and left once one of them is kept: the one
// set that this has for an end does not depend on who is asked when.
std::vector<Choice> independentSet(const SurfaceGraph& graph, std::uint64_t seed) {
  const std::size_t count = graph.vertexCount();
  std::vector<std::uint64_t> ranks(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t v) {
    // Unequal, as the number fills the lower bits.
    ranks[v] = (transport::scrambled(transport::scrambled(seed) ^ v) & ~std::uint64_t{0xffffffff}) | v;
  });
  std::vector<Choice> choices(count, Choice::kOpen);
  std::vector<std::uint32_t> open(count);
  std::iota(open.begin(), open.end(), 0U);
  while (!open.empty()) {
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t o) {
      const std::uint32_t v = open[o];
      Choice choice = Choice::kKept;
      for (const Link& link : graph.linksOf(v)) {
        if (ranks[link.to] < ranks[v]) continue;
        const Choice other = std::atomic_ref(choices[link.to]).load(std::memory_order_relaxed);
        if (other == Choice::kKept) {
          choice = Choice::kLeft;
          break;
        }
        if (other == Choice::kOpen) choice = Choice::kOpen;
      }
      std::atomic_ref(choices[v]).store(choice, std::memory_order_relaxed);
    });
    std::erase_if(open, [&](std::uint32_t v) { return choices[v] != Choice::kOpen; });
  }
  return choices;
}

// The ways found to one coarse vertex. Those that turn differently go around something and are kept apart.
struct Ways {
  std::uint32_t to = 0;
  std::array<std::uint32_t, 4> count = {};
  std::array<Offset, 4> sum = {};

  void add(const Link& link) {
    ++count[link.turns];
    for (std::size_t axis = 0; axis < 2; ++axis) sum[link.turns][axis] += link.offset[axis];
  }
  Link mean() const {
    const auto turns =
        static_cast<std::uint32_t>(std::max_element(count.begin(), count.end()) - count.begin());
    const auto ways = static_cast<float>(count[turns]);
    return {to, turns, {sum[turns][0] / ways, sum[turns][1] / ways}};
  }
};

// Fine vertices of each coarse one.
struct Children {
  std::vector<std::uint32_t> first, list;
};

Children childrenOf(const std::vector<Link>& parents, std::size_t coarse) {
  Children result;
  result.first.assign(coarse + 1, 0);
  for (const Link& parent : parents) ++result.first[parent.to + 1];
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  result.list.resize(parents.size());
  std::vector<std::uint32_t> next(result.first.begin(), result.first.end() - 1);
  for (std::size_t v = 0; v < parents.size(); ++v)
    result.list[next[parents[v].to]++] = static_cast<std::uint32_t>(v);
  return result;
}

std::vector<Link> linksBetween(const SurfaceGraph& fine, const std::vector<Link>& parents,
                               const Children& children, std::uint32_t coarse) {
  std::vector<Ways> found;
  for (std::uint32_t c = children.first[coarse]; c < children.first[coarse + 1]; ++c) {
    const std::uint32_t child = children.list[c];
    const Link to_child = reversed(parents[child], child);
    for (const Link& link : fine.linksOf(child)) {
      const Link& to_parent = parents[link.to];
      if (to_parent.to == coarse) continue;
      auto ways =
          std::find_if(found.begin(), found.end(), [&](const Ways& w) { return w.to == to_parent.to; });
      if (ways == found.end()) ways = found.insert(found.end(), Ways{to_parent.to});
      ways->add(joined(joined(to_child, link), to_parent));
    }
  }
  std::vector<Link> links;
  for (const Ways& ways : found) links.push_back(ways.mean());
  const auto shorter = [](const Link& a, const Link& b) {
    const float length_a = squaredLength(a), length_b = squaredLength(b);
    return length_a != length_b ? length_a < length_b : a.to < b.to;
  };
  if (links.size() > kMostLinks) {
    std::nth_element(links.begin(), links.begin() + kMostLinks, links.end(), shorter);
    links.resize(kMostLinks);
  }
  std::sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.to < b.to; });
  return links;
}

}  // namespace

Coarsening coarsened(const SurfaceGraph& fine, std::uint64_t seed) {
  const std::size_t count = fine.vertexCount();
  const std::vector<Choice> choices = independentSet(fine, seed);
  Coarsening result;
  std::vector<std::uint32_t> coarse_of_fine(count);
  for (std::size_t v = 0; v < count; ++v) {
    if (choices[v] != Choice::kKept) continue;
    coarse_of_fine[v] = static_cast<std::uint32_t>(result.fine_of_coarse.size());
    result.fine_of_coarse.push_back(static_cast<std::uint32_t>(v));
    result.coarse.exemplars.push_back(fine.exemplars[v]);
  }

  result.parents.resize(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t v) {
    if (choices[v] == Choice::kKept) {
      result.parents[v] = {coarse_of_fine[v], 0, {0, 0}};
      return;
    }
    const Link* nearest = nullptr;
    for (const Link& link : fine.linksOf(v))
      if (choices[link.to] == Choice::kKept &&
          (nearest == nullptr || squaredLength(link) < squaredLength(*nearest)))
        nearest = &link;
    result.parents[v] = *nearest;
    result.parents[v].to = coarse_of_fine[nearest->to];
  });

  const std::size_t coarse_count = result.fine_of_coarse.size();
  const Children children = childrenOf(result.parents, coarse_count);
  std::vector<std::vector<Link>> links(coarse_count);
  tbb::parallel_for(std::size_t{0}, coarse_count, [&](std::size_t c) {
    links[c] = linksBetween(fine, result.parents, children, static_cast<std::uint32_t>(c));
  });
  SurfaceGraph& coarse = result.coarse;
  coarse.first.resize(coarse_count + 1);
  bool any_full = false;
  for (std::size_t c = 0; c < coarse_count; ++c) {
    coarse.first[c + 1] = coarse.first[c] + links[c].size();
    any_full = any_full || links[c].size() == kMostLinks;
  }
  coarse.links.resize(coarse.first.back());
  tbb::parallel_for(std::size_t{0}, coarse_count, [&](std::size_t c) {
    std::copy(links[c].begin(), links[c].end(),
              coarse.links.begin() + static_cast<std::ptrdiff_t>(coarse.first[c]));
  });
  if (any_full) keepMutual(coarse);
  return result;
}

}  // namespace bakelight::mesomesh
