#include "formats/mesh_gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <functional>
#include <random>

#include "formats/draco_mesh.h"
#include "formats/error.h"
#include "formats/mesh_import.h"
#include "tests/unit/formats/gltf_maker.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::filesystem::path kCases = std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/cases/gltf";

MeshImport read(const std::string& content) {
  return merged(readGltf("a.gltf", bytesOf(content)), "a.gltf");
}
MeshImport read(const GltfMaker& file) {
  return read(file.text());
}

std::string errorOf(const std::string& content) {
  try {
    read(content);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(MeshGltfTest, TheBracketTextAndBinary) {
  for (const std::string& content :
       {bracketFile().text(), bracketFile().glb(), "\xEF\xBB\xBF" + bracketFile().text()}) {
    const MeshImport import = read(content);
    expectSameTriangles(import.mesh, bracket(), content.substr(0, 4));
    EXPECT_THAT(import.notes, IsEmpty());
    EXPECT_THAT(import.mesh.colors, IsEmpty());
    EXPECT_THAT(import.mesh.normals, IsEmpty());
    EXPECT_THAT(import.mesh.material_names, IsEmpty());
  }
}

TEST(MeshGltfTest, FilesThatOtherReadersGotWrong) {
  for (const char* name :
       {"quantized.gltf", "skin_scaled_node.gltf", "uv_ushort.gltf", "uri_space/my model.gltf",
        "texture_transform/moved.gltf", "base_colour_factor.gltf"}) {
    const TriangleMesh mesh = importMesh(kCases / name).mesh;
    const BodyFigures figures = figuresOf(mesh);
    EXPECT_EQ(mesh.triangleCount(), 20U) << name;
    EXPECT_NEAR(figures.area, 18, 2e-3) << name;
    EXPECT_NEAR(figures.volume, 4, 2e-3) << name;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(figures.high[k], 3 - static_cast<float>(k), 2e-4F) << name;
  }
  EXPECT_EQ(figuresOf(importMesh(kCases / "morph_default_weight.gltf").mesh).high, (Float3{3, 4, 1}));
  EXPECT_EQ(importMesh(kCases / "gpu_instancing.gltf").mesh.triangleCount(), 60U);
  const TriangleMesh unwrapped = importMesh(kCases / "uv_ushort.gltf").mesh;
  for (std::size_t i = 0; i < unwrapped.vertexCount(); ++i)
    EXPECT_NEAR(unwrapped.texcoords.at(i)[0], unwrapped.positions[i][0] / 3, 1e-5F);
  const MeshImport moved = importMesh(kCases / "texture_transform/moved.gltf");
  ASSERT_EQ(moved.textures.size(), 1U);
  EXPECT_TRUE(std::filesystem::exists(moved.textures[0].path));
  for (std::size_t i = 0; i < moved.mesh.vertexCount(); ++i)
    EXPECT_NEAR(moved.texture_lookups.at(i)[0], moved.mesh.texcoords.at(i)[0] + 0.5F, 1e-6F);
  EXPECT_EQ(importMesh(kCases / "base_colour_factor.gltf").mesh.colors.size(), 12U);
  // Its Draco data are a header and zeros: an empty point cloud.
  try {
    importMesh(kCases / "draco_required.glb");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("KHR_draco_mesh_compression"), HasSubstr("not a mesh")));
  }
}

TEST(MeshGltfTest, FbxIsTurnedUpright) {
  const MeshImport import = importMesh(kCases.parent_path() / "fbx/z_up.fbx");
  const BodyFigures figures = figuresOf(import.mesh);
  EXPECT_EQ(import.mesh.triangleCount(), 20U);
  EXPECT_NEAR(figures.area, 18, 1e-9);
  EXPECT_NEAR(figures.volume, 4, 1e-9);
  EXPECT_EQ(figures.low, (Float3{0, 0, -2}));
  EXPECT_EQ(figures.high, (Float3{3, 1, 0}));
  EXPECT_THAT(import.notes, Contains(HasSubstr("+Z up: turned to +Y up")));
}

// --- Accessors

template <class Value>
std::vector<Value> codesOf(const std::vector<Float3>& positions, double scale) {
  std::vector<Value> codes;
  for (const float v : flat(positions)) codes.push_back(static_cast<Value>(std::lround(v * scale)));
  return codes;
}

template <class Value>
void expectQuantized(bool normalized) {
  constexpr double kLargest = std::numeric_limits<Value>::max(), kStep = 30;
  GltfMaker file = bracketFile();
  file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  file.attribute("POSITION", file.accessor(codesOf<Value>(bracket().positions, kStep), "VEC3", normalized));
  const double scale = normalized ? kLargest / kStep : 1 / kStep;
  file.json["nodes"][0]["scale"] = {scale, scale, scale};
  expectSameTriangles(read(file).mesh, bracket(),
                      std::to_string(gltfCode<Value>()) + (normalized ? " n" : ""));
}

