#include "formats/mesh_file_check.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

#include "formats/error.h"
#include "formats/ply_header.h"

namespace bakelight::formats {
namespace {

constexpr const char* kCutRemedy = "copy or export the file again, it was probably cut short";

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

// Takes the next word off `text`; empty at its end.
std::string_view takeWord(std::string_view& text) {
  std::size_t begin = 0;
  while (begin < text.size() && isBlank(text[begin])) ++begin;
  std::size_t end = begin;
  while (end < text.size() && !isBlank(text[end])) ++end;
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

// A number in the C locale. Its magnitude is not judged here: the importer names what is not finite.
bool isNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && status != std::errc::invalid_argument && end == word.data() + word.size();
}

class ObjCheck {
 public:
  ObjCheck(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  std::vector<std::string> run() {
    while (!text_.empty()) checkLine(takeLine());
    checkLargestIndices();
    return checkEnding();
  }

 private:
  enum Kind { kVertex, kTexcoord, kNormal };
  static constexpr std::array<const char*, 3> kNames = {"vertex", "texture coordinate", "normal"};

  Error error(std::uint64_t line, const std::string& what, const std::string& expected) const {
    return badInput({file_, "line " + std::to_string(line), ""}, what, expected, kCutRemedy);
  }

  // A logical line: a backslash at the end joins the next one.
  std::string takeLine() {
    std::string line;
    first_line_ = line_ + 1;
    for (bool joined = true; joined && !text_.empty();) {
      const std::size_t end = text_.find('\n');
      ends_with_newline_ = end != std::string_view::npos;
      std::string_view part = text_.substr(0, end);
      text_.remove_prefix(ends_with_newline_ ? end + 1 : text_.size());
      ++line_;
      if (part.ends_with('\r')) part.remove_suffix(1);
      joined = part.ends_with('\\');
      if (joined) part.remove_suffix(1);
      line += part;
      line += ' ';
    }
    return line;
  }

  void checkLine(const std::string& line) {
    std::string_view rest = std::string_view(line).substr(0, line.find('#'));
    const std::string_view keyword = takeWord(rest);
    if (keyword == "v") {
      checkVertex(rest);
    } else if (keyword == "vt") {
      checkNumbers(rest, 1, "vt u v");
      ++counts_[kTexcoord];
    } else if (keyword == "vn") {
      checkNumbers(rest, 3, "vn x y z");
      ++counts_[kNormal];
    } else if (keyword == "f") {
      checkFace(rest);
    }
  }

  // assimp drops vertices of other forms, and reads past the end of the colours if only some have one.
  void checkVertex(std::string_view rest) {
    const int numbers = checkNumbers(rest, 3, "v x y z");
    if (numbers != 3 && numbers != 4 && numbers != 6) {
      throw error(first_line_, "it has " + std::to_string(numbers) + " numbers",
                  "v x y z, v x y z w, or v x y z r g b");
    }
    colored_vertices_ += numbers == 6;
    ++counts_[kVertex];
    if (colored_vertices_ != 0 && colored_vertices_ != counts_[kVertex]) {
      throw error(first_line_, "some vertices have a colour and others have none",
                  "colours at all or at none");
    }
  }

  // Returns how many there are.
  int checkNumbers(std::string_view rest, int least, const char* form) const {
    int count = 0;
    for (auto word = takeWord(rest); !word.empty(); word = takeWord(rest), ++count) {
      if (!isNumber(word)) throw error(first_line_, "'" + std::string(word) + "' is not a number", form);
    }
    if (count < least) throw error(first_line_, "it has " + std::to_string(count) + " numbers", form);
    return count;
  }

  void checkFace(std::string_view rest) {
    int corners = 0;
    for (auto word = takeWord(rest); !word.empty(); word = takeWord(rest), ++corners) checkCorner(word);
    if (corners < 3) {
      throw error(first_line_, "the face has " + std::to_string(corners) + " corners", "at least 3 corners");
    }
  }

  // "7", "7/2", "7//3" or "7/2/3".
  void checkCorner(std::string_view word) {
    std::string_view rest = word;
    for (const Kind kind : {kVertex, kTexcoord, kNormal}) {
      const std::size_t slash = rest.find('/');
      const std::string_view digits = rest.substr(0, slash);
      if (!digits.empty() || kind == kVertex) checkIndex(digits, kind);
      if (slash == std::string_view::npos) return;
      rest.remove_prefix(slash + 1);
    }
    throw error(first_line_, "the corner '" + std::string(word) + "' is malformed", "vertex/texture/normal");
  }

  void checkIndex(std::string_view digits, Kind kind) {
    std::int64_t index = 0;
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    if (status != std::errc() || end != digits.data() + digits.size() || index == 0) {
      throw error(first_line_, "'" + std::string(digits) + "' is not an index",
                  "an integer from 1, or below 0");
    }
    if (index < 0) index += counts_[kind] + 1;  // counted back from the latest
    if (index < 1 || index > kMaxIndex) throw missing(first_line_, kind, index);
    if (index > largest_[kind].index) largest_[kind] = {index, first_line_};
    if (kind == kVertex) markUsed(static_cast<std::size_t>(index - 1));
  }

  void markUsed(std::size_t vertex) {
    // A line may name vertices that come later; one beyond twice the count and a bit will be reported at the
    // end.
    if (vertex >= used_.size()) {
      if (vertex > kLookAhead + 2 * static_cast<std::size_t>(counts_[kVertex])) return;
      used_.resize(std::max(vertex + 1, used_.size() * 2));
    }
    used_count_ += !used_[vertex];
    used_[vertex] = true;
  }

  Error missing(std::uint64_t line, Kind kind, std::int64_t index) const {
    return error(line, std::string(kNames[kind]) + " " + std::to_string(index) + " does not exist",
                 "1 to " + std::to_string(counts_[kind]));
  }

  // At the end, as a face may stand before its vertices.
  void checkLargestIndices() const {
    for (const Kind kind : {kVertex, kTexcoord, kNormal}) {
      if (largest_[kind].index > counts_[kind])
        throw missing(largest_[kind].line, kind, largest_[kind].index);
    }
  }

  // A cut inside the last number leaves a well-formed line. Such a file lacks its last newline, and, as faces
  // are missing, has vertices that none uses; a whole file with both is rare enough to ask for its newline.
  std::vector<std::string> checkEnding() const {
    const std::int64_t unused = counts_[kVertex] - used_count_;
    const std::string unused_text =
        std::to_string(unused) + " of " + std::to_string(counts_[kVertex]) + " vertices belong to no face";
    if (used_count_ > 0 && unused > 0 && !ends_with_newline_) {
      throw badInput({file_, "line " + std::to_string(line_), ""},
                     "the file ends inside a line, and " + unused_text, "a newline at the end",
                     std::string(kCutRemedy) + "; if it is whole, add the newline");
    }
    std::vector<std::string> notes;
    if (used_count_ > 0 && unused > 0) notes.push_back(unused_text + ": was the file cut short?");
    if (used_count_ > 0 && !ends_with_newline_)
      notes.push_back("the last line has no newline: was the file cut short?");
    return notes;
  }

  static constexpr std::int64_t kMaxIndex = std::int64_t{1} << 32;
  static constexpr std::size_t kLookAhead = 1 << 20;

  struct Largest {
    std::int64_t index = 0;
    std::uint64_t line = 0;
  };

  std::string_view text_;
  std::string file_;
  std::uint64_t line_ = 0, first_line_ = 0;
  bool ends_with_newline_ = true;
  std::array<std::int64_t, 3> counts_{};
  std::array<Largest, 3> largest_{};
  std::vector<bool> used_;
  std::int64_t used_count_ = 0, colored_vertices_ = 0;
};

// The numbers of an OFF file after its keyword, without comments.
class OffCheck {
 public:
  OffCheck(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  void run() {
    const auto keyword = next();
    if (!keyword || keyword->find("OFF") == std::string_view::npos) return;  // left to assimp
    const auto vertices = nextCount(), faces = nextCount();
    nextCount();  // of edges
    // Each vertex and face stands on a line of its own; what follows its coordinates (colours) is not ours to
    // judge.
    for (std::uint64_t i = 0; i < vertices; ++i) takeNumbers(3, "vertex " + std::to_string(i));
    for (std::uint64_t i = 0; i < faces; ++i) {
      const std::string element = "face " + std::to_string(i);
      takeNumbers(nextCount(element), element);
    }
  }

 private:
  Error endsEarly(const std::string& element) const {
    return badInput({file_, element, ""}, "the file ends or the line breaks off here",
                    "as many as its header says", kCutRemedy);
  }

  std::optional<std::string_view> next() {
    while (true) {
      std::string_view word = takeWord(line_);
      if (!word.empty() && word[0] != '#') return word;
      if (text_.empty()) return std::nullopt;
      const std::size_t end = text_.find('\n');
      line_ = text_.substr(0, end);
      text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    }
  }

  std::uint64_t nextCount(const std::string& element = "header") {
    const auto word = next();
    std::uint32_t count = 0;
    if (!word || std::from_chars(word->data(), word->data() + word->size(), count).ec != std::errc()) {
      throw endsEarly(element);
    }
    return count;
  }

  void takeNumbers(std::uint64_t count, const std::string& element) {
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto word = next();
      if (!word || !isNumber(*word)) throw endsEarly(element);
    }
    line_ = {};
  }

  std::string_view text_, line_;
  std::string file_;
};

void checkStl(std::string_view text, const std::string& file) {
  if (!text.starts_with("solid") || text.find("facet") == std::string_view::npos)
    return;  // binary: left to assimp
  const std::size_t last_facet = text.rfind("endfacet"), end = text.rfind("endsolid");
  if (end == std::string_view::npos || (last_facet != std::string_view::npos && end < last_facet)) {
    throw badInput({file, "", ""}, "the file ends before endsolid", "a last line that says endsolid",
                   kCutRemedy);
  }
}

}  // namespace

std::vector<std::string> checkMeshFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (ending == ".obj") return ObjCheck(text, path.string()).run();
  if (ending == ".ply") checkPlyBody(readPlyHeader(bytes, path.string()), bytes, path.string());
  if (ending == ".off") OffCheck(text, path.string()).run();
  if (ending == ".stl") checkStl(text, path.string());
  return {};
}

}  // namespace bakelight::formats
