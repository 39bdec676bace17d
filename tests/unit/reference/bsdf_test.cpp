#include "tools/reference/bsdf.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "tests/support/pack_parts.h"
#include "tests/unit/reference/scenes.h"
#include "transport/directions.h"
#include "transport/gauss_legendre.h"
#include "transport/glossy.h"

namespace bakelight::reference {
namespace {

using namespace bakelight::tests;
using reference::Integrator;

constexpr double kPi = std::numbers::pi;

formats::Reflection lobe(formats::Lobe model, float parameter, float specular = 0.8f) {
  const Float3 color = {specular, specular, specular};
  if (model == formats::Lobe::kPhong) return formats::PhongReflection{color, parameter};
  return formats::GgxReflection{color, parameter};
}

struct LobeCase {
  formats::Lobe model;
  float parameter;
};

class LobeShape : public testing::TestWithParam<LobeCase> {
 protected:
  LobeShape()
      : lobe_(GetParam().model == formats::Lobe::kPhong ? Lobe::phong(GetParam().parameter)
                                                        : Lobe::ggx(GetParam().parameter)),
        kernel_(GetParam().model == formats::Lobe::kPhong
                    ? transport::phongKernel(kOrder, GetParam().parameter)
                    : transport::ggxKernel(kOrder, GetParam().parameter)) {}