TEST(MeshGltfTest, PositionsOfAllComponentTypes) {
  for (const bool normalized : {false, true}) {
    expectQuantized<std::int8_t>(normalized);
    expectQuantized<std::uint8_t>(normalized);
    expectQuantized<std::int16_t>(normalized);
    expectQuantized<std::uint16_t>(normalized);
  }
}

TEST(MeshGltfTest, IndicesOfAllTypesAndNone) {
  GltfMaker bytes = bracketFile(), words = bracketFile(), none = bracketFile();
  bytes.primitive()["indices"] = bytes.accessor(indicesOf<std::uint8_t>(bracket()), "SCALAR");
  words.primitive()["indices"] = words.accessor(indicesOf<std::uint32_t>(bracket()), "SCALAR");
  none.primitive().erase("indices");
  std::vector<Float3> corners;
  for (const std::uint32_t i : flat(bracket().triangles)) corners.push_back(bracket().positions[i]);
  none.attribute("POSITION", none.accessor(flat(corners), "VEC3"));
  expectSameTriangles(read(bytes).mesh, bracket(), "8 bits");
  expectSameTriangles(read(words).mesh, bracket(), "32 bits");
  expectSameTriangles(read(none).mesh, bracket(), "no indices");
}

TEST(MeshGltfTest, StripsAndFansKeepTheirSide) {
  GltfMaker file = bracketFile();
  file.primitive()["mode"] = 5;
  file.primitive()["indices"] =
      file.accessor(std::vector<std::uint16_t>{0, 1, 2, 3, 3, 4, 4, 5, 6}, "SCALAR");
  EXPECT_THAT(read(file).mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{1, 3, 2}, Triangle{4, 5, 6}))
      << "triangles with two equal corners only lead on";
  file.primitive()["mode"] = 6;
  file.primitive()["indices"] = file.accessor(std::vector<std::uint16_t>{0, 1, 2, 3}, "SCALAR");
  EXPECT_THAT(read(file).mesh.triangles, ElementsAre(Triangle{1, 2, 0}, Triangle{2, 3, 0}));
}

TEST(MeshGltfTest, PointsLinesAndLeftoversAreNoted) {
  GltfMaker file = bracketFile();
  Json lines = file.primitive();
  lines["mode"] = 1;
  file.json["meshes"][0]["primitives"].push_back(lines);
  auto indices = indicesOf<std::uint16_t>(bracket());
  indices.push_back(0);
  file.primitive()["indices"] = file.accessor(indices, "SCALAR");
  const MeshImport import = read(file);
  expectBracket(import.mesh, "with lines");
  EXPECT_THAT(import.notes,
              ElementsAre(HasSubstr("1 primitive of points or lines"), HasSubstr("1 corner was")));
}

TEST(MeshGltfTest, InterleavedAttributes) {
  GltfMaker file = bracketFile();
  std::vector<float> rows;
  for (const Float3& p : bracket().positions) {
    for (const float value : {9.F, p[0], p[1], p[2], p[0] / 4, p[1] / 4}) rows.push_back(value);
  }
  const int table = file.accessor(rows, "SCALAR");
  const int view = file.json["accessors"][table]["bufferView"];
  file.json["bufferViews"][view]["byteStride"] = 24;
  const auto column = [&](int offset, const char* type) {
    file.json["accessors"].push_back({{"bufferView", view},
                                      {"byteOffset", offset},
                                      {"componentType", 5126},
                                      {"count", 12},
                                      {"type", type}});
    return static_cast<int>(file.json["accessors"].size()) - 1;
  };
  file.attribute("POSITION", column(4, "VEC3"));
  file.attribute("TEXCOORD_0", column(16, "VEC2"));
  const TriangleMesh mesh = read(file).mesh;
  expectSameTriangles(mesh, bracket(), "interleaved");
  EXPECT_EQ(mesh.texcoords[4], (Float2{0.25F, 0.5F})) << "origin at the lower left: v = 1 − 2 / 4";
}

TEST(MeshGltfTest, SparseAccessors) {
  GltfMaker file = bracketFile();
  std::vector<Float3> base = bracket().positions;
  base[1] = {7, 7, 7}, base[11] = {8, 8, 8};
  const int positions = file.accessor(flat(base), "VEC3");
  const int places = file.accessor(std::vector<std::uint8_t>{1, 11}, "SCALAR");
  const int values = file.accessor(flat(std::vector<Float3>{{3, 0, 0}, {0, 2, 1}}), "VEC3");
  const auto view = [&](int accessor) { return file.json["accessors"][accessor]["bufferView"]; };
  file.json["accessors"][positions]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", view(places)}, {"componentType", 5121}}},
      {"values", {{"bufferView", view(values)}}}};
  file.attribute("POSITION", positions);
  expectSameTriangles(read(file).mesh, bracket(), "sparse");
  file.json["accessors"][positions].erase("bufferView");
  const TriangleMesh mesh = read(file).mesh;
  EXPECT_EQ(mesh.positions[1], (Float3{3, 0, 0}));
  EXPECT_EQ(mesh.positions[2], (Float3{0, 0, 0})) << "without a view, what is not replaced is zero";
}

