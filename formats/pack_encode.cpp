#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <list>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "formats/draco_mesh.h"
#include "formats/pack_check.h"
#include "formats/pack_layout.h"
#include "formats/pixel_transfer.h"
#include "formats/translucency.h"

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

Json positionAccessor(std::optional<int> view, std::span<const Float3> positions) {
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

// What comes nearest to a lobe among glTF's materials, for viewers that do not know the extension. A Phong
// exponent becomes that of the half angle, four times as large (Fisher & Woo 1994), then
// alpha² = 2 / (exponent + 2).
float viewerRoughness(const PackPart& reflection) {
  if (const auto* ggx = reflection.as<GgxLobe>()) return ggx->roughness;
  if (const auto* phong = reflection.as<PhongLobe>()) return std::pow(2 / (4 * phong->exponent + 2), 0.25F);
  return 1;
}

constexpr const char* kIor = "KHR_materials_ior";
constexpr const char* kDiffuseTransmission = "KHR_materials_diffuse_transmission";
constexpr const char* kVolume = "KHR_materials_volume";

// For viewers that do not know the extension: e^(−attenuation · d) is attenuationColor at attenuationDistance, for which the color that
// falls fastest tells the scale.
Json volumeOf(const TranslucencyFallback& fallback) {
  Json volume = {{"thicknessFactor", fallback.thickness}};
  const float greatest = *std::max_element(fallback.attenuation.begin(), fallback.attenuation.end());
  if (!(greatest > 0)) return volume;
  Float3 color;
  for (std::size_t c = 0; c < 3; ++c) color[c] = std::exp(-fallback.attenuation[c] / greatest);
  volume["attenuationColor"] = color;
  volume["attenuationDistance"] = std::min(1 / greatest, std::numeric_limits<float>::max());
  return volume;
}

// Triangles of one appearance, and with Draco the vertices of its own.
struct Primitive {
  std::vector<Triangle> triangles;
  const DracoMesh* draco = nullptr;
  std::size_t first_vertex = 0, vertex_count = 0;  // with Draco: the decoded ones
};

// Writes the fields of a part as JSON, their bytes as sections.
class FieldWriter final : public FieldVisitor {
 public:
  // Bytes that the sections need and nobody else keeps go to `kept`.
  FieldWriter(GlbWriter& writer, std::list<Bytes>& kept) : writer_(writer), kept_(kept) {}

  Json finish() { return std::move(open_.front()); }
  const std::vector<Float4>* tangentsFound() const { return tangents_; }

  void integer(const char* name, int& value, const Range&) override { top()[name] = value; }
  void number(const char* name, float& value, const Range&) override { top()[name] = value; }
  void vector(const char* name, Float3& value, const Range&) override { top()[name] = value; }
  void constant(const char* name, const char* text) override { top()[name] = text; }
  void choice(const char* name, int& value, std::span<const char* const> names) override {
    top()[name] = names[static_cast<std::size_t>(value)];
  }

  void table(const char* name, EncodedTable& table, Rows, std::size_t) override {
    top()[name] = tableJson(name, table);
  }
  void floats(const char* name, std::vector<float>& values, std::size_t) override {
    top()[name] = array("float32", {values.size()}, section(name, bytesOf(values)));
  }
  void integers(const char* name, IntegerArray& values, std::size_t) override {
    top()[name] = array(nameOfIntegers(values.width), {values.count()},
                        section(name, std::span(values.data.data(), values.data.size())));
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t end) override {
    if (end <= 1U << 8) return narrow<std::uint8_t>(name, values, "uint8");
    if (end <= 1U << 16) return narrow<std::uint16_t>(name, values, "uint16");
    top()[name] = array("uint32", {values.size()}, section(name, bytesOf(values)));
  }
  void tangents(const char*, std::vector<Float4>& values) override { tangents_ = &values; }
  void image(const char* name, PackImage& image) override {
    Json json = tableJson(name, image.texels);
    json["shape"] = {image.height, image.width, image.channels.size()};
    json["channels"] = image.channels;
    top()[name] = std::move(json);
  }

  bool open(const char* name, bool is_there) override {
    if (!is_there) return false;
    names_.emplace_back(name);
    open_.push_back(Json::object());
    return true;
  }
  void close() override {
    Json group = std::move(open_.back());
    open_.pop_back();
    top()[names_.back()] = std::move(group);
    names_.pop_back();
  }
  void require(bool, const char*, const std::string&, const std::string&, const std::string&) override {}

 private:
  Json& top() { return open_.back(); }
  int section(const std::string& name, std::span<const std::byte> bytes) {
    return writer_.addSection(name, bytes, GlbTarget::kNone);
  }
  static Json array(const char* type, std::vector<std::size_t> shape, int view) {
    return {{"type", type}, {"shape", std::move(shape)}, {"bufferView", view}};
  }
  template <class Narrow>
  void narrow(const char* name, const std::vector<std::uint32_t>& values, const char* type) {
    Bytes& bytes = kept_.emplace_back(values.size() * sizeof(Narrow));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto value = static_cast<Narrow>(values[i]);
      std::memcpy(bytes.data() + i * sizeof value, &value, sizeof value);
    }
    top()[name] = array(type, {values.size()}, section(name, bytes));
  }
  Json tableJson(const std::string& name, const EncodedTable& table) {
    Json json = array(nameOf(table.precision), {table.rows, table.columns}, section(name, table.data));
    if (table.precision == Precision::kUint8) {
      json["scale"] = section(name + "Scale", bytesOf(table.scale));
      json["offset"] = section(name + "Offset", bytesOf(table.offset));
    }
    return json;
  }

  GlbWriter& writer_;
  std::list<Bytes>& kept_;
  std::vector<Json> open_ = {Json::object()};
  std::vector<std::string> names_;
  const std::vector<Float4>* tangents_ = nullptr;
};

