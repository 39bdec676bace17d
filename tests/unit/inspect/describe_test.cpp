#include "tools/inspect/describe.h"

#include "formats/error.h"
#include "tests/support/pack_parts.h"

namespace bakelight::inspect {
namespace {

using formats::ElementType;
using formats::Json;
using formats::Tensor;
using ::testing::HasSubstr;

Json described(std::vector<Section> sections) {
  return asJson({"f", "k", 0, std::move(sections)});
}

formats::EncodedTable tableOf(const std::vector<float>& values, std::size_t columns,
                              formats::Precision precision = formats::Precision::kFloat32) {
  return formats::encodeTable(values, columns, precision, "test", "table");
}

formats::Pack trianglePack() {
  formats::Pack pack;
  pack.name = "one";
  pack.appearances[0].base_color = {0.5f, 0.25f, 0.125f};
  pack.mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}};
  pack.mesh.normals.assign(3, {0, 0, 1});
  pack.mesh.triangles = {{0, 1, 2}};
  pack.sh().order = 2;
  pack.sh().vectors = tableOf({1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0}, 4);
  return pack;
}

// Two clusters of one weight, rows of order 1, near field, a lobe.
formats::Pack glossyPack() {
  formats::Pack pack = trianglePack();
  formats::ShTransfer& transfer = pack.sh();
  transfer.near_field = {{1, 2, 3}, 5, tableOf(std::vector<float>(12, 2), 4)};
  makeGlossy(transfer, formats::Storage::kCpca, 1);
  transfer.glossy->tangents.assign(3, {1, 0, 0, 1});
  transfer.glossy->vertexTable() = tableOf({0, 1, 2}, 1, formats::Precision::kUint8);
  clustersOf(transfer).clusters = {0, 1, 1};
  clustersOf(transfer).basis =
      tableOf({1, 1, 1, 1, 0, 2, 0, 0, 3, 3, 3, 3, 0, 0, 4, 0}, 4, formats::Precision::kFloat16);
  reflectionOf(pack) = formats::GgxLobe{0.3f, {1, 1, 1}};
  return pack;
}

TEST(DescribeMesh, SaysWhatATriangleIs) {
  const Json mesh = described(describeMesh(trianglePack().mesh, {"a note"}));
  EXPECT_EQ(mesh["size"]["vertices"], 3);
  EXPECT_EQ(mesh["size"]["maximum"], Json({3, 4, 0}));
  EXPECT_EQ(mesh["size"]["diagonal"], 5);
  EXPECT_EQ(mesh["size"]["volume"], nullptr);
  EXPECT_EQ(mesh["topology"]["closed"], false);
  EXPECT_EQ(mesh["topology"]["borders"], 1);
  EXPECT_EQ(mesh["topology"]["euler_characteristic"], 1);
  EXPECT_EQ(mesh["attributes"]["unit_normals"], true);
  EXPECT_EQ(mesh["notes"][0]["note"], "a note");
  EXPECT_FALSE(mesh.contains("materials"));
}

TEST(DescribeMesh, NamesTrianglesAndAreaOfMaterials) {
  formats::TriangleMesh triangle = trianglePack().mesh;  // 3 × 4 / 2
  triangle.triangles.push_back(formats::Triangle(triangle.triangles.front()));
  triangle.triangle_materials = {2, 2};
  triangle.material_names = {"", "red", "bad \xFF\x1b[31m"};
  const Json materials = described(describeMesh(triangle, {}))["materials"];
  ASSERT_EQ(materials.size(), 3u);
  EXPECT_EQ(materials[0], Json({{"index", 0}, {"name", ""}, {"triangles", 0}, {"area", 0.0}}));
  EXPECT_EQ(materials[1]["name"], "red");
  EXPECT_EQ(materials[2],
            Json({{"index", 2}, {"name", "bad \uFFFD?[31m"}, {"triangles", 2}, {"area", 12.0}}));
}

