#include "tools/inspect/colormap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/color.h"

namespace bakelight::inspect {

DisplayColor divergingColor(double value) {
  constexpr std::array<double, 3> kCool = {0.230, 0.299, 0.754}, kWarm = {0.706, 0.016, 0.150};
  if (!std::isfinite(value)) return kNotFiniteColor;
  const auto& end = value < 0 ? kCool : kWarm;
  const double amount = std::sqrt(std::min(std::abs(value), 1.0));
  DisplayColor color{};
  for (std::size_t c = 0; c < 3; ++c) color[c] = static_cast<float>(1 + amount * (end[c] - 1));
  return color;
}

DisplayColor chartColor(std::uint32_t number) {
  // Oklab (Ottosson 2020). Steps of five twelfths of the circle visit all hues.
  const double hue = 2 * std::numbers::pi * ((number * 5) % kChartColors) / kChartColors + 0.35;
  const double lightness = number % 2 == 0 ? 0.80 : 0.66, chroma = 0.11;
  const double a = chroma * std::cos(hue), b = chroma * std::sin(hue);
  const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
  const auto display = [](double linear) { return transport::srgbFromLinear(static_cast<float>(linear)); };
  return {display(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          display(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          display(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

}  // namespace bakelight::inspect
