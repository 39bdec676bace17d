// COLLADA files: axes, units, transforms, materials by face, colours, texture coordinates, all kinds of
// lists.

#include <gmock/gmock.h>

#include <sstream>

#include "tests/unit/formats/dialects.h"
#include "tests/unit/formats/painted_bracket.h"

namespace bakelight::formats {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class ColladaFiles : public DialectTest {
 protected:
  ColladaFiles() : DialectTest(".dae") {}
};

struct Scene {
  std::string asset = "<up_axis>Y_UP</up_axis>";
  std::string nodes = "<node>BODY</node>";  // BODY stands for the geometry
  std::string library_nodes = {};
  std::string primitives = {};  // of the geometry
  bool painted = false, textured = false;
};

std::string numbersOf(const std::vector<Float3>& values) {
  std::ostringstream text;
  for (const Float3& v : values) text << v[0] << " " << v[1] << " " << v[2] << " ";
  return text.str();
}

std::string sourceOf(const std::string& id, std::size_t width, const std::string& names, std::size_t count,
                     const std::string& numbers) {
  std::string params;
  for (const char name : names) params += std::string("<param name=\"") + name + "\" type=\"float\"/>";
  return "<source id=\"" + id + "\"><float_array id=\"" + id + "-array\" count=\"" +
         std::to_string(count * width) + "\">" + numbers +
         "</float_array><technique_common><accessor source=\"#" + id + "-array\" count=\"" +
         std::to_string(count) + "\" stride=\"" + std::to_string(width) + "\">" + params +
         "</accessor></technique_common></source>";
}

// Triangles `begin` to `end` of the bracket, all inputs by the vertex's number.
std::string trianglesOf(std::size_t begin, std::size_t end, const std::string& attributes = "",
                        const std::string& inputs = "") {
  const TriangleMesh mesh = bracket();
  std::string text = "<triangles count=\"" + std::to_string(end - begin) + "\"" + attributes +
                     "><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>" + inputs + "<p>";
  for (std::size_t t = begin; t < end; ++t)
    for (const std::uint32_t v : mesh.triangles[t]) text += std::to_string(v) + " ";
  return text + "</p></triangles>";
}

std::string effects(bool textured) {
  std::string text;
  if (textured)
    text += "<library_images><image id=\"img\"><init_from>wood.png</init_from></image></library_images>";
  text += "<library_effects>";
  for (std::size_t m = 0; m < 2; ++m) {
    const std::string picture =
        "<newparam sid=\"s\"><surface type=\"2D\"><init_from>img</init_from></surface></newparam>"
        "<newparam sid=\"smp\"><sampler2D><source>s</source></sampler2D></newparam>";
    const bool has_picture = textured && m == 0;
    text += "<effect id=\"e" + std::to_string(m) + "\"><profile_COMMON>" + (has_picture ? picture : "") +
            "<technique sid=\"t\"><lambert><diffuse>" +
            (has_picture ? "<texture texture=\"smp\" texcoord=\"UV\"/>"
                         : "<color>" + numbersOf({kPaints[m]}) + "1</color>") +
            "</diffuse></lambert></technique></profile_COMMON></effect>";
  }
  text += "</library_effects><library_materials>";
  for (std::size_t m = 0; m < 2; ++m)
    text += "<material id=\"m" + std::to_string(m) + "\" name=\"" + kPaintNames[m] +
            "\"><instance_effect url=\"#e" + std::to_string(m) + "\"/></material>";
  return text + "</library_materials>";
}

std::string colladaOf(const Scene& scene, const std::string& version = "1.4.1") {
  const TriangleMesh mesh = bracket();
  std::ostringstream texcoords;
  std::vector<Float3> colors;
  for (const Float3& p : mesh.positions) {
    texcoords << texcoordAt(p)[0] << " " << texcoordAt(p)[1] << " ";
    colors.push_back(vertexColorAt(p));
  }
  std::string body = "<instance_geometry url=\"#g\">";
  if (scene.painted || scene.textured)
    body +=
        "<bind_material><technique_common><instance_material symbol=\"first\" target=\"#m0\">"
        "<bind_vertex_input semantic=\"UV\" input_semantic=\"TEXCOORD\" input_set=\"0\"/></instance_material>"
        "<instance_material symbol=\"second\" target=\"#m1\"/></technique_common></bind_material>";
  body += "</instance_geometry>";
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<COLLADA "
         "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"" +
         version + "\"><asset>" + scene.asset + "</asset>" +
         (scene.painted || scene.textured ? effects(scene.textured) : "") +
         "<library_geometries><geometry id=\"g\"><mesh>" +
         sourceOf("p", 3, "XYZ", 12, numbersOf(mesh.positions)) +
         sourceOf("uv", 2, "ST", 12, texcoords.str()) + sourceOf("c", 3, "RGB", 12, numbersOf(colors)) +
         "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>" +
         (scene.primitives.empty() ? trianglesOf(0, 20) : scene.primitives) +
         "</mesh></geometry></library_geometries>" + scene.library_nodes +
         "<library_visual_scenes><visual_scene id=\"w\">" + replaced(scene.nodes, "BODY", body) +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene "
         "url=\"#w\"/></scene></COLLADA>";
}

TEST_F(ColladaFiles, AxesAndUnits) {
  struct Case {
    const char *asset, *note;
    double unit;
    Float3 (*moved)(const Float3&);
  };
  const auto same = [](const Float3& p) { return p; };
  const auto z_up = [](const Float3& p) { return Float3{p[0], p[2], -p[1]}; };
  const auto x_up = [](const Float3& p) { return Float3{-p[1], p[0], p[2]}; };
  for (const Case& c : std::initializer_list<Case>{
           {"", nullptr, 1, same},
           {"<up_axis>Y_UP</up_axis>", nullptr, 1, same},
           {"<unit meter=\"1\" name=\"meter\"/><up_axis>Z_UP</up_axis>", "+Z up", 1, z_up},
           {"<up_axis>X_UP</up_axis>", "+X up", 1, x_up},
           {"<unit name=\"centimeter\" meter=\"0.01\"/>", "0.01", 0.01, same},
           {"<unit name=\"inch\" meter=\"0.0254\"/><up_axis>Z_UP</up_axis>", "0.0254", 0.0254, z_up},
           {"<unit name=\"kilometer\" meter=\"1000\"/><up_axis>X_UP</up_axis>", "1000", 1000, x_up}}) {
    const MeshImport read = import(colladaOf({.asset = c.asset}));
    const auto moved = [&](const Float3& p) {
      Float3 result = c.moved(p);
      for (float& x : result) x = static_cast<float>(x * c.unit);
      return result;
    };
    expectMovedBracket(read.mesh, moved, c.unit, c.asset);
    if (c.note == nullptr)
      EXPECT_THAT(read.notes, IsEmpty()) << c.asset;
    else
      EXPECT_THAT(read.notes, Contains(HasSubstr(c.note))) << c.asset;
  }
}

TEST_F(ColladaFiles, TransformsInTheirOrderAndChained) {
  // First twice as large, then a quarter turn about z, then moved.
  const auto moved = [](const Float3& p) { return Float3{5 - 2 * p[1], 6 + 2 * p[0], 7 + 2 * p[2]}; };
  const std::string move = "<translate>5 6 7</translate>", turn = "<rotate>0 0 1 90</rotate>",
                    grow = "<scale>2 2 2</scale>",
                    matrix = "<matrix>0 -2 0 5 2 0 0 6 0 0 2 7 0 0 0 1</matrix>";
  for (const std::string& nodes :
       {"<node>" + move + turn + grow + "BODY</node>", "<node>" + matrix + "BODY</node>",
        "<node>" + move + "<node>" + turn + "<node>" + grow + "BODY</node></node></node>",
        "<node>" + move + "<rotate>0 0 -1 90</rotate><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix>" +
            turn + turn + grow + "BODY</node>",
        "<node>" + matrix + "<instance_node url=\"#shared\"/></node>"}) {
    const MeshImport read = import(colladaOf(
        {.nodes = nodes,
         .library_nodes = nodes.find("instance_node") == std::string::npos
                              ? ""
                              : "<library_nodes><node id=\"shared\"><instance_geometry url=\"#g\"/></node></"
                                "library_nodes>"}));
    expectMovedBracket(read.mesh, moved, 2, nodes);
  }
  const MeshImport skewed = import(colladaOf({.asset = "<unit meter=\"0.01\"/><up_axis>Z_UP</up_axis>",
                                              .nodes = "<node>" + matrix + "BODY</node>"}));
  const auto upright = [&](const Float3& p) {
    const Float3 q = moved(p);
    return Float3{q[0] / 100, q[2] / 100, -q[1] / 100};
  };
  expectMovedBracket(skewed.mesh, upright, 0.02, "transform, axis and unit");
  const MeshImport mirrored = import(colladaOf({.nodes = "<node><scale>-1 1 1</scale>BODY</node>"}));
  expectMovedBracket(
      mirrored.mesh,
      [](const Float3& p) {
        return Float3{-p[0], p[1], p[2]};
      },
      1, "mirrored", true);
  EXPECT_THAT(mirrored.notes, Contains(HasSubstr("mirrored")));
}

TEST_F(ColladaFiles, MaterialsByFace) {
  const std::string first = trianglesOf(0, kFirstBlue, " material=\"first\""),
                    second = trianglesOf(kFirstBlue, 20, " material=\"second\"");
  const MeshImport read = import(colladaOf({.primitives = first + second, .painted = true}));
  expectMovedBracket(
      read.mesh, [](const Float3& p) { return p; }, 1, "materials");
  expectPaints(read, "materials");
}

TEST_F(ColladaFiles, ColorsAndTextureCoordinatesOfVertices) {
  const std::string inputs =
      "<input semantic=\"TEXCOORD\" source=\"#uv\" offset=\"0\" set=\"0\"/>"
      "<input semantic=\"COLOR\" source=\"#c\" offset=\"0\" set=\"0\"/>";
  const MeshImport read = import(colladaOf({.primitives = trianglesOf(0, 20, "", inputs)}));
  expectMovedBracket(
      read.mesh, [](const Float3& p) { return p; }, 1, "colours");
  expectTexcoords(read.mesh.texcoords, read.mesh, "texture coordinates");
  ASSERT_EQ(read.mesh.colors.size(), read.mesh.positions.size());
  for (std::size_t v = 0; v < read.mesh.colors.size(); ++v)
    EXPECT_EQ(read.mesh.colors[v], vertexColorAt(read.mesh.positions[v])) << v;
}

TEST_F(ColladaFiles, PicturesOfMaterials) {
  write("wood.png", "no picture, only its name counts here");
  const std::string uv = "<input semantic=\"TEXCOORD\" source=\"#uv\" offset=\"0\" set=\"0\"/>";
  const MeshImport read =
      import(colladaOf({.primitives = trianglesOf(0, 20, " material=\"first\"", uv), .textured = true}));
  ASSERT_EQ(read.textures.size(), 1U);
  EXPECT_EQ(read.textures[0].path, folder_ / "wood.png");
  ASSERT_EQ(read.material_textures.size(), read.mesh.material_names.size());
  ASSERT_EQ(read.mesh.triangle_materials.size(), 20U);
  for (const std::uint32_t m : read.mesh.triangle_materials) {
    EXPECT_EQ(read.mesh.material_names[m], "red");
    EXPECT_EQ(read.material_textures[m], 0);
  }
  expectTexcoords(read.texture_lookups.empty() ? read.mesh.texcoords : read.texture_lookups, read.mesh,
                  "lookups");
}

TEST_F(ColladaFiles, PolygonsOfAllLists) {
  const std::string head = " count=\"8\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  // Both L-shaped sides, which are concave, and six sides of four corners.
  const std::vector<std::string> polygons = {"5 4 3 2 1 0", "6 7 8 9 10 11", "0 1 7 6",   "1 2 8 7",
                                             "2 3 9 8",     "3 4 10 9",      "4 5 11 10", "5 0 6 11"};
  std::string list = "<polylist" + head + "<vcount>6 6 4 4 4 4 4 4</vcount><p>", each = "<polygons" + head;
  for (const std::string& polygon : polygons) {
    list += polygon + "\n";
    each += "<p>" + polygon + "</p>";
  }
  for (const std::string& primitives : {list + "</p></polylist>", each + "</polygons>"}) {
    for (const char* version : {"1.4.1", "1.5.0"}) {
      const MeshImport read = import(colladaOf({.primitives = primitives}, version));
      expectBracket(read.mesh, primitives + version);
    }
  }
}

TEST_F(ColladaFiles, CutOnesAreErrors) {
  const std::string whole = colladaOf({});
  ASSERT_EQ(errorOf(whole), "no error");
  for (std::size_t size = 0; size + 10 < whole.size(); size += 29)
    EXPECT_NE(errorOf(whole.substr(0, size)), "no error") << size;
  EXPECT_THAT(errorOf(replaced(whole, "<p>2 1 0", "<p>2 1 12")), Not(HasSubstr("no error")));
  EXPECT_THAT(errorOf(replaced(whole, "<p>2 1 0", "<p>2 1 x")), HasSubstr("<p> holds 'x'"));
}

}  // namespace
}  // namespace bakelight::formats
