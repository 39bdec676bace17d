#include "transport/diffusion.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "transport/gauss_legendre.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr DiffusionModel kModels[] = {DiffusionModel::kDipole, DiffusionModel::kBetterDipole,
                                      DiffusionModel::kNormalizedDiffusion};

// ∫ over r = 0–∞ of f, which falls on scales around `scale`: by decades, of which the first begin at 1e-7 of it.
template <class Function>
double radialIntegral(double scale, double end, Function f) {
  static const std::vector<QuadratureNode> rule = gaussLegendreRule(48);
  double sum = 0;
  std::vector<double> ends = {0};
  for (double r = scale * 1e-7; r < end; r *= 1.5) ends.push_back(r);
  ends.push_back(end);
  for (std::size_t i = 1; i < ends.size(); ++i)
    for (const QuadratureNode& node : rule) {
      const double half = (ends[i] - ends[i - 1]) / 2;
      sum += half * node.weight * f(ends[i - 1] + half * (node.x + 1));
    }
  return sum;
}

TEST(Fresnel, DiffuseReflectanceIsAsTabulatedAndNothingWithoutABoundary) {
  EXPECT_NEAR(2 * fresnelMoments(1 / 1.3).first, 0.444457, 1e-6);
  EXPECT_NEAR(2 * fresnelMoments(1 / 1.5).first, 0.596346, 1e-6);
  EXPECT_EQ(fresnelMoments(1).first, 0);
  EXPECT_EQ(fresnelMoments(1).second, 0);
  // The radiance theorem: what is reflected from inside and outside differ by η² alone.
  for (const double eta : {1.05, 1.3, 2.0})
    EXPECT_NEAR(1 - 2 * fresnelMoments(1 / eta).first, (1 - 2 * fresnelMoments(eta).first) / (eta * eta),
                1e-8);
  EXPECT_NEAR(fresnelReflectance(1, 1.5), 0.04, 1e-12);
  EXPECT_NEAR(schlickTransmittance(1, 1.5), 0.96, 1e-12);
  EXPECT_EQ(schlickTransmittance(0, 1.5), 0);
}

TEST(Fresnel, EnteringFactorsAreIntegralsOfTheirKernel) {
  const std::vector<double> factors = enteringCosineFactors(6, 1.5);
  constexpr int kSteps = 20000;
  for (int l = 0; l < 6; ++l) {
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = (i + 0.5) / kSteps;
      sum += 2 * kPi * std::legendre(static_cast<unsigned>(l), cosine) * cosine *
             schlickTransmittance(cosine, 1.5) / kSteps;
    }
    EXPECT_NEAR(factors[static_cast<std::size_t>(l)], sum, 1e-6) << l;
  }
}

// Summed over a square grid, shifted or not, it has R_d's frequency response up to half of what the grid carries, whatever the mean free path.
TEST(Diffusion, BandLimitedIsWhatAGridCarries) {
  for (const DiffusionModel model : kModels)
    for (const double path : {0.01, 0.5, 2.0}) {
      const DiffuseReflectance r(model, {0.95 / path, 0.05 / path, 1.3});
      for (const double k : {0.0, kPi / 8, kPi / 2})
        for (const double shift : {0.0, 0.37}) {
          double sum = 0;
          constexpr int kReach = 40;
          for (int y = -kReach; y <= kReach; ++y)
            for (int x = -kReach; x <= kReach; ++x) {
              const double u = x + shift, v = y + 0.6 * shift;
              const double distance = std::hypot(u, v);
              sum += std::cos(k * u) * (distance < 8 ? r.bandLimited(distance, 1) : r(distance));
            }
          EXPECT_NEAR(sum, r.frequencyResponse(k), 0.004 * r.total()) << path << " " << k << " " << shift;
        }
    }
}

TEST(Diffusion, TheDipolesTotalIsTheClosedForm) {
  const double f = 0.596346, offset = (1 + f) / (1 - f);
  for (const double absorption : {0.0021, 0.0041, 0.0071, 0.5}) {
    const ScatteringCoefficients c{2.19, absorption, 1.5};
    const double s = std::sqrt(3 * (1 - c.albedo()));
    EXPECT_NEAR(DiffuseReflectance(DiffusionModel::kDipole, c).total(),
                c.albedo() / 2 * (1 + std::exp(-4.0 / 3 * offset * s)) * std::exp(-s), 1e-6);
  }
  const ScatteringCoefficients marble{2.19, 0.0021, 1.5}, skin{0.74, 0.032, 1.3};
  EXPECT_NEAR(DiffuseReflectance(DiffusionModel::kDipole, marble).total(), 0.830, 1e-3);
  EXPECT_NEAR(DiffuseReflectance(DiffusionModel::kDipole, skin).total(), 0.436, 1e-3);
}

