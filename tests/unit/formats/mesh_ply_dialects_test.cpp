// PLY files as different programs write them.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>

#include "tests/unit/formats/bracket.h"
#include "tests/unit/formats/dialects.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;

enum class Encoding { kText, kLittle, kBig };
constexpr Encoding kEncodings[] = {Encoding::kText, Encoding::kLittle, Encoding::kBig};

// Writes values of any type in any encoding; rows end in `line_end` in a text.
class PlyText {
 public:
  explicit PlyText(Encoding encoding, std::string line_end = "\n")
      : encoding_(encoding), line_end_(std::move(line_end)) {
    constexpr const char* kNames[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    header("ply").header(std::string("format ") + kNames[static_cast<int>(encoding)] + " 1.0");
  }

  PlyText& header(const std::string& line) {
    text_ += line + line_end_;
    return *this;
  }

  PlyText& value(const std::string& type, double value) {
    if (type == "char" || type == "int8") return put<std::int8_t>(value);
    if (type == "uchar" || type == "uint8") return put<std::uint8_t>(value);
    if (type == "short" || type == "int16") return put<std::int16_t>(value);
    if (type == "ushort" || type == "uint16") return put<std::uint16_t>(value);
    if (type == "int" || type == "int32") return put<std::int32_t>(value);
    if (type == "uint" || type == "uint32") return put<std::uint32_t>(value);
    if (type == "float" || type == "float32") return put<float>(value);
    return put<double>(value);
  }

  PlyText& endRow() {
    if (encoding_ == Encoding::kText) text_ += line_end_;
    return *this;
  }

  const std::string& text() const { return text_; }

 private:
  template <class T>
  PlyText& put(double value) {
    if (encoding_ == Encoding::kText) {
      char digits[40];
      std::snprintf(digits, sizeof digits, "%.17g ", value);
      text_ += digits;
      return *this;
    }
    const auto typed = static_cast<T>(value);
    char bytes[sizeof(T)];
    std::memcpy(bytes, &typed, sizeof(T));
    if (encoding_ == Encoding::kBig) std::reverse(bytes, bytes + sizeof(T));
    text_.append(bytes, sizeof(T));
    return *this;
  }

  Encoding encoding_;
  std::string line_end_, text_;
};

struct Dialect {
  std::string coordinate = "float", count = "uchar", index = "int", indices = "vertex_indices",
              line_end = "\n";
};

std::string bracketPly(Encoding encoding, const Dialect& d = {}) {
  const TriangleMesh mesh = bracket();
  PlyText ply(encoding, d.line_end);
  ply.header("element vertex 12");
  for (const char* axis : {"x", "y", "z"}) ply.header("property " + d.coordinate + " " + axis);
  ply.header("element face 20").header("property list " + d.count + " " + d.index + " " + d.indices);
  ply.header("end_header");
  for (const Float3& p : mesh.positions) {
    for (const float v : p) ply.value(d.coordinate, v);
    ply.endRow();
  }
  for (const Triangle& t : mesh.triangles) {
    ply.value(d.count, 3);
    for (const std::uint32_t v : t) ply.value(d.index, v);
    ply.endRow();
  }
  return ply.text();
}

class PlyDialects : public DialectTest {
 protected:
  PlyDialects() : DialectTest(".ply") {}
  void expectOrderKept(const std::string& text, const std::string& what) const {
    const MeshImport read = import(text);
    expectBracket(read.mesh, what);
    EXPECT_EQ(read.mesh.positions, bracket().positions) << what;
    EXPECT_EQ(read.mesh.triangles, bracket().triangles) << what;
    EXPECT_THAT(read.notes, IsEmpty()) << what;
  }
};

TEST_F(PlyDialects, AllTypesInAllEncodings) {
  const std::vector<std::string> types = {"char", "uchar", "short", "ushort", "int",   "uint",
                                          "int8", "uint8", "int16", "uint16", "int32", "uint32"};
  for (const Encoding encoding : kEncodings) {
    const std::string in = " in encoding " + std::to_string(static_cast<int>(encoding));
    for (const std::string& type : types) {
      expectOrderKept(bracketPly(encoding, {.coordinate = type}), "coordinates of " + type + in);
      expectOrderKept(bracketPly(encoding, {.count = type}), "counts of " + type + in);
      expectOrderKept(bracketPly(encoding, {.index = type, .indices = "vertex_index"}),
                      "indices of " + type + in);
    }
    for (const char* type : {"float", "double", "float32", "float64"})
      expectOrderKept(bracketPly(encoding, {.coordinate = type}), type + in);
    for (const char* line_end : {"\r\n", "\r"})
      expectOrderKept(bracketPly(encoding, {.line_end = line_end}), "other line ends" + in);
  }
  expectOrderKept("\xEF\xBB\xBF" + bracketPly(Encoding::kText), "byte-order mark");
}

TEST_F(PlyDialects, PropertiesAndElementsInAnyOrder) {
  const TriangleMesh mesh = bracket();
  for (const Encoding encoding : kEncodings) {
    PlyText ply(encoding);
    ply.header("comment faces first").header("obj_info nothing").header("element range_grid 2");
    ply.header("property list uchar int vertex_indices")
        .header("element face 20")
        .header("property uchar flags");
    ply.header("property list ushort double weights").header("property list uint ushort vertex_indices");
    ply.header("element empty 1000000000000")
        .header("element vertex 12")
        .header("property list uchar float extra");
    for (const char* name : {"nz", "y", "t", "nx", "quality", "x", "s", "ny", "z"})
      ply.header(std::string("property ") + (name[0] == 'n' ? "double " : "float ") + name);
    ply.header("element edge 1")
        .header("property int vertex1")
        .header("property int vertex2")
        .header("end_header");
    ply.value("uchar", 1).value("int", 0).endRow().value("uchar", 0).endRow();
    for (const Triangle& t : mesh.triangles) {
      ply.value("uchar", 7).value("ushort", 2).value("double", 0.5).value("double", 1).value("uint", 3);
      for (const std::uint32_t v : t) ply.value("ushort", v);
      ply.endRow();
    }
    for (std::size_t i = 0; i < 12; ++i) {
      const Float3& p = mesh.positions[i];
      ply.value("uchar", static_cast<double>(i % 3));
      for (std::size_t k = 0; k < i % 3; ++k) ply.value("float", 9);
      ply.value("double", 1).value("float", p[1]).value("float", 0.25).value("double", 0).value("float", 7);
      ply.value("float", p[0]).value("float", 0.75).value("double", 0).value("float", p[2]).endRow();
    }
    ply.value("int", 0).value("int", 1).endRow();
    const MeshImport read = import(ply.text());
    EXPECT_EQ(read.mesh.positions, mesh.positions);
    EXPECT_EQ(read.mesh.triangles, mesh.triangles);
    EXPECT_THAT(read.mesh.normals, Each(Float3{0, 0, 1}));
    EXPECT_THAT(read.mesh.texcoords, Each(Float2{0.75F, 0.25F}));
    EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("range_grid")));
  }
}

