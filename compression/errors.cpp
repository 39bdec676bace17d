#include "compression/errors.h"

#include <cmath>
#include <stdexcept>

#include "transport/cube_map.h"

namespace bakelight::compression {

double relativeRms(std::span<const Radiance4> values, std::span<const Radiance4> truth) {
  if (values.size() != truth.size())
    throw std::invalid_argument("relativeRms: values and truth differ in number");
  double difference = 0, square = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double off = double{values[i](c)} - truth[i](c);
      difference += off * off;
      square += double{truth[i](c)} * truth[i](c);
    }
  return square > 0 ? std::sqrt(difference / square) : 0;
}

std::vector<Radiance4> texelEnergies(std::span<const formats::Float3> radiance, int cube_side) {
  std::vector<Radiance4> energies(radiance.size());
  for (std::size_t k = 0; k < energies.size(); ++k) {
    const auto within = static_cast<int>(k) % (cube_side * cube_side);
    const auto solid_angle =
        static_cast<float>(transport::cubeTexelSolidAngle(within % cube_side, within / cube_side, cube_side));
    energies[k] = Radiance4(radiance[k][0], radiance[k][1], radiance[k][2], 0) * solid_angle;
  }
  return energies;
}

}  // namespace bakelight::compression
