#include "formats/mesh_off.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "formats/error.h"
#include "formats/polygon_mesh.h"
#include "formats/text_scan.h"
#include "formats/vertex_colors.h"

namespace bakelight::formats {
namespace {

constexpr const char* kCutRemedy = "copy or export the file again, it was probably cut short";
constexpr const char* kRepairRemedy = "correct the line, or export the file again";
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr Float3 kNoColor = {kNan, kNan, kNan};

// What stands at each vertex beside its position, in this order.
struct OffHeader {
  bool normals = false, colors = false, texcoords = false, binary = false;
  int numbersWithoutColor() const { return 3 + (normals ? 3 : 0) + (texcoords ? 2 : 0); }
};

Error badHeader(const std::string& file, const std::string& what) {
  return badInput({file, "header", ""}, what,
                  "OFF, with ST, C or N before it and BINARY after it, or without",
                  "export the file again as OFF");
}

// "OFF", "STCNOFF", …; digits that follow without a blank are given back in `rest`.
OffHeader headerFrom(std::string_view word, std::string_view& digits, const std::string& file) {
  std::size_t off = word.find("OFF");
  if (off == std::string_view::npos) off = word.find("off");
  if (off == std::string_view::npos)
    throw badHeader(file, "'" + std::string(word.substr(0, 40)) + "' is no OFF");
  digits = word.substr(off + 3);
  std::string_view prefix = word.substr(0, off);
  OffHeader header;
  while (!prefix.empty()) {
    if (prefix.starts_with("ST") || prefix.starts_with("st")) {
      header.texcoords = true;
      prefix.remove_prefix(2);
      continue;
    }
    const char c = prefix[0];
    if (c == 'C' || c == 'c') {
      header.colors = true;
    } else if (c == 'N') {
      header.normals = true;
    } else {
      throw badHeader(file, "it is a " + std::string(word.substr(0, off + 3)) + " file" +
                                (c == '4' || c == 'n' ? ", whose points are not those of space" : ""));
    }
    prefix.remove_prefix(1);
  }
  return header;
}

std::string placeOf(const char* element, std::uint64_t index, std::uint64_t line) {
  return std::string(element) + " " + std::to_string(index) + " (counted from 0" +
         (line > 0 ? ", line " + std::to_string(line) : "") + ")";
}

// Colours as the file has them become linear. Integers throughout go to 255, unless none is beyond 1.
void makeLinear(std::vector<Float3>& colors, bool integers, const char* whose,
                std::vector<std::string>& notes) {
  if (colors.empty()) return;
  ColorRange range;
  std::size_t without = 0;
  for (const Float3& color : colors) {
    if (std::isnan(color[0]))
      ++without;
    else
      range.add(color);
  }
  const bool bytes = integers ? range.largest() > 1 : range.isOfBytes();
  if (without == colors.size()) {
    colors.clear();
    return;
  }
  if (bytes && !integers)
    notes.push_back(std::string(whose) + " colours go beyond 1: they were read as 8-bit codes, 255 is white");
  for (Float3& color : colors) {
    if (std::isnan(color[0])) continue;
    for (float& value : color) value = linearFromSrgb(bytes ? value / 255.0F : value);
  }
}

// Adds faces to a mesh, but for those of too few corners.
class FaceFilter {
 public:
  void add(const std::vector<std::uint32_t>& corners, const Float3& color, PolygonMesh& mesh) {
    if (corners.size() < 3) {
      ++left_out_;
      return;
    }
    mesh.corner_counts.push_back(static_cast<std::uint32_t>(corners.size()));
    mesh.corners.insert(mesh.corners.end(), corners.begin(), corners.end());
    mesh.face_colors.push_back(color);
  }

  void addNote(std::vector<std::string>& notes) const {
    if (left_out_ > 0)
      notes.push_back(counted(left_out_, "face has fewer than 3 corners, and was left out",
                              "faces have fewer than 3 corners, and were left out"));
  }

 private:
  std::size_t left_out_ = 0;
};

class TextOff {
 public:
  TextOff(std::string_view text, std::string file)
      : lines_(withoutByteOrderMark(text)), file_(std::move(file)) {}

