// Opening a pack beside what must happen at least: every byte read and its checksum taken.
//
// floor_ratio = time of the checksums alone over the mapped file ÷ time of readPack; peak_over_size = memory
// that readPack took at its peak ÷ size of the file, of which 1.2 is the most that is allowed.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "formats/hash.h"
#include "formats/mapped_file.h"
#include "formats/pack.h"
#include "tests/support/rippled_ball.h"

namespace bakelight {
namespace {

using Clock = std::chrono::steady_clock;

// Kilobytes of a line of /proc/self/status.
double statusKb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1));
  return 0;
}

double secondsOf(const auto& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A ball with `columns` random coefficients a vertex: 25 without matrices, 625 more with.
std::filesystem::path writtenPack(bool glossy) {
  formats::Pack pack;
  pack.name = "ball";
  pack.mesh = tests::rippledBall(400'000);
  for (const formats::Float3& position : pack.mesh.positions)
    pack.mesh.normals.push_back(transport::float3(transport::vec3(position).normalized()));
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-1, 1);
  const auto table = [&](std::size_t columns, formats::Precision precision) {
    std::vector<float> values(pack.mesh.vertexCount() * columns);
    for (float& value : values) value = uniform(random);
    return formats::encodeTable(values, columns, precision, "made", "table");
  };
  formats::ShTransfer& transfer = pack.sh();
  transfer.order = 5;
  transfer.vectors = table(25, formats::Precision::kFloat32);
  if (glossy) {
    formats::GlossyTransfer& part = transfer.glossy.emplace();
    part.output_order = 5;
    for (const formats::Float3& n : pack.mesh.normals) {
      const float length = std::hypot(n[1], n[0]);
      part.tangents.push_back(length > 1e-3F ? formats::Float4{-n[1] / length, n[0] / length, 0, 1}
                                             : formats::Float4{1, 0, 0, 1});
    }
    part.transfer = formats::MatrixOperator{table(625, formats::Precision::kUint8)};
    pack.appearances.front().reflection = formats::GgxLobe{0.4F, {1, 1, 1}};
  }
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "bench_pack_open.glb";
  formats::writePack(path, pack, {});
  return path;
}

void open(benchmark::State& state) {
  const std::filesystem::path path = writtenPack(state.range(0) != 0);
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  for (auto _ : state) {
    std::ofstream("/proc/self/clear_refs") << 5;  // the peak begins anew
    const double before_kb = statusKb("VmRSS");
    double opened_s = 0, peak_kb = 0;
    {
      formats::Pack pack;
      opened_s = secondsOf([&] { pack = formats::readPack(path); });
      peak_kb = statusKb("VmHWM") - before_kb;
      benchmark::DoNotOptimize(pack.mesh.positions.data());
    }
    const double checksum_s = secondsOf([&] {
      const auto file = formats::MappedFile::open(path);
      benchmark::DoNotOptimize(formats::checksum64(file->bytes()));
    });
    state.SetIterationTime(opened_s);
    state.counters["floor_ratio"] = checksum_s / opened_s;
    state.counters["peak_over_size"] = 1024 * peak_kb / size;
    state.counters["megabytes"] = 1e-6 * size;
  }
  std::filesystem::remove(path);
}
BENCHMARK(open)->ArgName("glossy")->Arg(0)->Arg(1)->Iterations(1)->Repetitions(3)->UseManualTime()->Unit(
    benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
