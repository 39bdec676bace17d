// FBX files as texts and binary: axes, units, transforms, materials by face, colours, texture coordinates.

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/unit/formats/dialects.h"
#include "tests/unit/formats/fbx_maker.h"
#include "tests/unit/formats/painted_bracket.h"

namespace bakelight::formats {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using Nodes = std::vector<FbxNode>;

constexpr FbxEncoding kEncodings[] = {FbxEncoding::kText, FbxEncoding::kBinary7400, FbxEncoding::kBinary7500};
constexpr std::int64_t kGeometry = 100, kModel = 200, kParent = 201, kMaterial = 300, kTexture = 400;

std::string nameOf(FbxEncoding encoding) {
  constexpr const char* kNames[] = {"text", "binary 7400", "binary 7500"};
  return kNames[static_cast<int>(encoding)];
}

class FbxFiles : public DialectTest {
 protected:
  FbxFiles() : DialectTest(".fbx") {}
};

// Right, up and towards the viewer.
struct Axes {
  int right = 0, right_sign = 1, up = 1, up_sign = 1, front = 2, front_sign = 1;
};

struct Scene {
  Axes axes = {};
  double unit = 100;              // in cm; 100 is not worth a note
  Nodes model = {}, parent = {};  // properties
  bool polygons = false, painted = false, colored = false, textured = false;
};

FbxNode property(const std::string& name, const std::string& type, std::vector<FbxValue> values) {
  std::vector<FbxValue> all = {name, type, std::string(), std::string("A")};
  all.insert(all.end(), values.begin(), values.end());
  return {"P", all};
}

FbxNode properties(Nodes children) {
  return {"Properties70", {}, std::move(children)};
}

FbxNode settings(const Scene& scene) {
  const Axes& a = scene.axes;
  Nodes nodes;
  for (const auto& [name, value] :
       std::initializer_list<std::pair<const char*, int>>{{"UpAxis", a.up},
                                                          {"UpAxisSign", a.up_sign},
                                                          {"FrontAxis", a.front},
                                                          {"FrontAxisSign", a.front_sign},
                                                          {"CoordAxis", a.right},
                                                          {"CoordAxisSign", a.right_sign}})
    nodes.push_back(property(name, "int", {std::int32_t{value}}));
  nodes.push_back(property("UnitScaleFactor", "double", {scene.unit}));
  return {"GlobalSettings", {}, {{"Version", {std::int32_t{1000}}}, properties(std::move(nodes))}};
}

FbxNode layerElement(const std::string& name, const std::string& mapping, Nodes values) {
  Nodes children = {{"Version", {std::int32_t{101}}},
                    {"Name", {std::string("layer")}},
                    {"MappingInformationType", {mapping}},
                    {"ReferenceInformationType", {std::string("IndexToDirect")}}};
  children.insert(children.end(), values.begin(), values.end());
  return {name, {std::int32_t{0}}, std::move(children)};
}

// The last index of a polygon is the complement of the vertex's number.
std::vector<std::int32_t> cornersOf(bool polygons) {
  if (polygons)
    return {5, 4,  3, 2, 1, -1, 6, 7, 8,  9,   10, -12, 0,  1,   7, -7, 1, 2,
            8, -8, 2, 3, 9, -9, 3, 4, 10, -10, 4,  5,   11, -11, 5, 0,  6, -12};
  std::vector<std::int32_t> corners;
  for (const Triangle& t : bracket().triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::int32_t>(t[k]);
      corners.push_back(k == 2 ? ~v : v);
    }
  return corners;
}

FbxNode geometry(const Scene& scene) {
  std::vector<double> positions, texcoords, colors;
  for (const Float3& p : bracket().positions) {
    positions.insert(positions.end(), p.begin(), p.end());
    const Float2 t = texcoordAt(p);
    texcoords.insert(texcoords.end(), t.begin(), t.end());
    const Float3 color = vertexColorAt(p);
    colors.insert(colors.end(), {color[0], color[1], color[2], 1});
  }
  const std::vector<std::int32_t> corners = cornersOf(scene.polygons);
  std::vector<std::int32_t> vertices, materials;
  for (const std::int32_t corner : corners) vertices.push_back(corner < 0 ? ~corner : corner);
  for (std::size_t t = 0; t < 20; ++t) materials.push_back(static_cast<std::int32_t>(paintOf(t)));
  Nodes children = {{"Vertices", {positions}}, {"PolygonVertexIndex", {corners}}};
  Nodes layer = {{"Version", {std::int32_t{100}}}};
  const auto add = [&](FbxNode element) {
    layer.push_back({"LayerElement", {}, {{"Type", {element.name}}, {"TypedIndex", {std::int32_t{0}}}}});
    children.push_back(std::move(element));
  };
  if (scene.painted) add(layerElement("LayerElementMaterial", "ByPolygon", {{"Materials", {materials}}}));
  if (scene.textured)
    add(layerElement("LayerElementMaterial", "AllSame", {{"Materials", {std::vector<std::int32_t>{0}}}}));
  if (scene.colored || scene.textured)
    add(layerElement("LayerElementUV", "ByPolygonVertex", {{"UV", {texcoords}}, {"UVIndex", {vertices}}}));
  if (scene.colored)
    add(layerElement("LayerElementColor", "ByPolygonVertex",
                     {{"Colors", {colors}}, {"ColorIndex", {vertices}}}));
  children.push_back({"Layer", {std::int32_t{0}}, std::move(layer)});
  return {"Geometry", {kGeometry, FbxName{"Geometry", "body"}, std::string("Mesh")}, std::move(children)};
}

FbxNode model(std::int64_t id, const std::string& kind, Nodes moved) {
  return {"Model",
          {id, FbxName{"Model", "model " + std::to_string(id)}, kind},
          {{"Version", {std::int32_t{232}}}, properties(std::move(moved))}};
}

FbxNode link(std::int64_t child, std::int64_t parent) {
  return {"C", {std::string("OO"), child, parent}};
}

std::vector<FbxNode> sceneOf(const Scene& scene) {
  Nodes objects = {geometry(scene), model(kModel, "Mesh", scene.model)},
        links = {link(kGeometry, kModel), link(kModel, scene.parent.empty() ? 0 : kParent)};
  if (!scene.parent.empty()) {
    objects.push_back(model(kParent, "Null", scene.parent));
    links.push_back(link(kParent, 0));
  }
  for (std::size_t m = 0; (scene.painted || scene.textured) && m < 2; ++m) {
    const auto id = kMaterial + static_cast<std::int64_t>(m);
    const Float3& paint = kPaints[m];
    objects.push_back({"Material",
                       {id, FbxName{"Material", kPaintNames[m]}, std::string()},
                       {{"ShadingModel", {std::string("lambert")}},
                        properties({property("DiffuseColor", "Color",
                                             {double{paint[0]}, double{paint[1]}, double{paint[2]}}),
                                    property("DiffuseFactor", "Number", {1.0})})}});
    links.push_back(link(id, kModel));
  }
  if (scene.textured) {
    objects.push_back({"Texture",
                       {kTexture, FbxName{"Texture", "wood"}, std::string()},
                       {{"FileName", {std::string("C:\\\\elsewhere\\\\wood.png")}},
                        {"RelativeFilename", {std::string("wood.png")}}}});
    links.push_back({"C", {std::string("OP"), kTexture, kMaterial, std::string("DiffuseColor")}});
  }
  return {{"FBXHeaderExtension",
           {},
           {{"FBXHeaderVersion", {std::int32_t{1003}}}, {"FBXVersion", {std::int32_t{7400}}}}},
          settings(scene),
          {"Objects", {}, std::move(objects)},
          {"Connections", {}, std::move(links)}};
}

Nodes moves(const char* name, double x, double y, double z) {
  return {property(name, name, {x, y, z})};
}

TEST_F(FbxFiles, AxesAndUnits) {
  struct Case {
    const char* what;
    Axes axes;
    Float3 (*moved)(const Float3&);
    const char* note;
  };
  for (const Case& c : std::initializer_list<Case>{{"+Y up", {}, [](const Float3& p) { return p; }, nullptr},
                                                   {"+Z up, as 3ds Max has it",
                                                    {0, 1, 2, 1, 1, -1},
                                                    [](const Float3& p) {
                                                      return Float3{p[0], p[2], -p[1]};
                                                    },
                                                    "+Z up"},
                                                   {"+X up",
                                                    {1, -1, 0, 1, 2, 1},
                                                    [](const Float3& p) {
                                                      return Float3{-p[1], p[0], p[2]};
                                                    },
                                                    "+X up"},
                                                   {"−Y up",
                                                    {0, -1, 1, -1, 2, 1},
                                                    [](const Float3& p) {
                                                      return Float3{-p[0], -p[1], p[2]};
                                                    },
                                                    "−Y up"},
                                                   {"+Y up, to +X",
                                                    {2, -1, 1, 1, 0, 1},
                                                    [](const Float3& p) {
                                                      return Float3{-p[2], p[1], p[0]};
                                                    },
                                                    "another way"}})
    for (const FbxEncoding encoding : kEncodings) {
      const MeshImport read = import(fbxFile(sceneOf({.axes = c.axes}), encoding));
      expectMovedBracket(read.mesh, c.moved, 1, c.what + (", " + nameOf(encoding)));
      if (c.note == nullptr)
        EXPECT_THAT(read.notes, IsEmpty()) << c.what << ", " << nameOf(encoding);
      else
        EXPECT_THAT(read.notes, Contains(HasSubstr(c.note))) << c.what << ", " << nameOf(encoding);
    }
  for (const FbxEncoding encoding : kEncodings)
    for (const auto& [unit, note] : std::initializer_list<std::pair<double, const char*>>{
             {1, "of 1 cm"}, {2.54, "of 2.54 cm"}, {0.1, "of 0.1 cm"}}) {
      const MeshImport read = import(fbxFile(sceneOf({.unit = unit}), encoding));
      expectBracket(read.mesh, nameOf(encoding));
      EXPECT_THAT(read.notes, Contains(HasSubstr(note))) << nameOf(encoding);
    }
}

TEST(FbxCases, ZUpIsTurnedUpright) {
  const MeshImport import =
      importMesh(std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/cases/fbx/z_up.fbx");
  const BodyFigures figures = figuresOf(import.mesh);
  EXPECT_EQ(import.mesh.triangleCount(), 20U);
  EXPECT_NEAR(figures.area, 18, 1e-9);
  EXPECT_NEAR(figures.volume, 4, 1e-9);
  EXPECT_EQ(figures.low, (Float3{0, 0, -2}));
  EXPECT_EQ(figures.high, (Float3{3, 1, 0}));
  EXPECT_THAT(import.notes, Contains(HasSubstr("+Z up: turned to +Y up")));
}

TEST_F(FbxFiles, TransformsInTheirOrderAndChained) {
  // First twice as large, then a quarter turn about z, then moved.
  const auto moved = [](const Float3& p) { return Float3{5 - 2 * p[1], 6 + 2 * p[0], 7 + 2 * p[2]}; };
  const Nodes move = moves("Lcl Translation", 5, 6, 7), turn = moves("Lcl Rotation", 0, 0, 90),
              grow = moves("Lcl Scaling", 2, 2, 2);
  const Nodes turn_and_grow = {turn[0], grow[0]}, all = {move[0], turn[0], grow[0]};
  const Nodes geometric = {move[0], turn[0], property("GeometricScaling", "Vector3D", {2.0, 2.0, 2.0})};
  // About (1, 0, 0), which stays where it is.
  const Nodes pivot = {moves("Lcl Translation", 3, 6, 7)[0],
                       property("RotationPivot", "Vector3D", {1.0, 2.0, 3.0}), turn[0],
                       property("ScalingPivot", "Vector3D", {0.0, 0.0, 0.0}), grow[0]};
  for (const FbxEncoding encoding : kEncodings) {
    const std::string what = nameOf(encoding);
    expectMovedBracket(import(fbxFile(sceneOf({.model = all}), encoding)).mesh, moved, 2, what);
    expectMovedBracket(import(fbxFile(sceneOf({.model = turn_and_grow, .parent = move}), encoding)).mesh,
                       moved, 2, what + ", by a parent");
    expectMovedBracket(import(fbxFile(sceneOf({.model = geometric}), encoding)).mesh, moved, 2,
                       what + ", geometric");
    // p + R (2 p' − p) with the pivot p
    expectMovedBracket(
        import(fbxFile(sceneOf({.model = pivot}), encoding)).mesh,
        [](const Float3& p) {
          return Float3{3 + 1 - (2 * p[1] - 2), 6 + 2 + (2 * p[0] - 1), 7 + 2 * p[2]};
        },
        2, what + ", about a pivot");
    const MeshImport upright =
        import(fbxFile(sceneOf({.axes = {0, 1, 2, 1, 1, -1}, .model = all}), encoding));
    expectMovedBracket(
        upright.mesh,
        [&](const Float3& p) {
          const Float3 q = moved(p);
          return Float3{q[0], q[2], -q[1]};
        },
        2, what + ", transform and axes");
    const MeshImport mirrored = import(fbxFile(sceneOf({.model = moves("Lcl Scaling", -1, 1, 1)}), encoding));
    expectMovedBracket(
        mirrored.mesh,
        [](const Float3& p) {
          return Float3{-p[0], p[1], p[2]};
        },
        1, what + ", mirrored", true);
    EXPECT_THAT(mirrored.notes, Contains(HasSubstr("mirrored"))) << what;
  }
}

TEST_F(FbxFiles, MaterialsByFace) {
  for (const FbxEncoding encoding : kEncodings) {
    const MeshImport read = import(fbxFile(sceneOf({.painted = true}), encoding));
    expectMovedBracket(
        read.mesh, [](const Float3& p) { return p; }, 1, nameOf(encoding));
    expectPaints(read, nameOf(encoding));
  }
}

TEST_F(FbxFiles, ColorsAndTextureCoordinatesOfCorners) {
  for (const FbxEncoding encoding : kEncodings) {
    const MeshImport read = import(fbxFile(sceneOf({.colored = true}), encoding));
    expectMovedBracket(
        read.mesh, [](const Float3& p) { return p; }, 1, nameOf(encoding));
    expectTexcoords(read.mesh.texcoords, read.mesh, nameOf(encoding));
    ASSERT_EQ(read.mesh.colors.size(), read.mesh.positions.size()) << nameOf(encoding);
    for (std::size_t v = 0; v < read.mesh.colors.size(); ++v)
      EXPECT_EQ(read.mesh.colors[v], vertexColorAt(read.mesh.positions[v])) << nameOf(encoding);
  }
}

TEST_F(FbxFiles, PicturesOfMaterials) {
  write("wood.png", "no picture, only its name counts here");
  for (const FbxEncoding encoding : kEncodings) {
    const MeshImport read = import(fbxFile(sceneOf({.textured = true}), encoding));
    ASSERT_EQ(read.textures.size(), 1U) << nameOf(encoding);
    EXPECT_EQ(read.textures[0].path, folder_ / "wood.png") << nameOf(encoding);
    ASSERT_EQ(read.mesh.triangle_materials.size(), 20U) << nameOf(encoding);
    for (const std::uint32_t m : read.mesh.triangle_materials) {
      EXPECT_EQ(read.mesh.material_names.at(m), "red");
      EXPECT_EQ(read.material_textures.at(m), 0);
    }
    expectTexcoords(read.texture_lookups.empty() ? read.mesh.texcoords : read.texture_lookups, read.mesh,
                    nameOf(encoding));
  }
}

TEST_F(FbxFiles, Polygons) {
  for (const FbxEncoding encoding : kEncodings)
    expectBracket(import(fbxFile(sceneOf({.polygons = true}), encoding)).mesh, nameOf(encoding));
}

TEST_F(FbxFiles, CutOnesAreErrors) {
  for (const FbxEncoding encoding : kEncodings) {
    const std::string whole = fbxFile(sceneOf({}), encoding);
    ASSERT_EQ(errorOf(whole), "no error");
    for (std::size_t size = 0; size + 40 < whole.size(); size += 61)
      EXPECT_NE(errorOf(whole.substr(0, size)), "no error") << nameOf(encoding) << " " << size;
  }
}

}  // namespace
}  // namespace bakelight::formats