TEST(MeshGltfTest, ColoursAndTextureCoordinatesOfAllTypes) {
  GltfMaker file = bracketFile();
  const std::vector<std::uint8_t> bytes(36, 51);
  const std::vector<std::uint16_t> shorts(48, 13107);
  const std::vector<float> floats(48, 0.2F);
  for (const int accessor : {file.accessor(bytes, "VEC3", true), file.accessor(bytes, "VEC3"),
                             file.accessor(shorts, "VEC4", true), file.accessor(floats, "VEC4")}) {
    file.attribute("COLOR_0", accessor);
    const MeshImport import = read(file);
    EXPECT_FLOAT_EQ(import.mesh.colors.at(5)[1], 0.2F) << accessor;
    EXPECT_EQ(import.notes.size(), accessor == 3 ? 1U : 0U) << "not marked as normalised: noted";
  }
  const std::vector<std::uint8_t> u(24, 51);
  const std::vector<std::uint16_t> v(24, 13107);
  for (const int accessor : {file.accessor(u, "VEC2", true), file.accessor(v, "VEC2", true),
                             file.accessor(std::vector<float>(24, 0.2F), "VEC2")}) {
    file.attribute("TEXCOORD_0", accessor);
    EXPECT_FLOAT_EQ(read(file).mesh.texcoords.at(3)[0], 0.2F) << accessor;
    EXPECT_FLOAT_EQ(read(file).mesh.texcoords.at(3)[1], 0.8F) << accessor;
  }
}

// --- Nodes

TEST(MeshGltfTest, NodeTransformsAreChainedInDoublePrecision) {
  GltfMaker file = bracketFile();
  file.json["nodes"] = Json::parse(R"([
    {"children": [1], "translation": [100000000, 0, 0]},
    {"children": [2], "rotation": [0, 0, 0.70710678118654752, 0.70710678118654752], "scale": [2, 2, 2]},
    {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,50000000,0.25,1]}])");
  const TriangleMesh mesh = read(file).mesh;
  EXPECT_NEAR(mesh.positions[0][0], 0, 1e-4F) << "single precision would be off by several units";
  EXPECT_NEAR(mesh.positions[1][1], 6, 1e-4F) << "x became y, twice as long";
  EXPECT_EQ(mesh.positions[0][2], 0.5F);
}

TEST(MeshGltfTest, MirroredNodesKeepTheirOutside) {
  GltfMaker file = bracketFile();
  file.attribute("NORMAL", file.accessor(flat(std::vector<Float3>(12, {0, 1, 0})), "VEC3"));
  file.json["nodes"][0]["scale"] = {1, -2, 1};
  const MeshImport import = read(file);
  EXPECT_NEAR(figuresOf(import.mesh).volume, 8, 1e-9);
  EXPECT_EQ(import.mesh.normals[0], (Float3{0, -1, 0}));
  EXPECT_THAT(import.notes, ElementsAre(HasSubstr("mirrored")));
}

TEST(MeshGltfTest, ScenesAndVisibility) {
  GltfMaker file = bracketFile();
  file.json["nodes"] = Json::parse(R"([{"mesh": 0}, {"children": [2, 3]}, {"mesh": 0},
    {"children": [4], "extensions": {"KHR_node_visibility": {"visible": false}}}, {"mesh": 0}])");
  file.json["scenes"] = Json::parse(R"([{"nodes": [0, 1]}, {"nodes": [0]}])");
  EXPECT_EQ(read(file).mesh.triangleCount(), 40U) << "not the hidden one";
  EXPECT_THAT(read(file).notes, AllOf(Contains(HasSubstr("2 scenes")), Contains(HasSubstr("invisible"))));
  file.json["scene"] = 1;
  EXPECT_EQ(read(file).mesh.triangleCount(), 20U);
  file.json.erase("scene"), file.json.erase("scenes");
  EXPECT_EQ(read(file).mesh.triangleCount(), 40U) << "all root nodes";
  file.json.erase("nodes");
  EXPECT_EQ(read(file).mesh.triangleCount(), 20U) << "a library of meshes";
}

TEST(MeshGltfTest, PrimitivesThatShareVerticesDoNotMultiplyThem) {
  GltfMaker file = bracketFile();
  Json second = file.primitive();
  second["indices"] = file.accessor(std::vector<std::uint16_t>{6, 7, 8}, "SCALAR");
  file.json["meshes"][0]["primitives"].push_back(second);
  const MeshImport import = read(file);
  EXPECT_EQ(import.mesh.vertexCount(), 15U);
  EXPECT_EQ(import.mesh.positions[import.mesh.triangles[20][2]], bracket().positions[8]);
}

