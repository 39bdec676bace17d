// glTF: nodes, skins, morph targets, instances.

#include <gmock/gmock.h>

#include "tests/unit/formats/gltf_reading.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(GltfScene, NodeTransformsAreChainedInDoublePrecision) {
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

TEST(GltfScene, MirroredNodesKeepTheirOutside) {
  GltfMaker file = bracketFile();
  file.attribute("NORMAL", file.accessor(flat(std::vector<Float3>(12, {0, 1, 0})), "VEC3"));
  file.json["nodes"][0]["scale"] = {1, -2, 1};
  const MeshImport import = read(file);
  EXPECT_NEAR(figuresOf(import.mesh).volume, 8, 1e-9);
  EXPECT_EQ(import.mesh.normals[0], (Float3{0, -1, 0}));
  EXPECT_THAT(import.notes, ElementsAre(HasSubstr("mirrored")));
}

TEST(GltfScene, ScenesAndVisibility) {
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

TEST(GltfScene, PrimitivesThatShareVerticesDoNotMultiplyThem) {
  GltfMaker file = bracketFile();
  Json second = file.primitive();
  second["indices"] = file.accessor(std::vector<std::uint16_t>{6, 7, 8}, "SCALAR");
  file.json["meshes"][0]["primitives"].push_back(second);
  const MeshImport import = read(file);
  EXPECT_EQ(import.mesh.vertexCount(), 15U);
  EXPECT_EQ(import.mesh.positions[import.mesh.triangles[20][2]], bracket().positions[8]);
}

TEST(GltfScene, SkinsAreReadAtThePoseOfTheirJoints) {
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

TEST(GltfScene, MorphTargetsAtTheirDefaultWeights) {
  GltfMaker file = bracketFile();
  const std::vector<float> up(36, 1);
  const int target = file.accessor(up, "VEC3");
  file.primitive()["targets"] = {{{"POSITION", target}}, {{"POSITION", target}}};
  file.json["meshes"][0]["weights"] = {0.5, 0};
  EXPECT_EQ(figuresOf(read(file).mesh).high, (Float3{3.5F, 2.5F, 1.5F}));
  file.json["nodes"][0]["weights"] = {1, 1};
  EXPECT_EQ(figuresOf(read(file).mesh).high, (Float3{5, 4, 3})) << "the node's go before";
}

TEST(GltfScene, Instances) {
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

}  // namespace
}  // namespace bakelight::formats
