// glTF: files beside the file, containers, and all that may be wrong in one.

#include <gmock/gmock.h>

#include <random>

#include "formats/draco_mesh.h"
#include "tests/unit/formats/gltf_reading.h"
#include "tests/unit/formats/test_meshes.h"

namespace bakelight::formats {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(GltfFiles, FilesBesideItByAnyNameThatAUriMayHave) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "my files");
  const std::vector<std::pair<std::string, std::string>> names = {
      {"my%20files/%C3%A4%2B1.bin", "my files/ä+1.bin"},
      {"100%.bin", "100%.bin"},
      {"my files\\b.bin", "my files/b.bin"},
      {"file://" + (folder / "abs%20olute.bin").string(), "abs olute.bin"},
      {"a%20b.bin", "a%20b.bin"}};
  for (const auto& [uri, name] : names) {
    GltfMaker file = bracketFile();
    writeQuickly(folder / name, file.binary);
    file.json["buffers"] = {{{"byteLength", file.binary.size()}, {"uri", uri}}};
    writeQuickly(folder / "a.gltf", file.text());
    expectBracket(importMesh(folder / "a.gltf").mesh, uri);
    std::filesystem::remove(folder / name);
    EXPECT_THROW(importMesh(folder / "a.gltf"), Error) << uri;
  }
  writeQuickly(folder / "binary.gltf", bracketFile().glb());
  writeQuickly(folder / "text.glb", bracketFile().text());
  expectBracket(importMesh(folder / "binary.gltf").mesh, "binary under the text's ending");
  expectBracket(importMesh(folder / "text.glb").mesh, "text under the binary's ending");
}

TEST(GltfFiles, DataUrisOfAllForms) {
  GltfMaker file = bracketFile();
  std::string digits = base64(file.binary), escaped, spaced, safe = digits, percent;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    escaped += digits[i] == '+' ? "%2B" : digits[i] == '/' ? "%2F" : std::string(1, digits[i]);
    spaced += digits[i];
    if (i % 76 == 75) spaced += "\r\n";
  }
  for (char& c : safe) c = c == '+' ? '-' : c == '/' ? '_' : c;
  while (safe.ends_with('=')) safe.pop_back();
  for (const char c : file.binary) {
    constexpr const char* kHex = "0123456789abcdef";
    percent += {'%', kHex[static_cast<unsigned char>(c) >> 4], kHex[static_cast<unsigned char>(c) & 15]};
  }
  for (const std::string& uri : {"data:;base64," + digits, "data:application/gltf-buffer;base64," + escaped,
                                 "DATA:a/b;base64," + spaced, "data:a/b;charset=x;base64," + safe,
                                 "data:application/octet-stream," + percent}) {
    file.json["buffers"] = {{{"byteLength", file.binary.size()}, {"uri", uri}}};
    expectBracket(read(file).mesh, uri.substr(0, 30));
  }
  const std::vector<std::pair<std::string, std::string>> faults = {
      {"data:;base64", "no comma"},
      {"data:;base64,AB*D", "character 2"},
      {"data:;base64,AAAAA", "group of four"},
      {"data:;base64,AA==AA", "character 4"},
      {"data:;base64,AAAA", "has 3 bytes"},
      {"https://a.b/c.bin", "not the name of a file"},
      {"none.bin", "none.bin is missing"}};
  for (const auto& [uri, what] : faults) {
    file.json["buffers"] = {{{"byteLength", file.binary.size()}, {"uri", uri}}};
    EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr("/buffers/0"), HasSubstr(what))) << uri;
  }
}

TEST(GltfFiles, BinaryContainersThatAreWrong) {
  const std::string whole = bracketFile().glb();
  EXPECT_THAT(errorOf(whole.substr(0, 15)), HasSubstr("ends inside it"));
  EXPECT_THAT(errorOf(whole.substr(0, whole.size() - 1)), HasSubstr("its header says"));
  std::string changed = whole;
  changed[4] = 1;
  EXPECT_THAT(errorOf(changed), HasSubstr("version 1"));
  changed = whole;
  changed[12] = '\xFF', changed[13] = '\xFF';
  EXPECT_THAT(errorOf(changed), AllOf(HasSubstr("chunk 0"), HasSubstr("end beyond")));
  changed = whole;
  changed[16] = 'B';
  EXPECT_THAT(errorOf(changed), AllOf(HasSubstr("chunk 0"), HasSubstr("no JSON")));
  const MeshImport longer = read(whole + "xyz");
  expectBracket(longer.mesh, "longer");
  EXPECT_THAT(longer.notes, ElementsAre(HasSubstr("3 bytes after the end")));
  GltfMaker without = bracketFile();
  without.binary.clear();
  EXPECT_THAT(errorOf(without.glb()), HasSubstr("/bufferViews/0/byteLength"));
}

