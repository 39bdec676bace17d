// The Stanford bunny with 960,000 vertices: retiling, and CGAL's isotropic remeshing of the same mesh to as many;
// then three exemplars laid out over it, with the figures of quality, and what these figures are for places at
// random, for a tiling of a flat torus and for the exhaustive search (controls).
//
//   bench_mesomesh [Google Benchmark flags]
//   BAKELIGHT_BENCH_MESH=path         another mesh
//   BAKELIGHT_BENCH_CGAL_ITERATIONS=n of the rival (1); 0 leaves it out
//   BAKELIGHT_BENCH_THREADS=n         no more than n threads
//   BAKELIGHT_BENCH_PICTURES=folder   pictures of what was laid out
//   BAKELIGHT_BENCH_LARGE=1           60,000 to 4,000,000 vertices, too: how time and memory grow
#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "cgal_remesh.h"
#include "formats/error.h"
#include "formats/mesh_import.h"
#include "synthesis_benchmarks.h"
#include "tools/atlas/make_atlas.h"
#include "tools/mesomesh/field/direction_field.h"
#include "tools/mesomesh/retile/retile.h"
#include "tools/simplify/simplify.h"
#include "transport/surface_query.h"
#include "transport/vector_types.h"

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

// Of each vertex, whether an edge joins it to another chart of an atlas of the simplified mesh.
std::vector<std::uint8_t> besideCuts(const formats::TriangleMesh& mesh) {
  simplify::SimplifyOptions simplification;
  simplification.triangles = 20'000;
  const atlas::Atlas atlas =
      atlas::makeAtlas(simplify::simplify(bunny(), simplification, "bench").mesh, {}, {}, "bench").atlas;
  transport::SurfaceMesh surface;
  for (const formats::Float3& p : atlas.mesh.positions) surface.positions.push_back(transport::vec3(p));
  surface.triangles = atlas.mesh.triangles;
  const transport::SurfaceQuery query(std::move(surface));
  std::vector<std::uint32_t> charts(mesh.vertexCount());
  tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t v) {
    const transport::ClosestPoint point =
        query.closestFacing(transport::vec3(mesh.positions[v]), transport::vec3(mesh.normals[v]));
    charts[v] = point.valid ? atlas.triangle_charts[point.triangle] : ~0U;
  });
  std::vector<std::uint8_t> beside(charts.size(), 0);
  for (const formats::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (charts[t[k]] != charts[t[(k + 1) % 3]]) beside[t[k]] = beside[t[(k + 1) % 3]] = 1;
  return beside;
}

const SynthesisSurface& retiledBunny(int folds) {
  static const RetiledMesh retiled = [] {
    RetileOptions options;
    options.vertices = kVertices;
    return retile(bunny(), options, "bench");
  }();
  static const std::vector<std::uint8_t> beside = besideCuts(retiled.mesh);
  static std::map<int, SynthesisSurface> surfaces;
  SynthesisSurface& made = surfaces[folds];
  if (made.on_seam.empty()) {
    made.surface.mesh = retiled.mesh;
    made.surface.tangents =
        directionField(retiled.mesh, {folds, RetileOptions().crease_angle_deg}, {}, "").tangents;
    made.surface.exemplars.assign(retiled.mesh.vertexCount(), 0);
    made.on_seam = beside;
  }
  return made;
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
  registerSynthesis(retiledBunny);
}

}  // namespace
}  // namespace bakelight::mesomesh

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  try {
    const std::string threads = bakelight::mesomesh::environment("BAKELIGHT_BENCH_THREADS", "");
    std::optional<tbb::global_control> limit;
    if (!threads.empty()) limit.emplace(tbb::global_control::max_allowed_parallelism, std::stoul(threads));
    bakelight::mesomesh::registerAll();
    benchmark::RunSpecifiedBenchmarks();
  } catch (const bakelight::Error& error) {
    std::fprintf(stderr, "bench_mesomesh: %s\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
