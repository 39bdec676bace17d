// Whole glTF files.

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/unit/formats/gltf_reading.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

const std::filesystem::path kCases = std::filesystem::path(BAKELIGHT_SOURCE_DIR) / "tests/cases/gltf";
TEST(MeshGltfTest, TheBracketTextAndBinary) {
  for (const std::string& content :
       {bracketFile().text(), bracketFile().glb(), "\xEF\xBB\xBF" + bracketFile().text()}) {
    const MeshImport import = read(content);
    expectSameTriangles(import.mesh, bracket(), content.substr(0, 4));
    EXPECT_THAT(import.notes, IsEmpty());
    EXPECT_THAT(import.mesh.colors, IsEmpty());
    EXPECT_THAT(import.mesh.normals, IsEmpty());
    EXPECT_THAT(import.mesh.material_names, IsEmpty());
  }
}

TEST(MeshGltfTest, FilesThatOtherReadersGotWrong) {
  for (const char* name :
       {"quantized.gltf", "skin_scaled_node.gltf", "uv_ushort.gltf", "uri_space/my model.gltf",
        "texture_transform/moved.gltf", "base_colour_factor.gltf"}) {
    const TriangleMesh mesh = importMesh(kCases / name).mesh;
    const BodyFigures figures = figuresOf(mesh);
    EXPECT_EQ(mesh.triangleCount(), 20U) << name;
    EXPECT_NEAR(figures.area, 18, 2e-3) << name;
    EXPECT_NEAR(figures.volume, 4, 2e-3) << name;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(figures.high[k], 3 - static_cast<float>(k), 2e-4F) << name;
  }
  EXPECT_EQ(figuresOf(importMesh(kCases / "morph_default_weight.gltf").mesh).high, (Float3{3, 4, 1}));
  EXPECT_EQ(importMesh(kCases / "gpu_instancing.gltf").mesh.triangleCount(), 60U);
  const TriangleMesh unwrapped = importMesh(kCases / "uv_ushort.gltf").mesh;
  for (std::size_t i = 0; i < unwrapped.vertexCount(); ++i)
    EXPECT_NEAR(unwrapped.texcoords.at(i)[0], unwrapped.positions[i][0] / 3, 1e-5F);
  const MeshImport moved = importMesh(kCases / "texture_transform/moved.gltf");
  ASSERT_EQ(moved.textures.size(), 1U);
  EXPECT_TRUE(std::filesystem::exists(moved.textures[0].path));
  for (std::size_t i = 0; i < moved.mesh.vertexCount(); ++i)
    EXPECT_NEAR(moved.texture_lookups.at(i)[0], moved.mesh.texcoords.at(i)[0] + 0.5F, 1e-6F);
  EXPECT_EQ(importMesh(kCases / "base_colour_factor.gltf").mesh.colors.size(), 12U);
  // Its Draco data are a header and zeros: an empty point cloud.
  try {
    importMesh(kCases / "draco_required.glb");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("KHR_draco_mesh_compression"), HasSubstr("not a mesh")));
  }
}

}  // namespace
}  // namespace bakelight::formats
