// What radiance transfer textures must be where that is known.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/patches.h"
#include "tools/rtt/rtt.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::rtt {
namespace {

using formats::RadianceTransferTexture;
using patch::PatchGeometry;

constexpr double kPi = std::numbers::pi;
const double kUniformSky = std::sqrt(4 * kPi);  // coefficient 0 of radiance 1 from everywhere

RadianceTransferTexture rendered(const PatchGeometry& geometry, const Options& options) {
  return makeRtt(geometry, options, [] {}).texture;
}

Options small(int resolution = 16, int views = 4) {
  Options options;
  options.resolution = options.elements = resolution;
  options.views = views;
  return options;
}

// Calls visit(column, row, x, y) for all texels of all views.
template <class Visit>
void forAll(const RadianceTransferTexture& texture, const Visit& visit) {
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column)
      for (int y = 0; y < texture.height; ++y)
        for (int x = 0; x < texture.width; ++x) visit(column, row, x, y);
}

struct Extremes {
  double least = 1e9, most = -1e9;
  void add(double value) { least = std::min(least, value), most = std::max(most, value); }
};

// Of all texels and views, under a uniform sky of 1.
Extremes underUniformSky(const RadianceTransferTexture& texture) {
  Extremes extremes;
  forAll(texture, [&](int column, int row, int x, int y) {
    extremes.add(kUniformSky * texture.response(column, row, x, y)[0]);
  });
  return extremes;
}

// ρ/π · {0.886227, 1.023327, 0.495416, 0, −0.110778} at m = 0.
double worstOfFlat(LightRule rule) {
  constexpr std::array<double, 5> kClosedForm = {0.886226925, 1.023326708, 0.495415912, 0, -0.110778365};
  const formats::Float3 albedo = {1, 0.5F, 0.25F};
  Options options = small(4, 3);
  options.light_rule = rule;
  const RadianceTransferTexture texture = rendered(tests::flatPatch(albedo), options);
  double worst = 0;
  forAll(texture, [&](int column, int row, int x, int y) {
    const auto response = texture.response(column, row, x, y);
    for (std::size_t c = 0; c < 3; ++c)
      for (int l = 0; l < 5; ++l)
        for (int m = -l; m <= l; ++m) {
          const double right = m == 0 ? albedo[c] / kPi * kClosedForm[static_cast<std::size_t>(l)] : 0;
          const double is = response[c * 25 + static_cast<std::size_t>(transport::coefficientIndex(l, m))];
          worst = std::max(worst, std::abs(is - right));
        }
  });
  return worst;
}

TEST(RttOfAFlatPatch, IsTheClampedCosineToRounding) {
  EXPECT_LT(worstOfFlat(LightRule::kGaussLegendre), 2e-7);
}

// 1.2e-2 of the coefficients before division by π.
TEST(RttOfAFlatPatch, ErrsByThePolarGridWithThePapersLights) {
  const double worst = kPi * worstOfFlat(LightRule::kPolar);
  EXPECT_GT(worst, 1e-3);
  EXPECT_LT(worst, 1.3e-2);
}

// White, closed, all bounces. What a texel lacks of 1 is the quadrature's error of the 128 lights on tilted surfaces
// (up to 1 % where they see the whole sky), which bounces make up for elsewhere.
TEST(RttFurnace, WhiteHeightFieldIsAsBrightAsItsSky) {
  for (const double depth : {0.05, 0.3, 1.5}) {
    const PatchGeometry geometry = tests::heightPatch(24, depth, tests::waves);
    const Extremes found = underUniformSky(rendered(geometry, small()));
    EXPECT_GT(found.least, 0.985) << depth;
    EXPECT_LT(found.most, 1.015) << depth;
  }
}

TEST(RttFurnace, WhitePitsOfADeepFieldToo) {
  const PatchGeometry geometry = tests::heightPatch(
      24, 1, [](double x, double y) { return std::hypot(x - 0.5, y - 0.5) < 0.3 ? 0.0 : 1.0; });
  const Extremes found = underUniformSky(rendered(geometry, small()));
  EXPECT_GT(found.least, 0.98);
  EXPECT_LT(found.most, 1.02);
}

