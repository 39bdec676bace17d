// Our simplifier beside meshoptimizer's on the Stanford bunny: closeness to the original, shape of the
// triangles, time.
//
// And what a large scan takes: a rippled ball of a million triangles → 100,000, step by step.
//
//   bench_simplify [Google Benchmark flags]
//   BAKELIGHT_BENCH_MESH=path       another mesh
//   BAKELIGHT_BENCH_TRIANGLES=n     another target (20000)
//   BAKELIGHT_BENCH_THREADS=n       no more than n threads
#include <benchmark/benchmark.h>
#include <meshoptimizer.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "surface/metrics.h"
#include "surface/repair.h"
#include "tests/support/rippled_ball.h"
#include "tools/simplify/simplify.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

constexpr std::size_t kDenseSamples = 1'000'000;
constexpr std::size_t kLargeTriangles = 1'000'000;
constexpr int kLargeTarget = 100'000;

struct Outcome {
  WorkingMesh mesh;
  double seconds = 0;
  AngleQuality angles;
  Deviation deviation;  // ÷ bounding-box diagonal
  std::map<std::string, double> step_seconds;
};

std::string environment(const char* name, const std::string& fallback) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : fallback;
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// What both simplifiers start from: welded, so that meshoptimizer meets no seams either.
formats::TriangleMesh weldedMesh(const std::string& path) {
  WorkingMesh working = workingMesh(formats::importMesh(path).mesh);
  repair(working, 0);
  formats::TriangleMesh mesh;
  for (const Vec3& position : working.positions) mesh.positions.push_back(transport::float3(position));
  mesh.triangles = working.triangles;
  return mesh;
}

Outcome ours(const formats::TriangleMesh& mesh, int triangles) {
  SimplifyOptions options;
  options.triangles = triangles;
  const auto start = std::chrono::steady_clock::now();
  SimplifyResult result = simplify(mesh, options, "bench");
  Outcome outcome;
  outcome.seconds = secondsSince(start);
  outcome.mesh = workingMesh(result.mesh);
  outcome.step_seconds = std::move(result.report.seconds);
  outcome.deviation = result.report.deviation;
  return outcome;
}

Outcome meshoptimizers(const formats::TriangleMesh& mesh, int triangles) {
  Outcome outcome;
  std::vector<unsigned int> indices(3 * mesh.triangleCount());
  const auto start = std::chrono::steady_clock::now();
  const std::size_t count = meshopt_simplify(
      indices.data(), mesh.triangles[0].data(), indices.size(), mesh.positions[0].data(), mesh.vertexCount(),
      sizeof(formats::Float3), 3 * static_cast<std::size_t>(triangles), 1.0f);
  outcome.seconds = secondsSince(start);
  outcome.mesh = workingMesh(mesh);
  outcome.mesh.triangles.clear();
  for (std::size_t i = 0; i < count; i += 3)
    outcome.mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  // Only the vertices that are left, as the others would count as samples.
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> renumbered(mesh.vertexCount(), kUnused);
  std::vector<Vec3> used;
  for (Triangle& t : outcome.mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (renumbered[v] == kUnused)
        renumbered[v] = static_cast<std::uint32_t>(used.size()), used.push_back(outcome.mesh.positions[v]);
      v = renumbered[v];
    }
  }
  outcome.mesh.positions = std::move(used);
  return outcome;
}

void judge(Outcome& outcome, const SurfaceQuery& original) {
  outcome.angles = angleQuality(outcome.mesh);
  outcome.deviation = deviation(original, SurfaceQuery(outcome.mesh), kDenseSamples);
  const double diagonal = boundingBoxDiagonal(original.mesh());
  outcome.deviation.hausdorff /= diagonal;
  outcome.deviation.mean /= diagonal;
}

