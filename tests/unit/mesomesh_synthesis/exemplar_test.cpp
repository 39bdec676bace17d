#include "tools/mesomesh/synthesis/exemplar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "formats/error.h"
#include "tests/support/exemplars.h"

namespace bakelight::mesomesh {
namespace {

using testing::HasSubstr;

std::string refusal(const formats::Image& image, const ExemplarSettings& settings = {}) {
  try {
    makeExemplar(image, settings, "patch.exr");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "";
}

TEST(ExemplarSymmetries, AreMeasured) {
  const auto symmetry = [](const formats::Image& image) { return makeExemplar(image, {}, "").symmetry; };
  EXPECT_NEAR(symmetry(tests::checks()).quarter.likeness, 1, 1e-6);
  EXPECT_EQ(symmetry(tests::checks()).folds(), 4);
  EXPECT_NEAR(symmetry(tests::stripes()).half.likeness, 1, 1e-6);
  EXPECT_LT(symmetry(tests::stripes()).quarter.likeness, 0.1);
  EXPECT_EQ(symmetry(tests::stripes()).folds(), 2);
  EXPECT_EQ(symmetry(tests::stones()).folds(), 1);
  EXPECT_LT(symmetry(tests::whiteNoise()).half.likeness, 0.1);
  EXPECT_EQ(symmetry(tests::constantImage()).folds(), 4);
}

TEST(ExemplarSymmetries, TellWhereTexelsGo) {
  const Exemplar exemplar = makeExemplar(tests::checks(), {}, "");
  const auto [x, y] = exemplar.symmetry.quarter.shift;
  const auto value = [&](int column, int row) {
    return exemplar.channels((((row % 64) + 64) % 64) * 64 + ((column % 64) + 64) % 64, 0);
  };
  for (const auto& [column, row] : {std::array{0, 0}, {3, 17}, {40, 5}})
    EXPECT_NEAR(value(column, row), value(-row + x, column + y), 1e-5);
}

TEST(Exemplars, OfManyChannelsKeepWhatVaries) {
  // 200 channels, all combinations of three.
  const formats::Image three = tests::stochastic(24);
  std::vector<std::string> names;
  for (int c = 0; c < 200; ++c) names.push_back("c" + std::to_string(c));
  formats::Image image(24, 24, names);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 24; ++x)
      for (int c = 0; c < 200; ++c)
        for (int k = 0; k < 3; ++k)
          image.texel(x, y)[c] +=
              three.texel(x, y)[k] *
              static_cast<float>(tests::hashedUnit(9, static_cast<std::uint64_t>(c * 3 + k)) - 0.5);
  const Exemplar exemplar = makeExemplar(image, {}, "");
  EXPECT_GT(exemplar.retained_channel_variance, 0.9999);
  // Distances between texels are those between their channels.
  const auto distance = [&](int a, int b) {
    double sum = 0;
    for (int c = 0; c < 200; ++c) {
      const double d = image.texel(a, 23)[c] - image.texel(b, 23)[c];
      sum += d * d;
    }
    return std::sqrt(sum);
  };
  EXPECT_NEAR((exemplar.channels.row(2) - exemplar.channels.row(11)).norm(), distance(2, 11),
              1e-3 * distance(2, 11));
}

TEST(Exemplars, ThatCannotBeUsedAreRefused) {
  formats::Image image = tests::stones(16, 3);
  EXPECT_THAT(refusal(formats::Image{}), HasSubstr("no texel"));
  EXPECT_THAT(refusal(tests::constantImage(8), {false, {}}), HasSubstr("8 × 8 texels and is not periodic"));
  EXPECT_EQ(refusal(tests::constantImage(9), {false, {}}), "");
  EXPECT_EQ(refusal(tests::constantImage(1)), "");
  EXPECT_THAT(refusal(image, {true, 0.0}), HasSubstr("side length of a texel"));
  EXPECT_THAT(refusal(image, {true, std::numeric_limits<double>::quiet_NaN()}),
              HasSubstr("side length of a texel"));
  image.texel(5, 7)[1] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(refusal(image), HasSubstr("patch.exr, texel (5, 7), channel G"));
}

}  // namespace
}  // namespace bakelight::mesomesh
