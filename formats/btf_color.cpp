#include "formats/btf_color.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <Eigen/Core>
#include <Eigen/LU>
#include <numeric>
#include <stdexcept>

namespace bakelight::formats {
namespace {

using Plane = Eigen::Map<Eigen::ArrayXf>;
constexpr BtfMatrix kRgbFromYCoCg = {{{1, 1, -1}, {1, 0, 1}, {1, -1, -1}}};

Plane plane(std::span<float> planes, std::size_t count, std::size_t c) {
  return Plane(planes.data() + c * count, static_cast<Eigen::Index>(count));
}

// planes = matrix · planes
void multiply(std::span<float> planes, std::size_t count, const BtfMatrix& matrix) {
  for (std::size_t i = 0; i < count; ++i) {
    const float a = planes[i], b = planes[count + i], c = planes[2 * count + i];
    for (std::size_t row = 0; row < 3; ++row)
      planes[row * count + i] = matrix[row][0] * a + matrix[row][1] * b + matrix[row][2] * c;
  }
}

BtfMatrix transposed(const BtfMatrix& matrix) {
  BtfMatrix result;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) result[i][j] = matrix[j][i];
  return result;
}

void undoLogarithm(Plane values) {
  values = values.exp() - kBtfLogOffset;
}

BtfMatrix inverted(const BtfMatrix& matrix) {
  Eigen::Matrix3d values;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      values(i, j) = matrix[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  const Eigen::Matrix3d inverse = values.inverse();
  BtfMatrix result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      result[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = static_cast<float>(inverse(i, j));
  return result;
}

// How many were below 0.
std::size_t takeLogarithm(Plane values) {
  const auto negative = static_cast<std::size_t>((values < 0).count());
  values = (values.max(0.0F) + kBtfLogOffset).log();
  return negative;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return text;
}

// A Gaussian with another width on either side.
double lobe(double x, double middle, double below, double above) {
  const double t = (x - middle) * (x < middle ? below : above);
  return std::exp(-t * t / 2);
}

// CIE 1931, from wavelengths in nm.
std::array<double, 3> observer(double nm) {
  return {1.056 * lobe(nm, 599.8, 0.0264, 0.0323) + 0.362 * lobe(nm, 442.0, 0.0624, 0.0374) -
              0.065 * lobe(nm, 501.1, 0.0490, 0.0382),
          0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322),
          1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725)};
}

}  // namespace

double wavelengthOf(const std::string& channel) {
  const std::size_t begin = channel.find_first_of("0123456789");
  if (begin == std::string::npos) return 0;
  double value = 0;
  const auto [end, failed] = std::from_chars(channel.data() + begin, channel.data() + channel.size(), value);
  return failed == std::errc() && value >= 300 && value <= 1100 ? value : 0;
}

std::vector<std::array<float, 3>> rgbOfWavelengths(std::span<const double> wavelengths_nm) {
  constexpr double kRgbFromXyz[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                        {-0.9692660, 1.8760108, 0.0415560},
                                        {0.0556434, -0.2040259, 1.0572252}};
  constexpr int kFirst_nm = 360, kLast_nm = 830;
  std::vector<std::size_t> order(wavelengths_nm.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return wavelengths_nm[i]; });
  // The spectrum between samples is linear, beyond them constant.
  std::vector<std::array<double, 3>> xyz(order.size(), {0, 0, 0});
  for (int nm = kFirst_nm; nm <= kLast_nm; ++nm) {
    const auto above = std::ranges::upper_bound(order, static_cast<double>(nm), {},
                                                [&](std::size_t i) { return wavelengths_nm[i]; });
    const std::size_t high = above == order.end() ? order.back() : *above;
    const std::size_t low = above == order.begin() ? order.front() : *(above - 1);
    const double span = wavelengths_nm[high] - wavelengths_nm[low];
    const double share = span > 0 ? (nm - wavelengths_nm[low]) / span : 0;
    const std::array<double, 3> seen = observer(nm);
    for (std::size_t c = 0; c < 3; ++c) {
      xyz[low][c] += (1 - share) * seen[c];
      xyz[high][c] += share * seen[c];
    }
  }
  std::vector<std::array<double, 3>> rgb(xyz.size());
  std::array<double, 3> white = {};
  for (std::size_t i = 0; i < xyz.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 3; ++k) rgb[i][c] += kRgbFromXyz[c][k] * xyz[i][k];
      white[c] += rgb[i][c];
    }
  std::vector<std::array<float, 3>> weights(rgb.size());
  for (std::size_t i = 0; i < rgb.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) weights[i][c] = static_cast<float>(rgb[i][c] / white[c]);
  return weights;
}

