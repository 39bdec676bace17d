// Translucent objects: what baking costs, and how far what is played is from the integral that it stands for.
//
// horse: the horse of glmark2, its hooves' lids left out, at 10,000 vertices, 512² texels, in marble, five centimetres long.
//   kernel_seconds, factor_seconds, blend_seconds: of the steps of `kernels`, on all cores.
//   blend_rel_rmse: relative RMSE over 1,500 places of the surface, the worst of three lights; also of each, beside what the naive sum errs by
//     (kernels of R_d and factors with a diagonal of 0), and how many times that is as much at least (naive_ratio).
// horse_with_veins: the same with dark veins through the marble.
// horse_textured: striped in red and white, which the medium reflects, with a mean free path as of marble.
// factors: of the bunny's 34,000 vertices. bytes, seconds.
// product: factors times light at run time; bandwidth_ratio: bytes that they have ÷ seconds ÷ what this machine reads in a second.
// respond: all of a light change on the CPU.
// punctual: what a point light sends into each texel, in the object's shadow: a move of such a light, before respond; and setup_ms, once.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>

#include "formats/image.h"
#include "formats/mesh_import.h"
#include "tests/bench/roofline.h"
#include "tests/bench/translucency_error.h"
#include "tests/support/temporary_folder.h"
#include "tools/atlas/make_atlas.h"
#include "tools/atlas/maps/geometry_maps.h"
#include "tools/kernels/kernels.h"
#include "tools/simplify/simplify.h"
#include "transport/near_light.h"
#include "transport/texel_irradiance.h"
#include "transport/translucent_response.h"

