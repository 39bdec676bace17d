// `.btf` files of every layout, of a BTF that is given as a function: byte by byte, by nothing of the code under test.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <Eigen/Core>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/btf.h"

namespace bakelight::formats {

inline constexpr double kDegree = std::numbers::pi / 180;

struct MadeBtf {
  std::vector<BtfDirection> views, lights;
  int width = 0, height = 0;
  // RGB of texel y · width + x.
  std::function<std::array<double, 3>(const BtfDirection& view, const BtfDirection& light, int texel)> value;

  int texelCount() const { return width * height; }
  std::vector<float> values() const {
    std::vector<float> all;
    for (const BtfDirection& view : views)
      for (const BtfDirection& light : lights)
        for (int t = 0; t < texelCount(); ++t)
          for (const double v : value(view, light, t)) all.push_back(static_cast<float>(v));
    return all;
  }
  BtfInfo info() const {
    BtfInfo info;
    info.views = views, info.lights = lights, info.width = width, info.height = height;
    return info;
  }
};

struct BtfVariant {
  std::string signature = "!DFMF08FCR";
  int scalar = 4;  // bytes
  bool transposed = false;
  int color_model = 0;
  std::uint32_t meta_version = 3;
  std::uint32_t cosine = 1;
  std::uint32_t rotations = 0;
  bool is_logarithmic = false;   // FCER
  std::uint8_t extension = 2;    // FCER
  std::uint32_t scan_lines = 2;  // BDI
  std::uint8_t compression = 0;  // BDI
  int missing_texel = -1;        // BDI, sparse
  bool old_body = false;         // PVF
};

class BtfMaker {
 public:
  BtfMaker(MadeBtf made, BtfVariant variant) : made_(std::move(made)), variant_(std::move(variant)) {}

  std::vector<std::byte> bytes() {
    bytes_.clear();
    addText(variant_.signature, variant_.signature.size());
    const std::string& s = variant_.signature;
    if (variant_.old_body) {
      for (const int number : {301074, 1, made_.width, made_.height, static_cast<int>(made_.views.size())})
        add(static_cast<std::uint32_t>(number));
      addSampling();
      addPerView(true);
      return bytes_;
    }
    addMeta();
    addSampling();
    add(static_cast<std::uint32_t>(made_.width));
    add(static_cast<std::uint32_t>(made_.height));
    if (s == "!BDIF06R2!") {
      addRaw();
      return bytes_;
    }
    if (s.ends_with("R")) addRotations();
    if (s.starts_with("!DFMF")) addDecorrelated();
    if (s.starts_with("!FMF")) addFullMatrix();
    if (s.starts_with("!PVF")) addPerView(false);
    return bytes_;
  }

