#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/pack_reading.h"
#include "formats/pixel_transfer.h"
#include "formats/translucency.h"

namespace bakelight::formats {
namespace {

const std::string kMesh = "/meshes/0";
const std::string kTransfer = kMesh + "/extensions/" + kTransferExtension;
const std::string kNeighborhood = std::string("/nodes/0/extensions/") + kTransferExtension;

// Fills the fields of a part from its JSON. What is out of range is found by checkPack; here only what cannot
// be read at all is refused.
class FieldReader final : public FieldVisitor, private PackReading {
 public:
  // `pointer` is the part's object.
  FieldReader(const GlbReader& glb, std::string pointer, const std::vector<Float4>& tangents)
      : PackReading(glb), pointer_(std::move(pointer)), tangents_(tangents) {}

  void integer(const char* name, int& value, const Range& range) override {
    value =
        intAt(at(name), static_cast<std::uint64_t>(range.least), static_cast<std::uint64_t>(range.greatest));
  }
  void number(const char* name, float& value, const Range&) override { value = glb_.floatAt(at(name)); }
  void vector(const char* name, Float3& value, const Range&) override { value = float3At(at(name)); }
  void constant(const char* name, const char* text) override { require(at(name), text); }
  void choice(const char* name, int& value, std::span<const char* const> names) override {
    const std::string text = glb_.textAt(at(name));
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end()) {
      std::string known;
      for (const char* one : names) known += (known.empty() ? "" : ", ") + std::string(one);
      throw glb_.error(at(name), "'" + text + "' is not known", "one of " + known);
    }
    value = static_cast<int>(found - names.begin());
  }

  void table(const char* name, EncodedTable& table, Rows, std::size_t) override {
    table = readTable(at(name), "type", glb_.unsignedAt(at(name) + "/shape/0"),
                      glb_.unsignedAt(at(name) + "/shape/1"));
  }
  void floats(const char* name, std::vector<float>& values, std::size_t) override {
    require(at(name) + "/type", "float32");
    values = readValues<float>(at(name) + "/bufferView", glb_.unsignedAt(at(name) + "/shape/0"));
  }
  void integers(const char* name, IntegerArray& values, std::size_t) override {
    require(at(name) + "/type", nameOfIntegers(values.width));
    const std::uint64_t count = glb_.unsignedAt(at(name) + "/shape/0");
    values.data = glb_.shared(sectionOfSize(at(name) + "/bufferView", checkedProduct({count, values.width}),
                                            std::to_string(count) + " integers"));
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t) override {
    const std::string type = glb_.textAt(at(name) + "/type"), view = at(name) + "/bufferView";
    const std::uint64_t count = glb_.unsignedAt(at(name) + "/shape/0");
    if (type == "uint8") {
      widen(readValues<std::uint8_t>(view, count), values);
    } else if (type == "uint16") {
      widen(readValues<std::uint16_t>(view, count), values);
    } else if (type == "uint32") {
      values = readValues<std::uint32_t>(view, count);
    } else {
      throw glb_.error(at(name) + "/type", "'" + type + "' is not known", "uint8, uint16 or uint32");
    }
  }
  void tangents(const char*, std::vector<Float4>& values) override { values = tangents_; }
  void image(const char* name, PackImage& image) override {
    image.height = intAt(at(name) + "/shape/0", 1, kMostTexels);
    image.width = intAt(at(name) + "/shape/1", 1, kMostTexels);
    const int channels = intAt(at(name) + "/shape/2", 1, kMostChannels);
    image.channels.clear();
    for (int c = 0; c < channels; ++c)
      image.channels.push_back(glb_.textAt(at(name) + "/channels/" + std::to_string(c)));
    image.texels = readTable(
        at(name), "type", static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height),
        static_cast<std::uint64_t>(channels));
  }

  bool open(const char* name, bool) override {
    if (!glb_.has(at(name))) return false;
    groups_.push_back(pointer_);
    pointer_ = at(name);
    return true;
  }
  void close() override {
    pointer_ = groups_.back();
    groups_.pop_back();
  }
  void require(bool, const char*, const std::string&, const std::string&, const std::string&) override {}

 private:
  static constexpr std::uint64_t kMostTexels = 1 << 16, kMostChannels = 1024;

  using PackReading::require;
  std::string at(const char* name) const { return pointer_ + "/" + name; }
  template <class Narrow>
  static void widen(const std::vector<Narrow>& from, std::vector<std::uint32_t>& to) {
    to.assign(from.begin(), from.end());
  }

  std::string pointer_;
  std::vector<std::string> groups_;
  const std::vector<Float4>& tangents_;
};

class PackReader : private PackReading {
 public:
  explicit PackReader(const GlbReader& glb) : PackReading(glb) {}

