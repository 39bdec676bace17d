#include "transport/color.h"

#include <gtest/gtest.h>

#include <limits>

namespace bakelight::transport {
namespace {

TEST(Color, EndsAndMiddle) {
  EXPECT_EQ(displayCode(0), 0);
  EXPECT_EQ(displayCode(1), 255);
  EXPECT_EQ(displayCode(0.21586050f), 128);  // ((128/255 + 0.055) / 1.055)^2.4
  EXPECT_NEAR(srgbFromLinear(0.18f), 0.46135613f, 1e-6);
}

TEST(Color, ClampsWhatIsOutside) {
  EXPECT_EQ(displayCode(-3), 0);
  EXPECT_EQ(displayCode(1e30f), 255);
  EXPECT_EQ(displayCode(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(displayCode(std::numeric_limits<float>::quiet_NaN()), 0);
}

TEST(Color, EncodingIsInvertible) {
  for (int code = 0; code <= 255; ++code)
    EXPECT_EQ(displayCode(linearFromSrgb(static_cast<float>(code) / 255)), code);
}

}  // namespace
}  // namespace bakelight::transport
