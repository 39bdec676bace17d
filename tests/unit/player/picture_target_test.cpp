#include "tools/player/gl/picture_target.h"

#include <cmath>
#include <limits>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "transport/color.h"
#include "transport/cpu_renderer.h"

namespace bakelight::player {
namespace {

// A target that holds the given subsamples (R, G, B, A, rows from top to bottom).
PictureTarget targetHolding(const formats::Image& subsamples, int supersampling) {
  PictureTarget target;
  target.resize(subsamples.width / supersampling, subsamples.height / supersampling, supersampling);
  target.beginFrame(1);
  GLint destination = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &destination);
  const Texture texture = makeTexture(GL_RGBA32F, subsamples.width, subsamples.height);
  const Framebuffer source = makeFramebuffer(texture, {});
  for (int y = 0; y < subsamples.height; ++y)
    glTextureSubImage2D(texture.name(), 0, 0, subsamples.height - 1 - y, subsamples.width, 1, GL_RGBA,
                        GL_FLOAT, subsamples.texel(0, y));
  glBlitNamedFramebuffer(source.name(), static_cast<GLuint>(destination), 0, 0, subsamples.width,
                         subsamples.height, 0, 0, subsamples.width, subsamples.height, GL_COLOR_BUFFER_BIT,
                         GL_NEAREST);
  throwIfGlFailed("preparing a test");
  return target;
}

int code(float value) {
  return static_cast<int>(std::lround(255 * value));
}

class PictureTargetTest : public testing::Test {
 protected:
  HeadlessContext context_;
};

TEST_F(PictureTargetTest, DisplayCodesAreThoseOfTheCpu) {
  constexpr float kExposure = 1.7f;
  // Values in the middle of each code, and just beside each boundary between two codes.
  formats::Image values(256, 3, {"R", "G", "B", "A"});
  for (int x = 0; x < 256; ++x)
    for (int y = 0; y < 3; ++y) {
      const float edge = static_cast<float>(x) + (y == 0 ? 0.0f : 0.5f);
      const float linear = transport::linearFromSrgb(edge / 255) * (y == 1 ? 0.999f : 1.001f) / kExposure;
      std::fill_n(values.texel(x, y), 3, linear);
      values.texel(x, y)[3] = 1;
    }
  const formats::Image picture = targetHolding(values, 1).displayImage(kExposure);
  for (int x = 0; x < 256; ++x) {
    EXPECT_EQ(code(picture.texel(x, 0)[0]), x);
    for (int y = 1; y < 3; ++y)
      EXPECT_NEAR(code(picture.texel(x, y)[1]), transport::displayCode(values.texel(x, y)[1] * kExposure), 1)
          << x;
  }
}

TEST_F(PictureTargetTest, OutOfRangeValuesBecomeBlackOrWhite) {
  formats::Image values(4, 1, {"R", "G", "B", "A"});
  const float cases[4] = {-3, 1e30f, std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity()};
  const int expected[4] = {0, 255, 0, 255};
  for (int x = 0; x < 4; ++x) {
    std::fill_n(values.texel(x, 0), 3, cases[x]);
    values.texel(x, 0)[3] = 1;
  }
  const formats::Image picture = targetHolding(values, 1).displayImage(1);
  for (int x = 0; x < 4; ++x) EXPECT_EQ(code(picture.texel(x, 0)[0]), expected[x]) << cases[x];
}

TEST_F(PictureTargetTest, SubsamplesAreAveragedInLinearRadiance) {
  for (const int supersampling : {1, 2, 3, 4}) {
    formats::Image values(5 * supersampling, 3 * supersampling, {"R", "G", "B", "A"});
    formats::Image expected(5, 3, values.channel_names);
    for (int y = 0; y < values.height; ++y)
      for (int x = 0; x < values.width; ++x)
        for (std::size_t c = 0; c < 4; ++c) {
          const auto value = static_cast<float>((x * 7 + y * 13 + static_cast<int>(c) * 5) % 32) / 32;
          values.texel(x, y)[c] = value;
          expected.texel(x / supersampling, y / supersampling)[c] +=
              value / static_cast<float>(supersampling * supersampling);
        }
    const formats::Image picture = targetHolding(values, supersampling).linearImage();
    ASSERT_EQ(picture.values.size(), expected.values.size());
    for (std::size_t i = 0; i < expected.values.size(); ++i)
      EXPECT_NEAR(picture.values[i], expected.values[i], 1e-6) << supersampling;
  }
}

TEST_F(PictureTargetTest, CoverageIsDividedOutBeforeEncoding) {
  formats::Image values(3, 1, {"R", "G", "B", "A"});
  values.values = {0.1f, 0.2f, 0.05f, 0.25f, 0, 0, 0, 0, 0.5f, 0.5f, 0.5f, 1};
  const formats::Image picture = targetHolding(values, 1).displayImage(0.5f);
  EXPECT_NEAR(code(picture.texel(0, 0)[0]), transport::displayCode(0.2f), 1);
  EXPECT_NEAR(code(picture.texel(0, 0)[1]), transport::displayCode(0.4f), 1);
  EXPECT_EQ(code(picture.texel(0, 0)[3]), 64);
  EXPECT_EQ(code(picture.texel(1, 0)[0]), 0);
  EXPECT_EQ(code(picture.texel(1, 0)[3]), 0);
  EXPECT_NEAR(code(picture.texel(2, 0)[2]), transport::displayCode(0.25f), 1);
}

TEST_F(PictureTargetTest, TooLargeASizeIsAnErrorThatSaysTheLimit) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  PictureTarget target;
  try {
    target.resize(largest / 2 + 1, 4, 2);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_THAT(error.what(), testing::HasSubstr("at most " + std::to_string(largest)));
  }
}

}  // namespace
}  // namespace bakelight::player
