// What packs hold: each storage at each precision, there and back, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
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

constexpr MatrixStorage kStorages[] = {MatrixStorage::kMatrix, MatrixStorage::kVisibility,
                                       MatrixStorage::kCpca};
constexpr Precision kPrecisions[] = {Precision::kFloat32, Precision::kFloat16, Precision::kUint8};
constexpr LobeModel kLobes[] = {LobeModel::kNone, LobeModel::kPhong, LobeModel::kGgx, LobeModel::kTable};
const std::string kExtension = std::string("/meshes/0/primitives/0/extensions/") + kTransferExtension;

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

class StoredPack : public testing::TestWithParam<std::tuple<MatrixStorage, Precision>> {
 protected:
  Pack pack(std::uint32_t n, LobeModel lobe = LobeModel::kGgx) const {
    return glossyPack(wavyGrid(n), std::get<0>(GetParam()), std::get<1>(GetParam()), lobe);
  }
};

TEST_P(StoredPack, RoundTripIsExactWithEachLobe) {
  for (const LobeModel lobe : kLobes) {
    const Pack source = pack(4, lobe);
    ASSERT_EQ(source.transfer.matrices.precision, std::get<1>(GetParam()));
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

TEST_P(StoredPack, QuantisedNormalsKeepFramesOfRightAngles) {
  const Pack source = pack(9);
  const Pack read = roundTrip(source, {.draco = true, .position_bits = 10, .normal_bits = 6});
  ASSERT_EQ(read.transfer.tangents.size(), source.mesh.vertexCount());
  for (std::size_t i = 0; i < read.transfer.tangents.size(); ++i) {
    const Float4& t = read.transfer.tangents[i];
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
  EXPECT_THAT(sectionNames(glossyPack(mesh, MatrixStorage::kMatrix, Precision::kFloat16, LobeModel::kPhong)),
              ElementsAre("indices", "positions", "normals", "tangents", "colors", "transfer", "nearTransfer",
                          "matrices"));
  EXPECT_THAT(sectionNames(glossyPack(mesh, MatrixStorage::kVisibility, Precision::kUint8, LobeModel::kGgx)),
              ElementsAre("indices", "positions", "normals", "tangents", "colors", "transfer", "nearTransfer",
                          "visibility", "visibilityScale", "visibilityOffset"));
  EXPECT_THAT(sectionNames(glossyPack(mesh, MatrixStorage::kCpca, Precision::kFloat32, LobeModel::kTable),
                           {.draco = true}),
              ElementsAre("draco", "tangents", "colors", "transfer", "nearTransfer", "weights", "clusters",
                          "basis", "brdf"));
}

TEST(PackContents, VersionIsTheOneWritten) {
  EXPECT_EQ(packVersion(encodePack(diffusePack(wavyGrid(2), 1), {}, "a.glb"), "a.glb"), 2);
}

TEST(PackContents, GltfViewersSeeRoughnessTangentsAndColours) {
  const auto documentOf = [](LobeModel lobe) {
    return jsonOf(
        encodePack(glossyPack(wavyGrid(3), MatrixStorage::kMatrix, Precision::kUint8, lobe), {}, "a.glb"));
  };
  const auto roughness = [&](LobeModel lobe) {
    return documentOf(lobe)["/materials/0/pbrMetallicRoughness/roughnessFactor"_json_pointer].get<float>();
  };
  EXPECT_FLOAT_EQ(roughness(LobeModel::kGgx), 0.37F);
  EXPECT_FLOAT_EQ(roughness(LobeModel::kPhong), std::pow(2 / (4 * 12.3F + 2), 0.25F));
  EXPECT_EQ(roughness(LobeModel::kTable), 1);
  const Json document = documentOf(LobeModel::kGgx);
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
  std::memcpy(table.data.data() + i * sizeof value, &value, sizeof value);
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
  EXPECT_THAT(refusal(good, [](Pack& p) { p.base_color[1] = 1.5F; }), HasSubstr("base colour"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.colors.assign(8, {0, 0, 0}); }), HasSubstr("colors"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.colors.assign(9, {0, -1, 0}); }), HasSubstr("colors, vertex 0"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.order = 11; }), HasSubstr("order"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.transport = "guessed"; }), HasSubstr("'guessed'"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.channels = 2; }), HasSubstr("2 channels"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.channels = 3; }),
              HasSubstr("9 vertices × 12 coefficients"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.vectors.rows = 8; }), HasSubstr("section transfer"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.vectors.data.pop_back(); }),
              HasSubstr("section transfer"));
  EXPECT_THAT(refusal(good, [](Pack& p) { setFloat(p.transfer.vectors, 9, std::nanf("")); }),
              HasSubstr("section transfer, row 2: value 1"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.tangents = tangentsOf(p.mesh); }), HasSubstr("diffuse"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.material.model = LobeModel::kGgx; }),
              HasSubstr("diffuse"));
}

