// What BTFs take in a pack, beside a full-matrix factorisation of rank 100 (Müller, Meseth & Klein 2003), the usual compression of BTFs:
// at its error. 64 × 64 texels, 8 × 8 views, 8 × 8 lights, with heights.
//
//   bench_btf_payload [Google Benchmark flags]
//
// btf_rank100_error  relative RMS that rank 100 of each of Y, U and V leaves, in halves.
// btf_rank100_ratio  raw values as halves ÷ bytes of that file.
// btf_error          of what the pack plays at the finest level, with halves.
// btf_ratio          raw values as halves ÷ bytes in the pack: code, basis and heights; _float32 and _uint8: raw values as these.
// btf_components     that a pixel looks up.
// btf_loading_s      making all that is played of it, on one core.
#include <benchmark/benchmark.h>

#include <unistd.h>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "formats/btf_writer.h"
#include "formats/material.h"
#include "formats/patch_code.h"
#include "patch/read_patch.h"
#include "tools/pack/btf_packing.h"
#include "tools/rtt/directional.h"
#include "tools/rtt/rtt.h"
#include "transport/btf_factorization.h"

namespace bakelight {
namespace {

double secondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Rival {
  double error = 0, bytes = 0;
};
Rival rank100(const formats::Btf& btf) {
  constexpr auto kModel = formats::BtfColorModel::kYuv;
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("bench_btf_payload." + std::to_string(::getpid()) + ".btf");
  formats::writeFactorizedBtf(file, btf.info(), kModel, transport::factorize(btf, kModel, 100).channels,
                              formats::BtfPrecision::kHalf);
  const Rival rival{transport::relativeError(*formats::openBtf(file), btf),
                    static_cast<double>(std::filesystem::file_size(file))};
  std::filesystem::remove(file);
  return rival;
}

void payload(benchmark::State& state, const std::string& name) {
  const patch::PatchGeometry geometry = patch::readPatch(
      formats::readMaterials(std::string(BAKELIGHT_SOURCE_DIR) + "/configs/patches/" + name + ".json").base);
  const rtt::Options options;
  for (auto _ : state) {
    const auto made = rtt::makeBtf(geometry, options, {}, name, [] {});
    const formats::RadianceTransferTexture texture = rtt::makeRtt(geometry, options, [] {}).texture;
    const Rival rival = rank100(*made.btf);
    packing::BtfPackingOptions packing_options;
    packing_options.error = rival.error;
    packing::PackedBtf packed;
    const double packing_s = secondsOf(
        [&] { packed = packing::packBtf(packing::samplesOf(*made.btf), 8, packing_options, &texture); });
    const double loading_s = secondsOf([&] { formats::expandPatch(packed.reflection, name); });
    const auto ratio = [&](double bytes_a_value, double bytes) {
      return bytes_a_value * static_cast<double>(packed.value_count) / bytes;
    };
    const auto stored = static_cast<double>(packed.stored_bytes);
    state.SetIterationTime(packing_s);
    state.counters["btf_rank100_error"] = rival.error;
    state.counters["btf_rank100_ratio"] = ratio(2, rival.bytes);
    state.counters["btf_error"] = packed.reflection.error;
    state.counters["btf_ratio"] = ratio(2, stored);
    state.counters["btf_ratio_float32"] = ratio(4, stored);
    state.counters["btf_ratio_uint8"] = ratio(1, stored);
    state.counters["btf_components"] = packed.reflection.components;
    state.counters["btf_packing_s"] = packing_s;
    state.counters["btf_loading_s"] = loading_s;
  }
}
BENCHMARK_CAPTURE(payload, weave, "weave")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(payload, stucco, "stucco")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
