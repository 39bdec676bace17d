#include "transport/all_frequency_shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "tests/support/compressed_transfer.h"
#include "tests/support/made_pixel_pack.h"
#include "tests/support/shapes.h"
#include "transport/cube_light.h"
#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"
#include "transport/light_backdrop.h"
#include "transport/light_rig.h"
#include "transport/patch_lookup.h"

namespace bakelight::transport {
namespace {

using namespace bakelight::tests;
using formats::BtfReflection;
using formats::Pack;
using formats::PixelRows;

constexpr double kPi = std::numbers::pi;
constexpr int kSide = 16, kLocal = 8;

Vec3 middleOf(std::size_t texel, int side) {
  const auto i = static_cast<int>(texel);
  return directionOfCubeFace(i / (side * side), (i % side + 0.5) / side, (i / side % side + 0.5) / side);
}

// Of a convex body: whole texels above the tangent plane.
formats::PixelTransfer unshadowed(const TriangleMesh& mesh, const std::vector<formats::Float4>& tangents) {
  PixelRows rows;
  rows.cube_side = kSide;
  rows.local_side = kLocal;
  rows.subsamples = 1;
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    const Eigen::Matrix3d local = localFrame(mesh.normals[v], tangents[v]);
    std::vector<std::vector<std::uint16_t>> cells(kLocal * kLocal);
    for (std::size_t texel = 0; texel < rows.view().columnCount(); ++texel) {
      const Vec3 direction = local * middleOf(texel, kSide);
      if (direction.z() <= 0) continue;
      const SquarePoint place = squareFromHemisphere(direction);
      const int x = std::min(static_cast<int>(place.a * kLocal), kLocal - 1),
                y = std::min(static_cast<int>(place.b * kLocal), kLocal - 1);
      cells[static_cast<std::size_t>(y * kLocal + x)].push_back(static_cast<std::uint16_t>(texel));
    }
    for (const auto& cell : cells) {
      rows.columns.insert(rows.columns.end(), cell.begin(), cell.end());
      rows.row_offsets.push_back(rows.columns.size());
    }
  }
  rows.codes.assign(rows.columns.size(), 1);
  return formats::pixelTransferOf(rows.view(), tangents);
}

std::vector<formats::Float4> anyTangents(const TriangleMesh& mesh) {
  std::vector<formats::Float4> tangents;
  for (const Float3& normal : mesh.normals) {
    const Float3 t = float3(vec3(normal).unitOrthogonal());
    tangents.push_back({t[0], t[1], t[2], 1});
  }
  return tangents;
}

Pack ballPack(formats::PackPart reflection) {
  Pack pack{.name = "ball", .mesh = icosphere(2)};
  addSphericalTexcoords(pack.mesh);
  pack.transfer = unshadowed(pack.mesh, anyTangents(pack.mesh));
  pack.appearances.front().reflection = std::move(reflection);
  return pack;
}

std::vector<Float3> uniformCube(const Float3& radiance) {
  return std::vector<Float3>(6 * kSide * kSide, radiance);
}
std::vector<Float3> someCube() {
  std::vector<Float3> light;
  for (std::size_t i = 0; i < 6 * kSide * kSide; ++i)
    light.push_back({static_cast<float>(i % 7), static_cast<float>(i % 11) * 0.5F, i == 700 ? 1e6F : 1.0F});
  return light;
}

std::vector<SurfaceHit> someHits(const TriangleMesh& mesh) {
  std::vector<SurfaceHit> hits;
  for (std::uint32_t t = 0; t < mesh.triangleCount(); t += 7) hits.push_back({t, 0.3F, 0.25F});
  return hits;
}
std::vector<Float3> shade(AllFrequencyShading& shading, const std::vector<Float3>& light,
                          const TriangleMesh& mesh, const Vec3& eye = Vec3(0.4, 3, 2)) {
  shading.setCubeLight(light);
  shading.setView({eye, 0});
  const std::vector<SurfaceHit> hits = someHits(mesh);
  std::vector<Float3> radiance(hits.size());
  shading.radianceAt(hits, radiance);
  return radiance;
}

TEST(HemisphereCellCosine, IsTheMeanOverTheCell) {
  for (const int side : {1, 2, 3, 5, 8, 32}) {
    double sum = 0;
    for (int row = 0; row < side; ++row)
      for (int column = 0; column < side; ++column) {
        const double cosine = hemisphereCellCosine(side, column, row);
        sum += cosine;
        if (side > 5) continue;
        constexpr int kPoints = 200;
        double mean = 0;
        for (int j = 0; j < kPoints; ++j)
          for (int i = 0; i < kPoints; ++i)
            mean += hemisphereFromSquare((column + (i + 0.5) / kPoints) / side,
                                         (row + (j + 0.5) / kPoints) / side)
                        .z();
        EXPECT_NEAR(cosine, mean / (kPoints * kPoints), 5e-5) << side << " " << column << " " << row;
      }
    EXPECT_NEAR(sum, side * side / 2.0, 1e-10 * side * side);
  }
}

TEST(AllFrequencyShading, IsTakenForItsPacks) {
  const Pack lambert = ballPack(formats::LambertReflection());
  EXPECT_TRUE(AllFrequencyShading::shades(lambert));
  EXPECT_TRUE(AllFrequencyShading::shades(ballPack(flatBtf(kLocal))));
  EXPECT_FALSE(AllFrequencyShading::shades(ballPack(formats::PhongLobe{})));
  EXPECT_EQ(makePackShading(lambert)->needs().cube_side, kSide);
  EXPECT_THROW(makePackShading(ballPack(flatBtf(4))), std::invalid_argument);
  AllFrequencyShading shading(lambert);
  EXPECT_THROW(shading.setLight({}, {}), std::logic_error);
  EXPECT_THROW(shading.setCubeLight(std::vector<Float3>(5)), std::invalid_argument);
}

// A white surface sends back what it receives, as a BTF as well as a Lambertian; but for texels at the horizon.
TEST(AllFrequencyShading, Furnace) {
  Pack lambert = ballPack(formats::LambertReflection());
  lambert.appearances.front().base_color = {1, 0.5F, 0.25F};
  for (const Pack& pack : {lambert, ballPack(flatBtf(kLocal))}) {
    const bool is_btf = pack.appearances.front().reflection.as<BtfReflection>() != nullptr;
    AllFrequencyShading shading(pack);
    for (const Float3& radiance : shade(shading, uniformCube({2, 2, 2}), pack.mesh)) {
      EXPECT_NEAR(radiance[0], 2, 0.012);
      EXPECT_NEAR(radiance[2], is_btf ? 2 : 0.5, 0.012);
    }
  }
}

TEST(AllFrequencyShading, IncidentIsRadianceTimesSolidAngle) {
  const Pack pack = ballPack(formats::LambertReflection());
  AllFrequencyShading shading(pack);
  shading.setCubeLight(uniformCube({1, 1, 1}));
  double sum = 0;
  for (const Float3& cell : shading.incident(17)) sum += cell[0];
  EXPECT_NEAR(sum, 2 * kPi, 0.01 * 2 * kPi);
}

// What another method made of the transfer takes the place of its own.
TEST(AllFrequencyShading, TakesIncidentLightFromElsewhere) {
  const Pack pack = ballPack(madeBtf(kLocal, 4, 8, 8, 6));
  const formats::PixelTransferRows rows(*pack.transfer.as<formats::PixelTransfer>());
  AllFrequencyShading shading(pack);
  const std::vector<Float3> expected = shade(shading, someCube(), pack.mesh);
  const std::vector<Float3> light = texelLight(someCube(), kSide, 1);
  std::vector<Radiance4> energies, incident(rows.view().rowCount());
  for (const Float3& texel : light) energies.emplace_back(texel[0], texel[1], texel[2], 0);
  multiply(rows.view(), energies, incident);
  AllFrequencyShading other(pack);
  other.setIncident(incident);
  other.setView({Vec3(0.4, 3, 2), 0});
  const std::vector<SurfaceHit> hits = someHits(pack.mesh);
  std::vector<Float3> radiance(hits.size());
  other.radianceAt(hits, radiance);
  for (std::size_t i = 0; i < hits.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(radiance[i][c], expected[i][c], 1e-4 * (1 + std::abs(expected[i][c])));
  incident.pop_back();
  EXPECT_THROW(other.setIncident(incident), std::invalid_argument);
}

// A sun of 1e6 over a sky, too: in relation to its own brightness.
TEST(AllFrequencyShading, IsLinearInTheLight) {
  const Pack pack = ballPack(madeBtf(kLocal, 4, 8, 8, 6));
  AllFrequencyShading shading(pack);
  const std::vector<Float3> some = someCube(), uniform = uniformCube({1, 2, 3});
  std::vector<Float3> both = some;
  for (std::size_t i = 0; i < both.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) both[i][c] = 2 * some[i][c] + uniform[i][c];
  const auto of_some = shade(shading, some, pack.mesh), of_uniform = shade(shading, uniform, pack.mesh),
             of_both = shade(shading, both, pack.mesh);
  float most = 0;
  for (std::size_t i = 0; i < of_both.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(of_both[i][c], 2 * of_some[i][c] + of_uniform[i][c], 2e-6 * std::abs(of_both[i][c]) + 2e-6);
      most = std::max(most, of_both[i][c]);
    }
  EXPECT_GT(most, 100);
}

// Turning light, mesh, frames and eye together changes nothing: by 90°, which turns a cube map into itself.
TEST(AllFrequencyShading, TurnsWithTheLight) {
  const Pack pack = ballPack(madeBtf(kLocal, 4, 8, 8, 6));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(kPi / 2, Vec3::UnitZ()).toRotationMatrix();
  Pack turned = pack;
  std::vector<formats::Float4> tangents = anyTangents(pack.mesh);
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    turned.mesh.positions[v] = float3(turn * vec3(pack.mesh.positions[v]));
    turned.mesh.normals[v] = float3(turn * vec3(pack.mesh.normals[v]));
    const Float3 t = float3(turn * Vec3(tangents[v][0], tangents[v][1], tangents[v][2]));
    tangents[v] = {t[0], t[1], t[2], 1};
  }
  turned.transfer = unshadowed(turned.mesh, tangents);
  const std::vector<Float3> light = someCube();
  std::vector<Float3> turned_light(light.size());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const auto [face, s, t] = cubeFaceOfDirection(turn * middleOf(i, kSide));
    turned_light[static_cast<std::size_t>((face * kSide + static_cast<int>(t * kSide)) * kSide +
                                          static_cast<int>(s * kSide))] = light[i];
  }
  AllFrequencyShading shading(pack), turned_shading(turned);
  const Vec3 eye(0.4, 3, 2);
  const auto expected = shade(shading, light, pack.mesh, eye),
             got = shade(turned_shading, turned_light, turned.mesh, turn * eye);
  double squared = 0, difference = 0;
  for (std::size_t i = 0; i < got.size(); ++i)
    for (std::size_t c = 0; c < 2; ++c) {  // blue has the sun: one texel may change its cell by a rounding
      squared += expected[i][c] * expected[i][c];
      difference += std::pow(got[i][c] - expected[i][c], 2);
    }
  EXPECT_LT(std::sqrt(difference / squared), 2e-3);
}

