#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/draco_mesh.h"
#include "formats/pack_check.h"
#include "formats/pack_layout.h"

namespace bakelight::formats {
namespace {

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

Json accessor(std::optional<int> view, ComponentType component, std::size_t count, const char* type) {
  Json result = {{"componentType", static_cast<int>(component)}, {"count", count}, {"type", type}};
  if (view) result["bufferView"] = *view;
  return result;
}

Json positionAccessor(std::optional<int> view, const std::vector<Float3>& positions) {
  Float3 least = positions[0], greatest = positions[0];
  for (const Float3& position : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], position[axis]);
      greatest[axis] = std::max(greatest[axis], position[axis]);
    }
  }
  Json result = accessor(view, kFloat32Component, positions.size(), "VEC3");
  result["min"] = least;
  result["max"] = greatest;
  return result;
}

// What comes nearest to the pack's lobe among glTF's materials, for viewers that do not know the extension.
// A Phong exponent becomes that of the half angle, four times as large (Fisher & Woo 1994), then
// alpha² = 2 / (exponent + 2).
float viewerRoughness(const GlossyMaterial& material) {
  if (material.model == LobeModel::kGgx) return material.roughness;
  if (material.model == LobeModel::kPhong) return std::pow(2 / (4 * material.exponent + 2), 0.25F);
  return 1;
}

Json documentFor(const Pack& pack) {
  const Float3& c = pack.base_color;
  Json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "Bakelight"}};
  document["extensionsUsed"] = Json::array({kTransferExtension});
  document["scene"] = 0;
  document["scenes"] = {{{"nodes", {0}}}};
  document["nodes"] = {{{"mesh", 0}, {"name", pack.name}}};
  document["materials"] = {{{"pbrMetallicRoughness",
                             {{"baseColorFactor", {c[0], c[1], c[2], 1.0F}},
                              {"metallicFactor", 0},
                              {"roughnessFactor", viewerRoughness(pack.transfer.material)}}}}};
  return document;
}

class PackEncoder {
 public:
  // With `draco`, `pack` has its vertices in the order of draco->decoded.
  PackEncoder(const Pack& pack, const DracoMesh* draco) : pack_(pack), draco_(draco) {}

  Bytes encode(const std::string& file) {
    document_ = documentFor(pack_);
    Json primitive = draco_ != nullptr ? dracoPrimitive() : plainPrimitive();
    addVertexAttribute(primitive, "TANGENT", "tangents", pack_.transfer.tangents, "VEC4");
    addVertexAttribute(primitive, "COLOR_0", "colors", pack_.colors, "VEC3");
    primitive["extensions"][kTransferExtension] = transferExtension();
    document_["meshes"] = {{{"name", pack_.name}, {"primitives", {std::move(primitive)}}}};
    return writer_.finish(std::move(document_), file);
  }

 private:
  // Appends an accessor to the document and returns its index.
  std::size_t add(Json accessor_json) {
    document_["accessors"].push_back(std::move(accessor_json));
    return document_["accessors"].size() - 1;
  }

  // The accessors of the mesh, whose bytes lie in the views given (none with Draco).
  struct MeshViews {
    std::optional<int> indices, positions, normals, texcoords;
  };

  Json primitiveOf(const MeshViews& views) {
    const TriangleMesh& mesh = pack_.mesh;
    const std::size_t count = mesh.vertexCount();
    Json primitive = {{"mode", 4}, {"material", 0}};
    primitive["indices"] = add(accessor(views.indices, kUint32Component, mesh.triangleCount() * 3, "SCALAR"));
    Json& attributes = primitive["attributes"];
    attributes["POSITION"] = add(positionAccessor(views.positions, mesh.positions));
    attributes["NORMAL"] = add(accessor(views.normals, kFloat32Component, count, "VEC3"));
    if (!mesh.texcoords.empty()) {
      attributes["TEXCOORD_0"] = add(accessor(views.texcoords, kFloat32Component, count, "VEC2"));
    }
    return primitive;
  }

