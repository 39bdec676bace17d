#include "tools/pack/rtt_packing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bakelight::packing {
namespace {

formats::RadianceTransferTexture madeTexture(int views, int width, int height) {
  formats::RadianceTransferTexture texture{
      .material = "", .order = 3, .views = views, .width = width, .height = height};
  texture.allocate();
  for (std::size_t i = 0; i < texture.values.size(); ++i)
    texture.values[i] = static_cast<float>(0.3 + 0.2 * std::sin(0.37 * static_cast<double>(i)) +
                                           0.1 * std::cos(0.011 * static_cast<double>(i)));
  return texture;
}

// Σ_k factors_k · basis_k of a texel and view.
std::vector<float> responseOf(const formats::RttReflection& rtt, std::size_t texel, int view) {
  const std::vector<float> factors = rtt.factors.decode();
  std::vector<float> response(27, 0.0F);
  for (int k = 0; k < rtt.components; ++k)
    for (std::size_t i = 0; i < response.size(); ++i)
      response[i] +=
          factors[(texel * static_cast<std::size_t>(rtt.views * rtt.views) + static_cast<std::size_t>(view)) *
                      static_cast<std::size_t>(rtt.components) +
                  static_cast<std::size_t>(k)] *
          rtt.basisOf(k)[i];
  return response;
}

TEST(RttPacking, AllComponentsGiveTheTextureBack) {
  const auto texture = madeTexture(2, 4, 3);
  const PackedRtt packed = packRtt(texture, {.error = 0, .precision = formats::Precision::kFloat32}, "made");
  EXPECT_EQ(packed.reflection.components, 27);
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column)
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x) {
          const auto expected = texture.response(column, row, x, y);
          const auto seen =
              responseOf(packed.reflection, static_cast<std::size_t>(y * 4 + x), row * 2 + column);
          for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_NEAR(seen[i], expected[i], 2e-6);
        }
}

TEST(RttPacking, HeightsAreKeptWhereThereAreAny) {
  auto texture = madeTexture(2, 4, 2);
  EXPECT_FALSE(packRtt(texture, {}, "made").reflection.heights);
  texture.heights.assign(texture.responseCount(), 0.0F);
  EXPECT_FALSE(packRtt(texture, {}, "made").reflection.heights);
  for (int view = 0; view < 4; ++view)
    for (int x = 0; x < 4; ++x)
      texture.heights[texture.responseIndex(view % 2, view / 2, x, 1)] = 0.25F * static_cast<float>(view + x);
  EXPECT_FALSE(packRtt(texture, {.relief = false}, "made").reflection.heights);
  const formats::RttReflection packed = packRtt(texture, {}, "made").reflection;
  ASSERT_TRUE(packed.heights);
  const std::vector<float> heights = packed.heights->decode();
  ASSERT_EQ(heights.size(), (8U + 2 + 1) * 4);
  for (std::size_t view = 0; view < 4; ++view) {
    const float own = 0.25F * static_cast<float>(view);
    EXPECT_EQ(heights[(4 + 3) * 4 + view], own + 0.75F);         // x = 3, y = 1
    EXPECT_EQ(heights[3 * 4 + view], 0);                         // x = 3, y = 0
    EXPECT_EQ(heights[(8 + 1) * 4 + view], (own + 0.625F) / 2);  // of four texels
    EXPECT_EQ(heights[10 * 4 + view], (own + 0.375F) / 2);       // of all
  }
}

// By texture coordinates a patch is as wide as its material says; an id map has widths of its own.
TEST(RttPacking, WidthsAreTheMaterialsWithoutAnIdMap) {
  formats::Materials materials;
  materials.base.patch.emplace().width = 0.25;
  materials.by_name["hem"].patch.emplace().width = 0.5;
  materials.by_name["plain"].patch.emplace();
  PatchSources patches;
  takeMaterials(materials, patches);
  EXPECT_EQ(patches.widths, (std::map<std::string, double>{{"", 0.25}, {"hem", 0.5}}));
  EXPECT_EQ(patches.own_materials, (std::set<std::string>{"hem", "plain"}));
  PatchSources laid_out{{}, formats::IndexImage(), {{"", 2}}};
  takeMaterials(materials, laid_out);
  EXPECT_EQ(laid_out.widths, (std::map<std::string, double>{{"", 2}}));
}

