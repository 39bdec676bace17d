#include "tools/mesomesh/field/direction_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "bodies.h"
#include "formats/error.h"
#include "formats/file.h"
#include "tests/support/temporary_folder.h"
#include "tools/mesomesh/retile/retile.h"

namespace bakelight::mesomesh {
namespace {

using formats::TriangleMesh;
using testing::AllOf;
using testing::HasSubstr;
using tests::vec3;
using transport::Vec3;

TriangleMesh retiled(const TriangleMesh& mesh, std::int64_t vertices) {
  return retile(mesh, {vertices, 80}, "mesh.ply").mesh;
}

DirectionField fieldOf(const TriangleMesh& mesh, int symmetry, std::span<const DirectionHint> hints = {}) {
  return directionField(mesh, {symmetry, 80}, hints, "hints.json");
}

// Largest of any edge, of the smallest among directions that the symmetry takes for one.
double turnAlongEdges(const TriangleMesh& mesh, const DirectionField& field, int symmetry) {
  double largest = 0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = vec3(field.tangents[t[k]]), b = vec3(field.tangents[t[(k + 1) % 3]]);
      const Vec3 n = vec3(mesh.normals[t[k]]);
      double best = 10;
      for (int r = 0; r < symmetry; ++r) {
        const double angle = 2 * std::numbers::pi * r / symmetry;
        const Vec3 turned = std::cos(angle) * a + std::sin(angle) * n.cross(a);
        best = std::min(best, std::acos(std::clamp(turned.dot(b), -1.0, 1.0)));
      }
      largest = std::max(largest, best);
    }
  return largest;
}

TEST(DirectionField, IsUnitAndTangent) {
  const TriangleMesh mesh = retiled(tests::torus(), 10'000);
  const DirectionField field = fieldOf(mesh, 1);
  ASSERT_EQ(field.tangents.size(), mesh.vertexCount());
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    ASSERT_NEAR(vec3(field.tangents[v]).norm(), 1, 1e-5);
    ASSERT_NEAR(vec3(field.tangents[v]).dot(vec3(mesh.normals[v])), 0, 1e-5);
  }
}

// Poincaré and Hopf: indices sum to the Euler characteristic.
TEST(DirectionField, IndicesSumToTheEulerCharacteristic) {
  const TriangleMesh sphere = retiled(tests::icosphere(3), 8'000), torus = retiled(tests::torus(24), 8'000);
  for (const int symmetry : {1, 2, 4}) {
    const DirectionField on_sphere = fieldOf(sphere, symmetry);
    EXPECT_EQ(on_sphere.index_sum, 2 * symmetry);
    // The smoothest one has no more than it needs.
    EXPECT_EQ(on_sphere.singularities.size(), static_cast<std::size_t>(2 * symmetry));
    const DirectionField on_torus = fieldOf(torus, symmetry);
    EXPECT_EQ(on_torus.index_sum, 0);
    // One direction goes round; pairs of opposite index can be smoother for others.
    EXPECT_TRUE(symmetry != 1 || on_torus.singularities.empty());
  }
}

TEST(DirectionField, IsConstantOnAPlane) {
  const TriangleMesh mesh = retiled(tests::square(), 8'000);
  for (const int symmetry : {1, 2, 4}) {
    const DirectionField field = fieldOf(mesh, symmetry);
    EXPECT_TRUE(field.singularities.empty());
    EXPECT_LT(turnAlongEdges(mesh, field, symmetry), 1e-3);
  }
}

TEST(DirectionField, TurnsLittleBetweenNeighbours) {
  const TriangleMesh mesh = retiled(tests::torus(24), 10'000);
  EXPECT_LT(turnAlongEdges(mesh, fieldOf(mesh, 1), 1), 0.2);
}

TEST(DirectionField, FollowsHints) {
  const TriangleMesh mesh = retiled(tests::square(), 8'000);
  const DirectionHint one = {{0.5F, 0.5F, 0.001F}, {1, 2, 3}};
  const Vec3 wanted = Vec3(1, 2, 0).normalized();
  for (const int symmetry : {1, 4}) {
    const DirectionField field = fieldOf(mesh, symmetry, std::span(&one, 1));
    double farthest = 0;
    for (const auto& t : field.tangents) {
      double best = 0;
      for (int r = 0; r < symmetry; ++r) {
        const double angle = 2 * std::numbers::pi * r / symmetry;
        best =
            std::max(best, vec3(t).dot(Vec3(std::cos(angle) * wanted.x() - std::sin(angle) * wanted.y(),
                                            std::sin(angle) * wanted.x() + std::cos(angle) * wanted.y(), 0)));
      }
      farthest = std::max(farthest, 1 - best);
    }
    EXPECT_LT(farthest, 1e-4);
  }
  // Two that differ: each where it was asked for, and no singularity between.
  const std::vector<DirectionHint> two = {{{0.1F, 0.5F, 0}, {1, 0, 0}}, {{0.9F, 0.5F, 0}, {0, 1, 0}}};
  const DirectionField field = fieldOf(mesh, 1, two);
  EXPECT_TRUE(field.singularities.empty());
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v)
    for (const DirectionHint& hint : two) {
      const bool is_near = (vec3(mesh.positions[v]) - vec3(hint.point)).norm() < 0.02;
      ASSERT_TRUE(!is_near || vec3(field.tangents[v]).dot(vec3(hint.direction)) > 0.9);
    }
  EXPECT_LT(turnAlongEdges(mesh, field, 1), 0.3);
}

TEST(DirectionField, IsNotCarriedOverCreases) {
  const TriangleMesh mesh = retiled(tests::cube(), 10'000);
  // One side follows the hint, its neighbours are free of it: each constant by itself.
  const DirectionHint hint = {{0, 0, 0.5F}, {1, 0.3F, 0}};
  const DirectionField field = fieldOf(mesh, 4, std::span(&hint, 1));
  EXPECT_TRUE(field.singularities.empty());
  EXPECT_LT(turnAlongEdges(mesh, field, 4), 1e-3);
}

TEST(DirectionField, PassesBordersBetweenMaterials) {
  TriangleMesh mesh = tests::square(8);
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    mesh.triangle_materials.push_back(t / 2 % 8 < 4 ? 1 : 0);
  mesh.material_names = {"a", "b"};
  const TriangleMesh tiles = retiled(mesh, 10'000);
  const DirectionHint hint = {{0.1F, 0.1F, 0}, {1, 2, 0}};
  const DirectionField field = fieldOf(tiles, 1, std::span(&hint, 1));
  const Vec3 wanted = Vec3(1, 2, 0).normalized();
  for (const auto& t : field.tangents) ASSERT_GT(vec3(t).dot(wanted), 0.999);
}

TEST(DirectionField, AnyNumberOfThreadsGivesTheSameBytes) {
  const TriangleMesh mesh = retiled(tests::torus(24), 8'000);
  const DirectionField many = fieldOf(mesh, 4);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many.tangents, fieldOf(mesh, 4).tangents);
}

TEST(DirectionField, HintsThatSayNothingAreRefusedOrTold) {
  const TriangleMesh mesh = retiled(tests::square(), 2'000);
  const auto errorOf = [](const auto& action) -> std::string {
    try {
      action();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const DirectionHint along_normal = {{0.5F, 0.5F, 0}, {0, 0, 1}}, far = {{0.5F, 0.5F, 1}, {1, 0, 0}};
  EXPECT_THAT(errorOf([&] { fieldOf(mesh, 1, std::span(&along_normal, 1)); }),
              AllOf(HasSubstr("hints.json"), HasSubstr("/0/direction"), HasSubstr("normal")));
  EXPECT_THAT(fieldOf(mesh, 1, std::span(&far, 1)).warnings, testing::ElementsAre(HasSubstr("hint 0")));

  const tests::TemporaryFolder folder;
  const auto read = [&](const char* text) {
    formats::writeFileAtomically(folder / "h.json", std::string_view(text));
    return readHints(folder / "h.json");
  };
  const auto hints = read(R"([{"point": [1, 2, 3], "direction": [0, 1, 0]}])");
  ASSERT_EQ(hints.size(), 1U);
  EXPECT_EQ(hints[0].point, (formats::Float3{1, 2, 3}));
  EXPECT_THAT(errorOf([&] { read(R"({"point": [1, 2, 3]})"); }), HasSubstr("a list of"));
  EXPECT_THAT(errorOf([&] { read(R"([{"point": [1, 2, 3]}])"); }),
              AllOf(HasSubstr("/0"), HasSubstr("direction")));
  EXPECT_THAT(errorOf([&] { read(R"([{"point": [1, 2, 3], "direction": [0, 0, 0]}])"); }),
              HasSubstr("no length"));
  EXPECT_THAT(errorOf([&] { read(R"([{"point": [1, 2, 3], "direction": [0, 1, 0], "wieght": 1}])"); }),
              HasSubstr("wieght"));
}

}  // namespace
}  // namespace bakelight::mesomesh