TEST(DescribePack, SectionsBytesAndTransfer) {
  const formats::Pack pack = trianglePack();
  const formats::Bytes bytes = formats::encodePack(pack, {}, "p.glb");
  const Json json = described(describePack(pack, bytes, "p.glb"));
  EXPECT_EQ(json["pack"]["version"], 3);
  EXPECT_EQ(json["material 0"]["base_color"], Json({0.5, 0.25, 0.125}));
  EXPECT_DOUBLE_EQ(json["pack"]["bytes_per_vertex"], static_cast<double>(bytes.size()) / 3);
  EXPECT_EQ(json["transfer"]["transport"], "shadowed");
  EXPECT_EQ(json["transfer"]["kind"], "sh");
  EXPECT_EQ(json["transfer"]["order"], 2);
  EXPECT_FALSE(json["transfer"].contains("glossy.operator"));
  EXPECT_EQ(json["material 0"]["kind"], "lambert");
  EXPECT_NEAR(json["energy_per_sh_band"][0]["share_percent"], 50, 1e-12);
  bool found = false;
  for (const Json& section : json["sections"]) {
    if (section["section"] != "vectors") continue;
    found = true;
    EXPECT_EQ(section["size_bytes"], 3 * 4 * 4);
    EXPECT_EQ(section["verified"], true);
  }
  EXPECT_TRUE(found);
}

TEST(DescribePack, GlossyTablesNearFieldAndLobe) {
  const formats::Pack pack = glossyPack();
  const Json json = described(describePack(pack, formats::encodePack(pack, {}, "p.glb"), "p.glb"));
  EXPECT_EQ(json["transfer"]["glossy.operator"], "cpca");
  EXPECT_EQ(json["transfer"]["glossy.outputOrder"], 1);
  EXPECT_EQ(json["transfer"]["nearField.center"], Json({1, 2, 3}));
  EXPECT_EQ(json["transfer"]["nearField.radius"], 5);
  EXPECT_EQ(json["material 0"]["kind"], "ggx");
  EXPECT_EQ(json["material 0"]["roughness"], 0.3);
  EXPECT_FALSE(json["material 0"].contains("exponent"));
  ASSERT_EQ(json["tables"].size(), 5U);
  EXPECT_EQ(json["tables"][2]["table"], "glossy.tangents");
  EXPECT_EQ(json["tables"][3]["table"], "glossy.weights");
  EXPECT_EQ(json["tables"][3]["precision"], "uint8");
  EXPECT_NEAR(json["tables"][3]["mean"].get<double>(), 1, 0.01);
  EXPECT_EQ(json["tables"][4]["table"], "glossy.basis");
  EXPECT_EQ(json["tables"][4]["rows"], 4);
  EXPECT_EQ(json["tables"][4]["maximum"], 4);
  EXPECT_EQ(json["near_energy_per_sh_band"][1]["mean_energy"], 12);
}

TEST(DescribePack, AnOldPackIsWhatItWas) {
  const std::string file = std::string(BAKELIGHT_SOURCE_DIR) + "/tests/unit/formats/golden/pack-v1.glb";
  const formats::Bytes bytes = formats::readFile(file);
  const Json json = described(describePack(formats::decodePack(bytes, file), bytes, file));
  EXPECT_EQ(json["pack"]["version"], 1);
  EXPECT_EQ(json["transfer"]["kind"], "sh");
}

TEST(DescribeTensors, EnergyOfColoredTransferIsThatOfAllChannels) {
  formats::TensorFile file;
  std::vector<float> values(1 * 3 * 4, 0.0f);
  values[0] = 3;      // red, l = 0
  values[4 + 2] = 6;  // green, l = 1
  file.tensors["transfer"] = Tensor::from<float>(ElementType::kFloat32, {1, 3, 4}, values);
  file.tensors["near_transfer"] = file.tensors["transfer"];
  const Json json = described(describeTensors(file));
  EXPECT_EQ(json["energy_per_sh_band"][0]["mean_energy"], 3);
  EXPECT_EQ(json["energy_per_sh_band"][1]["mean_energy"], 12);
  EXPECT_EQ(json["near_energy_per_sh_band"], json["energy_per_sh_band"]);
}

