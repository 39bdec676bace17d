#include "formats/pack_check.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "formats/error.h"
#include "formats/rtt_reflection.h"
#include "formats/translucency.h"

namespace bakelight::formats {
namespace {

// Of a length that should be 1, and of a cosine that should be 0; the Khronos validator asks for 5e-3 or so.
constexpr float kUnitTolerance = 1e-3F;
constexpr std::uint16_t kHalfExponent = 0x7C00;

template <std::size_t N>
bool isFinite(const std::array<float, N>& values) {
  return std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); });
}

float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// False for NaN, too.
bool isUnit(const Float3& v) {
  return std::abs(std::sqrt(dot(v, v)) - 1) <= kUnitTolerance;
}

bool isReflectance(const Float3& color) {
  return std::all_of(color.begin(), color.end(), [](float value) { return value >= 0 && value <= 1; });
}

// Judges the fields of a part by what its list says of them.
class FieldChecker final : public FieldVisitor {
 public:
  FieldChecker(const TriangleMesh& mesh, const std::string& file, std::string part)
      : mesh_(mesh), file_(file), part_(std::move(part)) {}

  void integer(const char* name, int& value, const Range& range) override {
    checkRange(name, value, std::to_string(value), range);
  }
  void number(const char* name, float& value, const Range& range) override {
    checkRange(name, value, std::to_string(value), range);
  }
  void vector(const char* name, Float3& value, const Range& range) override {
    for (const float component : value) checkRange(name, component, std::to_string(component), range);
  }
  void choice(const char* name, int& value, std::span<const char* const> names) override {
    require(value >= 0 && static_cast<std::size_t>(value) < names.size(), name, "there is no such choice",
            "less than " + std::to_string(names.size()), "");
  }
  void constant(const char*, const char*) override {}

  void table(const char* name, EncodedTable& table, Rows rows, std::size_t columns) override {
    const std::string element = std::string("section ") + name;
    const std::size_t expected = rows == Rows::kVertex ? mesh_.vertexCount() : table.rows;
    const std::string shape = rows == Rows::kVertex ? std::to_string(expected) + " vertices × " +
                                                          std::to_string(columns) + " values"
                                                    : "rows of " + std::to_string(columns) + " values";
    if (table.rows != expected || table.columns != columns) {
      throw error(element,
                  "it has " + std::to_string(table.rows) + " rows of " + std::to_string(table.columns), shape,
                  "bake the transfer again, for this mesh");
    }
    checkTable(element, table, shape);
  }
  void floats(const char* name, std::vector<float>& values, std::size_t count) override {
    const std::string element = std::string("section ") + name;
    if (values.size() != count)
      throw error(element, "it has " + std::to_string(values.size()) + " values", std::to_string(count));
    for (std::size_t i = 0; i < count; ++i)
      if (!std::isfinite(values[i]))
        throw error(element, "value " + std::to_string(i) + " is not finite", "a number");
  }
  void integers(const char* name, IntegerArray& values, std::size_t count) override {
    if (values.data.size() != count * values.width)
      throw error(std::string("section ") + name, "it has " + std::to_string(values.data.size()) + " bytes",
                  std::to_string(count) + " integers of " + std::to_string(values.width) + " bytes");
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t end) override {
    const std::string element = std::string("section ") + name;
    checkCount(element, values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] >= end)
        throw error(element + ", vertex " + std::to_string(i), "it is " + std::to_string(values[i]),
                    "less than " + std::to_string(end));
  }
  void tangents(const char* name, std::vector<Float4>& values) override {
    checkCount(name, values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Float4& t = values[i];
      const Float3 tangent = {t[0], t[1], t[2]};
      const std::string element = name + std::string(", vertex ") + std::to_string(i);
      if (!isUnit(tangent) || std::abs(t[3]) != 1)
        throw error(element, "it is no unit vector with a sign", "length 1, and 1 or -1");
      if (!(std::abs(dot(tangent, mesh_.normals[i])) <= kUnitTolerance))
        throw error(element, "it is not at right angles to the normal", "a frame of the same mesh");
    }
  }
  void image(const char* name, PackImage& image) override {
    const std::string element = std::string("section ") + name;
    const auto texels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::string shape = std::to_string(image.width) + " × " + std::to_string(image.height) +
                              " texels of " + std::to_string(image.channels.size()) + " channels";
    if (image.width < 1 || image.height < 1 || image.channels.empty() || image.texels.rows != texels ||
        image.texels.columns != image.channels.size())
      throw error(element,
                  "it has " + std::to_string(image.texels.rows) + " texels of " +
                      std::to_string(image.texels.columns),
                  shape);
    checkTable(element, image.texels, shape);
  }

  bool open(const char* name, bool is_there) override {
    if (is_there) groups_.emplace_back(name);
    return is_there;
  }
  void close() override { groups_.pop_back(); }

  void require(bool holds, const char* name, const std::string& what, const std::string& expected,
               const std::string& remedy) override {
    if (!holds) throw error(elementOf(name), what, expected, remedy);
  }

 private:
  Error error(const std::string& element, const std::string& what, const std::string& expected,
              const std::string& remedy = "") const {
    return badInput({file_, element, ""}, what, expected, remedy);
  }
  std::string elementOf(const char* name) const {
    std::string element = part_;
    for (const std::string& group : groups_) element += ", " + group;
    return element + ", " + name;
  }
  void checkRange(const char* name, double value, const std::string& text, const Range& range) const {
    if (!range.holds(value)) throw error(elementOf(name), "it is " + text, textOf(range));
  }
  void checkCount(const std::string& element, std::size_t count) const {
    if (count == mesh_.vertexCount()) return;
    throw error(element, "it has " + std::to_string(count) + " entries",
                "one for each of the " + std::to_string(mesh_.vertexCount()) + " vertices");
  }

  void checkTable(const std::string& element, const EncodedTable& table, const std::string& shape) const {
    const auto bytes = checkedProduct({table.rows, table.columns, bytesPerValue(table.precision)});
    const std::size_t ranges = table.precision == Precision::kUint8 ? table.columns : 0;
    if (!bytes || table.data.size() != *bytes || table.scale.size() != ranges ||
        table.offset.size() != ranges) {
      throw error(element, "its data do not have the size that rows, columns and precision ask for", shape);
    }
    checkFinite(table, element);
  }

  void checkFinite(const EncodedTable& table, const std::string& element) const {
    const auto notFinite = [&](std::size_t i) {
      return error(element + ", row " + std::to_string(i / table.columns),
                   "value " + std::to_string(i % table.columns) + " is not finite", "a number");
    };
    for (std::size_t i = 0; i < table.scale.size(); ++i) {
      if (!std::isfinite(table.offset[i] + table.scale[i] * 255) || !std::isfinite(table.offset[i]))
        throw error(element + ", column " + std::to_string(i), "its range is not finite", "numbers");
    }
    const std::size_t count = table.rows * table.columns;
    for (std::size_t i = 0; i < count && table.precision == Precision::kFloat32; ++i) {
      float value;
      std::memcpy(&value, table.data.data() + i * sizeof value, sizeof value);
      if (!std::isfinite(value)) throw notFinite(i);
    }
    for (std::size_t i = 0; i < count && table.precision == Precision::kFloat16; ++i) {
      std::uint16_t bits;
      std::memcpy(&bits, table.data.data() + i * sizeof bits, sizeof bits);
      if ((bits & kHalfExponent) == kHalfExponent) throw notFinite(i);
    }
  }

  const TriangleMesh& mesh_;
  const std::string& file_;
  std::string part_;
  std::vector<std::string> groups_;
};