// Bones at y = 0 and 1; the upper one is turned by a quarter about z.
GltfMaker skinnedFile(const std::vector<float>& weights) {
  GltfMaker file = bracketFile();
  std::vector<std::uint8_t> joints;
  for (int i = 0; i < 12; ++i) joints.insert(joints.end(), {0, 1, 0, 0});
  file.attribute("JOINTS_0", file.accessor(joints, "VEC4"));
  file.attribute("WEIGHTS_0", file.accessor(weights, "VEC4"));
  file.attribute("NORMAL", file.accessor(flat(std::vector<Float3>(12, {1, 0, 0})), "VEC3"));
  std::vector<float> bind(32, 0);
  for (const std::size_t i : {0U, 5U, 10U, 15U}) bind[i] = bind[16 + i] = 1;
  bind[16 + 13] = -1;
  file.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", file.accessor(bind, "MAT4")}}};
  file.json["nodes"] = Json::parse(R"([{"mesh": 0, "skin": 0, "translation": [50, 0, 0]}, {"children": [2]},
    {"translation": [0, 1, 0], "rotation": [0, 0, 0.70710678118654752, 0.70710678118654752]}])");
  file.json["scenes"][0]["nodes"] = {0, 1};
  return file;
}

TEST(MeshGltfTest, SkinsAreReadAtThePoseOfTheirJoints) {
  std::vector<float> weights;
  for (const Float3& p : bracket().positions) {
    const float upper = p[1] == 2 ? 4.F : 0.F;  // not normalised: 4 of 4
    for (const float w : {p[1] == 1 ? 1.F : 1 - upper / 4, p[1] == 1 ? 1.F : upper, 0.F, 0.F})
      weights.push_back(w);
  }
  const TriangleMesh mesh = read(skinnedFile(weights)).mesh;
  EXPECT_EQ(mesh.positions[1], (Float3{3, 0, 0})) << "the node's own transform does not matter";
  EXPECT_NEAR(mesh.positions[4][0], -1, 1e-6F) << "(1, 2) about (0, 1) by a quarter";
  EXPECT_NEAR(mesh.positions[4][1], 2, 1e-6F);
  EXPECT_NEAR(mesh.positions[2][0], 1.5F, 1e-6F) << "half of (3, 1), half of (0, 4)";
  EXPECT_NEAR(mesh.positions[2][1], 2.5F, 1e-6F);
  EXPECT_NEAR(mesh.normals[4][1], 1, 1e-6F);
  const MeshImport limp = read(skinnedFile(std::vector<float>(48, 0)));
  expectSameTriangles(limp.mesh, bracket(), "no weights");
  EXPECT_THAT(limp.notes, ElementsAre(HasSubstr("12 vertices have no joint weights")));
}

TEST(MeshGltfTest, MorphTargetsAtTheirDefaultWeights) {
  GltfMaker file = bracketFile();
  const std::vector<float> up(36, 1);
  const int target = file.accessor(up, "VEC3");
  file.primitive()["targets"] = {{{"POSITION", target}}, {{"POSITION", target}}};
  file.json["meshes"][0]["weights"] = {0.5, 0};
  EXPECT_EQ(figuresOf(read(file).mesh).high, (Float3{3.5F, 2.5F, 1.5F}));
  file.json["nodes"][0]["weights"] = {1, 1};
  EXPECT_EQ(figuresOf(read(file).mesh).high, (Float3{5, 4, 3})) << "the node's go before";
}

TEST(MeshGltfTest, Instances) {
  GltfMaker file = bracketFile();
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  file.json["nodes"][0]["translation"] = {0, 0, 10};
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", file.accessor(std::vector<float>{0, 0, 0, 5, 0, 0}, "VEC3")},
      {"ROTATION", file.accessor(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 32767, 0, 0}, "VEC4", true)},
      {"SCALE", file.accessor(std::vector<float>{1, 1, 1, 2, 2, 2}, "VEC3")}};
  const TriangleMesh mesh = read(file).mesh;
  ASSERT_EQ(mesh.vertexCount(), 24U);
  EXPECT_EQ(mesh.positions[1], (Float3{3, 0, 10}));
  EXPECT_EQ(mesh.positions[13], (Float3{-1, 0, 10})) << "5 − 2 · 3, turned by a half about y";
}

// --- Compression

