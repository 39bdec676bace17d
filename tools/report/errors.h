// How far a picture is from its reference, in linear radiance (docs/REPORT.md defines the figures).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/image.h"
#include "tools/report/gbuffer.h"

namespace bakelight::report {

// A path-traced picture: R, G, B, A (premultiplied linear radiance) and the variance of each pixel's mean.
// `covered`: the pixel's alpha is 1.
struct Reference {
  Picture picture;
  std::vector<float> variance;  // R, G, B a pixel; empty for a picture without noise
};
// From an image with the channels R, G, B, A and variance.R, variance.G, variance.B. Throws Error(kBadInput)
// naming `file` for a missing channel, a negative variance, or another size than that.
Reference referenceFrom(const formats::Image& image, int width_px, int height_px, const std::string& file);

// Sums over one view. Pixels that count are those that both pictures cover wholly.
struct ViewErrors {
  std::size_t pixels = 0;
  double squared_difference = 0;            // mean |Δ|² over pixels and colours
  double variance = 0;                      // mean variance of both pictures' noise
  double squared_reference = 0;             // mean square of the scale picture
  std::vector<float> relative_differences;  // a pixel: √(mean over colours of Δ²) / √squared_reference
  double coverage_error = 0;                // mean |Δ alpha| / mean alpha of the reference

  // √(max(0, squared_difference − variance) / squared_reference): what noise alone would give is taken away.
  double relativeRmse() const;
};

// `scale` is the picture whose mean square the errors are measured in: the view's truth. Throws
// std::invalid_argument for pictures of different sizes; pixels is 0 if they share none.
ViewErrors viewErrors(const Reference& a, const Reference& b, const Picture& scale);

// Standard error of a reference over its own mean square: √(mean variance / mean square) over covered pixels.
double relativeNoise(const Reference& reference);

// Over views: root of the mean square.
double rootMeanSquare(std::span<const double> values);
// The value that a share `rank` (0–1) of the values does not exceed; the largest for 1. 0 for no values.
double percentile(std::vector<float> values, double rank);

}  // namespace bakelight::report
