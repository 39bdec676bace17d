#include "formats/mesh_ply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/hash.h"
#include "formats/json.h"
#include "formats/materials.h"
#include "formats/ply_header.h"
#include "formats/ply_materials.h"

namespace bakelight::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are copied into the file as they are in memory");

// Rounding to float, and what exporters do with three decimals.
constexpr double kNormalLengthTolerance = 1e-3;
constexpr const char* kImportRemedy = "run the simplify tool on it first, which reads any mesh file";

bool isIndexList(const PlyProperty& property) {
  return property.list_count && isInteger(property.type) &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <class T>
T valueAt(const std::byte* data) {
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

class PlyReader {
 public:
  PlyReader(std::span<const std::byte> bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  TriangleMesh read() {
    const PlyHeader header = readHeader();
    TriangleMesh mesh;
    mesh.material_names = plyMaterialNames(header.comments);
    for (const PlyElement& element : header.elements) {
      if (element.name == "vertex") {
        readVertices(element, mesh);
      } else if (element.name == "face") {
        readFaces(element, mesh);
      } else {
        skipRows(element);
      }
    }
    checkEnd();
    checkIndices(mesh);
    return mesh;
  }

  std::vector<std::array<std::uint32_t, 2>> readEdges() {
    const PlyHeader header = readHeader();
    std::uint64_t vertex_count = 0;
    for (const PlyElement& element : header.elements)
      if (element.name == "vertex") vertex_count = element.count;
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (const PlyElement& element : header.elements) {
      if (element.name == "edge")
        readEdges(element, vertex_count, edges);
      else
        skipRows(element);
    }
    checkEnd();
    return edges;
  }

 private:
  PlyHeader readHeader() {
    PlyHeader header = readPlyHeader(bytes_, file_);
    if (header.format != "binary_little_endian" || header.version != "1.0") {
      throw error("header", "the format is " + header.format + " " + header.version,
                  "binary_little_endian 1.0 between stages", kImportRemedy);
    }
    position_ = header.size_bytes;
    return header;
  }

  void checkEnd() const {
    if (position_ != bytes_.size()) {
      throw error("", std::to_string(bytes_.size() - position_) + " bytes follow the last element",
                  "the end of the file");
    }
  }

  Error error(const std::string& element, const std::string& what, const std::string& expected,
              const std::string& remedy = "") const {
    return badInput({file_, element, ""}, what, expected, remedy);
  }

  const std::byte* take(std::uint64_t size, const PlyElement& element, std::uint64_t row) {
    if (size > bytes_.size() - position_) {
      throw error(element.name + " " + std::to_string(row), "the file ends here",
                  std::to_string(element.count) + " rows of " + element.name,
                  "make the file again, it was cut short");
    }
    const std::byte* data = bytes_.data() + position_;
    position_ += size;
    return data;
  }

  struct List {
    std::uint64_t count;
    const std::byte* data;
  };

  List takeList(const PlyProperty& property, const PlyElement& element, std::uint64_t row) {
    const std::int64_t count =
        plyIntegerAt(take(sizeOf(*property.list_count), element, row), *property.list_count);
    if (count < 0) {
      throw error(element.name + " " + std::to_string(row),
                  "a list has " + std::to_string(count) + " members", "0 or more");
    }
    // A count has at most 32 bits, so the product stays far below 64.
    return {static_cast<std::uint64_t>(count),
            take(static_cast<std::uint64_t>(count) * sizeOf(property.type), element, row)};
  }

  void skipRow(const PlyElement& element, std::uint64_t row) {
    for (const PlyProperty& property : element.properties) {
      if (property.list_count) {
        takeList(property, element, row);
      } else {
        take(sizeOf(property.type), element, row);
      }
    }
  }

  void skipRows(const PlyElement& element) {
    if (element.properties.empty()) return;
    for (std::uint64_t row = 0; row < element.count; ++row) skipRow(element, row);
  }

  // Byte offset in a vertex row of a float32 property, if there is one.
  std::optional<std::size_t> floatOffset(const PlyElement& element, const std::string& name) const {
    std::size_t offset = 0;
    for (const PlyProperty& property : element.properties) {
      if (property.name == name) {
        if (property.type == PlyScalar::kFloat32) return offset;
        throw error("header", "the vertex property " + name + " is not float",
                    "float (32 bits) between stages", kImportRemedy);
      }
      offset += sizeOf(property.type);
    }
    return std::nullopt;
  }

  // Byte offsets of a group of properties, or nothing if none of it is there.
  template <std::size_t N>
  std::optional<std::array<std::size_t, N>> floatOffsets(const PlyElement& element,
                                                         const std::array<const char*, N>& names) const {
    std::array<std::size_t, N> offsets{};
    std::size_t present = 0;
    for (std::size_t i = 0; i < N; ++i) {
      if (const auto offset = floatOffset(element, names[i])) offsets[i] = *offset, ++present;
    }
    if (present == 0) return std::nullopt;
    if (present < N) {
      throw error("header", std::string("the vertex properties from ") + names[0] + " on are not complete",
                  std::string(names.front()) + " to " + names.back());
    }
    return offsets;
  }

  // Float colours are those that writePly writes; others (8 bits, by custom) are not linear and left to
  // importMesh.
  std::optional<std::array<std::size_t, 3>> linearColor(const PlyElement& element) const {
    for (const PlyProperty& property : element.properties)
      if (property.name == "red" && property.type != PlyScalar::kFloat32) return std::nullopt;
    return floatOffsets<3>(element, {"red", "green", "blue"});
  }

  template <std::size_t N>
  std::array<float, N> floatsAt(const std::byte* row_data, const std::array<std::size_t, N>& offsets,
                                std::uint64_t row, const char* what) const {
    std::array<float, N> values;
    for (std::size_t i = 0; i < N; ++i) {
      values[i] = valueAt<float>(row_data + offsets[i]);
      if (!std::isfinite(values[i])) {
        throw error("vertex " + std::to_string(row), std::string("its ") + what + " is not finite",
                    "a number", "repair the mesh in its modelling program");
      }
    }
    return values;
  }

  // One of length 1e29 would be taken at its word by all that follows.
  Float3 unitLength(const Float3& normal, std::uint64_t row) const {
    double squared = 0;
    for (const float x : normal) squared += static_cast<double>(x) * x;
    const double length = std::sqrt(squared);
    if (std::abs(length - 1) <= kNormalLengthTolerance) return normal;
    throw error("vertex " + std::to_string(row), "its normal has no unit length",
                "length 1 to within " + Json(kNormalLengthTolerance).dump() + ", not " + Json(length).dump(),
                "run the simplify tool on the mesh, which makes normals");
  }

  void readVertices(const PlyElement& element, TriangleMesh& mesh) {
    std::size_t row_size = 0;
    for (const PlyProperty& property : element.properties) {
      if (property.list_count) {
        throw error("header", "the vertex property " + property.name + " is a list", "numbers",
                    kImportRemedy);
      }
      row_size += sizeOf(property.type);
    }
    const auto position = floatOffsets<3>(element, {"x", "y", "z"});
    const auto normal = floatOffsets<3>(element, {"nx", "ny", "nz"});
    const auto texcoord = floatOffsets<2>(element, {"s", "t"});
    const auto color = linearColor(element);
    if (!position) throw error("header", "vertices have no position", "float properties x, y and z");
    // Before anything is allocated: a hostile count must not ask for memory that the file cannot fill.
    if (element.count > (bytes_.size() - position_) / row_size) {
      throw error("vertex " + std::to_string((bytes_.size() - position_) / row_size), "the file ends here",
                  std::to_string(element.count) + " vertices of " + std::to_string(row_size) + " bytes",
                  "make the file again, it was cut short");
    }
    mesh.positions.reserve(element.count);
    if (normal) mesh.normals.reserve(element.count);
    if (texcoord) mesh.texcoords.reserve(element.count);
    if (color) mesh.colors.reserve(element.count);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      const std::byte* data = take(row_size, element, row);
      mesh.positions.push_back(floatsAt(data, *position, row, "position"));
      if (normal) mesh.normals.push_back(unitLength(floatsAt(data, *normal, row, "normal"), row));
      if (texcoord) mesh.texcoords.push_back(floatsAt(data, *texcoord, row, "texture coordinate"));
      if (color) mesh.colors.push_back(floatsAt(data, *color, row, "colour"));
    }
  }

  void readFaces(const PlyElement& element, TriangleMesh& mesh) {
    bool has_indices = false;
    for (const PlyProperty& property : element.properties) has_indices |= isIndexList(property);
    if (!has_indices)
      throw error("header", "faces have no vertices", "property list uchar uint vertex_indices");
    mesh.triangles.reserve(std::min<std::uint64_t>(element.count, bytes_.size() - position_));
    // Without names they are those of another program.
    const auto isMaterial = [&](const PlyProperty& property) {
      return property.name == kPlyMaterialIndex && !property.list_count && isInteger(property.type) &&
             !mesh.material_names.empty();
    };
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : element.properties) {
        if (isIndexList(property)) {
          mesh.triangles.push_back(triangleFrom(takeList(property, element, row), property, row));
        } else if (property.list_count) {
          takeList(property, element, row);
        } else if (const std::byte* data = take(sizeOf(property.type), element, row); isMaterial(property)) {
          mesh.triangle_materials.push_back(
              materialFrom(plyIntegerAt(data, property.type), row, mesh.material_names.size()));
        }
      }
    }
    if (mesh.triangle_materials.empty()) mesh.material_names.clear();
  }

  std::uint32_t materialFrom(std::int64_t index, std::uint64_t row, std::size_t count) const {
    if (index < 0 || static_cast<std::uint64_t>(index) >= count) {
      throw error("face " + std::to_string(row), "material " + std::to_string(index) + " does not exist",
                  "the index of one of the header's " + std::to_string(count) + " materials, counted from 0",
                  "make the file again");
    }
    return static_cast<std::uint32_t>(index);
  }

  Triangle triangleFrom(const List& list, const PlyProperty& property, std::uint64_t row) const {
    if (list.count != 3) {
      throw error("face " + std::to_string(row), "it has " + std::to_string(list.count) + " corners",
                  "triangles between stages", kImportRemedy);
    }
    Triangle triangle;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::int64_t index = plyIntegerAt(list.data + corner * sizeOf(property.type), property.type);
      if (index < 0) throw indexError("face", row, index);
      triangle[corner] = static_cast<std::uint32_t>(index);
    }
    return triangle;
  }

  Error indexError(const std::string& element, std::uint64_t row, std::int64_t index) const {
    return error(element + " " + std::to_string(row), "vertex " + std::to_string(index) + " does not exist",
                 "the index of a vertex, counted from 0", "make the file again");
  }

  void readEdges(const PlyElement& element, std::uint64_t vertex_count,
                 std::vector<std::array<std::uint32_t, 2>>& edges) {
    const auto hasEnd = [&](const char* name) {
      return std::any_of(element.properties.begin(), element.properties.end(), [&](const PlyProperty& p) {
        return p.name == name && !p.list_count && isInteger(p.type);
      });
    };
    if (!hasEnd("vertex1") || !hasEnd("vertex2"))
      throw error("header", "edges have no vertices", "integer properties vertex1 and vertex2");
    for (std::uint64_t row = 0; row < element.count; ++row) {
      std::array<std::uint32_t, 2> edge = {};
      for (const PlyProperty& property : element.properties) {
        if (property.list_count) {
          takeList(property, element, row);
          continue;
        }
        const std::byte* data = take(sizeOf(property.type), element, row);
        if (property.name != "vertex1" && property.name != "vertex2") continue;
        const std::int64_t index = plyIntegerAt(data, property.type);
        if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count)
          throw indexError("edge", row, index);
        edge[property.name == "vertex2"] = static_cast<std::uint32_t>(index);
      }
      edges.push_back(edge);
    }
  }

  void checkIndices(const TriangleMesh& mesh) const {
    for (std::size_t row = 0; row < mesh.triangles.size(); ++row) {
      for (const std::uint32_t index : mesh.triangles[row]) {
        if (index >= mesh.vertexCount()) throw indexError("face", row, index);
      }
    }
  }

  std::span<const std::byte> bytes_;
  std::string file_;
  std::size_t position_ = 0;
};

