// glTF files made by code, for the tests of the reader.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "formats/file.h"
#include "formats/json.h"
#include "tests/unit/formats/bracket.h"

namespace bakelight::formats {

inline std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * static_cast<int>(k)) & 63];
  }
  return text;
}

template <class Value>
constexpr int gltfCode() {
  if (std::is_same_v<Value, std::int8_t>) return 5120;
  if (std::is_same_v<Value, std::uint8_t>) return 5121;
  if (std::is_same_v<Value, std::int16_t>) return 5122;
  if (std::is_same_v<Value, std::uint16_t>) return 5123;
  if (std::is_same_v<Value, std::uint32_t>) return 5125;
  return 5126;
}

struct GltfMaker {
  Json json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {}}]}],
      "accessors": [], "bufferViews": []})");
  std::string binary;

  int view(const std::string& bytes) {
    binary.resize((binary.size() + 3) / 4 * 4);
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary += bytes;
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }

  // `flat`: all components one after the other.
  template <class Value>
  int accessor(const std::vector<Value>& flat, const std::string& type, bool normalized = false) {
    const std::string bytes(reinterpret_cast<const char*>(flat.data()), flat.size() * sizeof(Value));
    const std::size_t components = type == "SCALAR" ? 1
                                   : type == "MAT4" ? 16
                                                    : static_cast<std::size_t>(type[3] - '0');
    Json made = {{"bufferView", view(bytes)},
                 {"componentType", gltfCode<Value>()},
                 {"count", flat.size() / components},
                 {"type", type}};
    if (normalized) made["normalized"] = true;
    json["accessors"].push_back(made);
    return static_cast<int>(json["accessors"].size()) - 1;
  }

  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  void attribute(const std::string& name, int accessor) { primitive()["attributes"][name] = accessor; }

  std::string text() const {
    Json whole = json;
    if (!whole.contains("buffers")) {
      whole["buffers"] = {
          {{"byteLength", binary.size()}, {"uri", "data:application/octet-stream;base64," + base64(binary)}}};
    }
    return whole.dump();
  }

  std::string glb() const {
    Json whole = json;
    if (!whole.contains("buffers")) whole["buffers"] = {{{"byteLength", binary.size()}}};
    std::string document = whole.dump(), body = binary;
    document.resize((document.size() + 3) / 4 * 4, ' ');
    body.resize((body.size() + 3) / 4 * 4);
    std::string result =
        "glTF" + word(2) + word(static_cast<std::uint32_t>(28 + document.size() + body.size()));
    result += word(static_cast<std::uint32_t>(document.size())) + "JSON" + document;
    return result + word(static_cast<std::uint32_t>(body.size())) + std::string("BIN\0", 4) + body;
  }

  static std::string word(std::uint32_t value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }
};

template <class Value, std::size_t n>
std::vector<Value> flat(const std::vector<std::array<Value, n>>& values) {
  std::vector<Value> result;
  for (const auto& value : values) result.insert(result.end(), value.begin(), value.end());
  return result;
}

template <class Index>
std::vector<Index> indicesOf(const TriangleMesh& mesh) {
  std::vector<Index> result;
  for (const std::uint32_t index : flat(mesh.triangles)) result.push_back(static_cast<Index>(index));
  return result;
}

// The L bracket: floats, 16-bit indices.
inline GltfMaker bracketFile() {
  GltfMaker file;
  file.attribute("POSITION", file.accessor(flat(bracket().positions), "VEC3"));
  file.primitive()["indices"] = file.accessor(indicesOf<std::uint16_t>(bracket()), "SCALAR");
  return file;
}

inline Bytes bytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace bakelight::formats
