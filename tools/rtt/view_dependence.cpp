#include "tools/rtt/view_dependence.h"

#include <cmath>
#include <vector>

#include "transport/hemisphere_grid.h"

namespace bakelight::rtt {
namespace {

using formats::RadianceTransferTexture;

// Of the views, the weights that add up to 1: by cosine, or of the four around the zenith.
std::vector<double> cosineWeights(const RadianceTransferTexture& texture) {
  std::vector<double> weights;
  double sum = 0;
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column) {
      weights.push_back(transport::hemisphereCell(texture.views, column, row).z());
      sum += weights.back();
    }
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<double> headOnWeights(const RadianceTransferTexture& texture) {
  std::vector<double> weights(texture.viewCount(), 0.0);
  const transport::GridPosition at = transport::gridPosition(texture.views, transport::Vec3(0, 0, 1));
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double weight = (i == 1 ? at.across : 1 - at.across) * (j == 1 ? at.up : 1 - at.up);
      if (weight > 0) weights[static_cast<std::size_t>(at.row + j) * texture.views + at.column + i] += weight;
    }
  return weights;
}

}  // namespace

ViewDependence viewDependence(const RadianceTransferTexture& texture) {
  const std::vector<double> cosines = cosineWeights(texture), head_on = headOnWeights(texture);
  const int step = texture.width >= 32 ? 4 : 1;
  double squares = 0, from_mean = 0, from_head_on = 0;
  std::vector<double> mean(texture.responseSize()), above(texture.responseSize());
  for (int y = 0; y < texture.height; y += step)
    for (int x = 0; x < texture.width; x += step) {
      const auto response = [&](std::size_t view) {
        const int columns = texture.views;
        return texture.response(static_cast<int>(view) % columns, static_cast<int>(view) / columns, x, y);
      };
      std::fill(mean.begin(), mean.end(), 0.0), std::fill(above.begin(), above.end(), 0.0);
      for (std::size_t v = 0; v < cosines.size(); ++v)
        for (std::size_t i = 0; i < mean.size(); ++i) {
          mean[i] += cosines[v] * response(v)[i];
          above[i] += head_on[v] * response(v)[i];
        }
      for (std::size_t v = 0; v < cosines.size(); ++v)
        for (std::size_t i = 0; i < mean.size(); ++i) {
          const double value = response(v)[i];
          squares += cosines[v] * value * value;
          from_mean += cosines[v] * (value - mean[i]) * (value - mean[i]);
          from_head_on += cosines[v] * (value - above[i]) * (value - above[i]);
        }
    }
  if (squares == 0) return {};
  return {std::sqrt(from_mean / squares), std::sqrt(from_head_on / squares)};
}

}  // namespace bakelight::rtt