  // After readHeader.
  MeshParts read(const OffHeader& header) {
    header_ = header;
    readCounts();
    chooseLayout();
    for (std::uint64_t i = 0; i < vertex_count_; ++i) readVertex(i);
    for (std::uint64_t i = 0; i < face_count_; ++i) readFace(i);
    if (!(flowing_ && !trimmed(line_).empty()) && !nextLine()) line_ = {};
    if (line_.empty() && !lines_.latestHasEnd())
      note("the last line has no line end: was the file cut short?");
    if (!trimmed(line_).empty())
      note("text follows the last face that the header counts, and was not read (from line " +
           std::to_string(lines_.lineNumber()) + " on)");
    return finish();
  }

  // The keyword, which may be missing. The bytes of a binary file begin at restOfFile().
  OffHeader readHeader() {
    if (!nextLine()) throw badHeader(file_, "there is nothing in it");
    std::string_view ahead = line_;
    const std::string_view word = takeWord(ahead);
    if (parseInteger(word)) return {};
    std::string_view digits;
    OffHeader header = headerFrom(word, digits, file_);
    std::string_view after = ahead;
    if (equalIgnoringCase(takeWord(after), "BINARY")) {
      header.binary = true;
      return header;
    }
    // Some write the first count against the keyword: "OFF490 518 0".
    line_ = digits.empty()
                ? ahead
                : std::string_view(digits.data(), static_cast<std::size_t>(line_.end() - digits.begin()));
    return header;
  }

  std::string_view restOfFile() const { return lines_.rest(); }

 private:
  void note(std::string text) { result_.notes.push_back(std::move(text)); }

  Error error(const char* element, std::uint64_t index, const std::string& what,
              const std::string& expected) const {
    return badInput({file_, placeOf(element, index, lines_.lineNumber()), ""}, what, expected, kRepairRemedy);
  }

  Error endsEarly(const std::string& place) const {
    return badInput({file_, place, ""}, "the file ends here",
                    std::to_string(vertex_count_) + " vertices and " + std::to_string(face_count_) +
                        " faces, as its header says",
                    kCutRemedy);
  }

  // The next line that is not blank, without its comment.
  bool nextLine() {
    while (lines_.next(line_)) {
      line_ = trimmed(line_.substr(0, line_.find('#')));
      if (!line_.empty()) return true;
    }
    line_ = {};
    return false;
  }

  // Across lines; empty at the end.
  std::string_view nextWord() {
    while (true) {
      const std::string_view word = takeWord(line_);
      if (!word.empty() || !nextLine()) return word;
    }
  }

  std::uint64_t readCount(const char* what) {
    const std::string_view word = nextWord();
    if (word.empty()) throw endsEarly("header");
    const auto count = parseInteger(word);
    if (!count || *count < 0)
      throw badInput({file_, "header (line " + std::to_string(lines_.lineNumber()) + ")", ""},
                     "'" + std::string(word.substr(0, 40)) + "' is no number of " + what, "an integer from 0",
                     kRepairRemedy);
    if (*count >= std::numeric_limits<std::uint32_t>::max())
      throw badInput({file_, "header", ""}, "it says that there are " + std::string(word) + " " + what,
                     "less than 4,294,967,295", "export the file again, its header is damaged");
    return static_cast<std::uint64_t>(*count);
  }

  void readCounts() {
    vertex_count_ = readCount("vertices");
    face_count_ = readCount("faces");
    // The number of edges, of which nobody makes use, may be missing or stand on a line of its own.
    if (!trimmed(line_).empty()) {
      readCount("edges");
      if (trimmed(line_).empty()) nextLine();
      return;
    }
    if (!nextLine()) return;
    std::string_view ahead = line_;
    takeWord(ahead);
    if (trimmed(ahead).empty()) nextLine();
  }

  static std::size_t wordsIn(std::string_view line) {
    std::size_t count = 0;
    while (!takeWord(line).empty()) ++count;
    return count;
  }

  std::uint64_t linesLeft() const {
    LineScanner ahead = lines_;
    std::uint64_t count = 1;
    for (std::string_view line; ahead.next(line);) count += !trimmed(line.substr(0, line.find('#'))).empty();
    return count;
  }

