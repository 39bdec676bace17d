// glTF: numbers of all types and layouts, and the primitives that they make.

#include <gmock/gmock.h>

#include "tests/unit/formats/gltf_reading.h"

namespace bakelight::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

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

TEST(GltfAccessors, PositionsOfAllComponentTypes) {
  for (const bool normalized : {false, true}) {
    expectQuantized<std::int8_t>(normalized);
    expectQuantized<std::uint8_t>(normalized);
    expectQuantized<std::int16_t>(normalized);
    expectQuantized<std::uint16_t>(normalized);
  }
}

TEST(GltfAccessors, IndicesOfAllTypesAndNone) {
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

TEST(GltfAccessors, StripsAndFansKeepTheirSide) {
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

TEST(GltfAccessors, PointsLinesAndLeftoversAreNoted) {
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

TEST(GltfAccessors, InterleavedAttributes) {
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

TEST(GltfAccessors, SparseAccessors) {
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

TEST(GltfAccessors, ColorsAndTextureCoordinatesOfAllTypes) {
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

}  // namespace
}  // namespace bakelight::formats
