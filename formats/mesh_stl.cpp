#include "formats/mesh_stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "formats/error.h"
#include "formats/polygon.h"
#include "formats/text_scan.h"
#include "formats/vertex_colors.h"

namespace bakelight::formats {
namespace {

constexpr const char* kCutRemedy = "copy or export the file again, it was probably cut short";
constexpr const char* kRepairRemedy = "correct the line, or export the file again";
constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

static_assert(std::endian::native == std::endian::little, "values are read as they are in the file");

template <class T>
T valueAt(std::span<const std::byte> bytes, std::size_t position) {
  T value;
  std::memcpy(&value, bytes.data() + position, sizeof value);
  return value;
}

bool isFinite(const Float3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

std::string plural(std::size_t count, const char* one, const char* several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

// Facets whose normal in the file points to the other side than their winding.
class NormalCheck {
 public:
  void add(const Float3& normal, const Float3& a, const Float3& b, const Float3& c) {
    std::array<double, 3> u, v;
    for (std::size_t k = 0; k < 3; ++k) {
      u[k] = static_cast<double>(b[k]) - a[k];
      v[k] = static_cast<double>(c[k]) - a[k];
    }
    const std::array<double, 3> n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                     u[0] * v[1] - u[1] * v[0]};
    double product = 0, area = 0, length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      product += n[k] * normal[k];
      area += n[k] * n[k];
      length += static_cast<double>(normal[k]) * normal[k];
    }
    // Slivers round to any side.
    opposing_ += product < -0.5 * std::sqrt(area * length);
  }

  void addNote(std::vector<std::string>& notes) const {
    if (opposing_ > 0)
      notes.push_back(plural(opposing_, "facet is", "facets are") +
                      " wound against the normal in the file: the winding counts");
  }

 private:
  std::size_t opposing_ = 0;
};

class BinaryStl {
 public:
  BinaryStl(std::span<const std::byte> bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  MeshParts read() {
    const std::uint64_t count = valueAt<std::uint32_t>(bytes_, kHeaderBytes - 4);
    checkSize(count);
    MeshPart part;
    part.positions.reserve(3 * count);
    part.triangles.reserve(count);
    NormalCheck normals;
    for (std::uint64_t facet = 0; facet < count; ++facet) {
      const std::size_t begin = kHeaderBytes + facet * kFacetBytes;
      std::array<Float3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = valueAt<Float3>(bytes_, begin + 12 * (k + 1));
        if (!isFinite(corners[k]))
          throw badInput({file_, "facet " + std::to_string(facet) + " (counted from 0)", ""},
                         "a coordinate of its corner " + std::to_string(k + 1) + " is not finite",
                         "three numbers", "repair the mesh in its modelling program");
      }
      normals.add(valueAt<Float3>(bytes_, begin), corners[0], corners[1], corners[2]);
      const auto base = static_cast<std::uint32_t>(part.positions.size());
      part.triangles.push_back({base, base + 1, base + 2});
      part.positions.insert(part.positions.end(), corners.begin(), corners.end());
    }
    readColors(count, part);
    normals.addNote(result_.notes);
    result_.parts.push_back(std::move(part));
    return std::move(result_);
  }

 private:
  void checkSize(std::uint64_t count) {
    const std::uint64_t room = (bytes_.size() - kHeaderBytes) / kFacetBytes;
    const std::uint64_t rest = bytes_.size() - kHeaderBytes - std::min(count, room) * kFacetBytes;
    const std::string says = "its header says " + std::to_string(count) + " facets";
    if (count > room) {
      const std::uint64_t swapped = __builtin_bswap32(static_cast<std::uint32_t>(count));
      if (swapped * kFacetBytes + kHeaderBytes == bytes_.size())
        throw badInput({file_, "", ""}, "it is a big-endian STL file",
                       "little-endian numbers, as STL has them",
                       "export it again on another machine or by another program");
      throw badInput({file_, "facet " + std::to_string(room) + " (counted from 0)", ""},
                     "the file ends here, and " + says,
                     std::to_string(count * kFacetBytes + kHeaderBytes) + " bytes",
                     std::string(kCutRemedy) + ", or its header is damaged");
    }
    if (rest >= kFacetBytes)
      throw badInput({file_, "header", ""}, says + ", and the file has room for " + std::to_string(room),
                     std::to_string(count * kFacetBytes + kHeaderBytes) + " bytes",
                     "export it again, its header or its end is damaged");
    if (rest > 0)
      result_.notes.push_back(plural(rest, "byte follows", "bytes follow") + " the last facet, and " +
                              (rest == 1 ? "was" : "were") + " not read");
  }

