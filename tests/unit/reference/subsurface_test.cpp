// Light that passes through media, against closed forms.
#include "tools/reference/subsurface.h"

#include <gtest/gtest.h>

#include <numbers>

#include "formats/error.h"
#include "tests/unit/reference/scenes.h"
#include "transport/diffusion.h"

namespace bakelight::tests {
namespace {

using namespace reference;

constexpr double kPi = std::numbers::pi;

Surface translucent(const TriangleMesh& mesh, const formats::Medium& medium) {
  Surface surface = surfaceOf(mesh, 1);
  surface.material.media = {medium};
  return surface;
}

transport::DiffuseReflectance reflectanceOf(const formats::Medium& medium, std::size_t color) {
  return {medium.model,
          {medium.reduced_scattering[color] * medium.unit_mm, medium.absorption[color] * medium.unit_mm,
           medium.eta}};
}

// What a uniform sky of 1 sends through the surface: Schlick's transmittance of the cosine, integrated.
double enteredOfUniformSky(double eta) {
  return kPi * transport::schlickTransmittance(1, eta) * 20 / 21;
}

// In the middle of the square's diagonal, on its first triangle.
ShadingPoint middleOf(const Scene& scene) {
  transport::Hit hit;
  hit.valid = true;
  hit.u = 0;
  hit.v = 0.5F;
  return scene.pointAt(hit);
}

void expectMean(const BatchMeans& means, const Rgb& expected, double smallest_error) {
  for (int c = 0; c < 3; ++c) {
    const double error = std::sqrt(means.variance()[c]);
    EXPECT_LT(error, smallest_error * expected[c]) << c;  // there is not much noise
    EXPECT_NEAR(means.mean()[c], expected[c], 3.5 * error + 1e-4 * expected[c]) << c;
  }
}

class PlaneOfAMedium : public testing::TestWithParam<formats::DiffusionModel> {};

TEST_P(PlaneOfAMedium, SendsTheTotalBack) {
  for (const float unit_mm : {1.0F, 0.1F, 10.0F}) {
    const formats::Medium medium{{2, 3, 4}, {0.5F, 0.3F, 2}, 1.5, unit_mm, GetParam()};
    const Scene scene = sceneOf(translucent(floorSquare(60 / unit_mm), medium), uniformRig());
    const Vec3 eye = Vec3(0, 1, std::sqrt(3.0)) / 2;
    const auto means = estimate(scene, {.transport = Transport::kShadowed}, middleOf(scene), eye, 400);
    Rgb expected;
    for (std::size_t c = 0; c < 3; ++c)
      expected[static_cast<Eigen::Index>(c)] = enteredOfUniformSky(1.5) * reflectanceOf(medium, c).total() *
                                               transport::schlickTransmittance(0.5, 1.5) / kPi;
    expectMean(means, expected, 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Models, PlaneOfAMedium,
                         testing::Values(formats::DiffusionModel::kDipole,
                                         formats::DiffusionModel::kBetterDipole,
                                         formats::DiffusionModel::kNormalizedDiffusion));

TEST(Subsurface, LightStaysInItsMedium) {
  formats::Medium medium{{2, 2, 2}, {0.5F, 0.5F, 0.5F}, 1.3, 1, {}};
  Surface surface = translucent(floorSquare(60), medium);
  surface.material.media = {medium, std::nullopt};
  surface.material.reflections.resize(2);
  surface.material.names.resize(2);
  surface.material.of_triangle = {0, 1};
  const Scene scene = sceneOf(surface, uniformRig());
  const auto means =
      estimate(scene, {.transport = Transport::kShadowed}, middleOf(scene), Vec3::UnitY(), 400);
  // The half of the plane that is of it.
  const double expected = enteredOfUniformSky(1.3) * reflectanceOf(medium, 0).total() / 2 *
                          transport::schlickTransmittance(1, 1.3) / kPi;
  expectMean(means, Rgb::Constant(expected), 0.05);
}

// Lines meet the ceiling first, from where so little comes that no number holds it.
TEST(Subsurface, PlacesOutOfReachDoNotHideNearOnes) {
  const formats::Medium medium{{2, 2, 2}, {0.5F, 0.5F, 0.5F}, 1.3, 100, {}};
  TriangleMesh mesh = floorSquare(1);
  for (const Vec3& corner :
       {Vec3(-0.1, 5, 0.1), Vec3(0.1, 5, 0.1), Vec3(0.1, 5, -0.1), Vec3(-0.1, 5, -0.1)}) {
    mesh.positions.push_back(float3(corner));
    mesh.normals.push_back({0, 1, 0});
  }
  mesh.triangles.push_back({4, 5, 6});
  mesh.triangles.push_back({4, 6, 7});
  const Scene scene = sceneOf(translucent(mesh, medium), uniformRig());
  const auto means =
      estimate(scene, {.transport = Transport::kShadowed}, middleOf(scene), Vec3::UnitY(), 400);
  const double expected = enteredOfUniformSky(1.3) * reflectanceOf(medium, 0).total() *
                          transport::schlickTransmittance(1, 1.3) / kPi;
  expectMean(means, Rgb::Constant(expected), 0.05);
}

// Through a ball, from all sides: a quadrature over its surface; of one medium, with veins, and of what its colors say.
enum class Varies { kNot, kByVeins, kByAlbedo };
class ThroughABall : public testing::TestWithParam<Varies> {};
INSTANTIATE_TEST_SUITE_P(Media, ThroughABall,
                         testing::Values(Varies::kNot, Varies::kByVeins, Varies::kByAlbedo));

TEST_P(ThroughABall, IsTheIntegralOverItsSurface) {
  TriangleMesh ball = icosphere(3);
  formats::Medium medium{{1, 3, 10}, {0.01F, 0.1F, 0.2F}, 1.3, 1, {}};
  if (GetParam() == Varies::kByVeins) medium.veins = formats::Veins{{4, 1, 2}, {1, 2, 0.5F}, 0.6, 0.2, 3};
  if (GetParam() == Varies::kByAlbedo) {
    medium.reflectance = formats::ReflectanceSource::kAlbedo;
    for (const formats::Float3& p : ball.positions)
      ball.colors.push_back({p[0] > 0 ? 0.9F : 0.3F, p[1] > 0 ? 0.8F : 0.2F, 0.5F + 0.3F * p[2]});
  }
  const transport::MediumField field(medium, ball);
  Surface surface = translucent(ball, medium);
  surface.material.medium_reflectance = ball.colors;
  const Scene scene = sceneOf(surface, uniformRig());
  const ShadingPoint point = scene.pointAtVertex(7);
  const auto along = [&](const Vec3& place, const Vec3& color) {
    if (!field.isOfSurface()) return field.along(point.position, place);
    return field.along(field.surroundings(point.position, ball.colors[7]),
                       field.surroundings(place, float3(color)), (place - point.position).norm());
  };
  Rgb integral = Rgb::Zero();
  constexpr int kParts = 6;
  for (const auto& [i, j, k] : ball.triangles) {
    const Vec3 a = vec3(ball.positions[i]), b = vec3(ball.positions[j]), c = vec3(ball.positions[k]);
    const double area = (b - a).cross(c - a).norm() / 2 / (kParts * kParts);
    for (int s = 0; s < kParts; ++s)
      for (int t = 0; t < kParts - s; ++t)
        for (const double third : {1.0 / 3, 2.0 / 3}) {
          if (third > 0.5 && t == kParts - s - 1) continue;
          const Vec3 place = a + (b - a) * ((s + third) / kParts) + (c - a) * ((t + third) / kParts);
          Vec3 painted = Vec3::Ones();
          if (!ball.colors.empty()) {
            const Vec3 at_a = vec3(ball.colors[i]);
            painted = at_a + (vec3(ball.colors[j]) - at_a) * ((s + third) / kParts) +
                      (vec3(ball.colors[k]) - at_a) * ((t + third) / kParts);
          }
          for (int color = 0; color < 3; ++color)
            integral[color] +=
                area * field.reflectance(static_cast<std::size_t>(color), (place - point.position).norm(),
                                         along(place, painted));
        }
  }
  const auto means = estimate(scene, {.transport = Transport::kShadowed}, point, point.normal, 600);
  // The sky is seen over the tangent plane of the place that is hit, of which interpolated normals know.
  expectMean(means, enteredOfUniformSky(1.3) * integral * (transport::schlickTransmittance(1, 1.3) / kPi),
             0.05);
}

TEST(Subsurface, RandomWalksHaveNoAlbedoToGoBy) {
  formats::Medium medium{{2, 2, 2}, {0.5F, 0.5F, 0.5F}, 1.3, 1, {}};
  medium.reflectance = formats::ReflectanceSource::kAlbedo;
  Surface surface = translucent(icosphere(2), medium);
  surface.material.medium_reflectance.assign(surface.mesh.vertexCount(), {0.5F, 0.5F, 0.5F});
  EXPECT_NO_THROW(sceneOf(surface, uniformRig()));
  surface.translucency = Translucency::kRandomWalk;
  try {
    sceneOf(surface, uniformRig());
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.paragraph().find("/medium/reflectance"), std::string::npos) << error.paragraph();
  }
}

TEST(Subsurface, SunlightEntersByItsCosineAndAShadowEndsSoftly) {
  const formats::Medium medium{{2, 2, 2}, {0.5F, 0.5F, 0.5F}, 1.3, 1, {}};
  formats::LightRig rig;
  rig.distant.emplace_back(formats::DirectionalLight{{0, 1, 1}, {5, 5, 5}});
  // A wall over x > 0, high above, shades half of the ground: what the sun sends goes on by the edge's response.
  TriangleMesh mesh = floorSquare(60);
  const Scene lit = sceneOf(translucent(mesh, medium), rig);
  const auto bright = estimate(lit, {.transport = Transport::kShadowed}, middleOf(lit), Vec3::UnitY(), 200);
  const double cosine = std::sqrt(0.5);
  const double expected = 5 * cosine * transport::schlickTransmittance(cosine, 1.3) *
                          reflectanceOf(medium, 0).total() * transport::schlickTransmittance(1, 1.3) / kPi;
  expectMean(bright, Rgb::Constant(expected), 0.05);
  for (const Vec3& corner : {Vec3(0, 30, -60), Vec3(60, 30, -60), Vec3(60, 30, 120), Vec3(0, 30, 120)}) {
    mesh.positions.push_back(float3(corner));
    mesh.normals.push_back({0, 1, 0});
  }
  mesh.triangles.push_back({4, 5, 6});
  mesh.triangles.push_back({4, 6, 7});
  Surface surface = translucent(mesh, medium);
  surface.material.media = {medium, std::nullopt};
  surface.material.reflections.resize(2);
  surface.material.names.resize(2);
  surface.material.of_triangle = {0, 0, 1, 1};
  const Scene shaded = sceneOf(surface, rig);
  const auto edge =
      estimate(shaded, {.transport = Transport::kShadowed}, middleOf(shaded), Vec3::UnitY(), 400);
  expectMean(edge, Rgb::Constant(expected / 2), 0.05);
}

}  // namespace
}  // namespace bakelight::tests
