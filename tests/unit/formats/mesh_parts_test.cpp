#include "formats/mesh_parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A unit square of two triangles that share the edge from 0 to 2.
MeshPart square(float z = 0) {
  MeshPart part;
  part.positions = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
  part.triangles = {{0, 1, 2}, {0, 2, 3}};
  return part;
}

MeshParts partsOf(std::vector<MeshPart> parts, std::vector<PartMaterial> materials = {}) {
  return {std::move(parts), std::move(materials), {}, {}};
}

AlbedoTexture picture(const std::string& name) {
  return {.name = name, .path = name};
}

std::string errorOf(MeshParts parts) {
  try {
    merged(std::move(parts), "a.gltf");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

TEST(MeshPartsTest, PartsFollowEachOther) {
  MeshPart points = square();
  points.triangles.clear();
  const MeshImport read = merged(partsOf({square(0), points, square(5)}), "a");
  EXPECT_EQ(read.mesh.vertexCount(), 8U) << "a part without triangles counts for nothing";
  EXPECT_THAT(read.mesh.triangles,
              ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}, Triangle{4, 5, 6}, Triangle{4, 6, 7}));
  EXPECT_EQ(read.mesh.positions[4], (Float3{0, 0, 5}));
  EXPECT_THAT(read.notes, ElementsAre("2 parts were merged"));
  EXPECT_THAT(read.mesh.triangle_materials, IsEmpty());
  EXPECT_THAT(read.mesh.material_names, IsEmpty());
  EXPECT_THAT(read.mesh.colors, IsEmpty());
  EXPECT_THAT(read.texture_lookups, IsEmpty());
}

TEST(MeshPartsTest, NoTriangleIsAnError) {
  EXPECT_THAT(errorOf({}), AllOf(HasSubstr("a.gltf"), HasSubstr("no triangle")));
  MeshPart points = square();
  points.triangles.clear();
  EXPECT_THAT(errorOf(partsOf({points})), HasSubstr("no triangle"));
}

TEST(MeshPartsTest, VerticesAtABorderOfMaterialsAreCopied) {
  MeshPart part = square();
  part.colors = {{0.5F, 1, 1}, {1, 1, 1}, {1, 1, 0.5F}, {1, 1, 1}};
  part.triangle_materials = {1, 0};
  const MeshImport read =
      merged(partsOf({part}, {{"blue", Float3{0, 0, 1}, -1}, {"red", Float3{1, 0, 0}, -1}}), "a");
  const TriangleMesh& mesh = read.mesh;
  EXPECT_THAT(mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{4, 5, 3}));
  EXPECT_EQ(mesh.positions[4], mesh.positions[0]);
  EXPECT_EQ(mesh.positions[5], mesh.positions[2]);
  EXPECT_THAT(mesh.triangle_materials, ElementsAre(1U, 0U));
  EXPECT_THAT(mesh.material_names, ElementsAre("blue", "red"));
  EXPECT_THAT(mesh.colors, ElementsAre(Float3{0.5F, 0, 0}, Float3{1, 0, 0}, Float3{1, 0, 0}, Float3{0, 0, 1},
                                       Float3{0, 0, 1}, Float3{0, 0, 0.5F}));
  EXPECT_THAT(read.notes, IsEmpty());
}

TEST(MeshPartsTest, TrianglesWithoutMaterialGetANamelessOneIfOthersHaveOne) {
  MeshPart with = square();
  with.material = 1;
  const MeshImport read = merged(partsOf({square(), with}, {{"idle", {}, -1}, {"used", {}, -1}}), "a");
  EXPECT_THAT(read.mesh.triangle_materials, ElementsAre(2U, 2U, 1U, 1U));
  EXPECT_THAT(read.mesh.material_names, ElementsAre("idle", "used", ""));
  EXPECT_THAT(read.mesh.colors, IsEmpty()) << "no material has a colour";
  const MeshImport without = merged(partsOf({square()}, {{"idle", Float3{1, 0, 0}, -1}}), "a");
  EXPECT_THAT(without.mesh.material_names, IsEmpty());
  EXPECT_THAT(without.mesh.colors, IsEmpty()) << "no triangle has the colour";
}

TEST(MeshPartsTest, MissingColorsAreWhiteAndNoted) {
  MeshPart red = square(), painted = square(), plain = square(), textured = square();
  red.material = 0, textured.material = 1;
  painted.colors.assign(4, {0.25F, 0.5F, 0.75F});
  textured.texcoords.assign(4, {0.5F, 0.5F});
  MeshParts parts = partsOf({red, painted, plain, textured}, {{"red", Float3{1, 0, 0}, -1}, {"map", {}, 0}});
  parts.textures = {picture("a.png")};
  const MeshImport read = merged(std::move(parts), "a");
  EXPECT_EQ(read.mesh.colors[0], (Float3{1, 0, 0}));
  EXPECT_EQ(read.mesh.colors[4], (Float3{0.25F, 0.5F, 0.75F}));
  EXPECT_EQ(read.mesh.colors[8], (Float3{1, 1, 1}));
  EXPECT_EQ(read.mesh.colors[12], (Float3{1, 1, 1})) << "the texture is its colour";
  EXPECT_THAT(read.notes, Contains(AllOf(HasSubstr("4 vertices"), HasSubstr("white"))));
}

