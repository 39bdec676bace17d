#include "tools/report/flip.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace bakelight::report {
namespace {

constexpr int kWidth = 56, kHeight = 40;

formats::Image uniform(float r, float g, float b, int width = 24, int height = 24) {
  formats::Image image(width, height, {"R", "G", "B"});
  for (std::size_t i = 0; i < image.values.size(); i += 3) {
    image.values[i] = r, image.values[i + 1] = g, image.values[i + 2] = b;
  }
  return image;
}

// Coloured waves.
formats::Image waves(double amplitude, double shift, double tilt) {
  formats::Image image(kWidth, kHeight, {"R", "G", "B"});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        image.texel(x, y)[c] = static_cast<float>(0.5 + amplitude * std::sin(0.31 * x + 0.9 * c + shift) *
                                                            std::cos(0.23 * y - tilt * c));
  return image;
}

double mean(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// The expected numbers come from the authors' own program (flip_api.py of their repository, its
// two-dimensional filters, in double precision).
TEST(Flip, AgreesWithItsAuthorsProgram) {
  const formats::Image reference = waves(0.45, 0, 0.4);
  formats::Image test = waves(0.40, 0.2, 0.5);
  for (int y = 10; y < 14; ++y)
    for (int x = 20; x < 40; ++x) {
      test.texel(x, y)[0] = 0.9F, test.texel(x, y)[1] = 0.1F, test.texel(x, y)[2] = 0.2F;
    }
  std::fill_n(test.texel(30, 30), 3, 1.0F);
  const std::vector<float> errors = FlipReference(reference).errorsOf(test);
  ASSERT_EQ(errors.size(), static_cast<std::size_t>(kWidth) * kHeight);
  EXPECT_NEAR(mean(errors), 0.3259659730511741, 2e-6);
  const struct {
    int row, column;
    double error;
  } expected[] = {{0, 0, 0.37557057611144445},   {11, 30, 0.9686118016769939}, {30, 30, 0.6613307637974679},
                  {39, 55, 0.40915222798781536}, {20, 10, 0.2595191089482204}, {12, 19, 0.31865748863691884}};
  for (const auto& [row, column, error] : expected)
    EXPECT_NEAR(errors[row * kWidth + column], error, 1e-5) << row << ", " << column;
}

TEST(Flip, IsOneForGreenAgainstBlueAndZeroForEqualPictures) {
  for (const float error : FlipReference(uniform(0, 1, 0)).errorsOf(uniform(0, 0, 1)))
    EXPECT_NEAR(error, 1, 1e-5);
  for (const float error : FlipReference(uniform(0, 0, 0)).errorsOf(uniform(1, 1, 1)))
    EXPECT_NEAR(error, 0.9673797634231922, 1e-5);
  const formats::Image picture = waves(0.4, 0.1, 0.3);
  for (const float error : FlipReference(picture).errorsOf(picture)) EXPECT_EQ(error, 0);
}

TEST(Flip, IsSymmetricAndGrowsWithTheDifference) {
  const formats::Image a = waves(0.4, 0, 0.4), b = waves(0.4, 0.3, 0.4), c = waves(0.4, 0.6, 0.4);
  EXPECT_EQ(FlipReference(a).errorsOf(b), FlipReference(b).errorsOf(a));
  EXPECT_GT(mean(FlipReference(a).errorsOf(c)), 1.3 * mean(FlipReference(a).errorsOf(b)));
}

// Seen from afar, a fine pattern is its mean (in the linear space of the filter), and no edge is left of it.
TEST(Flip, DoesNotSeeWhatTheEyeCannotResolve) {
  formats::Image stripes(kWidth, kHeight, {"R", "G", "B"}), shifted = stripes;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      std::fill_n(stripes.texel(x, y), 3, x % 2 == 0 ? 0.2F : 0.8F);
      std::fill_n(shifted.texel(x, y), 3, x % 2 == 1 ? 0.2F : 0.8F);
    }
  const std::size_t center = kHeight / 2 * kWidth + kWidth / 2;
  const double near = FlipReference(stripes, 8).errorsOf(shifted)[center];
  const double far = FlipReference(stripes, 67).errorsOf(shifted)[center];
  EXPECT_GT(near, 0.5);
  EXPECT_LT(far, 0.05);
}

// Further channels, here alpha, do not count.
TEST(Flip, LooksAtColorsOnly) {
  const formats::Image reference = uniform(0.2F, 0.5F, 0.7F), test = uniform(0.3F, 0.5F, 0.7F);
  formats::Image with_alpha(test.width, test.height, {"R", "G", "B", "A"});
  for (std::size_t i = 0; i < test.values.size() / 3; ++i) {
    std::copy_n(&test.values[3 * i], 3, &with_alpha.values[4 * i]);
    with_alpha.values[4 * i + 3] = 0.1F * static_cast<float>(i % 7);
  }
  EXPECT_EQ(FlipReference(reference).errorsOf(with_alpha), FlipReference(reference).errorsOf(test));
  EXPECT_THROW(FlipReference(reference).errorsOf(uniform(0, 0, 0, 23)), std::invalid_argument);
  EXPECT_THROW(FlipReference(formats::Image(4, 4, {"Y"})), std::invalid_argument);
}

TEST(Flip, IsTheSameOnOneThread) {
  const formats::Image reference = waves(0.4, 0, 0.4), test = waves(0.3, 0.3, 0.2);
  const std::vector<float> many = FlipReference(reference).errorsOf(test);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(FlipReference(reference).errorsOf(test), many);
}

}  // namespace
}  // namespace bakelight::report
