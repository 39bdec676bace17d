// Bi-scale shading beside the truth: paths traced through the patch's own triangles, laid over the macro surface by shell
// mapping, under the light as it is.
//
// Each row is a patch on a macro surface (0 plane, 1 cylinder, 2 trough) under a light (degrees across, 45° from the zenith; 0: a
// sky). Pixels are as large as texels, along parallel rays; of both sides each is its mean. Noise of the truth is taken out of
// all errors.
//   rel_rmse = √Σ (bi-scale − truth)² ÷ √Σ truth² over the four views; rel_rmse_60: of the view 60° from the normal.
//   macro_only_ratio, meso_only_ratio, normal_map_ratio = the same of that rival ÷ rel_rmse: flat with the patch's mean
// albedo and M; B under light that no macro surface shadows; a normal map under it, shaded plainly. On a plane and on a
// cylinder there is nothing to shadow, and meso only is bi-scale shading without M's errors.
//   least_ratio_60: of the best rival (meso only left out where it is no rival).
//   sharp_rel_rmse: at four pixels a texel. noise: standard error of the truth, relative.
// causes: rel_rmse under the light of 40° as it is, and with less of one cause each: order 10, 16 × 16 views, 128 texels, three
// times the vertices along a patch; and with more: matrices that cut light off at the vertices' own horizons, and views that are
// all looked up at one place of the mid-plane (without_relief).
//
// bench_biscale --pictures FOLDER writes pictures side by side: truth, bi-scale, normal map.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <optional>

#include "formats/image.h"
#include "tests/bench/biscale_images.h"
#include "transport/light_rig.h"

namespace bakelight::bench {
namespace {

using std::numbers::pi;

const char* const kPatches[] = {"stucco", "weave"};
constexpr int kViews_deg[] = {0, 30, 60, 75};
constexpr int kSky = 0;
constexpr int kBatches = 4;  // of 16 samples a pixel

formats::LightRig rigOf(int across_deg) {
  formats::LightRig rig;
  if (across_deg == kSky) {
    formats::SkyLight sky;
    sky.sun = false;
    rig.distant.emplace_back(sky);
    return rig;
  }
  const double polar = pi / 4, azimuth = 75 * pi / 180;
  formats::DiskLight disk;
  disk.direction = transport::float3(
      Vec3(std::sin(polar) * std::cos(azimuth), std::cos(polar), -std::sin(polar) * std::sin(azimuth)));
  disk.half_angle_deg = across_deg / 2.0;
  rig.distant.emplace_back(disk);
  return rig;
}

// The last one asked for is kept: it has millions of triangles.
const reference::Surface& truthFor(int patch, Macro macro) {
  static std::optional<std::pair<int, Macro>> key;
  static reference::Surface surface;
  if (key != std::pair(patch, macro)) {
    surface = truthOf(kPatches[patch], macro);
    key.emplace(patch, macro);
  }
  return surface;
}

const Packs& packsFor(int patch, Macro macro, const BakeVariant& variant) {
  static std::map<std::tuple<int, Macro, BakeVariant>, Packs> made;
  const auto [found, is_new] = made.try_emplace({patch, macro, variant});
  if (is_new) found->second = packsOf(kPatches[patch], macro, variant);
  return found->second;
}

Image biScaleImage(int patch, Macro macro, const BakeVariant& variant, const formats::LightRig& rig,
                   const Window& window) {
  return packImage(packsFor(patch, macro, variant).bi_scale, macro, variant.macro_steps,
                   transport::distantLight(rig, variant.order).light, window);
}

// Of the views so far.
struct Errors {
  SquaredError bi_scale, sharp, macro_only, meso_only, normal_map;
  double variance = 0;

