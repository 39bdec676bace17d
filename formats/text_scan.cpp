#include "formats/text_scan.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace bakelight::formats {
namespace {

char lowered(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

// Whether a decimal number that float cannot hold is too large, rather than too small: the place of its first
// digit that is not 0 decides.
bool isHuge(std::string_view number) {
  const std::size_t e = std::min(number.find_first_of("eE"), number.size());
  const std::string_view digits = number.substr(0, e);
  const std::size_t point = std::min(digits.find('.'), digits.size());
  const std::size_t first = digits.find_first_of("123456789");
  if (first == std::string_view::npos) return false;
  const auto place = static_cast<std::int64_t>(point) - static_cast<std::int64_t>(first);
  std::string_view exponent_text = number.substr(std::min(e + 1, number.size()));
  const bool negative = exponent_text.starts_with('-');
  if (exponent_text.starts_with('+')) exponent_text.remove_prefix(1);
  std::int64_t exponent = 0;
  const auto status =
      std::from_chars(exponent_text.data(), exponent_text.data() + exponent_text.size(), exponent).ec;
  if (status == std::errc::result_out_of_range) return !negative;
  return place + exponent > 0;
}

// "1.#INF", "-1.#IND000", "1.#QNAN"
std::optional<float> parseWindowsNotFinite(std::string_view word) {
  const bool negative = word.starts_with('-');
  if (negative) word.remove_prefix(1);
  if (!startsIgnoringCase(word, "1.#")) return std::nullopt;
  word.remove_prefix(3);
  if (startsIgnoringCase(word, "inf"))
    return negative ? -std::numeric_limits<float>::infinity() : std::numeric_limits<float>::infinity();
  for (const char* name : {"ind", "qnan", "snan", "nan"})
    if (startsIgnoringCase(word, name)) return std::numeric_limits<float>::quiet_NaN();
  return std::nullopt;
}

}  // namespace

bool LineScanner::next(std::string_view& line) {
  if (text_.empty()) return false;
  std::size_t end = 0;
  while (end < text_.size() && text_[end] != '\n' && text_[end] != '\r') ++end;
  line = text_.substr(0, end);
  latest_has_end_ = end < text_.size();
  if (latest_has_end_) {
    const bool pair = text_[end] == '\r' && end + 1 < text_.size() && text_[end + 1] == '\n';
    end += pair ? 2 : 1;
  }
  text_.remove_prefix(end);
  ++number_;
  return true;
}

bool isBlank(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view takeWord(std::string_view& text) {
  std::size_t begin = 0;
  while (begin < text.size() && isBlank(text[begin])) ++begin;
  std::size_t end = begin;
  while (end < text.size() && !isBlank(text[end])) ++end;
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

std::string_view withoutByteOrderMark(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

std::optional<std::string> utf8FromUtf16(std::string_view text) {
  const bool little = text.starts_with("\xFF\xFE"), big = text.starts_with("\xFE\xFF");
  if (!little && !big) return std::nullopt;
  std::string result;
  const auto unitAt = [&](std::size_t i) {
    const auto first = static_cast<unsigned char>(text[i]), second = static_cast<unsigned char>(text[i + 1]);
    return static_cast<std::uint32_t>(little ? first | second << 8 : first << 8 | second);
  };
  for (std::size_t i = 2; i + 1 < text.size(); i += 2) {
    std::uint32_t code = unitAt(i);
    if (code >= 0xD800 && code < 0xDC00 && i + 3 < text.size()) {  // the first of a pair
      code = 0x10000 + ((code - 0xD800) << 10) + (unitAt(i + 2) - 0xDC00) % 0x400;
      i += 2;
    }
    if (code < 0x80) {
      result += static_cast<char>(code);
      continue;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    constexpr unsigned kFirst[] = {0, 0xC0, 0xE0, 0xF0};
    result += static_cast<char>(kFirst[more] | code >> (6 * more));
    for (int k = more - 1; k >= 0; --k) result += static_cast<char>(0x80 | (code >> (6 * k) & 0x3F));
  }
  return result;
}

bool equalIgnoringCase(std::string_view a, std::string_view b) {
  return a.size() == b.size() && startsIgnoringCase(a, b);
}

bool startsIgnoringCase(std::string_view text, std::string_view prefix) {
  return text.size() >= prefix.size() && std::equal(prefix.begin(), prefix.end(), text.begin(),
                                                    [](char a, char b) { return lowered(a) == lowered(b); });
}

std::optional<float> parseFloat(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && (isDigit(word[1]) || word[1] == '.')) word.remove_prefix(1);
  float value = 0;
  const char* end = word.data() + word.size();
  const auto [rest, status] = std::from_chars(word.data(), end, value);
  if (status == std::errc() && rest == end) return value;
  if (status == std::errc::result_out_of_range && rest == end) {
    const float magnitude = isHuge(word) ? std::numeric_limits<float>::infinity() : 0.0F;
    return word.starts_with('-') ? -magnitude : magnitude;
  }
  return parseWindowsNotFinite(word);
}

std::optional<std::int64_t> parseInteger(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && isDigit(word[1])) word.remove_prefix(1);
  std::int64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [rest, status] = std::from_chars(word.data(), end, value);
  if (status != std::errc() || rest != end) return std::nullopt;
  return value;
}

}  // namespace bakelight::formats
