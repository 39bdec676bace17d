#include "tools/mesomesh/retile/figures.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bakelight::mesomesh {
namespace {

constexpr std::size_t kChunk = 4096;
constexpr std::size_t kSamples = 50'000;

// parallel_deterministic_reduce: the same splits, so the same roundings, for any number of threads.
template <class Sum, class Add>
Sum total(std::size_t count, const Add& add) {
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, count, kChunk), Sum{},
      [&](const auto& range, Sum sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) add(sum, i);
        return sum;
      },
      [](Sum a, const Sum& b) { return a += b; });
}

struct Shape {
  double quality = 0, least = 1, sides2 = 0;
  Shape& operator+=(const Shape& o) {
    quality += o.quality, sides2 += o.sides2;
    least = std::min(least, o.least);
    return *this;
  }
};
struct Valence {
  std::int64_t six = 0, inside = 0;
  Valence& operator+=(const Valence& o) {
    six += o.six, inside += o.inside;
    return *this;
  }
};
struct Distances {
  double sum = 0, largest = 0;
  Distances& operator+=(const Distances& o) {
    sum += o.sum;
    largest = std::max(largest, o.largest);
    return *this;
  }
  void add(double distance) { sum += distance, largest = std::max(largest, distance); }
};

}  // namespace

void measureTiling(const SlidingMesh& sliding, RetileReport& report) {
  const CornerMesh& mesh = sliding.mesh;
  const auto count = static_cast<double>(mesh.triangles.size());
  const auto shape = total<Shape>(mesh.triangles.size(), [&](Shape& sum, std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 &pa = mesh.positions[a], &pb = mesh.positions[b], &pc = mesh.positions[c];
    const double sides2 = (pb - pa).squaredNorm() + (pc - pb).squaredNorm() + (pa - pc).squaredNorm();
    const double area = (pb - pa).cross(pc - pa).norm() / 2;
    const double quality = sides2 > 0 ? 4 * std::numbers::sqrt3 * area / sides2 : 0;
    sum += Shape{quality, quality, sides2};
  });
  const auto valence = total<Valence>(mesh.positions.size(), [&](Valence& sum, std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    if (mesh.feature[v] != 0) return;
    int neighbors = 0;
    mesh.forSidesAround(v, [&](Side) { ++neighbors; });
    ++sum.inside, sum.six += neighbors == 6;
  });
  report.mean_quality = shape.quality / count;
  report.least_quality = shape.least;
  report.edge_length = std::sqrt(shape.sides2 / (3 * count));
  report.six_neighbors =
      valence.inside > 0 ? static_cast<double>(valence.six) / static_cast<double>(valence.inside) : 1;
}

void measureDeviation(const SlidingMesh& sliding, const OriginalSurface& original, double diagonal,
                      RetileReport& report) {
  const CornerMesh& mesh = sliding.mesh;
  const CornerMesh& surface = original.mesh().mesh;
  const SurfaceQuery tiling({mesh.positions, mesh.triangles, mesh.materials});
  const std::size_t step_in = std::max<std::size_t>(1, surface.positions.size() / kSamples),
                    step_out = std::max<std::size_t>(1, mesh.triangles.size() / kSamples);
  const std::size_t count_in = surface.positions.size() / step_in,
                    count_out = mesh.triangles.size() / step_out;
  const auto in = total<Distances>(count_in, [&](Distances& sum, std::size_t i) {
    const std::size_t v = i * step_in;
    if (surface.leaving[v] == kNone) return;
    // Of its own region: a sheet that was lost must not hide behind another.
    sum.add(tiling.closest(surface.positions[v], surface.materials[surface.leaving[v] / 3]).distance);
  });
  const auto out = total<Distances>(count_out, [&](Distances& sum, std::size_t i) {
    const std::size_t t = i * step_out;
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 middle = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3;
    sum.add(original.surface().closest(middle, mesh.materials[t]).distance);
  });
  if (!(diagonal > 0)) return;
  report.largest_deviation = std::max(in.largest, out.largest) / diagonal;
  report.mean_deviation =
      std::max(in.sum / static_cast<double>(count_in), out.sum / static_cast<double>(count_out)) / diagonal;
}

}  // namespace bakelight::mesomesh
