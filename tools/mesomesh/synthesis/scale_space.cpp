#include "tools/mesomesh/synthesis/scale_space.h"

#include <cmath>
#include <utility>
#include <vector>

namespace bakelight::mesomesh {
namespace {

using Kernel = std::vector<float>;  // about its middle

ChannelGrid filteredAlong(const ChannelGrid& grid, const Kernel& kernel, bool rows) {
  ChannelGrid result = grid;
  result.values.setZero();
  const int reach = static_cast<int>(std::ssize(kernel) / 2);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      for (int tap = 0; tap < std::ssize(kernel); ++tap) {
        const int k = tap - reach;
        result.values.row(grid.row(x, y)) +=
            kernel[tap] * grid.values.row(rows ? grid.row(x + k, y) : grid.row(x, y + k));
      }
  return result;
}

Kernel gaussian(double sigma) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) sum += weights.emplace_back(std::exp(-k * k / (2 * sigma * sigma)));
  Kernel kernel;
  for (const double weight : weights) kernel.push_back(static_cast<float>(weight / sum));
  return kernel;
}

// Weights of the texels −1, 0, 1, 2 at `t` of the way from 0 to 1.
std::array<float, 4> catmullRom(double t) {
  const std::array<double, 4> weights = {0.5 * t * (-1 + t * (2 - t)), 1 + t * t * (-2.5 + 1.5 * t),
                                         0.5 * t * (1 + t * (4 - 3 * t)), 0.5 * t * t * (t - 1)};
  return {static_cast<float>(weights[0]), static_cast<float>(weights[1]), static_cast<float>(weights[2]),
          static_cast<float>(weights[3])};
}

ChannelGrid upsampledAlong(const ChannelGrid& grid, int factor, bool rows) {
  ChannelGrid result{
      rows ? grid.width * factor : grid.width, rows ? grid.height : grid.height * factor, grid.periodic, {}};
  result.values.setZero(static_cast<Eigen::Index>(result.width) * result.height, grid.values.cols());
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) {
      const int along = rows ? x : y, texel = along / factor;
      const std::array<float, 4> weights = catmullRom(static_cast<double>(along % factor) / factor);
      for (int k = 0; k < 4; ++k)
        result.values.row(result.row(x, y)) +=
            weights[static_cast<std::size_t>(k)] *
            grid.values.row(rows ? grid.row(texel + k - 1, y) : grid.row(x, texel + k - 1));
    }
  return result;
}

}  // namespace

ChannelGrid blurredFor(const Exemplar& exemplar, double step) {
  ChannelGrid grid{exemplar.width, exemplar.height, exemplar.periodic, exemplar.channels};
  // A texel stands for a Gaussian of half its side already.
  const double sigma = step > 1 ? 0.5 * std::sqrt(step * step - 1) : 0;
  if (sigma < 0.1) return grid;
  const Kernel kernel = gaussian(sigma);
  return filteredAlong(filteredAlong(grid, kernel, true), kernel, false);
}

ChannelGrid upsampled(ChannelGrid grid, int factor) {
  if (factor == 1) return grid;
  return upsampledAlong(upsampledAlong(grid, factor, true), factor, false);
}

}  // namespace bakelight::mesomesh