  Json plainPrimitive() {
    const TriangleMesh& mesh = pack_.mesh;
    MeshViews views;
    views.indices = writer_.addSection("indices", bytesOf(mesh.triangles), GlbTarget::kIndices);
    views.positions = writer_.addSection("positions", bytesOf(mesh.positions), GlbTarget::kVertices);
    views.normals = writer_.addSection("normals", bytesOf(mesh.normals), GlbTarget::kVertices);
    if (!mesh.texcoords.empty()) {
      texcoords_ = flippedTexcoords(mesh.texcoords);
      views.texcoords = writer_.addSection("texcoords", bytesOf(texcoords_), GlbTarget::kVertices);
    }
    return primitiveOf(views);
  }

  Json dracoPrimitive() {
    const DracoAttributes& attributes = draco_->attributes;
    Json ids = {{"POSITION", attributes.position}, {"NORMAL", attributes.normal}};
    if (attributes.texcoord >= 0) ids["TEXCOORD_0"] = attributes.texcoord;
    const int view = writer_.addSection("draco", draco_->bytes, GlbTarget::kNone);
    document_["extensionsUsed"].push_back(kDracoExtension);
    document_["extensionsRequired"] = Json::array({kDracoExtension});
    Json primitive = primitiveOf({});
    primitive["extensions"][kDracoExtension] = {{"bufferView", view}, {"attributes", std::move(ids)}};
    return primitive;
  }

  // Stays outside of Draco, which the extension allows.
  template <class Value>
  void addVertexAttribute(Json& primitive, const char* attribute, const char* section,
                          const std::vector<Value>& values, const char* type) {
    if (values.empty()) return;
    const int view = writer_.addSection(section, bytesOf(values), GlbTarget::kVertices);
    primitive["attributes"][attribute] = add(accessor(view, kFloat32Component, values.size(), type));
  }

  int addSection(const std::string& name, std::span<const std::byte> bytes) {
    return writer_.addSection(name, bytes, GlbTarget::kNone);
  }

  Json table(const std::string& section, const EncodedTable& table) {
    Json json = {{"precision", nameOf(table.precision)}, {"rows", table.rows}, {"columns", table.columns}};
    json["bufferView"] = addSection(section, table.data);
    if (table.precision == Precision::kUint8) {
      json["scale"] = addSection(section + "Scale", bytesOf(table.scale));
      json["offset"] = addSection(section + "Offset", bytesOf(table.offset));
    }
    return json;
  }

  Json transferExtension() {
    const RadianceTransfer& transfer = pack_.transfer;
    Json json = {{"technique", transfer.storage == MatrixStorage::kNone ? "diffuse" : "glossy"},
                 {"transport", transfer.transport},
                 {"order", transfer.order},
                 {"channels", transfer.channels},
                 {"basis", kBasis},
                 {"frame", "object"},
                 {"inversePi", "inside"},
                 {"albedo", "outside"}};
    json["transfer"] = table("transfer", transfer.vectors);
    if (!transfer.near_vectors.empty()) {
      json["nearField"] = {{"center", transfer.sphere_center}, {"radius", transfer.sphere_radius}};
      json["nearField"]["transfer"] = table("nearTransfer", transfer.near_vectors);
    }
    if (transfer.storage != MatrixStorage::kNone) json["glossy"] = glossy();
    return json;
  }

  Json glossy() {
    const RadianceTransfer& transfer = pack_.transfer;
    const char* section = matrixSection(transfer.storage);
    const bool object_frame = transfer.storage == MatrixStorage::kVisibility;
    Json json = {{"storage", nameOf(transfer.storage)},
                 {"rowOrder", transfer.row_order},
                 {"frame", object_frame ? "object" : "local"}};
    json[section] = table(section, transfer.matrices);
    if (transfer.storage == MatrixStorage::kCpca) {
      json["clusters"] = {{"count", transfer.basis.rows / (1 + transfer.matrices.columns)},
                          {"bufferView", addSection("clusters", bytesOf(transfer.clusters))}};
      json["basis"] = table("basis", transfer.basis);
    }
    if (transfer.material.model != LobeModel::kNone) json["lobe"] = lobe(transfer.material);
    return json;
  }

