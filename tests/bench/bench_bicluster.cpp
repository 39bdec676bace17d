// Transfer in a pixel basis, compressed: how few operations and bytes, how fast the product, and whether it is exact.
//
//   bench_bicluster [Google Benchmark flags]
//
// The Stanford bunny at 3,286, 12,380 and about 34,800 vertices, a flat scene and a curved one; 8 × 8 cells, a cube map of 6 × 32 × 32 texels,
// 2 × 2 subsamples. flops_percent: operations as the paper counts them (its equation 7), of 2 · entries; executed_percent: those that
// are really done. bytes_percent: the file's, of rows × texels; csr_speedup: (seconds of the rows as they are, 8-bit codes and 16-bit
// columns, by the faster of two kernels) ÷ (seconds of the sums), RGB, all cores (a millisecond's work, of which waking the others is a
// part), medians of runs in turn; csr_speedup_one_core the same on one. bytes_moved_ratio: (bytes that
// the product reads and writes ÷ the rate at which this machine reads memory) ÷ its seconds. The figures of the bunny at 3,286
// vertices have no suffix. `greedy` is the published method: ten seconds at 3,286 vertices, on one core. `player`: the same products by
// the player's compute shaders on the GL driver that is there, waited for; gpu_csr_speedup as csr_speedup. `shading`: light changes of
// transport::AllFrequencyShading, with the projection onto a Lambertian surface.
#include <benchmark/benchmark.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compression/shared_sums.h"
#include "compression/tolerance.h"
#include "formats/mesh_import.h"
#include "formats/sum_grammar_file.h"
#include "tests/bench/roofline.h"
#include "tests/support/rippled_ball.h"
#include "tools/bicluster/greedy.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/techniques/pixel_product.h"
#include "tools/simplify/simplify.h"
#include "tools/transfer/pixel_transfer.h"
#include "transport/all_frequency_shading.h"
#include "transport/sum_product.h"

