#include "tools/brdf/merl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "formats/error.h"
#include "transport/sh.h"

namespace bakelight::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kValues = 90 * 90 * 180;

// A file whose value at (half, difference, azimuth) cells and channel is `value`.
template <class Value>
std::vector<std::byte> merlFile(const Value& value) {
  std::vector<std::byte> bytes(12 + 3 * kValues * 8);
  const std::int32_t sizes[3] = {90, 90, 180};
  std::memcpy(bytes.data(), sizes, 12);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t cell = 0; cell < kValues; ++cell) {
      const double number = value(static_cast<int>(cell / (90 * 180)), static_cast<int>(cell / 180 % 90),
                                  static_cast<int>(cell % 180), static_cast<int>(c));
      std::memcpy(&bytes[12 + (c * kValues + cell) * 8], &number, 8);
    }
  return bytes;
}

// 1/π in each channel, once the database's scales are taken out.
TEST(Merl, OfALambertianIsTheClampedCosine) {
  const Brdf brdf = readMerl(merlFile([](int, int, int, int c) {
                               const double scale[3] = {1500, 1500 / 1.15, 1500 / 1.66};
                               return scale[c] / kPi;
                             }),
                             "lambert.binary");
  const Projection projection = project(brdf, 4, 3), expected = project(lambert(Vec3::Ones()), 4, 3);
  for (std::size_t i = 0; i < expected.table.values.size(); ++i)
    EXPECT_NEAR(projection.table.values[i], expected.table.values[i], 1e-6);
}

TEST(Merl, IndexesHalfAndDifferenceAngles) {
  const Brdf half = readMerl(merlFile([](int i, int, int, int) { return 1500.0 * i; }), "half.binary");
  const Brdf difference =
      readMerl(merlFile([](int, int j, int, int) { return 1500.0 * j; }), "difference.binary");
  const Brdf turn = readMerl(merlFile([](int, int, int k, int) { return 1500.0 * k; }), "turn.binary");
  const auto at = [](double polar_deg, double azimuth_deg) {
    const double polar = polar_deg * kPi / 180, azimuth = azimuth_deg * kPi / 180;
    return Vec3(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
  };
  // Mirror directions: half angle 0, difference angle that of incidence.
  EXPECT_EQ(half(at(40.5, 0), at(40.5, 180))[0], 0);
  EXPECT_EQ(difference(at(40.5, 20), at(40.5, 200))[0], 40);
  // The same direction back: half angle that of incidence, in steps of its square root; difference 0.
  EXPECT_EQ(half(at(30.5, 70), at(30.5, 70))[0], std::floor(std::sqrt(30.5 / 90) * 90));
  EXPECT_EQ(difference(at(30.5, 70), at(30.5, 70))[0], 0);
  // In the plane of incidence the difference lies along it: azimuth 0 or 180°; across it: 90°.
  const double across = turn(Vec3(0.3, 0.4, std::sqrt(0.75)), Vec3(0.3, -0.4, std::sqrt(0.75)))[0];
  EXPECT_NEAR(across, 90, 1);
  // Reciprocity: a half turn of the difference is the same cell.
  EXPECT_NEAR(turn(Vec3(0.3, 0.1, std::sqrt(0.9)), Vec3(-0.2, -0.4, std::sqrt(0.8)))[0],
              turn(Vec3(-0.2, -0.4, std::sqrt(0.8)), Vec3(0.3, 0.1, std::sqrt(0.9)))[0], 1);
}

TEST(Merl, TakesUnmeasuredValuesForBlack) {
  const Brdf brdf = readMerl(merlFile([](int, int, int, int) { return -1.0; }), "negative.binary");
  EXPECT_EQ(brdf(Vec3(0, 0, 1), Vec3(0, 0, 1)), Vec3(0, 0, 0));
}

TEST(Merl, RefusesOtherFiles) {
  std::vector<std::byte> bytes = merlFile([](int, int, int, int) { return 1.0; });
  const auto problem = [](std::span<const std::byte> file) -> std::string {
    try {
      readMerl(file, "some.binary");
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      return error.paragraph();
    }
    return "";
  };
  EXPECT_EQ(problem(bytes), "");
  EXPECT_THAT(problem(std::span(bytes).first(bytes.size() - 1)), testing::HasSubstr("some.binary"));
  EXPECT_THAT(problem(std::span(bytes).first(bytes.size() - 1)), testing::HasSubstr("34992012"));
  EXPECT_THAT(problem(std::span(bytes).first(5)), testing::HasSubstr("MERL"));
  const double nan = std::nan("");
  std::memcpy(&bytes[12 + 8 * 1000], &nan, 8);
  EXPECT_THAT(problem(bytes), testing::HasSubstr("value 1000"));
  bytes[0] = std::byte{91};
  EXPECT_THAT(problem(bytes), testing::HasSubstr("90, 90 and 180"));
}

}  // namespace
}  // namespace bakelight::brdf
