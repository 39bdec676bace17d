#include "formats/ply_contents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "formats/error.h"
#include "formats/ply_body.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// The value of a vertex or face that a property gives.
enum Slot { kX, kY, kZ, kNx, kNy, kNz, kS, kT, kRed, kGreen, kBlue, kSlotCount, kNoSlot = kSlotCount };

using Names = std::vector<std::string_view>;

// Where `properties` has scalars of all these names; else empty.
std::vector<std::size_t> indicesOf(const std::vector<PlyProperty>& properties, const Names& names) {
  std::vector<std::size_t> indices;
  for (const std::string_view name : names) {
    const auto found = std::find_if(properties.begin(), properties.end(), [&](const PlyProperty& property) {
      return !property.list_count && equalIgnoringCase(property.name, name);
    });
    if (found == properties.end()) return {};
    indices.push_back(static_cast<std::size_t>(found - properties.begin()));
  }
  return indices;
}

class SlotPlan {
 public:
  explicit SlotPlan(const std::vector<PlyProperty>& properties)
      : properties_(properties), slots_(properties.size(), kNoSlot) {}

  // Whether one of the groups of names is there, the first of them counts.
  bool assign(Slot first, const std::vector<Names>& groups) {
    for (const Names& names : groups) {
      const auto indices = indicesOf(properties_, names);
      for (std::size_t i = 0; i < indices.size(); ++i)
        slots_[indices[i]] = static_cast<Slot>(first + static_cast<int>(i));
      if (!indices.empty()) return true;
    }
    return false;
  }

  bool assignColors() {
    return assign(
        kRed, {{"red", "green", "blue"}, {"r", "g", "b"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}});
  }

  PlyScalar typeOf(Slot slot) const {
    const auto found = std::find(slots_.begin(), slots_.end(), slot);
    return properties_[static_cast<std::size_t>(found - slots_.begin())].type;
  }

  Slot operator[](std::size_t property) const { return slots_[property]; }

 private:
  const std::vector<PlyProperty>& properties_;
  std::vector<Slot> slots_;
};