TEST(MeshGltfTest, DracoWithOtherAttributesBeside) {
  GltfMaker file = bracketFile();
  TriangleMesh source = bracket();
  source.texcoords.assign(12, {0.25F, 0.75F});
  const DracoMesh packed = encodeDraco(source, 0, 0, "a");
  file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const std::string bytes(reinterpret_cast<const char*>(packed.bytes.data()), packed.bytes.size());
  file.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", file.view(bytes)},
      {"attributes", {{"POSITION", packed.attributes.position}, {"TEXCOORD_0", packed.attributes.texcoord}}}};
  file.attribute("TEXCOORD_0", file.accessor(std::vector<float>(24, 0), "VEC2"));
  file.attribute("COLOR_0", file.accessor(std::vector<float>(36, 0.5F), "VEC3"));
  const TriangleMesh mesh = read(file).mesh;
  expectBracket(mesh, "Draco");
  EXPECT_EQ(mesh.texcoords[7], (Float2{0.25F, 0.25F}));
  EXPECT_EQ(mesh.colors[7], (Float3{0.5F, 0.5F, 0.5F}));
}

GltfMaker meshoptFile() {
  GltfMaker file = bracketFile();
  const auto positions = flat(bracket().positions);
  const auto indices = indicesOf<std::uint32_t>(bracket());
  std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(12, 12)),
      triangles(meshopt_encodeIndexBufferBound(60, 12));
  vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), positions.data(), 12, 12));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), 60));
  const auto pack = [&](int accessor, const std::vector<unsigned char>& bytes, int count, int stride,
                        const char* mode) {
    const int source = file.view({bytes.begin(), bytes.end()});
    Json& view = file.json["bufferViews"][static_cast<int>(file.json["accessors"][accessor]["bufferView"])];
    view["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},
        {"byteOffset", file.json["bufferViews"][source]["byteOffset"]},
        {"byteLength", bytes.size()},
        {"byteStride", stride},
        {"count", count},
        {"mode", mode}};
    view["buffer"] = 1;  // a fallback that is not there
    view["byteOffset"] = 0;
  };
  pack(0, vertices, 12, 12, "ATTRIBUTES");
  pack(1, triangles, 60, 2, "TRIANGLES");
  file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  file.json["buffers"] = {
      {{"byteLength", file.binary.size()}},
      {{"byteLength", 264}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  return file;
}

TEST(MeshGltfTest, Meshopt) {
  expectBracket(read(meshoptFile().glb()).mesh, "meshopt");
  GltfMaker file = meshoptFile();
  auto& packed = file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  packed["count"] = 4000000000U;
  EXPECT_THAT(errorOf(file.glb()), HasSubstr("/bufferViews/0/extensions/EXT_meshopt_compression/count"));
  packed["count"] = 12;
  packed["filter"] = "QUATERNION";
  EXPECT_THAT(errorOf(file.glb()), HasSubstr("filter QUATERNION"));
  packed["filter"] = "NONE";
  packed["byteLength"] = 20;
  EXPECT_THAT(errorOf(file.glb()), HasSubstr("meshoptimizer cannot decode it"));
}

// --- Materials

TEST(MeshGltfTest, MaterialsAndTheirPictures) {
  GltfMaker file = bracketFile();
  file.attribute("TEXCOORD_1", file.accessor(std::vector<float>{0.5F, 0.25F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                                0,    0,     0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
                                             "VEC2"));
  file.json["materials"] =
      Json::parse(R"([{"name": "idle", "pbrMetallicRoughness": {"baseColorTexture": {"index": 99}}},
    {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 2, 0.5], "baseColorTexture": {"index": 0, "texCoord": 7,
      "extensions": {"KHR_texture_transform": {"texCoord": 1, "offset": [0, 1], "rotation": 1.5707963267948966,
      "scale": [0.5, 0.5]}}}}, "alphaMode": "BLEND"}])");
  file.json["textures"] = Json::parse(R"([{"source": 0, "sampler": 0}])");
  file.json["samplers"] = Json::parse(R"([{"wrapS": 33071, "wrapT": 33648}])");
  file.json["images"] = {{{"bufferView", file.view("\x89PNG")}, {"mimeType", "image/png"}, {"name", "skin"}}};
  file.primitive()["material"] = 1;
  const MeshImport import = read(file);
  EXPECT_THAT(import.mesh.material_names, ElementsAre("idle", "material_1"));
  EXPECT_THAT(import.mesh.triangle_materials, testing::Each(1U));
  EXPECT_EQ(import.mesh.colors[3], (Float3{0.5F, 0.25F, 1}));
  EXPECT_THAT(import.material_textures, ElementsAre(-1, 0));
  ASSERT_EQ(import.textures.size(), 1U);
  EXPECT_EQ(import.textures[0].bytes, bytesOf("\x89PNG"));
  EXPECT_EQ(import.textures[0].name, "a.gltf, image 0 (skin)");
  EXPECT_EQ(import.textures[0].wrap_u, AlbedoTexture::Wrap::kClamp);
  EXPECT_EQ(import.textures[0].wrap_v, AlbedoTexture::Wrap::kMirror);
  // The lower left quarter of the picture, turned clockwise: (0.5, 0.25) → (0.125, 0.75), from the top.
  EXPECT_NEAR(import.texture_lookups[0][0], 0.125F, 1e-6F);
  EXPECT_NEAR(import.texture_lookups[0][1], 0.25F, 1e-6F);
  EXPECT_THAT(import.notes, Contains(HasSubstr("baked as opaque: material_1")));
}

