#include "formats/draco_mesh.h"

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

constexpr int kEncodingSpeed = 0, kDecodingSpeed = 0;  // the smallest result: packs are written once

Error dracoError(const std::string& file, const std::string& what) {
  return badInput({file, "section draco", ""}, what, "", "write the pack without Draco");
}

template <class Value>
int addAttribute(draco::Mesh& target, draco::GeometryAttribute::Type role, draco::DataType type,
                 const std::vector<Value>& values) {
  constexpr std::size_t kComponentSize = 4;
  draco::GeometryAttribute attribute;
  attribute.Init(role, nullptr, sizeof(Value) / kComponentSize, type, false, sizeof(Value), 0);
  const int id = target.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  draco::PointAttribute& added = *target.attribute(id);
  for (std::uint32_t i = 0; i < values.size(); ++i)
    added.SetAttributeValue(draco::AttributeValueIndex(i), &values[i]);
  return static_cast<int>(added.unique_id());
}

struct DracoInput {
  draco::Mesh mesh;
  DracoAttributes attributes;
  int source_index = -1;
};

void fillInput(DracoInput& input, const TriangleMesh& mesh) {
  using draco::GeometryAttribute;
  input.mesh.set_num_points(static_cast<std::uint32_t>(mesh.vertexCount()));
  input.attributes.position =
      addAttribute(input.mesh, GeometryAttribute::POSITION, draco::DT_FLOAT32, mesh.positions);
  if (!mesh.normals.empty()) {
    input.attributes.normal =
        addAttribute(input.mesh, GeometryAttribute::NORMAL, draco::DT_FLOAT32, mesh.normals);
  }
  if (!mesh.texcoords.empty()) {
    input.attributes.texcoord =
        addAttribute(input.mesh, GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, mesh.texcoords);
  }
  for (const Triangle& triangle : mesh.triangles) {
    input.mesh.AddFace(
        {draco::PointIndex(triangle[0]), draco::PointIndex(triangle[1]), draco::PointIndex(triangle[2])});
  }
}

Bytes encode(const draco::Mesh& mesh, int position_bits, int normal_bits, const std::string& file) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(kEncodingSpeed, kDecodingSpeed);
  if (position_bits > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  if (normal_bits > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, normal_bits);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeMeshToBuffer(mesh, &buffer);
  if (!status.ok())
    throw dracoError(file, std::string("Draco cannot encode the mesh (") + status.error_msg() + ")");
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return Bytes(bytes.begin(), bytes.end());
}

std::unique_ptr<draco::Mesh> decode(std::span<const std::byte> bytes, const std::string& file) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    throw badInput({file, "section draco", ""},
                   std::string("Draco cannot decode it (") + decoded.status().error_msg() + ")",
                   "a Draco mesh");
  }
  return std::move(decoded).value();
}

template <class Value>
std::vector<Value> attributeValues(const draco::Mesh& mesh, int id, draco::DataType type,
                                   const std::string& file) {
  constexpr std::size_t kComponentSize = 4;
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
  if (attribute == nullptr || attribute->data_type() != type ||
      attribute->num_components() != static_cast<int>(sizeof(Value) / kComponentSize)) {
    throw badInput({file, "section draco", ""},
                   "attribute " + std::to_string(id) + " is missing or has another type",
                   "the attributes that the glTF names");
  }
  std::vector<Value> values(mesh.num_points());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    attribute->GetMappedValue(draco::PointIndex(i), &values[i]);
  }
  return values;
}

TriangleMesh triangleMeshOf(const draco::Mesh& source, const DracoAttributes& attributes,
                            const std::string& file) {
  TriangleMesh mesh;
  mesh.positions = attributeValues<Float3>(source, attributes.position, draco::DT_FLOAT32, file);
  if (attributes.normal >= 0) {
    mesh.normals = attributeValues<Float3>(source, attributes.normal, draco::DT_FLOAT32, file);
  }
  if (attributes.texcoord >= 0) {
    mesh.texcoords = attributeValues<Float2>(source, attributes.texcoord, draco::DT_FLOAT32, file);
  }
  mesh.triangles.reserve(source.num_faces());
  for (std::uint32_t i = 0; i < source.num_faces(); ++i) {
    const auto& face = source.face(draco::FaceIndex(i));
    mesh.triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return mesh;
}

bool sameBits(const TriangleMesh& a, const TriangleMesh& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), std::as_bytes(std::span(x)).size()) == 0);
  };
  return same(a.positions, b.positions) && same(a.normals, b.normals) && same(a.texcoords, b.texcoords) &&
         same(a.triangles, b.triangles);
}

