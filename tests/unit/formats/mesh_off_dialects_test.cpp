// OFF files as different programs write them.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
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

class OffDialects : public DialectTest {
 protected:
  OffDialects() : DialectTest(".off") {}
};

std::string verticesWith(const std::string& rest) {
  std::string text;
  for (const Float3& p : bracket().positions) text += integersText(p) + rest + "\n";
  return text;
}

std::string facesWith(const std::string& rest) {
  std::string text;
  for (const Triangle& t : bracket().triangles)
    text +=
        "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + rest + "\n";
  return text;
}

std::string bracketOff(const std::string& header = "OFF\n12 20 30\n", const std::string& vertex = "",
                       const std::string& face = "") {
  return header + verticesWith(vertex) + facesWith(face);
}

TEST_F(OffDialects, LayoutChangesNothing) {
  const std::string plain = bracketOff(), body = verticesWith("") + facesWith("");
  for (const auto& [what, text] : std::initializer_list<std::pair<const char*, std::string>>{
           {"LF", plain},
           {"CR LF", replaced(plain, "\n", "\r\n")},
           {"CR", replaced(plain, "\n", "\r")},
           {"comments", "# first\n" + replaced(plain, "\n", " # note\n# 1 2 3\n\n")},
           {"comments without a blank", replaced(plain, "\n", "#note\n")},
           {"tabs", replaced(plain, " ", "\t ")},
           {"byte-order mark", "\xEF\xBB\xBF" + plain},
           {"lowercase", "off" + plain.substr(3)},
           {"counts on the keyword's line", "OFF 12 20 0\n" + body},
           {"counts against the keyword", "OFF12 20 0\n" + body},
           {"counts on lines of their own", "OFF\n12\n20\n0\n" + body},
           {"no number of edges", "OFF\n12 20\n" + body},
           {"no keyword", "12 20 0\n" + body},
           {"all on a line", replaced(plain, "\n", " ") + "\n"},
           {"broken anywhere", replaced(plain, " ", "\n")},
           {"blank lines at the end", plain + "\n \n# end\n"}}) {
    const MeshImport read = import(text);
    expectBracket(read.mesh, what);
    EXPECT_EQ(read.mesh.positions, bracket().positions) << what;
    EXPECT_EQ(read.mesh.triangles, bracket().triangles) << what;
    EXPECT_THAT(read.notes, IsEmpty()) << what;
  }
}

TEST_F(OffDialects, HeadersSayWhatVerticesHave) {
  constexpr float kLinearOf128 = 0.21586050F;
  struct Case {
    const char *keyword, *rest;
    bool normals, colors, texcoords;
  };
  for (const Case& c :
       std::initializer_list<Case>{{"COFF", " 255 0 128", false, true, false},
                                   {"COFF", " 255 0 128 255", false, true, false},
                                   {"COFF", " 1.0 0 0.50196078 1", false, true, false},
                                   {"NOFF", " 0 0 1", true, false, false},
                                   {"CNOFF", " 0 0 1 255 0 128 255", true, true, false},
                                   {"NCOFF", " 0 0 1 255 0 128", true, true, false},
                                   {"STOFF", " 0.25 0.75", false, false, true},
                                   {"STCNOFF", " 0 0 1 255 0 128 255 0.25 0.75", true, true, true}}) {
    const MeshImport read = import(bracketOff(std::string(c.keyword) + "\n12 20 0\n", c.rest));
    expectSameTriangles(read.mesh, bracket(), c.keyword);
    EXPECT_EQ(read.mesh.normals, std::vector<Float3>(c.normals ? 12 : 0, {0, 0, 1})) << c.keyword;
    EXPECT_EQ(read.mesh.texcoords, std::vector<Float2>(c.texcoords ? 12 : 0, {0.25F, 0.75F})) << c.keyword;
    ASSERT_EQ(read.mesh.colors.size(), c.colors ? 12U : 0U) << c.keyword;
    for (const Float3& color : read.mesh.colors)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(color[k], (Float3{1, 0, kLinearOf128})[k], 1e-5F) << c.rest;
    EXPECT_THAT(read.notes, IsEmpty()) << c.keyword;
  }
  EXPECT_THAT(import(bracketOff("OFF\n12 20 0\n", " 255 0 0")).mesh.colors, Each(Float3{1, 0, 0}))
      << "not named, and usual";
  for (const char* keyword : {"4OFF", "nOFF", "4nOFF", "LOFF"})
    EXPECT_THAT(errorOf(bracketOff(std::string(keyword) + "\n12 20 0\n")), HasSubstr(keyword));
}

