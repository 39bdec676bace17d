#include "formats/mesh_ply.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/hash.h"

namespace bakelight::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are copied into the file as they are in memory");

enum class ScalarType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
  std::string name;
  std::optional<ScalarType> list_count;  // of a list property
  ScalarType type;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

constexpr const char* kImportRemedy = "run the simplify tool on it first, which reads any mesh file";

std::size_t sizeOf(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kFloat64:
      return 8;
    default:
      return 4;
  }
}

std::optional<ScalarType> scalarTypeNamed(std::string_view name) {
  struct Name {
    std::string_view short_name, long_name;
  };
  constexpr Name kNames[] = {{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                             {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                             {"float", "float32"}, {"double", "float64"}};
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if (name == kNames[i].short_name || name == kNames[i].long_name) return static_cast<ScalarType>(i);
  }
  return std::nullopt;
}

template <class T>
T valueAt(const std::byte* data) {
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

std::int64_t integerAt(const std::byte* data, ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return valueAt<std::int8_t>(data);
    case ScalarType::kUint8:
      return valueAt<std::uint8_t>(data);
    case ScalarType::kInt16:
      return valueAt<std::int16_t>(data);
    case ScalarType::kUint16:
      return valueAt<std::uint16_t>(data);
    case ScalarType::kInt32:
      return valueAt<std::int32_t>(data);
    case ScalarType::kUint32:
      return valueAt<std::uint32_t>(data);
    default:
      throw std::logic_error("not an integer type");
  }
}

bool isInteger(ScalarType type) {
  return type < ScalarType::kFloat32;
}

class PlyReader {
 public:
  PlyReader(std::span<const std::byte> bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  TriangleMesh read() {
    readHeader();
    TriangleMesh mesh;
    for (const Element& element : elements_) {
      if (element.name == "vertex") {
        readVertices(element, mesh);
      } else if (element.name == "face") {
        readFaces(element, mesh);
      } else if (!element.properties.empty()) {
        for (std::uint64_t row = 0; row < element.count; ++row) skipRow(element, row);
      }
    }
    if (position_ != bytes_.size()) {
      throw error("", std::to_string(bytes_.size() - position_) + " bytes follow the last element",
                  "the end of the file");
    }
    checkIndices(mesh);
    return mesh;
  }

 private:
  Error error(const std::string& element, const std::string& what, const std::string& expected,
              const std::string& remedy = "") const {
    return badInput({file_, element, ""}, what, expected, remedy);
  }

  // ---- header

  std::string_view headerLine() {
    const auto* text = reinterpret_cast<const char*>(bytes_.data());
    const std::string_view rest(text + position_, bytes_.size() - position_);
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) {
      throw error("header", "the file ends inside the header", "a line end_header", "make the file again");
    }
    position_ += end + 1;
    std::string_view line = rest.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  static std::vector<std::string_view> words(std::string_view line) {
    std::vector<std::string_view> result;
    while (true) {
      const std::size_t begin = line.find_first_not_of(" \t");
      if (begin == std::string_view::npos) return result;
      const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
      result.push_back(line.substr(begin, end - begin));
      line.remove_prefix(end);
    }
  }

  void readHeader() {
    constexpr std::string_view kMagic = "ply";
    if (bytes_.size() < 4 || std::memcmp(bytes_.data(), kMagic.data(), kMagic.size()) != 0 ||
        headerLine() != kMagic) {
      throw error("", "this is not a PLY file", "a first line that says ply", kImportRemedy);
    }
    bool has_format = false;
    while (true) {
      const std::string_view line = headerLine();
      const auto word = words(line);
      if (word.empty() || word[0] == "comment" || word[0] == "obj_info") continue;
      if (word[0] == "end_header") break;
      if (word[0] == "format") {
        readFormat(line, word);
        has_format = true;
      } else if (word[0] == "element") {
        readElement(line, word);
      } else if (word[0] == "property") {
        readProperty(line, word);
      } else {
        throw malformed(line);
      }
    }
    if (!has_format) throw error("header", "there is no format line", "format binary_little_endian 1.0");
  }

  Error malformed(std::string_view line) const {
    return error("header", "the line '" + std::string(line.substr(0, 80)) + "' is malformed",
                 "format, element, property, comment or end_header");
  }

  void readFormat(std::string_view line, std::span<const std::string_view> word) const {
    if (word.size() != 3) throw malformed(line);
    if (word[1] != "binary_little_endian" || word[2] != "1.0") {
      throw error("header", "the format is " + std::string(word[1]) + " " + std::string(word[2]),
                  "binary_little_endian 1.0 between stages", kImportRemedy);
    }
  }

  void readElement(std::string_view line, std::span<const std::string_view> word) {
    Element element;
    if (word.size() != 3) throw malformed(line);
    element.name = word[1];
    const char* end = word[2].data() + word[2].size();
    const auto [rest, status] = std::from_chars(word[2].data(), end, element.count);
    if (status != std::errc() || rest != end) throw malformed(line);
    for (const Element& other : elements_) {
      if (other.name == element.name)
        throw error("header", "the element " + element.name + " stands twice", "once");
    }
    elements_.push_back(std::move(element));
  }

  void readProperty(std::string_view line, std::span<const std::string_view> word) {
    if (elements_.empty()) throw malformed(line);
    const bool is_list = word.size() == 5 && word[1] == "list";
    if (!is_list && word.size() != 3) throw malformed(line);
    const auto type = scalarTypeNamed(word[is_list ? 3 : 1]);
    if (!type) throw malformed(line);
    Property property{std::string(word.back()), std::nullopt, *type};
    if (is_list) {
      property.list_count = scalarTypeNamed(word[2]);
      if (!property.list_count || !isInteger(*property.list_count)) throw malformed(line);
    }
    elements_.back().properties.push_back(std::move(property));
  }

  // ---- body

  const std::byte* take(std::uint64_t size, const Element& element, std::uint64_t row) {
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

  List takeList(const Property& property, const Element& element, std::uint64_t row) {
    const std::int64_t count =
        integerAt(take(sizeOf(*property.list_count), element, row), *property.list_count);
    if (count < 0) {
      throw error(element.name + " " + std::to_string(row),
                  "a list has " + std::to_string(count) + " members", "0 or more");
    }
    // A count has at most 32 bits, so the product stays far below 64.
    return {static_cast<std::uint64_t>(count),
            take(static_cast<std::uint64_t>(count) * sizeOf(property.type), element, row)};
  }

  void skipRow(const Element& element, std::uint64_t row) {
    for (const Property& property : element.properties) {
      if (property.list_count) {
        takeList(property, element, row);
      } else {
        take(sizeOf(property.type), element, row);
      }
    }
  }

  // Byte offset in a vertex row of a float32 property, if there is one.
  std::optional<std::size_t> floatOffset(const Element& element, const std::string& name) const {
    std::size_t offset = 0;
    for (const Property& property : element.properties) {
      if (property.name == name) {
        if (property.type == ScalarType::kFloat32) return offset;
        throw error("header", "the vertex property " + name + " is not float",
                    "float (32 bits) between stages", kImportRemedy);
      }
      offset += sizeOf(property.type);
    }
    return std::nullopt;
  }

  // Byte offsets of a group of properties, or nothing if none of it is there.
  template <std::size_t N>
  std::optional<std::array<std::size_t, N>> floatOffsets(const Element& element,
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

  void readVertices(const Element& element, TriangleMesh& mesh) {
    std::size_t row_size = 0;
    for (const Property& property : element.properties) {
      if (property.list_count) {
        throw error("header", "the vertex property " + property.name + " is a list", "numbers",
                    kImportRemedy);
      }
      row_size += sizeOf(property.type);
    }
    const auto position = floatOffsets<3>(element, {"x", "y", "z"});
    const auto normal = floatOffsets<3>(element, {"nx", "ny", "nz"});
    const auto texcoord = floatOffsets<2>(element, {"s", "t"});
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
    for (std::uint64_t row = 0; row < element.count; ++row) {
      const std::byte* data = take(row_size, element, row);
      mesh.positions.push_back(floatsAt(data, *position, row, "position"));
      if (normal) mesh.normals.push_back(floatsAt(data, *normal, row, "normal"));
      if (texcoord) mesh.texcoords.push_back(floatsAt(data, *texcoord, row, "texture coordinate"));
    }
  }

  void readFaces(const Element& element, TriangleMesh& mesh) {
    bool has_indices = false;
    for (const Property& property : element.properties) has_indices |= isIndexList(property);
    if (!has_indices)
      throw error("header", "faces have no vertices", "property list uchar uint vertex_indices");
    mesh.triangles.reserve(std::min<std::uint64_t>(element.count, bytes_.size() - position_));
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const Property& property : element.properties) {
        if (isIndexList(property)) {
          mesh.triangles.push_back(triangleFrom(takeList(property, element, row), property, row));
        } else if (property.list_count) {
          takeList(property, element, row);
        } else {
          take(sizeOf(property.type), element, row);
        }
      }
    }
  }

  static bool isIndexList(const Property& property) {
    return property.list_count && isInteger(property.type) &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
  }

  Triangle triangleFrom(const List& list, const Property& property, std::uint64_t row) const {
    if (list.count != 3) {
      throw error("face " + std::to_string(row), "it has " + std::to_string(list.count) + " corners",
                  "triangles between stages", kImportRemedy);
    }
    Triangle triangle;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::int64_t index = integerAt(list.data + corner * sizeOf(property.type), property.type);
      if (index < 0) throw indexError(row, index);
      triangle[corner] = static_cast<std::uint32_t>(index);
    }
    return triangle;
  }

  Error indexError(std::uint64_t row, std::int64_t index) const {
    return error("face " + std::to_string(row), "vertex " + std::to_string(index) + " does not exist",
                 "the index of a vertex, counted from 0", "make the file again");
  }

  void checkIndices(const TriangleMesh& mesh) const {
    for (std::size_t row = 0; row < mesh.triangles.size(); ++row) {
      for (const std::uint32_t index : mesh.triangles[row]) {
        if (index >= mesh.vertexCount()) throw indexError(row, index);
      }
    }
  }

  std::span<const std::byte> bytes_;
  std::string file_;
  std::size_t position_ = 0;
  std::vector<Element> elements_;
};

// Copies `value` to `target` and returns where the next one goes.
template <class T>
std::byte* put(std::byte* target, const T& value) {
  std::memcpy(target, &value, sizeof value);
  return target + sizeof value;
}

std::string headerOf(const TriangleMesh& mesh) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  header += "element vertex " + std::to_string(mesh.vertexCount()) + "\n";
  for (const char* name : {"x", "y", "z"}) header += std::string("property float ") + name + "\n";
  if (!mesh.normals.empty()) {
    for (const char* name : {"nx", "ny", "nz"}) header += std::string("property float ") + name + "\n";
  }
  if (!mesh.texcoords.empty()) header += "property float s\nproperty float t\n";
  header += "element face " + std::to_string(mesh.triangleCount()) + "\n";
  return header + "property list uchar uint vertex_indices\nend_header\n";
}

}  // namespace

