// A picture that a material names and that is not there: a note with the same words in every format, and the
// material's own colour.

#include <gmock/gmock.h>

#include "formats/mesh_import.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

constexpr const char* kPly =
    "ply\nformat ascii 1.0\ncomment TextureFile none.png\nelement vertex 3\nproperty float x\nproperty float "
    "y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\nproperty list uchar int "
    "vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";

constexpr const char* kGltf =
    R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
  "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
  "materials":[{"name":"paint","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"baseColorTexture":{"index":0}}}],
  "textures":[{"source":0}],"images":[{"uri":"none.png"}],
  "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
  "bufferViews":[{"buffer":0,"byteLength":36}],
  "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

std::string colladaTriangle() {
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Y_UP</up_axis></asset><library_images><image id="i"><init_from>none.png</init_from></image></library_images>
<library_effects><effect id="fx"><profile_COMMON><newparam sid="f"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="s"><sampler2D><source>f</source></sampler2D></newparam><technique sid="common"><lambert><diffuse>
<texture texture="s" texcoord="UV"/></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="paint"><instance_effect url="#fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array>
<technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/>
</vertices><triangles count="1" material="y"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh>
</geometry></library_geometries><library_visual_scenes><visual_scene id="c"><node><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="y" target="#m"/></technique_common></bind_material></instance_geometry></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#c"/></scene></COLLADA>)";
}

TEST(MissingPictures, AreNotedAlikeInEveryFormat) {
  const ScratchFolder folder;
  writeQuickly(folder / "a.mtl", "newmtl paint\nKd 0.5 0.25 1\nmap_Kd none.png\n");
  struct Case {
    const char *name, *place, *material, *color;
    std::string text;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"a.obj", "a.mtl, line 3", "'paint'", "(0.5, 0.25, 1) alone",
            "mtllib a.mtl\nusemtl paint\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"},
           {"a.ply", "a.ply", "'none.png'", "no colour of its own", kPly},
           {"a.gltf", "/images/0", "'paint'", "(0.5, 0.25, 1) alone", kGltf},
           {"a.dae", "a.dae", "'paint'", "alone", colladaTriangle()}}) {
    writeQuickly(folder / c.name, c.text);
    const MeshImport read = importMesh(folder / c.name);
    EXPECT_EQ(read.mesh.triangleCount(), 1U) << c.name;
    EXPECT_TRUE(read.textures.empty()) << c.name;
    EXPECT_THAT(
        read.notes,
        Contains(AllOf(HasSubstr(c.place), HasSubstr("the picture 'none.png' does not exist"),
                       HasSubstr(c.material), HasSubstr(c.color), HasSubstr("put the picture there"))))
        << c.name;
    if (std::string(c.color).starts_with("(0.5")) {
      EXPECT_EQ(read.mesh.colors.at(0), (Float3{0.5F, 0.25F, 1})) << c.name;
    }
  }
}

}  // namespace
}  // namespace bakelight::formats
