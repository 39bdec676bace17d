#include "tools/mesomesh/synthesis/synthesize.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <queue>

#include "tools/mesomesh/synthesis/coarsening.h"
#include "tools/mesomesh/synthesis/level_appearance.h"
#include "transport/random.h"

namespace bakelight::mesomesh {
namespace {

constexpr std::size_t kMostLevels = 12;
// A level that keeps more than this share of the vertices is no coarser (many small components).
constexpr double kCoarserShare = 0.8;
// Shares of a level's spacing by which its coordinates are moved; finer levels only mend.
constexpr double kJitter = 1.0, kLeastJitteredStep = 3;

// Of exhaustive search; it mostly stands still after a third of them.
constexpr int kMostSweeps = 40;

struct Surface {
  MeshGraph mesh;
  double spacing;
  std::vector<PlacedExemplar> exemplars;

  Surface(const SurfaceView& view, std::span<const Exemplar> given, const SynthesisOptions& options)
      : mesh(graphOf(view, options.folds, given.size())),
        spacing(mesh.graph.meanLength()),
        exemplars(placed(given, options.folds, spacing)) {}
  std::size_t vertexCount() const { return mesh.graph.vertexCount(); }
};

// The seam that a caller marks, or the surface's own.
std::vector<std::uint8_t> seamOf(const Surface& surface, std::span<const std::uint8_t> marked) {
  if (marked.empty()) return surface.mesh.on_seam;
  std::vector<std::uint8_t> result(surface.vertexCount());
  for (std::size_t v = 0; v < marked.size(); ++v)
    if (marked[v] != 0) result[surface.mesh.vertex_of[v]] = 1;
  return result;
}

std::vector<Coarsening> coarseLevels(const Surface& surface, std::uint64_t seed) {
  std::vector<Coarsening> levels;
  while (levels.size() < kMostLevels) {
    const SurfaceGraph& finer = levels.empty() ? surface.mesh.graph : levels.back().coarse;
    Coarsening next = coarsened(finer, seed + levels.size());
    const double spacing = next.coarse.meanLength();
    if (static_cast<double>(next.coarse.vertexCount()) >
            kCoarserShare * static_cast<double>(finer.vertexCount()) ||
        std::none_of(surface.exemplars.begin(), surface.exemplars.end(),
                     [&](const PlacedExemplar& e) { return suits(e, spacing, false); }))
      // Exemplars of texels that are huge beside the finest spacing are met further up.
      if (std::none_of(surface.exemplars.begin(), surface.exemplars.end(),
                       [&](const PlacedExemplar& e) { return spacing < e.texel_size; }) ||
          next.coarse.vertexCount() == finer.vertexCount())
        break;
    levels.push_back(std::move(next));
  }
  return levels;
}

class Synthesis {
 public:
  Synthesis(const Surface& surface, const SynthesisOptions& options)
      : surface_(surface), options_(options), coarse_(coarseLevels(surface, options.seed)) {
    ranges_ = options.ranges != 0 ? options.ranges
                                  : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()) * 8;
  }

  std::vector<FixedPoint> run(SynthesisReport& report, std::span<const std::uint8_t> on_seam) {
    report.levels.resize(coarse_.size() + 1);
    for (std::size_t level = coarse_.size() + 1; level-- > 0;) {
      const SurfaceGraph& graph = level == 0 ? surface_.mesh.graph : coarse_[level - 1].coarse;
      const bool coarsest = level == coarse_.size();
      const double spacing = graph.meanLength();
      if (coarsest)
        begin(graph);
      else
        refine(graph, coarse_[level]);
      const LevelAppearance appearance(surface_.exemplars, spacing, level == 0, options_.similar);
      report.levels[level] = {graph.vertexCount(), spacing, 0, appearance.leastRetainedVariance()};
      jitter(graph, spacing, coarsest);
      if (appearance.empty()) continue;
      admit(graph, appearance);
      const LevelPlan plan = planOf(graph, appearance.scales());
      report.levels[level].classes = plan.classCount();
      const LevelState state{graph, plan, appearance.matchers()};
      correct(state, coarsest);
      if (level == 0 && options_.measure_quality)
        report.quality = measureQuality(state, on_seam, coordinates_);
    }
    return std::move(coordinates_);
  }

 private:
  const PlacedExemplar& exemplarOf(const SurfaceGraph& graph, std::size_t vertex) const {
    return surface_.exemplars[graph.exemplars[vertex]];
  }
  static FixedPoint wrapped(FixedPoint at, const Exemplar& exemplar) {
    const FixedPoint period = {exemplar.width << kFixedBits, exemplar.height << kFixedBits};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      at[axis] %= period[axis];
      if (at[axis] < 0) at[axis] += period[axis];
    }
    return at;
  }
  // What continues `at`, the coordinates at the other end of `link`.
  FixedPoint continued(const PlacedExemplar& placed, const Link& link, FixedPoint at) const {
    const FixedPoint theirs = placed.turns(at, link.turns), way = fixedOffset(link.offset, placed.texel_size);
    const FixedPoint moved = {theirs[0] - way[0], theirs[1] - way[1]};
    const Exemplar& exemplar = *placed.exemplar;
    if (exemplar.periodic) return wrapped(moved, exemplar);
    return {std::clamp(moved[0], 0, (exemplar.width - 1) << kFixedBits),
            std::clamp(moved[1], 0, (exemplar.height - 1) << kFixedBits)};
  }

