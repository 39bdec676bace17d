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
    if (!text_.starts_with("ply") || nextLine() != "ply") {
      throw badInput({file_, "", ""}, "this is not a PLY file", "a first line that says ply");
    }
    for (std::string_view line = nextLine();; line = nextLine()) {
      const auto words = wordsOf(line);
      if (words.empty() || words[0] == "obj_info") continue;
      if (words[0] == "comment") {
        header_.comments.emplace_back(line.substr(static_cast<std::size_t>(words[0].end() - line.begin())));
        continue;
      }
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() == 3) {
        header_.format = words[1];
        header_.version = words[2];
      } else if (words[0] == "element" && words.size() == 3) {
        readElement(line, words);
      } else if (words[0] == "property" && !header_.elements.empty()) {
        readProperty(line, words);
      } else {
        throw malformed(line);
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
    return error("the line '" + std::string(line.substr(0, 80)) + "' is malformed",
                 "format, element, property, comment or end_header");
  }

  std::string_view nextLine() {
    const std::size_t end = text_.find('\n', header_.size_bytes);
    if (end == std::string_view::npos)
      throw error("the file ends inside the header", "a line end_header", kCutRemedy);
    std::string_view line = text_.substr(header_.size_bytes, end - header_.size_bytes);
    header_.size_bytes = end + 1;
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

  std::string_view text_;
  std::string file_;
  PlyHeader header_;
};

Error endsEarly(const std::string& file, const PlyElement& element, std::uint64_t row) {
  return badInput({file, element.name + " " + std::to_string(row), ""}, "the file ends here",
                  std::to_string(element.count) + " rows of " + element.name, kCutRemedy);
}

// A body as a row of values; `remaining` counts bytes (binary) or words (ascii).
class BodyCheck {
 public:
  BodyCheck(const PlyHeader& header, std::span<const std::byte> body, const std::string& file)
      : header_(header), body_(body), file_(file), is_text_(header.format == "ascii") {}

  void run() {
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;
      for (std::uint64_t row = 0; row < element.count; ++row) {
        for (const PlyProperty& property : element.properties) {
          if (!takeProperty(property)) throw endsEarly(file_, element, row);
        }
      }
    }
  }

 private:
  bool takeProperty(const PlyProperty& property) {
    if (!property.list_count) return is_text_ ? takeWord().has_value() : skipBytes(sizeOf(property.type));
    const auto count = is_text_ ? takeTextCount() : takeBinaryCount(*property.list_count);
    if (!count) return false;
    if (!is_text_) return skipBytes(*count * sizeOf(property.type));
    for (std::uint64_t i = 0; i < *count; ++i) {
      if (!takeWord()) return false;
    }
    return true;
  }

  bool skipBytes(std::uint64_t size) {
    if (size > body_.size() - position_) return false;
    position_ += size;
    return true;
  }

  std::optional<std::uint64_t> takeBinaryCount(PlyScalar type) {
    const std::size_t size = sizeOf(type);
    std::array<std::byte, 8> bytes{};
    if (size > body_.size() - position_) return std::nullopt;
    std::memcpy(bytes.data(), body_.data() + position_, size);
    if (header_.format == "binary_big_endian")
      std::reverse(bytes.begin(), bytes.begin() + static_cast<int>(size));
    position_ += size;
    const std::int64_t count = plyIntegerAt(bytes.data(), type);
    return count < 0 ? std::nullopt : std::optional(static_cast<std::uint64_t>(count));
  }

  std::optional<std::uint64_t> takeTextCount() {
    const auto word = takeWord();
    std::uint32_t count = 0;
    if (!word || std::from_chars(word->data(), word->data() + word->size(), count).ec != std::errc())
      return std::nullopt;
    return count;
  }

  std::optional<std::string_view> takeWord() {
    const auto* text = reinterpret_cast<const char*>(body_.data());
    const auto isSpace = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
    while (position_ < body_.size() && isSpace(text[position_])) ++position_;
    const std::size_t begin = position_;
    while (position_ < body_.size() && !isSpace(text[position_])) ++position_;
    if (position_ == begin) return std::nullopt;
    return std::string_view(text + begin, position_ - begin);
  }

  const PlyHeader& header_;
  std::span<const std::byte> body_;
  const std::string& file_;
  bool is_text_;
  std::size_t position_ = 0;
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

void checkPlyBody(const PlyHeader& header, std::span<const std::byte> bytes, const std::string& file) {
  BodyCheck(header, bytes.subspan(header.size_bytes), file).run();
}

}  // namespace bakelight::formats