std::string triangleWith(Encoding encoding, const std::string& type, const std::array<std::string, 3>& names,
                         const Float3& color) {
  PlyText ply(encoding);
  ply.header("element vertex 3")
      .header("property float x")
      .header("property float y")
      .header("property float z");
  for (const std::string& name : names) ply.header("property " + type + " " + name);
  ply.header("element face 1").header("property list uchar int vertex_indices").header("end_header");
  for (const Float3& p : {Float3{0, 0, 0}, Float3{1, 0, 0}, Float3{0, 1, 0}}) {
    for (const float v : p) ply.value("float", v);
    for (const float v : color) ply.value(type, v);
    ply.endRow();
  }
  return ply.value("uchar", 3).value("int", 0).value("int", 1).value("int", 2).endRow().text();
}

TEST_F(PlyDialects, ColorsByNameAndType) {
  const std::vector<std::array<std::string, 3>> names = {
      {"red", "green", "blue"}, {"r", "g", "b"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}};
  struct Case {
    const char* type;
    Float3 written, linear;
  };
  constexpr float kLinearOf128 = 0.21586050F;
  for (const Encoding encoding : kEncodings)
    for (const auto& name : names)
      for (const Case& c : std::initializer_list<Case>{{"uchar", {255, 0, 128}, {1, 0, kLinearOf128}},
                                                       {"ushort", {65535, 0, 13107}, {1, 0, 0.2F}},
                                                       {"float", {1, 0, 0.25F}, {1, 0, 0.25F}},
                                                       {"double", {1, 0, 0.25F}, {1, 0, 0.25F}},
                                                       {"int", {255, 0, 128}, {1, 0, kLinearOf128}},
                                                       {"float", {255, 0, 128}, {1, 0, kLinearOf128}}}) {
        const MeshImport read = import(triangleWith(encoding, c.type, name, c.written));
        ASSERT_EQ(read.mesh.colors.size(), 3U) << c.type << " " << name[0];
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(read.mesh.colors[1][k], c.linear[k], 1e-6F) << c.type;
      }
}

