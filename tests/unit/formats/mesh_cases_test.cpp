// Small files that importers get wrong, with what is right.

#include <gmock/gmock.h>

#include <filesystem>

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "tests/unit/formats/bracket.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

const std::filesystem::path kCases = std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/cases";

std::string errorOfCase(const char* name) {
  try {
    importMesh(kCases / name);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(MeshCases, BodiesAreWhole) {
  for (const char* name :
       {"colours/shape.OBJ", "colours/r_g_b.ply", "ply/tristrips.ply", "ply/element_between.ply",
        "ply/element_before.ply", "off/comment_between_faces.off", "obj/bom.obj",
        "obj/comment_after_face.obj", "obj/face_of_two.obj", "obj/mtl_colours/box.obj",
        "stl/binary_solid_facet.stl", "stl/upper_case.stl"})
    expectBracket(importMesh(kCases / name).mesh, name);
}

TEST(MeshCases, ErrorsSayWhatIsTrue) {
  struct Case {
    const char* name;
    std::vector<const char*> parts;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"off/index_out_of_range.off", {"face 19", "line 34", "vertex 77 does not exist", "0 to 11"}},
           {"obj/nan_sixth_vertex.obj", {"line 6", "vertex 6 (counted from 1)", "not finite"}},
           {"obj/lfs_pointer.obj", {"pointer of Git LFS", "git lfs pull"}}}) {
    const std::string error = errorOfCase(c.name);
    for (const char* part : c.parts) EXPECT_THAT(error, HasSubstr(part)) << c.name;
    EXPECT_THAT(error, testing::Not(HasSubstr("cut short"))) << c.name;
  }
}

TEST(MeshCases, DisplayCodesBecomeLight) {
  for (const auto& [name, linear] : std::initializer_list<std::pair<const char*, float>>{
           {"colours/shape.OBJ", 0.21404114F}, {"colours/r_g_b.ply", 0.21586050F}}) {
    const TriangleMesh mesh = importMesh(kCases / name).mesh;
    ASSERT_EQ(mesh.colors.size(), mesh.positions.size()) << name;
    for (const Float3& color : mesh.colors)
      for (const float value : color) EXPECT_NEAR(value, linear, 1e-6F) << name;
  }
}

TEST(MeshCases, AFaceOfTwoCornersIsNoted) {
  EXPECT_THAT(importMesh(kCases / "obj/face_of_two.obj").notes,
              testing::ElementsAre(testing::AllOf(HasSubstr("fewer than 3 corners"), HasSubstr("line 33"))));
}

TEST(MeshCases, FacesHaveTheColorsOfTheirMaterials) {
  const TriangleMesh mesh = importMesh(kCases / "obj/mtl_colours/box.obj").mesh;
  ASSERT_EQ(mesh.material_names, (std::vector<std::string>{"red", "green"}));
  ASSERT_EQ(mesh.triangle_materials.size(), 20U);
  for (std::size_t t = 0; t < 20; ++t) {
    EXPECT_EQ(mesh.triangle_materials[t], t < 10 ? 0U : 1U) << t;
    for (const std::uint32_t vertex : mesh.triangles[t])
      EXPECT_EQ(mesh.colors[vertex], t < 10 ? (Float3{0.8F, 0.05F, 0.05F}) : (Float3{0.05F, 0.8F, 0.05F}))
          << t;
  }
}

TEST(MeshCases, TextureCoordinatesOfFaceCornersAreKept) {
  const MeshImport read = importMesh(kCases / "ply/wedge/cube.ply");
  const TriangleMesh& mesh = read.mesh;
  ASSERT_EQ(mesh.triangles.size(), 12U);
  ASSERT_EQ(mesh.texcoords.size(), mesh.positions.size());
  ASSERT_EQ(read.textures.size(), 1U);
  EXPECT_EQ(read.textures[0].path.filename(), "tex.png");
  EXPECT_EQ(read.material_textures, std::vector<int>{0});
  EXPECT_EQ(read.texture_lookups, mesh.texcoords);
  // Sides along x, y and z lie in the first, second and third of three columns.
  for (std::size_t t = 0; t < 12; ++t)
    for (const std::uint32_t vertex : mesh.triangles[t]) {
      const float u = mesh.texcoords[vertex][0];
      EXPECT_EQ(static_cast<std::size_t>(u * 3), t / 4) << t;
    }
}

}  // namespace
}  // namespace bakelight::formats
