// Colours that stand for values and for charts.
#pragma once

#include <array>
#include <cstdint>

namespace bakelight::inspect {

using DisplayColor = std::array<float, 3>;  // sRGB, 0–1

inline constexpr DisplayColor kNotFiniteColor = {1, 0, 1};

// A cool-to-warm diverging map (end colours of Moreland 2009) from −1 to 1, white in the middle; it grows
// with the square root, so that small values of either sign show.
DisplayColor divergingColor(double value);

// One of twelve hues, every other one darker; far from each other from one number to the next.
inline constexpr std::uint32_t kChartColors = 12;
DisplayColor chartColor(std::uint32_t number);

}  // namespace bakelight::inspect
