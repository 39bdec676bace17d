#include "tools/brdf/brdf.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <stdexcept>

#include "formats/file.h"
#include "transport/directions.h"
#include "transport/sh.h"

namespace bakelight::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kWhite = Vec3::Ones(), kBlack = Vec3::Zero();

// Lambert plus microfacets with Fresnel's term.
Brdf coated(const Vec3& diffuse_color, const Vec3& specular_color, double roughness) {
  const Brdf facets = ggx(transport::Microfacets(specular_color, roughness, true, false));
  return [diffuse_color, facets](const Vec3& incident, const Vec3& outgoing) -> Vec3 {
    return diffuse_color / kPi + facets(incident, outgoing);
  };
}

// Lambert's row is the clamped cosine over π, whatever the eye: A_l/π · y_l0(z).
TEST(BrdfProjection, OfLambertIsTheClampedCosine) {
  const int order = 10;
  const Projection projection = project(lambert(Vec3(1, 0.5, 0)), order, 5);
  const std::vector<double> cosine = transport::clampedCosineFactors(order);
  const std::size_t count = transport::coefficientCount(order);
  for (int angle = 0; angle < 5; ++angle)
    for (std::size_t c = 0; c < 3; ++c)
      for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m) {
          const double expected = m != 0 ? 0
                                         : (1 - 0.5 * static_cast<double>(c)) * cosine[l] / kPi *
                                               std::sqrt((2 * l + 1) / (4 * kPi));
          EXPECT_NEAR(projection.table.values[(angle * 3 + c) * count + transport::coefficientIndex(l, m)],
                      expected, 1e-7)
              << "angle " << angle << ", band " << l << ", m " << m;
        }
  for (const Vec3& albedo : projection.albedo) EXPECT_LT((albedo - Vec3(1, 0.5, 0)).norm(), 1e-12);
  EXPECT_LT(projection.residual, 1e-8);
}

TEST(BrdfProjection, AlbedoIsTheConstantCoefficient) {
  const Projection projection = project(coated(0.2 * kWhite, 0.5 * kWhite, 0.5), 4, 9);
  for (int angle = 0; angle < 9; ++angle)
    EXPECT_NEAR(projection.table.values[angle * 3 * 16] * std::sqrt(4 * kPi), projection.albedo[angle][0],
                1e-6);
}

// Seen along the normal, Phong's lobe is zonal: coefficients by one integral over the cosine.
TEST(BrdfProjection, OfPhongAlongTheNormalEqualsAnIntegralOverTheCosine) {
  const int order = 6;
  for (const double exponent : {0.0, 5.0, 200.0, 1e5}) {
    const Projection projection = project(phong(kBlack, kWhite, exponent), order, 3);
    for (int l = 0; l < order; ++l) {
      // ∫ 2π (n+2)/2π t^(n+1) y_l0(t) dt, by midpoints in t^(n+2).
      double expected = 0;
      constexpr int kSamples = 20000;
      for (int sample = 0; sample < kSamples; ++sample) {
        const double t = std::pow((sample + 0.5) / kSamples, 1 / (exponent + 2));
        expected += std::sqrt((2 * l + 1) / (4 * kPi)) * transport::legendre(order, t)[l] / kSamples;
      }
      EXPECT_NEAR(projection.table.values[2 * 3 * 36 + transport::coefficientIndex(l, 0)], expected, 1e-6)
          << "exponent " << exponent << ", band " << l;
    }
  }
}

// The quadrature against a lattice over the sphere that knows nothing of the lobe, for an oblique eye.
TEST(BrdfProjection, OfAnObliqueEyeEqualsALatticeSum) {
  const int order = 5, angles = 5;
  const Brdf brdf = coated(0.3 * kWhite, Vec3(0.9, 0.6, 0.3), 0.7);
  const Projection projection = project(brdf, order, angles);
  const Vec3 eye(std::sqrt(1 - 0.25), 0, 0.5);
  std::vector<double> sums(3 * 25);
  const std::vector<Vec3> lattice = transport::sphereDirections(400000);
  for (const Vec3& s : lattice) {
    if (s.z() <= 0) continue;
    const Vec3 value = brdf(s, eye) * s.z() * 4 * kPi / static_cast<double>(lattice.size());
    const std::vector<double> y = transport::evaluateSh(order, s);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < 25; ++i) sums[c * 25 + i] += value[c] * y[i];
  }
  for (std::size_t i = 0; i < sums.size(); ++i)
    EXPECT_NEAR(projection.table.values[2 * 75 + i], sums[i], 2e-5) << "coefficient " << i;
}

TEST(Brdf, IsReciprocalAndIsotropic) {
  const std::vector<Vec3> directions = transport::sphereDirections(60);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vec3::UnitZ()).toRotationMatrix();
  int compared = 0;
  for (const Brdf& brdf : {lambert(0.5 * kWhite), phong(0.2 * kWhite, 0.7 * kWhite, 12),
                           coated(0.1 * kWhite, Vec3(0.8, 0.5, 0.2), 0.3)})
    for (const Vec3& a : directions)
      for (const Vec3& b : directions) {
        if (a.z() <= 0 || b.z() <= 0) continue;
        ++compared;
        const Vec3 value = brdf(a, b);
        ASSERT_LT((value - brdf(b, a)).norm(), 1e-9 * (1 + value.norm()));
        ASSERT_LT((value - brdf(turn * a, turn * b)).norm(), 1e-9 * (1 + value.norm()));
      }
  EXPECT_GT(compared, 1000);
}

