// Shading of a glossy pack on the CPU, as `report` times it, beside what the machine can do at best: 25 × 25
// RGB over the bunny of 10,800 vertices, for each storage and precision, on all cores. light/…: a light
// change (VertexShading::setLight, diffuse part included); view/…: a view change (setView).
//
// roofline_ratio = floor ÷ measured time; the floor is the larger of
//   bytes ÷ read bandwidth: what the step reads and writes, once; the bandwidth is that of a plain
//     multi-threaded sum over a buffer of the same size;
//   multiply-adds ÷ their rate: those that the method cannot do without (docs/RUNTIME.md counts them); the
//     rate is that of independent chains in registers, on the same threads with the same instructions.
// The three run in turn within each round, each warmed by itself, and the ratio is that of the medians, as
// machines drift; best_ratio is that of the least times, for a machine with other work on it.
#include <benchmark/benchmark.h>
#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>

#include "formats/image.h"
#include "formats/mesh_import.h"
#include "formats/pack_contents.h"
#include "tests/bench/roofline.h"
#include "tests/support/pack_parts.h"
#include "tools/simplify/simplify.h"
#include "tools/transfer/cpca.h"
#include "tools/transfer/transfer.h"
#include "transport/camera.h"
#include "transport/glossy_evaluator.h"
#include "transport/lights.h"
#include "transport/vertex_shading.h"