TEST(DescribeTensors, TypesShapesMetadataAndBands) {
  formats::TensorFile file;
  file.tensors["transfer"] =
      Tensor::from<float>(ElementType::kFloat32, {2, 4}, std::vector<float>{1, 0, 0, 0, 0, 0, 2, 0});
  file.tensors["ids"] =
      Tensor::from<std::uint32_t>(ElementType::kUint32, {3}, std::vector<std::uint32_t>{5, 6, 7});
  file.metadata["order"] = "2";
  const Json json = described(describeTensors(file));
  ASSERT_EQ(json["tensors"].size(), 2U);
  EXPECT_EQ(json["tensors"][0]["tensor"], "ids");
  EXPECT_EQ(json["tensors"][0]["type"], "U32");
  EXPECT_EQ(json["tensors"][0]["mean"], 6);
  EXPECT_EQ(json["tensors"][1]["shape"], "2 × 4");
  EXPECT_EQ(json["metadata"]["order"], "2");
  EXPECT_EQ(json["energy_per_sh_band"][0]["mean_energy"], 0.5);
  EXPECT_EQ(json["energy_per_sh_band"][1]["mean_energy"], 2);
  EXPECT_EQ(json["energy_per_sh_band"][1]["share_percent"], 80);
}

TEST(DescribeRecord, AStagesStats) {
  const Json json = described(
      describeRecord(Json::parse(R"({"tool": "pack", "wall_s": 1.5, "cpu_s": 2.5, "peak_memory_bytes": 4096,
                      "warnings": ["careful"], "stats": {"vertices": 3, "bytes_per_vertex": {"normals": 12}}})"),
                     "stats.json"));
  EXPECT_EQ(json["run"]["tool"], "pack");
  EXPECT_EQ(json["run"]["wall_s"], 1.5);
  EXPECT_EQ(json["stats"]["bytes_per_vertex.normals"], 12);
  EXPECT_EQ(json["warnings"][0]["warning"], "careful");
}

TEST(DescribeRecord, AnAssetsRecord) {
  const Json json = described(describeRecord(Json::parse(R"({"asset": "bunny", "recipe": "prt", "stages": {
        "transfer": {"tool": "transfer", "status": "ran", "reason": "new", "wall_s": 2.0, "cpu_s": 8.0,
                     "peak_memory_bytes": 1, "warnings": ["w"], "stats": {"rays": 7}},
        "pack": {"tool": "pack", "status": "not-run", "reason": "transfer failed"}}})"),
                                             "record.json"));
  EXPECT_EQ(json["asset"]["name"], "bunny");
  ASSERT_EQ(json["stages"].size(), 2U);
  EXPECT_EQ(json["stages"][0]["stage"], "pack");
  EXPECT_EQ(json["stages"][0]["wall_s"], nullptr);
  EXPECT_EQ(json["stages"][1]["cpu_s"], 8.0);
  EXPECT_EQ(json["warnings"][0]["stage"], "transfer");
  EXPECT_EQ(json["stats_of_transfer"]["rays"], 7);
}

TEST(DescribeRecord, OtherJsonIsAnError) {
  EXPECT_THROW(describeRecord(Json::parse(R"({"mesh": "a.obj"})"), "asset.json"), Error);
  EXPECT_THROW(describeRecord(Json::parse("[1]"), "list.json"), Error);
  EXPECT_THROW(describeRecord(Json::parse(R"({"tool": "x", "wall_s": "long"})"), "stats.json"), Error);
}

}  // namespace
}  // namespace bakelight::inspect
