#include "formats/mesh_ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(MeshPly, RoundTripKeepsOrderAndBits) {
  const ScratchFolder folder;
  TriangleMesh mesh = wavyGrid(5);
  mesh.positions[0] = {-0.0F, 1e-45F, 3.4e38F};
  for (const bool with_normals : {true, false}) {
    for (const bool with_texcoords : {true, false}) {
      TriangleMesh written = mesh;
      if (!with_normals) written.normals.clear();
      if (!with_texcoords) written.texcoords.clear();
      writePly(folder / "a.ply", written);
      const TriangleMesh read = readPly(folder / "a.ply");
      ASSERT_EQ(read.vertexCount(), 25U);
      EXPECT_EQ(std::memcmp(read.positions.data(), written.positions.data(), 25 * sizeof(Float3)), 0);
      EXPECT_EQ(read.normals, written.normals);
      EXPECT_EQ(read.texcoords, written.texcoords);
      EXPECT_EQ(read.triangles, written.triangles);
      EXPECT_EQ(geometryHash(read), geometryHash(written));
    }
  }
}

TriangleMesh twoMaterials() {
  TriangleMesh mesh = wavyGrid(3);
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    mesh.triangle_materials.push_back(static_cast<std::uint32_t>(t * t % 5));
  mesh.material_names = {"red paint", "", "100 %\r\n\"Ä\xFF", "red paint", " end_header "};
  mesh.material_names.push_back(std::string("\0\t%41", 5));
  for (int m = 6; m < 12; ++m) mesh.material_names.push_back("unused");
  return mesh;
}

TEST(MeshPly, MaterialsComeBackWithNamesOfAnyBytes) {
  const ScratchFolder folder;
  const TriangleMesh mesh = twoMaterials();
  writePly(folder / "a.ply", mesh);
  const TriangleMesh read = readPly(folder / "a.ply");
  EXPECT_EQ(read.triangle_materials, mesh.triangle_materials);
  EXPECT_EQ(read.material_names, mesh.material_names);
  EXPECT_EQ(read.triangles, mesh.triangles);
  EXPECT_EQ(geometryHash(read), geometryHash(wavyGrid(3)));
  writePly(folder / "b.ply", read);
  EXPECT_EQ(readFile(folder / "a.ply"), readFile(folder / "b.ply"));
}

TEST(MeshPly, AMaterialOutOfRangeIsAnError) {
  const ScratchFolder folder;
  TriangleMesh mesh = twoMaterials();
  writePly(folder / "a.ply", mesh);
  std::string text = readTextFile(folder / "a.ply");
  text[text.size() - 4] = 12;  // of the last face
  writeQuickly(folder / "a.ply", text);
  EXPECT_THAT(errorOf([&] { readPly(folder / "a.ply"); }),
              testing::AllOf(HasSubstr("face 7"), HasSubstr("material 12")));
  mesh.triangle_materials.pop_back();
  EXPECT_THROW(writePly(folder / "b.ply", mesh), std::logic_error);
  mesh.triangle_materials.push_back(12);
  EXPECT_THROW(writePly(folder / "b.ply", mesh), std::logic_error);
}

TEST(MeshPly, AnotherProgramsMaterialsAreSkipped) {
  const ScratchFolder folder;
  writePly(folder / "a.ply", twoMaterials());
  std::string text = readTextFile(folder / "a.ply");
  for (std::size_t at = 0; (at = text.find("comment material", at)) != std::string::npos; at += 16)
    text.replace(at, 16, "comment Material");
  writeQuickly(folder / "a.ply", text);
  const TriangleMesh read = readPly(folder / "a.ply");
  EXPECT_TRUE(read.triangle_materials.empty());
  EXPECT_TRUE(read.material_names.empty());
  EXPECT_EQ(read.triangles, wavyGrid(3).triangles);
}