// The mean over L* of Lambertian and of BTF at the same place: a triangle whose frames differ too much takes the nearest corner.
TEST(AllFrequencyShading, DoesNotInterpolateAcrossCreases) {
  Pack pack{.name = "fold", .mesh = {}};
  pack.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  pack.mesh.normals = {{0, 0, 1}, {1, 0, 0}, {0, 0, 1}};
  pack.mesh.triangles = {{0, 1, 2}};
  const std::vector<formats::Float4> tangents = {{1, 0, 0, 1}, {0, 0, -1, 1}, {1, 0, 0, 1}};
  formats::PixelTransfer transfer = unshadowed(pack.mesh, tangents);
  std::vector<Float3> light(6 * kSide * kSide, Float3{0, 0, 0});
  for (std::size_t i = 0; i < light.size(); ++i)
    if (middleOf(i, kSide).z() > 0) light[i] = {1, 1, 1};
  const auto redAt = [&](float u) {
    AllFrequencyShading shading(pack);
    shading.setCubeLight(light);
    shading.setView({Vec3(2, 1, 3), 0});
    std::vector<Float3> radiance(1);
    shading.radianceAt(std::vector<SurfaceHit>{{0, u, 0.1F}}, radiance);
    return radiance[0][0];
  };
  pack.transfer = transfer;
  pack.appearances.front().base_color = {1, 1, 1};
  EXPECT_NEAR(redAt(0.2F), 1, 0.02);    // corner 0 sees all of the sky
  EXPECT_NEAR(redAt(0.8F), 0.5, 0.02);  // corner 1 half
  transfer.crease_angle = 120;
  pack.transfer = transfer;
  EXPECT_NEAR(redAt(0.4F), 0.8, 0.02);
  transfer.tangents[1][3] = -1;  // another handedness
  pack.transfer = transfer;
  EXPECT_NEAR(redAt(0.2F), 1, 0.02);
}

