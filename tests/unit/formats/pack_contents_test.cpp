// What packs hold: each storage at each precision, there and back, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/glb.h"
#include "formats/pack.h"
#include "tests/unit/formats/test_packs.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr Storage kStorages[] = {Storage::kMatrix, Storage::kVisibility, Storage::kCpca};
constexpr Precision kPrecisions[] = {Precision::kFloat32, Precision::kFloat16, Precision::kUint8};
constexpr Lobe kLobes[] = {Lobe::kNone, Lobe::kPhong, Lobe::kGgx, Lobe::kTable};
const std::string kExtension = std::string("/meshes/0/extensions/") + kTransferExtension;
const std::string kReflection = std::string("/materials/0/extensions/") + kTransferExtension;

std::vector<std::string> sectionNames(const Pack& pack, const PackOptions& options = {}) {
  std::vector<std::string> names;
  for (const PackSection& section : packSections(encodePack(pack, options, "a.glb"), "a.glb"))
    names.push_back(section.name);
  return names;
}

Json jsonOf(const Bytes& bytes) {
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, sizeof size);
  const auto* text = reinterpret_cast<const char*>(bytes.data()) + 20;
  return Json::parse(text, text + size);
}

class StoredPack : public testing::TestWithParam<std::tuple<Storage, Precision>> {
 protected:
  Pack pack(std::uint32_t n, Lobe lobe = Lobe::kGgx) const {
    return glossyPack(wavyGrid(n), std::get<0>(GetParam()), std::get<1>(GetParam()), lobe);
  }
};

TEST_P(StoredPack, RoundTripIsExactWithEachLobe) {
  for (const Lobe lobe : kLobes) {
    const Pack source = pack(4, lobe);
    ASSERT_EQ(source.sh().glossy->vertexTable().precision, std::get<1>(GetParam()));
    expectSamePack(roundTrip(source, {}), source);
  }
}

TEST_P(StoredPack, DracoKeepsEveryTableInStep) {
  const Pack source = pack(9);
  const Pack read = roundTrip(source, {.draco = true});
  EXPECT_EQ(read.mesh.vertexCount(), source.mesh.vertexCount());
  EXPECT_NE(read.mesh.positions, source.mesh.positions)
      << "Edgebreaker is expected to reorder: is the test still one?";
  expectSamePack(read, source);
}