TEST(MeshGltfTest, TheOlderMaterialModelAndOtherPictureFormats) {
  GltfMaker file = bracketFile();
  file.attribute("TEXCOORD_0", file.accessor(std::vector<float>(24, 0), "VEC2"));
  file.json["materials"] = Json::parse(R"([{"extensions": {"KHR_materials_pbrSpecularGlossiness": {
    "diffuseFactor": [0.5, 0.5, 0.5, 1], "diffuseTexture": {"index": 0}}},
    "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}])");
  file.json["textures"] =
      Json::parse(R"([{"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}}])");
  file.json["images"] = Json::parse(R"([{"uri": "data:image/ktx2,x"}, {"uri": "data:image/jpeg,x%20y"}])");
  file.primitive()["material"] = 0;
  const MeshImport import = read(file);
  EXPECT_EQ(import.mesh.colors[0], (Float3{0.5F, 0.5F, 0.5F}));
  EXPECT_EQ(import.textures.at(0).bytes, bytesOf("x y"));
  file.json["textures"][0].erase("source");
  EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr("/images/0"), HasSubstr("KTX2")));
  file.json["textures"][0] = {{"extensions", {{"EXT_texture_webp", {{"source", 1}}}}}};
  EXPECT_EQ(read(file).textures.size(), 1U);
}

// --- Files

TEST(MeshGltfTest, FilesBesideItByAnyNameThatAUriMayHave) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "my files");
  const std::vector<std::pair<std::string, std::string>> names = {
      {"my%20files/%C3%A4%2B1.bin", "my files/ä+1.bin"},
      {"100%.bin", "100%.bin"},
      {"my files\\b.bin", "my files/b.bin"},
      {"file://" + (folder / "abs%20olute.bin").string(), "abs olute.bin"},
      {"a%20b.bin", "a%20b.bin"}};
  for (const auto& [uri, name] : names) {
    GltfMaker file = bracketFile();
    writeQuickly(folder / name, file.binary);
    file.json["buffers"] = {{{"byteLength", file.binary.size()}, {"uri", uri}}};
    writeQuickly(folder / "a.gltf", file.text());
    expectBracket(importMesh(folder / "a.gltf").mesh, uri);
    std::filesystem::remove(folder / name);
    EXPECT_THROW(importMesh(folder / "a.gltf"), Error) << uri;
  }
  writeQuickly(folder / "binary.gltf", bracketFile().glb());
  writeQuickly(folder / "text.glb", bracketFile().text());
  expectBracket(importMesh(folder / "binary.gltf").mesh, "binary under the text's ending");
  expectBracket(importMesh(folder / "text.glb").mesh, "text under the binary's ending");
}

TEST(MeshGltfTest, DataUrisOfAllForms) {
  GltfMaker file = bracketFile();
  std::string digits = base64(file.binary), escaped, spaced, safe = digits, percent;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    escaped += digits[i] == '+' ? "%2B" : digits[i] == '/' ? "%2F" : std::string(1, digits[i]);
    spaced += digits[i];
    if (i % 76 == 75) spaced += "\r\n";
  }
  for (char& c : safe) c = c == '+' ? '-' : c == '/' ? '_' : c;
  while (safe.ends_with('=')) safe.pop_back();
  for (const char c : file.binary) {
    constexpr const char* kHex = "0123456789abcdef";
    percent += {'%', kHex[static_cast<unsigned char>(c) >> 4], kHex[static_cast<unsigned char>(c) & 15]};
  }
  for (const std::string& uri : {"data:;base64," + digits, "data:application/gltf-buffer;base64," + escaped,
                                 "DATA:a/b;base64," + spaced, "data:a/b;charset=x;base64," + safe,
                                 "data:application/octet-stream," + percent}) {
    file.json["buffers"] = {{{"byteLength", file.binary.size()}, {"uri", uri}}};
    expectBracket(read(file).mesh, uri.substr(0, 30));
  }
  const std::vector<std::pair<std::string, std::string>> faults = {
      {"data:;base64", "no comma"},
      {"data:;base64,AB*D", "character 2"},
      {"data:;base64,AAAAA", "group of four"},
      {"data:;base64,AA==AA", "character 4"},
      {"data:;base64,AAAA", "has 3 bytes"},
      {"https://a.b/c.bin", "not the name of a file"},
      {"none.bin", "none.bin is missing"}};
  for (const auto& [uri, what] : faults) {
    file.json["buffers"] = {{{"byteLength", file.binary.size()}, {"uri", uri}}};
    EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr("/buffers/0"), HasSubstr(what))) << uri;
  }
}

