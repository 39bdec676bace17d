// Media that reflect what the surface's colors say.
#include <gtest/gtest.h>

#include <limits>

#include "formats/error.h"
#include "tests/support/shapes.h"
#include "tests/unit/kernels/uneven_plate.h"
#include "tools/kernels/fallback.h"

namespace bakelight::kernels {
namespace {

using formats::Float3;

formats::Medium ofAlbedo(double mean_free_path) {
  formats::Medium medium = tests::mediumOf(mean_free_path);
  medium.reflectance = formats::ReflectanceSource::kAlbedo;
  return medium;
}

struct Painted : Plate {
  template <class Color>
  explicit Painted(const Color& color) {
    for (const Float3& p : mesh.positions) mesh.colors.push_back(color(p));
  }
};

// Squares of 16 texels, as soft as triangles are; colors differ.
Float3 checkered(const Float3& p) {
  const bool dark = (static_cast<int>(p[0] / 16) + static_cast<int>(p[2] / 16)) % 2 == 1;
  return dark ? Float3{0.15F, 0.3F, 0.7F} : Float3{0.85F, 0.7F, 0.75F};
}

double relativeError(const std::vector<Rgb>& found, const std::vector<Rgb>& expected) {
  double difference = 0, squares = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    difference += static_cast<double>((found[k] - expected[k]).square().sum());
    squares += static_cast<double>(expected[k].square().sum());
  }
  return std::sqrt(difference / squares);
}

TEST(PaintedPlate, OfOneColorIsTheUniformMedium) {
  const Float3 color = {0.3F, 0.5F, 0.85F};
  const Painted plate([&](const Float3&) { return color; });
  const formats::Medium painted = ofAlbedo(1.5);
  formats::Medium uniform = tests::mediumOf(1.5);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto own = transport::coefficientsOfReflectance(
        uniform.model, static_cast<double>(color[c]),
        static_cast<double>(uniform.reduced_scattering[c]) + static_cast<double>(uniform.absorption[c]),
        uniform.eta);
    uniform.reduced_scattering[c] = static_cast<float>(own.reduced_scattering);
    uniform.absorption[c] = static_cast<float>(own.absorption);
  }
  const auto expected = responseOf(plate.made(uniform), 20), found = responseOf(plate.made(painted), 20);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t r = 0; r < found.size(); ++r)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[r][c], expected[r][c], 1e-4);
}

TEST(PaintedPlate, HalvesHaveTheirReflectance) {
  const Float3 left = {0.2F, 0.4F, 0.55F}, right = {0.5F, 0.1F, 0.55F};
  const Painted plate([&](const Float3& p) { return p[0] < (kTexels - 4) / 2.0F ? left : right; });
  const formats::Translucency made = plate.made(ofAlbedo(0.7));
  const auto found = responseOf(made, 0);
  const auto receivers = formats::wordsOf(made.receivers), texels = formats::wordsOf(made.texels);
  int seen = 0;
  for (std::size_t r = 0; r < receivers.size(); ++r) {
    const int x = static_cast<int>(texels[receivers[r]] % kTexels),
              y = static_cast<int>(texels[receivers[r]] / kTexels);
    if (std::abs(y - kTexels / 2) > 20 || std::min(std::abs(x - 26), std::abs(x - 74)) > 2) continue;
    ++seen;
    for (std::size_t c = 0; c < 3; ++c) {
      const float expected = (x < kTexels / 2 ? left : right)[c];
      EXPECT_NEAR(found[r][c] / expected, 1, 0.01) << x << " " << y << " " << c;
    }
  }
  EXPECT_GT(seen, 300);
}

TEST(PaintedPlate, IsTheSumOverAllWays) {
  const Painted plate(checkered);
  const formats::Medium medium = ofAlbedo(1.5);
  const formats::Translucency made = plate.made(medium);
  EXPECT_LT(errorOf(plate, made, medium, 0), 0.015);
  EXPECT_LT(errorOf(plate, made, medium, 20), 0.02);
  // What colors change is far more than that.
  const Painted plain([](const Float3&) { return Float3{0.5F, 0.5F, 0.72F}; });
  EXPECT_GT(errorOf(plate, plain.made(medium), medium, 0), 0.1);
}