// Copies `value` to `target` and returns where the next one goes.
template <class T>
std::byte* put(std::byte* target, const T& value) {
  std::memcpy(target, &value, sizeof value);
  return target + sizeof value;
}

std::string headerOf(const TriangleMesh& mesh) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (std::size_t m = 0; m < mesh.material_names.size(); ++m)
    header += "comment" + plyMaterialComment(m, mesh.material_names[m]) + "\n";
  header += "element vertex " + std::to_string(mesh.vertexCount()) + "\n";
  for (const char* name : {"x", "y", "z"}) header += std::string("property float ") + name + "\n";
  if (!mesh.normals.empty()) {
    for (const char* name : {"nx", "ny", "nz"}) header += std::string("property float ") + name + "\n";
  }
  if (!mesh.texcoords.empty()) header += "property float s\nproperty float t\n";
  if (!mesh.colors.empty()) {
    for (const char* name : {"red", "green", "blue"}) header += std::string("property float ") + name + "\n";
  }
  header += "element face " + std::to_string(mesh.triangleCount()) + "\n";
  header += "property list uchar uint vertex_indices\n";
  if (!mesh.triangle_materials.empty()) header += std::string("property uint ") + kPlyMaterialIndex + "\n";
  return header + "end_header\n";
}

}  // namespace