TEST_P(StoredPack, QuantizedNormalsKeepFramesOfRightAngles) {
  const Pack source = pack(9);
  const Pack read = roundTrip(source, {.draco = true, .position_bits = 10, .normal_bits = 6});
  ASSERT_EQ(read.sh().glossy->tangents.size(), source.mesh.vertexCount());
  for (std::size_t i = 0; i < read.sh().glossy->tangents.size(); ++i) {
    const Float4& t = read.sh().glossy->tangents[i];
    const Float3& n = read.mesh.normals[i];
    EXPECT_NEAR(t[0] * n[0] + t[1] * n[1] + t[2] * n[2], 0, 1e-5);
    EXPECT_NEAR(t[0] * t[0] + t[1] * t[1] + t[2] * t[2], 1, 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Pack, StoredPack,
                         testing::Combine(testing::ValuesIn(kStorages), testing::ValuesIn(kPrecisions)),
                         [](const auto& test) {
                           return std::string(nameOf(std::get<0>(test.param))) + "_" +
                                  nameOf(std::get<1>(test.param));
                         });

TEST(PackContents, SectionsHaveTheNamesOfWhatTheyHold) {
  TriangleMesh mesh = wavyGrid(3);
  mesh.texcoords.clear();
  EXPECT_THAT(sectionNames(glossyPack(mesh, Storage::kMatrix, Precision::kFloat16, Lobe::kPhong)),
              ElementsAre("indices", "positions", "normals", "vectors", "nearVectors", "matrices", "tangents",
                          "colors"));
  EXPECT_THAT(sectionNames(glossyPack(mesh, Storage::kVisibility, Precision::kUint8, Lobe::kGgx)),
              ElementsAre("indices", "positions", "normals", "vectors", "nearVectors", "visibility",
                          "visibilityScale", "visibilityOffset", "tangents", "colors"));
  EXPECT_THAT(
      sectionNames(glossyPack(mesh, Storage::kCpca, Precision::kFloat32, Lobe::kTable), {.draco = true}),
      ElementsAre("draco", "vectors", "nearVectors", "weights", "basis", "clusters", "tangents", "colors",
                  "brdf"));
}

TEST(PackContents, VersionIsTheOneWritten) {
  EXPECT_EQ(packVersion(encodePack(diffusePack(wavyGrid(2), 1), {}, "a.glb"), "a.glb"), 3);
}

TEST(PackContents, GltfViewersSeeRoughnessTangentsAndColors) {
  const auto documentOf = [](Lobe lobe) {
    return jsonOf(
        encodePack(glossyPack(wavyGrid(3), Storage::kMatrix, Precision::kUint8, lobe), {}, "a.glb"));
  };
  const auto roughness = [&](Lobe lobe) {
    return documentOf(lobe)["/materials/0/pbrMetallicRoughness/roughnessFactor"_json_pointer].get<float>();
  };
  EXPECT_FLOAT_EQ(roughness(Lobe::kGgx), 0.37F);
  EXPECT_FLOAT_EQ(roughness(Lobe::kPhong), std::pow(2 / (4 * 12.3F + 2), 0.25F));
  EXPECT_EQ(roughness(Lobe::kTable), 1);
  const Json document = documentOf(Lobe::kGgx);
  const Json attributes = document["/meshes/0/primitives/0/attributes"_json_pointer];
  EXPECT_EQ(document["accessors"][attributes["TANGENT"].get<std::size_t>()]["type"], "VEC4");
  EXPECT_EQ(document["accessors"][attributes["COLOR_0"].get<std::size_t>()]["type"], "VEC3");
}

std::string encodeErrorOf(const Pack& pack) {
  try {
    encodePack(pack, {}, "a.glb");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

// What encodePack says of `good` once `change` has spoiled it.
std::string refusal(const Pack& good, const std::function<void(Pack&)>& change) {
  Pack pack = good;
  change(pack);
  return encodeErrorOf(pack);
}

void setFloat(EncodedTable& table, std::size_t i, float value) {
  Bytes bytes(table.data.begin(), table.data.end());
  std::memcpy(bytes.data() + i * sizeof value, &value, sizeof value);
  table.data = std::move(bytes);
}

void shorten(EncodedTable& table) {
  table.data = Bytes(table.data.begin(), table.data.end() - 1);
}

TEST(PackContents, WhatCannotBeAPackIsRefused) {
  const Pack good = diffusePack(wavyGrid(3), 2);
  ASSERT_EQ(encodeErrorOf(good), "no error");
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh = {}; }), HasSubstr("no vertex"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh.normals.pop_back(); }),
              AllOf(HasSubstr("normals"), HasSubstr("8")));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh.normals[4] = {0, 2, 0}; }), HasSubstr("vertex 4"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh.triangles[1][2] = 9; }), HasSubstr("triangle 1: vertex 9"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.name = "\xFF"; }), HasSubstr("UTF-8"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.appearances[0].base_color[1] = 1.5F; }),
              HasSubstr("base colour"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.colors.assign(8, {0, 0, 0}); }), HasSubstr("colors"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.colors.assign(9, {0, -1, 0}); }), HasSubstr("colors, vertex 0"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().order = 11; }), HasSubstr("order"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().transport = static_cast<Transport>(3); }),
              HasSubstr("transport"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().channels = 2; }), HasSubstr("2 channels"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().channels = 3; }), HasSubstr("9 vertices × 12 values"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().vectors.rows = 8; }), HasSubstr("section vectors"));
  EXPECT_THAT(refusal(good, [](Pack& p) { shorten(p.sh().vectors); }), HasSubstr("section vectors"));
  EXPECT_THAT(refusal(good, [](Pack& p) { setFloat(p.sh().vectors, 9, std::nanf("")); }),
              HasSubstr("section vectors, row 2: value 1"));
  EXPECT_THAT(refusal(good, [](Pack& p) { reflectionOf(p) = GgxLobe(); }), HasSubstr("transfer matrices"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.appearances.clear(); }), HasSubstr("materials"));
}

