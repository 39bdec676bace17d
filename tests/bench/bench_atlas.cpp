// Our atlas of the Stanford bunny, and xatlas's of the same triangles: how many charts, how full, how much
// stretch, how long; and what must hold exactly.
//
//   bench_atlas [Google Benchmark flags]
//   BAKELIGHT_BENCH_MESH=path        another mesh
//   BAKELIGHT_BENCH_TRIANGLES=n      another target of simplify (20000)
//   BAKELIGHT_BENCH_XATLAS=command   scripts/run-xatlas: the rival, in the same run (make bench-atlas)
//   BAKELIGHT_BENCH_LARGE=1          a rippled ball of 1,000,000 triangles, too: time and memory
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"
#include "tests/support/rippled_ball.h"
#include "tests/support/temporary_folder.h"
#include "tools/atlas/make_atlas.h"
#include "tools/atlas/maps/geometry_maps.h"
#include "tools/simplify/simplify.h"
#include "transport/vector_types.h"

namespace bakelight::atlas {
namespace {

constexpr int kResolution = 1024, kGutter = 2, kAreaResolution = 2048, kRounds = 3;

std::string environment(const char* name, const std::string& fallback) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : fallback;
}

const formats::TriangleMesh& simplified() {
  static const formats::TriangleMesh mesh = [] {
    const std::string path = environment("BAKELIGHT_BENCH_MESH", BAKELIGHT_DATA_DIR "/models/bunny.obj");
    simplify::SimplifyOptions options;
    options.triangles = std::stoi(environment("BAKELIGHT_BENCH_TRIANGLES", "20000"));
    return simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
  }();
  return mesh;
}

// The largest |Σ texel areas − surface area| ÷ surface area of any chart.
double largestAreaError(const Atlas& atlas) {
  const formats::Image maps = geometryMaps(atlas, {kAreaResolution, 0}, "bench");
  const auto area = static_cast<std::size_t>(maps.channelIndex("area")),
             chart = static_cast<std::size_t>(maps.channelIndex("chart"));
  std::vector<double> texels(atlas.chart_count, 0), surface(atlas.chart_count, 0);
  for (std::size_t i = 0; i < maps.values.size(); i += maps.channelCount())
    if (maps.values[i + chart] >= 0)
      texels[static_cast<std::size_t>(maps.values[i + chart])] += maps.values[i + area];
  for (std::size_t t = 0; t < atlas.mesh.triangleCount(); ++t) {
    const auto corner = [&](std::size_t k) {
      return transport::vec3(atlas.mesh.positions[atlas.mesh.triangles[t][k]]);
    };
    surface[atlas.triangle_charts[t]] += (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 2;
  }
  double largest = 0;
  for (std::size_t c = 0; c < texels.size(); ++c)
    largest = std::max(largest, std::abs(texels[c] - surface[c]) / surface[c]);
  return largest;
}

struct Rival {
  AtlasFigures figures;
  double seconds = 0, utilisation = 0;  // of its own rectangle
};

// Nothing if no command is given. Throws if it fails.
std::optional<Rival> rivalOf(const formats::TriangleMesh& mesh) {
  const std::string command = environment("BAKELIGHT_BENCH_XATLAS", "");
  if (command.empty()) return std::nullopt;
  const tests::TemporaryFolder folder;
  const std::filesystem::path in = folder / "in.ply", out = folder / "out.ply", told = folder / "told.json";
  formats::writePly(in, mesh);
  const std::string line = command + " " + in.string() + " " + out.string() + " " +
                           std::to_string(kResolution) + " " + std::to_string(kGutter) + " > " +
                           told.string();
  if (std::system(line.c_str()) != 0)
    throw Error(ExitStatus::kNotAvailable, {command, "", ""}, "xatlas could not be run");
  std::ifstream stream(told);
  const nlohmann::json json = nlohmann::json::parse(stream);
  const double width = json.at("width"), height = json.at("height"), side = std::max(width, height);
  Rival run;
  run.figures = check(atlasOf(formats::readPly(out)), static_cast<int>(side), "xatlas");
  run.utilisation = run.figures.utilisation * side * side / (width * height);
  run.seconds = json.at("seconds");
  return run;
}

// Once a process.
const std::optional<Rival>& rival() {
  static const std::optional<Rival> result = rivalOf(simplified());
  return result;
}

void print(const char* who, const AtlasFigures& f, double utilisation, double seconds) {
  std::printf(
      "%-15s %4lld charts  %.3f of the texels used  L2 stretch %.4f  largest of a chart %.4f  borders %.1f  "
      "gutter %d  defects %lld  %.2f s\n",
      who, static_cast<long long>(f.charts), utilisation, f.l2_stretch, f.worst_chart_l2, f.border_length,
      f.smallest_gutter, static_cast<long long>(f.defects()), seconds);
}

void run(benchmark::State& state, const char* name, double max_stretch) {
  const formats::TriangleMesh& mesh = simplified();
  AtlasOptions options;
  options.resolution = kResolution;
  options.gutter = kGutter;
  options.max_stretch = max_stretch;
  AtlasResult result;
  std::vector<double> seconds;
  for ([[maybe_unused]] const auto iteration : state) {
    const auto start = std::chrono::steady_clock::now();
    result = makeAtlas(mesh, {}, options, "bench");
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    state.SetIterationTime(seconds.back());
  }
  std::sort(seconds.begin(), seconds.end());
  const double median = seconds[seconds.size() / 2];
  const AtlasFigures& f = result.report.figures;
  print(name, f, f.utilisation, median);
  auto& counters = state.counters;
  counters["triangles"] = static_cast<double>(f.triangles);
  counters["charts"] = static_cast<double>(f.charts);
  counters["utilisation"] = f.utilisation;
  counters["l2_stretch"] = f.l2_stretch;
  counters["worst_chart_l2"] = f.worst_chart_l2;
  counters["seconds"] = median;
  counters["flipped"] = static_cast<double>(f.flipped);
  counters["collapsed"] = static_cast<double>(f.collapsed);
  counters["overlapping_texels"] = static_cast<double>(f.overlapping_texels);
  counters["crossing_edges"] = static_cast<double>(f.crossing_edges);
  counters["smallest_gutter"] = f.smallest_gutter;
  counters["chart_area_error"] = largestAreaError(result.atlas);
  for (const auto& [step, spent] : result.report.seconds) counters["seconds_" + step] = spent;
  if (const auto& other = rival()) {
    print("xatlas", other->figures, other->utilisation, other->seconds);
    counters["xatlas_charts"] = static_cast<double>(other->figures.charts);
    counters["xatlas_utilisation"] = other->utilisation;
    counters["xatlas_l2_stretch"] = other->figures.l2_stretch;
    counters["xatlas_seconds"] = other->seconds;
    counters["utilisation_ratio"] = f.utilisation / other->utilisation;
    counters["border_ratio"] = f.border_length / other->figures.border_length;
  }
}

// A larger mesh, once. Counters end in `suffix`.
void runLarge(benchmark::State& state, const formats::TriangleMesh& mesh, const std::string& suffix,
              bool has_rival) {
  AtlasOptions options;
  options.resolution = kResolution;
  options.gutter = kGutter;
  AtlasResult result;
  double seconds = 0;
  for ([[maybe_unused]] const auto iteration : state) {
    const auto start = std::chrono::steady_clock::now();
    result = makeAtlas(mesh, {}, options, "bench");
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
  }
  const AtlasFigures& f = result.report.figures;
  print(suffix.c_str(), f, f.utilisation, seconds);
  for (const std::string& warning : result.report.warnings) std::printf("  %s\n", warning.c_str());
  auto& counters = state.counters;
  counters["triangles_" + suffix] = static_cast<double>(f.triangles);
  counters["seconds_" + suffix] = seconds;
  counters["charts_" + suffix] = static_cast<double>(f.charts);
  counters["utilisation_" + suffix] = f.utilisation;
  counters["l2_stretch_" + suffix] = f.l2_stretch;
  counters["defects_" + suffix] = static_cast<double>(f.defects());
  counters["smallest_gutter_" + suffix] = f.smallest_gutter;
  for (const auto& [step, spent] : result.report.seconds) counters["seconds_" + step + "_" + suffix] = spent;
  if (const auto other = has_rival ? rivalOf(mesh) : std::nullopt) {
    print("xatlas", other->figures, other->utilisation, other->seconds);
    counters["xatlas_charts_" + suffix] = static_cast<double>(other->figures.charts);
    counters["xatlas_seconds_" + suffix] = other->seconds;
  }
}

void runBunny70k(benchmark::State& state) {
  runLarge(state, formats::importMesh(BAKELIGHT_DATA_DIR "/models/bunny.obj").mesh, "70k", true);
}

void runBall100k(benchmark::State& state) {
  runLarge(state, tests::rippledBall(100'000), "100k", true);
}

void runBall1M(benchmark::State& state) {
  runLarge(state, tests::rippledBall(1'000'000), "1m", false);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak_memory_bytes_1m"] = 1024.0 * static_cast<double>(usage.ru_maxrss);
}

BENCHMARK_CAPTURE(run, default, "default", kFewCharts)
    ->Name("atlas/default")
    ->Iterations(kRounds)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);
BENCHMARK_CAPTURE(run, low_distortion, "low distortion", kLowDistortion)
    ->Name("atlas/low_distortion")
    ->Iterations(kRounds)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);
BENCHMARK(runBunny70k)->Name("atlas/bunny_70k")->Iterations(1)->UseManualTime()->Unit(benchmark::kSecond);
BENCHMARK(runBall100k)->Name("atlas/ball_100k")->Iterations(1)->UseManualTime()->Unit(benchmark::kSecond);

void registerLarge() {
  if (environment("BAKELIGHT_BENCH_LARGE", "").empty()) return;
  benchmark::RegisterBenchmark("atlas/ball_1m", runBall1M)
      ->Iterations(1)
      ->UseManualTime()
      ->Unit(benchmark::kSecond);
}

}  // namespace
}  // namespace bakelight::atlas

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  try {
    bakelight::atlas::registerLarge();
    benchmark::RunSpecifiedBenchmarks();
  } catch (const bakelight::Error& error) {
    std::fprintf(stderr, "bench_atlas: %s\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