  Pack read() {
    Pack pack;
    pack.name = glb_.textAt(kMesh + "/name");
    for (std::size_t i = 0; i < glb_.at("/materials").size(); ++i)
      primitives_.push_back(kMesh + "/primitives/" + std::to_string(i));
    if (primitives_.empty()) throw glb_.error("/materials", "it is empty", "one material or more");
    if (glb_.at(kMesh + "/primitives").size() != primitives_.size())
      throw glb_.error(kMesh + "/primitives", "there is not one for each material",
                       std::to_string(primitives_.size()));
    for (std::size_t i = 0; i < primitives_.size(); ++i) require(primitives_[i] + "/material", i);
    readMesh(pack.mesh);
    pack.colors = readAttribute<Float3>("COLOR_0", "VEC3");
    const auto tangents = readAttribute<Float4>("TANGENT", "VEC4");
    pack.transfer = readPart(kTransfer, transferKinds(), tangents);
    if (auto* pixel = pack.transfer.as<PixelTransfer>(); pixel != nullptr && pixel->sums)
      pixel->sums->grammar = std::make_shared<const SumGrammar>(decodeSums(codedSumsOf(*pixel), glb_.file()));
    pack.appearances.clear();
    for (std::size_t i = 0; i < primitives_.size(); ++i)
      pack.appearances.push_back(readAppearance("/materials/" + std::to_string(i)));
    if (primitives_.size() > 1)
      for (const Appearance& appearance : pack.appearances)
        pack.mesh.material_names.push_back(appearance.material);
    if (glb_.has(kNeighborhood))
      pack.neighborhood = readPart(kNeighborhood, neighborhoodKinds(), kNoTangents);
    return pack;
  }

 private:
  PackPart readPart(const std::string& pointer, const PackPartKinds& kinds,
                    const std::vector<Float4>& tangents) const {
    const std::string name = glb_.textAt(pointer + "/kind");
    const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                   [&](const PackPartKind& known) { return name == known.name; });
    if (kind == kinds.end())
      throw glb_.error(pointer + "/kind", "'" + name + "' is not known", namesOf(kinds),
                       "read it with the Bakelight that made it");
    PackPart part = kind->make();
    FieldReader fields(glb_, pointer, tangents);
    part.describe(fields);
    return part;
  }

  Appearance readAppearance(const std::string& pointer) const {
    Appearance appearance;
    if (glb_.has(pointer + "/name")) appearance.material = glb_.textAt(pointer + "/name");
    const std::string part = pointer + "/extensions/" + kTransferExtension;
    appearance.reflection = readPart(part, reflectionKinds(), kNoTangents);
    appearance.base_color = float3At(appearance.reflection.as<Translucency>() != nullptr
                                         ? part + "/stain"
                                         : pointer + "/pbrMetallicRoughness/baseColorFactor");
    return appearance;
  }

  bool hasDraco() const { return glb_.has(primitives_.front() + "/extensions/" + kDracoExtension); }

  void readMesh(TriangleMesh& mesh) {
    if (!hasDraco()) mesh = readPlainVertices(primitives_.front());
    for (std::uint32_t i = 0; i < primitives_.size(); ++i) {
      std::vector<Triangle> triangles;
      if (hasDraco()) {
        triangles = appendDraco(mesh, readDracoMesh(primitives_[i]));
      } else {
        for (const char* name : {"POSITION", "NORMAL"})
          require(primitives_[i] + "/attributes/" + name, glb_.at(primitives_[0] + "/attributes/" + name));
        triangles = readAccessor<Triangle>(primitives_[i] + "/indices", kUint32Component, "SCALAR", 3);
      }
      if (primitives_.size() > 1)
        mesh.triangle_materials.insert(mesh.triangle_materials.end(), triangles.size(), i);
      if (mesh.triangles.empty()) {
        mesh.triangles = std::move(triangles);
      } else {
        mesh.triangles.insert(mesh.triangles.end(), triangles.begin(), triangles.end());
      }
    }
    mesh.texcoords = flippedTexcoords(mesh.texcoords);
  }

  std::vector<Triangle> appendDraco(TriangleMesh& mesh, TriangleMesh part) {
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(mesh.positions, part.positions);
    append(mesh.normals, part.normals);
    append(mesh.texcoords, part.texcoords);
    for (Triangle& t : part.triangles)
      for (std::uint32_t& v : t) v += first;
    counts_.push_back(part.vertexCount());
    return std::move(part.triangles);
  }

  // Empty if the primitives have no such attribute. With Draco each has its part of one section, in order.
  template <class Item>
  std::vector<Item> readAttribute(const char* name, const char* type) const {
    const std::string pointer = primitives_.front() + "/attributes/" + name;
    if (!glb_.has(pointer)) return {};
    if (!hasDraco() || primitives_.size() == 1) return readAccessor<Item>(pointer, kFloat32Component, type);
    const std::string view = accessorAt(pointer) + "/bufferView";
    std::uint64_t first = 0;
    for (std::size_t i = 0; i < primitives_.size(); ++i) {
      const std::string part = accessorAt(primitives_[i] + "/attributes/" + name);
      require(part + "/bufferView", glb_.at(view));
      require(part + "/componentType", static_cast<int>(kFloat32Component));
      require(part + "/type", type);
      require(part + "/count", counts_[i]);
      if (first > 0) require(part + "/byteOffset", first * sizeof(Item));
      first += counts_[i];
    }
    return readValues<Item>(view, first);
  }

  inline static const std::vector<Float4> kNoTangents = {};
  std::vector<std::string> primitives_;
  std::vector<std::size_t> counts_;  // vertices of each, with Draco
};

}  // namespace

Pack decodeUncheckedPack(const GlbReader& glb) {
  if (glb.version() < 3) return decodeUncheckedPack2(glb);
  return PackReader(glb).read();
}

}  // namespace bakelight::formats
