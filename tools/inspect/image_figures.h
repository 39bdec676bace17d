// Figures of an image: its channels, and what it is as a light if it can be one.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "tools/inspect/moments.h"
#include "transport/vector_types.h"

namespace bakelight::inspect {

// One a channel, in the image's order.
std::vector<Moments> measureChannels(const formats::Image& image);

// Indices of red, green and blue, with or without a layer's prefix ("Combined.R"); a single channel serves
// all three. Nothing if there are other channels only.
std::optional<std::array<std::size_t, 3>> colorChannels(const formats::Image& image);

// Linear RGB to luminance (Rec. 709).
double luminance(double red, double green, double blue);

struct ProbeFigures {
  std::array<double, 3> mean_radiance = {};  // over the sphere, by exact solid angles
  std::array<double, 3> brightest_radiance = {};
  transport::Vec3 brightest_direction = transport::Vec3::Zero();  // towards the texel of most luminance
  // log2 of the largest luminance over that which 1% of the texels stay below; 0 if that is not positive.
  double dynamic_range_stops = 0;
};

// An image read as a lat-long probe (orientation in transport/lights.h). Nothing unless it is twice as wide
// as high, has colour channels, is finite throughout and not black.
std::optional<ProbeFigures> measureProbe(const formats::Image& image, const std::string& file);

}  // namespace bakelight::inspect