TEST_F(OffDialects, ColorsOfFaces) {
  for (const char* color : {" 255 0 0", " 255 0 0 255", " 1.0 0.0 0.0", " 1.0 0 0 1", " 1 0 0"}) {
    const MeshImport read = import(bracketOff("OFF\n12 20 0\n", "", color));
    expectSameTriangles(read.mesh, bracket(), color);
    EXPECT_THAT(read.mesh.colors, AllOf(testing::SizeIs(12), Each(Float3{1, 0, 0}))) << color;
  }
  const std::string two = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3";
  const MeshImport borders = import(two + " 0 0 255\n");
  EXPECT_EQ(borders.mesh.vertexCount(), 6U);
  for (std::size_t t = 0; t < 2; ++t)
    for (const std::uint32_t v : borders.mesh.triangles[t])
      EXPECT_EQ(borders.mesh.colors[v], t == 0 ? (Float3{1, 0, 0}) : (Float3{0, 0, 1}));
  EXPECT_THAT(import(two + "\n").notes, Contains(HasSubstr("1 face has no colour")));
  EXPECT_THAT(import(bracketOff("OFF\n12 20 0\n", "", " 4")).notes, Contains(HasSubstr("colour map")));
}

TEST_F(OffDialects, PolygonsHaveTheirArea) {
  std::string text = "OFF\n12 9 0\n" + verticesWith("") + "6 5 4 3 2 1 0\n6 6 7 8 9 10 11\n2 0 1\n";
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    text += "4 " + std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(j + 6) + " " +
            std::to_string(i + 6) + "\n";
  }
  const MeshImport read = import(text);
  expectBracket(read.mesh, "polygons");
  EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("1 face has fewer than 3 corners")));
}

TEST_F(OffDialects, ErrorsNameElementAndLine) {
  EXPECT_THAT(
      errorOf(replaced(bracketOff(), "3 6 7 8", "3 6 77 8")),
      AllOf(HasSubstr("face 4 (counted from 0, line 19)"), HasSubstr("vertex 77"), HasSubstr("0 to 11")));
  EXPECT_THAT(errorOf(replaced(bracketOff(), "3 6 7 8", "3 6 -1 8")), HasSubstr("vertex -1"));
  EXPECT_THAT(errorOf(replaced(bracketOff(), "3 6 7 8", "3 6 7")),
              AllOf(HasSubstr("face 4"), HasSubstr("2 corners")));
  EXPECT_THAT(errorOf(replaced(bracketOff(), "1 2 0", "1 nan 0")),
              AllOf(HasSubstr("vertex 4"), HasSubstr("line 7"), HasSubstr("not finite")));
  EXPECT_THAT(errorOf(replaced(bracketOff(), "1 2 0", "1 0")),
              AllOf(HasSubstr("vertex 4"), HasSubstr("2 numbers")));
  EXPECT_THAT(errorOf(bracketOff("OFF\n12 21 0\n")), AllOf(HasSubstr("face 20"), HasSubstr("cut short")));
  EXPECT_THAT(import(bracketOff("OFF\n12 20 0\n") + "3 0 1 2\n").notes, Contains(HasSubstr("text follows")));
  EXPECT_THAT(errorOf("OFF\n-1 2 3\n"), HasSubstr("'-1'"));
  EXPECT_THAT(errorOf("mesh\n1 2 3\n"), HasSubstr("no OFF"));
  EXPECT_THAT(errorOf("OFF\n4000000000 4000000000 0\n0 0 0\n"), HasSubstr("vertex 1"));
}

TEST_F(OffDialects, ACutAnywhereIsAnErrorOrANote) {
  for (const std::string& whole : {bracketOff(), bracketOff("COFF\n12 20 0\n", " 1 2 3", " 255 0 0")})
    for (std::size_t size = 0; size < whole.size(); size += 2) {
      const bool is_read = errorOf(whole.substr(0, size)) == "no error";
      EXPECT_TRUE(!is_read || !import(whole.substr(0, size)).notes.empty()) << size;
    }
}

TEST_F(OffDialects, BinaryIsBigEndian) {
  std::string bytes = "OFF BINARY\n";
  const auto put = [&](auto value) {
    char raw[4];
    std::memcpy(raw, &value, 4);
    std::reverse(raw, raw + 4);
    bytes.append(raw, 4);
  };
  for (const std::int32_t count : {12, 20, 30}) put(count);
  for (const Float3& p : bracket().positions)
    for (const float v : p) put(v);
  for (const Triangle& t : bracket().triangles) {
    put(std::int32_t{3});
    for (const std::uint32_t v : t) put(v);
    put(std::int32_t{0});
  }
  const MeshImport read = import(bytes);
  EXPECT_EQ(read.mesh.positions, bracket().positions);
  EXPECT_EQ(read.mesh.triangles, bracket().triangles);
  EXPECT_THAT(read.notes, IsEmpty());
  for (std::size_t size = 0; size < bytes.size(); size += 3)
    EXPECT_NE(errorOf(bytes.substr(0, size)), "no error") << size;
}

}  // namespace
}  // namespace bakelight::formats