class Checker {
 public:
  Checker(const Pack& pack, const std::string& file) : mesh_(pack.mesh), pack_(pack), file_(file) {}

  void check() const {
    checkMeshSizes();
    checkVertices();
    checkTriangles();
    checkColors();
    checkAppearances();
    // Field lists are for reading and writing; these visitors only look.
    auto& pack = const_cast<Pack&>(pack_);
    FieldChecker transfer(mesh_, file_, "transfer");
    pack.transfer.describe(transfer);
    for (std::size_t i = 0; i < pack.appearances.size(); ++i) {
      FieldChecker reflection(mesh_, file_, "material " + std::to_string(i));
      pack.appearances[i].reflection.describe(reflection);
      checkCombination(pack.appearances[i].reflection, "material " + std::to_string(i));
    }
    if (pack.neighborhood) {
      FieldChecker neighborhood(mesh_, file_, "neighborhood");
      pack.neighborhood->describe(neighborhood);
    }
  }

 private:
  Error error(const std::string& element, const std::string& what, const std::string& expected,
              const std::string& remedy = "") const {
    return badInput({file_, element, ""}, what, expected, remedy);
  }

  void checkCount(const char* section, std::size_t count, const std::string& remedy = "") const {
    if (count == mesh_.vertexCount()) return;
    throw error(section, "it has " + std::to_string(count) + " entries",
                "one for each of the " + std::to_string(mesh_.vertexCount()) + " vertices", remedy);
  }

  void checkMeshSizes() const {
    const std::size_t count = mesh_.vertexCount();
    if (count == 0 || mesh_.triangles.empty()) {
      throw error("mesh", "it has no " + std::string(count == 0 ? "vertex" : "triangle"),
                  "at least one triangle");
    }
    if (count >= std::numeric_limits<std::uint32_t>::max()) {
      throw error("mesh", "it has " + std::to_string(count) + " vertices", "fewer than 4,294,967,295");
    }
    checkCount("normals", mesh_.normals.size(), "run the simplify tool on the mesh, which computes them");
    if (!mesh_.texcoords.empty()) checkCount("texcoords", mesh_.texcoords.size());
  }