void writePly(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const std::size_t count = mesh.vertexCount();
  if ((!mesh.normals.empty() && mesh.normals.size() != count) ||
      (!mesh.texcoords.empty() && mesh.texcoords.size() != count) ||
      (!mesh.colors.empty() && mesh.colors.size() != count)) {
    throw std::logic_error(
        "a mesh has normals, texture coordinates and colours for all vertices or for none");
  }
  requireMaterials(mesh);
  const std::string header = headerOf(mesh);
  const std::size_t vertex_size = sizeof(Float3) + (mesh.normals.empty() ? 0 : sizeof(Float3)) +
                                  (mesh.texcoords.empty() ? 0 : sizeof(Float2)) +
                                  (mesh.colors.empty() ? 0 : sizeof(Float3));
  const bool has_materials = !mesh.triangle_materials.empty();
  const std::size_t face_size = 1 + sizeof(Triangle) + (has_materials ? sizeof(std::uint32_t) : 0);
  Bytes bytes(header.size() + count * vertex_size + mesh.triangleCount() * face_size);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::byte* cursor = bytes.data() + header.size();
  for (std::size_t i = 0; i < count; ++i) {
    cursor = put(cursor, mesh.positions[i]);
    if (!mesh.normals.empty()) cursor = put(cursor, mesh.normals[i]);
    if (!mesh.texcoords.empty()) cursor = put(cursor, mesh.texcoords[i]);
    if (!mesh.colors.empty()) cursor = put(cursor, mesh.colors[i]);
  }
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    cursor = put(put(cursor, std::uint8_t{3}), mesh.triangles[t]);
    if (has_materials) cursor = put(cursor, mesh.triangle_materials[t]);
  }
  writeFileAtomically(path, bytes);
}