bool isIndexList(const PlyProperty& property) {
  return property.list_count && (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <class Body>
class ContentsReader {
 public:
  ContentsReader(const PlyHeader& header, Body body, std::string file)
      : header_(header), body_(std::move(body)), file_(std::move(file)) {}

  PlyContents read() {
    for (const PlyElement& element : header_.elements)
      if (element.name == "vertex") vertex_count_ = element.count;
    if (vertex_count_ >= std::numeric_limits<std::uint32_t>::max() - 1)
      throw headerError("it has " + std::to_string(vertex_count_) + " vertices", "less than 4,294,967,295");
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;
      if (element.name == "vertex")
        readVertices(element);
      else if (element.name == "face")
        readFaces(element);
      else if (element.name == "tristrips")
        readStrips(element);
      else
        skipRows(element);
    }
    if (short_faces_ > 0)
      result_.notes.push_back(counted(short_faces_, "face has fewer than 3 corners, and was left out",
                                      "faces have fewer than 3 corners, and were left out"));
    if (auto note = body_.finish()) result_.notes.push_back(std::move(*note));
    return std::move(result_);
  }

 private:
  Error headerError(const std::string& what, const std::string& expected) const {
    return badInput({file_, "header", ""}, what, expected, "export the file again");
  }
  Error rowError(const std::string& what, const std::string& expected) const {
    return badInput({file_, body_.row().text(), ""}, what, expected, "export the file again");
  }

  // No more than the rest of the file can fill, whatever the header says.
  std::size_t reservation(std::uint64_t count, std::size_t least_bytes) const {
    return static_cast<std::size_t>(std::min<std::uint64_t>(count, body_.bytesLeft() / least_bytes + 1));
  }

  std::uint64_t takeCount(const PlyProperty& property) {
    const std::int64_t count = body_.takeInteger(*property.list_count);
    if (count < 0) throw rowError("a list has " + std::to_string(count) + " members", "0 or more");
    return static_cast<std::uint64_t>(count);
  }

  void skip(const PlyProperty& property) {
    body_.skip(property.type, property.list_count ? takeCount(property) : 1);
  }

  void skipRows(const PlyElement& element) {
    for (std::uint64_t row = 0; row < element.count; ++row) {
      body_.beginRow(element, row);
      for (const PlyProperty& property : element.properties) skip(property);
    }
    // Of these everybody knows that they are no surface.
    if (element.count > 0 && element.name != "edge" && element.name != "camera")
      result_.notes.push_back("the element '" + element.name + "' was left out");
  }

  void readVertices(const PlyElement& element) {
    SlotPlan plan(element.properties);
    if (!plan.assign(kX, {{"x", "y", "z"}}))
      throw headerError("vertices have no position", "properties x, y and z");
    const bool has_normals = plan.assign(kNx, {{"nx", "ny", "nz"}});
    const bool has_texcoords =
        plan.assign(kS, {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}});
    const bool has_colors = plan.assignColors();
    if (has_colors) result_.color_type = plan.typeOf(kRed);
    const std::size_t expected = reservation(element.count, 3);
    mesh_.positions.reserve(expected);
    if (has_normals) mesh_.normals.reserve(expected);
    if (has_texcoords) mesh_.texcoords.reserve(expected);
    if (has_colors) mesh_.colors.reserve(expected);
    std::array<float, kSlotCount + 1> v = {};
    for (std::uint64_t row = 0; row < element.count; ++row) {
      body_.beginRow(element, row);
      takeSlots(element, plan, v);
      if (!std::isfinite(v[kX]) || !std::isfinite(v[kY]) || !std::isfinite(v[kZ]))
        result_.not_finite.push_back({row, body_.row().line});
      mesh_.positions.push_back({v[kX], v[kY], v[kZ]});
      if (has_normals) mesh_.normals.push_back({v[kNx], v[kNy], v[kNz]});
      if (has_texcoords) mesh_.texcoords.push_back({v[kS], v[kT]});
      if (has_colors) mesh_.colors.push_back({v[kRed], v[kGreen], v[kBlue]});
    }
  }

  void takeSlots(const PlyElement& element, const SlotPlan& plan, std::array<float, kSlotCount + 1>& values) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (plan[p] == kNoSlot)
        skip(property);
      else
        values[plan[p]] = body_.takeFloat(property.type);
    }
  }

  void readFaces(const PlyElement& element) {
    const auto& properties = element.properties;
    if (std::none_of(properties.begin(), properties.end(), isIndexList)) {
      if (element.count == 0) return;
      throw headerError("faces have no corners", "property list uchar int vertex_indices");
    }
    SlotPlan plan(properties);
    const bool has_colors = plan.assignColors();
    if (has_colors) result_.face_color_type = plan.typeOf(kRed);
    const bool has_texture = !indicesOf(properties, {"texnumber"}).empty();
    const std::size_t expected = reservation(element.count, 4);
    mesh_.corner_counts.reserve(expected);
    mesh_.corners.reserve(3 * expected);
    std::array<float, kSlotCount + 1> values = {};
    for (std::uint64_t row = 0; row < element.count; ++row) {
      body_.beginRow(element, row);
      int texture = -1;
      face_.clear();
      face_texcoords_.clear();
      for (std::size_t p = 0; p < properties.size(); ++p) {
        const PlyProperty& property = properties[p];
        if (isIndexList(property))
          takeIndices(property);
        else if (property.list_count && property.name == "texcoord")
          takeTexcoords(property);
        else if (!property.list_count && property.name == "texnumber")
          texture = static_cast<int>(std::clamp<std::int64_t>(body_.takeInteger(property.type), -1, 1 << 30));
        else if (plan[p] != kNoSlot)
          values[plan[p]] = body_.takeFloat(property.type);
        else
          skip(property);
      }
      if (!appendFace()) continue;
      if (has_texture) mesh_.face_materials.push_back(texture);
      if (has_colors) mesh_.face_colors.push_back({values[kRed], values[kGreen], values[kBlue]});
    }
  }

  void takeIndices(const PlyProperty& property) {
    const std::uint64_t count = takeCount(property);
    for (std::uint64_t i = 0; i < count; ++i) face_.push_back(takeIndex(property));
  }

  std::uint32_t takeIndex(const PlyProperty& property) {
    const std::int64_t index = body_.takeInteger(property.type);
    if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count_)
      throw rowError("vertex " + std::to_string(index) + " does not exist",
                     vertex_count_ == 0 ? "no index, as there are no vertices"
                                        : "0 to " + std::to_string(vertex_count_ - 1));
    return static_cast<std::uint32_t>(index);
  }

  void takeTexcoords(const PlyProperty& property) {
    const std::uint64_t count = takeCount(property);
    for (std::uint64_t i = 0; i < count; ++i) face_texcoords_.push_back(body_.takeFloat(property.type));
  }

  // False for one of too few corners.
  bool appendFace() {
    if (!face_texcoords_.empty() && face_texcoords_.size() != 2 * face_.size())
      throw rowError("it has " + std::to_string(face_.size()) + " corners and " +
                         std::to_string(face_texcoords_.size()) + " numbers of texture coordinates",
                     "two numbers a corner");
    if (face_.size() < 3) {
      ++short_faces_;
      return false;
    }
    // Lists may begin, and end, at any face.
    if (!face_texcoords_.empty()) mesh_.corner_texcoords.resize(mesh_.corners.size(), {kNan, kNan});
    mesh_.corners.insert(mesh_.corners.end(), face_.begin(), face_.end());
    mesh_.corner_counts.push_back(static_cast<std::uint32_t>(face_.size()));
    for (std::size_t i = 0; i + 1 < face_texcoords_.size(); i += 2)
      mesh_.corner_texcoords.push_back({face_texcoords_[i], face_texcoords_[i + 1]});
    return true;
  }

  // Each index makes a triangle with the two before it, every other one turned over; a negative one begins
  // another strip. Triangles with a vertex twice only lead the strip on.
  void readStrips(const PlyElement& element) {
    const auto& properties = element.properties;
    if (std::none_of(properties.begin(), properties.end(), isIndexList))
      throw headerError("triangle strips have no vertices", "property list int int vertex_indices");
    for (std::uint64_t row = 0; row < element.count; ++row) {
      body_.beginRow(element, row);
      for (const PlyProperty& property : properties) {
        if (isIndexList(property))
          readStrip(property);
        else
          skip(property);
      }
    }
  }

  void readStrip(const PlyProperty& property) {
    const std::uint64_t count = takeCount(property);
    Triangle last = {};
    std::uint64_t length = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::int64_t index = body_.takeInteger(property.type);
      if (index < 0) {
        length = 0;
        continue;
      }
      if (static_cast<std::uint64_t>(index) >= vertex_count_)
        throw rowError("vertex " + std::to_string(index) + " does not exist",
                       "0 to " + std::to_string(vertex_count_ - 1) + ", or −1 to begin another strip");
      last = {last[1], last[2], static_cast<std::uint32_t>(index)};
      if (++length < 3 || last[0] == last[1] || last[1] == last[2] || last[0] == last[2]) continue;
      const bool turned = length % 2 == 0;
      mesh_.corners.insert(mesh_.corners.end(),
                           {turned ? last[1] : last[0], turned ? last[0] : last[1], last[2]});
      mesh_.corner_counts.push_back(3);
    }
  }

  const PlyHeader& header_;
  Body body_;
  std::string file_;
  PlyContents result_;
  PolygonMesh& mesh_ = result_.mesh;
  std::uint64_t vertex_count_ = 0, short_faces_ = 0;
  std::vector<std::uint32_t> face_;
  std::vector<float> face_texcoords_;
};

}  // namespace