TEST(MeshGltfTest, BinaryContainersThatAreWrong) {
  const std::string whole = bracketFile().glb();
  EXPECT_THAT(errorOf(whole.substr(0, 15)), HasSubstr("ends inside it"));
  EXPECT_THAT(errorOf(whole.substr(0, whole.size() - 1)), HasSubstr("its header says"));
  std::string changed = whole;
  changed[4] = 1;
  EXPECT_THAT(errorOf(changed), HasSubstr("version 1"));
  changed = whole;
  changed[12] = '\xFF', changed[13] = '\xFF';
  EXPECT_THAT(errorOf(changed), AllOf(HasSubstr("chunk 0"), HasSubstr("end beyond")));
  changed = whole;
  changed[16] = 'B';
  EXPECT_THAT(errorOf(changed), AllOf(HasSubstr("chunk 0"), HasSubstr("no JSON")));
  const MeshImport longer = read(whole + "xyz");
  expectBracket(longer.mesh, "longer");
  EXPECT_THAT(longer.notes, ElementsAre(HasSubstr("3 bytes after the end")));
  GltfMaker without = bracketFile();
  without.binary.clear();
  EXPECT_THAT(errorOf(without.glb()), HasSubstr("/bufferViews/0/byteLength"));
}

struct Fault {
  const char* patch;  // JSON merge patch (RFC 7386) or a JSON patch (RFC 6902) on bracketFile()
  const char* pointer;
  const char* what;
};

TEST(MeshGltfTest, FaultsAreNamedWithTheirPlace) {
  const std::vector<Fault> faults = {
      {R"({"asset": {"version": "1.0"}})", "/asset/version", "glTF 1.0"},
      {R"({"asset": null, "techniques": {}})", "", "glTF 1.0"},
      {R"({"asset": {"minVersion": "2.1"}})", "/asset/minVersion", "2.1"},
      {R"({"extensionsRequired": ["VENDOR_curves"]})", "/extensionsRequired/0", "VENDOR_curves"},
      {R"({"scene": 3})", "/scene", "does not exist"},
      {R"({"scenes": [{"nodes": [0, 0]}]})", "/scenes/0/nodes/1", "twice"},
      {R"({"nodes": [{"mesh": 1}]})", "/nodes/0/mesh", "1 of \"meshes\" does not exist"},
      {R"({"nodes": [{"mesh": -1}]})", "/nodes/0/mesh", "out of range"},
      {R"({"nodes": [{"mesh": "a"}]})", "/nodes/0/mesh", "string"},
      {R"({"nodes": [{"children": [1]}, {"children": [1]}]})", "/nodes/1/children/0", "another parent"},
      {R"({"nodes": [{}, {"children": [2]}, {"children": [1]}]})", "/nodes/1", "below itself"},
      {R"({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]})", "/nodes/0/rotation", "no length"},
      {R"({"nodes": [{"mesh": 0, "scale": [1, 2]}]})", "/nodes/0/scale", "2 entries"},
      {R"({"nodes": [{"mesh": 0, "scale": [1e300, 1, 1]}]})", "/meshes/0/primitives/0/attributes/POSITION",
       "beyond the range"},
      {R"({"nodes": [{"mesh": 0, "matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})", "/nodes/0/matrix",
       "last row"},
      {R"({"nodes": [{"mesh": 0, "skin": 0}], "skins": [{"joints": [0]}]})", "/nodes/0/skin", "JOINTS_0"},
      {R"({"nodes": [{"mesh": 0, "weights": [1]}]})", "/meshes/0/primitives/0", "1 weights"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/mode", "value": 7}])", "/meshes/0/primitives/0/mode",
       "7 is no mode"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/material", "value": 0}])",
       "/meshes/0/primitives/0/material", "does not exist"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/attributes/COLOR_0", "value": 1}])",
       "/accessors/1/type", "SCALAR"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/attributes/JOINTS_0", "value": 0}])",
       "/meshes/0/primitives/0/attributes", "only one of"},
      {R"([{"op": "replace", "path": "/meshes/0/primitives/0/indices", "value": 0}])", "/accessors/0/type",
       "VEC3"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 13}])", "/accessors/0/count",
       "13 elements"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 9007199254740991}])",
       "/accessors/0/count", "end beyond"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 1e300}])", "/accessors/0/count",
       "out of range"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 5}])", "/accessors/1",
       "vertex 5 does not exist"},
      {R"([{"op": "replace", "path": "/accessors/0/componentType", "value": 5124}])",
       "/accessors/0/componentType", "5124"},
      {R"([{"op": "replace", "path": "/accessors/1/componentType", "value": 5126}])",
       "/accessors/1/componentType", "5126"},
      {R"([{"op": "add", "path": "/accessors/0/byteOffset", "value": 18446744073709551615}])",
       "/accessors/0/byteOffset", "out of range"},
      {R"([{"op": "add", "path": "/accessors/0/byteOffset", "value": 4}])", "/accessors/0/count",
       "end beyond"},
      {R"([{"op": "replace", "path": "/accessors/0/bufferView", "value": 9}])", "/accessors/0/bufferView",
       "9 of"},
      {R"([{"op": "add", "path": "/accessors/0/sparse", "value": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121, "byteOffset": 6}, "values": {"bufferView": 9}}}])",
       "/accessors/0/sparse/values/bufferView", "9 of"},
      {R"([{"op": "add", "path": "/accessors/0/sparse", "value": {"count": 9, "indices": {"bufferView": 1, "componentType": 5125}, "values": {"bufferView": 0}}}])",
       "/accessors/0/sparse/indices", "below the accessor's count"},
      {R"([{"op": "add", "path": "/bufferViews/0/byteStride", "value": 8}])", "/accessors/0/bufferView",
       "byteStride"},
      {R"([{"op": "replace", "path": "/bufferViews/0/byteLength", "value": 9999}])",
       "/bufferViews/0/byteLength", "beyond the buffer"},
      {R"([{"op": "replace", "path": "/bufferViews/0/byteOffset", "value": 9007199254740991}])",
       "/bufferViews/0/byteLength", "beyond the buffer"},
      {R"([{"op": "add", "path": "/buffers", "value": [{"byteLength": 264}]}])", "/buffers/0", "no \"uri\""},
      {R"([{"op": "remove", "path": "/accessors/0/bufferView"}, {"op": "replace", "path": "/accessors/0/count", "value": 4000000000}])",
       "/accessors/0/count", "without a bufferView"},
  };
  for (const Fault& fault : faults) {
    GltfMaker file = bracketFile();
    const Json patch = Json::parse(fault.patch);
    if (patch.is_array()) {
      file.json = file.json.patch(patch);
    } else {
      file.json.merge_patch(patch);
    }
    EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr(fault.pointer), HasSubstr(fault.what))) << fault.patch;
  }
  EXPECT_THAT(errorOf("{"), HasSubstr("line 1"));
  EXPECT_THAT(errorOf("[]"), HasSubstr("no object"));
  EXPECT_THAT(errorOf("{}"), HasSubstr("no \"asset\""));
  EXPECT_THAT(errorOf(" "), HasSubstr("empty"));
}