TEST_F(PlyDialects, ColorsOfFacesEndAtTheirBorders) {
  for (const Encoding encoding : kEncodings) {
    PlyText ply(encoding);
    ply.header("element vertex 4")
        .header("property float x")
        .header("property float y")
        .header("property float z");
    ply.header("element face 2")
        .header("property uchar red")
        .header("property uchar green")
        .header("property uchar blue");
    ply.header("property list uchar int vertex_indices").header("end_header");
    for (const Float3& p : {Float3{0, 0, 0}, Float3{1, 0, 0}, Float3{1, 1, 0}, Float3{0, 1, 0}})
      ply.value("float", p[0]).value("float", p[1]).value("float", p[2]).endRow();
    for (const int second : {1, 2}) {
      ply.value("uchar", second == 1 ? 255 : 0).value("uchar", 0).value("uchar", 255).value("uchar", 3);
      ply.value("int", 0).value("int", second).value("int", second + 1).endRow();
    }
    const TriangleMesh mesh = import(ply.text()).mesh;
    ASSERT_EQ(mesh.vertexCount(), 6U);
    for (std::size_t t = 0; t < 2; ++t)
      for (const std::uint32_t v : mesh.triangles[t])
        EXPECT_EQ(mesh.colors[v], (Float3{t == 0 ? 1.0F : 0.0F, 0, 1}));
  }
}

TEST_F(PlyDialects, TexturesOfFaces) {
  writeQuickly(folder_ / "a b.png", "");
  PlyText ply(Encoding::kLittle);
  ply.header("comment TextureFile a b.png").header("comment TextureFile none.png").header("element vertex 4");
  ply.header("property float x")
      .header("property float y")
      .header("property float z")
      .header("element face 3");
  ply.header("property list uchar int vertex_indices").header("property list uchar float texcoord");
  ply.header("property int texnumber").header("end_header");
  for (const Float3& p : {Float3{0, 0, 0}, Float3{1, 0, 0}, Float3{1, 1, 0}, Float3{0, 1, 0}})
    ply.value("float", p[0]).value("float", p[1]).value("float", p[2]);
  for (const int texture : {0, 1, 5}) {
    ply.value("uchar", 3).value("int", 0).value("int", 1).value("int", 2).value("uchar", 6);
    for (int i = 0; i < 6; ++i) ply.value("float", 0.125 * i);
    ply.value("int", texture);
  }
  const MeshImport read = import(ply.text());
  EXPECT_EQ(read.mesh.material_names, (std::vector<std::string>{"a b.png", "none.png", ""}));
  EXPECT_EQ(read.mesh.triangle_materials, (std::vector<std::uint32_t>{0, 1, 2}));
  ASSERT_EQ(read.textures.size(), 1U);
  EXPECT_EQ(read.textures[0].path, folder_ / "a b.png");
  EXPECT_EQ(read.material_textures, (std::vector<int>{0, -1, -1}));
  EXPECT_EQ(read.texture_lookups[read.mesh.triangles[0][2]], (Float2{0.5F, 0.625F}));
  EXPECT_THAT(read.notes, Contains(HasSubstr("'none.png'")));
  EXPECT_THAT(read.notes, Contains(HasSubstr("1 face has the number of a texture")));
}

TEST_F(PlyDialects, MaterialsBetweenStagesKeepTheirNames) {
  const std::string text =
      "ply\nformat ascii 1.0\ncomment material 0 red%20paint\ncomment material 1 \nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\nelement face 2\n"
      "property list uchar uint vertex_indices\nproperty uint material_index\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1\n3 0 2 1 0\n";
  const MeshImport read = import(text);
  EXPECT_EQ(read.mesh.material_names, (std::vector<std::string>{"red paint", ""}));
  EXPECT_EQ(read.mesh.triangle_materials, (std::vector<std::uint32_t>{1, 0}));
}

TEST_F(PlyDialects, PolygonsAndStrips) {
  for (const Encoding encoding : kEncodings) {
    PlyText ply(encoding);
    ply.header("element vertex 12")
        .header("property float x")
        .header("property float y")
        .header("property float z");
    ply.header("element face 3").header("property list uchar int vertex_indices");
    ply.header("element tristrips 2").header("property list int int vertex_indices").header("end_header");
    for (const Float3& p : bracket().positions) {
      for (const float v : p) ply.value("float", v);
      ply.endRow();
    }
    for (const auto& face : std::vector<std::vector<int>>{{5, 4, 3, 2, 1, 0}, {0, 1}, {6, 7, 8, 9, 10, 11}}) {
      ply.value("uchar", static_cast<double>(face.size()));
      for (const int v : face) ply.value("int", v);
      ply.endRow();
    }
    // The mantle in two strips, the second of which begins again.
    for (const auto& strip :
         std::vector<std::vector<int>>{{6, 0, 7, 1, 8, 2, 9, 3}, {9, 3, 10, 4, 11, 5, -1, 11, 5, 6, 0}}) {
      ply.value("int", static_cast<double>(strip.size()));
      for (const int v : strip) ply.value("int", v);
      ply.endRow();
    }
    const MeshImport read = import(ply.text());
    expectBracket(read.mesh, "strips");
    EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("1 face has fewer than 3 corners")));
  }
}