void writePly(const std::filesystem::path& path, const TriangleMesh& mesh) {
  const std::size_t count = mesh.vertexCount();
  if ((!mesh.normals.empty() && mesh.normals.size() != count) ||
      (!mesh.texcoords.empty() && mesh.texcoords.size() != count)) {
    throw std::logic_error("a mesh has normals and texture coordinates for all vertices or for none");
  }
  const std::string header = headerOf(mesh);
  const std::size_t vertex_size = sizeof(Float3) + (mesh.normals.empty() ? 0 : sizeof(Float3)) +
                                  (mesh.texcoords.empty() ? 0 : sizeof(Float2));
  Bytes bytes(header.size() + count * vertex_size + mesh.triangleCount() * (1 + sizeof(Triangle)));
  std::memcpy(bytes.data(), header.data(), header.size());
  std::byte* cursor = bytes.data() + header.size();
  for (std::size_t i = 0; i < count; ++i) {
    cursor = put(cursor, mesh.positions[i]);
    if (!mesh.normals.empty()) cursor = put(cursor, mesh.normals[i]);
    if (!mesh.texcoords.empty()) cursor = put(cursor, mesh.texcoords[i]);
  }
  for (const Triangle& triangle : mesh.triangles) cursor = put(put(cursor, std::uint8_t{3}), triangle);
  writeFileAtomically(path, bytes);
}

TriangleMesh readPly(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  return PlyReader(bytes, path.string()).read();
}

std::string geometryHash(const TriangleMesh& mesh) {
  // Hashed one by one and then together, so that bytes which move from one array to the next change the name.
  return contentHash(contentHash(std::as_bytes(std::span(mesh.positions))) +
                     contentHash(std::as_bytes(std::span(mesh.normals))) +
                     contentHash(std::as_bytes(std::span(mesh.triangles))));
}

}  // namespace bakelight::formats
