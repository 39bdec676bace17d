#include "tools/player/techniques/vertex_radiance.h"

#include <cmath>
#include <string>

#include "tests/e2e/made_packs.h"
#include "tests/support/evaluate_pack.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gpu_timer.h"
#include "tools/player/lights/gpu_light.h"

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
  const SurfaceMesh mesh(pack.mesh, Vec3(0.1, 0.2, 0.3));
  VertexRadiance technique(pack, mesh, !near_light.empty());
  GpuLight distant = darkLight(), near = darkLight();
  setLight(distant, light);
  setLight(near, near_light);
  technique.setLight(distant, near_light.empty() ? nullptr : &near);
  technique.lookFrom(eye);
  std::vector<Float3> actual(pack.mesh.vertexCount());
  glGetNamedBufferSubData(technique.radiance().name(), 0,
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

class VertexRadianceTest : public testing::Test {
 protected:
  HeadlessContext context_;
  const transport::ShLight light_ = lightFrom({1, 2, 3}, {5, 4, 3});
  const transport::ShLight near_light_ = lightFrom({-2, 1, 0.5}, {1, 6, 2});
  const Vec3 eye_{2, 1, 3};
};

TEST_F(VertexRadianceTest, DiffuseIsThatOfTheCpu) {
  formats::Pack pack = tests::wavyPack(kOrder, 16);
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v)
    pack.colors.push_back({0.2f, 0.9f, static_cast<float>(v % 7) / 7});
  for (const auto precision : {Precision::kFloat32, Precision::kFloat16, Precision::kUint8}) {
    tests::encodeAt(precision, pack);
    EXPECT_LT(relativeError(pack, light_, {}, eye_), 1e-5) << nameOf(precision);
    EXPECT_LT(relativeError(pack, light_, near_light_, eye_), 1e-5) << nameOf(precision);
  }
}

TEST_F(VertexRadianceTest, NearVectorsTakeTheNearLightAlone) {
  formats::Pack pack = tests::spherePack(kOrder, 12);
  tests::scaleMesh(pack, 0.4f);
  const double without = relativeError(pack, light_, near_light_, eye_);
  tests::addNearTransfer(pack, 1);
  EXPECT_LT(without, 1e-5);
  EXPECT_LT(relativeError(pack, light_, near_light_, eye_), 1e-5);
}

TEST_F(VertexRadianceTest, GlossyIsThatOfTheCpuForAllThatAPackCanHold) {
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

TEST_F(VertexRadianceTest, StorageIsNoMatterOfThePicture) {
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
TEST_F(VertexRadianceTest, MaterialsReflectEachInItsOwnWay) {
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

TEST_F(VertexRadianceTest, DiffusePackWithoutEmittersPaysForNothingElse) {
  formats::Pack diffuse = tests::wavyPack(kOrder, 16), glossy = diffuse;
  tests::addGlossyTransfer(glossy, 3, Storage::kMatrix);
  reflectionOf(glossy) = materialOf(Lobe::kPhong, 3);
  tests::addNearTransfer(glossy, 9);
  const std::size_t count = diffuse.mesh.vertexCount();
  const SurfaceMesh mesh(diffuse.mesh, Vec3::Zero());
  // Vectors and radiance.
  const VertexRadiance plain(diffuse, mesh, false);
  EXPECT_EQ(plain.gpuBytes(), count * (kOrder * kOrder + 3) * sizeof(float));
  const VertexRadiance far_only(glossy, mesh, false), both(glossy, mesh, true);
  EXPECT_EQ(both.gpuBytes() - far_only.gpuBytes(),
            count * (kOrder * kOrder + 3) * sizeof(float) + sizeInBytes(darkLight().sh));
}

// Each light alone may change, and nothing is evaluated for a light that has not.
TEST_F(VertexRadianceTest, FollowsEachLightAndEvaluatesNoneTwice) {
  formats::Pack pack = tests::wavyPack(kOrder, 8);
  tests::addGlossyTransfer(pack, 3, Storage::kMatrix);
  reflectionOf(pack) = materialOf(Lobe::kPhong, 3);
  const SurfaceMesh mesh(pack.mesh, Vec3::Zero());
  VertexRadiance technique(pack, mesh, true);
  GpuLight distant = darkLight(), near = darkLight();
  GpuTimer timer;
  const auto passes = [&] {
    timer.start(GpuTimer::Of::kPasses);
    technique.setLight(distant, &near);
    technique.lookFrom(eye_);
    return timer.finish().passes_ms.size();
  };
  const auto error = [&](const transport::ShLight& light, const transport::ShLight& near_light) {
    const auto expected = transport::evaluatePack(pack, light, near_light, eye_);
    std::vector<Float3> actual(expected.size());
    glGetNamedBufferSubData(technique.radiance().name(), 0,
                            static_cast<GLsizeiptr>(actual.size() * sizeof(Float3)), actual.data());
    double largest = 0;
    for (std::size_t v = 0; v < expected.size(); ++v)
      for (std::size_t c = 0; c < 3; ++c)
        largest = std::max(largest, std::abs(static_cast<double>(expected[v][c]) - actual[v][c]));
    return largest;
  };
  const transport::ShLight dark(kOrder * kOrder, Float3{0, 0, 0});
  setLight(distant, light_);
  EXPECT_EQ(passes(), 3u) << "diffuse, transfer, glossy";
  EXPECT_LT(error(light_, dark), 1e-3);
  setLight(near, near_light_);
  EXPECT_EQ(passes(), 3u);
  EXPECT_LT(error(light_, near_light_), 1e-3);
  EXPECT_EQ(passes(), 1u) << "glossy alone";
  EXPECT_LT(error(light_, near_light_), 1e-3);
  setLight(distant, dark);
  EXPECT_EQ(passes(), 3u);
  EXPECT_LT(error(dark, near_light_), 1e-3);
}

TEST_F(VertexRadianceTest, NeedsTheLightThatThePackNeeds) {
  formats::Pack pack = tests::wavyPack(kOrder, 8);
  EXPECT_EQ(techniqueFor(pack).needs(pack).sh_order, kOrder);
  EXPECT_FALSE(techniqueFor(pack).needs(pack).near_center);
  tests::addNearTransfer(pack, 9);
  EXPECT_EQ(techniqueFor(pack).needs(pack).near_center, transport::vec3(pack.sh().near_field->center));
}

}  // namespace
}  // namespace bakelight::player