class PackEncoder {
 public:
  PackEncoder(Pack& pack, const std::vector<Primitive>& primitives) : pack_(pack), primitives_(primitives) {}

  Bytes encode(const std::string& file) {
    document_["asset"] = {{"version", "2.0"}, {"generator", "Bakelight"}};
    document_["extensionsUsed"] = Json::array({kTransferExtension});
    document_["scene"] = 0;
    document_["scenes"] = {{{"nodes", {0}}}};
    document_["nodes"] = {{{"mesh", 0}, {"name", pack_.name}}};
    Json mesh = {{"name", pack_.name}};
    Json& primitives = mesh["primitives"] = Json::array();
    addMesh(primitives);
    mesh["extensions"][kTransferExtension] = fieldsOf(pack_.transfer);
    if (tangents_ != nullptr) addVertexAttribute(primitives, "TANGENT", "tangents", *tangents_, "VEC4");
    addVertexAttribute(primitives, "COLOR_0", "colors", pack_.colors, "VEC3");
    document_["meshes"] = {std::move(mesh)};
    for (Appearance& appearance : pack_.appearances) document_["materials"].push_back(materialOf(appearance));
    if (pack_.neighborhood)
      document_["nodes"][0]["extensions"][kTransferExtension] = fieldsOf(*pack_.neighborhood);
    return writer_.finish(std::move(document_), file);
  }

 private:
  Json fieldsOf(PackPart& part) {
    FieldWriter fields(writer_, kept_);
    part.describe(fields);
    if (fields.tangentsFound() != nullptr) tangents_ = fields.tangentsFound();
    Json json = fields.finish();
    json["kind"] = part.kind();
    return json;
  }

  Json materialOf(Appearance& appearance) {
    const auto* translucency = appearance.reflection.as<Translucency>();
    Float3 c = appearance.base_color;
    for (std::size_t i = 0; i < 3 && translucency != nullptr; ++i)
      c[i] *= translucency->fallback.reflectance[i];
    Json material = {{"pbrMetallicRoughness",
                      {{"baseColorFactor", {c[0], c[1], c[2], 1.0F}},
                       {"metallicFactor", 0},
                       {"roughnessFactor", viewerRoughness(appearance.reflection)}}}};
    if (!appearance.material.empty()) material["name"] = appearance.material;
    material["extensions"][kTransferExtension] = fieldsOf(appearance.reflection);
    if (translucency != nullptr) addFallback(material["extensions"], *translucency, appearance.base_color);
    return material;
  }

