#include "transport/patch_table.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "transport/hemisphere_grid.h"

namespace bakelight::transport {
namespace {

using formats::Float2;
using formats::RttLevel;

float fraction(float x) {
  return x - std::floor(x);
}

int texelOf(float place, int count) {
  return std::clamp(static_cast<int>(place * static_cast<float>(count)), 0, count - 1);
}

int wrapped(int i, int count) {
  i %= count;
  return i < 0 ? i + count : i;
}

}  // namespace

float leastReliefCosine(int views) {
  return std::min(kLeastReliefCosine, static_cast<float>(hemisphereCell(views, 0, 0).z()));
}

Float2 reliefSlope(const Vec3& direction, float least_cosine) {
  const double z = std::max(direction.z(), double{least_cosine});
  return {static_cast<float>(direction.x() / z), static_cast<float>(direction.y() / z)};
}

PatchTable::PatchTable(const formats::FactoredPatch& source, const formats::PackImage* image)
    : views_(source.views),
      components_(static_cast<std::size_t>(source.components)),
      texel_width_(source.patch_width / static_cast<float>(source.width)),
      aspect_(static_cast<float>(source.width) / static_cast<float>(source.height)),
      repeats_(source.repeats),
      least_cosine_(leastReliefCosine(source.views)),
      levels_(formats::rttLevels(source.width, source.height)),
      factors_(source.factors.decode()) {
  const std::size_t rows = formats::rttTexelCount(levels_) * viewCount();
  if (factors_.size() != rows * components_)
    throw std::invalid_argument("factors of a patch do not fit its size");
  if (source.heights) {
    heights_ = source.heights->decode();
    if (heights_.size() != rows) throw std::invalid_argument("heights of a patch do not fit its size");
    highest_ = *std::max_element(heights_.begin(), heights_.end());
  }
  for (int row = 0; row < source.views; ++row)
    for (int column = 0; column < source.views; ++column)
      slopes_.push_back(reliefSlope(hemisphereCell(source.views, column, row), least_cosine_));
  if (image == nullptr) return;
  if (image->texels.columns != 2 || image->texels.precision != formats::Precision::kUint8)
    throw std::invalid_argument("an index has two channels of 8 bits");
  index_width_ = image->width;
  index_height_ = image->height;
  index_.resize(image->texels.data.size());
  std::transform(image->texels.data.begin(), image->texels.data.end(), index_.begin(),
                 [](std::byte code) { return static_cast<std::uint8_t>(code); });
  std::copy_n(image->texels.scale.begin(), 2, index_scale_.begin());
  std::copy_n(image->texels.offset.begin(), 2, index_offset_.begin());
}

Float2 PatchTable::placeOf(const Float2& texcoord) const {
  if (index_.empty()) {
    const double repeats = repeats_, u = texcoord[0] * repeats, v = texcoord[1] * repeats * double{aspect_};
    return {static_cast<float>(u - std::floor(u)), static_cast<float>(v - std::floor(v))};
  }
  const int x = texelOf(texcoord[0], index_width_), y = texelOf(1 - texcoord[1], index_height_);
  const std::uint8_t* codes = &index_[2 * (static_cast<std::size_t>(y) * index_width_ + x)];
  return {index_offset_[0] + index_scale_[0] * static_cast<float>(codes[0]),
          index_offset_[1] + index_scale_[1] * static_cast<float>(codes[1])};
}

// Linear between texels: heights that jump from texel to texel would make places jump with the last digit.
float PatchTable::heightAt(const RttLevel& level, const Float2& place, std::size_t view) const {
  const float x = place[0] * static_cast<float>(level.width) - 0.5F,
              y = (1 - place[1]) * static_cast<float>(level.height) - 0.5F;
  const float left = std::floor(x), top = std::floor(y), across = x - left, down = y - top;
  const auto at = [&](int i, int j) {
    const std::size_t texel =
        level.first_texel +
        static_cast<std::size_t>(wrapped(static_cast<int>(top) + j, level.height)) * level.width +
        static_cast<std::size_t>(wrapped(static_cast<int>(left) + i, level.width));
    return heights_[texel * viewCount() + view];
  };
  return (1 - down) * ((1 - across) * at(0, 0) + across * at(1, 0)) +
         down * ((1 - across) * at(0, 1) + across * at(1, 1));
}

std::array<PatchTable::View, 4> PatchTable::viewsAt(const RttLevel& level, const Float2& place,
                                                    const Vec3& to_eye) const {
  std::array<View, 4> found;
  if (views_ == 1) {
    found[0] = {0, 1, place};
    return found;
  }
  const GridPosition at = gridPosition(views_, to_eye);
  const Float2 slope = reliefSlope(to_eye, least_cosine_);
  const auto width = static_cast<float>(level.width), height = static_cast<float>(level.height);
  float total = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const int i = static_cast<int>(k) % 2, j = static_cast<int>(k) / 2;
    View& one = found[k];
    one.weight = (i == 0 ? 1 - at.across : at.across) * (j == 0 ? 1 - at.up : at.up);
    one.view = static_cast<std::size_t>((at.row + j) * views_ + at.column + i);
    one.place = place;
    if (!heights_.empty() && one.weight > 0) {
      const Float2 shift = {slope[0] - slopes_[one.view][0], (slope[1] - slopes_[one.view][1]) * aspect_};
      const auto shifted = [&](float h) { return Float2{place[0] + h * shift[0], place[1] + h * shift[1]}; };
      Float2 last = place;
      one.place = shifted(kReliefStart * highest_);
      for (int step = 0; step < kReliefSteps; ++step) {
        last = one.place;
        one.place = shifted(heightAt(level, last, one.view));
      }
      const float off_x = (one.place[0] - last[0]) * width, off_y = (one.place[1] - last[1]) * height;
      one.weight *= kUnseenReliefWeight + std::exp(-(off_x * off_x + off_y * off_y));
    }
    total += one.weight;
  }
  for (View& one : found) one.weight /= total;
  return found;
}

void PatchTable::add(const RttLevel& level, const View& view, float weight, std::span<float> sum) const {
  const int x = texelOf(fraction(view.place[0]), level.width),
            y = texelOf(fraction(1 - view.place[1]), level.height);
  const std::size_t texel = level.first_texel + static_cast<std::size_t>(y) * level.width + x;
  const float* row = &factors_[(texel * viewCount() + view.view) * sum.size()];
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * row[k];
}

}  // namespace bakelight::transport