// Triangles in a common order, each beginning at its smallest corner, without those that have two equal
// corners.
std::vector<Triangle> canonicalTriangles(const std::vector<Triangle>& triangles,
                                         const std::vector<std::uint32_t>& vertex_map) {
  std::vector<Triangle> result;
  result.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    Triangle t = {vertex_map[triangle[0]], vertex_map[triangle[1]], vertex_map[triangle[2]]};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    result.push_back(t);
  }
  std::sort(result.begin(), result.end());
  return result;
}

bool isSameSurface(const TriangleMesh& source, const DracoMesh& draco) {
  for (const std::uint32_t vertex : draco.source_from_decoded) {
    if (vertex >= source.vertexCount()) return false;
  }
  std::vector<std::uint32_t> identity(source.vertexCount());
  std::iota(identity.begin(), identity.end(), 0U);
  return canonicalTriangles(source.triangles, identity) ==
         canonicalTriangles(draco.decoded.triangles, draco.source_from_decoded);
}

// Whether vertices carry the very values of their source vertices, where nothing was quantised.
bool keepsValues(const TriangleMesh& source, const DracoMesh& draco, bool check_positions,
                 bool check_normals) {
  for (std::size_t i = 0; i < draco.source_from_decoded.size(); ++i) {
    const std::uint32_t from = draco.source_from_decoded[i];
    if (check_positions && draco.decoded.positions[i] != source.positions[from]) return false;
    if (check_normals && !source.normals.empty() && draco.decoded.normals[i] != source.normals[from])
      return false;
    if (!source.texcoords.empty() && draco.decoded.texcoords[i] != source.texcoords[from]) return false;
  }
  return true;
}

}  // namespace

DracoMesh encodeDraco(const TriangleMesh& mesh, int position_bits, int normal_bits, const std::string& file) {
  // Once with the vertex number as a further attribute, to learn the order; then without it, as it would cost
  // bytes. That both come out in the same order is checked, not assumed.
  DracoInput numbered;
  fillInput(numbered, mesh);
  std::vector<std::array<std::uint32_t, 1>> numbers(mesh.vertexCount());
  for (std::uint32_t i = 0; i < numbers.size(); ++i) numbers[i] = {i};
  numbered.source_index =
      addAttribute(numbered.mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT32, numbers);
  const auto order = decode(encode(numbered.mesh, position_bits, normal_bits, file), file);

  DracoInput plain;
  fillInput(plain, mesh);
  DracoMesh result;
  result.attributes = plain.attributes;
  result.bytes = encode(plain.mesh, position_bits, normal_bits, file);
  result.decoded = decodeDraco(result.bytes, plain.attributes, file);
  for (const auto& [number] :
       attributeValues<std::array<std::uint32_t, 1>>(*order, numbered.source_index, draco::DT_UINT32, file)) {
    result.source_from_decoded.push_back(number);
  }
  if (result.decoded.triangles.empty()) throw dracoError(file, "no triangle has three different corners");
  if (!sameBits(result.decoded, triangleMeshOf(*order, numbered.attributes, file)) ||
      !isSameSurface(mesh, result) || !keepsValues(mesh, result, position_bits == 0, normal_bits == 0)) {
    throw dracoError(file, "Draco does not give back the same surface");
  }
  return result;
}

TriangleMesh decodeDraco(std::span<const std::byte> bytes, const DracoAttributes& attributes,
                         const std::string& file) {
  return triangleMeshOf(*decode(bytes, file), attributes, file);
}

}  // namespace bakelight::formats
