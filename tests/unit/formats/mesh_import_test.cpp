#include "formats/mesh_import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_ply.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class MeshImportTest : public testing::Test {
 protected:
  MeshImport import(const std::string& name, const std::string& text) const {
    writeQuickly(folder_ / name, text);
    return importMesh(folder_ / name);
  }

  std::string errorOf(const std::string& name, const std::string& text) const {
    try {
      import(name, text);
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      return error.what();
    }
    return "no error";
  }

  ScratchFolder folder_;
};

const std::string kTriangleObj = "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nf 1 2 3\n";

TEST_F(MeshImportTest, ObjPolygonsAreTriangulatedInOrder) {
  const MeshImport read = import("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf -4 -2 -1\n");
  ASSERT_EQ(read.mesh.triangleCount(), 3U);
  EXPECT_EQ(read.mesh.positions[read.mesh.triangles[0][1]], (Float3{1, 0, 0}));
}

TEST_F(MeshImportTest, ObjSeamsKeepTheirTextureCoordinates) {
  // Two triangles with one edge in common, whose ends have another texture coordinate in each.
  const std::string positions = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const std::string texcoords = "vt 0 0\nvt 0.25 0\nvt 0.25 0.5\nvt 0.5 0.5\nvt 0.75 1\nvt 0.5 1\n";
  const TriangleMesh mesh = import("a.obj", positions + texcoords + "f 1/1 2/2 3/3\nf 1/4 3/5 4/6\n").mesh;
  ASSERT_EQ(mesh.triangleCount(), 2U);
  ASSERT_EQ(mesh.texcoords.size(), mesh.vertexCount());
  const std::vector<std::vector<Float2>> expected = {{{0, 0}, {0.25F, 0}, {0.25F, 0.5F}},
                                                     {{0.5F, 0.5F}, {0.75F, 1}, {0.5F, 1}}};
  for (std::size_t t = 0; t < 2; ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(mesh.texcoords[mesh.triangles[t][k]], expected[t][k]) << t << " " << k;
  EXPECT_EQ(mesh.positions[mesh.triangles[0][0]], mesh.positions[mesh.triangles[1][0]]);
}

TEST_F(MeshImportTest, CutObjNamesTheLine) {
  EXPECT_THAT(errorOf("a.obj", "v 0 0 0\nv 1 0\n"), AllOf(HasSubstr("line 2"), HasSubstr("2 numbers")));
  EXPECT_THAT(errorOf("a.obj", kTriangleObj + "v 0 0 -"), HasSubstr("line 5"));
  EXPECT_THAT(errorOf("a.obj", kTriangleObj + "f 1 2"), AllOf(HasSubstr("line 5"), HasSubstr("2 corners")));
  EXPECT_THAT(errorOf("a.obj", kTriangleObj + "f 1 2 4\n"),
              AllOf(HasSubstr("line 5"), HasSubstr("vertex 4")));
  EXPECT_THAT(errorOf("a.obj", kTriangleObj + "f 1/1 2/1 3/1\n"), HasSubstr("texture coordinate 1"));
  EXPECT_THAT(errorOf("a.obj", kTriangleObj + "f 1 2 -4\n"), HasSubstr("line 5"));
  EXPECT_THAT(errorOf("a.obj", kTriangleObj + "f 0 1 2\n"), HasSubstr("line 5"));
  EXPECT_THAT(errorOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), HasSubstr("no triangle"));
}

TEST_F(MeshImportTest, ObjCutAtAnyByteIsAnErrorOrNoted) {
  std::string text;
  const TriangleMesh grid = wavyGrid(3);
  for (const Float3& p : grid.positions) {
    text += "v " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
  }
  for (const Triangle& t : grid.triangles) {
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  }
  ASSERT_TRUE(import("a.obj", text).notes.empty());
  int errors = 0;
  for (std::size_t size = 0; size + 1 < text.size(); ++size) {
    const std::string cut = text.substr(0, size);
    if (errorOf("a.obj", cut) != "no error") {
      ++errors;
      continue;
    }
    // What is left: a cut between two lines, or in a last index while every vertex is used already. The
    // former drops whole faces after all vertices are used and cannot be told from a smaller mesh.
    const MeshImport read = import("a.obj", cut);
    EXPECT_TRUE(cut.ends_with('\n') || !read.notes.empty()) << size;
  }
  EXPECT_GT(errors, static_cast<int>(text.size() * 9 / 10));
}