  // Nearly all files have a vertex or face a line; the format also lets them flow over lines.
  void chooseLayout() {
    const auto base = static_cast<std::size_t>(header_.numbersWithoutColor());
    const std::size_t words = wordsIn(line_);
    if (vertex_count_ == 0 || words == base) return;
    const bool declared = header_.colors && (words == base + 3 || words == base + 4);
    const std::uint64_t rows = vertex_count_ + face_count_, lines = linesLeft();
    if (words < base)
      flowing_ = lines != rows;
    else
      flowing_ = !declared && lines < rows && (words % base == 0 || words > base + 4);
  }

  float readNumber(std::string_view word, std::uint64_t vertex) const {
    const auto value = parseFloat(word);
    if (!value)
      throw error("vertex", vertex, "'" + std::string(word.substr(0, 40)) + "' is not a number", "numbers");
    return *value;
  }

  void readVertex(std::uint64_t index) {
    if (!flowing_ && index > 0) nextLine();
    values_.clear();
    const auto base = static_cast<std::size_t>(header_.numbersWithoutColor());
    const std::size_t flowing_count = base + (header_.colors ? 4 : 0);
    while (!flowing_ || values_.size() < flowing_count) {
      const std::string_view word = flowing_ ? nextWord() : takeWord(line_);
      if (word.empty()) break;
      values_.push_back(readNumber(word, index));
      integer_vertex_colors_ &= values_.size() <= 3 || !isFraction(word) || !isColorAt(values_.size() - 1);
    }
    if (values_.empty() || (flowing_ && values_.size() < flowing_count))
      throw endsEarly(placeOf("vertex", index, 0));
    if (values_.size() < base) {
      const std::string what = "its line has " + counted(values_.size(), "number", "numbers");
      if (lines_.atEnd()) throw endsEarly(placeOf("vertex", index, lines_.lineNumber()));
      throw error("vertex", index, what, std::to_string(base));
    }
    storeVertex(index, values_.size() - base);
  }

  // Of the latest vertex: colours stand behind the normal.
  bool isColorAt(std::size_t number) const {
    const std::size_t begin = header_.normals ? 6 : 3;
    return number >= begin && number < begin + 3;
  }
  static bool isFraction(std::string_view word) {
    return word.find_first_of(".eE") != std::string_view::npos;
  }

  void storeVertex(std::uint64_t index, std::size_t color_count) {
    const Float3 position = {values_[0], values_[1], values_[2]};
    if (!std::isfinite(position[0]) || !std::isfinite(position[1]) || !std::isfinite(position[2]))
      not_finite_.push_back({index, lines_.lineNumber()});
    mesh_.positions.push_back(position);
    std::size_t next = 3;
    if (header_.normals) {
      mesh_.normals.push_back({values_[3], values_[4], values_[5]});
      next = 6;
    }
    if (color_count == 3 || color_count == 4) {
      mesh_.colors.resize(static_cast<std::size_t>(index), kNoColor);
      mesh_.colors.push_back({values_[next], values_[next + 1], values_[next + 2]});
    } else if (color_count > 0) {
      ++strange_vertices_;
    }
    next += color_count;
    if (header_.texcoords) mesh_.texcoords.push_back({values_[next], values_[next + 1]});
  }

  void readFace(std::uint64_t index) {
    // The first line is the current one if there are no vertices.
    if (!flowing_ && (index > 0 || vertex_count_ > 0)) nextLine();
    std::string_view word = flowing_ ? nextWord() : takeWord(line_);
    if (word.empty()) throw endsEarly(placeOf("face", index, 0));
    const auto count = parseInteger(word);
    if (!count || *count < 0)
      throw error("face", index, "'" + std::string(word.substr(0, 40)) + "' is no number of corners",
                  "an integer from 0");
    face_.clear();
    for (std::int64_t k = 0; k < *count; ++k) {
      word = flowing_ ? nextWord() : takeWord(line_);
      if (word.empty() && lines_.atEnd()) throw endsEarly(placeOf("face", index, lines_.lineNumber()));
      if (word.empty())
        throw error("face", index, "its line has " + std::to_string(k) + " corners", std::to_string(*count));
      face_.push_back(vertexFrom(word, index));
    }
    const Float3 color = flowing_ ? kNoColor : readFaceColor(index);
    faces_.add(face_, color, mesh_);
  }

