#include "transport/bi_scale_shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/made_rtt.h"
#include "transport/hemisphere_grid.h"
#include "transport/triple_product.h"

namespace bakelight::transport {
namespace {

using formats::Pack;
using formats::RttReflection;

constexpr int kOrder = 5;

// What an unshadowed point facing +z receives: the light of its hemisphere, in its frame.
std::vector<float> openMatrix(const Eigen::Matrix3d& local_from_object) {
  const int count = coefficientCount(kOrder);
  std::vector<float> matrix(static_cast<std::size_t>(count) * count);
  // The hemisphere above the normal as an SH vector in the object's frame.
  const int order = 2 * kOrder - 1;
  std::vector<double> zonal(static_cast<std::size_t>(order));
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double z = (i + 0.5) / kSteps;
    const std::vector<double> values = evaluateSh(order, Vec3(std::sqrt(1 - z * z), 0, z));
    for (int l = 0; l < order; ++l)
      zonal[l] += 2 * std::numbers::pi * values[static_cast<std::size_t>(l * (l + 1))] / kSteps;
  }
  std::vector<float> visibility(static_cast<std::size_t>(order) * order, 0.0F);
  for (int l = 0; l < order; ++l)
    visibility[static_cast<std::size_t>(l * (l + 1))] = static_cast<float>(zonal[l]);
  TripleProduct(kOrder, kOrder).matrixOf(visibility, matrix);  // local light to local light
  const ShRotation rotation(kOrder, local_from_object);
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(count, count);
  for (int l = 0; l < kOrder; ++l) turn.block(l * l, l * l, 2 * l + 1, 2 * l + 1) = rotation.band(l);
  const Eigen::MatrixXf product =
      Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(matrix.data(), count,
                                                                                        count) *
      turn.cast<float>();
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) matrix[static_cast<std::size_t>(i) * count + j] = product(i, j);
  return matrix;
}

// A square in the plane of x and z that faces up, u along x and v along −z; its frames' tangents along x turned by `turn` about
// the normal.
Pack squarePack(const RttReflection& rtt, double turn = 0) {
  Pack pack;
  for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, -1), Vec3(0, 0, -1)}) {
    pack.mesh.positions.push_back(float3(corner));
    pack.mesh.normals.push_back({0, 1, 0});
    pack.mesh.texcoords.push_back({static_cast<float>(corner.x()), static_cast<float>(-corner.z())});
  }
  pack.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Vec3 t(std::cos(turn), 0, -std::sin(turn)), n(0, 1, 0);
  Eigen::Matrix3d local;
  local.row(0) = t;
  local.row(1) = n.cross(t);
  local.row(2) = n;
  formats::ShTransfer transfer;
  transfer.order = kOrder;
  formats::GlossyTransfer& glossy = transfer.glossy.emplace();
  glossy.output_order = kOrder;
  std::vector<float> matrices, one = openMatrix(local);
  for (int v = 0; v < 4; ++v) {
    glossy.tangents.push_back({static_cast<float>(t.x()), 0, static_cast<float>(t.z()), 1});
    matrices.insert(matrices.end(), one.begin(), one.end());
  }
  glossy.transfer = formats::MatrixOperator{
      formats::encodeTable(matrices, one.size(), formats::Precision::kFloat32, "made", "matrices")};
  transfer.vectors =
      formats::encodeTable(std::vector<float>(4 * 25, 0.0F), 25, formats::Precision::kFloat32, "made", "");
  pack.transfer = transfer;
  pack.appearances.front().reflection = rtt;
  return pack;
}

ShLight constantLight(const Float3& radiance) {
  ShLight light(static_cast<std::size_t>(coefficientCount(kOrder)), Float3{0, 0, 0});
  for (std::size_t c = 0; c < 3; ++c)
    light[0][c] = radiance[c] * static_cast<float>(std::sqrt(4 * std::numbers::pi));
  return light;
}

Float3 radianceAt(const Pack& pack, const ShLight& light, const ViewPoint& view, float u, float v) {
  BiScaleShading shading(pack);
  shading.setLight(light, {});
  shading.setView(view);
  const SurfaceHit hit{0, u, v};
  Float3 radiance;
  shading.radianceAt({&hit, 1}, {&radiance, 1});
  return radiance;
}

