// Exemplars of texture made by code: linear values, periodic where they do not say otherwise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "formats/image.h"
#include "transport/random.h"

namespace bakelight::tests {

// In [0, 1).
inline double hashedUnit(std::uint64_t seed, std::uint64_t element) {
  return static_cast<double>(transport::scrambled(transport::scrambled(seed) ^ element) >> 11) * 0x1p-53;
}

// A plain weave: red threads over and under white ones, each thread of a shade of its own; colour and height.
inline formats::Image weave(int side = 64, int thread = 8) {
  formats::Image image(side, side, {"R", "G", "B", "height"});
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int column = x / thread, row = y / thread;
      const bool warp_over = (column + row) % 2 == 0;
      const double across = ((warp_over ? x : y) % thread + 0.5) / thread * 2 - 1;
      const double along = ((warp_over ? y : x) % thread + 0.5) / thread * 2 - 1;
      const double height =
          std::sqrt(std::max(0.0, 1 - 0.8 * across * across)) * (0.6 + 0.4 * (1 - along * along));
      const double shade =
          0.75 + 0.25 * hashedUnit(warp_over ? 1 : 2, static_cast<std::uint64_t>(warp_over ? column : row));
      const std::array<double, 3> color =
          warp_over ? std::array{0.55, 0.09, 0.07} : std::array{0.75, 0.68, 0.52};
      for (std::size_t c = 0; c < 3; ++c)
        image.texel(x, y)[c] = static_cast<float>(color[c] * shade * (0.25 + 0.75 * height));
      image.texel(x, y)[3] = static_cast<float>(0.3 * height);
    }
  return image;
}

// Stones of different grays between dark joints: Voronoi cells of points scattered on a torus.
inline formats::Image stones(int side = 64, int count = 26) {
  formats::Image image(side, side, {"R", "G", "B"});
  struct Stone {
    double x, y, gray, warmth;
  };
  std::vector<Stone> chosen;
  // Of ten places the one farthest from the others each time, so that stones are of like size (Mitchell 1991).
  for (int s = 0; s < count; ++s) {
    Stone best{};
    double best_distance = -1;
    for (int candidate = 0; candidate < 10; ++candidate) {
      const auto key = static_cast<std::uint64_t>(s * 10 + candidate);
      const Stone stone{hashedUnit(3, key) * side, hashedUnit(4, key) * side,
                        0.12 + 0.55 * hashedUnit(5, key), hashedUnit(6, key)};
      double nearest = std::numeric_limits<double>::max();
      for (const Stone& other : chosen) {
        const double dx = std::remainder(stone.x - other.x, side),
                     dy = std::remainder(stone.y - other.y, side);
        nearest = std::min(nearest, dx * dx + dy * dy);
      }
      if (nearest > best_distance) best_distance = nearest, best = stone;
    }
    chosen.push_back(best);
  }
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      double first = std::numeric_limits<double>::max(), second = first;
      const Stone* nearest = nullptr;
      for (const Stone& stone : chosen) {
        const double distance =
            std::hypot(std::remainder(x + 0.5 - stone.x, side), std::remainder(y + 0.5 - stone.y, side));
        if (distance < first)
          second = first, first = distance, nearest = &stone;
        else
          second = std::min(second, distance);
      }
      const double face = std::clamp((second - first - 0.6) / 2.0, 0.0, 1.0);
      const double gray = 0.03 + (nearest->gray - 0.03) * face;
      const std::array<double, 3> tint = {1, 0.95 - 0.08 * nearest->warmth, 0.88 - 0.25 * nearest->warmth};
      for (std::size_t c = 0; c < 3; ++c) image.texel(x, y)[c] = static_cast<float>(gray * tint[c]);
    }
  return image;
}

inline formats::Image whiteNoise(int side = 64, int channels = 3) {
  static const std::vector<std::string> kNames = {"R", "G", "B", "A", "X", "Y", "Z", "W"};
  formats::Image image(side, side, {kNames.begin(), kNames.begin() + channels});
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<float>(hashedUnit(7, i));
  return image;
}

// Noise of grains some texels wide.
inline formats::Image stochastic(int side = 64, double grain_texels = 1.4) {
  const formats::Image noise = whiteNoise(side);
  formats::Image image = noise;
  const int reach = static_cast<int>(std::ceil(3 * grain_texels));
  double sum_of_squares = 0;
  std::vector<double> kernel;
  for (int k = -reach; k <= reach; ++k)
    kernel.push_back(std::exp(-k * k / (2 * grain_texels * grain_texels))),
        sum_of_squares += kernel.back() * kernel.back();
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = -reach; j <= reach; ++j)
          for (int i = -reach; i <= reach; ++i)
            sum += kernel[i + reach] * kernel[j + reach] *
                   (noise.texel((x + i + side) % side, (y + j + side) % side)[c] - 0.5);
        // All of one deviation, whatever the grain; the channels go together for the most part.
        image.texel(x, y)[c] = static_cast<float>(sum / sum_of_squares);
      }
  for (std::size_t t = 0; t < image.values.size(); t += 3) {
    const double r = image.values[t], g = image.values[t + 1], b = image.values[t + 2];
    image.values[t] = static_cast<float>(std::clamp(0.45 + 0.5 * r, 0.0, 1.0));
    image.values[t + 1] = static_cast<float>(std::clamp(0.38 + 0.35 * r + 0.2 * g, 0.0, 1.0));
    image.values[t + 2] = static_cast<float>(std::clamp(0.28 + 0.2 * r + 0.1 * g + 0.15 * b, 0.0, 1.0));
  }
  return image;
}

// Waves along u: a half turn leaves them as they are, a quarter turn does not.
inline formats::Image stripes(int side = 64, int waves = 8) {
  formats::Image image(side, side, {"Y"});
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      image.texel(x, y)[0] =
          static_cast<float>(0.5 + 0.5 * std::cos(2 * std::numbers::pi * waves * (x + 0.5) / side));
  return image;
}

// Waves along both: a quarter turn leaves them as they are.
inline formats::Image checks(int side = 64, int waves = 8) {
  formats::Image image(side, side, {"Y"});
  const auto wave = [&](int at) { return std::cos(2 * std::numbers::pi * waves * (at + 0.5) / side); };
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      image.texel(x, y)[0] = static_cast<float>(0.5 + 0.25 * (wave(x) + wave(y)));
  return image;
}

inline formats::Image constantImage(int side = 16, float value = 0.3f) {
  formats::Image image(side, side, {"Y"});
  std::fill(image.values.begin(), image.values.end(), value);
  return image;
}

}  // namespace bakelight::tests
