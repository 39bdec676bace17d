// Retiling of the Stanford bunny to 960,000 vertices, and CGAL's isotropic remeshing of the same mesh to as
// many, in the same run.
//
//   bench_mesomesh [Google Benchmark flags]
//   BAKELIGHT_BENCH_MESH=path         another mesh
//   BAKELIGHT_BENCH_CGAL_ITERATIONS=n of the rival (1); 0 leaves it out
//   BAKELIGHT_BENCH_LARGE=1           60,000 to 4,000,000 vertices, too: how time and memory grow
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "cgal_remesh.h"
#include "formats/error.h"
#include "formats/mesh_import.h"
#include "tools/mesomesh/field/direction_field.h"
#include "tools/mesomesh/retile/retile.h"

namespace bakelight::mesomesh {
namespace {

constexpr std::int64_t kVertices = 960'000;

std::string environment(const char* name, const std::string& fallback) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : fallback;
}

const formats::TriangleMesh& bunny() {
  static const formats::TriangleMesh mesh =
      formats::importMesh(environment("BAKELIGHT_BENCH_MESH", BAKELIGHT_DATA_DIR "/models/bunny.obj")).mesh;
  return mesh;
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void run(benchmark::State& state, std::int64_t vertices, bool has_rival) {
  RetileOptions options;
  options.vertices = vertices;
  double retile_seconds = 0, field_seconds = 0;
  RetiledMesh result;
  DirectionField field;
  for ([[maybe_unused]] const auto iteration : state) {
    const auto start = std::chrono::steady_clock::now();
    result = retile(bunny(), options, "bench");
    retile_seconds = secondsSince(start);
    const auto field_start = std::chrono::steady_clock::now();
    field = directionField(result.mesh, {4, options.crease_angle_deg}, {}, "");
    field_seconds = secondsSince(field_start);
    state.SetIterationTime(retile_seconds + field_seconds);
  }
  const RetileReport& report = result.report;
  auto& counters = state.counters;
  counters["vertices"] = static_cast<double>(report.vertices);
  counters["retile_seconds"] = retile_seconds;
  counters["quality"] = report.mean_quality;
  counters["least_quality"] = report.least_quality;
  counters["six_neighbors"] = report.six_neighbors;
  counters["largest_deviation"] = report.largest_deviation;
  counters["folded"] = static_cast<double>(report.folded_triangles);
  counters["field_seconds"] = field_seconds;
  counters["singularities"] = static_cast<double>(field.singularities.size());
  counters["vertices_per_s"] = static_cast<double>(report.vertices) / retile_seconds;
  for (const auto& [step, spent] : report.seconds) counters["seconds_" + step] = spent;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  counters["peak_memory_bytes"] = 1024.0 * static_cast<double>(usage.ru_maxrss);
  std::printf("ours  %lld vertices  quality %.4f  %.2f s, field %.2f s\n",
              static_cast<long long>(report.vertices), report.mean_quality, retile_seconds, field_seconds);
  const int iterations = std::stoi(environment("BAKELIGHT_BENCH_CGAL_ITERATIONS", "1"));
  if (!has_rival || iterations < 1) return;
  const tests::CgalTiling rival =
      tests::cgalRemeshing(bunny(), static_cast<double>(vertices), static_cast<unsigned>(iterations));
  counters["cgal_vertices"] = rival.vertices;
  counters["cgal_seconds"] = rival.seconds;
  counters["cgal_quality"] = rival.mean_quality;
  std::printf("CGAL  %.0f vertices  quality %.4f  %.2f s, %d iterations\n", rival.vertices,
              rival.mean_quality, rival.seconds, iterations);
}

void registerAll() {
  const auto add = [](const std::string& name, std::int64_t vertices, bool has_rival) {
    benchmark::RegisterBenchmark(name.c_str(),
                                 [=](benchmark::State& state) { run(state, vertices, has_rival); })
        ->Iterations(1)
        ->UseManualTime()
        ->Unit(benchmark::kSecond);
  };
  // From few to many: the peak of memory is the process's.
  if (!environment("BAKELIGHT_BENCH_LARGE", "").empty())
    for (const int vertices : {60'000, 240'000, 960'000, 2'000'000, 4'000'000})
      add("mesomesh/size/" + std::to_string(vertices), vertices, false);
  add("mesomesh/bunny", kVertices, true);
}

}  // namespace
}  // namespace bakelight::mesomesh

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  try {
    bakelight::mesomesh::registerAll();
    benchmark::RunSpecifiedBenchmarks();
  } catch (const bakelight::Error& error) {
    std::fprintf(stderr, "bench_mesomesh: %s\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
