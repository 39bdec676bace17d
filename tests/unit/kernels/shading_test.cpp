// A translucent pack as it is shaded and kept.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "formats/compare.h"
#include "formats/error.h"
#include "formats/json.h"
#include "formats/pack.h"
#include "tests/support/made_translucent_pack.h"
#include "transport/translucent_shading.h"

namespace bakelight::transport {
namespace {

constexpr int kTexels = 64;

// What enters, by a sum over the hemisphere.
double transmittedOf(double eta) {
  double sum = 0;
  constexpr int kSteps = 2000;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = (i + 0.5) / kSteps;
    sum += 2 * cosine * schlickTransmittance(cosine, eta) / kSteps;
  }
  return sum;
}

SurfaceHit hitIn(const formats::TriangleMesh& mesh, float x, float z) {
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 p = vec3(mesh.positions[a]), e1 = vec3(mesh.positions[b]) - p,
               e2 = vec3(mesh.positions[c]) - p;
    const double det = e1.x() * e2.z() - e1.z() * e2.x(), dx = static_cast<double>(x) - p.x(),
                 dz = static_cast<double>(z) - p.z();
    const double u = (dx * e2.z() - dz * e2.x()) / det, v = (e1.x() * dz - e1.z() * dx) / det;
    if (u >= 0 && v >= 0 && u + v <= 1) return {t, static_cast<float>(u), static_cast<float>(v)};
  }
  return {};
}

// A white sky of radiance 1 over a plate: E = π times what enters, B = total · E, and Fresnel's share of B ÷ π leaves.
TEST(TranslucentShading, WhiteSkyGivesTotalTimesBothTransmittances) {
  formats::Medium medium = tests::mediumOf(1.5, 0.95);
  medium.eta = 1.5;
  formats::Pack pack = tests::translucentPack(kTexels, medium, 4, 0);
  pack.appearances.front().base_color = {1, 0.5F, 0.25F};
  const auto shading = makePackShading(pack);
  EXPECT_EQ(shading->needs().sh_order, 4);
  std::vector<Float3> sky(16, Float3{0, 0, 0});
  const auto one = static_cast<float>(2 * std::sqrt(std::numbers::pi));
  sky[0] = {one, one, one};
  shading->setLight(sky, {});
  const auto colors = kernels::reflectanceOf(medium);
  const float middle = kTexels / 2 - 2;
  for (const double slant : {0.0, 1.2}) {
    const Vec3 at(static_cast<double>(middle), 0, static_cast<double>(middle));
    shading->setView(Vec3(at + 1000 * Vec3(std::sin(slant), std::cos(slant), 0)));
    const SurfaceHit hit = hitIn(pack.mesh, middle, middle);
    Float3 radiance;
    shading->radianceAt(std::span(&hit, 1), std::span(&radiance, 1));
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(
          radiance[c] / (colors[c].total() * transmittedOf(1.5) * schlickTransmittance(std::cos(slant), 1.5) *
                         static_cast<double>(pack.appearances.front().base_color[c])),
          1, 0.005)
          << slant << " color " << c;
  }
}

TEST(TranslucentShading, BranchesAddUp) {
  const formats::Pack pack = tests::translucentPack(kTexels, tests::mediumOf(2.5), 3, 0.5F);
  std::vector<Float3> light(9, Float3{0.1F, 0.2F, 0.3F});
  light[0] = {3, 3, 3};
  std::vector<std::vector<formats::Float4>> pictures;
  for (const auto branches : {TranslucentResponse::Branches::kBoth, TranslucentResponse::Branches::kLocal,
                              TranslucentResponse::Branches::kGlobal}) {
    TranslucentShading shading(withBranches(pack, branches));
    shading.setLight(light, {});
    pictures.emplace_back(shading.radiosity().begin(), shading.radiosity().end());
  }
  double largest = 0;
  for (std::size_t i = 0; i < pictures[0].size(); ++i) {
    EXPECT_NEAR(pictures[0][i][1], pictures[1][i][1] + pictures[2][i][1], 1e-4F);
    largest = std::max(largest, static_cast<double>(pictures[1][i][1]));
  }
  EXPECT_GT(largest, 0.05);
  formats::Pack other = pack;
  other.appearances.front().reflection = formats::LambertReflection{};
  EXPECT_THROW(withBranches(other, TranslucentResponse::Branches::kLocal), std::invalid_argument);
}