 private:
  template <class T>
  void add(const T& value) {
    const auto added = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), added.begin(), added.end());
  }
  void addText(const std::string& text, std::size_t length) {
    for (std::size_t i = 0; i < length; ++i) add(i < text.size() ? text[i] : '\0');
  }
  void addNumber(double value) {
    if (variant_.scalar == 2) add(Eigen::half(static_cast<float>(value)));
    if (variant_.scalar == 4) add(static_cast<float>(value));
    if (variant_.scalar == 8) add(value);
  }
  void addMeta() {
    const std::string xml = "<measurement/>";
    const std::uint32_t v = variant_.meta_version;
    std::size_t size = 264;
    if (v > 1) size += 4;
    if (v > 2) size += 4 + xml.size();
    if (v > 3) size += 4 + 3 * 5;
    add(static_cast<std::uint32_t>(size));
    add(v);
    addText("dome", 80);
    addText("camera", 80);
    addText("lamp", 80);
    add(12.5F);
    for (int c = 0; c < 3; ++c) add(1.0F);
    if (v > 1) add(variant_.cosine);
    if (v > 2) add(static_cast<std::uint32_t>(xml.size()));
    if (v > 2) addText(xml, xml.size());
    if (v > 3) add(std::uint32_t{3});
    if (v > 3)
      for (const char* name : {"R", "G", "B"}) {
        add(std::uint32_t{1});
        addText(name, 1);
      }
  }
  void addDirection(const BtfDirection& direction) {
    add(static_cast<float>(direction.polar_rad));
    add(static_cast<float>(direction.azimuth_rad));
  }
  void addSampling() {
    add(static_cast<std::uint32_t>(made_.views.size()));
    for (const BtfDirection& view : made_.views) {
      addDirection(view);
      add(static_cast<std::uint32_t>(made_.lights.size()));
      for (const BtfDirection& light : made_.lights) addDirection(light);
    }
  }
  void addRotations() {
    add(variant_.rotations);
    for (std::uint32_t r = 0; r < variant_.rotations; ++r)
      for (int i = 0; i < 9; ++i) add(i % 4 == 0 ? 1.0F : 0.0F);
  }

  // What is stored of a value: the models' formulas the other way round.
  std::array<double, 3> stored(const std::array<double, 3>& rgb) const {
    const auto [r, g, b] = rgb;
    // Solves RGB = [[1, 0, 1.13983], [1, −0.39465, −0.5806], [1, 2.03211, 0]] · YUV.
    const double f = 0.39465 / 2.03211, w = 0.5806 / 1.13983;
    const double y = (g + f * b + w * r) / (1 + f + w), u = (b - y) / 2.03211, v = (r - y) / 1.13983;
    constexpr double kOffset = 1e-5;
    const auto amount = [](double x) { return std::copysign(std::log(std::abs(x) / kOffset), x); };
    switch (variant_.color_model) {
      case 1:
        return {y, u, v};
      case 3:  // the transform below is a permutation: stored · M + mean
        return {g - 0.5, b - 0.75, r - 0.25};
      case 4:
        return {(r + 2 * g + b) / 4, (r - b) / 2, (2 * g - r - b) / 4};
      case 5:
        return {r + g + b, g / (r + g + b), b / (r + g + b)};
      case 9:
        return {std::log(y + kOffset), u, v};
      case 10:
        return {std::log(y + kOffset), amount(u), amount(v)};
      case 11:
        return {std::log(y + kOffset), u / (y + kOffset), v / (y + kOffset)};
      case 12:
        return {std::log(r + kOffset), std::log(g + kOffset), std::log(b + kOffset)};
      default:
        return rgb;
    }
  }
  std::size_t pairCount() const { return made_.views.size() * made_.lights.size(); }
  double at(std::size_t pair, int texel, std::size_t c) const {
    std::array<double, 3> rgb =
        made_.value(made_.views[pair / made_.lights.size()], made_.lights[pair % made_.lights.size()], texel);
    if (variant_.is_logarithmic)
      for (double& value : rgb) value = std::log(value + 1e-5);
    return stored(rgb)[c];
  }

  // rows × columns, as that · identity or identity · that: exact, of full rank.
  void addMatrix(std::size_t rows, std::size_t columns,
                 const std::function<double(std::size_t, std::size_t)>& value) {
    const std::size_t rank = std::min(rows, columns);
    add(static_cast<std::uint32_t>(rank));
    add(static_cast<std::uint32_t>(rows));
    add(static_cast<std::uint32_t>(columns));
    for (std::size_t k = 0; k < rank; ++k) addNumber(1);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t k = 0; k < rank; ++k) addNumber(rank == columns ? value(i, k) : i == k ? 1 : 0);
    for (std::size_t i = 0; i < columns; ++i)
      for (std::size_t k = 0; k < rank; ++k) addNumber(rank < columns ? value(k, i) : i == k ? 1 : 0);
  }
  void addDecorrelated() {
    const auto texels = static_cast<std::size_t>(made_.texelCount());
    add(static_cast<std::uint32_t>(texels));
    add(static_cast<std::int32_t>(variant_.color_model));
    for (const float mean : {0.25F, 0.5F, 0.75F}) add(mean);
    for (const float entry : {0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 1.0F, 0.0F, 0.0F}) add(entry);
    for (std::size_t c = 0; c < 3; ++c) {
      add(static_cast<std::uint8_t>(variant_.scalar));
      if (variant_.transposed)
        addMatrix(texels, pairCount(),
                  [&](std::size_t t, std::size_t p) { return at(p, static_cast<int>(t), c); });
      else
        addMatrix(pairCount(), texels,
                  [&](std::size_t p, std::size_t t) { return at(p, static_cast<int>(t), c); });
    }
  }
  void addFullMatrix() {
    const auto texels = static_cast<std::size_t>(made_.texelCount());
    if (variant_.signature == "!FMF12FCER") {
      add(variant_.extension);
      if (variant_.extension >= 1) add(static_cast<std::uint32_t>(variant_.is_logarithmic ? 1 : 0));
      if (variant_.extension >= 2)
        for (const std::uint32_t size : {2U, 1U}) add(size);
      if (variant_.extension >= 2)
        for (int i = 0; i < 2; ++i) add(Eigen::half(0.5F));
    }
    add(static_cast<std::uint32_t>(texels));
    add(static_cast<std::uint8_t>(variant_.scalar));
    if (variant_.transposed)
      addMatrix(3 * texels, pairCount(),
                [&](std::size_t row, std::size_t p) { return at(p, static_cast<int>(row / 3), row % 3); });
    else
      addMatrix(3 * pairCount(), texels,
                [&](std::size_t row, std::size_t t) { return at(row / 3, static_cast<int>(t), row % 3); });
  }
  void addPerView(bool is_old) {
    const std::size_t texels = static_cast<std::size_t>(made_.texelCount()), lights = made_.lights.size();
    if (!is_old) {
      add(static_cast<std::uint32_t>(texels));
      add(static_cast<std::uint32_t>(made_.views.size()));
    }
    constexpr double kMean = 0.125;
    const std::size_t rows = 3 * (variant_.transposed ? texels : lights);
    const std::size_t rank = variant_.transposed ? lights : texels;
    for (std::size_t v = 0; v < made_.views.size(); ++v) {
      add(static_cast<std::uint8_t>(variant_.scalar));
      for (const std::size_t size : {rank, rank, rows}) add(static_cast<std::uint32_t>(size));
      for (std::size_t k = 0; k < rank; ++k) addNumber(1);
      for (std::size_t i = 0; i < rows; ++i) addNumber(kMean);
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t k = 0; k < rank; ++k) {
          const std::size_t light = variant_.transposed ? k : i / 3, texel = variant_.transposed ? i / 3 : k;
          addNumber(at(v * lights + light, static_cast<int>(texel), i % 3) - kMean);
        }
      for (std::size_t i = 0; i < rank; ++i)
        for (std::size_t k = 0; k < rank; ++k) addNumber(i == k ? 1 : 0);
    }
  }
  void addRaw() {
    add(variant_.scan_lines);
    add(variant_.compression);
    std::vector<int> texels;
    for (int t = 0; t < made_.texelCount(); ++t) {
      add(static_cast<std::uint8_t>(t != variant_.missing_texel));
      if (t != variant_.missing_texel) texels.push_back(t);
    }
    addRotations();
    const std::size_t a_chunk = static_cast<std::size_t>(made_.width) * variant_.scan_lines;
    for (std::size_t begin = 0; begin < texels.size(); begin += a_chunk) {
      const std::size_t end = std::min(begin + a_chunk, texels.size());
      add(static_cast<std::uint32_t>((end - begin) * pairCount() * 6));
      for (std::size_t t = begin; t < end; ++t)
        for (std::size_t p = 0; p < pairCount(); ++p)
          for (std::size_t c = 0; c < 3; ++c) add(Eigen::half(static_cast<float>(at(p, texels[t], c))));
    }
  }

  MadeBtf made_;
  BtfVariant variant_;
  std::vector<std::byte> bytes_;
};