struct Fault {
  const char* patch;  // JSON merge patch (RFC 7386) or a JSON patch (RFC 6902) on bracketFile()
  const char* pointer;
  const char* what;
};

TEST(GltfFiles, FaultsAreNamedWithTheirPlace) {
  const std::vector<Fault> faults = {
      {R"({"asset": {"version": "1.0"}})", "/asset/version", "glTF 1.0"},
      {R"({"asset": null, "techniques": {}})", "", "glTF 1.0"},
      {R"({"asset": {"minVersion": "2.1"}})", "/asset/minVersion", "2.1"},
      {R"({"extensionsRequired": ["VENDOR_curves"]})", "/extensionsRequired/0", "VENDOR_curves"},
      {R"({"scene": 3})", "/scene", "does not exist"},
      {R"({"scenes": [{"nodes": [0, 0]}]})", "/scenes/0/nodes/1", "twice"},
      {R"({"nodes": [{"mesh": 1}]})", "/nodes/0/mesh", "1 of \"meshes\" does not exist"},
      {R"({"nodes": [{"mesh": -1}]})", "/nodes/0/mesh", "out of range"},
      {R"({"nodes": [{"mesh": "a"}]})", "/nodes/0/mesh", "a text"},
      {R"({"nodes": [{"children": [1]}, {"children": [1]}]})", "/nodes/1/children/0", "another parent"},
      {R"({"nodes": [{}, {"children": [2]}, {"children": [1]}]})", "/nodes/1", "below itself"},
      {R"({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]})", "/nodes/0/rotation", "no length"},
      {R"({"nodes": [{"mesh": 0, "scale": [1, 2]}]})", "/nodes/0/scale", "2 entries"},
      {R"({"nodes": [{"mesh": 0, "scale": [1e300, 1, 1]}]})", "/meshes/0/primitives/0/attributes/POSITION",
       "beyond the range"},
      {R"({"nodes": [{"mesh": 0, "matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})", "/nodes/0/matrix",
       "last row"},
      {R"({"nodes": [{"mesh": 0, "skin": 0}], "skins": [{"joints": [0]}]})", "/nodes/0/skin", "JOINTS_0"},
      {R"({"nodes": [{"mesh": 0, "weights": [1]}]})", "/meshes/0/primitives/0", "1 weights"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/mode", "value": 7}])", "/meshes/0/primitives/0/mode",
       "7 is no mode"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/material", "value": 0}])",
       "/meshes/0/primitives/0/material", "does not exist"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/attributes/COLOR_0", "value": 1}])",
       "/accessors/1/type", "SCALAR"},
      {R"([{"op": "add", "path": "/meshes/0/primitives/0/attributes/JOINTS_0", "value": 0}])",
       "/meshes/0/primitives/0/attributes", "only one of"},
      {R"([{"op": "replace", "path": "/meshes/0/primitives/0/indices", "value": 0}])", "/accessors/0/type",
       "VEC3"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 13}])", "/accessors/0/count",
       "13 elements"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 9007199254740991}])",
       "/accessors/0/count", "end beyond"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 1e300}])", "/accessors/0/count",
       "out of range"},
      {R"([{"op": "replace", "path": "/accessors/0/count", "value": 5}])", "/accessors/1",
       "vertex 5 does not exist"},
      {R"([{"op": "replace", "path": "/accessors/0/componentType", "value": 5124}])",
       "/accessors/0/componentType", "5124"},
      {R"([{"op": "replace", "path": "/accessors/1/componentType", "value": 5126}])",
       "/accessors/1/componentType", "5126"},
      {R"([{"op": "add", "path": "/accessors/0/byteOffset", "value": 18446744073709551615}])",
       "/accessors/0/byteOffset", "out of range"},
      {R"([{"op": "add", "path": "/accessors/0/byteOffset", "value": 4}])", "/accessors/0/count",
       "end beyond"},
      {R"([{"op": "replace", "path": "/accessors/0/bufferView", "value": 9}])", "/accessors/0/bufferView",
       "9 of"},
      {R"([{"op": "add", "path": "/accessors/0/sparse", "value": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121, "byteOffset": 6}, "values": {"bufferView": 9}}}])",
       "/accessors/0/sparse/values/bufferView", "9 of"},
      {R"([{"op": "add", "path": "/accessors/0/sparse", "value": {"count": 9, "indices": {"bufferView": 1, "componentType": 5125}, "values": {"bufferView": 0}}}])",
       "/accessors/0/sparse/indices", "below the accessor's count"},
      {R"([{"op": "add", "path": "/bufferViews/0/byteStride", "value": 8}])", "/accessors/0/bufferView",
       "byteStride"},
      {R"([{"op": "replace", "path": "/bufferViews/0/byteLength", "value": 9999}])",
       "/bufferViews/0/byteLength", "beyond the buffer"},
      {R"([{"op": "replace", "path": "/bufferViews/0/byteOffset", "value": 9007199254740991}])",
       "/bufferViews/0/byteLength", "beyond the buffer"},
      {R"([{"op": "add", "path": "/buffers", "value": [{"byteLength": 264}]}])", "/buffers/0", "no \"uri\""},
      {R"([{"op": "remove", "path": "/accessors/0/bufferView"}, {"op": "replace", "path": "/accessors/0/count", "value": 4000000000}])",
       "/accessors/0/count", "without a bufferView"},
  };
  for (const Fault& fault : faults) {
    GltfMaker file = bracketFile();
    const Json patch = Json::parse(fault.patch);
    if (patch.is_array()) {
      file.json = file.json.patch(patch);
    } else {
      file.json.merge_patch(patch);
    }
    EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr(fault.pointer), HasSubstr(fault.what))) << fault.patch;
  }
  EXPECT_THAT(errorOf("{"), HasSubstr("line 1"));
  EXPECT_THAT(errorOf("[]"), HasSubstr("no object"));
  EXPECT_THAT(errorOf("{}"), HasSubstr("no \"asset\""));
  EXPECT_THAT(errorOf(" "), HasSubstr("empty"));
}