  std::uint16_t attributeOf(std::uint64_t facet) const {
    return valueAt<std::uint16_t>(bytes_, kHeaderBytes + facet * kFacetBytes + 48);
  }

  static Float3 colorFrom(int red, int green, int blue) {
    return linearFromSrgb(Float3{static_cast<float>(red) / 31.0F, static_cast<float>(green) / 31.0F,
                                 static_cast<float>(blue) / 31.0F});
  }

  // Five bits a channel. VisCAM: blue in the lowest, bit 15 set if the facet has a colour. Materialise, which
  // says "COLOR=" and the colour of the whole in the header: red in the lowest, bit 15 clear if the facet has
  // one of its own.
  void readColors(std::uint64_t count, MeshPart& part) {
    const std::string_view header(reinterpret_cast<const char*>(bytes_.data()), kHeaderBytes - 4);
    const std::size_t mark = header.find("COLOR=");
    const bool materialise = mark != std::string_view::npos && mark + 10 <= header.size();
    std::uint64_t with_bit = 0, nonzero = 0;
    for (std::uint64_t facet = 0; facet < count; ++facet) {
      with_bit += attributeOf(facet) >> 15;
      nonzero += attributeOf(facet) != 0;
    }
    if (!materialise && with_bit == 0) {
      if (nonzero > 0)
        result_.notes.push_back(plural(nonzero, "facet has", "facets have") +
                                " attribute bytes that are no colour; they were not read");
      return;
    }
    Float3 whole = {1, 1, 1};
    for (std::size_t c = 0; materialise && c < 3; ++c)
      whole[c] =
          linearFromSrgb(static_cast<float>(static_cast<unsigned char>(header[mark + 6 + c])) / 255.0F);
    std::uint64_t without = 0;
    for (std::uint64_t facet = 0; facet < count; ++facet) {
      const int bits = attributeOf(facet);
      const int low = bits & 31, middle = bits >> 5 & 31, high = bits >> 10 & 31;
      // Attributes that are 0 throughout were never written.
      const bool own = materialise ? bits >> 15 == 0 && nonzero > 0 : bits >> 15 == 1;
      without += !own;
      const Float3 color = !own          ? whole
                           : materialise ? colorFrom(low, middle, high)
                                         : colorFrom(high, middle, low);
      part.colors.insert(part.colors.end(), 3, color);
    }
    if (!materialise && without > 0)
      result_.notes.push_back(plural(without, "facet has", "facets have") + " no colour, and " +
                              (without == 1 ? "was" : "were") + " taken as white");
  }

  std::span<const std::byte> bytes_;
  std::string file_;
  MeshParts result_;
};

// Words, whatever the lines; only names go on to the end of theirs.
class TextStl {
 public:
  TextStl(std::string_view text, std::string file)
      : lines_(withoutByteOrderMark(text)), file_(std::move(file)) {}

  MeshParts read() {
    bool inside = false;
    for (std::string_view word = next(); !word.empty(); word = next()) {
      if (is(word, "solid")) {
        if (inside) throw error("another solid begins inside a solid", "endsolid");
        inside = true;
        line_ = {};
      } else if (is(word, "endsolid")) {
        inside = false;
        line_ = {};
      } else if (is(word, "facet")) {
        readFacet();
      } else {
        throw error("'" + std::string(word.substr(0, 40)) + "' is no word of an STL file",
                    "solid, facet or endsolid");
      }
    }
    if (inside)
      throw badInput({file_, "line " + std::to_string(lines_.lineNumber()), ""},
                     "the file ends before endsolid", "a last line that says endsolid", kCutRemedy);
    if (crossing_ > 0)
      result_.notes.push_back(plural(crossing_, "facet has", "facets have") +
                              " more than 3 corners that have no area or cross themselves");
    normals_.addNote(result_.notes);
    result_.parts.push_back(std::move(part_));
    return std::move(result_);
  }