  void checkVertices() const {
    for (std::size_t i = 0; i < mesh_.vertexCount(); ++i) {
      const bool texcoord_ok = mesh_.texcoords.empty() || isFinite(mesh_.texcoords[i]);
      if (!isFinite(mesh_.positions[i]) || !isFinite(mesh_.normals[i]) || !texcoord_ok) {
        throw error("vertex " + std::to_string(i), "it has values that are not finite", "numbers");
      }
      if (!isUnit(mesh_.normals[i])) {
        throw error(
            "vertex " + std::to_string(i),
            "its normal has length " + std::to_string(std::sqrt(dot(mesh_.normals[i], mesh_.normals[i]))),
            "1");
      }
    }
  }

  void checkTriangles() const {
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      for (const std::uint32_t index : mesh_.triangles[i]) {
        if (index < mesh_.vertexCount()) continue;
        throw error("triangle " + std::to_string(i), "vertex " + std::to_string(index) + " does not exist",
                    "less than " + std::to_string(mesh_.vertexCount()));
      }
    }
  }

  void checkColors() const {
    if (pack_.colors.empty()) return;
    checkCount("colors", pack_.colors.size());
    for (std::size_t i = 0; i < pack_.colors.size(); ++i) {
      if (isReflectance(pack_.colors[i])) continue;
      throw error("colors, vertex " + std::to_string(i), "it is out of range", "0 to 1");
    }
  }

  void checkAppearances() const {
    const std::size_t count = pack_.appearances.size();
    if (count == 0) throw error("materials", "there is none", "one or more");
    for (std::size_t i = 0; i < count; ++i)
      if (!isReflectance(pack_.appearances[i].base_color))
        throw error("material " + std::to_string(i), "its base colour is out of range", "0 to 1");
    if (count == 1) return;
    std::vector<std::size_t> triangles(count);
    if (mesh_.triangle_materials.size() != mesh_.triangleCount())
      throw error("materials", "triangles do not say which they have", "an index a triangle");
    for (const std::uint32_t material : mesh_.triangle_materials)
      if (material >= count)
        throw error("materials", "there is no material " + std::to_string(material),
                    "less than " + std::to_string(count));
      else
        ++triangles[material];
    for (std::size_t i = 0; i < count; ++i)
      if (triangles[i] == 0)
        throw error("material " + std::to_string(i), "no triangle has it", "one or more");
    try {
      appearanceRanges(pack_);
    } catch (const std::invalid_argument& problem) {
      throw error("materials", problem.what(), "vertices in the order of materials, none shared by two");
    }
  }

  void checkTranslucency(const std::string& element) const {
    if (pack_.transfer.as<ShTransfer>() == nullptr)
      throw error(element, "a translucent object needs transfer vectors", "transfer in spherical harmonics");
    if (pack_.appearances.size() != 1)
      throw error(element, "a translucent object has other materials", "one", "bake them apart");
    if (mesh_.texcoords.size() != mesh_.vertexCount())
      throw error(element, "a translucent object needs texture coordinates", "a mesh with them", "an atlas");
  }

  // What reflects transferred radiance needs the operator that transfers it.
  void checkCombination(const PackPart& reflection, const std::string& element) const {
    const auto* table = reflection.as<BrdfTable>();
    const auto* rtt = reflection.as<RttReflection>();
    if (reflection.as<Translucency>() != nullptr) return checkTranslucency(element);
    if (table == nullptr && rtt == nullptr && reflection.as<PhongLobe>() == nullptr &&
        reflection.as<GgxLobe>() == nullptr)
      return;
    const auto* transfer = pack_.transfer.as<ShTransfer>();
    if (transfer == nullptr || !transfer->glossy)
      throw error(element, std::string("reflection ") + reflection.kind() + " needs transfer matrices",
                  "glossy transfer, or lambert");
    if (table != nullptr && table->order < transfer->glossy->output_order)
      throw error(element + ", brdf", "its order is " + std::to_string(table->order),
                  std::to_string(transfer->glossy->output_order) + " (the transfer's output order) to 10",
                  "project the BRDF again at that order");
    if (rtt == nullptr) return;
    if (rtt->order > transfer->glossy->output_order)
      throw error(element + ", order", "its order is " + std::to_string(rtt->order),
                  "1 to " + std::to_string(transfer->glossy->output_order) + " (the transfer's output order)",
                  "bake transfer with a row_order of the texture's order");
    if (mesh_.texcoords.size() != mesh_.vertexCount())
      throw error(element, "a radiance transfer texture needs texture coordinates", "a mesh with them",
                  "an atlas");
  }

  const TriangleMesh& mesh_;
  const Pack& pack_;
  const std::string& file_;
};

}  // namespace

void checkPack(const Pack& pack, const std::string& file) {
  Checker(pack, file).check();
}

std::optional<std::uint64_t> checkedProduct(std::initializer_list<std::uint64_t> factors) {
  std::uint64_t product = 1;
  for (const std::uint64_t factor : factors) {
    if (factor != 0 && product > std::numeric_limits<std::uint64_t>::max() / factor) return std::nullopt;
    product *= factor;
  }
  return product;
}

}  // namespace bakelight::formats
