#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/draco_mesh.h"
#include "formats/pack_check.h"
#include "formats/pack_layout.h"

namespace bakelight::formats {
namespace {

const std::string kPrimitive = "/meshes/0/primitives/0";
const std::string kExtension = kPrimitive + "/extensions/" + kTransferExtension;

class PackReader {
 public:
  explicit PackReader(const GlbReader& glb) : glb_(glb) {}

  Pack read() const {
    Pack pack;
    pack.name = glb_.textAt("/meshes/0/name");
    pack.base_color = float3At("/materials/0/pbrMetallicRoughness/baseColorFactor");
    pack.mesh = glb_.has(kPrimitive + "/extensions/" + kDracoExtension) ? readDracoMesh() : readPlainMesh();
    pack.mesh.texcoords = flippedTexcoords(pack.mesh.texcoords);
    if (glb_.version() == 1) {
      pack.transfer = readVersion1(pack.mesh.vertexCount());
    } else {
      pack.colors = readAttribute<Float3>("COLOR_0", "VEC3");
      pack.transfer = readTransfer(pack.mesh.vertexCount());
    }
    return pack;
  }

 private:
  void require(const std::string& pointer, const Json& expected) const {
    if (glb_.at(pointer) != expected) throw glb_.error(pointer, "it has another value", expected.dump());
  }

  Float3 float3At(const std::string& pointer) const {
    Float3 result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = glb_.floatAt(pointer + "/" + std::to_string(i));
    return result;
  }

  int intAt(const std::string& pointer, std::uint64_t least, std::uint64_t greatest) const {
    const std::uint64_t value = glb_.unsignedAt(pointer);
    if (value < least || value > greatest) {
      throw glb_.error(pointer, std::to_string(value) + " is out of range",
                       std::to_string(least) + " to " + std::to_string(greatest));
    }
    return static_cast<int>(value);
  }

  int orderAt(const std::string& pointer) const { return intAt(pointer, 1, kMaxOrder); }

  // Pointer of the accessor whose index stands at `pointer`.
  std::string accessorAt(const std::string& pointer) const {
    return "/accessors/" + std::to_string(glb_.unsignedAt(pointer));
  }

  // ---- the mesh

  // `values_per_item` glTF elements make one Item: 3 indices a triangle.
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

  // Empty if the primitive has no such attribute.
  template <class Item>
  std::vector<Item> readAttribute(const char* name, const char* type) const {
    const std::string pointer = kPrimitive + "/attributes/" + name;
    if (!glb_.has(pointer)) return {};
    return readAccessor<Item>(pointer, kFloat32Component, type);
  }

  TriangleMesh readPlainMesh() const {
    const std::string attributes = kPrimitive + "/attributes";
    TriangleMesh mesh;
    mesh.positions = readAccessor<Float3>(attributes + "/POSITION", kFloat32Component, "VEC3");
    mesh.normals = readAccessor<Float3>(attributes + "/NORMAL", kFloat32Component, "VEC3");
    mesh.texcoords = readAttribute<Float2>("TEXCOORD_0", "VEC2");
    mesh.triangles = readAccessor<Triangle>(kPrimitive + "/indices", kUint32Component, "SCALAR", 3);
    return mesh;
  }

  TriangleMesh readDracoMesh() const {
    const std::string extension = kPrimitive + "/extensions/" + kDracoExtension;
    const std::string ids = extension + "/attributes";
    DracoAttributes attributes{intAt(ids + "/POSITION", 0, 255), intAt(ids + "/NORMAL", 0, 255), -1};
    if (glb_.has(ids + "/TEXCOORD_0")) attributes.texcoord = intAt(ids + "/TEXCOORD_0", 0, 255);
    TriangleMesh mesh = decodeDraco(glb_.sectionAt(extension + "/bufferView"), attributes, glb_.file());
    const std::string count = accessorAt(kPrimitive + "/attributes/POSITION") + "/count";
    if (glb_.unsignedAt(count) != mesh.vertexCount()) {
      throw glb_.error(count, "Draco gives " + std::to_string(mesh.vertexCount()) + " vertices", "as many");
    }
    return mesh;
  }

  // ---- tables

  // The values of a section that must hold `count` of them.
  template <class Value>
  std::vector<Value> readValues(const std::string& view_pointer, std::uint64_t count) const {
    return valuesOf<Value>(sectionOfSize(view_pointer, checkedProduct({count, sizeof(Value)}),
                                         std::to_string(count) + " values"));
  }

  std::span<const std::byte> sectionOfSize(const std::string& view_pointer,
                                           std::optional<std::uint64_t> size_bytes,
                                           const std::string& expected) const {
    const auto bytes = glb_.sectionAt(view_pointer);
    if (!size_bytes || bytes.size() != *size_bytes) {
      throw glb_.sectionError(view_pointer, "it has " + std::to_string(bytes.size()) + " bytes", expected);
    }
    return bytes;
  }

  Precision precisionAt(const std::string& pointer) const {
    const std::string name = glb_.textAt(pointer);
    for (const std::string& known : precisionNames()) {
      if (name == known) return precisionNamed(name);
    }
    throw glb_.error(pointer, "'" + name + "' is not known", "float32, float16 or uint8");
  }

  EncodedTable readTable(const std::string& pointer) const {
    EncodedTable table;
    table.precision = precisionAt(pointer + "/precision");
    table.rows = glb_.unsignedAt(pointer + "/rows");
    table.columns = glb_.unsignedAt(pointer + "/columns");
    const auto bytes = sectionOfSize(
        pointer + "/bufferView", checkedProduct({table.rows, table.columns, bytesPerValue(table.precision)}),
        std::to_string(table.rows) + " rows × " + std::to_string(table.columns) + " values of " +
            nameOf(table.precision));
    table.data.assign(bytes.begin(), bytes.end());
    if (table.precision == Precision::kUint8) {
      table.scale = readValues<float>(pointer + "/scale", table.columns);
      table.offset = readValues<float>(pointer + "/offset", table.columns);
    }
    return table;
  }

