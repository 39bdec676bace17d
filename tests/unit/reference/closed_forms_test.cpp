// The path tracer against closed forms.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/spherical_cavity.h"
#include "tests/unit/reference/scenes.h"

namespace bakelight::tests {
namespace {

using namespace reference;

constexpr double kPi = std::numbers::pi;

// A convex body of albedo ρ under a uniform sky of 1 sends ρ everywhere.
class Furnace : public testing::TestWithParam<std::tuple<bool, float, At>> {};

TEST_P(Furnace, ConvexBodySendsItsAlbedo) {
  const auto [smooth, albedo, at] = GetParam();
  const TriangleMesh mesh = smooth ? icosphere(2) : flatShaded(icosphere(1));
  Options options = pictureOptions(40, 30, 256);
  options.at = at;
  const Reference made = render(surfaceOf(mesh, albedo), uniformRig(), options);
  const float expected_radiance = albedo;
  const auto statistics = compareWith(
      made.picture.image, [&](std::size_t) { return expected_radiance; }, [](std::size_t) { return 0.0; });
  EXPECT_GT(statistics.pixels, 300);
  EXPECT_LT(std::abs(statistics.mean_difference), 0.005 * albedo);
  EXPECT_GE(made.picture.report.samples, 256);
  EXPECT_LT(made.picture.report.relative_error, 0.06);  // there is a noise to compare with, and not much
  if (at == At::kPixels) {
    EXPECT_LT(std::abs(statistics.mean_z), 3);
    EXPECT_NEAR(statistics.chi_squared, 1, 0.35);
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, Furnace,
                         testing::Combine(testing::Bool(), testing::Values(1.0f, 0.4f),
                                          testing::Values(At::kPixels, At::kVertices, At::kLeastSquares)));

// Inside of a sphere that is open above. A vertex sees exactly f of the sky (Lambert's formula), of which it
// sends ρ f; with bounces it sends B / π whatever the vertex, but for how the sphere is cut into triangles.
class CavityRadiance : public testing::TestWithParam<float> {};

TEST_P(CavityRadiance, IsTheClosedForm) {
  const float albedo = GetParam();
  const Cavity cavity = sphericalCavity(0.25, 3);
  const Scene scene = sceneOf(surfaceOf(cavity.mesh, albedo), uniformRig());
  const double f = cavity.mean_open_fraction, back = albedo * (1 - f);
  double chi_squared = 0, full = 0, full_variance = 0, one = 0, one_variance = 0;
  int compared = 0;
  for (std::uint32_t v = 0; v < cavity.mesh.vertexCount(); v += 7) {
    if (cavity.open_fraction[v] < 0) continue;
    const ShadingPoint point = scene.pointAtVertex(v);
    const auto direct = estimate(scene, {.transport = Transport::kShadowed}, point, point.normal, 64, v);
    chi_squared +=
        std::pow(direct.luminance() - albedo * cavity.open_fraction[v], 2) / direct.luminanceVariance();
    const auto once = estimate(scene, {.bounces = 1}, point, point.normal, 64, v);
    one += once.luminance();
    one_variance += once.luminanceVariance();
    const auto all = estimate(scene, {}, point, point.normal, 64, v);
    full += all.luminance();
    full_variance += all.luminanceVariance();
    ++compared;
  }
  ASSERT_GT(compared, 50);
  EXPECT_NEAR(chi_squared / compared, 1, 0.6);
  // The mean of vertices' open fractions stands for that of the surface: to 0.5%, as for the bake.
  const auto tolerance = [&](double expected, double variance) {
    return 3 * std::sqrt(variance) / compared + 0.005 * expected;
  };
  const double expected_one = albedo * f * (1 + back);
  EXPECT_NEAR(one / compared, expected_one, tolerance(expected_one, one_variance));
  const double expected_full = albedo * f / (1 - back);
  EXPECT_NEAR(full / compared, expected_full, tolerance(expected_full, full_variance));
  EXPECT_LT(std::sqrt(full_variance) / full, 0.005);
  std::printf("rho %.1f: direct chi² %.2f, one bounce %+.3f%%, all %+.3f%% ± %.3f%%\n", albedo,
              chi_squared / compared, 100 * (one / compared / expected_one - 1),
              100 * (full / compared / expected_full - 1), 100 * std::sqrt(full_variance) / full);
}

INSTANTIATE_TEST_SUITE_P(Albedos, CavityRadiance, testing::Values(0.5f, 0.9f));

TEST(Cavity, ClosedIsDark) {
  const Scene scene = sceneOf(surfaceOf(insideOut(icosphere(2)), 1), uniformRig());
  const ShadingPoint point = scene.pointAtVertex(5);
  EXPECT_EQ(estimate(scene, {}, point, point.normal, 8).luminance(), 0);
}

// A disk of half angle a wholly above the horizon, at an angle θ to the normal, gives E = π sin² a cos θ.
class DiskLight : public testing::TestWithParam<Integrator> {};

TEST_P(DiskLight, IrradianceOnASphere) {
  const double half_angle = 0.35, albedo = 0.6;
  const Scene scene =
      sceneOf(surfaceOf(icosphere(2), static_cast<float>(albedo)), diskRig(half_angle * 180 / kPi, 2));
  int compared = 0;
  double chi_squared = 0;
  for (std::uint32_t v = 0; v < scene.mesh().vertexCount(); ++v) {
    const ShadingPoint point = scene.pointAtVertex(v);
    const double cosine = point.normal.y();
    const bool above = std::acos(cosine) + half_angle < kPi / 2 - 0.01;
    const bool below = std::acos(cosine) - half_angle > kPi / 2 + 0.01;
    if (!above && !below) continue;
    const auto means = estimate(scene, {.integrator = GetParam()}, point, point.normal,
                                GetParam() == Integrator::kMis ? 16 : 128, v);
    if (below) {
      EXPECT_EQ(means.luminance(), 0);
      continue;
    }
    const double expected = albedo / kPi * 2 * kPi * std::pow(std::sin(half_angle), 2) * cosine;
    chi_squared += std::pow(means.luminance() - expected, 2) / means.luminanceVariance();
    if (GetParam() == Integrator::kMis) {
      EXPECT_NEAR(means.luminance(), expected, 0.05 * expected) << v;
    }
    ++compared;
  }
  ASSERT_GT(compared, 30);
  EXPECT_NEAR(chi_squared / compared, 1, 0.8);
}

INSTANTIATE_TEST_SUITE_P(Integrators, DiskLight, testing::Values(Integrator::kMis, Integrator::kUniform));

TEST(DirectionalLight, IrradianceIsThatOfTheCosine) {
  formats::LightRig rig;
  rig.distant.emplace_back(formats::DirectionalLight{{0, 2, 0}, {3, 2, 1}});
  const Scene scene = sceneOf(surfaceOf(icosphere(2), 0.5f), rig);
  for (const auto integrator : {Integrator::kMis, Integrator::kUniform})
    for (std::uint32_t v = 0; v < 40; ++v) {
      const ShadingPoint point = scene.pointAtVertex(v);
      const auto means = estimate(scene, {.integrator = integrator}, point, point.normal, 2);
      EXPECT_NEAR(means.mean()[0], 0.5 / kPi * 3 * std::max(0.0, point.normal.y()), 1e-6);
      EXPECT_NEAR(means.mean()[2], 0.5 / kPi * 1 * std::max(0.0, point.normal.y()), 1e-6);
    }
}

// Irradiance of a polygon above the horizon, by Lambert's formula: E = L/2 Σ angle of edge × its normal · n.
double lambertIrradiance(const std::vector<Vec3>& corners, const Vec3& point, const Vec3& normal) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = (corners[i] - point).normalized(),
               b = (corners[(i + 1) % corners.size()] - point).normalized();
    const Vec3 across = a.cross(b);
    sum += std::atan2(across.norm(), a.dot(b)) * normal.dot(across.normalized());
  }
  return std::abs(sum) / 2;
}

class QuadEmitter : public testing::TestWithParam<std::tuple<Integrator, Transport>> {};

TEST_P(QuadEmitter, IrradianceIsLamberts) {
  const auto [integrator, transport] = GetParam();
  formats::LightRig rig;
  rig.object_units = false;
  formats::Emitter quad;
  quad.position = {0.2f, 0.7f, 0.1f};
  quad.normal = {0, 1, 0};  // its back shines down
  quad.width = 0.8;
  quad.height = 0.5;
  quad.radiance = {5, 5, 5};
  rig.emitters.push_back(quad);
  const Scene scene = sceneOf(surfaceOf(floorSquare(1), 0.7f), rig);
  std::vector<Vec3> corners;
  for (const auto& [x, z] : {std::pair(-0.4, -0.25), {0.4, -0.25}, {0.4, 0.25}, {-0.4, 0.25}})
    corners.emplace_back(0.2 + x, 0.7, 0.1 + z);
  // Width and height may lie either way.
  const auto emitters = transport::emitterMesh(rig, {}, 0);
  for (std::size_t i = 0; i < 4; ++i) corners[i] = vec3(emitters.mesh.positions[i]);

  const int batches = integrator == Integrator::kMis ? 32 : 512;
  for (const float u : {0.1f, 0.3f, 0.6f}) {
    transport::Hit hit;
    hit.valid = true;
    hit.u = u;
    hit.v = 0.3f;
    const ShadingPoint point = scene.pointAt(hit);
    const double expected = 0.7 / kPi * 5 * lambertIrradiance(corners, point.origin, point.normal);
    const auto means =
        estimate(scene, {.transport = transport, .integrator = integrator}, point, point.normal, batches);
    EXPECT_NEAR(means.luminance(), expected, 3.5 * standardError(means)) << u;
    EXPECT_LT(standardError(means), 0.05 * expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, QuadEmitter,
                         testing::Combine(testing::Values(Integrator::kMis, Integrator::kUniform),
                                          testing::Values(Transport::kFull, Transport::kUnshadowed)));

// From inside a sphere that emits, everything is a uniform light, whatever is behind the emitter.
TEST(Emitters, HideTheSkyAndSurroundWithTheirOwnLight) {
  formats::LightRig rig = uniformRig(100);
  formats::Emitter shell;
  shell.shape = formats::Emitter::Shape::kSphere;
  shell.radius = 3;
  shell.radiance = {2, 2, 2};
  rig.emitters.push_back(shell);
  const Scene scene = sceneOf(surfaceOf(icosphere(1), 0.5f), rig);
  const ShadingPoint point = scene.pointAtVertex(7);
  for (const auto integrator : {Integrator::kMis, Integrator::kUniform})
    for (const auto transport : {Transport::kFull, Transport::kShadowed, Transport::kUnshadowed}) {
      const auto means =
          estimate(scene, {.transport = transport, .integrator = integrator}, point, point.normal, 128);
      EXPECT_NEAR(means.luminance(), 0.5 * 2, 3.5 * standardError(means));
      EXPECT_LT(standardError(means), 0.02);
    }
}

// Many clusters, some of them below the horizon or dark, give what directions over the hemisphere find.
TEST(Emitters, ManyAgreeWithDirectionsOverTheHemisphere) {
  formats::LightRig rig;
  for (const auto& [position, radiance] : {std::pair(Float3{0.9f, 0.8f, 0}, 3.0f),
                                           {Float3{-0.7f, -0.9f, 0.3f}, 9.0f},
                                           {Float3{0, 0.9f, 0.9f}, 0.0f},
                                           {Float3{-1, 0.1f, -0.6f}, 5.0f}}) {
    formats::Emitter sphere;
    sphere.shape = formats::Emitter::Shape::kSphere;
    sphere.position = position;
    sphere.radius = 0.35;
    sphere.radiance = {radiance, radiance, radiance};
    rig.emitters.push_back(sphere);
  }
  const Scene scene = sceneOf(surfaceOf(floorSquare(1), 0.7f), rig);
  transport::Hit hit;
  hit.valid = true;
  hit.u = hit.v = 0.25f;
  const ShadingPoint point = scene.pointAt(hit);
  const auto mis = estimate(scene, {}, point, point.normal, 128);
  const auto uniform = estimate(scene, {.integrator = Integrator::kUniform}, point, point.normal, 1024, 1);
  EXPECT_NEAR(mis.luminance(), uniform.luminance(),
              3.5 * std::sqrt(mis.luminanceVariance() + uniform.luminanceVariance()));
  EXPECT_LT(standardError(mis), 0.03 * mis.luminance());
  EXPECT_LT(standardError(uniform), 0.05 * mis.luminance());

  // Each sample says of itself what densityPerSr says, and none is drawn of what does not shine.
  const transport::StratifiedBatch batch(1, 2, 3);
  for (int s = 0; s < 16; ++s) {
    const auto [u, v] = batch.pair(s, 0);
    const auto sample = scene.emitters().sample(point.origin, point.normal, u, v);
    ASSERT_GT(sample.density_per_sr, 0);
    EXPECT_GT(scene.emitters().radiance(sample.triangle)[0], 0);
    EXPECT_NEAR(scene.emitters().densityPerSr(point.origin, point.normal, sample.triangle, sample.direction,
                                              sample.distance),
                sample.density_per_sr, 1e-9 * sample.density_per_sr);
  }
}

}  // namespace
}  // namespace bakelight::tests
