#include "formats/ply_body.h"

#include <array>
#include <cmath>
#include <limits>

#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

constexpr const char* kRepairRemedy = "correct the line, or export the file again";

struct IntegerRange {
  std::int64_t least, most;
};

IntegerRange rangeOf(PlyScalar type) {
  switch (type) {
    case PlyScalar::kInt8:
      return {-128, 255};  // also codes of bytes whose type is written without its "u"
    case PlyScalar::kUint8:
      return {0, 255};
    case PlyScalar::kInt16:
      return {-32768, 32767};
    case PlyScalar::kUint16:
      return {0, 65535};
    case PlyScalar::kUint32:
      return {0, std::numeric_limits<std::uint32_t>::max()};
    default:
      return {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()};
  }
}

}  // namespace

const char* nameOf(PlyScalar type) {
  constexpr std::array<const char*, 8> kNames = {"char", "uchar", "short", "ushort",
                                                 "int",  "uint",  "float", "double"};
  return kNames[static_cast<std::size_t>(type)];
}

std::string PlyRow::text() const {
  return element->name + " " + std::to_string(row) + (line > 0 ? " (line " + std::to_string(line) + ")" : "");
}

Error plyEndsHere(const std::string& file, const PlyRow& row) {
  return badInput(
      {file, row.text(), ""}, "the file ends here",
      std::to_string(row.element->count) + " rows of " + row.element->name + ", as the header says",
      "copy or export the file again, it was cut short");
}

PlyTextBody::PlyTextBody(const PlyHeader& header, std::span<const std::byte> bytes, std::string file)
    : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
      file_(std::move(file)),
      position_(header.size_bytes),
      line_(header.line_count + 1) {}

bool PlyTextBody::skipBlanks() {
  bool line_end = false;
  for (; position_ < text_.size() && isBlank(text_[position_]); ++position_) {
    const char c = text_[position_];
    if (c == '\n' || (c == '\r' && (position_ + 1 == text_.size() || text_[position_ + 1] != '\n'))) {
      ++line_;
      line_end = true;
    }
  }
  return line_end;
}

void PlyTextBody::beginRow(const PlyElement& element, std::uint64_t row) {
  const bool is_first = row_.element == nullptr;
  if (!skipBlanks() && !is_first && !misaligned_ && position_ < text_.size()) {
    misaligned_ = row_;
    misaligned_->line = line_;
  }
  row_ = {&element, row, line_};
}

std::string_view PlyTextBody::takeWord() {
  skipBlanks();
  const std::size_t begin = position_;
  while (position_ < text_.size() && !isBlank(text_[position_])) ++position_;
  if (position_ == begin) {
    throwIfMisaligned();
    throw plyEndsHere(file_, row_);
  }
  return text_.substr(begin, position_ - begin);
}

void PlyTextBody::throwIfMisaligned() const {
  if (!misaligned_) return;
  throw badInput(
      {file_, misaligned_->text(), ""},
      "it does not end where its line ends, so the line has more or fewer values than the header says",
      std::to_string(misaligned_->element->properties.size()) + " properties of " +
          misaligned_->element->name + " on each line",
      kRepairRemedy);
}

Error PlyTextBody::notOf(PlyScalar type, std::string_view word) const {
  throwIfMisaligned();
  return badInput(
      {file_, row_.element->name + " " + std::to_string(row_.row) + " (line " + std::to_string(line_) + ")",
       ""},
      "'" + std::string(word.substr(0, 40)) + "' is no value of type " + nameOf(type), "as the header says",
      kRepairRemedy);
}

float PlyTextBody::takeFloat(PlyScalar type) {
  if (isInteger(type)) return static_cast<float>(takeInteger(type));
  const std::string_view word = takeWord();
  const auto value = parseFloat(word);
  if (!value) throw notOf(type, word);
  return *value;
}

std::int64_t PlyTextBody::takeInteger(PlyScalar type) {
  const std::string_view word = takeWord();
  auto value = parseInteger(word);
  if (!value) {
    // "255.0"
    const auto number = parseFloat(word);
    if (number && std::abs(*number) < 1e6F && *number == std::floor(*number))
      value = static_cast<std::int64_t>(*number);
  }
  if (!value) throw notOf(type, word);
  if (isInteger(type) && (*value < rangeOf(type).least || *value > rangeOf(type).most))
    throw notOf(type, word);
  return *value;
}

void PlyTextBody::skip(PlyScalar /*type*/, std::uint64_t count) {
  for (std::uint64_t i = 0; i < count; ++i) takeWord();
}

std::optional<std::string> PlyTextBody::finish() {
  const bool new_line = skipBlanks();
  if (position_ == text_.size()) {
    if (!text_.empty() && !isBlank(text_.back()))
      return "the last line has no line end: was the file cut short?";
    return std::nullopt;
  }
  if (!new_line && row_.element != nullptr && !misaligned_) {
    misaligned_ = row_;
    misaligned_->line = line_;
  }
  throwIfMisaligned();
  return "text follows the last element that the header names, and was not read (from line " +
         std::to_string(line_) + " on)";
}

}  // namespace bakelight::formats
