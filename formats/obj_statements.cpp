#include "formats/obj_statements.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

constexpr const char* kCutRemedy = "copy or export the file again, it was probably cut short";
constexpr const char* kRepairRemedy = "correct the line, or export the file again";

enum Kind { kVertex, kTexcoord, kNormal };
constexpr std::array<const char*, 3> kKindNames = {"vertex", "texture coordinate", "normal"};

// A backslash at the end of a line joins the next one.
class LogicalLines {
 public:
  explicit LogicalLines(std::string_view text) : lines_(text) {}

  bool next(std::string_view& line) {
    if (!lines_.next(line)) return false;
    first_ = lines_.lineNumber();
    if (!line.ends_with('\\')) return true;
    joined_.clear();
    while (true) {
      const bool more = line.ends_with('\\');
      if (more) line.remove_suffix(1);
      joined_ += line;
      joined_ += ' ';
      if (!more || !lines_.next(line)) break;
    }
    line = joined_;
    return true;
  }

  std::uint64_t firstNumber() const { return first_; }  // of the latest logical line
  const LineScanner& scanner() const { return lines_; }

 private:
  LineScanner lines_;
  std::string joined_;
  std::uint64_t first_ = 0;
};

// A comment begins at '#', but for "1.#QNAN", which is a number of sorts.
std::string_view withoutComment(std::string_view line) {
  for (std::size_t hash = line.find('#'); hash != std::string_view::npos; hash = line.find('#', hash + 1))
    if (hash == 0 || line[hash - 1] != '.') return line.substr(0, hash);
  return line;
}

// A name may contain '#' and blanks; a comment stands apart.
std::string_view nameIn(std::string_view rest) {
  rest = trimmed(rest);
  for (std::size_t hash = rest.find('#'); hash != std::string_view::npos; hash = rest.find('#', hash + 1))
    if (hash > 0 && isBlank(rest[hash - 1])) return trimmed(rest.substr(0, hash));
  return rest;
}

bool isOneOf(std::string_view word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return equalIgnoringCase(word, w); });
}

