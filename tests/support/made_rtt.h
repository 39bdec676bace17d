// Radiance transfer textures of made-up values, smooth over places and views.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "formats/rtt_reflection.h"
#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::tests {

// Hills, a tenth of the patch high.
inline formats::EncodedTable madeHeights(int views, int width, int height) {
  std::vector<float> heights;
  for (const formats::RttLevel& level : formats::rttLevels(width, height))
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        heights.insert(heights.end(), static_cast<std::size_t>(views) * views,
                       static_cast<float>(0.1 * std::sin(6.28 * (x + 0.5) / level.width) *
                                          std::sin(6.28 * (y + 0.5) / level.height)));
  return formats::encodeTable(heights, 1, formats::Precision::kFloat16, "made", "heights");
}

inline formats::RttReflection madeRtt(int order, int views, int width, int height, int components) {
  formats::RttReflection rtt;
  rtt.order = order;
  rtt.views = views;
  rtt.width = width;
  rtt.height = height;
  rtt.components = components;
  rtt.patch_width = 0.5F;
  std::vector<float> factors;
  for (const formats::RttLevel& level : formats::rttLevels(width, height))
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        for (int view = 0; view < views * views; ++view)
          for (int k = 0; k < components; ++k)
            factors.push_back(
                static_cast<float>(0.5 +
                                   0.3 * std::sin(6.28 * (x + 0.5) / level.width + k) *
                                       std::cos(6.28 * (y + 0.5) / level.height) +
                                   0.15 * std::cos(0.4 * (view % views) + 0.3 * (view / views) + 0.7 * k)));
  rtt.factors = formats::encodeTable(factors, static_cast<std::size_t>(components),
                                     formats::Precision::kFloat16, "made", "factors");
  if (views > 1) rtt.heights = madeHeights(views, width, height);
  for (int k = 0; k < components; ++k)
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < order * order; ++i)
        rtt.basis.push_back(static_cast<float>((i == 0 ? 0.8 : 0.1 * std::cos(1.3 * i + c)) / components));
  return rtt;
}

// Places that run over the patch again and again.
inline formats::PackImage madeIndex(int width, int height) {
  formats::PackImage image{width, height, {"U", "V"}, {}};
  formats::Bytes codes;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int code : {(x * 20 + y * 3) % 256, (y * 24 + x * 5) % 256})
        codes.push_back(static_cast<std::byte>(code));
  image.texels.precision = formats::Precision::kUint8;
  image.texels.rows = static_cast<std::size_t>(width) * height;
  image.texels.columns = 2;
  image.texels.data = std::move(codes);
  image.texels.scale = {1.0F / 256, 1.0F / 256};
  image.texels.offset = {1.0F / 512, 1.0F / 512};
  return image;
}

// Longitude and latitude; the seam's triangles run backwards through all longitudes, which shading need not mind.
inline void addSphericalTexcoords(formats::TriangleMesh& mesh) {
  mesh.texcoords.clear();
  for (const formats::Float3& position : mesh.positions) {
    const transport::Vec3 direction = transport::vec3(position).normalized();
    mesh.texcoords.push_back(
        {static_cast<float>(0.5 + std::atan2(direction.x(), direction.z()) / (2 * std::numbers::pi)),
         static_cast<float>(std::acos(-direction.y()) / std::numbers::pi)});
  }
}

}  // namespace bakelight::tests
