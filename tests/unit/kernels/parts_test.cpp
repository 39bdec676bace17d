// Knots, far factors, components, and the file.
#include <gtest/gtest.h>

#include "formats/error.h"
#include "formats/part_tensors.h"
#include "tests/support/plate.h"
#include "tests/support/shapes.h"
#include "tools/kernels/compression.h"
#include "tools/kernels/fallback.h"
#include "tools/kernels/point_index.h"

namespace bakelight::kernels {
namespace {

TEST(Knots, HatsAndTheirRings) {
  const Knots knots = knotsOf(tests::icosphere(3));
  double area = 0;
  for (const double a : knots.areas) area += a;
  EXPECT_NEAR(area, 4 * std::numbers::pi, 0.1);
  for (std::size_t k = 0; k < knots.count(); ++k) {
    const auto ring = knots.ring(k);
    EXPECT_EQ(ring[0], k);
    EXPECT_TRUE(ring.size() == 6 || ring.size() == 7);
    float sum = 0;
    for (const float weight : knots.sharpeningOf(k)) sum += weight;
    EXPECT_NEAR(sum, 1, 1e-6F);
  }
}

TEST(Knots, CopiesAlongSeamsAreOne) {
  auto mesh = tests::icosphere(1);
  tests::append(mesh, tests::icosphere(1));
  EXPECT_EQ(knotsOf(mesh).count(), knotsOf(tests::icosphere(1)).count());
}

// By way of far knots as between any two.
TEST(Throughput, FarKnotsGiveWhatPairsGive) {
  const Knots knots = knotsOf(tests::icosphere(4, 10));
  formats::Medium medium = tests::mediumOf(0.8, 0.999);
  medium.absorption = {1e-3F, 2e-3F, 5e-3F};
  const transport::MediumField field(medium, formats::TriangleMesh());
  const Reflectance reflectance(field, 21, 0.1, 0.1);
  const Throughput pairs(knots, reflectance, {.threshold = 0, .hierarchical = false});
  const Throughput far(knots, reflectance, {.threshold = 0});
  ASSERT_GT(far.farCount(), 50U);
  EXPECT_LT(far.near().columns.size() + far.far().columns.size(), pairs.near().columns.size() / 3);
  std::vector<Rgb> power(knots.count(), Rgb::Zero());
  for (std::size_t k = 0; k < knots.count(); ++k)
    if (knots.positions[k].y() > 6) power[k] = Rgb::Constant(static_cast<float>(knots.areas[k]));
  const auto expected = pairs.respond(power), found = far.respond(power);
  double difference = 0, squares = 0;
  for (std::size_t k = 0; k < knots.count(); ++k) {
    difference += static_cast<double>((found[k] - expected[k]).square().sum());
    squares += static_cast<double>(expected[k].square().sum());
  }
  EXPECT_LT(std::sqrt(difference / squares), 0.004);
  EXPECT_GT(difference, 0);
}

TEST(Throughput, DroppedFactorsAreTold) {
  const Knots knots = knotsOf(tests::icosphere(4, 10));
  const transport::MediumField field(tests::mediumOf(0.8), formats::TriangleMesh());
  const Reflectance reflectance(field, 21, 0.1, 0.1);
  const Throughput all(knots, reflectance, {.threshold = 0, .hierarchical = false});
  const Throughput few(knots, reflectance, {.threshold = 1e-4, .hierarchical = false});
  EXPECT_LT(all.figures().dropped_share, 1e-5);  // what lies beyond the reach of factors
  EXPECT_LT(few.near().columns.size(), all.near().columns.size());
  std::vector<Rgb> power;
  for (const double area : knots.areas) power.push_back(Rgb::Constant(static_cast<float>(area)));
  const auto expected = all.respond(power), found = few.respond(power);
  double worst = 0;
  for (std::size_t k = 0; k < knots.count(); ++k)
    worst = std::max(worst, static_cast<double>((expected[k] - found[k]).maxCoeff()));
  EXPECT_GT(worst, 0);
  EXPECT_LE(worst, few.figures().dropped_share * 1.5);  // sharpening adds some
}

TEST(PointIndex, FindsWhatASearchOfAllFinds) {
  const auto mesh = tests::icosphere(3);
  std::vector<Vec3> points;
  for (const auto& p : mesh.positions) points.push_back(transport::vec3(p));
  const PointIndex index(points);
  std::vector<std::uint32_t> found;
  const Vec3 place(0.3, 0.8, 0.4);
  index.within(place, 0.5, found);
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if ((points[i] - place).norm() <= 0.5) expected.push_back(i);
  EXPECT_EQ(found, expected);
  EXPECT_GT(expected.size(), 10U);
  index.nearest(place, 7, found);
  ASSERT_EQ(found.size(), 7U);
  for (std::size_t i = 1; i < 7; ++i)
    EXPECT_LE((points[found[i - 1]] - place).norm(), (points[found[i]] - place).norm());
}

TEST(Compression, RowsOfLowRankAreExact) {
  std::vector<float> rows;
  for (int r = 0; r < 500; ++r)
    for (int c = 0; c < 20; ++c)
      rows.push_back(std::sin(0.1F * static_cast<float>(r)) * static_cast<float>(c) +
                     static_cast<float>(r % 7));
  const CompressedKernels compressed = compress(rows, 20, 1e-5);
  EXPECT_EQ(compressed.components, 2);
  for (std::size_t r = 0; r < 500; ++r)
    for (std::size_t c = 0; c < 20; ++c) {
      float sum = 0;
      for (std::size_t k = 0; k < 2; ++k) sum += compressed.weights[r * 2 + k] * compressed.basis[k * 20 + c];
      EXPECT_NEAR(sum, rows[r * 20 + c], 1e-3F);
    }
}

// Chords through a ball have a mean of 4/3 radii; a plate has no inside.
TEST(Fallback, ThicknessIsTheMeanChord) {
  EXPECT_NEAR(meanThickness(tests::icosphere(5, 3)), 4, 0.01);
  EXPECT_EQ(meanThickness(tests::plateMesh(24, 4.4, 7)), 0);
}

// A ball of 4 mm across in the mean, in units of half a millimetre.
TEST(Fallback, IsWhatALayerOfTheMediumDoes) {
  formats::Medium medium;
  medium.reduced_scattering = {2, 4, 2};
  medium.absorption = {0, 0, 0.5F};
  medium.eta = 1;
  medium.unit_mm = 0.5;
  const formats::TranslucencyFallback fallback = fallbackOf(tests::icosphere(5, 6), medium);
  EXPECT_NEAR(fallback.thickness, 8, 0.02F);
  const double red = (5.0 / 3) / (8 + 4.0 / 3), green = (5.0 / 3) / (16 + 4.0 / 3);  // in mean free paths
  EXPECT_NEAR(fallback.transmission, red, 0.002);
  EXPECT_EQ(fallback.transmission_color[0], 1);
  EXPECT_NEAR(fallback.transmission_color[1], green / red, 0.003);
  EXPECT_EQ(fallback.reflectance[0], 1);
  EXPECT_EQ(fallback.attenuation[1], 0);
  // The dipole's total, and what a layer of 10 mean free paths lets through.
  const double albedo = 0.8, s = std::sqrt(3 * (1 - albedo));
  EXPECT_NEAR(fallback.reflectance[2], albedo / 2 * (1 + std::exp(-4.0 / 3 * s)) * std::exp(-s), 1e-6);
  // What is scattered, and what is not.
  const double through =
      albedo * std::cosh(s * 2 / 3) * std::sinh(s * 5 / 3) / std::sinh(s * (10 + 4.0 / 3)) + std::exp(-10);
  EXPECT_NEAR(fallback.transmission * fallback.transmission_color[2] *
                  std::exp(-fallback.attenuation[2] * fallback.thickness) / through,
              1, 0.02);
}

TEST(KernelsFile, ComesBackAsItWas) {
  Made made = tests::kernelsOf(tests::plateMesh(24, 4.4), 24, tests::mediumOf(2));
  made.translucency.fallback.attenuation = {0.1F, 1.0F / 3, 1e-9F};
  formats::PackPart part(made.translucency);
  formats::TensorFile file = formats::tensorsOf(part);
  formats::PackPart read{formats::Translucency()};
  formats::readPart(read, file, "file");
  EXPECT_EQ(formats::encodeSafetensors(formats::tensorsOf(read)), formats::encodeSafetensors(file));

  EXPECT_EQ(read.as<formats::Translucency>()->fallback.attenuation, made.translucency.fallback.attenuation);

  formats::TensorFile missing = file;
  missing.tensors.erase("near.values");
  EXPECT_THROW(formats::readPart(read, missing, "file"), Error);
  formats::TensorFile stray = file;
  stray.metadata["knotCount"] = "3";
  EXPECT_THROW(formats::readPart(read, stray, "file"), Error);
  formats::TensorFile other = file;
  other.metadata["part"] = "lambert";
  EXPECT_THROW(formats::readPart(read, other, "file"), Error);
}

}  // namespace
}  // namespace bakelight::kernels
