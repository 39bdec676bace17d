#include "tools/pack/btf_packing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "formats/error.h"
#include "formats/patch_code.h"
#include "formats/patch_levels.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::packing {
namespace {

// Which of the directions is the middle of each cell of the grid that they are; `what` are they, for errors.
std::vector<int> gridOf(const std::vector<formats::BtfDirection>& directions, const char* what,
                        const std::string& file, int& side) {
  constexpr double kTolerance = 2e-3;  // rad
  const Error error =
      badInput({file, "", "/btf"},
               std::string("its ") + what + " are not the middles of a grid's cells over the hemisphere",
               "a BTF in a directional basis", "make it with rtt's output btf");
  side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(directions.size()))));
  if (directions.empty() || static_cast<std::size_t>(side) * side != directions.size()) throw error;
  std::vector<int> indices(directions.size(), -1);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double sine = std::sin(directions[i].polar_rad);
    const transport::Vec3 direction(sine * std::cos(directions[i].azimuth_rad),
                                    sine * std::sin(directions[i].azimuth_rad),
                                    std::cos(directions[i].polar_rad));
    const transport::SquarePoint place = transport::squareFromHemisphere(direction);
    const int column = std::min(static_cast<int>(place.a * side), side - 1),
              row = std::min(static_cast<int>(place.b * side), side - 1);
    int& index = indices[static_cast<std::size_t>(row) * side + column];
    if (index >= 0 || (transport::hemisphereCell(side, column, row) - direction).norm() > kTolerance)
      throw error;
    index = static_cast<int>(i);
  }
  return indices;
}

// Error that is left to components: so many are played a pixel, while finer steps only cost bytes.
constexpr double kShareOfComponents = 0.6;
// Heights may err by so much of a texel's width, root mean square: seen at 45°, places move by as much.
constexpr double kHeightError = 0.125;

formats::IntegerArray arrayOf(formats::Bytes bytes) {
  return {1, std::move(bytes)};
}

// Steps for what the error leaves to them beside the components.
formats::PatchCode codeOf(const Factored& made, const std::vector<float>& heights,
                          const formats::BtfReflection& btf, const BtfPackingOptions& options) {
  formats::PatchCode code;
  code.precision = options.precision;
  const formats::PatchEncoder encoder(made.values, {btf.width, btf.height, btf.views, btf.components});
  const double left = std::max(options.error * options.error - made.error * made.error, 1e-12);
  code.step = encoder.stepFor(left * std::max(made.total, 1e-30));
  code.factors = arrayOf(encoder.encode(code.step));
  if (heights.empty()) return code;
  const formats::PatchEncoder relief(heights, {btf.width, btf.height, btf.views, 1});
  const double least = kHeightError / btf.width;
  const float step = relief.stepFor(least * least * static_cast<double>(heights.size()));
  code.relief = formats::ReliefCode{step, arrayOf(relief.encode(step))};
  return code;
}

double squaredDifference(const std::vector<float>& stored, const std::vector<float>& values) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += (double{stored[i]} - values[i]) * (double{stored[i]} - values[i]);
  return sum;
}

}  // namespace

BtfSamples samplesOf(const formats::Btf& btf) {
  const formats::BtfInfo& info = btf.info();
  BtfSamples samples;
  samples.file = info.file, samples.width = info.width, samples.height = info.height;
  const std::vector<int> view_of = gridOf(info.views, "views", info.file, samples.views),
                         light_of = gridOf(info.lights, "lights", info.file, samples.lights);
  const std::size_t texels = btf.texelCount(), cells = light_of.size(), values = 3 * cells;
  samples.values.resize(view_of.size() * texels * values);
  for (const int view : view_of)
    if (btf.lightsOf(view).size() != cells)
      throw badInput({info.file, "view " + std::to_string(view), "/btf"}, "pictures of it are missing",
                     "one under each light");
  tbb::parallel_for(std::size_t{0}, view_of.size(), [&](std::size_t view) {
    std::vector<float> rgb(values * texels);
    btf.view(view_of[view])->decode(light_of, {0, texels}, rgb);
    for (std::size_t value = 0; value < values; ++value) {
      const int cell = static_cast<int>(value % cells), side = samples.lights;
      const auto weight = static_cast<float>(
          info.cosine_inside ? 1 : transport::hemisphereCellCosine(side, cell % side, cell / side));
      for (std::size_t t = 0; t < texels; ++t)
        samples.values[(view * texels + t) * values + value] = weight * rgb[value * texels + t];
    }
  });
  return samples;
}