TEST(TranslucentShading, ABranchOnItsOwnIsThatOfTheResponse) {
  const formats::Pack pack = tests::translucentPack(kTexels, tests::mediumOf(2.5), 3, 0.5F);
  const auto tables = [](const formats::Pack& of) {
    return TranslucentResponse(*of.appearances.front().reflection.as<formats::Translucency>());
  };
  const TranslucentResponse whole = tables(pack);
  std::vector<Float3> light(whole.texelCount());
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = {1, i % 3 == 0 ? 2.0F : 0.0F, 0.5F};
  for (const auto branches : {TranslucentResponse::Branches::kLocal, TranslucentResponse::Branches::kGlobal})
    EXPECT_EQ(tables(withBranches(pack, branches)).respond(light), whole.respond(light, branches));
}

TEST(TranslucentPack, ComesBackAsItWasWhateverOrderItsVerticesTake) {
  const formats::Pack pack = tests::translucentPack(kTexels, tests::mediumOf(2.5), 2, 0.5F);
  std::vector<Float3> light(4, Float3{1, 1, 1});
  TranslucentShading expected(pack);
  expected.setLight(light, {});
  for (const bool draco : {false, true}) {
    formats::PackOptions options;
    options.draco = draco;
    const formats::Pack read = formats::decodePack(formats::encodePack(pack, options, "pack"), "pack");
    TranslucentShading shading(read);
    shading.setLight(light, {});
    for (std::size_t i = 0; i < expected.radiosity().size(); ++i)
      for (std::size_t c = 0; c < 4; ++c)
        EXPECT_NEAR(shading.radiosity()[i][c], expected.radiosity()[i][c], 1e-5F);
  }
}

formats::Json jsonOf(const formats::Bytes& glb) {
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, sizeof size);
  const auto* text = reinterpret_cast<const char*>(glb.data() + 20);
  return formats::Json::parse(text, text + size);
}

// What viewers that do not know this extension show.
TEST(TranslucentPack, HasGltfsOwnExtensionsToo) {
  formats::Pack pack = tests::translucentPack(24, tests::mediumOf(2.5), 2, 0);
  formats::Appearance& appearance = pack.appearances.front();
  appearance.base_color = {1, 0.3F, 0.1F};
  auto& translucency = *appearance.reflection.as<formats::Translucency>();
  translucency.eta = 1.5F;
  translucency.fallback = {{0.9F, 0.7F, 0.3F}, 0.25F, {1, 0.5F, 0.25F}, {2, 4, 0}, 3};
  const formats::Bytes bytes = formats::encodePack(pack, {}, "pack");
  formats::Json json = jsonOf(bytes);
  formats::Json& material = json["materials"][0];
  const auto near = [&](const formats::Json& found, const Float3& expected) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found.at(c).get<float>(), expected[c], 1e-7F) << c;
  };
  near(material["pbrMetallicRoughness"]["baseColorFactor"], {0.9F, 0.21F, 0.03F});
  formats::Json& extensions = material["extensions"];
  EXPECT_EQ(extensions["KHR_materials_ior"]["ior"], 1.5F);
  const formats::Json& transmission = extensions["KHR_materials_diffuse_transmission"];
  EXPECT_EQ(transmission.at("diffuseTransmissionFactor"), 0.25F);
  near(transmission.at("diffuseTransmissionColorFactor"), {1, 0.15F, 0.025F});
  const formats::Json& volume = extensions["KHR_materials_volume"];
  EXPECT_EQ(volume.at("thicknessFactor"), 3.0F);
  EXPECT_EQ(volume.at("attenuationDistance"), 0.25F);
  near(volume.at("attenuationColor"), {std::exp(-0.5F), std::exp(-1.0F), 1});
  const std::vector<std::string> used = json["extensionsUsed"];
  EXPECT_THAT(used, testing::IsSupersetOf(
                        {"KHR_materials_ior", "KHR_materials_diffuse_transmission", "KHR_materials_volume"}));

  const formats::Pack read = formats::decodePack(bytes, "pack");
  EXPECT_EQ(read.appearances.front().base_color, appearance.base_color);
  formats::CompareLimits limits;
  limits.maximum = 1e-6;  // of texture coordinates, which are turned over twice
  EXPECT_TRUE(formats::comparePacks(read, pack, limits).passes());

  // No volume, nothing that goes through it; no absorption, no color of it.
  translucency.fallback.thickness = 0;
  EXPECT_EQ(jsonOf(formats::encodePack(pack, {}, "pack"))["extensionsUsed"].size(), used.size() - 2);
  translucency.fallback.thickness = 3;
  translucency.fallback.attenuation = {0, 0, 0};
  const formats::Json clear = jsonOf(formats::encodePack(pack, {}, "pack"));
  EXPECT_EQ(clear["materials"][0]["extensions"]["KHR_materials_volume"].size(), 1U);
}