// Vertices that share blocks, blocks that none has, a block in which nothing is seen, under a sun.
TEST(AllFrequencyShading, OfSumsIsThatOfRows) {
  Pack pack = ballPack(flatBtf(kLocal));
  const formats::PixelTransfer whole = unshadowed(pack.mesh, anyTangents(pack.mesh));
  const formats::PixelTransferRows read(whole);
  PixelRows seen;
  seen.cube_side = kSide, seen.local_side = kLocal, seen.subsamples = 1;
  for (std::size_t row = 0; row < read.view().rowCount(); ++row) {
    for (std::uint64_t i = read.view().row_offsets[row]; i < read.view().row_offsets[row + 1]; ++i)
      if (row / whole.cells() != 12 && row % 7 != 0) seen.columns.push_back(read.view().columns[i]);
    seen.row_offsets.push_back(seen.columns.size());
  }
  seen.codes.assign(seen.columns.size(), 1);
  formats::PixelTransfer rows = formats::pixelTransferOf(seen.view(), whole.tangents);
  rows.blocks[3] = rows.blocks[4] = 8;
  pack.transfer = rows;
  AllFrequencyShading of_rows(pack);
  pack.transfer = compressed(rows, {.rows_per_tile = 3000});
  const formats::SumGrammar& grammar = *pack.transfer.as<formats::PixelTransfer>()->sums->grammar;
  ASSERT_GT(grammar.tileCount(), 1U);
  ASSERT_LT(grammar.row_places.size(), grammar.row_count);
  AllFrequencyShading of_sums(pack);
  of_rows.setCubeLight(someCube()), of_sums.setCubeLight(someCube());
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    const std::vector<Float3> expected = of_rows.incident(v), found = of_sums.incident(v);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t cell = 0; cell < found.size(); ++cell)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(found[cell][c], expected[cell][c], 1e-6 * expected[cell][c]) << v << " " << cell;
  }
  EXPECT_EQ(shade(of_sums, someCube(), pack.mesh).size(), someHits(pack.mesh).size());
  pack.transfer.as<formats::PixelTransfer>()->sums->grammar = nullptr;
  EXPECT_THROW(AllFrequencyShading{pack}, std::invalid_argument);
}

