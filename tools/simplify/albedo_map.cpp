#include "tools/simplify/albedo_map.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <utility>

#include "formats/color_picture.h"
#include "formats/error.h"

namespace bakelight::simplify {
namespace {

using formats::Image;
using transport::Vec3;
using Wrap = AlbedoMap::Wrap;

constexpr const char* kOwnTextureRemedy = "put a picture there, or give the mesh another one with --texture";

// Lists the picture and its halves, so that a sample takes the mean of what it stands for.
std::vector<Image> halvings(Image image) {
  std::vector<Image> levels;
  levels.push_back(std::move(image));
  while (levels.back().width > 1 || levels.back().height > 1) {
    const Image& fine = levels.back();
    Image coarse(std::max(fine.width / 2, 1), std::max(fine.height / 2, 1), fine.channel_names);
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const int right = std::min(2 * x + 1, fine.width - 1), below = std::min(2 * y + 1, fine.height - 1);
          coarse.texel(x, y)[c] = (fine.texel(2 * x, 2 * y)[c] + fine.texel(right, 2 * y)[c] +
                                   fine.texel(2 * x, below)[c] + fine.texel(right, below)[c]) /
                                  4;
        }
    levels.push_back(std::move(coarse));
  }
  return levels;
}

// A coordinate within the picture.
double wrapped(double u, Wrap wrap) {
  switch (wrap) {
    case Wrap::kRepeat:
      return u - std::floor(u);
    case Wrap::kMirror: {
      const double phase = u - 2 * std::floor(u / 2);
      return phase > 1 ? 2 - phase : phase;
    }
    case Wrap::kClamp:
      break;
  }
  return std::clamp(u, 0.0, 1.0);
}

// Beyond the side a mirrored picture shows the texel beside it once more, as a clamped one does.
int wrapped(int i, int size, Wrap wrap) {
  return wrap == Wrap::kRepeat ? (i % size + size) % size : std::clamp(i, 0, size - 1);
}

Image readPicture(const formats::AlbedoTexture& texture, const std::string& mesh_file) {
  using formats::PictureTurn, formats::PictureUse;
  const PictureTurn turn = texture.as_stored ? PictureTurn::kAsStored : PictureTurn::kAsFileSays;
  if (!texture.bytes.empty())
    return formats::readColorPicture(texture.bytes, texture.name, PictureUse::kReflectance, turn).image;
  if (!std::filesystem::is_regular_file(texture.path))
    throw badInput({texture.path.string(), "", ""}, "there is no such file",
                   "the picture that gives " + mesh_file + " its albedo", kOwnTextureRemedy);
  return formats::readColorPicture(texture.path, PictureUse::kReflectance, turn).image;
}

}  // namespace

Image readAlbedoTexture(const formats::AlbedoTexture& texture, const std::string& mesh_file,
                        std::vector<std::string>& notes) {
  Image albedo = readPicture(texture, mesh_file);
  std::size_t outside = 0;
  for (std::size_t texel = 0; 3 * texel < albedo.values.size(); ++texel) {
    const std::span<float> color(&albedo.values[3 * texel], 3);
    outside += std::any_of(color.begin(), color.end(), [](float value) { return value < 0 || value > 1; });
    for (float& value : color) value = std::clamp(value, 0.0F, 1.0F);
  }
  if (outside > 0)
    notes.push_back(texture.name + ": " + std::to_string(outside) +
                    " texels are no albedo and were clamped to 0–1");
  return albedo;
}

AlbedoMap::AlbedoMap(Image image, Wrap wrap_u, Wrap wrap_v)
    : levels_(halvings(std::move(image))), wrap_u_(wrap_u), wrap_v_(wrap_v) {}

Vec3 AlbedoMap::colorAt(double u, double v, double area) const {
  const double covered = area * levels_.front().width * levels_.front().height;  // texels
  const int level = covered > 1 ? static_cast<int>(std::lround(0.5 * std::log2(covered))) : 0;
  const Image& texture = levels_[std::min<std::size_t>(level, levels_.size() - 1)];
  const double x = wrapped(u, wrap_u_) * texture.width - 0.5;
  const double y = (1 - wrapped(v, wrap_v_)) * texture.height - 0.5;
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  Vec3 color = Vec3::Zero();
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const double weight = (dx == 1 ? x - column : 1 - (x - column)) * (dy == 1 ? y - row : 1 - (y - row));
      const float* texel = texture.texel(wrapped(column + dx, texture.width, wrap_u_),
                                         wrapped(row + dy, texture.height, wrap_v_));
      color += weight * Vec3(texel[0], texel[1], texel[2]);
    }
  return color;
}

}  // namespace bakelight::simplify