std::string plural(std::uint64_t count, const std::string& one, const std::string& several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

class StatementReader {
 public:
  StatementReader(std::string_view text, std::string file)
      : lines_(withoutByteOrderMark(text)), file_(std::move(file)) {}

  ObjStatements read() {
    for (std::string_view line; lines_.next(line);) readLine(line);
    result_.ends_inside_line = !lines_.scanner().latestHasEnd();
    result_.line_count = lines_.scanner().lineNumber();
    if (!result_.colors.empty()) result_.colors.resize(result_.positions.size(), kNoColor);
    checkLargestIndices();
    addNotes();
    return std::move(result_);
  }

 private:
  static constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  static constexpr Float3 kNoColor = {kNan, kNan, kNan};

  Error errorAt(std::uint64_t line, const std::string& what, const std::string& expected) const {
    const bool cut =
        lines_.scanner().atEnd() && !lines_.scanner().latestHasEnd() && line == lines_.scanner().lineNumber();
    return badInput({file_, "line " + std::to_string(line), ""}, what, expected,
                    cut ? kCutRemedy : kRepairRemedy);
  }
  Error error(const std::string& what, const std::string& expected) const {
    return errorAt(lines_.firstNumber(), what, expected);
  }

  void readLine(std::string_view line) {
    std::string_view rest = line;
    const std::string_view keyword = takeWord(rest);
    if (keyword.empty() || keyword[0] == '#') return;
    if (equalIgnoringCase(keyword, "v")) {
      readVertex(withoutComment(rest));
    } else if (equalIgnoringCase(keyword, "f") || equalIgnoringCase(keyword, "fo")) {
      readFace(withoutComment(rest));
    } else if (equalIgnoringCase(keyword, "vt")) {
      std::array<float, 4> values = {};
      readNumbers(withoutComment(rest), values, 1, 3, "vt u v");
      result_.texcoords.push_back({values[0], values[1]});
    } else if (equalIgnoringCase(keyword, "vn")) {
      std::array<float, 4> values = {};
      readNumbers(withoutComment(rest), values, 3, 3, "vn x y z");
      result_.normals.push_back({values[0], values[1], values[2]});
    } else if (equalIgnoringCase(keyword, "usemtl")) {
      useMaterial(nameIn(rest));
    } else if (equalIgnoringCase(keyword, "mtllib")) {
      result_.libraries.push_back({std::string(nameIn(rest)), lines_.firstNumber()});
    } else {
      countOther(withoutComment(keyword));
    }
  }

  void countOther(std::string_view keyword) {
    if (isOneOf(keyword, {"o", "g"})) {
      begins_group_ = true;
    } else if (equalIgnoringCase(keyword, "l")) {
      ++line_count_;
    } else if (equalIgnoringCase(keyword, "p")) {
      ++point_count_;
    } else if (isOneOf(keyword, {"curv", "curv2", "surf", "bsp", "bzp", "cdc", "cdp"})) {
      ++free_form_count_;
    } else if (!isOneOf(keyword, {"s",          "vp",        "cstype",   "deg",  "bmat",   "step",   "parm",
                                  "trim",       "hole",      "scrv",     "sp",   "end",    "con",    "mg",
                                  "bevel",      "c_interp",  "d_interp", "lod",  "usemap", "maplib", "res",
                                  "shadow_obj", "trace_obj", "ctech",    "stech"})) {
      if (unknown_count_++ == 0) {
        unknown_ = keyword.substr(0, 40);
        unknown_line_ = lines_.firstNumber();
      }
    }
  }

  template <std::size_t N>
  int readNumbers(std::string_view rest, std::array<float, N>& values, int least, int most,
                  const char* form) const {
    int count = 0;
    for (auto word = takeWord(rest); !word.empty(); word = takeWord(rest), ++count) {
      const auto value = parseFloat(word);
      if (!value) throw error("'" + std::string(word.substr(0, 40)) + "' is not a number", form);
      if (static_cast<std::size_t>(count) < N) values[static_cast<std::size_t>(count)] = *value;
    }
    if (count < least || count > most) throw error("it has " + plural(count, "number", "numbers"), form);
    return count;
  }

  void readVertex(std::string_view rest) {
    std::array<float, 7> v = {};
    constexpr const char* kForms = "v x y z, v x y z w, v x y z r g b or v x y z r g b a";
    const int count = readNumbers(rest, v, 3, 7, kForms);
    if (count == 5) throw error("it has 5 numbers", kForms);
    Float3 position = {v[0], v[1], v[2]};
    if (count == 4 && v[3] != 1) {
      ++weighted_count_;
      for (float& coordinate : position) coordinate /= v[3];
    }
    alpha_count_ += count == 7;
    if (!std::isfinite(position[0]) || !std::isfinite(position[1]) || !std::isfinite(position[2]))
      result_.not_finite.push_back({result_.positions.size(), lines_.firstNumber()});
    if (count >= 6) {
      result_.colors.resize(result_.positions.size(), kNoColor);
      result_.colors.push_back({v[3], v[4], v[5]});
    }
    result_.positions.push_back(position);
  }

  void readFace(std::string_view rest) {
    const std::size_t begin = result_.corners.size();
    for (auto word = takeWord(rest); !word.empty(); word = takeWord(rest)) readCorner(word);
    const std::size_t count = result_.corners.size() - begin;
    if (count < 3) {
      if (lines_.scanner().atEnd() && !lines_.scanner().latestHasEnd())
        throw error("the file ends inside a face of " + std::to_string(count) + " corners",
                    "at least 3 corners");
      result_.corners.resize(begin);
      if (short_face_count_++ == 0) short_face_line_ = lines_.firstNumber();
      return;
    }
    if (begins_group_) ++group_count_;
    begins_group_ = false;
    result_.corner_counts.push_back(static_cast<std::uint32_t>(count));
    result_.face_materials.push_back(material_);
  }

  // "7", "7/2", "7//3" or "7/2/3"; also "7/" and "7//".
  void readCorner(std::string_view word) {
    ObjCorner corner;
    std::array<std::uint32_t*, 3> indices = {&corner.vertex, &corner.texcoord, &corner.normal};
    std::string_view rest = word;
    for (const Kind kind : {kVertex, kTexcoord, kNormal}) {
      const std::size_t slash = rest.find('/');
      const std::string_view digits = rest.substr(0, slash);
      if (!digits.empty() || kind == kVertex) *indices[kind] = indexFrom(digits, kind);
      if (slash == std::string_view::npos) {
        result_.corners.push_back(corner);
        return;
      }
      rest.remove_prefix(slash + 1);
    }
    throw error("the corner '" + std::string(word.substr(0, 40)) + "' is malformed", "vertex/texture/normal");
  }

  std::int64_t countOf(Kind kind) const {
    return static_cast<std::int64_t>(kind == kVertex     ? result_.positions.size()
                                     : kind == kTexcoord ? result_.texcoords.size()
                                                         : result_.normals.size());
  }

  std::uint32_t indexFrom(std::string_view digits, Kind kind) {
    const auto written = parseInteger(digits);
    if (!written || *written == 0)
      throw error("'" + std::string(digits.substr(0, 40)) + "' is not the index of a " + kKindNames[kind],
                  "an integer from 1, or below 0 to count back from the latest");
    const std::int64_t index = *written < 0 ? countOf(kind) + 1 + *written : *written;
    if (index < 1 || index > std::numeric_limits<std::uint32_t>::max())
      throw missing(lines_.firstNumber(), kind, *written);
    if (index > largest_[kind].index) largest_[kind] = {index, lines_.firstNumber()};
    return static_cast<std::uint32_t>(index);
  }

  Error missing(std::uint64_t line, Kind kind, std::int64_t index) const {
    const std::int64_t count = countOf(kind);
    return errorAt(line, std::string(kKindNames[kind]) + " " + std::to_string(index) + " does not exist",
                   count == 0 ? std::string("no such index, as the file has no ") + kKindNames[kind]
                   : index < 0
                       ? "at most " + std::to_string(count) + " back, as many as stand before this line"
                       : "1 to " + std::to_string(count));
  }

  // At the end, as a face may stand before its vertices.
  void checkLargestIndices() const {
    for (const Kind kind : {kVertex, kTexcoord, kNormal})
      if (largest_[kind].index > countOf(kind))
        throw missing(largest_[kind].line, kind, largest_[kind].index);
  }

  void useMaterial(std::string_view name) {
    const auto [known, added] =
        material_numbers_.try_emplace(std::string(name), static_cast<std::int32_t>(result_.materials.size()));
    if (added) result_.materials.emplace_back(name);
    material_ = known->second;
  }

  void addNotes() {
    const auto note = [&](std::uint64_t count, const std::string& one, const std::string& several,
                          const std::string& rest) {
      if (count > 0) result_.notes.push_back(plural(count, one, several) + rest);
    };
    if (group_count_ > 1)
      result_.notes.push_back(std::to_string(group_count_) + " objects or groups were merged");
    note(short_face_count_, "face has", "faces have",
         " fewer than 3 corners, and " + std::string(short_face_count_ == 1 ? "was" : "were") +
             " left out (line " + std::to_string(short_face_line_) + ")");
    note(point_count_ + line_count_, "line of points or lines was", "lines of points or lines were",
         " left out");
    note(free_form_count_, "free-form curve or surface was", "free-form curves and surfaces were",
         " left out: only polygons are read");
    note(weighted_count_, "vertex has a weight, and was", "vertices have a weight, and were",
         " divided by it");
    note(alpha_count_, "vertex has", "vertices have",
         " 7 numbers: they were read as x y z r g b a, and a was left out");
    note(unknown_count_, "line has an unknown keyword, and was", "lines have an unknown keyword, and were",
         " left out (line " + std::to_string(unknown_line_) + ": '" + unknown_ + "')");
  }

  struct Largest {
    std::int64_t index = 0;
    std::uint64_t line = 0;
  };

  LogicalLines lines_;
  std::string file_;
  ObjStatements result_;
  std::int32_t material_ = -1;
  std::unordered_map<std::string, std::int32_t> material_numbers_;
  std::array<Largest, 3> largest_{};
  bool begins_group_ = true;
  std::uint64_t group_count_ = 0, short_face_count_ = 0, short_face_line_ = 0, point_count_ = 0,
                line_count_ = 0, free_form_count_ = 0, weighted_count_ = 0, alpha_count_ = 0,
                unknown_count_ = 0, unknown_line_ = 0;
  std::string unknown_;
};

}  // namespace

ObjStatements readObjStatements(std::string_view text, const std::string& file) {
  return StatementReader(text, file).read();
}

std::vector<ObjStatements::Library> objLibraries(std::string_view text) {
  std::vector<ObjStatements::Library> libraries;
  LogicalLines lines(withoutByteOrderMark(text));
  for (std::string_view line; lines.next(line);) {
    const std::string_view keyword = takeWord(line);
    if (equalIgnoringCase(keyword, "mtllib"))
      libraries.push_back({std::string(nameIn(line)), lines.firstNumber()});
  }
  return libraries;
}

}  // namespace bakelight::formats
