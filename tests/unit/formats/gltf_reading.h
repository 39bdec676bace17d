// What the tests of the glTF reader share.
#pragma once

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/mesh_gltf.h"
#include "formats/mesh_import.h"
#include "tests/unit/formats/gltf_maker.h"

namespace bakelight::formats {

inline MeshImport read(const std::string& content) {
  return merged(readGltf("a.gltf", bytesOf(content)), "a.gltf");
}
inline MeshImport read(const GltfMaker& file) {
  return read(file.text());
}

// "no error" where there is none.
inline std::string errorOf(const std::string& content) {
  try {
    read(content);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.what();
  }
  return "no error";
}

// Bones at y = 0 and 1; the upper one is turned by a quarter about z.
inline GltfMaker skinnedFile(const std::vector<float>& weights) {
  GltfMaker file = bracketFile();
  std::vector<std::uint8_t> joints;
  for (int i = 0; i < 12; ++i) joints.insert(joints.end(), {0, 1, 0, 0});
  file.attribute("JOINTS_0", file.accessor(joints, "VEC4"));
  file.attribute("WEIGHTS_0", file.accessor(weights, "VEC4"));
  file.attribute("NORMAL", file.accessor(flat(std::vector<Float3>(12, {1, 0, 0})), "VEC3"));
  std::vector<float> bind(32, 0);
  for (const std::size_t i : {0U, 5U, 10U, 15U}) bind[i] = bind[16 + i] = 1;
  bind[16 + 13] = -1;
  file.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", file.accessor(bind, "MAT4")}}};
  file.json["nodes"] = Json::parse(R"([{"mesh": 0, "skin": 0, "translation": [50, 0, 0]}, {"children": [2]},
    {"translation": [0, 1, 0], "rotation": [0, 0, 0.70710678118654752, 0.70710678118654752]}])");
  file.json["scenes"][0]["nodes"] = {0, 1};
  return file;
}

inline GltfMaker meshoptFile() {
  GltfMaker file = bracketFile();
  const auto positions = flat(bracket().positions);
  const auto indices = indicesOf<std::uint32_t>(bracket());
  std::vector<unsigned char> vertices(meshopt_encodeVertexBufferBound(12, 12)),
      triangles(meshopt_encodeIndexBufferBound(60, 12));
  vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), positions.data(), 12, 12));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), 60));
  const auto pack = [&](int accessor, const std::vector<unsigned char>& bytes, int count, int stride,
                        const char* mode) {
    const int source = file.view({bytes.begin(), bytes.end()});
    Json& view = file.json["bufferViews"][static_cast<int>(file.json["accessors"][accessor]["bufferView"])];
    view["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},
        {"byteOffset", file.json["bufferViews"][source]["byteOffset"]},
        {"byteLength", bytes.size()},
        {"byteStride", stride},
        {"count", count},
        {"mode", mode}};
    view["buffer"] = 1;  // a fallback that is not there
    view["byteOffset"] = 0;
  };
  pack(0, vertices, 12, 12, "ATTRIBUTES");
  pack(1, triangles, 60, 2, "TRIANGLES");
  file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  file.json["buffers"] = {
      {{"byteLength", file.binary.size()}},
      {{"byteLength", 264}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  return file;
}

}  // namespace bakelight::formats