  static constexpr int kOrder = 8;
  Lobe lobe_;
  std::vector<double> kernel_;  // what the player scales band l by: the lobe's Legendre moments
};

TEST_P(LobeShape, MomentsAreThePlayersKernel) {
  std::vector<double> moments(kOrder, 0.0);
  for (double begin = 0, end = 1e-6; begin < 1; begin = end, end = std::min(2 * end, 1.0))
    for (const auto& [x, weight] : transport::gaussLegendreRule(16)) {
      const double u = begin + (end - begin) * (1 + x) / 2;
      const std::vector<double> p = transport::legendre(kOrder, 1 - u);
      for (int l = 0; l < kOrder; ++l)
        moments[l] += (end - begin) / 2 * weight * 2 * kPi * lobe_.valuePerSr(1 - u) * p[l];
    }
  for (int l = 0; l < kOrder; ++l) EXPECT_NEAR(moments[l], kernel_[l], 1e-5) << l;
}

TEST_P(LobeShape, SamplesHaveTheSameMoments) {
  constexpr int kCount = 20000;
  std::vector<double> moments(kOrder, 0.0);
  double last = -1;
  for (int i = 0; i < kCount; ++i) {
    const double u = lobe_.sampleOneMinusCosine((i + 0.5) / kCount);
    ASSERT_GT(u, last);  // the inverse of a distribution function grows
    ASSERT_LE(u, 1);
    last = u;
    const std::vector<double> p = transport::legendre(kOrder, 1 - u);
    for (int l = 0; l < kOrder; ++l) moments[l] += p[l] / kCount;
  }
  for (int l = 0; l < kOrder; ++l) EXPECT_NEAR(moments[l], kernel_[l], 1e-3) << l;
}

INSTANTIATE_TEST_SUITE_P(
    Lobes, LobeShape,
    testing::Values(LobeCase{formats::Lobe::kPhong, 0}, LobeCase{formats::Lobe::kPhong, 7.5f},
                    LobeCase{formats::Lobe::kPhong, 300}, LobeCase{formats::Lobe::kGgx, 0.1f},
                    LobeCase{formats::Lobe::kGgx, 0.4f}, LobeCase{formats::Lobe::kGgx, 0.9f},
                    LobeCase{formats::Lobe::kGgx, 0.99f}, LobeCase{formats::Lobe::kGgx, 1}));

// Mean of value(s) over a fine set of directions: what a uniform sky of 1 gives.
double underUniformSky(const Bsdf& bsdf) {
  static const std::vector<Vec3> directions = transport::sphereDirections(200000);
  double sum = 0;
  for (const Vec3& direction : directions) sum += bsdf.value(direction)[1];
  return sum * 4 * kPi / static_cast<double>(directions.size());
}

Vec3 eyeAt(double angle) {
  return Vec3(std::sin(angle), std::cos(angle), 0);
}

class UniformSky : public testing::TestWithParam<std::tuple<LobeCase, Integrator>> {};

TEST_P(UniformSky, LobeGivesItsColorTimesItsShareAboveTheSurface) {
  const auto& [shape, integrator] = GetParam();
  const Scene scene =
      sceneOf(surfaceOf(floorSquare(1), 0.3f, lobe(shape.model, shape.parameter), ReflectionModel::kLobe),
              uniformRig());
  transport::Hit hit;
  hit.valid = true;
  hit.u = hit.v = 0.25f;
  const ShadingPoint point = scene.pointAt(hit);
  double before = 10;
  for (const double angle : {0.0, 0.7, 1.4}) {
    const Bsdf bsdf(&scene.material(0), point.albedo, point.normal, eyeAt(angle));
    const double expected = underUniformSky(bsdf);
    if (angle == 0) {
      EXPECT_NEAR(expected, 0.3 + 0.8, 0.002);  // the whole lobe is above
    }
    EXPECT_LT(expected, before);
    EXPECT_GT(expected, 0.3 + 0.8 / 2 - 0.002);
    before = expected;
    const auto means = estimate(scene, {.integrator = integrator}, point, eyeAt(angle), 256);
    EXPECT_NEAR(means.mean()[1], expected, 3.5 * std::sqrt(means.variance()[1]) + 5e-4) << angle;
    EXPECT_LT(std::sqrt(means.variance()[1]), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(Lobes, UniformSky,
                         testing::Combine(testing::Values(LobeCase{formats::Lobe::kPhong, 20},
                                                          LobeCase{formats::Lobe::kGgx, 0.35f},
                                                          LobeCase{formats::Lobe::kGgx, 0.8f}),
                                          testing::Values(Integrator::kMis, Integrator::kUniform)));

class Sampled : public testing::TestWithParam<ReflectionModel> {};

TEST_P(Sampled, IntegratesToOneAndKnowsItsDensity) {
  // Rough facets that scatter several times, for the physical one.
  const formats::GgxReflection ggx{{0.4F, 0.4F, 0.4F}, 0.5, true, true};
  const Glossy material = glossyOf(ggx, GetParam(), nullptr);
  const Vec3 normal = Vec3(1, 2, -0.5).normalized(), outgoing = Vec3(0.3, 1, 0.4).normalized();
  const Bsdf bsdf(&material, Rgb(0.2, 0.5, 0.7), normal, outgoing);
  double density = 0, reflectance = 0;
  const auto directions = transport::sphereDirections(200000);
  for (const Vec3& direction : directions) {
    density += bsdf.densityPerSr(direction) * 4 * kPi / static_cast<double>(directions.size());
    reflectance += bsdf.value(direction)[0] * 4 * kPi / static_cast<double>(directions.size());
  }
  double mean_weight = 0;
  int below = 0;
  constexpr int kSide = 60;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const auto sample = bsdf.sample((i % kSide + 0.5) / kSide, (i / kSide % kSide + 0.5) / kSide,
                                    (i / kSide / kSide + 0.5) / kSide);
    if (normal.dot(sample.incoming) <= 0) {
      EXPECT_EQ(sample.weight[0], 0);
      ++below;
      continue;
    }
    EXPECT_NEAR(sample.density_per_sr, bsdf.densityPerSr(sample.incoming), 1e-9);
    mean_weight += sample.weight[0];
  }
  const double count = kSide * kSide * kSide;
  EXPECT_NEAR(mean_weight / count, reflectance, 0.005);
  EXPECT_NEAR(density, 1 - below / count, 0.005);
  EXPECT_GT(below, 0);
}

INSTANTIATE_TEST_SUITE_P(Models, Sampled,
                         testing::Values(ReflectionModel::kLobe, ReflectionModel::kPhysical));

// Both ways to take the integral, by directions that know the facets and by some that do not.
TEST(Physical, BothIntegratorsAgreeUnderADisk) {
  for (const double roughness : {0.3, 0.6, 0.9}) {
    const formats::GgxReflection ggx{{0.7F, 0.5F, 0.3F}, roughness, true, roughness > 0.5};
    const Scene scene = sceneOf(surfaceOf(floorSquare(1), 0.2F, ggx), diskRig(40, 3, {-0.6F, 1, 0.2F}));
    const ShadingPoint point = scene.pointAtVertex(0);
    const Vec3 outgoing = eyeAt(0.7);
    const auto mis = estimate(scene, {.integrator = Integrator::kMis}, point, outgoing, 512);
    const auto uniform = estimate(scene, {.integrator = Integrator::kUniform}, point, outgoing, 4096);
    EXPECT_NEAR(mis.luminance(), uniform.luminance(),
                3.5 * std::hypot(standardError(mis), standardError(uniform)));
    EXPECT_LT(standardError(mis), 0.01 * mis.luminance());
    EXPECT_LT(standardError(uniform), 0.02 * uniform.luminance());
  }
}

// White facets, with or without a diffuse ground, under a uniform sky.
TEST(Physical, FurnaceIsWhiteWithMultipleScatteringAndDarkerWithout) {
  for (const bool multiple : {false, true}) {
    const formats::GgxReflection ggx{{1, 1, 1}, 0.9, false, multiple};
    const Scene scene = sceneOf(surfaceOf(floorSquare(1), 0, ggx), uniformRig());
    const auto means = estimate(scene, {}, scene.pointAtVertex(0), eyeAt(0.6), 1024);
    if (multiple) {
      EXPECT_NEAR(means.luminance(), 1, 3.5 * standardError(means) + 0.002);
    } else {
      EXPECT_LT(means.luminance(), 0.9);
    }
  }
}

TEST(Physical, EachFaceHasItsOwnMaterial) {
  TriangleMesh mesh = floorSquare(1);
  Surface surface = surfaceOf(flatShaded(mesh), 0, formats::GgxReflection{{0.5F, 0.5F, 0.5F}, 0});
  surface.material.reflections.push_back(formats::GgxReflection{{0.25F, 0.25F, 0.25F}, 0});
  surface.material.of_triangle = {0, 1};
  const Scene scene = sceneOf(surface, uniformRig());
  for (const std::uint32_t triangle : {0U, 1U}) {
    transport::Hit hit;
    hit.valid = true;
    hit.triangle = triangle;
    hit.u = hit.v = 0.25F;
    const double expected = triangle == 0 ? 0.5 : 0.25;
    EXPECT_NEAR(estimate(scene, {}, scene.pointAt(hit), eyeAt(0.4), 2).luminance(), expected, 1e-9);
    EXPECT_NEAR(estimate(scene, {}, scene.pointAtVertex(3 * triangle), eyeAt(0.4), 2).luminance(), expected,
                1e-9);
  }
}

TEST(Physical, ATableThatIsAskedForMustBeThere) {
  EXPECT_THROW(glossyOf(formats::GgxReflection(), ReflectionModel::kTable, nullptr), Error);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(
      glossyOf(formats::GgxReflection(), ReflectionModel::kNone, nullptr)));
  EXPECT_TRUE(std::holds_alternative<TintedLobe>(
      glossyOf(formats::GgxReflection(), ReflectionModel::kLobe, nullptr)));
  EXPECT_TRUE(std::holds_alternative<TintedLobe>(
      glossyOf(formats::PhongReflection(), ReflectionModel::kPhysical, nullptr)));
}

// 4 × 2 texels of different colours.
formats::LightRig coarseImageRig() {
  formats::LightRig rig;
  formats::EnvironmentLight light;
  light.image = formats::Image(4, 2, {"R", "G", "B"});
  for (std::size_t i = 0; i < light.image.values.size(); ++i)
    light.image.values[i] = static_cast<float>(1 + i * 7 % 11);
  rig.distant.emplace_back(light);
  return rig;
}

class Mirror : public testing::TestWithParam<ReflectionModel> {};
INSTANTIATE_TEST_SUITE_P(Models, Mirror, testing::Values(ReflectionModel::kLobe, ReflectionModel::kPhysical));

TEST_P(Mirror, ShowsExactlyWhatItSees) {
  const ReflectionModel model = GetParam();
  const Scene scene =
      sceneOf(surfaceOf(floorSquare(1), 0, lobe(formats::Lobe::kGgx, 0, 0.5f), model), coarseImageRig());
  transport::Hit hit;
  hit.valid = true;
  hit.u = hit.v = 0.25f;
  const ShadingPoint point = scene.pointAt(hit);
  std::set<double> seen;
  for (const Vec3& eye :
       {Vec3(0.5, 0.4, 0.1), Vec3(-0.5, 0.4, 0.1), Vec3(0.3, 0.4, -0.6), Vec3(-0.3, 0.4, -0.6)}) {
    const Vec3 outgoing = eye.normalized(), reflected(-outgoing.x(), outgoing.y(), -outgoing.z());
    const Rgb expected = 0.5 * scene.distantLight().radiance(reflected);
    seen.insert(expected[0]);
    for (const auto integrator : {Integrator::kMis, Integrator::kUniform}) {
      const auto means = estimate(scene, {.integrator = integrator}, point, outgoing, 2);
      for (Eigen::Index c = 0; c < 3; ++c) EXPECT_NEAR(means.mean()[c], expected[c], 1e-9);
      EXPECT_NEAR(means.luminanceVariance(), 0, 1e-20);
    }
  }
  EXPECT_GT(seen.size(), 2u);
}

// Diffuse part and mirror of one surface add up.
TEST_P(Mirror, AddsToTheDiffusePart) {
  const ReflectionModel model = GetParam();
  const Scene scene =
      sceneOf(surfaceOf(floorSquare(1), 0.4f, lobe(formats::Lobe::kGgx, 0, 0.5f), model), uniformRig());
  const ShadingPoint point = scene.pointAtVertex(0);
  for (const auto integrator : {Integrator::kMis, Integrator::kUniform}) {
    const auto means = estimate(scene, {.integrator = integrator}, point, eyeAt(0.5), 256);
    EXPECT_NEAR(means.luminance(), 0.9, 3.5 * standardError(means));
    EXPECT_LT(standardError(means), 0.02);
  }
}

// Bounces off another surface count a lobe in full transport only.
TEST(Transport, InterreflectedLeavesLobesOfLaterBouncesOut) {
  // A mirror floor, and a mirror wall behind it that a floor's mirror shows.
  Surface surface = surfaceOf(floorSquare(2), 0, lobe(formats::Lobe::kGgx, 0, 0.5f));
  TriangleMesh wall = floorSquare(2);
  for (auto& position : wall.positions) position = {-1, position[0] + 2, position[2]};
  for (auto& normal : wall.normals) normal = {1, 0, 0};
  for (auto& triangle : wall.triangles) std::swap(triangle[1], triangle[2]);
  append(surface.mesh, wall);
  const Scene scene = sceneOf(surface, uniformRig());
  const ShadingPoint point{Vec3(0, 1e-4, 0), Vec3::UnitY(), Rgb::Zero()};
  const Vec3 outgoing = Vec3(1, 1, 0).normalized();  // reflected towards the wall
  EXPECT_NEAR(estimate(scene, {}, point, outgoing, 4).luminance(), 0.25, 1e-9);
  EXPECT_EQ(estimate(scene, {.transport = Transport::kInterreflected}, point, outgoing, 4).luminance(), 0);
  EXPECT_EQ(estimate(scene, {.transport = Transport::kShadowed}, point, outgoing, 4).luminance(), 0);
  EXPECT_NEAR(estimate(scene, {.transport = Transport::kUnshadowed}, point, outgoing, 4).luminance(), 0.5,
              1e-9);
}

// A table's value is its SH expansion, as tableRows has it, over the hemisphere above the surface.
TEST(Table, IsItsExpansion) {
  formats::BrdfTable table;
  table.angles = 3;
  table.order = 4;
  for (int angle = 0; angle < table.angles; ++angle)
    for (int c = 0; c < 3; ++c)
      for (int l = 0; l < table.order; ++l)
        for (int m = -l; m <= l; ++m)
          table.values.push_back(
              m < 0 ? 0.0f : 0.3f / static_cast<float>(1 + l + m) + 0.05f * static_cast<float>(angle + c));
  const Scene scene =
      sceneOf(surfaceOf(floorSquare(1), 0.2f, formats::TableReflection{"", table}), uniformRig());
  const ShadingPoint point = scene.pointAtVertex(1);
  const auto directions = transport::sphereDirections(100000);
  for (const double angle : {0.2, 1.1}) {
    // In a frame of its own: z the normal +Y, x towards the eye.
    std::vector<double> rows(3 * 16);
    transport::tableRows(table, Vec3(std::sin(angle), 0, std::cos(angle)), 4, rows);
    Rgb expected = Rgb::Constant(0.2);
    for (const Vec3& direction : directions) {
      if (direction.z() <= 0) continue;
      const auto basis = transport::evaluateSh(4, direction);
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 16; ++i)
          expected[static_cast<Eigen::Index>(c)] +=
              rows[c * 16 + i] * basis[i] * 4 * kPi / static_cast<double>(directions.size());
    }
    for (const auto integrator : {Integrator::kMis, Integrator::kUniform}) {
      const auto means = estimate(scene, {.integrator = integrator}, point, eyeAt(angle), 512);
      for (Eigen::Index c = 0; c < 3; ++c)
        EXPECT_NEAR(means.mean()[c], expected[c], 3.5 * std::sqrt(means.variance()[c]) + 1e-4);
      EXPECT_LT(standardError(means), 0.03);
    }
  }
}

}  // namespace
}  // namespace bakelight::reference
