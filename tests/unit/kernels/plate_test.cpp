// A flat plate, of which all is known: total, sinusoids, the edge of a shadow, a disk of light.
#include <gtest/gtest.h>

#include "tests/support/plate.h"
#include "transport/translucent_response.h"

namespace bakelight::kernels {
namespace {

using std::numbers::pi;
using transport::DiffuseReflectance;
using transport::TranslucentResponse;

constexpr int kTexels = 120;
constexpr double kSpacing = 4.4;

Options exactKernels() {
  Options options;
  options.kernel_error = 0;
  return options;
}

struct Plate {
  formats::Translucency translucency;
  std::array<DiffuseReflectance, 3> colors;
  TranslucentResponse response;

  Plate(double mean_free_path, double spacing)
      : translucency(tests::kernelsOf(tests::plateMesh(kTexels, spacing), kTexels,
                                      tests::mediumOf(mean_free_path), exactKernels())
                         .translucency),
        colors(reflectanceOf(tests::mediumOf(mean_free_path))),
        response(translucency) {}

  // Of texels, by the middle of each.
  template <class Light>
  std::vector<formats::Float3> respond(const Light& light) const {
    std::vector<formats::Float3> entering;
    for (const std::uint32_t place : formats::wordsOf(translucency.texels)) {
      const auto value = static_cast<float>(
          light(place % kTexels + 0.5 - kTexels / 2.0, place / kTexels + 0.5 - kTexels / 2.0));
      entering.push_back({value, value, value});
    }
    return response.respond(entering);
  }
  // Of receivers within `half` of the middle: f(x, y, radiosity).
  template <class Visit>
  void inTheMiddle(double half, const std::vector<formats::Float3>& radiosity, const Visit& visit) const {
    const auto receivers = formats::wordsOf(translucency.receivers),
               texels = formats::wordsOf(translucency.texels);
    std::size_t count = 0;
    for (std::size_t r = 0; r < receivers.size(); ++r) {
      const std::uint32_t place = texels[receivers[r]];
      const double x = place % kTexels + 0.5 - kTexels / 2.0, y = place / kTexels + 0.5 - kTexels / 2.0;
      if (std::abs(x) > half || std::abs(y) > half) continue;
      visit(x, y, radiosity[r]);
      ++count;
    }
    ASSERT_GE(count, 3 * half * half);
  }
};

class PlateOfMeanFreePath : public testing::TestWithParam<double> {
 protected:
  Plate plate{GetParam(), kSpacing};
};
INSTANTIATE_TEST_SUITE_P(Texels, PlateOfMeanFreePath, testing::Values(0.3, 1.0, 2.5));

TEST_P(PlateOfMeanFreePath, GivesTheTotalOfEvenLightEverywhere) {
  plate.inTheMiddle(25, plate.respond([](double, double) { return 1.0; }),
                    [&](double x, double y, const formats::Float3& b) {
                      for (std::size_t c = 0; c < 3; ++c)
                        EXPECT_NEAR(b[c] / plate.colors[c].total(), 1, 0.003)
                            << x << " " << y << " color " << c;
                    });
}

// Up to half of what texels can carry, the contrast is that of the integral.
void expectContrasts(const Plate& plate, double allowed) {
  for (const double wavelength : {4.0, 6.0, 10.0, 20.0, 50.0}) {
    const double k = 2 * pi / wavelength, turn = 0.4, cosine = std::cos(turn), sine = std::sin(turn);
    const auto wave = [&](double x, double y) { return std::cos(k * (cosine * x + sine * y)); };
    // Under a smooth window, so that what is cut at its edge does not count.
    std::array<double, 3> response{}, light{};
    plate.inTheMiddle(50, plate.respond(wave), [&](double x, double y, const formats::Float3& b) {
      const double window = std::pow(std::cos(pi * x / 100) * std::cos(pi * y / 100), 2) * wave(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        response[c] += window * static_cast<double>(b[c]), light[c] += window * wave(x, y);
    });
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(response[c] / light[c], plate.colors[c].frequencyResponse(k),
                  allowed * plate.colors[c].total())
          << "wavelength " << wavelength << " color " << c;
  }
}

TEST_P(PlateOfMeanFreePath, KeepsTheContrastOfSinusoids) {
  expectContrasts(plate, 0.015);
}

TEST(Plate, KeepsTheContrastOfSinusoidsWhereVerticesAreClose) {
  expectContrasts(Plate(2.5, 2), 0.008);
}

// Light on one side: half of the total at the edge, and the line spread is the slope.
TEST_P(PlateOfMeanFreePath, CastsTheShadowOfAnEdge) {
  const double reach = 8;
  plate.inTheMiddle(
      reach, plate.respond([](double x, double) { return x > 0 ? 1.0 : 0.0; }),
      [&](double x, double y, const formats::Float3& b) {
        for (std::size_t c = 0; c < 3; ++c) {
          double expected = plate.colors[c].total() / 2;
          constexpr int kSteps = 400;
          for (int i = 0; i < kSteps; ++i)
            expected += x / kSteps * plate.colors[c].lineSpread(std::abs(x) * (i + 0.5) / kSteps);
          // The edge lies between texels, whose light is one value each.
          const double allowed = std::abs(x) < 2 ? 0.06 : 0.02;
          EXPECT_NEAR(b[c], expected, allowed * plate.colors[c].total()) << x << " " << y << " color " << c;
        }
      });
}

TEST(Plate, GivesTheEnclosedEnergyInTheMiddleOfADisk) {
  const Plate plate(2.5, kSpacing);
  for (const double radius : {6.0, 12.0, 24.0}) {
    const auto radiosity = plate.respond(
        [&](double x, double y) { return std::clamp(radius - std::hypot(x, y) + 0.5, 0.0, 1.0); });
    plate.inTheMiddle(1, radiosity, [&](double, double, const formats::Float3& b) {
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(b[c] / plate.colors[c].enclosed(radius), 1, radius > 10 ? 0.015 : 0.05)
            << radius << " color " << c;
    });
  }
}

TEST(Plate, KernelsByComponentsErrAsTheySay) {
  const auto mesh = tests::plateMesh(kTexels, kSpacing);
  const auto medium = tests::mediumOf(2.5);
  const Made exact = tests::kernelsOf(mesh, kTexels, medium, exactKernels());
  Options coarse;
  coarse.kernel_error = 0.01;
  const Made few = tests::kernelsOf(mesh, kTexels, medium, coarse);
  ASSERT_GT(few.figures.components, 0);
  EXPECT_LE(few.figures.kernel_error, 0.01);
  const std::size_t values = std::size_t{3} * formats::kKernelTexels,
                    rows = exact.translucency.receiverCount();
  const auto components = static_cast<std::size_t>(few.figures.components);
  const std::vector<float> all = exact.translucency.kernels.decode(),
                           weights = few.translucency.kernels.decode();
  double difference = 0, squares = 0;
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t v = 0; v < values; ++v) {
      double sum = 0;
      for (std::size_t c = 0; c < components; ++c)
        sum += static_cast<double>(weights[r * components + c]) *
               static_cast<double>(few.translucency.basis[c * values + v]);
      difference += std::pow(sum - static_cast<double>(all[r * values + v]), 2);
      squares += std::pow(static_cast<double>(all[r * values + v]), 2);
    }
  EXPECT_NEAR(std::sqrt(difference / squares), few.figures.kernel_error, 0.002);
}

}  // namespace
}  // namespace bakelight::kernels