TEST(PackContents, ANearFieldNeedsItsSphere) {
  const Pack good = glossyPack(wavyGrid(3), MatrixStorage::kMatrix, Precision::kFloat32, LobeModel::kGgx);
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.sphere_radius = 0; }), HasSubstr("near field"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.sphere_radius = INFINITY; }), HasSubstr("near field"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.sphere_center[2] = std::nanf(""); }),
              HasSubstr("near field"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.near_vectors.columns = 11; }),
              HasSubstr("section nearTransfer"));
}

TEST(PackContents, FramesHaveRightAngles) {
  const Pack good = glossyPack(wavyGrid(3), MatrixStorage::kMatrix, Precision::kFloat32, LobeModel::kGgx);
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.tangents.clear(); }), HasSubstr("tangents"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.tangents[3][3] = 0.5F; }),
              HasSubstr("tangents, vertex 3"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.tangents[3][0] *= 2; }),
              HasSubstr("tangents, vertex 3"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.tangents[3][1] = std::nanf(""); }),
              HasSubstr("tangents, vertex 3"));
  EXPECT_THAT(refusal(good,
                      [](Pack& p) {
                        const Float3& n = p.mesh.normals[5];
                        p.transfer.tangents[5] = {n[0], n[1], n[2], 1};
                      }),
              AllOf(HasSubstr("vertex 5"), HasSubstr("right angles")));
}

TEST(PackContents, TablesThatDoNotFitAreRefusedByName) {
  const Pack matrix = glossyPack(wavyGrid(3), MatrixStorage::kMatrix, Precision::kFloat16, LobeModel::kGgx);
  EXPECT_THAT(refusal(matrix, [](Pack& p) { p.transfer.row_order = 2; }), HasSubstr("section matrices"));
  EXPECT_THAT(refusal(matrix, [](Pack& p) { p.transfer.row_order = 0; }), HasSubstr("row order"));
  EXPECT_THAT(refusal(matrix, [](Pack& p) { p.transfer.matrices.data[1] = std::byte{0x7C}; }),
              HasSubstr("section matrices, row 0: value 0"));
  EXPECT_THAT(refusal(matrix, [](Pack& p) { p.transfer.clusters.assign(9, 0); }), HasSubstr("clusters"));
  const Pack coded = glossyPack(wavyGrid(3), MatrixStorage::kVisibility, Precision::kUint8, LobeModel::kGgx);
  EXPECT_THAT(refusal(coded, [](Pack& p) { p.transfer.matrices.scale.pop_back(); }),
              HasSubstr("section visibility"));
  EXPECT_THAT(refusal(coded, [](Pack& p) { p.transfer.matrices.scale[2] = INFINITY; }),
              HasSubstr("section visibility, column 2"));
  EXPECT_THAT(refusal(coded, [](Pack& p) { p.transfer.matrices.precision = Precision::kFloat16; }),
              HasSubstr("section visibility"));
  EXPECT_THAT(refusal(coded,
                      [](Pack& p) {
                        p.transfer.channels = 3;
                        p.transfer.vectors = tableOver(p.mesh, 12, Precision::kFloat32, 0);
                        p.transfer.near_vectors = {};
                      }),
              HasSubstr("no colour"));
}