TEST(PackContents, ANearFieldNeedsItsSphere) {
  const Pack good = glossyPack(wavyGrid(3), Storage::kMatrix, Precision::kFloat32, Lobe::kGgx);
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().near_field->radius = 0; }), HasSubstr("nearField"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().near_field->radius = INFINITY; }), HasSubstr("nearField"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().near_field->center[2] = std::nanf(""); }),
              HasSubstr("nearField"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().near_field->vectors.columns = 11; }),
              HasSubstr("section nearVectors"));
}

TEST(PackContents, FramesHaveRightAngles) {
  const Pack good = glossyPack(wavyGrid(3), Storage::kMatrix, Precision::kFloat32, Lobe::kGgx);
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().glossy->tangents.clear(); }), HasSubstr("tangents"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().glossy->tangents[3][3] = 0.5F; }),
              HasSubstr("tangents, vertex 3"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().glossy->tangents[3][0] *= 2; }),
              HasSubstr("tangents, vertex 3"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.sh().glossy->tangents[3][1] = std::nanf(""); }),
              HasSubstr("tangents, vertex 3"));
  EXPECT_THAT(refusal(good,
                      [](Pack& p) {
                        const Float3& n = p.mesh.normals[5];
                        p.sh().glossy->tangents[5] = {n[0], n[1], n[2], 1};
                      }),
              AllOf(HasSubstr("vertex 5"), HasSubstr("right angles")));
}

TEST(PackContents, TablesThatDoNotFitAreRefusedByName) {
  const Pack matrix = glossyPack(wavyGrid(3), Storage::kMatrix, Precision::kFloat16, Lobe::kGgx);
  EXPECT_THAT(refusal(matrix, [](Pack& p) { p.sh().glossy->output_order = 2; }),
              HasSubstr("section matrices"));
  EXPECT_THAT(refusal(matrix, [](Pack& p) { p.sh().glossy->output_order = 0; }), HasSubstr("outputOrder"));
  EXPECT_THAT(refusal(matrix, [](Pack& p) { setByte(p.sh().glossy->vertexTable(), 1, std::byte{0x7C}); }),
              HasSubstr("section matrices, row 0: value 0"));
  const Pack coded = glossyPack(wavyGrid(3), Storage::kVisibility, Precision::kUint8, Lobe::kGgx);
  EXPECT_THAT(refusal(coded, [](Pack& p) { p.sh().glossy->vertexTable().scale.pop_back(); }),
              HasSubstr("section visibility"));
  EXPECT_THAT(refusal(coded, [](Pack& p) { p.sh().glossy->vertexTable().scale[2] = INFINITY; }),
              HasSubstr("section visibility, column 2"));
  EXPECT_THAT(refusal(coded, [](Pack& p) { p.sh().glossy->vertexTable().precision = Precision::kFloat16; }),
              HasSubstr("section visibility"));
  EXPECT_THAT(refusal(coded,
                      [](Pack& p) {
                        p.sh().channels = 3;
                        p.sh().vectors = tableOver(p.mesh, 12, Precision::kFloat32, 0);
                        p.sh().near_field.reset();
                      }),
              HasSubstr("no colour"));
}

TEST(PackContents, ClustersAreInRange) {
  const Pack good = glossyPack(wavyGrid(3), Storage::kCpca, Precision::kUint8, Lobe::kGgx);
  ASSERT_EQ(encodeErrorOf(good), "no error");
  EXPECT_THAT(refusal(good, [](Pack& p) { clustersOf(p).clusters[7] = 2; }),
              AllOf(HasSubstr("section clusters, vertex 7"), HasSubstr("less than 2")));
  EXPECT_THAT(refusal(good, [](Pack& p) { clustersOf(p).clusters.pop_back(); }), HasSubstr("clusters"));
  EXPECT_THAT(refusal(good, [](Pack& p) { clustersOf(p).basis = {}; }), HasSubstr("section basis"));
  EXPECT_THAT(refusal(good, [](Pack& p) { clustersOf(p).basis.rows = 5; }), HasSubstr("section basis"));
  EXPECT_THAT(refusal(good, [](Pack& p) { clustersOf(p).basis.columns = 107; }), HasSubstr("section basis"));
}

