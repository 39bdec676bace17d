#include "tools/report/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "formats/error.h"

namespace bakelight::report {
namespace {

constexpr int kSize = 100;

// Radiance 2, 1, 0.5 everywhere; the left column is covered by half.
Reference flat(double factor = 1) {
  Reference reference{{formats::Image(kSize, kSize, {"R", "G", "B", "A"}), {}}, {}};
  for (int i = 0; i < kSize * kSize; ++i) {
    float* texel = &reference.picture.linear.values[4 * i];
    for (int c = 0; c < 3; ++c) texel[c] = static_cast<float>(factor * 2 / (1 << c));
    texel[3] = i % kSize == 0 ? 0.5F : 1;
    reference.picture.covered.push_back(i % kSize != 0);
  }
  return reference;
}

void addNoise(Reference& reference, double deviation, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0, deviation);
  reference.variance.assign(3 * kSize * kSize, static_cast<float>(deviation * deviation));
  for (std::size_t i = 0; i < reference.picture.linear.values.size(); ++i)
    if (i % 4 != 3) reference.picture.linear.values[i] += static_cast<float>(normal(generator));
}

TEST(Errors, OfAScaledPictureAreTheFactor) {
  const Reference truth = flat(), brighter = flat(1.1);
  const ViewErrors errors = viewErrors(truth, brighter, truth.picture);
  EXPECT_EQ(errors.pixels, static_cast<std::size_t>(kSize * (kSize - 1)))
      << "pixels covered in part do not count";
  EXPECT_NEAR(errors.relativeRmse(), 0.1, 1e-6);
  EXPECT_NEAR(errors.squared_reference, (4 + 1 + 0.25) / 3, 1e-6);
  EXPECT_NEAR(percentile(errors.relative_differences, 0.99), 0.1, 1e-6);
  EXPECT_EQ(errors.coverage_error, 0);
}

// The noise of the reference does not count as error, and does not hide one.
TEST(Errors, NoiseIsSubtracted) {
  for (const double error : {0.0, 0.02}) {
    Reference noisy = flat();
    addNoise(noisy, 0.1, 1);
    const ViewErrors errors = viewErrors(noisy, flat(1 + error), flat().picture);
    const double raw = std::sqrt(errors.squared_difference / errors.squared_reference);
    EXPECT_GT(raw, 0.07);
    // Standard deviation of the mean of N squares of noise: √(2/N) of its variance.
    const double uncertainty = 4 * std::sqrt(2.0 / (3 * kSize * kSize)) * 0.01 / errors.squared_reference;
    EXPECT_NEAR(errors.relativeRmse() * errors.relativeRmse(), error * error, uncertainty + 2e-5);
    EXPECT_LT(errors.relativeRmse(), error + 0.5 * raw);
  }
}

// Two noisy pictures of the same: both variances go.
TEST(Errors, NoiseOfBothPicturesIsSubtracted) {
  Reference a = flat(), b = flat();
  addNoise(a, 0.1, 1);
  addNoise(b, 0.2, 2);
  const ViewErrors errors = viewErrors(a, b, a.picture);
  EXPECT_NEAR(errors.variance, 0.01 + 0.04, 1e-6);
  EXPECT_NEAR(errors.squared_difference, 0.05, 0.002);
  EXPECT_NEAR(relativeNoise(a), 0.1 / std::sqrt(1.75 + 0.01), 0.001);
  EXPECT_EQ(relativeNoise(flat()), 0);
}

TEST(Errors, CoverageIsComparedByItself) {
  const Reference truth = flat();
  Reference smaller = flat();
  for (int i = 0; i < kSize * kSize; ++i)
    if (i % kSize == 1) {
      smaller.picture.linear.values[4 * i + 3] = 0;
      smaller.picture.covered[i] = 0;
    }
  const ViewErrors errors = viewErrors(truth, smaller, truth.picture);
  EXPECT_NEAR(errors.coverage_error, 1 / (kSize - 0.5), 1e-6);
  EXPECT_EQ(errors.pixels, static_cast<std::size_t>(kSize * (kSize - 2)));
  EXPECT_EQ(errors.relativeRmse(), 0);
}

TEST(Errors, ReferencesAreReadByChannelName) {
  formats::Image image(2, 1, {"A", "B", "G", "R", "variance.B", "variance.G", "variance.R"});
  image.values = {1, 3, 2, 1, 30, 20, 10, 0.5F, 6, 5, 4, 60, 50, 40};
  const Reference reference = referenceFrom(image, 2, 1, "truth.exr");
  EXPECT_EQ(reference.picture.linear.values, (std::vector<float>{1, 2, 3, 1, 4, 5, 6, 0.5F}));
  EXPECT_EQ(reference.variance, (std::vector<float>{10, 20, 30, 40, 50, 60}));
  EXPECT_EQ(reference.picture.covered, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_THROW(referenceFrom(image, 1, 2, "truth.exr"), Error);
  image.values[5] = -1;
  EXPECT_THROW(referenceFrom(image, 2, 1, "truth.exr"), Error);
  image.channel_names[5] = "other";
  EXPECT_THROW(referenceFrom(image, 2, 1, "truth.exr"), Error);
}

TEST(Errors, PercentileIsTheLeastValueThatEnoughDoNotExceed) {
  std::vector<float> values(200);
  for (int i = 0; i < 200; ++i) values[(37 * i) % 200] = static_cast<float>(i + 1);
  EXPECT_EQ(percentile(values, 0.99), 198);
  EXPECT_EQ(percentile(values, 1), 200);
  EXPECT_EQ(percentile(values, 0), 1);
  EXPECT_EQ(percentile({}, 0.5), 0);
  EXPECT_DOUBLE_EQ(rootMeanSquare(std::vector<double>{3, 4, 5, 0}), std::sqrt(50.0 / 4));
}

}  // namespace
}  // namespace bakelight::report
