// Ways to store transfer in a pixel basis, at equal bytes: exact sums and sums within a bound beside plain rows, clustered principal components,
// Haar wavelets, adaptive 4-D wavelets and spherical harmonics (compression/).
//
//   bench_compression [Google Benchmark flags]
//
// The Stanford bunny at 3,286 vertices, or as many as BAKELIGHT_BENCH_TRIANGLES makes; 8 × 8 cells, a cube map of 6 × 32 × 32 texels, 2 × 2 subsamples. Each row is a
// method at a share of the bytes of the exact sums, in per cent (rows and sums: at what they take). bytes_percent: of rows × texels at a byte
// an entry; flops_percent: of 2 · entries; error_LIGHT: √(Σ |L* − exact L*|² ÷ Σ |exact L*|²) over all vertices, cells and colors under three
// probes and a sun of 2° over a sky; error: root of their mean square; product_ms: of three colors. `truth`: the same errors of exact
// rows from those of 8 × 8 subsamples, over a part of the vertices: what sampling errs.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "compression/clustered_rows.h"
#include "compression/coded_sums.h"
#include "compression/errors.h"
#include "compression/haar_rows.h"
#include "compression/harmonics.h"
#include "compression/wavelets_4d.h"
#include "formats/light_rig_file.h"
#include "formats/mesh_import.h"
#include "tools/simplify/simplify.h"
#include "tools/transfer/pixel_transfer.h"
#include "transport/cube_light.h"
#include "transport/morton.h"

namespace bakelight::compression {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kProducts = 15;

std::string dataFolder() {
  const char* folder = std::getenv("BAKELIGHT_DATA");
  return folder != nullptr ? folder : BAKELIGHT_DATA_DIR;
}

const formats::TriangleMesh& bunny() {
  static const formats::TriangleMesh mesh = [] {
    const char* triangles = std::getenv("BAKELIGHT_BENCH_TRIANGLES");
    simplify::SimplifyOptions options;
    options.triangles = triangles != nullptr ? std::atoi(triangles) : 6568;
    const std::string path = dataFolder() + "/models/bunny.obj";
    return simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
  }();
  return mesh;
}

struct Light {
  const char* name;
  std::vector<Radiance4> energies;
};

const std::vector<Light>& lights() {
  static const std::vector<Light> all = [] {
    std::vector<Light> result;
    const auto add = [&](const char* name, const formats::LightRig& rig) {
      result.push_back(
          {name, texelEnergies(transport::cubeLight(rig.distant, 32, Eigen::Matrix3d::Identity()), 32)});
    };
    for (const char* probe : {"courtyard", "studio", "sunrise"})
      add(probe, formats::readLights(dataFolder() + "/probes/" + probe + ".exr", {}));
    formats::LightRig sun;
    formats::DiskLight disk, sky;
    disk.direction = {-0.7F, 0.6F, 0.5F};
    disk.half_angle_deg = 1;
    disk.radiance = {2400, 2300, 2100};
    sky.half_angle_deg = 180;
    sky.radiance = {0.12F, 0.14F, 0.18F};
    sun.distant = {disk, sky};
    add("sun", sun);
    return result;
  }();
  return all;
}

struct Subject {
  formats::PixelRows rows = transfer::bakePixelTransfer(bunny(), {}).rows;
  std::vector<std::vector<Radiance4>> exact;  // a light
  WaveletRows haar;
  std::vector<std::uint32_t> order = transport::mortonOrder(bunny().positions);
  std::optional<CompressedTransfer> sums;