namespace bakelight::bicluster {
namespace {

using compression::bytesInMemory;
using compression::compress;
using compression::operationsOf;
using compression::reconstructionErrors;
using compression::TolerantRows;
using compression::withinTolerance;
using formats::PixelCodes;
using formats::PixelRows;
using formats::TriangleMesh;
using transport::Radiance4;
using transport::Vec3;
using Clock = std::chrono::steady_clock;

constexpr int kRounds = 31;

double secondsOf(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TriangleMesh bunny(int triangles) {
  const char* folder = std::getenv("BAKELIGHT_DATA");
  const std::string path = std::string(folder != nullptr ? folder : BAKELIGHT_DATA_DIR) + "/models/bunny.obj";
  simplify::SimplifyOptions options;
  options.triangles = triangles;
  return simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
}

// A face of squares; `u` × `v` points out.
void addRectangle(TriangleMesh& mesh, const Vec3& corner, const Vec3& u, const Vec3& v, int squares) {
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  const std::uint32_t across = static_cast<std::uint32_t>(squares) + 1;
  for (std::uint32_t j = 0; j < across; ++j)
    for (std::uint32_t i = 0; i < across; ++i) {
      mesh.positions.push_back(transport::float3(corner + u * i / squares + v * j / squares));
      mesh.normals.push_back(transport::float3(u.cross(v).normalized()));
    }
  for (std::uint32_t j = 0; j + 1 < across; ++j)
    for (std::uint32_t i = 0; i + 1 < across; ++i) {
      const std::uint32_t at = first + j * across + i;
      mesh.triangles.push_back({at, at + 1, at + across + 1});
      mesh.triangles.push_back({at, at + across + 1, at + across});
    }
}

// A floor with a hall of columns on it: few normals, and hard edges against the sky.
TriangleMesh hall() {
  TriangleMesh mesh;
  const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  addRectangle(mesh, Vec3(-4, 0, 4), 8 * x, -8 * z, 30);
  for (int i = 0; i < 9; ++i) {
    const Vec3 corner(-3.1 + 3 * (i % 3), 0, -3.1 + 3 * (i / 3));
    const double height = 1 + 0.3 * i, width = 0.6;
    addRectangle(mesh, corner + width * z, width * x, height * y, 7);
    addRectangle(mesh, corner + width * x, -width * x, height * y, 7);
    addRectangle(mesh, corner + width * x + width * z, -width * z, height * y, 7);
    addRectangle(mesh, corner, width * z, height * y, 7);
    addRectangle(mesh, corner + height * y + width * z, width * x, -width * z, 7);
  }
  return mesh;
}

TriangleMesh ball() {
  return simplify::simplify(tests::rippledBall(7000), {.triangles = 6600}, "ball").mesh;
}

struct Scene {
  const char* suffix;
  std::function<TriangleMesh()> mesh;
};
const Scene kScenes[] = {{"", [] { return bunny(6568); }},
                         {"_12380", [] { return bunny(24756); }},
                         {"_34840", [] { return bunny(1 << 24); }},
                         {"_flat", [] { return hall(); }},
                         {"_curved", [] { return ball(); }}};

const PixelRows& rowsOf(int scene) {
  static std::optional<PixelRows> rows[std::size(kScenes)];
  if (!rows[scene]) rows[scene] = transfer::bakePixelTransfer(kScenes[scene].mesh(), {}).rows;
  return *rows[scene];
}

std::vector<Radiance4> someLight(std::size_t texels) {
  std::vector<Radiance4> light(texels);
  for (std::size_t k = 0; k < texels; ++k)
    light[k] = Radiance4(1, 0.7F, 0.4F, 0) * (1 + 0.01F * static_cast<float>(k * 7919 % 1000));
  return light;
}

// The other kernel for rows as they are: light by code, added without multiplications.
void addTabled(const PixelCodes& codes, std::span<const Radiance4> light, std::span<Radiance4> values) {
  const std::size_t full = static_cast<std::size_t>(codes.subsamples) * codes.subsamples,
                    texels = light.size();
  std::vector<Radiance4> tabled(texels * (full + 1));
  for (std::size_t code = 1; code <= full; ++code)
    for (std::size_t k = 0; k < texels; ++k)
      tabled[code * texels + k] = light[k] * (static_cast<float>(code) / static_cast<float>(full));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, codes.rowCount(), 2048), [&](const auto& range) {
    for (std::size_t row = range.begin(); row < range.end(); ++row) {
      Radiance4 even = Radiance4::Zero(), odd = Radiance4::Zero();
      std::uint64_t i = codes.row_offsets[row];
      const std::uint64_t end = codes.row_offsets[row + 1];
      for (; i + 1 < end; i += 2) {
        even += tabled[codes.codes[i] * texels + codes.columns[i]];
        odd += tabled[codes.codes[i + 1] * texels + codes.columns[i + 1]];
      }
      if (i < end) even += tabled[codes.codes[i] * texels + codes.columns[i]];
      values[row] = even + odd;
    }
  });
}

// Bytes a second.
double readingRate() {
  const std::vector<Radiance4> buffer(std::size_t{1} << 24, Radiance4::Ones());
  std::vector<double> seconds;
  for (int i = 0; i < 5; ++i)
    seconds.push_back(secondsOf([&] {
      benchmark::DoNotOptimize(readSum({buffer[0].data(), 4 * buffer.size()}));
    }));
  return 16.0 * static_cast<double>(buffer.size()) / median(seconds);
}

void figures(benchmark::State& state, const std::string& suffix, const PixelCodes& codes, double operations,
             double bytes) {
  const double entries = static_cast<double>(codes.columns.size());
  state.counters["flops_percent" + suffix] = 100 * operations / (2 * entries);
  state.counters["bytes_percent" + suffix] =
      100 * bytes / (static_cast<double>(codes.rowCount()) * static_cast<double>(codes.columnCount()));
}

struct ProductSeconds {
  double sums = 0, csr = 0;
};
ProductSeconds productSeconds(const PixelCodes& codes, const formats::SumGrammar& grammar) {
  const std::vector<Radiance4> light = someLight(codes.columnCount());
  std::vector<Radiance4> sums(grammar.row_places.size()), rows(codes.rowCount());
  std::vector<double> ours, multiplied, tabled;
  for (int round = 0; round < kRounds; ++round) {
    ours.push_back(secondsOf([&] { transport::multiply(grammar, light, sums); }));
    multiplied.push_back(secondsOf([&] { transport::multiply(codes, light, rows); }));
    tabled.push_back(secondsOf([&] { addTabled(codes, light, rows); }));
  }
  return {median(ours), std::min(median(multiplied), median(tabled))};
}

void product(benchmark::State& state, const std::string& suffix, const PixelCodes& codes,
             const formats::SumGrammar& grammar) {
  const ProductSeconds all = productSeconds(codes, grammar);
  state.counters["csr_speedup" + suffix] = all.csr / all.sums;
  state.counters["product_ms" + suffix] = 1e3 * all.sums;
  state.counters["csr_ms" + suffix] = 1e3 * all.csr;
  const auto moved = static_cast<double>(bytesInMemory(grammar) + 16 * grammar.row_places.size());
  state.counters["bytes_moved_ratio" + suffix] = moved / readingRate() / all.sums;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const ProductSeconds alone = productSeconds(codes, grammar);
  state.counters["csr_speedup_one_core" + suffix] = alone.csr / alone.sums;
}

void sums(benchmark::State& state) {
  const auto scene = static_cast<int>(state.range(0));
  const std::string suffix = kScenes[scene].suffix;
  const PixelCodes codes = rowsOf(scene).view();
  for (auto _ : state) {
    std::vector<double> seconds;
    formats::SumGrammar grammar;
    for (int round = 0; round < 3; ++round) seconds.push_back(secondsOf([&] { grammar = compress(codes); }));
    state.SetIterationTime(median(seconds));
    state.counters["compress_seconds" + suffix] = median(seconds);
    const formats::TensorFile file = formats::encodeSumGrammar(grammar);
    formats::SumGrammar loaded;
    state.counters["load_seconds" + suffix] =
        secondsOf([&] { loaded = formats::decodeSumGrammar(file, ""); });
    state.counters["reconstruction_errors" + suffix] =
        static_cast<double>(reconstructionErrors(loaded, codes));
    figures(state, suffix, codes, static_cast<double>(operationsOf(grammar).counted),
            static_cast<double>(formats::encodedBytes(file)));
    state.counters["executed_percent" + suffix] = 50.0 * static_cast<double>(operationsOf(grammar).executed) /
                                                  static_cast<double>(codes.columns.size());
    state.counters["memory_bytes" + suffix] = static_cast<double>(bytesInMemory(grammar));
    state.counters["vertices" + suffix] =
        static_cast<double>(codes.rowCount()) / (codes.local_side * codes.local_side);
    product(state, suffix, codes, loaded);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    state.counters["thread_differences" + suffix] =
        formats::encodeSafetensors(formats::encodeSumGrammar(compress(codes))) ==
                formats::encodeSafetensors(file)
            ? 0
            : 1;
  }
}
BENCHMARK(sums)->Name("sums")->DenseRange(0, 4)->Iterations(1)->UseManualTime()->Unit(
    benchmark::kMillisecond);

void player(benchmark::State& state) {
  const auto scene = static_cast<int>(state.range(0));
  const std::string suffix = kScenes[scene].suffix;
  const PixelCodes codes = rowsOf(scene).view();
  const formats::SumGrammar grammar = compress(codes);
  const bakelight::player::HeadlessContext context;
  const bakelight::player::SumProduct sum_product(grammar);
  const bakelight::player::RowProduct row_product(codes);
  const std::vector<formats::Float3> light(codes.columnCount(), formats::Float3{1, 0.7F, 0.4F});
  const bakelight::player::Buffer texels =
      bakelight::player::makeBuffer(light.size() * sizeof(light[0]), light.data());
  const bakelight::player::Buffer incident =
      bakelight::player::makeBuffer(codes.rowCount() * sizeof(light[0]), nullptr);
  const auto secondsOfProduct = [&](const bakelight::player::PixelProduct& product) {
    return secondsOf([&] {
      product.run(texels, incident);
      glFinish();
    });
  };
  for (auto _ : state) {
    std::vector<double> ours, csr;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(secondsOfProduct(sum_product));
      csr.push_back(secondsOfProduct(row_product));
    }
    state.SetIterationTime(median(ours));
    state.counters["gpu_csr_speedup" + suffix] = median(csr) / median(ours);
    state.counters["gpu_product_ms" + suffix] = 1e3 * median(ours);
    state.counters["gpu_csr_ms" + suffix] = 1e3 * median(csr);
    state.counters["gpu_bytes" + suffix] = static_cast<double>(sum_product.gpuBytes());
    state.counters["gpu_csr_bytes" + suffix] = static_cast<double>(row_product.gpuBytes());
  }
}
BENCHMARK(player)->Name("player")->Arg(0)->Arg(1)->Iterations(1)->UseManualTime()->Unit(
    benchmark::kMillisecond);

