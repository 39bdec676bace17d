// The patch that is synthesized over a surface.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "formats/image.h"
#include "tools/mesomesh/synthesis/principal_components.h"

namespace bakelight::mesomesh {

// How well the exemplar maps onto itself under a quarter and a half turn, each with the shift that suits it
// best: 1 exactly, 0 no better than another place of it.
struct ExemplarSymmetry {
  struct Turn {
    double likeness = 0;
    // Texel (x, y) goes to rotated (x, y) + shift; columns and rows from the lower left.
    std::array<int, 2> shift = {0, 0};
  };
  Turn quarter, half;
  // 4, 2 or 1: the most folds whose turns are at least kSymmetricFrom alike.
  int folds() const;
  static constexpr double kSymmetricFrom = 0.7;
};

struct ExemplarSettings {
  // Whether its left continues its right and its top its bottom. Where it does not, windows and coordinates
  // stay inside of it.
  bool periodic = true;
  // Side length of a texel in the asset's unit; none: the mean distance of neighboring vertices.
  std::optional<double> texel_size = std::nullopt;
};

// Ready for synthesis. Texels are numbered from the lower left, row by row upwards, as texture coordinates
// are.
struct Exemplar {
  std::string name;  // for errors: the file or what the caller calls it
  int width = 0, height = 0;
  bool periodic = true;
  std::optional<double> texel_size;
  Samples channels;  // width · height × at most 30, principal components
  double retained_channel_variance = 1;
  ExemplarSymmetry symmetry;

  std::size_t texelCount() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

// Texels that windows reach beyond their middle.
constexpr int kWindowReach = 2;
// Without period, fewer texels a side leave no choice of windows.
constexpr int kLeastOpenSide = 4 * kWindowReach + 1;
constexpr int kMostExemplarSide = 2048;

// From an image of any number of channels, whose units are weighed as they are (scale a channel to have it
// count for more). Throws Error(kBadInput) naming `name`: no texel or channel, a value that is not finite, a
// side above 2048 texels, or below 9 without period, a texel size that is not positive. Cost: linear in
// values; symmetry takes 1024 · texels · channels.
Exemplar makeExemplar(const formats::Image& image, const ExemplarSettings& settings, std::string name);

}  // namespace bakelight::mesomesh
