// Shading of all frequencies with meso-structure beside the truth: paths traced through the patch's own triangles, laid over a trough (half a cylinder
// from inside, whose walls throw their shadows on its ground), under three probes and a sun of 2° that stands on the edge of a wall. Direct light at both scales.
//
//   bench_allfreq [Google Benchmark flags]
//
// 2,401 vertices, 8 × 8 cells, a cube map of 6 × 32 × 32 texels of 2 × 2 rays, BTFs as packs have them. Each row is a way to store transfer, at a share of the bytes of the exact
// sums in per cent; `biscale` is spherical harmonics of order 5 as the recipe biscale has them, matrices and patch, uncompressed (share 0). rel_rmse_LIGHT: √Σ (picture −
// truth)² ÷ √Σ truth² over three views of 2 × 2 patches at a pixel a texel, noise of the truth taken out; rel_rmse: root mean square of the lights'.
// incident_error: of L* from exact, likewise. bytes: of the transfer.
#include <benchmark/benchmark.h>

#include <cmath>
#include <functional>
#include <map>
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
#include "tests/bench/biscale_images.h"
#include "tests/bench/biscale_subject.h"
#include "transport/all_frequency_shading.h"
#include "transport/bi_scale_shading.h"
#include "transport/cube_light.h"
#include "transport/light_rig.h"
#include "transport/morton.h"

namespace bakelight::bench {
namespace {

using compression::CompressedTransfer;
using transport::Radiance4;

constexpr auto kMacro = Macro::kTrough;
constexpr BakeVariant kVariant = {.macro_steps = 4, .bounces = false};
constexpr int kViews_deg[] = {0, 30, 60};
constexpr int kTexels = 2;   // pixels of the pictures before they are blurred
constexpr int kBatches = 4;  // of 16 samples a pixel

struct Light {
  const char* name;
  formats::LightRig rig;
};
const std::vector<Light>& lights() {
  static const std::vector<Light> all = [] {
    std::vector<Light> made;
    const char* folder = std::getenv("BAKELIGHT_DATA");
    for (const char* probe : {"courtyard", "studio", "sunrise"})
      made.push_back(
          {probe, formats::readLights(std::string(folder != nullptr ? folder : BAKELIGHT_DATA_DIR) +
                                          "/probes/" + probe + ".exr",
                                      {})});
    formats::DiskLight disk, sky;
    disk.direction = {0.2F, 1, -1};
    disk.half_angle_deg = 1;
    disk.radiance = {2400, 2300, 2100};
    sky.half_angle_deg = 180;
    sky.radiance = {0.12F, 0.14F, 0.18F};
    formats::LightRig sun;
    sun.distant = {disk, sky};
    made.push_back({"sun", std::move(sun)});
    return made;
  }();
  return all;
}

Window windowOf(int view_deg) {
  Window window;
  window.widths = 2;
  window.side = static_cast<int>(window.widths) * kVariant.resolution * kTexels;
  window.polar_deg = view_deg;
  return window;
}

// A patch on the trough: its packs, and what is true of it.
class Subject {
 public:
  explicit Subject(const std::string& patch)
      : bi_scale(packsOf(patch, kMacro, kVariant).bi_scale),
        all_frequency(allFrequencyPackOf(patch, kMacro, kVariant)),
        rows_(*all_frequency.transfer.as<formats::PixelTransfer>()),
        haar(compression::haarRows(codes())),
        order(transport::mortonOrder(all_frequency.mesh.positions)),
        sums(compression::exactSums(codes())) {
    const reference::Surface surface = truthOf(patch, kMacro);
    for (const Light& light : lights()) {
      energies.push_back(compression::texelEnergies(
          transport::cubeLight(light.rig.distant, codes().cube_side, Eigen::Matrix3d::Identity()),
          codes().cube_side));
      exact.emplace_back(codes().rowCount());
      transport::multiply(codes(), energies.back(), exact.back());
      const reference::Scene scene(surface, light.rig, {}, transport::boundingSphere(surface.mesh));
      for (const int view : kViews_deg)
        truth[light.name].push_back(
            truthImage(scene, kMacro, windowOf(view), kBatches, reference::Transport::kShadowed)
                .blurred(kTexels));
    }
  }
  formats::PixelCodes codes() const { return rows_.view(); }

  formats::Pack bi_scale, all_frequency;

 private:
  formats::PixelTransferRows rows_;