TEST(TranslucentPack, EveryTableIsCompared) {
  const formats::Pack pack = tests::translucentPack(24, tests::mediumOf(2.5), 2, 0.5F);
  EXPECT_TRUE(formats::comparePacks(pack, pack, {}).passes());
  const auto changed = [](formats::EncodedTable& table) {
    std::vector<float> values = table.decode();
    values[values.size() / 2] += 0.5F;
    table = formats::encodeTable(values, table.columns, table.precision, "test", "table");
  };
  using T = formats::Translucency;
  for (formats::EncodedTable T::*table : {&T::texel_weights, &T::areas, &T::blend, &T::kernels}) {
    formats::Pack other = pack;
    changed(other.appearances.front().reflection.as<T>()->*table);
    EXPECT_FALSE(formats::comparePacks(other, pack, {}).passes());
  }
  formats::Pack thicker = pack;
  thicker.appearances.front().reflection.as<T>()->fallback.thickness += 1;
  EXPECT_FALSE(formats::comparePacks(thicker, pack, {}).passes());
  for (formats::SparseRows T::*matrix : {&T::sharpen, &T::near}) {
    formats::Pack other = pack;
    changed((other.appearances.front().reflection.as<T>()->*matrix).values);
    EXPECT_FALSE(formats::comparePacks(other, pack, {}).passes());
  }
}

// By one who makes a pack in memory, which no reader has checked.
TEST(TranslucentShading, VerticesThatLackSomethingAreRefused) {
  const formats::Pack pack = tests::translucentPack(24, tests::mediumOf(2.5), 2, 0);
  EXPECT_NO_THROW(TranslucentShading{pack});
  formats::Pack other = pack;
  other.mesh.texcoords.clear();
  EXPECT_THROW(TranslucentShading{other}, std::invalid_argument);
  other = pack;
  other.mesh.normals.pop_back();
  EXPECT_THROW(TranslucentShading{other}, std::invalid_argument);
  other = pack;
  other.appearances.front().reflection.as<formats::Translucency>()->knots.pop_back();
  EXPECT_THROW(TranslucentShading{other}, std::invalid_argument);
}

TEST(TranslucentPack, OtherMaterialsAndTransferAreRefused) {
  formats::Pack pack = tests::translucentPack(24, tests::mediumOf(2.5), 2, 0);
  formats::Pack without_texcoords = pack;
  without_texcoords.mesh.texcoords.clear();
  EXPECT_THROW(formats::encodePack(without_texcoords, {}, "pack"), Error);
  formats::Pack stray = pack;
  auto* translucency = stray.appearances.front().reflection.as<formats::Translucency>();
  translucency->knot_count = 3;
  EXPECT_THROW(formats::encodePack(stray, {}, "pack"), Error);
}

}  // namespace
}  // namespace bakelight::transport
