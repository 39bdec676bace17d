#include "formats/pack.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "formats/draco_mesh.h"
#include "formats/error.h"
#include "formats/glb.h"

namespace bakelight::formats {
namespace {

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
constexpr const char* kTechnique = "diffuse_vector";
constexpr const char* kBasis = "real_sh_cartesian";
constexpr int kMaxOrder = 10;
constexpr float kUnitTolerance = 1e-3F;  // of a normal's length; the Khronos validator asks for 5e-3 or so
const std::string kPrimitive = "/meshes/0/primitives/0";

// glTF's number and name of each kind of accessor in use.
enum ComponentType { kUint32Component = 5125, kFloat32Component = 5126 };

// ---- what is true of every pack, before writing and after reading

Error packError(const std::string& file, const std::string& element, const std::string& what,
                const std::string& expected, const std::string& remedy = "") {
  return badInput({file, element, ""}, what, expected, remedy);
}

template <std::size_t N>
bool isFinite(const std::array<float, N>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
}

void checkMesh(const TriangleMesh& mesh, const std::string& file) {
  const std::size_t count = mesh.vertexCount();
  if (count == 0 || mesh.triangles.empty()) {
    throw packError(file, "mesh", "it has no " + std::string(count == 0 ? "vertex" : "triangle"),
                    "at least one triangle");
  }
  if (count >= std::numeric_limits<std::uint32_t>::max()) {
    throw packError(file, "mesh", "it has " + std::to_string(count) + " vertices",
                    "fewer than 4,294,967,295");
  }
  if (mesh.normals.size() != count) {
    throw packError(file, "mesh", "it has " + std::to_string(mesh.normals.size()) + " normals",
                    "one for each of the " + std::to_string(count) + " vertices",
                    "run the simplify tool on it, which computes them");
  }
  if (!mesh.texcoords.empty() && mesh.texcoords.size() != count) {
    throw packError(file, "mesh", "it has " + std::to_string(mesh.texcoords.size()) + " texture coordinates",
                    "none, or one for each of the " + std::to_string(count) + " vertices");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Float3& n = mesh.normals[i];
    const bool texcoord_ok = mesh.texcoords.empty() || isFinite(mesh.texcoords[i]);
    if (!isFinite(mesh.positions[i]) || !isFinite(n) || !texcoord_ok) {
      throw packError(file, "vertex " + std::to_string(i), "it has values that are not finite", "numbers");
    }
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(std::abs(length - 1) <= kUnitTolerance)) {
      throw packError(file, "vertex " + std::to_string(i), "its normal has length " + std::to_string(length),
                      "1");
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t index : mesh.triangles[i]) {
      if (index < count) continue;
      throw packError(file, "triangle " + std::to_string(i),
                      "vertex " + std::to_string(index) + " does not exist",
                      "less than " + std::to_string(count));
    }
  }
}

void checkTransfer(const DiffuseTransfer& transfer, std::size_t vertex_count, const std::string& file) {
  if (transfer.order < 1 || transfer.order > kMaxOrder) {
    throw packError(file, "transfer", "its order is " + std::to_string(transfer.order), "1 to 10");
  }
  if (transfer.visibility != "unshadowed" && transfer.visibility != "shadowed") {
    throw packError(file, "transfer", "its visibility is '" + transfer.visibility + "'",
                    "unshadowed or shadowed");
  }
  const auto coefficients = static_cast<std::size_t>(transfer.order) * transfer.order;
  if (transfer.vectors.size() != vertex_count * coefficients) {
    throw packError(
        file, "transfer", "it has " + std::to_string(transfer.vectors.size()) + " values",
        std::to_string(vertex_count) + " vertices × " + std::to_string(coefficients) + " coefficients",
        "run the transfer tool on this mesh");
  }
  for (std::size_t i = 0; i < transfer.vectors.size(); ++i) {
    if (std::isfinite(transfer.vectors[i])) continue;
    throw packError(file, "transfer of vertex " + std::to_string(i / coefficients),
                    "coefficient " + std::to_string(i % coefficients) + " is not finite", "a number");
  }
}

void checkPack(const Pack& pack, const std::string& file) {
  checkMesh(pack.mesh, file);
  checkTransfer(pack.transfer, pack.mesh.vertexCount(), file);
  for (const float value : pack.base_color) {
    if (!(value >= 0 && value <= 1)) {
      throw packError(file, "base colour", std::to_string(value) + " is out of range", "0 to 1");
    }
  }
}

void checkOptions(const PackOptions& options) {
  const auto isValid = [](int bits, int least) { return bits == 0 || (bits >= least && bits <= 30); };
  if (!isValid(options.position_bits, 8) || !isValid(options.normal_bits, 6)) {
    throw std::logic_error("Draco's bits are out of range");
  }
}

// glTF counts v from the top of an image, a TriangleMesh from the bottom. Its own inverse up to rounding, and
// exact in float for the multiples of 2^-24 in [0, 1].
std::vector<Float2> flippedTexcoords(const std::vector<Float2>& texcoords) {
  std::vector<Float2> result;
  result.reserve(texcoords.size());
  for (const Float2& t : texcoords) result.push_back({t[0], 1 - t[1]});
  return result;
}

// ---- writing

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

// Appends an accessor to the document and returns its index.
std::size_t add(Json& document, Json accessor_json) {
  document["accessors"].push_back(std::move(accessor_json));
  return document["accessors"].size() - 1;
}

// The accessors of `mesh`, whose bytes lie in the views given (none with Draco).
struct MeshViews {
  std::optional<int> indices, positions, normals, texcoords;
};

Json primitiveOf(Json& document, const TriangleMesh& mesh, const MeshViews& views) {
  const std::size_t count = mesh.vertexCount();
  Json primitive = {{"mode", 4}, {"material", 0}};
  primitive["indices"] =
      add(document, accessor(views.indices, kUint32Component, mesh.triangleCount() * 3, "SCALAR"));
  Json& attributes = primitive["attributes"];
  attributes["POSITION"] = add(document, positionAccessor(views.positions, mesh.positions));
  attributes["NORMAL"] = add(document, accessor(views.normals, kFloat32Component, count, "VEC3"));
  if (!mesh.texcoords.empty()) {
    attributes["TEXCOORD_0"] = add(document, accessor(views.texcoords, kFloat32Component, count, "VEC2"));
  }
  return primitive;
}

Json dracoExtension(int view, const DracoAttributes& attributes) {
  Json ids = {{"POSITION", attributes.position}, {"NORMAL", attributes.normal}};
  if (attributes.texcoord >= 0) ids["TEXCOORD_0"] = attributes.texcoord;
  return {{"bufferView", view}, {"attributes", std::move(ids)}};
}

Json transferExtension(int view, const DiffuseTransfer& transfer) {
  return {{"technique", kTechnique},
          {"visibility", transfer.visibility},
          {"order", transfer.order},
          {"basis", kBasis},
          {"frame", "object"},
          {"inversePi", "inside"},
          {"albedo", "outside"},
          {"coefficientsPerVertex", transfer.order * transfer.order},
          {"componentType", static_cast<int>(kFloat32Component)},
          {"bufferView", view}};
}

Json documentFor(const Pack& pack) {
  const Float3& c = pack.base_color;
  Json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "Bakelight"}};
  document["extensionsUsed"] = Json::array({kTransferExtension});
  document["scene"] = 0;
  document["scenes"] = {{{"nodes", {0}}}};
  document["nodes"] = {{{"mesh", 0}, {"name", pack.name}}};
  document["materials"] = {
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {c[0], c[1], c[2], 1.0F}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}}}};
  return document;
}