BtfColors::BtfColors(const BtfCursor& cursor, int model, const std::vector<std::string>& channels,
                     const BtfMatrix& transform, const std::array<float, 3>& mean, bool is_logarithmic)
    : model_(static_cast<BtfColorModel>(model)),
      channel_count_(channels.size()),
      transform_(transform),
      mean_(mean),
      is_logarithmic_(is_logarithmic) {
  constexpr int kKnown[] = {0, 1, 3, 4, 5, 9, 10, 11, 12};
  if (std::ranges::find(kKnown, model) == std::end(kKnown))
    throw cursor.error("the colours are of model " + std::to_string(model) +
                           (model == 2   ? " (Lab)"
                            : model == 6 ? " (linear spectral)"
                                         : ""),
                       "0, 1, 3, 4, 5, 9, 10, 11 or 12", cursor.offset(),
                       model == 2 || model == 6 ? "it is not known how to undo it: write the file as RGB"
                                                : "the file is damaged, or of a kind not known here");
  const bool any_count = model == 0 || model == 5 || model == 12;
  if (channel_count_ != 3 && !any_count)
    throw cursor.error("a colour model of three channels is used for " + std::to_string(channel_count_), "3");

  std::vector<double> wavelengths;
  for (const std::string& name : channels) wavelengths.push_back(wavelengthOf(name));
  const auto named = [&](const std::string& a, const std::string& b, const std::string& c) {
    return channel_count_ == 3 && lower(channels[0]) == a && lower(channels[1]) == b &&
           lower(channels[2]) == c;
  };
  if (named("r", "g", "b") || named("red", "green", "blue")) return;
  if (std::ranges::find(wavelengths, 0.0) == wavelengths.end()) {
    rgb_of_channel_ = rgbOfWavelengths(wavelengths);
    notes_.push_back("a spectrum of " + std::to_string(channel_count_) +
                     " channels is seen as red, green and blue under equal energy");
  } else if (channel_count_ == 1) {
    rgb_of_channel_ = {{1, 1, 1}};
    notes_.push_back("its single channel is grey");
  } else if (channel_count_ == 3) {
    notes_.push_back("its channels are called " + channels[0] + ", " + channels[1] + ", " + channels[2] +
                     ": they are taken for red, green and blue");
  } else {
    throw cursor.error("its " + std::to_string(channel_count_) +
                           " channels are no colour: the first is called \"" + channels[0] + "\"",
                       "R, G and B, wavelengths in nm, or a single grey one");
  }
}

void BtfColors::undoModel(std::span<float> planes, std::size_t count) const {
  const auto at = [&](std::size_t c) { return plane(planes, count, c); };
  switch (model_) {
    case BtfColorModel::kRgb:
      return;
    case BtfColorModel::kYuv:
      return multiply(planes, count, kBtfRgbFromYuv);
    case BtfColorModel::kPca:
      multiply(planes, count, transposed(transform_));  // rows of values times the matrix
      for (std::size_t c = 0; c < 3; ++c) at(c) += mean_[c];
      return;
    case BtfColorModel::kYCoCg:
      return multiply(planes, count, kRgbFromYCoCg);
    case BtfColorModel::kSpectral: {  // the sum, and the shares of all but the first
      const Eigen::ArrayXf sum = at(0);
      for (std::size_t c = 1; c < channel_count_; ++c) {
        at(c) *= sum;
        at(0) -= at(c);
      }
      return;
    }
    case BtfColorModel::kLogYuv:
      undoLogarithm(at(0));
      return multiply(planes, count, kBtfRgbFromYuv);
    case BtfColorModel::kLogYLogUv:
      undoLogarithm(at(0));
      for (std::size_t c = 1; c < 3; ++c) at(c) = at(c).sign() * at(c).abs().exp() * kBtfLogOffset;
      return multiply(planes, count, kBtfRgbFromYuv);
    case BtfColorModel::kLogYRelativeUv:
      undoLogarithm(at(0));
      for (std::size_t c = 1; c < 3; ++c) at(c) *= at(0) + kBtfLogOffset;
      return multiply(planes, count, kBtfRgbFromYuv);
    case BtfColorModel::kLogRgb:
      return undoLogarithm(Plane(planes.data(), static_cast<Eigen::Index>(planes.size())));
  }
}

void BtfColors::toRgb(std::span<float> planes, std::size_t count, std::span<float> rgb) const {
  undoModel(planes, count);
  if (is_logarithmic_) undoLogarithm(Plane(planes.data(), static_cast<Eigen::Index>(planes.size())));
  if (rgb_of_channel_.empty()) {
    if (planes.data() != rgb.data()) std::ranges::copy(planes, rgb.begin());
    return;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    Plane color = plane(rgb, count, c);
    color = plane(planes, count, 0) * rgb_of_channel_[0][c];
    for (std::size_t k = 1; k < channel_count_; ++k) color += plane(planes, count, k) * rgb_of_channel_[k][c];
  }
}

std::size_t decorrelate(BtfColorModel model, std::span<float> planes, std::size_t count) {
  static const BtfMatrix kYuvFromRgb = inverted(kBtfRgbFromYuv), kYCoCgFromRgb = inverted(kRgbFromYCoCg);
  switch (model) {
    case BtfColorModel::kRgb:
      return 0;
    case BtfColorModel::kYuv:
      multiply(planes, count, kYuvFromRgb);
      return 0;
    case BtfColorModel::kYCoCg:
      multiply(planes, count, kYCoCgFromRgb);
      return 0;
    case BtfColorModel::kLogYRelativeUv:
      multiply(planes, count, kYuvFromRgb);
      for (std::size_t c = 1; c < 3; ++c)
        plane(planes, count, c) /= plane(planes, count, 0).max(0.0F) + kBtfLogOffset;
      return takeLogarithm(plane(planes, count, 0));
    case BtfColorModel::kLogRgb:
      return takeLogarithm(Plane(planes.data(), static_cast<Eigen::Index>(planes.size())));
    default:
      throw std::invalid_argument("decorrelate: files of this colour model are not written");
  }
}

}  // namespace bakelight::formats