TEST(PackContents, LobesAreInRange) {
  const auto with = [](Lobe lobe) {
    return glossyPack(wavyGrid(3), Storage::kVisibility, Precision::kFloat32, lobe);
  };
  EXPECT_THAT(refusal(with(Lobe::kPhong), [](Pack& p) { reflectionAs<PhongLobe>(p).exponent = -1; }),
              AllOf(HasSubstr("material 0, exponent"), HasSubstr("0 or more")));
  EXPECT_THAT(refusal(with(Lobe::kGgx), [](Pack& p) { reflectionAs<GgxLobe>(p).roughness = 1.1F; }),
              AllOf(HasSubstr("roughness"), HasSubstr("0 to 1")));
  EXPECT_THAT(refusal(with(Lobe::kGgx), [](Pack& p) { reflectionAs<GgxLobe>(p).specular_color[0] = 2; }),
              HasSubstr("specularColor"));
  const Pack table = with(Lobe::kTable);
  EXPECT_THAT(refusal(table,
                      [](Pack& p) {
                        auto& brdf = reflectionAs<BrdfTable>(p);
                        brdf.order = 2;
                        brdf.values.resize(4 * 3 * 4);
                      }),
              HasSubstr("output order"));
  EXPECT_THAT(refusal(table, [](Pack& p) { reflectionAs<BrdfTable>(p).angles = 1; }), HasSubstr("angles"));
  EXPECT_THAT(refusal(table, [](Pack& p) { reflectionAs<BrdfTable>(p).values.pop_back(); }),
              HasSubstr("section brdf"));
  EXPECT_THAT(refusal(table, [](Pack& p) { reflectionAs<BrdfTable>(p).values[8] = INFINITY; }),
              HasSubstr("value 8"));
}

// ---- hostile files

// A GLB with valid checksums around any JSON, as a hostile author can make it.
Bytes withJson(const Pack& pack, const std::function<void(Json&)>& change) {
  const Bytes bytes = encodePack(pack, {}, "a.glb");
  Json document = jsonOf(bytes);
  for (const char* key : {"bufferViews", "buffers", "extensions"}) document.erase(key);
  change(document);
  GlbWriter writer;
  for (const PackSection& section : packSections(bytes, "a.glb")) {
    writer.addSection(section.name, std::span(bytes).subspan(section.offset_bytes, section.size_bytes),
                      GlbTarget::kNone);
  }
  return writer.finish(std::move(document), "a.glb");
}