// Inside of the sphere the radiance is ρ f / (1 − ρ(1 − f)) everywhere, on the plate around it, which sees the sky
// alone, ρ. Each point sees the hole through 128 lights' directions, so single texels scatter about it.
TEST(RttOfASphericalDimple, IsThatOfTheCavity) {
  struct Case {
    double open;
    float albedo;
  };
  for (const auto& [open, albedo] : {Case{0.25, 0.5F}, Case{0.1, 0.9F}, Case{0.25, 0.999F}, Case{0.1, 1}}) {
    Options options = small(32, 1);
    options.bounce_directions = 512;
    const double hole = 0.2;
    const RadianceTransferTexture texture =
        rendered(tests::dimple(open, hole, 48, {albedo, albedo, albedo}), options);
    double inside = 0;
    int count = 0;
    Extremes plate;
    forAll(texture, [&](int, int, int x, int y) {
      const double radius = std::hypot((x + 0.5) / 32 - 0.5, (y + 0.5) / 32 - 0.5);
      const double radiance = kUniformSky * texture.response(0, 0, x, y)[0];
      if (radius < hole - 0.04) inside += radiance, ++count;
      if (radius > hole + 0.07) plate.add(radiance);
    });
    const double right = albedo * open / (1 - albedo * (1 - open));
    EXPECT_NEAR(inside / count, right, 0.03 * right) << open << " " << albedo;
    EXPECT_NEAR(plate.least, albedo, 1e-5) << open << " " << albedo;
    EXPECT_NEAR(plate.most, albedo, 1e-5) << open << " " << albedo;
  }
}

// A patch that is turned counter-clockwise by a quarter: so are its texels, its views, and the light that it answers to.
// Root mean square of the difference ÷ that of the values.
double errorOfQuarterTurn(const Options& options) {
  constexpr int kSide = 20;
  const PatchGeometry patch = tests::heightPatch(kSide, 0.3, tests::waves);
  const PatchGeometry turned =
      tests::heightPatch(kSide, 0.3, [](double x, double y) { return tests::waves(y, 1 - x); });
  const RadianceTransferTexture before = rendered(patch, options), after = rendered(turned, options);
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const transport::ShRotation rotation(options.order, turn);
  const int last = options.views - 1, edge = options.resolution - 1;
  double squares = 0, differences = 0;
  forAll(before, [&](int column, int row, int x, int y) {
    // (x right, y down): the right side goes to the top, so a texel's x becomes its height.
    const auto source = before.response(column, row, x, y);
    const auto found = after.response(last - row, column, y, edge - x);
    std::vector<double> red(source.begin(), source.begin() + 25), rotated(25);
    rotation.apply(red, rotated);
    for (std::size_t i = 0; i < 25; ++i)
      squares += rotated[i] * rotated[i], differences += std::pow(rotated[i] - found[i], 2);
  });
  return std::sqrt(differences / squares);
}

TEST(RttOfATurnedPatch, IsTheTurnedOne) {
  Options options = small(20, 4);
  options.bounces = 0;
  // A ray or two that graze the surface go one way or the other.
  EXPECT_LT(errorOfQuarterTurn(options), 3e-3);
  // What bounces is looked for in directions that a quarter turn does not map onto themselves.
  options.bounces = {};
  EXPECT_LT(errorOfQuarterTurn(options), 1e-2);
}

TEST(Rtt, HasTheSameBytesWithAnyNumberOfThreads) {
  const PatchGeometry geometry = tests::heightPatch(20, 0.4, tests::waves, {0.9F, 0.5F, 0.3F});
  std::vector<RadianceTransferTexture> made;
  for (const std::size_t threads : {1, 2}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    made.push_back(rendered(geometry, small()));
  }
  EXPECT_EQ(made[0].values, made[1].values);
}

}  // namespace
}  // namespace bakelight::rtt
