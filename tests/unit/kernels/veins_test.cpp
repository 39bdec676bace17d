// A plate whose medium varies: against the sum of R_d over all texels, each by what its way has.
#include <gtest/gtest.h>

#include "formats/error.h"
#include "tests/unit/kernels/uneven_plate.h"

namespace bakelight::kernels {
namespace {

formats::Medium veinedMedium() {
  formats::Medium medium = tests::mediumOf(1.5, 0.98);
  medium.veins = formats::Veins{{0.4F, 0.5F, 0.6F}, {0.1F, 0.05F, 0.02F}, 40, 10, 2};
  return medium;
}

TEST(PlateWithVeins, IsTheSumOverAllWays) {
  const Plate plate;
  const formats::Translucency translucency = plate.made(veinedMedium());
  EXPECT_LT(errorOf(plate, translucency, veinedMedium(), 0), 0.012);
  EXPECT_LT(errorOf(plate, translucency, veinedMedium(), 20), 0.02);
  // What veins change is far more than that.
  formats::Medium plain = veinedMedium();
  plain.veins.reset();
  EXPECT_GT(errorOf(plate, plate.made(plain), veinedMedium(), 0), 0.1);
}

// By way of far points, too, whose ways are others than the knots'.
TEST(PlateWithVeins, FarKnotsGiveWhatPairsGive) {
  formats::Medium medium = veinedMedium();
  medium.absorption = {1e-5F, 2e-5F, 4e-5F};
  medium.veins->absorption = {1e-4F, 2e-4F, 3e-4F};
  medium.veins->reduced_scattering = {0.2F, 0.25F, 0.3F};
  const formats::TriangleMesh mesh = tests::plateMesh(200, 4.4);
  const Knots knots = knotsOf(mesh);
  const transport::MediumField field(medium, mesh.positions);
  const Reflectance reflectance(field, 400, 1, 1.01);
  const Throughput pairs(knots, reflectance, {.threshold = 0, .hierarchical = false}),
      far(knots, reflectance, {.threshold = 0});
  ASSERT_GT(far.farCount(), 50U);
  std::vector<Rgb> power;
  for (const double area : knots.areas) power.push_back(Rgb::Constant(static_cast<float>(area)));
  for (std::size_t k = 0; k < knots.count(); ++k)
    if (knots.positions[k].x() > 100) power[k].setZero();
  const auto expected = pairs.respond(power), found = far.respond(power);
  double difference = 0, squares = 0;
  for (std::size_t k = 0; k < knots.count(); ++k) {
    difference += static_cast<double>((found[k] - expected[k]).square().sum());
    squares += static_cast<double>(expected[k].square().sum());
  }
  EXPECT_LT(std::sqrt(difference / squares), 0.005);
  EXPECT_GT(difference, 0);
}

TEST(PlateWithVeins, VeinsOfTheSameMediumAreNone) {
  const Plate plate;
  formats::Medium plain = tests::mediumOf(1.5, 0.98), veined = plain;
  veined.veins = formats::Veins{plain.reduced_scattering, plain.absorption, 40, 10, 2};
  const auto expected = responseOf(plate.made(plain), 20), found = responseOf(plate.made(veined), 20);
  ASSERT_EQ(expected.size(), found.size());
  ASSERT_GT(expected.size(), 5000U);
  for (std::size_t r = 0; r < found.size(); ++r)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[r][c], expected[r][c], 2e-3);
}

TEST(PlateWithVeins, ThinVeinsAreRefused) {
  const Plate plate;
  formats::Medium medium = veinedMedium();
  medium.veins->width = 0.01;
  try {
    plate.made(medium);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("veins"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace bakelight::kernels