TEST(MeshPartsTest, ColorsOutsideTheRangeAreClampedAndNoted) {
  MeshPart part = square();
  part.material = 0;
  part.colors = {{2, 0.5F, -1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  const MeshImport read = merged(partsOf({part}, {{"bright", Float3{0.5F, 3, 1}, -1}}), "a");
  EXPECT_EQ(read.mesh.colors[0], (Float3{0.5F, 0.5F, 0}));
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("1 vertex colour was outside"),
                                      HasSubstr("the colour of 1 material was outside")));
}

TEST(MeshPartsTest, ColorsThatAreNotFiniteAreLeftOutAndNoted) {
  MeshPart part = square();
  part.colors = {{kNan, 0, 0}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  MeshImport read = merged(partsOf({part}), "a");
  EXPECT_THAT(read.mesh.colors, IsEmpty());
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("vertex colours were left out: 1 of them")));
  part.material = 0;
  read = merged(partsOf({part}, {{"red", Float3{1, 0, 0}, -1}}), "a");
  EXPECT_EQ(read.mesh.colors[0], (Float3{1, 0, 0})) << "the material's own colour stays";
  part.colors.clear();
  read = merged(partsOf({part}, {{"none", Float3{1, kNan, 0}, -1}}), "a");
  EXPECT_THAT(read.mesh.colors, IsEmpty());
  EXPECT_THAT(read.notes, ElementsAre(HasSubstr("it is not finite")));
}

TEST(MeshPartsTest, NormalsAreMadeUnitLength) {
  MeshPart part = square();
  part.normals = {{0, 3, 4}, {0, 0, -1e30F}, {1e-30F, 0, 0}, {1, 0, 0}};
  const MeshImport read = merged(partsOf({part}), "a");
  EXPECT_THAT(read.mesh.normals,
              ElementsAre(Float3{0, 0.6F, 0.8F}, Float3{0, 0, -1}, Float3{1, 0, 0}, Float3{1, 0, 0}));
}

TEST(MeshPartsTest, AttributesOfSomeVerticesAreLeftOutAndNoted) {
  MeshPart part = square();
  part.normals.assign(4, {0, 0, 1});
  part.texcoords.assign(4, {0, 0});
  MeshImport read = merged(partsOf({part, square()}), "a");
  EXPECT_THAT(read.mesh.normals, IsEmpty());
  EXPECT_THAT(read.mesh.texcoords, IsEmpty());
  EXPECT_THAT(read.notes, Contains(HasSubstr("normals were left out: 1 of 2 parts have none")));
  EXPECT_THAT(read.notes, Contains(HasSubstr("texture coordinates were left out: 1 of 2 parts have none")));
  part.normals[2] = {0, 0, 0};
  part.texcoords[1][0] = kNan;
  read = merged(partsOf({part}), "a");
  EXPECT_THAT(read.mesh.normals, IsEmpty());
  EXPECT_THAT(read.mesh.texcoords, IsEmpty());
  EXPECT_THAT(read.notes, Contains(HasSubstr("normals were left out: 1 of them have no direction")));
  EXPECT_THAT(read.notes, Contains(HasSubstr("1 of them are not finite")));
}

TEST(MeshPartsTest, TexturesAreLookedUpWhereTheirMaterialSays) {
  MeshPart first = square(), second = square();
  first.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  first.triangle_materials = {2, 0};
  second.material = 3;
  second.texture_lookups.assign(4, {7, 8});
  MeshParts parts =
      partsOf({first, second}, {{"plain", {}, -1}, {"idle", {}, 0}, {"a", {}, 2}, {"b", {}, 1}});
  parts.textures = {picture("idle.png"), picture("b.png"), picture("a.png")};
  const MeshImport read = merged(std::move(parts), "x");
  ASSERT_EQ(read.textures.size(), 2U) << "one belongs to no triangle";
  EXPECT_EQ(read.textures[0].name, "a.png");
  EXPECT_EQ(read.textures[1].name, "b.png");
  EXPECT_THAT(read.material_textures, ElementsAre(-1, -1, 0, 1));
  const Triangle &a = read.mesh.triangles[0], &plain = read.mesh.triangles[1], &b = read.mesh.triangles[2];
  EXPECT_EQ(read.texture_lookups[a[2]], (Float2{1, 1}));
  EXPECT_EQ(read.texture_lookups[plain[1]], (Float2{0, 0}));
  EXPECT_EQ(read.texture_lookups[b[0]], (Float2{7, 8}));
  EXPECT_EQ(read.texture_lookups.size(), read.mesh.vertexCount());
}

TEST(MeshPartsTest, ATextureWithoutCoordinatesIsAnError) {
  MeshPart part = square();
  part.material = 0;
  MeshParts parts = partsOf({part}, {{"bark", {}, 0}});
  parts.textures = {picture("bark.png")};
  EXPECT_THAT(errorOf(parts),
              AllOf(HasSubstr("material 'bark'"), HasSubstr("bark.png"), HasSubstr("unwrap")));
  parts.parts[0].texture_lookups.assign(4, {0, kNan});
  EXPECT_THAT(errorOf(parts), AllOf(HasSubstr("material 'bark'"), HasSubstr("not finite")));
}

}  // namespace
}  // namespace bakelight::formats