TEST_F(MeshImportTest, LegalOddObjsAreRead) {
  EXPECT_EQ(import("a.obj", "f 1 2 3\n" + kTriangleObj).mesh.triangleCount(), 2U) << "faces before vertices";
  EXPECT_EQ(import("a.obj", "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n3\n").mesh.triangleCount(), 1U);
  EXPECT_EQ(import("a.obj", "v +0 0 0 1 0 0\r\nv 1 0 0 1 0 0\r\nv 0 1 0 1 0 0 # red\r\nf 1 2 3\r\n")
                .mesh.triangleCount(),
            1U);
  EXPECT_THAT(import("a.obj", kTriangleObj.substr(0, kTriangleObj.size() - 1)).notes,
              testing::ElementsAre(HasSubstr("no line end")));
  // As scans have them: had the file been cut, vertices would be missing at the end.
  std::string whole = "v 5 5 5\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4";
  EXPECT_THAT(import("a.obj", whole).notes, testing::ElementsAre(HasSubstr("1 of 4 vertices")));
  whole = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3";
  EXPECT_THAT(errorOf("a.obj", whole), HasSubstr("ends inside a line"));
}

TEST_F(MeshImportTest, NotFiniteCoordinatesNameTheVertex) {
  EXPECT_THAT(errorOf("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("vertex 2 (counted from 1)")));
  EXPECT_THAT(errorOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1e60 0\nf 1 2 3\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("vertex 3 (counted from 1)")));
}

TEST_F(MeshImportTest, PlyCutAtAnyByteIsAnErrorNotAHang) {
  writePly(folder_ / "a.ply", wavyGrid(2));
  const std::string whole = readTextFile(folder_ / "a.ply");
  ASSERT_EQ(errorOf("b.ply", whole), "no error");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(errorOf("b.ply", whole.substr(0, size)), HasSubstr("b.ply")) << size;
  }
  const std::string ascii =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  EXPECT_EQ(import("c.ply", ascii).mesh.triangleCount(), 1U);
  for (std::size_t size = 0; size < ascii.size() - 2; ++size) {
    EXPECT_NE(errorOf("c.ply", ascii.substr(0, size)), "no error") << size;
  }
}

TEST_F(MeshImportTest, CutOffAndStlAreErrorsNotAborts) {
  const std::string off = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  EXPECT_EQ(import("a.off", off).mesh.triangleCount(), 4U);
  for (std::size_t size = 0; size < off.size() - 2; ++size) {
    EXPECT_NE(errorOf("a.off", off.substr(0, size)), "no error") << size;
  }
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const std::string stl = "solid a\n" + facet + facet + "endsolid a\n";
  EXPECT_EQ(import("a.stl", stl).mesh.triangleCount(), 2U);
  for (std::size_t size = 0; size < stl.size() - 3; ++size) {
    EXPECT_NE(errorOf("a.stl", stl.substr(0, size)), "no error") << size;
  }
  std::string binary(80, ' ');
  const auto put = [&](auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(std::uint32_t{1});
  for (const float value : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) put(value);
  put(std::uint16_t{0});
  EXPECT_EQ(import("b.stl", binary).mesh.triangleCount(), 1U);
  for (std::size_t size = 0; size < binary.size(); ++size) {
    EXPECT_NE(errorOf("b.stl", binary.substr(0, size)), "no error") << size;
  }
}

// One triangle below a node that mirrors x and moves; little-endian floats in base64: (0,0,0) (1,0,0)
// (0,1,0).
std::string gltfWith(const std::string& node, int buffer_size = 36) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0)" + node +
         R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
  "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
  "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":)" +
         std::to_string(buffer_size) +
         R"(,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}

TEST_F(MeshImportTest, NodeTransformsAreAppliedAndMirrorsTurnedOver) {
  const MeshImport read = import("a.gltf", gltfWith(R"(,"scale":[-2,1,1],"translation":[10,0,5])"));
  ASSERT_EQ(read.mesh.triangleCount(), 1U);
  const Triangle& t = read.mesh.triangles[0];
  EXPECT_EQ(read.mesh.positions[t[0]], (Float3{10, 0, 5}));
  EXPECT_EQ(read.mesh.positions[t[1]], (Float3{10, 1, 5})) << "turned over, so that it faces the same side";
  EXPECT_EQ(read.mesh.positions[t[2]], (Float3{8, 0, 5}));
  EXPECT_THAT(read.notes, testing::Contains(HasSubstr("mirrored")));
}