PlyContents readPlyContents(const PlyHeader& header, std::span<const std::byte> bytes,
                            const std::string& file) {
  PlyContents contents;
  if (header.format == "ascii") {
    contents = ContentsReader(header, PlyTextBody(header, bytes, file), file).read();
  } else if (header.format == "binary_little_endian") {
    contents = ContentsReader(header, PlyBinaryBody<std::endian::little>(header, bytes, file), file).read();
  } else if (header.format == "binary_big_endian") {
    contents = ContentsReader(header, PlyBinaryBody<std::endian::big>(header, bytes, file), file).read();
  } else {
    throw badInput({file, "header", ""}, "the format is " + header.format,
                   "ascii, binary_little_endian or binary_big_endian", "export the file again");
  }
  // Lists of texture coordinates that end before the last face, and what strips do not have.
  PolygonMesh& mesh = contents.mesh;
  if (!mesh.corner_texcoords.empty()) mesh.corner_texcoords.resize(mesh.corners.size(), {kNan, kNan});
  if (!mesh.face_materials.empty()) mesh.face_materials.resize(mesh.corner_counts.size(), -1);
  if (!mesh.face_colors.empty()) mesh.face_colors.resize(mesh.corner_counts.size(), {kNan, kNan, kNan});
  return contents;
}

}  // namespace bakelight::formats
