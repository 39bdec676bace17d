#include "tools/report/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "formats/error.h"

namespace bakelight::report {
namespace {

// Samples that all hit may add up to a little less than 1.
constexpr float kWholeAlpha = 1 - 1e-5F;

template <std::size_t N>
std::array<int, N> channelsOf(const formats::Image& image, const std::array<const char*, N>& names,
                              const std::string& file) {
  std::array<int, N> channels;
  for (std::size_t i = 0; i < N; ++i) {
    channels[i] = image.channelIndex(names[i]);
    if (channels[i] < 0)
      throw badInput({file, std::string("channel ") + names[i], ""}, "there is no such channel",
                     "R, G, B, A, variance.R, variance.G and variance.B", "rendering it with `reference`");
  }
  return channels;
}

double meanSquare(const Picture& picture, const std::vector<std::uint8_t>& counts) {
  double sum = 0;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) continue;
    ++pixels;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = picture.linear.values[4 * i + c];
      sum += value * value;
    }
  }
  return pixels > 0 ? sum / (3.0 * static_cast<double>(pixels)) : 0;
}

double coverageError(const formats::Image& a, const formats::Image& b) {
  double difference = 0, sum = 0;
  for (std::size_t i = 3; i < a.values.size(); i += 4) {
    difference += std::abs(static_cast<double>(a.values[i]) - b.values[i]);
    sum += a.values[i];
  }
  return sum > 0 ? difference / sum : 0;
}

}  // namespace

Reference referenceFrom(const formats::Image& image, int width_px, int height_px, const std::string& file) {
  if (image.width != width_px || image.height != height_px)
    throw badInput(
        {file, "", ""},
        "it has " + std::to_string(image.width) + " × " + std::to_string(image.height) + " pixels",
        "those of the view's frame, " + std::to_string(width_px) + " × " + std::to_string(height_px));
  const auto color = channelsOf<4>(image, {"R", "G", "B", "A"}, file);
  const auto variance = channelsOf<3>(image, {"variance.R", "variance.G", "variance.B"}, file);
  const std::size_t pixels = static_cast<std::size_t>(width_px) * height_px;
  Reference reference{{formats::Image(width_px, height_px, {"R", "G", "B", "A"}), {}}, {}};
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* texel = &image.values[i * image.channelCount()];
    for (std::size_t c = 0; c < 4; ++c) reference.picture.linear.values[4 * i + c] = texel[color[c]];
    reference.picture.covered.push_back(texel[color[3]] >= kWholeAlpha);
    for (const int channel : variance) {
      if (texel[channel] < 0)
        throw badInput({file, "channel " + image.channel_names[channel], ""}, "a variance is negative");
      reference.variance.push_back(texel[channel]);
    }
  }
  return reference;
}

double ViewErrors::relativeRmse() const {
  return squared_reference > 0 ? std::sqrt(std::max(0.0, squared_difference - variance) / squared_reference)
                               : 0;
}

ViewErrors viewErrors(const Reference& a, const Reference& b, const Picture& scale) {
  const std::size_t pixels = a.picture.covered.size();
  if (b.picture.covered.size() != pixels || scale.covered.size() != pixels)
    throw std::invalid_argument("pictures that are compared have one size");
  std::vector<std::uint8_t> counts(pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    counts[i] = a.picture.covered[i] && b.picture.covered[i] && scale.covered[i];

  ViewErrors errors;
  errors.squared_reference = meanSquare(scale, counts);
  errors.coverage_error = coverageError(a.picture.linear, b.picture.linear);
  const double scale_rms = std::sqrt(errors.squared_reference);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!counts[i]) continue;
    double squared = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference =
          static_cast<double>(b.picture.linear.values[4 * i + c]) - a.picture.linear.values[4 * i + c];
      squared += difference * difference;
      for (const Reference* noisy : {&a, &b})
        if (!noisy->variance.empty()) errors.variance += noisy->variance[3 * i + c];
    }
    ++errors.pixels;
    errors.squared_difference += squared;
    errors.relative_differences.push_back(
        scale_rms > 0 ? static_cast<float>(std::sqrt(squared / 3) / scale_rms) : 0);
  }
  if (errors.pixels > 0) {
    errors.squared_difference /= 3.0 * static_cast<double>(errors.pixels);
    errors.variance /= 3.0 * static_cast<double>(errors.pixels);
  }
  return errors;
}

double relativeNoise(const Reference& reference) {
  const ViewErrors errors = viewErrors(reference, {reference.picture, {}}, reference.picture);
  return errors.squared_reference > 0 ? std::sqrt(errors.variance / errors.squared_reference) : 0;
}

double rootMeanSquare(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double percentile(std::vector<float> values, double rank) {
  if (values.empty()) return 0;
  const double count = static_cast<double>(values.size());
  const auto place = static_cast<std::size_t>(std::clamp(std::ceil(rank * count) - 1, 0.0, count - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[place];
}

}  // namespace bakelight::report
