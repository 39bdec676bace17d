#include "patch/height_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/error.h"
#include "patch/creased_normals.h"

namespace bakelight::patch {
namespace {

using formats::Image;

constexpr int kMostSide = 4096;
constexpr double kMostHeight = 1000;

std::size_t heightChannel(const Image& image) {
  for (const char* name : {"height", "Z"})
    if (const int channel = image.channelIndex(name); channel >= 0) return static_cast<std::size_t>(channel);
  return 0;
}

// Heights in widths; rows upwards, beyond the picture as it continues.
class Heights {
 public:
  Heights(const Image& image, double depth, bool periodic, const std::string& file)
      : width_(periodic ? image.width : 2 * image.width),
        height_(periodic ? image.height : 2 * image.height) {
    if (image.width < 1 || image.height < 1 || image.channelCount() < 1)
      throw badInput({file, "", ""}, "it has no texel", "a picture of heights");
    if (image.width > kMostSide || image.height > kMostSide)
      throw badInput(
          {file, "", ""},
          "it has " + std::to_string(image.width) + " × " + std::to_string(image.height) + " texels",
          "at most " + std::to_string(kMostSide) + " a side: each becomes a vertex",
          "scale the picture down");
    const std::size_t channel = heightChannel(image);
    values_.resize(static_cast<std::size_t>(width_) * height_);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const int column = x < image.width ? x : 2 * image.width - 1 - x;
        const int row = y < image.height ? image.height - 1 - y : y - image.height;
        const double value = depth * image.texel(column, row)[channel];
        if (!(std::abs(value) <= kMostHeight))
          throw badInput({file, "texel (" + std::to_string(column) + ", " + std::to_string(row) + ")", ""},
                         "its height is not within 1000 widths of the patch",
                         "finite heights of a thin patch", "lessen the patch's depth");
        values_[static_cast<std::size_t>(y) * width_ + x] = value;
      }
    const auto [low, high] = std::minmax_element(values_.begin(), values_.end());
    middle_ = (*low + *high) / 2;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  float at(int x, int y) const {
    return static_cast<float>(values_[static_cast<std::size_t>(y % height_) * width_ + x % width_] - middle_);
  }

 private:
  int width_, height_;
  std::vector<double> values_;
  double middle_ = 0;
};

}  // namespace

PatchGeometry heightField(const Image& image, double depth, bool periodic, const std::string& file) {
  const Heights heights(image, depth, periodic, file);
  PatchGeometry geometry;
  const double texel = 1.0 / image.width;
  geometry.aspect = texel * image.height;
  geometry.period_x = texel * heights.width();
  geometry.period_y = texel * heights.height();
  formats::TriangleMesh mesh;
  for (int y = 0; y <= heights.height(); ++y)
    for (int x = 0; x <= heights.width(); ++x)
      mesh.positions.push_back(
          {static_cast<float>((x + 0.5) * texel), static_cast<float>((y + 0.5) * texel), heights.at(x, y)});
  const auto vertex = [&](int x, int y) {
    return static_cast<std::uint32_t>(static_cast<std::size_t>(y) * (heights.width() + 1) + x);
  };
  for (int y = 0; y < heights.height(); ++y)
    for (int x = 0; x < heights.width(); ++x) {
      const std::uint32_t a = vertex(x, y), b = vertex(x + 1, y), c = vertex(x + 1, y + 1),
                          d = vertex(x, y + 1);
      const auto z = [&](std::uint32_t v) { return mesh.positions[v][2]; };
      if (std::abs(z(a) - z(c)) <= std::abs(z(b) - z(d)))
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
      else
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {b, c, d}});
    }
  geometry.mesh = withCreasedNormals(mesh, geometry.period_x, geometry.period_y);
  return geometry;
}

}  // namespace bakelight::patch