// One component that is `value` of place (u, v) and view; basis: the flat patch.
RttReflection rttOf(int views, int width, int height,
                    const std::function<double(double u, double v, const Vec3& view)>& value) {
  RttReflection rtt = flatReflection(kOrder);
  rtt.views = views;
  rtt.width = width;
  rtt.height = height;
  std::vector<float> factors;
  for (const formats::RttLevel& level : formats::rttLevels(width, height))
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        for (int row = 0; row < views; ++row)
          for (int column = 0; column < views; ++column)
            factors.push_back(static_cast<float>(value((x + 0.5) / level.width, 1 - (y + 0.5) / level.height,
                                                       hemisphereCell(views, column, row))));
  rtt.factors = formats::encodeTable(factors, 1, formats::Precision::kFloat32, "made", "factors");
  return rtt;
}

// Bands 0 and 1 are all that the clamped cosine and a hemisphere of constant light share: exact at any order.
TEST(BiScaleShading, FlatPatchUnderUniformLightReturnsIt) {
  const Float3 radiance =
      radianceAt(squarePack(rttOf(1, 1, 1, [](double, double, const Vec3&) { return 1; })),
                 constantLight({1, 2, 0.5F}), Vec3(3, 4, 5), 0.3F, 0.2F);
  EXPECT_NEAR(radiance[0], 1, 1e-4);
  EXPECT_NEAR(radiance[1], 2, 2e-4);
  EXPECT_NEAR(radiance[2], 0.5, 1e-4);
}

// A view from +x of a frame whose tangent is x looks up +x; of a turned frame the direction turned back.
TEST(BiScaleShading, ViewsAreOfTheVertexFrame) {
  const RttReflection rtt =
      rttOf(8, 1, 1, [](double, double, const Vec3& view) { return 2 + view.x() + 0.1 * view.y(); });
  const Vec3 at(1, 0, -0.5);  // of triangle 0: u = v = 0.5
  for (const double turn : {0.0, 0.5, -2.0}) {
    for (const Vec3& towards : {Vec3(1, 1, 0), Vec3(-1, 1.5, 0.4), Vec3(0, 1, -1)}) {
      const Vec3 t(std::cos(turn), 0, -std::sin(turn)), b = Vec3(0, 1, 0).cross(t), d = towards.normalized();
      const Float3 radiance =
          radianceAt(squarePack(rtt, turn), constantLight({1, 1, 1}), Vec3(at + 3 * d), 0.5F, 0.5F);
      EXPECT_NEAR(radiance[0], 2 + d.dot(t) + 0.1 * d.dot(b), 0.03) << turn;  // linear between cells
    }
  }
}

// A sun of 1e6 beside a sky of 1, along relief and between levels: the sum of both, to the digits of the larger.
TEST(BiScaleShading, IsLinearInTheLight) {
  RttReflection rtt = tests::madeRtt(kOrder, 4, 16, 8, 12);
  rtt.patch_width = 0.3F;
  const Pack pack = squarePack(rtt);
  const ShLight sky = constantLight({1, 0.9F, 0.8F});
  ShLight sun(sky.size(), Float3{0, 0, 0}), both = sky;
  const std::vector<double> basis = evaluateSh(kOrder, Vec3(0.3, 0.9, 0.2).normalized());
  for (std::size_t i = 0; i < sun.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      sun[i][c] = static_cast<float>(1e6 * basis[i]);
      both[i][c] += sun[i][c];
    }
  for (const double slope : {0.1, 1.0, 6.0}) {
    const ViewPoint view(Vec3(slope, 1, -0.2), 0.02);
    const Float3 of_sky = radianceAt(pack, sky, view, 0.3F, 0.4F),
                 of_sun = radianceAt(pack, sun, view, 0.3F, 0.4F),
                 of_both = radianceAt(pack, both, view, 0.3F, 0.4F);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_GT(std::abs(of_sun[c]), 100);
      EXPECT_NEAR(of_both[c], of_sun[c] + of_sky[c], 2e-6 * 1e6) << slope;
    }
  }
}