 public:
  compression::WaveletRows haar;
  std::vector<std::uint32_t> order;
  CompressedTransfer sums;
  std::vector<std::vector<Radiance4>> energies, exact;  // a light
  std::map<std::string, std::vector<Image>> truth;      // by light: of each view
};
const Subject& subject(const std::string& patch) {
  static std::map<std::string, Subject> made;
  return made.try_emplace(patch, patch).first->second;
}

// `lit` is called for each light, and gives it to the shading.
void tellPictures(benchmark::State& state, const Subject& subject, transport::PackShading& shading,
                  const std::function<void(std::size_t light)>& lit) {
  double squares = 0;
  for (std::size_t i = 0; i < lights().size(); ++i) {
    lit(i);
    SquaredError error;
    for (std::size_t view = 0; view < std::size(kViews_deg); ++view)
      error.add(
          shadedImage(shading, kMacro, kVariant.macro_steps, windowOf(kViews_deg[view])).blurred(kTexels),
          subject.truth.at(lights()[i].name)[view]);
    state.counters[std::string("rel_rmse_") + lights()[i].name] = error.relative();
    squares += error.relative() * error.relative();
  }
  state.counters["rel_rmse"] = std::sqrt(squares / static_cast<double>(lights().size()));
}

using Store = std::function<CompressedTransfer(const Subject& subject, std::uint64_t budget)>;
void stored(benchmark::State& state, const std::string& patch, int share, const Store& store) {
  const Subject& of = subject(patch);
  for (auto _ : state) {
    std::optional<CompressedTransfer> made;
    try {
      made = store(of, of.sums.bytes * static_cast<std::uint64_t>(share) / 100);
    } catch (const std::invalid_argument& error) {
      state.SkipWithError(error.what());
      break;
    }
    state.SetLabel(made->parameters);
    state.counters["bytes"] = static_cast<double>(made->bytes);
    double squares = 0;
    transport::AllFrequencyShading shading(of.all_frequency);
    tellPictures(state, of, shading, [&](std::size_t light) {
      const std::vector<Radiance4> incident = made->incident(of.energies[light]);
      const double error = compression::relativeRms(incident, of.exact[light]);
      squares += error * error;
      shading.setIncident(incident);
    });
    state.counters["incident_error"] = std::sqrt(squares / static_cast<double>(lights().size()));
  }
}

void biScale(benchmark::State& state, const std::string& patch) {
  const Subject& of = subject(patch);
  for (auto _ : state) {
    const auto coefficients = static_cast<std::size_t>(kVariant.order) * kVariant.order;
    state.counters["bytes"] =
        static_cast<double>(of.bi_scale.mesh.vertexCount() * coefficients * coefficients * 2);  // in halves
    transport::BiScaleShading shading(of.bi_scale);
    tellPictures(state, of, shading, [&](std::size_t light) {
      shading.setLight(transport::distantLight(lights()[light].rig, kVariant.order).light, {});
    });
  }
}

const struct {
  const char* name;
  Store store;
} kMethods[] = {{"sums", [](const Subject& of, std::uint64_t) { return of.sums; }},
                {"cpca",
                 [](const Subject& of, std::uint64_t budget) {
                   constexpr int kComponents[] = {4, 8, 12};
                   return compression::clusteredWithin(budget, of.codes(), kComponents);
                 }},
                {"haar",
                 [](const Subject& of, std::uint64_t budget) {
                   return compression::haarWithin(budget, of.haar, compression::Selection::kAreaWeighted);
                 }},
                {"wavelets4d",
                 [](const Subject& of, std::uint64_t budget) {
                   return compression::wavelets4dWithin(budget, of.haar, of.codes().local_side, of.order);
                 }},
                {"harmonics", [](const Subject& of, std::uint64_t budget) {
                   return compression::harmonicsWithin(budget, of.codes(), kVariant.order);
                 }}};

void registerRows() {
  for (const std::string patch : {"stucco", "weave"}) {
    const auto add = [&](const std::string& name, const auto& run) {
      benchmark::RegisterBenchmark((patch + "/" + name).c_str(), run)
          ->Iterations(1)
          ->Unit(benchmark::kMillisecond);
    };
    for (const int share : {100, 200})
      for (const auto& method : kMethods)
        if (share == 100 || std::string(method.name) != "sums")
          add(method.name + ("/" + std::to_string(share)),
              [patch, share, store = method.store](benchmark::State& state) {
                stored(state, patch, share, store);
              });
    add("biscale/0", [patch](benchmark::State& state) { biScale(state, patch); });
  }
}

}  // namespace
}  // namespace bakelight::bench

int main(int argc, char** argv) {
  bakelight::bench::registerRows();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
