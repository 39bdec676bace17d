#include "tools/pack/btf_packing.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "formats/error.h"
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

}  // namespace

PackedBtf packBtf(const formats::Btf& btf, int local_side, const BtfPackingOptions& options) {
  const formats::BtfInfo& info = btf.info();
  int views = 0, lights = 0;
  const std::vector<int> view_of = gridOf(info.views, "views", info.file, views),
                         light_of = gridOf(info.lights, "lights", info.file, lights);
  if (lights != local_side)
    throw badInput({info.file, "", "/btf"},
                   "it has " + std::to_string(lights) + " × " + std::to_string(lights) +
                       " lights, the transfer " + std::to_string(local_side) + " × " +
                       std::to_string(local_side) + " cells a vertex",
                   "as many", "set btf_lights of rtt, or local_side of transfer");
  const std::size_t texels = btf.texelCount(), cells = light_of.size(), values = 3 * cells;
  std::vector<float> samples(view_of.size() * texels * values);
  for (std::size_t view = 0; view < view_of.size(); ++view)
    if (btf.lightsOf(view_of[view]).size() != cells)
      throw badInput({info.file, "view " + std::to_string(view_of[view]), "/btf"},
                     "pictures of it are missing", "one under each light");
  tbb::parallel_for(std::size_t{0}, view_of.size(), [&](std::size_t view) {
    std::vector<float> rgb(values * texels);
    btf.view(view_of[view])->decode(light_of, {0, texels}, rgb);
    for (std::size_t value = 0; value < values; ++value) {
      const int cell = static_cast<int>(value % cells);
      const auto weight = static_cast<float>(
          info.cosine_inside ? 1 : transport::hemisphereCellCosine(lights, cell % lights, cell / lights));
      for (std::size_t t = 0; t < texels; ++t)
        samples[(view * texels + t) * values + value] = weight * rgb[value * texels + t];
    }
  });
  PackedBtf packed;
  packed.reflection.lights = lights;
  const FactoringFigures figures =
      factorPatch({samples, views, info.width, info.height, values}, options.error, options.precision,
                  info.file, packed.reflection);
  packed.reflection.error = static_cast<float>(figures.stored);
  packed.ratio = static_cast<double>(samples.size() * sizeof(float)) /
                 static_cast<double>(packed.reflection.factors.data.size() +
                                     packed.reflection.basis.size() * sizeof(float));
  return packed;
}

}  // namespace bakelight::packing