// All figures of all models are integrals of one function.
TEST(Diffusion, ClosedFormsAreTheIntegralsOfReflectance) {
  for (const DiffusionModel model : kModels)
    for (const double absorption : {0.0, 1e-9, 0.01, 3.0}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(model)) + " " + std::to_string(absorption));
      const DiffuseReflectance r(model, {2.0, absorption, 1.3});
      for (const double radius : {0.01, 0.7, 40.0}) {
        const double disk = radialIntegral(1, radius, [&](double x) { return 2 * kPi * x * r(x); });
        EXPECT_NEAR(r.enclosed(radius), disk, 1e-7 * disk) << radius;
        const double line = 2 * radialIntegral(1, 1e6, [&](double y) { return r(std::hypot(radius, y)); });
        EXPECT_NEAR(r.lineSpread(radius), line, 1e-5 * line) << radius;
      }
      // The Hankel transform through the line's spread: a cosine transform, here by a fine sum to where nothing is left.
      if (absorption < 1) continue;
      const double k = 2.5;
      const double cosine = 2 * radialIntegral(0.5, 30, [&](double x) {
                              return x > 0 ? r.lineSpread(x) * std::cos(k * x) : 0;
                            });
      EXPECT_NEAR(r.frequencyResponse(k), cosine, 1e-4 * r.total());
    }
}

TEST(Diffusion, WhatEntersLeavesWhereNothingIsAbsorbed) {
  for (const double scattering : {1e-6, 1.0, 1e6}) {
    const DiffuseReflectance dipole(DiffusionModel::kDipole, {scattering, 0, 1.5});
    EXPECT_NEAR(dipole.total(), 1, 1e-12);
    // The tail falls as 1/R.
    const double far = 1e4 / scattering;
    EXPECT_NEAR((1 - dipole.enclosed(2 * far)) / (1 - dipole.enclosed(far)), 0.5, 1e-3);
    const DiffuseReflectance better(DiffusionModel::kBetterDipole, {scattering, 0, 1.5});
    EXPECT_NEAR(better.total(), 1, 1e-8);
    const DiffuseReflectance nearly(DiffusionModel::kDipole, {scattering, scattering * 1e-9, 1.5});
    EXPECT_LT(nearly.total(), 1);
    EXPECT_GT(nearly.total(), 1 - 1e-3);
  }
}

// Scales of length do not matter.
TEST(Diffusion, UnitsScaleOut) {
  for (const DiffusionModel model : kModels)
    for (const double unit : {1e-9, 1e-3, 1e3, 1e9}) {
      const DiffuseReflectance here(model, {2, 0.05, 1.3}), there(model, {2 / unit, 0.05 / unit, 1.3});
      for (const double r : {0.001, 0.3, 5.0}) {
        EXPECT_NEAR(there(r * unit) * unit * unit / here(r), 1, 1e-12);
        EXPECT_NEAR(there.enclosed(r * unit) / here.enclosed(r), 1, 1e-12);
        EXPECT_NEAR(there.frequencyResponse(r / unit) / here.frequencyResponse(r), 1, 1e-12);
      }
    }
}

TEST(Diffusion, ARadiusEnclosesAllButAShare) {
  for (const DiffusionModel model : kModels) {
    const DiffuseReflectance r(model, {2.19, 0.0021, 1.5});
    const double radius = r.radiusFor(0.01);
    EXPECT_NEAR(r.enclosed(radius), 0.99 * r.total(), 1e-9);
  }
  const DiffuseReflectance white(DiffusionModel::kDipole, {1, 0, 1});
  EXPECT_GT(white.radiusFor(1e-5), 1e4);
}

TEST(Diffusion, CoefficientsOfAReflectanceHaveIt) {
  for (const auto model :
       {DiffusionModel::kDipole, DiffusionModel::kBetterDipole, DiffusionModel::kNormalizedDiffusion})
    for (const double eta : {1.0, 1.3, 1.8}) {
      double before = 0;
      for (const double reflectance : {1e-3, 0.01, 0.2, 0.5, 0.83, 0.99, 1 - 1e-6}) {
        const ScatteringCoefficients c = coefficientsOfReflectance(model, reflectance, 3.5, eta);
        EXPECT_NEAR(c.extinction(), 3.5, 1e-12);
        EXPECT_NEAR(DiffuseReflectance(model, c).total() / reflectance, 1, 1e-9) << reflectance;
        EXPECT_GT(c.albedo(), before);
        before = c.albedo();
      }
      EXPECT_EQ(coefficientsOfReflectance(model, 1, 3.5, eta).absorption, 0);
      EXPECT_EQ(coefficientsOfReflectance(model, 1.5, 3.5, eta).absorption, 0);
    }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double none : {0.0, -1.0, nan})
    EXPECT_THROW(coefficientsOfReflectance(DiffusionModel::kDipole, none, 1, 1.3), std::invalid_argument);
}

TEST(Diffusion, RefusesWhatIsNoMedium) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const ScatteringCoefficients c :
       {ScatteringCoefficients{0, 0, 1.3}, ScatteringCoefficients{-1, 1, 1.3},
        ScatteringCoefficients{1, -1e-9, 1.3}, ScatteringCoefficients{1, nan, 1.3},
        ScatteringCoefficients{1, 1, 0.9}, ScatteringCoefficients{1, 1, nan}})
    EXPECT_THROW(DiffuseReflectance(DiffusionModel::kDipole, c), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