TEST_F(MeshImportTest, CutGltfIsAnError) {
  const std::string whole = gltfWith("");
  ASSERT_EQ(errorOf("a.gltf", whole), "no error");
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    EXPECT_NE(errorOf("a.gltf", whole.substr(0, size)), "no error") << size;
  }
}

// Of the vertex of `mesh` at `position`; assimp may reorder.
Float3 colorAt(const TriangleMesh& mesh, const Float3& position) {
  EXPECT_EQ(mesh.colors.size(), mesh.positions.size());
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    if (mesh.positions[i] == position) return mesh.colors[i];
  }
  ADD_FAILURE() << "no vertex at " << position[0] << ", " << position[1] << ", " << position[2];
  return {};
}

void expectColor(const Float3& color, const Float3& expected) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], expected[c], 1e-6F) << c;
}

// 0.5 and code 128 as light: IEC 61966-2-1 by hand.
constexpr float kLinearOfHalf = 0.21404114F, kLinearOf128 = 0.21586050F, kLinearOf2Percent = 0.02F / 12.92F;

TEST_F(MeshImportTest, ObjColorsAreDisplayCodes) {
  const MeshImport read = import("a.obj", "v 0 0 0 1 0 0.5\nv 1 0 0 0 0.02 0\nv 0 0.5 0 0 0 1\nf 1 2 3\n");
  expectColor(colorAt(read.mesh, {0, 0, 0}), {1, 0, kLinearOfHalf});
  expectColor(colorAt(read.mesh, {1, 0, 0}), {0, kLinearOf2Percent, 0});
  expectColor(colorAt(read.mesh, {0, 0.5F, 0}), {0, 0, 1});
  EXPECT_TRUE(read.notes.empty());
  EXPECT_TRUE(import("b.obj", kTriangleObj).mesh.colors.empty());
}

TEST_F(MeshImportTest, ObjVerticesOfOtherForms) {
  const MeshImport some = import("a.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expectColor(colorAt(some.mesh, {0, 0, 0}), {1, 0, 0});
  expectColor(colorAt(some.mesh, {0, 1, 0}), {1, 1, 1});
  EXPECT_THAT(some.notes, testing::Contains(HasSubstr("2 of 3 vertices have no colour")));
  EXPECT_THAT(errorOf("a.obj", "v 0 0 0 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
              AllOf(HasSubstr("line 1"), HasSubstr("5 numbers")));
  EXPECT_THAT(errorOf("a.obj", "v 0 0 0 1 0 0 1 1\n"), HasSubstr("8 numbers"));
  const MeshImport alpha = import("a.obj", "v 0 0 0 1 0 0 0.5\nv 1 0 0 0 1 0 1\nv 0 1 0 0 0 1 1\nf 1 2 3\n");
  expectColor(colorAt(alpha.mesh, {1, 0, 0}), {0, 1, 0});
  EXPECT_THAT(alpha.notes, testing::Contains(HasSubstr("7 numbers")));
  const MeshImport weighted = import("a.obj", "v 0 0 0 1\nv 2 0 0 2\nv 0 1 0 1\nf 1 2 3\n");
  EXPECT_EQ(weighted.mesh.positions[1], (Float3{1, 0, 0}));
  EXPECT_THAT(weighted.notes, testing::Contains(HasSubstr("divided")));
  const MeshImport bytes = import("a.obj", "v 0 0 0 255 0 128\nv 1 0 0 0 255 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
  expectColor(colorAt(bytes.mesh, {0, 0, 0}), {1, 0, kLinearOf128});
  EXPECT_THAT(bytes.notes, testing::Contains(HasSubstr("8-bit")));
}

std::string plyWith(const std::string& type, const std::string& first, const std::string& second) {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "property " +
         type + " red\nproperty " + type + " green\nproperty " + type +
         " blue\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0 " +
         first + "\n1 0 0 " + second + "\n0 1 0 " + first + "\n3 0 1 2\n";
}

TEST_F(MeshImportTest, PlyColorsOfEightBitsAreDisplayCodesAndFloatsAreLight) {
  const MeshImport codes = import("a.ply", plyWith("uchar", "255 0 128", "0 128 255"));
  expectColor(colorAt(codes.mesh, {0, 0, 0}), {1, 0, kLinearOf128});
  expectColor(colorAt(codes.mesh, {1, 0, 0}), {0, kLinearOf128, 1});
  const MeshImport floats = import("b.ply", plyWith("float", "1 0 0.5", "0.25 0.02 0"));
  expectColor(colorAt(floats.mesh, {0, 1, 0}), {1, 0, 0.5F});
  expectColor(colorAt(floats.mesh, {1, 0, 0}), {0.25F, 0.02F, 0});
}

TEST_F(MeshImportTest, ColorsOutsideTheRangeAreClampedAndNoted) {
  const MeshImport read = import("a.ply", plyWith("float", "1 0 0.5", "1.5 -1 0"));
  expectColor(colorAt(read.mesh, {1, 0, 0}), {1, 0, 0});
  EXPECT_THAT(read.notes, testing::Contains(AllOf(HasSubstr("1 vertex colour"), HasSubstr("clamped"))));
}

// The triangle of gltfWith, COLOR_0 in a buffer of its own. With `second`, another primitive without colours.
std::string coloredGltf(const std::string& accessor, int size, const std::string& base64,
                        bool second = false) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
  "meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1}})" +
         std::string(second ? R"(,{"attributes":{"POSITION":0}})" : "") + R"(]}],
  "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
               {"bufferView":1,"count":3,)" +
         accessor + R"(}],
  "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":1,"byteLength":)" +
         std::to_string(size) + R"(}],
  "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"},
             {"byteLength":)" +
         std::to_string(size) + R"(,"uri":"data:application/octet-stream;base64,)" + base64 + R"("}]})";
}

