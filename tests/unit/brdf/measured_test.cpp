#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <numbers>

#include "formats/error.h"
#include "tools/brdf/tensor_bsdf.h"
#include "tools/brdf/utia.h"
#include "transport/directions.h"

namespace bakelight::brdf {
namespace {

using testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

Vec3 at(double polar, double azimuth) {
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

using Bytes = std::vector<std::byte>;

Bytes utiaFile(const Brdf& brdf) {
  Bytes bytes;
  for (int c = 0; c < 3; ++c)
    for (int l = 0; l < 288; ++l)
      for (int v = 0; v < 288; ++v) {
        const auto direction = [](int i) { return at(i / 48 * kPi / 12, i % 48 * kPi / 24); };
        const double value = brdf(direction(l), direction(v))[c];
        const auto added = std::as_bytes(std::span(&value, 1));
        bytes.insert(bytes.end(), added.begin(), added.end());
      }
  return bytes;
}

class TensorFileMaker {
 public:
  template <class T>
  void add(const std::string& name, int type, std::vector<std::uint64_t> shape,
           const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    fields_.push_back({name, type, std::move(shape), {bytes.begin(), bytes.end()}});
  }
  Bytes bytes() const {
    std::uint64_t offset = 18;
    for (const Field& field : fields_) offset += 2 + field.name.size() + 2 + 1 + 8 + 8 * field.shape.size();
    Bytes bytes;
    const auto put = [&](const auto& value) {
      const auto added = std::as_bytes(std::span(&value, 1));
      bytes.insert(bytes.end(), added.begin(), added.end());
    };
    for (const char c : {'t', 'e', 'n', 's', 'o', 'r', '_', 'f', 'i', 'l', 'e', '\0', '\1', '\0'}) put(c);
    put(static_cast<std::uint32_t>(fields_.size()));
    for (const Field& field : fields_) {
      put(static_cast<std::uint16_t>(field.name.size()));
      for (const char c : field.name) put(c);
      put(static_cast<std::uint16_t>(field.shape.size()));
      put(static_cast<std::uint8_t>(field.type));
      put(offset);
      for (const std::uint64_t extent : field.shape) put(extent);
      offset += field.bytes.size();
    }
    for (const Field& field : fields_) bytes.insert(bytes.end(), field.bytes.begin(), field.bytes.end());
    return bytes;
  }

 private:
  struct Field {
    std::string name;
    int type;
    std::vector<std::uint64_t> shape;
    Bytes bytes;
  };
  std::vector<Field> fields_;
};

// Of a BRDF, with uneven tables on the way that cancel: a density of visible normals (½ + x)(½ + y), normals 1 + x, areas
// 1 + x/2. Values are what those leave: f cos θ_light · 4 area ÷ normals, over the evened square.
Bytes tensorFile(const Brdf& brdf, const std::vector<double>& azimuths = {0}, int wavelengths = 0,
                 const std::string& leave_out = "") {
  constexpr int kPolars = 24, kSide = 64, kCoarse = 8;
  std::vector<float> polar, azimuth(azimuths.begin(), azimuths.end()), normals, areas, density, values;
  for (int p = 0; p < kPolars; ++p) polar.push_back(static_cast<float>(p * 1.57 / (kPolars - 1)));
  for (int y = 0; y < kCoarse; ++y)
    for (int x = 0; x < kCoarse; ++x) {
      normals.push_back(static_cast<float>(1 + x / (kCoarse - 1.0)));
      areas.push_back(static_cast<float>(1 + 0.5 * x / (kCoarse - 1.0)));
    }
  for (std::size_t a = 0; a < azimuths.size(); ++a)
    for (int p = 0; p < kPolars; ++p) {
      for (int y = 0; y < kCoarse; ++y)
        for (int x = 0; x < kCoarse; ++x)  // to any scale
          density.push_back(static_cast<float>((1 + static_cast<double>(a)) * (0.5 + x / (kCoarse - 1.0)) *
                                               (0.5 + y / (kCoarse - 1.0))));
      const Vec3 eye = at(polar[static_cast<std::size_t>(p)], azimuths[a]);
      const int channels = wavelengths > 0 ? wavelengths : 3;
      for (int c = 0; c < channels; ++c)
        for (int j = 0; j < kSide; ++j)
          for (int i = 0; i < kSide; ++i) {
            // s = x/2 + x²/2
            const auto uneven = [](double s) { return (std::sqrt(1 + 8 * s) - 1) / 2; };
            const double x = uneven(i / (kSide - 1.0)), y = uneven(j / (kSide - 1.0));
            const Vec3 half =
                at(x * x * kPi / 2, (2 * y - 1) * kPi + (azimuths.size() <= 2 ? azimuths[a] : 0));
            const Vec3 light = 2 * half.dot(eye) * half - eye;
            const double area = 1 + 0.5 * std::sqrt(polar[static_cast<std::size_t>(p)] * 2 / kPi);
            const double value =
                light.z() > 0 ? brdf(light, eye)[wavelengths > 0 ? 0 : c] * light.z() * 4 * area / (1 + x)
                              : 0;
            values.push_back(static_cast<float>(value));
          }
    }
  TensorFileMaker maker;
  const std::uint64_t a = azimuths.size();
  const auto add = [&](const std::string& name, int type, const std::vector<std::uint64_t>& shape,
                       const auto& list) {
    if (name != leave_out) maker.add(name, type, shape, list);
  };
  add("description", 1, {4}, std::vector<char>{'m', 'a', 'd', 'e'});
  add("jacobian", 1, {1}, std::vector<std::uint8_t>{1});
  add("theta_i", 10, {kPolars}, polar);
  add("phi_i", 10, {a}, azimuth);
  add("ndf", 10, {kCoarse, kCoarse}, normals);
  add("sigma", 10, {kCoarse, kCoarse}, areas);
  add("vndf", 10, {a, kPolars, kCoarse, kCoarse}, density);
  add("luminance", 10, {a, kPolars, kCoarse, kCoarse}, density);
  if (wavelengths == 0) {
    add("rgb", 10, {a, kPolars, 3, kSide, kSide}, values);
  } else {
    std::vector<float> nm;
    for (int k = 0; k < wavelengths; ++k)
      nm.push_back(static_cast<float>(400 + k * 300.0 / (wavelengths - 1)));
    add("wavelengths", 10, {static_cast<std::uint64_t>(wavelengths)}, nm);
    add("spectra", 10, {a, kPolars, static_cast<std::uint64_t>(wavelengths), kSide, kSide}, values);
  }
  return maker.bytes();
}

// Of all coefficients, in units of the largest.
double differenceOf(const Brdf& measured, const Brdf& expected) {
  const auto a = project(measured, 5, 5, 1e-3).table.values, b = project(expected, 5, 5, 1e-3).table.values;
  float largest = 0, difference = 0;
  for (std::size_t i = 75; i < a.size(); ++i) {  // not at the horizon, where no file has data
    largest = std::max(largest, std::abs(b[i]));
    difference = std::max(difference, std::abs(a[i] - b[i]));
  }
  return static_cast<double>(difference) / static_cast<double>(largest);
}

const Vec3 kColor(0.6, 0.3, 0.1);

TEST(MeasuredBrdf, OfALambertianIsTheClampedCosine) {
  EXPECT_LT(differenceOf(readUtia(utiaFile(lambert(kColor)), "u.bin").brdf, lambert(kColor)), 1e-6);
  const MeasuredBrdf tensor = readTensorBsdf(tensorFile(lambert(kColor)), "t.bsdf");
  EXPECT_LT(differenceOf(tensor.brdf, lambert(kColor)), 0.01);
  EXPECT_EQ(tensor.anisotropy, 0);
  EXPECT_TRUE(tensor.notes.empty());
}

// Linear between 15° and 7.5°: a lobe that broad errs by 6%.
TEST(MeasuredBrdf, OfALobeIsProjectedAsTheLobe) {
  const Brdf lobe = phong(0.5 * kColor, kColor, 4);
  EXPECT_LT(differenceOf(readUtia(utiaFile(lobe), "u.bin").brdf, lobe), 0.07);
  const Brdf facets = ggx(transport::Microfacets(kColor, 0.6, false, false));
  EXPECT_LT(differenceOf(readTensorBsdf(tensorFile(facets), "t.bsdf").brdf, facets), 0.02);
  EXPECT_LT(differenceOf(readTensorBsdf(tensorFile(facets, {-3, 3}), "t.bsdf").brdf, facets), 0.02);
}

TEST(MeasuredBrdf, OfASpectrumIsSeenByTheObserver) {
  const MeasuredBrdf grey = readTensorBsdf(tensorFile(lambert(kColor), {0}, 7), "t.bsdf");
  EXPECT_THAT(grey.notes, testing::ElementsAre(HasSubstr("7 wavelengths")));
  EXPECT_LT((grey.brdf(at(0.3, 1), at(0.5, 0)) - Vec3::Constant(0.6 / kPi)).norm(), 5e-3);
}

// 1 + ½ cos 2φ of the eye: the mean is 1, the difference ½/√2 of √(1 + ⅛).
TEST(MeasuredBrdf, ThatIsAnisotropicIsAveraged) {
  const Brdf brushed = [](const Vec3&, const Vec3& eye) -> Vec3 {
    const double turn = std::atan2(eye.y(), eye.x());
    return kColor / kPi * (1 + 0.5 * std::cos(2 * turn));
  };
  const double expected = std::sqrt(0.125 / 1.125);
  // Polar angle 0 has azimuths in the file, too, but not in this function.
  const MeasuredBrdf utia = readUtia(utiaFile(brushed), "u.bin");
  EXPECT_NEAR(utia.anisotropy, expected, 0.02);
  EXPECT_LT((utia.brdf(at(0.7, 1), at(0.6, 2)) - kColor / kPi).norm(), 1e-6);
  std::vector<double> azimuths;
  for (int a = 0; a <= 16; ++a) azimuths.push_back(-3.1415926 + a * 3.1415926 / 8);
  const MeasuredBrdf tensor = readTensorBsdf(tensorFile(brushed, azimuths), "t.bsdf");
  EXPECT_NEAR(tensor.anisotropy, expected, 0.03);
  EXPECT_LT((tensor.brdf(at(0.7, 1), at(0.6, 2)) - kColor / kPi).norm(), 5e-3);
  EXPECT_LT((tensor.brdf(at(0.7, 1), at(0.6, 2)) - tensor.brdf(at(0.7, -2), at(0.6, -3))).norm(), 1e-4)
      << "mirrored";
}

TEST(MeasuredBrdf, RefusesOtherFiles) {
  const auto problem = [](const auto& read, std::span<const std::byte> bytes) -> std::string {
    try {
      read(bytes, "some.file");
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      EXPECT_THAT(error.paragraph(), HasSubstr("some.file"));
      return error.paragraph();
    }
    return "";
  };
  Bytes utia = utiaFile(lambert(kColor));
  EXPECT_THAT(problem(readUtia, std::span(utia).first(100)), HasSubstr("1990656"));
  const double nan = std::nan("");
  std::memcpy(&utia[80], &nan, 8);
  EXPECT_THAT(problem(readUtia, utia), HasSubstr("value 10"));
  const double negative = -1;
  std::memcpy(&utia[80], &negative, 8);
  EXPECT_THAT(readUtia(utia, "u").notes, testing::ElementsAre(HasSubstr("1 negative")));

  for (const char* name : {"theta_i", "phi_i", "ndf", "sigma", "vndf", "rgb", "jacobian"})
    EXPECT_THAT(problem(readTensorBsdf, tensorFile(lambert(kColor), {0}, 0, name)), HasSubstr(name));
  EXPECT_THAT(problem(readTensorBsdf, tensorFile(lambert(kColor), {0, 0.5, 1.5})), HasSubstr("phi_i"));
  EXPECT_THAT(problem(readTensorBsdf, tensorFile(lambert(kColor), {1, 1})), HasSubstr("ascend"));
  EXPECT_THAT(problem(readTensorBsdf, utia), HasSubstr("tensor file"));
  const Bytes tensor = tensorFile(lambert(kColor));
  for (std::size_t size = 0; size < tensor.size(); size += size < 600 ? 1 : tensor.size() / 10)
    EXPECT_NE(problem(readTensorBsdf, std::span(tensor).first(size)), "") << size;
  for (std::size_t i = 0; i < 600; i += 3) {  // headers and the first tables
    Bytes turned = tensor;
    turned[i] ^= std::byte{0xFF};
    problem(readTensorBsdf, turned);
  }
}

}  // namespace
}  // namespace bakelight::brdf
