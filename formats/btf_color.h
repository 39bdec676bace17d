// From the channels of a BTF's file to linear red, green and blue, and back.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/btf_cursor.h"

namespace bakelight::formats {

// The numbers that files have for them.
enum class BtfColorModel : int {
  kRgb = 0,
  kYuv = 1,
  kPca = 3,
  kYCoCg = 4,
  kSpectral = 5,
  kLogYuv = 9,           // log Y, U, V
  kLogYLogUv = 10,       // log Y, and U and V by the logarithm of their amount
  kLogYRelativeUv = 11,  // log Y, U/Y, V/Y
  kLogRgb = 12
};
inline constexpr float kBtfLogOffset = 1e-5F;  // exp(log value) − this

using BtfMatrix = std::array<std::array<float, 3>, 3>;  // rows

class BtfColors {
 public:
  BtfColors() = default;
  // `model` at the cursor's offset is refused if it is not known. Channels are R, G and B, numbers (wavelengths in nm,
  // then seen under equal energy by the CIE 1931 observer), or a single grey one. `transform` and `mean` are of
  // model PCA.
  BtfColors(const BtfCursor& cursor, int model, const std::vector<std::string>& channels,
            const BtfMatrix& transform, const std::array<float, 3>& mean, bool is_logarithmic);
  std::size_t channelCount() const { return channel_count_; }
  // channelCount() planes of `count` values each become three; `planes` are overwritten.
  void toRgb(std::span<float> planes, std::size_t count, std::span<float> rgb) const;
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void undoModel(std::span<float> planes, std::size_t count) const;

  BtfColorModel model_ = BtfColorModel::kRgb;
  std::size_t channel_count_ = 3;
  BtfMatrix transform_ = {};
  std::array<float, 3> mean_ = {};
  bool is_logarithmic_ = false;
  std::vector<std::array<float, 3>> rgb_of_channel_;
  std::vector<std::string> notes_;
};

// Y, U, V → R, G, B as in these files.
inline constexpr BtfMatrix kBtfRgbFromYuv = {{{1, 0, 1.13983F}, {1, -0.39465F, -0.5806F}, {1, 2.03211F, 0}}};

// Three planes of `count` values, red, green and blue, become the channels of a model that can be written: kRgb, kYuv,
// kYCoCg, kLogYRelativeUv or kLogRgb (std::invalid_argument for others). Logarithms take negative values for 0;
// returns how many there were.
std::size_t decorrelate(BtfColorModel model, std::span<float> planes, std::size_t count);

// Weights of samples of a spectrum at `wavelengths_nm` (any order, any spacing) for linear sRGB: a constant spectrum
// gives r = g = b = the constant. Observer by the fit of Wyman, Sloan & Shirley 2013.
std::vector<std::array<float, 3>> rgbOfWavelengths(std::span<const double> wavelengths_nm);
// The wavelength that a channel's name states ("550", "550nm", "w550.5"), or 0.
double wavelengthOf(const std::string& channel);

}  // namespace bakelight::formats