std::string decodeErrorOf(std::span<const std::byte> bytes) {
  try {
    decodePack(bytes, "a.glb");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

void expectErrors(const Pack& pack, const std::vector<std::pair<std::string, Json>>& cases) {
  ASSERT_EQ(decodeErrorOf(withJson(pack, [](Json&) {})), "no error");
  for (const auto& [pointer, value] : cases) {
    const Bytes bytes = withJson(pack, [&](Json& json) { json.at(Json::json_pointer(pointer)) = value; });
    EXPECT_THAT(decodeErrorOf(bytes), HasSubstr("a.glb")) << pointer << " = " << value;
  }
}

TEST(HostilePack, NumbersOfMeshAndDiffuseTransfer) {
  expectErrors(diffusePack(wavyGrid(3), 2),
               {{"/accessors/1/count", 0x4000000000000001ULL},  // × 12 wraps
                {"/accessors/1/count", 10},
                {"/accessors/1/count", -9},
                {"/accessors/1/count", 9.5},
                {"/accessors/0/count", 0xFFFFFFFFFFFFFFFFULL},
                {"/accessors/1/bufferView", 99},
                {"/accessors/1/componentType", 5123},
                {"/meshes/0/primitives/0/attributes/POSITION", 18446744073709551615ULL},
                {"/meshes/0/primitives/0/indices", "0"},
                {kExtension + "/order", 4294967298ULL},  // 2 in 32 bits
                {kExtension + "/order", 11},
                {kExtension + "/channels", 2},
                {kExtension + "/channels", 3},
                {kExtension + "/kind", "other"},
                {kExtension + "/basis", "other"},
                {kExtension + "/transport", "maybe"},
                {kExtension + "/vectors/shape", {8, 4}},
                {kExtension + "/vectors/shape", {9, 0x4000000000000004ULL}},  // × 9 × 4 wraps
                {kExtension + "/vectors/shape", {9}},
                {kExtension + "/vectors/type", "float16"},
                {kExtension + "/vectors/type", "uint8"},
                {kExtension + "/vectors/type", "float64"},
                {kExtension + "/vectors/bufferView", 0},
                {kReflection + "/kind", "ggx"},
                {kReflection + "/kind", "other"},
                {"/meshes/0/primitives/0/material", 1},
                {"/materials", Json::array()},
                {"/materials/0/pbrMetallicRoughness/baseColorFactor", {1e300, 0, 0, 1}},
                {"/materials/0/pbrMetallicRoughness/baseColorFactor", {2, 0, 0, 1}},
                {"/meshes", Json::array()}});
}

TEST(HostilePack, NumbersOfClustersNearFieldAndLobe) {
  const std::string glossy = kExtension + "/glossy";
  expectErrors(glossyPack(wavyGrid(3), Storage::kCpca, Precision::kUint8, Lobe::kTable),
               {{glossy + "/operator", "matrix"},
                {glossy + "/operator", "none"},
                {glossy + "/outputOrder", 0},
                {glossy + "/outputOrder", 4},
                {glossy + "/weights/shape", {9, 0}},
                {glossy + "/weights/shape", {9, 0xFFFFFFFFFFFFFFFFULL}},
                {glossy + "/weights/scale", 0},
                {glossy + "/weights/offset", 99},
                {glossy + "/clusters/shape", {8}},
                {glossy + "/clusters/shape", {0x5555555555555557ULL}},
                {glossy + "/clusters/type", "uint32"},
                {glossy + "/clusters/type", "float32"},
                {glossy + "/clusters/bufferView", 0},
                {glossy + "/basis/shape", {0, 108}},
                {glossy + "/basis/type", "float32"},
                {kReflection + "/kind", "lobe"},
                {kReflection + "/kind", "ggx"},
                {kReflection + "/angles", 0},
                {kReflection + "/angles", 0xFFFFFFFFULL},
                {kReflection + "/order", 5},
                {"/meshes/0/primitives/0/attributes/TANGENT", 0},
                {"/meshes/0/primitives/0/attributes/COLOR_0", 2},
                {kExtension + "/nearField/radius", -1},
                {kExtension + "/nearField/radius", "wide"},
                {kExtension + "/nearField/center", {0, 0}},
                {kExtension + "/nearField/nearVectors/shape", {1, 12}}});
}

// ---- several materials

// The grid's triangles in three materials by turns, the vertices of each its own.
Pack packOfThreeMaterials(Lobe lobe) {
  const TriangleMesh grid = wavyGrid(4);
  TriangleMesh mesh;
  std::vector<std::uint32_t> materials;
  for (std::uint32_t material = 0; material < 3; ++material)
    for (std::size_t t = material; t < grid.triangleCount(); t += 3) {
      Triangle triangle;
      for (std::size_t c = 0; c < 3; ++c) {
        triangle[c] = static_cast<std::uint32_t>(mesh.vertexCount());
        const std::uint32_t v = grid.triangles[t][c];
        // Vertices are told apart by where they are.
        const Float3& p = grid.positions[v];
        mesh.positions.push_back({p[0], p[1] + 0.01F * static_cast<float>(triangle[c]), p[2]});
        mesh.normals.push_back(grid.normals[v]);
        mesh.texcoords.push_back(grid.texcoords[v]);
      }
      mesh.triangles.push_back(triangle);
      materials.push_back(material);
    }
  Pack pack = glossyPack(std::move(mesh), Storage::kCpca, Precision::kUint8, lobe);
  for (Float3& color : pack.colors) color = {0.5F, 0.25F, 0.125F};
  pack.mesh.triangle_materials = materials;
  pack.appearances = {{"wood", {0.1F, 0.2F, 0.3F}, LambertReflection()},
                      {"", {0.4F, 0.5F, 0.6F}, reflectionOf(pack)},
                      {"metal", {0.7F, 0.8F, 0.9F}, PhongLobe{4, {0.5F, 0.5F, 0.5F}}}};
  pack.mesh.material_names = {"wood", "", "metal"};
  return pack;
}

TEST(PackOfSeveralMaterials, RoundTripIsExact) {
  for (const bool draco : {false, true}) {
    const Pack source = packOfThreeMaterials(Lobe::kTable);
    const Pack read = roundTrip(source, {.draco = draco});
    expectSamePack(read, source);
    EXPECT_EQ(read.mesh.triangle_materials, source.mesh.triangle_materials);
    EXPECT_EQ(read.mesh.material_names, source.mesh.material_names);
    const std::vector<VertexRange> ranges = appearanceRanges(read), expected = appearanceRanges(source);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(ranges[i].end, expected[i].end);
  }
}

TEST(PackOfSeveralMaterials, EachIsAPrimitiveAndAMaterialOfGltf) {
  const Json document = jsonOf(encodePack(packOfThreeMaterials(Lobe::kGgx), {}, "a.glb"));
  ASSERT_EQ(document["meshes"][0]["primitives"].size(), 3U);
  EXPECT_EQ(document["meshes"][0]["primitives"][2]["material"], 2);
  EXPECT_EQ(document["materials"][2]["name"], "metal");
  EXPECT_FALSE(document["materials"][1].contains("name"));
}

TEST(PackOfSeveralMaterials, VerticesBelongToOneAndAreInOrder) {
  const Pack good = packOfThreeMaterials(Lobe::kGgx);
  ASSERT_EQ(encodeErrorOf(good), "no error");
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh.triangles.back()[0] = 0; }), HasSubstr("order"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh.triangle_materials[0] = 3; }), HasSubstr("material 3"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.mesh.triangle_materials.clear(); }), HasSubstr("materials"));
  EXPECT_THAT(refusal(good, [](Pack& p) { std::fill_n(p.mesh.triangle_materials.begin(), 6, 1U); }),
              HasSubstr("material 0"));
}