void shading(benchmark::State& state) {
  const PixelRows& rows = rowsOf(0);
  formats::Pack pack{.name = "bunny", .mesh = kScenes[0].mesh()};
  std::vector<formats::Float4> tangents;
  for (const formats::Float3& normal : pack.mesh.normals) {
    const formats::Float3 t = transport::float3(transport::vec3(normal).unitOrthogonal());
    tangents.push_back({t[0], t[1], t[2], 1});
  }
  pack.transfer = formats::pixelTransferOf(rows.view(), tangents);
  transport::AllFrequencyShading of_rows(pack);
  auto grammar = std::make_shared<const formats::SumGrammar>(compress(rows.view()));
  pack.transfer = formats::pixelTransferOf(formats::encodeSums(*grammar), grammar, tangents);
  transport::AllFrequencyShading of_sums(pack);
  const std::vector<formats::Float3> light(rows.view().columnCount(), formats::Float3{1, 0.7F, 0.4F});
  for (auto _ : state) {
    std::vector<double> ours, csr;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(secondsOf([&] { of_sums.setCubeLight(light); }));
      csr.push_back(secondsOf([&] { of_rows.setCubeLight(light); }));
    }
    state.SetIterationTime(median(ours));
    state.counters["shading_csr_speedup"] = median(csr) / median(ours);
    state.counters["shading_ms"] = 1e3 * median(ours);
  }
}
BENCHMARK(shading)->Name("shading")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

