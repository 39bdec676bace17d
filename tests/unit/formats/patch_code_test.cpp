#include "formats/patch_code.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/btf_reflection.h"
#include "formats/error.h"
#include "formats/patch_levels.h"

namespace bakelight::formats {
namespace {

// Smooth, with edges and one component that is much weaker.
std::vector<float> madeValues(const PatchValuesShape& shape) {
  std::vector<float> values;
  for (int y = 0; y < shape.height; ++y)
    for (int x = 0; x < shape.width; ++x)
      for (int v = 0; v < shape.views * shape.views; ++v)
        for (int k = 0; k < shape.components; ++k)
          values.push_back(static_cast<float>(std::pow(0.3, k) *
                                              (2 + std::sin(0.4 * x + 0.2 * v) * std::cos(0.3 * y - 0.1 * v) +
                                               (x > shape.width / 3 + v % 3 ? 0.5 : -0.5))));
  return values;
}

double squaredDifference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (double{a[i]} - b[i]) * (double{a[i]} - b[i]);
  return sum;
}

class PatchCodeOfShape : public testing::TestWithParam<PatchValuesShape> {};

TEST_P(PatchCodeOfShape, ErrsAsMuchAsIsSaidAndAsked) {
  const PatchValuesShape shape = GetParam();
  const std::vector<float> values = madeValues(shape);
  const PatchEncoder encoder(values, shape);
  double total = 0;
  for (const float value : values) total += double{value} * value;
  for (const double relative : {0.1, 0.01, 1e-4}) {
    const double asked = relative * relative * total;
    const float step = encoder.stepFor(asked);
    const Bytes bytes = encoder.encode(step);
    const double difference =
        squaredDifference(decodePatchValues(bytes, step, shape, "made", "code"), values);
    EXPECT_LE(difference, asked * 1.001) << relative;
    EXPECT_NEAR(difference, encoder.squaredError(step), 1e-3 * asked + 1e-12 * total) << relative;
    // A step twice as large would err too much: the bytes are well spent. A patch of one value may be met exactly.
    if (shape.count() > 100) {
      EXPECT_GT(encoder.squaredError(2 * step), asked) << relative;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, PatchCodeOfShape,
                         testing::Values(PatchValuesShape{16, 16, 4, 5}, PatchValuesShape{1, 1, 1, 1},
                                         PatchValuesShape{7, 5, 1, 3}, PatchValuesShape{3, 65, 2, 2},
                                         PatchValuesShape{130, 2, 3, 1}));

TEST(PatchCode, TakesAFewHundredthsOfSmoothValues) {
  const PatchValuesShape shape{32, 32, 4, 6};
  const std::vector<float> values = madeValues(shape);
  const PatchEncoder encoder(values, shape);
  double total = 0;
  for (const float value : values) total += double{value} * value;
  const Bytes bytes = encoder.encode(encoder.stepFor(0.02 * 0.02 * total));
  EXPECT_LT(bytes.size() * 50, values.size() * 2);
}

TEST(PatchCode, IsTheSameEachTime) {
  const PatchValuesShape shape{9, 9, 2, 2};
  const std::vector<float> values = madeValues(shape);
  EXPECT_EQ(PatchEncoder(values, shape).encode(0.01F), PatchEncoder(values, shape).encode(0.01F));
}

TEST(PatchCode, HoldsNothing) {
  const PatchValuesShape shape{4, 4, 2, 2};
  const std::vector<float> zeros(shape.count(), 0.0F);
  const PatchEncoder encoder(zeros, shape);
  const float step = encoder.stepFor(1e-6);
  EXPECT_EQ(decodePatchValues(encoder.encode(step), step, shape, "made", "code"), zeros);
}

TEST(PatchCode, RefusesWhatIsNone) {
  const PatchValuesShape shape{8, 8, 2, 3};
  const Bytes whole = PatchEncoder(madeValues(shape), shape).encode(0.05F);
  const auto messageOf = [&](const Bytes& bytes, const PatchValuesShape& read_as) {
    try {
      decodePatchValues(bytes, 0.05F, read_as, "torn.glb", "factorCode");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  EXPECT_EQ(messageOf(whole, shape), "read");
  EXPECT_THAT(messageOf(Bytes(whole.begin(), whole.end() - 1), shape), testing::HasSubstr("torn.glb"));
  EXPECT_THAT(messageOf(Bytes(whole.begin(), whole.begin() + 4), shape), testing::HasSubstr("factorCode"));
  EXPECT_THAT(messageOf(whole, {8, 8, 2, 4}), testing::HasSubstr("factorCode"));
  EXPECT_THAT(messageOf(whole, {8, 7, 2, 3}), testing::HasSubstr("factorCode"));
  EXPECT_THROW(PatchEncoder(madeValues(shape), {8, 8, 2, 4}), std::invalid_argument);
}

TEST(PatchCode, BecomesFactorsAndHeightsOfAllLevels) {
  BtfReflection btf;
  btf.width = 12, btf.height = 6, btf.views = 2, btf.components = 3;
  const PatchValuesShape shape{12, 6, 2, 3}, one{12, 6, 2, 1};
  btf.code.emplace().step = 1e-3F;
  btf.code->factors.data = PatchEncoder(madeValues(shape), shape).encode(1e-3F);
  btf.code->relief = ReliefCode{2e-3F, {1, PatchEncoder(madeValues(one), one).encode(2e-3F)}};
  for (const Precision precision : {Precision::kFloat16, Precision::kUint8}) {
    btf.code->precision = precision;
    expandPatch(btf, "made");
    EXPECT_EQ(btf.factors.precision, precision);
    const std::vector<float> factors = btf.factors.decode(),
                             expected = withLevels(madeValues(shape), 12, 6, 12);
    ASSERT_EQ(factors.size(), expected.size());
    for (std::size_t i = 0; i < factors.size(); ++i) ASSERT_NEAR(factors[i], expected[i], 0.02) << i;
    ASSERT_TRUE(btf.heights);
    const std::vector<float> heights = btf.heights->decode();
    const std::vector<float> expected_heights = withLevels(madeValues(one), 12, 6, 4);
    ASSERT_EQ(heights.size(), expected_heights.size());
    for (std::size_t i = 0; i < heights.size(); ++i) ASSERT_NEAR(heights[i], expected_heights[i], 0.01) << i;
  }
}

TEST(PatchLevels, AreMeansOverWhatTheyCover) {
  // 3 × 2 texels, then one: of three columns each a third.
  const std::vector<float> finest = {1, 2, 3, 4, 5, 9};
  EXPECT_EQ(withLevels(finest, 3, 2, 1).size(), 7U);
  EXPECT_FLOAT_EQ(withLevels(finest, 3, 2, 1).back(), 4);
}

}  // namespace
}  // namespace bakelight::formats
