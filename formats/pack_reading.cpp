#include "formats/pack_reading.h"

#include <nlohmann/json.hpp>

#include "formats/draco_mesh.h"

namespace bakelight::formats {

void PackReading::require(const std::string& pointer, const Json& expected) const {
  if (glb_.at(pointer) != expected) throw glb_.error(pointer, "it has another value", expected.dump());
}

Float3 PackReading::float3At(const std::string& pointer) const {
  Float3 result;
  for (std::size_t i = 0; i < 3; ++i) result[i] = glb_.floatAt(pointer + "/" + std::to_string(i));
  return result;
}

int PackReading::intAt(const std::string& pointer, std::uint64_t least, std::uint64_t greatest) const {
  const std::uint64_t value = glb_.unsignedAt(pointer);
  if (value < least || value > greatest) {
    throw glb_.error(pointer, std::to_string(value) + " is out of range",
                     std::to_string(least) + " to " + std::to_string(greatest));
  }
  return static_cast<int>(value);
}

std::string PackReading::accessorAt(const std::string& pointer) const {
  return "/accessors/" + std::to_string(glb_.unsignedAt(pointer));
}

std::span<const std::byte> PackReading::sectionOfSize(const std::string& view_pointer,
                                                      std::optional<std::uint64_t> size_bytes,
                                                      const std::string& expected) const {
  const auto bytes = glb_.sectionAt(view_pointer);
  if (!size_bytes || bytes.size() != *size_bytes) {
    throw glb_.sectionError(view_pointer, "it has " + std::to_string(bytes.size()) + " bytes", expected);
  }
  return bytes;
}

TriangleMesh PackReading::readPlainVertices(const std::string& primitive) const {
  const std::string attributes = primitive + "/attributes";
  TriangleMesh mesh;
  mesh.positions = readAccessor<Float3>(attributes + "/POSITION", kFloat32Component, "VEC3");
  mesh.normals = readAccessor<Float3>(attributes + "/NORMAL", kFloat32Component, "VEC3");
  if (glb_.has(attributes + "/TEXCOORD_0"))
    mesh.texcoords = readAccessor<Float2>(attributes + "/TEXCOORD_0", kFloat32Component, "VEC2");
  return mesh;
}

TriangleMesh PackReading::readDracoMesh(const std::string& primitive) const {
  const std::string extension = primitive + "/extensions/" + kDracoExtension;
  const std::string ids = extension + "/attributes";
  DracoAttributes attributes{intAt(ids + "/POSITION", 0, 255), intAt(ids + "/NORMAL", 0, 255), -1};
  if (glb_.has(ids + "/TEXCOORD_0")) attributes.texcoord = intAt(ids + "/TEXCOORD_0", 0, 255);
  TriangleMesh mesh = decodeDraco(glb_.sectionAt(extension + "/bufferView"), attributes, glb_.file());
  const std::string count = accessorAt(primitive + "/attributes/POSITION") + "/count";
  if (glb_.unsignedAt(count) != mesh.vertexCount()) {
    throw glb_.error(count, "Draco gives " + std::to_string(mesh.vertexCount()) + " vertices", "as many");
  }
  return mesh;
}

EncodedTable PackReading::readTable(const std::string& pointer, const char* precision_key, std::uint64_t rows,
                                    std::uint64_t columns) const {
  EncodedTable table;
  table.precision = precisionAt(pointer + "/" + precision_key);
  table.rows = rows;
  table.columns = columns;
  table.data = glb_.shared(sectionOfSize(
      pointer + "/bufferView", checkedProduct({rows, columns, bytesPerValue(table.precision)}),
      std::to_string(rows) + " rows × " + std::to_string(columns) + " values of " + nameOf(table.precision)));
  if (table.precision == Precision::kUint8) {
    table.scale = readValues<float>(pointer + "/scale", columns);
    table.offset = readValues<float>(pointer + "/offset", columns);
  }
  return table;
}

Precision PackReading::precisionAt(const std::string& pointer) const {
  const std::string name = glb_.textAt(pointer);
  if (const Precision* known = valueFor(kPrecisions, name)) return *known;
  throw glb_.error(pointer, "'" + name + "' is not known", "float32, float16 or uint8");
}

}  // namespace bakelight::formats