void greedy(benchmark::State& state) {
  const PixelCodes codes = rowsOf(0).view();
  for (auto _ : state) {
    Biclusters biclusters;
    const double seconds = secondsOf([&] { biclusters = greedyBiclusters(codes); });
    state.SetIterationTime(seconds);
    state.counters["compress_seconds_greedy"] = seconds;
    const PixelRows decoded = decode(biclusters);
    state.counters["reconstruction_errors_greedy"] =
        decoded.codes == rowsOf(0).codes && decoded.columns == rowsOf(0).columns ? 0 : 1;
    figures(state, "_greedy", codes, static_cast<double>(biclusters.operations()),
            static_cast<double>(biclusters.bytes()));
    std::vector<Radiance4> values(codes.rowCount());
    const std::vector<Radiance4> light = someLight(codes.columnCount());
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    std::vector<double> ours, csr;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(secondsOf([&] { multiply(biclusters, light, values); }));
      csr.push_back(secondsOf([&] { transport::multiply(codes, light, values); }));
    }
    state.counters["csr_speedup_greedy"] = median(csr) / median(ours);  // both on one core
  }
}
BENCHMARK(greedy)->Name("greedy")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

// Argument: the tolerance in thousandths.
void within(benchmark::State& state) {
  const std::string suffix = "_within_" + std::to_string(state.range(0));
  for (auto _ : state) {
    TolerantRows changed;
    state.SetIterationTime(secondsOf(
        [&] { changed = withinTolerance(rowsOf(0).view(), static_cast<double>(state.range(0)) / 1000); }));
    const formats::SumGrammar grammar = compress(changed.rows.view());
    figures(state, suffix, rowsOf(0).view(), static_cast<double>(operationsOf(grammar).counted),
            static_cast<double>(formats::encodedBytes(formats::encodeSumGrammar(grammar))));
    state.counters["largest_error" + suffix] = changed.figures.largest_error;
    state.counters["rms_error" + suffix] = changed.figures.rms_error;
    state.counters["white_sky_rms" + suffix] = changed.figures.white_sky_rms;
  }
}
BENCHMARK(within)->Name("within")->Arg(20)->Arg(100)->Arg(400)->Iterations(1)->UseManualTime()->Unit(
    benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight::bicluster

BENCHMARK_MAIN();
