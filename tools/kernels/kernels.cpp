#include "tools/kernels/kernels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "formats/error.h"
#include "tools/kernels/compression.h"
#include "tools/kernels/fallback.h"
#include "tools/stage/stopwatch.h"

namespace bakelight::kernels {
namespace {

using formats::EncodedTable;
using formats::encodeTable;
using formats::Precision;

// What the tables hold cannot be wrong but by a fault of ours.
EncodedTable table(const std::vector<float>& values, std::size_t columns, Precision precision,
                   const char* what) {
  return encodeTable(values, columns, precision, "kernels", what);
}

formats::SparseRows encoded(const Matrix& matrix, float scale, Precision precision, const char* what) {
  std::vector<float> values = matrix.values;
  for (float& value : values) value *= scale;
  return {formats::integersOf(matrix.ends), formats::integersOf(matrix.columns),
          table(values, matrix.value_columns, precision, what)};
}

double diagonalOf(const Knots& knots) {
  Vec3 low = knots.positions.front(), high = low;
  for (const Vec3& p : knots.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).norm();
}

// That of a spacing; where R_d is so faint that half floats would lose it, as much as makes its factors near 1.
double areaUnit(const Knots& knots, const Throughput& throughput) {
  constexpr double kFaint = 1e-2, kLeastArea = 1e-300, kMostArea = 1e30;
  float greatest = 0;
  for (const Matrix* matrix : {&throughput.near(), &throughput.far()})
    for (const float value : matrix->values) greatest = std::max(greatest, std::abs(value));
  const double area = std::max(knots.meanSpacing() * knots.meanSpacing(), kLeastArea);
  const double factor = static_cast<double>(greatest) * area;
  return factor > 0 && factor < kFaint ? std::min(area / factor, kMostArea) : area;
}

void takeTexels(const Texels& texels, const Knots& knots, const Blending& blending,
                formats::Translucency& result) {
  result.resolution = texels.resolution;
  result.texels = formats::integersOf(texels.places);
  std::vector<std::uint32_t> corners;
  std::vector<float> weights, areas, given;
  for (std::size_t i = 0; i < texels.count(); ++i) {
    const auto& t = knots.triangles[texels.triangles[i]];
    corners.insert(corners.end(), t.begin(), t.end());
    weights.insert(weights.end(), {texels.weights[i][1], texels.weights[i][2]});
    areas.push_back(texels.areas[i] / result.area_unit);
    for (std::size_t c = 0; c < 3; ++c) {
      const Rgb value = texels.areas[i] * blending.densities[i][c];
      given.insert(given.end(), value.data(), value.data() + 3);
    }
  }
  result.texel_knots = formats::integersOf(corners);
  result.texel_weights = table(weights, 2, Precision::kFloat32, "texelWeights");
  result.areas = table(areas, 1, Precision::kFloat32, "areas");
  result.blend = table(given, 9, Precision::kFloat16, "blend");
  result.receivers = formats::integersOf(blending.receivers);
}

}  // namespace

Made makeTranslucency(const formats::TriangleMesh& mesh, const std::filesystem::path& maps,
                      const formats::Medium& medium, const Options& options, stage::ProgressStyle style) {
  Made made;
  formats::Translucency& result = made.translucency;
  Figures& figures = made.figures;

  stage::Stopwatch watch(figures.seconds);
  Knots knots = knotsOf(mesh);
  Texels texels = texelsOf(maps, mesh, knots);
  const transport::MediumField field = [&] {
    try {
      return transport::MediumField(medium, mesh);
    } catch (const std::invalid_argument& problem) {
      throw badInput({maps.string(), "", ""}, std::string("the medium of its mesh: ") + problem.what(), "",
                     medium.veins ? "wider veins, or none" : "");
    }
  }();
  takeSurroundings(field, mesh, knots, texels);
  const auto [least, greatest] = std::minmax_element(texels.sides.begin(), texels.sides.end());
  const Reflectance reflectance(field, diagonalOf(knots) * 1.001, static_cast<double>(*least),
                                static_cast<double>(*greatest));

  watch.lap("prepare");
  const Throughput throughput = [&] {
    try {
      return Throughput(knots, reflectance, options.factors);
    } catch (const std::length_error& problem) {
      throw badInput({maps.string(), "", ""},
                     "its mesh has " + std::to_string(knots.count()) + " vertices: " + problem.what(),
                     "at most " + std::to_string(Throughput::kMostFactors / 1'000'000) + " million",
                     "simplify the mesh: vertices some 5 texels apart do");
    }
  }();
  watch.lap("factors");

  stage::Progress progress(style, "kernels", 2 * mesh.triangles.size(), "triangles");
  const Blending blending =
      blend(knots, texels, reflectance, throughput, [&](std::size_t count) { progress.advance(count); });
  watch.lap("blending");
  figures.seconds.erase("blending");  // by its two halves
  figures.seconds["blend"] = blending.fit_seconds;
  figures.seconds["kernels"] = blending.kernel_seconds;

  result.area_unit = static_cast<float>(areaUnit(knots, throughput));
  result.eta = static_cast<float>(medium.eta);
  result.fallback = fallbackOf(mesh, medium);
  result.knot_count = static_cast<int>(knots.count());
  result.knots = knots.of_vertex;
  takeTexels(texels, knots, blending, result);

  const std::size_t values = std::size_t{3} * formats::kKernelTexels;
  const CompressedKernels compressed = options.kernel_error > 0
                                           ? compress(blending.kernels, values, options.kernel_error)
                                           : CompressedKernels();
  result.components = compressed.components;
  result.basis = compressed.basis;
  result.kernels = compressed.components > 0
                       ? table(compressed.weights, static_cast<std::size_t>(compressed.components),
                               Precision::kFloat16, "kernels")
                       : table(blending.kernels, values, Precision::kFloat16, "kernels");
  watch.lap("compress");

  result.sharpen = encoded(sharpeningOf(knots), 1, Precision::kFloat32, "sharpen");
  result.near = encoded(throughput.near(), result.area_unit, Precision::kFloat16, "near");
  result.far_count = static_cast<int>(throughput.farCount());
  result.spread = encoded(throughput.spread(), 1, Precision::kFloat16, "spread");
  result.far = encoded(throughput.far(), result.area_unit, Precision::kFloat16, "far");

  figures.knots = knots.count();
  figures.far_knots = throughput.farCount();
  figures.triangles = mesh.triangles.size();
  figures.texels = texels.count();
  figures.receivers = blending.receivers.size();
  figures.near_entries = throughput.near().columns.size();
  double side = 0;
  for (const float s : texels.sides) side += static_cast<double>(s) / static_cast<double>(texels.count());
  figures.texels_per_spacing = knots.meanSpacing() / side;
  double path = 1e300;
  for (std::size_t c = 0; c < 3; ++c)
    for (const double share : {0.0, 1.0})
      path = std::min(path, 1 / field.coefficients(c, share).extinction());
  figures.mean_free_path_texels = path / side;
  figures.near_dropped_share = throughput.figures().dropped_share;
  figures.apart_pairs = throughput.figures().apart_pairs;
  figures.touching_knots = throughput.figures().touching_knots;
  figures.rank_deficient = blending.rank_deficient;
  figures.clamped = blending.clamped;
  figures.window_share = blending.window_share;
  if (medium.reflectance == formats::ReflectanceSource::kAlbedo)
    figures.clamped_reflectances = static_cast<std::size_t>(
        std::count_if(mesh.colors.begin(), mesh.colors.end(), [](const formats::Float3& color) {
          const auto [low, high] = std::minmax({color[0], color[1], color[2]});
          return low < transport::MediumField::kLeastReflectance || high > 1;
        }));
  figures.components = compressed.components;
  figures.kernel_error = compressed.error;
  return made;
}

}  // namespace bakelight::kernels
