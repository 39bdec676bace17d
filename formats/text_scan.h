// Lines, words and numbers of text files, the same in every locale. Private to the readers of text formats.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace bakelight::formats {

// Lines that end in LF, CR LF or CR (also mixed), each without its end.
class LineScanner {
 public:
  explicit LineScanner(std::string_view text) : text_(text) {}

  // False at the end of the text. A line end at the very end begins no further line.
  bool next(std::string_view& line);
  std::uint64_t lineNumber() const { return number_; }  // of the latest line, from 1
  bool latestHasEnd() const { return latest_has_end_; }
  bool atEnd() const { return text_.empty(); }
  std::string_view rest() const { return text_; }  // behind the latest line

 private:
  std::string_view text_;
  std::uint64_t number_ = 0;
  bool latest_has_end_ = true;
};

// Blanks are the space, tab, vertical tab and form feed; a line end counts as one where words are asked for
// across lines.
bool isBlank(char c);
std::string_view trimmed(std::string_view text);
// Takes the next word off `text`; empty at its end.
std::string_view takeWord(std::string_view& text);

std::string_view withoutByteOrderMark(std::string_view text);  // UTF-8's
// What a text that begins with UTF-16's byte-order mark (of either endianness) says in UTF-8; nothing if it
// does not begin so.
std::optional<std::string> utf8FromUtf16(std::string_view text);

bool equalIgnoringCase(std::string_view a, std::string_view b);  // ASCII
bool startsIgnoringCase(std::string_view text, std::string_view prefix);

// The float nearest to a decimal number; a leading '+' is allowed. Beyond the range of float ±∞, below it ±0.
// NaN and ∞ are read as such, also as C libraries of Windows write them ("-1.#IND"). Nothing if `word` is no
// number as a whole.
std::optional<float> parseFloat(std::string_view word);
// Nothing also where it does not fit.
std::optional<std::int64_t> parseInteger(std::string_view word);

}  // namespace bakelight::formats
