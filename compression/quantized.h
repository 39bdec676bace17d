// What wavelet methods share: which coefficients are kept, and as what.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace bakelight::compression {

// Numbers of bits that quantisers are tried with, for the largest value and its sign; 4 and 8 err more at all sizes that were tried.
inline constexpr std::array<int, 2> kQuantizerBits = {5, 6};

// Multiples of a step, of values whose weighted magnitude is at least the threshold.
struct Quantizer {
  float step = 1, threshold = 0;

  static Quantizer of(float largest, int bits, float threshold) {
    return {largest / static_cast<float>((1 << (bits - 1)) - 1), threshold};
  }
  // 0: not kept.
  std::int32_t quantized(float value, float weight) const {
    return std::abs(value) * weight < threshold ? 0 : static_cast<std::int32_t>(std::lround(value / step));
  }
  float value(std::int32_t quantized) const { return static_cast<float>(quantized) * step; }
};

// For solveForBytes: from a ten-millionth of the largest weighted magnitude to just above it.
inline float thresholdAt(double position, float largest) {
  constexpr double kOctaves = 23;
  return largest * static_cast<float>(std::exp2(kOctaves * (position - 1)) * (1 + 1e-4));
}

}  // namespace bakelight::compression