  void addFallback(Json& extensions, const Translucency& translucency, const Float3& stain) {
    const auto add = [&](const char* name, Json content) {
      document_["extensionsUsed"].push_back(name);
      extensions[name] = std::move(content);
    };
    const TranslucencyFallback& fallback = translucency.fallback;
    extensions[kTransferExtension]["stain"] = stain;
    add(kIor, {{"ior", translucency.eta}});
    if (!(fallback.thickness > 0)) return;
    Float3 color = stain;
    for (std::size_t i = 0; i < 3; ++i) color[i] *= fallback.transmission_color[i];
    add(kDiffuseTransmission,
        {{"diffuseTransmissionFactor", fallback.transmission}, {"diffuseTransmissionColorFactor", color}});
    add(kVolume, volumeOf(fallback));
  }

  // Appends an accessor to the document and returns its index.
  std::size_t add(Json accessor_json) {
    document_["accessors"].push_back(std::move(accessor_json));
    return document_["accessors"].size() - 1;
  }

  void addMesh(Json& primitives) {
    const bool draco = primitives_.front().draco != nullptr;
    if (draco) {
      document_["extensionsUsed"].push_back(kDracoExtension);
      document_["extensionsRequired"] = Json::array({kDracoExtension});
    }
    for (std::size_t i = 0; i < primitives_.size(); ++i) {
      Json primitive = {{"mode", 4}, {"material", i}};
      std::optional<int> indices;
      if (!draco)
        indices = writer_.addSection("indices", bytesOf(primitives_[i].triangles), GlbTarget::kIndices);
      primitive["indices"] =
          add(accessor(indices, kUint32Component, primitives_[i].triangles.size() * 3, "SCALAR"));
      if (draco) addDraco(primitive, primitives_[i]);
      primitives.push_back(std::move(primitive));
    }
    if (!draco) addPlainVertices(primitives);
  }

  // All primitives share the vertices.
  void addPlainVertices(Json& primitives) {
    const TriangleMesh& mesh = pack_.mesh;
    const int positions = writer_.addSection("positions", bytesOf(mesh.positions), GlbTarget::kVertices);
    const std::size_t accessor_index = add(positionAccessor(positions, mesh.positions));
    for (Json& primitive : primitives) primitive["attributes"]["POSITION"] = accessor_index;
    addVertexAttribute(primitives, "NORMAL", "normals", mesh.normals, "VEC3");
    if (mesh.texcoords.empty()) return;
    texcoords_ = flippedTexcoords(mesh.texcoords);
    addVertexAttribute(primitives, "TEXCOORD_0", "texcoords", texcoords_, "VEC2");
  }

  void addDraco(Json& primitive, const Primitive& part) {
    const DracoAttributes& attributes = part.draco->attributes;
    Json ids = {{"POSITION", attributes.position}, {"NORMAL", attributes.normal}};
    if (attributes.texcoord >= 0) ids["TEXCOORD_0"] = attributes.texcoord;
    const int view = writer_.addSection("draco", part.draco->bytes, GlbTarget::kNone);
    const std::span<const Float3> positions =
        std::span(pack_.mesh.positions).subspan(part.first_vertex, part.vertex_count);
    Json& into = primitive["attributes"];
    into["POSITION"] = add(positionAccessor({}, positions));
    into["NORMAL"] = add(accessor({}, kFloat32Component, part.vertex_count, "VEC3"));
    if (attributes.texcoord >= 0)
      into["TEXCOORD_0"] = add(accessor({}, kFloat32Component, part.vertex_count, "VEC2"));
    primitive["extensions"][kDracoExtension] = {{"bufferView", view}, {"attributes", std::move(ids)}};
  }