namespace bakelight {
namespace {

using formats::Float3;
using formats::Precision;
using formats::Storage;
using Clock = std::chrono::steady_clock;

constexpr int kTriangles = 21596;  // about 10,800 vertices
constexpr int kOrder = 5;
constexpr int kDirections = 1024;  // the tables' values matter little here
constexpr int kClusters = 64, kComponents = 16;
constexpr int kRounds = 60;
constexpr int kRepeats = 4;  // of one kind in a round; the first warms the caches and is not counted

std::filesystem::path data(const std::string& path) {
  const char* folder = std::getenv("BAKELIGHT_DATA");
  return std::filesystem::path(folder != nullptr ? folder : BAKELIGHT_DATA_DIR) / path;
}

const formats::TriangleMesh& bunny() {
  static const formats::TriangleMesh mesh = [] {
    const std::filesystem::path path = data("models/bunny.obj");
    simplify::SimplifyOptions options;
    options.triangles = kTriangles;
    return simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
  }();
  return mesh;
}

transfer::Transfer bake(transfer::Glossy glossy) {
  transfer::TransferOptions options;
  options.order = options.row_order = kOrder;
  options.directions = kDirections;
  options.glossy = glossy;
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  return transfer::bakeTransfer(bunny(), {}, options, silent);
}

const transfer::Transfer& matrices() {
  static const transfer::Transfer baked = bake(transfer::Glossy::kMatrices);
  return baked;
}

const transfer::Transfer& visibility() {
  static const transfer::Transfer baked = bake(transfer::Glossy::kVisibility);
  return baked;
}

constexpr std::size_t kCells = kOrder * kOrder * kOrder * kOrder;

const transfer::Cpca& cpca() {
  static const transfer::Cpca made =
      transfer::clusteredPca(matrices().matrices, kCells, {kClusters, kComponents, 12});
  return made;
}

formats::EncodedTable encode(std::span<const float> values, std::size_t columns, Precision precision) {
  return formats::encodeTable(values, columns, precision, "bench_runtime", "table");
}

// With Phong's lobe of exponent 20.
formats::Pack packOf(Storage storage, Precision precision) {
  formats::Pack pack{.name = "bunny", .mesh = bunny()};
  formats::ShTransfer& transfer = pack.sh();
  transfer.order = kOrder;
  transfer.vectors = encode(matrices().vectors, kOrder * kOrder, Precision::kFloat32);
  formats::GlossyTransfer& glossy = makeGlossy(transfer, storage, kOrder);
  glossy.tangents = matrices().tangents;
  if (storage == Storage::kMatrix) glossy.vertexTable() = encode(matrices().matrices, kCells, precision);
  if (storage == Storage::kVisibility)
    glossy.vertexTable() = encode(visibility().visibility, (2 * kOrder - 1) * (2 * kOrder - 1), precision);
  if (storage == Storage::kCpca)
    glossy.transfer = formats::ClusteredOperator{encode(cpca().weights, kComponents, precision),
                                                 cpca().clusters, encode(cpca().basis, kCells, precision)};
  reflectionOf(pack) = formats::PhongLobe{20, {1, 1, 1}};
  return pack;
}

const transport::ShLight& light() {
  static const transport::ShLight projected = [] {
    const std::filesystem::path path = data("probes/sunrise.exr");
    return transport::projectLatLong(formats::readImage(path), kOrder, path);
  }();
  return projected;
}

transport::Vec3 eye() {
  const transport::BoundingSphere sphere = transport::boundingSphere(bunny());
  return sphere.center + 3 * sphere.radius * transport::Vec3(0.3, 0.4, 1).normalized();
}

// Against full matrices at single precision.
double relativeError(const transport::VertexShading& shading) {
  static const std::vector<Float3> exact = [] {
    transport::VertexShading full(packOf(Storage::kMatrix, Precision::kFloat32));
    full.setLight(light(), {});
    full.setView(eye());
    const auto radiance = full.vertexRadiance();
    return std::vector<Float3>(radiance.begin(), radiance.end());
  }();
  const std::span<const Float3> found = shading.vertexRadiance();
  double error = 0, norm = 0;
  for (std::size_t v = 0; v < exact.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) {
      error += std::pow(found[v][c] - exact[v][c], 2);
      norm += std::pow(exact[v][c], 2);
    }
  return std::sqrt(error / norm);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

double least(const std::vector<double>& values) {
  return *std::ranges::min_element(values);
}

// Seconds of each run but the first.
template <class Work>
void measure(const Work& work, std::vector<double>& seconds) {
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const auto start = Clock::now();
    work();
    if (repeat > 0) seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  }
}

// What one step cannot do without.
struct Floor {
  double bytes = 0, multiply_adds = 0;
};

Floor floorOf(const formats::Pack& pack, bool of_light) {
  const transport::GlossyEvaluator glossy(pack.sh());
  const auto vertices = static_cast<double>(pack.mesh.vertexCount());
  constexpr double kCoefficients = kOrder * kOrder;
  const double transferred = vertices * kCoefficients * sizeof(Float3), radiance = vertices * sizeof(Float3);
  if (of_light)
    return {static_cast<double>(glossy.tableBytes()) + vertices * kCoefficients * sizeof(float) +
                transferred + radiance,
            glossy.multiplyAdds() + vertices * kCoefficients * 3};
  // Positions, normals and tangents are read, too; basis functions take as many multiply-adds as their sum.
  return {transferred + 2 * radiance + vertices * (2 * sizeof(Float3) + sizeof(formats::Float4)),
          vertices * kCoefficients * (3 + 1)};
}

void shade(benchmark::State& state, bool of_light, Storage storage, Precision precision) {
  const formats::Pack pack = packOf(storage, precision);
  transport::VertexShading shading(pack);
  shading.setLight(light(), {});
  const transport::Vec3 from = eye();
  const Floor floor = floorOf(pack, of_light);

  const std::size_t buffer_size = static_cast<std::size_t>(floor.bytes / sizeof(float)) / 64 * 64;
  const auto buffer = hwy::AllocateAligned<float>(buffer_size);
  std::fill_n(buffer.get(), buffer_size, 1.0f);

  // As many multiply-adds as the step makes, so that waking the threads weighs the same in both.
  constexpr std::size_t kTrialSteps = 4096;
  float trial = 0;
  const auto chain_steps = static_cast<std::size_t>(std::max<long>(
      1, std::lround(kTrialSteps * floor.multiply_adds / multiplyAddChains(kTrialSteps, trial))));

  for (auto _ : state) {
    std::vector<double> step_s, read_s, chains_s;
    double chained = 0;
    float sink = 0;
    for (int round = 0; round < kRounds; ++round) {
      measure([&] { of_light ? shading.setLight(light(), {}) : shading.setView(from); }, step_s);
      measure([&] { sink += static_cast<float>(readSum({buffer.get(), buffer_size})); }, read_s);
      measure([&] { chained = multiplyAddChains(chain_steps, sink); }, chains_s);
    }
    benchmark::DoNotOptimize(sink);
    const double buffer_bytes = static_cast<double>(buffer_size * sizeof(float));
    const auto floors = [&](const auto& typical) {
      return std::pair(floor.bytes / buffer_bytes * typical(read_s),
                       floor.multiply_adds / chained * typical(chains_s));
    };
    const double measured = median(step_s);
    const auto [bytes_floor_s, sums_floor_s] = floors(median);
    const auto [best_bytes_floor_s, best_sums_floor_s] = floors(least);
    state.SetIterationTime(measured);
    state.counters["roofline_ratio"] = std::max(bytes_floor_s, sums_floor_s) / measured;
    state.counters["best_ratio"] = std::max(best_bytes_floor_s, best_sums_floor_s) / least(step_s);
    shading.setView(from);
    state.counters["rel_error"] = relativeError(shading);
    state.counters["bytes_per_vertex"] = floor.bytes / static_cast<double>(pack.mesh.vertexCount());
    state.counters["gflop_per_s"] = 2e-9 * floor.multiply_adds / measured;
    state.counters["read_floor_ms"] = 1e3 * bytes_floor_s;
    state.counters["multiply_add_floor_ms"] = 1e3 * sums_floor_s;
    state.counters["read_gb_per_s"] = 1e-9 * floor.bytes / bytes_floor_s;
    state.counters["peak_gflop_per_s"] = 2e-9 * floor.multiply_adds / sums_floor_s;
    state.counters["vertices"] = static_cast<double>(pack.mesh.vertexCount());
    state.SetLabel(instructionSet());
  }
}

const bool registered = [] {
  for (const bool of_light : {true, false})
    for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca})
      for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
        // Transferred radiance is float32 whatever it came from: one view change is as another.
        if (!of_light && (storage == Storage::kCpca || precision != Precision::kFloat32)) continue;
        const std::string name =
            std::string(of_light ? "light/" : "view/") + nameOf(storage) + "/" + nameOf(precision);
        benchmark::RegisterBenchmark(name.c_str(), shade, of_light, storage, precision)
            ->Iterations(1)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
      }
  return true;
}();

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