namespace bakelight::bench {
namespace {

std::string dataFolder() {
  const char* folder = std::getenv("BAKELIGHT_DATA_DIR");
  return folder != nullptr ? folder : BAKELIGHT_DATA_DIR;
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

formats::Medium marble() {
  formats::Medium medium;
  medium.reduced_scattering = {2.19F, 2.62F, 3.00F};
  medium.absorption = {0.0021F, 0.0041F, 0.0071F};
  medium.eta = 1.5;
  medium.unit_mm = 29;
  return medium;
}

formats::Medium veinedMarble() {
  formats::Medium medium = marble();
  medium.veins = formats::Veins{{2, 2.2F, 2.4F}, {0.5F, 0.55F, 0.5F}, 0.4, 0.04, 1};
  return medium;
}

formats::Medium candy() {
  formats::Medium medium = marble();
  medium.reflectance = formats::ReflectanceSource::kAlbedo;
  return medium;
}

// Slanted stripes.
void paint(formats::TriangleMesh& mesh) {
  for (const formats::Float3& p : mesh.positions) {
    const float wave = std::sin(17.5F * (p[0] + 0.6F * p[1] + 0.3F * std::abs(p[2])));
    const float red = std::clamp(0.5F + 0.9F * wave, 0.0F, 1.0F);
    mesh.colors.push_back({0.86F - 0.24F * red, 0.80F - 0.77F * red, 0.70F - 0.65F * red});
  }
}

struct Horse {
  formats::Medium medium;
  tests::TemporaryFolder folder;
  atlas::AtlasResult result;
  kernels::Made made;

  explicit Horse(const formats::Medium& of) : medium(of) {
    simplify::SimplifyOptions options;
    options.triangles = of.veins ? 30000 : 20000;
    options.refine = true;
    options.least_part = 0.005;
    const formats::TriangleMesh mesh =
        simplify::simplify(formats::importMesh(dataFolder() + "/models/horse.3ds").mesh, options, "horse")
            .mesh;
    atlas::AtlasOptions charts;
    charts.resolution = 512;
    charts.border = 4;
    result = atlas::makeAtlas(mesh, {}, charts, "horse");
    formats::writeExr(folder / "maps.exr", atlas::geometryMaps(result.atlas, {512, 4}, "horse"),
                      formats::ExrPrecision::kFloat);
    result.atlas.mesh.colors.clear();
    if (of.reflectance == formats::ReflectanceSource::kAlbedo) paint(result.atlas.mesh);
    made = kernels::makeTranslucency(result.atlas.mesh, folder / "maps.exr", medium, {},
                                     stage::ProgressStyle::kNone);
  }
};

const Horse& horse() {
  static const auto made = std::make_unique<const Horse>(marble());
  return *made;
}

void measure(benchmark::State& state, const Horse& subject) {
  for (auto _ : state) {
    const auto& seconds = subject.made.figures.seconds;
    state.counters["factor_seconds"] = seconds.at("factors");
    state.counters["blend_seconds"] = seconds.at("blend");
    state.counters["kernel_seconds"] = seconds.at("kernels");
    state.counters["prepare_seconds"] = seconds.at("prepare");
    state.counters["compress_seconds"] = seconds.at("compress");
    const formats::TriangleMesh& mesh = subject.result.atlas.mesh;
    kernels::Knots knots = kernels::knotsOf(mesh);
    kernels::Texels texels = kernels::texelsOf(subject.folder / "maps.exr", mesh, knots);
    const transport::MediumField field(subject.medium, mesh);
    kernels::takeSurroundings(field, mesh, knots, texels);
    const auto [least, greatest] = std::minmax_element(texels.sides.begin(), texels.sides.end());
    const kernels::Reflectance reflectance(field, 3, static_cast<double>(*least),
                                           static_cast<double>(*greatest));
    double worst = 0, ratio = 1e9;
    for (const auto& [name, light] : testLights(knots)) {
      const TranslucencyErrors errors =
          translucencyErrors(knots, texels, reflectance, subject.made.translucency, light, 1500);
      state.counters["rel_rmse_" + name] = errors.blend;
      state.counters["naive_rel_rmse_" + name] = errors.naive;
      state.counters["local_rel_rmse_" + name] = errors.local;
      state.counters["global_rel_rmse_" + name] = errors.global;
      worst = std::max(worst, errors.blend);
      ratio = std::min(ratio, errors.naive / errors.blend);
    }
    state.counters["blend_rel_rmse"] = worst;
    state.counters["naive_ratio"] = ratio;
    state.counters["vertices"] = static_cast<double>(knots.count());
    state.counters["far_knots"] = static_cast<double>(subject.made.figures.far_knots);
  }
}
void BM_horse(benchmark::State& state) {
  measure(state, horse());
}
BENCHMARK(BM_horse)->Name("horse")->Iterations(1)->Unit(benchmark::kSecond);

void BM_horse_with_veins(benchmark::State& state) {
  measure(state, Horse(veinedMarble()));
}
BENCHMARK(BM_horse_with_veins)->Name("horse_with_veins")->Iterations(1)->Unit(benchmark::kSecond);

void BM_horse_textured(benchmark::State& state) {
  measure(state, Horse(candy()));
}
BENCHMARK(BM_horse_textured)->Name("horse_textured")->Iterations(1)->Unit(benchmark::kSecond);

void BM_factors(benchmark::State& state) {
  const formats::TriangleMesh mesh = formats::importMesh(dataFolder() + "/models/bunny.obj").mesh;
  const kernels::Knots knots = kernels::knotsOf(mesh);
  formats::Medium milk;  // skim milk, a bunny of ten centimetres
  milk.reduced_scattering = {0.70F, 1.22F, 1.90F};
  milk.absorption = {0.0014F, 0.0025F, 0.0142F};
  kernels::Vec3 low = knots.positions.front(), high = low;
  for (const kernels::Vec3& p : knots.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  milk.unit_mm = 170 / (high - low).norm();
  const transport::MediumField field(milk, mesh.positions);
  const double side = knots.meanSpacing() / 5;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    const kernels::Reflectance reflectance(field, (high - low).norm() * 1.01, side, side * 1.01);
    const kernels::Throughput throughput(knots, reflectance, {});
    state.counters["seconds"] = secondsSince(start);
    state.counters["vertices"] = static_cast<double>(knots.count());
    state.counters["far_knots"] = static_cast<double>(throughput.farCount());
    double bytes = 0;
    for (const kernels::Matrix* matrix : {&throughput.near(), &throughput.spread(), &throughput.far()})
      bytes +=
          4.0 * static_cast<double>(matrix->columns.size() + matrix->values.size() + matrix->ends.size());
    state.counters["bytes"] = bytes;
    state.counters["dropped_share"] = throughput.figures().dropped_share;
  }
}
BENCHMARK(BM_factors)->Name("factors")->Iterations(1)->Unit(benchmark::kSecond);

void BM_product(benchmark::State& state) {
  const Horse& subject = horse();
  const transport::TranslucentResponse response(subject.made.translucency);
  const std::vector<formats::Float3> light(response.texelCount(), formats::Float3{1, 1, 1});
  // As the class holds them: floats and columns of four bytes.
  double bytes = 0;
  const formats::Translucency& t = subject.made.translucency;
  for (const formats::SparseRows* matrix : {&t.sharpen, &t.sharpen, &t.near, &t.spread, &t.spread, &t.far})
    bytes += 4.0 * static_cast<double>(matrix->columns.count() * (1 + matrix->values.columns));
  // What texels with an area give to three knots each: index, power, three weights.
  for (const float area : t.areas.decode()) bytes += area > 0 ? 3 * 20.0 : 0;
  std::vector<float> buffer(std::size_t{64} << 20, 1.0F);
  const std::size_t aligned =
      (64 - reinterpret_cast<std::uintptr_t>(buffer.data()) % 64) / sizeof(float) % 16;
  const std::span<const float> read(buffer.data() + aligned, (std::size_t{64} << 20) - 1024);
  double seconds = 1e9, reading = 1e9;
  for (auto _ : state) {
    auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(response.atKnots(light));
    seconds = std::min(seconds, secondsSince(start));
    start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(readSum(read));
    reading = std::min(reading, secondsSince(start));
  }
  const double bandwidth = static_cast<double>(read.size_bytes()) / reading;
  state.counters["product_ms"] = 1e3 * seconds;
  state.counters["bandwidth_ratio"] = bytes / seconds / bandwidth;
}
BENCHMARK(BM_product)->Name("product")->Iterations(20)->Unit(benchmark::kMillisecond);

void BM_respond(benchmark::State& state) {
  const transport::TranslucentResponse response(horse().made.translucency);
  const std::vector<formats::Float3> light(response.texelCount(), formats::Float3{1, 1, 1});
  for (auto _ : state) benchmark::DoNotOptimize(response.respond(light));
}
BENCHMARK(BM_respond)->Name("respond")->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_punctual(benchmark::State& state) {
  const formats::TriangleMesh& mesh = horse().result.atlas.mesh;
  const formats::Translucency& translucency = horse().made.translucency;
  const auto start = std::chrono::steady_clock::now();
  const transport::TexelIrradiance texels(translucency, mesh);
  state.counters["setup_ms"] = 1e3 * secondsSince(start);
  const transport::Occlusion shadows = transport::shadowsOf(mesh);
  const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
  transport::PlacedPunctualLight light;
  light.position = bounds.center + bounds.radius * transport::Vec3(1.3, 0.6, 2.8);
  for (auto _ : state) benchmark::DoNotOptimize(texels.entering(std::span(&light, 1), shadows));
  state.counters["texels"] = static_cast<double>(texels.texels().size());
}
BENCHMARK(BM_punctual)->Name("punctual")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace bakelight::bench

BENCHMARK_MAIN();