TEST(MeshPly, EveryTruncationIsAnError) {
  const ScratchFolder folder;
  TriangleMesh grid = wavyGrid(2);
  grid.triangle_materials.assign(grid.triangleCount(), 0);
  grid.material_names = {"all"};
  writePly(folder / "a.ply", grid);
  const std::string whole = readTextFile(folder / "a.ply");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    writeQuickly(folder / "cut.ply", whole.substr(0, size));
    EXPECT_THAT(errorOf([&] { readPly(folder / "cut.ply"); }), HasSubstr("cut.ply")) << size;
  }
}

TEST(MeshPly, FurtherPropertiesAndElementsAreSkipped) {
  const ScratchFolder folder;
  std::string text =
      "ply\r\nformat binary_little_endian 1.0\ncomment by hand\nelement camera 1\nproperty list uchar short "
      "a\n"
      "element vertex 3\nproperty uchar red\nproperty float32 z\nproperty float y\nproperty float x\n"
      "element face 1\nproperty double quality\nproperty list int ushort vertex_index\nend_header\n";
  const auto put = [&](auto value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(std::uint8_t{2}), put(std::int16_t{1}), put(std::int16_t{1});
  for (float i = 0; i < 3; ++i) put(std::uint8_t{9}), put(i), put(i * i), put(1 - i);
  put(0.5), put(std::int32_t{3}), put(std::uint16_t{2}), put(std::uint16_t{0}), put(std::uint16_t{1});
  writeQuickly(folder / "a.ply", text);
  const TriangleMesh mesh = readPly(folder / "a.ply");
  EXPECT_EQ(mesh.positions, (std::vector<Float3>{{1, 0, 0}, {0, 1, 1}, {-1, 4, 2}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{2, 0, 1}}));
}

// What Blender and MeshLab write beside faces: a little mesh with two marked edges.
std::string markedSquare(std::int32_t last_vertex) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "element edge 2\nproperty uchar sharp\nproperty int vertex1\nproperty int vertex2\n"
      "element face 2\nproperty list uchar uint vertex_indices\nend_header\n";
  const auto put = [&](auto value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int i = 0; i < 4; ++i) put(static_cast<float>(i % 2)), put(static_cast<float>(i / 2)), put(0.0F);
  put(std::uint8_t{1}), put(std::int32_t{1}), put(std::int32_t{2});
  put(std::uint8_t{1}), put(std::int32_t{0}), put(last_vertex);
  put(std::uint8_t{3}), put(0U), put(1U), put(2U);
  put(std::uint8_t{3}), put(1U), put(3U), put(2U);
  return text;
}