TEST(PackContents, ClustersAreInRange) {
  const Pack good = glossyPack(wavyGrid(3), MatrixStorage::kCpca, Precision::kUint8, LobeModel::kGgx);
  ASSERT_EQ(encodeErrorOf(good), "no error");
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.clusters[7] = 2; }),
              AllOf(HasSubstr("section clusters, vertex 7"), HasSubstr("no cluster 2")));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.clusters.pop_back(); }), HasSubstr("clusters"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.basis = {}; }), HasSubstr("section basis"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.basis.rows = 5; }), HasSubstr("section basis"));
  EXPECT_THAT(refusal(good, [](Pack& p) { p.transfer.basis.columns = 107; }), HasSubstr("section basis"));
}

TEST(PackContents, LobesAreInRange) {
  const auto with = [](LobeModel lobe) {
    return glossyPack(wavyGrid(3), MatrixStorage::kVisibility, Precision::kFloat32, lobe);
  };
  EXPECT_THAT(refusal(with(LobeModel::kPhong), [](Pack& p) { p.transfer.material.exponent = -1; }),
              HasSubstr("exponent"));
  EXPECT_THAT(refusal(with(LobeModel::kGgx), [](Pack& p) { p.transfer.material.roughness = 1.1F; }),
              HasSubstr("roughness"));
  EXPECT_THAT(refusal(with(LobeModel::kGgx), [](Pack& p) { p.transfer.material.specular_color[0] = 2; }),
              HasSubstr("specular colour"));
  const Pack table = with(LobeModel::kTable);
  EXPECT_THAT(refusal(table, [](Pack& p) { p.transfer.material.table.order = 2; }), HasSubstr("row order"));
  EXPECT_THAT(refusal(table, [](Pack& p) { p.transfer.material.table.angles = 1; }),
              HasSubstr("section brdf"));
  EXPECT_THAT(refusal(table, [](Pack& p) { p.transfer.material.table.values.pop_back(); }),
              HasSubstr("section brdf"));
  EXPECT_THAT(refusal(table, [](Pack& p) { p.transfer.material.table.values[8] = INFINITY; }),
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
                {kExtension + "/technique", "glossy"},
                {kExtension + "/technique", "other"},
                {kExtension + "/transport", "maybe"},
                {kExtension + "/transfer/rows", 8},
                {kExtension + "/transfer/columns", 0x4000000000000004ULL},  // × 9 × 4 wraps
                {kExtension + "/transfer/precision", "float16"},
                {kExtension + "/transfer/precision", "uint8"},
                {kExtension + "/transfer/precision", "float64"},
                {kExtension + "/transfer/bufferView", 0},
                {"/materials/0/pbrMetallicRoughness/baseColorFactor", {1e300, 0, 0, 1}},
                {"/materials/0/pbrMetallicRoughness/baseColorFactor", {2, 0, 0, 1}},
                {"/meshes", Json::array()}});
}