  // Stays outside of Draco, which the extension allows; each primitive has its part of the section then.
  template <class Value>
  void addVertexAttribute(Json& primitives, const char* attribute, const char* section,
                          const std::vector<Value>& values, const char* type) {
    if (values.empty()) return;
    const int view = writer_.addSection(section, bytesOf(values), GlbTarget::kVertices);
    const bool draco = primitives_.front().draco != nullptr;
    std::optional<std::size_t> shared;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (!draco) {
        if (!shared) shared = add(accessor(view, kFloat32Component, values.size(), type));
        primitives[i]["attributes"][attribute] = *shared;
        continue;
      }
      Json part = accessor(view, kFloat32Component, primitives_[i].vertex_count, type);
      if (primitives_[i].first_vertex > 0) part["byteOffset"] = primitives_[i].first_vertex * sizeof(Value);
      primitives[i]["attributes"][attribute] = add(std::move(part));
    }
  }

  Pack& pack_;
  const std::vector<Primitive>& primitives_;
  const std::vector<Float4>* tangents_ = nullptr;
  std::vector<Float2> texcoords_;
  std::list<Bytes> kept_;
  Json document_;
  GlbWriter writer_;
};

// ---- primitives

std::vector<Primitive> primitivesOf(const Pack& pack) {
  std::vector<Primitive> primitives(pack.appearances.size());
  const TriangleMesh& mesh = pack.mesh;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    primitives[primitives.size() == 1 ? 0 : mesh.triangle_materials[t]].triangles.push_back(
        mesh.triangles[t]);
  return primitives;
}

// The vertices of one appearance and its triangles.
TriangleMesh partOf(const TriangleMesh& mesh, const VertexRange& range, std::vector<Triangle> triangles) {
  TriangleMesh part;
  const auto copy = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    to.assign(from.begin() + static_cast<std::ptrdiff_t>(range.first),
              from.begin() + static_cast<std::ptrdiff_t>(range.end));
  };
  copy(mesh.positions, part.positions);
  copy(mesh.normals, part.normals);
  copy(mesh.texcoords, part.texcoords);
  part.texcoords = flippedTexcoords(part.texcoords);
  part.triangles = std::move(triangles);
  for (Triangle& t : part.triangles)
    for (std::uint32_t& v : t) v -= static_cast<std::uint32_t>(range.first);
  return part;
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

Bytes encodeWithDraco(const Pack& pack, const PackOptions& options, const std::string& file) {
  const std::vector<VertexRange> ranges = appearanceRanges(pack);
  std::vector<Primitive> primitives = primitivesOf(pack);
  std::vector<DracoMesh> draco;
  draco.reserve(primitives.size());
  std::vector<std::uint32_t> order;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    Primitive& primitive = primitives[i];
    draco.push_back(encodeDraco(partOf(pack.mesh, ranges[i], std::move(primitive.triangles)),
                                options.position_bits, options.normal_bits, file));
    primitive.draco = &draco.back();
    primitive.triangles = draco.back().decoded.triangles;
    primitive.first_vertex = order.size();
    primitive.vertex_count = draco.back().decoded.vertexCount();
    for (const std::uint32_t v : draco.back().source_from_decoded)
      order.push_back(v + static_cast<std::uint32_t>(ranges[i].first));
  }
  Pack reordered = pack;
  permuteVertices(reordered, order);
  std::size_t next = 0;
  for (const DracoMesh& part : draco)
    for (std::size_t v = 0; v < part.decoded.vertexCount(); ++v, ++next) {
      reordered.mesh.positions[next] = part.decoded.positions[v];
      reordered.mesh.normals[next] = part.decoded.normals[v];
    }
  if (auto* sh = reordered.transfer.as<ShTransfer>(); sh != nullptr && sh->glossy && options.normal_bits > 0)
    turnTowardsNormals(sh->glossy->tangents, reordered.mesh.normals);
  if (auto* pixel = reordered.transfer.as<PixelTransfer>(); pixel != nullptr && options.normal_bits > 0)
    turnTowardsNormals(pixel->tangents, reordered.mesh.normals);
  return PackEncoder(reordered, primitives).encode(file);
}

}  // namespace

Bytes encodeCheckedPack(const Pack& pack, const PackOptions& options, const std::string& file) {
  if (options.draco) return encodeWithDraco(pack, options, file);
  // Field lists are for reading and writing; this visitor only looks.
  return PackEncoder(const_cast<Pack&>(pack), primitivesOf(pack)).encode(file);
}

}  // namespace bakelight::formats