  // From one vertex of each component on, each continues the one it was reached from.
  void begin(const SurfaceGraph& graph) {
    coordinates_.assign(graph.vertexCount(), {0, 0});
    std::vector<std::uint8_t> reached(graph.vertexCount());
    for (std::uint32_t root = 0; root < graph.vertexCount(); ++root) {
      if (reached[root] != 0) continue;
      reached[root] = 1;
      std::queue<std::uint32_t> front({root});
      for (; !front.empty(); front.pop())
        for (const Link& link : graph.linksOf(front.front())) {
          if (reached[link.to] != 0) continue;
          reached[link.to] = 1;
          coordinates_[link.to] = continued(exemplarOf(graph, link.to), reversed(link, front.front()),
                                            coordinates_[front.front()]);
          front.push(link.to);
        }
    }
  }

  void refine(const SurfaceGraph& graph, const Coarsening& coarsening) {
    std::vector<FixedPoint> finer(graph.vertexCount());
    tbb::parallel_for(std::size_t{0}, finer.size(), [&](std::size_t v) {
      const Link& parent = coarsening.parents[v];
      finer[v] = continued(exemplarOf(graph, v), parent, coordinates_[parent.to]);
    });
    coordinates_ = std::move(finer);
  }

  // At the coarsest level anywhere, then by less and less.
  void jitter(const SurfaceGraph& graph, double spacing, bool coarsest) {
    if (options_.randomness == 0) return;
    tbb::parallel_for(std::size_t{0}, coordinates_.size(), [&](std::size_t v) {
      const PlacedExemplar& placed = exemplarOf(graph, v);
      const double step = spacing / placed.texel_size;
      if (!coarsest && step < kLeastJitteredStep) return;
      const std::uint64_t bits = transport::scrambled(
          transport::scrambled(options_.seed ^ transport::scrambled(graph.vertexCount())) ^ v);
      FixedPoint at = coordinates_[v];
      const std::array<int, 2> sides = {placed.exemplar->width, placed.exemplar->height};
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double signed_unit = static_cast<double>((bits >> (32 * axis)) & 0xffffffff) * 0x1p-31 - 1;
        const double reach = options_.randomness * (coarsest ? 0.5 * sides[axis] : kJitter * step);
        at[axis] += static_cast<Fixed>(signed_unit * reach * kOneTexel);
      }
      coordinates_[v] = wrapped(at, *placed.exemplar);
    });
  }

  void admit(const SurfaceGraph& graph, const LevelAppearance& appearance) {
    tbb::parallel_for(std::size_t{0}, coordinates_.size(), [&](std::size_t v) {
      const Matcher* matcher = appearance.matchers()[graph.exemplars[v]];
      if (matcher != nullptr) coordinates_[v] = matcher->appearance().admitted(coordinates_[v]);
    });
  }

  void correct(const LevelState& state, bool coarsest) {
    const int passes = coarsest ? 2 * options_.passes : options_.passes;
    if (options_.method == SynthesisMethod::kCoherent)
      for (int pass = 0; pass < passes; ++pass) correctOnce(state, ranges_, coordinates_);
    else
      for (int sweep = 0; sweep < kMostSweeps && searchOnce(state, coordinates_) > 0; ++sweep) {
      }
  }

  const Surface& surface_;
  const SynthesisOptions& options_;
  std::vector<Coarsening> coarse_;
  std::size_t ranges_;
  std::vector<FixedPoint> coordinates_;
};

float asCoordinate(Fixed at, int side) {
  const double coordinate = (static_cast<double>(at) / kOneTexel + 0.5) / side;
  const auto rounded = static_cast<float>(coordinate >= 1 ? coordinate - 1 : coordinate);
  return rounded < 1 ? rounded : 0;
}

Fixed asFixed(float coordinate, int side) {
  const auto at = static_cast<Fixed>(std::lround((static_cast<double>(coordinate) * side - 0.5) * kOneTexel));
  const Fixed period = side << kFixedBits;
  return at < 0 ? at + period : at >= period ? at - period : at;
}

}  // namespace

PatchCoordinates synthesize(const SurfaceView& view, std::span<const Exemplar> exemplars,
                            const SynthesisOptions& options) {
  const Surface surface(view, exemplars, options);
  PatchCoordinates result;
  result.report.welded_vertices = surface.mesh.welded_vertices;
  result.report.twisted_vertices = surface.mesh.twisted_vertices;
  for (const PlacedExemplar& placed : surface.exemplars)
    result.report.texel_sizes.push_back(placed.texel_size);
  const std::vector<FixedPoint> coordinates =
      Synthesis(surface, options).run(result.report, seamOf(surface, options.on_seam));
  result.coordinates.resize(view.positions.size());
  tbb::parallel_for(std::size_t{0}, result.coordinates.size(), [&](std::size_t v) {
    const FixedPoint at = coordinates[surface.mesh.vertex_of[v]];
    const Exemplar& exemplar = exemplars[view.exemplars[v]];
    result.coordinates[v] = {asCoordinate(at[0], exemplar.width), asCoordinate(at[1], exemplar.height)};
  });
  return result;
}

SynthesisQuality qualityOf(const SurfaceView& view, std::span<const Exemplar> exemplars,
                           const SynthesisOptions& options, std::span<const formats::Float2> coordinates) {
  const Surface surface(view, exemplars, options);
  std::vector<FixedPoint> fixed(surface.vertexCount());
  for (std::size_t v = 0; v < coordinates.size(); ++v) {
    const Exemplar& exemplar = exemplars[view.exemplars[v]];
    fixed[surface.mesh.vertex_of[v]] = {asFixed(coordinates[v][0], exemplar.width),
                                        asFixed(coordinates[v][1], exemplar.height)};
  }
  const LevelAppearance appearance(surface.exemplars, surface.spacing, true, 0);
  const LevelPlan plan = planOf(surface.mesh.graph, appearance.scales());
  return measureQuality({surface.mesh.graph, plan, appearance.matchers()}, seamOf(surface, options.on_seam),
                        fixed);
}

}  // namespace bakelight::mesomesh