TEST(MeshPly, EdgesAreReadBesideTheMesh) {
  const ScratchFolder folder;
  writeQuickly(folder / "a.ply", markedSquare(3));
  EXPECT_EQ(readPlyEdges(folder / "a.ply"), (std::vector<std::array<std::uint32_t, 2>>{{1, 2}, {0, 3}}));
  EXPECT_EQ(readPly(folder / "a.ply").triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
  writePly(folder / "b.ply", wavyGrid(3));
  EXPECT_TRUE(readPlyEdges(folder / "b.ply").empty());
}

TEST(MeshPly, BadEdgesAreNamed) {
  const ScratchFolder folder;
  const auto errorOfText = [&](const std::string& text) {
    writeQuickly(folder / "a.ply", text);
    return errorOf([&] { readPlyEdges(folder / "a.ply"); });
  };
  EXPECT_THAT(errorOfText(markedSquare(4)), HasSubstr("edge 1: vertex 4 does not exist"));
  EXPECT_THAT(errorOfText(markedSquare(-1)), HasSubstr("edge 1: vertex -1 does not exist"));
  std::string renamed = markedSquare(3);
  renamed.replace(renamed.find("vertex2"), 7, "vertexB");
  EXPECT_THAT(errorOfText(renamed), HasSubstr("edges have no vertices"));
  const std::string whole = markedSquare(3);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THAT(errorOfText(whole.substr(0, size)), HasSubstr("a.ply")) << size;
  EXPECT_THAT(errorOfText(whole + "x"), HasSubstr("1 bytes follow"));
}

TEST(MeshPly, StagesFilesAreToldFromThoseThatHoldMore) {
  const ScratchFolder folder;
  TriangleMesh mesh = wavyGrid(2);
  mesh.colors.assign(4, {0.5F, 0.25F, 1});
  mesh.triangle_materials.assign(2, 0);
  mesh.material_names = {"stone"};
  writePly(folder / "a.ply", mesh);
  EXPECT_TRUE(isStagePly(folder / "a.ply"));
  const std::string whole = readTextFile(folder / "a.ply");
  // Properties that importMesh reads and readPly does not.
  for (const auto& [ours, theirs] : std::vector<std::pair<std::string, std::string>>{
           {"property float red", "property uchar red"}, {"property float s\n", "property float u\n"}}) {
    std::string text = whole;
    text.replace(text.find(ours), ours.size(), theirs);
    writeQuickly(folder / "b.ply", text);
    EXPECT_FALSE(isStagePly(folder / "b.ply")) << theirs;
  }
  EXPECT_FALSE(isStagePly(folder / "none.ply"));
}

TEST(MeshPly, BadFilesAreNamed) {
  const ScratchFolder folder;
  const auto errorOfText = [&](const std::string& text) {
    writeQuickly(folder / "a.ply", text);
    return errorOf([&] { readPly(folder / "a.ply"); });
  };
  EXPECT_THAT(errorOf([&] { readPly(folder / "none.ply"); }), HasSubstr("none.ply"));
  EXPECT_THAT(errorOfText("solid"), HasSubstr("not a PLY"));
  EXPECT_THAT(errorOfText("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("ascii"));
  const std::string head = "ply\nformat binary_little_endian 1.0\n";
  const std::string floats = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_THAT(errorOfText(head + "element vertex 18446744073709551615\n" + floats + "end_header\n"),
              HasSubstr("vertex 0"));
  EXPECT_THAT(errorOfText(head + "element vertex 99999999999999999999\n" + floats + "end_header\n"),
              HasSubstr("malformed"));
  EXPECT_THAT(errorOfText(head + "element vertex 1\nproperty double x\nend_header\n"),
              HasSubstr("not float"));
  EXPECT_THAT(errorOfText(head + "element vertex 1\nproperty float x\nend_header\n"),
              HasSubstr("not complete"));

  TriangleMesh mesh = wavyGrid(2);
  mesh.triangles[1][0] = 4;
  writePly(folder / "b.ply", mesh);
  EXPECT_THAT(errorOf([&] { readPly(folder / "b.ply"); }),
              testing::AllOf(HasSubstr("face 1"), HasSubstr("vertex 4")));
  mesh = wavyGrid(2);
  mesh.positions[3][1] = std::nanf("");
  writePly(folder / "b.ply", mesh);
  EXPECT_THAT(errorOf([&] { readPly(folder / "b.ply"); }), HasSubstr("vertex 3"));
  mesh = wavyGrid(2);
  mesh.normals[2] = {0, 1e29F, 0};
  writePly(folder / "b.ply", mesh);
  EXPECT_THAT(errorOf([&] { readPly(folder / "b.ply"); }),
              testing::AllOf(HasSubstr("vertex 2"), HasSubstr("no unit length")));
}

TEST(MeshPly, GeometryHashSeesOrderNormalsAndTrianglesOnly) {
  const TriangleMesh mesh = wavyGrid(3);
  TriangleMesh other = mesh;
  other.texcoords.clear();
  EXPECT_EQ(geometryHash(other), geometryHash(mesh));
  std::swap(other.triangles[0], other.triangles[1]);
  EXPECT_NE(geometryHash(other), geometryHash(mesh));
  other = mesh;
  std::swap(other.positions[0], other.positions[1]);
  EXPECT_NE(geometryHash(other), geometryHash(mesh));
  other = mesh;
  other.normals.clear();
  EXPECT_NE(geometryHash(other), geometryHash(mesh));
  EXPECT_EQ(geometryHash(mesh).size(), 32U);
}

}  // namespace
}  // namespace bakelight::formats