// Rings of azimuths around the zenith.
struct Ring {
  double polar_deg;
  int count;
  double first_deg;
};
inline std::vector<BtfDirection> ringsOf(std::span<const Ring> rings) {
  std::vector<BtfDirection> directions;
  for (const Ring& ring : rings)
    for (int i = 0; i < ring.count; ++i) {
      double azimuth = ring.first_deg + 360.0 * i / ring.count;
      if (azimuth >= 180) azimuth -= 360;
      directions.push_back({ring.polar_deg * kDegree, azimuth * kDegree});
    }
  return directions;
}
// The 151 of UBO2014 and the 81 of UBO2003.
inline std::vector<BtfDirection> directions151() {
  static constexpr Ring kRings[] = {{0, 1, 0},       {11, 6, 15}, {23.5, 12, 0},   {30, 12, 15},
                                    {37.5, 12, 0},   {45, 18, 0}, {52.5, 18, 7.5}, {60, 24, 0},
                                    {67.5, 24, 7.5}, {75, 24, 0}};
  return ringsOf(kRings);
}
inline std::vector<BtfDirection> directions81() {
  static constexpr Ring kRings[] = {{0, 1, 0},   {15, 6, 0},  {30, 12, 0},
                                    {45, 18, 0}, {60, 20, 0}, {75, 24, 0}};
  return ringsOf(kRings);
}

// Few directions, six texels, all values different and above 0.
inline MadeBtf smallBtf() {
  MadeBtf made;
  made.views = {{0, 0}, {0.5, 1}, {1.2, -2}};
  made.lights = {{0, 0}, {0.3, 0.5}, {0.9, 2}, {1.3, -1}};
  made.width = 3, made.height = 2;
  made.value = [](const BtfDirection& view, const BtfDirection& light, int texel) {
    const double common = 0.2 + 0.1 * std::sin(view.polar_rad + 2 * light.polar_rad + light.azimuth_rad) +
                          0.05 * std::cos(view.azimuth_rad - light.azimuth_rad);
    return std::array<double, 3>{common * (1 + 0.1 * texel), common * 0.5 + 0.02 * texel * view.polar_rad,
                                 0.05 + 0.03 * texel * light.polar_rad};
  };
  return made;
}

// Everything of a BTF, in the order of MadeBtf::values.
inline std::vector<float> decoded(const Btf& btf) {
  std::vector<float> all;
  const std::size_t texels = btf.texelCount();
  for (std::size_t v = 0; v < btf.info().views.size(); ++v) {
    const std::vector<int> lights = btf.lightsOf(static_cast<int>(v));
    std::vector<float> rgb(3 * lights.size() * texels);
    btf.view(static_cast<int>(v))->decode(lights, {0, texels}, rgb);
    for (std::size_t l = 0; l < lights.size(); ++l)
      for (std::size_t t = 0; t < texels; ++t)
        for (std::size_t c = 0; c < 3; ++c) all.push_back(rgb[(c * lights.size() + l) * texels + t]);
  }
  return all;
}

}  // namespace bakelight::formats