BtfSamples samplesOf(const formats::BtfTable& table) {
  const std::size_t views = static_cast<std::size_t>(table.views) * table.views,
                    a_view = table.valueCount() / views;
  BtfSamples samples{table.file,  table.views,  table.lights,
                     table.width, table.height, std::vector<float>(table.valueCount())};
  tbb::parallel_for(std::size_t{0}, views, [&](std::size_t view) {
    const std::vector<float> values = table.valuesOf(view);
    std::copy(values.begin(), values.end(),
              samples.values.begin() + static_cast<std::ptrdiff_t>(view * a_view));
  });
  return samples;
}

PackedBtf packBtf(const BtfSamples& samples, int local_side, const BtfPackingOptions& options,
                  const formats::RadianceTransferTexture* texture, const RttPackingOptions& relief) {
  if (samples.lights != local_side)
    throw badInput({samples.file, "", "/btf"},
                   "it has " + std::to_string(samples.lights) + " × " + std::to_string(samples.lights) +
                       " lights, the transfer " + std::to_string(local_side) + " × " +
                       std::to_string(local_side) + " cells a vertex",
                   "as many", "set btf_lights of rtt, or local_side of transfer");
  Factored made = factored({samples.values, samples.views, samples.width, samples.height,
                            3 * static_cast<std::size_t>(samples.lights) * samples.lights},
                           kShareOfComponents * options.error);
  PackedBtf packed;
  packed.components_error = made.error;
  packed.value_count = samples.values.size();
  formats::BtfReflection& patch = packed.reflection;
  patch.lights = samples.lights;
  patch.views = samples.views;
  patch.width = samples.width;
  patch.height = samples.height;
  patch.components = made.components;
  const bool has_heights = texture != nullptr && texture->views == samples.views &&
                           texture->width == samples.width && texture->height == samples.height;
  const std::vector<float> heights = has_heights ? heightsByTexel(*texture, relief) : std::vector<float>();
  if (options.error > 0) {
    patch.code = codeOf(made, heights, patch, options);
    formats::expandPatch(patch, samples.file);
    packed.stored_bytes =
        patch.code->factors.data.size() + (patch.code->relief ? patch.code->relief->heights.data.size() : 0);
  } else {
    const std::size_t components = static_cast<std::size_t>(made.components);
    patch.factors = formats::encodeTable(
        formats::withLevels(made.values, samples.width, samples.height,
                            components * static_cast<std::size_t>(samples.views) * samples.views),
        components, options.precision, samples.file, "factors of the patch");
    if (has_heights) patch.heights = reliefOf(*texture, relief, samples.file);
    packed.stored_bytes = patch.factors.data.size() + (patch.heights ? patch.heights->data.size() : 0);
  }
  const double lost = squaredDifference(patch.factors.decode(), made.values);
  patch.error =
      static_cast<float>(std::sqrt(made.error * made.error + (made.total > 0 ? lost / made.total : 0)));
  patch.basis = std::move(made.basis);
  packed.stored_bytes += patch.basis.size() * sizeof(float);
  patch.storage_ratio = static_cast<float>(2 * static_cast<double>(packed.value_count) /
                                           static_cast<double>(packed.stored_bytes));
  return packed;
}

}  // namespace bakelight::packing
