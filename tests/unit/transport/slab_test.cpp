#include "transport/slab.h"

#include <gtest/gtest.h>
#include <cmath>
#include <stdexcept>

namespace bakelight::transport {
namespace {

// Index-matched and without absorption: (1 + 2/3) mean free paths of source ÷ (thickness + 4/3).
TEST(Slab, LossIsInverseToThicknessWithoutAbsorption) {
  const SlabTransmission slab = slabTransmission({2, 0, 1}, 30);
  EXPECT_NEAR(slab.unabsorbed, (5.0 / 3) / (60 + 4.0 / 3), 1e-12);
  EXPECT_EQ(slab.attenuation, 0);
  // The better the boundary mirrors, the more goes through: A = (1 + F) ÷ (1 − F), F = 0.596346 for 1.5.
  const double beyond = 2 * 1.596346 / 0.403654 / 3;
  EXPECT_NEAR(slabTransmission({2, 0, 1.5}, 30).unabsorbed, (1 + beyond) / (60 + 2 * beyond), 1e-6);
}

TEST(Slab, ThickLayersAttenuateByDiffusionsRate) {
  const double rate = std::sqrt(3 * 0.1 * 2.1);
  // What is lost without absorption, some ln(thickness) ÷ thickness, is not counted as attenuation.
  EXPECT_NEAR(slabTransmission({2, 0.1, 1.3}, 1e4).attenuation / rate, 1, 2e-3);
  const SlabTransmission endless = slabTransmission({2, 0.1, 1.3}, 1e9);  // e^−8e8 is no number
  EXPECT_NEAR(endless.attenuation / rate, 1, 1e-6);
  EXPECT_GT(endless.unabsorbed, 0);
}

// Light that meets nothing; what little is absorbed goes by σa along its way.
TEST(Slab, ThinLayersLetAllThrough) {
  EXPECT_NEAR(slabTransmission({1, 0.5, 1}, 1e-4).unabsorbed, 1, 1e-4);
  EXPECT_NEAR(slabTransmission({1, 0.5, 1}, 1e-9).unabsorbed, 1, 1e-8);
  EXPECT_NEAR(slabTransmission({1, 0.5, 1}, 1e-4).attenuation, 0.5, 0.5);
}

TEST(Slab, UnitsChangeNothing) {
  const SlabTransmission one = slabTransmission({2, 0.1, 1.4}, 3),
                         other = slabTransmission({2e6, 1e5, 1.4}, 3e-6);
  EXPECT_NEAR(other.unabsorbed, one.unabsorbed, 1e-12);
  EXPECT_NEAR(other.attenuation, 1e6 * one.attenuation, 1e-3);
}

TEST(Slab, RefusesWhatIsNone) {
  EXPECT_THROW(slabTransmission({2, 0.1, 1.4}, 0), std::invalid_argument);
  EXPECT_THROW(slabTransmission({0, 1, 1.4}, 1), std::invalid_argument);
  EXPECT_THROW(slabTransmission({1, -1, 1.4}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
