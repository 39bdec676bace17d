// Packs of versions 1 and 2: one primitive, which the transfer extension stands on.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/pack_reading.h"

namespace bakelight::formats {
namespace {

const std::string kPrimitive = "/meshes/0/primitives/0";
const std::string kExtension = kPrimitive + "/extensions/" + kTransferExtension;

class PackReader2 : private PackReading {
 public:
  explicit PackReader2(const GlbReader& glb) : PackReading(glb) {}

  Pack read() const {
    Pack pack;
    pack.name = glb_.textAt("/meshes/0/name");
    if (glb_.has(kPrimitive + "/extensions/" + kDracoExtension)) {
      pack.mesh = readDracoMesh(kPrimitive);
    } else {
      pack.mesh = readPlainVertices(kPrimitive);
      pack.mesh.triangles = readAccessor<Triangle>(kPrimitive + "/indices", kUint32Component, "SCALAR", 3);
    }
    pack.mesh.texcoords = flippedTexcoords(pack.mesh.texcoords);
    Appearance& appearance = pack.appearances.front();
    appearance.base_color = float3At("/materials/0/pbrMetallicRoughness/baseColorFactor");
    if (glb_.version() == 1) {
      pack.transfer = readVersion1(pack.mesh.vertexCount());
      return pack;
    }
    if (glb_.has(kPrimitive + "/attributes/COLOR_0"))
      pack.colors = readAccessor<Float3>(kPrimitive + "/attributes/COLOR_0", kFloat32Component, "VEC3");
    pack.transfer = readTransfer(pack.mesh.vertexCount());
    if (glb_.has(kExtension + "/glossy/lobe")) appearance.reflection = readLobe(kExtension + "/glossy/lobe");
    return pack;
  }

 private:
  int orderAt(const std::string& pointer) const { return intAt(pointer, 1, kMaxOrder); }

  EncodedTable tableAt(const std::string& pointer) const {
    return readTable(pointer, "precision", glb_.unsignedAt(pointer + "/rows"),
                     glb_.unsignedAt(pointer + "/columns"));
  }

  // ---- radiance transfer

  ShTransfer readVersion1(std::size_t vertex_count) const {
    require(kExtension + "/technique", "diffuse_vector");
    requireConventions();
    require(kExtension + "/componentType", static_cast<int>(kFloat32Component));
    ShTransfer transfer;
    transfer.order = orderAt(kExtension + "/order");
    transfer.transport = transportAt(kExtension + "/visibility");
    const auto order = static_cast<std::size_t>(transfer.order), columns = order * order;
    require(kExtension + "/coefficientsPerVertex", columns);
    EncodedTable& vectors = transfer.vectors;
    vectors.rows = vertex_count;
    vectors.columns = columns;
    const auto bytes =
        sectionOfSize(kExtension + "/bufferView", checkedProduct({vertex_count, columns, sizeof(float)}),
                      std::to_string(vertex_count) + " vertices × " + std::to_string(columns) + " floats");
    vectors.data = glb_.shared(bytes);
    return transfer;
  }

  void requireConventions() const {
    require(kExtension + "/basis", "real_sh_cartesian");
    require(kExtension + "/frame", "object");
    require(kExtension + "/inversePi", "inside");
    require(kExtension + "/albedo", "outside");
  }

  Transport transportAt(const std::string& pointer) const {
    const std::string name = glb_.textAt(pointer);
    if (const Transport* known = valueFor(kTransports, name)) return *known;
    throw glb_.error(pointer, "'" + name + "' is not known", "unshadowed, shadowed or interreflected");
  }

  ShTransfer readTransfer(std::size_t vertex_count) const {
    requireConventions();
    ShTransfer transfer;
    transfer.order = orderAt(kExtension + "/order");
    transfer.transport = transportAt(kExtension + "/transport");
    transfer.channels = intAt(kExtension + "/channels", 1, 3);
    transfer.vectors = tableAt(kExtension + "/transfer");
    const std::string near_field = kExtension + "/nearField";
    if (glb_.has(near_field))
      transfer.near_field = {float3At(near_field + "/center"), glb_.floatAt(near_field + "/radius"),
                             tableAt(near_field + "/transfer")};
    const bool glossy = glb_.has(kExtension + "/glossy");
    require(kExtension + "/technique", glossy ? "glossy" : "diffuse");
    if (glossy) transfer.glossy = readGlossy(kExtension + "/glossy", vertex_count);
    return transfer;
  }

  GlossyTransfer readGlossy(const std::string& pointer, std::size_t vertex_count) const {
    GlossyTransfer glossy;
    glossy.output_order = orderAt(pointer + "/rowOrder");
    if (glb_.has(kPrimitive + "/attributes/TANGENT"))
      glossy.tangents = readAccessor<Float4>(kPrimitive + "/attributes/TANGENT", kFloat32Component, "VEC4");
    const std::string storage = glb_.textAt(pointer + "/storage");
    if (storage == kOperatorNames[0]) {
      glossy.transfer = MatrixOperator{tableAt(pointer + "/matrices")};
    } else if (storage == kOperatorNames[1]) {
      glossy.transfer = VisibilityOperator{tableAt(pointer + "/visibility")};
    } else if (storage == kOperatorNames[2]) {
      glossy.transfer = readClusters(pointer, vertex_count);
    } else {
      throw glb_.error(pointer + "/storage", "'" + storage + "' is not known", "matrix, visibility or cpca");
    }
    require(pointer + "/frame", glossy.isInObjectFrame() ? "object" : "local");
    return glossy;
  }

  ClusteredOperator readClusters(const std::string& pointer, std::size_t vertex_count) const {
    ClusteredOperator result{tableAt(pointer + "/weights"),
                             readValues<std::uint32_t>(pointer + "/clusters/bufferView", vertex_count),
                             tableAt(pointer + "/basis")};
    const std::uint64_t count = glb_.unsignedAt(pointer + "/clusters/count");
    if (checkedProduct({count, 1 + result.weights.columns}) != result.basis.rows) {
      throw glb_.error(pointer + "/clusters/count", std::to_string(count) + " does not fit the basis",
                       "rows of the basis / (1 + columns of the weights)");
    }
    return result;
  }

  PackPart readLobe(const std::string& pointer) const {
    const std::string model = glb_.textAt(pointer + "/model");
    if (model == BrdfTable::kKind) return readBrdf(pointer);
    const Float3 specular_color = float3At(pointer + "/specularColor");
    if (model == PhongLobe::kKind) return PhongLobe{glb_.floatAt(pointer + "/exponent"), specular_color};
    if (model == GgxLobe::kKind) return GgxLobe{glb_.floatAt(pointer + "/roughness"), specular_color};
    throw glb_.error(pointer + "/model", "'" + model + "' is not known", "phong, ggx or table");
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
};

}  // namespace

Pack decodeUncheckedPack2(const GlbReader& glb) {
  return PackReader2(glb).read();
}

}  // namespace bakelight::formats
