#include "tools/player/exit_radiance.h"

#include <cmath>
#include <string>

#include "tests/e2e/made_packs.h"
#include "tests/support/evaluate_pack.h"
#include "tools/player/gl_context.h"
#include "tools/player/gpu_light.h"

namespace bakelight::player {
namespace {

using formats::Lobe;
using formats::Precision;
using formats::Storage;
using transport::Float3;
using transport::Vec3;

constexpr int kOrder = 4;

formats::MadeReflection materialOf(Lobe model, int row_order) {
  formats::MadeReflection material;
  material.model = model;
  material.exponent = 25;
  material.roughness = 0.4f;
  material.specular_color = {0.9f, 0.6f, 0.3f};
  if (model == Lobe::kTable) material.table = tests::madeBrdfTable(9, row_order + 1);
  return material;
}

transport::ShLight lightFrom(const Vec3& direction, const Float3& radiance) {
  return transport::sum(transport::diskLight(kOrder, direction.normalized(), 0.4, radiance),
                        transport::uniformLight(kOrder, {0.2f, 0.3f, 0.4f}));
}

// Largest difference from transport::evaluatePack, over the largest radiance.
double relativeError(const formats::Pack& pack, const transport::ShLight& light,
                     const transport::ShLight& near_light, const Vec3& eye) {
  const Buffer near_buffer = makeLightBuffer();
  setLight(near_buffer, near_light);
  ExitRadiance exit_radiance(pack, Vec3(0.1, 0.2, 0.3), near_light.empty() ? nullptr : &near_buffer);
  exit_radiance.setDistantLight(light);
  exit_radiance.update();
  exit_radiance.lookFrom(eye);
  std::vector<Float3> actual(pack.mesh.vertexCount());
  glGetNamedBufferSubData(exit_radiance.buffer().name(), 0,
                          static_cast<GLsizeiptr>(actual.size() * sizeof(Float3)), actual.data());
  throwIfGlFailed("reading back");

  const auto expected = transport::evaluatePack(pack, light, near_light, eye);
  EXPECT_EQ(expected.size(), actual.size());
  double largest = 0, error = 0;
  for (std::size_t v = 0; v < expected.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) {
      largest = std::max(largest, std::abs(static_cast<double>(expected[v][c])));
      error = std::max(error, std::abs(static_cast<double>(expected[v][c]) - actual[v][c]));
    }
  EXPECT_GT(largest, 0.01);
  return error / largest;
}

class ExitRadianceTest : public testing::Test {
 protected:
  HeadlessContext context_;
  const transport::ShLight light_ = lightFrom({1, 2, 3}, {5, 4, 3});
  const transport::ShLight near_light_ = lightFrom({-2, 1, 0.5}, {1, 6, 2});
  const Vec3 eye_{2, 1, 3};
};

TEST_F(ExitRadianceTest, DiffuseIsThatOfTheCpu) {
  formats::Pack pack = tests::wavyPack(kOrder, 16);
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v)
    pack.colors.push_back({0.2f, 0.9f, static_cast<float>(v % 7) / 7});
  for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
    tests::encodeAt(precision, pack);
    EXPECT_LT(relativeError(pack, light_, {}, eye_), 1e-5) << nameOf(precision);
    EXPECT_LT(relativeError(pack, light_, near_light_, eye_), 1e-5) << nameOf(precision);
  }
}

TEST_F(ExitRadianceTest, NearVectorsTakeTheNearLightAlone) {
  formats::Pack pack = tests::spherePack(kOrder, 12);
  tests::scaleMesh(pack, 0.4f);
  const double without = relativeError(pack, light_, near_light_, eye_);
  tests::addNearTransfer(pack, 1);
  EXPECT_LT(without, 1e-5);
  EXPECT_LT(relativeError(pack, light_, near_light_, eye_), 1e-5);
}

TEST_F(ExitRadianceTest, GlossyIsThatOfTheCpuForAllThatAPackCanHold) {
  constexpr int kRowOrder = 3;
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca})
    for (const auto model : {Lobe::kPhong, Lobe::kGgx, Lobe::kTable})
      for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8})
        for (const int channels : {1, 3}) {
          if (storage == Storage::kVisibility && channels == 3) continue;
          formats::Pack pack = tests::wavyPack(kOrder, 8);
          tests::addGlossyTransfer(pack, kRowOrder, storage, channels);
          reflectionOf(pack) = materialOf(model, kRowOrder);
          tests::encodeAt(precision, pack);
          const std::string what = std::string(nameOf(storage)) + ' ' + nameOf(model) + ' ' +
                                   nameOf(precision) + ' ' + std::to_string(channels);
          EXPECT_LT(relativeError(pack, light_, {}, eye_), 5e-5) << what;
          EXPECT_LT(relativeError(pack, light_, near_light_, eye_), 5e-5) << what << ", near";
        }
}

