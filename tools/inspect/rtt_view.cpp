#include "tools/inspect/rtt_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/inspect/describe_parts.h"
#include "transport/hemisphere_grid.h"
#include "transport/lights.h"

namespace bakelight::inspect {
namespace {

using formats::RadianceTransferTexture;

// Under a uniform sky, over all views by their cosines and over texels.
formats::Float3 meanAlbedo(const RadianceTransferTexture& texture) {
  std::array<double, 3> sums = {};
  double cosines = 0;
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column) {
      const double cosine = transport::hemisphereCell(texture.views, column, row).z();
      cosines += cosine;
      for (int y = 0; y < texture.height; ++y)
        for (int x = 0; x < texture.width; ++x)
          for (std::size_t c = 0; c < 3; ++c)
            sums[c] += cosine * texture.response(column, row, x, y)[c * texture.coefficientCount()];
    }
  const double sky = std::sqrt(4 * std::numbers::pi) / (cosines * static_cast<double>(texture.texelCount()));
  return {static_cast<float>(sums[0] * sky), static_cast<float>(sums[1] * sky),
          static_cast<float>(sums[2] * sky)};
}

}  // namespace

std::vector<Section> describeRtt(const std::vector<RadianceTransferTexture>& textures) {
  std::vector<Section> sections;
  for (const RadianceTransferTexture& texture : textures) {
    const std::string name = texture.material.empty() ? "texture" : "texture " + texture.material;
    sections.push_back({name,
                        {{"width_px", texture.width, "px"},
                         {"height_px", texture.height, "px"},
                         {"views", texture.viewCount(), ""},
                         {"order", texture.order, ""},
                         {"mean_albedo", listOf(meanAlbedo(texture)), ""}},
                        {},
                        {}});
    sections.push_back(bandSection(name + " bands", texture.values, texture.order));
  }
  return sections;
}

Preview previewRtt(const std::vector<RadianceTransferTexture>& textures, const PreviewOptions& options) {
  int width = 0, height = 0;
  for (const RadianceTransferTexture& texture : textures) {
    width = std::max(width, texture.views * texture.width);
    height += texture.views * texture.height;
  }
  formats::Image image(width, height, {"R", "G", "B"});
  int top = 0;
  for (const RadianceTransferTexture& texture : textures) {
    const transport::ShLight light = transport::defaultLight(texture.order);
    for (int row = 0; row < texture.views; ++row)
      for (int column = 0; column < texture.views; ++column)
        for (int y = 0; y < texture.height; ++y)
          for (int x = 0; x < texture.width; ++x) {
            const auto response = texture.response(column, row, x, y);
            float* texel =
                image.texel(column * texture.width + x, top + (texture.views - 1 - row) * texture.height + y);
            for (std::size_t c = 0; c < 3; ++c)
              for (std::size_t i = 0; i < light.size(); ++i)
                texel[c] += response[c * light.size() + i] * light[i][c];
          }
    top += texture.views * texture.height;
  }
  Preview preview = previewImage(image, false, options);
  preview.caption =
      "the patch under a key light from the upper left, towards all views: from above in the middle";
  return preview;
}

}  // namespace bakelight::inspect
