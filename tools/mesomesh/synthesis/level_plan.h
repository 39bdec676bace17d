// What the vertices of one level read when their coordinates are corrected. It depends on the surface alone.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/mesomesh/synthesis/appearance.h"
#include "tools/mesomesh/synthesis/surface_graph.h"

namespace bakelight::mesomesh {

// A vertex that predicts what a sample point looks like: the exemplar at T(its coordinates) + offset.
struct Predictor {
  std::uint32_t vertex = 0;
  std::uint16_t weight = 0;  // those of a sample point add up to kFullWeight, or to 0 where it has none
  std::uint16_t turns = 0;
  FixedPoint offset = {0, 0};
};
constexpr int kFullWeight = 256;

// A vertex is judged by four points about it, one step along both axes each (Lefebvre & Hoppe 2006, 3.3).
constexpr std::size_t kSamplePoints = 4;
constexpr std::size_t kPredictors = 3;  // of a sample point at most
constexpr std::array<std::array<int, 2>, kSamplePoints> kSampleDirections = {
    {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
using SamplePlan = std::array<Predictor, kSamplePoints * kPredictors>;

// Proposes T(its coordinates) − offset.
struct Proposer {
  std::uint32_t vertex = 0;
  std::uint32_t turns = 0;
  FixedPoint offset = {0, 0};
};

// What an exemplar is to a level of the surface.
struct ExemplarScale {
  double texel_size = 1;                        // units
  const AppearanceLevel* appearance = nullptr;  // none: the level's spacing is not one to correct this one at
};

struct LevelPlan {
  std::vector<SamplePlan> samples;       // of each vertex
  std::vector<std::size_t> first = {0};  // vertices + 1, into proposers
  std::vector<Proposer> proposers;
  // Vertices by class, ascending in each. No vertex reads one of its own class.
  std::vector<std::uint32_t> order;
  std::vector<std::size_t> class_first;

  std::span<const Proposer> proposersOf(std::size_t vertex) const {
    return {proposers.data() + first[vertex], first[vertex + 1] - first[vertex]};
  }
  std::size_t classCount() const { return class_first.size() - 1; }
};

// `scales`: of each exemplar. Predictors are taken from the two rings around a vertex, the three nearest to a
// sample point. Linear in vertices.
LevelPlan planOf(const SurfaceGraph& graph, std::span<const ExemplarScale> scales);

// One round towards coordinates that fit: `offset` units as texels.
FixedPoint fixedOffset(const Offset& offset, double texel_size);

}  // namespace bakelight::mesomesh
