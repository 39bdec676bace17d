#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/support/evaluate_pack.h"
#include "tests/support/pack_parts.h"
#include "transport/directions.h"
#include "transport/evaluator.h"
#include "transport/glossy.h"

namespace bakelight::transport {
namespace {

using formats::Lobe;
using formats::Pack;
using formats::Storage;

constexpr double kPi = std::numbers::pi;
constexpr int kOrder = 4;
constexpr std::size_t kVertices = 40;
const Vec3 kEye(0.5, 1.5, 3);

formats::EncodedTable exactTable(const std::vector<float>& values, std::size_t columns) {
  return formats::encodeTable(values, columns, formats::Precision::kFloat32, "test", "table");
}

std::vector<Float3> someLight(double phase = 0) {
  std::vector<Float3> light(coefficientCount(kOrder));
  for (std::size_t i = 0; i < light.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      light[i][c] = static_cast<float>(
          std::sin(1 + phase + 2.3 * static_cast<double>(i) + 0.7 * static_cast<double>(c)));
  return light;
}

// A sphere's vertices: nothing shadows anything.
Pack convexPack() {
  Pack pack;
  pack.sh().order = kOrder;
  pack.sh().transport = formats::Transport::kUnshadowed;
  std::vector<float> vectors;
  const std::vector<double> cosine = clampedCosineFactors(kOrder);
  for (const Vec3& normal : sphereDirections(kVertices)) {
    pack.mesh.positions.push_back(float3(normal));
    pack.mesh.normals.push_back(float3(normal));
    const std::vector<double> y = evaluateSh(kOrder, normal);
    for (int l = 0; l < kOrder; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i)
        vectors.push_back(static_cast<float>(cosine[l] / kPi * y[i]));
  }
  pack.sh().vectors = exactTable(vectors, coefficientCount(kOrder));
  return pack;
}

// Light of the object's frame seen in each vertex's frame, mirrored where that is left-handed.
std::vector<float> localMatrices(const Pack& pack) {
  std::vector<float> matrices;
  const std::size_t count = coefficientCount(kOrder);
  for (std::size_t v = 0; v < kVertices; ++v) {
    const formats::Float4& t = pack.sh().glossy->tangents[v];
    Eigen::Matrix3d frame;
    frame.col(0) = Vec3(t[0], t[1], t[2]);
    frame.col(2) = vec3(pack.mesh.normals[v]);
    frame.col(1) = frame.col(2).cross(frame.col(0));
    const ShRotation rotation(kOrder, Eigen::Quaterniond(frame).normalized().toRotationMatrix().transpose());
    std::vector<double> dense(count * count);
    for (std::size_t j = 0; j < count; ++j) {
      std::vector<double> unit(count, 0.0), turned(count);
      unit[j] = 1;
      rotation.apply(std::span<const double>(unit), std::span<double>(turned));
      for (int l = 0; l < kOrder; ++l)
        for (int m = -l; m <= l; ++m)
          dense[coefficientIndex(l, m) * count + j] =
              turned[coefficientIndex(l, m)] * (m < 0 ? static_cast<double>(t[3]) : 1.0);
    }
    for (const double value : dense) matrices.push_back(static_cast<float>(value));
  }
  return matrices;
}

// Every third frame is left-handed.
void store(Pack& pack, Storage storage) {
  const std::size_t cells = coefficientCount(kOrder) * coefficientCount(kOrder);
  makeGlossy(pack.sh(), storage, kOrder);
  for (std::size_t v = 0; v < kVertices; ++v) {
    const Float3 tangent = float3(vec3(pack.mesh.normals[v]).unitOrthogonal());
    pack.sh().glossy->tangents.push_back({tangent[0], tangent[1], tangent[2], v % 3 == 0 ? -1.0f : 1.0f});
  }
  if (storage == Storage::kMatrix) pack.sh().glossy->vertexTable() = exactTable(localMatrices(pack), cells);
  if (storage == Storage::kVisibility) {
    const std::size_t count = coefficientCount(2 * kOrder - 1);
    std::vector<float> visible(kVertices * count);
    for (std::size_t v = 0; v < kVertices; ++v) visible[v * count] = static_cast<float>(std::sqrt(4 * kPi));
    pack.sh().glossy->vertexTable() = exactTable(visible, count);
  }
  if (storage == Storage::kCpca) {
    // Two clusters of mean zero would need many components; a cluster a vertex needs none but its mean.
    std::vector<float> basis;
    const std::vector<float> matrices = localMatrices(pack);
    for (std::size_t v = 0; v < kVertices; ++v) {
      clustersOf(pack).clusters.push_back(static_cast<std::uint32_t>(kVertices - 1 - v));
      const auto row = matrices.begin() + (kVertices - 1 - v) * cells;
      basis.insert(basis.end(), row, row + cells);
      basis.insert(basis.end(), cells, 0.0f);
    }
    clustersOf(pack).basis = exactTable(basis, cells);
    pack.sh().glossy->vertexTable() = exactTable(std::vector<float>(kVertices, 0.0f), 1);
  }
}

// Lambert of albedo 1 as a table: the clamped cosine over π, the same for every eye.
formats::BrdfTable lambertTable() {
  formats::BrdfTable table{3, kOrder, {}};
  const std::vector<double> cosine = clampedCosineFactors(kOrder);
  for (int row = 0; row < 3 * 3; ++row)
    for (int l = 0; l < kOrder; ++l)
      for (int m = -l; m <= l; ++m)
        table.values.push_back(
            m == 0 ? static_cast<float>(cosine[l] / kPi * std::sqrt((2 * l + 1) / (4 * kPi))) : 0);
  return table;
}

class PackStorages : public testing::TestWithParam<Storage> {};

// The glossy path with Lambert's BRDF gives what the diffuse vectors give.
TEST_P(PackStorages, LambertAsATableEqualsTheDiffusePart) {
  Pack pack = convexPack();
  const std::vector<Float3> expected = evaluatePack(pack, someLight(), {}, kEye);
  pack.sh().vectors = {};
  store(pack, GetParam());
  reflectionOf(pack) = lambertTable();
  const std::vector<Float3> found = evaluatePack(pack, someLight(), {}, kEye);
  ASSERT_EQ(found.size(), kVertices);
  for (std::size_t v = 0; v < kVertices; ++v)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[v][c], expected[v][c], 2e-6) << "vertex " << v;
}

// Without shadows the lobe sees the light itself: Σ g_l y_i(reflection) L_i, by vectors in the object's
// frame.
TEST_P(PackStorages, LobesReflectTheLightItself) {
  for (const Lobe model : {Lobe::kPhong, Lobe::kGgx}) {
    Pack pack = convexPack();
    store(pack, GetParam());
    pack.sh().vectors = {};
    const Float3 specular = {1, 0.5f, 0.25f};
    reflectionOf(pack) = formats::MadeReflection{model, 6, 0.4f, specular, {}};
    const std::vector<double> kernel =
        model == Lobe::kPhong ? phongKernel(kOrder, 6) : ggxKernel(kOrder, 0.4f);
    const std::vector<Float3> found = evaluatePack(pack, someLight(), {}, kEye), light = someLight();
    for (std::size_t v = 0; v < kVertices; ++v) {
      const Vec3 normal = vec3(pack.mesh.normals[v]);
      const Vec3 eye = (kEye - vec3(pack.mesh.positions[v])).normalized();
      const Vec3 facing = normal.dot(eye) < 0 ? Vec3(-normal) : normal;
      // From below, the eye's mirror image above the surface is reflected.
      const Vec3 above = normal.dot(eye) < 0 ? Vec3(eye + 2 * facing.dot(eye) * normal) : eye;
      const Vec3 reflection = 2 * normal.dot(above) * normal - above;
      const std::vector<double> y = evaluateSh(kOrder, reflection);
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (int l = 0; l < kOrder; ++l)
          for (int i = l * l; i < (l + 1) * (l + 1); ++i) sum += kernel[l] * y[i] * light[i][c];
        EXPECT_NEAR(found[v][c], sum * specular[c], 3e-6) << "vertex " << v;
      }
    }
  }
}

// Furnace: a uniform sky comes back unchanged from any normalised lobe.
TEST_P(PackStorages, UniformLightStaysUniform) {
  const std::vector<Float3> sky = uniformLight(kOrder, {1, 2, 3});
  for (const float exponent : {0.0f, 1.0f, 50.0f}) {
    Pack pack = convexPack();
    store(pack, GetParam());
    pack.sh().vectors = {};
    reflectionOf(pack) = formats::PhongLobe{exponent, {1, 1, 1}};
    for (const Float3& color : evaluatePack(pack, sky, {}, kEye))
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], static_cast<double>(1 + c), 5e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Storages, PackStorages,
                         testing::Values(Storage::kMatrix, Storage::kVisibility, Storage::kCpca),
                         [](const auto& instance) { return nameOf(instance.param); });

TEST(VertexShading, AddsGlossyToColoredDiffuse) {
  Pack pack = convexPack();
  pack.appearances[0].base_color = {0.5f, 0.25f, 1};
  pack.colors.assign(kVertices, {1, 1, 1});
  pack.colors[7] = {0.5f, 0, 1};
  const std::vector<Float3> sky = uniformLight(kOrder, {1, 1, 1});
  std::vector<Float3> radiance = evaluatePack(pack, sky, {}, kEye);
  EXPECT_NEAR(radiance[6][0], 0.5, 1e-5);
  EXPECT_NEAR(radiance[6][1], 0.25, 1e-5);
  EXPECT_NEAR(radiance[7][0], 0.25, 1e-5);
  EXPECT_NEAR(radiance[7][1], 0, 1e-5);
  store(pack, Storage::kMatrix);
  reflectionOf(pack) = formats::PhongLobe{0, {0.1f, 0.1f, 0.1f}};
  radiance = evaluatePack(pack, sky, {}, kEye);
  EXPECT_NEAR(radiance[7][0], 0.35, 1e-5);
  EXPECT_NEAR(radiance[7][1], 0.1, 1e-5) << "the lobe is not tinted by the diffuse colour";
}

TEST(VertexShading, TakesNearLightThroughItsOwnVectors) {
  Pack pack = convexPack();
  const std::vector<Float3> far = someLight(), near = someLight(2), dark(coefficientCount(kOrder));
  const std::vector<Float3> of_far = evaluatePack(pack, far, {}, kEye),
                            of_near = evaluatePack(pack, near, {}, kEye);
  const std::vector<Float3> both = evaluatePack(pack, far, near, kEye);
  for (std::size_t v = 0; v < kVertices; ++v) EXPECT_NEAR(both[v][1], of_far[v][1] + of_near[v][1], 1e-5);

  std::vector<float> halved = pack.sh().vectors.decode();
  for (float& value : halved) value /= 2;
  pack.sh().near_field = {{0, 0, 0}, 1, exactTable(halved, coefficientCount(kOrder))};
  const std::vector<Float3> near_only = evaluatePack(pack, dark, near, kEye);
  for (std::size_t v = 0; v < kVertices; ++v) EXPECT_NEAR(near_only[v][1], of_near[v][1] / 2, 1e-5);
}

TEST(VertexShading, ReadsOneVectorAColor) {
  Pack pack = convexPack();
  const std::vector<float> single = pack.sh().vectors.decode();
  const std::size_t count = coefficientCount(kOrder);
  std::vector<float> colored;
  for (std::size_t v = 0; v < kVertices; ++v)
    for (int c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < count; ++i)
        colored.push_back(single[v * count + i] * static_cast<float>(c + 1));
  const std::vector<Float3> gray = evaluatePack(pack, someLight(), {}, kEye);
  pack.sh().channels = 3;
  pack.sh().vectors = exactTable(colored, 3 * count);
  const std::vector<Float3> found = evaluatePack(pack, someLight(), {}, kEye);
  for (std::size_t v = 0; v < kVertices; ++v)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(found[v][c], gray[v][c] * static_cast<float>(c + 1), 1e-5);
}

TEST(VertexShading, RefusesTablesThatDoNotFit) {
  Pack pack = convexPack();
  EXPECT_THROW(evaluatePack(pack, std::vector<Float3>(9), {}, kEye), std::invalid_argument);
  store(pack, Storage::kMatrix);
  reflectionOf(pack) = formats::PhongLobe();
  pack.sh().glossy->tangents.pop_back();
  EXPECT_THROW(evaluatePack(pack, someLight(), {}, kEye), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
