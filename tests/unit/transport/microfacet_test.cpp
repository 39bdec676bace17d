#include "transport/microfacet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "transport/directions.h"
#include "transport/gauss_legendre.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kWhite = Vec3::Ones();

Vec3 at(double cosine, double azimuth = 0) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

// ∫ over the hemisphere: by a lattice over it that knows nothing of the lobe.
template <class Integrand>
double overHemisphere(const Integrand& integrand) {
  static const std::vector<Vec3> directions = sphereDirections(100000);
  double sum = 0;
  for (const Vec3& s : directions)
    if (s.z() > 0) sum += integrand(s);
  return sum * 4 * kPi / static_cast<double>(directions.size());
}

double albedoOf(const Microfacets& facets, const Vec3& eye) {
  return overHemisphere([&](const Vec3& s) { return facets.brdf(s, eye)[0] * s.z(); });
}

// Along the normal nothing is masked and light leaves at twice the facet's angle, so that with t = tan²
// of that
//   E = ∫₀¹ α²/(α² + t)² · 2/(1 + √(1 + 4α²t/(1 − t)²)) dt;
// for alpha 1 the root is (1 + t)/(1 − t), and E = ∫ (1 − t)/(1 + t)² dt = 1 − ln 2.
double albedoAlongTheNormal(double alpha) {
  double sum = 0;
  for (double begin = 0, end = 1e-4; begin < 1; begin = end, end = std::min(2 * end, 1.0))
    for (const auto& [x, weight] : gaussLegendreRule(16)) {
      const double t = begin + (end - begin) * (1 + x) / 2, slope2 = alpha * alpha;
      const double fall = slope2 + t;
      sum += (end - begin) / 2 * weight * slope2 / (fall * fall) * 2 /
             (1 + std::sqrt(1 + 4 * slope2 * t / ((1 - t) * (1 - t))));
    }
  return sum;
}

TEST(Microfacets, LoseAlongTheNormalWhatTheClosedFormSays) {
  EXPECT_NEAR(albedoAlongTheNormal(1), 1 - std::numbers::ln2, 1e-9);
  for (const double roughness : {0.3, 0.5, 0.8, 1.0}) {
    const double expected = albedoAlongTheNormal(roughness * roughness);
    const Microfacets single(kWhite, roughness, false, false), multiple(kWhite, roughness, false, true);
    EXPECT_NEAR(albedoOf(single, Vec3::UnitZ()), expected, 5e-4) << roughness;
    EXPECT_NEAR(multiple.singleAlbedo(1), expected, 5e-4) << roughness;
  }
}

class MicrofacetShape : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(MicrofacetShape, WhiteFurnaceLosesNothingWithMultipleScattering) {
  const auto [roughness, cosine] = GetParam();
  const double lost = 1 - albedoOf(Microfacets(kWhite, roughness, false, false), at(cosine));
  EXPECT_GE(lost, -1e-3);
  const double left = albedoOf(Microfacets(kWhite, roughness, false, true), at(cosine));
  EXPECT_NEAR(left, 1, 0.001 + 0.01 * lost);
}

TEST_P(MicrofacetShape, NeverReflectMoreThanTheyReceive) {
  const auto [roughness, cosine] = GetParam();
  for (const double color : {0.04, 1.0})
    for (const bool multiple : {false, true})
      EXPECT_LE(albedoOf(Microfacets(color * kWhite, roughness, true, multiple), at(cosine)), 1.002)
          << color << multiple;
}