  // ---- radiance transfer

  RadianceTransfer readVersion1(std::size_t vertex_count) const {
    require(kExtension + "/technique", "diffuse_vector");
    requireConventions();
    require(kExtension + "/componentType", static_cast<int>(kFloat32Component));
    RadianceTransfer transfer;
    transfer.order = orderAt(kExtension + "/order");
    transfer.transport = glb_.textAt(kExtension + "/visibility");
    const auto order = static_cast<std::size_t>(transfer.order), columns = order * order;
    require(kExtension + "/coefficientsPerVertex", columns);
    EncodedTable& vectors = transfer.vectors;
    vectors.rows = vertex_count;
    vectors.columns = columns;
    const auto bytes =
        sectionOfSize(kExtension + "/bufferView", checkedProduct({vertex_count, columns, sizeof(float)}),
                      std::to_string(vertex_count) + " vertices × " + std::to_string(columns) + " floats");
    vectors.data.assign(bytes.begin(), bytes.end());
    return transfer;
  }

  void requireConventions() const {
    require(kExtension + "/basis", kBasis);
    require(kExtension + "/frame", "object");
    require(kExtension + "/inversePi", "inside");
    require(kExtension + "/albedo", "outside");
  }

  RadianceTransfer readTransfer(std::size_t vertex_count) const {
    requireConventions();
    RadianceTransfer transfer;
    transfer.order = orderAt(kExtension + "/order");
    transfer.transport = glb_.textAt(kExtension + "/transport");
    transfer.channels = intAt(kExtension + "/channels", 1, 3);
    transfer.vectors = readTable(kExtension + "/transfer");
    const std::string near_field = kExtension + "/nearField";
    if (glb_.has(near_field)) {
      transfer.sphere_center = float3At(near_field + "/center");
      transfer.sphere_radius = glb_.floatAt(near_field + "/radius");
      transfer.near_vectors = readTable(near_field + "/transfer");
    }
    const bool glossy = glb_.has(kExtension + "/glossy");
    require(kExtension + "/technique", glossy ? "glossy" : "diffuse");
    if (glossy) readGlossy(kExtension + "/glossy", vertex_count, transfer);
    return transfer;
  }

  MatrixStorage storageAt(const std::string& pointer) const {
    const std::string name = glb_.textAt(pointer);
    for (const auto storage : {MatrixStorage::kMatrix, MatrixStorage::kVisibility, MatrixStorage::kCpca}) {
      if (name == nameOf(storage)) return storage;
    }
    throw glb_.error(pointer, "'" + name + "' is not known", "matrix, visibility or cpca");
  }

  void readGlossy(const std::string& pointer, std::size_t vertex_count, RadianceTransfer& transfer) const {
    transfer.storage = storageAt(pointer + "/storage");
    transfer.row_order = orderAt(pointer + "/rowOrder");
    require(pointer + "/frame", transfer.storage == MatrixStorage::kVisibility ? "object" : "local");
    transfer.tangents = readAttribute<Float4>("TANGENT", "VEC4");
    transfer.matrices = readTable(pointer + "/" + matrixSection(transfer.storage));
    if (transfer.storage == MatrixStorage::kCpca) {
      transfer.clusters = readValues<std::uint32_t>(pointer + "/clusters/bufferView", vertex_count);
      transfer.basis = readTable(pointer + "/basis");
      const std::uint64_t count = glb_.unsignedAt(pointer + "/clusters/count");
      if (checkedProduct({count, 1 + transfer.matrices.columns}) != transfer.basis.rows) {
        throw glb_.error(pointer + "/clusters/count", std::to_string(count) + " does not fit the basis",
                         "rows of the basis / (1 + columns of the weights)");
      }
    }
    if (glb_.has(pointer + "/lobe")) transfer.material = readLobe(pointer + "/lobe");
  }

  GlossyMaterial readLobe(const std::string& pointer) const {
    GlossyMaterial material;
    const std::string model = glb_.textAt(pointer + "/model");
    if (model == nameOf(LobeModel::kTable)) {
      material.model = LobeModel::kTable;
      material.table = readBrdf(pointer);
      return material;
    }
    material.specular_color = float3At(pointer + "/specularColor");
    if (model == nameOf(LobeModel::kPhong)) {
      material.model = LobeModel::kPhong;
      material.exponent = glb_.floatAt(pointer + "/exponent");
    } else if (model == nameOf(LobeModel::kGgx)) {
      material.model = LobeModel::kGgx;
      material.roughness = glb_.floatAt(pointer + "/roughness");
    } else {
      throw glb_.error(pointer + "/model", "'" + model + "' is not known", "phong, ggx or table");
    }
    return material;
  }

  BrdfTable readBrdf(const std::string& pointer) const {
    BrdfTable table;
    table.order = orderAt(pointer + "/order");
    table.angles = intAt(pointer + "/angles", 2, kMaxAngles);
    const auto order = static_cast<std::uint64_t>(table.order);
    table.values = readValues<float>(pointer + "/bufferView",
                                     static_cast<std::uint64_t>(table.angles) * 3 * order * order);
    return table;
  }

  const GlbReader& glb_;
};

}  // namespace

Pack decodeUncheckedPack(const GlbReader& glb) {
  return PackReader(glb).read();
}

}  // namespace bakelight::formats