TEST(HostilePack, NumbersOfClustersNearFieldAndLobe) {
  const std::string glossy = kExtension + "/glossy";
  expectErrors(glossyPack(wavyGrid(3), MatrixStorage::kCpca, Precision::kUint8, LobeModel::kTable),
               {{glossy + "/storage", "matrix"},
                {glossy + "/storage", "none"},
                {glossy + "/rowOrder", 0},
                {glossy + "/rowOrder", 4},
                {glossy + "/frame", "object"},
                {glossy + "/weights/columns", 0},
                {glossy + "/weights/columns", 0xFFFFFFFFFFFFFFFFULL},
                {glossy + "/weights/scale", 0},
                {glossy + "/weights/offset", 99},
                {glossy + "/clusters/count", 1},
                {glossy + "/clusters/count", 0x5555555555555557ULL},  // × 3 wraps to 5
                {glossy + "/clusters/bufferView", 0},
                {glossy + "/basis/rows", 0},
                {glossy + "/basis/precision", "float32"},
                {glossy + "/lobe/model", "none"},
                {glossy + "/lobe/model", "ggx"},
                {glossy + "/lobe/angles", 0},
                {glossy + "/lobe/angles", 0xFFFFFFFFULL},
                {glossy + "/lobe/order", 5},
                {"/meshes/0/primitives/0/attributes/TANGENT", 0},
                {"/meshes/0/primitives/0/attributes/COLOR_0", 2},
                {kExtension + "/nearField/radius", -1},
                {kExtension + "/nearField/radius", "wide"},
                {kExtension + "/nearField/center", {0, 0}},
                {kExtension + "/nearField/transfer/rows", 1}});
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

// Sines differ in the last bit between C libraries, so values near, not equal, to a pack made today; and by
// position, as Draco reorders.
void expectGolden(const Pack& read, const Pack& expected) {
  ASSERT_EQ(read.mesh.vertexCount(), 9U);
  ASSERT_EQ(read.mesh.triangleCount(), 8U);
  EXPECT_EQ(read.name, "grid");
  EXPECT_EQ(read.base_color, expected.base_color);
  ASSERT_EQ(read.colors.size(), expected.colors.size());
  ASSERT_EQ(read.transfer.tangents.size(), expected.transfer.tangents.size());
  ASSERT_EQ(read.transfer.clusters.size(), expected.transfer.clusters.size());
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
    if (!read.transfer.clusters.empty()) {
      EXPECT_EQ(read.transfer.clusters[i], expected.transfer.clusters[source]);
    }
    for (std::size_t axis = 0; axis < 4 && !read.transfer.tangents.empty(); ++axis)
      EXPECT_NEAR(read.transfer.tangents[i][axis], expected.transfer.tangents[source][axis], 1e-6F);
  }
  EXPECT_EQ(read.transfer.transport, expected.transfer.transport);
  EXPECT_EQ(read.transfer.channels, expected.transfer.channels);
  EXPECT_EQ(read.transfer.storage, expected.transfer.storage);
  EXPECT_EQ(read.transfer.row_order, expected.transfer.row_order);
  EXPECT_EQ(read.transfer.sphere_center, expected.transfer.sphere_center);
  EXPECT_EQ(read.transfer.sphere_radius, expected.transfer.sphere_radius);
  expectNear(read.transfer.vectors, expected.transfer.vectors, source_of);
  expectNear(read.transfer.near_vectors, expected.transfer.near_vectors, source_of);
  expectNear(read.transfer.matrices, expected.transfer.matrices, source_of);
  EXPECT_EQ(read.transfer.basis.decode(), expected.transfer.basis.decode());
  expectSameMaterial(read.transfer.material, expected.transfer.material);
}

struct Golden {
  const char* file;
  int version;
  Pack pack;
};

std::vector<Golden> goldens() {
  const TriangleMesh grid = wavyGrid(3);
  const auto glossy = [&](MatrixStorage storage, Precision precision, LobeModel lobe) {
    return glossyPack(grid, storage, precision, lobe);
  };
  return {
      {"pack-v1.glb", 1, diffusePack(grid, 2)},
      {"pack-v1-draco.glb", 1, diffusePack(grid, 2)},
      {"pack-v2-diffuse.glb", 2, diffusePack(grid, 2)},
      {"pack-v2-matrix-uint8-phong.glb", 2,
       glossy(MatrixStorage::kMatrix, Precision::kUint8, LobeModel::kPhong)},
      {"pack-v2-matrix-float32-draco.glb", 2,
       glossy(MatrixStorage::kMatrix, Precision::kFloat32, LobeModel::kGgx)},
      {"pack-v2-visibility-float16-ggx.glb", 2,
       glossy(MatrixStorage::kVisibility, Precision::kFloat16, LobeModel::kGgx)},
      {"pack-v2-cpca-uint8-table.glb", 2, glossy(MatrixStorage::kCpca, Precision::kUint8, LobeModel::kTable)},
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