void print(const char* who, const Outcome& o) {
  std::printf(
      "%-14s %7zu triangles  Hausdorff %.3e  mean %.3e  min angle mean %.2f deg worst %.2f deg  %.3f s\n",
      who, o.mesh.triangles.size(), o.deviation.hausdorff, o.deviation.mean, o.angles.mean_min_angle_deg,
      o.angles.worst_min_angle_deg, o.seconds);
}

void countSeconds(benchmark::State& state, const Outcome& o) {
  state.SetIterationTime(o.seconds);
  state.counters["seconds"] = o.seconds;
  for (const auto& [step, seconds] : o.step_seconds) state.counters["seconds_" + step] = seconds;
}

void run(benchmark::State& state) {
  const std::string path = environment("BAKELIGHT_BENCH_MESH", BAKELIGHT_DATA_DIR "/models/bunny.obj");
  const int target = std::stoi(environment("BAKELIGHT_BENCH_TRIANGLES", "20000"));
  const formats::TriangleMesh mesh = weldedMesh(path);
  const SurfaceQuery original(workingMesh(mesh));
  for ([[maybe_unused]] const auto iteration : state) {
    Outcome a = ours(mesh, target), b = meshoptimizers(mesh, target);
    countSeconds(state, a);
    judge(a, original);
    judge(b, original);
    const double hausdorff_ratio = a.deviation.hausdorff / b.deviation.hausdorff;
    const double mean_ratio = a.deviation.mean / b.deviation.mean;
    print("simplify", a);
    print("meshoptimizer", b);
    std::printf("ratios         Hausdorff %.3f  mean distance %.3f  time %.1f\n", hausdorff_ratio, mean_ratio,
                a.seconds / b.seconds);
    state.counters["hausdorff_ratio"] = hausdorff_ratio;
    state.counters["mean_distance_ratio"] = mean_ratio;
    state.counters["triangles"] = static_cast<double>(a.mesh.triangles.size());
    state.counters["mean_min_angle_deg"] = a.angles.mean_min_angle_deg;
    state.counters["worst_min_angle_deg"] = a.angles.worst_min_angle_deg;
    state.counters["meshoptimizer_triangles"] = static_cast<double>(b.mesh.triangles.size());
    state.counters["meshoptimizer_mean_min_angle_deg"] = b.angles.mean_min_angle_deg;
    state.counters["meshoptimizer_worst_min_angle_deg"] = b.angles.worst_min_angle_deg;
    state.counters["meshoptimizer_seconds"] = b.seconds;
    state.counters["time_ratio"] = a.seconds / b.seconds;
  }
}

void runRippledBall(benchmark::State& state) {
  const formats::TriangleMesh mesh = tests::rippledBall(kLargeTriangles);
  for ([[maybe_unused]] const auto iteration : state) {
    const Outcome a = ours(mesh, kLargeTarget);
    countSeconds(state, a);
    state.counters["triangles_in"] = static_cast<double>(mesh.triangleCount());
    state.counters["triangles"] = static_cast<double>(a.mesh.triangles.size());
    const AngleQuality angles = angleQuality(a.mesh);
    state.counters["mean_min_angle_deg"] = angles.mean_min_angle_deg;
    state.counters["worst_min_angle_deg"] = angles.worst_min_angle_deg;
    state.counters["hausdorff"] = a.deviation.hausdorff;
    state.counters["mean_distance"] = a.deviation.mean;
  }
}

}  // namespace
}  // namespace bakelight::simplify

BENCHMARK(bakelight::simplify::run)
    ->Name("simplify")
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);
BENCHMARK(bakelight::simplify::runRippledBall)
    ->Name("simplify/rippled_ball")
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  try {
    const std::string threads = bakelight::simplify::environment("BAKELIGHT_BENCH_THREADS", "");
    std::optional<tbb::global_control> limit;
    if (!threads.empty()) limit.emplace(tbb::global_control::max_allowed_parallelism, std::stoul(threads));
    benchmark::RunSpecifiedBenchmarks();
  } catch (const bakelight::Error& error) {
    std::fprintf(stderr, "bench_simplify: %s\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
