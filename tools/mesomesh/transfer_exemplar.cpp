#include "tools/mesomesh/transfer_exemplar.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace bakelight::mesomesh {
namespace {

using formats::Image;
using formats::RadianceTransferTexture;

constexpr int kMostViews = 3;  // a side

std::vector<int> chosenViews(int views) {
  if (views <= kMostViews) {
    std::vector<int> all;
    for (int i = 0; i < views; ++i) all.push_back(i);
    return all;
  }
  return {0, views / 2, views - 1};
}

Image emptyImage(const RadianceTransferTexture& texture, std::size_t channels) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < channels; ++i) names.push_back("c" + std::to_string(i));
  return {texture.width, texture.height, std::move(names)};
}

std::vector<float> bandWeights(int order) {
  std::vector<float> weights;
  for (int l = 0; l < order; ++l)
    weights.insert(weights.end(), 2 * static_cast<std::size_t>(l) + 1, 1.0F / (1.0F + static_cast<float>(l)));
  return weights;
}

template <class Visit>
void forTexels(const RadianceTransferTexture& texture, const Visit& visit) {
  for (int y = 0; y < texture.height; ++y)
    for (int x = 0; x < texture.width; ++x) visit(x, y);
}

}  // namespace

Image appearanceOf(const RadianceTransferTexture& texture) {
  const std::vector<int> chosen = chosenViews(texture.views);
  const std::vector<float> weights = bandWeights(texture.order);
  Image image = emptyImage(texture, chosen.size() * chosen.size() * texture.responseSize());
  forTexels(texture, [&](int x, int y) {
    float* to = image.texel(x, y);
    for (const int row : chosen)
      for (const int column : chosen)
        for (std::size_t i = 0; const float value : texture.response(column, row, x, y))
          *to++ = value * weights[i++ % weights.size()];
  });
  return image;
}

Image turnInvariant(const RadianceTransferTexture& texture) {
  const auto bands = static_cast<std::size_t>(texture.order);
  Image image = emptyImage(texture, 3 * bands);
  forTexels(texture, [&](int x, int y) {
    float* to = image.texel(x, y);
    for (int view = 0; view < texture.views * texture.views; ++view) {
      const auto response = texture.response(view % texture.views, view / texture.views, x, y);
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t l = 0; l < bands; ++l)
          to[c * bands + l] +=
              response[c * texture.coefficientCount() + l * (l + 1)] / static_cast<float>(1 + l);
    }
  });
  for (float& value : image.values) value /= static_cast<float>(texture.viewCount());
  return image;
}

Image zenithColors(const RadianceTransferTexture& texture) {
  Image image(texture.width, texture.height, {"R", "G", "B"});
  const float sky = std::sqrt(4 * std::numbers::pi_v<float>);
  const int last = texture.views / 2, first = (texture.views - 1) / 2;
  const auto count = static_cast<float>((last - first + 1) * (last - first + 1));
  forTexels(texture, [&](int x, int y) {
    for (std::size_t c = 0; c < 3; ++c) {
      float sum = 0;
      for (int row = first; row <= last; ++row)
        for (int column = first; column <= last; ++column)
          sum += texture.response(column, row, x, y)[c * texture.coefficientCount()];
      image.texel(x, y)[c] = std::clamp(sky * sum / count, 0.0F, 1.0F);
    }
  });
  return image;
}

}  // namespace bakelight::mesomesh