TEST_F(PlyDialects, ACutAnywhereIsAnErrorOrANote) {
  for (const Encoding encoding : kEncodings) {
    const std::string whole = bracketPly(encoding);
    for (std::size_t size = 0; size + 1 < whole.size(); size += encoding == Encoding::kText ? 2 : 5) {
      const std::string error = errorOf(whole.substr(0, size));
      if (error == "no error") {
        EXPECT_EQ(encoding, Encoding::kText) << size;
        EXPECT_THAT(import(whole.substr(0, size)).notes, testing::Not(IsEmpty())) << size;
      }
    }
    EXPECT_THAT(errorOf(whole.substr(0, whole.size() - 20)),
                AllOf(HasSubstr("face 1"), HasSubstr("cut short")));
  }
  EXPECT_THAT(import(bracketPly(Encoding::kBig) + "xy").notes, Contains(HasSubstr("2 bytes follow")));
}

TEST_F(PlyDialects, ErrorsNameElementAndLine) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string face = "3 0 1 2\n";
  EXPECT_THAT(errorOf(head + "0 0 0\nnan 0 0\n0 1 0\n" + face),
              AllOf(HasSubstr("vertex 1 (counted from 0, line 11)"), HasSubstr("not finite")));
  EXPECT_THAT(errorOf(head + "0 0 0\n1 0 0\n0 1e39 0\n" + face), HasSubstr("vertex 2"));
  EXPECT_THAT(errorOf(head + "0 0 0\n1 0 0\n0 x 0\n" + face), AllOf(HasSubstr("line 12"), HasSubstr("'x'")));
  EXPECT_THAT(errorOf(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
              AllOf(HasSubstr("face 0 (counted from 0, line 13)"), HasSubstr("vertex 3 does not exist"),
                    HasSubstr("0 to 2")));
  EXPECT_THAT(errorOf(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"), HasSubstr("vertex -1"));
  EXPECT_THAT(errorOf(head + "0 0 0\n1 0 0\n0 1 0\n300 0 1 2\n"), HasSubstr("uchar"));
  // A row with another number of values than the header says, and not a file cut short.
  EXPECT_THAT(errorOf(head + "0 0 0\n1 0\n0 1 0\n" + face),
              AllOf(HasSubstr("vertex 1"), HasSubstr("line"), testing::Not(HasSubstr("cut short"))));
  EXPECT_THAT(errorOf(head + "0 0 0 7\n1 0 0 7\n0 1 0 7\n" + face),
              AllOf(HasSubstr("vertex 0"), HasSubstr("line 10")));
  EXPECT_THAT(errorOf(head.substr(0, head.find("element face")) + "end_header\n0 0 0\n1 0 0\n0 1 0\n"),
              HasSubstr("point cloud"));
  EXPECT_THAT(errorOf("ply\nformat middle 1.0\nelement vertex 1\nproperty float x\nproperty float "
                      "y\nproperty float z\nend_header\n"),
              HasSubstr("middle"));
  EXPECT_THAT(errorOf("ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float "
                      "x\nproperty float y\nproperty float z\n"
                      "element face 4000000000\nproperty list uchar int vertex_indices\nend_header\n"),
              HasSubstr("vertex 0 (counted from 0): the file ends here"));
}

TEST_F(PlyDialects, CoordinatesAreTheNearestFloats) {
  PlyText ply(Encoding::kBig);
  ply.header("element vertex 3")
      .header("property double x")
      .header("property int y")
      .header("property uint z");
  ply.header("element face 1").header("property list uchar int vertex_indices").header("end_header");
  for (int i = 0; i < 3; ++i)
    ply.value("double", 0.1 + i).value("int", -16777217).value("uint", 4294967295.0);
  ply.value("uchar", 3).value("int", 0).value("int", 1).value("int", 2);
  const MeshImport read = import(ply.text());
  EXPECT_EQ(read.mesh.positions[0], (Float3{0.1F, -16777216.0F, 4294967296.0F}));
  const std::string text = triangleWith(Encoding::kText, "float", {"red", "green", "blue"}, {0, 0, 0});
  const std::size_t at = text.find("end_header\n0 ");
  const MeshImport nearest =
      import(text.substr(0, at) + "end_header\n1.00000017881393432617187499" + text.substr(at + 12));
  EXPECT_EQ(nearest.mesh.positions[0][0], 1.00000011920928955078125F);
}

}  // namespace
}  // namespace bakelight::formats
