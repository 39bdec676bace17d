// What least squares at the vertices save of the interpolation error: shadowed transfer of the bunny, order 5, under five
// probes, against transfer that is baked at points of its own all over the surface, two a triangle, which no fit has seen.
//
// interpolation_error = √(Σ area |interpolated − there|² ÷ Σ area |there|²) of what transfer sampled at the vertices shows,
// over points and colours, root mean square over the probes; interpolation_error_least_squares of what is fitted,
// in the same bytes; gain_percent = 100 (1 − the latter ÷ the former). original_error and
// original_error_least_squares are the same against the mesh before simplification, its own points and its own shadows,
// the fit being to samples on that.
#include <benchmark/benchmark.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "formats/image.h"
#include "formats/mesh_import.h"
#include "tools/simplify/simplify.h"
#include "tools/transfer/shadow_pass.h"
#include "tools/transfer/transfer.h"
#include "transport/lights.h"
#include "transport/random.h"
#include "transport/surface_query.h"

namespace bakelight {
namespace {

using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

constexpr int kOrder = 5;
constexpr int kDirections = 4096;
constexpr int kHeldOut = 2;  // points a triangle
constexpr const char* kProbes[] = {"courtyard", "forest", "interior", "studio", "sunrise"};

std::string dataFile(const std::string& name) {
  const char* folder = std::getenv("BAKELIGHT_DATA");
  return std::string(folder != nullptr ? folder : BAKELIGHT_DATA_DIR) + "/" + name;
}

TriangleMesh bunny(int triangles) {
  const std::string path = dataFile("models/bunny.obj");
  simplify::SimplifyOptions options;
  options.triangles = triangles;
  return simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
}

// Lights × coefficients.
const std::vector<transport::ShLight>& probes() {
  static const std::vector<transport::ShLight> lights = [] {
    std::vector<transport::ShLight> result;
    for (const char* name : kProbes) {
      const std::string path = dataFile(std::string("probes/") + name + ".exr");
      result.push_back(transport::projectLatLong(formats::readImage(path), kOrder, path));
    }
    return result;
  }();
  return lights;
}

struct Place {
  std::uint32_t triangle;
  Vec3 weights;
};

// Points of a surface with the transfer there.
class HeldOut {
 public:
  explicit HeldOut(const TriangleMesh& mesh) : mesh_(mesh) {
    const transport::RayScene scene(mesh);
    const transfer::ShadowPass pass(mesh, scene, {.order = kOrder, .sphere = {}}, kDirections);
    const float offset = transport::surfaceOffset(mesh, transport::kDefaultBias);
    places_.resize(kHeldOut * mesh.triangleCount());
    areas_.resize(places_.size());
    vectors_.resize(places_.size() * kSize);
    tbb::enumerable_thread_specific<transfer::ShadowPass::Workspace> workspaces(
        [&] { return transfer::ShadowPass::Workspace(pass); });
    tbb::parallel_for(std::size_t{0}, places_.size(), [&](std::size_t i) {
      const auto triangle = static_cast<std::uint32_t>(i / kHeldOut);
      double u = random(2 * i), v = random(2 * i + 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      places_[i] = {triangle, {1 - u - v, u, v}};
      const transport::SmoothPoint point = transport::smoothPoint(mesh, triangle, u, v);
      const auto traced = pass.trace(
          {transport::float3(point.lifted + offset * point.normal), transport::float3(point.normal)}, {},
          {std::span(vectors_).subspan(i * kSize, kSize), {}, {}}, workspaces.local());
      const auto& [a, b, c] = mesh.triangles[triangle];
      const Vec3 origin = vec3(mesh.positions[a]);
      const double area =
          (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin).norm() / 2;
      areas_[i] = traced.buried ? 0 : area / kHeldOut;
    });
  }

  Vec3 position(std::size_t i) const {
    return transport::smoothPoint(mesh_, places_[i].triangle, places_[i].weights[1], places_[i].weights[2])
        .position;
  }
  Vec3 normal(std::size_t i) const {
    return transport::smoothPoint(mesh_, places_[i].triangle, places_[i].weights[1], places_[i].weights[2])
        .normal;
  }
  const std::vector<Place>& places() const { return places_; }

  // Of transfer at the vertices of `mesh`, of which `at` are the places that stand for these points.
  double error(const TriangleMesh& mesh, const std::vector<float>& vectors, std::span<const Place> at) const {
    double sum = 0;
    for (const transport::ShLight& light : probes()) {
      double difference = 0, all = 0;
      for (std::size_t i = 0; i < places_.size(); ++i) {
        if (areas_[i] == 0) continue;
        const formats::Triangle& corners = mesh.triangles[at[i].triangle];
        for (int c = 0; c < 3; ++c) {
          double shown = 0, there = 0;
          for (std::size_t k = 0; k < kSize; ++k) {
            there += vectors_[i * kSize + k] * light[k][c];
            for (int corner = 0; corner < 3; ++corner)
              shown += at[i].weights[corner] * vectors[corners[corner] * kSize + k] * light[k][c];
          }
          difference += areas_[i] * (shown - there) * (shown - there);
          all += areas_[i] * there * there;
        }
      }
      sum += difference / all;
    }
    return std::sqrt(sum / static_cast<double>(probes().size()));
  }

 private:
  static constexpr std::size_t kSize = transport::coefficientCount(kOrder);
  static double random(std::uint64_t number) {
    return 0x1p-64 * static_cast<double>(transport::scrambled(transport::scrambled(number)));
  }

  const TriangleMesh& mesh_;
  std::vector<Place> places_;
  std::vector<double> areas_;
  std::vector<float> vectors_;
};

std::vector<Place> nearestPlaces(const HeldOut& points, const TriangleMesh& mesh) {
  transport::SurfaceMesh surface;
  for (const formats::Float3& position : mesh.positions) surface.positions.push_back(vec3(position));
  surface.triangles = mesh.triangles;
  const transport::SurfaceQuery query(std::move(surface));
  std::vector<Place> places(points.places().size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const transport::ClosestPoint foot = query.closestFacing(points.position(i), points.normal(i));
    places[i] = {foot.triangle, foot.barycentric};
  });
  return places;
}

struct TimedBake {
  transfer::Transfer transfer;
  double seconds = 0;
};

TimedBake timedBake(const TriangleMesh& mesh, const transfer::TransferOptions& options) {
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  const auto start = std::chrono::steady_clock::now();
  TimedBake timed{transfer::bakeTransfer(mesh, {}, options, silent), 0};
  timed.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return timed;
}

// Argument: triangles.
void leastSquares(benchmark::State& state) {
  const TriangleMesh mesh = bunny(static_cast<int>(state.range(0)));
  const TriangleMesh original = bunny(100'000'000);
  const HeldOut own(mesh), before(original);
  const std::vector<Place> nearest = nearestPlaces(before, mesh);
  transfer::TransferOptions options;
  options.order = kOrder;
  options.directions = kDirections;
  for (auto _ : state) {
    const TimedBake at_vertices = timedBake(mesh, options);
    options.fit = transfer::Fit::kLeastSquares;
    const TimedBake fitted = timedBake(mesh, options);
    options.original = &original;
    const TimedBake to_original = timedBake(mesh, options);
    const double error = own.error(mesh, at_vertices.transfer.vectors, own.places());
    const double least = own.error(mesh, fitted.transfer.vectors, own.places());
    const double original_error = before.error(mesh, at_vertices.transfer.vectors, nearest);
    const double original_least = before.error(mesh, to_original.transfer.vectors, nearest);
    state.SetIterationTime(fitted.seconds);
    state.counters["interpolation_error"] = error;
    state.counters["interpolation_error_least_squares"] = least;
    state.counters["gain_percent"] = 100 * (1 - least / error);
    state.counters["original_error"] = original_error;
    state.counters["original_error_least_squares"] = original_least;
    state.counters["original_gain_percent"] = 100 * (1 - original_least / original_error);
    state.counters["vertices"] = static_cast<double>(mesh.vertexCount());
    state.counters["bake_s_vertices"] = at_vertices.seconds;
    state.counters["least_shown"] = fitted.transfer.fit.least_shown;
    state.counters["most_shown"] = fitted.transfer.fit.most_shown;
    state.counters["limited_vertices"] = static_cast<double>(fitted.transfer.fit.limited_vertices);
    state.counters["strayed_samples"] = static_cast<double>(to_original.transfer.fit.strayed_samples);
  }
}
BENCHMARK(leastSquares)
    ->Name("least_squares")
    ->Arg(21'596)
    ->Arg(10'800)
    ->Arg(4'000)
    ->ArgName("triangles")
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