TEST_P(MicrofacetShape, DensityIsThatOfTheSamples) {
  const auto [roughness, cosine] = GetParam();
  const Vec3 eye = at(cosine, 0.4);
  const Microfacets facets(Vec3(0.9, 0.5, 0.2), roughness, true, false);
  double weights = 0, above = 0;
  Vec3 mean = Vec3::Zero(), expected_mean = Vec3::Zero();
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const double v = i * std::numbers::phi;
    const Vec3 incident = facets.sampleIncident(eye, (i + 0.5) / kCount, v - std::floor(v));
    ASSERT_NEAR(incident.norm(), 1, 1e-9);
    if (incident.z() <= 0) {
      EXPECT_EQ(facets.densityPerSr(incident, eye), 0);
      continue;
    }
    above += 1.0 / kCount;
    mean += incident / kCount;
    weights += facets.brdf(incident, eye)[1] * incident.z() / facets.densityPerSr(incident, eye) / kCount;
  }
  EXPECT_NEAR(overHemisphere([&](const Vec3& s) { return facets.densityPerSr(s, eye); }), above, 0.003);
  for (int axis = 0; axis < 3; ++axis)
    expected_mean[axis] =
        overHemisphere([&](const Vec3& s) { return facets.densityPerSr(s, eye) * s[axis]; });
  EXPECT_LT((mean - expected_mean).norm(), 0.004);
  const double reflected = overHemisphere([&](const Vec3& s) { return facets.brdf(s, eye)[1] * s.z(); });
  EXPECT_NEAR(weights, reflected, 0.003);
}

INSTANTIATE_TEST_SUITE_P(Cases, MicrofacetShape,
                         testing::Combine(testing::Values(0.3, 0.8, 1.0), testing::Values(0.1, 0.5, 1.0)));

TEST(Microfacets, AreReciprocal) {
  const std::vector<Vec3> directions = sphereDirections(80);
  for (const bool multiple : {false, true}) {
    const Microfacets facets(Vec3(0.9, 0.5, 0.2), 0.45, true, multiple);
    for (const Vec3& a : directions)
      for (const Vec3& b : directions) {
        const Vec3 value = facets.brdf(a, b);
        ASSERT_LT((value - facets.brdf(b, a)).norm(), 1e-12 * (1 + value.norm()));
        if (a.z() < 0 || b.z() < 0) {
          ASSERT_EQ(value, Vec3::Zero());
        }
      }
  }
}

TEST(Microfacets, FresnelRisesToOne) {
  const Microfacets with(0.04 * kWhite, 0.3, true, false), without(0.04 * kWhite, 0.3, false, false);
  EXPECT_NEAR(with.facetReflectance(1)[0], 0.04, 1e-12);
  EXPECT_NEAR(with.facetReflectance(0)[0], 1, 1e-12);
  EXPECT_NEAR(with.facetReflectance(0.5)[0], 0.04 + 0.96 / 32, 1e-12);
  EXPECT_EQ(without.facetReflectance(0)[0], 0.04);
}

// The mean of multiple scattering over all light is what single scattering leaves, coloured once more a
// bounce.
TEST(Microfacets, ColorOfMultipleScatteringIsThatOfTwoBouncesAndMore) {
  const Microfacets white(kWhite, 0.9, false, true), gray(0.5 * kWhite, 0.9, false, true);
  EXPECT_NEAR(white.multipleColor()[0], 1, 1e-9);
  EXPECT_LT(gray.multipleColor()[0], 0.25) << "two bounces or more";
  EXPECT_GT(gray.multipleColor()[0], 0.1);
}

TEST(Microfacets, OfNoRoughnessAreAMirror) {
  EXPECT_TRUE(Microfacets(kWhite, 0, true, true).isMirror());
  EXPECT_FALSE(Microfacets(kWhite, 0.001, true, true).isMirror());
  // Nearly one: every sample is next to the mirrored direction, and none is lost.
  const Microfacets polished(kWhite, 0.001, false, false);
  const Vec3 eye = at(0.6);
  for (int i = 0; i < 50; ++i) {
    const Vec3 incident = polished.sampleIncident(eye, (i + 0.5) / 50, 0.3);
    EXPECT_LT((incident - Vec3(-eye.x(), -eye.y(), eye.z())).norm(), 1e-3);
    EXPECT_NEAR(polished.brdf(incident, eye)[0] * incident.z() / polished.densityPerSr(incident, eye), 1,
                1e-3);
  }
}

}  // namespace
}  // namespace bakelight::transport