TEST(RttPacking, FewerComponentsErrAsTheySay) {
  const auto texture = madeTexture(3, 8, 8);
  double last = 1;
  for (const double limit : {0.3, 0.05, 0.001}) {
    const PackedRtt packed =
        packRtt(texture, {.error = limit, .precision = formats::Precision::kFloat32}, "made");
    EXPECT_LE(packed.error, limit);
    double wrong = 0, all = 0;
    for (int view = 0; view < 9; ++view)
      for (int texel = 0; texel < 64; ++texel) {
        const auto expected = texture.response(view % 3, view / 3, texel % 8, texel / 8);
        const auto seen = responseOf(packed.reflection, static_cast<std::size_t>(texel), view);
        for (std::size_t i = 0; i < seen.size(); ++i) {
          wrong += std::pow(double{seen[i]} - expected[i], 2);
          all += std::pow(expected[i], 2);
        }
      }
    EXPECT_NEAR(std::sqrt(wrong / all), packed.error, 1e-5);
    EXPECT_LE(packed.error, last);
    last = packed.error;
  }
  EXPECT_LT(last, 0.001);
}

// Of any size: each level is the mean over the area that its texels cover, and the last the mean of all.
TEST(RttPacking, LevelsAreMeans) {
  const auto texture = madeTexture(2, 6, 5);
  const PackedRtt packed = packRtt(texture, {.error = 0, .precision = formats::Precision::kFloat32}, "made");
  const auto levels = formats::rttLevels(6, 5);
  ASSERT_EQ(levels.size(), 3U);  // 6 × 5, 3 × 2, 1 × 1
  for (int view = 0; view < 4; ++view) {
    std::vector<double> mean(27, 0);
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x)
        for (std::size_t i = 0; i < mean.size(); ++i)
          mean[i] += texture.response(view % 2, view / 2, x, y)[i] / 30.0;
    const auto top = responseOf(packed.reflection, levels[2].first_texel, view);
    for (std::size_t i = 0; i < mean.size(); ++i) EXPECT_NEAR(top[i], mean[i], 2e-6);
    // Upper left of 3 × 2: two columns, and two and a half rows.
    std::vector<double> corner(27, 0);
    for (int x = 0; x < 2; ++x)
      for (std::size_t i = 0; i < corner.size(); ++i)
        corner[i] +=
            (texture.response(view % 2, view / 2, x, 0)[i] + texture.response(view % 2, view / 2, x, 1)[i] +
             0.5 * texture.response(view % 2, view / 2, x, 2)[i]) /
            5;
    const auto seen = responseOf(packed.reflection, levels[1].first_texel, view);
    for (std::size_t i = 0; i < corner.size(); ++i) EXPECT_NEAR(seen[i], corner[i], 2e-6);
  }
}

TEST(RttPacking, AnIndexKeepsItsPlaces) {
  formats::IndexImage ids(2, 1, {"patch.U", "patch.V"});
  ids.values = {0, 65535, 32768, 300};
  const formats::PackImage image = packIndex(ids);
  const std::vector<float> places = image.texels.decode();
  EXPECT_NEAR(places[0], 0.5 / 256, 1e-6);
  EXPECT_NEAR(places[1], 255.5 / 256, 1e-6);
  EXPECT_NEAR(places[2], 128.5 / 256, 1e-6);
  EXPECT_NEAR(places[3], 1.5 / 256, 1e-6);
}

}  // namespace
}  // namespace bakelight::packing