std::vector<float> permuted(const DiffuseTransfer& transfer,
                            const std::vector<std::uint32_t>& source_from_target) {
  const auto coefficients = static_cast<std::size_t>(transfer.order) * transfer.order;
  std::vector<float> result;
  result.reserve(source_from_target.size() * coefficients);
  for (const std::uint32_t source : source_from_target) {
    const auto row = transfer.vectors.begin() + static_cast<std::ptrdiff_t>(source * coefficients);
    result.insert(result.end(), row, row + static_cast<std::ptrdiff_t>(coefficients));
  }
  return result;
}

Bytes finish(Json document, Json primitive, GlbWriter& writer, const Pack& pack,
             std::span<const float> vectors, const std::string& file) {
  const int view = writer.addSection("transfer", std::as_bytes(vectors), GlbTarget::kNone);
  primitive["extensions"][kTransferExtension] = transferExtension(view, pack.transfer);
  document["meshes"] = {{{"name", pack.name}, {"primitives", {std::move(primitive)}}}};
  return writer.finish(std::move(document), file);
}

Bytes encodePlain(const Pack& pack, const std::string& file) {
  const TriangleMesh& mesh = pack.mesh;
  const auto texcoords = flippedTexcoords(mesh.texcoords);
  GlbWriter writer;
  MeshViews views;
  views.indices = writer.addSection("indices", bytesOf(mesh.triangles), GlbTarget::kIndices);
  views.positions = writer.addSection("positions", bytesOf(mesh.positions), GlbTarget::kVertices);
  views.normals = writer.addSection("normals", bytesOf(mesh.normals), GlbTarget::kVertices);
  if (!texcoords.empty()) {
    views.texcoords = writer.addSection("texcoords", bytesOf(texcoords), GlbTarget::kVertices);
  }
  Json document = documentFor(pack);
  Json primitive = primitiveOf(document, mesh, views);
  return finish(std::move(document), std::move(primitive), writer, pack, pack.transfer.vectors, file);
}