  std::uint32_t vertexFrom(std::string_view word, std::uint64_t face) const {
    const auto vertex = parseInteger(word);
    if (!vertex)
      throw error("face", face, "'" + std::string(word.substr(0, 40)) + "' is not the index of a vertex",
                  "an integer");
    if (*vertex < 0 || static_cast<std::uint64_t>(*vertex) >= vertex_count_)
      throw error("face", face, "vertex " + std::to_string(*vertex) + " does not exist",
                  vertex_count_ == 0 ? "no index, as there are no vertices"
                                     : "0 to " + std::to_string(vertex_count_ - 1));
    return static_cast<std::uint32_t>(*vertex);
  }

  Float3 readFaceColor(std::uint64_t index) {
    values_.clear();
    for (auto word = takeWord(line_); !word.empty(); word = takeWord(line_)) {
      const auto value = parseFloat(word);
      if (!value)
        throw error("face", index, "'" + std::string(word.substr(0, 40)) + "' follows its corners",
                    "a colour");
      values_.push_back(*value);
      integer_face_colors_ &= values_.size() > 3 || !isFraction(word);
    }
    if (values_.size() == 3 || values_.size() == 4) return {values_[0], values_[1], values_[2]};
    if (values_.size() == 1) ++mapped_faces_;
    if (values_.size() == 2 || values_.size() > 4) ++strange_faces_;
    return kNoColor;
  }

  void checkFinite() const {
    if (not_finite_.empty()) return;
    std::vector<bool> used(mesh_.positions.size());
    for (const std::uint32_t vertex : mesh_.corners) used[vertex] = true;
    for (const auto& [vertex, line] : not_finite_)
      if (used[vertex])
        throw badInput({file_, placeOf("vertex", vertex, line), ""}, "its position is not finite",
                       "three numbers that a 32-bit float can hold",
                       "repair the mesh in its modelling program");
  }

  MeshParts finish() {
    checkFinite();
    faces_.addNote(result_.notes);
    const auto noteCount = [&](std::size_t count, const char* one, const char* several) {
      if (count > 0) note(counted(count, one, several));
    };
    noteCount(mapped_faces_, "colour of a face was left out: it is the index of a colour map",
              "colours of faces were left out: they are indices of a colour map");
    noteCount(strange_faces_, "face has numbers behind its corners that are no colour; they were not read",
              "faces have numbers behind their corners that are no colour; they were not read");
    noteCount(strange_vertices_, "vertex has numbers that the header does not name; they were not read",
              "vertices have numbers that the header does not name; they were not read");
    if (!mesh_.colors.empty()) mesh_.colors.resize(mesh_.positions.size(), kNoColor);
    makeLinear(mesh_.colors, integer_vertex_colors_, "vertex", result_.notes);
    makeLinear(mesh_.face_colors, integer_face_colors_, "face", result_.notes);
    std::size_t without = 0;
    for (Float3& color : mesh_.colors) {
      if (!std::isnan(color[0])) continue;
      ++without;
      color = {1, 1, 1};
    }
    noteCount(without, "vertex has no colour, and was taken as white",
              "vertices have no colour, and were taken as white");
    result_.parts.push_back(partOf(std::move(mesh_), result_.notes));
    return std::move(result_);
  }

  LineScanner lines_;
  std::string_view line_;
  std::string file_;
  OffHeader header_;
  bool flowing_ = false;
  std::uint64_t vertex_count_ = 0, face_count_ = 0;
  std::vector<float> values_;
  std::vector<std::uint32_t> face_;
  std::vector<std::array<std::uint64_t, 2>> not_finite_;  // vertex, line
  bool integer_vertex_colors_ = true, integer_face_colors_ = true;
  FaceFilter faces_;
  std::size_t mapped_faces_ = 0, strange_faces_ = 0, strange_vertices_ = 0;
  PolygonMesh mesh_;
  MeshParts result_;
};

// Big-endian 32-bit integers and floats.
class BinaryOff {
 public:
  BinaryOff(std::span<const std::byte> bytes, const OffHeader& header, std::string file)
      : bytes_(bytes), header_(header), file_(std::move(file)) {}