TEST(GltfFiles, FaultsInTheDataAreNamedWithTheirPlace) {
  GltfMaker file = bracketFile();
  std::vector<Float3> positions = bracket().positions;
  positions[7][1] = std::nanf("");
  file.attribute("POSITION", file.accessor(flat(positions), "VEC3"));
  file.json["nodes"][0]["name"] = "leg";
  EXPECT_THAT(errorOf(file.text()), AllOf(HasSubstr("vertex 7"), HasSubstr("'leg'"), HasSubstr("not finite"),
                                          HasSubstr("/meshes/0/primitives/0/attributes/POSITION")));
  file = bracketFile();
  file.primitive()["indices"] = file.accessor(std::vector<std::uint8_t>{0, 1, 255}, "SCALAR");
  EXPECT_THAT(errorOf(file.text()),
              AllOf(HasSubstr("/accessors/2"), HasSubstr("index 2 is 255"), HasSubstr("restart")));
  GltfMaker skinned = skinnedFile(std::vector<float>(48, 1));
  skinned.json["skins"][0]["joints"] = {1};
  EXPECT_THAT(errorOf(skinned.text()), AllOf(HasSubstr("/skins/0/joints"), HasSubstr("vertex 0")));
}

// Whatever the bytes: a mesh or an Error.
TEST(GltfFiles, DamagedFilesAreMeshesOrErrors) {
  GltfMaker draco = bracketFile();
  const DracoMesh packed = encodeDraco(bracket(), 0, 0, "a");
  draco.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", draco.view({reinterpret_cast<const char*>(packed.bytes.data()), packed.bytes.size()})},
      {"attributes", {{"POSITION", packed.attributes.position}}}};
  std::mt19937 random(7);
  int errors = 0, meshes = 0;
  for (const std::string& whole :
       {skinnedFile(std::vector<float>(48, 1)).glb(), meshoptFile().glb(), draco.glb()}) {
    ASSERT_EQ(errorOf(whole), "no error");
    for (int trial = 0; trial < 700; ++trial) {
      std::string changed = whole;
      for (int flips = 1 + trial % 3; flips > 0; --flips) {
        const std::size_t place = random() % changed.size();
        changed[place] = static_cast<char>(changed[place] ^ (1 << random() % 8));
      }
      if (trial % 10 == 0) changed.resize(random() % changed.size());
      try {
        read(changed);
        ++meshes;
      } catch (const Error&) {
        ++errors;
      }
    }
  }
  EXPECT_GT(errors, 500);
  EXPECT_GT(meshes, 100);
}

}  // namespace
}  // namespace bakelight::formats