// The patch's lower left is at small u and v; it is repeated.
TEST(BiScaleShading, PlacesFollowTextureCoordinates) {
  RttReflection rtt = rttOf(1, 16, 8, [](double u, double v, const Vec3&) { return 1 + u + 10 * v; });
  const auto at = [&](float x, float z) {
    // Triangle 0 has corners (0, 0), (1, 0), (1, −1): u + v along x, v along −z.
    return radianceAt(squarePack(rtt), constantLight({1, 1, 1}), Vec3(0.5, 4, -0.5), x + z, -z)[0];
  };
  rtt.repeats = 1;
  EXPECT_NEAR(at(0.72F, -0.1F), 1 + 0.71875 + 10 * 0.1875, 1e-2);
  rtt.repeats = 2;
  EXPECT_NEAR(at(0.86F, -0.1F), 1 + 0.71875 + 10 * 0.4375, 1e-2);
}

TEST(BiScaleShading, AnIndexSaysWhereThePatchIs) {
  RttReflection rtt = rttOf(1, 16, 16, [](double u, double v, const Vec3&) { return 1 + u + 10 * v; });
  rtt.index = tests::madeIndex(2, 2);
  const auto code = [&](std::size_t texel, std::size_t c) {
    return static_cast<int>(rtt.index->texels.data[2 * texel + c]) / 16;  // texel of 16
  };
  // The lower right of the index: the last of four.
  const Float3 radiance =
      radianceAt(squarePack(rtt), constantLight({1, 1, 1}), Vec3(0.5, 4, -0.5), 0.5F, 0.2F);
  EXPECT_NEAR(radiance[0], 1 + (code(3, 0) + 0.5) / 16 + 10 * (code(3, 1) + 0.5) / 16, 2e-3);
}

// From afar everything is the mean, and in between neither more nor less of it.
TEST(BiScaleShading, FarPatchesAreTheirMean) {
  RttReflection rtt =
      rttOf(1, 16, 16, [](double u, double v, const Vec3&) { return std::lround(16 * (u + v) - 1) % 2; });
  std::vector<float> factors = rtt.factors.decode();
  std::fill(factors.begin() + 256, factors.end(), 0.5F);  // the levels above
  rtt.factors = formats::encodeTable(factors, 1, formats::Precision::kFloat32, "made", "factors");
  rtt.patch_width = 0.1F;
  const Pack pack = squarePack(rtt);
  const auto at = [&](double distance) {
    return radianceAt(pack, constantLight({1, 1, 1}), {Vec3(0.7, distance, -0.2), 1e-3}, 0.52F, 0.21F)[0];
  };
  EXPECT_NEAR(std::abs(at(1) - 0.5), 0.5, 1e-3);
  EXPECT_NEAR(at(100), 0.5, 1e-3);
  EXPECT_NEAR(at(1e6), 0.5, 1e-3);
}

TEST(BiScaleShading, LevelsDoubleWithDistance) {
  EXPECT_EQ(rttLevelOf(1, 0.01, 1, 0.02), 0);
  EXPECT_NEAR(rttLevelOf(4, 0.01, 1, 0.01), 2, 1e-12);
  EXPECT_NEAR(rttLevelOf(8, 0.01, 1, 0.01), 3, 1e-12);
  EXPECT_NEAR(rttLevelOf(4, 0.01, 0.25, 0.01), 3, 1e-12);  // by area
  EXPECT_EQ(rttLevelOf(4, 0, 1, 0.01), 0);
}

TEST(BiScaleShading, RefusesWhatDoesNotFit) {
  RttReflection rtt = rttOf(2, 4, 4, [](double, double, const Vec3&) { return 1; });
  Pack pack = squarePack(rtt);
  pack.mesh.texcoords.clear();
  EXPECT_THROW(BiScaleShading{pack}, std::invalid_argument);
  rtt.width = 8;
  EXPECT_THROW(BiScaleShading{squarePack(rtt)}, std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
