// OBJ files as different programs write them.

#include <gmock/gmock.h>

#include <functional>

#include "tests/unit/formats/bracket.h"
#include "tests/unit/formats/dialects.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;

class ObjDialects : public DialectTest {
 protected:
  ObjDialects() : DialectTest(".obj") {}
};

std::string verticesOf(const TriangleMesh& mesh, const std::string& suffix = "") {
  std::string text;
  for (const Float3& p : mesh.positions) text += "v " + integersText(p) + suffix + "\n";
  return text;
}

std::string facesOf(const TriangleMesh& mesh, const std::function<std::string(std::uint32_t)>& corner) {
  std::string text;
  for (const Triangle& t : mesh.triangles)
    text += "f " + corner(t[0] + 1) + " " + corner(t[1] + 1) + " " + corner(t[2] + 1) + "\n";
  return text;
}

std::string plainCorner(std::uint32_t number) {
  return std::to_string(number);
}

std::string bracketObj() {
  return verticesOf(bracket()) + facesOf(bracket(), plainCorner);
}

std::string utf16(const std::string& text, bool big_endian) {
  std::string result = big_endian ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : text) result += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
  return result;
}

TEST_F(ObjDialects, LayoutAndEncodingChangeNothing) {
  const std::string plain = bracketObj();
  for (const auto& [what, text] : std::initializer_list<std::pair<const char*, std::string>>{
           {"LF", plain},
           {"CR LF", replaced(plain, "\n", "\r\n")},
           {"CR", replaced(plain, "\n", "\r")},
           {"tabs", replaced(plain, " ", "\t")},
           {"many blanks", replaced(replaced(plain, " ", "   "), "\n", " \t \n  ")},
           {"blank lines", replaced(plain, "\n", "\n\n")},
           {"comments", replaced(plain, "\n", " # note 1 2 3\n#\n# v 9 9 9\n")},
           {"comment without a blank", replaced(plain, "\n", "# note\n")},
           {"byte-order mark", "\xEF\xBB\xBF" + plain},
           {"UTF-16, little-endian", utf16(plain, false)},
           {"UTF-16, big-endian", utf16(plain, true)},
           {"capitals", replaced(replaced(plain, "v", "V"), "f", "F")},
           {"continued lines", replaced(plain, " 1", " \\\n1")},
           {"continued lines, CR LF", replaced(plain, " 1", " \\\r\n1")},
           {"faces first", facesOf(bracket(), plainCorner) + verticesOf(bracket())},
           {"plus signs", replaced(plain, " ", " +")},
           {"decimals", verticesOf(bracket(), ".0e0") + facesOf(bracket(), plainCorner)},
           {"w of 1", verticesOf(bracket(), " 1.0") + facesOf(bracket(), plainCorner)},
           {"counted back",
            verticesOf(bracket()) +
                facesOf(bracket(), [](std::uint32_t i) { return std::to_string(static_cast<int>(i) - 13); })},
           {"smoothing and groups of one", "s off\no L\n" + plain + "s 1\n"}}) {
    const MeshImport read = import(text);
    expectBracket(read.mesh, what);
    expectSameTriangles(read.mesh, bracket(), what);
    EXPECT_THAT(read.notes, IsEmpty()) << what;
  }
  expectBracket(import(plain, "b.OBJ").mesh, "ending in capitals");
}

