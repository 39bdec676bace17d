#include "formats/vertex_colors.h"

#include <cmath>

namespace bakelight::formats {

float linearFromSrgb(float srgb) {
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

Float3 linearFromSrgb(const Float3& srgb) {
  return {linearFromSrgb(srgb[0]), linearFromSrgb(srgb[1]), linearFromSrgb(srgb[2])};
}

void ColorRange::add(const Float3& color) {
  for (const float value : color) {
    if (value > largest_) largest_ = value;
    whole_ = whole_ && value == std::floor(value);
  }
}

}  // namespace bakelight::formats
