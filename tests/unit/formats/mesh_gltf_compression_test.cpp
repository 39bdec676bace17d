// glTF: geometry packed by Draco and meshoptimizer.

#include <gmock/gmock.h>

#include "formats/draco_mesh.h"
#include "tests/unit/formats/gltf_reading.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

TEST(GltfCompression, DracoWithOtherAttributesBeside) {
  GltfMaker file = bracketFile();
  TriangleMesh source = bracket();
  source.texcoords.assign(12, {0.25F, 0.75F});
  const DracoMesh packed = encodeDraco(source, 0, 0, "a");
  file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const std::string bytes(reinterpret_cast<const char*>(packed.bytes.data()), packed.bytes.size());
  file.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", file.view(bytes)},
      {"attributes", {{"POSITION", packed.attributes.position}, {"TEXCOORD_0", packed.attributes.texcoord}}}};
  file.attribute("TEXCOORD_0", file.accessor(std::vector<float>(24, 0), "VEC2"));
  file.attribute("COLOR_0", file.accessor(std::vector<float>(36, 0.5F), "VEC3"));
  const TriangleMesh mesh = read(file).mesh;
  expectBracket(mesh, "Draco");
  EXPECT_EQ(mesh.texcoords[7], (Float2{0.25F, 0.25F}));
  EXPECT_EQ(mesh.colors[7], (Float3{0.5F, 0.5F, 0.5F}));
}

TEST(GltfCompression, Meshopt) {
  expectBracket(read(meshoptFile().glb()).mesh, "meshopt");
  GltfMaker file = meshoptFile();
  auto& packed = file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  packed["count"] = 4000000000U;
  EXPECT_THAT(errorOf(file.glb()), HasSubstr("/bufferViews/0/extensions/EXT_meshopt_compression/count"));
  packed["count"] = 12;
  packed["filter"] = "QUATERNION";
  EXPECT_THAT(errorOf(file.glb()), HasSubstr("filter QUATERNION"));
  packed["filter"] = "NONE";
  packed["byteLength"] = 20;
  EXPECT_THAT(errorOf(file.glb()), HasSubstr("meshoptimizer cannot decode it"));
}

}  // namespace
}  // namespace bakelight::formats