TEST(AllFrequencyShading, TakesSeveralMaterials) {
  Pack pack = ballPack(flatBtf(kLocal));
  TriangleMesh& mesh = pack.mesh;
  const TriangleMesh other = icosphere(1, 0.5, Vec3(3, 0, 0));
  const std::size_t first = mesh.vertexCount(), triangles = mesh.triangleCount();
  append(mesh, other);
  mesh.texcoords.resize(mesh.vertexCount(), {0.5F, 0.5F});
  mesh.material_names = {"white", "grey"};
  mesh.triangle_materials.assign(triangles, 0);
  mesh.triangle_materials.resize(mesh.triangleCount(), 1);
  pack.transfer = unshadowed(mesh, anyTangents(mesh));
  pack.appearances = {{"white", {1, 1, 1}, flatBtf(kLocal)}, {"grey", {0.5F, 0.5F, 0.5F}}};
  BtfReflection half = flatBtf(kLocal);
  for (float& value : half.basis) value *= 0.25F;
  AllFrequencyShading shading(pack);
  shading.setCubeLight(uniformCube({1, 1, 1}));
  shading.setView({Vec3(0, 9, 2), 0});
  std::vector<SurfaceHit> hits = {{3, 0.2F, 0.2F}, {static_cast<std::uint32_t>(triangles) + 3, 0.2F, 0.2F}};
  std::vector<Float3> radiance(2);
  shading.radianceAt(hits, radiance);
  EXPECT_NEAR(radiance[0][0], 1, 0.012);
  EXPECT_NEAR(radiance[1][0], 0.5, 0.012);
  pack.appearances[1].reflection = half;
  AllFrequencyShading of_two(pack);
  of_two.setCubeLight(uniformCube({1, 1, 1}));
  of_two.radianceAt(hits, radiance);
  EXPECT_NEAR(radiance[1][0], 0.25, 0.012);
  EXPECT_GT(first, 0U);
}

// ---- light as cube maps

Eigen::Array3d energyOf(const std::vector<Float3>& cube, int side) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (std::size_t i = 0; i < cube.size(); ++i) {
    const auto within = static_cast<int>(i) % (side * side);
    sum += vec3(cube[i]).array() * cubeTexelSolidAngle(within % side, within / side, side);
  }
  return sum;
}

Eigen::Matrix3d someTurn() {
  return Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
}