// ---- released versions

std::filesystem::path goldenPath(const std::string& name) {
  return std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/unit/formats/golden" / name;
}

// wavyGrid(3) has its vertices at multiples of a half.
std::size_t gridVertexAt(const Float3& position) {
  return static_cast<std::size_t>(std::lround(-position[2] * 2) * 3 + std::lround(position[0] * 2));
}

void expectNear(const EncodedTable& read, const EncodedTable& expected,
                const std::vector<std::size_t>& source_of) {
  ASSERT_EQ(read.precision, expected.precision);
  ASSERT_EQ(read.columns, expected.columns);
  ASSERT_EQ(read.rows, expected.empty() ? 0 : source_of.size());
  const std::vector<float> values = read.decode(), sources = expected.decode();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t column = i % read.columns;
    // A rounding of the last bit may tip a code, or a half, over to its neighbour.
    const float step = read.precision == Precision::kUint8     ? read.scale[column]
                       : read.precision == Precision::kFloat16 ? 1e-3F * std::abs(values[i])
                                                               : 0;
    ASSERT_NEAR(values[i], sources[source_of[i / read.columns] * read.columns + column], step + 1e-5F) << i;
  }
}

void expectGoldenGlossy(const GlossyTransfer& read, const GlossyTransfer& expected,
                        const std::vector<std::size_t>& source_of) {
  ASSERT_STREQ(read.operatorName(), expected.operatorName());
  EXPECT_EQ(read.output_order, expected.output_order);
  ASSERT_EQ(read.tangents.size(), source_of.size());
  for (std::size_t i = 0; i < source_of.size(); ++i)
    for (std::size_t axis = 0; axis < 4; ++axis)
      EXPECT_NEAR(read.tangents[i][axis], expected.tangents[source_of[i]][axis], 1e-6F);
  expectNear(read.vertexTable(), expected.vertexTable(), source_of);
  if (const auto* clusters = std::get_if<ClusteredOperator>(&read.transfer)) {
    const auto& golden = std::get<ClusteredOperator>(expected.transfer);
    EXPECT_EQ(clusters->basis.decode(), golden.basis.decode());
    for (std::size_t i = 0; i < source_of.size(); ++i)
      EXPECT_EQ(clusters->clusters[i], golden.clusters[source_of[i]]);
  }
}

