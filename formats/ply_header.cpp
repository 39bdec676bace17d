#include "formats/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

constexpr const char* kCutRemedy = "copy or export the file again, it was cut short";

std::optional<PlyScalar> scalarNamed(std::string_view name) {
  struct Name {
    std::string_view short_name, long_name;
  };
  constexpr Name kNames[] = {{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                             {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                             {"float", "float32"}, {"double", "float64"}};
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if (name == kNames[i].short_name || name == kNames[i].long_name) return static_cast<PlyScalar>(i);
  }
  return std::nullopt;
}

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> result;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return result;
    const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    result.push_back(line.substr(begin, end - begin));
    line.remove_prefix(end);
  }
}

template <class T>
T valueAt(const std::byte* data) {
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

class HeaderReader {
 public:
  HeaderReader(std::span<const std::byte> bytes, std::string file)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), file_(std::move(file)) {}

  PlyHeader read() {
    const std::size_t first_end = text_.find_first_of("\r\n");
    if (!text_.starts_with("ply") || text_.substr(0, first_end).find_first_not_of(" \t", 3) != kNone)
      throw badInput({file_, "", ""}, "this is not a PLY file", "a first line that says ply");
    // Told by the first line, as a body of bytes may begin with LF after the header's last CR.
    if (first_end != kNone && text_[first_end] == '\r' && text_.substr(first_end, 2) != "\r\n")
      line_end_ = '\r';
    nextLine();
    for (std::string_view line = nextLine();; line = nextLine()) {
      const auto words = wordsOf(line);
      if (words.empty() || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "comment") {
        header_.comments.emplace_back(line.substr(static_cast<std::size_t>(words[0].end() - line.begin())));
        continue;
      }
      if (words[0] == "format" && words.size() == 3) {
        header_.format = words[1];
        header_.version = words[2];
      } else if (words[0] == "element" && words.size() == 3) {
        readElement(line, words);
      } else if (words[0] == "property" && !header_.elements.empty()) {
        readProperty(line, words);
      } else if (isKeyword(words[0])) {
        throw malformed(line);
      } else {
        header_.unknown_lines.emplace_back(line.substr(0, 80));
      }
    }
    if (header_.format.empty()) throw error("there is no format line", "format binary_little_endian 1.0");
    return std::move(header_);
  }

 private:
  Error error(const std::string& what, const std::string& expected, const std::string& remedy = "") const {
    return badInput({file_, "header", ""}, what, expected, remedy);
  }

  Error malformed(std::string_view line) const {
    return error("line " + std::to_string(header_.line_count) + ", '" + std::string(line.substr(0, 80)) +
                     "', is malformed",
                 "format, element, property, comment or end_header");
  }

  static bool isKeyword(std::string_view word) {
    return word == "format" || word == "element" || word == "property";
  }

  std::string_view nextLine() {
    const std::size_t end = text_.find(line_end_, header_.size_bytes);
    if (end == kNone) throw error("the file ends inside the header", "a line end_header", kCutRemedy);
    std::string_view line = text_.substr(header_.size_bytes, end - header_.size_bytes);
    header_.size_bytes = end + 1;
    ++header_.line_count;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  void readElement(std::string_view line, const std::vector<std::string_view>& words) {
    PlyElement element;
    element.name = words[1];
    const char* end = words[2].data() + words[2].size();
    const auto [rest, status] = std::from_chars(words[2].data(), end, element.count);
    if (status != std::errc() || rest != end) throw malformed(line);
    for (const PlyElement& other : header_.elements) {
      if (other.name == element.name) throw error("the element " + element.name + " stands twice", "once");
    }
    header_.elements.push_back(std::move(element));
  }

  void readProperty(std::string_view line, const std::vector<std::string_view>& words) {
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (!is_list && words.size() != 3) throw malformed(line);
    const auto type = scalarNamed(words[is_list ? 3 : 1]);
    if (!type) throw malformed(line);
    PlyProperty property{std::string(words.back()), std::nullopt, *type};
    if (is_list) {
      property.list_count = scalarNamed(words[2]);
      if (!property.list_count || !isInteger(*property.list_count)) throw malformed(line);
    }
    header_.elements.back().properties.push_back(std::move(property));
  }

  static constexpr std::size_t kNone = std::string_view::npos;

  std::string_view text_;
  std::string file_;
  char line_end_ = '\n';
  PlyHeader header_;
};

}  // namespace

std::size_t sizeOf(PlyScalar type) {
  switch (type) {
    case PlyScalar::kInt8:
    case PlyScalar::kUint8:
      return 1;
    case PlyScalar::kInt16:
    case PlyScalar::kUint16:
      return 2;
    case PlyScalar::kFloat64:
      return 8;
    default:
      return 4;
  }
}

bool isInteger(PlyScalar type) {
  return type < PlyScalar::kFloat32;
}

std::int64_t plyIntegerAt(const std::byte* data, PlyScalar type) {
  switch (type) {
    case PlyScalar::kInt8:
      return valueAt<std::int8_t>(data);
    case PlyScalar::kUint8:
      return valueAt<std::uint8_t>(data);
    case PlyScalar::kInt16:
      return valueAt<std::int16_t>(data);
    case PlyScalar::kUint16:
      return valueAt<std::uint16_t>(data);
    case PlyScalar::kInt32:
      return valueAt<std::int32_t>(data);
    case PlyScalar::kUint32:
      return valueAt<std::uint32_t>(data);
    default:
      throw std::logic_error("not an integer type");
  }
}

PlyHeader readPlyHeader(std::span<const std::byte> bytes, const std::string& file) {
  return HeaderReader(bytes, file).read();
}

}  // namespace bakelight::formats
