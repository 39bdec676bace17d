// What readers of every version of packs share: the mesh's accessors and values out of sections. Private to
// formats/pack*.cpp.
#pragma once

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "formats/pack_check.h"
#include "formats/pack_layout.h"

namespace bakelight::formats {

class PackReading {
 public:
  explicit PackReading(const GlbReader& glb) : glb_(glb) {}

 protected:
  void require(const std::string& pointer, const Json& expected) const;
  Float3 float3At(const std::string& pointer) const;
  int intAt(const std::string& pointer, std::uint64_t least, std::uint64_t greatest) const;
  // Pointer of the accessor whose index stands at `pointer`.
  std::string accessorAt(const std::string& pointer) const;

  // `elements_per_item` glTF elements make one Item: 3 indices a triangle. The accessor takes a whole
  // section.
  template <class Item>
  std::vector<Item> readAccessor(const std::string& index_pointer, ComponentType component, const char* type,
                                 std::uint64_t elements_per_item = 1) const {
    const std::string accessor_pointer = accessorAt(index_pointer);
    require(accessor_pointer + "/componentType", static_cast<int>(component));
    require(accessor_pointer + "/type", type);
    const std::uint64_t count = glb_.unsignedAt(accessor_pointer + "/count");
    const auto bytes = glb_.sectionAt(accessor_pointer + "/bufferView");
    // Compared by division: count × size may not fit 64 bits in a hostile file.
    if (bytes.size() % sizeof(Item) != 0 || count % elements_per_item != 0 ||
        count / elements_per_item != bytes.size() / sizeof(Item)) {
      throw glb_.error(accessor_pointer + "/count", std::to_string(count) + " does not fit its bufferView",
                       std::to_string(bytes.size() / sizeof(Item) * elements_per_item));
    }
    return valuesOf<Item>(bytes);
  }

  template <class Item>
  static std::vector<Item> valuesOf(std::span<const std::byte> bytes) {
    std::vector<Item> items(bytes.size() / sizeof(Item));
    if (!items.empty()) std::memcpy(items.data(), bytes.data(), items.size() * sizeof(Item));
    return items;
  }

  // The values of a section that must hold `count` of them.
  template <class Value>
  std::vector<Value> readValues(const std::string& view_pointer, std::uint64_t count) const {
    return valuesOf<Value>(sectionOfSize(view_pointer, checkedProduct({count, sizeof(Value)}),
                                         std::to_string(count) + " values"));
  }
  std::span<const std::byte> sectionOfSize(const std::string& view_pointer,
                                           std::optional<std::uint64_t> size_bytes,
                                           const std::string& expected) const;

  TriangleMesh readPlainVertices(const std::string& primitive) const;
  TriangleMesh readDracoMesh(const std::string& primitive) const;
  // The table whose precision stands under `precision_key`.
  EncodedTable readTable(const std::string& pointer, const char* precision_key, std::uint64_t rows,
                         std::uint64_t columns) const;
  Precision precisionAt(const std::string& pointer) const;

  const GlbReader& glb_;
};

}  // namespace bakelight::formats