// Sines differ in the last bit between C libraries, so values near, not equal, to a pack made today; and by
// position, as Draco reorders.
void expectGolden(const Pack& read, const Pack& expected) {
  ASSERT_EQ(read.mesh.vertexCount(), 9U);
  ASSERT_EQ(read.mesh.triangleCount(), 8U);
  EXPECT_EQ(read.name, "grid");
  EXPECT_EQ(read.appearances[0].base_color, expected.appearances[0].base_color);
  ASSERT_EQ(read.colors.size(), expected.colors.size());
  std::vector<std::size_t> source_of;
  for (std::size_t i = 0; i < 9; ++i) {
    const std::size_t source = gridVertexAt(read.mesh.positions[i]);
    source_of.push_back(source);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(read.mesh.positions[i][axis], expected.mesh.positions[source][axis], 1e-6F);
      EXPECT_NEAR(read.mesh.normals[i][axis], expected.mesh.normals[source][axis], 1e-6F);
    }
    EXPECT_EQ(read.mesh.texcoords[i], expected.mesh.texcoords[source]);
    if (!read.colors.empty()) {
      EXPECT_EQ(read.colors[i], expected.colors[source]);
    }
  }
  const ShTransfer &transfer = read.sh(), &golden = expected.sh();
  EXPECT_EQ(transfer.transport, golden.transport);
  EXPECT_EQ(transfer.channels, golden.channels);
  expectNear(transfer.vectors, golden.vectors, source_of);
  ASSERT_EQ(transfer.near_field.has_value(), golden.near_field.has_value());
  if (golden.near_field) {
    EXPECT_EQ(transfer.near_field->center, golden.near_field->center);
    EXPECT_EQ(transfer.near_field->radius, golden.near_field->radius);
    expectNear(transfer.near_field->vectors, golden.near_field->vectors, source_of);
  }
  expectSameReflection(read.appearances[0].reflection, expected.appearances[0].reflection);
  ASSERT_EQ(transfer.glossy.has_value(), golden.glossy.has_value());
  if (golden.glossy) expectGoldenGlossy(*transfer.glossy, *golden.glossy, source_of);
}

struct Golden {
  const char* file;
  int version;
  Pack pack;
};

std::vector<Golden> goldens() {
  const TriangleMesh grid = wavyGrid(3);
  const auto glossy = [&](Storage storage, Precision precision, Lobe lobe) {
    return glossyPack(grid, storage, precision, lobe);
  };
  return {
      {"pack-v1.glb", 1, diffusePack(grid, 2)},
      {"pack-v1-draco.glb", 1, diffusePack(grid, 2)},
      {"pack-v2-diffuse.glb", 2, diffusePack(grid, 2)},
      {"pack-v2-matrix-uint8-phong.glb", 2, glossy(Storage::kMatrix, Precision::kUint8, Lobe::kPhong)},
      {"pack-v2-matrix-float32-draco.glb", 2, glossy(Storage::kMatrix, Precision::kFloat32, Lobe::kGgx)},
      {"pack-v2-visibility-float16-ggx.glb", 2,
       glossy(Storage::kVisibility, Precision::kFloat16, Lobe::kGgx)},
      {"pack-v2-cpca-uint8-table.glb", 2, glossy(Storage::kCpca, Precision::kUint8, Lobe::kTable)},
  };
}

// Packs as each release wrote them. They stay readable for ever.
TEST(GoldenPack, EachReleasedVersionStaysReadable) {
  for (const Golden& golden : goldens()) {
    SCOPED_TRACE(golden.file);
    const Bytes bytes = readFile(goldenPath(golden.file));
    EXPECT_EQ(packVersion(bytes, golden.file), golden.version);
    expectGolden(decodePack(bytes, golden.file), golden.pack);
  }
}

}  // namespace
}  // namespace bakelight::formats