  Subject() : haar(haarRows(rows.view())) {
    for (const Light& light : lights()) {
      exact.emplace_back(rows.view().rowCount());
      transport::multiply(rows.view(), light.energies, exact.back());
    }
    sums = exactSums(rows.view());
  }
};
const Subject& subject() {
  static const Subject made;
  return made;
}

struct Method {
  const char* name;
  std::function<CompressedTransfer(std::uint64_t budget)> make;
};
const Method kMethods[] = {
    {"_rows", [](std::uint64_t) { return plainRows(subject().rows.view()); }},
    {"_sums", [](std::uint64_t) { return *subject().sums; }},
    {"_within", [](std::uint64_t budget) { return sumsWithin(budget, subject().rows.view()); }},
    {"_cpca",
     [](std::uint64_t budget) {
       constexpr int kComponents[] = {4, 8, 12};
       return clusteredWithin(budget, subject().rows.view(), kComponents);
     }},
    {"_haar",
     [](std::uint64_t budget) { return haarWithin(budget, subject().haar, Selection::kAreaWeighted); }},
    {"_haar_magnitude",
     [](std::uint64_t budget) { return haarWithin(budget, subject().haar, Selection::kMagnitude); }},
    {"_wavelets4d",
     [](std::uint64_t budget) { return wavelets4dWithin(budget, subject().haar, 8, subject().order); }},
    {"_harmonics", [](std::uint64_t budget) { return harmonicsWithin(budget, subject().rows.view(), 5); }},
};

void tellErrors(benchmark::State& state, const std::string& suffix,
                const std::function<double(std::size_t light)>& error_of) {
  double sum = 0;
  for (std::size_t i = 0; i < lights().size(); ++i) {
    const double error = error_of(i);
    state.counters[std::string("error_") + lights()[i].name + suffix] = error;
    sum += error * error;
  }
  state.counters["error" + suffix] = std::sqrt(sum / static_cast<double>(lights().size()));
}

// Arguments: the method, and the share of the exact sums' bytes in per cent.
void atBytes(benchmark::State& state) {
  const Method& method = kMethods[state.range(0)];
  const std::string suffix = method.name;
  const formats::PixelCodes codes = subject().rows.view();
  for (auto _ : state) {
    const auto budget = static_cast<std::uint64_t>(static_cast<double>(subject().sums->bytes) *
                                                   static_cast<double>(state.range(1)) / 100);
    const auto start = Clock::now();
    std::optional<CompressedTransfer> made;
    try {
      made = method.make(budget);
    } catch (const std::invalid_argument& error) {
      state.SkipWithError(error.what());
      break;
    }
    const CompressedTransfer& transfer = *made;
    state.SetIterationTime(std::chrono::duration<double>(Clock::now() - start).count());
    state.SetLabel(transfer.parameters);
    state.counters["bytes" + suffix] = static_cast<double>(transfer.bytes);
    state.counters["bytes_percent" + suffix] =
        100 * static_cast<double>(transfer.bytes) /
        (static_cast<double>(codes.rowCount()) * static_cast<double>(codes.columnCount()));
    state.counters["flops_percent" + suffix] =
        50 * static_cast<double>(transfer.operations) / static_cast<double>(codes.columns.size());
    tellErrors(state, suffix, [&](std::size_t i) {
      return relativeRms(transfer.incident(lights()[i].energies), subject().exact[i]);
    });
    std::vector<Radiance4> values(transfer.value_count);
    std::vector<double> times;
    for (int i = 0; i < kProducts; ++i) {
      const auto before = Clock::now();
      transfer.multiply(lights()[0].energies, values);
      times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - before).count());
    }
    std::nth_element(times.begin(), times.begin() + kProducts / 2, times.end());
    state.counters["product_ms" + suffix] = times[kProducts / 2];
  }
}
BENCHMARK(atBytes)
    ->Name("at_bytes")
    ->ArgNames({"method", "share"})
    ->Args({0, 100})
    ->Args({1, 100})
    ->ArgsProduct({{2}, {50, 25}})
    ->ArgsProduct({{3, 4, 5, 6, 7}, {100, 50, 25}})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void truth(benchmark::State& state) {
  for (auto _ : state) {
    constexpr std::size_t kPieces = 12, kPieceVertices = 16;
    const transfer::PixelBaker coarse(bunny(), {}), dense(bunny(), {.subsamples = 8});
    std::vector<std::vector<Radiance4>> of_coarse(lights().size()), of_dense(lights().size());
    for (std::size_t piece = 0; piece < kPieces; ++piece) {
      const std::size_t first = piece * (bunny().vertexCount() - kPieceVertices) / (kPieces - 1);
      const auto add = [&](const transfer::PixelBaker& baker, std::vector<std::vector<Radiance4>>& all) {
        const formats::PixelRows rows = baker.bake({first, first + kPieceVertices}).rows;
        std::vector<Radiance4> values(rows.view().rowCount());
        for (std::size_t i = 0; i < lights().size(); ++i) {
          transport::multiply(rows.view(), lights()[i].energies, values);
          all[i].insert(all[i].end(), values.begin(), values.end());
        }
      };
      add(coarse, of_coarse), add(dense, of_dense);
    }
    tellErrors(state, "_sampling", [&](std::size_t i) { return relativeRms(of_coarse[i], of_dense[i]); });
  }
}
BENCHMARK(truth)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight::compression

BENCHMARK_MAIN();