Bytes encodeWithDraco(const Pack& pack, const PackOptions& options, const std::string& file) {
  TriangleMesh mesh = pack.mesh;
  mesh.texcoords = flippedTexcoords(mesh.texcoords);
  const DracoMesh draco = encodeDraco(mesh, options.position_bits, options.normal_bits, file);
  const auto vectors = permuted(pack.transfer, draco.source_from_decoded);
  GlbWriter writer;
  const int view = writer.addSection("draco", draco.bytes, GlbTarget::kNone);
  Json document = documentFor(pack);
  document["extensionsUsed"].push_back(kDracoExtension);
  document["extensionsRequired"] = Json::array({kDracoExtension});
  Json primitive = primitiveOf(document, draco.decoded, {});
  primitive["extensions"][kDracoExtension] = dracoExtension(view, draco.attributes);
  return finish(std::move(document), std::move(primitive), writer, pack, vectors, file);
}

// ---- reading

class PackReader {
 public:
  explicit PackReader(const GlbReader& glb) : glb_(glb) {}

  Pack read() const {
    Pack pack;
    pack.name = glb_.textAt("/meshes/0/name");
    for (std::size_t i = 0; i < 3; ++i) {
      pack.base_color[i] =
          glb_.floatAt("/materials/0/pbrMetallicRoughness/baseColorFactor/" + std::to_string(i));
    }
    pack.mesh = glb_.has(kPrimitive + "/extensions/" + kDracoExtension) ? readDracoMesh() : readPlainMesh();
    pack.mesh.texcoords = flippedTexcoords(pack.mesh.texcoords);
    pack.transfer = readTransfer(pack.mesh.vertexCount());
    return pack;
  }

 private:
  // Pointer of the accessor whose index stands at `pointer`.
  std::string accessorAt(const std::string& pointer) const {
    return "/accessors/" + std::to_string(glb_.unsignedAt(pointer));
  }