  Json lobe(const GlossyMaterial& material) {
    Json json = {{"model", nameOf(material.model)}};
    if (material.model == LobeModel::kTable) {
      json["angles"] = material.table.angles;
      json["order"] = material.table.order;
      json["bufferView"] = addSection("brdf", bytesOf(material.table.values));
      return json;
    }
    json["specularColor"] = material.specular_color;
    if (material.model == LobeModel::kPhong) json["exponent"] = material.exponent;
    if (material.model == LobeModel::kGgx) json["roughness"] = material.roughness;
    return json;
  }

  const Pack& pack_;
  const DracoMesh* draco_;
  std::vector<Float2> texcoords_;
  Json document_;
  GlbWriter writer_;
};

// ---- in the order of the Draco mesh

template <class Value>
std::vector<Value> permuted(const std::vector<Value>& values,
                            const std::vector<std::uint32_t>& source_from_target) {
  std::vector<Value> result;
  if (values.empty()) return result;
  result.reserve(source_from_target.size());
  for (const std::uint32_t source : source_from_target) result.push_back(values[source]);
  return result;
}

EncodedTable permuted(const EncodedTable& table, const std::vector<std::uint32_t>& source_from_target) {
  if (table.empty()) return {};
  EncodedTable result = table;
  const std::size_t row_bytes = table.rowBytes();
  result.rows = source_from_target.size();
  result.data.resize(result.rows * row_bytes);
  for (std::size_t row = 0; row < result.rows; ++row) {
    std::memcpy(result.data.data() + row * row_bytes, table.data.data() + source_from_target[row] * row_bytes,
                row_bytes);
  }
  return result;
}

// Quantised normals are off by a fraction of a degree; the frame stays one of right angles.
void turnTowardsNormals(std::vector<Float4>& tangents, const std::vector<Float3>& normals) {
  for (std::size_t i = 0; i < tangents.size(); ++i) {
    Float4& t = tangents[i];
    const Float3& n = normals[i];
    const float along = t[0] * n[0] + t[1] * n[1] + t[2] * n[2];
    for (std::size_t axis = 0; axis < 3; ++axis) t[axis] -= along * n[axis];
    const float length = std::hypot(t[0], t[1], t[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) t[axis] /= length;
  }
}

Pack inOrderOf(const DracoMesh& draco, const Pack& pack, const PackOptions& options) {
  const auto& order = draco.source_from_decoded;
  const RadianceTransfer& source = pack.transfer;
  Pack result{pack.name, draco.decoded, pack.base_color, permuted(pack.colors, order), {}};
  RadianceTransfer& target = result.transfer;
  target.order = source.order;
  target.transport = source.transport;
  target.channels = source.channels;
  target.vectors = permuted(source.vectors, order);
  target.near_vectors = permuted(source.near_vectors, order);
  target.sphere_center = source.sphere_center;
  target.sphere_radius = source.sphere_radius;
  target.storage = source.storage;
  target.row_order = source.row_order;
  target.tangents = permuted(source.tangents, order);
  target.matrices = permuted(source.matrices, order);
  target.clusters = permuted(source.clusters, order);
  target.basis = source.basis;  // a row a cluster, not a vertex
  target.material = source.material;
  if (options.normal_bits > 0) turnTowardsNormals(target.tangents, draco.decoded.normals);
  return result;
}

}  // namespace

Bytes encodeCheckedPack(const Pack& pack, const PackOptions& options, const std::string& file) {
  if (!options.draco) return PackEncoder(pack, nullptr).encode(file);
  TriangleMesh mesh = pack.mesh;
  mesh.texcoords = flippedTexcoords(mesh.texcoords);
  const DracoMesh draco = encodeDraco(mesh, options.position_bits, options.normal_bits, file);
  const Pack reordered = inOrderOf(draco, pack, options);
  return PackEncoder(reordered, &draco).encode(file);
}

}  // namespace bakelight::formats