 private:
  Error error(const std::string& what, const std::string& expected) const {
    const bool cut = lines_.atEnd() && !lines_.latestHasEnd() && trimmed(line_).empty();
    return badInput({file_, "line " + std::to_string(lines_.lineNumber()), ""}, what, expected,
                    cut ? kCutRemedy : kRepairRemedy);
  }

  static bool is(std::string_view word, std::string_view keyword) { return equalIgnoringCase(word, keyword); }

  // Empty at the end of the file.
  std::string_view next() {
    while (true) {
      const std::string_view word = takeWord(line_);
      if (!word.empty() || !lines_.next(line_)) return word;
    }
  }

  void expect(std::string_view keyword) {
    const std::string_view word = next();
    if (word.empty())
      throw badInput({file_, "line " + std::to_string(lines_.lineNumber()), ""},
                     "the file ends inside facet " + std::to_string(facet_count_) + " (counted from 0)",
                     std::string(keyword), kCutRemedy);
    if (!is(word, keyword))
      throw error("'" + std::string(word.substr(0, 40)) + "' stands in a facet", std::string(keyword));
  }

  Float3 readNumbers(const char* form, bool finite) {
    Float3 values;
    for (float& value : values) {
      const std::string_view word = next();
      const auto number = parseFloat(word);
      if (!number) throw error("'" + std::string(word.substr(0, 40)) + "' is not a number", form);
      if (finite && !std::isfinite(*number))
        throw error(
            "a coordinate in facet " + std::to_string(facet_count_) + " (counted from 0) is not finite",
            "three numbers that a 32-bit float can hold");
      value = *number;
    }
    return values;
  }

  void readFacet() {
    expect("normal");
    const Float3 normal = readNumbers("facet normal x y z", false);
    expect("outer");
    expect("loop");
    corners_.clear();
    std::string_view word = next();
    for (; is(word, "vertex"); word = next()) corners_.push_back(readNumbers("vertex x y z", true));
    if (!is(word, "endloop"))
      throw error(word.empty()
                      ? "the file ends inside facet " + std::to_string(facet_count_) + " (counted from 0)"
                      : "'" + std::string(word.substr(0, 40)) + "' stands in a facet",
                  "vertex or endloop");
    if (corners_.size() < 3)
      throw error("facet " + std::to_string(facet_count_) + " (counted from 0) has " +
                      plural(corners_.size(), "corner", "corners"),
                  "3 corners");
    expect("endfacet");
    triangles_.clear();
    crossing_ += !triangulator_.triangulate(corners_, triangles_);
    const auto base = static_cast<std::uint32_t>(part_.positions.size());
    for (const Triangle& t : triangles_) {
      part_.triangles.push_back({base + t[0], base + t[1], base + t[2]});
      normals_.add(normal, corners_[t[0]], corners_[t[1]], corners_[t[2]]);
    }
    part_.positions.insert(part_.positions.end(), corners_.begin(), corners_.end());
    ++facet_count_;
  }

  LineScanner lines_;
  std::string_view line_;
  std::string file_;
  MeshPart part_;
  MeshParts result_;
  NormalCheck normals_;
  PolygonTriangulator triangulator_;
  std::vector<Float3> corners_;
  std::vector<Triangle> triangles_;
  std::size_t facet_count_ = 0, crossing_ = 0;
};

bool isText(std::span<const std::byte> bytes) {
  std::string_view text =
      trimmed(withoutByteOrderMark({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  // A binary file's header may begin so, and its count or first floats have bytes that no text has.
  return startsIgnoringCase(text, "solid") && text.substr(0, 1024).find('\0') == std::string_view::npos;
}

}  // namespace

MeshParts readStl(std::span<const std::byte> bytes, const std::string& file) {
  const bool whole_binary =
      bytes.size() >= kHeaderBytes &&
      kHeaderBytes + kFacetBytes * std::uint64_t{valueAt<std::uint32_t>(bytes, kHeaderBytes - 4)} ==
          bytes.size();
  if (!whole_binary && isText(bytes))
    return TextStl({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file).read();
  if (bytes.size() < kHeaderBytes)
    throw badInput(
        {file, "", ""}, "it has " + std::to_string(bytes.size()) + " bytes and does not begin with \"solid\"",
        "a text that begins so, or at least 84 bytes of a binary STL file", "copy or export the file again");
  return BinaryStl(bytes, file).read();
}

}  // namespace bakelight::formats