TEST(MeshGltfTest, FaultsInTheDataAreNamedWithTheirPlace) {
  GltfMaker file = bracketFile();
  std::vector<Float3> positions = bracket().positions;
  positions[7][1] = std::nanf("");
  file.attribute("POSITION", file.accessor(flat(positions), "VEC3"));
  file.json["nodes"][0]["name"] = "leg";
  EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr("vertex 7"), HasSubstr("'leg'"), HasSubstr("not finite"),
                                          HasSubstr("/meshes/0/primitives/0/attributes/POSITION")));
  file = bracketFile();
  file.primitive()["indices"] = file.accessor(std::vector<std::uint8_t>{0, 1, 255}, "SCALAR");
  EXPECT_THAT(errorOf(file.text()),
              AllOf(HasSubstr("/accessors/2"), HasSubstr("index 2 is 255"), HasSubstr("restart")));
  GltfMaker skinned = skinnedFile(std::vector<float>(48, 1));
  skinned.json["skins"][0]["joints"] = {1};
  EXPECT_THAT(errorOf(skinned.text()), AllOf(HasSubstr("/skins/0/joints"), HasSubstr("vertex 0")));
}

// Whatever the bytes: a mesh or an Error.
TEST(MeshGltfTest, DamagedFilesAreMeshesOrErrors) {
  GltfMaker draco = bracketFile();
  const DracoMesh packed = encodeDraco(bracket(), 0, 0, "a");
  draco.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", draco.view({reinterpret_cast<const char*>(packed.bytes.data()), packed.bytes.size()})},
      {"attributes", {{"POSITION", packed.attributes.position}}}};
  std::mt19937 random(7);
  int errors = 0, meshes = 0;
  for (const std::string& whole :
       {skinnedFile(std::vector<float>(48, 1)).glb(), meshoptFile().glb(), draco.glb()}) {
    ASSERT_EQ(errorOf(whole), "no error");
    for (int trial = 0; trial < 700; ++trial) {
      std::string changed = whole;
      for (int flips = 1 + trial % 3; flips > 0; --flips) {
        const std::size_t place = random() % changed.size();
        changed[place] = static_cast<char>(changed[place] ^ (1 << random() % 8));
      }
      if (trial % 10 == 0) changed.resize(random() % changed.size());
      try {
        read(changed);
        ++meshes;
      } catch (const Error&) {
        ++errors;
      }
    }
  }
  EXPECT_GT(errors, 500);
  EXPECT_GT(meshes, 100);
}

}  // namespace
}  // namespace bakelight::formats
