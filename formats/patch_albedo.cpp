#include "formats/patch_albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace bakelight::formats {
namespace {

// Cosine of a cell's middle, z = 1 − r² in the grid's square (transport/hemisphere_grid.h).
double cosineOf(int views, int column, int row) {
  const double a = std::abs((2 * column + 1.0) / views - 1), b = std::abs((2 * row + 1.0) / views - 1);
  const double radius = std::max(a, b);
  return 1 - radius * radius;
}

}  // namespace

Float3 meanAlbedo(const RadianceTransferTexture& texture) {
  std::array<double, 3> sum{};
  double weight = 0;
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column) {
      const double cosine = texture.views == 1 ? 1 : cosineOf(texture.views, column, row);
      weight += cosine;
      std::array<double, 3> view{};
      for (int y = 0; y < texture.height; ++y)
        for (int x = 0; x < texture.width; ++x)
          for (std::size_t c = 0; c < 3; ++c)
            view[c] += texture.response(column, row, x, y)[c * texture.coefficientCount()];
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] += cosine * view[c] / static_cast<double>(texture.texelCount());
    }
  Float3 albedo;
  for (std::size_t c = 0; c < 3; ++c)  // radiance 1 from all sides is 2√π in coefficient 0
    albedo[c] = static_cast<float>(std::clamp(2 * std::sqrt(std::numbers::pi) * sum[c] / weight, 0.0, 1.0));
  return albedo;
}

void takePatchAlbedo(Materials& materials, std::span<const RadianceTransferTexture> textures) {
  for (const RadianceTransferTexture& texture : textures) {
    Material& material = texture.material.empty() ? materials.base : materials.by_name[texture.material];
    material.albedo = meanAlbedo(texture);
    material.texture.clear();
  }
}

}  // namespace bakelight::formats
