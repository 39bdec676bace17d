#include "patch/patch_geometry.h"

#include <algorithm>
#include <cmath>

namespace bakelight::patch {
namespace {

// Into 0–1 along a period of `period` units of the patch's side, which is 2 where the second is a mirror image.
double folded(double at, double period) {
  const double place = at - period * std::floor(at / period);
  return place > 1 ? 2 - place : place;
}

struct Tap {
  int first, second;
  float weight;  // of the second
};
Tap tapAt(double place, int side, bool wraps) {
  const double texel = place * side - 0.5;
  const auto below = static_cast<int>(std::floor(texel));
  const auto inside = [&](int i) { return wraps ? (i + side) % side : std::clamp(i, 0, side - 1); };
  return {inside(below), inside(below + 1), static_cast<float>(texel - below)};
}

Float3 product(const Float3& a, const Float3& b) {
  return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}

}  // namespace

Float3 PatchGeometry::textureAt(double x, double y) const {
  if (texture.values.empty()) return {1, 1, 1};
  const Tap across = tapAt(folded(x, period_x), texture.width, !mirrored());
  const Tap down = tapAt(1 - folded(y / aspect, period_y / aspect), texture.height, !mirrored());
  Float3 color;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto row = [&](int j) {
      return (1 - across.weight) * texture.texel(across.first, j)[c] +
             across.weight * texture.texel(across.second, j)[c];
    };
    color[c] = (1 - down.weight) * row(down.first) + down.weight * row(down.second);
  }
  return color;
}

Float3 PatchGeometry::albedoAt(std::uint32_t triangle, float u, float v) const {
  const formats::Triangle& corners = mesh.triangles[triangle];
  const std::array<float, 3> weights = {1 - u - v, u, v};
  Float3 color = {1, 1, 1};
  double x = 0, y = 0;
  if (!mesh.colors.empty()) color = {0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    x += static_cast<double>(weights[i]) * mesh.positions[corners[i]][0];
    y += static_cast<double>(weights[i]) * mesh.positions[corners[i]][1];
    if (mesh.colors.empty()) continue;
    for (std::size_t c = 0; c < 3; ++c) color[c] += weights[i] * mesh.colors[corners[i]][c];
  }
  return product(albedo, product(color, textureAt(x, y)));
}

Float3 PatchGeometry::albedoOfVertex(std::uint32_t vertex) const {
  const Float3& p = mesh.positions[vertex];
  const Float3 color = mesh.colors.empty() ? Float3{1, 1, 1} : mesh.colors[vertex];
  return product(albedo, product(color, textureAt(p[0], p[1])));
}

}  // namespace bakelight::patch