// (1, 0, 0.5) (0.25, 0.5, 0) (0, 0, 1) as floats, and (255, 0, 128, 255) (64, 128, 0, 255) (0, 0, 255, 255).
const std::string kFloatColors = "AACAPwAAAAAAAAA/AACAPgAAAD8AAAAAAAAAAAAAAAAAAIA/";
const std::string kByteColors = "/wCA/0CAAP8AAP//";

TEST_F(MeshImportTest, GltfColorsAreLight) {
  const std::string floats = R"("componentType":5126,"type":"VEC3")";
  const MeshImport read = import("a.gltf", coloredGltf(floats, 36, kFloatColors));
  expectColor(colorAt(read.mesh, {0, 0, 0}), {1, 0, 0.5F});
  expectColor(colorAt(read.mesh, {1, 0, 0}), {0.25F, 0.5F, 0});
  expectColor(colorAt(read.mesh, {0, 1, 0}), {0, 0, 1});
  const std::string bytes = R"("componentType":5121,"normalized":true,"type":"VEC4")";
  const MeshImport coded = import("b.gltf", coloredGltf(bytes, 12, kByteColors));
  expectColor(colorAt(coded.mesh, {0, 0, 0}), {1, 0, 128 / 255.0F});
  expectColor(colorAt(coded.mesh, {1, 0, 0}), {64 / 255.0F, 128 / 255.0F, 0});
}

TEST_F(MeshImportTest, VerticesWithoutColorAreWhiteAndNoted) {
  const MeshImport read =
      import("a.gltf", coloredGltf(R"("componentType":5126,"type":"VEC3")", 36, kFloatColors, true));
  EXPECT_EQ(read.mesh.vertexCount(), 6U);
  expectColor(read.mesh.colors.at(0), {1, 0, 0.5F});
  expectColor(read.mesh.colors.at(3), {1, 1, 1});
  EXPECT_THAT(read.notes, testing::Contains(AllOf(HasSubstr("3 vertices"), HasSubstr("white"))));
}

TEST_F(MeshImportTest, ColorsOfOurOwnPlyAreTakenAsTheyAre) {
  TriangleMesh mesh = wavyGrid(2);
  mesh.colors = {{0.5F, 0, 0.02F}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  writePly(folder_ / "a.ply", mesh);
  const TriangleMesh read = readPly(folder_ / "a.ply");
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.colors, mesh.colors);
  expectColor(colorAt(importMesh(folder_ / "a.ply").mesh, mesh.positions[0]), {0.5F, 0, 0.02F});
}

TEST_F(MeshImportTest, MissingAndForeignFilesAreNamed) {
  EXPECT_THROW(importMesh(folder_ / "none.obj"), Error);
  EXPECT_THAT(errorOf("a.txt", "hello"), HasSubstr("a.txt"));
}

}  // namespace
}  // namespace bakelight::formats