  void add(const Errors& other) {
    bi_scale.add(other.bi_scale), sharp.add(other.sharp);
    macro_only.add(other.macro_only), meso_only.add(other.meso_only), normal_map.add(other.normal_map);
    variance += other.variance;
  }
  double noise() const { return std::sqrt(variance / bi_scale.square); }
};

class Comparison {
 public:
  Comparison(int patch, Macro macro, int light_deg)
      : patch_(patch),
        macro_(macro),
        rig_(rigOf(light_deg)),
        scene_(truthFor(patch, macro), rig_, {}, transport::boundingSphere(truthFor(patch, macro).mesh)),
        light_(transport::distantLight(rig_, BakeVariant().order).light),
        normals_(normalMapOf(patchOf(kPatches[patch]), BakeVariant().resolution)) {}

  void add(const Window& window, Errors& errors) const {
    const BakeVariant variant;
    const Packs& packs = packsFor(patch_, macro_, variant);
    const Image truth = truthImage(scene_, macro_, window, kBatches),
                bi_scale = packImage(packs.bi_scale, macro_, variant.macro_steps, light_, window);
    const int texel = window.side / variant.resolution;
    const Image blurred = truth.blurred(texel);
    errors.sharp.add(bi_scale, truth);
    errors.bi_scale.add(bi_scale.blurred(texel), blurred);
    const auto rival = [&](const formats::Pack& pack) {
      return packImage(pack, macro_, variant.macro_steps, light_, window).blurred(texel);
    };
    errors.macro_only.add(rival(packs.macro_only), blurred);
    errors.meso_only.add(rival(packs.meso_only), blurred);
    errors.normal_map.add(normalMapImage(normals_, macro_, light_, window).blurred(texel), blurred);
    errors.variance += blurred.variance;
  }