TEST(CubeLight, KeepsTheEnergyOfEachLight) {
  formats::DiskLight sun;
  sun.direction = {0.3F, 0.8F, -0.2F};
  sun.half_angle_deg = 0.265;
  sun.radiance = {1e6F, 9e5F, 1};
  formats::DirectionalLight point;
  point.irradiance = {3, 2, 1};
  formats::PolygonLight window;
  window.vertices = {{-0.5F, 1, -0.5F}, {0.5F, 1, -0.5F}, {0.5F, 1, 0.7F}, {-0.5F, 1, 0.7F}};
  const double sine = std::sin(0.265 / 2 * kPi / 180);
  for (const int side : {1, 7, 32}) {
    const auto energy = [&](const formats::DistantLight& light) {
      return energyOf(cubeLight(std::vector{light}, side, someTurn()), side);
    };
    EXPECT_NEAR(energy(sun)[0] / (1e6 * 4 * kPi * sine * sine), 1, 1e-5);
    EXPECT_NEAR(energy(point)[1], 2, 1e-5);
    formats::PolygonLight small = window;
    for (auto& vertex : small.vertices) vertex = {vertex[0] * 1e-3F, 1, vertex[2] * 1e-3F};
    EXPECT_NEAR(energy(small)[0] / 1.2e-6, 1, 1e-3);
  }
  // A sun is where it is.
  const std::vector<Float3> cube = cubeLight(std::vector<formats::DistantLight>{sun}, 32, someTurn());
  for (std::size_t i = 0; i < cube.size(); ++i)
    if (cube[i][0] > 0) {
      EXPECT_GT(middleOf(i, 32).dot(someTurn() * vec3(sun.direction).normalized()), std::cos(0.05));
    }
}

TEST(CubeLight, OfImagesIsTheirs) {
  formats::EnvironmentLight light;
  light.image = formats::Image(64, 32, {"R", "G", "B"});
  double energy = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      light.image.texel(x, y)[0] = 2;
      light.image.texel(x, y)[1] = x == 40 && y == 9 ? 1e6F : 0.0F;
      light.image.texel(x, y)[2] = y < 16 ? 1.0F : 0.0F;
      if (y == 9 && x == 40) energy = 1e6 * latLongTexelSolidAngle(9, 64, 32);
    }
  light.intensity = 0.5;
  light.yaw_deg = 30;
  const std::vector<Float3> cube =
      cubeLight(std::vector<formats::DistantLight>{light}, 32, Eigen::Matrix3d::Identity());
  EXPECT_NEAR(energyOf(cube, 32)[0], 4 * kPi, 1e-4);
  EXPECT_NEAR(energyOf(cube, 32)[1] / (0.5 * energy), 1, 1e-5);
  for (std::size_t i = 0; i < cube.size(); ++i) {
    EXPECT_NEAR(cube[i][0], 1, 0.04);
    const double height = middleOf(i, 32).y();
    if (std::abs(height) > 0.06) {
      EXPECT_NEAR(cube[i][2], height > 0 ? 0.5 : 0, 0.02);
    }
  }
  // A texel's light is where it is, however it is turned.
  const Vec3 there = someTurn() * worldFromEnvironment(light) * directionOfLatLong(40.5 / 64, 9.5 / 32);
  const std::vector<Float3> turned = cubeLight(std::vector<formats::DistantLight>{light}, 32, someTurn());
  for (std::size_t i = 0; i < turned.size(); ++i)
    if (turned[i][1] > 0) {
      EXPECT_GT(middleOf(i, 32).dot(there), std::cos(0.1));
    }
  // As a cube map, turned nowhere, an image of the same size is itself.
  formats::EnvironmentLight strip;
  strip.image = formats::Image(6 * 8, 8, {"R", "G", "B"});
  for (std::size_t i = 0; i < strip.image.values.size(); ++i)
    strip.image.values[i] = static_cast<float>(i % 13);
  const std::vector<Float3> same =
      cubeLight(std::vector<formats::DistantLight>{strip}, 8, Eigen::Matrix3d::Identity());
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(same[static_cast<std::size_t>((face * 8 + y) * 8 + x)][c],
                      strip.image.texel(face * 8 + x, y)[c], 1e-4);
}

TEST(CubeLight, OfASkyIsWhatSphericalHarmonicsSay) {
  formats::SkyLight sky;
  sky.sun_elevation_deg = 35;
  const std::vector<Float3> cube =
      cubeLight(std::vector<formats::DistantLight>{sky}, 32, Eigen::Matrix3d::Identity());
  const ShLight sh = projectLight(sky, 1);
  const double band = std::sqrt(1 / (4 * kPi));
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(energyOf(cube, 32)[c] * band / sh[0][static_cast<std::size_t>(c)], 1, 2e-3);
}

}  // namespace
}  // namespace bakelight::transport