TEST_F(ObjDialects, CornersHaveAnyOfTheThreeIndices) {
  const std::string attributes = "vt 0 0\nvt 1 0.5\nvt 0.25 0.75 0\nvn 0 0 1\nvn 0 1 0\n";
  const auto with = [&](const std::string& rest) {
    return import(verticesOf(bracket()) + attributes +
                  facesOf(bracket(), [&](std::uint32_t i) { return std::to_string(i) + rest; }));
  };
  const MeshImport texture = with("/2");
  expectSameTriangles(texture.mesh, bracket(), "v/vt");
  EXPECT_THAT(texture.mesh.texcoords, Each(Float2{1, 0.5F}));
  EXPECT_THAT(texture.mesh.normals, IsEmpty());
  const MeshImport normal = with("//-1");
  expectSameTriangles(normal.mesh, bracket(), "v//vn");
  EXPECT_THAT(normal.mesh.normals, Each(Float3{0, 1, 0}));
  const MeshImport both = with("/3/1");
  expectSameTriangles(both.mesh, bracket(), "v/vt/vn");
  EXPECT_THAT(both.mesh.texcoords, Each(Float2{0.25F, 0.75F}));
  EXPECT_THAT(both.mesh.normals, Each(Float3{0, 0, 1}));
  for (const char* empty : {"/", "//"}) expectSameTriangles(with(empty).mesh, bracket(), empty);

  const MeshImport mixed = import("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + attributes + "f 1/1 2/2 3/3\nf 1 3 2\n");
  EXPECT_THAT(mixed.mesh.texcoords, IsEmpty());
  EXPECT_THAT(mixed.notes, Contains(HasSubstr("texture coordinates were left out: 3 of 6 corners")));
}

TEST_F(ObjDialects, CoordinatesAreTheNearestFloats) {
  const MeshImport read = import(
      "v 0.1 16777217 1e-46\nv 1.00000017881393432617187499 1.00000017881393432617187500 -0\n"
      "v 3.4028235e38 1e-40 0.30000001192092896\nf 1 2 3\n");
  EXPECT_EQ(read.mesh.positions[0], (Float3{0.1F, 16777216.0F, 0}));
  // Halfway between two floats and just below: through double both would round to the even one.
  EXPECT_EQ(read.mesh.positions[1][0], 1.00000011920928955078125F);
  EXPECT_EQ(read.mesh.positions[1][1], 1.0000002384185791015625F);
  EXPECT_EQ(read.mesh.positions[2], (Float3{3.4028235e38F, 1e-40F, 0.3F}));
}

TEST_F(ObjDialects, WhatIsNoNumberNamesItsLine) {
  const auto with = [](const std::string& word) {
    return "# one\nv 0 0 0\nv 1 " + word + " 0\nv 0 1 0\nf 1 2 3\n";
  };
  for (const char* word : {"nan", "-NaN", "inf", "1e400", "-1e39", "1.#QNAN", "-1.#IND00", "1.#INF"})
    EXPECT_THAT(errorOf(with(word)),
                AllOf(HasSubstr("line 3"), HasSubstr("vertex 2 (counted from 1)"), HasSubstr("not finite")))
        << word;
  for (const char* word : {"0,5", "x", "0x10", "1e", "--1", "1.2.3"})
    EXPECT_THAT(errorOf(with(word)), AllOf(HasSubstr("line 3"), HasSubstr("not a number"))) << word;
  const MeshImport unused = import("v 0 0 0\nv nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 4\n");
  EXPECT_EQ(unused.mesh.vertexCount(), 3U) << "no face names the vertex";
  EXPECT_THAT(unused.notes, Contains(HasSubstr("1 of 4 vertices")));
}

TEST_F(ObjDialects, IndicesOutOfRangeNameLineIndexAndCount) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
  EXPECT_THAT(errorOf(three + "f 1 2 4\n"),
              AllOf(HasSubstr("line 5"), HasSubstr("vertex 4 does not exist"), HasSubstr("1 to 3")));
  EXPECT_THAT(errorOf(three + "f 1/1 2/2 3/1\n"),
              AllOf(HasSubstr("line 5"), HasSubstr("texture coordinate 2"), HasSubstr("1 to 1")));
  EXPECT_THAT(errorOf(three + "f 1//1 2//1 3//1\n"), AllOf(HasSubstr("normal 1"), HasSubstr("no normal")));
  EXPECT_THAT(errorOf(three + "f 1 2 -4\n"), AllOf(HasSubstr("line 5"), HasSubstr("vertex -4")));
  for (const char* corner : {"0", "1.5", "x", "1/1/1/1", "99999999999999999999", "/1"})
    EXPECT_THAT(errorOf(three + "f 1 2 " + corner + "\n"), HasSubstr("line 5")) << corner;
  EXPECT_THAT(errorOf(three + "f 1 2 4294967297\n"), HasSubstr("4294967297 does not exist"));
}