TEST_F(ExitRadianceTest, StorageIsNoMatterOfThePicture) {
  formats::Pack matrices = tests::wavyPack(kOrder, 8);
  reflectionOf(matrices) = materialOf(Lobe::kTable, 3);
  formats::Pack visibility = matrices;
  tests::addGlossyTransfer(matrices, 3, Storage::kMatrix);
  tests::addGlossyTransfer(visibility, 3, Storage::kVisibility);
  const auto a = transport::evaluatePack(matrices, light_, {}, eye_);
  const auto b = transport::evaluatePack(visibility, light_, {}, eye_);
  for (std::size_t v = 0; v < a.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(a[v][c], b[v][c], 1e-4) << v;
}

// Each part of the body in a material of its own: Lambert, a lobe and a table side by side.
TEST_F(ExitRadianceTest, MaterialsReflectEachInItsOwnWay) {
  for (const auto storage : {Storage::kMatrix, Storage::kVisibility, Storage::kCpca}) {
    formats::Pack pack = tests::wavyPack(kOrder, 16);
    tests::addGlossyTransfer(pack, 3, storage);
    // Triangles between two thirds of the vertices are left out.
    const auto vertices = static_cast<std::uint32_t>(pack.mesh.vertexCount());
    const auto third = vertices / 3;
    const auto materialAt = [&](std::uint32_t v) { return std::min(v / third, 2U); };
    std::vector<formats::Triangle> kept;
    for (const formats::Triangle& t : pack.mesh.triangles) {
      const std::uint32_t material = materialAt(t[0]);
      if (materialAt(t[1]) != material || materialAt(t[2]) != material) continue;
      kept.push_back(t);
      pack.mesh.triangle_materials.push_back(material);
    }
    pack.mesh.triangles = kept;
    pack.mesh.material_names = {"a", "b", "c"};
    pack.appearances = {{"a", {0.5f, 0.4f, 0.3f}, formats::LambertReflection()},
                        {"b", {0.1f, 0.2f, 0.3f}, materialOf(Lobe::kPhong, 3)},
                        {"c", {0.9f, 0.1f, 0.2f}, materialOf(Lobe::kTable, 3)}};
    EXPECT_LT(relativeError(pack, light_, {}, eye_), 5e-5) << nameOf(storage);
    EXPECT_LT(relativeError(pack, light_, near_light_, eye_), 5e-5) << nameOf(storage) << ", near";
    // And each differs from what the others would give.
    const auto mixed = transport::evaluatePack(pack, light_, {}, eye_);
    pack.appearances[1].reflection = formats::LambertReflection();
    const auto plain = transport::evaluatePack(pack, light_, {}, eye_);
    EXPECT_EQ(mixed[third / 2], plain[third / 2]);
    EXPECT_NE(mixed[third + third / 2], plain[third + third / 2]);
    EXPECT_EQ(mixed[vertices - 1], plain[vertices - 1]);
  }
}

TEST_F(ExitRadianceTest, DiffusePackWithoutEmittersPaysForNothingElse) {
  formats::Pack diffuse = tests::wavyPack(kOrder, 16), glossy = diffuse;
  tests::addGlossyTransfer(glossy, 3, Storage::kMatrix);
  reflectionOf(glossy) = materialOf(Lobe::kPhong, 3);
  tests::addNearTransfer(glossy, 9);
  const Buffer near_light = makeLightBuffer();
  const std::size_t count = diffuse.mesh.vertexCount();
  // Vectors, radiance and one light.
  const ExitRadiance plain(diffuse, Vec3::Zero(), nullptr);
  EXPECT_EQ(plain.gpuBytes(), count * (kOrder * kOrder + 3) * sizeof(float) + sizeInBytes(near_light));
  const ExitRadiance far_only(glossy, Vec3::Zero(), nullptr), both(glossy, Vec3::Zero(), &near_light);
  EXPECT_EQ(both.gpuBytes() - far_only.gpuBytes(),
            count * (kOrder * kOrder + 3) * sizeof(float) + sizeInBytes(near_light));
}

}  // namespace
}  // namespace bakelight::player
