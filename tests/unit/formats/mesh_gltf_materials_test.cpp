// glTF: materials and their pictures.

#include <gmock/gmock.h>

#include "tests/unit/formats/gltf_reading.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(GltfMaterialsTest, MaterialsAndTheirPictures) {
  GltfMaker file = bracketFile();
  file.attribute("TEXCOORD_1", file.accessor(std::vector<float>{0.5F, 0.25F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                                                0,    0,     0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
                                             "VEC2"));
  file.json["materials"] =
      Json::parse(R"([{"name": "idle", "pbrMetallicRoughness": {"baseColorTexture": {"index": 99}}},
    {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 2, 0.5], "baseColorTexture": {"index": 0, "texCoord": 7,
      "extensions": {"KHR_texture_transform": {"texCoord": 1, "offset": [0, 1], "rotation": 1.5707963267948966,
      "scale": [0.5, 0.5]}}}}, "alphaMode": "BLEND"}])");
  file.json["textures"] = Json::parse(R"([{"source": 0, "sampler": 0}])");
  file.json["samplers"] = Json::parse(R"([{"wrapS": 33071, "wrapT": 33648}])");
  file.json["images"] = {{{"bufferView", file.view("\x89PNG")}, {"mimeType", "image/png"}, {"name", "skin"}}};
  file.primitive()["material"] = 1;
  const MeshImport import = read(file);
  EXPECT_THAT(import.mesh.material_names, ElementsAre("idle", "material_1"));
  EXPECT_THAT(import.mesh.triangle_materials, testing::Each(1U));
  EXPECT_EQ(import.mesh.colors[3], (Float3{0.5F, 0.25F, 1}));
  EXPECT_THAT(import.material_textures, ElementsAre(-1, 0));
  ASSERT_EQ(import.textures.size(), 1U);
  EXPECT_EQ(import.textures[0].bytes, bytesOf("\x89PNG"));
  EXPECT_EQ(import.textures[0].name, "a.gltf, image 0 (skin)");
  EXPECT_EQ(import.textures[0].wrap_u, AlbedoTexture::Wrap::kClamp);
  EXPECT_EQ(import.textures[0].wrap_v, AlbedoTexture::Wrap::kMirror);
  // The lower left quarter of the picture, turned clockwise: (0.5, 0.25) → (0.125, 0.75), from the top.
  EXPECT_NEAR(import.texture_lookups[0][0], 0.125F, 1e-6F);
  EXPECT_NEAR(import.texture_lookups[0][1], 0.25F, 1e-6F);
  EXPECT_THAT(import.notes, Contains(HasSubstr("baked as opaque: material_1")));
}

TEST(GltfMaterialsTest, TheOlderMaterialModelAndOtherPictureFormats) {
  GltfMaker file = bracketFile();
  file.attribute("TEXCOORD_0", file.accessor(std::vector<float>(24, 0), "VEC2"));
  file.json["materials"] = Json::parse(R"([{"extensions": {"KHR_materials_pbrSpecularGlossiness": {
    "diffuseFactor": [0.5, 0.5, 0.5, 1], "diffuseTexture": {"index": 0}}},
    "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}])");
  file.json["textures"] =
      Json::parse(R"([{"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}}])");
  file.json["images"] = Json::parse(R"([{"uri": "data:image/ktx2,x"}, {"uri": "data:image/jpeg,x%20y"}])");
  file.primitive()["material"] = 0;
  const MeshImport import = read(file);
  EXPECT_EQ(import.mesh.colors[0], (Float3{0.5F, 0.5F, 0.5F}));
  EXPECT_EQ(import.textures.at(0).bytes, bytesOf("x y"));
  file.json["textures"][0].erase("source");
  EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr("/images/0"), HasSubstr("KTX2")));
  file.json["textures"][0] = {{"extensions", {{"EXT_texture_webp", {{"source", 1}}}}}};
  EXPECT_EQ(read(file).textures.size(), 1U);
}

}  // namespace
}  // namespace bakelight::formats
