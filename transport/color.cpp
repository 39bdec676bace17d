#include "transport/color.h"

#include <algorithm>
#include <cmath>

namespace bakelight::transport {

float srgbFromLinear(float linear) {
  if (!(linear > 0)) return 0;  // NaN too
  const float clamped = std::min(linear, 1.0f);
  return clamped <= 0.0031308f ? 12.92f * clamped : 1.055f * std::pow(clamped, 1 / 2.4f) - 0.055f;
}

float linearFromSrgb(float srgb) {
  const float clamped = std::clamp(srgb, 0.0f, 1.0f);
  return clamped <= 0.04045f ? clamped / 12.92f : std::pow((clamped + 0.055f) / 1.055f, 2.4f);
}

int displayCode(float linear) {
  return static_cast<int>(std::lround(255 * srgbFromLinear(linear)));
}

}  // namespace bakelight::transport