// By way of far points, too.
TEST(PaintedPlate, FarKnotsGiveWhatPairsGive) {
  formats::TriangleMesh mesh = tests::plateMesh(175, 4.4);
  for (const Float3& p : mesh.positions) {
    const Float3 color = checkered(p);
    mesh.colors.push_back({0.9F + color[0] / 10, 0.95F + color[1] / 20, 0.97F + color[2] / 40});
  }
  const transport::MediumField field(ofAlbedo(1.5), mesh);
  Knots knots = knotsOf(mesh);
  Texels none;
  takeSurroundings(field, mesh, knots, none);
  const Reflectance reflectance(field, 400, 1, 1.01);
  const Throughput pairs(knots, reflectance, {.threshold = 0, .hierarchical = false}),
      far(knots, reflectance, {.threshold = 0});
  ASSERT_GT(far.farCount(), 50U);
  std::vector<Rgb> power;
  for (std::size_t k = 0; k < knots.count(); ++k)
    power.push_back(Rgb::Constant(knots.positions[k].x() > 100 ? 0 : static_cast<float>(knots.areas[k])));
  const auto expected = pairs.respond(power), found = far.respond(power);
  EXPECT_LT(relativeError(found, expected), 0.005);
  EXPECT_NE(found[0][0], expected[0][0]);

  // What one end sends to the other, it gets from there.
  for (std::size_t i = 0; i < knots.count(); i += 7) {
    const auto row = Knots::row(far.near().columns, far.near().ends, i);
    const std::size_t first = static_cast<std::size_t>(row.data() - far.near().columns.data());
    for (std::size_t e = 0; e < row.size(); ++e) {
      const auto back = Knots::row(far.near().columns, far.near().ends, row[e]);
      const auto there = std::lower_bound(back.begin(), back.end(), i);
      ASSERT_TRUE(there != back.end() && *there == i);
      const auto other = static_cast<std::size_t>(&*there - far.near().columns.data());
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(far.near().values[3 * (first + e) + c], far.near().values[3 * other + c], 1e-8F);
    }
  }
}

TEST(PaintedPlate, BlackAndWhiteAreClampedAndNoNumberIsRefused) {
  Painted plate([](const Float3& p) { return p[0] < 48 ? Float3{0, 0, 0} : Float3{1, 1, 2}; });
  const auto make = [&] {
    return makeTranslucency(plate.mesh, plate.folder / "maps.exr", ofAlbedo(1.5), {},
                            stage::ProgressStyle::kNone);
  };
  const Made made = make();
  EXPECT_EQ(made.figures.clamped_reflectances, plate.mesh.vertexCount());
  std::array<double, 2> sums = {0, 0};
  const auto receivers = formats::wordsOf(made.translucency.receivers),
             texels = formats::wordsOf(made.translucency.texels);
  const auto found = responseOf(made.translucency, 0);
  for (std::size_t r = 0; r < found.size(); ++r) {
    const std::uint32_t x = texels[receivers[r]] % kTexels;
    for (const float value : found[r]) {
      ASSERT_TRUE(value > -0.02F && value < 1.01F) << value;
      if (x < 30) sums[0] += value;
      if (x > 70) sums[1] += value;
    }
  }
  EXPECT_LT(sums[0], 0.05 * sums[1]);
  EXPECT_GT(sums[1] / static_cast<double>(found.size()), 0.2);
  plate.mesh.colors[40][1] = std::numeric_limits<float>::quiet_NaN();
  try {
    make();
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("finite"), std::string::npos) << error.what();
  }
}

TEST(PaintedBall, FallsBackToTheMeanOfItsColors) {
  formats::TriangleMesh ball = tests::icosphere(4, 6);
  for (const Float3& p : ball.positions)
    ball.colors.push_back(p[0] < 0 ? Float3{0.2F, 0.5F, 0.9F} : Float3{0.6F, 0.5F, 0.1F});
  const formats::TranslucencyFallback fallback = fallbackOf(ball, ofAlbedo(1));
  const Float3 expected = {0.4F, 0.5F, 0.5F};
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(fallback.reflectance[c], expected[c], 0.01) << c;
}

}  // namespace
}  // namespace bakelight::kernels
