// STL files as different programs write them.

#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <limits>

#include "tests/unit/formats/bracket.h"
#include "tests/unit/formats/dialects.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class StlDialects : public DialectTest {
 protected:
  StlDialects() : DialectTest(".stl") {}
};

std::string facetsOf(std::size_t begin, std::size_t end) {
  const TriangleMesh mesh = bracket();
  std::string text;
  for (std::size_t t = begin; t < end; ++t) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const std::uint32_t v : mesh.triangles[t]) {
      const Float3& p = mesh.positions[v];
      text += "      vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " +
              std::to_string(p[2]) + "\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  return text;
}

std::string textStl() {
  return "solid my L bracket\n" + facetsOf(0, 20) + "endsolid my L bracket\n";
}

std::string binaryStl(std::string header, const std::vector<std::uint16_t>& attributes = {},
                      const Float3& normal = {}) {
  const TriangleMesh mesh = bracket();
  header.resize(80, ' ');
  append(header, std::uint32_t{20});
  for (std::size_t t = 0; t < 20; ++t) {
    append(header, normal);
    for (const std::uint32_t v : mesh.triangles[t]) append(header, mesh.positions[v]);
    append(header, attributes.empty() ? std::uint16_t{0} : attributes[t]);
  }
  return header;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

TEST_F(StlDialects, TextInAnyLayout) {
  const std::string plain = textStl();
  for (const auto& [what, text] : std::initializer_list<std::pair<const char*, std::string>>{
           {"LF", plain},
           {"CR LF", replaced(plain, "\n", "\r\n")},
           {"CR", replaced(plain, "\n", "\r")},
           {"capitals", upper(plain)},
           {"no indentation", replaced(plain, "  ", "")},
           {"tabs", replaced(plain, "  ", "\t")},
           {"byte-order mark", "\xEF\xBB\xBF" + plain},
           {"blank lines before", "\n\n " + plain},
           {"no names", replaced(plain, " my L bracket", "")},
           {"a name with its words", replaced(plain, "my L bracket", "facet endsolid vertex")},
           {"no final line end", plain.substr(0, plain.size() - 1)},
           {"two solids",
            "solid a\n" + facetsOf(0, 7) + "endsolid a\nsolid\n" + facetsOf(7, 20) + "endsolid\n"},
           {"an empty solid", plain + "solid b\nendsolid b\n"}}) {
    const MeshImport read = import(text);
    expectBracket(read.mesh, what);
    expectSameTriangles(read.mesh, bracket(), what);
    EXPECT_THAT(read.notes, IsEmpty()) << what;
  }
}

TEST_F(StlDialects, BinaryWhateverItsHeaderSays) {
  for (const char* header : {"", "made by hand", "solid", "solid facet normal", "SOLID facet\nouter loop"}) {
    const MeshImport read = import(binaryStl(header));
    expectSameTriangles(read.mesh, bracket(), header);
    EXPECT_THAT(read.notes, IsEmpty()) << header;
  }
}

TEST_F(StlDialects, SizesThatDoNotFitAreTold) {
  const std::string whole = binaryStl("made by hand");
  EXPECT_THAT(errorOf(whole.substr(0, whole.size() - 1)),
              AllOf(HasSubstr("facet 19"), HasSubstr("20 facets"), HasSubstr("cut short")));
  EXPECT_THAT(errorOf(whole + std::string(50, '\0')),
              AllOf(HasSubstr("20 facets"), HasSubstr("room for 21")));
  EXPECT_THAT(import(whole + "xyz").notes, Contains(HasSubstr("3 bytes follow")));
  std::string big_endian = whole;
  std::reverse(big_endian.begin() + 80, big_endian.begin() + 84);
  EXPECT_THAT(errorOf(big_endian), HasSubstr("big-endian"));
  for (const std::string& stl : {whole, textStl()})
    for (std::size_t size = 0; size + 14 < stl.size(); size += 7)
      EXPECT_NE(errorOf(stl.substr(0, size)), "no error") << size;
}

TEST_F(StlDialects, ErrorsNameFacetOrLine) {
  std::string damaged = binaryStl("");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(damaged.data() + 84 + 50 * 7 + 12, &nan, sizeof nan);
  EXPECT_THAT(errorOf(damaged), AllOf(HasSubstr("facet 7 (counted from 0)"), HasSubstr("not finite")));
  EXPECT_THAT(errorOf(replaced(textStl(), "endloop", "end")), AllOf(HasSubstr("line 7"), HasSubstr("'end'")));
  EXPECT_THAT(errorOf("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex nan 0 0\n"),
              AllOf(HasSubstr("line 5"), HasSubstr("facet 0"), HasSubstr("not finite")));
  EXPECT_THAT(errorOf("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                      "0\nendloop\nendfacet\nendsolid\n"),
              HasSubstr("2 corners"));
  EXPECT_THAT(errorOf("solid a\nendsolid a\n"), HasSubstr("no triangle"));
  EXPECT_THAT(errorOf("hello"), HasSubstr("5 bytes"));
}

TEST_F(StlDialects, NormalsAgainstTheWindingAreNoted) {
  const MeshImport read = import(binaryStl("", {}, {0, 0, 1}));
  expectBracket(read.mesh, "the winding counts");
  EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("4 facets are wound against the normal")));
}

TEST_F(StlDialects, ColorsOfFacets) {
  std::vector<std::uint16_t> viscam(20, 0x8000 | 31 << 10), materialise(20, 31);
  viscam[3] = 0;                       // no colour of its own
  materialise[3] = 0x8000 | 31 << 10;  // the whole's
  const MeshImport blue_low = import(binaryStl("", viscam));
  const MeshImport red_low = import(binaryStl(std::string("COLOR=\x00\xFF\x00\xFF", 10), materialise));
  for (const MeshImport* read : {&blue_low, &red_low}) {
    ASSERT_EQ(read->mesh.colors.size(), 60U);
    EXPECT_EQ(read->mesh.colors[0], (Float3{1, 0, 0}));
  }
  EXPECT_EQ(blue_low.mesh.colors[9], (Float3{1, 1, 1}));
  EXPECT_THAT(blue_low.notes, testing::ElementsAre(HasSubstr("1 facet has no colour")));
  EXPECT_EQ(red_low.mesh.colors[9], (Float3{0, 1, 0}));
  const MeshImport other = import(binaryStl("", std::vector<std::uint16_t>(20, 7)));
  EXPECT_THAT(other.mesh.colors, IsEmpty());
  EXPECT_THAT(other.notes, testing::ElementsAre(HasSubstr("attribute bytes")));
}

}  // namespace
}  // namespace bakelight::formats