  void require(const std::string& pointer, const Json& expected) const {
    if (glb_.at(pointer) != expected) throw glb_.error(pointer, "it has another value", expected.dump());
  }

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
    std::vector<Item> items(bytes.size() / sizeof(Item));
    if (!items.empty()) std::memcpy(items.data(), bytes.data(), bytes.size());
    return items;
  }

  TriangleMesh readPlainMesh() const {
    const std::string attributes = kPrimitive + "/attributes";
    TriangleMesh mesh;
    mesh.positions = readAccessor<Float3>(attributes + "/POSITION", kFloat32Component, "VEC3");
    mesh.normals = readAccessor<Float3>(attributes + "/NORMAL", kFloat32Component, "VEC3");
    if (glb_.has(attributes + "/TEXCOORD_0")) {
      mesh.texcoords = readAccessor<Float2>(attributes + "/TEXCOORD_0", kFloat32Component, "VEC2");
    }
    mesh.triangles = readAccessor<Triangle>(kPrimitive + "/indices", kUint32Component, "SCALAR", 3);
    return mesh;
  }

  int dracoId(const std::string& pointer) const {
    const std::uint64_t id = glb_.unsignedAt(pointer);
    if (id > 255) throw glb_.error(pointer, std::to_string(id) + " is out of range", "0 to 255");
    return static_cast<int>(id);
  }

  TriangleMesh readDracoMesh() const {
    const std::string extension = kPrimitive + "/extensions/" + kDracoExtension;
    const std::string ids = extension + "/attributes";
    DracoAttributes attributes{dracoId(ids + "/POSITION"), dracoId(ids + "/NORMAL"), -1};
    if (glb_.has(ids + "/TEXCOORD_0")) attributes.texcoord = dracoId(ids + "/TEXCOORD_0");
    TriangleMesh mesh = decodeDraco(glb_.sectionAt(extension + "/bufferView"), attributes, glb_.file());
    const std::string count = accessorAt(kPrimitive + "/attributes/POSITION") + "/count";
    if (glb_.unsignedAt(count) != mesh.vertexCount()) {
      throw glb_.error(count, "Draco gives " + std::to_string(mesh.vertexCount()) + " vertices", "as many");
    }
    return mesh;
  }

  DiffuseTransfer readTransfer(std::size_t vertex_count) const {
    const std::string extension = kPrimitive + "/extensions/" + kTransferExtension;
    require(extension + "/technique", kTechnique);
    require(extension + "/basis", kBasis);
    require(extension + "/frame", "object");
    require(extension + "/inversePi", "inside");
    require(extension + "/albedo", "outside");
    require(extension + "/componentType", static_cast<int>(kFloat32Component));
    const std::uint64_t order = glb_.unsignedAt(extension + "/order");
    if (order < 1 || order > kMaxOrder) {
      throw glb_.error(extension + "/order", std::to_string(order) + " is out of range", "1 to 10");
    }
    require(extension + "/coefficientsPerVertex", order * order);
    const auto bytes = glb_.sectionAt(extension + "/bufferView");
    if (bytes.size() != vertex_count * order * order * sizeof(float)) {
      throw glb_.error(
          extension + "/bufferView", "it has " + std::to_string(bytes.size()) + " bytes",
          std::to_string(vertex_count) + " vertices × " + std::to_string(order * order) + " floats");
    }
    DiffuseTransfer transfer{static_cast<int>(order), glb_.textAt(extension + "/visibility"), {}};
    transfer.vectors.resize(bytes.size() / sizeof(float));
    if (!bytes.empty()) std::memcpy(transfer.vectors.data(), bytes.data(), bytes.size());
    return transfer;
  }

  const GlbReader& glb_;
};

}  // namespace

Bytes encodePack(const Pack& pack, const PackOptions& options, const std::string& file) {
  checkOptions(options);
  checkPack(pack, file);
  return options.draco ? encodeWithDraco(pack, options, file) : encodePlain(pack, file);
}

Pack decodePack(std::span<const std::byte> bytes, const std::string& file) {
  const GlbReader glb(bytes, file);
  Pack pack = PackReader(glb).read();
  checkPack(pack, file);
  return pack;
}

void writePack(const std::filesystem::path& path, const Pack& pack, const PackOptions& options) {
  writeFileAtomically(path, encodePack(pack, options, path.string()));
}

Pack readPack(const std::filesystem::path& path) {
  return decodePack(readFile(path), path.string());
}

std::vector<PackSection> packSections(std::span<const std::byte> bytes, const std::string& file) {
  return GlbReader(bytes, file).sections();
}

}  // namespace bakelight::formats
