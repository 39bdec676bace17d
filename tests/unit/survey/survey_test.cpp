#include "tools/survey/survey.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/mesh_ply.h"
#include "formats/stage_record.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/survey/bodies.h"
#include "transport/lights.h"

namespace bakelight::survey {
namespace {

using namespace bakelight::tests;
using Lobe = SurveyOptions::Lobe;

constexpr double kErrors = 4;  // standard errors that an estimate may be off

Float3 gray(double albedo) {
  const auto value = static_cast<float>(albedo);
  return {value, value, value};
}

void expectNear(const Estimate& estimate, double expected, double slack = 0) {
  EXPECT_GT(estimate.standard_error, 0);
  EXPECT_NEAR(estimate.value, expected, kErrors * estimate.standard_error + slack);
}

TEST(Survey, ConvexBodyNeedsNoRays) {
  for (const TriangleMesh& mesh : {icosphere(4), turned(box(8)), diskFacingDown({0, 2, 0}, 1, 24)}) {
    const Survey result = survey(mesh, {.albedo = gray(1)});
    EXPECT_EQ(result.rays, 0u);
    EXPECT_EQ(result.concavity, 0);
    for (const Estimate& estimate : {result.blocked_share, result.bounce_energy, result.view_dependence}) {
      EXPECT_EQ(estimate.value, 0);
      EXPECT_EQ(estimate.standard_error, 0);
    }
    EXPECT_EQ(result.largest_blocked_share, 0);
  }
}

TEST(Survey, SameFiguresAtEveryScale) {
  const TriangleMesh mesh = cavity(0.2, 12, 24);
  const Survey expected = survey(mesh, {.albedo = gray(0.5), .samples = 256});
  ASSERT_GT(expected.blocked_share.value, 0.5);
  for (const double scale : {1e-14, 1e-10, 1e-6, 1e6, 1e10, 5e14}) {
    TriangleMesh other = mesh;
    for (auto& position : other.positions) position = float3(scale * vec3(position));
    const Survey result = survey(other, {.albedo = gray(0.5), .samples = 256});
    EXPECT_NEAR(result.concavity, expected.concavity, 1e-5) << scale;
    EXPECT_NEAR(result.blocked_share.value, expected.blocked_share.value, 2e-3) << scale;
    EXPECT_NEAR(result.bounce_energy.value, expected.bounce_energy.value, 2e-3) << scale;
  }
}

TEST(Survey, ScalesThatFloatsDoNotReachAreRefused) {
  for (const double scale : {1e-18, 1e18, 1e30}) {
    TriangleMesh mesh = cavity(0.2, 12, 24);
    for (auto& position : mesh.positions) position = float3(scale * vec3(position));
    EXPECT_THROW(survey(mesh, {.albedo = gray(0.5), .samples = 64}), Error) << scale;
  }
}

// What leaves the inner surface through the plane of the opening and what enters there are the same pairs of
// points: the mean open share is the opening's area over the surface's, tessellated as it is.
class SphericalCavity : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(SphericalCavity, BlocksAndBouncesAsTheClosedForm) {
  const auto [open_fraction, albedo] = GetParam();
  constexpr int kSides = 96;
  const TriangleMesh mesh = cavity(open_fraction, 48, kSides);
  const double open = openingArea(open_fraction, kSides) / surfaceArea(mesh);
  const Survey result = survey(mesh, {.albedo = gray(albedo)});
  expectNear(result.blocked_share, 1 - open);
  EXPECT_LT(result.blocked_share.standard_error, 0.002);
  // The tessellation makes the open share vary a little over the surface.
  const double expected = 1 / (1 - albedo * (1 - open)) - 1;
  expectNear(result.bounce_energy, expected, 2e-3 * expected);
  EXPECT_LT(result.bounce_energy.standard_error, 0.06 * expected);
  EXPECT_GT(result.rays, 4096u * kDirections);
}

INSTANTIATE_TEST_SUITE_P(Cases, SphericalCavity,
                         testing::Values(std::pair(0.5, 0.3), std::pair(0.5, 0.8), std::pair(0.25, 0.5),
                                         std::pair(0.25, 0.9), std::pair(0.25, 1.0), std::pair(0.05, 0.8)));

// Configuration factor of a sphere to a coaxial disk: ½ (1 − 1/√(1 + (R/h)²)); the disk's to the sphere by
// reciprocity.
TEST(Survey, SphereUnderDiskBlocksAsTheConfigurationFactor) {
  constexpr double kHeight = 2, kRadius = 3;
  const TriangleMesh sphere = icosphere(5), disk = diskFacingDown({0, kHeight, 0}, kRadius, 256);
  const double share = 0.5 * (1 - 1 / std::hypot(1, kRadius / kHeight));
  const double sphere_area = surfaceArea(sphere), disk_area = surfaceArea(disk);
  const double expected = 2 * sphere_area * share / (sphere_area + disk_area);
  const TriangleMesh mesh = joined(sphere, disk);
  // Estimates of different sizes use different points: their errors say whether the standard errors are
  // right.
  double squares = 0;
  constexpr int kRepeats = 24;
  for (int i = 0; i < kRepeats; ++i) {
    const Survey result = survey(mesh, {.samples = 500 + i});
    expectNear(result.blocked_share, expected, 1e-3);
    squares += std::pow((result.blocked_share.value - expected) / result.blocked_share.standard_error, 2);
  }
  // Stratification makes the estimates better than independent samples would be, never worse.
  EXPECT_LT(std::sqrt(squares / kRepeats), 1.4);
  EXPECT_GT(std::sqrt(squares / kRepeats), 0.1);
}

// White bodies under a uniform sky send 1 from everywhere, so bounces make up for all that is blocked.
TEST(Survey, WhiteFurnace) {
  const TriangleMesh mesh = joined(icosphere(3), icosphere(3, 0.6, {1.7, 0.2, 0}));
  const Survey result = survey(mesh, {.albedo = gray(1), .samples = 20000});
  const double blocked = result.blocked_share.value;
  EXPECT_GT(blocked, 0.02);
  expectNear(result.bounce_energy, blocked / (1 - blocked));
}

TEST(Survey, BlackBodiesBounceNothing) {
  const TriangleMesh mesh = joined(icosphere(2), icosphere(2, 1, {2.2, 0, 0}));
  const Survey result = survey(mesh, {.albedo = gray(0), .lobe = Lobe::kTinted});
  EXPECT_EQ(result.bounce_energy.value, 0);
  EXPECT_GT(result.blocked_share.value, 0.01);
  EXPECT_EQ(result.view_dependence.value, 1);
}

TEST(Survey, ColorsOfTheMeshAreItsAlbedo) {
  TriangleMesh mesh = joined(icosphere(2), icosphere(2, 1, {2.2, 0, 0}));
  mesh.colors.assign(mesh.vertexCount(), gray(0));
  EXPECT_EQ(survey(mesh, {.albedo = gray(1)}).bounce_energy.value, 0);
  mesh.colors.assign(mesh.vertexCount(), gray(0.7));
  EXPECT_EQ(
      survey(mesh, {.albedo = gray(0)}).bounce_energy.value,
      survey({mesh.positions, mesh.normals, {}, mesh.triangles}, {.albedo = gray(0.7)}).bounce_energy.value);
}

// A plate over a smaller one, both facing up: the lower sees the upper's back, which can be seen and bounces.
TEST(Survey, BacksOfOpenPartsBounceAndInsidesOfClosedOnesAreDark) {
  const auto plate = [](double height, double radius) {
    TriangleMesh mesh = insideOut(diskFacingDown({0, height, 0}, radius, 64));
    return mesh;
  };
  const TriangleMesh plates = joined(plate(0, 2), plate(1, 1));
  EXPECT_GT(survey(plates, {}).bounce_energy.value, 1e-3);

  // The back given as triangles of its own, at the same place or a little below: the same light, whichever of
  // the two a ray is said to meet.
  const auto floor_and_ceiling = [&](double thickness) {
    return joined(plate(0, 2), joined(plate(1, 1), insideOut(plate(1 - thickness, 1))));
  };
  const Survey thin = survey(floor_and_ceiling(0), {}), thick = survey(floor_and_ceiling(1e-4), {});
  EXPECT_GT(thin.bounce_energy.value, 0.05);
  expectNear(thin.bounce_energy, thick.bounce_energy.value);

  // Nothing reaches a body within another, and nothing comes back from there.
  const TriangleMesh inner = icosphere(3, 0.5), outer = icosphere(4);
  const Survey buried = survey(joined(outer, inner), {});
  expectNear(buried.blocked_share, surfaceArea(inner) / (surfaceArea(inner) + surfaceArea(outer)), 1e-3);
  EXPECT_EQ(buried.bounce_energy.value, 0);
  EXPECT_EQ(buried.largest_blocked_share, 1);
}

TEST(Survey, ClosedWhiteCavityEnds) {
  const Survey result = survey(insideOut(icosphere(3)), {.albedo = gray(1), .samples = 256});
  EXPECT_EQ(result.blocked_share.value, 1);
  EXPECT_EQ(result.bounce_energy.value, 0);
}

TEST(Survey, ViewDependenceIsTheShareOfTheLobe) {
  const TriangleMesh convex = icosphere(2), concave = joined(convex, icosphere(2, 1, {2.2, 0, 0}));
  for (const TriangleMesh& mesh : {convex, concave}) {
    SurveyOptions options{.albedo = gray(0.6), .specular_color = gray(0.2)};
    EXPECT_EQ(survey(mesh, options).view_dependence.value, 0);
    options.lobe = Lobe::kTinted;
    EXPECT_NEAR(survey(mesh, options).view_dependence.value, 0.25, 1e-6);
    options.specular_color = gray(0);
    EXPECT_EQ(survey(mesh, options).view_dependence.value, 0);
    options.lobe = Lobe::kTable;
    EXPECT_EQ(survey(mesh, options).view_dependence.value, 1);
  }
}

// Half white, half black, seen by area: luminance of a red lobe over that and the mean albedo.
TEST(Survey, ViewDependenceWeighsColorsByArea) {
  TriangleMesh mesh = joined(diskFacingDown({0, 0, 0}, 1, 32), diskFacingDown({5, 0, 0}, 2, 32));
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) mesh.colors.push_back(gray(v < 33 ? 1 : 0));
  const double red = transport::luminance({0.5, 0, 0});
  const Survey result = survey(mesh, {.specular_color = {0.5, 0, 0}, .lobe = Lobe::kTinted});
  EXPECT_NEAR(result.view_dependence.value, red / (red + 1.0 / 5), 1e-6);
}

TEST(Survey, SameFiguresWithAnyNumberOfThreads) {
  const TriangleMesh mesh = cavity(0.3, 12, 24);
  const auto figures = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Survey s = survey(mesh, {.lobe = Lobe::kTinted, .samples = 700});
    return std::vector<double>{s.concavity,
                               s.blocked_share.value,
                               s.blocked_share.standard_error,
                               s.largest_blocked_share,
                               s.bounce_energy.value,
                               s.bounce_energy.standard_error,
                               s.view_dependence.value,
                               s.view_dependence.standard_error,
                               static_cast<double>(s.rays)};
  };
  EXPECT_EQ(figures(1), figures(4));
}

