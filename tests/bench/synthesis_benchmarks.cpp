#include "synthesis_benchmarks.h"

#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "formats/image.h"
#include "tests/support/exemplars.h"
#include "tests/support/painted_picture.h"
#include "tests/support/rippled_ball.h"
#include "tests/support/textured_surface.h"
#include "tools/mesomesh/synthesis/synthesize.h"

namespace bakelight::mesomesh {
namespace {

std::string environment(const char* name, const std::string& fallback) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : fallback;
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

using Surfaces = std::function<const SynthesisSurface&(int)>;

void count(benchmark::State& state, const SynthesisQuality& quality) {
  state.counters["neighbourhood_error"] = quality.neighborhood_error;
  state.counters["neighbourhood_error_ratio"] = quality.neighborhood_error_ratio;
  state.counters["random_ratio"] = quality.random_ratio;
  state.counters["coherent_share"] = quality.coherent_share;
  state.counters["coverage"] = quality.coverage;
  state.counters["entropy"] = quality.entropy;
  state.counters["seam_ratio"] = quality.seam_ratio;
  state.counters["seam_vertices"] = static_cast<double>(quality.seam_vertices);
}

void runLarge(benchmark::State& state, const Surfaces& surfaces, const std::string& name,
              const formats::Image& image) {
  const int folds = makeExemplar(image, {}, name).symmetry.folds();
  const auto& [surface, on_seam] = surfaces(folds);
  for ([[maybe_unused]] const auto iteration : state) {
    SynthesisOptions options;
    options.folds = static_cast<FieldFolds>(folds);
    options.on_seam = on_seam;
    options.measure_quality = false;
    const auto start = std::chrono::steady_clock::now();
    const std::vector<Exemplar> exemplars = {makeExemplar(image, {}, name)};
    const PatchCoordinates patch = synthesize(surface.view(), exemplars, options);
    const double seconds = secondsSince(start);
    state.SetIterationTime(seconds);
    state.counters["synthesis_seconds"] = seconds;
    const auto vertices = static_cast<double>(surface.mesh.vertexCount());
    state.counters["vertices"] = vertices;
    state.counters["vertices_per_second_and_core"] =
        vertices / seconds / tbb::this_task_arena::max_concurrency();
    state.counters["levels"] = static_cast<double>(patch.report.levels.size());
    state.counters["retained_variance"] = patch.report.levels[0].retained_variance;
    count(state, qualityOf(surface.view(), exemplars, options, patch.coordinates));
    const std::string folder = environment("BAKELIGHT_BENCH_PICTURES", "");
    if (folder.empty()) continue;
    const formats::TriangleMesh mesh = tests::painted(surface, image, patch.coordinates);
    for (const double yaw_deg : {30.0, 210.0})
      formats::writePng(std::filesystem::path(folder) / (name + (yaw_deg < 180 ? "_front.png" : "_back.png")),
                        tests::paintedPicture(mesh, 1400, yaw_deg));
    formats::writePng(std::filesystem::path(folder) / (name + "_near.png"),
                      tests::paintedPicture(mesh, 1400, 30, 4));
  }
}

// What figures mean: places at random, a tiling, the exhaustive search.
void runRandom(benchmark::State& state, const Surfaces& surfaces, const std::string& name,
               const formats::Image& image) {
  const tests::TexturedSurface& surface = surfaces(1).surface;
  for ([[maybe_unused]] const auto iteration : state) {
    std::vector<formats::Float2> coordinates(surface.mesh.vertexCount());
    for (std::size_t v = 0; v < coordinates.size(); ++v)
      coordinates[v] = {static_cast<float>(tests::hashedUnit(1, v)),
                        static_cast<float>(tests::hashedUnit(2, v))};
    const std::vector<Exemplar> exemplars = {makeExemplar(image, {}, name)};
    count(state, qualityOf(surface.view(), exemplars, {}, coordinates));
  }
}

void runFlatTorus(benchmark::State& state, const std::string& name, const formats::Image& image) {
  const tests::TexturedSurface surface = tests::flatTorus(256);
  for ([[maybe_unused]] const auto iteration : state) {
    SynthesisOptions options;
    options.randomness = 0;
    const std::vector<Exemplar> exemplars = {
        makeExemplar(image, {.periodic = true, .texel_size = 1.0}, name)};
    count(state, synthesize(surface.view(), exemplars, options).report.quality);
  }
}

void runFull(benchmark::State& state, const std::string& name, const formats::Image& image,
             SynthesisMethod method) {
  const tests::TexturedSurface surface = tests::texturedSurface(tests::rippledBall(4000));
  for ([[maybe_unused]] const auto iteration : state) {
    SynthesisOptions options;
    options.method = method;
    const std::vector<Exemplar> exemplars = {makeExemplar(image, {}, name)};
    count(state, synthesize(surface.view(), exemplars, options).report.quality);
  }
}

}  // namespace

void registerSynthesis(const Surfaces& surfaces) {
  const auto once = [](const std::string& name, const auto& run) {
    return benchmark::RegisterBenchmark(name.c_str(), run)->Iterations(1)->Unit(benchmark::kSecond);
  };
  for (const auto& [name, image] : {std::pair<std::string, formats::Image>{"weave", tests::weave()},
                                    {"stones", tests::stones()},
                                    {"stochastic", tests::stochastic()}}) {
    once("synthesis/" + name, [=](benchmark::State& state) {
      runLarge(state, surfaces, name, image);
    })->UseManualTime();
    once("control_random/" + name, [=](benchmark::State& state) { runRandom(state, surfaces, name, image); });
    once("control_flat_torus/" + name, [=](benchmark::State& state) { runFlatTorus(state, name, image); });
    once("control_small/" + name,
         [=](benchmark::State& state) { runFull(state, name, image, SynthesisMethod::kCoherent); });
    once("control_full/" + name,
         [=](benchmark::State& state) { runFull(state, name, image, SynthesisMethod::kFull); });
  }
}

}  // namespace bakelight::mesomesh