TEST_F(ObjDialects, WhatIsNoPolygonIsLeftOutAndNoted) {
  const MeshImport read =
      import(bracketObj() + "l 1 2 3\np 4\nf 7\nf\ncstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nend\nfoo bar\n");
  expectBracket(read.mesh, "with other elements");
  EXPECT_THAT(read.notes, Contains(HasSubstr("2 lines of points or lines")));
  EXPECT_THAT(read.notes,
              Contains(AllOf(HasSubstr("2 faces have fewer than 3 corners"), HasSubstr("line 35"))));
  EXPECT_THAT(read.notes, Contains(HasSubstr("1 free-form curve")));
  EXPECT_THAT(read.notes,
              Contains(AllOf(HasSubstr("unknown keyword"), HasSubstr("foo"), HasSubstr("line 41"))));
  EXPECT_THAT(errorOf("v 0 0 0\nv 1 0 0\np 1 2\n"), AllOf(HasSubstr("no triangle"), HasSubstr("2 vertices")));
}

TEST_F(ObjDialects, PolygonsHaveTheirArea) {
  std::string text = verticesOf(bracket()) + "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
  for (int i = 1; i <= 6; ++i)
    text += "f " + std::to_string(i) + " " + std::to_string(i % 6 + 1) + " " + std::to_string(i % 6 + 7) +
            " " + std::to_string(i + 6) + "\n";
  const MeshImport read = import(text);
  expectBracket(read.mesh, "six-cornered ends, concave");
  EXPECT_THAT(read.notes, IsEmpty());
}

TEST_F(ObjDialects, NamesOfMaterialsAndLibrariesContainBlanks) {
  const std::string blue = "newmtl deep blue # 2\nKd 0.1 0.2 0.3\n";
  struct Case {
    const char *library, *line;
  };
  for (const Case& c : std::initializer_list<Case>{{"a.mtl", "mtllib a.mtl"},
                                                   {"my colours.mtl", "mtllib my colours.mtl  "},
                                                   {"my colours.mtl", "mtllib \"my colours.mtl\""},
                                                   {"b c.mtl", "mtllib none.mtl b c.mtl"},
                                                   {"Plain.MTL", "mtllib plain.mtl"},
                                                   {"d.mtl", "mtllib .\\d.mtl"},
                                                   {"e.mtl", "mtllib C:\\models\\e.mtl"}}) {
    write(c.library, blue);
    const MeshImport read = import(std::string(c.line) + "\r\nusemtl deep blue \r\n" + bracketObj());
    EXPECT_EQ(read.mesh.material_names, std::vector<std::string>{"deep blue"}) << c.line;
    EXPECT_THAT(read.mesh.colors, AllOf(testing::SizeIs(12), Each(Float3{0.1F, 0.2F, 0.3F}))) << c.line;
  }
}

TEST_F(ObjDialects, MissingLibrariesAndMaterialsAreNotedAndKeepTheirNames) {
  const MeshImport no_library = import("mtllib none.mtl\nusemtl a\n" + bracketObj());
  EXPECT_EQ(no_library.mesh.material_names, std::vector<std::string>{"a"});
  EXPECT_THAT(no_library.mesh.colors, IsEmpty());
  EXPECT_THAT(no_library.notes, testing::ElementsAre(AllOf(HasSubstr("line 1"), HasSubstr("none.mtl"))));
  write("a.mtl", "newmtl a\nKd 1 0 0\n");
  const MeshImport no_material = import("mtllib a.mtl\nusemtl b\n" + bracketObj());
  EXPECT_THAT(no_material.notes, Contains(HasSubstr("the material 'b' is in none")));
}

TEST_F(ObjDialects, MaterialsAreInOrderOfFirstUse) {
  write("a.mtl", "newmtl unused\nKd 1 1 1\nnewmtl one\nKd 0.5\nnewmtl two\nkd 2 0 0\n");
  const MeshImport read = import(
      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 3 2 1\nusemtl two\nf 1 2 3\nusemtl one\nf 1 2 3\nusemtl "
      "two\nf 1 3 2\n");
  EXPECT_EQ(read.mesh.material_names, (std::vector<std::string>{"two", "one", ""}));
  EXPECT_EQ(read.mesh.triangle_materials, (std::vector<std::uint32_t>{2, 0, 1, 0}));
  EXPECT_EQ(read.mesh.colors[read.mesh.triangles[1][0]], (Float3{1, 0, 0}));
  EXPECT_EQ(read.mesh.colors[read.mesh.triangles[2][0]], (Float3{0.5F, 0.5F, 0.5F}));
  EXPECT_THAT(read.notes, Contains(HasSubstr("clamped")));
}

const std::string kTexturedTriangle =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