TEST(Survey, MeshWithoutAreaIsRefused) {
  TriangleMesh flat{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {}, {}, {{0, 1, 2}}};
  EXPECT_THROW(survey(flat, {}), std::invalid_argument);
  EXPECT_THROW(survey(TriangleMesh(), {}), std::invalid_argument);
}

TEST(SurveyTool, WritesItsFiguresAndRefusesAnEmptyMesh) {
  const TemporaryFolder folder;
  const auto run = [&](const TriangleMesh& mesh) {
    formats::writePly(folder / "mesh.ply", mesh);
    const std::string command = std::string(BAKELIGHT_BIN_DIR) + "/survey " + (folder / "mesh.ply").string() +
                                " --samples 64 --progress none --stats " + (folder / "stats.json").string() +
                                " 2> " + (folder / "errors.txt").string();
    return std::system(command.c_str());
  };
  ASSERT_EQ(run(cavity(0.3, 8, 16)), 0);
  const formats::Json stats =
      formats::stageRecordFromJson(formats::readJson(folder / "stats.json"), "stats.json").stats;
  for (const char* figure :
       {"concavity", "blocked_share", "blocked_share_standard_error", "largest_blocked_share",
        "bounce_energy", "bounce_energy_standard_error", "rays"})
    EXPECT_GT(stats.value(figure, 0.0), 0) << figure;
  EXPECT_EQ(stats.at("view_dependence"), 0);
  EXPECT_EQ(WEXITSTATUS(run(TriangleMesh())), 2);
}

}  // namespace
}  // namespace bakelight::survey