TEST(Brdf, NeverReflectsMoreThanItReceives) {
  for (const double roughness : {0.05, 0.2, 0.5, 1.0})
    for (const Vec3& albedo : project(coated(kBlack, kWhite, roughness), 3, 9).albedo)
      EXPECT_LE(albedo.maxCoeff(), 1 + 1e-6) << "roughness " << roughness;
  for (const double exponent : {0.0, 10.0, 1e4})
    for (const Vec3& albedo : project(phong(0.4 * kWhite, 0.6 * kWhite, exponent), 3, 9).albedo)
      EXPECT_LE(albedo.maxCoeff(), 1 + 1e-6) << "exponent " << exponent;
}

// A smooth white metal loses next to nothing between its facets.
TEST(Brdf, GgxOfAWhiteMetalKeepsItsEnergy) {
  const Projection projection = project(coated(kBlack, kWhite, 0.1), 3, 5);
  for (int angle = 1; angle < 5; ++angle) EXPECT_NEAR(projection.albedo[angle][0], 1, 0.01) << angle;
  EXPECT_LT(projection.residual, 1e-5);
}

// What a lobe returns of a constant sky is its colour where none of it is below the surface.
TEST(Brdf, OfAMaterialIsWhatTheReferenceTraces) {
  const Projection lobe = project(reflection(formats::PhongReflection{{0.5F, 0.25F, 1}, 200}), 3, 3);
  EXPECT_LT((lobe.albedo[2] - Vec3(0.5, 0.25, 1)).norm(), 1e-5);
  const formats::GgxReflection ggx_reflection{{0.5F, 0.25F, 1}, 0.6, false, true};
  const transport::Microfacets facets(Vec3(0.5, 0.25, 1), 0.6, false, true);
  const Vec3 a = Vec3(0.3, 0.1, 0.8).normalized(), b = Vec3(-0.2, 0.5, 0.6).normalized();
  EXPECT_LT((reflection(ggx_reflection)(a, b) - facets.brdf(a, b)).norm(), 1e-12);
  EXPECT_EQ(reflection(formats::Lambert())(a, b), Vec3::Zero());
  EXPECT_NEAR(project(reflection(formats::GgxReflection{.roughness = 0}), 5, 4).albedo[3][0], 0.2, 1e-3)
      << "nearly a mirror";
  EXPECT_THROW(reflection(formats::TableReflection()), std::invalid_argument);
}

TEST(BrdfProjection, GivesTheSameBytesWithAnyNumberOfThreads) {
  const Brdf brdf = coated(0.1 * kWhite, 0.5 * kWhite, 0.4);
  std::vector<float> one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = project(brdf, 4, 8).table.values;
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 5);
  EXPECT_EQ(project(brdf, 4, 8).table.values, one);
}

TEST(BrdfProjection, RefusesWhatIsNotFinite) {
  EXPECT_THROW(project([](const Vec3&, const Vec3&) -> Vec3 { return kWhite / 0.0; }, 3, 4),
               std::invalid_argument);
  EXPECT_THROW(project(lambert(kWhite), 3, 1), std::invalid_argument);
  EXPECT_THROW(coated(kBlack, kWhite, 0), std::invalid_argument);
}

TEST(BrdfTool, WritesTheTableThatPackReads) {
  const std::filesystem::path folder = testing::TempDir() + "brdf_tool_test";
  std::filesystem::remove_all(folder);
  const std::filesystem::path table = folder / "table.safetensors";
  formats::writeFileAtomically(folder / "m.json", std::string(R"({ "albedo": [1, 1, 1], "reflection":
      { "model": "ggx", "roughness": 0.4, "specular_color": [0.5, 0.4, 0.3], "fresnel": true } })"));
  const std::string command = std::string(BAKELIGHT_BIN_DIR) + "/brdf --progress none --table " +
                              table.string() + " --order 4 --angles 6 --material ";
  ASSERT_EQ(std::system((command + (folder / "m.json").string()).c_str()), 0);
  const formats::TensorFile file = formats::readSafetensors(table);
  const auto values = file.require("brdf", formats::ElementType::kFloat32, 3, table).as<float>();
  const Projection expected = project(coated(kBlack, Vec3(0.5f, 0.4f, 0.3f), 0.4), 4, 6);
  EXPECT_TRUE(std::ranges::equal(values, expected.table.values));
  EXPECT_EQ(file.requireMetadata("order", table), "4");
  EXPECT_EQ(file.requireMetadata("frame", table), "local");
  EXPECT_EQ(file.requireMetadata("cosine", table), "inside");
  EXPECT_EQ(file.requireMetadata("basis", table), "real_sh_cartesian");

  const std::string wrong = command + (folder / "nowhere.json").string() + " 2> /dev/null";
  EXPECT_NE(std::system(wrong.c_str()), 0);
}

}  // namespace
}  // namespace bakelight::brdf