TEST_F(ObjDialects, TexturesOfMaterials) {
  std::filesystem::create_directory(folder_ / "maps");
  write("maps/my wood.png", "");
  const auto with = [&](const std::string& line) {
    write("a.mtl", "newmtl a\nKd 0.5 0.25 1\n" + line + "\n");
    return import("mtllib a.mtl\nusemtl a\n" + kTexturedTriangle);
  };
  for (const char* line :
       {"map_Kd maps/my wood.png", "map_kd maps\\my wood.png", "\tmap_Kd   MAPS/My Wood.PNG  ",
        "map_Kd -blendu on -bm 1 -texres 64 -clamp off -mm 0 1 maps/my wood.png"}) {
    const MeshImport read = with(line);
    ASSERT_EQ(read.textures.size(), 1U) << line;
    EXPECT_EQ(read.textures[0].path, folder_ / "maps/my wood.png") << line;
    EXPECT_EQ(read.textures[0].wrap_u, AlbedoTexture::Wrap::kRepeat) << line;
    EXPECT_EQ(read.texture_lookups[0], (Float2{0.5F, 0.25F})) << line;
    EXPECT_EQ(read.mesh.colors[0], (Float3{0.5F, 0.25F, 1})) << line;
  }
  const MeshImport moved = with("map_Kd -s 2 4 1 -o 0.5 -clamp on maps/my wood.png");
  ASSERT_EQ(moved.textures.size(), 1U);
  EXPECT_EQ(moved.textures[0].wrap_v, AlbedoTexture::Wrap::kClamp);
  EXPECT_EQ(moved.texture_lookups[0], (Float2{1.5F, 1}));
  EXPECT_EQ(moved.mesh.texcoords[0], (Float2{0.5F, 0.25F})) << "the mesh's own stay";

  const MeshImport missing = with("map_Kd maps/stone.png");
  EXPECT_THAT(missing.textures, IsEmpty());
  EXPECT_EQ(missing.mesh.colors[0], (Float3{0.5F, 0.25F, 1}));
  EXPECT_THAT(missing.notes, Contains(AllOf(HasSubstr("a.mtl, line 3"), HasSubstr("maps/stone.png"))));
}

TEST_F(ObjDialects, BlackUnderATextureMeansTheTextureAlone) {
  write("a.png", "");
  write("a.mtl", "newmtl a\nKd 0 0 0\nmap_Kd a.png\n");
  const MeshImport read = import("mtllib a.mtl\nusemtl a\n" + kTexturedTriangle);
  ASSERT_EQ(read.textures.size(), 1U);
  for (const Float3& color : read.mesh.colors) EXPECT_EQ(color, (Float3{1, 1, 1}));
  EXPECT_THAT(read.notes, Contains(HasSubstr("black")));
  const MeshImport bare = import("mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(bare.textures, IsEmpty());
  EXPECT_THAT(bare.notes, Contains(HasSubstr("no texture coordinates")));
}

TEST_F(ObjDialects, WrongLibrariesNameTheirLine) {
  write("a.mtl", "newmtl a\nKd red\n");
  EXPECT_THAT(errorOf("mtllib a.mtl\nusemtl a\n" + bracketObj()),
              AllOf(HasSubstr("a.mtl, line 2"), HasSubstr("red")));
  write("a.mtl", "newmtl a\nmap_Kd\n");
  EXPECT_THAT(errorOf("mtllib a.mtl\nusemtl a\n" + bracketObj()), HasSubstr("a.mtl, line 2"));
  write("a.mtl", "newmtl a\nKd spectral file.rfl 1\n");
  EXPECT_THAT(import("mtllib a.mtl\nusemtl a\n" + bracketObj()).notes, Contains(HasSubstr("spectral")));
}

TEST_F(ObjDialects, OtherFilesUnderItsEndingAreTold) {
  EXPECT_THAT(errorOf(""), HasSubstr("empty"));
  EXPECT_THAT(errorOf("<!DOCTYPE html><html></html>"), HasSubstr("web page"));
  EXPECT_THAT(errorOf("\n <HTML><body>"), HasSubstr("web page"));
  EXPECT_THAT(errorOf("PK\x03\x04 and more"), HasSubstr("zip"));
  EXPECT_THAT(errorOf("glTF and more"), AllOf(HasSubstr("glTF"), HasSubstr(".glb")));
  EXPECT_THAT(errorOf("ply\nformat ascii 1.0\n"), HasSubstr("PLY"));
}

}  // namespace
}  // namespace bakelight::formats