  MeshParts read() {
    place_ = "header";
    const std::int64_t vertices = take<std::int32_t>(), faces = take<std::int32_t>();
    take<std::int32_t>();  // edges
    if (vertices < 0 || faces < 0)
      throw badInput({file_, place_, ""},
                     "it says that there are " + std::to_string(vertices) + " vertices and " +
                         std::to_string(faces) + " faces",
                     "counts from 0, big-endian", "export the file again as a text");
    vertex_count_ = static_cast<std::uint64_t>(vertices);
    for (std::uint64_t i = 0; i < vertex_count_; ++i) readVertex(i);
    for (std::int64_t i = 0; i < faces; ++i) readFace(static_cast<std::uint64_t>(i));
    MeshParts result;
    faces_.addNote(result.notes);
    if (!bytes_.empty())
      result.notes.push_back(counted(bytes_.size(), "byte follows", "bytes follow") +
                             " the last face, and were not read");
    makeLinear(mesh_.colors, false, "vertex", result.notes);
    makeLinear(mesh_.face_colors, false, "face", result.notes);
    result.parts.push_back(partOf(std::move(mesh_), result.notes));
    return result;
  }

 private:
  template <class T>
  T take() {
    if (bytes_.size() < sizeof(T))
      throw badInput({file_, place_, ""}, "the file ends here",
                     "as many vertices and faces as its header says", kCutRemedy);
    std::uint32_t raw;
    std::memcpy(&raw, bytes_.data(), sizeof raw);
    if constexpr (std::endian::native == std::endian::little) raw = __builtin_bswap32(raw);
    bytes_ = bytes_.subspan(sizeof raw);
    return std::bit_cast<T>(raw);
  }

  Float3 take3() {
    const float x = take<float>(), y = take<float>(), z = take<float>();
    return {x, y, z};
  }

  void readVertex(std::uint64_t index) {
    place_ = placeOf("vertex", index, 0);
    const Float3 position = take3();
    if (!std::isfinite(position[0]) || !std::isfinite(position[1]) || !std::isfinite(position[2]))
      throw badInput({file_, place_, ""}, "its position is not finite", "three numbers",
                     "repair the mesh in its modelling program");
    mesh_.positions.push_back(position);
    if (header_.normals) mesh_.normals.push_back(take3());
    if (header_.colors) {
      mesh_.colors.push_back(take3());
      take<float>();
    }
    if (header_.texcoords) {
      const float u = take<float>(), v = take<float>();
      mesh_.texcoords.push_back({u, v});
    }
  }

  void readFace(std::uint64_t index) {
    place_ = placeOf("face", index, 0);
    const std::int32_t count = take<std::int32_t>();
    if (count < 0)
      throw badInput({file_, place_, ""}, "it has " + std::to_string(count) + " corners", "a number from 0",
                     "export the file again");
    face_.clear();
    for (std::int32_t k = 0; k < count; ++k) {
      const std::int32_t vertex = take<std::int32_t>();
      if (vertex < 0 || static_cast<std::uint64_t>(vertex) >= vertex_count_)
        throw badInput({file_, place_, ""}, "vertex " + std::to_string(vertex) + " does not exist",
                       "an index below " + std::to_string(vertex_count_), "export the file again");
      face_.push_back(static_cast<std::uint32_t>(vertex));
    }
    const std::int32_t color_count = take<std::int32_t>();
    Float3 color = kNoColor;
    for (std::int32_t c = 0; c < color_count; ++c) {
      const float value = take<float>();
      if (c < 3 && color_count >= 3) color[static_cast<std::size_t>(c)] = value;
    }
    faces_.add(face_, color, mesh_);
  }

  std::span<const std::byte> bytes_;
  OffHeader header_;
  std::string file_, place_;
  std::uint64_t vertex_count_ = 0;
  std::vector<std::uint32_t> face_;
  FaceFilter faces_;
  PolygonMesh mesh_;
};

}  // namespace

MeshParts readOff(std::span<const std::byte> bytes, const std::string& file) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  TextOff reader(text, file);
  const OffHeader header = reader.readHeader();
  if (!header.binary) return reader.read(header);
  return BinaryOff(bytes.last(reader.restOfFile().size()), header, file).read();
}

}  // namespace bakelight::formats
