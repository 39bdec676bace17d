#include "transport/buried_fill.h"

#include <algorithm>

namespace bakelight::transport {

using formats::TriangleMesh;

namespace {

using Ring = std::vector<std::uint32_t>;

// Vertices that share an edge with each buried one; empty for the others.
std::vector<Ring> neighborsOf(const TriangleMesh& mesh, std::span<const std::uint8_t> buried) {
  std::vector<Ring> rings(mesh.vertexCount());
  for (const auto& triangle : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      if (buried[triangle[i]] == 0) continue;
      rings[triangle[i]].push_back(triangle[(i + 1) % 3]);
      rings[triangle[i]].push_back(triangle[(i + 2) % 3]);
    }
  for (Ring& ring : rings) {
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  }
  return rings;
}

}  // namespace

BuriedFill::BuriedFill(const TriangleMesh& mesh, std::span<const std::uint8_t> buried) {
  if (std::find(buried.begin(), buried.end(), 1) == buried.end()) return;
  const std::vector<Ring> rings = neighborsOf(mesh, buried);
  std::vector<std::uint8_t> open(buried.begin(), buried.end());
  while (true) {
    // Who borders on a filled vertex is decided before any of this round is filled, so the order does not
    // matter.
    const std::size_t first = steps_.size();
    for (std::uint32_t v = 0; v < open.size(); ++v) {
      if (open[v] == 0) continue;
      Step step{v, {}};
      for (const std::uint32_t neighbor : rings[v])
        if (open[neighbor] == 0) step.sources.push_back(neighbor);
      if (!step.sources.empty()) steps_.push_back(std::move(step));
    }
    if (steps_.size() == first) return;
    for (std::size_t i = first; i < steps_.size(); ++i) open[steps_[i].vertex] = 0;
  }
}

void BuriedFill::apply(std::span<float> table, std::size_t row_size) const {
  std::vector<double> sum(row_size);
  for (const Step& step : steps_) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (const std::uint32_t source : step.sources)
      for (std::size_t i = 0; i < row_size; ++i) sum[i] += table[source * row_size + i];
    for (std::size_t i = 0; i < row_size; ++i)
      table[step.vertex * row_size + i] =
          static_cast<float>(sum[i] / static_cast<double>(step.sources.size()));
  }
}

}  // namespace bakelight::transport
