// Glossy evaluation on the CPU beside what the machine can do at best: shade() of 25 × 25 RGB over the bunny
// of 10,800 vertices, for each storage and precision, on all cores.
//
// roofline_ratio = floor ÷ measured time; the floor is the larger of
//   bytes ÷ read bandwidth: tables, rows of the eye and radiance, once; the bandwidth is that of a plain
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
#include "tools/simplify/simplify.h"
#include "tools/transfer/transfer.h"
#include "transport/camera.h"
#include "transport/cpca.h"
#include "transport/glossy.h"
#include "transport/glossy_evaluator.h"
#include "transport/lights.h"

namespace bakelight {
namespace {

using formats::Float3;
using formats::MatrixStorage;
using formats::Precision;
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

// The bunny with frames and Phong's lobe of exponent 20; without tables.
const formats::Pack& bunny() {
  static const formats::Pack pack = [] {
    formats::Pack made;
    const std::filesystem::path path = data("models/bunny.obj");
    simplify::SimplifyOptions options;
    options.triangles = kTriangles;
    made.mesh = simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
    return made;
  }();
  return pack;
}

transfer::Transfer bake(transfer::Glossy glossy) {
  transfer::TransferOptions options;
  options.order = options.row_order = kOrder;
  options.directions = kDirections;
  options.glossy = glossy;
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  return transfer::bakeTransfer(bunny().mesh, {}, options, silent);
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

const transport::Cpca& cpca() {
  static const transport::Cpca made =
      transport::clusteredPca(matrices().matrices, kCells, {kClusters, kComponents, 12});
  return made;
}

formats::EncodedTable encode(std::span<const float> values, std::size_t columns, Precision precision) {
  return formats::encodeTable(values, columns, precision, "bench_runtime", "table");
}

formats::RadianceTransfer stored(MatrixStorage storage, Precision precision) {
  formats::RadianceTransfer transfer;
  transfer.order = transfer.row_order = kOrder;
  transfer.storage = storage;
  transfer.tangents = matrices().tangents;
  if (storage == MatrixStorage::kMatrix) transfer.matrices = encode(matrices().matrices, kCells, precision);
  if (storage == MatrixStorage::kVisibility)
    transfer.matrices = encode(visibility().visibility, (2 * kOrder - 1) * (2 * kOrder - 1), precision);
  if (storage == MatrixStorage::kCpca) {
    transfer.matrices = encode(cpca().weights, kComponents, precision);
    transfer.basis = encode(cpca().basis, kCells, precision);
    transfer.clusters = cpca().clusters;
  }
  return transfer;
}

const transport::ShLight& light() {
  static const transport::ShLight projected = [] {
    const std::filesystem::path path = data("probes/sunrise.exr");
    return transport::projectLatLong(formats::readImage(path), kOrder, path);
  }();
  return projected;
}

std::vector<float> eyeRows(bool object_frame, std::span<const std::uint32_t> vertex_order) {
  formats::Pack pack = bunny();
  pack.transfer.tangents = matrices().tangents;
  const transport::BoundingSphere sphere = transport::boundingSphere(pack.mesh);
  const transport::Vec3 eye = sphere.center + 3 * sphere.radius * transport::Vec3(0.3, 0.4, 1).normalized();
  return transport::lobeRows(pack, transport::phongKernel(kOrder, 20), eye, object_frame, vertex_order);
}

// Full matrices at single precision, summed in double.
std::vector<std::array<double, 3>> exactRadiance() {
  const transport::GlossyEvaluator order_of_tiles(stored(MatrixStorage::kMatrix, Precision::kFloat32));
  const std::vector<float> rows = eyeRows(false, order_of_tiles.vertexOrder());
  constexpr std::size_t kTile = transport::GlossyEvaluator::kTile;
  const std::size_t count = bunny().mesh.vertexCount(), n = kOrder * kOrder;
  std::vector<std::array<double, 3>> radiance(count);
  for (std::size_t v = 0; v < count; ++v)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t c = 0; c < 3; ++c)
          radiance[v][c] += double{rows[(v / kTile * n + i) * kTile + v % kTile]} *
                            matrices().matrices[v * kCells + i * n + j] * light()[j][c];
  return radiance;
}

double relativeError(std::span<const Float3> found) {
  static const std::vector<std::array<double, 3>> exact = exactRadiance();
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

void shade(benchmark::State& state, MatrixStorage storage, Precision precision) {
  const transport::GlossyEvaluator evaluator(stored(storage, precision));
  const std::vector<float> rows = eyeRows(storage == MatrixStorage::kVisibility, evaluator.vertexOrder());
  const std::size_t vertices = bunny().mesh.vertexCount();
  std::vector<Float3> radiance(vertices);

  const double bytes = static_cast<double>(evaluator.tableBytes() + rows.size() * sizeof(float) +
                                           radiance.size() * sizeof(Float3));
  const std::size_t buffer_size = static_cast<std::size_t>(bytes / sizeof(float)) / 64 * 64;
  const auto buffer = hwy::AllocateAligned<float>(buffer_size);
  std::fill_n(buffer.get(), buffer_size, 1.0f);

  // As many multiply-adds as the evaluation makes, so that waking the threads weighs the same in both.
  constexpr std::size_t kTrialSteps = 4096;
  float trial = 0;
  const auto chain_steps = static_cast<std::size_t>(
      std::lround(kTrialSteps * evaluator.multiplyAdds() / multiplyAddChains(kTrialSteps, trial)));

  for (auto _ : state) {
    std::vector<double> shade_s, read_s, chains_s;
    double chained = 0;
    float sink = 0;
    for (int round = 0; round < kRounds; ++round) {
      measure([&] { evaluator.shade(light(), rows, radiance); }, shade_s);
      measure([&] { sink += static_cast<float>(readSum({buffer.get(), buffer_size})); }, read_s);
      measure([&] { chained = multiplyAddChains(chain_steps, sink); }, chains_s);
    }
    benchmark::DoNotOptimize(sink);
    const double buffer_bytes = static_cast<double>(buffer_size * sizeof(float));
    const auto floors = [&](const auto& typical) {
      return std::pair(bytes / buffer_bytes * typical(read_s),
                       evaluator.multiplyAdds() / chained * typical(chains_s));
    };
    const double measured = median(shade_s);
    const auto [bytes_floor_s, sums_floor_s] = floors(median);
    const auto [best_bytes_floor_s, best_sums_floor_s] = floors(least);
    state.SetIterationTime(measured);
    state.counters["roofline_ratio"] = std::max(bytes_floor_s, sums_floor_s) / measured;
    state.counters["best_ratio"] = std::max(best_bytes_floor_s, best_sums_floor_s) / least(shade_s);
    state.counters["rel_error"] = relativeError(radiance);
    state.counters["bytes_per_vertex"] =
        static_cast<double>(evaluator.tableBytes()) / static_cast<double>(vertices);
    state.counters["gflop_per_s"] = 2e-9 * evaluator.multiplyAdds() / measured;
    state.counters["read_floor_ms"] = 1e3 * bytes_floor_s;
    state.counters["multiply_add_floor_ms"] = 1e3 * sums_floor_s;
    state.counters["read_gb_per_s"] = 1e-9 * bytes / bytes_floor_s;
    state.counters["peak_gflop_per_s"] = 2e-9 * evaluator.multiplyAdds() / sums_floor_s;
    state.counters["vertices"] = static_cast<double>(vertices);
    state.SetLabel(instructionSet());
  }
}

const bool registered = [] {
  for (const auto storage : {MatrixStorage::kMatrix, MatrixStorage::kVisibility, MatrixStorage::kCpca})
    for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
      const std::string name = std::string("shade/") + nameOf(storage) + "/" + nameOf(precision);
      benchmark::RegisterBenchmark(name.c_str(), shade, storage, precision)
          ->Iterations(1)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  return true;
}();

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
