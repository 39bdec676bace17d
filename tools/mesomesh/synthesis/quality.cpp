#include "tools/mesomesh/synthesis/quality.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tools/mesomesh/synthesis/ordered_sum.h"
#include "transport/random.h"

namespace bakelight::mesomesh {
namespace {

constexpr std::size_t kSampledVertices = 4096;
constexpr double kVerticesPerCell = 4;
// Squared difference of what would be equal, but for the rounding of appearances: a twelfth for each number, of
// either side.
constexpr double kRounding = kSamplePoints * kAppearanceSize / 6.0;

const Matcher* matcherOf(const LevelState& level, std::size_t vertex) {
  return level.matchers[level.graph.exemplars[vertex]];
}

// What makes errors of several exemplars comparable: squared differences of random places.
double scaleOf(const Matcher& matcher, const Surroundings& surroundings) {
  const auto known =
      static_cast<double>(std::count(surroundings.known.begin(), surroundings.known.end(), true));
  return 2 * matcher.appearance().variance() * known;
}

struct VertexErrors {
  bool counted = false;
  double own = 0, best = 0, random = 0;
  double resolution = 0;
};

FixedPoint randomPlace(const AppearanceLevel& appearance, std::size_t vertex) {
  const std::uint64_t bits = transport::scrambled(transport::scrambled(1) ^ vertex);
  return appearance.admitted(
      {static_cast<Fixed>((bits & 0xffff) * static_cast<std::uint64_t>(appearance.width())),
       static_cast<Fixed>((bits >> 16 & 0xffff) * static_cast<std::uint64_t>(appearance.height()))});
}

VertexErrors errorsOf(const LevelState& level, std::size_t v, const std::vector<FixedPoint>& coordinates,
                      bool search) {
  const Matcher* matcher = matcherOf(level, v);
  if (matcher == nullptr) return {};
  const Surroundings surroundings = matcher->surroundings(level.plan.samples[v], coordinates.data());
  const double scale = scaleOf(*matcher, surroundings);
  if (!(scale > 0)) return {};
  const Match own{coordinates[v], matcher->error(surroundings, coordinates[v])};
  const Match best = search ? bestOfAll(*matcher, surroundings, own) : own;
  return {true, own.error / scale, best.error / scale,
          search ? matcher->error(surroundings, randomPlace(matcher->appearance(), v)) / scale : 0,
          kRounding / scale};
}

void measureErrors(const LevelState& level, const std::vector<FixedPoint>& coordinates,
                   SynthesisQuality& quality) {
  const std::size_t count = coordinates.size(), sampled = std::min(count, kSampledVertices);
  std::vector<VertexErrors> errors(sampled);
  tbb::parallel_for(std::size_t{0}, sampled, [&](std::size_t s) {
    // One in each of equal parts of the vertices, so that none is drawn twice.
    const std::size_t begin = count * s / sampled, size = count * (s + 1) / sampled - begin;
    errors[s] = errorsOf(level, begin + transport::scrambled(s) % size, coordinates, true);
  });
  double own = 0, best = 0, random = 0, resolution = 0, counted = 0;
  for (const VertexErrors& error : errors) {
    own += error.own, best += error.best, random += error.random;
    resolution += error.resolution;
    counted += error.counted ? 1 : 0;
  }
  if (counted == 0) return;
  quality.neighborhood_error = own / counted;
  quality.best_neighborhood_error = best / counted;
  quality.neighborhood_error_ratio = std::max(own, resolution) / std::max(best, resolution);
  quality.random_ratio = std::max(random, resolution) / std::max(best, resolution);
}

void measureSeams(const LevelState& level, std::span<const std::uint8_t> on_seam,
                  const std::vector<FixedPoint>& coordinates, SynthesisQuality& quality) {
  std::vector<VertexErrors> errors(coordinates.size());
  tbb::parallel_for(std::size_t{0}, errors.size(),
                    [&](std::size_t v) { errors[v] = errorsOf(level, v, coordinates, false); });
  const auto sum = [&](bool seam, const auto& value) {
    return orderedSum(errors.size(), [&](std::size_t v) {
      return errors[v].counted && (on_seam[v] != 0) == seam ? value(errors[v]) : 0.0;
    });
  };
  const auto one = [](const VertexErrors&) { return 1.0; };
  const auto own = [](const VertexErrors& error) { return error.own; };
  const double on = sum(true, one), off = sum(false, one);
  quality.seam_vertices = static_cast<std::size_t>(on);
  if (on == 0 || off == 0) return;
  const double interior = sum(false, own) / off, seam = sum(true, own) / on;
  const double resolution = sum(false, [](const VertexErrors& error) { return error.resolution; }) / off;
  quality.seam_ratio = std::max(seam, resolution) / std::max(interior, resolution);
}

bool isCoherent(const LevelState& level, std::size_t v, const Proposer& proposer,
                const std::vector<FixedPoint>& coordinates) {
  const Matcher& matcher = *matcherOf(level, v);
  const AppearanceLevel& appearance = matcher.appearance();
  const FixedPoint theirs = matcher.turns()(coordinates[proposer.vertex], proposer.turns);
  std::array<double, 2> apart;
  const std::array<int, 2> sides = {appearance.width(), appearance.height()};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    apart[axis] =
        static_cast<double>(theirs[axis] - proposer.offset[axis] - coordinates[v][axis]) / kOneTexel;
    if (appearance.periodic()) apart[axis] -= sides[axis] * std::round(apart[axis] / sides[axis]);
  }
  return apart[0] * apart[0] + apart[1] * apart[1] <= 0.25;
}

void measureCoherence(const LevelState& level, const std::vector<FixedPoint>& coordinates,
                      SynthesisQuality& quality) {
  const double pairs = orderedSum(coordinates.size(), [&](std::size_t v) {
    return matcherOf(level, v) == nullptr ? 0.0 : static_cast<double>(level.plan.proposersOf(v).size());
  });
  if (pairs == 0) return;
  quality.coherent_share = orderedSum(coordinates.size(),
                                      [&](std::size_t v) {
                                        if (matcherOf(level, v) == nullptr) return 0.0;
                                        double coherent = 0;
                                        for (const Proposer& proposer : level.plan.proposersOf(v))
                                          coherent += isCoherent(level, v, proposer, coordinates) ? 1 : 0;
                                        return coherent;
                                      }) /
                           pairs;
}

void measureCoverage(const LevelState& level, const std::vector<FixedPoint>& coordinates,
                     SynthesisQuality& quality) {
  double used = 0, coverage = 0, entropy = 0;
  for (std::size_t e = 0; e < level.matchers.size(); ++e) {
    if (level.matchers[e] == nullptr) continue;
    const AppearanceLevel& appearance = level.matchers[e]->appearance();
    std::vector<std::size_t> taken(static_cast<std::size_t>(appearance.width()) * appearance.height());
    double vertices = 0;
    // Cells of the part that coordinates may lie in, one a texel or as large as leaves vertices for each.
    for (std::size_t v = 0; v < coordinates.size(); ++v) vertices += level.graph.exemplars[v] == e ? 1 : 0;
    if (vertices == 0) continue;
    const double across =
        appearance.periodic()
            ? appearance.width()
            : static_cast<double>(appearance.greatest()[0] - appearance.least()[0]) / kOneTexel;
    const double up = appearance.periodic()
                          ? appearance.height()
                          : static_cast<double>(appearance.greatest()[1] - appearance.least()[1]) / kOneTexel;
    const double side = std::max(1.0, std::sqrt(across * up * kVerticesPerCell / vertices));
    const auto columns = static_cast<std::size_t>(std::max(1.0, std::floor(across / side)));
    const auto rows = static_cast<std::size_t>(std::max(1.0, std::floor(up / side)));
    taken.assign(columns * rows, 0);
    const FixedPoint origin =
        appearance.periodic() ? FixedPoint{-kHalfTexel, -kHalfTexel} : appearance.least();
    const auto cellOf = [&](Fixed at, Fixed from, double extent, std::size_t cells) {
      double place = static_cast<double>(at - from) / kOneTexel / extent;
      place -= std::floor(place);
      return std::min(cells - 1, static_cast<std::size_t>(place * static_cast<double>(cells)));
    };
    for (std::size_t v = 0; v < coordinates.size(); ++v)
      if (level.graph.exemplars[v] == e)
        ++taken[cellOf(coordinates[v][1], origin[1], up, rows) * columns +
                cellOf(coordinates[v][0], origin[0], across, columns)];
    double cells = 0, bits = 0;
    for (const std::size_t times : taken) {
      if (times == 0) continue;
      ++cells;
      const double share = static_cast<double>(times) / vertices;
      bits -= share * std::log2(share);
    }
    ++used;
    coverage += cells / static_cast<double>(taken.size());
    entropy += taken.size() > 1 ? bits / std::log2(static_cast<double>(taken.size())) : 1;
  }
  if (used > 0) quality.coverage = coverage / used, quality.entropy = entropy / used;
}

}  // namespace

SynthesisQuality measureQuality(const LevelState& level, std::span<const std::uint8_t> on_seam,
                                const std::vector<FixedPoint>& coordinates) {
  SynthesisQuality quality;
  if (coordinates.empty()) return quality;
  measureErrors(level, coordinates, quality);
  measureSeams(level, on_seam, coordinates, quality);
  measureCoherence(level, coordinates, quality);
  measureCoverage(level, coordinates, quality);
  return quality;
}

}  // namespace bakelight::mesomesh