TriangleMesh readPly(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  return PlyReader(bytes, path.string()).read();
}

bool isStagePly(const std::filesystem::path& path) {
  if (lowerEnding(path) != ".ply") return false;
  const auto isOurs = [](const PlyElement& element, const PlyProperty& property) {
    static constexpr std::string_view kVertex[] = {"x", "y", "z",   "nx",    "ny",  "nz",
                                                   "s", "t", "red", "green", "blue"};
    if (element.name == "vertex")
      return !property.list_count && property.type == PlyScalar::kFloat32 &&
             std::find(std::begin(kVertex), std::end(kVertex), property.name) != std::end(kVertex);
    if (element.name == "face") return isIndexList(property) || property.name == kPlyMaterialIndex;
    return element.name == "edge";
  };
  try {
    const PlyHeader header = readPlyHeader(readFile(path), path.string());
    if (header.format != "binary_little_endian") return false;
    for (const PlyElement& element : header.elements)
      for (const PlyProperty& property : element.properties)
        if (!isOurs(element, property)) return false;
    return true;
  } catch (const Error&) {
    return false;
  }
}

std::vector<std::array<std::uint32_t, 2>> readPlyEdges(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  return PlyReader(bytes, path.string()).readEdges();
}

std::string geometryHash(const TriangleMesh& mesh) {
  // Hashed one by one and then together, so that bytes which move from one array to the next change the name.
  return contentHash(contentHash(std::as_bytes(std::span(mesh.positions))) +
                     contentHash(std::as_bytes(std::span(mesh.normals))) +
                     contentHash(std::as_bytes(std::span(mesh.triangles))));
}

}  // namespace bakelight::formats
