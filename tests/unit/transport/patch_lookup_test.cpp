#include "transport/patch_lookup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/made_rtt.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::transport {
namespace {

using formats::Float2;
using formats::RttReflection;

constexpr int kViews = 8, kWidth = 128, kHeight = 64;

double pattern(double u, double v) {
  return std::sin(2 * std::numbers::pi * u) * std::cos(2 * std::numbers::pi * v);
}

// What a painted plane sends that lies `height` above the mid-plane: each view sees it shifted.
RttReflection raisedPlane(double height) {
  RttReflection rtt = tests::madeRtt(1, kViews, kWidth, kHeight, 1);
  std::vector<float> factors, heights;
  for (const formats::RttLevel& level : formats::rttLevels(kWidth, kHeight))
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        for (int view = 0; view < kViews * kViews; ++view) {
          const Vec3 towards = hemisphereCell(kViews, view % kViews, view / kViews);
          const double u = (x + 0.5) / level.width + height * towards.x() / towards.z(),
                       v = 1 - (y + 0.5) / level.height +
                           height * towards.y() / towards.z() * kWidth / kHeight;
          factors.push_back(static_cast<float>(pattern(u, v)));
          heights.push_back(static_cast<float>(height));
        }
  rtt.factors = formats::encodeTable(factors, 1, formats::Precision::kFloat32, "made", "factors");
  rtt.heights = formats::encodeTable(heights, 1, formats::Precision::kFloat32, "made", "heights");
  return rtt;
}

float lookUp(const PatchLookup& lookup, const Float2& place, const Vec3& to_eye) {
  SeenPoint point;
  point.texcoord = {place[0], place[1] * kHeight / kWidth};
  point.to_eye = to_eye;
  float factor = 0;
  lookup.factorsAt(point, 0, {&factor, 1});
  return factor;
}

// Over directions between those of the grid and places all over the patch.
double worstOf(const RttReflection& rtt, double height) {
  const PatchLookup lookup(rtt, nullptr);
  double worst = 0;
  for (const double polar : {0.0, 20.0, 40.0, 60.0, 70.0})
    for (const double azimuth : {10.0, 80.0, 200.0, 290.0})
      for (int i = 0; i < 64; ++i) {
        const double theta = polar * std::numbers::pi / 180, phi = azimuth * std::numbers::pi / 180;
        const Vec3 eye(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        const Float2 place = {static_cast<float>((i % 8 + 0.3) / 8), static_cast<float>((i / 8 + 0.7) / 8)};
        const double seen = pattern(place[0] + height * eye.x() / eye.z(),
                                    place[1] + height * eye.y() / eye.z() * kWidth / kHeight);
        worst = std::max(worst, std::abs(lookUp(lookup, place, eye) - seen));
      }
  return worst;
}

// Each view is rounded to its nearest texel: half of one, on a pattern whose slope is 2π.
constexpr double kRounding = std::numbers::pi * (1.0 / kWidth + 1.0 / kHeight) + 1e-3;

TEST(PatchLookup, LooksAlongTheRelief) {
  for (const double height : {-0.1, 0.05, 0.15}) {
    RttReflection rtt = raisedPlane(height);
    EXPECT_LT(worstOf(rtt, height), kRounding) << height;
    rtt.heights.reset();
    EXPECT_GT(worstOf(rtt, height), 5 * kRounding) << height;
  }
  EXPECT_LT(worstOf(raisedPlane(0), 0), kRounding);
}

// A step down, whose edge hides from some views what others see: they count for next to nothing, and all weights sum to 1.
TEST(PatchLookup, ViewsThatDoNotSeeThePointGiveWay) {
  RttReflection rtt = tests::madeRtt(1, kViews, kWidth, kHeight, 1);
  std::vector<float> heights;
  for (const formats::RttLevel& level : formats::rttLevels(kWidth, kHeight))
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        for (int view = 0; view < kViews * kViews; ++view) {
          // A wall 0.2 high on the left half, seen over a floor at 0: from the left it hides the floor beside it.
          const Vec3 towards = hemisphereCell(kViews, view % kViews, view / kViews);
          const double u = (x + 0.5) / level.width, top = u + 0.2 * towards.x() / towards.z();
          heights.push_back(top - std::floor(top) < 0.5 ? 0.2F : 0.0F);
        }
  rtt.heights = formats::encodeTable(heights, 1, formats::Precision::kFloat32, "made", "heights");
  const PatchLookup lookup(rtt, nullptr);
  const formats::RttLevel& finest = lookup.finestLevel();
  int settled = 0, hidden = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec3 eye = Vec3(-0.55, 0.05, 1).normalized();
    const Float2 place = {static_cast<float>((i + 0.5) / 100), 0.5F};
    float total = 0, least = 1, most = 0;
    for (const PatchLookup::View& view : lookup.viewsAt(finest, place, eye)) {
      total += view.weight;
      least = std::min(least, view.weight), most = std::max(most, view.weight);
    }
    EXPECT_NEAR(total, 1, 1e-6);
    // Between these cells no view's share by the grid alone is below a hundredth.
    hidden += least < 2e-3F && most > 0.1F, settled += least > 0.01F;
  }
  EXPECT_GT(hidden, 2);
  EXPECT_GT(settled, 60);
}

TEST(PatchLookup, RefusesTablesOfAnotherSize) {
  RttReflection rtt = raisedPlane(0.1);
  rtt.heights->rows -= 1;
  rtt.heights->data = formats::Bytes(rtt.heights->rows * 4);
  EXPECT_THROW(PatchLookup(rtt, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