 private:
  int patch_;
  Macro macro_;
  formats::LightRig rig_;
  reference::Scene scene_;
  transport::ShLight light_;
  NormalMap normals_;
};

double leastRatio(const Errors& errors, Macro macro) {
  double rival = std::min(errors.macro_only.relative(), errors.normal_map.relative());
  if (macro == Macro::kTrough) rival = std::min(rival, errors.meso_only.relative());
  return rival / errors.bi_scale.relative();
}

void againstGeometry(benchmark::State& state) {
  const int patch = static_cast<int>(state.range(0));
  const auto macro = static_cast<Macro>(state.range(1));
  for (auto _ : state) {
    const Comparison comparison(patch, macro, static_cast<int>(state.range(2)));
    Errors all;
    for (const int view : kViews_deg) {
      Window window;
      window.polar_deg = view;
      Errors one;
      comparison.add(window, one);
      all.add(one);
      const std::string suffix = "_" + std::to_string(view);
      state.counters["rel_rmse" + suffix] = one.bi_scale.relative();
      state.counters["least_ratio" + suffix] = leastRatio(one, macro);
    }
    const double error = all.bi_scale.relative();
    state.counters["rel_rmse"] = error;
    state.counters["sharp_rel_rmse"] = all.sharp.relative();
    state.counters["noise"] = all.noise();
    state.counters["macro_only_ratio"] = all.macro_only.relative() / error;
    state.counters["meso_only_ratio"] = all.meso_only.relative() / error;
    state.counters["normal_map_ratio"] = all.normal_map.relative() / error;
  }
}
// Rows of one surface follow each other.
void allRows(benchmark::internal::Benchmark* rows) {
  for (const int patch : {0, 1})
    for (const Macro macro : {Macro::kPlane, Macro::kCylinder, Macro::kTrough})
      for (const int light : {10, 40, 110, kSky}) rows->Args({patch, static_cast<int>(macro), light});
}
BENCHMARK(againstGeometry)
    ->Name("against_geometry")
    ->ArgNames({"patch", "macro", "light_deg"})
    ->Apply(allRows)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

constexpr int kLightOfCauses_deg = 40;

// At a pixel a texel; kept for all causes.
const Image& truthOfView(int patch, Macro macro, const Window& window) {
  static std::map<std::tuple<int, Macro, double>, Image> made;
  const auto [found, is_new] = made.try_emplace({patch, macro, window.polar_deg});
  if (!is_new) return found->second;
  const reference::Surface& surface = truthFor(patch, macro);
  const reference::Scene scene(surface, rigOf(kLightOfCauses_deg), {},
                               transport::boundingSphere(surface.mesh));
  return found->second = truthImage(scene, macro, window, kBatches).blurred(2);
}

struct Cause {
  const char* name;
  BakeVariant variant = {};
};
const Cause kCauses[] = {{"as_it_is"},
                         {"order_10", {.order = 10}},
                         {"views_16", {.views = 16}},
                         {"resolution_128", {.resolution = 128}},
                         {"macro_finer", {.macro_steps = 6}},
                         {"cut_horizon", {.open_horizon = false}},
                         {"without_relief", {.relief = false}}};

void causes(benchmark::State& state) {
  const int patch = static_cast<int>(state.range(0));
  const auto macro = static_cast<Macro>(state.range(1));
  const Cause& cause = kCauses[state.range(2)];
  state.SetLabel(cause.name);
  for (auto _ : state) {
    const formats::LightRig rig = rigOf(kLightOfCauses_deg);
    SquaredError all;
    for (const int view : kViews_deg) {
      Window window;
      window.polar_deg = view;
      const Image seen = biScaleImage(patch, macro, cause.variant, rig, window);
      SquaredError one;
      one.add(seen.blurred(2), truthOfView(patch, macro, window));
      all.add(one);
      state.counters["rel_rmse_" + std::to_string(view)] = one.relative();
    }
    state.counters["rel_rmse"] = all.relative();
  }
}
void causeRows(benchmark::internal::Benchmark* rows) {
  for (const int patch : {0, 1})
    for (const Macro macro : {Macro::kPlane, Macro::kTrough})
      for (int cause = 0; cause < static_cast<int>(std::size(kCauses)); ++cause)
        rows->Args({patch, static_cast<int>(macro), cause});
}
BENCHMARK(causes)
    ->ArgNames({"patch", "macro", "cause"})
    ->Apply(causeRows)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

// Side by side, each as bright as the first.
void writePictures(const std::filesystem::path& file, const std::vector<Image>& images) {
  constexpr int kGap_px = 8;
  const int side = images.front().side, step = side + kGap_px;
  formats::Image picture(step * static_cast<int>(images.size()) - kGap_px, side, {"R", "G", "B"});
  std::fill(picture.values.begin(), picture.values.end(), 1.0F);
  std::vector<float> values;
  for (const Float3& value : images.front().values)
    values.push_back(*std::max_element(value.begin(), value.end()));
  const auto white = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), white, values.end());
  for (std::size_t k = 0; k < images.size(); ++k)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          picture.texel(static_cast<int>(k) * step + x, side - 1 - y)[c] = static_cast<float>(std::pow(
              std::clamp(images[k].values[static_cast<std::size_t>(y) * side + x][c] / *white, 0.0F, 1.0F),
              1 / 2.2));
  formats::writePng(file, picture);
}

void pictures(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  struct Shot {
    int patch;
    Macro macro;
    int light_deg, view_deg;
  };
  for (const auto& [patch, macro, light_deg, view_deg] : {Shot{0, Macro::kPlane, 40, 30},
                                                          {1, Macro::kPlane, 40, 30},
                                                          {1, Macro::kPlane, 40, 60},
                                                          {1, Macro::kTrough, 110, 30}}) {
    const BakeVariant variant;
    const formats::LightRig rig = rigOf(light_deg);
    const reference::Surface& surface = truthFor(patch, macro);
    const reference::Scene scene(surface, rig, {}, transport::boundingSphere(surface.mesh));
    Window window;
    window.side = 288;
    window.widths = 3;
    window.polar_deg = view_deg;
    writePictures(folder / (std::string(kPatches[patch]) + "_" + nameOf(macro) + "_" +
                            std::to_string(view_deg) + ".png"),
                  {truthImage(scene, macro, window, 4), biScaleImage(patch, macro, variant, rig, window),
                   normalMapImage(normalMapOf(patchOf(kPatches[patch]), variant.resolution), macro,
                                  transport::distantLight(rig, variant.order).light, window)});
  }
}

}  // namespace
}  // namespace bakelight::bench

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--pictures") == 0) {
    bakelight::bench::pictures(argv[2]);
    return 0;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
